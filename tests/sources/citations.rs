//! Citations in sources, cases and tests have targets: sections and equations of the theory, equations of the two papers, reference files.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// All files below a folder with one of these extensions.
fn files(folder: &str, extensions: &[&str]) -> Vec<PathBuf> {
    let (mut found, mut folders) = (Vec::new(), vec![root().join(folder)]);
    while let Some(folder) = folders.pop() {
        for path in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| extensions.contains(&e.to_str().unwrap_or_default())) {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

/// Path and text of all that may cite.
fn citing() -> Vec<(String, String)> {
    let folders = ["src", "tests", "benches", "cases"];
    let all = folders.iter().flat_map(|folder| files(folder, &["rs", "toml", "md"]));
    let here = Path::new(file!()).file_name().unwrap();
    all.filter(|path| path.file_name() != Some(here))
        .map(|path| (path.strip_prefix(root()).unwrap().display().to_string(), fs::read_to_string(path).unwrap()))
        .collect()
}

/// A label such as `A.3` or `A.3.1` at the beginning of the text.
fn label(text: &str) -> Option<&str> {
    let mut letters = text.chars();
    let starts = letters.next()?.is_ascii_uppercase() && letters.next()? == '.' && letters.next()?.is_ascii_digit();
    let end = text.find(|c: char| !c.is_ascii_alphanumeric() && c != '.').unwrap_or(text.len());
    starts.then(|| text[..end].trim_end_matches('.'))
}

/// Sections and equations of the chapters in `docs/src/theory`; equations in brackets, as they are cited.
fn theory() -> BTreeSet<String> {
    let mut labels = BTreeSet::new();
    for path in files("docs/src/theory", &["md"]) {
        let text = fs::read_to_string(path).unwrap();
        for line in text.lines() {
            if let Some(heading) = line.strip_prefix('#') {
                labels.extend(label(heading.trim_start_matches('#').trim()).map(str::to_owned));
            }
            for rest in line.split("\\tag{").skip(1) {
                let equation = format!("({})", rest.split('}').next().unwrap());
                assert!(labels.insert(equation.clone()), "equation {equation} stands twice in the theory");
            }
        }
    }
    labels
}

/// The labels that a text cites: a list after the word theory, and equations in brackets anywhere.
fn cited(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    for rest in text.split("theory ").skip(1) {
        for item in rest.split([',', ';', '–']).map(|item| item.trim_start().trim_start_matches("and ")) {
            match label(item.trim_start_matches('(')) {
                Some(name) if item.starts_with('(') => found.push(format!("({name})")),
                Some(name) => found.push(name.to_owned()),
                None => break,
            }
        }
        // A number alone is no label.
        let bare = rest.starts_with(|c: char| c.is_ascii_digit());
        found.extend(bare.then(|| rest.chars().take(6).collect()));
    }
    for rest in text.split('(').skip(1) {
        let name = label(rest).filter(|name| rest[name.len()..].starts_with([')', ',']));
        found.extend(name.map(|name| format!("({name})")));
    }
    found
}

#[test]
fn cited_sections_and_equations_of_the_theory_exist() {
    let theory = theory();
    assert!(theory.len() > 100, "{}", theory.len());
    let mut wrong = Vec::new();
    for (path, text) in citing() {
        let missing = cited(&text).into_iter().filter(|label| !theory.contains(label));
        wrong.extend(missing.map(|label| format!("{path}: theory {label}")));
    }
    assert!(wrong.is_empty(), "without a target in docs/src/theory:\n{}", wrong.join("\n"));
}

#[test]
fn labels_are_found_in_every_form() {
    let text =
        "as theory A.3, A.5 say, theory (B.12), theory D.4.1; linear theory within 3 %, f(A.x) and (C.7); theory 6.2";
    assert_eq!(cited(text), ["A.3", "A.5", "(B.12)", "D.4.1", "6.2", "(B.12)", "(C.7)"]);
}

/// The rows of the table of a paper's equations: number, and the sources that do the work.
fn table(paper: &str) -> Vec<(u32, Vec<String>)> {
    let text = fs::read_to_string(root().join("docs/src/theory/papers.md")).unwrap();
    let row = |line: &str| {
        let rest = line.strip_prefix(&format!("| {paper} ("))?;
        let number = rest.split(')').next()?.parse().ok()?;
        let sources = rest.rsplit('|').nth(1)?.split('`').skip(1).step_by(2).map(str::to_owned).collect();
        Some((number, sources))
    };
    text.lines().filter_map(row).collect()
}

/// The numbers after `Lian (` or `Becker (`.
fn equations(text: &str, paper: &str) -> Vec<u32> {
    let mut numbers = Vec::new();
    for rest in text.split(&format!("{paper} (")).skip(1) {
        let list = rest.split(')').next().unwrap_or_default();
        for item in list.split(", ") {
            let ends: Vec<u32> = item.split('–').filter_map(|end| end.parse().ok()).collect();
            match ends[..] {
                [one] => numbers.push(one),
                [first, last] => numbers.extend(first..=last),
                _ => {}
            }
        }
    }
    numbers
}

/// The numbers that comments give in brackets, or after `eq.` and `eqs.`: at the line that does the work the paper goes without saying.
fn in_comments(text: &str) -> Vec<u32> {
    let mut numbers = Vec::new();
    for comment in text.lines().filter_map(|line| Some(line.split_once("//")?.1)) {
        for rest in comment.split(['(', '.']).skip(1) {
            let end = rest.find(|c: char| !c.is_ascii_digit() && !"–, ".contains(c)).unwrap_or(rest.len());
            for item in rest[..end].split(',').map(str::trim) {
                let ends: Vec<u32> = item.split('–').filter_map(|end| end.trim().parse().ok()).collect();
                numbers.extend(ends.first().zip(ends.last()).into_iter().flat_map(|(first, last)| *first..=*last));
            }
        }
    }
    numbers
}

#[test]
fn equations_of_the_papers_are_listed_and_cited_in_the_sources_that_the_list_names() {
    for paper in ["Lian", "Becker"] {
        let table = table(paper);
        assert!(table.len() > 10, "{paper}");
        for (number, sources) in &table {
            for source in sources {
                let text = fs::read_to_string(root().join("src").join(source)).unwrap_or_else(|_| panic!("{source}"));
                let there = equations(&text, paper).contains(number) || in_comments(&text).contains(number);
                assert!(there, "src/{source} doesn't say where it does {paper} ({number})");
            }
        }
        for (path, text) in citing() {
            for number in equations(&text, paper) {
                let known = table.iter().any(|(listed, _)| *listed == number);
                assert!(known, "{path} cites {paper} ({number}), which docs/src/theory/papers.md doesn't list");
            }
        }
    }
}

#[test]
fn cited_reference_files_exist() {
    for path in files("cases", &["toml", "md"]) {
        let (folder, text) = (path.parent().unwrap(), fs::read_to_string(&path).unwrap());
        for rest in text.split("reference/").skip(1) {
            let end = rest.find(|c: char| !c.is_ascii_alphanumeric() && !"-_.".contains(c)).unwrap_or(rest.len());
            let file = rest[..end].trim_end_matches('.');
            if file.contains('.') {
                assert!(folder.join("reference").join(file).is_file(), "{}: reference/{file}", path.display());
            }
        }
    }
}
