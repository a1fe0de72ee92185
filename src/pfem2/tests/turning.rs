//! A rigid disc that is turned in a fluid.

use super::solids::{solid, water};
use super::*;
use crate::linalg::SolverKind;
use crate::material::Rigid;
use crate::pfem2::Pfem2;
use crate::pfem2::solid::setup::{PrescribedMotion, SolidSetup};
use crate::pfem2::solid::structure::Structure;
use crate::pfem2::solid::surface::tests::disc as solid_disc;
use crate::simulation::Solver;
use std::f64::consts::PI;

/// Radius of the disc, in a vessel of radius 1 [m], and viscosity [Pa s].
const RADIUS: f64 = 0.45;
const VISCOSITY: f64 = 1e4;

/// A disc begins to turn in a vessel of a thick fluid: in the end the fluid has the velocity of Couette, a r + b/r, and the disc the torque
/// −4 π μ ω R²/(1 − R²), with iterations and with a factor. Nodes of the disc stand still along an axis in some steps, and in others don't.
#[test]
fn a_disc_that_is_turned_has_the_torque_of_couette() {
    let omega = 2.0;
    for kind in [SolverKind::Iterative, SolverKind::Direct] {
        let mut mesh = solid_disc(3);
        mesh.nodes.iter_mut().for_each(|x| *x *= RADIUS);
        let turn = formula("2*min(20*t, 1)");
        let motion = PrescribedMotion {
            velocity: [Some(Signal::ZERO), Some(Signal::ZERO), None],
            spin: [None, None, Some(turn)],
        };
        let body = solid(mesh, (1.0, 0.0), |_| [false; 2], |_| Vector::ZERO);
        let body = SolidSetup { motion, law: Box::new(Rigid { density: 1000.0 }), ..body };
        let mut physics = water(weightless());
        physics.fluids = vec![fluid("honey", 1000.0, VISCOSITY)];
        let mut setup = setup(disc(14, 72), Vec::new(), physics, |_| 0, |_| Vector::ZERO);
        setup.solids = Some(Structure::new(vec![body]).unwrap());
        setup.linear.kind = kind;
        let mut pfem = Pfem2::new(setup);
        for k in 0..20 {
            pfem.step(0.01 * f64::from(k), 0.01).unwrap();
        }
        let solids = pfem.solids.as_ref().unwrap();
        let places = solids.structure.positions(&solids.last.predicted);
        let both = places.iter().zip(&solids.last.nodal);
        let torque: f64 = both.map(|(x, force)| x[0] * force[1] - x[1] * force[0]).sum();
        let couette = -4.0 * PI * VISCOSITY * omega * RADIUS.powi(2) / (1.0 - RADIUS.powi(2));
        assert!((torque / couette - 1.0).abs() < 0.02, "{kind:?}: {torque} {couette}");
        let b = omega * RADIUS.powi(2) / (1.0 - RADIUS.powi(2));
        let exact = |x: Vector<2>| Vector([-x[1], x[0]]) * (b / x.norm_squared() - b);
        let outside = |(x, _): &(&Vector<2>, &Vector<2>)| x.norm() > RADIUS + 1e-3;
        let all = pfem.system.mesh.nodes().iter().zip(&pfem.system.velocity).filter(outside);
        let error = all.map(|(x, v)| (*v - exact(*x)).norm()).fold(0.0, f64::max);
        assert!(error < 0.01 * omega * RADIUS, "{kind:?}: {error}");
    }
}
