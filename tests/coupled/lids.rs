//! Sheets along walls.

use crate::model::*;
use lateen::material::StartState;
use lateen::math::Vector;
use lateen::mpm::WallKind;

/// The nodes and quadrilaterals of a square of `n` by `n` cells at the height of one cell.
fn lid(n: u32, cell: f64) -> (Vec<Vector<3>>, Vec<Vec<u32>>) {
    let places = (0..=n).flat_map(|j| (0..=n).map(move |i| Vector([f64::from(i), f64::from(j), 1.0]) * cell));
    let corner = |i: u32, j: u32| j * (n + 1) + i;
    let elements = (0..n).flat_map(|j| (0..n).map(move |i| [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]));
    (places.collect(), elements.map(|corners| corners.map(|(i, j)| corner(i, j)).to_vec()).collect())
}

/// Gas at rest, one cell deep, under a lid that is held. At the nodes on the wall the areas of the lid and of its
/// mirror image cancel: what rounding leaves of them is no normal, along which the gas would be pushed out through a
/// wall.
#[test]
fn gas_one_cell_deep_under_a_lid_stays_at_rest() {
    let (n, cell) = (8, 0.125);
    let (points, elements) = lid(n, cell);
    let held = support((0..points.len() as u32).collect(), [true; 3]);
    let membrane = membrane(points, elements, [20.0, 1e3, 0.3, 0.01], vec![held]);
    let mut grid = open([0.0; 3], cell, [8, 8, 3]);
    grid.walls.iter_mut().flatten().for_each(|wall| wall.kind = WallKind::Slip);
    let state = StartState { energy: Some(2.5), ..StartState::default() };
    let gas = body("gas", (gas(0.0), state), ([0.0; 3], [16, 16, 2], 0.5 * cell), |_| true, Vector::ZERO);
    let mut mpm = start(setup(grid, vec![gas], vec![membrane]));
    // Five passages of sound over the width.
    run(&mut mpm, 4.0, |_, _| {});
    let kinetic = term(&mpm, "kinetic energy: gas");
    assert!(kinetic < 1e-6 * term(&mpm, "stored energy at the start"), "{kinetic}");
    assert_eq!(crossed(&mpm), 0);
}
