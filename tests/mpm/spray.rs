//! Liquids that separate into drops.

use crate::model::*;
use lateen::material::{EquationsOfState, Fluid, PointLaw, eos};
use lateen::math::{Signal, Tensor, Vector};
use lateen::mpm::{Locking, Transfer, WallKind};

fn water() -> Box<dyn PointLaw> {
    let eos = EquationsOfState::LinearLiquid(eos::LinearLiquid { sound_speed: 20.0, tensile_strength: 0.0 });
    Box::new(Fluid { density: 1000.0, viscosity: 0.0, bulk_viscosity: Default::default(), eos })
}

/// A drop that expands at 4/s in all directions. Its particles separate, and each has an affine velocity of its own,
/// with which its volume would grow as V0 (1 + 4 t)², to 81 V0 in two seconds; a liquid that has parted keeps V0.
#[test]
fn an_expanding_drop_keeps_its_volume_and_mass() {
    for locking in [Locking::None, Locking::Average { blend: 1.0 }] {
        let mut setup = setup(grid([-5.0, -5.0], 0.1, [100, 100], WallKind::Open));
        (setup.transfer, setup.locking) = (Transfer::Apic, locking);
        let drop = |x: Vector<2>| x.norm() < 0.3;
        let mut drop = body(water(), ([-0.3, -0.3], [12, 12], 0.05), drop, |x| x * 4.0);
        drop.velocity_gradient = vec![Tensor::identity() * 4.0; drop.position.len()];
        let before = drop.volume.iter().sum::<f64>();
        setup.bodies = vec![drop];
        let mut mpm = start(setup);
        run(&mut mpm, 2.0, 1.0, |_, _, _| {}).unwrap();
        let volume = field(&mpm, "volume");
        let (sum, most) = (volume.iter().sum::<f64>(), volume.iter().copied().fold(0.0, f64::max));
        assert!((sum / before - 1.0).abs() < 0.02 && most < 1.05 * 0.0025, "{locking:?}: {sum} of {before}, {most}");
        assert!((term(&mpm, "mass") / (1000.0 * before) - 1.0).abs() < 1e-12);
        assert!(field(&mpm, "void").iter().all(|void| (0.0..=3.0 + 1e-12).contains(void)));
    }
}

/// A collapsing column that splashes in a corner: at all times the volume of its particles is that of its mass, within
/// 5 %.
#[test]
fn a_splash_keeps_its_volume() {
    let mut setup = setup(grid([0.0, 0.0], 0.125, [16, 24], WallKind::Separate));
    (setup.transfer, setup.locking) = (Transfer::Apic, Locking::Average { blend: 1.0 });
    setup.gravity = [Signal::ZERO, Signal::Constant(-9.81)];
    setup.bodies = vec![body(water(), ([0.0, 0.0], [8, 16], 0.0625), |_| true, |_| Vector([2.0, 0.0]))];
    let mut mpm = start(setup);
    let mut worst = 0.0f64;
    run(&mut mpm, 1.5, 1.0, |_, _, mpm| {
        let sum = field(mpm, "volume").iter().sum::<f64>();
        worst = worst.max((sum / 0.5 - 1.0).abs());
    })
    .unwrap();
    assert!(worst < 0.05, "{worst}");
}
