//! Integrals over a fluid of PFEM-2 extend over the region that it fills on the mesh: exact for polygons and a cut
//! cube.

use lateen::case::{Case, Source};
use lateen::output::{Probe, ProbeSpec, UnitLabels};
use lateen::simulation::Solver;
use std::path::Path;

/// Water of 800 kg/m³ in a region, air elsewhere in a box of one; a flow that is linear in space.
fn fluids(dimension: usize, cell: f64, region: &str) -> Box<dyn Solver> {
    let corner = |x: i32| format!("{:?}", vec![x; dimension]);
    let velocity = if dimension == 2 { "[\"1 + y\", \"2*x - 3\"]" } else { "[\"1 + y\", \"2*x - 3\", \"x\"]" };
    let text = format!(
        r#"
name = "tilted"
method = "pfem2"
dimension = {dimension}
units = "none"
time = {{ end = 1, step = 0.1 }}
[mesh]
shape = "box"
lower = {lower}
upper = {upper}
cell = {cell}
[[body]]
name = "water"
region = {region}
velocity = {velocity}
material = {{ law = "newtonian", density = 800, viscosity = 1e-3 }}
[[body]]
name = "air"
region = {{ shape = "box", lower = {below}, upper = {above} }}
velocity = {velocity}
material = {{ law = "newtonian", density = 1, viscosity = 1e-5 }}
[[boundary]]
on = "rest"
kind = "slip"
"#,
        lower = corner(0),
        upper = corner(1),
        below = corner(-1),
        above = corner(2),
    );
    let case = Case::read(Source::new("case.toml", "", &text), &[]).unwrap_or_else(|error| panic!("{error}"));
    case.build().unwrap_or_else(|error| panic!("{error}"))
}

/// The values of a probe of the water with these keys.
fn probed(solver: &dyn Solver, keys: &str) -> Vec<f64> {
    let spec: ProbeSpec = toml::from_str(&format!("name = \"p\"\nof = \"water\"\n{keys}")).unwrap();
    let snapshot = solver.snapshot();
    Probe::new(spec, "probe[0]", &snapshot, Path::new(""), 1.0, UnitLabels::Shown).unwrap().evaluate(&snapshot)
}

fn close(found: &[f64], exact: &[f64]) {
    assert_eq!(found.len(), exact.len());
    let off = found.iter().zip(exact).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(off < 1e-9, "{found:?} instead of {exact:?}");
}

/// The region below y = 0.31 + 0.2 x.
const BELOW: &str = "{ shape = \"polygon\", corners = [[-5, -5], [5, -5], [5, 1.31], [-5, -0.69]] }";

/// Below y = 0.31 + 0.2 x stands a trapezium: area 0.41, ∫x = 0.31/2 + 0.2/3, ∫y = ½ ∫(0.31 + 0.2 x)² dx.
#[test]
fn integrals_over_a_fluid_are_exact_for_a_trapezium() {
    let solver = fluids(2, 1.0 / 9.0, BELOW);
    let pfem = solver.as_ref();
    let area = 0.41;
    let (mx, my) = (0.155 + 0.2 / 3.0, 0.5 * (0.31_f64.powi(2) + 0.31 * 0.2 + 0.04 / 3.0));
    let centre = [mx / area, my / area];
    close(&probed(pfem, "reduce = \"center-of-mass\""), &centre);
    close(&probed(pfem, "reduce = \"mean\""), &centre);
    close(&probed(pfem, "reduce = \"sum\"\nquantity = \"volume\""), &[area]);
    close(&probed(pfem, "reduce = \"sum\"\nquantity = \"mass\""), &[800.0 * area]);
    let mean = [1.0 + centre[1], 2.0 * centre[0] - 3.0];
    close(&probed(pfem, "reduce = \"mean\"\nquantity = \"velocity\""), &mean);
    close(&probed(pfem, "reduce = \"mean\"\nquantity = \"velocity\"\nweight = \"mass\""), &mean);
    close(&probed(pfem, "reduce = \"sum\"\nquantity = \"velocity\""), &mean.map(|v| v * area));
    let momentum = mean.map(|v| v * 800.0 * area);
    close(&probed(pfem, "reduce = \"sum\"\nquantity = \"velocity\"\nweight = \"mass\""), &momentum);
}

/// `within` cuts elements: the part of the trapezium between x = 0.23 and 0.57, above y = 0.15.
#[test]
fn integrals_over_a_fluid_within_a_box_are_exact() {
    let solver = fluids(2, 1.0 / 9.0, BELOW);
    let pfem = solver.as_ref();
    let within = "within = { lower = [0.23, 0.15], upper = [0.57, 2.0] }\n";
    let area = 0.34 * (0.31 - 0.15 + 0.2 * 0.4);
    close(&probed(pfem, &format!("{within}reduce = \"sum\"\nquantity = \"volume\"")), &[area]);
    let mx = 0.16 * 0.34 * 0.4 + 0.2 * (0.57_f64.powi(3) - 0.23_f64.powi(3)) / 3.0;
    let centre = probed(pfem, &format!("{within}reduce = \"center-of-mass\""));
    close(&centre[..1], &[mx / area]);
    let nothing = "within = { lower = [0.1, 0.7], upper = [0.3, 0.9] }\nreduce = \"center-of-mass\"";
    assert!(probed(pfem, nothing)[0].is_nan());
}

/// A plane through the middle halves a cube. Below x + y + z = 3/2 is a corner of 27/48, less three of 1/48 beyond the
/// cube.
#[test]
fn integrals_over_a_fluid_are_exact_for_half_a_cube() {
    let solver = fluids(3, 1.0 / 3.0, "{ shape = \"half-space\", point = [0.5, 0.5, 0.5], normal = [1, 1, 1] }");
    let pfem = solver.as_ref();
    close(&probed(pfem, "reduce = \"sum\"\nquantity = \"volume\""), &[0.5]);
    // Σ ± V x̄ of tetrahedra with legs of 3/2 at the origin, and of 1/2 at the ends of the unit vectors.
    let (large, small) = (27.0 / 48.0, 1.0 / 48.0);
    let moment = large * 3.0 / 8.0 - small * (1.0 + 1.0 / 8.0) - 2.0 * small / 8.0;
    close(&probed(pfem, "reduce = \"center-of-mass\""), &[moment / 0.5; 3]);
}
