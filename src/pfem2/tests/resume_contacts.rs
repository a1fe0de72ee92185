//! The same bits after a restart and for any number of threads: solids that touch themselves, each other and walls,
//! solids of triangles, starts in equilibrium.

use super::enclosed::of_triangles;
use super::resume_solids::{beam, goes_on_with_the_same_bits, in_water};
use super::solids::solid;
use super::*;
use crate::material::{Elastic, NeoHookean, Rigid, StVenantKirchhoff};
use crate::pfem2::Pfem2;
use crate::pfem2::solid::mesh::SolidMesh;
use crate::pfem2::solid::mesh::shapes::Fold;
use crate::pfem2::solid::setup::{SolidSetup, SurfaceCondition, SurfaceTraction};
use crate::pfem2::solid::structure::Structure;

/// Solids in a box of side 1 full of water, in space.
fn in_water_in_space(solids: Vec<SolidSetup<3>>) -> Pfem2<3, 4> {
    let mesh = shaken(&Mesh::<3, 4>::block(Vector::ZERO, Vector::splat(1.0), [5; 3]).unwrap(), 0.2);
    let physics = physics(vec![fluid("water", 1000.0, 1e-3)], [Signal::ZERO, Signal::ZERO, (-9.81).into()]);
    let physics = Physics { stabilisation: Stabilisation::Dynamic, ..physics };
    let mut setup = setup(mesh, Vec::new(), physics, |_| 0, |_| Vector::ZERO);
    setup.solids = Some(Structure::new(solids).unwrap());
    Pfem2::new(setup)
}

/// A folded strip whose arms are pressed together until they touch within four steps, in water and in a gas.
#[test]
fn a_strip_that_touches_itself_goes_on_with_the_same_bits() {
    let strip = || {
        let fold = Fold { thickness: 0.06, inner: 0.034, arm: 0.4, width: 0.0 };
        let mesh = fold.mesh(12, Vector([0.3, 0.3]));
        let load = |side: f64| {
            let outer = |a: &u32| side * (mesh.nodes[*a as usize][1] - 0.3) > 0.9 * fold.thickness + fold.inner;
            let on = |f: &u32| {
                let nodes = &mesh.facets[*f as usize].nodes;
                nodes.iter().all(|a| outer(a) && mesh.nodes[*a as usize][0] > 0.45)
            };
            let facets = (0..mesh.facets.len() as u32).filter(on).collect();
            SurfaceTraction { facets, traction: [Signal::ZERO, (-side * 3000.0).into()] }
        };
        let tractions = vec![load(-1.0), load(1.0)];
        let own = solid(mesh.clone(), (1.0, 0.3), |_| [false; 2], |_| Vector::ZERO);
        let law = Box::new(NeoHookean { elastic: Elastic::new(1e4, 1e6, 0.3) });
        Structure::new(vec![SolidSetup { tractions, friction: 0.3, law, ..own }]).unwrap()
    };
    for density in [1000.0, 1.0] {
        let case = || in_water(strip(), 0.0, |setup| setup.fluids = vec![fluid("fluid", density, 1e-3)]);
        let [_, pushes] = goes_on_with_the_same_bits(case, Some(0.05)).pushes;
        assert!(pushes > 1.0, "{density}: {pushes}");
    }
}

/// Two elastic blocks that meet and slide along each other in water.
#[test]
fn elastic_solids_that_touch_in_water_go_on_with_the_same_bits() {
    let blocks = || {
        let block = |[lower, upper]: [[f64; 2]; 2], velocity: [f64; 2]| {
            let mesh = SolidMesh::block(Vector(lower), Vector(upper), [2, 2]).unwrap();
            let own = solid(mesh, (1e6, 0.3), |_| [false; 2], |_| Vector(velocity));
            SolidSetup { friction: 0.3, ..own }
        };
        let left = block([[0.21, 0.2], [0.41, 0.41]], [0.5, 0.2]);
        let right = block([[0.447, 0.23], [0.64, 0.4]], [-0.5, -0.2]);
        Structure::new(vec![left, right]).unwrap()
    };
    let [_, pushes] = goes_on_with_the_same_bits(|| in_water(blocks(), 9.81, |_| ()), Some(0.005)).pushes;
    assert!(pushes > 1.0, "{pushes}");
}

/// The same in space, where the water glides, with an elastic and a rigid block.
#[test]
fn solids_that_touch_in_space_go_on_with_the_same_bits() {
    let case = || {
        let block = |[lower, upper]: [[f64; 3]; 2], speed: f64| {
            let mesh = SolidMesh::block(Vector(lower), Vector(upper), [1; 3]).unwrap();
            let law = Box::new(StVenantKirchhoff { elastic: Elastic::new(1500.0, 1e6, 0.3) });
            let velocity = vec![Vector([speed, 0.1, 0.0]); mesh.nodes.len()];
            let own = SolidSetup::free("block", mesh, law);
            SolidSetup { velocity, friction: 0.3, surface: SurfaceCondition::Slip, ..own }
        };
        let left = block([[0.15, 0.3, 0.3], [0.43, 0.6, 0.63]], 0.5);
        let mut right = block([[0.535, 0.33, 0.27], [0.8, 0.67, 0.71]], -0.5);
        right.law = Box::new(Rigid { density: 1500.0 });
        in_water_in_space(vec![left, right])
    };
    let [_, pushes] = goes_on_with_the_same_bits(case, Some(0.005)).pushes;
    assert!(pushes > 1.0, "{pushes}");
}

/// A box of triangles that turns and meets the floor.
#[test]
fn a_rigid_solid_of_triangles_goes_on_with_the_same_bits() {
    let case = || {
        let mut mesh = of_triangles();
        mesh.nodes.iter_mut().for_each(|x| x[2] -= 0.165);
        let velocity = mesh.nodes.iter().map(|x| Vector([0.2 * x[2], 0.1 - 0.3 * x[0], -0.5])).collect();
        let own = SolidSetup::free("box", mesh, Box::new(Rigid { density: 3000.0 }));
        in_water_in_space(vec![SolidSetup { velocity, friction: 0.2, surface: SurfaceCondition::Slip, ..own }])
    };
    let [pushes, _] = goes_on_with_the_same_bits(case, Some(0.005)).pushes;
    assert!(pushes > 1.0, "{pushes}");
}

/// A beam that begins at rest under its weight, which then grows, and a soft block that begins where it lies on the
/// floor.
#[test]
fn starts_in_equilibrium_go_on_with_the_same_bits() {
    let own = || {
        let mesh = SolidMesh::block(Vector([0.55, 0.035]), Vector([0.85, 0.2]), [3, 2]).unwrap();
        let law = Box::new(NeoHookean { elastic: Elastic::new(2000.0, 1e5, 0.3) });
        let block = SolidSetup { law, ..solid(mesh, (1.0, 0.0), |_| [false; 2], |_| Vector::ZERO) };
        let mut beam = beam(1.0, 0.0);
        beam.law = Box::new(StVenantKirchhoff { elastic: Elastic::new(1500.0, 1e7, 0.3) });
        Structure::new(vec![beam, SolidSetup { friction: 0.3, ..block }]).unwrap()
    };
    let case = || {
        in_water(own(), 9.81, |setup| {
            setup.start = InitialState::Equilibrium;
            setup.gravity[1] = formula("-9.81*(1 + 20*t)");
        })
    };
    let [pushes, _] = goes_on_with_the_same_bits(case, Some(0.005)).pushes;
    assert!(pushes > 1.0, "{pushes}");
}
