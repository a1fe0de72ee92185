//! The bodies' nodes that contact touches, followed through the sub-steps of the membranes (theory D.1, C.9).
//!
//! ```text
//! p̄(t) = p⁻ + t f + Σ J      at the time t after the start of the step, J the contact impulses so far
//! ```
//!
//! Mass and weights stay as they are; f is the force of everything but membranes. The sum is handed to the
//! grid once, p ← p + ΣJ and f ← f + ΣJ/Δt, so that p⁻ = p − Δt f stays true.

use crate::math::Vector;
use crate::mpm::Grid;
use crate::mpm::wall::folded_stencil::FoldedStencil;

/// The number of an absent node or partner.
pub const NONE: u32 = u32::MAX;

#[derive(Debug, Clone)]
struct Partner<const D: usize> {
    field: u32,
    node: u32,
    mass: f64,
    /// 1/m along the axes that contact may push, 0 along the others [1/kg].
    inverse_mass: Vector<D>,
    /// p⁻ [N s].
    momentum: Vector<D>,
    /// f [N].
    force: Vector<D>,
    /// Σ J [N s].
    impulse: Vector<D>,
}

/// All of them, in the order in which contact has found them.
#[derive(Debug, Default)]
pub struct Partners<const D: usize> {
    dt: f64,
    list: Vec<Partner<D>>,
    /// Number of each node of each field, `NONE` where there is none.
    index: Vec<Vec<u32>>,
}

impl<const D: usize> Partners<D> {
    /// Forgets the last step.
    pub fn begin(&mut self, dt: f64) {
        self.dt = dt;
        for partner in self.list.drain(..) {
            self.index[partner.field as usize][partner.node as usize] = NONE;
        }
    }

    /// The number of a node of a field; added if it is new.
    pub fn add(&mut self, grid: &Grid<D>, stencil: &FoldedStencil<D>, field: usize, node: usize) -> u32 {
        if self.index.len() <= field {
            self.index.resize(field + 1, Vec::new());
        }
        let index = &mut self.index[field];
        if index.len() <= node {
            index.resize(grid.node_count().max(node + 1), NONE);
        }
        let known = &mut index[node];
        if *known == NONE {
            *known = self.list.len() as u32;
            let value = &grid.fields[field].nodes[node];
            let free = stencil.free(grid, node);
            self.list.push(Partner {
                field: field as u32,
                node: node as u32,
                mass: value.mass,
                inverse_mass: Vector::from_fn(|a| if free[a] { 1.0 / value.mass } else { 0.0 }),
                momentum: value.momentum - value.force * self.dt,
                force: value.force,
                impulse: Vector::ZERO,
            });
        }
        *known
    }

    /// Mass [kg] and trial velocity [m/s] at the time `t` [s] after the start of the step.
    #[inline]
    pub fn trial(&self, partner: u32, t: f64) -> (f64, Vector<D>) {
        let p = &self.list[partner as usize];
        (p.mass, (p.momentum + p.force * t + p.impulse) / p.mass)
    }

    /// 1/m along the axes that contact may push, 0 along the others [1/kg].
    #[inline]
    pub fn inverse_mass(&self, partner: u32) -> Vector<D> {
        self.list[partner as usize].inverse_mass
    }

    /// Number of partners.
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// Adds a contact impulse [N s].
    #[inline]
    pub fn add_impulse(&mut self, partner: u32, impulse: Vector<D>) {
        self.list[partner as usize].impulse += impulse;
    }

    /// Hands the impulses to the grid: Lian (53), theory (D.1).
    pub fn apply_to_grid(&self, grid: &mut Grid<D>) {
        for p in &self.list {
            let node = &mut grid.fields[p.field as usize].nodes[p.node as usize];
            node.momentum += p.impulse; // Lian (53)
            node.force += p.impulse / self.dt;
        }
    }

    /// v̂ = (p⁻ + p)/(2m), the mean of the velocities before and after the step [m/s].
    pub fn mean_velocity(&self, partner: u32, grid: &Grid<D>, dt: f64) -> Vector<D> {
        let p = &self.list[partner as usize];
        let node = &grid.fields[p.field as usize].nodes[p.node as usize];
        (node.momentum - node.force * (0.5 * dt)) / p.mass
    }
}
