//! Energy and momentum of the flow on the mesh (theory F.13).
//!
//! ```text
//! kinetic      ½ Σ_e Σ_i m_i |v_i|²
//! gravity      Σ m φ at the start − Σ m φ now, φ = −b·x   in a closed box whose fluids keep their volumes, b steady and uniform
//!              Δt Σ m_i b_i·(v_i + ũ_e)                   elsewhere
//! boundaries   Δt Σ (traction and support)·v_i
//! openings     −Δt ∮ ½ρ |v|² v·n                        (see `through`)
//! viscous      what the step takes                      (see `dissipation`)
//! surface      σ A
//! ```
//!
//! In elements that solids cut, i are the nodes and the cut points, with the masses of the simplices of the fluid part.
//!
//! The mass is moved by v + ũ, theory F.7.4: gravity and the pressure that balances it do nothing together, as they
//! would not with v alone.
//!
//! The first form of gravity's work is what the fluids have lost of potential energy where they are now: interfaces
//! that run ahead of the velocity, or behind it, show in the ledger. The second would not see them.
//!
//! Powers and forces are taken with the weights of the step: θ at its end, β₁ at its start, β₂ at the start of the one
//! before (see `step`); their sums over time are compensated (Neumaier). Walls and inlets that hold nodes from
//! the start on take them along in the first step: that is work of boundaries, too. The rest is booked as numerical
//! dissipation: of the transport by particles, of the time integration and of the stabilisation.

use super::through::OpenBoundaryFlux;
use crate::math::Vector;
use crate::parallel;
use crate::pfem2::equations::system::VelocityPressureSystem;
use crate::pfem2::history::StepWeights;
use crate::pfem2::solid::coupling::immersed::PointMass;
use crate::simulation::TermKind::{Gain, Loss, Remainder, Stored};
use crate::simulation::{BalanceTerm, CompensatedSum, Ledger, Record};
use bytemuck::{Pod, Zeroable};

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
    /// The totals of a state.
    pub fn of<const D: usize, const N: usize>(system: &VelocityPressureSystem<D, N>) -> Self {
        let chunk = |range: std::ops::Range<usize>| {
            range.map(|e| Self::of_element(system, e)).fold(Self::default(), Self::plus)
        };
        parallel::reduce(system.contents.elements.len(), chunk, Self::plus).unwrap_or_default()
    }

    /// The totals of an element: of its masses at its nodes, and at cut points where a solid cuts it, between which the
    /// velocity isn't that of the nodes. Its subscale moves its mass, too.
    fn of_element<const D: usize, const N: usize>(system: &VelocityPressureSystem<D, N>, e: usize) -> Self {
        let nodes = system.mesh.elements()[e].map(|node| node as usize);
        let force = nodes.iter().map(|&i| system.force[i]).sum::<Vector<D>>() / N as f64;
        let cut = system.immersed.as_ref().and_then(|immersed| immersed.masses(&system.mesh, e, &system.velocity));
        let mut totals = match cut {
            Some(masses) => masses.fold(Self::default(), |sum, own| sum.plus(Self::of_mass(&own, force))),
            None => nodes.iter().zip(system.contents.elements[e].mass).fold(Self::default(), |sum, (&i, mass)| {
                let own = PointMass { mass, position: system.mesh.nodes()[i], velocity: system.velocity[i] };
                sum.plus(Self::of_mass(&own, system.force[i]))
            }),
        };
        totals.gravity += totals.mass * force.dot(system.subscales.velocity(e));
        totals
    }

    /// The totals of a mass under a body force [m/s²].
    fn of_mass<const D: usize>(own: &PointMass<D>, force: Vector<D>) -> Self {
        let &PointMass { mass, position, velocity } = own;
        Self {
            mass,
            momentum: (velocity * mass).to3(),
            weight: (force * mass).to3(),
            kinetic: 0.5 * mass * velocity.norm_squared(),
            moment: (position * mass).to3(),
            gravity: mass * force.dot(velocity),
        }
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
    /// Rates by the terms of the ledger.
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
#[derive(Debug, Clone, Copy, Default, Pod, Zeroable)]
#[repr(C)]
pub struct ExternalTerms {
    /// Work of gravity [J], or its power [W].
    pub gravity: f64,
    /// Work of tractions and supports [J], or its power [W].
    pub boundary: f64,
    /// Kinetic energy through open boundaries [J] or [W].
    pub openings: f64,
    /// Impulse of gravity, tractions and supports [N s], or their force [N].
    pub impulse: [f64; 3],
    /// Momentum through open boundaries [N s] or [N].
    pub momentum: [f64; 3],
}

/// The sums of [`ExternalTerms`] over time, with the rounding errors of their additions.
#[derive(Debug, Clone, Copy, Default, Pod, Zeroable)]
#[repr(C)]
struct ExternalSums {
    gravity: CompensatedSum,
    boundary: CompensatedSum,
    openings: CompensatedSum,
    impulse: [CompensatedSum; 3],
    momentum: [CompensatedSum; 3],
}

impl ExternalSums {
    fn add(&mut self, terms: [f64; TERMS]) {
        let sums: &mut [CompensatedSum; TERMS] = bytemuck::cast_mut(self);
        sums.iter_mut().zip(terms).for_each(|(sum, term)| sum.add(term));
    }

    fn value(&self) -> ExternalTerms {
        let sums: &[CompensatedSum; TERMS] = bytemuck::cast_ref(self);
        bytemuck::cast(sums.map(CompensatedSum::value))
    }
}

/// The energy ledger since the start, a column of checkpoints.
#[derive(Debug, Clone, Copy, Default, Pod, Zeroable)]
#[repr(C)]
pub struct EnergyLedger {
    /// Works and impulses from outside since the start.
    external: ExternalSums,
    /// Viscous dissipation since the start [J].
    viscous: CompensatedSum,
    /// Powers and forces from outside at the end of the last step.
    pub last: ExternalTerms,
    /// Powers and forces from outside at the end of the step before.
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

impl Record for EnergyLedger {
    type Number = f64;
}

impl EnergyLedger {
    /// Opens the ledger with the kinetic and the surface energy at the start, and the kinetic energy of an impulsive
    /// start [J].
    pub fn open(kinetic: f64, surface: f64, impulsive: f64) -> Self {
        let stored = kinetic + surface;
        let (peak, largest) = (kinetic + impulsive, (stored + impulsive).max(surface));
        Self { stored, impulsive, peak, largest, ..Self::default() }
    }

    /// Works and impulses from outside since the start.
    pub fn external(&self) -> ExternalTerms {
        self.external.value()
    }

    /// Viscous dissipation since the start [J].
    pub fn viscous(&self) -> f64 {
        self.viscous.value()
    }

    /// Sets the work of gravity since the start to the potential energy that the fluids have lost [J].
    pub fn set_gravity(&mut self, lost: f64) {
        self.external.gravity = CompensatedSum::default();
        self.external.gravity.add(lost);
    }

    /// Keeps the largest energies, with those of a state [J].
    pub fn keep_largest(&mut self, totals: &FlowTotals, surface: f64) {
        let ExternalTerms { gravity, boundary, openings, .. } = self.external();
        let terms = [surface, gravity, boundary, openings, self.viscous()];
        let largest = terms.iter().fold(totals.kinetic, |largest, term| largest.max(term.abs()));
        (self.peak, self.largest) = (self.peak.max(totals.kinetic), self.largest.max(largest));
    }

    /// Energy exchanged with boundaries and dissipated since the start [J].
    pub fn exchanged(&self) -> f64 {
        self.external().boundary.abs() + self.viscous()
    }

    /// Kinetic and surface energy at the start, with that of an impulsive start [J].
    pub fn begun(&self) -> f64 {
        [self.stored, self.impulsive].iter().sum()
    }

    /// Energy of the flow and its surfaces that no term explains [J].
    pub fn gained(&self, totals: &FlowTotals, surface: f64) -> f64 {
        let ExternalTerms { gravity, boundary, openings, .. } = self.external();
        let gained: f64 = [gravity, boundary, openings].iter().sum();
        totals.kinetic + surface - (self.stored + gained - self.viscous())
    }

    /// Takes powers and forces from outside as those at the start, of which the first step takes its explicit part.
    pub fn begin<const D: usize>(&mut self, outside: &ExternalRates<D>) {
        self.last = outside.terms();
        self.earlier = self.last;
    }

    /// Adds a step by its `step_weights`, with the powers and forces from outside at its end and its viscous
    /// dissipation [J].
    pub fn add<const D: usize>(&mut self, step_weights: StepWeights, outside: &ExternalRates<D>, viscous: f64) {
        let now = outside.terms();
        let [now_terms, last, earlier] = [now, self.last, self.earlier].map(bytemuck::cast::<_, [f64; TERMS]>);
        self.external.add(std::array::from_fn(|i| {
            step_weights.dt
                * (step_weights.end * now_terms[i] + step_weights.start * last[i] + step_weights.earlier * earlier[i])
        }));
        (self.earlier, self.last) = (self.last, now);
        self.external.boundary.add(std::mem::take(&mut self.impulsive));
        self.viscous.add(viscous);
    }

    /// All terms of the ledger: energies, mass, momentum; `gained` is the energy that no term explains [J].
    pub fn ledger<const D: usize>(&self, totals: &FlowTotals, surface: f64, gained: f64) -> Ledger {
        let (external, viscous) = (self.external(), self.viscous());
        let mut terms = vec![
            BalanceTerm::energy(Stored, "kinetic energy", totals.kinetic),
            BalanceTerm::energy(Stored, "surface energy", surface),
            BalanceTerm::energy(Gain, "work of gravity", external.gravity),
            BalanceTerm::energy(Gain, "work of boundaries", external.boundary),
            BalanceTerm::energy(Gain, "energy through openings", external.openings),
            BalanceTerm::energy(Loss, "viscous dissipation", viscous),
            BalanceTerm::energy(Remainder, "numerical dissipation", -gained),
            BalanceTerm::other("mass", "kg", totals.mass),
        ];
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate().take(D) {
            terms.push(BalanceTerm::other(format!("momentum {name}"), "N s", totals.momentum[axis]));
            terms.push(BalanceTerm::other(format!("external impulse {name}"), "N s", external.impulse[axis]));
            terms.push(BalanceTerm::other(format!("momentum through openings {name}"), "N s", external.momentum[axis]));
        }
        Ledger { terms, ..Ledger::default() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A work of 1 J per step on top of 10¹⁶ J, which a plain sum in double precision would not see.
    #[test]
    fn sums_over_many_steps_keep_what_rounding_takes() {
        let rates = |gravity| ExternalRates::<2> { gravity, ..ExternalRates::default() };
        let mut ledger = EnergyLedger::open(0.0, 0.0, 0.0);
        let implicit = StepWeights { dt: 1.0, end: 1.0, start: 0.0, earlier: 0.0 };
        ledger.add(implicit, &rates(1e16), 1e16);
        for _ in 0..3 {
            ledger.add(implicit, &rates(1.0), 1.0);
        }
        ledger.add(implicit, &rates(-1e16), -1e16);
        assert_eq!((ledger.external().gravity, ledger.viscous()), (3.0, 3.0));
        ledger.set_gravity(7.0);
        assert_eq!(ledger.external().gravity, 7.0);
    }
}
