//! Every folder of a case is built in, and builds without errors and warnings, but for gauges that are dry at the
//! start.

use lateen::Error;
use lateen::case::{Case, Source};
use lateen::verify::Level;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

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

/// The folders below `cases/` are the reference for the list that the program carries.
#[test]
fn every_case_folder_is_built_in() {
    let folder = |file: &PathBuf| file.parent().unwrap().file_name().unwrap().to_string_lossy().into_owned();
    let mut folders: Vec<String> = cases().iter().map(folder).collect();
    let mut built_in: Vec<String> = lateen::catalog::all().into_iter().map(|case| case.name().to_owned()).collect();
    folders.sort();
    built_in.sort();
    assert!(!folders.is_empty());
    assert_eq!(built_in, folders);
}

/// Findings of a case but for the one that is expected: a probe of a box that the flow reaches later.
fn complaints(file: &Path) -> String {
    let source = Source::read(file).unwrap();
    match Case::read(source.clone(), &[]).and_then(|case| case.model()) {
        Ok(mut model) => {
            model.warnings.retain(|warning| !warning.message.contains("the box holds nothing of"));
            // Layers at the beams of Turek & Hron are resolved.
            let glides = model
                .summary
                .notes
                .iter()
                .find(|note| file.to_string_lossy().contains("turek") && note.contains("glides"));
            source.render(&model.warnings, false).trim_start().to_owned() + glides.map_or("", String::as_str)
        }
        Err(Error::Case(findings)) => source.render(&findings, false),
        Err(other) => panic!("{other}"),
    }
}

/// (Takes long, as every case is built with all its particles, and the modes of its solids are found.)
#[test]
fn every_case_folder_builds_without_unexpected_warnings() {
    let (files, next) = (cases(), AtomicUsize::new(0));
    let worker = || {
        let mut wrong = String::new();
        while let Some(file) = files.get(next.fetch_add(1, Ordering::Relaxed)) {
            wrong += &complaints(file);
        }
        wrong
    };
    let wrong: String = thread::scope(|scope| {
        let workers: Vec<_> =
            (0..thread::available_parallelism().map_or(1, usize::from)).map(|_| scope.spawn(worker)).collect();
        workers.into_iter().map(|worker| worker.join().unwrap()).collect()
    });
    assert!(wrong.is_empty(), "\n{wrong}");
}

/// The options `--set` of the commands that the cases' READMEs print, `lateen run CASE --set KEY=VALUE …`, by case.
fn printed_settings() -> Vec<(PathBuf, Vec<String>)> {
    let mut found = Vec::new();
    for file in cases() {
        let readme = std::fs::read_to_string(file.with_file_name("README.md")).unwrap_or_default();
        let readme = readme.replace("\\\n", " ");
        let commands = readme.split("lateen run ").skip(1).map(|rest| rest.split(['`', '\n']).next().unwrap_or(""));
        for command in commands.filter(|command| !command.contains('…')) {
            let words = shell_words(command);
            let settings = words.windows(2).filter(|pair| pair[0] == "--set").map(|pair| pair[1].clone()).collect();
            let named = cases().into_iter().find(|case| case.parent().is_some_and(|at| at.ends_with(&words[0])));
            found.push((named.unwrap_or_else(|| panic!("`{command}` names no case")), settings));
        }
    }
    found
}

/// Words as a shell would hand them on.
fn shell_words(command: &str) -> Vec<String> {
    let (mut words, mut word, mut quote) = (Vec::new(), String::new(), None);
    for c in command.chars() {
        match (c, quote) {
            ('"' | '\'', None) => quote = Some(c),
            (c, Some(open)) if c == open => quote = None,
            (' ', None) => words.extend(Some(std::mem::take(&mut word)).filter(|word| !word.is_empty())),
            (c, _) => word.push(c),
        }
    }
    words.extend(Some(word).filter(|word| !word.is_empty()));
    words
}

#[test]
fn commands_printed_in_the_readmes_of_cases_are_valid() {
    let printed = printed_settings();
    // Guards against a change of format after which no command is found any more.
    assert!(printed.len() >= 5, "{}", printed.len());
    for (file, settings) in printed {
        let settings: Vec<(String, String)> = settings
            .iter()
            .map(|setting| setting.split_once('=').expect("KEY=VALUE"))
            .map(|(key, value)| (key.to_owned(), value.to_owned()))
            .collect();
        let source = Source::read(&file).unwrap();
        if let Err(Error::Case(findings)) = Case::read(source.clone(), &settings).and_then(|case| case.model()) {
            panic!("{settings:?}\n{}", source.render(&findings, false));
        }
    }
}

/// Settings of the levels and variants of a case are keys that it has.
#[test]
fn settings_of_comparisons_are_valid() {
    let mut variants = 0;
    for case in lateen::catalog::all() {
        let folder = lateen::run::Folder::built_in(case);
        let expected = lateen::verify::expected(&folder).unwrap().unwrap();
        for level in [Level::Quick, Level::Full] {
            for (name, run) in expected.runs(case.name(), level) {
                folder.read(&run.effort(level).overrides()).unwrap_or_else(|error| panic!("{name}: {error}"));
            }
        }
        variants += expected.variants.len();
    }
    assert!(variants > 0, "no case has variants any more");
}
