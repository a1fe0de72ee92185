//! What a step books: the work of the forces on nodes, and what transfers and stress updates lost or made up (theory A.17).

use super::ledger::{AccountId, Books};
use crate::mpm::particles::motion::Summary;
use crate::mpm::step::Step;
use crate::mpm::transfer::Answer;
use crate::mpm::{Field, Mpm, Node};
use crate::parallel;
use crate::simulation::TermKind;

/// The accounts that the bodies book to.
#[derive(Debug, Clone, Copy)]
pub(in crate::mpm) struct Accounts {
    pub gravity: AccountId,
    pub traction: AccountId,
    pub wall: AccountId,
    pub atmosphere: AccountId,
    pub wall_loss: AccountId,
    pub transfer: AccountId,
    pub heat: AccountId,
    pub stress: AccountId,
    /// What forces would have done over displacements of particles, which change places alone; no part of the closure.
    pub displacement: AccountId,
    pub volume: AccountId,
}

impl Accounts {
    /// Opens the accounts, in the order in which the ledger shows them.
    pub(in crate::mpm) fn open() -> (Books, Self) {
        let mut books = Books::default();
        let accounts = Self {
            gravity: books.open("work of gravity", TermKind::Gain),
            traction: books.open("work of tractions", TermKind::Gain),
            wall: books.open("work of walls", TermKind::Gain),
            atmosphere: books.open("work of the atmosphere", TermKind::Gain),
            stress: books.open("stress update error", TermKind::Gain),
            volume: books.open("work of volume corrections", TermKind::Gain),
            heat: books.open("heat of transfer dissipation", TermKind::Gain),
            wall_loss: books.open("wall dissipation", TermKind::Loss),
            transfer: books.open("transfer dissipation", TermKind::Loss),
            displacement: books.open("work over displacements", TermKind::Other),
        };
        (books, accounts)
    }
}

/// What the grid did to the bodies during a step [J].
#[derive(Debug, Clone, Copy, Default)]
pub(in crate::mpm) struct Tally {
    /// Δt Σ f_I · v̂_I over all forces.
    pub nodes: f64,
    /// The same over the forces of stresses, gravity and tractions.
    pub applied: f64,
    /// Of gravity and tractions.
    pub external: f64,
    /// What the noise filter leaves to the particles as heat.
    pub heat: f64,
}

/// What the forces on nodes did during a step [J], and the mass they act on [kg].
#[derive(Debug, Clone, Copy, Default)]
pub(in crate::mpm) struct NodeWork {
    pub all: f64,
    pub applied: f64,
    pub weight: f64,
    pub mass: f64,
}

impl NodeWork {
    pub fn and(self, other: Self) -> Self {
        Self {
            all: self.all + other.all,
            applied: self.applied + other.applied,
            weight: self.weight + other.weight,
            mass: self.mass + other.mass,
        }
    }
}

impl<const D: usize> Mpm<D> {
    /// Kinetic and internal energy of all bodies [J].
    pub(in crate::mpm) fn body_energies(&self) -> [f64; 2] {
        let kinetic = self.bodies.iter().map(|body| body.particles.kinetic_energy()).sum();
        let internal = self.bodies.iter().map(|body| body.particles.internal_energy()).sum();
        [kinetic, internal]
    }

    /// Takes from the books the work of stresses on nodes that nobody gets.
    ///
    /// Nodes do the work Δt f·½(v⁻ + v⁺), but FLIP gives the particles Δt f·½(v⁻ + ṽ) of it, and the forces f of stresses that are
    /// updated with ṽ take no more from the internal energy. To book ½ Δt f·(v⁺ − ṽ) as lost by one and made by the
    /// other would hide what they do. What PIC takes (its share β of the velocity; APIC is all PIC) is lost for good.
    pub(in crate::mpm) fn leave_unspent(&mut self, field: usize, step: &Step) {
        let (gravity, dt) = (self.uniform_gravity(step.t), step.momentum_dt);
        let kept = 1.0 - self.pic_share(dt);
        let Field { nodes, applied, velocity, .. } = &self.grid.fields[field];
        let unspent = 0.5
            * kept
            * dt
            * parallel::sum(nodes.len(), |n| {
                let Node { mass, momentum, .. } = nodes[n];
                if mass > 0.0 { (applied[n] - gravity * mass).dot(momentum - velocity[n]) } else { 0.0 }
            });
        self.tally.nodes -= unspent;
        self.tally.applied -= unspent;
    }

    /// Books what walls and obstacles did to membranes.
    pub(in crate::mpm) fn book_walls_of_sheets(&mut self, step: &Step) {
        let done = self.walls.book_sheets(&self.coupling.contact.wall_pushes(), step.momentum_dt);
        self.books.add(self.accounts.wall, done.work);
        self.books.add(self.accounts.wall_loss, done.dissipation);
        self.books.push(done.impulse.to3());
    }

    /// Books what the transfers lost, what the atmosphere did and what the stress update made up (theory A.17).
    ///
    /// Of p dV, which gases give, nodes get (p − p_a) dV and the atmosphere the rest (`ambient`).
    pub(in crate::mpm) fn close_books(&mut self) {
        let all = self.summaries.iter().fold(Summary::default(), |sum, &summary| sum.and(summary));
        let Summary { kinetic, internal, heat, .. } = all;
        let heat = heat + self.tally.heat;
        let [kinetic_before, internal_before] = self.energy;
        self.books.add(self.accounts.transfer, self.tally.nodes - (kinetic - kinetic_before));
        let internal_work = self.tally.applied - self.tally.external;
        self.books.add(self.accounts.heat, heat);
        let displaced = self.displaced_atmosphere();
        let expansion = displaced - self.displaced;
        self.books.add(self.accounts.atmosphere, -expansion);
        self.books.add(self.accounts.stress, internal - internal_before - heat + internal_work + expansion);
        self.energy = [kinetic, internal];
        self.displaced = displaced;
    }
}
