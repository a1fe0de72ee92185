//! Slack sheets: what wrinkles, snaps taut, or lies between two bodies makes no energy.

use crate::model::*;
use lateen::material::{EquationsOfState, Fluid, PointLaw, StartState, eos, sheet};
use lateen::math::{Signal, Vector};
use lateen::mpm::{MembraneSetup, Mpm, Setup, SheetContact};
use lateen::simulation::Solver;

/// A chain along `place`, which maps [0, 1] to the plane, that wrinkles and is held at its ends.
fn wrinkling(n: u32, place: impl Fn(f64) -> [f64; 2]) -> MembraneSetup<2> {
    let points: Vec<_> = (0..=n).map(|k| Vector(place(f64::from(k) / f64::from(n)))).collect();
    let elements = (0..n).map(|k| vec![k, k + 1]).collect();
    let chain = membrane(points, elements, [1000.0, 1e8, 0.3, 1e-4], vec![support(vec![0, n], [true; 3])]);
    MembraneSetup {
        sheet: Box::new(sheet::Elastic { density: 1000.0, young: 1e8, poisson: 0.3, wrinkling: true }),
        ..chain
    }
}

fn water() -> Box<dyn PointLaw> {
    let eos = EquationsOfState::LinearLiquid(eos::LinearLiquid { sound_speed: 20.0, tensile_strength: 0.0 });
    Box::new(Fluid { density: 1000.0, viscosity: 0.0, bulk_viscosity: Default::default(), eos })
}

/// A chain that stands in an arch falls through its supports and snaps taut again and again: its energy is never above
/// what gravity has given. In steps of the stable length of the flat sheet it gained a hundred times that.
#[test]
fn a_slack_sheet_that_snaps_taut_gains_nothing() {
    let arch = |s: f64| [0.5 - 0.5 * (std::f64::consts::PI * s).cos(), 0.4 * (std::f64::consts::PI * s).sin()];
    let setup = setup(open([-0.5, -1.0], 0.1, [20, 20]), Vec::new(), vec![wrinkling(40, arch)]);
    let mut mpm = start(Setup { gravity: [Signal::ZERO, Signal::Constant(-9.81)], ..setup });
    let terms = ["kinetic energy: sheet", "strain energy: sheet", "work of gravity: sheet"];
    run(&mut mpm, 2.0, |t, mpm| {
        let [kinetic, strain, work] = terms.map(|name| term(mpm, name));
        // 0.14 kg fall by up to 0.9 m. The ledger carries the strain energy on by half a step, to the time of the
        // velocities.
        assert!(strain > -1e-3 && kinetic + strain < work + 0.01, "t = {t}: {kinetic} + {strain} J of {work}");
    });
}

/// Two blocks of water that meet with a slack sheet between them.
fn squeezed() -> Mpm<2> {
    let bulge = |s: f64| [0.5 + 0.05 * (40.0 * s).sin(), s];
    let block = |name: &str, lower: [f64; 2], speed: f64| {
        let start = (water(), StartState::default());
        body(name, start, (lower, [12, 24], 0.0125), |_| true, Vector([speed, 0.0]))
    };
    let blocks = vec![block("left", [0.28, 0.35], 2.0), block("right", [0.57, 0.35], -2.0)];
    let setup = setup(open([-0.5, -0.5], 0.025, [80, 80]), blocks, vec![wrinkling(80, bulge)]);
    start(Setup { sheet_contact: SheetContact::Particles, ..setup })
}

/// A light sheet between heavy particles is hit from both sides. Contact only ever takes energy; where it undid
/// overlaps by velocities, each side threw back what the other had thrown.
#[test]
fn a_light_sheet_between_two_bodies_gets_no_energy_from_contact() {
    let mut mpm = squeezed();
    let energy = term(&mpm, "stored energy at the start");
    let mut taken = 0.0_f64;
    run(&mut mpm, 0.1, |t, mpm| {
        let now = term(mpm, "contact dissipation");
        assert!(now > taken - 1e-4 * energy, "t = {t}: contact has taken {now} J, and {taken} J before, of {energy}");
        taken = taken.max(now);
    });
    assert!(taken > 1e-3 * energy, "they have met: {taken}");
    assert!(mpm.snapshot().ledger.closure(energy).abs() < 1e-9 * energy);
}
