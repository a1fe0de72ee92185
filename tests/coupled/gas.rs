//! Gas in membranes: no particle crosses, and the paper's loop oscillates with the extrema and the period of
//! independent results (theory D.18).

use crate::model::*;
use lateen::material::StartState;
use lateen::math::{Signal, Vector};
use lateen::mpm::{Dissipation, MembraneSetup, Mpm, Setup, WallKind};
use lateen::simulation::Solver;

/// A chain through `corners` with `divisions` segments between them; closed if the last corner is the first.
pub fn chain(corners: &[[f64; 2]], divisions: &[u32]) -> (Vec<Vector<2>>, Vec<Vec<u32>>) {
    let mut points = Vec::new();
    for (ends, &n) in corners.windows(2).zip(divisions) {
        let [a, b] = [Vector(ends[0]), Vector(ends[1])];
        points.extend((0..n).map(|k| a + (b - a) * (f64::from(k) / f64::from(n))));
    }
    let closed = corners.first() == corners.last();
    points.extend((!closed).then(|| Vector(corners[corners.len() - 1])));
    let n = points.len() as u32;
    let elements = (0..if closed { n } else { n - 1 }).map(|k| vec![k, (k + 1) % n]).collect();
    (points, elements)
}

fn pressurised(lower: [f64; 2], count: [usize; 2], spacing: f64, energy: f64) -> lateen::mpm::BodySetup<2> {
    let state = StartState { energy: Some(energy), ..StartState::default() };
    body("gas", (gas(0.1), state), (lower, count, spacing), |_| true, Vector::ZERO)
}

/// A quarter of the gas block of 7.3 in its rectangular loop.
fn expansion(dissipation: Dissipation) -> Mpm<2> {
    let (points, elements) = chain(&[[0.5, 0.0], [0.5, 1.0], [0.0, 1.0]], &[10, 5]);
    let supports = vec![support(vec![0], [false, true, false]), support(vec![15], [true, false, false])];
    let membrane = membrane(points, elements, [0.5, 1e6, 0.3, 0.1], supports);
    let grid = symmetric(open([0.0, 0.0], 0.1, [16, 16]), &[0, 1]);
    let setup = setup(grid, vec![pressurised([0.0, 0.0], [18, 38], 0.025, 25.0)], vec![membrane]);
    start(Setup { dissipation, ..setup })
}

/// The first extrema of the oscillation, times and radii, are those of an independent program (theory D.18), which
/// knows them to 0.02.
///
/// The energy that is lost has no closed form. That program loses 3.1 to 5.1 % with cells of 0.1, depending on shape
/// functions and gap, and 3.0 % in contact (`cases/mpm/gas-expansion`). The bounds are a quarter above the most of it,
/// and a third around its part in contact: they guard against a regression that dissipates more, or misses the impact
/// of the gas.
#[test]
fn extrema_and_losses_of_the_gas_loop_agree_with_an_independent_program() {
    let mut mpm = expansion(Dissipation::Lost);
    let (mut widest, mut flattest, mut narrowest) = ([0.0; 2], [0.0, 9.0], [0.0, 9.0]);
    run(&mut mpm, 1.1, |t, mpm| {
        let points = nodes(mpm);
        let (side, top) = (points[0][0], points[15][1]);
        if side > widest[1] {
            widest = [t, side];
        }
        if top < flattest[1] {
            flattest = [t, top];
        }
        if t > 0.6 && side < narrowest[1] {
            narrowest = [t, side];
        }
    });
    for ([t, r], [time, radius]) in [(widest, [0.50, 1.13]), (flattest, [0.48, 0.733]), (narrowest, [0.97, 0.805])] {
        assert!((t - time).abs() < 0.03 && (r - radius).abs() < 0.02, "{t} {r}, expected {time} {radius}");
    }
    let energy = term(&mpm, "stored energy at the start");
    let losses = ["contact dissipation", "contact mapping loss", "transfer dissipation"].map(|name| term(&mpm, name));
    let lost = (losses.iter().sum::<f64>() - term(&mpm, "stress update error")) / energy;
    assert!((0.03..0.065).contains(&lost), "{lost}");
    assert!((0.02..0.04).contains(&(losses[0] / energy)), "{losses:?}");
    assert!(closure(&mpm).abs() < 1e-12);
    assert_eq!(crossed(&mpm), 0);
}

/// With the heat of the transfer, energy is lost in contact and in the stresses of the sheet alone: an identity of the
/// ledger. That the transfer dissipates more than 1 %, as in an independent program (`cases/mpm/gas-expansion`), shows
/// that there is something to keep.
#[test]
fn transfer_dissipation_heats_the_gas_in_the_loop() {
    let mut mpm = expansion(Dissipation::Heat);
    run(&mut mpm, 1.1, |_, _| {});
    let energy = term(&mpm, "stored energy at the start");
    let fraction = |name| term(&mpm, name) / energy;
    let contact = fraction("contact dissipation") + fraction("contact mapping loss");
    let stored = ["kinetic energy: gas", "internal energy: gas", "kinetic energy: sheet", "strain energy: sheet"];
    let lost = 1.0 - stored.into_iter().map(fraction).sum::<f64>();
    assert!(fraction("transfer dissipation") > 0.01, "{}", fraction("transfer dissipation"));
    let sheet = fraction("stress update error: sheet");
    assert!((lost - contact + sheet).abs() < 1e-4, "{lost} {contact} {sheet}");
    assert!(closure(&mpm).abs() < 1e-12);
}

/// The membrane is inextensible, so it oscillates about a circle of perimeter 6 with the period 0.988 of the second
/// ring mode of a gas-filled loop (theory (D.32)).
#[test]
fn the_gas_loop_oscillates_with_the_period_of_its_ring_mode() {
    let mut mpm = expansion(Dissipation::Lost);
    let (mut crossings, mut last) = (Vec::new(), 0.0);
    run(&mut mpm, 3.0, |t, mpm| {
        let points = nodes(mpm);
        let difference = points[0][0] - points[15][1];
        if last * difference < 0.0 && t > 0.2 {
            crossings.push(t);
        }
        last = difference;
    });
    let period = 2.0 * (crossings[crossings.len() - 1] - crossings[0]) / (crossings.len() - 1) as f64;
    assert!((period / 0.988 - 1.0).abs() < 0.05, "ring mode: {period}, {crossings:?}");
    let radii: Vec<f64> = nodes(&mpm).iter().map(|x| x[0].hypot(x[1])).collect();
    let mean = radii.iter().sum::<f64>() / radii.len() as f64;
    assert!((mean / 0.9554 - 1.0).abs() < 0.02, "radius {mean}");
}

/// A heavy sheet, held at its ends and under the same pressure from outside as from inside, closes a box of gas: it
/// stays at rest, also next to its supports.
#[test]
fn a_sheet_between_equal_pressures_stays_at_rest_up_to_its_supports() {
    let (points, elements) = chain(&[[0.0, 0.0], [0.6, 0.0]], &[12]);
    let lid = membrane(points, elements, [20.0, 1.0, 0.0, 0.05], vec![support(vec![0, 12], [true; 3])]);
    let lid = MembraneSetup { pressure: Signal::Constant(1.0), follower: false, ..lid };
    let mut grid = symmetric(open([0.0, -0.5], 0.1, [6, 9]), &[0, 1]);
    grid.walls[0][1].kind = WallKind::Slip;
    let mut mpm = start(setup(grid, vec![pressurised([0.0, -0.5], [24, 20], 0.025, 2.5)], vec![lid]));
    run(&mut mpm, 0.5, |_, _| ());
    for [_, y, _] in nodes(&mpm) {
        assert!(y.abs() < 1e-12, "{y:e}");
    }
}

/// A square box of membrane, held at its corners and blown up by the gas in it: no particle leaves in 10,000
/// steps, and the gas presses as hard as its energy says.
#[test]
fn a_pressurised_box_is_tight_for_ten_thousand_steps() {
    let corners = [[0.2, 0.2], [0.6, 0.2], [0.6, 0.6], [0.2, 0.6], [0.2, 0.2]];
    let (points, elements) = chain(&corners, &[6, 6, 6, 6]);
    let membrane = membrane(points, elements, [0.5, 1e3, 0.3, 0.05], vec![support(vec![0, 6, 12, 18], [true; 3])]);
    let mut mpm = start(setup(
        open([0.0, 0.0], 0.1, [8, 8]),
        vec![pressurised([0.2, 0.2], [12, 12], 0.4 / 12.0, 25.0)],
        vec![membrane],
    ));
    let mut t = 0.0;
    for _ in 0..10_000 {
        let dt = mpm.stable_dt();
        mpm.step(t, dt).unwrap_or_else(|error| panic!("{error}"));
        t += dt;
    }
    assert_eq!(crossed(&mpm), 0);
    assert!(closure(&mpm).abs() < 1e-12);
    assert!(t > 10.0 * 0.4 / 3.7, "many passages of sound: {t}");
}
