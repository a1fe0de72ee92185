//! Films between solids that come nearer to each other than an element (theory J.2a).

use super::*;
use crate::linalg::SolverKind;
use crate::material::{Elastic, PointLaw, Rigid, StVenantKirchhoff};
use crate::pfem2::Pfem2;
use crate::pfem2::solid::mesh::SolidMesh;
use crate::pfem2::solid::mesh::shapes::slotted;
use crate::pfem2::solid::setup::SolidSetup;
use crate::pfem2::solid::structure::Structure;
use crate::simulation::Solver;

const GRAVITY: f64 = 9.81;

/// The largest speed in five steps from rest, over √(g H), of solids in a box full of water of height H = 1.
fn largest_in_water<const D: usize, const N: usize>(
    cells: usize,
    solids: Vec<SolidSetup<D>>,
    speed: impl Fn(&Pfem2<D, N>) -> f64,
) -> f64 {
    let mesh = Mesh::<D, N>::block(Vector::ZERO, Vector::splat(1.0), [cells; D]).unwrap();
    let down = std::array::from_fn(|axis| if axis + 1 == D { (-GRAVITY).into() } else { Signal::ZERO });
    let physics = physics(vec![fluid("water", 1000.0, 1e-3)], down);
    let physics = Physics { stabilisation: Stabilisation::Dynamic, ..physics };
    let sets = vec![set(&mesh, "all", Condition::Slip, |_| true)];
    let mut setup = setup(mesh, sets, physics, |_| 0, |_| Vector::ZERO);
    setup.linear = SolverOptions { kind: SolverKind::Direct, tolerance: 1e-13, ..SolverOptions::default() };
    setup.solids = Some(Structure::new(solids).unwrap());
    let mut pfem = Pfem2::new(setup);
    let dt = 0.01;
    pfem.begin(0.0, dt).unwrap();
    let of_step = |k: i32| {
        pfem.step(f64::from(k) * dt, dt).unwrap();
        speed(&pfem)
    };
    (0..5).map(of_step).fold(0.0, f64::max) / GRAVITY.sqrt()
}

/// Two blocks as heavy as the water around them, side by side with this gap [m], after some steps: the largest speed of
/// water and blocks over √(g H).
fn speed_of_blocks<const D: usize, const N: usize>(gap: [f64; 2], cells: usize) -> f64 {
    let block = |name: &str, lower: f64, upper: f64| {
        let own = SolidMesh::block(
            Vector::from_fn(|axis| if axis == 0 { lower } else { 0.33 }),
            Vector::from_fn(|axis| if axis == 0 { upper } else { 0.64 }),
            [2; D],
        );
        let law: Box<dyn PointLaw> = Box::new(Rigid { density: 1000.0 });
        SolidSetup::free(name, own.unwrap(), law)
    };
    let blocks = vec![block("left", 0.21, gap[0]), block("right", gap[1], 0.83)];
    largest_in_water::<D, N>(cells, blocks, |pfem| {
        let solids = fastest(&pfem.solids.as_ref().unwrap().structure.state.velocity);
        solids.max(fastest(&pfem.system.velocity))
    })
}

/// Blocks as heavy as water rest in it, however near they are to each other: the film between them bears the pressure of
/// the water around, as water does that is wider. (Elements without a node between them held nothing before, and the
/// blocks were pressed together with more than twice g.) Where a corner lies in an element without a node of its block,
/// it is cut off, and what it lacks moves the block.
#[test]
fn blocks_rest_beside_each_other_in_the_plane() {
    for (gap, most) in [([0.41, 0.64], 1e-6), ([0.51, 0.54], 1e-6), ([0.53, 0.54], 1e-6), ([0.515, 0.525], 2e-3)] {
        let speed = speed_of_blocks::<2, 3>(gap, 20);
        assert!(speed < most, "{gap:?}: {speed:e}");
    }
}

/// The same in space, where edges beside films are cut off: 2 % of a free fall is left, and 0.6 % far from each other.
#[test]
fn blocks_rest_beside_each_other_in_space() {
    for (gap, most) in [([0.48, 0.58], 2e-3), ([0.51, 0.57], 5e-3)] {
        let speed = speed_of_blocks::<3, 4>(gap, 10);
        assert!(speed < most, "{gap:?}: {speed:e}");
    }
}

/// A free body as heavy as water with a slot from above that is narrower than an element: the largest speed of its
/// centre of mass over √(g H).
fn speed_of_a_slotted_body<const D: usize, const N: usize>(slot: [f64; 2], cells: usize, young: f64) -> f64 {
    let corners = [0.0, 1.0].map(|side| {
        Vector::from_fn(|axis| if axis == 0 { [0.21, 0.83][side as usize] } else { [0.33, 0.64][side as usize] })
    });
    let law: Box<dyn PointLaw> = match young == 0.0 {
        true => Box::new(Rigid { density: 1000.0 }),
        false => Box::new(StVenantKirchhoff { elastic: Elastic::new(1000.0, young, 0.3) }),
    };
    let own = SolidSetup::free("body", slotted(corners, slot), law);
    largest_in_water::<D, N>(cells, vec![own], |pfem| {
        let structure = &pfem.solids.as_ref().unwrap().structure;
        structure.momentum().norm() / structure.mass()
    })
}

/// A body as heavy as water rests in it, however narrow a slot in it is.
#[test]
fn a_body_with_a_narrow_slot_rests() {
    for young in [0.0, 1e9] {
        for slot in [[0.5, 0.56], [0.51, 0.535], [0.51, 0.515]] {
            let speed = speed_of_a_slotted_body::<2, 3>(slot, 20, young);
            assert!(speed < 1e-3, "plane {young} {slot:?}: {speed:e}");
        }
        let speed = speed_of_a_slotted_body::<3, 4>([0.51, 0.57], 10, young);
        assert!(speed < 3e-3, "space {young}: {speed:e}");
    }
}
