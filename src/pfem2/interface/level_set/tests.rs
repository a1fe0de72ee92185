//! Distances, volumes and turning bodies against closed forms.

use super::*;
use crate::pfem2::boundary::BoundaryKind;
use crate::pfem2::particles::convect::{Flow, Streamlines};
use crate::pfem2::solid::cut::SolidCut;
use crate::pfem2::solid::mesh::SolidMesh;
use crate::pfem2::solid::surface::SolidSurface;
use std::f64::consts::{PI, TAU};

fn square(cells: usize) -> Mesh<2, 3> {
    Mesh::block(Vector::ZERO, Vector::splat(1.0), [cells; 2]).unwrap()
}

fn circle(x: Vector<2>) -> f64 {
    (x - Vector([0.5, 0.75])).norm() - 0.15
}

fn nodal<const D: usize, const N: usize>(mesh: &Mesh<D, N>, phi: impl Fn(Vector<D>) -> f64) -> Vec<f64> {
    mesh.nodes().iter().map(|&x| phi(x)).collect()
}

#[test]
fn distances_from_a_circle_converge_with_the_square_of_the_mesh() {
    let error = |cells: usize| {
        let mesh = square(cells);
        let bent = nodal(&mesh, |x| circle(x) * (1.0 + x[0]));
        let distances = InterfacePolygons::new(&FluidRegion::whole(&mesh), &bent).distances(&mesh, 0.1);
        let each = mesh.nodes().iter().zip(&distances);
        each.map(|(&x, d)| (circle(x).abs().min(0.1) - d).abs()).fold(0.0, f64::max)
    };
    let (coarse, fine) = (error(16), error(64));
    assert!((coarse / fine).log2() / 2.0 > 1.6 && fine < 1e-3, "{coarse:e} {fine:e}");
}

#[test]
fn surface_and_volume_of_a_ball_converge() {
    let error = |cells: usize| {
        let mesh = Mesh::<3, 4>::block(Vector::ZERO, Vector::splat(1.0), [cells; 3]).unwrap();
        let ball = nodal(&mesh, |x| (x - Vector::splat(0.51)).norm() - 0.3);
        let (area, volume) = (0.36 * PI, 0.036 * PI);
        [
            InterfacePolygons::new(&FluidRegion::whole(&mesh), &ball).area() / area - 1.0,
            negative_volume(&FluidRegion::whole(&mesh), &ball) / volume - 1.0,
        ]
    };
    let (coarse, fine) = (error(8), error(16));
    for i in 0..2 {
        assert!(fine[i].abs() < 0.03 && (coarse[i] / fine[i]).abs().log2() > 1.5, "{coarse:?} {fine:?}");
    }
}

#[test]
fn the_shift_gives_the_volume_to_the_last_digits() {
    let mesh = square(80);
    let mut level = nodal(&mesh, circle);
    let volume = PI * 0.16 * 0.16;
    let shift = shift_to_volume(&FluidRegion::whole(&mesh), &mut level, volume, 0.1);
    let found = negative_volume(&FluidRegion::whole(&mesh), &level);
    assert!((found / volume - 1.0).abs() < 1e-13, "{found} {volume}");
    // A circle of radius 0.15 grows by 0.01, and what the polygon cuts off.
    assert!((shift + 0.01).abs() < 2e-4, "{shift}");
}

/// Turns the notched disc of Zalesak by one turn in `steps` steps and returns φ before and after.
fn turn(mesh: &Mesh<2, 3>, steps: usize, phi: impl Fn(Vector<2>) -> f64 + Sync) -> (Vec<f64>, LevelSet) {
    let velocity: Vec<_> = mesh.nodes().iter().map(|x| Vector([0.5 - x[1], x[0] - 0.5]) * TAU).collect();
    let boundary = vec![BoundaryKind::Wall; mesh.boundary().len()];
    let mut particles = Particles::seed(mesh, 5, |x| Some(u8::from(phi(x) < 0.0)), |_| Vector::ZERO);
    let mut set = LevelSet::new(mesh, 1, &phi, &mut particles);
    let start = set.level.clone();
    for _ in 0..steps {
        let flow = Flow { velocity: &velocity, boundary: &boundary, projectiles: None };
        particles.convect(&Streamlines::new(mesh, &flow), 1.0 / steps as f64);
        set.update(&FluidRegion::whole(mesh), &mut particles, &[]);
    }
    (start, set)
}

#[test]
fn a_disc_keeps_its_shape_and_volume_over_a_turn() {
    let mesh = square(40);
    let (start, set) = turn(&mesh, 20, circle);
    let away = start.iter().zip(&set.level).filter(|(a, _)| a.abs() < 0.02).map(|(a, b)| (a - b).abs());
    let largest = away.fold(0.0, f64::max);
    assert!(largest < 0.1 / 40.0, "{largest}");
    let volume = PI * 0.15 * 0.15;
    let kept = negative_volume(&FluidRegion::whole(&mesh), &set.level) / volume;
    assert!((kept - 1.0).abs() < 0.01, "{kept}");
}

#[test]
fn zalesaks_disc_loses_less_than_two_percent_of_its_area() {
    let notched = |x: Vector<2>| {
        let slot = ((x[0] - 0.5).abs() - 0.025).max(x[1] - 0.85);
        circle(x).max(-slot)
    };
    let mesh = square(50);
    let (start, set) = turn(&mesh, 20, notched);
    let wrong = 0.5 * start.iter().zip(&set.level).map(|(a, b)| (a.signum() - b.signum()).abs()).sum::<f64>();
    let inside = start.iter().filter(|phi| **phi < 0.0).count() as f64;
    assert!(wrong / inside < 0.02, "{wrong} of {inside}");
}

#[test]
fn signs_give_the_pseudo_level_set_of_the_source() {
    assert_eq!(pseudo(&[1.0, 0.5, 0.25]), [-1.0, 0.0, 0.5]);
}

/// Over a measurement, too: at rest, an interface that moved would set two fluids in motion.
fn stays<const D: usize, const N: usize>(mesh: &Mesh<D, N>, plane: impl Fn(Vector<D>) -> f64 + Sync) {
    let mut particles = Particles::seed(mesh, 3, |x| Some(u8::from(plane(x) >= 0.0)), |_| Vector::ZERO);
    let mut set = LevelSet::new(mesh, 0, &plane, &mut particles);
    for step in 0..25 {
        set.update(&FluidRegion::whole(mesh), &mut particles, &[]);
        let near = mesh.nodes().iter().zip(&set.level).filter(|(x, _)| plane(**x).abs() < 0.1);
        let worst = near.map(|(x, phi)| (phi - plane(*x)).abs()).fold(0.0, f64::max);
        assert!(worst < 1e-13, "{step}: {worst:e}");
    }
}

#[test]
fn a_plane_at_rest_stays_where_it_is_to_the_last_digits() {
    let flat = square(20);
    for angle in [0.0, 17.0, 30.0, 45.0, 63.0, 90.0, 140.0] {
        let normal = Vector([f64::to_radians(angle).cos(), f64::to_radians(angle).sin()]);
        stays(&flat, |x| (x - Vector([0.4871, 0.5213])).dot(normal));
    }
    let full = Mesh::<3, 4>::block(Vector::ZERO, Vector::splat(1.0), [8; 3]).unwrap();
    stays(&full, |x| (x - Vector([0.4871, 0.5213, 0.4477])).dot(Vector([2.0, -1.0, 2.0]) / 3.0));
}

/// On a line of the mesh, where rounding decides about the sides of nodes: depths that change by 1e-14 m in a step leave
/// the plane where it is over ten measurements.
#[test]
fn a_plane_on_a_line_of_the_mesh_stays_there_to_rounding() {
    let mesh = square(20);
    let plane = |x: Vector<2>| x[1] - 0.5;
    let mut particles = Particles::seed(&mesh, 3, |x| Some(u8::from(plane(x) >= 0.0)), |_| Vector::ZERO);
    let mut set = LevelSet::new(&mesh, 0, plane, &mut particles);
    for step in 0..100 {
        for (p, depth) in particles.depth.iter_mut().enumerate() {
            *depth += 1e-14 * (((p * 7919 + step * 31) % 1009) as f64 / 504.5 - 1.0);
        }
        set.update(&FluidRegion::whole(&mesh), &mut particles, &[]);
        let near = mesh.nodes().iter().zip(&set.level).filter(|(x, _)| plane(**x).abs() < 0.1);
        let worst = near.map(|(x, phi)| (phi - plane(*x)).abs()).fold(0.0, f64::max);
        assert!(worst < 1e-10, "{step}: {worst:e}");
    }
}

/// φ has other slopes in the cut elements than on either side, as a flow that bends at the nodes makes them.
#[test]
fn a_stretched_plane_is_measured_without_moving() {
    let mesh = square(20);
    let height = |x: Vector<2>| x[1] - 0.5213;
    let stretched = |x: Vector<2>| match x[1] {
        y if y < 0.5 => 1.5 * (y - 0.5) - 2.2 * 0.0213,
        y if y > 0.55 => 1.4 * (y - 0.55) + 2.2 * 0.0287,
        y => 2.2 * (y - 0.5213),
    };
    let mut particles = Particles::seed(&mesh, 3, |x| Some(u8::from(height(x) >= 0.0)), |_| Vector::ZERO);
    let mut set = LevelSet::new(&mesh, 0, stretched, &mut particles);
    set.measure(&FluidRegion::whole(&mesh), &mut particles);
    for (depth, x) in particles.depth.iter().zip(&particles.position).filter(|(_, x)| height(**x).abs() < 0.1) {
        assert!((depth - height(*x).abs()).abs() < 1e-13, "{x:?}: {depth}");
    }
}

#[test]
fn distances_to_a_circle_cut_by_a_wall_converge() {
    let behind = |x: Vector<2>| (x - Vector([0.5, -0.1])).norm() - 0.3;
    let error = |cells: usize| {
        let mesh = square(cells);
        let band = 4.0 / cells as f64;
        let distances =
            InterfacePolygons::new(&FluidRegion::whole(&mesh), &nodal(&mesh, behind)).distances(&mesh, band);
        let each = mesh.nodes().iter().zip(&distances).filter(|(x, _)| behind(**x).abs() < band);
        each.map(|(&x, d)| (behind(x).abs() - d).abs()).fold(0.0, f64::max)
    };
    let (coarse, fine) = (error(16), error(64));
    assert!((coarse / fine).log2() / 2.0 > 1.6 && fine < 2e-3, "{coarse:e} {fine:e}");
}

/// A plate ends below a step; the plane of the interface that meets the step's side comes out of its top.
#[test]
fn distances_behind_a_corner_count_from_the_end_of_the_interface() {
    let block = Mesh::<2, 3>::block(Vector::ZERO, Vector([2.0, 1.0]), [20, 10]).unwrap();
    let free = |nodes: &&[u32; 3]| {
        let center = nodes.iter().map(|&node| block.nodes()[node as usize]).sum::<Vector<2>>() / 3.0;
        center[0] < 1.0 || center[1] > 0.5
    };
    let elements = block.elements().iter().filter(free).copied().collect();
    let mesh = Mesh::new(block.nodes().to_vec(), elements).unwrap();
    // From (0.613, 0) up to the step's side at (1, 0.387); its line comes out of the top at (1.113, 0.5).
    let plane = |x: Vector<2>| (x[1] - x[0] + 0.613) * 0.5f64.sqrt();
    let level = nodal(&mesh, |x| if x[1] > 0.5 - 1e-9 { 0.2 } else { plane(x) });
    let distances = InterfacePolygons::new(&FluidRegion::whole(&mesh), &level).distances(&mesh, 0.4);
    let end = Vector([1.0, 0.387]);
    for (x, d) in mesh.nodes().iter().zip(distances).filter(|(x, _)| x[0] > 1.05 && x[1] > 0.5 - 1e-9) {
        let exact = (*x - end).norm().min(0.4);
        assert!((d - exact).abs() < 1e-9, "{x:?}: {d} {exact}");
    }
}

/// A block in water and air, in which φ has been continued from its top, too: distances above it are those from the
/// plane of the interface beside it, which goes on inside.
#[test]
fn the_interface_goes_on_inside_of_solids_as_it_meets_them() {
    let mesh = square(20);
    let block = SolidMesh::block(Vector([-0.1, 0.21]), Vector([0.62, 0.79]), [2; 2]).unwrap();
    let cut = SolidCut::new(&mesh, &SolidSurface::new(&[(&block, 0)], &block.nodes), &[]);
    let region = FluidRegion::new(&mesh, Some(&cut));
    let inside = |x: Vector<2>| x[0] < 0.57 && (0.26..0.74).contains(&x[1]);
    let plane = |x: Vector<2>| x[1] - 0.513 - 0.1 * (x[0] - 0.62);
    let level = nodal(&mesh, |x| if inside(x) { x[1] - 0.72 } else { plane(x) });
    let distances = InterfacePolygons::new(&region, &level).distances(&mesh, 2.0);
    for (x, d) in mesh.nodes().iter().zip(distances).filter(|(x, _)| x[1] > 0.8) {
        assert!((d - plane(*x).abs() / 1.01f64.sqrt()).abs() < 1e-12, "{x:?}: {d}");
    }
}
