//! Imports inside of the library: the rooms of `mpm`, `pfem2` and `pfem2/solid` in the order of their tables, and no
//! circles among the files of a folder.

use crate::layering::{outermost, root, sources, without_tests};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// Modules of a folder, each with the others that it imports.
type Imports = BTreeMap<String, BTreeSet<String>>;

/// The module of a file below `src`, by its names.
fn module(path: &Path) -> Vec<String> {
    let below = path.strip_prefix(root().join("src")).unwrap().with_extension("");
    let mut names: Vec<String> = below.iter().map(|name| name.to_str().unwrap().to_owned()).collect();
    names.pop_if(|last| last == "mod");
    names
}

/// The paths of an import that begins here, `a::b`, or `a::{b, c::d}`.
fn tree(text: &str) -> Vec<Vec<String>> {
    if let Some(list) = text.strip_prefix('{') {
        return outermost(list).into_iter().flat_map(tree).collect();
    }
    let end = text.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(text.len());
    let name = text[..end].to_owned();
    let Some(rest) = text[end..].strip_prefix("::") else { return vec![vec![name]] };
    let mut paths = tree(rest);
    paths.iter_mut().for_each(|path| path.insert(0, name.clone()));
    paths
}

/// The places below `crate` that the source of a module names.
fn named(module: &[String], text: &str) -> Vec<Vec<String>> {
    let code = without_tests(text);
    let is_start = |at: usize| !code[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == ':');
    let starts = ["crate::", "super::"].into_iter().flat_map(|word| code.match_indices(word)).map(|(at, _)| at);
    let paths = starts.filter(|&at| is_start(at)).flat_map(|at| tree(&code[at..]));
    let resolved = paths.map(|path| {
        let supers = path.iter().take_while(|name| *name == "super").count();
        let base = if path[0] == "crate" { &[] } else { &module[..module.len() - supers] };
        base.iter().chain(&path[supers.max(1)..]).cloned().collect()
    });
    resolved.collect()
}

/// Names that the module of a folder takes from its own modules, each with the module.
fn shared(folder: &str, known: &BTreeSet<String>) -> BTreeMap<String, String> {
    let base = root().join("src").join(folder);
    let own = [base.join("mod.rs"), base.with_extension("rs")].into_iter().find(|path| path.exists());
    let code = own.map(|path| without_tests(&fs::read_to_string(path).unwrap())).unwrap_or_default();
    let mut shared = BTreeMap::new();
    for statement in code.split(';') {
        let line = statement.trim_start().rsplit_once("use ").filter(|(before, _)| is_visibility(before));
        for mut path in line.map(|(_, names)| tree(names)).unwrap_or_default() {
            if known.contains(&path[0]) {
                path.pop_if(|last| last == "self");
                shared.insert(path[path.len() - 1].clone(), path[0].clone());
            }
        }
    }
    shared
}

/// True for what may stand before `use`.
fn is_visibility(text: &str) -> bool {
    text.is_empty() || text.starts_with("pub") && !text.contains(['{', '='])
}

/// The modules of a folder below `src`, and what they import of one another, also by the names that their parent
/// shares; those of a folder in it count as one. Tests don't count.
fn imports(folder: &str) -> Imports {
    let parent: Vec<String> = folder.split('/').map(str::to_owned).collect();
    let mut files = Vec::new();
    sources(&root().join("src").join(folder), &mut files);
    let modules: Vec<(Vec<String>, String)> =
        files.iter().map(|path| (module(path), fs::read_to_string(path).unwrap())).collect();
    let inside = |path: &[String]| path.strip_prefix(&parent[..]).and_then(|rest| rest.first()).cloned();
    let names = modules.iter().filter_map(|(module, _)| inside(module)).filter(|name| name != "tests");
    let mut imports: Imports = names.map(|name| (name, BTreeSet::new())).collect();
    let known: BTreeSet<String> = imports.keys().cloned().collect();
    let shared = shared(folder, &known);
    for (module, text) in modules.iter().filter(|(module, _)| !module.iter().any(|name| name == "tests")) {
        let Some(own) = inside(module) else { continue };
        let others = named(module, text).into_iter().filter_map(|path| inside(&path));
        let others = others.map(|name| shared.get(&name).cloned().unwrap_or(name));
        let others = others.filter(|name| *name != own && known.contains(name));
        imports.entry(own.clone()).or_default().extend(others);
    }
    imports
}

/// The modules that import each other in a circle, or those that do so.
fn in_circles(mut imports: Imports) -> Vec<String> {
    loop {
        let done: Vec<String> =
            imports.iter().filter(|(_, others)| others.is_empty()).map(|(name, _)| name.clone()).collect();
        if done.is_empty() {
            return imports.into_keys().collect();
        }
        imports.retain(|name, _| !done.contains(name));
        imports.values_mut().for_each(|others| others.retain(|name| !done.contains(name)));
    }
}

/// All folders below `src`, as `mpm/grid`.
fn folders() -> BTreeSet<String> {
    let mut files = Vec::new();
    sources(&root().join("src"), &mut files);
    let folder = |path: &std::path::PathBuf| {
        let folder = path.parent().unwrap().strip_prefix(root().join("src")).unwrap().to_str().unwrap().to_owned();
        (!folder.is_empty()).then_some(folder)
    };
    files.iter().filter_map(folder).collect()
}

#[test]
fn files_of_a_folder_import_each_other_in_one_direction() {
    let mut wrong = Vec::new();
    for folder in folders() {
        let circles = in_circles(imports(&folder));
        if !circles.is_empty() {
            wrong.push(format!("src/{folder}: {circles:?}"));
        }
    }
    assert!(wrong.is_empty(), "these import each other in circles, or import such files:\n{}", wrong.join("\n"));
}

/// The rows of a list of rooms, from above, in the part of a text that begins so.
fn rooms(text: &str, beginning: &str) -> Vec<Vec<String>> {
    let section = text.split(beginning).nth(1).expect("the list of rooms is introduced");
    let rows = section.lines().skip_while(|line| !line.starts_with("|---")).skip(1);
    let names = |row: &str| {
        let cell = row.split('|').nth(1).unwrap_or_default();
        cell.split('`').skip(1).step_by(2).map(|name| name.trim_end_matches(".rs").to_owned()).collect()
    };
    rows.take_while(|line| line.starts_with('|')).map(names).collect()
}

/// Imports among rooms against their order: each may import those below it in the list.
fn against(rooms: &[Vec<String>], imports: &Imports) -> Vec<String> {
    let place = |name: &String| rooms.iter().position(|row| row.contains(name));
    let mut wrong: Vec<String> =
        imports.keys().filter(|name| place(name).is_none()).map(|name| format!("{name} has no row")).collect();
    for (name, others) in imports {
        wrong.extend(
            others.iter().filter(|other| place(other) < place(name)).map(|other| format!("{name} imports {other}")),
        );
    }
    wrong
}

#[test]
fn rooms_of_solids_import_those_below_in_the_list() {
    let text = fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap();
    let imports = imports("pfem2/solid");
    let wrong = against(&rooms(&text, "`pfem2/solid` has rooms, too"), &imports);
    assert!(wrong.is_empty(), "against the list of rooms in ARCHITECTURE.md:\n{}", wrong.join("\n"));
    assert!(imports["coupling"].contains("cut"), "imports are found: {imports:?}");
}

/// Imports of the rooms of a method, which follow the table in its `mod.rs`: each imports those above it.
fn follow_their_table(method: &str) -> Imports {
    let path = format!("src/{method}/mod.rs");
    let text = fs::read_to_string(root().join(&path)).unwrap().replace("//! ", "");
    let (mut rooms, imports) = (rooms(&text, "| room |"), imports(method));
    rooms.reverse();
    let wrong = against(&rooms, &imports);
    assert!(wrong.is_empty(), "against the list of rooms in {path}:\n{}", wrong.join("\n"));
    imports
}

#[test]
fn rooms_of_material_points_import_those_above_in_the_list() {
    let imports = follow_their_table("mpm");
    assert!(imports["contact"].contains("leapfrog"), "names that the parent shares are found: {imports:?}");
}

#[test]
fn rooms_of_fluids_on_a_mesh_import_those_above_in_the_list() {
    let imports = follow_their_table("pfem2");
    assert!(imports["report"].contains("step"), "names that the parent shares are found: {imports:?}");
}

#[test]
fn places_are_found_in_every_form() {
    let text = "use super::{Structure, element::{A, B}};\nuse crate::pfem2::solid::{mesh::Mesh, setup};\n\
        #[cfg(test)]\nuse crate::never;\nfn f() { super::super::cut::g() }";
    let module = ["pfem2", "solid", "structure", "sums"].map(str::to_owned);
    let found: BTreeSet<String> = named(&module, text).iter().map(|path| path.join("/")).collect();
    let own = ["Structure", "element/A", "element/B"].map(|name| format!("pfem2/solid/structure/{name}"));
    let others = ["pfem2/solid/mesh/Mesh", "pfem2/solid/setup", "pfem2/solid/cut/g"].map(str::to_owned);
    assert_eq!(found, own.into_iter().chain(others).collect());
}

#[test]
fn circles_are_found() {
    let imports = |pairs: &[(&str, &[&str])]| -> Imports {
        pairs.iter().map(|(a, b)| ((*a).to_owned(), b.iter().map(|b| (*b).to_owned()).collect())).collect()
    };
    assert!(in_circles(imports(&[("a", &["b", "c"]), ("b", &["c"]), ("c", &[])])).is_empty());
    assert_eq!(in_circles(imports(&[("a", &["b"]), ("b", &["a"]), ("c", &[])])), ["a", "b"]);
}
