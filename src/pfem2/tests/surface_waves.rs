//! Waves of water under air.

use super::*;
use crate::pfem2::Pfem2;
use crate::pfem2::interface::level_set::LevelSet;
use crate::simulation::Solver;

const GRAVITY: f64 = 9.81;

/// Waves on a line of the mesh, four elements long, gain no energy from the air: what moves the surface is the velocity
/// with which forces on it work (theory (G.3b)). Without a shift of the level set, which hides a part of it.
#[test]
fn waves_on_a_line_of_the_mesh_do_not_grow() {
    let (cell, depth, dt) = (0.025, 0.25, 8e-3);
    let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector([0.5, 0.4]), [20, 16]).unwrap();
    let fluids = vec![fluid("water", 1000.0, 1e-3), fluid("air", 1.0, 1e-5)];
    let physics =
        Physics { stabilisation: Stabilisation::ConsistentPspg, ..physics(fluids, [Signal::ZERO, (-GRAVITY).into()]) };
    let sets = vec![set(&mesh, "all", Condition::Slip, |_| true)];
    let wave = std::f64::consts::TAU / (4.0 * cell);
    let start = |x: Vector<2>| Vector([0.0, if x[1] < depth { 1e-4 * (wave * x[0]).cos() } else { 0.0 }]);
    let mut setup = setup(mesh, sets, physics, |x| u8::from(x[1] > depth), start);
    setup.level_set = Some(LevelSet::new(&setup.mesh, 0, |x| x[1] - depth, &mut setup.particles));
    setup.volume = VolumeCorrection::None;
    let mut pfem = Pfem2::new(setup);
    pfem.begin(0.0, dt).unwrap();
    let mut largest = |steps: std::ops::Range<u32>| {
        let speed = |k: u32| {
            pfem.step(f64::from(k) * dt, dt).unwrap();
            fastest(&pfem.system.velocity)
        };
        steps.map(speed).fold(0.0, f64::max)
    };
    let [first, _, last] = [0..100, 100..900, 900..1000].map(&mut largest);
    assert!(last < first, "{first:e} {last:e}");
}
