//! Elastic solids in space whose surface comes from a file, against the same shapes as regions.

use super::findings::{edited, model};
use lateen::case::Model;
use lateen::error::Severity;
use std::f64::consts::{PI, TAU};
use std::fmt::Write;
use std::path::Path;

const CASE: &str = r#"
name = "part"
method = "pfem2"
dimension = 3
time = { end = "0.1 s", step = "0.01 s" }
mesh = { shape = "box", lower = [-1, -1, -1], upper = [1, 1, 1], cell = "0.25 m" }
[[body]]
name = "part"
region = REGION
material = { law = "neo-hookean", density = "1200 kg/m^3", young = "1 MPa", poisson = 0.3 }
KEYS
[[body]]
name = "water"
region = { shape = "box", lower = [-1, -1, -1], upper = [2, 2, 2] }
material = { law = "newtonian", density = "1000 kg/m^3", viscosity = "1e-3 Pa s" }
[[boundary]]
on = "rest"
"#;

const FILE: &str = r#"{ shape = "surface", file = "part.obj" }"#;

/// A profile (r, z), from the axis to the axis, turned about the third axis in some steps, as a file.
fn revolved(profile: &[[f64; 2]], count: usize) -> String {
    let (mut text, mut rows, mut next) = (String::new(), Vec::new(), 1);
    for &[r, z] in profile {
        let steps = if r > 1e-12 { count } else { 1 };
        rows.push((next, steps));
        next += steps;
        for k in 0..steps {
            let (sin, cos) = (TAU * k as f64 / count as f64).sin_cos();
            writeln!(text, "v {} {} {z}", r * cos, r * sin).unwrap();
        }
    }
    for pair in rows.windows(2) {
        let at = |(first, steps): (usize, usize), k: usize| first + k % steps;
        for k in 0..count {
            let [a, b] = [k, k + 1].map(|k| at(pair[0], k));
            let [c, d] = [k + 1, k].map(|k| at(pair[1], k));
            for [p, q, r] in [[a, b, c], [a, c, d]].into_iter().filter(|[p, q, r]| p != q && q != r && r != p) {
                writeln!(text, "f {p} {q} {r}").unwrap();
            }
        }
    }
    text
}

fn case(region: &str, keys: &str) -> String {
    edited(&edited(CASE, "REGION", region), "KEYS", keys)
}

/// A case with another size of the fluid's elements, which solids are as thick as, at least.
fn in_cells(size: &str, text: &str) -> String {
    edited(text, "cell = \"0.25 m\"", &format!("cell = \"{size}\""))
}

/// The model of a case with the file `part.obj`.
fn model_of(file: &str, text: &str) -> Model {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("part.obj"), file).unwrap();
    model(text, folder.path()).unwrap_or_else(|found| panic!("{found:#?}"))
}

/// The longest periods that `lateen check` shows [s].
fn periods(model: &Model) -> Vec<f64> {
    let note = model.summary.notes.iter().find_map(|note| Some(note.split_once("without the fluid: part ")?.1));
    note.unwrap().split(", ").map(|period| period.trim_end_matches(" s").parse().unwrap()).collect()
}

#[track_caller]
fn expect_alike(found: &[f64], expected: &[f64], tolerance: f64) {
    assert!(found.len() == 3 && expected.len() == 3);
    for (found, expected) in found.iter().zip(expected) {
        assert!((found / expected - 1.0).abs() < tolerance, "{found} {expected}");
    }
}

/// A bar, 0.8 m long and 0.1 × 0.2 m thick, turned by 30° about a skew axis and clamped at one end.
#[test]
fn a_turned_bar_of_triangles_swings_as_a_box() {
    let axis = [1.0, 2.0, 3.0].map(|a: f64| a / 14f64.sqrt());
    let (sin, cos) = (PI / 6.0).sin_cos();
    let turned = |x: [f64; 3]| {
        let along: f64 = (0..3).map(|k| axis[k] * x[k]).sum();
        let across = |k: usize| axis[(k + 1) % 3] * x[(k + 2) % 3] - axis[(k + 2) % 3] * x[(k + 1) % 3];
        [0, 1, 2].map(|k| x[k] * cos + across(k) * sin + axis[k] * along * (1.0 - cos))
    };
    let mut file = String::new();
    for n in 0..8 {
        let [x, y, z] = turned([0.8 * f64::from(n & 1), 0.1 * f64::from(n >> 1 & 1), 0.2 * f64::from(n >> 2)]);
        writeln!(file, "v {x} {y} {z}").unwrap();
    }
    file += "f 1 5 7 3\nf 2 4 8 6\nf 1 2 6 5\nf 3 7 8 4\nf 1 3 4 2\nf 5 6 8 7\n";
    let [a, b, c] = turned([1.0, 0.0, 0.0]);
    let keys = format!(
        "mesh = {{ cell = \"0.1 m\" }}\n\
         supports = [{{ on = {{ shape = \"half-space\", point = [0, 0, 0], normal = [{a}, {b}, {c}] }} }}]"
    );
    let bar = r#"{ shape = "rotated", angle = "30 deg", axis = [1, 2, 3], of = { shape = "box", lower = [0, 0, 0], upper = [0.8, 0.1, 0.2] } }"#;
    let [found, expected] = [FILE, bar].map(|region| model_of(&file, &in_cells("0.1 m", &case(region, &keys))));
    expect_alike(&periods(&found), &periods(&expected), 1e-3);
    let [found, expected] = [found, expected].map(|model| model.summary.solids[0].mass);
    assert!((found / expected - 1.0).abs() < 1e-12, "{found} {expected}");
}

/// A free ball, and a rod with round section that is clamped at its foot: facets make both a little smaller.
#[test]
fn balls_and_rods_of_triangles_swing_as_regions() {
    let around = |k: i32| (PI * f64::from(k) / 24.0).sin_cos();
    let ball = revolved(&(0..=24).map(around).map(|(sin, cos)| [0.3 * sin, -0.3 * cos]).collect::<Vec<_>>(), 48);
    let cells = "mesh = { cell = \"0.3 m\" }";
    let sphere = r#"{ shape = "sphere", center = [0, 0, 0], radius = 0.3 }"#;
    let [found, expected] = [FILE, sphere].map(|region| periods(&model_of(&ball, &case(region, cells))));
    expect_alike(&found, &expected, 1e-2);
    let rod = revolved(&[[0.0, 0.0], [0.1, 0.0], [0.1, 0.8], [0.0, 0.8]], 48);
    let keys = "mesh = { cell = \"0.15 m\" }\nsupports = [{ on = \"bottom\" }]";
    let cylinder = r#"{ shape = "cylinder", from = [0, 0, 0], to = [0, 0, 0.8], radius = 0.1 }"#;
    let of = |region: &str| periods(&model_of(&rod, &in_cells("0.18 m", &case(region, keys))));
    let [found, expected] = [FILE, cylinder].map(of);
    expect_alike(&found, &expected, 1e-2);
}

/// Elements of two cells of the fluid are wider than the rod, so smaller ones are taken; it sinks.
#[test]
fn a_solid_of_triangles_runs_without_further_keys() {
    let rod = revolved(&[[0.0, -0.4], [0.15, -0.4], [0.15, 0.4], [0.0, 0.4]], 24);
    let text = case(FILE, "")
        .replace("[[body]]\nname = \"part\"", "pfem2 = { gravity = [0, 0, \"-10 m/s^2\"] }\n[[body]]\nname = \"part\"");
    let mut model = model_of(&rod, &text);
    let solid = &model.summary.solids[0];
    assert!((solid.mass / (1200.0 * PI * 0.15 * 0.15 * 0.8) - 1.0).abs() < 0.02, "{solid:?}");
    for step in 0..2 {
        model.solver.step(0.01 * f64::from(step), 0.01).unwrap();
    }
}

/// An oval ring whose elements are, without a length in the case, as wide as its hole: its surface is that of the file.
#[test]
fn a_coarse_ring_follows_the_surface_of_its_file() {
    let (radius, thin, short, around, section) = (0.4365, 0.1587, 0.9, 48, 24);
    let mut file = String::new();
    for n in 0..around * section {
        let [theta, phi] = [(n / section) as f64 / around as f64, (n % section) as f64 / section as f64];
        let ((sin, cos), (up, out)) = ((TAU * theta).sin_cos(), (TAU * phi).sin_cos());
        let r = radius + thin * out;
        writeln!(file, "v {} {} {}", r * cos, short * r * sin, thin * up).unwrap();
    }
    let at = |i: usize, j: usize| 1 + i % around * section + j % section;
    for (i, j) in (0..around).flat_map(|i| (0..section).map(move |j| (i, j))) {
        writeln!(file, "f {} {} {} {}", at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)).unwrap();
    }
    let mesh = "lower = [-0.75, -0.75, -0.375], upper = [0.75, 0.75, 0.375], cell = \"0.125 m\"";
    let text = edited(&case(FILE, ""), "lower = [-1, -1, -1], upper = [1, 1, 1], cell = \"0.25 m\"", mesh);
    let model = model_of(&file, &text);
    assert!(
        !model.warnings.iter().any(|found| found.message.contains("off that of the file")),
        "{:#?}",
        model.warnings
    );
    let solid = &model.summary.solids[0];
    let [sines, polygon] = [around, section].map(|n| n as f64 * (TAU / n as f64).sin());
    let volume = sines * radius * 0.5 * polygon * thin * thin * short;
    assert!(solid.elements < 100 && (solid.mass / (1200.0 * volume) - 1.0).abs() < 0.01, "{solid:?} {volume}");
    let facets = [(radius + thin, around), (thin, section)].map(|(r, n)| r * (1.0 - (PI / n as f64).cos()));
    let snapshot = model.solver.snapshot();
    let outline = snapshot.outlines.iter().find(|set| set.name.starts_with("part")).expect("a surface");
    for &[x, y, z] in &outline.reference[..] {
        let away = (x.hypot(y / short) - radius).hypot(z) - thin;
        assert!(away.abs() < facets[0] + facets[1] + 1e-9, "{away} at {:?}", [x, y, z]);
    }
}

/// A ring, 0.4 m high, with a hole off its middle: 80 mm are left between them. Elements of a length that is given stay
/// off the hole there, which is said; without one smaller elements are taken.
#[test]
fn a_surface_that_elements_stay_off_is_named() {
    let count = 48;
    let mut file = String::new();
    for n in 0..4 * count {
        let ((sin, cos), height) = ((TAU * (n % count) as f64 / count as f64).sin_cos(), 0.4 * (n / count / 2) as f64);
        let (r, middle) = if n / count % 2 == 0 { (0.48, 0.24) } else { (0.8, 0.0) };
        writeln!(file, "v {} {} {height}", middle + r * cos, r * sin).unwrap();
    }
    for k in 0..count {
        let [inner, outer, top_inner, top_outer] =
            [0, 1, 2, 3].map(|row| [k, k + 1].map(|k| 1 + row * count + k % count));
        for ([a, b], [c, d]) in [(outer, top_outer), (top_inner, inner), (inner, outer), (top_outer, top_inner)] {
            writeln!(file, "f {a} {b} {d} {c}").unwrap();
        }
    }
    let found = |keys: &str| {
        let warnings = model_of(&file, &case(FILE, keys)).warnings;
        warnings.into_iter().filter(|found| found.message.contains("off that of the file")).collect::<Vec<_>>()
    };
    let coarse = found("mesh = { cell = \"0.274 m\" }");
    assert!(coarse.len() == 1 && coarse[0].key == "body[0].mesh", "{coarse:#?}");
    assert!(coarse[0].message.contains("the surface of `part` lies"), "{coarse:#?}");
    assert!(coarse[0].help.as_deref().is_some_and(|help| help.contains("`mesh = { cell = ")), "{coarse:#?}");
    assert_eq!(found(""), []);
}

/// The finding on a part that doesn't fit elements of a given length says where, and what helps; one on a surface that
/// is open says so.
#[test]
fn a_surface_that_cannot_be_meshed_is_refused() {
    let cup = [[0.0, 0.0], [0.5, 0.0], [0.5, 0.5], [0.4, 0.5], [0.4, 0.1], [0.0, 0.1]];
    let cup = revolved(&cup, 24);
    let folder = tempfile::tempdir().unwrap();
    let refused = |file: &str, keys: &str, message: &str, help: &str| {
        std::fs::write(folder.path().join("part.obj"), file).unwrap();
        let Err(found) = model(&case(FILE, keys), Path::new(folder.path())) else { panic!("{message}") };
        let found: Vec<_> = found.iter().filter(|f| f.severity == Severity::Error).collect();
        assert!(found.len() == 1 && found[0].message.contains(message), "{found:#?}");
        assert!(found[0].help.as_deref().unwrap_or("").contains(help), "{found:#?}");
    };
    refused(&cup, "mesh = { cell = \"0.45 m\" }", "thinner than an element", "`mesh = { cell = ... }`");
    let open: String = cup.lines().filter(|line| *line != "f 2 3 27").map(|line| format!("{line}\n")).collect();
    refused(&open, "", "is not closed", "");
}
