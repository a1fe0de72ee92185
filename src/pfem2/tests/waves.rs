//! Standing waves between two fluids in a box.

use super::*;
use crate::pfem2::Pfem2;
use crate::pfem2::interface::level_set::LevelSet;
use crate::simulation::Solver;
use std::f64::consts::PI;

const GRAVITY: f64 = 9.81;

/// A box of width and height 1, half full, under a rigid lid, with the surface at height · cos πnx. Rows of cells
/// become thinner towards the surface, y ↦ ½ sinh(by)/sinh(b/2): along it one fluid glides on the other, but the mesh
/// has one velocity for both.
fn half_full([columns, rows]: [usize; 2], thinning: f64, (height, n): (f64, f64), densities: [f64; 2]) -> Pfem2<2, 3> {
    let even = Mesh::<2, 3>::block(Vector([0.0, -0.5]), Vector([1.0, 0.5]), [columns, rows]).unwrap();
    let place = |x: &Vector<2>| Vector([x[0], 0.5 * (thinning * x[1]).sinh() / (0.5 * thinning).sinh()]);
    let mesh = Mesh::<2, 3>::new(even.nodes().iter().map(place).collect(), even.elements().to_vec()).unwrap();
    let sets = vec![BoundarySetup {
        name: "all".into(),
        facets: mesh.boundary().to_vec(),
        condition: Condition::Slip,
        brings: None,
    }];
    let fluids = vec![fluid("below", densities[0], 0.0), fluid("above", densities[1], 0.0)];
    let surface = |x: Vector<2>| x[1] - height * (n * PI * x[0]).cos();
    let below = |x: Vector<2>| u8::from(surface(x) >= 0.0);
    let mut setup = setup(mesh, sets, physics(fluids, [0.0.into(), (-GRAVITY).into()]), below, |_| Vector::ZERO);
    setup.level_set = Some(LevelSet::new(&setup.mesh, 0, surface, &mut setup.particles));
    Pfem2::new(setup)
}

/// The period of the horizontal momentum, from its first two zeros after the start.
fn period(cells: [usize; 2], thinning: f64, dt: f64, densities: [f64; 2]) -> f64 {
    let mut pfem = half_full(cells, thinning, (0.02, 1.0), densities);
    let volume = pfem.system.contents.volumes[0];
    let (mut before, mut zeros) = (0.0, Vec::new());
    for k in 0.. {
        let t = k as f64 * dt;
        pfem.step(t, dt).unwrap();
        let momentum = pfem.balance.totals.momentum[0];
        if before * momentum < 0.0 {
            zeros.push(t + dt * before / (before - momentum));
        }
        before = momentum;
        if zeros.len() == 2 || k > 1000 {
            break;
        }
    }
    assert!((pfem.system.contents.volumes[0] / volume - 1.0).abs() < 1e-9);
    2.0 * (zeros[1] - zeros[0])
}

/// Linear theory: ω² = (ρ₁ − ρ₂) g k/(ρ₁ coth kh₁ + ρ₂ coth kh₂), k = π.
#[test]
fn two_layers_slosh_with_the_period_of_linear_theory() {
    let period = period([16, 32], 6.0, 0.025, [1000.0, 500.0]);
    assert!((period / 2.046965 - 1.0).abs() < 0.01, "{period}");
}

#[test]
fn water_under_air_sloshes_with_the_period_of_linear_theory() {
    let period = period([40, 40], 0.1, 0.012, [1000.0, 1.0]);
    assert!((period / 1.182998 - 1.0).abs() < 0.01, "{period}");
}

/// The kinetic energy after each of 90 steps of Δt = `part` times the bound, over the potential energy that `n` half
/// waves begin with, ¼ (ρ₁ − ρ₂) g a².
fn energies_of_waves(n: f64, part: f64) -> Vec<f64> {
    let (height, densities) = (0.02 / n, [1000.0, 1.0]);
    let mut pfem = half_full([20, 20], 0.1, (height, n), densities);
    let dt = part * pfem.stable_dt();
    let whole = 0.25 * (densities[0] - densities[1]) * GRAVITY * height * height;
    let mut after = |k: i32| {
        pfem.step(f64::from(k) * dt, dt).unwrap();
        pfem.balance.totals.kinetic / whole
    };
    (0..90).map(&mut after).collect()
}

fn greatest(energies: &[f64]) -> f64 {
    energies.iter().copied().fold(0.0, f64::max)
}

/// Waves swap potential and kinetic energy, and lose some of it to the scheme: with the longest steps as well.
#[test]
fn waves_do_not_grow_below_the_bound() {
    for (n, part) in [(1.0, 0.95), (1.0, 0.5), (2.0, 0.95), (4.0, 0.9), (8.0, 0.95)] {
        let energy = greatest(&energies_of_waves(n, part));
        assert!(energy < 1.05, "{n}, {part}: {energy}");
    }
}

/// A wave of twenty elements, two periods of which have passed. With cut elements stabilised against the body force
/// alone, 0.56 of its energy was left.
#[test]
fn waves_keep_their_energy_in_short_steps() {
    let energy = greatest(&energies_of_waves(2.0, 1.0 / 3.0)[60..]);
    assert!((energy - 1.0).abs() < 0.2, "{energy}");
}

/// A wave of forty elements whose mean level lies amid a row of elements, over four periods: the interface moves as
/// the fluid does. With depths divided by one mean slope for both sides it ran 2 % faster, five
/// steps late, and the energy grew to 1.18.
#[test]
fn waves_amid_a_row_of_elements_do_not_grow() {
    let dt = 0.02;
    let mut pfem = half_full([20, 21], 0.01, (0.002, 1.0), [1000.0, 1.0]);
    let whole = 0.25 * 999.0 * GRAVITY * 0.002 * 0.002;
    let mut after = |k: i32| {
        pfem.step(f64::from(k) * dt, dt).unwrap();
        pfem.balance.totals.kinetic / whole
    };
    let energies: Vec<f64> = (0..240).map(&mut after).collect();
    let (first, last) = (greatest(&energies[..80]), greatest(&energies[160..]));
    assert!(last < 1.05 && last > 0.85, "{first} {last}");
}

/// Beyond the bound short waves gain energy from errors, which gives a notice long before the run has to stop.
#[test]
fn growth_beyond_the_stable_step_gives_a_notice() {
    let mut pfem = half_full([20, 20], 0.1, (0.02, 2.0), [1000.0, 1.0]);
    let dt = 2.0 * pfem.stable_dt();
    let mut said = Vec::new();
    for k in 0..100 {
        if pfem.step(f64::from(k) * dt, dt).is_err() || !said.is_empty() {
            break;
        }
        said.extend(pfem.notices().into_iter().filter(|notice| notice.contains("numerical dissipation")));
    }
    assert_eq!(said.len(), 1);
}

/// ωΔt = 3/2 for the wave of two elements, ω² = g π/h (1000 − 1)/(1000 + 1).
#[test]
fn the_step_is_bounded_by_the_wave_of_two_elements() {
    let pfem = half_full([20, 20], 0.1, (0.002, 1.0), [1000.0, 1.0]);
    let shortest = pfem.system.shortest();
    let exact = 1.5 * (shortest / (PI * GRAVITY) * 1001.0 / 999.0).sqrt();
    assert!((pfem.stable_dt() / exact - 1.0).abs() < 0.01, "{} {exact}", pfem.stable_dt());
}
