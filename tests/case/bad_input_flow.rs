//! Errors and unusual events of PFEM-2: meshes from files, boundary conditions, fluids that leave or enter, a linear
//! solver that fails. Errors in the keys are tested in `flow.rs`.

use super::findings::model;
use lateen::Error;
use lateen::case::{Case, Model, Source};
use lateen::error::{Diagnostic, Severity};
use lateen::run::{Options, RunDirectory, run};
use lateen::simulation::{Event, Observer, Progress};
use std::path::Path;
use std::sync::{Arc, Mutex};

const CHANNEL: &str = r#"
name = "channel"
method = "pfem2"
dimension = 2
units = "none"
[time]
end = 1.5
step = 0.05
[mesh]
shape = "box"
lower = [0, 0]
upper = [1, 0.4]
cell = 0.1
[[body]]
name = "water"
region = { shape = "half-space", point = [START, 0], normal = [1, 0] }
velocity = [SPEED, 0]
material = { law = "newtonian", density = 2.0, viscosity = 0.01 }
[[body]]
name = "oil"
region = { shape = "box", lower = [-1, -1], upper = [2, 2] }
velocity = [SPEED, 0]
material = { law = "newtonian", density = 1.0, viscosity = 0.01 }
[[boundary]]
on = "left"
kind = "inlet"
velocity = [SPEED, 0]
# left
[[boundary]]
on = "right"
kind = "outlet"
# right
[[boundary]]
on = ["bottom", "top"]
kind = "slip"
[output]
history = 0.05
"#;

/// A channel in which water reaches from the left to `start`, and everything moves with `speed`.
fn channel(start: &str, speed: &str) -> String {
    CHANNEL.replace("START", start).replace("SPEED", speed)
}

/// Nodes of a unit square with a fifth one at the centre of nothing.
const NODES: &str = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n3\n1 1 \"around\"\n1 2 \"lid\"\n2 3 \"domain\"\n\
    $EndPhysicalNames\n$Nodes\n6\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n5 7 8 0\n6 2 0 0\n$EndNodes\n";

/// A closed case on a file of these elements.
fn on_file(elements: &[&str]) -> Result<Model, Vec<Diagnostic>> {
    on_nodes(NODES, elements)
}

/// A closed case on a file with other nodes or groups.
fn on_nodes(nodes: &str, elements: &[&str]) -> Result<Model, Vec<Diagnostic>> {
    let home = tempfile::tempdir().unwrap();
    let lines: Vec<String> = elements.iter().enumerate().map(|(i, e)| format!("{} {e}\n", i + 1)).collect();
    let text = format!("{nodes}$Elements\n{}\n{}$EndElements\n", lines.len(), lines.concat());
    std::fs::write(home.path().join("domain.msh"), text).unwrap();
    let case = "name = \"file\"\nmethod = \"pfem2\"\ndimension = 2\nunits = \"none\"\n[time]\nend = 1.0\nstep = 0.1\n\
        [mesh]\nshape = \"file\"\npath = \"domain.msh\"\n[[body]]\nname = \"oil\"\n\
        region = { shape = \"box\", lower = [-9, -9], upper = [9, 9] }\n\
        material = { law = \"newtonian\", density = 1.0, viscosity = 0.1 }\n[[boundary]]\non = \"around\"\n";
    model(case, home.path())
}

const TRIANGLES: [&str; 2] = ["2 2 3 1 1 2 3", "2 2 3 1 1 3 4"];
const AROUND: [&str; 4] = ["1 2 1 1 1 2", "1 2 1 1 2 3", "1 2 1 1 3 4", "1 2 1 1 4 1"];

#[track_caller]
fn one(found: Result<Model, Vec<Diagnostic>>) -> Diagnostic {
    let found = found.map(|_| ()).unwrap_err();
    assert_eq!(found.len(), 1, "{found:?}");
    found[0].clone()
}

#[test]
fn inverted_and_flat_elements_are_named_with_their_place() {
    let inverted = one(on_file(&[TRIANGLES[0], "2 2 3 1 1 4 3"]));
    assert!(inverted.message.contains("element 2 at") && inverted.message.contains("inverted"), "{inverted:?}");
    assert!(inverted.message.contains("reverse its order"));
    let flat = one(on_file(&[TRIANGLES[0], "2 2 3 1 1 2 6"]));
    assert!(flat.message.contains("element 2 at") && flat.message.contains("degenerate"), "{flat:?}");
    assert_eq!(flat.key, "mesh.path");
}

#[test]
fn isolated_nodes_are_left_out_with_a_warning() {
    let model = on_file(&[&TRIANGLES[..], &AROUND[..]].concat()).unwrap();
    assert_eq!(model.summary.nodes, 4);
    let [warning] = &model.warnings[..] else { panic!("{:?}", model.warnings) };
    assert_eq!(warning.severity, Severity::Warning);
    assert!(warning.message.contains("2 nodes belong to no element, the first at (7.0"), "{warning:?}");
    assert!(model.summary.to_string().contains("pressure: zero at the highest node"));
}

#[test]
fn groups_without_a_condition_are_errors_and_facets_without_a_group_are_warned_of() {
    let unsaid = one(on_file(&[&TRIANGLES[..], &AROUND[..3], &["1 2 2 1 4 1"]].concat()));
    assert!(unsaid.message.contains("nothing is prescribed on `lid`"), "{unsaid:?}");
    let model = on_file(&[&TRIANGLES[..], &AROUND[..3]].concat()).unwrap();
    let texts: Vec<&str> = model.warnings.iter().map(|warning| warning.message.as_str()).collect();
    assert!(texts.iter().any(|text| text.contains("1 facets of the boundary are in no named part, the first at (0.0")));
}

/// A mesh in 2D lies in x and y: in any plane z = const, up to rounding.
#[test]
fn a_plane_mesh_with_differing_z_is_an_error() {
    let elements = [&TRIANGLES[..], &AROUND[..]].concat();
    let square = |places: [&str; 4]| {
        let [a, b, c, d] = places;
        let (flat, moved) = ("1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n", format!("1 {a}\n2 {b}\n3 {c}\n4 {d}\n"));
        on_nodes(&NODES.replace(flat, &moved), &elements)
    };
    square(["0 0 3", "1 0 3", "1 1 3.000000000001", "0 1 3"]).expect("a plane");
    let bent = one(square(["0 0 0", "1 0 0", "1 1 0.5", "0 1 0"]));
    assert!(bent.message.contains("node 1 has z = 0 and node 3 has z = 0.5"), "{bent:?}");
    let upright = one(square(["0 0 0", "1 0 0", "1 0 1", "0 0 1"]));
    assert!(upright.message.contains("node 1 has z = 0 and node 3 has z = 1"), "{upright:?}");
    assert!(upright.message.contains("make it in x and y") && upright.key == "mesh.path", "{upright:?}");
    let solid = one(on_nodes(&NODES.replace("5 7 8 0", "5 0 0 1"), &[&elements[..], &["4 2 3 1 1 2 3 5"]].concat()));
    assert!(solid.message.contains("element 7 of the file is a tetrahedron: write `dimension = 3`"), "{solid:?}");
}

/// A group with interior facets is reported with their number; `rest` means all other parts of the boundary.
#[test]
fn conditions_on_interior_facets_and_a_group_named_rest_are_refused() {
    let inside = one(on_file(&[&TRIANGLES[..], &["1 2 1 1 1 3"]].concat()));
    assert!(inside.message.contains("`around` is no part of the boundary: its 1 facets lie inside"), "{inside:?}");
    assert!(
        inside.key == "boundary[0].on" && inside.help.as_ref().unwrap().contains("cut the mesh open"),
        "{inside:?}"
    );
    let partly = on_file(&[&TRIANGLES[..], &AROUND[..], &["1 2 1 1 1 3"]].concat()).unwrap();
    let said = |warning: &&Diagnostic| warning.message.contains("1 facets of `around` lie inside the mesh");
    assert_eq!(partly.warnings.iter().filter(said).count(), 1, "{:?}", partly.warnings);
    let rest = one(on_nodes(&NODES.replace("\"lid\"", "\"rest\""), &[&TRIANGLES[..], &["1 2 2 1 4 1"]].concat()));
    assert!(rest.message.contains("a physical group is named `rest`, which means"), "{rest:?}");
    assert!(rest.help.as_ref().unwrap().contains("another name"), "{rest:?}");
}

/// A formula is evaluated where its facets are, y = 0.4 at the top: poles elsewhere don't matter.
#[test]
fn formulas_are_tried_on_their_own_part_of_the_boundary() {
    let kind = "on = [\"bottom\", \"top\"]\nkind = \"slip\"";
    let top =
        |keys: &str| channel("0.3", "1").replace(kind, &format!("on = \"top\"\n{keys}\n[[boundary]]\non = \"bottom\""));
    for formula in ["sqrt(y - 0.39)", "exp(-t)*sqrt(y - 0.39)", "1/(y - 0.2)"] {
        for keys in ["velocity = [F, 0]", "kind = \"pressure\"\npressure = F", "kind = \"traction\"\ntraction = [0, F]"]
        {
            let keys = keys.replace('F', &format!("\"{formula}\""));
            model(&top(&keys), Path::new("")).unwrap_or_else(|found| panic!("{keys}: {found:?}"));
        }
    }
    let below = one(model(&top("velocity = [\"sqrt(0.39 - y)\", 0]"), Path::new("")));
    assert!(below.message.contains("the formula gives NaN at x = 0, y = 0.4"), "{below:?}");
    assert_eq!(below.key, "boundary[2].velocity[0]");
}

#[test]
fn the_fluid_of_an_inlet_must_be_a_body() {
    let named = |fluid: &str, at: &str| channel("0.3", "1").replace(at, &format!("fluid = \"{fluid}\""));
    assert!(one(model(&named("milk", "# left"), Path::new(""))).message.contains("no body `milk`"));
    let wall = CHANNEL.replace("kind = \"slip\"", "kind = \"slip\"\nfluid = \"oil\"");
    let wall = wall.replace("START", "0.3").replace("SPEED", "1");
    assert!(one(model(&wall, Path::new(""))).message.contains("nothing flows in"));
}

#[test]
fn an_inlet_without_a_velocity_is_an_error() {
    let text = channel("0.3", "1").replace("kind = \"inlet\"\nvelocity = [1, 0]", "kind = \"inlet\"");
    let found = one(model(&text, Path::new("")));
    assert!(found.message.contains("no `velocity`") && found.key == "boundary[0].kind", "{found:?}");
    assert_eq!(&text[found.span.clone().unwrap()], "\"inlet\"");
    // At rest on purpose.
    assert!(model(&channel("0.3", "0"), Path::new("")).is_ok());
}

/// Fluid falls out of a side that is open along gravity under a uniform pressure; a hydrostatic pressure holds it.
#[test]
fn a_uniform_pressure_on_a_side_along_gravity_is_warned_of() {
    let falling = "[pfem2]\ngravity = [0, -9.81]\n[[body]]\nname = \"water\"";
    let text = channel("0.3", "1").replace("[[body]]\nname = \"water\"", falling);
    let warnings = |text: &str| model(text, Path::new("")).unwrap().warnings;
    let falls = |found: &[Diagnostic]| found.iter().filter(|f| f.message.contains("`right` is open over 0.4")).count();
    let found = warnings(&text);
    assert_eq!(falls(&found), 1, "{found:?}");
    let help = found.iter().find_map(|f| f.help.clone()).unwrap();
    assert!(help.contains("pressure = \"2 * 9.81 * (0.4 - y)\""), "{help}");
    let held = text.replace("kind = \"outlet\"", "kind = \"pressure\"\npressure = \"2 * 9.81 * (0.4 - y)\"");
    assert_eq!(falls(&warnings(&held)), 0);
    assert_eq!(falls(&warnings(&text.replace("[0, -9.81]", "[9.81, 0]"))), 0);
    assert_eq!(falls(&warnings(&text.replace("kind = \"outlet\"", "kind = \"pressure\"\npressure = 3"))), 1);
}

/// Keeps the warnings of a run.
#[derive(Clone, Default)]
struct Warnings(Arc<Mutex<Vec<String>>>);

impl Observer for Warnings {
    fn event(&mut self, event: &Event<'_>, _: &Progress) -> lateen::Result<()> {
        if let Event::Warning(text) = event {
            self.0.lock().unwrap().push((*text).to_owned());
        }
        Ok(())
    }
}

/// Runs a case; its warnings, and a history by name.
fn ran(text: &str) -> (Vec<String>, impl Fn(&str, &str) -> Vec<f64> + use<>) {
    let home = tempfile::tempdir().unwrap();
    let case = Case::read(Source::new("case.toml", "", text), &[]).unwrap();
    let warnings = Warnings::default();
    let options = Options { observers: vec![Box::new(warnings.clone())], ..Options::default() };
    run(&case, case.build().unwrap(), &RunDirectory::new(home.path()), options).unwrap();
    let said = warnings.0.lock().unwrap().clone();
    let column = move |table: &str, name: &str| {
        let text = std::fs::read_to_string(home.path().join(format!("history/{table}.csv"))).unwrap();
        let mut lines = text.lines();
        let header = lines.next().unwrap().split(',');
        let place = header.clone().position(|title| title.starts_with(name)).unwrap_or_else(|| panic!("{header:?}"));
        lines.map(|line| line.split(',').nth(place).unwrap().parse().unwrap()).collect()
    };
    (said, column)
}

/// A uniform velocity solves the equations wherever the interface is: the volume of water is 0.4 times the position of
/// its front, and a warning says once that no oil is left.
#[test]
fn a_uniform_flow_fills_a_channel_with_the_fluid_of_its_inlet_exactly() {
    let (said, column) = ran(&channel("0.025", "1").replace("# left", "fluid = \"water\""));
    for (t, volume) in column("balance", "time").iter().zip(column("balance", "volume: water")) {
        let exact = 0.4 * (0.025 + t).min(1.0);
        assert!((volume - exact).abs() < 1e-6, "t = {t}: {volume} instead of {exact}");
    }
    assert!(column("balance", "largest speed").iter().all(|speed| (speed - 1.0).abs() < 1e-12));
    assert_eq!(said, ["no particle of `oil` is left"]);
}

/// The water lies outside the channel until the inlet brings it; without an inlet that names it, that is an error.
#[test]
fn a_fluid_that_only_enters_through_an_inlet_may_lie_outside_the_mesh() {
    let outside = channel("-0.5", "0.97");
    let (said, column) = ran(&outside.replace("# left", "fluid = \"water\""));
    for (t, volume) in column("balance", "time").iter().zip(column("balance", "volume: water")) {
        let exact = 0.4 * (0.97 * t).min(1.0);
        assert!((volume - exact).abs() < 1e-6, "t = {t}: {volume} instead of {exact}");
    }
    assert!(column("balance", "largest speed").iter().all(|speed| (speed - 0.97).abs() < 1e-9));
    assert_eq!(said, ["no particle of `oil` is left"]);
    let finding = one(model(&outside, Path::new("")));
    assert!(finding.message.contains("no particles"), "{finding:?}");
    assert!(finding.help.is_some_and(|help| help.contains("inlet")));
}

/// The same with the pseudo level set, whose line is known within part of an element.
#[test]
fn a_pseudo_level_set_follows_a_uniform_flow_within_half_an_element() {
    let pseudo = "[pfem2]\ninterface = \"pseudo\"\n[[body]]\nname = \"water\"";
    let (_, column) = ran(&channel("0.025", "1").replace("[[body]]\nname = \"water\"", pseudo));
    for (t, volume) in column("balance", "time").iter().zip(column("balance", "volume: water")) {
        assert!((volume - 0.4 * (0.025 + t).min(1.0)).abs() < 0.5 * 0.4 * 0.1, "t = {t}: {volume}");
    }
    assert!(column("balance", "largest speed").iter().all(|speed| (speed - 1.0).abs() < 1e-12));
}

/// A uniform velocity towards the inlet: water leaves through it, and oil enters through the outlet.
#[test]
fn an_interface_that_reaches_an_inlet_is_reported_once_and_the_run_goes_on() {
    let (said, column) = ran(&channel("0.3", "-1"));
    assert_eq!(said.iter().filter(|text| text.contains("came to the inlet `left`")).count(), 1, "{said:?}");
    assert!(column("balance", "volume: water").last().unwrap().abs() < 1e-3);
    assert!(column("balance", "largest speed").iter().all(|speed| (speed - 1.0).abs() < 1e-6));
}

/// One particle per element, and steps over four elements: most run empty, and are filled from where the flow came.
#[test]
fn elements_that_lose_all_particles_are_refilled_and_counted() {
    let text = channel("0.3", "1")
        .replace("[[body]]\nname = \"water\"", "[pfem2]\nparticles-per-edge = 1\n[[body]]\nname = \"water\"");
    let text = text
        .replace("step = 0.05", "step = 0.4")
        .replace("end = 1.5", "end = 2.0")
        .replace("history = 0.05", "history = 0.4");
    let (_, column) = ran(&text);
    assert!(*column("counts", "elements: empty").last().unwrap() > 50.0);
    assert!(column("balance", "largest speed").iter().all(|speed| (speed - 1.0).abs() < 1e-6));
    for (water, oil) in column("balance", "volume: water").iter().zip(column("balance", "volume: oil")) {
        assert!((water + oil - 0.4).abs() < 1e-12);
    }
}

#[test]
fn a_linear_solver_that_fails_names_the_node_and_the_state_is_saved() {
    let home = tempfile::tempdir().unwrap();
    let solver =
        "[pfem2]\nsolver = { kind = \"iterative\", max-iterations = 3, tolerance = 1e-13 }\n[[body]]\nname = \"water\"";
    let text = channel("0.3", "1").replace("[[body]]\nname = \"water\"", solver).replace("cell = 0.1", "cell = 0.02");
    let text = text.replacen("velocity = [1, 0]", "velocity = [\"sin(9*y)\", 0]", 2);
    let text = text.replace("velocity = [1, 0]", "velocity = [\"sin(9*y) * exp(-t)\", 0]");
    let case = Case::read(Source::new("case.toml", "", &text), &[]).unwrap();
    let directory = RunDirectory::new(home.path());
    let Err(error) = run(&case, case.build().unwrap(), &directory, Options::default()) else { panic!("it converged") };
    let text = error.to_string();
    for part in [
        "did not converge",
        "relative residual",
        "residuals ",
        " after 0, ",
        "after 3 iterations",
        "node",
        "mesh",
        "raise `pfem2.solver.max-iterations` (3, by default 300)",
        "halve the step",
    ] {
        assert!(text.contains(part), "`{part}` is missing in: {text}");
    }
    assert!(std::fs::read_dir(home.path().join("checkpoint")).unwrap().count() > 0);
}

/// A pole between the times that `check` tries stops the run where it is, with the key; the state before is kept.
#[test]
fn a_formula_without_a_value_during_the_run_stops_it_and_is_named() {
    let text = channel("0.5", "1")
        .replace("kind = \"slip\"", "kind = \"slip\"\n[pfem2]\ngravity = [\"1e-5/max(0, abs(t - 0.15) - 0.01)\", 0]");
    let case = Case::read(Source::new("case.toml", "", text.replace("end = 1.5", "end = 1.45")), &[]).unwrap();
    let home = tempfile::tempdir().unwrap();
    let outcome = run(&case, case.build().unwrap(), &RunDirectory::new(home.path()), Options::default());
    let Err(Error::Step(error)) = outcome else { panic!("the run must stop") };
    assert!(error.what.contains("`pfem2.gravity[0]`") && !error.value.is_finite(), "{error}");
    assert!((error.time - 0.15).abs() < 1e-12 && error.step == 3, "{error}");
    assert!(home.path().join("checkpoint").read_dir().unwrap().count() > 0);
}
