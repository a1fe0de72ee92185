//! Every built-in case reads and builds without a finding, but for outputs that are meant to cut the step short:
//! cases that rest or start cold have a step without meaning.

use lateen::Error;
use lateen::case::{Case, Source};
use std::path::{Path, PathBuf};

fn cases() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("cases");
    let folders = |at: &Path| -> Vec<PathBuf> {
        let entries = std::fs::read_dir(at).expect("a folder of cases");
        entries.filter_map(|entry| Some(entry.ok()?.path())).filter(|path| path.is_dir()).collect()
    };
    let methods = folders(&root);
    let mut files: Vec<_> = methods.iter().flat_map(|at| folders(at)).map(|at| at.join("case.toml")).collect();
    files.retain(|file| file.exists());
    files.sort();
    files
}

#[test]
fn every_case_builds() {
    assert!(cases().len() >= 4);
    let mut wrong = String::new();
    for file in cases() {
        let source = Source::read(&file).unwrap();
        match Case::read(source.clone(), &[]).and_then(|case| case.model()) {
            Ok(mut model) => {
                model.warnings.retain(|warning| !warning.key.starts_with("output."));
                wrong += source.render(&model.warnings, false).trim_start();
            }
            Err(Error::Case(findings)) => wrong += &source.render(&findings, false),
            Err(other) => panic!("{other}"),
        }
    }
    assert!(wrong.is_empty(), "\n{wrong}");
}
