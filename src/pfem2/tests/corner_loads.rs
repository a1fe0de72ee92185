//! Forces of a viscous fluid on the nodes of solids in space.

use super::*;
use crate::material::{Elastic, StVenantKirchhoff};
use crate::pfem2::Pfem2;
use crate::pfem2::solid::mesh::SolidMesh;
use crate::pfem2::solid::setup::{HeldNodes, SolidSetup};
use crate::pfem2::solid::structure::Structure;
use crate::simulation::Solver;

/// The largest share that a corner node of a cube has in the drag on it. The cube, of eight elements, three elements of the mesh across,
/// creeps through a closed box, and lies `shift` [m] off the middle along every axis.
fn largest_share_of_a_corner(shift: [f64; 3]) -> f64 {
    let mesh = Mesh::<3, 4>::block(Vector::ZERO, Vector::splat(1.0), [8; 3]).unwrap();
    let lower = Vector([0.3125; 3]) + Vector(shift);
    let cube = SolidMesh::block(lower, lower + Vector::splat(0.375), [2; 3]).unwrap();
    let nodes: Vec<u32> = (0..cube.nodes.len() as u32).collect();
    let axis = |k: usize| Some(Signal::from(if k == 0 { 1e-6 } else { 0.0 }));
    let held = vec![HeldNodes { nodes: nodes.clone(), velocity: std::array::from_fn(axis) }];
    let is_corner = |a: &usize| {
        let own = cube.nodes[*a] - lower;
        own.0.iter().all(|x| (x - 0.1875).abs() > 0.18)
    };
    let corners: Vec<usize> = (0..cube.nodes.len()).filter(is_corner).collect();
    let law = Box::new(StVenantKirchhoff { elastic: Elastic::new(1e-3, 1e6, 0.3) });
    let oil = Physics { stabilisation: Stabilisation::Dynamic, ..physics(vec![fluid("oil", 1e-3, 1.0)], weightless()) };
    let sets = vec![set(&mesh, "walls", Condition::wall(), |_| true)];
    let mut setup = setup(mesh, sets, oil, |_| 0, |_| Vector::ZERO);
    setup.solids = Some(Structure::new(vec![SolidSetup { held, ..SolidSetup::free("cube", cube, law) }]).unwrap());
    let mut pfem = Pfem2::new(setup);
    pfem.step(0.0, 1.0).unwrap();
    let forces = &pfem.solids.as_ref().unwrap().last.nodal;
    let drag: Vector<3> = forces.iter().copied().sum();
    assert_eq!(corners.len(), 8);
    corners.into_iter().map(|a| forces[a].norm() / drag.norm()).fold(0.0, f64::max)
}

/// An even traction on the sides of the cube gives each of its corners 0.0035 of the drag.
#[test]
fn a_viscous_fluid_pulls_at_corners_no_more_than_at_what_is_around_them() {
    let shifts = [[0.0; 3], [0.02, 0.035, 0.05], [0.05, 0.02, 0.01], [-0.03, 0.045, 0.015], [0.06, 0.055, -0.045]];
    let shares = shifts.map(largest_share_of_a_corner);
    let most = shares.into_iter().fold(0.0, f64::max);
    assert!(most < 5.0 * 3.0 / 144.0 / 6.0, "{shares:?}");
}
