//! Forces of a fluid on the nodes of solids in space.

use super::*;
use crate::material::{Elastic, NeoHookean};
use crate::pfem2::Pfem2;
use crate::pfem2::solid::mesh::SolidMesh;
use crate::pfem2::solid::setup::{HeldNodes, SolidSetup};
use crate::pfem2::solid::structure::Structure;
use crate::simulation::Solver;

/// Elements of the mesh have edges of 6 cm.
const EDGE: f64 = 0.06;

/// A bar of 1 MPa, a tenth heavier than the water around it, clamped at a wall; it lies `up` [m] above a plane of the
/// mesh, two elements thick, and its own elements are smaller than those of the mesh.
fn bar(up: f64) -> Pfem2<3, 4> {
    let box_size = Vector([8.0 * EDGE, 6.0 * EDGE, 6.0 * EDGE]);
    let mesh = Mesh::<3, 4>::block(Vector::ZERO, box_size, [8, 6, 6]).unwrap();
    let lower = Vector([0.0, 0.1, 2.0 * EDGE + up]);
    let solid = SolidMesh::block(lower, lower + Vector([6.0 * EDGE, 0.16, 2.0 * EDGE]), [9, 4, 3]).unwrap();
    let nodes = (0..solid.nodes.len() as u32).filter(|&a| solid.nodes[a as usize][0] == 0.0).collect();
    let held = vec![HeldNodes { nodes, velocity: [0; 3].map(|_| Some(Signal::ZERO)) }];
    let law = Box::new(NeoHookean { elastic: Elastic::new(1100.0, 1e6, 0.3) });
    let down = [Signal::ZERO, Signal::ZERO, (-9.81).into()];
    let water = Physics { stabilisation: Stabilisation::Dynamic, ..physics(vec![fluid("water", 1000.0, 1e-3)], down) };
    let sets = vec![set(&mesh, "walls", Condition::Slip, |_| true)];
    let mut setup = setup(mesh, sets, water, |_| 0, |_| Vector::ZERO);
    setup.solids = Some(Structure::new(vec![SolidSetup { held, ..SolidSetup::free("bar", solid, law) }]).unwrap());
    Pfem2::new(setup)
}

/// The fluid does on the nodes of a solid what these do on it: the forces of viscosity and inertia have a symmetric
/// matrix, wherever the surface cuts the mesh.
#[test]
fn viscosity_and_inertia_act_on_solids_as_these_on_the_fluid() {
    for up in [0.0, 0.021] {
        let mut pfem = bar(up);
        pfem.step(0.0, 2e-3).unwrap();
        let immersed = pfem.system.immersed.as_ref().unwrap();
        let largest = |values: &[f64]| values.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
        for element in &immersed.elements {
            let all: Vec<f64> = element.to_fluid.iter().flatten().flatten().flatten().copied().collect();
            for (to_fluid, to_solid) in element.to_fluid.iter().zip(&element.to_solid) {
                for (i, r, s) in (0..36).map(|n| (n / 9, n / 3 % 3, n % 3)) {
                    assert!((to_fluid[i][r][s] - to_solid[i][s][r]).abs() <= 1e-12 * largest(&all));
                }
            }
        }
    }
}

/// A falling bar gives off no more energy than gravity gives it, also where its sides lie on planes of the mesh.
#[test]
fn a_bar_on_planes_of_the_mesh_gains_no_energy() {
    let (mut pfem, dt) = (bar(0.0), 2e-3);
    pfem.begin(0.0, dt).unwrap();
    for k in 0..10 {
        pfem.step(f64::from(k) * dt, dt).unwrap();
    }
    let ledger = pfem.snapshot().ledger;
    let term = |name: &str| ledger.terms.iter().find(|term| term.name == name).unwrap().value;
    let work = term("work of gravity") + term("work of gravity on solids");
    let lost = term("numerical dissipation");
    assert!(work > 0.0 && lost > -0.1 * work, "{lost} J lost to errors, of {work} J");
}
