//! Citations in sources, cases, tests and the guide have targets: sections and equations of the theory, equations of
//! the two papers, reference files.

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

/// Path and text of a file, whose lines of comments are one.
fn read(path: PathBuf) -> (String, String) {
    (path.strip_prefix(root()).unwrap().display().to_string(), joined(&fs::read_to_string(&path).unwrap()))
}

/// A text in one line, without the marks of comments: what is cited may stand in two lines.
fn joined(text: &str) -> String {
    let line = |line: &'_ str| line.trim_start().trim_start_matches(['/', '!', '#', '>']).trim().to_owned();
    text.lines().map(line).collect::<Vec<_>>().join(" ")
}

/// Path and text of sources, tests and cases.
fn sources() -> Vec<(String, String)> {
    let folders = ["src", "tests", "benches", "cases"];
    let all = folders.iter().flat_map(|folder| files(folder, &["rs", "toml", "md", "csv", "py"]));
    let here = Path::new(file!()).file_name().unwrap();
    all.filter(|path| path.file_name() != Some(here)).map(read).collect()
}

/// Path and text of the guide and of the pages beside it.
fn pages() -> Vec<(String, String)> {
    let beside = ["ARCHITECTURE.md", "CHANGELOG.md", "CONTRIBUTING.md", "README.md"].map(|name| root().join(name));
    files("docs/src", &["md"]).into_iter().chain(beside).map(read).collect()
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

/// The labels in the list with which a text begins: `D.2, D.3`, `D.2 to D.8`, `(D.2)–(D.4)`.
fn labels(mut rest: &str) -> Vec<String> {
    let mut found = Vec::new();
    loop {
        let open = rest.strip_prefix('(');
        let Some(name) = label(open.unwrap_or(rest)) else { return found };
        found.push(if open.is_some() { format!("({name})") } else { name.to_owned() });
        rest = &open.unwrap_or(rest)[name.len()..];
        rest = rest.strip_prefix(')').unwrap_or(rest);
        let next = [", and ", ", ", "; ", "–", " to ", " and "].iter().find_map(|between| rest.strip_prefix(between));
        let Some(next) = next else { return found };
        rest = next;
    }
}

/// The labels that a text cites: a list after the word theory, and equations in brackets anywhere.
fn cited(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    for rest in text.split("theory ").skip(1) {
        found.extend(labels(rest));
        // A number alone is no label.
        let bare = rest.starts_with(|c: char| c.is_ascii_digit());
        found.extend(bare.then(|| rest.chars().take(6).collect()));
    }
    found.extend(in_brackets(text));
    found
}

/// Lists of numbers before a citation of the theory that don't say of which paper they are: `(50, 52; theory (D.10))`.
fn without_paper(text: &str) -> Vec<&str> {
    let mut found = Vec::new();
    for (at, _) in text.match_indices("; theory ") {
        let Some(open) = text[..at].rfind('(') else { continue };
        let of_a_paper = ["Lian ", "Becker "].iter().any(|paper| text[..open].ends_with(paper));
        let is_list = text[open + 1..at].chars().all(|c| c.is_ascii_digit() || ",;– ".contains(c));
        found.extend((is_list && !of_a_paper).then_some(&text[open..at]));
    }
    found
}

/// The labels that stand in brackets.
fn in_brackets(text: &str) -> impl Iterator<Item = String> {
    text.split('(').skip(1).filter_map(|rest| {
        let name = label(rest).filter(|name| rest[name.len()..].starts_with([')', ',']))?;
        Some(format!("({name})"))
    })
}

/// The labels that a page of the guide cites: as sources do, and after the words section and chapter.
fn cited_in_guide(text: &str) -> Vec<String> {
    let words = ["section ", "sections ", "chapter "].into_iter().flat_map(|word| text.split(word).skip(1));
    let sections = words.flat_map(labels);
    sections.chain(cited(text)).collect()
}

#[test]
fn cited_sections_and_equations_of_the_theory_exist() {
    let theory = theory();
    assert!(theory.len() > 100, "{}", theory.len());
    let mut wrong = Vec::new();
    for (path, text) in sources() {
        let missing = cited(&text).into_iter().filter(|label| !theory.contains(label));
        wrong.extend(missing.map(|label| format!("{path}: theory {label}")));
        wrong.extend(without_paper(&text).into_iter().map(|list| format!("{path}: of which paper is {list}")));
    }
    // The guide puts sections in brackets, too.
    let known = |label: &String| theory.contains(label) || theory.contains(label.trim_matches(['(', ')']));
    for (path, text) in pages() {
        let missing = cited_in_guide(&text).into_iter().filter(|label| !known(label));
        wrong.extend(missing.map(|label| format!("{path}: {label}")));
    }
    assert!(wrong.is_empty(), "without a target in docs/src/theory:\n{}", wrong.join("\n"));
}

#[test]
fn labels_are_found_in_every_form() {
    let text =
        "as theory A.3, A.5 say, theory (B.12), theory D.4.1; linear theory within 3 %, f(A.x) and (C.7); theory 6.2";
    assert_eq!(cited(text), ["A.3", "A.5", "(B.12)", "D.4.1", "6.2", "(B.12)", "(C.7)"]);
    let page = "section G.12, sections F.3 and F.4; section 5 of the paper (H.9)";
    assert_eq!(cited_in_guide(page), ["G.12", "F.3", "F.4", "(H.9)"]);
    let lines = joined("/// as in theory\n    /// C.3 to C.5, and (theory (K.1)–(K.3))");
    assert_eq!(cited(&lines), ["C.3", "C.5", "(K.1)", "(K.3)", "(K.1)", "(K.3)"]);
    let numbers = "(50, 52; theory (D.10)), Lian (53–58; theory (D.12)), f(x; theory D.2), (a, 3; theory D.2)";
    assert_eq!(without_paper(numbers), ["(50, 52"]);
}

/// A source that a line `Code:` of the theory names for a section, with the items in brackets after it.
#[derive(Debug, PartialEq)]
struct CodeOfSection {
    section: String,
    path: String,
    items: Vec<String>,
}

/// The sources in the lines `Code:` of a chapter; such a line ends before an empty one.
fn code_of_sections(chapter: &str) -> Vec<CodeOfSection> {
    let (mut found, mut section) = (Vec::<CodeOfSection>::new(), String::new());
    for block in chapter.split("\n\n").map(str::trim) {
        if let Some(own) = block.strip_prefix('#').and_then(|heading| label(heading.trim_start_matches('#').trim())) {
            section = own.to_owned();
        }
        let Some(list) = block.strip_prefix("Code:") else { continue };
        let mut of_brackets = false;
        for (n, part) in list.split('`').enumerate() {
            if n % 2 == 0 {
                of_brackets = (of_brackets || part.contains('(')) && !part.contains(')');
            } else if let (true, Some(last)) = (of_brackets, found.last_mut()) {
                last.items.push(part.to_owned());
            } else {
                found.push(CodeOfSection { section: section.clone(), path: part.to_owned(), items: Vec::new() });
            }
        }
    }
    found
}

/// The file of a source that the theory names: in `src`, or of tests; a folder stands for its `mod.rs`.
fn source_of(path: &str) -> Option<PathBuf> {
    let found = [root().join("src").join(path), root().join(path)].into_iter().find(|path| path.exists())?;
    let module = found.join("mod.rs");
    Some(if module.exists() { module } else { found })
}

/// True if a source has an item of this name: a function, a type, a constant, a field or a variant.
fn has_item(text: &str, item: &str) -> bool {
    let name = item.rsplit("::").next().unwrap_or(item);
    let kinds = ["fn ", "struct ", "enum ", "trait ", "type ", "const ", "mod ", "\n    "];
    kinds.into_iter().any(|kind| {
        text.match_indices(&format!("{kind}{name}"))
            .any(|(at, found)| !text[at + found.len()..].starts_with(|c: char| c.is_alphanumeric() || c == '_'))
    })
}

/// What a source says of itself as a whole.
fn head(text: &str) -> String {
    joined(&text.lines().take_while(|line| line.starts_with("//!")).collect::<Vec<_>>().join("\n"))
}

/// Faults of a source that the theory names: it doesn't exist, lacks an item, or doesn't cite the chapter, in its head
/// or, where items are named, anywhere.
fn faults_of_code(code: &CodeOfSection) -> Vec<String> {
    let CodeOfSection { section, path, items } = code;
    let Some(file) = source_of(path) else { return vec![format!("theory {section}: no file {path}")] };
    // Of a folder without a head of its own all files are meant.
    let Ok(text) = fs::read_to_string(&file) else { return Vec::new() };
    let missing = items.iter().filter(|item| !item.contains(' ') && !has_item(&text, item));
    let mut faults: Vec<String> = missing.map(|item| format!("theory {section}: no {item} in {path}")).collect();
    let chapter = &section[..2];
    let place = if items.is_empty() { head(&text) } else { joined(&text) };
    if !cited(&place).iter().any(|label| label.trim_start_matches('(').starts_with(chapter)) {
        faults.push(format!("theory {section}: {path} doesn't cite it"));
    }
    faults
}

#[test]
fn sources_that_sections_name_exist_and_cite_the_chapter() {
    let text =
        "## B.2 Walls\n\nAs here.\n\nCode: `a/b.rs` (`one`, `Two::three`),\n`c.rs`.\n\n## B.3 Ends\n\nCode: `d.rs`.";
    let code = |section: &str, path: &str, items: &[&str]| CodeOfSection {
        section: section.into(),
        path: path.into(),
        items: items.iter().map(|&item| item.into()).collect(),
    };
    let expected = [code("B.2", "a/b.rs", &["one", "Two::three"]), code("B.2", "c.rs", &[]), code("B.3", "d.rs", &[])];
    assert_eq!(code_of_sections(text), expected);
    let all: Vec<CodeOfSection> = files("docs/src/theory", &["md"])
        .into_iter()
        .flat_map(|path| code_of_sections(&fs::read_to_string(path).unwrap()))
        .collect();
    assert!(all.len() > 300, "{}", all.len());
    let faults: Vec<String> = all.iter().flat_map(faults_of_code).collect();
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// The chapters that a text cites as a whole, by a letter alone: `theory C;`.
fn bare_chapters(text: &str) -> Vec<&str> {
    let after = text.match_indices("theory ").map(|(at, word)| (at, &text[at + word.len()..]));
    let is_bare = |rest: &str| {
        let mut letters = rest.chars();
        let is_letter = letters.next().is_some_and(|c| c.is_ascii_uppercase());
        let (next, then) = (letters.next(), letters.next());
        is_letter
            && !next.is_some_and(char::is_alphanumeric)
            && !(next == Some('.') && then.is_some_and(char::is_numeric))
    };
    after.filter(|(_, rest)| is_bare(rest)).map(|(at, rest)| &text[at..text.len() - rest.len() + 1]).collect()
}

#[test]
fn sections_are_cited_rather_than_chapters() {
    assert_eq!(
        bare_chapters("(theory J): as theory A.3, theory (B.2) and theory C.1 say; theory of A, theory F"),
        ["theory J", "theory F"]
    );
    let all = sources().into_iter().chain(pages());
    let faults: Vec<String> = all
        .flat_map(|(path, text)| {
            bare_chapters(&text).into_iter().map(|found| format!("{path}: {found}")).collect::<Vec<_>>()
        })
        .collect();
    assert!(faults.is_empty(), "a section of the chapter is meant:\n{}", faults.join("\n"));
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

/// The equations of a paper that the list names below its table, without a row.
fn without_row(paper: &str) -> Vec<u32> {
    let text = fs::read_to_string(root().join("docs/src/theory/papers.md")).unwrap();
    text.lines().filter(|line| line.starts_with("Without a row:")).flat_map(|line| equations(line, paper)).collect()
}

/// The numbers after `Lian (` or `Becker (`: `Lian (60, 61; 17–19)`, `Becker (29)–(33), (35)`.
fn equations(text: &str, paper: &str) -> Vec<u32> {
    text.split(&format!("{paper} (")).skip(1).flat_map(numbers).collect()
}

/// The numbers of a list that begins after its first bracket, and goes on in brackets of their own.
fn numbers(mut rest: &str) -> Vec<u32> {
    let (mut found, mut is_range) = (Vec::<u32>::new(), false);
    while let Some((list, after)) = rest.split_once(')') {
        let Some(own) = list.split([',', ';']).map(|item| range(item.trim())).collect::<Option<Vec<_>>>() else {
            break;
        };
        let own: Vec<u32> = own.into_iter().flatten().collect();
        if let (true, Some(last), Some(first)) = (is_range, found.last().copied(), own.first().copied()) {
            found.extend(last + 1..first);
        }
        found.extend(own);
        let next = [("–(", true), (", (", false), (" and (", false)];
        let next = next.into_iter().find_map(|(start, range)| Some((after.strip_prefix(start)?, range)));
        let Some(next) = next else { break };
        (rest, is_range) = next;
    }
    found
}

/// The numbers of `17` or `17–19`.
fn range(item: &str) -> Option<std::ops::RangeInclusive<u32>> {
    let (first, last) = item.split_once('–').unwrap_or((item, item));
    Some(first.parse().ok()?..=last.parse().ok()?)
}

#[test]
fn numbers_of_equations_are_found_in_every_form() {
    let text =
        "Lian (60, 61; 17–19), Becker (29)–(33), (35) and (36), theory (K.8) and (7); Becker (1) with (4) and (5)";
    assert_eq!(equations(text, "Lian"), [60, 61, 17, 18, 19]);
    assert_eq!(equations(text, "Becker"), [29, 30, 31, 32, 33, 35, 36, 1]);
    assert_eq!(equations("from (48), at 0.5 (17) of Lian (2014, p. 3)", "Lian"), [0; 0]);
}

/// A source without what is said of a module or an item as a whole: a number belongs to the line that does the work.
fn body(text: &str) -> String {
    let is_doc = |line: &&str| ["//!", "///"].iter().any(|mark| line.trim_start().starts_with(mark));
    text.lines().filter(|line| !is_doc(line)).collect::<Vec<_>>().join("\n")
}

#[test]
fn numbers_in_documentation_are_not_at_the_line_that_does_the_work() {
    let text = "//! All of it: Lian (53).\nimpl A {\n    /// The impulses, Lian (54).\n    fn b() {} // Lian (55)\n}";
    assert_eq!(equations(&body(text), "Lian"), [55]);
}

#[test]
fn equations_of_the_papers_are_listed_and_cited_in_the_sources_that_the_list_names() {
    for paper in ["Lian", "Becker"] {
        let (table, without_row) = (table(paper), without_row(paper));
        assert!(table.len() > 10, "{paper}");
        for (number, sources) in &table {
            for source in sources {
                let text = fs::read_to_string(root().join("src").join(source)).unwrap_or_else(|_| panic!("{source}"));
                let there = equations(&body(&text), paper).contains(number);
                assert!(there, "src/{source} doesn't say where it does {paper} ({number})");
            }
        }
        for (path, text) in sources().into_iter().chain(pages()) {
            for number in equations(&text, paper) {
                let known = without_row.contains(&number) || table.iter().any(|(listed, _)| *listed == number);
                assert!(known, "{path} cites {paper} ({number}), which docs/src/theory/papers.md doesn't list");
            }
        }
    }
}

/// The names of files in a folder of references that a text cites; none of a longer path, which is elsewhere.
fn files_cited<'a>(text: &'a str, folder: &'a str) -> impl Iterator<Item = &'a str> {
    text.match_indices(folder).filter(|(at, _)| !text[..*at].ends_with('/')).filter_map(|(at, _)| {
        let rest = &text[at + folder.len()..];
        let end = rest.find(|c: char| !c.is_ascii_alphanumeric() && !"-_.".contains(c)).unwrap_or(rest.len());
        let file = rest[..end].trim_end_matches('.');
        file.contains('.').then_some(file)
    })
}

#[test]
fn cited_reference_files_exist() {
    for path in files("cases", &["toml", "md", "csv", "py"]) {
        let text = fs::read_to_string(&path).unwrap();
        let folder = path.ancestors().find(|above| above.join("case.toml").is_file()).unwrap();
        for file in files_cited(&text, "reference/") {
            assert!(folder.join("reference").join(file).is_file(), "{}: reference/{file}", path.display());
        }
    }
    for (path, text) in sources().into_iter().chain(pages()) {
        for file in files_cited(&text, "tests/reference/") {
            assert!(root().join("tests/reference").join(file).is_file(), "{path}: tests/reference/{file}");
        }
    }
}
