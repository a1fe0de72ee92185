//! Energy and momentum of the flow on the mesh (theory F.13).
//!
//! ```text
//! kinetic      ½ Σ_e Σ_i m_i |v_i|²
//! gravity      Σ m φ at the start − Σ m φ now, φ = −b·x      in a closed box whose fluids keep their volumes, b steady and uniform
//!              Δt Σ m_i b_i·v_i                              elsewhere
//! boundaries   Δt Σ (traction and support)·v_i
//! openings     −Δt ∮ ½ρ |v|² v·n                        (see `through`)
//! viscous      what the step takes                      (see `dissipation`)
//! surface      σ A
//! ```
//!
//! The first form of gravity's work is what the fluids have lost of potential energy where they are now: interfaces that run ahead of
//! the velocity, or behind it, show in the ledger. The second would not see them.
//!
//! Powers and forces are taken with the weights of the step: θ at its end, β₁ at its start, β₂ at the start of the one
//! before (see `step`). Walls and inlets that hold nodes from the start on take them along in the first step: that is work of
//! boundaries, too. The rest is booked as numerical dissipation: of the transport by particles, of the time
//! integration and of the stabilisation.

use super::checkpoint::visit_numbers;
use super::through::OpenBoundaryFlux;
use crate::math::Vector;
use crate::parallel;
use crate::pfem2::equations::system::VelocityPressureSystem;
use crate::simulation::TermKind::{Gain, Loss, Other, Remainder, Stored};
use crate::simulation::{BalanceTerm, Column, Ledger};

/// Sums over the mesh.
#[derive(Debug, Clone, Copy, Default)]
pub struct FlowTotals {
    /// Mass [kg].
    pub mass: f64,
    /// Momentum [N s].
    pub momentum: [f64; 3],
    /// Weight of the fluid [N].
    pub weight: [f64; 3],
    /// Kinetic energy [J].
    pub kinetic: f64,
    /// Σ m x [kg m].
    pub moment: [f64; 3],
    /// Power of gravity [W].
    pub gravity: f64,
}

impl FlowTotals {
    /// Of a state.
    pub fn of<const D: usize, const N: usize>(system: &VelocityPressureSystem<D, N>) -> Self {
        let chunk = |range: std::ops::Range<usize>| {
            range.map(|e| Self::of_element(system, e)).fold(Self::default(), Self::plus)
        };
        parallel::reduce(system.contents.len(), chunk, Self::plus).unwrap_or_default()
    }

    fn of_element<const D: usize, const N: usize>(system: &VelocityPressureSystem<D, N>, e: usize) -> Self {
        let content = &system.contents[e];
        let nodes = system.mesh.elements()[e].map(|node| node as usize);
        let velocity = nodes.map(|i| system.velocity[i]);
        let mut totals = Self::default();
        let [mut momentum, mut weight, mut moment] = [Vector::<D>::ZERO; 3];
        for ((m, v), i) in content.mass.iter().zip(&velocity).zip(nodes) {
            totals.mass += m;
            totals.kinetic += 0.5 * m * v.norm_squared();
            moment += system.mesh.nodes()[i] * *m;
            momentum += *v * *m;
            weight += system.force[i] * *m;
            totals.gravity += m * system.force[i].dot(*v);
        }
        (totals.momentum, totals.weight, totals.moment) = (momentum.to3(), weight.to3(), moment.to3());
        totals
    }

    fn plus(self, other: Self) -> Self {
        let add = |a: [f64; 3], b: [f64; 3]| std::array::from_fn(|i| a[i] + b[i]);
        Self {
            mass: self.mass + other.mass,
            momentum: add(self.momentum, other.momentum),
            weight: add(self.weight, other.weight),
            kinetic: self.kinetic + other.kinetic,
            moment: add(self.moment, other.moment),
            gravity: self.gravity + other.gravity,
        }
    }
}

/// Powers and forces from outside at the end of a step.
#[derive(Debug, Clone, Copy, Default)]
pub struct ExternalRates<const D: usize> {
    /// Power of gravity [W].
    pub gravity: f64,
    /// Power of tractions and supports [W].
    pub boundary: f64,
    /// Force of both [N].
    pub force: [f64; 3],
    /// Energy and momentum that the flow carries through open boundaries.
    pub through: OpenBoundaryFlux<D>,
}

impl<const D: usize> ExternalRates<D> {
    /// By the terms of the ledger.
    fn terms(&self) -> ExternalTerms {
        let OpenBoundaryFlux { energy, momentum } = self.through;
        ExternalTerms {
            gravity: self.gravity,
            boundary: self.boundary,
            openings: energy,
            impulse: self.force,
            momentum: momentum.to3(),
        }
    }
}

/// Number of numbers in [`ExternalTerms`].
const TERMS: usize = 9;

/// Works and impulses from outside [J, N s], or their rates, powers and forces [W, N].
#[derive(Debug, Clone, Copy, Default)]
pub struct ExternalTerms {
    /// Of gravity [J] or [W].
    pub gravity: f64,
    /// Of tractions and supports [J] or [W].
    pub boundary: f64,
    /// Kinetic energy through open boundaries [J] or [W].
    pub openings: f64,
    /// Of gravity, tractions and supports [N s] or [N].
    pub impulse: [f64; 3],
    /// Momentum through open boundaries [N s] or [N].
    pub momentum: [f64; 3],
}

impl ExternalTerms {
    fn to_array(self) -> [f64; TERMS] {
        let ([fx, fy, fz], [px, py, pz]) = (self.impulse, self.momentum);
        [self.gravity, self.boundary, self.openings, fx, fy, fz, px, py, pz]
    }

    fn from_array([gravity, boundary, openings, fx, fy, fz, px, py, pz]: [f64; TERMS]) -> Self {
        Self { gravity, boundary, openings, impulse: [fx, fy, fz], momentum: [px, py, pz] }
    }
}

/// The energy ledger since the start.
#[derive(Debug, Clone, Copy, Default)]
pub struct EnergyLedger {
    /// Works and impulses from outside since the start.
    pub external: ExternalTerms,
    /// Viscous dissipation since the start [J].
    pub viscous: f64,
    /// Powers and forces from outside at the end of the last step.
    pub last: ExternalTerms,
    /// Those at the end of the step before.
    pub earlier: ExternalTerms,
    /// Kinetic and surface energy at the start [J].
    pub stored: f64,
    /// Kinetic energy of the impulsive start, until it is booked with the first step [J].
    pub impulsive: f64,
    /// The largest kinetic energy so far [J].
    pub peak: f64,
    /// The largest energy so far that was stored, gained or lost by anything but errors [J].
    pub largest: f64,
}

impl EnergyLedger {
    /// Opens the ledger with the kinetic and the surface energy at the start, and the kinetic energy of an impulsive start [J].
    pub fn open(kinetic: f64, surface: f64, impulsive: f64) -> Self {
        let stored = kinetic + surface;
        let (peak, largest) = (kinetic + impulsive, (stored + impulsive).max(surface));
        Self { stored, impulsive, peak, largest, ..Self::default() }
    }

    /// Sets the work of gravity since the start to the potential energy that the fluids have lost [J].
    pub fn set_gravity(&mut self, lost: f64) {
        self.external.gravity = lost;
    }

    /// Keeps the largest energies, with those of a state [J].
    pub fn keep_largest(&mut self, totals: &FlowTotals, surface: f64) {
        let ExternalTerms { gravity, boundary, openings, .. } = self.external;
        let terms = [surface, gravity, boundary, openings, self.viscous];
        let largest = terms.iter().fold(totals.kinetic, |largest, term| largest.max(term.abs()));
        (self.peak, self.largest) = (self.peak.max(totals.kinetic), self.largest.max(largest));
    }

    /// Energy exchanged with boundaries and dissipated since the start [J].
    pub fn exchanged(&self) -> f64 {
        self.external.boundary.abs() + self.viscous
    }

    /// Kinetic and surface energy at the start, with that of an impulsive start [J].
    pub fn begun(&self) -> f64 {
        [self.stored, self.impulsive].iter().sum()
    }

    /// Energy of the flow and its surfaces that no term explains [J].
    pub fn gained(&self, totals: &FlowTotals, surface: f64) -> f64 {
        let ExternalTerms { gravity, boundary, openings, .. } = self.external;
        let gained: f64 = [gravity, boundary, openings].iter().sum();
        totals.kinetic + surface - (self.stored + gained - self.viscous)
    }

    /// Takes powers and forces from outside as those at the start, of which the first step takes its explicit share.
    pub fn begin<const D: usize>(&mut self, outside: &ExternalRates<D>) {
        self.last = outside.terms();
        self.earlier = self.last;
    }

    /// Adds a step of `dt` [s] with the powers and forces from outside at its end and its viscous dissipation [J]; `shares` are θ, β₁
    /// and β₂.
    pub fn add<const D: usize>(&mut self, dt: f64, shares: [f64; 3], outside: &ExternalRates<D>, viscous: f64) {
        let now = outside.terms();
        let mut sums = self.external.to_array();
        let rates = now.to_array().into_iter().zip(self.last.to_array()).zip(self.earlier.to_array());
        for (sum, ((now, last), earlier)) in sums.iter_mut().zip(rates) {
            *sum += dt * (shares[0] * now + shares[1] * last + shares[2] * earlier);
        }
        self.external = ExternalTerms::from_array(sums);
        (self.earlier, self.last) = (self.last, now);
        self.external.boundary += std::mem::take(&mut self.impulsive);
        self.viscous += viscous;
    }

    /// Columns of a checkpoint.
    pub fn columns(&mut self, visit: &mut dyn FnMut(&str, Column<'_>)) {
        let [mut sums, mut rates] = [self.external.to_array().to_vec(), self.last.to_array().to_vec()];
        sums.push(self.viscous);
        rates.extend(self.earlier.to_array());
        visit("books/works", Column::new(&mut sums));
        visit("books/last", Column::new(&mut rates));
        if let (Some((external, [viscous])), Some((last, earlier))) =
            (sums.split_first_chunk::<TERMS>(), rates.split_first_chunk::<TERMS>())
        {
            (self.external, self.viscous) = (ExternalTerms::from_array(*external), *viscous);
            self.last = ExternalTerms::from_array(*last);
            self.earlier = earlier.first_chunk().map_or(self.earlier, |earlier| ExternalTerms::from_array(*earlier));
        }
        [self.stored, self.impulsive] = visit_numbers(visit, "books/start", [self.stored, self.impulsive]);
        [self.peak, self.largest] = visit_numbers(visit, "books/peak", [self.peak, self.largest]);
    }

    /// All terms of the ledger: energies, mass, momentum.
    pub fn ledger<const D: usize>(&self, totals: &FlowTotals, surface: f64) -> Ledger {
        let term = |kind, name: &str, unit, value| BalanceTerm { name: name.to_owned(), unit, kind, value };
        let mut terms = vec![
            term(Stored, "kinetic energy", "J", totals.kinetic),
            term(Stored, "surface energy", "J", surface),
            term(Gain, "work of gravity", "J", self.external.gravity),
            term(Gain, "work of boundaries", "J", self.external.boundary),
            term(Gain, "energy through openings", "J", self.external.openings),
            term(Loss, "viscous dissipation", "J", self.viscous),
            term(Remainder, "numerical dissipation", "J", -self.gained(totals, surface)),
            term(Other, "mass", "kg", totals.mass),
        ];
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate().take(D) {
            terms.push(term(Other, &format!("momentum {name}"), "N s", totals.momentum[axis]));
            terms.push(term(Other, &format!("external impulse {name}"), "N s", self.external.impulse[axis]));
            terms.push(term(Other, &format!("momentum through openings {name}"), "N s", self.external.momentum[axis]));
        }
        Ledger { terms, ..Ledger::default() }
    }
}
