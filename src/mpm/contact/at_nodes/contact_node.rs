//! A grid node that a sheet shares with bodies, and the contact of each body with the sheet there during the step
//! (theory D.2, D.4, D.8).

use crate::math::Vector;
use crate::mpm::SubStep;
use crate::mpm::contact::impulse::Impulse;
use crate::mpm::contact::partner::{NONE, Partners};

/// A grid node that the sheet shares with bodies.
#[derive(Debug, Clone)]
pub struct ContactNode<const D: usize> {
    /// Number of the grid node.
    pub grid_node: u32,
    /// m_I^r [kg].
    pub mass: f64,
    /// Part of m_I^r that belongs to nodes whose motion along an axis is prescribed [kg].
    pub held_mass: Vector<D>,
    /// Normal impulse over the change of normal velocity [kg].
    pub inertia: f64,
    /// Unit normal; zero where the sheet has no direction or contact may not push.
    pub normal: Vector<D>,
    /// True where the areas around the node cancel: the normal then comes from the bodies (theory (D.9)).
    pub folded: bool,
    /// Σ of the lengths of the arms whose sum gives the normal of a folded sheet [kg m].
    pub arm_length: f64,
    /// Centre of mass of the sheet around the node, x̄_I^r [m].
    pub centre: Vector<D>,
    /// Half thickness around the node [m].
    pub offset: f64,
    /// p̄_I^r [N s].
    pub momentum: Vector<D>,
    /// Mean of the momentum before and after the forces [N s].
    pub average: Vector<D>,
    /// Contact impulse of this pass on the sheet [N s].
    pub impulse: Vector<D>,
    /// Velocity of the sheet's mass at the node after the impulse [m/s].
    pub impulse_velocity: Vector<D>,
    /// True for axes along which contact may push the node.
    pub free: [bool; D],
}

/// A body and the sheet at a contact node.
#[derive(Debug, Clone)]
pub struct NodePair<const D: usize> {
    /// Gap to the particles labelled − and + [m]; infinite where there are none.
    pub gap: [f64; 2],
    /// Σ ± m_p N_Ip over the labelled particles: its sign decides the side [kg].
    pub vote: f64,
    /// Σ m_p N_Ip over the same particles [kg].
    pub mass: f64,
    /// Σ m_p N_Ip x_p over the same particles [kg m].
    pub moment: Vector<D>,
    /// Side from which the body comes to the sheet in this sub-step, +1 where the normal points.
    pub side: f64,
    /// The body's node in [`Partners`]; `NONE` while it is too far.
    pub partner: u32,
    /// True if the two touch in this sub-step.
    pub touching: bool,
    /// J of this sub-step on the body, all passes together [N s].
    pub impulse: Impulse<D>,
    /// Σ J over the sub-steps on the body: normal part and friction [N s].
    pub total: Impulse<D>,
    /// Σ J·v̂_I^r with the mean velocity of the sheet: normal part and friction [J].
    pub work: [f64; 2],
}

/// Least 1 − σ of theory (D.17): the mass fraction of a sheet that moves even where supports hold all of it.
const LEAST_FREE_FRACTION: f64 = 1e-6;

impl<const D: usize> Default for NodePair<D> {
    fn default() -> Self {
        Self {
            gap: [f64::INFINITY; 2],
            vote: 0.0,
            mass: 0.0,
            moment: Vector::ZERO,
            side: 1.0,
            partner: NONE,
            touching: false,
            impulse: Impulse::default(),
            total: Impulse::default(),
            work: [0.0; 2],
        }
    }
}

impl<const D: usize> NodePair<D> {
    /// The lesser of the two gaps [m].
    pub fn least_gap(&self) -> f64 {
        self.gap[0].min(self.gap[1])
    }

    /// The side of most of the body's particles near the node, 0 if there are none.
    pub fn majority_side(&self) -> f64 {
        match self.least_gap().is_finite() {
            true if self.vote >= 0.0 => 1.0,
            true => -1.0,
            false => 0.0,
        }
    }

    /// Sets the side of contact for a body that moves with `w` [m/s] along the normal relative to the sheet: a body
    /// with particles on both sides comes from the one that it moves away from. Returns the gap there [m].
    pub fn choose_side(&mut self, w: f64) -> f64 {
        let [minus, plus] = self.gap.map(f64::is_finite);
        self.side = if plus && !(minus && w > 0.0) { 1.0 } else { -1.0 };
        self.gap[usize::from(self.side > 0.0)]
    }

    /// Adds impulse and work of the sub-step, in which the sheet had the mean velocity `mean` [m/s] at the node;
    /// returns J·v̂ [J].
    pub fn add_work(&mut self, mean: Vector<D>) -> f64 {
        let work = [self.impulse.normal.dot(mean), self.impulse.tangent.dot(mean)];
        self.total.normal += self.impulse.normal;
        self.total.tangent += self.impulse.tangent;
        self.work[0] += work[0];
        self.work[1] += work[1];
        work[0] + work[1]
    }
}

impl<const D: usize> ContactNode<D> {
    pub fn new(node: usize) -> Self {
        Self {
            grid_node: node as u32,
            mass: 0.0,
            held_mass: Vector::ZERO,
            inertia: 0.0,
            normal: Vector::ZERO,
            folded: false,
            arm_length: 0.0,
            centre: Vector::ZERO,
            offset: 0.0,
            momentum: Vector::ZERO,
            average: Vector::ZERO,
            impulse: Vector::ZERO,
            impulse_velocity: Vector::ZERO,
            free: [true; D],
        }
    }

    /// m_I^r/(1 − s) (theory (D.17)) with the fraction s of the mass that supports hold along the normal.
    pub fn find_inertia(&mut self) {
        let held: f64 = (0..D).map(|a| self.normal[a].powi(2) * self.held_mass[a]).sum();
        self.inertia = self.mass / (1.0 - held / self.mass).max(LEAST_FREE_FRACTION);
    }

    /// `v` without the components that contact may not push.
    pub fn project(&self, v: Vector<D>) -> Vector<D> {
        Vector::from_fn(|axis| if self.free[axis] { v[axis] } else { 0.0 })
    }
}

/// Advances the gaps over the sub-step by the motion of the bodies relative to the sheet, which moves with `velocity`
/// [m/s].
pub fn update_gaps<const D: usize>(
    node: &ContactNode<D>,
    pairs: &mut [NodePair<D>],
    partners: &Partners<D>,
    velocity: Vector<D>,
    at: &SubStep<'_>,
) {
    for pair in pairs.iter_mut().filter(|pair| pair.partner != NONE) {
        let (_, v) = partners.trial(pair.partner, at.momentum_end);
        let opening = (node.project(v) - velocity).dot(node.normal) * at.momentum_dt;
        pair.gap = [pair.gap[0] - opening, pair.gap[1] + opening];
    }
}
