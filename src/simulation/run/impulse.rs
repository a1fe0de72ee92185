//! Forces between two rows of a history: F̄ = Σ Δt F/Σ Δt over the steps since the row before (theory H.10).
//!
//! A row may lie within a step, a time r before its end: F Δt of that step is parted at it.
//!
//! Contact and particles make forces waver from step to step, and rows lie many steps apart. The force of the step at
//! which a row happens to be written would alias; means over the time between rows add up to the impulse, Σ F̄ Δt = ∫ F
//! dt.

use crate::simulation::{Column, Solver};

/// Impulses of all forces since they were last recorded.
#[derive(Debug, Default)]
pub(super) struct Impulses {
    /// Three numbers per force [N s].
    sums: Vec<f64>,
    /// One number: the time they took [s]; empty before the first step.
    time: Vec<f64>,
    /// Forces of the last step [N].
    last: Vec<f64>,
}

impl Impulses {
    /// Adds the forces of a step of `dt` [s].
    pub fn add(&mut self, solver: &dyn Solver, dt: f64) {
        let Self { sums, time, last } = self;
        time.resize(1, 0.0);
        time[0] += dt;
        last.clear();
        solver.forces(&mut |force| last.extend(force));
        sums.resize(sums.len().max(last.len()), 0.0);
        sums.iter_mut().zip(last).for_each(|(sum, f)| *sum += *f * dt);
    }

    /// Replaces the forces of the last step, and then its moments, by their means since they were last recorded, up to
    /// `rest` [s] before the end of the step.
    pub fn average(&self, rest: f64, [forces, moments]: [&mut [(String, [f64; 3])]; 2]) {
        let Some(time) = self.time.first() else { return };
        let impulses = self.sums.as_chunks::<3>().0.iter().zip(self.last.as_chunks::<3>().0);
        for ((_, force), (sum, last)) in forces.iter_mut().chain(moments).zip(impulses) {
            *force = std::array::from_fn(|i| (sum[i] - last[i] * rest) / (time - rest));
        }
    }

    /// Begins anew `rest` [s] before the end of the last step.
    pub fn begin_anew(&mut self, rest: f64) {
        if rest == 0.0 {
            (self.sums, self.time) = Default::default();
            return;
        }
        self.time = vec![rest];
        self.sums.iter_mut().zip(&self.last).for_each(|(sum, f)| *sum = f * rest);
    }

    /// Shows the sums to a checkpoint.
    pub fn columns(&mut self, visit: &mut dyn FnMut(&str, Column<'_>)) {
        visit("loop/impulses", Column::growing(&mut self.sums));
        visit("loop/time of impulses", Column::growing(&mut self.time));
    }
}
