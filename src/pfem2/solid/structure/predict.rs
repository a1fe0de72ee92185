//! The prediction of a step's end, and that of a step that is solved anew (theory (J.1), (J.3), (J.3a), (J.3b)).

use super::constrained::held_axes;
use super::{Prediction, SolidState, Structure};
use crate::error::StepError;
use crate::math::Vector;
use crate::pfem2::history::StepWeights;

impl<const D: usize> Structure<D> {
    /// Predicts the end of a step at `t_end` [s], where v* has these weights of vⁿ, vⁿ⁻¹ and vⁿ⁻²
    /// (theory (F.8), (F.15)). Prescribed nodes are where they will be.
    ///
    /// # Errors
    /// Supports that a rigid solid can't follow.
    pub(in crate::pfem2) fn predict(
        &self,
        t_end: f64,
        step_weights: StepWeights,
        weights: [f64; 3],
    ) -> Result<Prediction<D>, StepError> {
        let StepWeights { dt, end, start, earlier } = step_weights;
        let SolidState { displacement: u, velocity: v, acceleration: a, .. } = &self.state;
        let hat = |x: &[Vector<D>], now: &[Vector<D>], before: &[Vector<D>]| -> Vec<Vector<D>> {
            let all = x.iter().zip(now).zip(before);
            all.map(|((x, now), before)| *x + (*now * start + *before * earlier) * dt).collect()
        };
        let displacement_hat = hat(u, v, &self.state.velocity_previous);
        let velocity_hat = hat(v, a, &self.state.acceleration_previous);
        let surface_velocity_hat = hat(v, &self.state.surface_acceleration, &self.state.surface_acceleration_previous);
        let mut displacement = self.extrapolated(weights, dt);
        let held = self.held_velocities(t_end);
        let supported = |node: usize, axis: usize, velocity: f64| displacement_hat[node][axis] + end * dt * velocity;
        for (unknown, velocity) in held.iter().enumerate() {
            if let Some(velocity) = velocity {
                displacement[unknown / D][unknown % D] = supported(unknown / D, unknown % D, *velocity);
            }
        }
        let rigid = self.predict_rigid(t_end, step_weights, weights, &|body| {
            held_axes::<D>(body, &held, |unknown, velocity| supported(unknown / D, unknown % D, velocity))
        })?;
        self.place_rigid(&mut displacement, |k| (rigid[k].displacement, rigid[k].rotation));
        self.ties.follow(&mut displacement);
        let guess: Vec<Vector<D>> = velocity_hat.iter().zip(a).map(|(hat, a)| *hat + *a * (end * dt)).collect();
        let velocities = self.independent(&held, &guess, &rigid);
        Ok(Prediction {
            displacement_hat,
            velocity_hat,
            surface_velocity_hat,
            displacement,
            found: None,
            rigid,
            velocities,
        })
    }

    /// Displacements after a step `dt` [s] with the velocity v*, of these weights; as far as velocities are unsteady, with
    /// the mean of the last two (theory (J.3), (J.3b)) [m].
    fn extrapolated(&self, weights: [f64; 3], dt: f64) -> Vec<Vector<D>> {
        let SolidState { displacement: u, velocity: v, velocity_previous, velocity_earlier, .. } = &self.state;
        let earlier_steps = velocity_previous.iter().zip(velocity_earlier);
        let all = u.iter().zip(v).zip(earlier_steps);
        let predicted = |((u, v), (previous, earlier)): ((&Vector<D>, &Vector<D>), (&Vector<D>, &Vector<D>))| {
            let extrapolated = *v * weights[0] + *previous * weights[1] + *earlier * weights[2];
            let steady = if weights[1] == 0.0 { 1.0 } else { steadiness([*v, *previous, *earlier]) };
            *u + (extrapolated * steady + (*v + *previous) * (0.5 * (1.0 - steady))) * dt
        };
        all.map(predicted).collect()
    }

    /// The prediction with the displacement û + Δ v to which the independent velocities that were found about it lead
    /// elastic solids, with their bonds; rigid ones stay where they were predicted.
    pub(in crate::pfem2) fn corrected(&self, delta: f64, prediction: &Prediction<D>, w: &[f64]) -> Prediction<D> {
        let nodal = prediction.velocities.nodal(w);
        let mut displacement = prediction.displacement.clone();
        for node in (0..self.node_count()).filter(|&node| self.is_elastic(node as u32)) {
            let velocity = Vector::from_fn(|axis| nodal[node * D + axis]);
            displacement[node] = prediction.displacement_hat[node] + velocity * delta;
        }
        let correction = displacement.iter().zip(&prediction.displacement).map(|(u, last)| *u - *last).collect();
        Prediction { displacement, found: Some(correction), ..prediction.clone() }
    }
}

/// β of theory (J.3b): one where the velocity of a node goes on as it did over the last three steps, and zero where it
/// goes to and fro.
fn steadiness<const D: usize>([v, previous, earlier]: [Vector<D>; 3]) -> f64 {
    let (change, turn) = ((v - previous).norm_squared(), (v - previous * 2.0 + earlier).norm_squared());
    if turn == 0.0 { 1.0 } else { 1.0 / (1.0 + (turn / change).powi(2)) }
}
