//! Pressures that follow the surface, solids under stress as they are given, and incompressible ones, against closed
//! forms.

use super::*;
use crate::material::{NeoHookean, Prestressed};
use crate::math::SymTensor;
use crate::pfem2::solid::setup::SurfacePressure;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Facets all of whose nodes lie in a place.
fn facets<const D: usize>(mesh: &SolidMesh<D>, on: impl Fn(Vector<D>) -> bool) -> Vec<u32> {
    let covered = |facet: &u32| mesh.facets[*facet as usize].nodes.iter().all(|&a| on(mesh.nodes[a as usize]));
    (0..mesh.facets.len() as u32).filter(covered).collect()
}

/// Nodes in a place that are held along an axis.
fn guided<const D: usize>(mesh: &SolidMesh<D>, axis: usize, on: impl Fn(Vector<D>) -> bool) -> HeldNodes<D> {
    let nodes = (0..mesh.nodes.len() as u32).filter(|&a| on(mesh.nodes[a as usize])).collect();
    HeldNodes { nodes, velocity: std::array::from_fn(|k| (k == axis).then_some(Signal::ZERO)) }
}

/// A quarter of a ring between the radii, of elements along r and around, in space of one layer of `depth`, with an
/// inner pressure that follows it.
fn ring<const D: usize>(radii: [f64; 2], counts: [usize; D], law: [f64; 2], pressure: f64) -> SolidSetup<D> {
    let upper = Vector::from_fn(|k| if k == 0 { radii[1] } else { 1.0 });
    let mut mesh = SolidMesh::block(Vector::from_fn(|k| if k == 0 { radii[0] } else { 0.0 }), upper, counts).unwrap();
    for x in &mut mesh.nodes {
        let (sin, cos) = (x[1] * FRAC_PI_2).sin_cos();
        (x[0], x[1]) = (x[0] * cos, x[0] * sin);
    }
    let [young, poisson] = law;
    let mut setup = solid(mesh, [1.0, young, poisson], |_| false);
    setup.law = Box::new(NeoHookean { elastic: Elastic::new(1.0, young, poisson) });
    setup.held = (0..2).map(|axis| guided(&setup.mesh, axis, |x| x[axis] < 1e-9)).collect();
    if D == 3 {
        setup.held.push(guided(&setup.mesh, 2, |_| true));
    }
    let inner = |x: Vector<D>| x[0].hypot(x[1]) < radii[0] + 1e-9;
    setup.pressures = vec![SurfacePressure { facets: facets(&setup.mesh, inner), pressure: pressure.into() }];
    setup
}

/// Pressure that blows an incompressible neo-Hookean ring in plane strain up from the radii A, B to a inside, over G:
/// ln(B/A) − ln(b/a) + ½ c (1/a² − 1/b²), c = a² − A², b² = B² + c, from dσ_r/dr = G (λ² − 1/λ²)/r, λ = r/R (Rivlin
/// 1949).
fn rivlin([inner, outer]: [f64; 2], a: f64) -> f64 {
    let c = a * a - inner * inner;
    let b = (outer * outer + c).sqrt();
    (outer / inner).ln() - (b / a).ln() + 0.5 * c * (1.0 / (a * a) - 1.0 / (b * b))
}

/// A ring blown up by 60 %: a dead traction of the same size would have 1/1.6 of the force.
#[test]
fn a_ring_is_blown_up_by_a_pressure_that_follows_it() {
    let (radii, young) = ([1.0, 2.0], 3.0);
    let pressure = rivlin(radii, 1.6);
    let mut structure = Structure::new(vec![ring::<2>(radii, [4, 4], [young, 0.5], pressure)]).unwrap();
    structure.equilibrium(0.0, |_| Vector::ZERO).unwrap();
    let inner = 1.0 + structure.state.displacement[0][0];
    assert!((inner / 1.6 - 1.0).abs() < 5e-4, "{inner}");
    let places = structure.positions(&structure.state.displacement);
    let change = structure.volume(&places) / structure.volume(&structure.nodes) - 1.0;
    assert!(change.abs() < 1e-4, "{change}");
}

/// The same in space, in one layer between walls.
#[test]
fn a_ring_in_space_is_blown_up_alike() {
    let radii = [1.0, 2.0];
    let pressure = rivlin(radii, 1.3);
    let mut structure = Structure::new(vec![ring::<3>(radii, [3, 3, 1], [3.0, 0.5], pressure)]).unwrap();
    structure.equilibrium(0.0, |_| Vector::ZERO).unwrap();
    let inner = 1.0 + structure.state.displacement[0][0];
    assert!((inner / 1.3 - 1.0).abs() < 5e-4, "{inner}");
}

/// Small widening with ν → ½ (Lamé, as in `a_thick_ring_of_nearly_incompressible_material_widens`): each value is its
/// own closed form, and 0.5 continues the sequence.
#[test]
fn the_widening_of_rings_tends_to_that_of_an_incompressible_one() {
    let exact = |nu: f64| (1.0 + nu) * 1e-5 * 9.0 * ((1.0 - 2.0 * nu) * 3.0 + 27.0) / 72.0;
    let mut last = f64::INFINITY;
    for poisson in [0.49, 0.499, 0.4999, 0.5] {
        let setup = ring::<2>([3.0, 9.0], [4, 3], [1000.0, poisson], 0.01);
        let mut structure = Structure::new(vec![setup]).unwrap();
        structure.equilibrium(0.0, |_| Vector::ZERO).unwrap();
        let widening = structure.state.displacement[0][0];
        assert!((widening / exact(poisson) - 1.0).abs() < 1e-3, "{poisson}: {}", widening / exact(poisson));
        let step = (widening / exact(0.5) - 1.0).abs();
        assert!(step < last, "{poisson}: {step} {last}");
        last = step + 2e-4;
    }
}

/// An inextensible beam of length 1 and bending stiffness 1, clamped at the origin along x, under a pressure q across
/// it that stays normal:
/// κ'' = q − ½ κ³ from the free end, where κ = κ' = 0 (Lévy 1884); the place of its end. From T' + κ N + q = 0, N' = κ
/// T, κ' = −T.
fn elastica(q: f64) -> [f64; 2] {
    let steps = 4000;
    let h = 1.0 / f64::from(steps);
    // κ, κ', angle and place from the end, whose tangent is along x.
    let slope = |y: [f64; 5]| [y[1], q - 0.5 * y[0].powi(3), y[0], y[2].cos(), y[2].sin()];
    let mut y = [0.0; 5];
    for _ in 0..steps {
        let ahead = |k: [f64; 5], part: f64| std::array::from_fn(|i| y[i] + part * h * k[i]);
        let a = slope(y);
        let b = slope(ahead(a, 0.5));
        let c = slope(ahead(b, 0.5));
        let d = slope(ahead(c, 1.0));
        y = std::array::from_fn(|i| y[i] + h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]));
    }
    // Seen from the clamp: the whole turned by its angle there.
    let (sin, cos) = y[2].sin_cos();
    [y[3] * cos + y[4] * sin, y[4] * cos - y[3] * sin]
}

/// A beam 20 times as long as thick, half of the pressure on its top and half of the suction on its bottom: its end is
/// that of the elastica, and 0.047 of the length away from where the same load with a fixed direction brings it.
#[test]
fn a_beam_under_a_following_pressure_is_an_elastica() {
    let (thickness, young, q) = (0.05, 1e6, 4.0);
    let load = q * young * thickness * thickness * thickness / 12.0;
    let mesh = || SolidMesh::block(Vector([0.0, -0.5 * thickness]), Vector([1.0, 0.5 * thickness]), [16, 1]).unwrap();
    let side = |mesh: &SolidMesh<2>, up: f64| facets(mesh, |x| up * x[1] > 0.49 * thickness);
    let end = |follows: bool| {
        let mut setup = solid(mesh(), [1.0, young, 0.0], |x| x[0] == 0.0);
        let halves = [1.0, -1.0].map(|up| (side(&setup.mesh, up), up * 0.5 * load));
        for (facets, pressure) in halves {
            if follows {
                setup.pressures.push(SurfacePressure { facets, pressure: pressure.into() });
            } else {
                setup.tractions.push(SurfaceTraction { facets, traction: [0.0.into(), (-0.5 * load).into()] });
            }
        }
        let mut structure = Structure::new(vec![setup]).unwrap();
        structure.equilibrium(0.0, |_| Vector::ZERO).unwrap();
        let k = tip([16, 1]);
        structure.positions(&structure.state.displacement)[k]
    };
    let [x, y] = elastica(q);
    let (following, dead) = (end(true), end(false));
    assert!((following - Vector([x, -y.abs()])).norm() < 4e-3, "{following:?} {x} {y}");
    assert!((following - dead).norm() > 0.04, "{following:?} {dead:?}");
}

/// Steps in time come to rest where the equilibrium is, which the load stiffness alone doesn't change: the loads
/// themselves do.
#[test]
fn steps_in_time_have_the_pressure_of_the_equilibrium() {
    let setup = || ring::<2>([1.0, 2.0], [2, 2], [3.0, 0.4], 0.2);
    let mut still = Structure::new(vec![setup()]).unwrap();
    still.equilibrium(0.0, |_| Vector::ZERO).unwrap();
    let mut heavy = setup();
    heavy.damping.mass = 2.0;
    let mut run = SolidsAlone::new(heavy, 0.2, 1.0);
    (0..120).for_each(|_| drop(run.solve_alone(Vector::ZERO)));
    let (found, exact) = (run.structure.state.displacement[0][0], still.state.displacement[0][0]);
    assert!(exact > 0.1 && (found / exact - 1.0).abs() < 1e-6, "{found} {exact}");
}

/// A strip of St. Venant–Kirchhoff material under tension, with ν = 0.
fn tensioned(mesh: SolidMesh<2>, density: f64, young: f64, stress: f64) -> SolidSetup<2> {
    let mut setup = solid(mesh, [density, young, 0.0], |_| false);
    let law = StVenantKirchhoff { elastic: Elastic::new(density, young, 0.0) };
    setup.law = Box::new(Prestressed::new(Box::new(law), SymTensor([stress, 0.0, 0.0, 0.0, 0.0, 0.0])).unwrap());
    setup
}

/// A beam on hinges under tension, ω² = (k π/L)² σ/ρ + (k π/L)⁴ E I/(ρ A): between a string and a beam.
#[test]
fn a_beam_under_tension_has_its_periods() {
    let (length, thickness, density, young, stress) = (1.0, 0.02, 1000.0, 1e7, 1e4);
    for stress in [stress, 0.0] {
        let mesh =
            SolidMesh::block(Vector([0.0, -0.5 * thickness]), Vector([length, 0.5 * thickness]), [30, 1]).unwrap();
        let mut setup = tensioned(mesh, density, young, stress);
        let hinge = |x: Vector<2>| x[1].abs() < 1e-9 && (x[0] < 1e-9 || x[0] > length - 1e-9);
        setup.held = vec![guided(&setup.mesh, 0, hinge), guided(&setup.mesh, 1, hinge)];
        let modes = Structure::new(vec![setup]).unwrap().natural_modes(3).found;
        for (k, mode) in modes.iter().take(2).enumerate() {
            let wave = (k + 1) as f64 * PI / length;
            let bending = young * thickness * thickness / 12.0;
            let omega = (wave.powi(2) * (stress + wave.powi(2) * bending) / density).sqrt();
            assert!((mode.period * omega / TAU - 1.0).abs() < 3e-3, "{stress} {k}: {}", mode.period * omega / TAU);
        }
    }
}

/// A block under tension between held ends stays as it is, in steps and in equilibrium, and pulls at its ends with σ A.
#[test]
fn a_prestressed_block_between_held_ends_stays_at_rest() {
    let (height, stress) = (0.5, 2e5);
    let mesh = SolidMesh::block(Vector::ZERO, Vector([2.0, height]), [4, 2]).unwrap();
    let mut setup = tensioned(mesh, 1000.0, 1e6, stress);
    setup.held = vec![guided(&setup.mesh, 0, |x| x[0] == 0.0 || x[0] == 2.0)];
    setup.held.push(guided(&setup.mesh, 1, |x| x[0] == 0.0 && x[1] == 0.0));
    let left = setup.held[0].nodes.iter().copied().filter(|&a| setup.mesh.nodes[a as usize][0] == 0.0);
    let left: Vec<u32> = left.collect();
    let mut run = SolidsAlone::new(setup, 0.01, 0.6);
    for _ in 0..5 {
        let reactions = run.solve_alone(Vector::ZERO);
        let force: f64 = left.iter().map(|&a| reactions[a as usize * 2]).sum();
        assert!((force / (-stress * height) - 1.0).abs() < 1e-12, "{force}");
        let speed = run.structure.state.velocity.iter().map(|v| v.norm()).fold(0.0, f64::max);
        assert!(speed < 1e-12, "{speed}");
    }
    run.structure.equilibrium(0.0, |_| Vector::ZERO).unwrap();
    assert!(run.structure.state.displacement.iter().all(|u| u.norm() < 1e-14));
    // λ (λ² − 1) = 2 σ/E and ∫W dV = ½ E e²/λ per volume as it is given, e = ½ (λ² − 1).
    let stretch = (0..20).fold(1.0f64, |x, _| x - (x.powi(3) - x - 2.0 * stress / 1e6) / (3.0 * x * x - 1.0));
    let strain = 0.5 * (stretch * stretch - 1.0);
    let energy = run.structure.strain_energy().unwrap() / (0.5e6 * strain * strain / stretch * 2.0 * height);
    assert!((energy - 1.0).abs() < 1e-9, "{energy}");
}
