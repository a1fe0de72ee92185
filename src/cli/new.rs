//! `lateen new NAME [DIR]` and `lateen cases`.

use super::Failure;
use lateen::catalog;
use lateen::verify::Expected;
use std::path::PathBuf;

/// Writes a built-in case as a starter.
pub fn new(name: &str, directory: Option<PathBuf>) -> Result<(), Failure> {
    let case = catalog::find(name).ok_or_else(|| catalog::unknown(name))?;
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
        let facts = [title, expected.measured.size, expected.measured.time];
        let facts: Vec<String> = facts.into_iter().filter(|fact| !fact.is_empty()).collect();
        println!("{:width$}  {}  {}", case.name(), case.method(), facts.join("; "));
    }
    Ok(())
}

fn title(case: &str) -> Option<String> {
    Some(case.parse::<toml::Table>().ok()?.get("title")?.as_str()?.to_owned())
}
