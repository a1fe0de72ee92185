//! Solids that change their volume in a box that nothing opens.

use super::solids::{solid, water};
use super::*;
use crate::pfem2::Pfem2;
use crate::pfem2::solid::mesh::SolidMesh;
use crate::pfem2::solid::structure::Structure;
use crate::simulation::Solver;

/// Height of the surface between both fluids [m].
const SURFACE: f64 = 0.71;

/// Ends of the block along both axes, off the lines of the mesh [m].
const BLOCK: [f64; 2] = [0.33, 0.57];

/// Length of the step [s].
const DT: f64 = 1e-4;

/// A block that begins to swell with the rate 1 m/s per m in a closed box of 20 × 20 squares, after one step; of these
/// fluids the last lies above `SURFACE`.
fn swelling(physics: Physics<2>) -> Pfem2<2, 3> {
    let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector::splat(1.0), [20; 2]).unwrap();
    let blocks = SolidMesh::block(Vector::splat(BLOCK[0]), Vector::splat(BLOCK[1]), [4; 2]).unwrap();
    let center = Vector::splat(0.5 * (BLOCK[0] + BLOCK[1]));
    let soft = solid(blocks, (1e3, 0.0), |_| [false; 2], |x| x - center);
    let slip = set(&mesh, "walls", Condition::Slip, |_| true);
    let last = physics.fluids.len() as u8 - 1;
    let above = |x: Vector<2>| if x[1] > SURFACE { last } else { 0 };
    let mut setup = setup(mesh, vec![slip], physics, above, |_| Vector::ZERO);
    setup.solids = Some(Structure::new(vec![soft]).unwrap());
    let mut pfem = Pfem2::new(setup);
    pfem.begin(0.0, DT).unwrap();
    pfem.step(0.0, DT).unwrap();
    pfem
}

/// Flow out of the elements that satisfy a test, ∫∇·v dV [m²/s], and their area [m²].
fn flow_out(pfem: &Pfem2<2, 3>, of: impl Fn(usize) -> bool) -> [f64; 2] {
    let system = &pfem.system;
    let elements = (0..system.mesh.elements().len()).filter(|&e| of(e));
    elements.fold([0.0; 2], |[flow, area], e| {
        let (simplex, nodes) = (system.mesh.simplex(e), system.mesh.elements()[e]);
        let own = nodes.iter().zip(&simplex.gradient).map(|(&i, g)| system.velocity[i as usize].dot(*g));
        [flow + simplex.volume * own.sum::<f64>(), area + simplex.volume]
    })
}

/// Rate at which the block takes up area in the step [m²/s].
fn swells(pfem: &Pfem2<2, 3>) -> f64 {
    let structure = &pfem.solids.as_ref().unwrap().structure;
    let at = |fraction: f64| -> f64 {
        let places =
            structure.setups()[0].mesh.nodes.iter().zip(&structure.state.displacement).zip(&structure.state.velocity);
        structure.volume(&places.map(|((x, u), v)| *x + *u + *v * (fraction * DT)).collect::<Vec<_>>())
    };
    (at(0.5) - at(-0.5)) / DT
}

/// A gas above water gives way to a block that swells in the water, everywhere alike: no
/// more comes in around the corner in which the pressure is held than in elements elsewhere, and water far from the block
/// keeps its volume.
#[test]
fn a_gas_in_a_closed_box_makes_room_for_a_solid() {
    let mut fluids = water(weightless());
    fluids.fluids.push(fluid("above", 1.0, 1e-5));
    let pfem = swelling(fluids);
    let pin = pfem.system.boundary.pin.as_ref().unwrap().node;
    let (mesh, rate) = (&pfem.system.mesh, swells(&pfem));
    assert!(rate > 0.01, "{rate}");
    let lowest = |e: usize| mesh.elements()[e].iter().map(|&i| mesh.nodes()[i as usize][1]).fold(1.0, f64::min);
    let [light, area] = flow_out(&pfem, |e| lowest(e) > SURFACE);
    // The lowest of these elements share equations with some that hold both fluids.
    assert!((light / -rate - 1.0).abs() < 0.05, "{light} {rate}");
    let [corner, own] = flow_out(&pfem, |e| mesh.elements()[e].contains(&pin));
    assert!(corner.abs() < 2.0 * own / area * rate, "{corner} {rate}");
    let [water, _] = flow_out(&pfem, |e| lowest(e) < 0.25);
    assert!(water.abs() < 0.05 * rate, "{water} {rate}");
}

/// So does a gas that has the box to itself.
#[test]
fn a_gas_alone_in_a_closed_box_makes_room_for_a_solid() {
    let pfem = swelling(physics(vec![fluid("gas", 1.0, 1e-5)], weightless()));
    let pin = pfem.system.boundary.pin.as_ref().unwrap().node;
    let (mesh, rate) = (&pfem.system.mesh, swells(&pfem));
    let [corner, own] = flow_out(&pfem, |e| mesh.elements()[e].contains(&pin));
    assert!(rate > 0.01 && corner.abs() < 2.0 * own * rate, "{corner} {rate}");
}
