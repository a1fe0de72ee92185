//! Motion of solids and of the steps before, and the prediction of a step's end (theory J.1).

use crate::math::Vector;
use crate::pfem2::solid::equations::independent::IndependentVelocities;
use crate::pfem2::solid::rigid::{RigidPrediction, RigidState};

/// Motion of the nodes of all solids, and of the steps before.
#[derive(Debug, Clone, PartialEq)]
pub struct SolidState<const D: usize> {
    /// uⁿ [m].
    pub displacement: Vec<Vector<D>>,
    /// uⁿ − u*, by which the last step corrected its prediction [m]; zero before the first step.
    pub correction: Vec<Vector<D>>,
    /// vⁿ [m/s].
    pub velocity: Vec<Vector<D>>,
    /// vⁿ⁻¹ [m/s].
    pub velocity_previous: Vec<Vector<D>>,
    /// vⁿ⁻² [m/s].
    pub velocity_earlier: Vec<Vector<D>>,
    /// aⁿ [m/s²].
    pub acceleration: Vec<Vector<D>>,
    /// aⁿ⁻¹ [m/s²].
    pub acceleration_previous: Vec<Vector<D>>,
    /// a_Fⁿ of the fluid at nodes [m/s²]: with the impulses on which rigid solids rest (theory (J.16c)).
    pub surface_acceleration: Vec<Vector<D>>,
    /// The same of the step before [m/s²].
    pub surface_acceleration_previous: Vec<Vector<D>>,
    /// Difference between vⁿ and its extrapolation from the two steps before [m/s]; zero before the first step.
    pub velocity_change: Vec<Vector<D>>,
    /// Motion of rigid solids, in their order.
    pub rigid: Vec<RigidState>,
}

/// Prediction of a step's end, before the step is solved.
#[derive(Debug, Clone, PartialEq)]
pub struct Prediction<const D: usize> {
    /// û [m].
    pub displacement_hat: Vec<Vector<D>>,
    /// v̂ [m/s].
    pub velocity_hat: Vec<Vector<D>>,
    /// v̂_F of the fluid at nodes [m/s] (theory (J.16c)).
    pub surface_velocity_hat: Vec<Vector<D>>,
    /// u* [m].
    pub displacement: Vec<Vector<D>>,
    /// u* less that of the prediction about which it was found [m], in a step that is solved anew.
    pub found: Option<Vec<Vector<D>>>,
    /// Predictions of rigid solids.
    pub rigid: Vec<RigidPrediction>,
    /// The velocities that nodes don't take from others.
    pub velocities: IndependentVelocities,
}

impl<const D: usize> Prediction<D> {
    /// The prediction half-way between one, about which it was found, and this.
    #[must_use]
    pub fn halfway_from(self, last: &Self) -> Self {
        let both = self.displacement.iter().zip(&last.displacement);
        let displacement: Vec<Vector<D>> = both.map(|(u, last)| (*u + *last) * 0.5).collect();
        let correction = displacement.iter().zip(&last.displacement).map(|(u, last)| *u - *last).collect();
        Self { displacement, found: Some(correction), ..self }
    }
}

impl<const D: usize> SolidState<D> {
    /// State of nodes in their reference places that start with `velocity` [m/s].
    pub fn new(velocity: Vec<Vector<D>>) -> Self {
        let zero = vec![Vector::ZERO; velocity.len()];
        Self {
            displacement: zero.clone(),
            correction: zero.clone(),
            velocity_previous: velocity.clone(),
            velocity_earlier: velocity.clone(),
            velocity,
            acceleration: zero.clone(),
            acceleration_previous: zero.clone(),
            surface_acceleration: zero.clone(),
            surface_acceleration_previous: zero.clone(),
            velocity_change: zero,
            rigid: Vec::new(),
        }
    }

    /// Forgets the steps before.
    pub fn clear_history(&mut self) {
        let (displacement, mut rigid) = (std::mem::take(&mut self.displacement), std::mem::take(&mut self.rigid));
        rigid.iter_mut().for_each(RigidState::clear_history);
        *self = Self { displacement, rigid, ..Self::new(std::mem::take(&mut self.velocity)) };
    }

    /// Brings all nodes to rest where they are.
    pub fn rest(&mut self) {
        self.velocity.fill(Vector::ZERO);
        self.rigid.iter_mut().for_each(RigidState::rest);
        self.clear_history();
    }

    /// Takes the steps before from the end of a predicted first step: a⁰ = a¹, v⁻¹ = 2 v⁰ − v¹ (theory H.9).
    pub fn begin(&mut self, end: &Self) {
        let both = || self.velocity.iter().zip(&end.velocity);
        let previous = both().map(|(start, end)| *start * 2.0 - *end).collect();
        let earlier = both().map(|(start, end)| *start * 3.0 - *end * 2.0).collect();
        (self.velocity_previous, self.velocity_earlier) = (previous, earlier);
        self.acceleration.clone_from(&end.acceleration);
        self.acceleration_previous.clone_from(&end.acceleration);
        self.surface_acceleration.clone_from(&end.surface_acceleration);
        self.surface_acceleration_previous.clone_from(&end.surface_acceleration);
        self.rigid.iter_mut().zip(&end.rigid).for_each(|(own, end)| own.begin(end));
    }
}
