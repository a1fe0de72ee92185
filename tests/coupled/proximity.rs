//! Membranes that come near each other, or themselves, which is reported.

use crate::bits::{restore, state};
use crate::model::*;
use lateen::math::Vector;
use lateen::mpm::proximity::distance::approach;
use lateen::mpm::{MembraneSetup, Mpm};
use lateen::simulation::Solver;
use nalgebra::{DMatrix, DVector};

/// Density 1000 kg/m³, 25 MPa, 4 mm thick.
const FILM: [f64; 4] = [1000.0, 2.5e7, 0.0, 4e-3];

/// A line of `n` segments of length `h`, along a curve.
fn line(n: u32, at: impl Fn(f64) -> [f64; 2]) -> MembraneSetup<2> {
    let places = (0..=n).map(|k| Vector(at(f64::from(k) / f64::from(n)))).collect();
    membrane(places, (0..n).map(|k| vec![k, k + 1]).collect(), FILM, Vec::new())
}

fn named<const D: usize>(name: &str, velocity: Vector<D>, mut sheet: MembraneSetup<D>) -> MembraneSetup<D> {
    sheet.name = name.into();
    sheet.velocity.fill(velocity);
    sheet
}

/// A square of `n` by `n` quadrilaterals with sides of 1 at the height `z`.
fn square(n: u32, z: f64) -> MembraneSetup<3> {
    let at = |k: u32| f64::from(k) / f64::from(n);
    let places = (0..=n).flat_map(|j| (0..=n).map(move |i| Vector([at(i), at(j), z]))).collect();
    let corner = |i: u32, j: u32| j * (n + 1) + i;
    let element = |(i, j)| vec![corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
    membrane(places, (0..n).flat_map(|j| (0..n).map(move |i| element((i, j)))).collect(), FILM, Vec::new())
}

/// Everything that a run says about membranes that meet, with its times.
fn notices<const D: usize>(mpm: &mut Mpm<D>, end: f64) -> Vec<(f64, String)> {
    let (mut t, mut all) = (0.0, Vec::new());
    while t < end {
        let dt = mpm.stable_dt().min(end - t);
        mpm.step(t, dt).unwrap_or_else(|error| panic!("{error}"));
        t += dt;
        all.extend(mpm.notices().into_iter().filter(|text| text.contains("other")).map(|text| (time(&text), text)));
    }
    all
}

/// The time that a notice tells [s].
fn time(text: &str) -> f64 {
    text.split("at t = ").nth(1).and_then(|rest| rest.split(' ').next()).unwrap().parse().unwrap()
}

/// Two flat sheets face to face, 0.1 m apart and 4 mm thick, approach each other at 2 m/s: at 48 ms they are a
/// thickness apart, at 52 ms they have passed.
#[test]
fn sheets_that_approach_face_to_face_are_reported_within_a_thickness() {
    let pair = || {
        let down = named("upper", Vector([0.0, 0.0, -1.0]), square(6, 0.5));
        vec![named("lower", Vector([0.0, 0.0, 1.0]), square(6, 0.4)), down]
    };
    let mut mpm = start(setup(open([-0.5; 3], 0.25, [8, 8, 8]), Vec::new(), pair()));
    let notices = notices(&mut mpm, 0.1);
    let [(t, text)] = &notices[..] else { panic!("{notices:?}") };
    assert!((0.048..0.052).contains(t), "{t}");
    assert!(text.starts_with("the membranes `lower` and `upper` come within"), "{text}");
    let height: f64 = text.split(['(', ')']).nth(1).unwrap().split(", ").nth(2).unwrap().parse().unwrap();
    assert!((height - 0.45).abs() < 4e-3, "{text}");
}

/// The sheets that approach each other face to face, saved as soon as they are known to meet: they do so for a
/// millisecond more, in the run that goes on from there, too, and there is no second notice.
#[test]
fn a_resumed_run_does_not_repeat_notices_of_contact_between_sheets() {
    let pair = || {
        let down = named("upper", Vector([0.0, 0.0, -1.0]), square(6, 0.5));
        let sheets = vec![named("lower", Vector([0.0, 0.0, 1.0]), square(6, 0.4)), down];
        start(setup(open([-0.5; 3], 0.25, [8, 8, 8]), Vec::new(), sheets))
    };
    let mut first = pair();
    let (mut t, mut told) = (0.0, Vec::new());
    while told.is_empty() && t < 0.06 {
        let dt = first.stable_dt().min(5e-4);
        first.step(t, dt).unwrap();
        t += dt;
        told = first.notices();
    }
    assert!(told.len() == 1 && t < 0.051, "{t}: {told:?}");
    let mut second = pair();
    restore(&mut second, &state(&mut first));
    assert!(second.misfit().is_none());
    for _ in 0..2 {
        let dt = second.stable_dt().min(5e-4);
        second.step(t, dt).unwrap();
        t += dt;
    }
    assert_eq!(second.notices(), Vec::<String>::new());
    assert!(t < 0.052, "they are still within a thickness: {t}");
}

/// A line of 1 m that falls with its end first onto another at 1 m/s from a height of 0.105 m: after 101 ms it is a
/// thickness away.
#[test]
fn contact_between_lines_is_reported_with_time_and_place() {
    let floor = named("floor", Vector::ZERO, line(20, |s| [s, 0.2]));
    let pole = named("pole", Vector([0.0, -1.0]), line(20, |s| [0.52, 0.305 + s]));
    let mut mpm = start(setup(open([-0.5; 2], 0.25, [8, 8]), Vec::new(), vec![floor, pole]));
    let notices = notices(&mut mpm, 0.2);
    let [(t, text)] = &notices[..] else { panic!("{notices:?}") };
    assert!((0.101..0.105).contains(t), "{t}: {text}");
    assert!(text.contains("`floor` and `pole`") && text.contains("at (5.2"), "{text}");
}

/// Two arms of 0.5 m at 60 degrees swing towards each other about their hinge at 1 rad/s each: after
/// π/6 s they would be one. An element away from the hinge they are a thickness apart when the angle is 0.04 to each
/// side.
#[test]
fn a_sheet_that_folds_onto_itself_is_reported_once() {
    let angle = std::f64::consts::PI / 6.0;
    let arm = |s: f64| [(1.0 - 2.0 * s).abs() * 0.5 * angle.cos(), (0.5 - s) * angle.sin()];
    let mut sheet = line(20, arm);
    sheet.supports = vec![support(vec![10], [true; 3])];
    for (x, v) in sheet.position.iter().zip(&mut sheet.velocity) {
        *v = Vector([x[1].abs(), -x[0] * x[1].signum()]);
    }
    let mut mpm = start(setup(open([-1.0; 2], 0.25, [8, 8]), Vec::new(), vec![sheet]));
    let notices = notices(&mut mpm, 0.6);
    let [(t, text)] = &notices[..] else { panic!("{notices:?}") };
    assert!((angle - 0.1..angle).contains(t), "{t}: {text}");
    assert!(text.contains("the membrane `sheet`"), "{text}");
}

/// Two squares sewn together at their edges, and blown up; and a thick sheet squeezed along itself: nobody meets.
#[test]
fn neighbours_and_joined_sheets_are_not_reported() {
    let bulge = |sign: f64| {
        let mut sheet = square(6, 0.5);
        let height = |x: &Vector<3>| 0.3 * x[0] * (1.0 - x[0]) * x[1] * (1.0 - x[1]);
        sheet.position.iter_mut().for_each(|x| x[2] += sign * height(x));
        sheet.name = format!("side {sign}");
        sheet.pressure = lateen::math::Signal::Constant(sign);
        let edge = |x: &Vector<3>| x.0[..2].iter().any(|c| *c == 0.0 || *c == 1.0);
        let held = (0_u32..).zip(&sheet.position).filter(|(_, x)| edge(x)).map(|(k, _)| k).collect();
        sheet.supports = vec![support(held, [true; 3])];
        sheet
    };
    let squeezed = {
        let mut sheet = square(6, 0.8);
        sheet.velocity = sheet.position.iter().map(|x| Vector([40.0 * (0.5 - x[0]), 0.0, 0.0])).collect();
        sheet.thickness = 0.3;
        sheet
    };
    let sheets = vec![bulge(1.0), bulge(-1.0), squeezed];
    let mut mpm = start(setup(open([-0.5; 3], 0.25, [8, 8, 8]), Vec::new(), sheets));
    assert_eq!(notices(&mut mpm, 0.2), []);
}

/// The distance of two triangles by trying all of their corners, sides and faces: for each pair the least squares
/// solution, taken where it lies in both.
fn distance_by_all_pairs(a: &[Vector<3>; 3], b: &[Vector<3>; 3]) -> f64 {
    const PARTS: [&[usize]; 7] = [&[0], &[1], &[2], &[0, 1], &[1, 2], &[2, 0], &[0, 1, 2]];
    let of = |p: &[usize], q: &[usize]| {
        let origin = a[p[0]] - b[q[0]];
        let sides = p[1..].iter().map(|&k| a[k] - a[p[0]]).chain(q[1..].iter().map(|&k| b[q[0]] - b[k]));
        let sides: Vec<Vector<3>> = sides.collect();
        if sides.is_empty() {
            return origin.norm();
        }
        let matrix = DMatrix::from_fn(3, sides.len(), |i, k| sides[k][i]);
        let right = DVector::from_fn(3, |i, _| -origin[i]);
        let weights = matrix.svd(true, true).solve(&right, 1e-12).expect("least squares");
        let within = |w: &[f64]| w.iter().all(|&w| w >= -1e-9) && w.iter().sum::<f64>() <= 1.0 + 1e-9;
        let (on_a, on_b) = weights.as_slice().split_at(p.len() - 1);
        let apart = sides.iter().zip(weights.iter()).fold(origin, |x, (&side, &w)| x + side * w).norm();
        if within(on_a) && within(on_b) { apart } else { f64::INFINITY }
    };
    PARTS.iter().flat_map(|p| PARTS.iter().map(move |q| of(p, q))).fold(f64::INFINITY, f64::min)
}

/// Triangles in any place, against the least of all pairs of their parts.
#[test]
fn distances_of_elements_are_the_least_of_all_pairs_of_their_parts() {
    let mut seed = 7_u64;
    let mut number = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    let mut corner = || Vector(std::array::from_fn::<f64, 3, _>(|_| number()));
    let (mut crossings, mut apart) = (0, 0);
    for k in 0..2000 {
        let away = Vector([f64::from(k % 4) * 0.5, 0.0, 0.0]);
        let a: [Vector<3>; 3] = std::array::from_fn(|_| corner());
        let b: [Vector<3>; 3] = std::array::from_fn(|_| corner() + away);
        let expected = distance_by_all_pairs(&a, &b);
        let found = approach(&a, &b, 10.0).unwrap();
        assert!((found.distance - expected).abs() < 1e-6, "{k}: {found:?} {expected}");
        assert!(approach(&a, &b, found.distance * 0.999).is_none());
        if found.distance == 0.0 { crossings += 1 } else { apart += 1 }
    }
    assert!(crossings > 300 && apart > 300, "{crossings} {apart}");
}

/// A segment over a quadrilateral that is not flat: its fan has its top in the middle.
#[test]
fn the_distance_of_a_quadrilateral_is_that_of_the_fan_around_its_mean_point() {
    let saddle = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.4], [1.0, 1.0, 0.0], [0.0, 1.0, 0.4]].map(Vector);
    let over = [[0.4, 0.4, 0.3], [0.6, 0.4, 0.3], [0.5, 0.6, 0.3]].map(Vector);
    let found = approach(&saddle, &over, 1.0).unwrap();
    assert!(found.distance < 0.1 + 1e-12 && found.distance > 0.05, "{found:?}");
    let through = [[0.45, 0.45, 0.3], [0.55, 0.45, 0.3], [0.5, 0.55, 0.1]].map(Vector);
    assert_eq!(approach(&saddle, &through, 1.0).unwrap().distance, 0.0);
}
