//! Probes over snapshots whose answers are known by hand.

use lateen::error::Diagnostic;
use lateen::output::history::HistoryTable;
use lateen::output::{Probe, ProbeSpec, UnitLabels};
use lateen::simulation::{Elements, Field, Monitor, PointSet, Snapshot, SurfaceSet};
use std::borrow::Cow;
use std::path::Path;

/// Four particles at the corners of a rectangle 2 × 1 in the plane z = 5, and a sheet of one element.
struct Model {
    position: Vec<[f64; 3]>,
    id: Vec<u32>,
    mass: Vec<f64>,
    velocity: Vec<f64>,
    nodes: Vec<[f64; 3]>,
    reference: Vec<[f64; 3]>,
    stress: Vec<f64>,
}

impl Model {
    fn new() -> Self {
        let nodes = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        Self {
            position: vec![[0.0, 0.0, 5.0], [2.0, 0.0, 5.0], [2.0, 1.0, 5.0], [0.0, 1.0, 5.0]],
            id: vec![0, 1, 2, 3],
            mass: vec![1.0, 3.0, 3.0, 1.0],
            velocity: vec![0.0, 0.0, 1.0, 0.0, 0.0, 2.0, 0.0, 0.0, 3.0, 3.0, 4.0, 12.0],
            reference: nodes.clone(),
            nodes,
            stress: vec![0.0, 0.0, 0.0, 2.0, 0.0, 0.0],
        }
    }

    fn snapshot(&self, dimension: usize) -> Snapshot<'_> {
        let fields = vec![
            Field::scalar("mass", "kg", &self.mass),
            Field { components: 3, ..Field::scalar("velocity", "m/s", &self.velocity) },
        ];
        let position = Cow::Borrowed(&self.position[..]);
        let points = PointSet { name: "water", position, id: Cow::Borrowed(&self.id), fields, filled: None };
        let surface = SurfaceSet {
            name: "sheet",
            position: Cow::Borrowed(&self.nodes),
            reference: Cow::Borrowed(&self.reference),
            elements: vec![&[0, 1, 2, 3]],
            kind: Elements::Sheet,
            node_fields: vec![],
            element_fields: vec![Field { components: 6, ..Field::scalar("stress", "Pa", &self.stress) }],
        };
        Snapshot { dimension, points: vec![points], surfaces: vec![surface], ..Snapshot::default() }
    }

    fn probe(&self, dimension: usize, keys: &str) -> Result<Probe, Diagnostic> {
        let spec: ProbeSpec = toml::from_str(&format!("name = \"p\"\n{keys}")).unwrap();
        Probe::new(spec, "probe[0]", &self.snapshot(dimension), Path::new("unused"), 1.0, UnitLabels::Shown)
    }

    fn read(&self, keys: &str) -> (Vec<String>, Vec<f64>) {
        let probe = self.probe(3, keys).unwrap();
        (probe.heads()[1..].to_vec(), probe.evaluate(&self.snapshot(3)))
    }
}

#[test]
fn reductions_over_a_rectangle_are_those_by_hand() {
    let model = Model::new();
    let value = |keys: &str| model.read(&format!("of = \"water\"\n{keys}")).1;
    assert_eq!(value("reduce = \"top\""), [5.0]);
    assert_eq!(value("reduce = \"top\"\naxis = \"x\""), [2.0]);
    assert_eq!(value("reduce = \"bottom\"\naxis = \"y\""), [0.0]);
    assert_eq!(value("reduce = \"mean\""), [1.0, 0.5, 5.0]);
    assert_eq!(value("reduce = \"center-of-mass\""), [1.5, 0.5, 5.0]);
    assert_eq!(value("reduce = \"mean\"\nweight = \"mass\"\ncomponent = \"x\""), [1.5]);
    assert_eq!(value("reduce = \"sum\"\nquantity = \"mass\""), [8.0]);
    assert_eq!(value("reduce = \"max\"\nquantity = \"velocity\""), [3.0, 4.0, 12.0]);
    assert_eq!(value("reduce = \"max\"\nquantity = \"velocity\"\ncomponent = \"magnitude\""), [13.0]);
    assert_eq!(value("reduce = \"max-radius\"\naxis = \"z\""), [5.0_f64.sqrt()]);
    assert_eq!(value("reduce = \"max-radius\"\ncenter = [2, 1, 0]"), [30.0_f64.sqrt()]);
    assert_eq!(value("reduce = \"mean-radius\"\naxis = \"z\"\ncenter = [1, 0.5, 0]"), [1.25_f64.sqrt()]);
    assert_eq!(value("reduce = \"count-fragments\"\ncell = 0.75"), [2.0]);
    assert_eq!(value("reduce = \"count\"\nwithin = { lower = [1, -1, 0], upper = [3, 3, 9] }"), [2.0]);
    assert!(value("reduce = \"top\"\nwithin = { lower = [7, 0, 0], upper = [8, 9, 9] }")[0].is_nan());
}

#[test]
fn heads_name_components_and_units() {
    let model = Model::new();
    let heads = |keys: &str| model.read(keys).0;
    assert_eq!(heads("of = \"sheet\"\nat = [0, 0, 0]"), ["x [m]", "y [m]", "z [m]"]);
    assert_eq!(heads("of = \"sheet\"\nat = [0, 0, 0]\nquantity = \"displacement\"\ncomponent = \"z\""), ["uz [m]"]);
    assert_eq!(heads("of = \"water\"\nreduce = \"count\""), ["count"]);
    assert_eq!(
        heads("of = \"sheet\"\nreduce = \"max\"\nquantity = \"stress\"\ncomponent = \"von-mises\""),
        ["stress-von-mises [Pa]"]
    );
    let flat = model.probe(2, "of = \"water\"\nreduce = \"max\"\nquantity = \"velocity\"").unwrap();
    assert_eq!(flat.heads(), ["time [s]", "vx [m/s]", "vy [m/s]"]);
}

#[test]
fn a_probe_follows_its_particle_and_shows_nan_once_it_is_gone() {
    let mut model = Model::new();
    let probe = model.probe(3, "of = \"water\"\nat = [1.9, 0.9, 5]\nquantity = \"displacement\"").unwrap();
    model.position[2][0] += 0.25;
    model.position.reverse();
    model.id.reverse();
    assert_eq!(probe.evaluate(&model.snapshot(3)), [0.25, 0.0, 0.0]);
    model.position.remove(1);
    model.id.remove(1);
    model.mass.remove(1);
    assert!(probe.evaluate(&model.snapshot(3)).iter().all(|value| value.is_nan()));
}

#[test]
fn a_place_on_a_membrane_refers_to_its_reference_configuration() {
    let mut model = Model::new();
    model.nodes = vec![[9.0; 3], [9.0; 3], [7.0, 8.0, 9.0], [9.0; 3]];
    assert_eq!(model.read("of = \"sheet\"\nat = [1, 1, 0]").1, [7.0, 8.0, 9.0]);
    assert_eq!(model.read("of = \"sheet\"\nat = [0, 0, 0]\nquantity = \"stress\"\ncomponent = \"xy\"").1, [2.0]);
}

/// A field that is linear in the place, and one that is bilinear: both are met between the nodes.
#[test]
fn a_place_between_nodes_shows_the_interpolated_value() {
    let mut model = Model::new();
    let linear = |x: &[f64; 3]| [10.0 + x[0], 20.0 + 3.0 * x[1], x[0] * x[1]];
    model.nodes = model.reference.iter().map(linear).collect();
    let found = |at: &str| model.read(&format!("of = \"sheet\"\nat = {at}")).1;
    for (at, wanted) in [("[0.25, 0.5, 0]", [10.25, 21.5, 0.125]), ("[0.9, 0.1, 0]", [10.9, 20.3, 0.09])] {
        assert!(found(at).iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-12), "{at}: {:?}", found(at));
    }
    // Beside the sheet, its nearest point.
    assert!(found("[2, 0.5, 3]").iter().zip([11.0, 21.5, 0.5]).all(|(a, b)| (a - b).abs() < 1e-12));
}

#[test]
fn a_probe_reports_the_point_it_took_instead() {
    let model = Model::new();
    let said = |keys: &str| model.probe(3, keys).unwrap().adjusted().unwrap_or_default();
    assert_eq!(said("of = \"sheet\"\nat = [0.25, 0.5, 0]"), "");
    assert_eq!(said("of = \"water\"\nat = [2, 1, 5]"), "");
    let beside = said("of = \"sheet\"\nat = [0.25, 0.5, 0.1]");
    assert!(beside.contains("nearest point of `sheet`, at (0.25, 0.5, 0), 1.000e-1 m from (0.25"), "{beside}");
    let particle = said("of = \"water\"\nat = [1.9, 1, 5]");
    assert!(
        particle.contains("nearest particle of `water`, at the start at (2, 1, 5), 1.000e-1 m from (1.9"),
        "{particle}"
    );
}

#[test]
fn lists_of_another_length_are_errors_at_their_key() {
    let model = Model::new();
    let error = |dimension, keys: &str| model.probe(dimension, &format!("of = \"water\"\n{keys}")).unwrap_err();
    for (keys, key) in [
        ("reduce = \"top\"\nwithin = { lower = [0, 0], upper = [1, 1, 1] }", "probe[0].within.lower"),
        ("reduce = \"top\"\nwithin = { lower = [0, 0, 0], upper = [1, 1, 1, 1] }", "probe[0].within.upper"),
        ("reduce = \"max-radius\"\ncenter = [1]", "probe[0].center"),
        ("at = [1, 1]", "probe[0].at"),
    ] {
        let found = error(3, keys);
        assert!(found.key == key && found.message.contains("coordinates in 3D"), "{keys}: {found}");
    }
    assert_eq!(error(2, "reduce = \"top\"\nwithin = { lower = [0], upper = [1] }").key, "probe[0].within.lower");
    assert!(model.probe(2, "of = \"water\"\nreduce = \"top\"\nwithin = { lower = [0, 0], upper = [1, 1] }").is_ok());
    for window in ["[1, 1]", "[-1, 1]", "[2, 1]"] {
        assert_eq!(error(3, &format!("reduce = \"max\"\nimpulse = {window}")).key, "probe[0].impulse");
    }
}

#[test]
fn unknown_names_are_errors_at_their_key_with_the_nearest_known_name() {
    let model = Model::new();
    let error = |keys: &str| model.probe(3, keys).unwrap_err();
    let body = error("of = \"watre\"\nreduce = \"mean\"");
    assert_eq!(body.key, "probe[0].of");
    assert!(body.help.unwrap().contains("did you mean `water`"));
    let quantity = error("of = \"water\"\nreduce = \"mean\"\nquantity = \"velocty\"");
    assert_eq!(quantity.key, "probe[0].quantity");
    assert!(quantity.help.unwrap().contains("did you mean `velocity`"));
    let component = error("of = \"water\"\nreduce = \"mean\"\nquantity = \"mass\"\ncomponent = \"x\"");
    assert_eq!(component.key, "probe[0].component");
    assert_eq!(error("of = \"water\"\nreduce = \"mean\"\nweight = \"velocity\"").key, "probe[0].weight");
    assert_eq!(error("of = \"water\"").key, "probe[0].at");
    assert_eq!(error("of = \"water\"\nreduce = \"mean\"\nat = [0, 0]").key, "probe[0].at");
    assert_eq!(error("of = \"water\"\nreduce = \"count-fragments\"").key, "probe[0].cell");
}

#[test]
fn histories_are_the_same_after_a_resume() {
    let dir = tempfile::tempdir().unwrap();
    let spec: ProbeSpec = toml::from_str("name = \"mean\"\nof = \"water\"\nreduce = \"mean\"").unwrap();
    let model = Model::new();
    let run = |resume: Option<f64>, times: &[f64]| {
        let initial = model.snapshot(3);
        let mut probe = Probe::new(spec.clone(), "probe[0]", &initial, dir.path(), 1.0, UnitLabels::Shown).unwrap();
        if let Some(time) = resume {
            probe.resume(time).unwrap();
        }
        times.iter().for_each(|&time| probe.sample(&Snapshot { time, ..model.snapshot(3) }, time).unwrap());
        std::fs::read_to_string(dir.path().join("mean.csv")).unwrap()
    };
    let whole = run(None, &[0.0, 1.0, 2.0]);
    assert_eq!(run(Some(1.0), &[1.0, 2.0]), whole);
    assert_eq!(HistoryTable::read(&dir.path().join("mean.csv")).unwrap().column("y").unwrap(), [0.5; 3]);
}

/// The reference of keys names the reductions that read a weight, and no other.
#[test]
fn the_description_of_weight_names_the_reductions_that_read_it() {
    let schema = serde_json::to_value(schemars::schema_for!(ProbeSpec)).unwrap();
    let text = schema["properties"]["weight"]["description"].as_str().unwrap();
    let model = Model::new();
    let reductions =
        ["min", "max", "mean", "sum", "center-of-mass", "top", "bottom", "max-radius", "mean-radius", "count"];
    for reduce in reductions {
        let read = model.probe(3, &format!("of = \"water\"\nreduce = \"{reduce}\"\nweight = \"mass\"")).is_ok();
        assert_eq!(text.contains(&format!("`{reduce}`")), read, "{reduce}: {text}");
    }
    let of = schema["properties"]["of"]["description"].as_str().unwrap();
    assert!(["body", "membrane", "`mesh`", "`interface`"].iter().all(|part| of.contains(part)), "{of}");
}

#[test]
fn the_schema_names_units() {
    let schema = serde_json::to_value(schemars::schema_for!(ProbeSpec)).unwrap();
    assert_eq!(schema["properties"]["at"]["unit"], "m");
    assert_eq!(schema["properties"]["every"]["unit"], "s");
}
