//! The built-in cases: the folder `cases/` of the source, carried in the program.
//!
//! `cases/<method>/<name>/` holds `case.toml`, `README.md` (paper, figure, what to look at),
//! `expected.toml` (what `lateen verify` compares) and `reference/*.csv`. Nothing about a built-in
//! case is hidden in the program: `lateen new NAME` writes this folder.

use crate::error::{Diagnostic, Error, Result};
use include_dir::{Dir, include_dir};
use std::fs;
use std::path::{Path, PathBuf};

static CASES: Dir<'static> = include_dir!("$CARGO_MANIFEST_DIR/cases");

/// The case file of a folder.
pub const CASE_FILE: &str = "case.toml";
/// Name of the file with the comparisons of a case.
pub const EXPECTED_FILE: &str = "expected.toml";

/// A case that is part of the program.
#[derive(Debug, Clone, Copy)]
pub struct BuiltIn {
    folder: &'static Dir<'static>,
}

/// All built-in cases, by method and name.
pub fn all() -> Vec<BuiltIn> {
    let mut cases: Vec<BuiltIn> =
        CASES.dirs().flat_map(|method| method.dirs()).map(|folder| BuiltIn { folder }).collect();
    cases.sort_by_key(|case| (case.method(), case.name()));
    cases
}

/// The built-in case of a name.
pub fn find(name: &str) -> Option<BuiltIn> {
    all().into_iter().find(|case| case.name() == name)
}

/// The built-in name that is nearest to `name`, if any is near.
pub fn nearest(name: &str) -> Option<&'static str> {
    let distance = |other: &&str| strsim::damerau_levenshtein(name, other);
    all().iter().map(BuiltIn::name).min_by_key(distance).filter(|near| distance(near) <= near.len() / 3)
}

/// The error for a name that is no built-in case.
pub fn unknown(name: &str) -> Error {
    let list = "`lateen cases` lists the built-in cases";
    let help = match nearest(name) {
        Some(near) => format!("did you mean `{near}`? {list}"),
        None => list.to_owned(),
    };
    Error::case(Diagnostic::error("", format!("there is no case `{name}`")).help(help))
}

impl BuiltIn {
    /// Its name.
    pub fn name(&self) -> &'static str {
        component(self.folder.path(), 1)
    }

    /// The method that solves it.
    pub fn method(&self) -> &'static str {
        component(self.folder.path(), 0)
    }

    /// The text of one of its files.
    pub fn text(&self, file: &str) -> Option<&'static str> {
        self.folder.get_file(self.folder.path().join(file))?.contents_utf8()
    }

    /// Writes its files into `directory` as a case of the name `own`; returns the path of its case file.
    ///
    /// # Errors
    /// Input/output errors; a file that is there already is one.
    pub fn write_to(&self, directory: &Path, own: &str) -> Result<PathBuf> {
        let quoted = toml::Value::from(own);
        write_folder(self.folder, directory, &|text| {
            let named = text.replacen(&format!("name = \"{}\"", self.name()), &format!("name = {quoted}"), 1);
            // Pictures of the guide stay behind.
            named.split_inclusive('\n').filter(|line| !line.starts_with("![")).collect()
        })?;
        Ok(directory.join(CASE_FILE))
    }
}

fn component(path: &'static Path, n: usize) -> &'static str {
    path.components().nth(n).and_then(|part| part.as_os_str().to_str()).unwrap_or_default()
}

fn write_folder(folder: &Dir<'_>, directory: &Path, adapt: &dyn Fn(&str) -> String) -> Result<()> {
    fs::create_dir_all(directory).map_err(|error| Error::io(directory, error))?;
    for file in folder.files() {
        let path = directory.join(file.path().file_name().unwrap_or_default());
        let adapted = file.contents_utf8().map(adapt);
        let contents = adapted.as_ref().map_or(file.contents(), |text| text.as_bytes());
        let write = || {
            let mut target = fs::File::create_new(&path)?;
            std::io::Write::write_all(&mut target, contents)
        };
        write().map_err(|error| Error::io(&path, taken(error)))?;
    }
    let mut below = folder.dirs();
    below.try_for_each(|dir| write_folder(dir, &directory.join(dir.path().file_name().unwrap_or_default()), adapt))
}

/// Says what to do about a file that is there already.
fn taken(error: std::io::Error) -> std::io::Error {
    match error.kind() {
        kind @ std::io::ErrorKind::AlreadyExists => std::io::Error::new(
            kind,
            "it is there already, and nothing is overwritten\n  help: name another directory, `lateen new CASE DIRECTORY`",
        ),
        _ => error,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_case_has_its_files() {
        for case in all() {
            for file in [CASE_FILE, EXPECTED_FILE, "README.md"] {
                assert!(case.text(file).is_some(), "{}/{file} is missing", case.name());
            }
            assert!(["mpm", "pfem2"].contains(&case.method()), "{}", case.name());
        }
    }

    #[test]
    fn a_typing_error_finds_the_case() {
        assert_eq!(nearest("water-spere"), Some("water-sphere"));
        assert_eq!(nearest("something-else-altogether"), None);
    }

    #[test]
    fn a_case_is_written_with_its_references_and_never_over_a_file() {
        let directory = tempfile::tempdir().unwrap();
        let case = find("water-sphere").unwrap();
        let path = case.write_to(directory.path(), "mine").unwrap();
        let text = fs::read_to_string(&path).unwrap();
        assert!(text.contains("name = \"mine\""), "{text}");
        assert_eq!(
            text.replacen("name = \"mine\"", &format!("name = \"{}\"", case.name()), 1),
            case.text(CASE_FILE).unwrap()
        );
        assert!(matches!(case.write_to(directory.path(), "mine"), Err(Error::Io { .. })));
    }

    #[test]
    fn a_case_is_toml_whatever_its_name() {
        for own in ["a\"b", "it's", "a\\b", "\"both' \\", "tab\t"] {
            let directory = tempfile::tempdir().unwrap();
            let path = find("water-sphere").unwrap().write_to(directory.path(), own).unwrap();
            let table: toml::Table = fs::read_to_string(&path).unwrap().parse().unwrap();
            assert_eq!(table["name"].as_str(), Some(own));
        }
    }
}
