//! Forces between two rows of a history: F̄ = Σ Δt F/Σ Δt over the steps since the row before.
//!
//! Contact and particles make forces waver from step to step, and rows lie many steps apart. The force of the step at which a
//! row happens to be written would alias; means over the time between rows add up to the impulse, Σ F̄ Δt = ∫ F dt.

use crate::simulation::{Column, Solver};

/// Impulses of all forces since they were last recorded.
#[derive(Debug, Default)]
pub(super) struct Impulses {
    /// Three numbers per force [N s].
    sums: Vec<f64>,
    /// One number: the time they took [s]; empty before the first step.
    time: Vec<f64>,
}

impl Impulses {
    /// Adds the forces of a step of `dt` [s].
    pub fn add(&mut self, solver: &dyn Solver, dt: f64) {
        let Self { sums, time } = self;
        time.resize(1, 0.0);
        time[0] += dt;
        let mut count = 0;
        solver.forces(&mut |force| {
            sums.resize(sums.len().max(count + 3), 0.0);
            sums[count..count + 3].iter_mut().zip(force).for_each(|(sum, f)| *sum += f * dt);
            count += 3;
        });
    }

    /// Replaces the forces of the last step, and then its moments, by their means since they were last recorded.
    pub fn average(&self, [forces, moments]: [&mut [(String, [f64; 3])]; 2]) {
        let Some(time) = self.time.first() else { return };
        for ((_, force), sum) in forces.iter_mut().chain(moments).zip(self.sums.as_chunks::<3>().0) {
            *force = sum.map(|impulse| impulse / time);
        }
    }

    /// Shows the sums to a checkpoint.
    pub fn columns(&mut self, visit: &mut dyn FnMut(&str, Column<'_>)) {
        visit("loop/impulses", Column::growing(&mut self.sums));
        visit("loop/time of impulses", Column::growing(&mut self.time));
    }
}
