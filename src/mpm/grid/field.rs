//! A velocity field of the grid: its nodes, and the other nodal data of a step.
//!
//! During a step a node holds, in this order: (m, p⁻, f) after the particles' scatter, then (m, p̄, f) with
//! p̄ = p⁻ + Δt f — walls and contact change p̄ *and* f together, so that p⁻ = p − Δt f always. When nothing changes
//! them any more, nodes are finished: their memory then holds (m, v⁺, a), which is read as [`NodeMotion`].

use crate::math::Vector;
use bytemuck::TransparentWrapper;

/// One velocity field.
#[derive(Debug, Clone, Default)]
pub struct VelocityField<const D: usize> {
    /// Nodes of all active blocks, 4ᴰ per block.
    pub nodes: Vec<Node<D>>,
    /// The velocity that gradients are taken of [m/s]: v⁻, v⁺ or the re-mapped one, by the stress update.
    pub velocity: Vec<Vector<D>>,
    /// The force of stresses, gravity and tractions alone [N], kept for the energy ledger.
    pub applied: Vec<Vector<D>>,
    /// The fractions by which the ghosts extrapolate, in this step.
    pub limits: GhostFractions,
    /// Nodes of which only rounding is left, in this step.
    pub small: Vec<SmallMassNode>,
    /// The masses up to which its nodes are small.
    pub cutoffs: MassCutoffs,
    /// The heat per mass that re-mapped nodes hand to the particles [J/kg], ghosts filled; empty: none.
    pub heat: Vec<[f64; 1]>,
    /// Sums over the particles around each node, Σ V N and Σ V q N.
    pub sums: Vec<[f64; 2]>,
    /// Quotients of the sums, ghosts filled.
    pub means: Vec<[f64; 1]>,
}

/// One node of one field: a cache line.
#[derive(Debug, Clone, Copy, Default)]
#[repr(C, align(64))]
pub struct Node<const D: usize> {
    /// Mass m_I [kg].
    pub mass: f64,
    /// Momentum [N s].
    pub momentum: Vector<D>,
    /// Force [N], walls and contact included.
    pub force: Vector<D>,
}

impl<const D: usize> Node<D> {
    /// Turns (m, p, f) of a node with mass into (m, v, a), which is read as [`NodeMotion`] from then on.
    #[inline]
    pub(in crate::mpm) fn finish(&mut self) -> &NodeMotion<D> {
        (self.momentum, self.force) = (self.momentum / self.mass, self.force / self.mass);
        NodeMotion::wrap_ref(self)
    }
}

/// A finished node, in the memory of a [`Node`].
#[derive(Debug, Clone, Copy, TransparentWrapper)]
#[repr(transparent)]
pub struct NodeMotion<const D: usize>(Node<D>);

impl<const D: usize> NodeMotion<D> {
    /// The nodes of a field, which have been finished.
    pub fn of(nodes: &[Node<D>]) -> &[Self] {
        Self::wrap_slice(nodes)
    }

    /// Mass m_I [kg].
    #[inline(always)]
    pub fn mass(&self) -> f64 {
        self.0.mass
    }

    /// Velocity v_I⁺ [m/s].
    #[inline(always)]
    pub fn velocity(&self) -> Vector<D> {
        self.0.momentum
    }

    /// Acceleration a_I [m/s²].
    #[inline(always)]
    pub fn acceleration(&self) -> Vector<D> {
        self.0.force
    }

    /// Velocity in the middle of a step of the momentum `dt` [s], v̂_I = ½ (v_I⁻ + v_I⁺) [m/s].
    #[inline(always)]
    pub fn midstep_velocity(&self, dt: f64) -> Vector<D> {
        self.velocity() - self.acceleration() * (0.5 * dt)
    }
}

/// The rule by which the ghosts beyond one end of an axis follow the domain.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fold {
    /// A symmetry plane.
    Mirror,
    /// Linear extrapolation.
    Extrapolate,
    /// Not at all: the grid goes on beyond the wall.
    Continue,
}

/// The fractions θ by which the ghosts of one velocity field extrapolate (`ghost::limit`); by default all are one.
#[derive(Debug, Clone, Default)]
pub struct GhostFractions {
    /// Fractions by axis, in the order of its ghosts; nothing where the grid goes on.
    pub(super) fractions: Vec<Vec<Option<f64>>>,
}

impl GhostFractions {
    /// The fraction of a ghost, by its number among those of the axis; nothing if it is none in this field.
    #[inline]
    pub(super) fn fraction(&self, axis: usize, number: usize) -> Option<f64> {
        self.fractions.get(axis).map_or(Some(1.0), |fractions| fractions[number])
    }
}

/// The masses [kg] up to which nodes have no force, velocity or contact.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MassCutoffs {
    /// Nodes up to this mass leave the forces of particles to their neighbours.
    pub force: f64,
    /// Nodes up to this mass take the mean velocity of their neighbours.
    pub velocity: f64,
    /// Nodes up to this mass have no contact.
    pub contact: f64,
}

/// A node whose mass is nothing but rounding, and the neighbours whose mean velocity it takes (`small_mass`).
#[derive(Debug, Clone)]
pub struct SmallMassNode {
    pub(super) node: u32,
    /// Neighbours with their fractions of the mass of all of them.
    pub(super) hosts: Vec<(u32, f64)>,
}

impl SmallMassNode {
    /// Gives the node the mean of its neighbours' values.
    pub fn follow<const D: usize>(&self, values: &mut [Vector<D>]) {
        values[self.node as usize] = self.hosts.iter().map(|&(host, fraction)| values[host as usize] * fraction).sum();
    }
}
