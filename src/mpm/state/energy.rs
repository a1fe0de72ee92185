//! The energy of the bodies over a step and its ledger, which closes to round-off: the work of the forces on nodes, and
//! what transfers and stress updates lost or made up (theory A.17).
//!
//! With v̂ = ½(v⁻ + v⁺) at the nodes and Δt the step of the momentum:
//!
//! ```text
//! nodes          ΔK_I = Δt Σ f_I · v̂_I          exact, since p⁺ = p⁻ + Δt f; of stresses that are updated with velocities
//!                                               mapped back, less the part that particles don't get (`leave_unspent`)
//! transfer loss  D    = Σ ΔK_I − ΔK_p           FLIP, PIC, APIC, filter and bound p⁻
//! its heat       Q    = Σ q_p                   what of D the particles keep (`heat`)
//! atmosphere     W_a  = −Δ Σ p_a V_p            work on gases whose forces count from p_a (`ambient`)
//! stress error   ε_s  = ΔU_p − Q + Δt Σ f_I^int · v̂_I − W_a   first: gains; modified last: loses
//! external       W    = Δt Σ F_p · Σ N_Ip v̂_I   equals Δt Σ f_I^ext · v̂_I
//! walls          W_w − D_w = Δt Σ f_I^wall · v̂_I
//! balance        Δ(K + U) = Σ gains − Σ losses + closure
//! ```
//!
//! The closure ([`Ledger::closure`](crate::simulation::Ledger::closure)) is what no term accounts for: f_I is booked
//! where it is made, so it shows any force that changed a node without being booked.

use crate::math::Vector;
use crate::mpm::grid::{NodeMotion, VelocityField};
use crate::mpm::particles::{Bodies, Body, Reduce, Summary};
use crate::mpm::wall::WallWork;
use crate::parallel;
use crate::simulation::{LedgerSums, TermId, TermKind};

/// Terms of the bodies in the ledger.
#[derive(Debug, Clone, Copy)]
pub(in crate::mpm) struct BodyTerms {
    pub gravity: TermId,
    pub traction: TermId,
    pub wall: TermId,
    pub atmosphere: TermId,
    pub wall_loss: TermId,
    pub transfer: TermId,
    pub heat: TermId,
    pub stress: TermId,
    /// Work that forces would have done over displacements of particles, which change places alone; no part
    /// of the closure.
    pub displacement: TermId,
    pub volume: TermId,
}

impl BodyTerms {
    /// Adds the terms, in the order in which the ledger shows them.
    fn add() -> (LedgerSums, Self) {
        let mut sums = LedgerSums::default();
        let terms = Self {
            gravity: sums.add_term("work of gravity", TermKind::Gain),
            traction: sums.add_term("work of tractions", TermKind::Gain),
            wall: sums.add_term("work of walls", TermKind::Gain),
            atmosphere: sums.add_term("work of the atmosphere", TermKind::Gain),
            stress: sums.add_term("stress update error", TermKind::Gain),
            volume: sums.add_term("work of volume corrections", TermKind::Gain),
            heat: sums.add_term("heat of transfer dissipation", TermKind::Gain),
            wall_loss: sums.add_term("wall dissipation", TermKind::Loss),
            transfer: sums.add_term("transfer dissipation", TermKind::Loss),
            displacement: sums.add_term("work over displacements", TermKind::Other),
        };
        (sums, terms)
    }
}

/// The work of the grid on the bodies during a step [J].
#[derive(Debug, Clone, Copy, Default)]
pub(in crate::mpm) struct GridWork {
    /// Δt Σ f_I · v̂_I over all forces.
    pub nodes: f64,
    /// Δt Σ f_I · v̂_I over the forces of stresses, gravity and tractions.
    pub applied: f64,
    /// Work of gravity and tractions.
    pub external: f64,
    /// The part of the noise filter's loss that the particles keep as heat.
    pub heat: f64,
}

/// The work of the forces on nodes during a step [J], and the mass they act on [kg].
#[derive(Debug, Clone, Copy, Default)]
pub(in crate::mpm) struct ForceWork {
    /// Work of all forces.
    pub all: f64,
    /// Work of stresses, gravity and tractions.
    pub applied: f64,
    /// Work of gravity.
    pub weight: f64,
    /// The mass [kg].
    pub mass: f64,
}

impl ForceWork {
    /// The sum of both.
    pub fn plus(self, other: Self) -> Self {
        Self {
            all: self.all + other.all,
            applied: self.applied + other.applied,
            weight: self.weight + other.weight,
            mass: self.mass + other.mass,
        }
    }
}

/// The energy of the bodies and its ledger.
#[derive(Debug)]
pub(in crate::mpm) struct Energy {
    /// Gains, losses and the impulse of gravity, tractions and walls since the start.
    pub sums: LedgerSums,
    pub terms: BodyTerms,
    /// Kinetic energy of the bodies [J].
    pub kinetic: f64,
    /// Internal energy of the bodies [J].
    pub internal: f64,
    /// Σ p_a V_p, the energy that gases have pushed their atmosphere away with [J].
    pub displaced: f64,
    /// The work of this step.
    pub work: GridWork,
}

impl Energy {
    /// An empty ledger.
    pub fn new() -> Self {
        let (sums, terms) = BodyTerms::add();
        Self { sums, terms, kinetic: 0.0, internal: 0.0, displaced: 0.0, work: GridWork::default() }
    }

    /// The energies that bodies start with, and those that are `stored` elsewhere [J].
    pub fn start<const D: usize>(&mut self, bodies: &Bodies<D>, stored: f64) {
        self.kinetic = bodies.iter().map(|body| body.particles.kinetic_energy()).sum();
        self.internal = bodies.iter().map(|body| body.particles.internal_energy()).sum();
        self.displaced = displaced_atmosphere(bodies);
        self.sums.set_start(stored + (self.kinetic + self.internal));
    }

    /// Books the work of all forces on the nodes of a field, under `gravity` [m/s²] over `dt` [s].
    pub fn add_nodes<const D: usize>(&mut self, work: ForceWork, gravity: Vector<D>, dt: f64) {
        self.work.nodes += work.all;
        self.work.applied += work.applied;
        self.work.external += work.weight;
        self.sums.add(self.terms.gravity, work.weight);
        self.sums.add_impulse((gravity * (work.mass * dt)).to3());
    }

    /// Books the work and impulse of external forces on the particles of a body over `dt` [s].
    pub fn add_external<const D: usize>(&mut self, body: &Body<D>, dt: f64) {
        let (all, tractions, impulse) = body.external_work(dt);
        self.work.external += all;
        self.sums.add(self.terms.gravity, all - tractions);
        self.sums.add(self.terms.traction, tractions);
        self.sums.add_impulse(impulse.to3());
    }

    /// Books the work of walls and obstacles, their dissipation and their impulse.
    pub fn add_walls<const D: usize>(&mut self, done: &WallWork<D>) {
        self.sums.add(self.terms.wall, done.work);
        self.sums.add(self.terms.wall_loss, done.dissipation);
        self.sums.add_impulse(done.impulse.to3());
    }

    /// Books the heat that the noise filter leaves to the particles [J], and the work of moving walls on filtered
    /// velocities, which the particles get or the filter takes.
    pub fn add_filter<const D: usize>(&mut self, heat: f64, done: &WallWork<D>) {
        self.work.heat += heat;
        self.work.nodes += done.work;
        self.sums.add(self.terms.wall, done.work);
        self.sums.add_impulse(done.impulse.to3());
    }

    /// Books the work of volume corrections, which the internal energy has taken up [J].
    pub fn add_volume_corrections(&mut self, work: f64) {
        self.sums.add(self.terms.volume, work);
        self.internal += work;
    }

    /// Takes from the work of a field's forces, under `gravity` [m/s²] over `dt` [s], the work of stresses on nodes
    /// that neither particles nor stresses get; `kept` is the fraction of the velocities that is not PIC's.
    ///
    /// Nodes do the work Δt f·½(v⁻ + v⁺), but FLIP gives the particles Δt f·½(v⁻ + ṽ) of it, and the forces f
    /// of stresses that are updated with ṽ take no more from the internal energy. To book ½ Δt f·(v⁺ − ṽ) as lost by
    /// one and made by the other would hide what they do. What PIC takes (its fraction β of the velocity; APIC is all
    /// PIC) is lost.
    pub fn leave_unspent<const D: usize>(&mut self, field: &VelocityField<D>, gravity: Vector<D>, dt: f64, kept: f64) {
        let VelocityField { nodes, applied, velocity, .. } = field;
        let nodes = NodeMotion::of(nodes);
        let unspent = 0.5
            * kept
            * dt
            * parallel::sum(nodes.len(), |n| {
                let mass = nodes[n].mass();
                if mass > 0.0 { (applied[n] - gravity * mass).dot(nodes[n].velocity() - velocity[n]) } else { 0.0 }
            });
        self.work.nodes -= unspent;
        self.work.applied -= unspent;
    }

    /// Books the losses of the transfers, the work of the atmosphere and the error of the stress update (theory A.17).
    ///
    /// Of p dV, which gases give, nodes get (p − p_a) dV and the atmosphere the rest (`ambient`).
    pub fn close_step<const D: usize>(&mut self, bodies: &Bodies<D>) {
        let all = bodies.iter().fold(Summary::default(), |sum, body| sum.plus(body.summary));
        let Summary { kinetic, internal, heat, .. } = all;
        let heat = heat + self.work.heat;
        self.sums.add(self.terms.transfer, self.work.nodes - (kinetic - self.kinetic));
        let internal_work = self.work.applied - self.work.external;
        self.sums.add(self.terms.heat, heat);
        let displaced = displaced_atmosphere(bodies);
        let expansion = displaced - self.displaced;
        self.sums.add(self.terms.atmosphere, -expansion);
        self.sums.add(self.terms.stress, internal - self.internal - heat + internal_work + expansion);
        (self.kinetic, self.internal) = (kinetic, internal);
        self.displaced = displaced;
    }

    /// All energies [J]: finite as long as every term is.
    pub fn sum(&self) -> f64 {
        self.kinetic + self.internal + self.sums.sum()
    }
}

/// Σ p_a V_p of all bodies [J].
fn displaced_atmosphere<const D: usize>(bodies: &Bodies<D>) -> f64 {
    bodies.iter().map(Body::displaced_atmosphere).sum()
}
