//! The force of a contact: unilateral along the normal, with Coulomb's friction, linear in the velocity (theory J.8, J.9).
//!
//! ```text
//! f = A k (g − d^{n+1}) n − c (1 − n ⊗ n) v,    d^{n+1} = d* + n·Σ c_i (û_i + Δ v_i − u_i*),    v = Σ c_i v_i
//! c = μ f_n/max(|v_t|, ε),   f_n: normal force of the last step,   v_t: 2 vⁿ − vⁿ⁻¹ along the surface,   ε = 10⁻⁴ g/Δt
//! ```
//!
//! c_i f acts on node i: c is one at the point that meets a wall, and −N_b at the nodes of a facet of a solid that it meets.
//!
//! Rigid solids with a coefficient of restitution e > 0 bounce, by an impulse that ends their steps before (theory (J.16a)):
//!
//! ```text
//! f = 10³ k Δ (−e v_n^n − n·v^{n+1}) n,    v_n^n = n·Σ c_i v_iⁿ < 0,    |v_n^n| > 2 |n·Σ c_i (v_iⁿ − v_iⁿ⁻¹)|
//! ```

use super::equations::LinearForces;
use super::setup::SolidSetup;
use super::structure::Structure;
use crate::math::{Tensor, Vector};

/// Gap in which fluid stays, over the size of an element of its mesh.
pub const GAP: f64 = 0.5;

/// Stiffness of a contact over that of an element of the solid; of a rigid one, over its mass by Δ².
const STIFFNESS: f64 = 10.0;

/// Stiffness of a bounce over that of the contact of a rigid solid: it reaches its speed to a ten-thousandth.
const BOUNCE: f64 = 1e3;

/// What bounces is faster than this many times what it has gained in the last step: what rests on something doesn't.
const IMPACT: f64 = 2.0;

/// Way per step, over the gap, up to which what sticks may creep.
const CREEP: f64 = 1e-4;

/// What pushes back where a solid is met.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Hardness {
    /// Pressure per depth of an elastic solid, 10 (λ + 2 μ)/h [Pa/m].
    Elastic(f64),
    /// Mass of a rigid one [kg]: it is stopped within a step.
    Rigid(f64),
}

impl Hardness {
    /// Of a solid with facets of this `size` [m].
    pub fn new<const D: usize>(structure: &Structure<D>, setup: &SolidSetup<D>, mass: f64, size: f64) -> Self {
        match setup.law.is_rigid() {
            true => Self::Rigid(mass),
            false => Self::Elastic(STIFFNESS * structure.wave_modulus(setup) / size),
        }
    }

    /// True of a rigid solid.
    pub fn is_rigid(self) -> bool {
        matches!(self, Self::Rigid(_))
    }

    /// A k of a point with the area `area` [m²] in a step with the implicit part `delta` [s] [N/m].
    pub fn stiffness(self, area: f64, delta: f64) -> f64 {
        match self {
            Self::Elastic(pressure) => pressure * area,
            Self::Rigid(mass) => STIFFNESS * mass / (delta * delta),
        }
    }

    /// That of two solids that meet: the softer of two elastic ones, the elastic one beside a rigid one, the heavier of two rigid ones.
    #[must_use]
    pub fn with(self, other: Self) -> Self {
        match (self, other) {
            (Self::Elastic(a), Self::Elastic(b)) => Self::Elastic(a.min(b)),
            (Self::Rigid(a), Self::Rigid(b)) => Self::Rigid(a.max(b)),
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
    /// A k [N/m].
    pub stiffness: f64,
    /// μ.
    pub friction: f64,
    /// e; zero where a solid is elastic.
    pub restitution: f64,
}

/// What a contact needs to know of a step.
pub struct ContactStep<'a, const D: usize> {
    /// Δt [s].
    pub dt: f64,
    /// Δ [s].
    pub delta: f64,
    /// û − u* of all nodes [m].
    pub rest: &'a dyn Fn(usize) -> Vector<D>,
    /// vⁿ of all nodes [m/s].
    pub velocity: &'a dyn Fn(usize) -> Vector<D>,
    /// vⁿ − vⁿ⁻¹ of all nodes [m/s].
    pub gained: &'a dyn Fn(usize) -> Vector<D>,
}

/// A contact during a step.
#[derive(Debug, Clone, PartialEq)]
pub struct Contact<const D: usize> {
    /// Number of the point.
    pub point: usize,
    shares: Vec<(u32, f64)>,
    normal: Vector<D>,
    /// Normal force without a velocity [N].
    push: f64,
    /// Change of the normal force with the normal velocity [N s/m].
    resistance: f64,
    /// c [N s/m].
    friction: f64,
    /// v_n^n of one that bounces [m/s].
    approach: Option<f64>,
}

impl<const D: usize> Contact<D> {
    /// The contact of a meeting, where the point had this normal force in the last step [N]; `None` where it doesn't touch: what pushed
    /// goes on until it would pull, else contacts would chatter. What bounces is not held where it leaves.
    pub fn new(last: Vector<D>, meeting: Meeting<D>, step: &ContactStep<'_, D>) -> Option<Self> {
        let Meeting { point, shares, normal, distance, gap, stiffness, friction, restitution } = meeting;
        let pushed = last.dot(normal).max(0.0);
        if distance >= gap && pushed == 0.0 {
            return None;
        }
        let sum = |of: &dyn Fn(usize) -> Vector<D>| -> Vector<D> {
            shares.iter().map(|&(node, share)| of(node as usize) * share).sum()
        };
        let (velocity, gained) = (sum(step.velocity), sum(step.gained));
        let (speed, slow) = (velocity.dot(normal), IMPACT * gained.dot(normal).abs());
        let meets = restitution > 0.0 && pushed == 0.0;
        if meets && speed > 0.0 {
            return None;
        }
        let approach = (meets && -speed > slow).then_some(speed);
        let resistance = stiffness * step.delta * if approach.is_some() { BOUNCE } else { 1.0 };
        let push = match approach {
            Some(speed) => -restitution * speed * resistance,
            None => stiffness * (gap - distance - normal.dot(sum(step.rest))),
        };
        let along = velocity + gained;
        let along = along - normal * along.dot(normal);
        let slowest = CREEP * gap.abs().max(f64::MIN_POSITIVE) / step.dt;
        Some(Self {
            point,
            normal,
            push,
            resistance,
            friction: friction * pushed / along.norm().max(slowest),
            approach,
            shares,
        })
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

    /// Force on the point at the velocities of nodes [m/s], and its part along the normal [N].
    pub fn force(&self, velocity: impl Fn(usize) -> Vector<D>) -> [Vector<D>; 2] {
        let force = self.normal * self.push - self.matrix().apply(self.relative(velocity));
        [force, self.normal * force.dot(self.normal)]
    }

    /// Σ c_i v_i [m/s].
    fn relative(&self, velocity: impl Fn(usize) -> Vector<D>) -> Vector<D> {
        self.shares.iter().map(|&(node, share)| velocity(node as usize) * share).sum()
    }

    /// True where it bounces.
    pub fn bounces(&self) -> bool {
        self.approach.is_some()
    }

    /// The nodes on which it acts.
    pub fn nodes(&self) -> impl Iterator<Item = usize> + '_ {
        self.shares.iter().map(|&(node, _)| node as usize)
    }

    /// What the power of the impulse of a bounce, which its mean velocity takes, differs by from the force at the end of the step times
    /// the velocity there [W]; θ is the implicit share of the step.
    pub fn excess_power(&self, theta: f64, velocity: impl Fn(usize) -> Vector<D>) -> f64 {
        let Some(before) = self.approach else { return 0.0 };
        let after = self.normal.dot(self.relative(&velocity));
        let [_, force] = self.force(velocity);
        force.dot(self.normal) * (0.5 * theta * (before + after) - after)
    }
}
