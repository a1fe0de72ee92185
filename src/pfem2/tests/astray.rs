//! Particles of one fluid inside the other.

use super::*;
use crate::pfem2::Pfem2;
use crate::pfem2::level_set::LevelSet;
use crate::simulation::Solver;

/// Water below 0.5 and air above it, at rest, with a drop of air in the water and a film of water just above the line that the
/// level set doesn't show.
fn strewn() -> Pfem2<2, 3> {
    let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector::splat(1.0), [16; 2]).unwrap();
    let sets = vec![set(&mesh, "walls", Condition::Slip, |x| x.0.iter().any(|c| *c == 0.0 || *c == 1.0))];
    let phi = |x: Vector<2>| x[1] - 0.5;
    let drop = |x: Vector<2>| (x - Vector([0.53, 0.22])).norm() < 0.025;
    let film = |x: Vector<2>| (0.51..0.54).contains(&x[1]);
    let fluid_at = |x: Vector<2>| u8::from(if drop(x) || film(x) { phi(x) < 0.0 } else { phi(x) >= 0.0 });
    let fluids = vec![fluid("water", 1000.0, 1e-3), fluid("air", 1.0, 1e-5)];
    let mut setup = setup(mesh, sets, physics(fluids, [0.0.into(), (-9.81).into()]), fluid_at, |_| Vector::ZERO);
    setup.level_set = Some(LevelSet::new(&setup.mesh, 0, phi, &mut setup.particles));
    Pfem2::new(setup)
}

fn astray(pfem: &Pfem2<2, 3>) -> [f64; 2] {
    let amounts = pfem.snapshot().amounts;
    ["astray: water", "astray: air"].map(|name| amounts.iter().find(|(own, ..)| own == name).unwrap().2)
}

#[test]
fn air_deep_in_water_joins_it_and_a_film_at_the_surface_stays() {
    let mut pfem = strewn();
    let particle = 1.0 / pfem.particles.len() as f64;
    let [film, drop] = astray(&pfem);
    assert!((drop - 0.025f64.powi(2) * std::f64::consts::PI).abs() < 6.0 * particle, "{drop}");
    assert!((film - 0.03).abs() < 20.0 * particle, "{film}");
    for k in 0..3 {
        pfem.step(f64::from(k) * 1e-3, 1e-3).unwrap();
    }
    let [film_now, drop_now] = astray(&pfem);
    assert!(drop_now == 0.0 && (film_now / film - 1.0).abs() < 0.05, "{drop_now} {film_now}");
    let counts = pfem.snapshot().counts;
    let joined = counts.iter().find(|(name, _)| name == "particles: joined").unwrap().1;
    assert!((joined as f64 * particle - drop).abs() < 0.1 * drop, "{joined}");
    assert!((pfem.implicit.volumes[0] - 0.5).abs() < 1e-12);
}
