//! Films between two solids, and in slots of one.

use super::super::mesh::SolidMesh;
use super::super::mesh::shapes::slotted;
use super::super::surface::tests::{disc, rotation, turned_box};
use super::tests::check_facets;
use super::*;
use crate::mesh::Simplex;
use std::f64::consts::PI;

/// A mesh of [−1, 1]ᴰ [m] cut by solids.
fn cut_by<const D: usize, const N: usize>(cells: usize, solids: &[&SolidMesh<D>]) -> (Mesh<D, N>, SolidCut<D, N>) {
    let mesh = Mesh::block(Vector::splat(-1.0), Vector::splat(1.0), [cells; D]).unwrap();
    let (mut first, mut positions) = (Vec::new(), Vec::new());
    for solid in solids {
        first.push((*solid, positions.len() as u32));
        positions.extend(&solid.nodes);
    }
    let surface = SolidSurface::new(&first, &positions);
    let cut = SolidCut::new(&mesh, &surface, &[]);
    (mesh, cut)
}

/// The larger of the forces that a pressure of 1 Pa everywhere has on two solids [N], and the number of elements
/// with a film between them.
fn force_of_an_even_pressure<const D: usize, const N: usize>(cells: usize, solids: [&SolidMesh<D>; 2]) -> (f64, usize) {
    let (mesh, cut) = cut_by::<D, N>(cells, &solids);
    check_facets(&mesh, &cut);
    let (second, mut forces) = (solids[0].nodes.len() as u32, [Vector::<D>::ZERO; 2]);
    for element in &cut.elements {
        for part in &element.parts {
            let simplex = Simplex::new(cut.corners(&mesh, element, part)).unwrap();
            assert!(simplex.volume > 0.0);
            for (vertex, gradient) in part.vertices.iter().zip(simplex.gradient) {
                let Vertex::Point(k) = vertex else { continue };
                for (node, weight) in &cut.points[element.points[usize::from(*k)] as usize].weights {
                    forces[usize::from(*node >= second)] += gradient * (simplex.volume * weight);
                }
            }
        }
    }
    let is_in_film = |point: &u32| cut.points[*point as usize].film_edge.is_some();
    let films = cut.elements.iter().filter(|element| element.points.iter().any(is_in_film)).count();
    (forces.iter().map(|force| force.norm()).fold(0.0, f64::max), films)
}

/// Two boxes that face each other over a gap of some elements of the mesh, turned by an angle.
fn boxes<const D: usize>(half: [f64; D], gap: f64, cells: usize, angle: f64) -> [SolidMesh<D>; 2] {
    let turn = rotation([angle, 0.7 * angle, 0.0]);
    let away = half[0] + gap / cells as f64;
    [-1.0, 1.0].map(|side| {
        let center = turn.apply(Vector::unit(0) * (side * away)) + Vector::from_fn(|axis| 0.053 - 0.032 * axis as f64);
        turned_box(half, [2; D], center, &turn)
    })
}

/// The boundary of the fluid is closed around each solid, however near the other is: an even pressure has no force on
/// either. (Without films, in elements without a node between them, it pressed them together.)
#[test]
fn an_even_pressure_has_no_force_on_solids_beside_each_other() {
    for (gap, angle) in [(0.6, 0.0), (0.3, 0.0), (0.1, 0.0), (0.5, 0.3), (0.5, 0.7), (0.3, 1.1), (0.1, 0.3)] {
        let [left, right] = boxes([0.27, 0.31], gap, 20, angle);
        let (force, films) = force_of_an_even_pressure::<2, 3>(20, [&left, &right]);
        assert!(force < 1e-13 && films > 2, "plane, {gap} {angle}: {force:e} {films}");
    }
    for (gap, angle) in [(0.5, 0.3), (0.5, 0.7), (0.3, 1.1)] {
        let [left, right] = boxes([0.27, 0.31, 0.35], gap, 10, angle);
        let (force, films) = force_of_an_even_pressure::<3, 4>(10, [&left, &right]);
        assert!(force < 1e-13 && films > 20, "space, {gap} {angle}: {force:e} {films}");
    }
    for gap in [0.9, 0.5, 0.3, 0.1, 0.03] {
        let [left, right] = [-1.0, 1.0].map(|side| {
            let mut own = disc(6);
            own.nodes.iter_mut().for_each(|x| *x = *x * 0.3 + Vector([0.05 + side * (0.3 + 0.05 * gap), 0.013]));
            own
        });
        let (force, films) = force_of_an_even_pressure::<2, 3>(20, [&left, &right]);
        assert!(force < 1e-13 && films > 0, "discs, {gap}: {force:e} {films}");
    }
}

/// The film between plane sides that lie off the lines of the mesh is as wide as it is, along all of its length.
#[test]
fn a_film_has_the_volume_between_the_sides() {
    let blocks = [[-0.5, 0.02], [0.05, 0.5]]
        .map(|[lower, upper]| SolidMesh::block(Vector([lower, -1.2]), Vector([upper, 1.2]), [2, 6]).unwrap());
    let (mesh, cut) = cut_by::<2, 3>(20, &[&blocks[0], &blocks[1]]);
    let volume = cut.volume_inside(&mesh);
    assert!((volume - 2.0 * (0.52 + 0.45)).abs() < 1e-6, "{volume}");
}

/// The film between boxes whose ends lie on a line of the mesh goes on to that line, where it opens, also if the middle of
/// an edge there lies in one of them; and no node of such thick boxes has a pressure of each side. (The last elements
/// before the line held nothing: the film had no way out, and what it closed off had no volume to change.)
#[test]
fn a_film_opens_where_solids_end_on_a_line_of_the_mesh() {
    for off in [-1e-6, 0.0, 1e-6] {
        let lower = SolidMesh::block(Vector([-0.4, -0.6]), Vector([0.4, -0.05 + off]), [4, 4]).unwrap();
        let upper = SolidMesh::block(Vector([-0.4, 0.0]), Vector([0.4, 0.5]), [4, 4]).unwrap();
        let (mesh, cut) = cut_by::<2, 3>(20, &[&lower, &upper]);
        let outside: f64 = (0..mesh.elements().len()).map(|e| cut.volume_outside(&mesh, e)).sum();
        let exact = 4.0 - 0.8 * (1.05 + off);
        assert!((outside - exact).abs() < 1e-4, "{off:e}: {outside} {exact}");
        assert!(cut.elements.iter().all(|element| element.nodes_of_two_sides().next().is_none()), "{off:e}");
    }
}

/// The force of an even pressure of 1 Pa on a solid [N], and the number of elements with a film between two of its
/// sides.
fn force_on_one<const D: usize, const N: usize>(cells: usize, solid: &SolidMesh<D>) -> (f64, usize) {
    let mesh = Mesh::<D, N>::block(Vector::splat(-1.0), Vector::splat(1.0), [cells; D]).unwrap();
    let surface = SolidSurface::new(&[(solid, 0)], &solid.nodes);
    let cut = SolidCut::new(&mesh, &surface, &[]);
    check_facets(&mesh, &cut);
    let mut force = Vector::<D>::ZERO;
    for element in &cut.elements {
        for part in &element.parts {
            let simplex = Simplex::new(cut.corners(&mesh, element, part)).unwrap();
            for (vertex, gradient) in part.vertices.iter().zip(simplex.gradient) {
                force += if let Vertex::Point(_) = vertex { gradient * simplex.volume } else { Vector::ZERO };
            }
        }
    }
    let is_in_film = |point: &u32| cut.points[*point as usize].film_edge.is_some();
    let films = cut.elements.iter().filter(|element| element.points.iter().any(is_in_film)).count();
    (force.norm(), films)
}

/// So it is in a narrow slot of one solid.
#[test]
fn an_even_pressure_has_no_force_on_a_solid_with_a_narrow_slot() {
    for gap in [0.6, 0.3, 0.1, 0.01] {
        let slot = |cells: usize| [0.013, 0.013 + gap * 2.0 / cells as f64];
        let plane = slotted([Vector([-0.45, -0.37]), Vector([0.51, 0.43])], slot(20));
        let (force, films) = force_on_one::<2, 3>(20, &plane);
        assert!(force < 1e-13 && films > 2, "plane, {gap}: {force:e} {films}");
        let space = slotted([Vector([-0.45, -0.37, -0.41]), Vector([0.51, 0.43, 0.39])], slot(10));
        let (force, films) = force_on_one::<3, 4>(10, &space);
        assert!(force < 1e-13 && films > 10, "space, {gap}: {force:e} {films}");
    }
}

/// Nodes inside of a plate 1.2 elements thick have fluid on both sides, and those of three discs that
/// nearly touch don't, though the pocket between them is parted from the fluid around.
#[test]
fn only_nodes_in_thin_solids_have_two_sides() {
    let has_two_sides = |cut: &SolidCut<2, 3>| cut.elements.iter().any(|element| element.two_sided.contains(&true));
    let plate = turned_box([0.6, 0.06], [8, 1], Vector([0.013, 0.021]), &rotation([0.2, 0.0, 0.0]));
    let (_, cut) = cut_by::<2, 3>(20, &[&plate]);
    assert!(has_two_sides(&cut));
    let third = |k: usize, angle: f64, gap: f64| {
        let angle = angle + 2.0 / 3.0 * PI * k as f64;
        let center = Vector([angle.cos(), angle.sin()]) * ((0.6 + gap) / 3_f64.sqrt());
        let mut own = disc(6);
        own.nodes.iter_mut().for_each(|x| *x = *x * 0.3 + center + Vector([0.013, 0.021]));
        own
    };
    for (gap, k) in [0.001, 0.01, 0.03].into_iter().flat_map(|gap| (0..20).map(move |k| (gap, k))) {
        let angle = 0.1 * f64::from(k);
        let discs: [SolidMesh<2>; 3] = std::array::from_fn(|k| third(k, angle, gap));
        let (_, cut) = cut_by::<2, 3>(20, &discs.each_ref());
        assert!(!has_two_sides(&cut), "{angle} {gap}");
    }
}
