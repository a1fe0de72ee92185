//! `lateen new NAME [DIR]` and `lateen cases`.

use super::{Failure, quoted, show};
use lateen::case::is_case_name;
use lateen::catalog;
use lateen::verify::Expected;
use std::path::PathBuf;

/// Writes a built-in case as a starter.
pub fn new(name: &str, directory: Option<PathBuf>) -> Result<(), Failure> {
    let case = catalog::find(name).ok_or_else(|| catalog::unknown(name))?;
    let directory = directory.unwrap_or_else(|| name.into());
    // A directory may have a name that a case can't have.
    let own = directory.file_name().map(|own| own.to_string_lossy().into_owned()).filter(|own| is_case_name(own));
    let own = own.unwrap_or_else(|| name.to_owned());
    let path = case.write_to(&directory, &own)?;
    let path = path.display().to_string();
    show(&format!("{path} is yours to change; run it with\n\n    lateen run {}\n", quoted(&path)))
}

/// Lists the built-in cases: method, measured run time, size, title.
pub fn cases() -> Result<(), Failure> {
    let mut rows = vec![["case", "method", "time", "size", "title"].map(str::to_owned)];
    for case in catalog::all() {
        let measured = Expected::parse(case.text(catalog::EXPECTED_FILE).unwrap_or_default())?.measured;
        let title = case.text(catalog::CASE_FILE).and_then(title).unwrap_or_default();
        rows.push([case.name().to_owned(), case.method().to_owned(), measured.time, grouped(&measured.size), title]);
    }
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let [name, method, time, size, _] = std::array::from_fn(width);
    let lines = rows.iter().map(|[case, by, took, large, title]| {
        format!("{case:name$}  {by:method$}  {took:>time$}  {large:size$}  {title}\n")
    });
    let times = "\ntimes: of one core of a server of 2025 (x86-64, AVX-512, 2.6 GHz), outputs included\n";
    show(&(lines.collect::<String>() + times))
}

/// The text with commas in whole numbers of four digits and more: `14661 particles` reads `14,661 particles`.
fn grouped(text: &str) -> String {
    let number = |word: &str| {
        let whole = word.len() > 3 && word.bytes().all(|byte| byte.is_ascii_digit());
        let comma = |i: usize| if whole && i > 0 && (word.len() - i).is_multiple_of(3) { "," } else { "" };
        word.char_indices().map(|(i, digit)| format!("{}{digit}", comma(i))).collect::<String>()
    };
    text.split(' ').map(number).collect::<Vec<_>>().join(" ")
}

fn title(case: &str) -> Option<String> {
    Some(case.parse::<toml::Table>().ok()?.get("title")?.as_str()?.to_owned())
}

#[cfg(test)]
mod tests {
    use super::grouped;

    #[test]
    fn large_numbers_have_commas() {
        assert_eq!(grouped("14661 particles, 240 nodes"), "14,661 particles, 240 nodes");
        assert_eq!(grouped("1200000 elements, 14,661 particles"), "1,200,000 elements, 14,661 particles");
    }
}
