//! The import table of ARCHITECTURE.md, held against the sources: a module imports what its row names, and nothing
//! else.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

type Layers = BTreeMap<String, BTreeSet<String>>;

pub fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// The rows of the table: `| module | imports |`, both as comma-separated names in backticks.
fn table() -> Layers {
    let text = fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap();
    let section = text.split("## What may import what").nth(1).expect("the table has its heading");
    let rows = section.lines().skip_while(|line| !line.starts_with("|---")).skip(1);
    let names = |cell: &str| -> BTreeSet<String> { cell.split('`').skip(1).step_by(2).map(str::to_owned).collect() };
    let mut layers = Layers::new();
    for row in rows.take_while(|line| line.starts_with('|')) {
        let cells: Vec<&str> = row.split('|').collect();
        for module in names(cells[1]) {
            layers.insert(module, names(cells[2]));
        }
    }
    layers
}

pub fn sources(path: &Path, files: &mut Vec<PathBuf>) {
    if path.is_dir() {
        for entry in fs::read_dir(path).unwrap() {
            sources(&entry.unwrap().path(), files);
        }
    } else if path.extension().is_some_and(|extension| extension == "rs") {
        files.push(path.to_owned());
    }
}

/// The source without comments and without the items behind `#[cfg(test)]`.
pub fn without_tests(text: &str) -> String {
    let code = text.lines().filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n");
    let mut parts = code.split("#[cfg(test)]");
    let mut kept = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        kept.push_str(&part[end_of_item(part)..]);
    }
    kept
}

/// The end of the item that `text` begins with: a semicolon, or the brace that closes its first one.
fn end_of_item(text: &str) -> usize {
    let mut depth = 0;
    for (at, c) in text.char_indices() {
        match c {
            ';' if depth == 0 => return at + 1,
            '{' => depth += 1,
            '}' if depth == 1 => return at + 1,
            '}' => depth -= 1,
            _ => {}
        }
    }
    text.len()
}

/// The top-level modules that a source names: `crate::name`, and `crate::{a, b::{c, d}}`.
fn imports(text: &str) -> BTreeSet<String> {
    let code = without_tests(text);
    let mut found = BTreeSet::new();
    for rest in code.split("crate::").skip(1) {
        let names = match rest.strip_prefix('{') {
            Some(list) => outermost(list),
            None => vec![rest],
        };
        for name in names {
            let end = name.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(name.len());
            found.insert(name[..end].to_owned());
        }
    }
    found
}

/// The elements of a list in braces, which has begun, each with all that it has in braces of its own.
pub fn outermost(list: &str) -> Vec<&str> {
    let (mut names, mut depth, mut start) = (Vec::new(), 0, 0);
    for (at, c) in list.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth > 0 => depth -= 1,
            ',' | '}' if depth == 0 => {
                names.push(list[start..at].trim());
                start = at + 1;
                if c == '}' {
                    break;
                }
            }
            _ => {}
        }
    }
    names.retain(|name| !name.is_empty());
    names
}

/// The files of a module of the library.
fn files_of(module: &str) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for path in [root().join(format!("src/{module}.rs")), root().join("src").join(module)] {
        if path.exists() {
            sources(&path, &mut files);
        }
    }
    assert!(!files.is_empty(), "the table has a row for `{module}`, which does not exist");
    files
}

#[test]
fn modules_import_what_the_table_allows_and_all_of_it() {
    let table = table();
    let mut wrong = Vec::new();
    for (module, allowed) in &table {
        let mut unused = allowed.clone();
        for file in files_of(module) {
            let imports = imports(&fs::read_to_string(&file).unwrap());
            unused.retain(|name| !imports.contains(name));
            let foreign = imports.into_iter().filter(|name| table.contains_key(name) && name != module);
            let forbidden: Vec<String> = foreign.filter(|name| !allowed.contains(name)).collect();
            if !forbidden.is_empty() {
                wrong.push(format!("{} imports {forbidden:?}", file.strip_prefix(root()).unwrap().display()));
            }
        }
        if !unused.is_empty() {
            wrong.push(format!("the row of `{module}` allows {unused:?}, which it doesn't import"));
        }
    }
    assert!(wrong.is_empty(), "against the table of ARCHITECTURE.md:\n{}", wrong.join("\n"));
}

/// Loops go through `parallel`, so that sums have one place and one order; the transfers and the linear algebra cut
/// their work themselves.
#[test]
fn only_parallel_transfers_and_linalg_use_rayon() {
    let rooms = ["src/parallel", "src/mpm/transfer", "src/linalg"];
    let mut files = Vec::new();
    sources(&root().join("src"), &mut files);
    let names = |path: &PathBuf| without_tests(&fs::read_to_string(path).unwrap()).contains("rayon");
    let outside = |path: &PathBuf| !rooms.iter().any(|room| path.starts_with(root().join(room)));
    let is_test = |path: &PathBuf| path.iter().any(|part| part == "tests" || part == "tests.rs");
    let wrong: Vec<_> = files.iter().filter(|path| outside(path) && !is_test(path) && names(path)).collect();
    assert!(wrong.is_empty(), "loops in parallel, not by rayon itself: {wrong:?}");
}

#[test]
fn every_module_has_a_row() {
    let table = table();
    let lib = fs::read_to_string(root().join("src/lib.rs")).unwrap();
    for line in lib.lines() {
        if let Some(module) = line.strip_prefix("pub mod ").and_then(|rest| rest.strip_suffix(';')) {
            assert!(table.contains_key(module), "`{module}` has no row in the table of ARCHITECTURE.md");
        }
    }
}

#[test]
fn the_table_has_no_cycles() {
    let table = table();
    let mut ordered: BTreeSet<&String> = BTreeSet::new();
    while ordered.len() < table.len() {
        let next =
            table.iter().find(|(name, below)| !ordered.contains(name) && below.iter().all(|b| ordered.contains(b)));
        let (name, _) = next.expect("some modules import each other in a circle, or import one without a row");
        ordered.insert(name);
    }
}

#[test]
fn imports_are_found_in_every_form() {
    let text = "#[cfg(test)]\nmod tests;\nuse crate::math::Vector;\nuse crate::{error, linalg::{A, B}, mesh::Mesh};\n\
        // crate::case\nlet x = crate::geometry::f();\n#[cfg(test)]\nmod more {\n    fn f() { crate::cli::run(); }\n}\n\
        fn g() { crate::run::h() }";
    let found = imports(text);
    assert_eq!(found.into_iter().collect::<Vec<_>>(), ["error", "geometry", "linalg", "math", "mesh", "run"]);
}
