//! `lateen check`: everything about a case without running it. `lateen laws` and `lateen schema`: the keys of a case.

use super::{Failure, located};
use lateen::run::Folder;

/// Options of the command.
#[derive(clap::Args)]
pub struct Arguments {
    /// A case file, or the name of a built-in case
    case: String,
    /// Override a key of the case, for example --set grid.cell="2 mm"
    #[arg(long, value_name = "KEY=VALUE", value_parser = super::key_value)]
    set: Vec<(String, String)>,
}

/// Prints the resolved case, its sizes, memory, first step and number of steps.
pub fn check(arguments: &Arguments) -> Result<(), Failure> {
    let folder = Folder::open(&arguments.case)?;
    let case = folder.read(&arguments.set).map_err(|error| located(error, &folder))?;
    let model = case.model().map_err(|error| located(error, &folder))?;
    super::show(&format!("{}\n{}\n", case.resolved_toml(), model.summary))?;
    super::show_findings(&folder.source, &model.warnings);
    Ok(())
}
