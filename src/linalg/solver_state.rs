//! The state of a linear solver as a checkpoint keeps it: with it a resumed run repeats the same bits (theory F.15).

use super::preconditioner::{Detour, Preconditioning, ReusePolicy};
use bytemuck::{Pod, Zeroable};

/// State that a solver carries from one system to the next.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SolverState {
    /// The matrix of the kept preconditioner, entry by entry; empty if none is kept.
    pub values: Vec<f64>,
    /// Row and column of the entries of the border's compliance to pressure, of which that matrix was made; empty if it
    /// has none.
    pub compliance_places: Vec<[u32; 2]>,
    /// The values of these entries.
    pub compliance: Vec<f64>,
    /// The coarse correction of the border.
    pub coarse: CoarseState,
    /// Counters of the use of the preconditioner.
    pub counters: SolverCounters,
}

/// State of the coarse correction of a border.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct CoarseState {
    /// Counters of its use.
    pub counters: CoarseCounters,
    /// Λ, the added mass of each motion over what resists in the solid.
    pub added_mass: Vec<f64>,
    /// W, the forces by the pressure of each motion, motion after motion.
    pub forces: Vec<f64>,
}

/// Counters that decide whether the coarse correction of a border is made anew. All are numbers of one type, so that a
/// checkpoint stores them as a record.
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct CoarseCounters {
    /// 1 if there is a correction, which may be one without motions, or else 0.
    pub made: f64,
    /// trace(WᵀY) of the first system, 0 before it.
    pub compliance: f64,
    /// Cost of a new correction, in iterations.
    pub price: f64,
    /// Iterations since the correction was made.
    pub spent: f64,
    /// Systems since it was made.
    pub systems: f64,
    /// [`REPLACED`] if the next system gets a new one, or else [`KEPT`].
    pub replacement: f64,
}

/// Counters that decide which method preconditions the next system, and whether anew. All are numbers of one type, so
/// that a checkpoint stores them as a record.
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct SolverCounters {
    /// Number of the method in use in the list of all.
    pub method_number: f64,
    /// Cost of a new preconditioner, in iterations.
    pub price: f64,
    /// Iterations since the preconditioner was made.
    pub spent: f64,
    /// Systems since it was made.
    pub systems: f64,
    /// [`REPLACED`] if the next system gets a new one, or else [`KEPT`].
    pub replacement: f64,
    /// Failures of kept preconditioners in a row.
    pub failures: f64,
    /// Systems to come that get a new one without a trial.
    pub rest: f64,
    /// Failures of the usual method in a row.
    pub detour_failures: f64,
    /// Systems until the usual method is tried again.
    pub detour_rest: f64,
}

/// The next system keeps the preconditioner.
pub const KEPT: f64 = 0.0;

/// The next system gets a new preconditioner.
pub const REPLACED: f64 = 1.0;

impl SolverCounters {
    /// The counters of a solver.
    pub(super) fn new(method: Preconditioning, reuse: &ReusePolicy, detour: &Detour) -> Self {
        let &ReusePolicy { price, spent, systems, replace, failures, rest } = reuse;
        Self {
            method_number: method.number() as f64,
            price,
            spent,
            systems,
            replacement: if replace { REPLACED } else { KEPT },
            failures: f64::from(failures),
            rest: f64::from(rest),
            detour_failures: f64::from(detour.failures),
            detour_rest: f64::from(detour.rest),
        }
    }

    /// True if a solver can have such counters.
    pub(super) fn are_possible(&self) -> bool {
        let Self { method_number, price, spent, systems, replacement, failures, rest, detour_failures, detour_rest } =
            *self;
        let counts = [method_number, failures, rest, detour_failures, detour_rest];
        counts.iter().all(|count| (0.0..=f64::from(u32::MAX / 2)).contains(count))
            && [price, spent, systems, replacement].iter().all(|sum| *sum >= 0.0)
    }

    /// The method in use.
    pub(super) fn method(&self) -> Preconditioning {
        Preconditioning::numbered(self.method_number as usize)
    }

    /// The detour from the usual method.
    pub(super) fn detour(&self) -> Detour {
        Detour { failures: self.detour_failures as u32, rest: self.detour_rest as u32 }
    }

    /// The use of the kept preconditioner.
    pub(super) fn reuse(&self) -> ReusePolicy {
        let Self { price, spent, systems, replacement, failures, rest, .. } = *self;
        let replace = replacement != KEPT;
        ReusePolicy { price, spent, systems, replace, failures: failures as u32, rest: rest as u32 }
    }
}
