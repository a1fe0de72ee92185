//! Runs against closed forms.

use super::history;
use lateen::output::history::HistoryTable;

fn last(table: &HistoryTable, column: &str) -> f64 {
    *table.column(column).unwrap().last().unwrap()
}

/// A ring of radius 1 and thickness 0.01 under the pressure 0.02: σ = p r/h = 2.00, ε = σ(1 − ν²)/E = 0.005, and with
/// both at the end 1.005048. Fields are written at times that fall between those of histories: short steps follow long
/// ones.
#[test]
fn a_damped_ring_reaches_its_radius_in_steps_of_varying_length() {
    const RING: &str = r#"
name = "ring"
dimension = 2
units = "none"
[time]
end = 10
[grid]
cell = 0.5
lower = [-3, -3]
upper = [3, 3]
[[membrane]]
name = "ring"
geometry = { shape = "circle", center = [0, 0], radius = 1.0, divisions = 40 }
thickness = 0.01
material = { law = "elastic", density = 1, young = 300, poisson = 0.5 }
damping = { mass = 3 }
pressure = { value = "0.02*ramp(t, 2)" }
[output]
history = 0.1
fields = 0.4938
[[probe]]
name = "radius"
of = "ring"
reduce = "mean-radius"
"#;
    let radius = last(&history(RING, "radius"), "radius");
    // Chords of 40 elements lie inside of the circle by a part of 1e-3 of what they stretch.
    assert!((radius - 1.005048).abs() < 3e-5, "{radius}");
}

/// A ball of rubber hits a prestressed sheet of aluminium with 2 m/s; outputs of two kinds are 1.7 µs apart at first. A
/// light body that a heavy one hits elastically leaves with twice its speed: no node is faster than 4 m/s, and the
/// sheet is hit, 1 m/s at least.
#[test]
fn a_stiff_sheet_under_a_ball_gains_no_velocity_from_steps_of_varying_length() {
    const SHEET: &str = r#"
name = "ball"
dimension = 2
[time]
end = "25 ms"
[grid]
cell = "20 mm"
lower = [-0.6, -0.3]
upper = [0.6, 0.4]
[mpm]
gravity = [0, "-9.81 m/s^2"]
[[body]]
name = "ball"
region = { shape = "sphere", center = [0, 0.08], radius = 0.08 }
particles-per-cell = 2
velocity = [0, "-2 m/s"]
material = { law = "neo-hookean", density = 1000, young = "1 MPa", poisson = 0.3 }
[[membrane]]
name = "sheet"
geometry = { shape = "chain", points = [[-0.5, 0], [0.5, 0]], divisions = [80] }
thickness = "1 mm"
material = { law = "elastic", density = 2700, young = "70 GPa", poisson = 0.3 }
prestress = ["10 MPa", 0]
supports = [{ on = "edges" }]
[output]
history = "1 ms"
fields = "1.0017 ms"
[[probe]]
name = "fastest"
of = "sheet"
reduce = "max"
quantity = "velocity"
component = "magnitude"
"#;
    let table = history(SHEET, "fastest");
    let fastest = table.columns[1].iter().copied().fold(0.0, f64::max);
    assert!(fastest > 1.0 && fastest < 4.0, "{fastest}");
}

/// Mass-proportional damping far above what an explicit step could follow: v = e^(−ct).
#[test]
fn strong_damping_by_mass_slows_a_membrane_monotonically() {
    const CHAIN: &str = r#"
name = "chain"
dimension = 2
units = "none"
[time]
end = 0.02
[grid]
cell = 0.25
lower = [-1, -1]
upper = [2, 1]
[[membrane]]
name = "sheet"
geometry = { shape = "chain", points = [[0, 0], [1, 0]], divisions = [20] }
thickness = 0.01
velocity = [0, 1]
material = { law = "elastic", density = 1, young = 1e3, poisson = 0 }
damping = { mass = 3e3 }
[output]
history = 0.001
[[probe]]
name = "speed"
of = "sheet"
reduce = "mean"
quantity = "velocity"
component = "y"
"#;
    let table = history(CHAIN, "speed");
    let speeds = table.columns.last().unwrap();
    assert!(speeds.windows(2).all(|pair| pair[1] >= 0.0 && pair[1] <= pair[0]), "{speeds:?}");
    assert!(speeds[1] < 0.25 && speeds[19] < 1e-9, "{speeds:?}");
}

/// A column of height 1 on an obstacle whose face lies between nodes. Its weight acts suddenly, so that its mean
/// displacement oscillates between 0 and twice the static settlement, ρgH²/3E = 3.33 mm.
#[test]
fn a_column_on_an_obstacle_between_nodes_swings_about_its_settlement() {
    const COLUMN: &str = r#"
name = "column"
dimension = 2
units = "none"
[time]
end = 1.5
[grid]
cell = 0.1
lower = [0, 0]
upper = [0.4, 2]
walls = { left = "slip", right = "slip", bottom = "slip" }
[mpm]
gravity = [0, -10]
[[obstacle]]
name = "floor"
region = { shape = "box", lower = [-1, -1], upper = [2, 0.375] }
kind = "separate"
[[body]]
name = "column"
region = { shape = "box", lower = [0, 0.375], upper = [0.4, 1.375] }
spacing = 0.05
material = { law = "neo-hookean", density = 1000, young = 1e6, poisson = 0.0 }
[[probe]]
name = "mean"
of = "column"
reduce = "mean"
quantity = "displacement"
"#;
    let table = history(COLUMN, "mean");
    let heights = table.columns.last().unwrap();
    let highest = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let lowest = heights.iter().copied().fold(f64::INFINITY, f64::min);
    assert!(highest < 5e-4 && (lowest / -6.667e-3 - 1.0).abs() < 0.05, "{lowest} to {highest}");
}

/// Bingham's fluid on a plate, driven along it by gravity, between open ends.
const MUD: &str = r#"
name = "mud"
method = "pfem2"
dimension = 2
units = "none"
time = { end = 0.2, step = 0.05 }
[mesh]
shape = "box"
lower = [0, 0]
upper = [1, 1]
cell = 0.05
[pfem2]
gravity = [4.0, 0]
[[body]]
name = "mud"
region = { shape = "box", lower = [-1, -1], upper = [3, 2] }
material = { law = "bingham", density = 1.0, viscosity = 1.0, yield-stress = 0.5, regularisation = 0.01 }
[[boundary]]
on = "bottom"
[[boundary]]
on = "top"
kind = "symmetry"
[[boundary]]
on = ["left", "right"]
kind = "pressure"
pressure = 0.0
[output]
history = 0.05
[[probe]]
name = "surface"
of = "mesh"
quantity = "velocity"
at = [0.5, 1.0]
"#;

/// The high viscosity of an unyielded Bingham fluid makes the condition at open ends dominate the matrix, so that a
/// factor of its symmetric part doesn't precondition it. The fallback of `auto` finds the same flow as multigrid alone.
#[test]
fn both_solvers_agree_on_bingham_flow_between_open_ends() {
    let alone = MUD.replace("[pfem2]", "[pfem2]\nsolver = \"iterative\"");
    let [both, alone] = [MUD, &alone].map(|text| last(&history(text, "surface"), "vx"));
    assert!(alone > 0.1 && (both / alone - 1.0).abs() < 1e-5, "{both} {alone}");
}

/// The plug above the yield surface, τ = ρ g (1 − y) = τ_y at y0 = 7/8, moves with ρ g y0²/2μ. A hundred times the
/// viscosity and the forces leave the velocity as it is, and make what the flow loses at the inlet, ½ ρ u², 0.3 % of
/// the drive.
#[test]
fn the_plug_of_a_bingham_fluid_moves_with_the_velocity_of_the_closed_form() {
    let thick = MUD.replace("[4.0, 0]", "[400.0, 0]").replace("viscosity = 1.0", "viscosity = 100.0");
    let thick = thick.replace("yield-stress = 0.5", "yield-stress = 50.0").replace("end = 0.2", "end = 1.0");
    let (found, exact) = (last(&history(&thick, "surface"), "vx"), 400.0 * 0.875 * 0.875 / 200.0);
    assert!((found / exact - 1.0).abs() < 0.02, "{found} instead of {exact}");
}

/// A plug of fluid pushed by a traction 3t on a side of 1/4: the impulse to t = 1 is 3/8, and the speed 3/8 over 1/2 of
/// mass.
#[test]
fn the_impulse_of_a_traction_is_booked_to_second_order() {
    const PLUG: &str = r#"
name = "plug"
method = "pfem2"
dimension = 2
units = "none"
time = { end = 1.0, step = 0.05 }
[mesh]
shape = "box"
lower = [0, 0]
upper = [1, 0.25]
cell = 0.125
[[body]]
name = "fluid"
region = { shape = "box", lower = [-1, -1], upper = [3, 2] }
material = { law = "newtonian", density = 2.0, viscosity = 0.01 }
[[boundary]]
on = "left"
kind = "traction"
traction = ["3.0*t", 0]
[[boundary]]
on = "right"
kind = "traction"
[[boundary]]
on = "rest"
kind = "symmetry"
[output]
history = 0.1
[[probe]]
name = "middle"
of = "mesh"
quantity = "velocity"
at = [0.5, 0.125]
"#;
    let error = |step: &str| {
        let text = PLUG.replace("0.05", step);
        last(&history(&text, "balance"), "external impulse x") - 0.375
    };
    let [long, short] = [error("0.05"), error("0.025")];
    assert!(long.abs() < 2e-3 && (long / short).log2() > 1.9, "{long} {short}");
    assert!((last(&history(PLUG, "middle"), "vx") - 0.75).abs() < 5e-3);
}

/// A disc of radius 1 (four cells) and mass π that spins with ω = 1 keeps its energy, ¼ m R² ω² = π/4. Particles
/// without velocity gradients at the start would lose a tenth in the first step.
#[test]
fn affine_particles_of_a_spinning_disc_keep_their_energy_from_the_first_step() {
    const DISC: &str = r#"
name = "disc"
dimension = 2
units = "none"
[time]
end = 0.02
step = 0.002
[grid]
cell = 0.25
lower = [-2, -2]
upper = [2, 2]
[mpm]
transfer = { kind = "apic" }
[[body]]
name = "disc"
region = { shape = "sphere", center = [0, 0], radius = 1.0 }
particles-per-cell = 4
material = { law = "neo-hookean", density = 1, young = 100, poisson = 0.3 }
velocity = ["-y", "x"]
[output]
history = 0.002
"#;
    let balance = history(DISC, "balance");
    let kinetic = balance.column("kinetic energy: disc").unwrap();
    assert!((kinetic[0] / std::f64::consts::FRAC_PI_4 - 1.0).abs() < 0.02, "{}", kinetic[0]);
    let least = kinetic.iter().copied().fold(f64::INFINITY, f64::min);
    assert!(least > 0.999 * kinetic[0], "{kinetic:?}");
}
