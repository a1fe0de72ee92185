//! Discs that turn in a fluid.

use super::solids::{solid, water};
use super::*;
use crate::linalg::SolverKind;
use crate::material::{Elastic, NeoHookean, Rigid};
use crate::pfem2::Pfem2;
use crate::pfem2::solid::setup::{PrescribedMotion, SolidSetup};
use crate::pfem2::solid::structure::Structure;
use crate::pfem2::solid::surface::tests::disc as solid_disc;
use crate::simulation::Solver;
use std::f64::consts::{PI, TAU};

/// Radius of the disc, in a vessel of radius 1 [m], and viscosity [Pa s].
const RADIUS: f64 = 0.45;
const VISCOSITY: f64 = 1e4;

/// A disc begins to turn in a vessel of a thick fluid: in the end the fluid has the velocity of Couette, a r + b/r, and
/// the disc the torque −4 π μ ω R²/(1 − R²), with iterations and with a factor. Nodes of the disc stand still along an
/// axis in some steps, and in others don't.
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

/// An elastic disc that spins free in a gas of a millionth of its density, 100 steps per turn: over ten turns it loses
/// less than 1 % of its energy, an incompressible one, whose prediction is far beyond its stiffness, less than 2 %,
/// neither gains any, and its middle stays where it is. (Takes long: ten turns of two discs are
/// two thousand steps.)
#[test]
fn a_free_disc_spins_on() {
    for (poisson, most) in [(0.4, 0.01), (0.5, 0.02)] {
        let middle = Vector([0.5, 0.5]);
        let mut mesh = solid_disc(2);
        mesh.nodes.iter_mut().for_each(|x| *x = middle + *x * 0.25);
        let turn = |x: Vector<2>| Vector([middle[1] - x[1], x[0] - middle[0]]) * TAU;
        let mut disc = solid(mesh, (1e7, 0.4), |_| [false; 2], turn);
        disc.law = Box::new(NeoHookean { elastic: Elastic::new(1000.0, 1e7, poisson) });
        let gas = physics(vec![fluid("gas", 1e-3, 1e-8)], weightless());
        let gas = Physics { stabilisation: Stabilisation::Dynamic, ..gas };
        let background = shaken(&Mesh::<2, 3>::block(Vector::ZERO, Vector([1.0, 1.0]), [8, 8]).unwrap(), 0.125);
        let mut setup = setup(background, Vec::new(), gas, |_| 0, |_| Vector::ZERO);
        setup.solids = Some(Structure::new(vec![disc]).unwrap());
        let mut pfem = Pfem2::new(setup);
        let energy = |pfem: &Pfem2<2, 3>| {
            let structure = &pfem.solids.as_ref().unwrap().structure;
            structure.kinetic_energy() + structure.strain_energy().unwrap()
        };
        let start = energy(&pfem);
        pfem.begin(0.0, 0.01).unwrap();
        for k in 0..1000 {
            pfem.step(0.01 * f64::from(k), 0.01).unwrap();
        }
        let lost = 1.0 - energy(&pfem) / start;
        assert!(lost > 0.0 && lost < most, "{poisson}: {lost:e}");
        let structure = &pfem.solids.as_ref().unwrap().structure;
        let drift = structure.momentum().norm() / structure.mass();
        assert!(drift < 1e-4 * TAU * 0.25, "{poisson}: {drift:e}");
    }
}
