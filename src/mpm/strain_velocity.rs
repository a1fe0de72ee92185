//! The velocity that strains solids where the particles' new velocity is mapped back to the nodes (`average`, `modified-last`).
//!
//! Of the velocity v_I⁺ that forces make on the grid, particles bring ṽ = v⁻ + Δt A a back, with a = f/m the accelerations of the
//! nodes and A = M⁻¹ Σ m_p N_Ip N_Jp, to the particles and back. Of waves as short as a cell A leaves a few hundredths, so that
//! strains by ṽ hardly answer to forces of that shape. With the stresses of a finite strain, whose particles move on through the
//! shape functions, stripes a cell wide then grow in a body at rest. v⁺ would answer to all of f, but also at nodes outside the
//! surface, which few particles reach: what the stresses do there is an error of the quadrature, and a body whose stresses relax
//! until it is gone creeps. And strains by v⁺ damp vibrations that are a few cells long. So solids are strained by
//!
//! ```text
//! w_I = ṽ_I + θ_I (v_I⁺ − ṽ_I),      θ_I = 0.1 min(1, m_I / ρ0 h^D)²
//! ```
//!
//! which hardly differs from ṽ at the outermost nodes. A tenth is enough: stripes grow in thousands of steps, and this takes them
//! in a hundred; twenty times as much holds the same beams, but takes a tenth of the energy of a ball that bounces. Where motion is
//! smooth, v⁺ − ṽ is of third order in the cell.
//!
//! **Books.** Nodes do the work Δt f·½(v⁻ + v⁺), but particles get Δt f·½(v⁻ + ṽ) as kinetic energy, and ṽ or w makes strains.
//! The rest, ½ Δt f·(v⁺ − ṽ) of the forces f of stresses, is work that nobody does: the part that strains don't see
//! either ([`Response::unspent`]) is in no account, and what they see is transfer dissipation, θ Δt² f·(1 − A) a ≥ 0.

use super::grid::{Field, Node};
use super::particles::Body;
use crate::math::Vector;
use crate::parallel;

/// θ where nodes are full.
const SHARE: f64 = 0.1;

/// How nodes answer, θ_I.
#[derive(Debug, Clone, Copy)]
pub(super) struct Response {
    /// 1/(ρ0 h^D) [1/kg]; 0: all strains are by ṽ.
    per_mass: f64,
}

impl Response {
    /// For the solids among the bodies of a field, by the lightest of them; fluids follow their particles alone.
    pub fn of<'a, const D: usize>(bodies: impl Iterator<Item = &'a Body<D>>, cell: f64) -> Self {
        let solids = bodies.filter(|body| body.law.keeps_shape());
        let density = solids.map(|body| body.law.density()).fold(f64::INFINITY, f64::min);
        Self { per_mass: 1.0 / (density * cell.powi(D as i32)) }
    }

    /// True if there are solids.
    pub fn is_any(self) -> bool {
        self.per_mass > 0.0
    }

    /// θ of a node of mass `mass` [kg].
    fn share(self, mass: f64) -> f64 {
        let part = (mass * self.per_mass).min(1.0);
        SHARE * part * part
    }

    /// Makes w of ṽ in `velocity` [m/s]; the nodes hold (m, v⁺, a).
    pub fn blend<const D: usize>(self, nodes: &mut [Node<D>], velocity: &mut [Vector<D>]) {
        parallel::for_each_pair_mut(nodes, velocity, |node, w| {
            if node.mass > 0.0 {
                *w += (node.momentum - *w) * self.share(node.mass);
            }
        });
    }

    /// Σ (½ − s θ) Δt f·(v⁺ − ṽ) [J] of the forces of stresses and tractions, over the nodes of a field that holds (m, v⁺, a)
    /// and ṽ; `part` s of the strains are by w, the steps before and after a force with half of it each. `gravity` [m/s²] and the
    /// step `dt` [s] are those of the momentum.
    pub fn unspent<const D: usize>(self, field: &Field<D>, part: f64, (gravity, dt): (Vector<D>, f64)) -> f64 {
        let Field { nodes, applied, velocity, .. } = field;
        parallel::sum(nodes.len(), |n| {
            let node = &nodes[n];
            if node.mass <= 0.0 {
                return 0.0;
            }
            let force = applied[n] - gravity * node.mass;
            (0.5 - part * self.share(node.mass)) * dt * force.dot(node.momentum - velocity[n])
        })
    }
}
