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

/// Lists the built-in cases: method, measured run time, size, title.
pub fn cases() -> Result<(), Failure> {
    let mut rows = vec![["case", "method", "time", "size", "title"].map(str::to_owned)];
    for case in catalog::all() {
        let measured = Expected::parse(case.text(catalog::EXPECTED_FILE).unwrap_or_default())?.measured;
        let title = case.text(catalog::CASE_FILE).and_then(title).unwrap_or_default();
        rows.push([case.name().to_owned(), case.method().to_owned(), measured.time, measured.size, title]);
    }
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let [name, method, time, size, _] = std::array::from_fn(width);
    for row in &rows {
        let [case, by, took, large, title] = row;
        println!("{case:name$}  {by:method$}  {took:>time$}  {large:size$}  {title}");
    }
    println!("\ntimes: of one core of a server of 2025 (x86-64, AVX-512, 2.6 GHz), outputs included");
    Ok(())
}

fn title(case: &str) -> Option<String> {
    Some(case.parse::<toml::Table>().ok()?.get("title")?.as_str()?.to_owned())
}
