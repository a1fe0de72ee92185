//! Small runs from the case file to the history, compared with closed forms.

mod forces;
mod runs;

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
