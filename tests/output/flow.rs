//! Outputs of PFEM-2 runs: the pressure at the start, values between nodes, impulses over a window of time.

use lateen::case::{Case, Source};
use lateen::output::history::HistoryTable;
use lateen::run::{Existing, Options, RunDirectory, run};
use std::fs;
use std::path::Path;

const FLOW: &str = include_str!("../fixtures/two_fluids.toml");

/// Water at rest under gravity in a closed box one metre high, whose pressure is zero at the top.
const REST: &str = r#"
name = "rest"
method = "pfem2"
dimension = 2
[time]
end = "0.4 s"
step = "0.04 s"
[mesh]
shape = "box"
lower = [0, 0]
upper = [1, 1]
cell = 0.3
[pfem2]
gravity = [0, -10]
[[body]]
name = "water"
region = { shape = "box", lower = [0, 0], upper = [1, 1] }
material = { law = "newtonian", density = 1000, viscosity = 1e-3 }
[[boundary]]
on = "rest"
kind = "slip"
[output]
history = "0.04 s"
[[probe]]
name = "depth"
of = "mesh"
quantity = "pressure"
at = [0.4, 0.37]
[[probe]]
name = "impulse"
of = "mesh"
quantity = "pressure"
at = [0.4, 0.37]
impulse = ["0.11 s", "0.27 s"]
"#;

/// The pressure at y = 0.37 m [Pa].
const PRESSURE: f64 = 1000.0 * 10.0 * (1.0 - 0.37);

fn case(text: &str) -> Case {
    Case::read(Source::new("case.toml", "", text), &[]).unwrap_or_else(|error| panic!("{error}"))
}

fn go(text: &str, home: &Path, existing: Existing) {
    let case = case(text);
    let options = Options { existing, ..Options::default() };
    run(&case, case.build().unwrap(), &RunDirectory::new(home), options).unwrap_or_else(|error| panic!("{error}"));
}

fn history(home: &Path, name: &str) -> HistoryTable {
    HistoryTable::read(&home.join(format!("history/{name}.csv"))).unwrap()
}

/// ρ g (1 − y) in every row; the place lies between the nodes of a mesh of 3 × 3 cells.
#[test]
fn water_at_rest_has_the_hydrostatic_pressure_from_the_first_row_on() {
    for scheme in ["", "scheme = { kind = \"backward-euler\" }\n"] {
        let home = tempfile::tempdir().unwrap();
        go(&REST.replace("[pfem2]\n", &format!("[pfem2]\n{scheme}")), home.path(), Existing::Refuse);
        let table = history(home.path(), "depth");
        let pressure = table.column("pressure").unwrap();
        assert_eq!(pressure.len(), 11);
        for (row, p) in pressure.iter().enumerate() {
            assert!((p / PRESSURE - 1.0).abs() < 1e-6, "{scheme} row {row}: {p} Pa instead of {PRESSURE}");
        }
        // Nothing has been counted before the first step.
        let counts = history(home.path(), "counts");
        assert_eq!(counts.column("solver: preconditioners").unwrap()[0], 0.0);
    }
}

/// Both ends of the window of 0.16 s lie within steps.
#[test]
fn the_impulse_of_a_steady_pressure_is_pressure_times_time() {
    let home = tempfile::tempdir().unwrap();
    go(REST, home.path(), Existing::Refuse);
    let table = history(home.path(), "impulse");
    assert_eq!(table.heads, ["time [s]", "pressure impulse [Pa s]"]);
    let (time, impulse) = (table.column("time").unwrap(), table.column("pressure impulse").unwrap());
    for (t, impulse) in time.iter().zip(impulse) {
        let exact = PRESSURE * (t.clamp(0.11, 0.27) - 0.11);
        assert!((impulse - exact).abs() < 1e-6 * PRESSURE, "{t}: {impulse} instead of {exact}");
    }
}

#[test]
fn cells_that_do_not_divide_the_box_are_reported() {
    let model = case(REST).model().unwrap();
    let said = model.summary.notes.join("\n");
    assert!(said.contains("no whole number of cells of 0.3 m; there are 3 of 0.333333 m along x, 3 of"), "{said}");
    assert!(!said.contains("probe"), "a place in the mesh is no adjustment: {said}");
    let whole = case(&REST.replace("cell = 0.3", "cell = 0.25")).model().unwrap();
    assert!(!whole.summary.notes.join("\n").contains("whole number"));
}

const PRESSED: &str = r#"
[[probe]]
name = "pressed"
of = "mesh"
quantity = "pressure"
at = ["0.03 m", "0.31 m"]
impulse = ["0.11 s", "0.27 s"]
"#;

/// Sloshing, stopped within the window and resumed; the reference is the uninterrupted run.
#[test]
fn an_impulse_continues_bit_for_bit_after_a_resumption() {
    let text = format!("{FLOW}{PRESSED}");
    let short = text.replace("end = \"0.4 s\"", "end = \"0.2 s\"");
    let [whole, parts] = [(); 2].map(|()| tempfile::tempdir().unwrap());
    go(&text, whole.path(), Existing::Refuse);
    go(&short, parts.path(), Existing::Refuse);
    go(&text, parts.path(), Existing::Resume);
    for name in ["pressed", "balance", "counts"] {
        let read = |home: &Path| fs::read_to_string(home.join(format!("history/{name}.csv"))).unwrap();
        assert_eq!(read(whole.path()), read(parts.path()), "{name}");
    }
    assert!(history(whole.path(), "pressed").column("pressure impulse").unwrap().last().unwrap().abs() > 1.0);
}

/// An impulse that is asked for within its window has no value; one that is no longer asked for is dropped.
#[test]
fn outputs_may_be_added_and_dropped_when_a_run_is_resumed() {
    let short = FLOW.replace("end = \"0.4 s\"", "end = \"0.2 s\"");
    let home = tempfile::tempdir().unwrap();
    go(&short, home.path(), Existing::Refuse);
    go(&format!("{}{PRESSED}", FLOW.replace("0.4 s", "0.3 s")), home.path(), Existing::Resume);
    let table = history(home.path(), "pressed");
    assert!(table.column("pressure impulse").unwrap().iter().all(|value| value.is_nan()));
    go(FLOW, home.path(), Existing::Resume);
    assert_eq!(history(home.path(), "balance").column("time").unwrap().last(), Some(&0.4));
}
