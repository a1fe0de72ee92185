//! Particles of one fluid inside the other.

use super::*;
use crate::pfem2::Pfem2;
use crate::pfem2::interface::level_set::LevelSet;
use crate::simulation::Solver;

/// Water below 0.5 and air above it, at rest, with a drop of air in the water and a film of water just above the line
/// that the level set doesn't show.
fn strewn() -> Pfem2<2, 3> {
    let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector::splat(1.0), [16; 2]).unwrap();
    let sets = vec![set(&mesh, "walls", Condition::Slip, |x| x.0.iter().any(|c| *c == 0.0 || *c == 1.0))];
    let phi = |x: Vector<2>| x[1] - 0.5;
    let fluids = vec![fluid("water", 1000.0, 1e-3), fluid("air", 1.0, 1e-5)];
    let mut setup =
        setup(mesh, sets, physics(fluids, [0.0.into(), (-9.81).into()]), |x| u8::from(phi(x) >= 0.0), |_| Vector::ZERO);
    setup.level_set = Some(LevelSet::new(&setup.mesh, 0, phi, &mut setup.particles));
    let mut pfem = Pfem2::new(setup);
    let Particles { position, phase, depth, .. } = &mut pfem.particles.columns;
    for ((x, phase), depth) in position.iter().zip(phase).zip(depth) {
        if (*x - Vector([0.53, 0.22])).norm() < 0.025 || is_film(x) {
            (*phase, *depth) = (1 - *phase, 0.0);
        }
    }
    pfem
}

fn is_film(x: &Vector<2>) -> bool {
    (0.51..0.54).contains(&x[1])
}

/// Numbers of particles of water above the line, and of air deep below it.
fn strays(pfem: &Pfem2<2, 3>) -> [usize; 2] {
    let Particles { position, phase, .. } = &pfem.particles.columns;
    let count = |stray: &dyn Fn(f64, u8) -> bool| position.iter().zip(phase).filter(|(x, f)| stray(x[1], **f)).count();
    [count(&|y, fluid| y > 0.505 && fluid == 0), count(&|y, fluid| y < 0.4 && fluid == 1)]
}

fn stray_volumes(pfem: &Pfem2<2, 3>) -> [f64; 2] {
    let amounts = pfem.snapshot().amounts;
    ["stray volume: water", "stray volume: air"].map(|name| amounts.iter().find(|(own, ..)| own == name).unwrap().2)
}

#[test]
fn air_deep_in_water_joins_it_and_a_film_at_the_surface_stays() {
    let mut pfem = strewn();
    // All elements are of one size and hold as many particles.
    let particle = 1.0 / pfem.particles.columns.len() as f64;
    let [film, drop] = strays(&pfem);
    assert!(film > 100 && drop > 10, "{film} {drop}");
    for (volume, count) in stray_volumes(&pfem).into_iter().zip([film, drop]) {
        assert!((volume - count as f64 * particle).abs() < 1e-12, "{volume} {count}");
    }
    for k in 0..3 {
        pfem.step(f64::from(k) * 1e-3, 1e-3).unwrap();
    }
    assert_eq!(strays(&pfem), [film, 0]);
    let counts = pfem.snapshot().counts;
    let joined = counts.iter().find(|(name, _)| name == "particles: joined").unwrap().1;
    assert_eq!(joined, drop as u64);
    assert!((pfem.system.contents.volumes[0] - 0.5).abs() < 1e-12);
}
