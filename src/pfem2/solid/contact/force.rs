//! The force of a contact: unilateral along the normal, with Coulomb's friction, linear in the velocity
//! (theory J.8, J.9).
//!
//! ```text
//! f = A k (g − d^{n+1}) n − c (1 − n ⊗ n) v,    d^{n+1} = d* + n·Σ c_i (û_i + Δ v_i − u_i*),    v = Σ c_i v_i
//! c = μ f_n/max(|v_t|, ε),   f_n: normal force of the last step,   v_t: 2 vⁿ − vⁿ⁻¹ along the surface,   ε = 10⁻⁶ g/Δt
//! ```
//!
//! c_i f acts on node i: c is one at the point that meets a wall, and −N_b at the nodes of a facet of a solid that it
//! meets.
//!
//! Rigid solids meet walls and each other by an impulse f Δ instead, which gives them a velocity (theory (J.16a)):
//!
//! ```text
//! f = 10⁴ m/Δ (w − n·v^{n+1}) n − c (1 − n ⊗ n) v^{n+1},   where it pushes
//! w = (r − dⁿ)/Δt + (g − r)/(100 Δt),    r = min(g, least dⁿ of both solids there)
//! w = e (dⁿ − d*)/Δt   where solids with a restitution collide: d* < r, least of both solids there,
//!                      (dⁿ − d*)/Δt > 2 Δt |n·Σ c_i a_iⁿ|
//! ```
//!
//! It comes as near as the gap and rests. A solid that has come nearer is lifted slowly; by r, others of its points may
//! come as near as the nearest, so that it rolls. Which contacts push, and c, is found beforehand (see `impulses`), and
//! then with the forces of the step (see `unilateral`).

use crate::math::{Tensor, Vector};
use crate::pfem2::solid::equations::LinearForces;
use crate::pfem2::solid::setup::SolidSetup;
use crate::pfem2::solid::structure::Structure;

/// Gap in which fluid stays, over the size of an element of its mesh.
pub const GAP: f64 = 0.5;

/// Distance within which solids look for places that they may touch, over the gap, besides their displacement in
/// a step.
pub const REACH: f64 = 1.25;

/// Stiffness of a contact over that of an element of the solid.
const STIFFNESS: f64 = 10.0;

/// Resistance of an impulse over the mass by Δ: a rigid solid reaches its speed to a ten-thousandth.
const IMPULSE: f64 = 1e4;

/// Solids that collide approach each other by more than this many times what other forces give it in a step: a solid
/// that rests on something doesn't.
const IMPACT: f64 = 2.0;

/// Part of the gap by which places of a solid may differ that meet another one at once.
const LEVEL: f64 = 1e-3;

/// Part of its distance from the gap by which a rigid solid that rests comes nearer to it per step.
const RETURN: f64 = 0.01;

/// Cosine of the angle between two normals of one point from which they are those of the same contact.
const SAME_CONTACT_COSINE: f64 = 0.8;

/// Displacement per step, over the gap, by which places that stick may creep.
const CREEP: f64 = 1e-6;

/// The law of a contact: what pushes the two apart.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ContactLaw {
    /// Pressure per depth of an elastic solid, 10 (λ + 2 μ)/h [Pa/m].
    Elastic(f64),
    /// A rigid one is stopped by an impulse.
    Rigid(RigidImpact),
}

/// Impact of a rigid solid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RigidImpact {
    /// Mass [kg].
    pub mass: f64,
    /// Coefficient of restitution.
    pub restitution: f64,
}

impl ContactLaw {
    /// The law of a solid with this `mass` [kg] and facets of this `size` [m].
    pub fn new<const D: usize>(structure: &Structure<D>, setup: &SolidSetup<D>, mass: f64, size: f64) -> Self {
        match setup.law.is_rigid() {
            true => Self::Rigid(RigidImpact { mass, restitution: setup.restitution }),
            false => Self::Elastic(STIFFNESS * structure.wave_modulus(setup) / size),
        }
    }

    /// The law between two solids that meet: the softer of two elastic ones, the elastic one beside a rigid one; of two
    /// rigid ones the heavier counts, and the root of the product of their restitutions.
    #[must_use]
    pub fn combined(self, other: Self) -> Self {
        match (self, other) {
            (Self::Elastic(a), Self::Elastic(b)) => Self::Elastic(a.min(b)),
            (Self::Rigid(a), Self::Rigid(b)) => {
                let restitution = (a.restitution * b.restitution).sqrt();
                Self::Rigid(RigidImpact { mass: a.mass.max(b.mass), restitution })
            }
            (elastic @ Self::Elastic(_), _) | (_, elastic) => elastic,
        }
    }
}

/// A place where a point of a solid may touch something, about the prediction of a step.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactCandidate<const D: usize> {
    /// Number of the point.
    pub point: usize,
    /// Nodes i with their coefficients c_i (theory J.8, J.9).
    pub coefficients: Vec<(u32, f64)>,
    /// Unit normal n of the wall or of the other surface, towards the point.
    pub normal: Vector<D>,
    /// d* [m].
    pub distance: f64,
    /// g [m].
    pub gap: f64,
    /// g, or a hundredth of that of the mesh where the pair began nearer than that [m]: depths and creep are measured
    /// by it.
    pub scale: f64,
    /// A [m²].
    pub area: f64,
    /// Elastic with k, or rigid.
    pub law: ContactLaw,
    /// μ.
    pub friction: f64,
}

impl<const D: usize> ContactCandidate<D> {
    /// Depth of an elastic solid in the gap, over its scale.
    pub(in crate::pfem2::solid) fn depth(&self) -> f64 {
        match self.law {
            ContactLaw::Elastic(_) => (self.gap - self.distance).max(0.0) / self.scale,
            ContactLaw::Rigid(_) => 0.0,
        }
    }

    /// dⁿ [m].
    pub fn distance_at_start(&self, step: &ContactStep<'_, D>) -> f64 {
        self.distance - self.normal.dot(relative(&self.coefficients, step.predicted_increment))
    }
}

/// The least distances of all places that may touch between the same two solids, or a solid and walls, with about
/// the same normal [m]; infinite where an elastic solid is one of them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeastDistances {
    /// The least dⁿ, at the start of the step.
    pub start: f64,
    /// The least d*, as predicted for its end.
    pub predicted: f64,
}

impl LeastDistances {
    /// No place.
    pub const NONE: Self = Self { start: f64::INFINITY, predicted: f64::INFINITY };

    /// The lesser of both.
    #[must_use]
    pub fn min(self, other: Self) -> Self {
        Self { start: self.start.min(other.start), predicted: self.predicted.min(other.predicted) }
    }
}

/// A step as contacts see it.
pub struct ContactStep<'a, const D: usize> {
    /// True where the step is solved anew: then d* alone says what touches.
    pub anew: bool,
    /// Δt [s].
    pub dt: f64,
    /// Δ [s].
    pub delta: f64,
    /// û − u* of all nodes [m].
    pub displacement_offset: &'a dyn Fn(usize) -> Vector<D>,
    /// u* − uⁿ of all nodes [m].
    pub predicted_increment: &'a dyn Fn(usize) -> Vector<D>,
    /// vⁿ of all nodes [m/s].
    pub velocity: &'a dyn Fn(usize) -> Vector<D>,
    /// vⁿ − vⁿ⁻¹ of all nodes [m/s].
    pub velocity_increment: &'a dyn Fn(usize) -> Vector<D>,
    /// aⁿ of all nodes, that of rigid solids without impulses [m/s²].
    pub acceleration: &'a dyn Fn(usize) -> Vector<D>,
}

/// A contact during a step.
#[derive(Debug, Clone, PartialEq)]
pub struct Contact<const D: usize> {
    /// Number of the point.
    pub point: usize,
    /// True if its force is in the equations: a place near something touches nothing where it would pull.
    pub is_active: bool,
    coefficients: Vec<(u32, f64)>,
    normal: Vector<D>,
    /// The force that takes it deeper by the scale of its gap: A k times that, or of an impulse its resistance times
    /// that over Δt [N].
    closing: f64,
    /// Normal force without a velocity [N].
    push: f64,
    /// Change of the normal force with the normal velocity [N s/m].
    resistance: f64,
    /// c [N s/m].
    friction: f64,
    /// Speed with which an elastic solid arrives that didn't touch in the last step [m/s].
    pub arrival: Option<f64>,
    /// The impulse of rigid solids.
    impulse: Option<RigidImpulse<D>>,
}

/// The impulse of a contact of rigid solids, as a target for the velocity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::pfem2::solid) struct RigidImpulse<const D: usize> {
    /// Σ c_i v_iⁿ [m/s].
    pub before: Vector<D>,
    /// w [m/s].
    pub target_velocity: f64,
    /// Coefficient of friction.
    pub friction: f64,
    /// ε [m/s].
    pub slowest: f64,
    /// Δ/Δt: the mean force of a step over the one that acts for Δ.
    time_fraction: f64,
    is_collision: bool,
}

impl<const D: usize> Contact<D> {
    /// The contact of a candidate, where the point had this normal force in the last step [N]. The contact of an
    /// elastic solid acts at first where d* < g or it pushed. `least`: the least distances of both solids there.
    pub fn new(
        last: Vector<D>,
        candidate: ContactCandidate<D>,
        least: LeastDistances,
        step: &ContactStep<'_, D>,
    ) -> Self {
        match candidate.law {
            ContactLaw::Elastic(pressure) => Self::elastic(pressure, last, candidate, step),
            ContactLaw::Rigid(impact) => Self::rigid(impact, candidate, least, step),
        }
    }

    fn elastic(pressure: f64, last: Vector<D>, candidate: ContactCandidate<D>, step: &ContactStep<'_, D>) -> Self {
        let ContactCandidate { point, coefficients, normal, distance, gap, scale, area, friction, .. } = candidate;
        let pushed = last.dot(normal).max(0.0);
        let velocity = relative(&coefficients, step.velocity);
        let along = velocity + relative(&coefficients, step.velocity_increment);
        let along = along - normal * along.dot(normal);
        let stiffness = pressure * area;
        Self {
            point,
            is_active: distance < gap || pushed > 0.0 && !step.anew,
            normal,
            closing: stiffness * scale,
            push: stiffness * (gap - distance - normal.dot(relative(&coefficients, step.displacement_offset))),
            resistance: stiffness * step.delta,
            friction: friction * pushed / along.norm().max(slowest(scale, step.dt)),
            arrival: (pushed == 0.0).then(|| -velocity.dot(normal)),
            impulse: None,
            coefficients,
        }
    }

    fn rigid(
        RigidImpact { mass, restitution }: RigidImpact,
        candidate: ContactCandidate<D>,
        least: LeastDistances,
        step: &ContactStep<'_, D>,
    ) -> Self {
        let reached = candidate.gap.min(least.start);
        let start = candidate.distance_at_start(step);
        let ContactCandidate { point, coefficients, normal, distance, gap, scale, friction, .. } = candidate;
        let before = relative(&coefficients, step.velocity);
        let slow = IMPACT * step.dt * relative(&coefficients, step.acceleration).dot(normal).abs();
        // By the way that is predicted: points of what rolls come near on curves, and others are nearer then.
        let speed = (distance - start) / step.dt;
        let is_nearest = distance < least.predicted + LEVEL * gap;
        let is_collision = distance < reached && is_nearest && speed < -slow;
        let target_velocity = match is_collision && restitution > 0.0 {
            true => -restitution * speed,
            false => (reached - start + RETURN * (gap - reached)) / step.dt,
        };
        let (resistance, slowest) = (IMPULSE * mass / step.delta, slowest(scale, step.dt));
        let time_fraction = step.delta / step.dt;
        let impulse = Some(RigidImpulse { before, target_velocity, friction, slowest, time_fraction, is_collision });
        Self {
            point,
            is_active: true,
            normal,
            closing: resistance * scale / step.dt,
            push: resistance * target_velocity,
            resistance,
            friction: 0.0,
            arrival: None,
            impulse,
            coefficients,
        }
    }

    /// True if it acts where the candidate is.
    pub(in crate::pfem2::solid) fn is_at(&self, candidate: &ContactCandidate<D>) -> bool {
        self.is_active && self.point == candidate.point && self.normal.dot(candidate.normal) > SAME_CONTACT_COSINE
    }

    /// Normal force on the point at the velocities of nodes at the end of the step [m/s]; negative where it pulls [N].
    pub(in crate::pfem2::solid) fn push(&self, velocity: impl Fn(usize) -> Vector<D>) -> f64 {
        self.force(velocity).dot(self.normal)
    }

    /// Depth in the gap with this normal force [N], over its scale; of an impulse beyond what it lets come nearer.
    pub(in crate::pfem2::solid) fn depth(&self, force: f64) -> f64 {
        if self.closing > 0.0 { force / self.closing } else { 0.0 }
    }

    /// Nodes on which its force acts.
    pub(in crate::pfem2::solid) fn nodes(&self) -> impl Iterator<Item = usize> + '_ {
        self.coefficients.iter().map(|&(node, _)| node as usize)
    }

    /// The impulse of rigid solids; none where an elastic one meets.
    pub(in crate::pfem2::solid) fn impulse(&self) -> Option<&RigidImpulse<D>> {
        self.impulse.as_ref()
    }

    /// Nodes with their c_i.
    pub(in crate::pfem2::solid) fn coefficients(&self) -> &[(u32, f64)] {
        &self.coefficients
    }

    /// Normal n, away from what is touched.
    pub(in crate::pfem2::solid) fn normal(&self) -> Vector<D> {
        self.normal
    }

    /// Change of the normal force with the normal velocity [N s/m].
    pub(in crate::pfem2::solid) fn resistance(&self) -> f64 {
        self.resistance
    }

    /// The contact as it is found to act, with this coefficient of friction c [N s/m].
    #[must_use]
    pub(in crate::pfem2::solid) fn found(self, is_active: bool, friction: f64) -> Self {
        Self { is_active, friction, ..self }
    }

    /// Minus the derivative of the force by the velocity [N s/m].
    fn matrix(&self) -> Tensor<D> {
        let normal = Tensor::outer(self.normal, self.normal);
        normal * self.resistance + (Tensor::identity() - normal) * self.friction
    }

    /// Adds its force on each of its nodes.
    pub fn add(&self, forces: &mut LinearForces) {
        let (matrix, load) = (self.matrix(), self.normal * self.push);
        for &(row, coefficient) in &self.coefficients {
            forces.add_load(row, load * coefficient);
            for &(column, other) in &self.coefficients {
                forces.add_block((row, column), &(matrix * (coefficient * other)));
            }
        }
    }

    /// Force on the point at the velocities of nodes [m/s] at the end of the step [N].
    fn force(&self, velocity: impl Fn(usize) -> Vector<D>) -> Vector<D> {
        self.normal * self.push - self.matrix().apply(relative(&self.coefficients, velocity))
    }

    /// Normal force on the point at the velocities of nodes at the end of the step [m/s]: there, and of impulses
    /// the mean over the step [N].
    pub fn normal_force(&self, velocity: impl Fn(usize) -> Vector<D>) -> Vector<D> {
        let time_fraction = self.impulse.map_or(1.0, |impulse| impulse.time_fraction);
        self.normal * (self.force(velocity).dot(self.normal) * time_fraction)
    }

    /// The forces on nodes at the velocities of nodes at the end of the step [m/s]; those of an impulse act for Δ [N].
    pub fn nodal_forces(&self, velocity: impl Fn(usize) -> Vector<D>) -> Vec<(usize, Vector<D>)> {
        let force = self.force(velocity);
        self.coefficients.iter().map(|&(node, coefficient)| (node as usize, force * coefficient)).collect()
    }

    /// The nodes of solids that collide.
    pub fn colliding(&self) -> impl Iterator<Item = usize> + '_ {
        let collides = self.impulse.is_some_and(|impulse| impulse.is_collision);
        self.coefficients.iter().filter(move |_| collides).map(|&(node, _)| node as usize)
    }

    /// Difference between the power of an impulse, which the mean velocity takes, and the force at the end of the step
    /// times the velocity there [W]; θ is the implicit weight of the step.
    pub fn excess_power(&self, theta: f64, velocity: impl Fn(usize) -> Vector<D>) -> f64 {
        let Some(RigidImpulse { before, .. }) = self.impulse else { return 0.0 };
        let after = relative(&self.coefficients, &velocity);
        self.force(velocity).dot((before + after) * (0.5 * theta) - after)
    }
}

/// ε: the velocity along a surface up to which places that stick may creep [m/s].
fn slowest(scale: f64, dt: f64) -> f64 {
    CREEP * scale / dt
}

/// The length by which depths and creep are measured in a gap beside one that the mesh would have [m].
pub(super) fn gap_scale(gap: f64, of_mesh: f64) -> f64 {
    /// Least part of the gap of the mesh.
    const LEAST: f64 = 0.01;
    gap.max(LEAST * of_mesh).max(f64::MIN_POSITIVE)
}

/// Σ c_i v_i.
pub(super) fn relative<const D: usize>(coefficients: &[(u32, f64)], of: impl Fn(usize) -> Vector<D>) -> Vector<D> {
    coefficients.iter().map(|&(node, coefficient)| of(node as usize) * coefficient).sum()
}
