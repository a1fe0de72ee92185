//! Energy and momentum of the flow on the mesh (theory F.13).
//!
//! ```text
//! kinetic      ½ Σ_e Σ_i m_i |v_i|²
//! gravity      Σ m φ at the start − Σ m φ now, φ = −b·x      in a closed box whose fluids keep their volumes, b steady and uniform
//!              Δt Σ m_i b_i·v_i                              elsewhere
//! boundaries   Δt Σ (traction and support)·v_i
//! openings     −Δt ∮ ½ρ |v|² v·n                        (see `through`)
//! viscous      what the step takes                      (see `friction`)
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

use super::through::OpenBoundaryFlux;
use crate::math::Vector;
use crate::parallel;
use crate::pfem2::equations::system::VelocityPressureSystem;
use crate::simulation::TermKind::{Gain, Loss, Other, Remainder, Stored};
use crate::simulation::{BalanceTerm, Ledger};

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
    /// Powers [W], then forces [N]: a part of a column of the ledger.
    fn entries(&self) -> [f64; RATES] {
        let ([fx, fy, fz], [px, py, pz]) = (self.force, self.through.momentum.to3());
        [self.gravity, self.boundary, self.through.energy, fx, fy, fz, px, py, pz]
    }
}

/// Number of rates in the ledger.
const RATES: usize = 9;

/// The energy ledger since the start.
#[derive(Debug, Clone, Default)]
pub struct EnergyLedger {
    /// Works of gravity and boundaries, kinetic energy that came in [J], impulse from outside, momentum that came in [N s], what
    /// viscosity took [J]: one column of a checkpoint.
    pub entries: Vec<f64>,
    /// Powers and forces at the end of the last step, then those of the step before: one column of a checkpoint.
    pub last: Vec<f64>,
    /// Kinetic and surface energy at the start; what walls and inlets give in the first step to the nodes that they hold, until it
    /// is booked [J].
    pub start: Vec<f64>,
    /// The largest kinetic energy so far, and the largest term of all but the numerical dissipation [J].
    pub peak: Vec<f64>,
}

impl EnergyLedger {
    /// Opens the ledger with the kinetic and the surface energy at the start, and the kinetic energy of an impulsive start [J].
    pub fn open(kinetic: f64, surface: f64, impulsive: f64) -> Self {
        let stored = kinetic + surface;
        Self {
            entries: vec![0.0; RATES + 1],
            last: vec![0.0; 2 * RATES],
            start: vec![stored, impulsive],
            peak: vec![kinetic + impulsive, (stored + impulsive).max(surface)],
        }
    }

    /// Sets the work of gravity since the start to the potential energy that the fluids have lost [J].
    pub fn set_gravity(&mut self, lost: f64) {
        self.entries[0] = lost;
    }

    /// Notes the energies of a state [J].
    pub fn note(&mut self, totals: &FlowTotals, surface: f64) {
        let [gravity, boundary, carried, ..] = self.entries[..] else { return };
        let terms = [surface, gravity, boundary, carried, self.viscous()];
        let largest = terms.iter().fold(totals.kinetic, |largest, term| largest.max(term.abs()));
        self.peak = vec![self.peak[0].max(totals.kinetic), self.peak[1].max(largest)];
    }

    /// Work of gravity since the start [J].
    pub fn gravity(&self) -> f64 {
        self.entries[0]
    }

    /// Viscous dissipation since the start [J].
    pub fn viscous(&self) -> f64 {
        self.entries[RATES]
    }

    /// Energy exchanged with boundaries and dissipated since the start [J].
    pub fn exchanged(&self) -> f64 {
        self.entries[1].abs() + self.viscous()
    }

    /// Kinetic and surface energy at the start, with what walls and inlets gave at once [J].
    pub fn begun(&self) -> f64 {
        self.start.iter().sum()
    }

    /// The largest kinetic energy so far [J].
    pub fn peak(&self) -> f64 {
        self.peak[0]
    }

    /// The largest energy so far that was stored, gained or lost by anything but errors [J].
    pub fn largest(&self) -> f64 {
        self.peak[1]
    }

    /// Energy of the flow and its surfaces that no term explains [J].
    pub fn gained(&self, totals: &FlowTotals, surface: f64) -> f64 {
        let gained: f64 = self.entries[..3].iter().sum();
        totals.kinetic + surface - (self.start[0] + gained - self.viscous())
    }

    /// Notes what acts from outside at the start, of which the first step takes its explicit share.
    pub fn begin<const D: usize>(&mut self, outside: &ExternalRates<D>) {
        self.last = [outside.entries(); 2].concat();
    }

    /// Books a step of `dt` with what acts from outside at its end and what viscosity took [J]; `shares` are θ, β₁ and β₂.
    pub fn add<const D: usize>(&mut self, dt: f64, shares: [f64; 3], outside: &ExternalRates<D>, viscous: f64) {
        let (last, earlier) = self.last.split_at_mut(RATES);
        for (k, now) in outside.entries().into_iter().enumerate() {
            self.entries[k] += dt * (shares[0] * now + shares[1] * last[k] + shares[2] * earlier[k]);
            (earlier[k], last[k]) = (last[k], now);
        }
        self.entries[1] += std::mem::take(&mut self.start[1]);
        self.entries[RATES] += viscous;
    }

    /// All terms of the ledger: energies, mass, momentum.
    pub fn ledger<const D: usize>(&self, totals: &FlowTotals, surface: f64) -> Ledger {
        let term = |kind, name: &str, unit, value| BalanceTerm { name: name.to_owned(), unit, kind, value };
        let mut terms = vec![
            term(Stored, "kinetic energy", "J", totals.kinetic),
            term(Stored, "surface energy", "J", surface),
            term(Gain, "work of gravity", "J", self.gravity()),
            term(Gain, "work of boundaries", "J", self.entries[1]),
            term(Gain, "energy through openings", "J", self.entries[2]),
            term(Loss, "viscous dissipation", "J", self.viscous()),
            term(Remainder, "numerical dissipation", "J", -self.gained(totals, surface)),
            term(Other, "mass", "kg", totals.mass),
        ];
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate().take(D) {
            terms.push(term(Other, &format!("momentum {name}"), "N s", totals.momentum[axis]));
            terms.push(term(Other, &format!("external impulse {name}"), "N s", self.entries[3 + axis]));
            terms.push(term(Other, &format!("momentum through openings {name}"), "N s", self.entries[6 + axis]));
        }
        Ledger { terms, ..Ledger::default() }
    }
}
