//! Passes of contact at grid nodes: what the nodes of a sheet take up (theory D.7).

use crate::model::*;
use lateen::math::Vector;
use lateen::mpm::{Friction, KernelKind, Setup};

/// The impulse on a heavy particle that sits at a grid node and hits a fine chain of mass 1 per length at speed 1.
fn impulse(contact_passes: usize) -> f64 {
    let hammer = block("hammer", [7.95, 4.95], [1, 1], 0.1, 1e12, Vector([0.0, -1.0]));
    let elements = (0..160_u32).map(|k| vec![k + 1, k]).collect();
    let at = |k: u32| Vector([4.0 + 0.05 * f64::from(k), 5.0]);
    let chain = sheet(elements, (0..=160).map(at).collect(), 1.0);
    let mut setup = setup([16, 12], vec![hammer], vec![chain], Friction::Slip(0.0));
    setup.bodies[0].position[0] = Vector([8.0, 5.0]);
    let mut world = World::new(Setup { kernel: KernelKind::Linear, contact_passes, ..setup });
    let dt = 1e-3;
    world.step(dt);
    // The first step of the momentum is half as long.
    world.contact_force().1[1] * 0.5 * dt
}

/// The one grid node sees the mass m = ∫N dx = 1 of the chain, but the chain's own nodes take up a velocity N(x) of
/// which the grid gets back ∫N² dx / ∫N dx = 2/3 only: each pass leaves a third of the approach, and the impulses of n
/// passes are m (1 + 1/3 + …) = 3/2 (1 − 3⁻ⁿ), theory (D.16).
#[test]
fn each_pass_leaves_a_third_of_the_approach() {
    for passes in [1, 2, 3, 8] {
        let expected = 1.5 * (1.0 - 3.0_f64.powi(-(passes as i32)));
        let found = impulse(passes);
        assert!((found - expected).abs() < 5e-3, "{passes} passes: {found} for {expected}");
    }
}
