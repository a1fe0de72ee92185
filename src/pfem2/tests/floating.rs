//! Solids between water and air against closed forms.

use super::*;
use crate::material::{Elastic, StVenantKirchhoff};
use crate::pfem2::Pfem2;
use crate::pfem2::interface::level_set::LevelSet;
use crate::pfem2::solid::mesh::SolidMesh;
use crate::pfem2::solid::setup::{Damping, HeldNodes, Plane, SolidSetup, SurfaceCondition};
use crate::pfem2::solid::structure::Structure;
use crate::simulation::Solver;

const GRAVITY: f64 = 9.81;

/// A stiff solid of this density [kg/m³]; its nodes have the velocities `held` along each axis.
fn solid(mesh: SolidMesh<2>, density: f64, held: [Option<Signal>; 2]) -> SolidSetup<2> {
    let nodes = (0..mesh.nodes.len() as u32).collect();
    SolidSetup {
        name: "solid".into(),
        law: Box::new(StVenantKirchhoff { elastic: Elastic::new(density, 1e8, 0.3) }),
        plane: Plane::Strain,
        velocity: vec![Vector::ZERO; mesh.nodes.len()],
        held: vec![HeldNodes { nodes, velocity: held }],
        tractions: Vec::new(),
        damping: Damping::default(),
        friction: 0.0,
        surface: SurfaceCondition::NoSlip,
        mesh,
    }
}

/// Water up to a height [m] under air, with a solid in both.
fn water_and_air(mesh: Mesh<2, 3>, height: f64, solid: SolidSetup<2>) -> Pfem2<2, 3> {
    let fluids = vec![fluid("water", 1000.0, 1e-3), fluid("air", 1.0, 1e-5)];
    let gravity = [Signal::ZERO, (-GRAVITY).into()];
    let physics = Physics { stabilisation: Stabilisation::ConsistentPspg, ..physics(fluids, gravity) };
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

#[test]
fn fluids_at_rest_stay_at_rest_beside_a_solid_that_is_held() {
    for (height, angle) in [(0.5, 0.0), (0.513, 0.0), (0.532, 0.3), (0.487, 1.2)] {
        let held = [Some(Signal::ZERO), Some(Signal::ZERO)];
        let mut pfem =
            water_and_air(unit_mesh(12), height, solid(block([0.37, 0.41], [0.52, 0.5], angle), 500.0, held));
        let start = pfem.system.volumes.clone();
        let dt = 0.01;
        for k in 0..25 {
            pfem.step(f64::from(k) * dt, dt).unwrap();
            let speed = fastest(&pfem.system.velocity);
            let lost = (pfem.system.volumes[0] / start[0] - 1.0).abs();
            eprintln!("{height} {angle} {k}: {speed:e} {lost:e} shift {:e}", pfem.interface.shift);
        }
        eprintln!("{:?}", pfem.notices());
        eprintln!("force {:?}", pfem.solids.as_ref().unwrap().last.forces);
    }
}

#[test]
fn a_solid_floats_at_rest() {
    for (cells, angle, y) in [(20usize, 0.0, 0.5), (20, 0.0, 0.513)] {
        let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector::splat(1.0), [cells; 2]).unwrap();
        // half submerged
        let density = 0.5 * 1001.0;
        let mut pfem = water_and_air(mesh, y, solid(block([0.4, 0.3], [0.5, y], angle), density, [None, None]));
        let dt = 0.01;
        let centre = |pfem: &Pfem2<2, 3>| {
            let structure = &pfem.solids.as_ref().unwrap().structure;
            let places = structure.positions(&structure.state.displacement);
            places.iter().copied().sum::<Vector<2>>() / places.len() as f64
        };
        let start = centre(&pfem);
        for k in 0..100 {
            pfem.step(f64::from(k) * dt, dt).unwrap();
            let speed = fastest(&pfem.system.velocity);
            if k % 10 == 9 || k < 5 {
                let drift = (centre(&pfem) - start) * cells as f64;
                let solids = pfem.solids.as_ref().unwrap();
                let cut = pfem.system.immersed.as_ref().unwrap().cut.volume_inside(&pfem.system.mesh);
                eprintln!(
                    "{y} {k}: speed {speed:e} drift {:e} {:e} cut {} it {} volumes {:?} E {:e} force {:?}",
                    drift[0],
                    drift[1],
                    cut / 0.12,
                    pfem.system.outcome.iterations,
                    pfem.system.volumes,
                    pfem.balance.totals.kinetic,
                    solids.last.forces[0] / (0.12 * density * GRAVITY)
                );
            }
        }
        eprintln!("{:?}", pfem.notices());
    }
}
