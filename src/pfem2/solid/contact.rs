//! The force of a contact: unilateral along the normal, with Coulomb's friction, linear in the velocity (theory J.8, J.9).
//!
//! ```text
//! f = A k (g − d^{n+1}) n − c (1 − n ⊗ n) v,    d^{n+1} = d* + n·Σ c_i (û_i + Δ v_i − u_i*),    v = Σ c_i v_i
//! c = μ f_n/max(|v_t|, ε),   f_n: normal force of the last step,   v_t: 2 vⁿ − vⁿ⁻¹ along the surface,   ε = 10⁻⁴ g/Δt
//! ```
//!
//! c_i f acts on node i: c is one at the point that meets a wall, and −N_b at the nodes of a facet of a solid that it meets.
//!
//! Rigid solids meet walls and each other by an impulse f Δ instead, which gives them a velocity (theory (J.16a)):
//!
//! ```text
//! f = 10⁴ m/Δ (w − n·v^{n+1}) n − c (1 − n ⊗ n) v^{n+1},      where it pushes
//! w = (r − dⁿ)/Δt + (g − r)/(100 Δt),    r = min(g, least dⁿ of both solids there)
//! w = e (dⁿ − d*)/Δt      where solids with a restitution collide: d* < r, least of both solids there, (dⁿ − d*)/Δt > 2 Δt |n·Σ c_i a_iⁿ|
//! ```
//!
//! It comes as near as the gap and rests. A solid that has come nearer is lifted slowly; by r, others of its points may come as near as the
//! nearest, so that it rolls. Which contacts push, and c, is found beforehand (see `impulses`).

use super::equations::LinearForces;
use super::setup::SolidSetup;
use super::structure::Structure;
use crate::math::{Tensor, Vector};

/// Gap in which fluid stays, over the size of an element of its mesh.
pub const GAP: f64 = 0.5;

/// How far solids look for what they may meet, over the gap, besides the way that they go in a step.
pub const REACH: f64 = 1.25;

/// Stiffness of a contact over that of an element of the solid.
const STIFFNESS: f64 = 10.0;

/// Resistance of an impulse over the mass by Δ: a rigid solid reaches its speed to a ten-thousandth.
const IMPULSE: f64 = 1e4;

/// What collides approaches by more than this many times what other forces give it in a step: what rests on something doesn't.
const IMPACT: f64 = 2.0;

/// Part of the gap by which places of a solid may differ that meet another one at once.
const LEVEL: f64 = 1e-3;

/// Part of its distance from the gap by which a rigid solid that rests comes nearer to it per step.
const RETURN: f64 = 0.01;

/// Product of two normals of one point from which they are those of the same contact.
const SAME: f64 = 0.8;

/// Way per step, over the gap, up to which what sticks may creep.
const CREEP: f64 = 1e-4;

/// What pushes back where a solid is met.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Hardness {
    /// Pressure per depth of an elastic solid, 10 (λ + 2 μ)/h [Pa/m].
    Elastic(f64),
    /// A rigid one is stopped by an impulse.
    Rigid {
        /// Mass [kg].
        mass: f64,
        /// Coefficient of restitution.
        restitution: f64,
    },
}

impl Hardness {
    /// Of a solid with this `mass` [kg] and facets of this `size` [m].
    pub fn new<const D: usize>(structure: &Structure<D>, setup: &SolidSetup<D>, mass: f64, size: f64) -> Self {
        match setup.law.is_rigid() {
            true => Self::Rigid { mass, restitution: setup.restitution },
            false => Self::Elastic(STIFFNESS * structure.wave_modulus(setup) / size),
        }
    }

    /// That of two solids that meet: the softer of two elastic ones, the elastic one beside a rigid one; of two rigid ones the heavier
    /// counts, and the root of the product of their restitutions.
    #[must_use]
    pub fn with(self, other: Self) -> Self {
        match (self, other) {
            (Self::Elastic(a), Self::Elastic(b)) => Self::Elastic(a.min(b)),
            (Self::Rigid { mass: a, restitution: e }, Self::Rigid { mass: b, restitution: f }) => {
                Self::Rigid { mass: a.max(b), restitution: (e * f).sqrt() }
            }
            (elastic @ Self::Elastic(_), _) | (_, elastic) => elastic,
        }
    }
}

/// Where a point of a solid meets something, about the prediction of a step.
#[derive(Debug, Clone, PartialEq)]
pub struct Meeting<const D: usize> {
    /// Number of the point.
    pub point: usize,
    /// c_i.
    pub shares: Vec<(u32, f64)>,
    /// n, away from what is met.
    pub normal: Vector<D>,
    /// d* [m].
    pub distance: f64,
    /// g [m].
    pub gap: f64,
    /// A [m²].
    pub area: f64,
    /// k, or that of rigid solids.
    pub hardness: Hardness,
    /// μ.
    pub friction: f64,
}

impl<const D: usize> Meeting<D> {
    /// Depth of an elastic solid in the gap, over it.
    pub(super) fn depth(&self) -> f64 {
        match self.hardness {
            Hardness::Elastic(_) => (self.gap - self.distance).max(0.0) / self.gap.max(f64::MIN_POSITIVE),
            Hardness::Rigid { .. } => 0.0,
        }
    }

    /// dⁿ [m].
    pub fn distance_at_start(&self, step: &ContactStep<'_, D>) -> f64 {
        self.distance - self.normal.dot(relative(&self.shares, step.way))
    }
}

/// What a contact needs to know of a step.
pub struct ContactStep<'a, const D: usize> {
    /// True where the step is solved anew: then d* alone says what touches.
    pub anew: bool,
    /// Δt [s].
    pub dt: f64,
    /// Δ [s].
    pub delta: f64,
    /// û − u* of all nodes [m].
    pub rest: &'a dyn Fn(usize) -> Vector<D>,
    /// u* − uⁿ of all nodes [m].
    pub way: &'a dyn Fn(usize) -> Vector<D>,
    /// vⁿ of all nodes [m/s].
    pub velocity: &'a dyn Fn(usize) -> Vector<D>,
    /// vⁿ − vⁿ⁻¹ of all nodes [m/s].
    pub gained: &'a dyn Fn(usize) -> Vector<D>,
    /// aⁿ of all nodes, that of rigid solids without impulses [m/s²].
    pub acceleration: &'a dyn Fn(usize) -> Vector<D>,
}

/// A contact during a step.
#[derive(Debug, Clone, PartialEq)]
pub struct Contact<const D: usize> {
    /// Number of the point.
    pub point: usize,
    /// True if its force is in the equations: a place near something touches nothing where it would pull.
    pub acts: bool,
    shares: Vec<(u32, f64)>,
    normal: Vector<D>,
    /// A k g of elastic solids: the force that would close the gap [N].
    closing: f64,
    /// Normal force without a velocity [N].
    push: f64,
    /// Change of the normal force with the normal velocity [N s/m].
    resistance: f64,
    /// c [N s/m].
    friction: f64,
    /// Speed with which an elastic solid arrives that didn't touch in the last step [m/s].
    pub arrival: Option<f64>,
    /// That of rigid solids.
    impulse: Option<Impulse<D>>,
}

/// A contact of rigid solids.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Impulse<const D: usize> {
    /// Σ c_i v_iⁿ [m/s].
    before: Vector<D>,
    /// w [m/s].
    pub wanted: f64,
    /// Coefficient of friction.
    pub friction: f64,
    /// ε [m/s].
    pub slowest: f64,
    /// Δ/Δt: the mean force of a step over the one that acts for Δ.
    share: f64,
    is_collision: bool,
}

impl<const D: usize> Contact<D> {
    /// The contact of a meeting, where the point had this normal force in the last step [N]. That of an elastic solid acts at first where d* < g
    /// or it pushed. `nearest`: the least dⁿ and d* of both solids there [m].
    pub fn new(last: Vector<D>, meeting: Meeting<D>, nearest: [f64; 2], step: &ContactStep<'_, D>) -> Self {
        match meeting.hardness {
            Hardness::Elastic(pressure) => Self::elastic(pressure, last, meeting, step),
            Hardness::Rigid { mass, restitution } => Self::rigid([mass, restitution], meeting, nearest, step),
        }
    }

    fn elastic(pressure: f64, last: Vector<D>, meeting: Meeting<D>, step: &ContactStep<'_, D>) -> Self {
        let Meeting { point, shares, normal, distance, gap, area, friction, .. } = meeting;
        let pushed = last.dot(normal).max(0.0);
        let velocity = relative(&shares, step.velocity);
        let along = velocity + relative(&shares, step.gained);
        let along = along - normal * along.dot(normal);
        let stiffness = pressure * area;
        Self {
            point,
            acts: distance < gap || pushed > 0.0 && !step.anew,
            normal,
            closing: stiffness * gap,
            push: stiffness * (gap - distance - normal.dot(relative(&shares, step.rest))),
            resistance: stiffness * step.delta,
            friction: friction * pushed / along.norm().max(slowest(gap, step.dt)),
            arrival: (pushed == 0.0).then(|| -velocity.dot(normal)),
            impulse: None,
            shares,
        }
    }

    fn rigid([mass, restitution]: [f64; 2], meeting: Meeting<D>, nearest: [f64; 2], step: &ContactStep<'_, D>) -> Self {
        let reached = meeting.gap.min(nearest[0]);
        let start = meeting.distance_at_start(step);
        let Meeting { point, shares, normal, distance, gap, friction, .. } = meeting;
        let before = relative(&shares, step.velocity);
        let slow = IMPACT * step.dt * relative(&shares, step.acceleration).dot(normal).abs();
        // By the way that is predicted: points of what rolls come near on curves, and others are nearer then.
        let speed = (distance - start) / step.dt;
        let is_nearest = distance < nearest[1] + LEVEL * gap;
        let is_collision = distance < reached && is_nearest && speed < -slow;
        let wanted = match is_collision && restitution > 0.0 {
            true => -restitution * speed,
            false => (reached - start + RETURN * (gap - reached)) / step.dt,
        };
        let (resistance, slowest) = (IMPULSE * mass / step.delta, slowest(gap, step.dt));
        let share = step.delta / step.dt;
        let impulse = Some(Impulse { before, wanted, friction, slowest, share, is_collision });
        Self {
            point,
            acts: true,
            normal,
            closing: 0.0,
            push: resistance * wanted,
            resistance,
            friction: 0.0,
            arrival: None,
            impulse,
            shares,
        }
    }

    /// True if it is that of a meeting, and acts.
    pub(super) fn is_at(&self, meeting: &Meeting<D>) -> bool {
        self.acts && self.point == meeting.point && self.normal.dot(meeting.normal) > SAME
    }

    /// Normal force on the point of an elastic solid at the velocities of nodes at the end of the step [m/s]; negative where it pulls [N].
    pub(super) fn elastic_push(&self, velocity: impl Fn(usize) -> Vector<D>) -> f64 {
        if self.impulse.is_some() { 0.0 } else { self.force(velocity).dot(self.normal) }
    }

    /// Depth of an elastic solid in the gap with this normal force [N], over the gap.
    pub(super) fn depth(&self, force: f64) -> f64 {
        if self.closing > 0.0 { force / self.closing } else { 0.0 }
    }

    /// Its nodes.
    pub(super) fn nodes(&self) -> impl Iterator<Item = usize> + '_ {
        self.shares.iter().map(|&(node, _)| node as usize)
    }

    /// That of rigid solids.
    pub(super) fn impulse(&self) -> Option<&Impulse<D>> {
        self.impulse.as_ref()
    }

    /// Σ c_i of nodes.
    pub(super) fn shares(&self) -> &[(u32, f64)] {
        &self.shares
    }

    /// n.
    pub(super) fn normal(&self) -> Vector<D> {
        self.normal
    }

    /// Change of the normal force with the normal velocity [N s/m].
    pub(super) fn resistance(&self) -> f64 {
        self.resistance
    }

    /// With c [N s/m].
    #[must_use]
    pub(super) fn with_friction(self, friction: f64) -> Self {
        Self { friction, ..self }
    }

    /// Minus the derivative of the force by the velocity [N s/m].
    fn matrix(&self) -> Tensor<D> {
        let normal = Tensor::outer(self.normal, self.normal);
        normal * self.resistance + (Tensor::identity() - normal) * self.friction
    }

    /// Adds its force on each of its nodes.
    pub fn add(&self, forces: &mut LinearForces) {
        let (matrix, load) = (self.matrix(), self.normal * self.push);
        for &(row, share) in &self.shares {
            forces.add_load(row, load * share);
            for &(column, other) in &self.shares {
                forces.add_block((row, column), &(matrix * (share * other)));
            }
        }
    }

    /// Force on the point at the velocities of nodes [m/s] at the end of the step [N].
    fn force(&self, velocity: impl Fn(usize) -> Vector<D>) -> Vector<D> {
        self.normal * self.push - self.matrix().apply(relative(&self.shares, velocity))
    }

    /// Normal force on the point at the velocities of nodes at the end of the step [m/s]: there, and of impulses the mean over the step [N].
    pub fn normal_force(&self, velocity: impl Fn(usize) -> Vector<D>) -> Vector<D> {
        let share = self.impulse.map_or(1.0, |impulse| impulse.share);
        self.normal * (self.force(velocity).dot(self.normal) * share)
    }

    /// The forces that act on nodes [N] for Δ as an impulse, at the velocities of nodes [m/s].
    pub fn impulses(&self, velocity: impl Fn(usize) -> Vector<D>) -> Vec<(usize, Vector<D>)> {
        if self.impulse.is_none() {
            return Vec::new();
        }
        let force = self.force(velocity);
        self.shares.iter().map(|&(node, share)| (node as usize, force * share)).collect()
    }

    /// The nodes of solids that collide.
    pub fn colliding(&self) -> impl Iterator<Item = usize> + '_ {
        let collides = self.impulse.is_some_and(|impulse| impulse.is_collision);
        self.shares.iter().filter(move |_| collides).map(|&(node, _)| node as usize)
    }

    /// What the power of an impulse, which the mean velocity takes, differs by from the force at the end of the step times the velocity
    /// there [W]; θ is the implicit share of the step.
    pub fn excess_power(&self, theta: f64, velocity: impl Fn(usize) -> Vector<D>) -> f64 {
        let Some(Impulse { before, .. }) = self.impulse else { return 0.0 };
        let after = relative(&self.shares, &velocity);
        self.force(velocity).dot((before + after) * (0.5 * theta) - after)
    }
}

/// ε: the velocity along a surface up to which what sticks may creep [m/s].
fn slowest(gap: f64, dt: f64) -> f64 {
    CREEP * gap.abs().max(f64::MIN_POSITIVE) / dt
}

/// Σ c_i v_i.
fn relative<const D: usize>(shares: &[(u32, f64)], of: impl Fn(usize) -> Vector<D>) -> Vector<D> {
    shares.iter().map(|&(node, share)| of(node as usize) * share).sum()
}
