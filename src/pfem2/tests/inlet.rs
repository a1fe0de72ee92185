//! Two fluids that flow side by side through a channel: uniform flow is the solution, and the line between them stays.

use super::*;
use crate::pfem2::Pfem2;
use crate::pfem2::interface::level_set::LevelSet;
use crate::simulation::Solver;

/// Length and height of the channel, its cells along the height, and the height of the line.
const CHANNEL: ([f64; 2], usize, f64) = ([1.0, 0.5], 10, 0.237);

/// Water under oil at rest; then both come in faster and faster, until their speed is one.
fn channel(names: bool) -> Pfem2<2, 3> {
    let ([length, height], cells, line) = CHANNEL;
    // Lines of nodes that tilt the more the farther they are from the ends.
    let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector([length, height]), [2 * cells, cells]).unwrap();
    let mesh = shaken(&mesh, height / cells as f64);
    let along = || Condition::Inlet([formula("ramp(t, 0.5)"), 0.0.into()]);
    let split = 0.25;
    let line = if names { split } else { line };
    let mut sets = vec![
        set(&mesh, "below", along(), |x| x[0] == 0.0 && x[1] < split + 1e-9),
        set(&mesh, "above", along(), |x| x[0] == 0.0 && x[1] > split - 1e-9),
        set(&mesh, "out", Condition::Outlet, |x| x[0] == length),
        set(&mesh, "sides", Condition::Slip, |x| x[1] == 0.0 || x[1] == height),
    ];
    if names {
        (sets[0].brings, sets[1].brings) = (Some(0), Some(1));
    }
    let phi = |x: Vector<2>| x[1] - line;
    let physics = physics(vec![fluid("water", 1000.0, 0.1), fluid("oil", 900.0, 0.5)], weightless());
    let mut setup = setup(mesh, sets, physics, |x| u8::from(phi(x) >= 0.0), |_| Vector::ZERO);
    setup.level_set = Some(LevelSet::new(&setup.mesh, 0, phi, &mut setup.particles));
    Pfem2::new(setup)
}

/// Largest distance of the line from where it belongs in the first quarter of the channel, and its outermost ends
/// there, after so many steps of `dt`.
fn wandered(names: bool, (steps, dt): (u32, f64)) -> f64 {
    let ([length, _], _, line) = CHANNEL;
    let line = if names { 0.25 } else { line };
    let mut pfem = channel(names);
    for k in 0..steps {
        pfem.step(f64::from(k) * dt, dt).unwrap();
    }
    let near = pfem.interface.outline.position.iter().filter(|x| x[0] < 0.25 * length);
    let away: Vec<f64> = near.map(|x| (x[1] - line).abs()).collect();
    assert!(!away.is_empty(), "there is no line at the inlet");
    away.into_iter().fold(0.0, f64::max)
}

/// A cell is 0.05 high. In short steps no streamline reaches from the middle of an element to the inlet.
#[test]
fn a_line_at_an_inlet_stays_where_it_is() {
    for (names, steps, dt) in [(false, 200, 0.04), (true, 60, 0.04), (false, 300, 0.005)] {
        let away = wandered(names, (steps, dt));
        assert!(away < 0.05 * 0.05, "{names} {dt}: {away}");
    }
}

/// A channel full of air at speed one, into which water begins to flow: its front is at x = t. Exact, however long the
/// steps.
#[test]
fn a_fluid_from_an_inlet_alone_comes_in_with_a_plane_front() {
    for (dt, steps) in [(0.03, 20), (0.004, 60)] {
        let mesh = shaken(&Mesh::<2, 3>::block(Vector::ZERO, Vector([1.0, 0.4]), [20, 8]).unwrap(), 0.05);
        let mut sets = vec![
            set(&mesh, "in", Condition::Inlet([1.0.into(), 0.0.into()]), |x| x[0] == 0.0),
            set(&mesh, "out", Condition::Outlet, |x| x[0] == 1.0),
            set(&mesh, "sides", Condition::Slip, |x| x[1] == 0.0 || x[1] == 0.4),
        ];
        sets[0].brings = Some(0);
        let physics = physics(vec![fluid("water", 1000.0, 0.0), fluid("air", 1.0, 0.0)], weightless());
        let mut setup = setup(mesh, sets, physics, |_| 1, |_| Vector([1.0, 0.0]));
        setup.level_set = Some(LevelSet::new(&setup.mesh, 0, |_| 1.0, &mut setup.particles));
        let mut pfem = Pfem2::new(setup);
        let (mut shift, mut away) = (0.0f64, 0.0f64);
        for k in 0..steps {
            pfem.step(f64::from(k) * dt, dt).unwrap();
            let t = f64::from(k + 1) * dt;
            assert!(
                (pfem.system.contents.volumes[0] - 0.4 * t).abs() < 1e-12,
                "{k}: {}",
                pfem.system.contents.volumes[0]
            );
            let line = &pfem.interface.outline.position;
            assert!(!line.is_empty(), "{k}: there is no line");
            away = line.iter().fold(away, |away, x| away.max((x[0] - t).abs()));
            shift = shift.max(pfem.interface.shift.abs());
        }
        assert!(away < 0.01 * 0.05 && shift < 0.01 * 0.05, "{dt}: {away} {shift}");
        assert_eq!(pfem.notices(), Vec::<String>::new());
    }
}
