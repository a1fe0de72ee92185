//! Taylor–Green vortices: order in the mesh and in the step, with the default choices.

use super::*;
use crate::pfem2::Pfem2;
use crate::simulation::Solver;
use std::f64::consts::TAU;

/// Vortices of wave length 1 at Re = 100 that start as `wave`, between slip planes: rms error at t = 0.5 and the largest
/// speed.
fn decayed<const D: usize, const N: usize>(
    mesh: Mesh<D, N>,
    wave: impl Fn(Vector<D>) -> Vector<D> + Copy + Sync,
    steps: usize,
) -> [f64; 2] {
    let decay = |t: f64| (-2.0 * TAU * TAU / 100.0 * t).exp();
    let sets = vec![BoundarySetup {
        name: "all".into(),
        facets: mesh.boundary().to_vec(),
        condition: Condition::Slip,
        brings: None,
    }];
    let setup = setup(mesh, sets, physics(vec![fluid("fluid", 1.0, 0.01)], weightless()), |_| 0, wave);
    let mut pfem = Pfem2::new(setup);
    let dt = 0.5 / steps as f64;
    (0..steps).for_each(|k| pfem.step(k as f64 * dt, dt).unwrap());
    let implicit = &pfem.implicit;
    [rms(implicit.mesh.nodes(), &implicit.velocity, |x| wave(x) * decay(0.5)), fastest(&implicit.velocity)]
}

/// One cell of them.
fn planar(cells: usize, steps: usize) -> [f64; 2] {
    let mesh = Mesh::<2, 3>::block(Vector::splat(0.25), Vector::splat(0.75), [cells; 2]).unwrap();
    let wave = |x: Vector<2>| {
        let [x, y] = x.0.map(|c| TAU * c);
        Vector([-x.cos() * y.sin(), x.sin() * y.cos()])
    };
    decayed(mesh, wave, steps)
}

/// max|u| of analytic_misc.csv.
const SPEED: f64 = 0.6738255;

#[test]
fn the_order_is_two_in_mesh_and_step_together() {
    let [coarse, fine] = [planar(12, 15), planar(24, 30)];
    assert!((coarse[0] / fine[0]).log2() > 1.9, "{coarse:?} {fine:?}");
    assert!((fine[1] / SPEED - 1.0).abs() < 0.005, "{fine:?}");
}

#[test]
fn the_order_is_two_in_the_step_alone() {
    let [long, short] = [planar(40, 5), planar(40, 10)];
    assert!((long[0] / short[0]).log2() > 1.9, "{long:?} {short:?}");
}

/// The same vortices in a slab of tetrahedra, with their axis along y.
fn spatial(cells: usize, steps: usize) -> f64 {
    let (low, high) = (Vector([0.25, 0.0, 0.25]), Vector([0.75, 0.5, 0.75]));
    let mesh = Mesh::<3, 4>::block(low, high, [cells; 3]).unwrap();
    let wave = |x: Vector<3>| {
        let [x, z] = [x[0], x[2]].map(|c| TAU * c);
        Vector([-x.cos() * z.sin(), 0.0, x.sin() * z.cos()])
    };
    decayed(mesh, wave, steps)[0]
}

#[test]
fn the_order_is_two_in_three_dimensions() {
    let [coarse, fine] = [spatial(6, 8), spatial(12, 16)];
    assert!((coarse / fine).log2() > 1.9, "{coarse} {fine}");
}
