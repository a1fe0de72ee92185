//! `lateen new NAME [DIR]` and `lateen cases`.

use super::Failure;
use lateen::catalog;
use lateen::error::{Diagnostic, Error};
use lateen::verify::Expected;
use std::path::PathBuf;

/// Writes a built-in case as a starter.
pub fn new(name: &str, directory: Option<PathBuf>) -> Result<(), Failure> {
    let case = catalog::find(name).ok_or_else(|| unknown_case(name))?;
    let directory = directory.unwrap_or_else(|| name.into());
    let path = case.write_to(&directory)?;
    println!("{} is yours to change; run it with\n\n    lateen run {}", path.display(), path.display());
    Ok(())
}

/// Lists the built-in cases: method, size, measured run time.
pub fn cases() -> Result<(), Failure> {
    let width = catalog::all().iter().map(|case| case.name().len()).max().unwrap_or(0);
    for case in catalog::all() {
        let expected = Expected::parse(case.text(catalog::EXPECTED_FILE).unwrap_or_default())?;
        let title = case.text(catalog::CASE_FILE).and_then(title).unwrap_or_default();
        let [size, time] = [expected.measured.size, expected.measured.time];
        println!("{:width$}  {}  {title}; {size}; {time}", case.name(), case.method());
    }
    Ok(())
}

/// What to say about a name that is no built-in case.
pub fn unknown_case(name: &str) -> Error {
    let help = match catalog::nearest(name) {
        Some(near) => format!("did you mean `{near}`? `lateen cases` lists the built-in cases"),
        None => "`lateen cases` lists the built-in cases".to_owned(),
    };
    Error::case(Diagnostic::error("", format!("there is no case `{name}`")).help(help))
}

fn title(case: &str) -> Option<String> {
    Some(case.parse::<toml::Table>().ok()?.get("title")?.as_str()?.to_owned())
}
