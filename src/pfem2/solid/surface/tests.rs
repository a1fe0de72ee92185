use super::super::mesh::SolidMesh;
use super::*;
use crate::math::Tensor;
use proptest::prelude::*;
use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_4;

/// Numbers in −1..1 from a seed (a linear congruential sequence).
pub fn number(seed: &mut u64) -> f64 {
    *seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
    (*seed >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

pub fn place<const D: usize>(seed: &mut u64, half: f64) -> Vector<D> {
    Vector::from_fn(|_| half * number(seed))
}

/// A rotation by three angles; in the plane by the first.
pub fn rotation<const D: usize>(angles: [f64; 3]) -> Tensor<D> {
    let about = |axis: usize, angle: f64| {
        let (s, c) = angle.sin_cos();
        let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
        let mut turn = Tensor::<3>::identity();
        (turn[i][i], turn[i][j], turn[j][i], turn[j][j]) = (c, -s, s, c);
        turn
    };
    let mut turn = about(2, angles[0]);
    if D == 3 {
        turn = turn.dot(&about(0, angles[1])).dot(&about(2, angles[2]));
    }
    Tensor::from_fn(|i, j| turn[i][j])
}

/// A box with these half edges about a centre, turned.
pub fn turned_box<const D: usize>(
    half: [f64; D],
    counts: [usize; D],
    center: Vector<D>,
    turn: &Tensor<D>,
) -> SolidMesh<D> {
    let mut mesh = SolidMesh::block(-Vector(half), Vector(half), counts).unwrap();
    mesh.nodes.iter_mut().for_each(|x| *x = center + turn.apply(*x));
    mesh
}

/// Signed distance of a box with these half edges about the origin.
pub fn box_distance<const D: usize>(half: [f64; D], x: Vector<D>) -> f64 {
    let q = Vector::<D>::from_fn(|i| x[i].abs() - half[i]);
    q.map(|q| q.max(0.0)).norm() + q.0.iter().copied().fold(f64::NEG_INFINITY, f64::max).min(0.0)
}

/// A disc of radius one: a square of n × n elements with a ring of n elements on each of its sides.
pub fn disc(n: usize) -> SolidMesh<2> {
    let mut nodes: Vec<Vector<2>> = Vec::new();
    let mut known = BTreeMap::new();
    let mut number = |x: Vector<2>| {
        let key = x.0.map(|c| (c * 1e9).round() as i64);
        *known.entry(key).or_insert_with(|| {
            nodes.push(x);
            nodes.len() as u32 - 1
        })
    };
    let mut elements = Vec::new();
    for block in 0..5 {
        let at = |i: usize, j: usize| {
            let [u, v] = [i, j].map(|index| index as f64 / n as f64 - 1.0);
            if block == 4 {
                return Vector([u, v]) * 0.5;
            }
            let fraction = 0.5 * (u + 1.0);
            let (s, c) = (FRAC_PI_4 * v).sin_cos();
            let side = Vector([0.5, 0.5 * v]) * (1.0 - fraction) + Vector([c, s]) * fraction;
            (0..block).fold(side, |x, _| Vector([-x[1], x[0]]))
        };
        for (i, j) in (0..n * n).map(|k| (2 * (k % n), 2 * (k / n))) {
            elements.push((0..9).map(|a| number(at(i + a % 3, j + a / 3))).collect());
        }
    }
    SolidMesh::new(nodes, elements).unwrap()
}

/// A plane mesh drawn out from −half to half along the third axis in `count` layers.
fn drawn_out(plane: &SolidMesh<2>, half: f64, count: usize) -> SolidMesh<3> {
    let stride = plane.nodes.len() as u32;
    let layer = |k: usize| {
        let z = half * (k as f64 / count as f64 - 1.0);
        plane.nodes.iter().map(move |x| Vector([x[0], x[1], z]))
    };
    let element = |k: usize| {
        plane.elements.iter().map(move |nodes| {
            (0..3).flat_map(|c| nodes.iter().map(move |node| node + (2 * k + c) as u32 * stride)).collect()
        })
    };
    SolidMesh::new((0..=2 * count).flat_map(layer).collect(), (0..count).flat_map(element).collect()).unwrap()
}

pub fn surface_of<const D: usize>(mesh: &SolidMesh<D>) -> SolidSurface<D> {
    SolidSurface::new(&[(mesh, 0)], &mesh.nodes)
}

/// Σ N_a x_a of weights.
pub fn interpolate<const D: usize>(weights: &NodeWeights, values: &[Vector<D>]) -> Vector<D> {
    weights.iter().map(|(node, weight)| values[*node as usize] * *weight).sum()
}

fn check_box<const D: usize>(half: [f64; D], counts: [usize; D], angles: [f64; 3], seed: u64) {
    let (turn, center, mut seed) = (rotation(angles), Vector::splat(0.3), seed);
    let mesh = turned_box(half, counts, center, &turn);
    let surface = surface_of(&mesh);
    for _ in 0..60 {
        let x = place::<D>(&mut seed, 2.5);
        let exact = box_distance(half, x);
        let there = center + turn.apply(x);
        let point = surface.nearest(there).unwrap();
        assert!((point.distance - exact).abs() < 1e-11, "{} {exact}", point.distance);
        assert!(((there - point.position).norm() - exact.abs()).abs() < 1e-11);
        assert!((interpolate(&point.weights, &mesh.nodes) - point.position).norm() < 1e-11);
        assert!((point.normal.norm() - 1.0).abs() < 1e-12);
        let inside = surface.locate_inside(there);
        assert_eq!(inside.is_some(), exact < 0.0);
        assert!(inside.is_none_or(|weights| (interpolate(&weights, &mesh.nodes) - there).norm() < 1e-10));
        assert!(exact > 0.0 || surface.is_near(there, 0.0));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn distances_of_turned_boxes_are_exact(angles in prop::array::uniform3(0.0..6.3), seed in 0..1000u64) {
        check_box([1.0, 0.4], [5, 2], angles, seed);
        check_box([1.0, 0.03], [4, 1], angles, seed);
        check_box([1.0, 0.4, 0.6], [2, 1, 2], angles, seed);
        check_box([1.0, 0.02, 0.6], [2, 1, 1], angles, seed);
    }
}

/// At corners, edges and nodes themselves, and on the continuation of sides, where nearest points lie between facets.
#[test]
fn distances_at_the_corners_of_boxes_are_exact() {
    let surface = surface_of(&SolidMesh::<3>::block(Vector([-1.0; 3]), Vector([1.0; 3]), [2; 3]).unwrap());
    let plane = surface_of(&SolidMesh::<2>::block(Vector([-1.0; 2]), Vector([1.0; 2]), [2; 2]).unwrap());
    let steps = [-2.0, -1.0, -0.5, 0.0, 0.5, 1.0, 1.5];
    for (x, y) in steps.into_iter().flat_map(|x| steps.map(|y| (x, y))) {
        let exact = box_distance([1.0; 2], Vector([x, y]));
        assert!((plane.distance(Vector([x, y])) - exact).abs() < 1e-14, "{x} {y}");
        for z in steps {
            let exact = box_distance([1.0; 3], Vector([x, y, z]));
            assert!((surface.distance(Vector([x, y, z])) - exact).abs() < 1e-14, "{x} {y} {z}");
        }
    }
}

/// Quadratic facets leave the circle that their nodes lie on in fourth order of their length.
#[test]
fn distances_of_a_disc_and_a_cylinder_converge_to_those_of_the_circle() {
    let error = |n: usize| {
        let (mesh, mut seed) = (disc(n), 3);
        let surface = surface_of(&mesh);
        let mut most = 0.0_f64;
        for _ in 0..300 {
            let x = place::<2>(&mut seed, 1.6);
            let distance = surface.distance(x);
            assert_eq!(distance < 0.0, surface.locate_inside(x).is_some());
            most = most.max((distance - (x.norm() - 1.0)).abs());
        }
        most
    };
    let [coarse, fine] = [error(2), error(4)];
    assert!(coarse < 2e-3 && fine < coarse / 12.0, "{coarse} {fine}");
    let (mesh, mut seed) = (drawn_out(&disc(4), 0.5, 1), 11);
    let surface = surface_of(&mesh);
    for _ in 0..200 {
        let x = place::<3>(&mut seed, 1.4);
        let exact = box_distance([1.0, 0.5], Vector([x[0].hypot(x[1]), x[2]]));
        let distance = surface.distance(x);
        assert!((distance - exact).abs() < 2.0 * fine, "{distance} {exact}");
        if let Some(weights) = surface.locate_inside(x) {
            assert!((interpolate(&weights, &mesh.nodes) - x).norm() < 1e-10);
        }
    }
}

/// An L of three squares: its distance is that of its six sides.
#[test]
fn distances_at_a_concave_corner_are_exact() {
    let corners = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]].map(Vector::<2>);
    let mut square = SolidMesh::<2>::block(Vector([0.0; 2]), Vector([2.0; 2]), [2, 2]).unwrap();
    square.elements.pop();
    let mesh = SolidMesh::new(square.nodes, square.elements).unwrap();
    let surface = surface_of(&mesh);
    let mut seed = 5;
    for _ in 0..1000 {
        let x = place::<2>(&mut seed, 1.5) + Vector([1.0, 1.0]);
        let side = |k: usize| {
            let (a, b) = (corners[k], corners[(k + 1) % 6]);
            let t = ((x - a).dot(b - a) / (b - a).norm_squared()).clamp(0.0, 1.0);
            (a + (b - a) * t - x).norm()
        };
        let is_inside = x[0] > 0.0 && x[1] > 0.0 && (x[0] < 2.0 && x[1] < 1.0 || x[0] < 1.0 && x[1] < 2.0);
        let exact = (0..6).map(side).fold(f64::INFINITY, f64::min) * if is_inside { -1.0 } else { 1.0 };
        assert!((surface.distance(x) - exact).abs() < 1e-12);
    }
}

/// Of two solids side by side the nearest counts; where they overlap, a place in one of them is inside.
#[test]
fn the_nearest_of_two_solids_counts() {
    let (left, right) = (disc(4), turned_box([0.5, 0.5], [2, 2], Vector([1.52, 0.0]), &Tensor::identity()));
    let first = left.nodes.len() as u32;
    let positions = [left.nodes.clone(), right.nodes.clone()].concat();
    let surface = SolidSurface::new(&[(&left, 0), (&right, first)], &positions);
    let mut seed = 9;
    for _ in 0..300 {
        let x = place::<2>(&mut seed, 2.2);
        let each = [x.norm() - 1.0, box_distance([0.5; 2], x - Vector([1.52, 0.0]))];
        let point = surface.nearest(x).unwrap();
        assert!((point.distance - each[0].min(each[1])).abs() < 1e-4);
        assert_eq!(point.solid, u32::from(each[1] < each[0]), "{each:?}");
        assert!((interpolate(&point.weights, &positions) - point.position).norm() < 1e-12);
    }
    let over = SolidSurface::new(&[(&left, 0), (&left, first)], &[left.nodes.clone(), left.nodes.clone()].concat());
    assert!((over.distance(Vector([0.9, 0.0])) + 0.1).abs() < 1e-4);
}

#[test]
fn without_solids_or_with_positions_that_are_not_finite_there_is_no_nearest_point() {
    assert_eq!(SolidSurface::<2>::new(&[], &[]).distance(Vector([0.0; 2])), f64::INFINITY);
    let mut mesh = SolidMesh::<2>::block(Vector([0.0; 2]), Vector([1.0; 2]), [1, 1]).unwrap();
    mesh.nodes.fill(Vector([f64::NAN; 2]));
    let surface = surface_of(&mesh);
    assert!(surface.nearest(Vector([0.5; 2])).is_none() && !surface.is_near(Vector([0.5; 2]), 0.0));
    assert!(surface_of(&disc(1)).nearest(Vector([f64::NAN; 2])).is_none());
}
