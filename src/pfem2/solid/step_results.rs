//! Results of a step of the solids: forces on them, energies, and how well it was solved.

use super::contact::step::ContactForces;
use super::energy::SolidEnergies;
use super::structure::Structure;
use super::structure::bodies::SolidPowers;
use crate::error::StepError;
use crate::math::Vector;
use crate::pfem2::moments::StepMeans;

/// Results of a step.
#[derive(Debug, Clone, Default)]
pub(in crate::pfem2) struct SolidStep<const D: usize> {
    /// Last predicted displacement u* [m]: the surface that cut the mesh.
    pub predicted: Vec<Vector<D>>,
    /// Forces of the fluid on each node of the solids at its end [N].
    pub nodal: Vec<Vector<D>>,
    /// Moments of the forces of the fluid on each solid, about their points.
    pub moments: StepMeans<3>,
    /// Forces of the fluid on each solid [N].
    pub forces: StepMeans<D>,
    /// Forces on supports and springs, and of contacts on solids [N].
    pub holding: StepMeans<D>,
    /// Their moments about the points of the solids [N m].
    pub holding_moments: StepMeans<3>,
    /// Normal forces of contacts at its end [N].
    pub contact_forces: ContactForces<D>,
    /// Energies at its end, and powers from outside.
    pub energies: SolidEnergies,
    /// Force that quasi-static solids were off balance by at its end, over the largest.
    pub imbalance: f64,
    /// Distance of the surface from its first prediction, in elements.
    pub prediction_error: f64,
    /// Number of its solutions (theory (J.3a)).
    pub solutions: usize,
    /// Distance by which the last solution of a step moved elastic solids, in elements, if that is too much; else zero.
    pub last_correction: f64,
    /// True if contacts of elastic solids pulled, or lacked, when it was solved for the last time.
    pub has_wrong_contacts: bool,
    /// Steps that solids make by backward Euler from now on (theory J.8).
    pub backward_steps: usize,
}

/// Energies of a structure [J], with these powers [W].
///
/// # Errors
/// An element is turned inside out.
pub(in crate::pfem2) fn energies<const D: usize>(
    structure: &Structure<D>,
    powers: SolidPowers,
) -> Result<SolidEnergies, StepError> {
    let SolidPowers { gravity, supports } = powers;
    let (kinetic, strain) = (structure.kinetic_energy(), structure.strain_energy()?);
    Ok(SolidEnergies { kinetic, strain, gravity, supports })
}
