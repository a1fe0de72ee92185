//! Supports that move, and volumes of fluids beside solids whose steps are solved again.

use super::solids::{solid, water};
use super::*;
use crate::material::{Elastic, StVenantKirchhoff};
use crate::pfem2::Pfem2;
use crate::pfem2::interface::level_set::LevelSet;
use crate::pfem2::solid::mesh::SolidMesh;
use crate::pfem2::solid::setup::{HeldNodes, SolidSetup, SurfaceTraction};
use crate::pfem2::solid::structure::Structure;
use crate::simulation::Solver;
use std::f64::consts::TAU;

/// A bar whose end is moved by A sin Ωt in a light gas: u = A cos k(L − x)/cos kL · sin Ωt with k = Ω √(ρ/E), above its
/// first period; it begins with that motion. The force of the support is that of the bar, E h A k tan kL sin Ωt against
/// the motion.
#[test]
fn a_bar_on_a_support_that_swings_has_the_standing_wave() {
    let (length, height, young, size) = (0.6, 0.1, 1e6_f64, 1e-4);
    // Between the first and the second free motion of a bar that is clamped, kL = π/2 and 3π/2.
    let number = 2.2 / length;
    let omega = number * (young / 1000.0).sqrt();
    let at = move |x: f64| (number * (length - x)).cos() / (number * length).cos();
    let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector([1.0, 0.5]), [20, 10]).unwrap();
    let mesh = shaken(&mesh, 0.05);
    let own = SolidMesh::block(Vector([0.2, 0.21]), Vector([0.2 + length, 0.21 + height]), [10, 1]).unwrap();
    let nodes = own.nodes.clone();
    let ends = (0..nodes.len() as u32).filter(|&a| nodes[a as usize][0] < 0.2 + 1e-9).collect();
    let start = move |x: Vector<2>| Vector([size * omega * at(x[0] - 0.2), 0.0]);
    let mut bar = solid(own, (young, 0.0), |_| [false; 2], start);
    let swing = formula(&format!("{}*cos({omega}*t)", size * omega));
    bar.held = vec![HeldNodes { nodes: ends, velocity: [Some(swing), Some(Signal::ZERO)] }];
    let mut gas = water(weightless());
    gas.fluids = vec![fluid("gas", 1e-3, 1e-8)];
    let mut setup = setup(mesh, Vec::new(), gas, |_| 0, |_| Vector::ZERO);
    setup.solids = Some(Structure::new(vec![bar]).unwrap());
    let mut pfem = Pfem2::new(setup);
    let dt = TAU / omega / 80.0;
    pfem.begin(0.0, dt).unwrap();
    let mut worst = 0.0f64;
    for k in 1..=120 {
        let t = f64::from(k) * dt;
        pfem.step(t - dt, dt).unwrap();
        let moved = &pfem.solids.as_ref().unwrap().structure.state.displacement;
        let error = |(x, u): (&Vector<2>, &Vector<2>)| (u[0] - size * at(x[0] - 0.2) * (omega * t).sin()).abs();
        worst = nodes.iter().zip(moved).map(error).fold(worst, f64::max);
    }
    let most = size / (number * length).cos().abs();
    assert!(worst < 0.02 * most, "{worst:e} {most:e}");
}

/// A soft beam, clamped at a wall, that slaps from water into air so fast, under a load to and fro, that most steps are
/// solved again: the sharp volumes of both fluids are what they were, and with the solid fill the box, at the end of
/// every step that is solved once. In one that is solved again they are off by less than what its surface sweeps from
/// the first prediction on: the next step puts that right.
#[test]
fn sharp_volumes_are_kept_in_steps_that_are_solved_again() {
    let mesh = shaken(&Mesh::<2, 3>::block(Vector::ZERO, Vector([1.0, 0.8]), [20, 16]).unwrap(), 0.05);
    let own = SolidMesh::block(Vector([0.0, 0.37]), Vector([0.6, 0.44]), [6, 1]).unwrap();
    let is_top =
        |facet: &u32| own.facets[*facet as usize].nodes.iter().all(|&a| own.nodes[a as usize][1] > 0.44 - 1e-9);
    let facets = (0..own.facets.len() as u32).filter(is_top).collect();
    let load = SurfaceTraction { facets, traction: [Signal::ZERO, formula("8e3*sin(60*t)")] };
    let law = Box::new(StVenantKirchhoff { elastic: Elastic::new(500.0, 1e6, 0.3) });
    let beam = SolidSetup {
        law,
        tractions: vec![load],
        ..solid(own.clone(), (1.0, 0.0), |x| [x[0] < 1e-9; 2], |_| Vector::ZERO)
    };
    let fluids = vec![fluid("water", 1000.0, 1e-3), fluid("air", 1.0, 1e-5)];
    let physics = physics(fluids, [Signal::ZERO, (-9.81).into()]);
    let level = 0.447;
    let mut setup = setup(mesh, Vec::new(), physics, |x| u8::from(x[1] > level), |_| Vector::ZERO);
    setup.level_set = Some(LevelSet::new(&setup.mesh, 0, |x| x[1] - level, &mut setup.particles));
    setup.solids = Some(Structure::new(vec![beam]).unwrap());
    let mut pfem = Pfem2::new(setup);
    let dt = 0.02;
    pfem.begin(0.0, dt).unwrap();
    let start = pfem.system.contents.volumes.clone();
    let mut again = 0;
    for k in 0..40 {
        pfem.step(f64::from(k) * dt, dt).unwrap();
        again += usize::from(pfem.solids.as_ref().unwrap().last.solutions > 1);
        let volumes = &pfem.system.contents.volumes;
        let inside = pfem.system.immersed.as_ref().unwrap().cut.volume_inside(&pfem.system.mesh);
        let lost = volumes[0] - start[0];
        let last = &pfem.solids.as_ref().unwrap().last;
        let swept = 2.0 * 0.6 * last.prediction_error / 20.0;
        assert!((volumes.iter().sum::<f64>() + inside - 0.8).abs() < 1e-12, "{k}");
        let most = if last.solutions > 1 { swept } else { 1e-12 };
        assert!(lost.abs() < most, "{k}: {lost:e} {swept:e}");
    }
    assert!(again > 5, "{again}");
}
