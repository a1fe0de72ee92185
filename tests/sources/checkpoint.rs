//! The table of ARCHITECTURE.md of what a checkpoint keeps, held against the sources and against the columns of both
//! methods.

use crate::layering::{root, sources, without_tests};
use lateen::case::{Case, Source};
use lateen::simulation::OF_OUTPUT;
use std::collections::BTreeSet;
use std::fs;

/// Fluid on both sides of a closed membrane, and an obstacle.
const POINTS: &str = r#"
name = "loop"
method = "mpm"
dimension = 2
[time]
end = "1 ms"
[grid]
cell = "0.1 m"
lower = [-0.6, -0.6]
upper = [0.6, 0.6]
walls = { left = "slip", right = "slip", bottom = "slip", top = "slip" }
[[body]]
name = "gas"
region = { shape = "box", lower = [-0.6, -0.6], upper = [0.4, 0.6] }
particles-per-cell = 2
pressure = 1e5
material = { law = "fluid", density = 1.2, eos = { kind = "ideal-gas", gamma = 1.4 } }
[[membrane]]
name = "loop"
geometry = { shape = "circle", center = [0, 0], radius = 0.3, divisions = 24 }
thickness = "1 mm"
material = { law = "elastic", density = 1000, young = 1e6, poisson = 0.3 }
[[obstacle]]
name = "post"
region = { shape = "sphere", center = [0.5, 0], radius = 0.05 }
"#;

/// Two fluids and an elastic solid.
const FLOW: &str = r#"
name = "flow"
method = "pfem2"
dimension = 2
[time]
end = "0.1 s"
step = "0.01 s"
[mesh]
shape = "box"
lower = [0, 0]
upper = [1, 1]
cell = "0.1 m"
[[body]]
name = "float"
region = { shape = "box", lower = [0.32, 0.32], upper = [0.68, 0.68] }
material = { law = "st-venant-kirchhoff", density = 500, young = 1e6, poisson = 0.3 }
[[body]]
name = "water"
region = { shape = "box", lower = [-1, -1], upper = [2, 0.47] }
material = { law = "newtonian", density = 1000, viscosity = 1e-3 }
[[body]]
name = "oil"
region = { shape = "box", lower = [-1, -1], upper = [2, 2] }
material = { law = "newtonian", density = 800, viscosity = 0.01 }
[[boundary]]
on = "rest"
kind = "slip"
"#;

/// A row of the table: the beginnings of the names of its columns, and the files that show them.
struct Row {
    beginnings: Vec<String>,
    files: Vec<String>,
}

fn rows() -> Vec<Row> {
    let text = fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap();
    let section = text.split("## What a checkpoint keeps").nth(1).expect("the table has its heading");
    let lines = section.lines().skip_while(|line| !line.starts_with("|---")).skip(1);
    let quoted = |cell: &str| -> Vec<String> { cell.split('`').skip(1).step_by(2).map(str::to_owned).collect() };
    let row = |line: &str| {
        let cells: Vec<&str> = line.split('|').collect();
        Row { beginnings: quoted(cells[3]), files: quoted(cells[4]) }
    };
    lines.take_while(|line| line.starts_with('|')).map(row).collect()
}

/// True if a source makes columns.
fn shows_columns(text: &str) -> bool {
    let code = without_tests(text);
    let made = |end: &str| ["new", "growing", "scalar", "record"].iter().any(|name| end.starts_with(name));
    code.split("Column::").skip(1).any(made)
}

#[test]
fn files_that_show_columns_are_those_of_the_table() {
    let listed: BTreeSet<String> = rows().into_iter().flat_map(|row| row.files).collect();
    let mut files = Vec::new();
    sources(&root().join("src"), &mut files);
    let mut showing = BTreeSet::new();
    for path in files.iter().filter(|path| !path.iter().any(|part| part == "tests")) {
        if shows_columns(&fs::read_to_string(path).unwrap()) {
            showing.insert(path.strip_prefix(root().join("src")).unwrap().to_str().unwrap().to_owned());
        }
    }
    let missing: Vec<_> = showing.difference(&listed).collect();
    assert!(missing.is_empty(), "they show columns that the table of ARCHITECTURE.md has no row for: {missing:?}");
    let idle: Vec<_> = listed.difference(&showing).collect();
    assert!(idle.is_empty(), "they show no columns, or don't exist: {idle:?}");
}

#[test]
fn names_of_columns_begin_as_the_table_says() {
    let rows = rows();
    let beginnings: Vec<&String> = rows.iter().flat_map(|row| &row.beginnings).collect();
    let (mut unknown, mut met) = (Vec::new(), BTreeSet::new());
    for text in [POINTS, FLOW] {
        let case = Case::read(Source::new("case.toml", "", text), &[]).unwrap_or_else(|error| panic!("{error}"));
        let mut solver = case.build().unwrap_or_else(|error| panic!("{error}"));
        solver.columns(&mut |name, _| {
            let longest = beginnings.iter().filter(|begin| name.starts_with(begin.as_str())).max_by_key(|b| b.len());
            match longest {
                Some(begin) => drop(met.insert((*begin).clone())),
                None => unknown.push(name.to_owned()),
            }
        });
    }
    assert!(unknown.is_empty(), "columns that no row of the table names: {unknown:?}");
    // Solvers don't show those of the time loop and of outputs.
    let others = |begin: &&String| *begin == "loop/" || *begin == OF_OUTPUT;
    let unmet: Vec<_> = beginnings.into_iter().filter(|begin| !met.contains(*begin) && !others(begin)).collect();
    assert!(unmet.is_empty(), "no column begins so: {unmet:?}");
}

#[test]
fn columns_are_found_outside_of_tests_and_comments() {
    assert!(shows_columns("visit(\"a\", Column::new::<f64>(&mut a));") && shows_columns("..Column::growing(&mut a)"));
    assert!(!shows_columns("/// Column::new(&mut a)\nfn f(column: Column<'_>) {}"));
    assert!(!shows_columns("#[cfg(test)]\nmod tests { fn f() { Column::scalar(&mut a); } }"));
}
