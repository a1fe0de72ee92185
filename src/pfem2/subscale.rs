//! Orthogonal subscales: the pressure gradient against which the next step is stabilised (theory 5.5).
//!
//! ```text
//! π_i = Σ_{e∋i} V_e (∇p/ρ_e − b̄_e) / Σ_{e∋i} V_e        over the elements with one fluid
//! s   = b + π̄,   in cut elements s = b
//! ```
//!
//! What is projected is what the body force doesn't balance, friction and −Dv/Dt: a fluid stays at rest under a force that changes
//! from step to step. Nodes without an element of one fluid have none of it: fluids at rest stay at rest.

use super::element::Content;
use crate::math::Vector;
use crate::mesh::Mesh;
use rayon::prelude::*;

/// Projects ∇p/ρ − b [m/s²] of the nodal pressures on the nodes; `pure` tells which elements hold one fluid.
pub fn project<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    contents: &[Content<N>],
    pure: impl Fn(usize) -> bool + Sync,
    pressure: impl Fn(usize) -> f64 + Sync,
    force: &[Vector<D>],
    projected: &mut Vec<Vector<D>>,
) {
    let at = |node: usize| {
        let (mut sum, mut volume) = (Vector::ZERO, 0.0);
        for element in mesh.elements_around(node).iter().map(|&e| e as usize).filter(|&e| pure(e)) {
            let (simplex, nodes) = (mesh.simplex(element), &mesh.elements()[element]);
            let slope = (0..N).map(|k| simplex.gradient[k] * pressure(nodes[k] as usize)).sum::<Vector<D>>();
            let balanced = nodes.iter().map(|&i| force[i as usize]).sum::<Vector<D>>() * (simplex.volume / N as f64);
            sum += slope * contents[element].lightness - balanced;
            volume += simplex.volume;
        }
        if volume > 0.0 { sum / volume } else { Vector::ZERO }
    };
    (0..mesh.nodes().len()).into_par_iter().map(at).collect_into_vec(projected);
}
