//! Viscous forces in the fluid part of a cut element, for the consistent stabilisation, and their power (theory F.7.2,
//! F.13, J.3).

use super::fluid_part::{PartGeometry, parts};
use crate::math::Vector;
use crate::mesh::Mesh;
use crate::pfem2::cut_element::Medium;
use crate::pfem2::element::shear::shear_rate;
use crate::pfem2::element::viscous_forces;
use crate::pfem2::solid::cut::{CutBySolid, CutPoint};

/// Viscous force on each node of an element [N], and its part of the mass of the fluid there [kg].
pub type CutForces<const D: usize, const N: usize> = [(Vector<D>, f64); N];

/// Viscous forces of the fluid part of a cut element on the nodes of the element; `velocity` [m/s] of these and
/// of nodes of solids.
pub fn cut_forces<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    cut: &CutBySolid<N>,
    points: &[CutPoint<D>],
    medium: Medium,
    velocity: [&dyn Fn(usize) -> Vector<D>; 2],
) -> CutForces<D, N> {
    let own: Vec<&CutPoint<D>> = cut.points.iter().map(|&point| &points[point as usize]).collect();
    let [of_node, of_solid] = velocity;
    let nodes = &mesh.elements()[cut.element as usize];
    let mut sum = [(Vector::ZERO, 0.0); N];
    for PartGeometry { simplex, vertices, .. } in parts(mesh, cut, &own, &[1.0; N]) {
        let at = |k: usize| match nodes.get(k) {
            Some(&node) => of_node(node as usize),
            None => own[k - N].velocity(of_node, of_solid),
        };
        let forces = viscous_forces(&simplex, medium.viscosity, &vertices.map(at));
        for (&k, force) in vertices.iter().zip(forces).filter(|(k, _)| **k < N) {
            sum[k].0 += force;
            sum[k].1 += medium.density * simplex.volume / N as f64;
        }
    }
    sum
}

/// ∫2 d:d over the fluid part of a cut element [W/(Pa s)]; `velocity` [m/s] of its nodes and of nodes of solids.
pub fn cut_power<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    cut: &CutBySolid<N>,
    points: &[CutPoint<D>],
    [of_node, of_solid]: [&dyn Fn(usize) -> Vector<D>; 2],
) -> f64 {
    let own: Vec<&CutPoint<D>> = cut.points.iter().map(|&point| &points[point as usize]).collect();
    let nodes = &mesh.elements()[cut.element as usize];
    let at = |vertex: usize| match nodes.get(vertex) {
        Some(&node) => of_node(node as usize),
        None => own[vertex - N].velocity(of_node, of_solid),
    };
    let of_part = |part: PartGeometry<D, N>| {
        part.simplex.volume * shear_rate(&part.simplex.gradient, &part.vertices.map(at)).powi(2)
    };
    parts(mesh, cut, &own, &[1.0; N]).into_iter().map(of_part).sum()
}
