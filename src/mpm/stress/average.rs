//! Averages over the nodes, the cure of volumetric locking (theory A.10).
//!
//! ```text
//! A q = Σ N_Ip q̃_I,      q̃_I = Σ V_p q_p N_Ip / Σ V_p N_Ip
//! ```
//!
//! of volume ratios before the law is called (`update`), and of pressures before they make forces. The average of a field of
//! particles is its own adjoint, Σ V p A q = Σ V q A p. The forces are therefore made of the averaged pressure
//!
//! ```text
//! p̃ = (1 − β) p + β A p        so that      Σ V_p p_p tr L̄_p = Σ V_p p̃_p tr L_p
//! ```
//!
//! and do the work that the laws store. With p itself they don't: they push on volume changes that no stress sees,
//! and a column of liquid under its own pressure gains energy from them without end.

use crate::mpm::Locking;
use crate::mpm::grid::{Ghosts, Limits, Node};
use crate::mpm::particles::Body;
use crate::mpm::transfer::{Content, Record, Sweep, Wanted, put_scalar};
use crate::parallel;

/// What averages take, and room for them.
pub(in crate::mpm) struct Average<'a, const D: usize> {
    /// The ghosts of the grid, and what the field's masses let them take.
    pub ghosts: (&'a Ghosts<D>, &'a Limits),
    /// The cure that is wanted.
    pub locking: Locking,
    /// Σ V N and Σ V q N by node.
    pub sums: &'a mut Vec<[f64; 2]>,
    /// q̃ by node, ghosts filled.
    pub means: &'a mut Vec<[f64; 1]>,
}

impl<const D: usize> Average<'_, D> {
    /// β, if averages are wanted.
    pub fn blend(&self) -> Option<f64> {
        match self.locking {
            Locking::None => None,
            Locking::Average { blend } => Some(blend),
        }
    }

    /// Begins the sums of `count` nodes.
    pub fn begin(&mut self, count: usize) {
        self.sums.clear();
        self.sums.resize(count, [0.0; 2]);
    }

    /// Divides the sums.
    pub fn divide(&mut self) {
        let (ghosts, limits) = self.ghosts;
        ghosts.fold(limits, self.sums, |_, _, _| {});
        parallel::map_into(self.sums, self.means, |[v, vq]| [if *v > 0.0 { vq / v } else { 0.0 }]);
        ghosts.fill(limits, self.means);
    }

    /// Scatters the forces of a body's stresses with its pressures averaged, Lian (17, 18).
    pub fn push(&mut self, sweep: &Sweep<'_, D>, body: &mut Body<D>, nodes: &mut [Node<D>]) {
        self.begin(nodes.len());
        sweep.scatter(self.sums, body, Content::Pressures);
        self.push_summed(sweep, body, nodes);
    }

    /// The same for a body whose pressures are summed up already.
    pub fn push_summed(&mut self, sweep: &Sweep<'_, D>, body: &mut Body<D>, nodes: &mut [Node<D>]) {
        let Locking::Average { blend } = self.locking else { return };
        self.divide();
        body.work.excess.resize(body.particles.len(), 0.0);
        let node = |n: usize, record: &mut Record| put_scalar(record, self.means[n][0]);
        sweep.relay(node, body.view().1, (Wanted::Scalar, Content::Force), nodes, |chunk| {
            for p in 0..chunk.particles.len() {
                let more = chunk.rows.scalar[p] - chunk.particles.mean_pressure(p);
                chunk.particles.excess[p] = blend * more;
            }
        });
    }
}
