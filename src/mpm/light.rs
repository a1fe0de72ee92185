//! Nodes that particles barely reach (theory A.4).
//!
//! Mass and momentum of a node are sums with the same weights: p_I/m_I is a mean of its particles' velocities however light
//! the node is, and a rigid motion stays exact. Forces are sums with slopes. Where a slope doesn't vanish with its shape
//! function, as that of the hat, f_I/m_I has no bound; then the neighbours are pushed instead, and no momentum is lost:
//!
//! ```text
//! m_I ≤ m_cut:   f_J ← f_J + f_I m_J / Σ_K m_K,   f_I ← 0          J, K: the neighbours of I above m_cut
//! ```
//!
//! Among the neighbours is always a node that the same particles reach well.
//!
//! Where a particle is at the end of a smooth shape function only rounding is left of m_I and p_I; what ghosts take of the rows next to walls
//! leaves them their mass (`ghost/limit.rs`). Such a *faint* node moves as its neighbours do on average, v_I = Σ m_J v_J / Σ m_J.

use super::ghost::Ghosted;
use super::{Grid, KernelKind, Node, Transfer};
use crate::math::Vector;
use crate::parallel::{self, CHUNK};

/// m_cut over the mass of the lightest particle, for shape functions with kinks at the ends of their supports.
const LIGHTEST_PUSHED: f64 = 1e-6;

/// The same with APIC, whose particles take the slope of the motion of a node that they barely reach in full: a node of mass N m_p
/// alone, with ω² = c²/(h² N) along one axis, is stable up to a Courant number of 2 √N, here ½.
const LIGHTEST_PUSHED_AFFINE: f64 = 1.0 / 16.0;

/// The same for smooth ones, whose f²/m stays bounded as m vanishes: just above the rounding of a node's mass. Below, nodes
/// are faint and out of contact.
const ROUNDING: f64 = 1e-15;

/// Up to which masses nodes are light [kg].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cutoff {
    /// Nodes up to this mass leave the forces of particles to their neighbours.
    pub pushed: f64,
    /// Nodes up to this mass are faint.
    pub faint: f64,
    /// Nodes up to this mass touch nothing.
    pub touching: f64,
}

impl Cutoff {
    /// For the lightest particle of a field [kg].
    pub fn new(kernel: KernelKind, transfer: &Transfer, particle: f64) -> Self {
        let rounding = ROUNDING * particle;
        let pushed = if *transfer == Transfer::Apic { LIGHTEST_PUSHED_AFFINE } else { LIGHTEST_PUSHED };
        match kernel {
            // Its weights are positive wherever their slopes are not zero; only a particle on a wall has folded ones.
            KernelKind::Linear => Self { pushed: pushed * particle, faint: 0.0, touching: rounding },
            KernelKind::Gimp | KernelKind::Quadratic | KernelKind::Cubic => {
                Self { pushed: rounding, faint: rounding, touching: rounding }
            }
        }
    }
}

/// A faint node, and the neighbours whose mean it follows.
#[derive(Debug, Clone)]
pub struct Faint {
    node: u32,
    hosts: Vec<(u32, f64)>,
}

impl Faint {
    /// Gives the node the mean of its neighbours' values.
    pub fn follow<const D: usize>(&self, values: &mut [Vector<D>]) {
        values[self.node as usize] = self.hosts.iter().map(|&(host, share)| values[host as usize] * share).sum();
    }
}

/// The neighbours of a node above the mass `least` [kg], with their shares of the mass of all of them.
fn hosts<const D: usize>(grid: &Grid<D>, nodes: &[Node<D>], node: usize, least: f64) -> Vec<(u32, f64)> {
    let mass = |n: usize| (n as u32, nodes[n].mass);
    let mut hosts: Vec<_> = grid.neighbours(node).map(mass).filter(|&(_, mass)| mass > least).collect();
    let total: f64 = hosts.iter().map(|(_, mass)| mass).sum();
    hosts.iter_mut().for_each(|(_, mass)| *mass /= total);
    hosts
}

/// Finds the faint nodes among those that hold (m, p⁻), and gives them their neighbours' velocity and a mass that is
/// too small to count.
pub fn find_faint<const D: usize>(grid: &Grid<D>, nodes: &mut [Node<D>], cutoff: &Cutoff) -> Vec<Faint> {
    let faint = |node: &Node<D>| node.mass <= cutoff.faint && !node.is_nothing();
    let found: Vec<usize> = parallel::collect_some(nodes.len(), CHUNK, |n| faint(&nodes[n]).then_some(n));
    let mut all = Vec::with_capacity(found.len());
    for node in found {
        let hosts = hosts(grid, nodes, node, cutoff.pushed);
        let velocity: Vector<D> =
            hosts.iter().map(|&(j, share)| nodes[j as usize].momentum * (share / nodes[j as usize].mass)).sum();
        let mass = ROUNDING * cutoff.touching;
        nodes[node] = Node { mass, momentum: velocity * mass, ..nodes[node] };
        all.push(Faint { node: node as u32, hosts });
    }
    all
}

/// p̄ ← p⁻ + Δt f with gravity [m/s²] among the forces, which `applied` keeps; light nodes hand the rest of theirs over.
pub fn advance<const D: usize>(
    grid: &Grid<D>,
    nodes: &mut [Node<D>],
    applied: &mut [Vector<D>],
    (gravity, dt): (Vector<D>, f64),
    cutoff: &Cutoff,
) {
    let light = parallel::collect_pair_mut(nodes, applied, |n, node, applied| {
        let left = if node.mass > cutoff.pushed { Vector::ZERO } else { std::mem::take(&mut node.force) };
        node.force += gravity * node.mass; // Lian (18)
        node.momentum += node.force * dt; // Lian (64)
        *applied = node.force;
        (left != Vector::ZERO).then_some((n, left))
    });
    for (node, force) in light {
        for (host, share) in hosts(grid, nodes, node, cutoff.pushed) {
            let (host, force) = (host as usize, force * share);
            nodes[host].force += force;
            nodes[host].momentum += force * dt;
            applied[host] += force;
        }
    }
}
