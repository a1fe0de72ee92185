//! Solids between water and air against closed forms (theory G.14).

use super::*;
use crate::material::{Elastic, StVenantKirchhoff};
use crate::pfem2::Pfem2;
use crate::pfem2::interface::level_set::LevelSet;
use crate::pfem2::solid::mesh::SolidMesh;
use crate::pfem2::solid::setup::{HeldNodes, SolidSetup, SurfaceCondition};
use crate::pfem2::solid::structure::Structure;
use crate::simulation::Solver;

const GRAVITY: f64 = 9.81;

/// A stiff solid of this density [kg/m³]; its nodes have the velocities `held` along each axis.
fn solid(mesh: SolidMesh<2>, density: f64, held: [Option<Signal>; 2]) -> SolidSetup<2> {
    let nodes = (0..mesh.nodes.len() as u32).collect();
    let held = vec![HeldNodes { nodes, velocity: held }];
    let law = Box::new(StVenantKirchhoff { elastic: Elastic::new(density, 1e8, 0.3) });
    SolidSetup { held, ..SolidSetup::free("solid", mesh, law) }
}

/// Water up to a height [m] under air, with a solid in both.
fn water_and_air(mesh: Mesh<2, 3>, height: f64, solid: SolidSetup<2>) -> Pfem2<2, 3> {
    let fluids = vec![fluid("water", 1000.0, 1e-3), fluid("air", 1.0, 1e-5)];
    let gravity = [Signal::ZERO, (-GRAVITY).into()];
    let physics = Physics { stabilisation: Stabilisation::Dynamic, ..physics(fluids, gravity) };
    let sets = vec![set(&mesh, "all", Condition::Slip, |_| true)];
    let mut start = setup(mesh, sets, physics, |x| u8::from(x[1] > height), |_| Vector::ZERO);
    start.level_set = Some(LevelSet::new(&start.mesh, 0, |x| x[1] - height, &mut start.particles));
    start.linear = SolverOptions { tolerance: 1e-13, ..SolverOptions::default() };
    start.solids = Some(Structure::new(vec![solid]).unwrap());
    Pfem2::new(start)
}

/// A block of this size [m] about a place, turned by an angle.
fn block(size: [f64; 2], center: [f64; 2], angle: f64) -> SolidMesh<2> {
    let half = Vector(size) * 0.5;
    let mesh = SolidMesh::block(half * -1.0, half, [3, 2]).unwrap();
    let (sin, cos) = angle.sin_cos();
    let turned = |x: &Vector<2>| Vector([cos * x[0] - sin * x[1], sin * x[0] + cos * x[1]]) + Vector(center);
    SolidMesh::new(mesh.nodes.iter().map(turned).collect(), mesh.elements).unwrap()
}

fn unit_mesh(cells: usize) -> Mesh<2, 3> {
    let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector::splat(1.0), [cells; 2]).unwrap();
    shaken(&mesh, 1.0 / cells as f64)
}

fn cut_volume(pfem: &Pfem2<2, 3>) -> f64 {
    pfem.system.immersed.as_ref().map_or(0.0, |immersed| immersed.cut.volume_inside(&pfem.system.mesh))
}

/// Water under air beside a solid that is held, its surface at any height and angle: nothing moves but by rounding, φ
/// goes on as a plane inside of the solid, the volumes stay what they are. (With mean densities in the elements that
/// hold both, the fluids fall with 0.1 g Δt.)
#[test]
fn fluids_at_rest_stay_at_rest_beside_a_solid_that_is_held() {
    let dt = 0.01;
    for (height, angle) in [(0.5, 0.0), (0.513, 0.0), (0.532, 0.3), (0.487, 1.2)] {
        let held = [Some(Signal::ZERO), Some(Signal::ZERO)];
        let mut pfem =
            water_and_air(unit_mesh(12), height, solid(block([0.37, 0.41], [0.52, 0.5], angle), 500.0, held));
        let start = pfem.system.contents.volumes.clone();
        for k in 0..15 {
            pfem.step(f64::from(k) * dt, dt).unwrap();
        }
        let speed = fastest(&pfem.system.velocity);
        assert!(speed < 1e-10 * GRAVITY * dt, "{height} {angle}: {speed:e}");
        let changed = start.iter().zip(&pfem.system.contents.volumes).map(|(start, now)| (now - start).abs());
        assert!(changed.fold(0.0, f64::max) < 1e-12);
        let off = |i: usize| (pfem.interface.level[i] - (pfem.system.mesh.nodes()[i][1] - height)).abs();
        let near = (0..pfem.interface.level.len()).filter(|&i| pfem.interface.level[i].abs() < 0.2);
        assert!(near.map(off).fold(0.0, f64::max) < 1e-11, "{height} {angle}");
        assert_eq!(pfem.notices(), Vec::<String>::new());
    }
}

/// The force on a solid at rest is the weight of the fluids that it displaces (Archimedes).
#[test]
fn a_solid_that_is_held_bears_the_weight_of_the_fluids_that_it_displaces() {
    let held = [Some(Signal::ZERO), Some(Signal::ZERO)];
    let height = 0.5137;
    let mut pfem = water_and_air(unit_mesh(12), height, solid(block([0.37, 0.41], [0.52, 0.5], 0.0), 500.0, held));
    (0..4).for_each(|k| pfem.step(0.01 * f64::from(k), 0.01).unwrap());
    let force = pfem.solids.as_ref().unwrap().last.forces.last[0];
    let below = 0.37 * (height - 0.295);
    let weight = GRAVITY * (1000.0 * below + 1.0 * (0.37 * 0.41 - below));
    assert!((force[1] / weight - 1.0).abs() < 1e-12 && force[0].abs() < 1e-9 * weight, "{force:?} {weight}");
}

/// A box half as heavy as water, half in it, lifted from there [m].
pub fn floating_box(cells: usize, height: f64, lift: f64, surface: SurfaceCondition) -> Pfem2<2, 3> {
    let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector::splat(1.0), [cells; 2]).unwrap();
    let own = solid(block([0.4, 0.2], [0.5, height + lift], 0.0), 500.5, [None, None]);
    water_and_air(mesh, height, SolidSetup { surface, ..own })
}

/// Place of the middle of the solid [m].
fn middle(pfem: &Pfem2<2, 3>) -> Vector<2> {
    let structure = &pfem.solids.as_ref().unwrap().structure;
    let places = structure.positions(&structure.state.displacement);
    places.iter().copied().sum::<Vector<2>>() / places.len() as f64
}

/// A block on lines of the mesh, or off them by as little as rounding or a step makes: corners at nodes, elements in
/// its corners with all nodes on its surface. The fluid part ends where the block does, to a ten-thousandth of an
/// element (in elements at corners a thousandth), and the force on it is that of Archimedes; thin slivers cost the
/// solver digits of the rest.
#[test]
fn the_fluid_ends_at_a_solid_on_lines_of_the_mesh() {
    let held = [Some(Signal::ZERO), Some(Signal::ZERO)];
    for (height, wider, most) in [
        (0.5, 0.0, 1e-5),
        (0.5, 1e-7, 1e-5),
        (0.5, -1e-7, 1e-5),
        (0.5, -1e-5, 6e-5),
        (0.5, -1e-4, 1e-5),
        (0.513, 0.0, 1e-5),
        (0.513, 1e-9, 1e-5),
        (0.513, 1e-5, 1e-5),
    ] {
        let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector::splat(1.0), [20; 2]).unwrap();
        let width = 0.4 + 2.0 * wider;
        let mut pfem = water_and_air(mesh, height, solid(block([width, 0.2], [0.5, height], 0.0), 500.5, held.clone()));
        (0..2).for_each(|k| pfem.step(0.01 * f64::from(k), 0.01).unwrap());
        let force = pfem.solids.as_ref().unwrap().last.forces.last[0][1] / (500.5 * width * 0.2 * GRAVITY);
        let volume = cut_volume(&pfem) / (width * 0.2);
        assert!((volume - 1.0).abs() < most && (force - 1.0).abs() < most, "{height} {wider}: {volume} {force}");
        let speed = fastest(&pfem.system.velocity);
        assert!(speed < 1e-8 * GRAVITY * 0.01, "{height} {wider}: {speed:e}");
    }
}

/// A solid that floats where Archimedes has it stays there, to a ten-thousandth of an element: sides on lines of the
/// mesh and off them. The start lets it swing: it is not compressed by the water yet.
#[test]
fn a_solid_floats_at_rest() {
    for height in [0.5, 0.513] {
        let (cells, dt) = (20, 0.01);
        let mut pfem = floating_box(cells, height, 0.0, SurfaceCondition::NoSlip);
        let start = middle(&pfem);
        let (mut drift, mut speed) = (0.0f64, 0.0f64);
        for k in 0..100 {
            pfem.step(f64::from(k) * dt, dt).unwrap();
            drift = drift.max((middle(&pfem) - start).norm() * cells as f64);
            let solids = pfem.solids.as_ref().unwrap();
            speed = (solids.structure.momentum() / solids.structure.mass()).norm();
            let volume = cut_volume(&pfem) / 0.08;
            assert!((volume - 1.0).abs() < 3e-5, "{height} {k}: {volume}");
        }
        assert!(drift < 1e-4, "{height}: {drift:e}");
        assert!(speed < 1e-5 * GRAVITY.sqrt(), "{height}: {speed:e}");
    }
}

/// A box that was lifted heaves with the period of linear theory, ω² = g B/(m/ρ + a): a is the added mass at this
/// frequency in a tank that is 2.5 boxes wide, by finite elements of the potential of a flow under a free surface on
/// four meshes, continued to none: 0.9479 s. The period is that between two falls through the mean.
#[test]
fn a_box_heaves_with_the_period_of_linear_theory() {
    let (dt, exact) = (0.008, 0.9479);
    let mut pfem = floating_box(32, 0.5, 0.012, SurfaceCondition::Slip);
    let start = middle(&pfem)[1];
    let step = |k: u32| {
        pfem.step(f64::from(k) * dt, dt).unwrap();
        middle(&pfem)[1] - start
    };
    let heave: Vec<f64> = (0..160).map(step).collect();
    let mean = heave[..119].iter().sum::<f64>() / 119.0;
    let falls = heave.windows(2).enumerate().filter(|(_, pair)| pair[0] > mean && pair[1] <= mean);
    let times: Vec<f64> =
        falls.map(|(k, pair)| (k as f64 + 1.0 + (pair[0] - mean) / (pair[0] - pair[1])) * dt).collect();
    let period = times[1] - times[0];
    assert!((period / exact - 1.0).abs() < 0.03, "{period} {times:?}");
}

/// A plate that is moved to and fro, through the surface and along it, at up to its own size in a tenth of a second:
/// the water keeps its volume, and the volumes of the three add up to that of the mesh, also where the plate is as thin
/// as an element. Of a plate of two elements the mesh shows nine tenths or more, below which a run says so.
#[test]
fn volumes_are_kept_beside_a_plate_that_moves_through_the_surface() {
    let thin = [[0.08, 0.5], [0.5, 0.06]];
    for (size, angle) in [([0.14, 0.5], 0.3), ([0.5, 0.13], 0.1), (thin[0], 0.3), (thin[1], 0.1)] {
        let velocity = [Some(formula("0.6*cos(12*t)")), Some(formula("0.9*sin(12*t)"))];
        let mut pfem = water_and_air(unit_mesh(16), 0.513, solid(block(size, [0.47, 0.51], angle), 500.0, velocity));
        let (start, dt) = (pfem.system.contents.volumes[0], 0.01);
        for k in 0..60 {
            pfem.step(f64::from(k) * dt, dt).unwrap();
            let volumes = &pfem.system.contents.volumes;
            assert!((volumes[0] / start - 1.0).abs() < 1e-12, "{k}: {}", volumes[0] / start - 1.0);
            assert!((volumes.iter().sum::<f64>() + cut_volume(&pfem) - 1.0).abs() < 1e-12);
            let shown = cut_volume(&pfem) / (size[0] * size[1]);
            assert!(thin.contains(&size) || (0.9..1.02).contains(&shown), "{k}: {shown}");
        }
    }
}
