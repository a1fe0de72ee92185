//! Orthogonal subscales: the pressure gradient against which the next step is stabilised (theory 5.5).
//!
//! ```text
//! π_i = Σ_{e∋i} V_e ∇p/ρ_e / Σ_{e∋i} V_e        over the elements with one fluid
//! ```
//!
//! ∇p/ρ = b − Dv/Dt (+ viscous forces) is continuous across an interface, unlike ∇p, so one value serves both fluids.
//! Nodes without such an element keep the body force: fluid at rest stays at rest.

use super::element::Content;
use crate::math::Vector;
use crate::mesh::Mesh;
use rayon::prelude::*;

/// Projects ∇p/ρ [m/s²] of the nodal pressures on the nodes; `pure` tells which elements hold one fluid.
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
            sum += slope * contents[element].lightness;
            volume += simplex.volume;
        }
        if volume > 0.0 { sum / volume } else { force[node] }
    };
    (0..mesh.nodes().len()).into_par_iter().map(at).collect_into_vec(projected);
}
