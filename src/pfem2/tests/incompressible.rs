//! Incompressible solids in fluids.

use super::solids::{solid, water};
use super::*;
use crate::pfem2::Pfem2;
use crate::pfem2::solid::mesh::SolidMesh;
use crate::pfem2::solid::structure::Structure;
use crate::simulation::Solver;

/// Water under a pressure all around compresses an incompressible block by what its bulk modulus of 10⁴ G has it
/// (J.18), E_11 = −p/(2 (λ + μ)) in the plane, and leaves its shape; the mean stress in it is the pressure, but for the
/// part ⅓ · 3/2 of a strain across the plane that is held.
#[test]
fn an_incompressible_block_bears_an_even_pressure() {
    let (young, pressure) = (1e4, 1e3);
    let mesh = shaken(&Mesh::<2, 3>::block(Vector::ZERO, Vector([1.0, 1.0]), [10, 10]).unwrap(), 0.1);
    let blocks = SolidMesh::block(Vector([0.33, 0.41]), Vector([0.71, 0.64]), [4, 3]).unwrap();
    let center = Vector([0.52, 0.525]);
    let held =
        |x: Vector<2>| [(x[0] - center[0]).abs() < 1e-9, (x[0] - 0.33).abs() < 1e-9 && (x[1] - 0.41).abs() < 1e-9];
    let soft = solid(blocks.clone(), (young, 0.5), held, |_| Vector::ZERO);
    let side = set(&mesh, "side", Condition::Traction([(-pressure).into(), Signal::ZERO]), |x| x[0] > 1.0 - 1e-9);
    let mut setup = setup(mesh, vec![side], water(weightless()), |_| 0, |_| Vector::ZERO);
    setup.solids = Some(Structure::new(vec![soft]).unwrap());
    setup.start = InitialState::Equilibrium;
    let mut pfem = Pfem2::new(setup);
    pfem.begin(0.0, 1e-3).unwrap();
    let shear = young / 3.0;
    let modulus = 1e4 * shear + shear / 3.0;
    let strain = -pressure / (2.0 * modulus);
    let structure = &pfem.solids.as_ref().unwrap().structure;
    let origin = Vector([center[0], 0.41]);
    let error = |(x, u): (&Vector<2>, &Vector<2>)| (*u - (*x - origin) * strain).norm();
    let most = blocks.nodes.iter().zip(&structure.state.displacement).map(error).fold(0.0, f64::max);
    let stresses = structure.nodal_stresses(0);
    let off = stresses.iter().map(|at| (at.stress.0[0] + pressure).abs().max((at.stress.0[1] + pressure).abs()));
    let off = off.fold(0.0, f64::max) / pressure;
    assert!(most < 0.02 * strain.abs() * 0.38, "{most:e} {strain:e}");
    assert!(off < 0.01, "{off}");
}

/// Half a period of a beam that is clamped in water and begins with the motion of its first mode [s].
fn half_period(poisson: f64) -> f64 {
    let (length, thick, young) = (0.5, 0.06, 1e7);
    let mesh = shaken(&Mesh::<2, 3>::block(Vector::ZERO, Vector([0.8, 0.6]), [24, 18]).unwrap(), 1.0 / 30.0);
    let beam = SolidMesh::block(Vector([0.0, 0.29]), Vector([length, 0.29 + thick]), [8, 1]).unwrap();
    let start = |x: Vector<2>| Vector([0.0, 1e-3 * (x[0] / length).powi(2)]);
    let tip = beam.nodes.iter().position(|x| (*x - Vector([length, 0.29])).norm() < 1e-9).unwrap();
    let beam = solid(beam, (young, poisson), |x| [x[0] < 1e-9; 2], start);
    let open = set(&mesh, "open", Condition::Outlet, |x| x[0] > 0.8 - 1e-9);
    let mut setup = setup(mesh, vec![open], water(weightless()), |_| 0, |_| Vector::ZERO);
    setup.solids = Some(Structure::new(vec![beam]).unwrap());
    let mut pfem = Pfem2::new(setup);
    let dt = 0.01;
    pfem.begin(0.0, dt).unwrap();
    let mut last = 0.0;
    for k in 0..100 {
        pfem.step(f64::from(k) * dt, dt).unwrap();
        let now = pfem.solids.as_ref().unwrap().structure.state.displacement[tip][1];
        if now <= 0.0 {
            return (f64::from(k) + last / (last - now)) * dt;
        }
        last = now;
    }
    panic!("it never came back");
}

/// A beam in water swings with ν = ½ as with 0.4999, and faster than with 0.3 by the root of (1 − 0.09)/(1 − 0.25), as
/// E/(1 − ν²) bends it, and the water is most of what moves.
#[test]
fn an_incompressible_beam_swings_in_water_as_a_nearly_incompressible_one() {
    let [own, near, other] = [0.5, 0.4999, 0.3].map(half_period);
    assert!((own / near - 1.0).abs() < 1e-3, "{own} {near}");
    assert!((other / own / ((1.0 - 0.09_f64) / 0.75).sqrt() - 1.0).abs() < 0.02, "{own} {other}");
}
