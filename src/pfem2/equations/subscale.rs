//! Orthogonal subscales: the pressure gradient against which the next step is stabilised (theory F.7.3).
//!
//! ```text
//! π_i = Σ_{e∋i} V_e (∇p/ρ_e − b̄_e) / Σ_{e∋i} V_e        over the elements with one fluid
//! γ_i ← γ_i + r (π_i − γ_i)                              r = 0.3: a mean over about three steps
//! s   = b + π̄                                            in elements with one fluid
//! s   = b + γ̄  over a side's own nodes, and 0.3 τ        on each side of a cut element
//! ```
//!
//! The projected field is the part of the pressure gradient that the body force doesn't balance, friction and −Dv/Dt:
//! a fluid stays at rest under a force that changes from step to step. Along an interface ∇p/ρ differs from side to
//! side, so each fluid has the value of its own nodes. Nodes without an element of one fluid have none: fluids at rest
//! stay at rest.
//!
//! With s = b in cut elements and the whole τ, as the paper has it everywhere, these are stabilised against
//! the acceleration of the flow itself: a disc in a ring of fluid that turn as one body are wrong by 2.5 % after
//! a turn, with a ratio of densities of 1000 by 9.6 %; with γ and τ by 0.4 %, with b and 0.3 τ by 1.3 and 2.5 %, with
//! both by 0.3 %. A wave of 10 elements with a third of the longest step loses 8 instead of 46 % of its energy in 90
//! steps. Neither can be taken to the end: an interface that moves with an extrapolated velocity feeds waves a little,
//! and what cut elements take out must outweigh that. With π of the last step alone, or with 0.1 τ, it doesn't.

use super::dynamic_subscale::DynamicSubscales;
use crate::math::Vector;
use crate::mesh::Mesh;
use crate::parallel;
use crate::pfem2::element::{Content, Stabilisation};

/// Part of the way that γ goes towards π in a step.
const FOLLOW: f64 = 0.3;

/// τ in cut elements, over that in others.
pub const CUT_TAU: f64 = 0.3;

/// The projections at the nodes.
#[derive(Debug, Clone, Default)]
pub struct Subscales<const D: usize> {
    /// π, projected from the last pressures [m/s²]; with the consistent form the viscous force per unit mass (see
    /// `viscous`).
    pub projected: Vec<Vector<D>>,
    /// γ, its mean over some steps [m/s²].
    pub followed: Vec<Vector<D>>,
    /// Subscales with an inertia.
    pub dynamic: DynamicSubscales<D>,
    /// ũ of subscales without, by element [m/s]; none away from solids.
    pub momentary: Vec<Vector<D>>,
}

impl<const D: usize> Subscales<D> {
    /// Subscales of fluids at rest on a mesh.
    pub fn at_rest<const N: usize>(mesh: &Mesh<D, N>, stabilisation: Stabilisation) -> Self {
        let (nodes, elements) = (vec![Vector::ZERO; mesh.nodes().len()], mesh.elements().len());
        let dynamic = DynamicSubscales::at_rest(if stabilisation == Stabilisation::Dynamic { elements } else { 0 });
        Self { projected: nodes.clone(), followed: nodes, dynamic, momentary: Vec::new() }
    }

    /// ũ of an element [m/s].
    pub fn velocity(&self, element: usize) -> Vector<D> {
        self.dynamic.velocity.get(element).or(self.momentary.get(element)).copied().unwrap_or_default()
    }

    /// γ after a step.
    pub fn average(&mut self) {
        for (followed, projected) in self.followed.iter_mut().zip(&self.projected) {
            *followed += (*projected - *followed) * FOLLOW;
        }
    }

    /// γ = π, as after many steps in a flow that doesn't change; subscales with an inertia begin to move.
    pub fn begin_average(&mut self) {
        self.followed.clone_from(&self.projected);
        self.dynamic.begin();
    }
}

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
            sum += slope * contents[element].volume_over_density - balanced;
            volume += simplex.volume;
        }
        if volume > 0.0 { sum / volume } else { Vector::ZERO }
    };
    projected.resize(mesh.nodes().len(), Vector::ZERO);
    parallel::fill(projected, 256, at);
}
