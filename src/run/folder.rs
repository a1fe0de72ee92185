//! The case that a user names: a file, a folder with a `case.toml`, or a built-in case.

use crate::case::{Case, Source};
use crate::catalog::{self, BuiltIn};
use crate::error::{Error, Result};
use crate::input;
use std::io;
use std::path::{Path, PathBuf};

/// A case file with what lies beside it.
#[derive(Debug, Clone)]
pub struct Folder {
    /// The case file.
    pub source: Source,
    built_in: Option<BuiltIn>,
}

impl Folder {
    /// Finds what `name` means: a file or folder where there is one, else a built-in case.
    ///
    /// # Errors
    /// There is neither, or the file can't be read.
    pub fn open(name: &str) -> Result<Self> {
        let path = Path::new(name);
        if path.is_dir() && path.join(catalog::CASE_FILE).is_file() {
            return Ok(Self { source: Source::read(path.join(catalog::CASE_FILE))?, built_in: None });
        }
        let is_plain_name = path.extension().is_none() && path.components().count() == 1 && !path.is_file();
        match catalog::find(name) {
            Some(case) if is_plain_name => Ok(Self::built_in(case)),
            None if is_plain_name => Err(catalog::unknown(name)),
            _ => Ok(Self { source: Source::read(path)?, built_in: None }),
        }
    }

    /// A built-in case, read from the program itself.
    pub fn built_in(case: BuiltIn) -> Self {
        let text = case.text(catalog::CASE_FILE).unwrap_or_default();
        let name = format!("{}/{}", case.name(), catalog::CASE_FILE);
        Self { source: Source::new(name, PathBuf::new(), text), built_in: Some(case) }
    }

    /// Reads the case with overrides of its keys.
    ///
    /// # Errors
    /// Everything that is wrong with the case.
    pub fn read(&self, set: &[(String, String)]) -> Result<Case> {
        Case::read(self.source.clone(), set)
    }

    /// A file beside the case, to show findings in; `None` if there is no such file.
    ///
    /// # Errors
    /// The file can't be read.
    pub fn beside(&self, file: &str) -> Result<Option<Source>> {
        let name = Path::new(&self.source.name).with_file_name(file).display().to_string();
        Ok(self.text(file)?.map(|text| Source::new(name, self.source.base.clone(), text)))
    }

    /// The text of a file beside the case; `None` if there is no such file.
    ///
    /// # Errors
    /// The file can't be read.
    pub fn text(&self, file: &str) -> Result<Option<String>> {
        if let Some(case) = self.built_in {
            return Ok(case.text(file).map(str::to_owned));
        }
        let path = self.source.base.join(file);
        match input::text(&path) {
            Ok(text) => Ok(Some(text)),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(Error::io(path, error)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_a_built_in_case_and_a_path_is_a_file() {
        assert_eq!(Folder::open("water-sphere").unwrap().source.name, "water-sphere/case.toml");
        assert!(matches!(Folder::open("none/such.toml"), Err(Error::Io { .. })));
        let error = Folder::open("water-spere").unwrap_err();
        assert!(error.to_string().contains("did you mean `water-sphere`"), "{error}");
    }

    #[test]
    fn files_beside_a_case_are_found() {
        let directory = tempfile::tempdir().unwrap();
        std::fs::write(directory.path().join("case.toml"), "name = 'mine'").unwrap();
        std::fs::write(directory.path().join("expected.toml"), "").unwrap();
        let folder = Folder::open(directory.path().to_str().unwrap()).unwrap();
        assert_eq!(folder.text("expected.toml").unwrap().as_deref(), Some(""));
        assert_eq!(folder.text("reference/none.csv").unwrap(), None);
        assert!(Folder::open("sphere-on-membrane").unwrap().text("reference/calculix.csv").unwrap().is_some());
    }
}
