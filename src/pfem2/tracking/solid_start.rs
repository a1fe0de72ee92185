//! The solids at the start of a run, and what its predicted first step leaves of them (theory H.9).

use super::solids::SolidTracking;
use crate::error::StepError;
use crate::math::Vector;
use crate::mesh::Mesh;
use crate::pfem2::boundary::Boundary;
use crate::pfem2::moments::{self, ForcedPart, MomentPoint, StepMeans};
use crate::pfem2::solid::contact::step::{ContactForces, StepContacts};
use crate::pfem2::solid::energy::SolidEnergies;
use crate::pfem2::solid::holding::Holders;
use crate::pfem2::solid::step_results::{SolidStep, energies};
use crate::pfem2::solid::structure::bodies::{LinearCells, SolidPowers};
use crate::pfem2::solid::structure::outline::SolidOutline;
use crate::pfem2::solid::structure::{SolidState, Structure};

/// State of solids at the start of a step.
pub(in crate::pfem2) struct SolidStart<const D: usize> {
    state: SolidState<D>,
    last: SolidStep<D>,
}

impl<const D: usize> SolidTracking<D> {
    /// Solids at the start, in a mesh with walls.
    pub fn new<const N: usize>(structure: Structure<D>, mesh: &Mesh<D, N>, boundary: &Boundary<D>) -> Self {
        let count = structure.setups().len();
        let contacts = StepContacts::new(&structure, mesh, boundary);
        let holders = Holders::new(&structure);
        let last = SolidStep {
            predicted: structure.state.displacement.clone(),
            nodal: vec![Vector::ZERO; structure.node_count()],
            moments: StepMeans::none(count),
            holding: StepMeans::none(holders.count()),
            holding_moments: StepMeans::none(holders.count()),
            forces: StepMeans::none(count),
            contact_forces: ContactForces::none(&structure, &contacts),
            // Elements that are turned inside out are found by the first step.
            energies: energies(&structure, SolidPowers::default()).unwrap_or_default(),
            ..SolidStep::default()
        };
        let setups = structure.setups().iter();
        let (cells, outlines) =
            setups.map(|setup| (LinearCells::new(&setup.mesh), SolidOutline::new(&setup.name, &setup.mesh))).unzip();
        let moment_points = vec![None; structure.setups().len()];
        Self {
            structure,
            cells,
            outlines,
            moment_points,
            holders,
            contacts,
            pressure_stiffness: None,
            prediction: None,
            first: None,
            last,
        }
    }

    /// The solids with points about which the forces on them have moments.
    #[must_use]
    pub fn with_moments(mut self, moments: &[MomentPoint<D>]) -> Self {
        self.moment_points = moments::points(moments, self.moment_points.len(), ForcedPart::Solid);
        self
    }

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
