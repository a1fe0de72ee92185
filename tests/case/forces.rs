//! One sign of forces in all histories, that of the force on the wall, obstacle or support: a weight at rest gives −m g
//! in both methods.

use super::history;
use lateen::output::history::HistoryTable;

/// Mean of a column over all intervals.
fn mean(table: &HistoryTable, column: &str) -> f64 {
    let rows = &table.column(column).unwrap()[1..];
    rows.iter().sum::<f64>() / rows.len() as f64
}

/// 0.4 m² of 1000 kg/m³ under 10 m/s².
const WEIGHT: f64 = 4000.0;

/// A block of rubber, or water, 0.4 × 1, on the wall of the grid or an obstacle.
fn material_points(body: &str, below: &str) -> String {
    format!(
        r#"
name = "column"
dimension = 2
units = "none"
time = {{ end = 1.5 }}
[grid]
cell = 0.1
lower = [0, 0]
upper = [0.4, 2]
walls = {{ left = "slip", right = "slip", bottom = "slip" }}
[mpm]
gravity = [0, -10]
{below}
[[body]]
name = "column"
{body}
spacing = 0.05
[output]
history = 0.1
"#
    )
}

const RUBBER: &str = "material = { law = \"neo-hookean\", density = 1000, young = 1e6, poisson = 0.0 }";
const LIQUID: &str = "material = { law = \"fluid\", density = 1000, eos = { kind = \"linear\", sound-speed = 30, tensile-strength = 1e6 } }";

#[test]
fn the_force_on_a_wall_of_the_grid_is_the_weight_downwards() {
    let region = "region = { shape = \"box\", lower = [0, 0], upper = [0.4, 1] }";
    for law in [RUBBER, LIQUID] {
        let table = history(&material_points(&format!("{region}\n{law}"), ""), "wall-bottom");
        let force = mean(&table, "fy");
        assert!((force / -WEIGHT - 1.0).abs() < 0.02, "{law}: {force}");
        assert_eq!(table.heads[2], "fy [on wall:bottom]");
    }
}

#[test]
fn the_force_on_an_obstacle_is_the_weight_downwards() {
    let floor = "[[obstacle]]\nname = \"step\"\nregion = { shape = \"box\", lower = [-1, -1], upper = [2, 0.4] }\n\
                 kind = \"separate\"";
    let region = "region = { shape = \"box\", lower = [0, 0.4], upper = [0.4, 1.4] }";
    let table = history(&material_points(&format!("{region}\n{RUBBER}"), floor), "obstacle-step");
    assert!((mean(&table, "fy") / -WEIGHT - 1.0).abs() < 0.02, "{}", mean(&table, "fy"));
}

#[test]
fn the_force_on_a_boundary_of_pfem2_is_the_weight_downwards() {
    const WATER: &str = r#"
name = "column"
method = "pfem2"
dimension = 2
units = "none"
time = { end = 0.3, step = 0.02 }
[mesh]
shape = "box"
lower = [0, 0]
upper = [0.4, 1]
cell = 0.1
[pfem2]
gravity = [0, -10]
[[body]]
name = "water"
region = { shape = "box", lower = [0, 0], upper = [0.4, 1] }
material = { law = "newtonian", density = 1000, viscosity = 1e-3 }
[[boundary]]
on = ["left", "top"]
kind = "slip"
[[boundary]]
on = "right"
kind = "slip"
moment-about = [0, 0]
[[boundary]]
on = "bottom"
moment-about = [0.1, 0.5]
[output]
history = 0.1
"#;
    let table = history(WATER, "bottom");
    assert!((mean(&table, "fy") / -WEIGHT - 1.0).abs() < 1e-6, "{}", mean(&table, "fy"));
    assert_eq!(table.heads[2..], ["fy [on bottom]", "mz [on bottom]"]);
    // The weight of the water, 0.1 to the right of the place.
    assert!((mean(&table, "mz") / (-0.1 * WEIGHT) - 1.0).abs() < 1e-6, "{}", mean(&table, "mz"));
    // ρ g H²/2 at a third of the height: linear elements have the moment of a linear pressure.
    let wall = history(WATER, "right");
    assert!((mean(&wall, "mz") / (-10_000.0 / 6.0) - 1.0).abs() < 1e-6, "{}", mean(&wall, "mz"));
}

/// A rigid box of 0.3 × 0.2 in water at rest: buoyancy ρ g A acts in its middle, 0.2 to the right of the place.
#[test]
fn the_moment_on_a_solid_is_that_of_its_buoyancy() {
    let case = |about: &str| {
        format!(
            r#"
name = "box"
method = "pfem2"
dimension = 2
units = "none"
time = {{ end = 0.03, step = 0.01 }}
[mesh]
shape = "box"
lower = [0, 0]
upper = [1, 1]
cell = 0.1
[pfem2]
gravity = [0, -10]
[[body]]
name = "box"
region = {{ shape = "box", lower = [0.33, 0.41], upper = [0.63, 0.61] }}
material = {{ law = "rigid", density = 3000 }}
motion = {{ velocity = [0, 0], spin = [0] }}
moment-about = {about}
[[body]]
name = "water"
region = {{ shape = "box", lower = [0, 0], upper = [1, 1] }}
material = {{ law = "newtonian", density = 1000, viscosity = 1e-3 }}
[[boundary]]
on = "rest"
kind = "slip"
[output]
history = 0.01
"#
        )
    };
    let table = history(&case("[0.28, 0.3]"), "box");
    let (force, moment) = (mean(&table, "fy"), mean(&table, "mz"));
    assert!((force / 600.0 - 1.0).abs() < 1e-3, "{force}");
    assert!((moment / (0.2 * 600.0) - 1.0).abs() < 2e-3, "{moment}");
    let own = mean(&history(&case("[0.48, 0.51]"), "box"), "mz");
    assert!(own.abs() < 2e-3 * 0.2 * 600.0, "{own}");
}

/// A pressure of 50 on a sheet of length 1 pulls its supports in its own direction with 50 × 1.
#[test]
fn the_force_on_supports_has_the_sign_of_the_pressure_on_the_membrane() {
    for pressure in [50, -50] {
        let sheet = format!(
            r#"
name = "sheet"
dimension = 2
units = "none"
time = {{ end = 2 }}
[grid]
cell = 0.25
lower = [-1, -1]
upper = [2, 1]
[[membrane]]
name = "sheet"
geometry = {{ shape = "chain", points = [[0, 0], [1, 0]], divisions = [20] }}
thickness = 0.01
material = {{ law = "elastic", density = 1, young = 1e5, poisson = 0 }}
damping = {{ mass = 50 }}
pressure = {{ value = "{pressure}*ramp(t, 0.5)" }}
supports = [{{ on = "edges" }}]
[output]
history = 0.1
[[probe]]
name = "bulge"
of = "sheet"
reduce = "mean"
"#
        );
        let force = *history(&sheet, "support-sheet-0").column("fy").unwrap().last().unwrap();
        let bulge = *history(&sheet, "bulge").column("y").unwrap().last().unwrap();
        assert!(bulge.abs() > 0.02, "{bulge}");
        assert!((force / (50.0 * bulge.signum()) - 1.0).abs() < 1e-3, "{force} {bulge}");
    }
}
