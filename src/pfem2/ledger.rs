//! Energy and momentum of the flow on the mesh.
//!
//! ```text
//! kinetic      ½ Σ_e Σ_i m_i |v_i|²
//! gravity      Σ m φ at the start − Σ m φ now, φ = −b·x      in a closed box whose fluids keep their volumes, b steady and uniform
//!              Δt Σ m_i b_i·v_i                              elsewhere
//! boundaries   Δt Σ (traction and support)·v_i
//! viscous      Δt Σ_e V μ γ̇²
//! surface      σ A
//! ```
//!
//! The first form of gravity's work is what the fluids have lost of potential energy where they are now: interfaces that run ahead of
//! the velocity, or behind it, show in the books. The second would not see them.
//!
//! Powers and forces are taken with the weights of the step: θ at its end, β₁ at its start, β₂ at the start of the one
//! before (see `step`). What they don't explain is booked as
//! numerical dissipation: of the transport by particles, of the time integration and of the stabilisation.

use super::implicit::Implicit;
use super::shear::shear_rate;
use crate::math::Vector;
use crate::parallel;
use crate::simulation::TermKind::{Gain, Loss, Other, Stored};
use crate::simulation::{BalanceTerm, Ledger};

/// Sums over the mesh.
#[derive(Debug, Clone, Copy, Default)]
pub struct Totals {
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
    /// Power lost to viscosity [W].
    pub viscous: f64,
}

impl Totals {
    /// Of a state.
    pub fn of<const D: usize, const N: usize>(implicit: &Implicit<D, N>) -> Self {
        let chunk = |range: std::ops::Range<usize>| {
            range.map(|e| Self::of_element(implicit, e)).fold(Self::default(), Self::plus)
        };
        parallel::reduce(implicit.contents.len(), chunk, Self::plus).unwrap_or_default()
    }

    fn of_element<const D: usize, const N: usize>(implicit: &Implicit<D, N>, e: usize) -> Self {
        let (simplex, content) = (implicit.mesh.simplex(e), &implicit.contents[e]);
        let nodes = implicit.mesh.elements()[e].map(|node| node as usize);
        let velocity = nodes.map(|i| implicit.velocity[i]);
        let mut totals = Self::default();
        let [mut momentum, mut weight, mut moment] = [Vector::<D>::ZERO; 3];
        for ((m, v), i) in content.mass.iter().zip(&velocity).zip(nodes) {
            totals.mass += m;
            totals.kinetic += 0.5 * m * v.norm_squared();
            moment += implicit.mesh.nodes()[i] * *m;
            momentum += *v * *m;
            weight += implicit.force[i] * *m;
            totals.gravity += m * implicit.force[i].dot(*v);
        }
        totals.viscous = simplex.volume * content.viscosity * shear_rate(&simplex.gradient, &velocity).powi(2);
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
            viscous: self.viscous + other.viscous,
        }
    }
}

/// Powers at the end of a step [W].
#[derive(Debug, Clone, Copy, Default)]
pub struct Powers {
    /// Of gravity.
    pub gravity: f64,
    /// Of tractions and supports.
    pub boundary: f64,
    /// Lost to viscosity.
    pub viscous: f64,
}

/// The running books: [gravity, boundaries, viscous] works since the start [J], the impulse from outside [N s].
#[derive(Debug, Clone, Default)]
pub struct Books {
    /// Works, then impulse: one column of a checkpoint.
    pub entries: Vec<f64>,
    /// Powers and forces at the end of the last step, then those of the step before: one column of a checkpoint.
    pub last: Vec<f64>,
    /// Kinetic and surface energy at the start [J].
    pub start: Vec<f64>,
    /// The largest kinetic energy so far [J].
    pub peak: Vec<f64>,
}

impl Books {
    /// Opens the books with the kinetic and the surface energy at the start [J], after walls and inlets have taken hold.
    pub fn open(kinetic: f64, surface: f64) -> Self {
        Self { entries: vec![0.0; 6], last: vec![0.0; 12], start: vec![kinetic + surface], peak: vec![kinetic] }
    }

    /// Books the work of gravity since the start by what the fluids have lost of potential energy [J].
    pub fn fall(&mut self, lost: f64) {
        self.entries[0] = lost;
    }

    /// Notes the kinetic energy of a state [J].
    pub fn note(&mut self, kinetic: f64) {
        self.peak[0] = self.peak[0].max(kinetic);
    }

    /// Work of gravity since the start [J].
    pub fn gravity(&self) -> f64 {
        self.entries[0]
    }

    /// What boundaries and friction have given and taken since the start [J].
    pub fn exchanged(&self) -> f64 {
        self.entries[1].abs() + self.entries[2]
    }

    /// Kinetic and surface energy at the start [J].
    pub fn begun(&self) -> f64 {
        self.start[0]
    }

    /// The largest kinetic energy so far [J].
    pub fn peak(&self) -> f64 {
        self.peak[0]
    }

    /// What nothing explains of the energy there is, with that of the surfaces [J].
    pub fn gained(&self, totals: &Totals, surface: f64) -> f64 {
        let [gravity, boundary, viscous] = [self.entries[0], self.entries[1], self.entries[2]];
        totals.kinetic + surface - (self.start[0] + gravity + boundary - viscous)
    }

    /// Notes the powers and the outer force at the start, of which the first step takes its explicit share.
    pub fn begin(&mut self, powers: Powers, force: [f64; 3]) {
        self.last = [entries(powers, force); 2].concat();
    }

    /// Books a step of `dt` with the powers and the outer force at its end; `shares` are θ, β₁ and β₂.
    pub fn add(&mut self, dt: f64, shares: [f64; 3], powers: Powers, force: [f64; 3]) {
        let (last, earlier) = self.last.split_at_mut(6);
        for (k, now) in entries(powers, force).into_iter().enumerate() {
            self.entries[k] += dt * (shares[0] * now + shares[1] * last[k] + shares[2] * earlier[k]);
            (earlier[k], last[k]) = (last[k], now);
        }
    }

    /// All terms of the ledger: energies, mass, momentum.
    pub fn ledger<const D: usize>(&self, totals: &Totals, surface: f64) -> Ledger {
        let [gravity, boundary, viscous] = [self.entries[0], self.entries[1], self.entries[2]];
        let term = |kind, name: &str, unit, value| BalanceTerm { name: name.to_owned(), unit, kind, value };
        let mut terms = vec![
            term(Stored, "kinetic energy", "J", totals.kinetic),
            term(Stored, "surface energy", "J", surface),
            term(Gain, "work of gravity", "J", gravity),
            term(Gain, "work of boundaries", "J", boundary),
            term(Loss, "viscous dissipation", "J", viscous),
            term(Loss, "numerical dissipation", "J", -self.gained(totals, surface)),
            term(Other, "mass", "kg", totals.mass),
        ];
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate().take(D) {
            terms.push(term(Other, &format!("momentum {name}"), "N s", totals.momentum[axis]));
            terms.push(term(Other, &format!("external impulse {name}"), "N s", self.entries[3 + axis]));
        }
        Ledger { terms }
    }
}

/// Powers [W], then forces [N]: a column of the books.
fn entries(powers: Powers, force: [f64; 3]) -> [f64; 6] {
    [powers.gravity, powers.boundary, powers.viscous, force[0], force[1], force[2]]
}
