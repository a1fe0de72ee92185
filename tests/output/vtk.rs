//! The files for ParaView, read back by VTK itself (`tests/vtk_readback.py`).
//!
//! Needs a Python with `vtk` and `numpy`: `$LATEEN_PYTHON`, `.venv/bin/python` or `python3`. Without one
//! the test says so and passes, unless `LATEEN_REQUIRE_VTK=1`.

use lateen::output::{FieldPrecision, Fields, UnitLabels};
use lateen::simulation::{Elements, Field, Monitor, PointSet, Snapshot, SurfaceSet};
use serde_json::{Value, json};
use std::borrow::Cow;
use std::path::Path;
use std::process::Command;

/// Exit code of `vtk_readback.py` where VTK is not installed.
const NOT_INSTALLED: i32 = 77;

/// A cloud of particles and a strip of a quadrilateral, a triangle and a segment.
struct Model {
    time: f64,
    particles: Vec<[f64; 3]>,
    id: Vec<u32>,
    stress: Vec<f64>,
    nodes: Vec<[f64; 3]>,
    tension: Vec<f64>,
}

const ELEMENTS: [&[u32]; 3] = [&[0, 1, 2, 3], &[1, 4, 2], &[4, 5]];

impl Model {
    /// `count` particles: none at all, or enough for several compressed blocks.
    fn new(count: usize, time: f64) -> Self {
        let wave = |p: usize, i: usize| (0.37 * (p * 3 + i) as f64 + time).sin();
        Self {
            time,
            particles: (0..count).map(|p| std::array::from_fn(|i| 1e-3 * wave(p, i))).collect(),
            id: (0..count as u32).rev().collect(),
            stress: (0..6 * count).map(|n| 1e5 * wave(n, 1)).collect(),
            nodes: (0..6).map(|n| [f64::from(n / 2), f64::from(n % 2), time]).collect(),
            tension: vec![1.0, 2.0, 3.0 + time],
        }
    }

    fn snapshot(&self) -> Snapshot<'_> {
        let speed = || self.particles.iter().map(|x| 2.0 * x[0]).collect();
        let points = PointSet {
            name: "water",
            position: Cow::Borrowed(&self.particles),
            id: Cow::Borrowed(&self.id),
            fields: vec![
                Field::computed("speed", "m/s", 1, speed),
                Field { name: "stress", unit: "Pa", components: 6, ..Field::scalar("", "", &self.stress) },
            ],
            filled: None,
        };
        let surface = SurfaceSet {
            name: "sheet & co",
            position: Cow::Borrowed(&self.nodes),
            reference: Cow::Borrowed(&self.nodes),
            elements: ELEMENTS.to_vec(),
            kind: Elements::Sheet,
            node_fields: vec![Field::computed("height", "", 1, || self.nodes.iter().map(|x| x[2]).collect())],
            element_fields: vec![Field::scalar("tension", "N/m", &self.tension)],
        };
        Snapshot { time: self.time, dimension: 3, points: vec![points], surfaces: vec![surface], ..Snapshot::default() }
    }

    fn expected_points(&self, tolerance: f64) -> Value {
        let count = self.particles.len();
        let speed: Vec<f64> = self.particles.iter().map(|x| 2.0 * x[0]).collect();
        json!({
            "time": self.time, "tolerance": tolerance, "points": self.particles,
            "connectivity": (0..count).collect::<Vec<_>>(), "offsets": (0..=count).collect::<Vec<_>>(),
            "types": vec![1; count], "cell-data": [],
            "point-data": [
                { "name": "id", "components": 1, "unit": "", "values": self.id },
                { "name": "speed", "components": 1, "unit": "m/s", "values": speed },
                { "name": "stress", "components": 6, "unit": "Pa", "values": self.stress },
            ],
        })
    }

    fn expected_surface(&self, tolerance: f64) -> Value {
        let height: Vec<f64> = self.nodes.iter().map(|x| x[2]).collect();
        json!({
            "time": self.time, "tolerance": tolerance, "points": self.nodes,
            "connectivity": ELEMENTS.concat(), "offsets": [0, 4, 7, 9], "types": [9, 5, 3],
            "point-data": [{ "name": "height", "components": 1, "unit": "", "values": height }],
            "cell-data": [{ "name": "tension", "components": 1, "unit": "N/m", "values": self.tension }],
        })
    }
}

fn python() -> String {
    let local = concat!(env!("CARGO_MANIFEST_DIR"), "/.venv/bin/python");
    let fallback = if Path::new(local).exists() { local } else { "python3" };
    std::env::var("LATEEN_PYTHON").unwrap_or_else(|_| fallback.to_owned())
}

/// Runs VTK's readers over a directory, or says that they are not there.
fn read_back(directory: &Path) {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/vtk_readback.py");
    let output = Command::new(python()).arg(script).arg(directory).output();
    match output {
        Ok(output) if output.status.success() => {}
        Ok(output) if output.status.code() != Some(NOT_INSTALLED) => {
            panic!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr))
        }
        absent => {
            assert!(std::env::var_os("LATEEN_REQUIRE_VTK").is_none(), "VTK is required here: {absent:?}");
            eprintln!("SKIPPED: no Python with vtk and numpy; files in {} not read back", directory.display());
        }
    }
}

fn write_and_read_back(precision: FieldPrecision, tolerance: f64, counts: &[usize]) {
    let directory = tempfile::tempdir().unwrap();
    let mut fields = Fields::new(directory.path(), 0.1, precision, UnitLabels::Shown);
    let models: Vec<Model> = counts.iter().enumerate().map(|(i, &n)| Model::new(n, 0.1 * i as f64)).collect();
    for model in &models {
        fields.sample(&model.snapshot(), 0.0).unwrap();
    }
    let expected = json!({
        "water": models.iter().map(|model| model.expected_points(tolerance)).collect::<Vec<_>>(),
        "sheet---co": models.iter().map(|model| model.expected_surface(tolerance)).collect::<Vec<_>>(),
    });
    std::fs::write(directory.path().join("expected.json"), expected.to_string()).unwrap();
    read_back(directory.path());
}

#[test]
fn vtk_reads_back_every_number_in_double_precision() {
    write_and_read_back(FieldPrecision::Double, 0.0, &[1, 7, 20_000]);
}

#[test]
fn vtk_reads_back_single_precision_to_seven_digits() {
    write_and_read_back(FieldPrecision::Single, 6.0e-8, &[32_768, 0, 5]);
}

/// A tetrahedron has four nodes, as a quadrilateral has; VTK's own numbers are 10 and 9 (*VTK File Formats*, fig. 2).
#[test]
fn elements_of_a_volume_with_four_nodes_are_tetrahedra() {
    let directory = tempfile::tempdir().unwrap();
    let nodes = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 1.0, 1.0]];
    let elements: [&[u32]; 2] = [&[0, 1, 2, 3], &[1, 2, 3, 4]];
    let mesh = SurfaceSet {
        name: "mesh",
        position: Cow::Borrowed(&nodes),
        reference: Cow::Borrowed(&nodes),
        elements: elements.to_vec(),
        kind: Elements::Volume,
        node_fields: vec![],
        element_fields: vec![],
    };
    let snapshot = Snapshot { dimension: 3, surfaces: vec![mesh], ..Snapshot::default() };
    Fields::new(directory.path(), 0.1, FieldPrecision::Double, UnitLabels::Shown).sample(&snapshot, 0.0).unwrap();
    let expected = json!({ "mesh": [{
        "time": 0.0, "tolerance": 0.0, "points": nodes, "connectivity": elements.concat(), "offsets": [0, 4, 8],
        "types": [10, 10], "point-data": [], "cell-data": [],
    }] });
    std::fs::write(directory.path().join("expected.json"), expected.to_string()).unwrap();
    read_back(directory.path());
}

/// Surfaces of solids are lines in the plane and quadrilaterals in space, as polygonal data (`.vtp`), with their
/// fields.
#[test]
fn surfaces_of_solids_are_lines_or_polygons() {
    let directory = tempfile::tempdir().unwrap();
    let nodes = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let traction: Vec<f64> = (0..12).map(f64::from).collect();
    let shapes: [(&str, Vec<&[u32]>, u8); 2] =
        [("beam-surface", vec![&[0, 1], &[1, 2], &[2, 3], &[3, 0]], 3), ("plate-surface", vec![&[0, 1, 2, 3]], 9)];
    let outline = |(name, elements, _): &(&'static str, Vec<&'static [u32]>, u8)| SurfaceSet {
        name,
        position: Cow::Borrowed(&nodes),
        reference: Cow::Borrowed(&nodes),
        elements: elements.clone(),
        kind: Elements::Sheet,
        node_fields: vec![Field::computed("traction", "Pa", 3, || traction.clone())],
        element_fields: vec![],
    };
    let outlines = shapes.iter().map(outline).collect();
    let snapshot = Snapshot { dimension: 3, outlines, ..Snapshot::default() };
    Fields::new(directory.path(), 0.1, FieldPrecision::Double, UnitLabels::Shown).sample(&snapshot, 0.0).unwrap();
    let text = std::fs::read(directory.path().join("beam-surface/000000.vtp")).unwrap();
    assert!(String::from_utf8_lossy(&text).contains("NumberOfLines=\"4\" NumberOfPolys=\"0\""));
    let read = lateen::output::vtk::read_array(&directory.path().join("plate-surface/000000.vtp"), "traction").unwrap();
    assert_eq!(read, traction);
    let expected = |elements: &[&[u32]], kind: u8| {
        let offsets: Vec<usize> = (0..=elements.len()).map(|n| elements[..n].iter().map(|e| e.len()).sum()).collect();
        json!([{
            "time": 0.0, "tolerance": 0.0, "points": nodes, "connectivity": elements.concat(), "offsets": offsets,
            "types": vec![kind; elements.len()], "cell-data": [],
            "point-data": [{ "name": "traction", "components": 3, "unit": "Pa", "values": traction }],
        }])
    };
    let all: serde_json::Map<String, Value> =
        shapes.iter().map(|(name, elements, kind)| ((*name).to_owned(), expected(elements, *kind))).collect();
    std::fs::write(directory.path().join("expected.json"), Value::Object(all).to_string()).unwrap();
    read_back(directory.path());
}

#[test]
fn a_resumed_run_leaves_the_same_files_as_an_uninterrupted_one() {
    let read = |directory: &Path, file: &str| std::fs::read(directory.join(file)).unwrap();
    let run = |directory: &Path, steps: std::ops::Range<usize>, resume: Option<f64>| {
        let mut fields = Fields::new(directory, 0.1, FieldPrecision::Single, UnitLabels::Shown);
        if let Some(time) = resume {
            fields.resume(time).unwrap();
        }
        steps.for_each(|i| fields.sample(&Model::new(10 + i, 0.1 * i as f64).snapshot(), 0.1 * i as f64).unwrap());
    };
    let (whole, parts) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    run(whole.path(), 0..6, None);
    run(parts.path(), 0..5, None);
    run(parts.path(), 3..6, Some(0.25));
    for file in ["water.pvd", "sheet---co.pvd", "water/000003.vtp", "water/000005.vtp", "sheet---co/000004.vtu"] {
        assert_eq!(read(whole.path(), file), read(parts.path(), file), "{file}");
    }
}
