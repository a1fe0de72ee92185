//! Liquids in membranes keep their volume, and particles their sides.

use crate::model::*;
use lateen::material::{EquationsOfState, Fluid, PointLaw, StartState, eos};
use lateen::math::{Signal, Vector};
use lateen::mpm::{Mpm, Setup, SheetContact, Transfer, WallKind};
use lateen::simulation::Solver;
use std::f64::consts::TAU;

const RADIUS: f64 = 0.1;
const CELL: f64 = 0.0125;

fn water() -> Box<dyn PointLaw> {
    let eos = EquationsOfState::LinearLiquid(eos::LinearLiquid { sound_speed: 20.0, tensile_strength: 0.0 });
    Box::new(Fluid { density: 1000.0, viscosity: 1e-3, bulk_viscosity: Default::default(), eos })
}

/// A loop of 64 elements full of water, 0.1 m above a floor.
fn balloon() -> Mpm<2> {
    let centre = Vector([0.0, 0.2]);
    let around = |k: u32| TAU * f64::from(k) / 64.0;
    let places = (0..64).map(|k| centre + Vector([around(k).cos(), around(k).sin()]) * RADIUS).collect();
    let elements = (0..64).map(|k| vec![k, (k + 1) % 64]).collect();
    let skin = membrane(places, elements, [1000.0, 1e6, 0.0, 5e-4], Vec::new());
    let inside = |x: Vector<2>| (x - centre).norm() < 0.95 * RADIUS;
    let start_at = (water(), StartState::default());
    let water = body("water", start_at, ([-0.1, 0.1], [32, 32], 0.5 * CELL), inside, Vector::ZERO);
    let mut grid = open([-0.3, 0.0], CELL, [48, 32]);
    grid.walls[1][0].kind = WallKind::Separate;
    let setup = setup(grid, vec![water], vec![skin]);
    let gravity = [Signal::ZERO, Signal::Constant(-9.81)];
    start(Setup { gravity, sheet_contact: SheetContact::Particles, transfer: Transfer::Apic, ..setup })
}

/// The area within a loop [m²].
fn enclosed(nodes: &[[f64; 3]]) -> f64 {
    let next = nodes.iter().cycle().skip(1);
    0.5 * nodes.iter().zip(next).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum::<f64>()
}

/// A balloon full of water that falls on a floor and sloshes there encloses no less than 95 % of the water's own
/// volume, which pressure changes by less than a per mille; contact gives back no more than 0.1 % of what gravity does,
/// the floor 1 %; no particle crosses. Without the room that volumes follow the loop encloses a tenth less after 1.5 s.
#[test]
fn a_balloon_full_of_water_keeps_its_volume() {
    let mut mpm = balloon();
    let volume = mpm.particle_count() as f64 * (0.5 * CELL).powi(2);
    let mut taken = [0.0_f64; 2];
    run(&mut mpm, 1.5, |t, mpm| {
        for ((taken, name), back) in taken.iter_mut().zip(["contact dissipation", "wall dissipation"]).zip([0.05, 0.5])
        {
            let now = term(mpm, name);
            assert!(now > *taken - back, "t = {t}: `{name}` is {now} J after {taken} J");
            *taken = taken.max(now);
        }
        assert_eq!(crossed(mpm), 0, "t = {t}");
    });
    let area = enclosed(&nodes(&mpm));
    assert!((0.95..1.06).contains(&(area / volume)), "{area} m² around {volume} m² of water");
    assert!(mpm.snapshot().ledger.closure(term(&mpm, "stored energy at the start")).abs() < 1e-9);
}
