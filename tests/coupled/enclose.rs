//! Volumes that membranes enclose, and pressures of bodies on them.

use crate::model::*;
use lateen::material::StartState;
use lateen::math::Vector;
use lateen::mpm::{MembraneSetup, Mpm, SheetContact, WallKind};
use lateen::simulation::Solver;
use std::f64::consts::{PI, TAU};

const FILM: [f64; 4] = [1000.0, 1e6, 0.3, 1e-3];

/// The surface of a cube from −1 to 1 with `n` by `n` quadrilaterals on each face, as `place` moves its nodes.
fn cube(n: u32, place: impl Fn(Vector<3>) -> Vector<3>) -> MembraneSetup<3> {
    let (mut keys, mut elements): (Vec<[u32; 3]>, Vec<Vec<u32>>) = (Vec::new(), Vec::new());
    let mut node = |key: [u32; 3]| {
        let known = keys.iter().position(|other| *other == key);
        known.unwrap_or_else(|| {
            keys.push(key);
            keys.len() - 1
        }) as u32
    };
    for (axis, end) in (0..3).flat_map(|axis| [(axis, 0), (axis, n)]) {
        for (i, j) in (0..n).flat_map(|j| (0..n).map(move |i| (i, j))) {
            let mut corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
            if end == 0 {
                corners.reverse();
            }
            let key = |(i, j)| -> [u32; 3] {
                std::array::from_fn(|a| {
                    if a == axis {
                        end
                    } else if a == (axis + 1) % 3 {
                        i
                    } else {
                        j
                    }
                })
            };
            elements.push(corners.map(|corner| node(key(corner))).to_vec());
        }
    }
    let at = |key: &[u32; 3]| place(Vector(key.map(|i| 2.0 * f64::from(i) / f64::from(n) - 1.0)));
    membrane(keys.iter().map(at).collect(), elements, FILM, Vec::new())
}

fn model<const D: usize>(sheet: MembraneSetup<D>) -> Mpm<D> {
    start(setup(open([-2.0; D], 0.5, [8; D]), Vec::new(), vec![sheet]))
}

/// A field of the elements of the only membrane.
fn field<const D: usize>(mpm: &Mpm<D>, name: &str) -> Option<Vec<f64>> {
    let snapshot = mpm.snapshot();
    let field = snapshot.surfaces[0].element_fields.iter().find(|field| field.name == name)?;
    Some(field.values().to_vec())
}

fn volume<const D: usize>(sheet: MembraneSetup<D>) -> Option<f64> {
    field(&model(sheet), "volume").map(|parts| parts.iter().sum())
}

/// A cube, also sheared, and whichever way its normals point; a ball to second order in its elements.
#[test]
fn closed_membranes_enclose_the_volumes_of_cube_and_ball() {
    let shear = |x: Vector<3>| Vector([x[0] + 0.3 * x[1], x[1] - 0.2 * x[2], 0.5 * x[2]]);
    let mut inward = cube(3, shear);
    inward.elements.iter_mut().for_each(|nodes| nodes.reverse());
    for (sheet, expected) in [(cube(1, |x| x), 8.0), (cube(3, shear), 4.0), (inward, 4.0)] {
        let found = volume(sheet).unwrap();
        assert!((found - expected).abs() < 1e-13, "{found}");
    }
    let errors = [8, 16].map(|n| 1.0 - volume(cube(n, |x| x.normalized().unwrap())).unwrap() / (4.0 * PI / 3.0));
    assert!(errors[0] < 0.02 && (3.8..4.2).contains(&(errors[0] / errors[1])), "{errors:?}");
}

/// A corner of a cube's face with 2 by 2 elements is lifted by h: two of the fan's four triangles of each of three
/// elements have it.
#[test]
fn volume_under_warped_quadrilaterals_is_that_of_their_fan_of_triangles() {
    let lifted =
        |h: f64| volume(cube(2, |x| if x == Vector([0.0, 0.0, 1.0]) { Vector([0.0, 0.0, 1.0 + h]) } else { x }));
    // The middle of a face belongs to four squares with sides of 1. In each, its lifting by h lifts the mean point by
    // h/4: the mean height of the fan is that of two triangles with (h, 0, h/4) and two with (0, 0, h/4).
    let each = (2.0 * (0.1 + 0.025) / 3.0 + 2.0 * 0.025 / 3.0) / 4.0;
    assert!((lifted(0.1).unwrap() - 8.0 - 4.0 * each).abs() < 1e-13);
}

#[test]
fn a_membrane_with_free_edges_or_mixed_normals_encloses_nothing() {
    let mut open = cube(2, |x| x);
    open.elements.pop();
    let mut mixed = cube(2, |x| x);
    mixed.elements[0].reverse();
    assert_eq!((volume(open), volume(mixed)), (None, None));
}

/// Of a loop in the plane it is the area: ½ n sin(2π/n) of a regular polygon.
#[test]
fn a_loop_encloses_its_area() {
    let n = 7_u32;
    let corner = |k: u32| Vector([(TAU * f64::from(k) / 7.0).cos(), (TAU * f64::from(k) / 7.0).sin()]);
    let chain = |closed: bool| {
        let last = if closed { n } else { n - 1 };
        membrane((0..n).map(corner).collect(), (0..last).map(|k| vec![k, (k + 1) % n]).collect(), FILM, Vec::new())
    };
    assert!((volume(chain(true)).unwrap() - 3.5 * (TAU / 7.0).sin()).abs() < 1e-14);
    assert_eq!(volume(chain(false)), None);
}

/// Gas of 1 Pa on the upper side of a flat sheet that is held: the sheet feels 1 Pa, away from its normal or along it,
/// and in sum the contact force, whichever way contact is found.
#[test]
fn the_contact_pressure_is_that_of_the_gas_and_sums_to_the_contact_force() {
    for (contact, sign) in [(SheetContact::Nodes, 1.0), (SheetContact::Particles, -1.0)] {
        let (n, cell) = (16_u32, 0.125);
        let at = |k: u32| Vector([if sign > 0.0 { f64::from(k) } else { f64::from(n - k) } / f64::from(n), 0.25]);
        let held = support((0..=n).collect(), [true; 3]);
        let sheet = membrane((0..=n).map(at).collect(), (0..n).map(|k| vec![k, k + 1]).collect(), FILM, vec![held]);
        let mut grid = open([0.0; 2], cell, [8, 8]);
        grid.walls.iter_mut().flatten().for_each(|wall| wall.kind = WallKind::Slip);
        let state = StartState { energy: Some(2.5), ..StartState::default() };
        let gas = body("gas", (gas(0.0), state), ([0.0, 0.25], [32, 24], 0.25 * cell), |_| true, Vector::ZERO);
        let mut mpm = start(lateen::mpm::Setup { sheet_contact: contact, ..setup(grid, vec![gas], vec![sheet]) });
        run(&mut mpm, 0.2, |_, _| {});
        let [pressure, area] = ["contact pressure", "contact area"].map(|name| field(&mpm, name).unwrap());
        let sum: f64 = pressure.iter().zip(&area).map(|(p, a)| p * a).sum();
        let forces = mpm.snapshot().forces;
        let force = forces.iter().find(|(name, _)| name == "contact:gas-sheet").unwrap().1[1];
        assert!((sum.abs() - force).abs() < 1e-9 * force, "{contact:?}: {sum} {force}");
        assert!((sum * sign - 1.0).abs() < 0.05, "{contact:?}: {sum}");
        assert!((area.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{area:?}");
    }
}
