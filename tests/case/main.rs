//! Case files: what they may say, what they build, what is wrong with them, and small runs from the file to the
//! history, compared with closed forms.

mod bad_input_case;
mod bad_input_flow;
mod bad_input_fuzz;
mod bad_input_model;
mod build;
mod catalog;
mod findings;
mod flow;
mod forces;
mod read;
mod reference;
mod runs;
mod solid_paths;
mod solid_surfaces;
mod solids;

use lateen::case::{Case, Source};
use lateen::output::history::HistoryTable;
use lateen::run::{Options, RunDirectory, run};

/// Runs a case and reads one of its histories.
fn history(text: &str, name: &str) -> HistoryTable {
    let home = tempfile::tempdir().unwrap();
    let case = Case::read(Source::new("case.toml", "", text), &[]).unwrap_or_else(|error| panic!("{error}"));
    run(&case, case.build().unwrap(), &RunDirectory::new(home.path()), Options::default()).unwrap();
    HistoryTable::read(&home.path().join(format!("history/{name}.csv"))).unwrap()
}
