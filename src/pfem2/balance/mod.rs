//! The energy balance of a run: its ledger, the available potential energy, and the checks of both and of the volumes
//! (theory F.13, F.14).
//!
//! ```text
//! forces      forces of the fluid on parts of the boundary                theory (F.38)
//! ledger      energy and momentum of the flow                             theory F.13
//! dissipation viscous dissipation of a step                               theory (F.40)
//! through     energy and momentum that the flow carries through openings  theory F.13
//! available   available potential energy, and the check against it        theory F.14
//! strain      energy of solids on particles                               theory K.6
//! ```
//!
//! The energy of solids on meshes of their own is in `solid/energy.rs`.

pub(super) mod available;
pub(super) mod dissipation;
pub(super) mod forces;
pub(super) mod ledger;
pub(super) mod strain;
mod through;

use crate::error::StepError;
use crate::math::Vector;
use crate::mesh::Mesh;
use crate::pfem2::checks::notices::Notices;
use crate::pfem2::equations::system::VelocityPressureSystem;
use crate::pfem2::history::StepWeights;
use crate::pfem2::solid::energy::{SolidEnergies, SolidEnergy};
use crate::pfem2::tracking::interface::InterfaceTracking;
use available::{AvailablePotentialEnergy, EnergyCheck};
use dissipation::ViscousDissipation;
use forces::BoundaryAction;
use ledger::{EnergyLedger, ExternalRates, FlowTotals};
use strain::StrainEnergy;
use through::OpenBoundaryFlux;

/// Part of the largest other energy so far that errors may take, or give, without a notice.
const TAKEN: f64 = 0.05;
const GIVEN: f64 = 0.02;

/// Part of the largest other energy so far that a viscous dissipation may lie below zero without a notice.
const NEGATIVE: f64 = 0.01;

/// Part of the weight times the size of the mesh that is rounding, and what the linear solver leaves.
const ROUNDING: f64 = 1e-9;

/// Part of an element by which gravity may move solids before errors are measured by its work: the surface of a solid
/// is known no better in a mesh that it cuts close to a node, and one that floats at rest moves by less.
const UNRESOLVED: f64 = 1e-3;

/// Solids with which a balance is opened.
#[derive(Debug, Clone, Copy)]
pub(in crate::pfem2) struct SolidsAtStart {
    /// Their energies.
    pub energies: SolidEnergies,
    /// Their mass [kg].
    pub mass: f64,
}

/// The energy balance of a run.
#[derive(Debug, Clone)]
pub(in crate::pfem2) struct EnergyBalance<const D: usize> {
    /// Sums over the mesh, after the last step.
    pub totals: FlowTotals,
    /// Works and losses since the start.
    pub ledger: EnergyLedger,
    /// Energy of solids, if there are any.
    pub solids: Option<SolidEnergy>,
    /// Strain energy of solids on particles, if there are any.
    pub strain: Option<StrainEnergy>,
    /// Viscous dissipation.
    pub dissipation: ViscousDissipation<D>,
    /// Work that gravity can do, where that can be told.
    pub available: Option<AvailablePotentialEnergy>,
    /// Volume of each fluid at the start [m³]; empty where fluid may come in or leave.
    pub initial_volumes: Vec<f64>,
    /// Energy that is rounding, of the weight at the start over the height of the mesh, or that lifts solids by less
    /// than their surface is known [J].
    pub negligible: f64,
}

impl<const D: usize> EnergyBalance<D> {
    /// The balance of a fluid that begins on a mesh of so many nodes; [`EnergyBalance::open`] follows.
    pub fn new(nodes: usize) -> Self {
        Self {
            totals: FlowTotals::default(),
            ledger: EnergyLedger::default(),
            solids: None,
            strain: None,
            dissipation: ViscousDissipation::at_rest(nodes),
            available: None,
            initial_volumes: Vec::new(),
            negligible: 0.0,
        }
    }

    /// Opens the balance with the state at the start and the kinetic energy that its boundary adds at once [J].
    pub fn open<const N: usize>(
        &mut self,
        system: &VelocityPressureSystem<D, N>,
        impulsive: f64,
        solids: Option<SolidsAtStart>,
    ) {
        self.solids = solids.map(|solids| SolidEnergy::open(solids.energies));
        // Solids that sink or rise, and the strain in them, belong to it too.
        let fluids_alone = solids.is_none() && system.particle_solids.is_none();
        self.available = AvailablePotentialEnergy::new(system, &self.totals).filter(|_| fluids_alone);
        if system.boundary.is_closed() {
            self.initial_volumes = system.contents.volumes.clone();
        }
        let rounding = ROUNDING * Vector(self.totals.weight).norm() * extent(&system.mesh);
        let gravity = Vector::<D>::from_fn(|i| system.physics.gravity[i].value([0.0; 3], 0.0)).norm();
        let lift = solids.map_or(0.0, |solids| solids.mass * gravity * system.shortest());
        self.negligible = rounding.max(UNRESOLVED * lift);
        self.ledger = EnergyLedger::open(self.totals.kinetic, system.surface_energy(), impulsive);
    }

    /// Updates the sums over the mesh.
    pub fn sum<const N: usize>(&mut self, system: &VelocityPressureSystem<D, N>) {
        self.totals = FlowTotals::of(system);
    }

    /// Takes the end of a predicted step as the step before the first.
    pub fn begin<const N: usize>(
        &mut self,
        system: &VelocityPressureSystem<D, N>,
        interface: &InterfaceTracking<D>,
        action: BoundaryAction<D>,
    ) {
        let rates = self.external_rates(system, interface, action);
        self.ledger.begin(&rates);
        self.dissipation.begin(system);
    }

    /// Adds a step with its `step_weights`; `first`: nothing came before it but its prediction.
    pub fn add<const N: usize>(
        &mut self,
        step_weights: StepWeights,
        first: bool,
        system: &VelocityPressureSystem<D, N>,
        interface: &InterfaceTracking<D>,
        action: BoundaryAction<D>,
    ) {
        let rates = self.external_rates(system, interface, action);
        let viscous = self.dissipation.of_step(system, step_weights, first);
        self.ledger.add(step_weights, &rates, viscous);
        if let Some(available) = self.available.as_ref().filter(|_| interface.keeps_volumes()) {
            self.ledger.set_gravity(available.released(&self.totals));
        }
        self.ledger.keep_largest(&self.totals, system.surface_energy());
        if let Some(solids) = &self.solids {
            self.ledger.largest = self.ledger.largest.max(solids.largest());
        }
        if let Some(strain) = &self.strain {
            self.ledger.largest = self.ledger.largest.max(strain.largest());
        }
        if first {
            let lost = -self.gained(system);
            // More than there was at the start can't be lost of it.
            let is_much = lost > TAKEN * self.largest_energy() && lost < self.begun();
            self.solids.iter_mut().filter(|_| is_much).for_each(|solids| solids.mismatch = lost);
        }
    }

    /// Energy of fluids and solids at the start [J].
    fn begun(&self) -> f64 {
        self.ledger.begun() + self.solids.as_ref().map_or(0.0, |solids| solids.stored)
    }

    /// Energy of the flow, its surfaces and the solids that no term explains [J].
    pub fn gained<const N: usize>(&self, system: &VelocityPressureSystem<D, N>) -> f64 {
        let of_solids = self.solids.as_ref().map_or(0.0, SolidEnergy::gained);
        let of_strain = self.strain.as_ref().map_or(0.0, StrainEnergy::gained);
        self.ledger.gained(&self.totals, system.surface_energy()) + of_solids + of_strain
    }

    /// Powers and forces from outside at the end of a step, with the sums over the mesh.
    fn external_rates<const N: usize>(
        &mut self,
        system: &VelocityPressureSystem<D, N>,
        interface: &InterfaceTracking<D>,
        BoundaryAction { force, power }: BoundaryAction<D>,
    ) -> ExternalRates<D> {
        self.sum(system);
        let FlowTotals { gravity, weight, .. } = self.totals;
        let force = std::array::from_fn(|i| force.to3()[i] + weight[i]);
        let mut through = OpenBoundaryFlux::of(system, |place| interface.inflow_density::<N>(place));
        through.energy += system.linear.dilatation_power;
        ExternalRates { gravity, boundary: power, force, through }
    }

    /// The energy that errors are measured by: the largest other energy so far, and no less than what counts in this
    /// run [J].
    pub fn largest_energy(&self) -> f64 {
        let least = self.available.as_ref().map_or(0.0, |available| available.least(&self.ledger));
        self.ledger.largest.max(least).max(self.negligible)
    }

    /// Gives notice of fluid that is lost, and of energy that errors took or gave.
    ///
    /// # Errors
    /// The flow has gained many times the energy that there was.
    pub fn check<const N: usize>(
        &self,
        system: &VelocityPressureSystem<D, N>,
        interface: &InterfaceTracking<D>,
        notices: &mut Notices,
    ) -> Result<(), StepError> {
        notices.losses(&system.physics.fluids, &self.initial_volumes, &system.contents.volumes);
        if interface.kept_volumes.is_some() {
            notices.weights(&system.physics.fluids, &self.initial_volumes, &system.contents.volumes);
        }
        self.check_errors(system, notices);
        let Some(available) = &self.available else { return Ok(()) };
        if available.check(&self.ledger, &self.totals, system)? == EnergyCheck::Excessive {
            notices.energy();
        }
        Ok(())
    }

    /// Gives notice of the part of the energy that errors have taken, or given.
    fn check_errors<const N: usize>(&self, system: &VelocityPressureSystem<D, N>, notices: &mut Notices) {
        let largest = self.largest_energy();
        let mismatch = self.solids.as_ref().map_or(0.0, |solids| solids.mismatch);
        if mismatch > 0.0 {
            notices.mismatch(mismatch / self.begun());
        }
        let gained = self.gained(system) + mismatch;
        let part = if largest > 0.0 { -gained / largest } else { 0.0 };
        notices.errors(part, !(-GIVEN..=TAKEN).contains(&part));
        if self.ledger.viscous() < -NEGATIVE * largest {
            notices.negative_dissipation();
        }
    }
}

/// Diagonal of the box around a mesh [m].
fn extent<const D: usize, const N: usize>(mesh: &Mesh<D, N>) -> f64 {
    let corner = |pick: fn(f64, f64) -> f64, start: f64| {
        mesh.nodes().iter().fold(Vector::<D>::splat(start), |a, b| Vector::from_fn(|i| pick(a[i], b[i])))
    };
    (corner(f64::max, f64::NEG_INFINITY) - corner(f64::min, f64::INFINITY)).norm()
}
