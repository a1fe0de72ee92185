//! The solids at the start of a run, and what its predicted first step leaves of them (theory H.9).

use super::step_results::SolidStep;
use super::step_results::energies;
use super::structure::SolidState;
use super::structure::bodies::SolidPowers;
use super::tracking::SolidTracking;
use crate::error::StepError;
use crate::math::Vector;
use crate::pfem2::report::moments::StepMeans;
use crate::pfem2::report::solids::SolidEnergies;

/// State of solids at the start of a step.
pub(in crate::pfem2) struct SolidStart<const D: usize> {
    state: SolidState<D>,
    last: SolidStep<D>,
}

impl<const D: usize> SolidTracking<D> {
    /// State at the start of a step.
    pub fn start(&self) -> SolidStart<D> {
        SolidStart { state: self.structure.state.clone(), last: self.last.clone() }
    }

    /// Takes the state at the start of a predicted first step, and the step before it from its end: a⁰ = a¹, v⁻¹ = 2 v⁰
    /// − v¹ (theory H.9).
    pub fn restart(&mut self, SolidStart { mut state, last }: SolidStart<D>) {
        state.begin(&self.structure.state);
        let contact_forces = std::mem::take(&mut self.last.contact_forces);
        let nodal = std::mem::take(&mut self.last.nodal);
        let SolidStep { mut forces, mut moments, mut holding, mut holding_moments, .. } = last.clone();
        forces.begin(std::mem::take(&mut self.last.forces.last));
        moments.begin(std::mem::take(&mut self.last.moments.last));
        holding.begin(std::mem::take(&mut self.last.holding.last));
        holding_moments.begin(std::mem::take(&mut self.last.holding_moments.last));
        self.last = SolidStep { forces, moments, holding, holding_moments, contact_forces, nodal, ..last };
        self.structure.state = state;
    }

    /// Energies with which a run begins in the present state [J].
    ///
    /// # Errors
    /// An element is turned inside out.
    pub fn open_energies(&mut self) -> Result<SolidEnergies, StepError> {
        let count = self.structure.setups().len();
        let SolidStep { predicted, contact_forces, mut nodal, .. } = std::mem::take(&mut self.last);
        nodal.fill(Vector::ZERO);
        let energies = energies(&self.structure, SolidPowers::default())?;
        self.last = SolidStep {
            predicted,
            nodal,
            moments: StepMeans::none(count),
            holding: StepMeans::none(self.holders.count()),
            holding_moments: StepMeans::none(self.holders.count()),
            contact_forces,
            energies,
            forces: StepMeans::none(count),
            ..SolidStep::default()
        };
        Ok(energies)
    }

    /// Forgets the steps before.
    pub fn clear_history(&mut self) {
        self.structure.state.clear_history();
    }
}
