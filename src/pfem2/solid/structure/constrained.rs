//! Solids whose nodes don't move freely: rigid ones, supports, and bonds (theory J.10, J.11, J.13).

use super::Structure;
use super::state::{Prediction, SolidState};
use crate::error::{Place, StepError};
use crate::math::{Tensor, Vector};
use crate::pfem2::history::StepWeights;
use crate::pfem2::solid::equations::IndependentInertia;
use crate::pfem2::solid::equations::independent::IndependentVelocities;
use crate::pfem2::solid::rigid::{Contradiction, HeldAxis, RigidBody, RigidLoad, RigidPrediction, RigidState};

/// Entries of a row of T, and its v̄ [m/s].
type VelocityRow = (Vec<(u32, f64)>, f64);

impl<const D: usize> Structure<D> {
    /// Gives the rigid solids the motion that is nearest to the velocity of their nodes.
    ///
    /// # Errors
    /// Supports that a rigid solid can't follow.
    pub(in crate::pfem2::solid) fn begin_rigid(&mut self) -> Result<(), String> {
        let momentum = self.weighted_by_mass(&self.state.velocity);
        let (held, mut velocity) = (self.held_velocities(0.0), self.state.velocity.clone());
        for body in &self.rigid {
            let of = |a: usize| Vector::<3>(Vector::<D>::from_fn(|axis| momentum[a * D + axis]).to3());
            let arm = |a: usize| Vector::<3>(self.nodes[a].to3()) - body.center;
            let angular = body.nodes.clone().map(|a| arm(a).cross(of(a))).sum();
            let fixed = held_axes::<D>(body, &held, |_, _| 0.0);
            let told = |Contradiction { missed }| {
                let name = &self.setups()[body.solid].name;
                format!(
                    "the supports of the rigid solid `{name}` ask for a deformation: one misses its velocity by {missed:.3e} m/s"
                )
            };
            let rates = body.start([body.nodes.clone().map(of).sum(), angular], &fixed).map_err(told)?;
            body.nodes.clone().for_each(|a| velocity[a] = Vector::from3(rates.at(arm(a)).0));
            self.state.rigid.push(RigidState::new(rates, &body.inertia));
        }
        let rigid = std::mem::take(&mut self.state.rigid);
        self.state = SolidState { rigid, ..SolidState::new(velocity) };
        Ok(())
    }

    /// Predicts the rigid solids, with the axes that supports hold.
    ///
    /// # Errors
    /// Supports that a rigid solid can't follow.
    pub(in crate::pfem2::solid) fn predict_rigid(
        &self,
        t_end: f64,
        step_weights: StepWeights,
        weights: [f64; 3],
        held: &dyn Fn(&RigidBody) -> Vec<HeldAxis>,
    ) -> Result<Vec<RigidPrediction>, StepError> {
        let mut first = 0;
        let predict = |(body, state): (&RigidBody, &RigidState)| {
            let mut own = body.predict(state, t_end, step_weights, weights, &held(body)).map_err(
                |Contradiction { missed }| {
                    let name = &self.setups()[body.solid].name;
                    let what = format!("the supports of the rigid solid `{name}` ask for a deformation");
                    let advice = "give all of its supports velocities of one rigid motion";
                    StepError::new(Place::Everywhere, what, "missed velocity", missed, advice)
                },
            )?;
            own.first = first;
            first += own.freedom.free.len() as u32;
            Ok(own)
        };
        self.rigid.iter().zip(&self.state.rigid).map(predict).collect()
    }

    /// Puts the nodes of rigid solids where they are with their displacement and rotation.
    pub(in crate::pfem2::solid) fn place_rigid(
        &self,
        displacement: &mut [Vector<D>],
        motion: impl Fn(usize) -> (Vector<3>, Tensor<3>),
    ) {
        for (k, body) in self.rigid.iter().enumerate() {
            let (center, rotation) = motion(k);
            let place = |node| Vector::from3(body.displacement(center, &rotation, node).0);
            body.nodes.clone().enumerate().for_each(|(node, a)| displacement[a] = place(node));
        }
    }

    /// The independent velocities of a step: those of rigid solids, then those of free nodes, by the velocities that
    /// are `held` and a guess of all nodal ones [m/s].
    pub(in crate::pfem2::solid) fn independent(
        &self,
        held: &[Option<f64>],
        guess: &[Vector<D>],
        rigid: &[RigidPrediction],
    ) -> IndependentVelocities {
        let mut velocities = IndependentVelocities::default();
        let mut rows: Vec<Option<VelocityRow>> = vec![None; held.len()];
        for ((body, prediction), state) in self.rigid.iter().zip(rigid).zip(&self.state.rigid) {
            velocities.add(&prediction.freedom.coordinates(&state.rates()));
            let own = body.nodes.start * D..body.nodes.end * D;
            own.for_each(|k| rows[k] = Some(body.row(prediction, k / D - body.nodes.start, k % D)));
        }
        for k in 0..held.len() {
            if let Some(velocity) = held[k].filter(|_| rows[k].is_none()) {
                rows[k] = Some((Vec::new(), velocity));
            } else if rows[k].is_none() && self.ties.leaders((k / D) as u32).is_none() {
                rows[k] = Some((vec![(velocities.add(&[guess[k / D][k % D]]), 1.0)], 0.0));
            }
        }
        for k in 0..held.len() {
            let (entries, prescribed) = rows[k].clone().unwrap_or_else(|| self.tied_row(&rows, k));
            velocities.push(&entries, prescribed);
        }
        velocities
    }

    /// The independent velocities of solids at rest, where prescribed ones vanish and rigid solids stay.
    pub(in crate::pfem2::solid) fn independent_at_rest(&self) -> IndependentVelocities {
        let mut held: Vec<_> = self.held_velocities(0.0).into_iter().map(|held| held.map(|_| 0.0)).collect();
        self.rigid.iter().for_each(|body| held[body.nodes.start * D..body.nodes.end * D].fill(Some(0.0)));
        self.independent(&held, &self.state.velocity, &[])
    }

    /// The row of an unknown that follows others.
    fn tied_row(&self, rows: &[Option<VelocityRow>], k: usize) -> VelocityRow {
        let (mut entries, mut prescribed) = (Vec::new(), 0.0);
        for &(leader, weight) in self.ties.leaders((k / D) as u32).unwrap_or_default() {
            if let Some((own, velocity)) = &rows[leader as usize * D + k % D] {
                entries.extend(own.iter().map(|&(column, value)| (column, value * weight)));
                prescribed += velocity * weight;
            }
        }
        (entries, prescribed)
    }

    /// Lets the rigid solids that have some of these nodes begin anew with the velocity that they have, and the forces
    /// of the step before: those of the fluid in a collision are an impulse, too.
    pub(in crate::pfem2::solid) fn begin_anew(&mut self, nodes: &[usize]) {
        let SolidState {
            rigid,
            velocity,
            velocity_previous,
            velocity_earlier,
            acceleration,
            acceleration_previous,
            surface_acceleration,
            surface_acceleration_previous,
            ..
        } = &mut self.state;
        for (body, state) in self.rigid.iter().zip(rigid) {
            let own = body.nodes.clone();
            if nodes.iter().any(|node| own.contains(node)) {
                state.begin_anew();
                velocity_previous[own.clone()].copy_from_slice(&velocity[own.clone()]);
                velocity_earlier[own.clone()].copy_from_slice(&velocity[own.clone()]);
                acceleration[own.clone()].copy_from_slice(&acceleration_previous[own.clone()]);
                surface_acceleration[own.clone()].copy_from_slice(&surface_acceleration_previous[own]);
            }
        }
    }

    /// The forces of the last step on rigid solids, without impulses, along their independent velocities.
    pub(in crate::pfem2::solid) fn rigid_forces(&self, prediction: &Prediction<D>) -> Vec<f64> {
        let all = self.rigid.iter().zip(&self.state.rigid).zip(&prediction.rigid);
        all.flat_map(|((body, state), prediction)| body.forces(state, prediction)).collect()
    }

    /// Takes out of the accelerations of rigid solids, at the end of a step with the implicit part `delta` [s], what
    /// these forces on nodes gave them [N].
    pub(in crate::pfem2::solid) fn take_out_impulses(
        &mut self,
        delta: f64,
        prediction: &Prediction<D>,
        forces: &[(usize, Vector<D>)],
    ) {
        for ((body, prediction), state) in self.rigid.iter().zip(&prediction.rigid).zip(&mut self.state.rigid) {
            let mut own = forces.iter().filter(|(node, _)| body.nodes.contains(node)).peekable();
            if own.peek().is_none() {
                continue;
            }
            let own = own.map(|&(node, force)| (node - body.nodes.start, Vector(force.to3())));
            let damping = self.setups[body.solid].damping.mass;
            let given = body.accelerations(prediction, delta, damping, own);
            body.take_out(state, prediction, &given);
            for node in body.nodes.clone() {
                let own = given.at(body.arm(prediction, node - body.nodes.start));
                self.state.acceleration[node] -= Vector::from3(own.0);
            }
        }
    }

    /// Inertia of rigid solids along the independent velocities.
    pub(in crate::pfem2::solid) fn rigid_inertia(&self, delta: f64, prediction: &Prediction<D>) -> IndependentInertia {
        let mut inertia = IndependentInertia::default();
        for (body, prediction) in self.rigid.iter().zip(&prediction.rigid) {
            body.add_inertia(prediction, delta, self.setups()[body.solid].damping.mass, &mut inertia);
        }
        inertia
    }

    /// Power of the inertia of rigid solids at the end of a step with the independent velocities `w` [W].
    pub(in crate::pfem2::solid) fn rigid_power(&self, delta: f64, prediction: &Prediction<D>, w: &[f64]) -> f64 {
        let power = |(body, prediction): (&RigidBody, &RigidPrediction)| {
            let rates = prediction.rates(w);
            body.inertial(prediction, delta, self.setups()[body.solid].damping.mass, &rates).dot(&rates)
        };
        self.rigid.iter().zip(&prediction.rigid).map(power).sum()
    }

    /// Force and moment that the motion of a rigid solid needs at the end of a step with the independent velocities `w`
    /// (theory (J.16)); `None` of an elastic one.
    pub(in crate::pfem2::solid) fn rigid_inertial(
        &self,
        solid: usize,
        delta: f64,
        prediction: &Prediction<D>,
        w: &[f64],
    ) -> Option<RigidLoad> {
        let (body, rigid) = self.rigid_of(solid, prediction)?;
        let load = body.inertial(rigid, delta, self.setups()[solid].damping.mass, &rigid.rates(w));
        Some(RigidLoad { load, center: body.center + rigid.displacement })
    }

    /// Inertial force and moment of the motion that impulses on nodes, as forces that act for Δ [N], give a rigid
    /// solid; `None` of an elastic one.
    pub(in crate::pfem2::solid) fn rigid_response(
        &self,
        solid: usize,
        delta: f64,
        prediction: &Prediction<D>,
        impulses: &[(usize, Vector<D>)],
    ) -> Option<RigidLoad> {
        let (body, rigid) = self.rigid_of(solid, prediction)?;
        let damping = self.setups()[solid].damping.mass;
        let own = impulses.iter().map(|&(node, force)| (node - body.nodes.start, Vector(force.to3())));
        let load = body.inertia_of(rigid, delta, damping, &body.accelerations(rigid, delta, damping, own));
        Some(RigidLoad { load, center: body.center + rigid.displacement })
    }

    fn rigid_of<'a>(
        &'a self,
        solid: usize,
        prediction: &'a Prediction<D>,
    ) -> Option<(&'a RigidBody, &'a RigidPrediction)> {
        self.rigid.iter().zip(&prediction.rigid).find(|(body, _)| body.solid == solid)
    }
}

/// The axes of a rigid solid that supports hold, with the velocity of each unknown, and their displacement by unknown
/// and velocity.
pub(in crate::pfem2::solid) fn held_axes<const D: usize>(
    body: &RigidBody,
    held: &[Option<f64>],
    displacement: impl Fn(usize, f64) -> f64,
) -> Vec<HeldAxis> {
    let axis = |k: usize| {
        let velocity = held[k]?;
        let (node, axis) = (k / D - body.nodes.start, k % D);
        Some(HeldAxis { node, axis, velocity, displacement: displacement(k, velocity) })
    };
    (body.nodes.start * D..body.nodes.end * D).filter_map(axis).collect()
}
