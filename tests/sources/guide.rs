//! The documentation against the program: the cases that it prints build, the messages that it explains are said, the
//! sources that it names exist.

use lateen::Error;
use lateen::case::{Case, Source};
use std::fs;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// All files below a folder with this extension.
fn files(folder: &str, extension: &str) -> Vec<PathBuf> {
    let (mut found, mut folders) = (Vec::new(), vec![root().join(folder)]);
    while let Some(folder) = folders.pop() {
        for path in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|found| found == extension) {
                found.push(path);
            }
        }
    }
    found
}

fn page(name: &str) -> String {
    fs::read_to_string(root().join("docs/src").join(name)).unwrap()
}

/// The cases of a page: a block of TOML that begins with a name, with the blocks of `[[membrane]]` that are to be added
/// to it.
fn cases(page: &str) -> Vec<String> {
    let mut cases: Vec<String> = Vec::new();
    for block in page.split("```toml\n").skip(1).map(|rest| rest.split("```").next().unwrap()) {
        if block.starts_with("name = ") {
            cases.push(block.to_owned());
        } else if block.starts_with("[[membrane]]") {
            let whole = format!("{}{block}", cases.last().expect("a case to add it to"));
            cases.push(whole);
        }
    }
    cases
}

#[test]
fn cases_printed_in_the_guide_build_without_warnings() {
    for (name, count) in [("first-case.md", 3), ("case-file.md", 2)] {
        let cases = cases(&page(name));
        assert_eq!(cases.len(), count, "{name}");
        for text in cases {
            let source = Source::new("case.toml", "", text);
            match Case::read(source.clone(), &[]).and_then(|case| case.model()) {
                Ok(model) => assert!(model.warnings.is_empty(), "{name}:\n{}", source.render(&model.warnings, false)),
                Err(Error::Case(findings)) => panic!("{name}:\n{}", source.render(&findings, false)),
                Err(other) => panic!("{name}: {other}"),
            }
        }
    }
}

/// The texts in backticks.
fn code(text: &str) -> impl Iterator<Item = &str> {
    text.split('`').skip(1).step_by(2)
}

/// The sources, with texts that run over several lines in one piece.
fn sources() -> String {
    let texts = files("src", "rs").into_iter().map(|path| fs::read_to_string(path).unwrap());
    let joined = |text: String| text.split("\\\n").map(str::trim_start).collect::<String>();
    texts.map(joined).collect()
}

/// Messages stand in the first cells of tables, with `…` for what depends on the case.
#[test]
fn messages_explained_in_the_guide_are_those_of_the_program() {
    let (page, sources) = (page("troubleshooting.md"), sources());
    let first_cells = page.lines().filter_map(|line| line.strip_prefix("| `")?.split(" |").next());
    let messages: Vec<String> =
        first_cells.flat_map(|cell| code(&format!("`{cell}")).map(str::to_owned).collect::<Vec<_>>()).collect();
    assert!(messages.len() > 30, "{}", messages.len());
    for message in messages {
        let mut parts = message.split('…').map(str::trim).filter(|part| !part.is_empty());
        assert!(parts.all(|part| sources.contains(part)), "no source says `{message}`");
    }
}

/// Examples of files that are to be written.
const EXAMPLES: [&str; 2] = ["ogden.rs", "roma.rs"];

#[test]
fn sources_named_in_the_documentation_exist() {
    let mut pages = files("docs/src", "md");
    pages.extend(["ARCHITECTURE.md", "CONTRIBUTING.md", "README.md"].map(|name| root().join(name)));
    let known: Vec<PathBuf> = ["src", "tests", "benches"].iter().flat_map(|folder| files(folder, "rs")).collect();
    let is_path = |name: &&str| name.ends_with(".rs") && !name.contains([' ', '*', '<', '…']);
    let mut named = 0;
    for path in pages {
        let text = fs::read_to_string(&path).unwrap();
        for name in code(&text).filter(is_path).filter(|name| !EXAMPLES.contains(name)) {
            named += 1;
            assert!(known.iter().any(|file| file.ends_with(Path::new(name))), "{}: `{name}`", path.display());
        }
    }
    assert!(named > 100, "{named}");
}
