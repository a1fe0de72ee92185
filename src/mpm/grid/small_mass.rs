//! Nodes of small mass, which particles barely reach (theory A.4).
//!
//! Mass and momentum of a node are sums with the same weights: p_I/m_I is a mean of its particles' velocities however
//! small its mass is, and a rigid motion stays exact. Forces are sums with slopes. Where a slope doesn't vanish with
//! its shape function, as that of the hat, f_I/m_I has no bound; then the neighbours get the force, and no momentum is
//! lost:
//!
//! ```text
//! m_I ≤ m_cut:   f_J ← f_J + f_I m_J / Σ_K m_K,   f_I ← 0          J, K: the neighbours of I above m_cut
//! ```
//!
//! Among the neighbours is always a node that the same particles reach well.
//!
//! With a particle at the end of a smooth shape function only rounding is left of m_I and p_I; what ghosts take of
//! the rows next to walls leaves them their mass (`ghost/limit.rs`). Such a node moves as its neighbours do on average,
//! v_I = Σ m_J v_J / Σ m_J.

use super::ghost::Ghosted;
use super::{Grid, MassCutoffs, Node, SmallMassNode};
use crate::math::Vector;
use crate::mpm::{Kernel, Transfer};
use crate::parallel::{self, CHUNK};

/// m_cut over the mass of the lightest particle, for shape functions with kinks at the ends of their supports.
const FORCE_CUTOFF: f64 = 1e-6;

/// The same with APIC, whose particles take the slope of the motion of such a node in full. With this number as N, a
/// node of mass N m_p alone has ω² = c²/(h² N) along one axis, and is stable up to a Courant number of 2 √N = ½.
const FORCE_CUTOFF_AFFINE: f64 = 1.0 / 16.0;

/// The same for smooth ones, whose f²/m stays bounded as m vanishes: just above the rounding of a node's mass. Below,
/// nodes take their neighbours' velocity and have no contact.
const ROUNDING: f64 = 1e-15;

impl MassCutoffs {
    /// The cutoffs for the lightest particle of a field [kg].
    pub fn new(kernel: Kernel, transfer: &Transfer, particle: f64) -> Self {
        let rounding = ROUNDING * particle;
        let force = if *transfer == Transfer::Apic { FORCE_CUTOFF_AFFINE } else { FORCE_CUTOFF };
        if kernel.is_smooth() {
            return Self { force: rounding, velocity: rounding, contact: rounding };
        }
        // Its weights are positive wherever their slopes are not zero; only a particle on a wall has folded ones.
        Self { force: force * particle, velocity: 0.0, contact: rounding }
    }
}

/// The neighbours of a node above the mass `least` [kg], with their fractions of the mass of all of them.
fn hosts<const D: usize>(grid: &Grid<D>, nodes: &[Node<D>], node: usize, least: f64) -> Vec<(u32, f64)> {
    let mass = |n: usize| (n as u32, nodes[n].mass);
    let mut hosts: Vec<_> = grid.neighbours(node).map(mass).filter(|&(_, mass)| mass > least).collect();
    let total: f64 = hosts.iter().map(|(_, mass)| mass).sum();
    hosts.iter_mut().for_each(|(_, mass)| *mass /= total);
    hosts
}

/// Finds the nodes of too small a mass for a velocity among those that hold (m, p⁻), and gives them their neighbours'
/// velocity and a mass that is too small to count.
pub fn find<const D: usize>(grid: &Grid<D>, nodes: &mut [Node<D>], cutoffs: &MassCutoffs) -> Vec<SmallMassNode> {
    let small = |node: &Node<D>| node.mass <= cutoffs.velocity && !node.is_nothing();
    let found: Vec<usize> = parallel::collect_some(nodes.len(), CHUNK, |n| small(&nodes[n]).then_some(n));
    let mut all = Vec::with_capacity(found.len());
    for node in found {
        let hosts = hosts(grid, nodes, node, cutoffs.force);
        let velocity: Vector<D> =
            hosts.iter().map(|&(j, fraction)| nodes[j as usize].momentum * (fraction / nodes[j as usize].mass)).sum();
        let mass = ROUNDING * cutoffs.contact;
        nodes[node] = Node { mass, momentum: velocity * mass, ..nodes[node] };
        all.push(SmallMassNode { node: node as u32, hosts });
    }
    all
}

/// The trial momentum of the nodes, Lian (64).
#[derive(Debug, Clone, Copy)]
pub struct TrialMomentum<const D: usize> {
    /// Gravity on the nodes [m/s²].
    pub gravity: Vector<D>,
    /// Step of the momentum [s].
    pub dt: f64,
    /// The masses up to which nodes are small.
    pub cutoffs: MassCutoffs,
}

impl<const D: usize> TrialMomentum<D> {
    /// p̄ ← p⁻ + Δt f with gravity among the forces, which `applied` keeps [N]; nodes of small mass hand the rest of
    /// theirs over.
    pub fn advance(&self, grid: &Grid<D>, nodes: &mut [Node<D>], applied: &mut [Vector<D>]) {
        let &Self { gravity, dt, cutoffs } = self;
        let small = parallel::collect_pair_mut(nodes, applied, |n, node, applied| {
            let left = if node.mass > cutoffs.force { Vector::ZERO } else { std::mem::take(&mut node.force) };
            node.force += gravity * node.mass; // Lian (18)
            node.momentum += node.force * dt; // Lian (64)
            *applied = node.force;
            (left != Vector::ZERO).then_some((n, left))
        });
        for (node, force) in small {
            for (host, fraction) in hosts(grid, nodes, node, cutoffs.force) {
                let (host, force) = (host as usize, force * fraction);
                nodes[host].force += force;
                nodes[host].momentum += force * dt;
                applied[host] += force;
            }
        }
    }
}
