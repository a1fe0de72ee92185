//! Rigid solids: motion of the centre of mass and rotation, in the scheme of elastic ones (theory J.11).
//!
//! ```text
//! v_a = V + ω × r_a,   r_a = R (X_a − X_c),   J = R J₀ Rᵀ,   L = J ω
//! m (V − V̂)/Δ = Σ f_a,     (J* ω − L̂)/Δ = Σ r_a* × f_a
//! c^{n+1} = ĉ + Δ V,       R^{n+1} = exp(Δ ω + Δt (β₁ ωⁿ + β₂ ωⁿ⁻¹)) Rⁿ
//! ```
//!
//! Starred: of the prediction at the end of the step. Vectors have three components also in the plane, where supports
//! take V_z, ω_x and ω_y. The rotation is one to rounding, so that the shape stays; the angular momentum is that
//! of the equations, so that it stays without a torque.

mod freedom;
mod state;

use super::equations::IndependentInertia;
use super::setup::PrescribedMotion;
use crate::linalg::{MatrixEntry, SparseMatrix};
use crate::math::{Signal, Tensor, Vector};
use crate::parallel;
use crate::pfem2::history::StepWeights;
pub use freedom::{Contradiction, Freedom, RigidRates};
pub use state::{RigidPrediction, RigidState};
use std::ops::Range;

/// A rigid solid.
#[derive(Debug)]
pub struct RigidBody {
    /// Number of the solid among all.
    pub solid: usize,
    /// Nodes of the solid among those of all solids.
    pub nodes: Range<usize>,
    /// Mass [kg].
    pub mass: f64,
    /// Centre of mass in the reference state [m].
    pub center: Vector<3>,
    /// Moments of inertia J₀ about it [kg m²].
    pub inertia: Tensor<3>,
    /// X_a − X_c [m].
    arms: Vec<Vector<3>>,
    motion: PrescribedMotion,
    dimension: usize,
}

/// A force and a torque about the centre of mass of a rigid solid [N, N m].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RigidLoad {
    /// Both.
    pub load: RigidRates,
    /// Position of the centre of mass [m].
    pub center: Vector<3>,
}

/// A nodal unknown that supports hold during a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeldAxis {
    /// Node of the solid.
    pub node: usize,
    /// Axis.
    pub axis: usize,
    /// Velocity at the end of the step [m/s].
    pub velocity: f64,
    /// Displacement there [m].
    pub displacement: f64,
}

impl RigidBody {
    /// The solid with these nodes among those in `places` [m], whose pairs have the masses M_ab [kg].
    pub fn new<const D: usize>(
        solid: usize,
        nodes: Range<usize>,
        places: &[Vector<D>],
        mass: &SparseMatrix,
        motion: PrescribedMotion,
    ) -> Self {
        let place = |a: usize| Vector(places[a].to3());
        let of_row = |a: usize| mass.row(a).map(move |n| (a, mass.columns[n] as usize, mass.values[n]));
        let pairs: Vec<(usize, usize, f64)> = nodes.clone().flat_map(of_row).collect();
        let total = parallel::sum(pairs.len(), |n| pairs[n].2);
        let center = parallel::sum(pairs.len(), |n| place(pairs[n].1) * pairs[n].2) / total;
        let inertia_of = |&(a, b, mass): &(usize, usize, f64)| {
            let (r, s) = (place(a) - center, place(b) - center);
            (Tensor::identity() * r.dot(s) - Tensor::outer(r, s)) * mass
        };
        let inertia = parallel::sum(pairs.len(), |n| inertia_of(&pairs[n]));
        // Rounding leaves it unsymmetric.
        let inertia = (inertia + inertia.transpose()) * 0.5;
        let arms = nodes.clone().map(|a| place(a) - center).collect();
        Self { solid, nodes, mass: total, center, inertia, arms, motion, dimension: D }
    }

    /// The rates nearest to these momenta [kg m/s, kg m²/s] that supports allow at the start.
    ///
    /// # Errors
    /// Supports that contradict each other.
    pub fn start(&self, [momentum, angular]: [Vector<3>; 2], held: &[HeldAxis]) -> Result<RigidRates, Contradiction> {
        let freedom = self.freedom(&Tensor::identity(), 0.0, held)?;
        let inverse = self.inertia.inverse().unwrap_or(Tensor::ZERO);
        let rates = RigidRates { velocity: momentum / self.mass, spin: inverse.apply(angular) };
        Ok(freedom.rates(&freedom.coordinates(&rates)))
    }

    /// J₀ turned [kg m²].
    fn turned_inertia(&self, rotation: &Tensor<3>) -> Tensor<3> {
        rotation.dot(&self.inertia).dot(&rotation.transpose())
    }

    /// Motions that supports leave free at time `t` [s].
    fn freedom(&self, rotation: &Tensor<3>, t: f64, held: &[HeldAxis]) -> Result<Freedom, Contradiction> {
        let unit = |axis| Vector::unit(axis);
        let translation = |axis| RigidRates { velocity: unit(axis), spin: Vector::ZERO };
        let turn = |axis| RigidRates { velocity: Vector::ZERO, spin: unit(axis) };
        let mut rows = Vec::new();
        if self.dimension == 2 {
            rows.extend([translation(2), turn(0), turn(1)].map(|row| (row, 0.0)));
        }
        let PrescribedMotion { velocity, spin } = self.motion_at(t);
        rows.extend((0..3).filter_map(|axis| Some((translation(axis), velocity[axis]?))));
        rows.extend((0..3).filter_map(|axis| Some((turn(axis), spin[axis]?))));
        let arm = |node: usize| rotation.apply(self.arms[node]);
        rows.extend(held.iter().map(|held| (RigidRates::of_point(arm(held.node), held.axis), held.velocity)));
        Freedom::new((self.inertia.trace() / self.mass).sqrt(), &rows)
    }

    /// Prescribed velocity and spin at time `t` [m/s, 1/s].
    fn motion_at(&self, t: f64) -> PrescribedMotion<f64> {
        let of = |signals: &[Option<Signal>; 3]| {
            std::array::from_fn(|axis| signals[axis].as_ref().map(|signal| signal.value(self.center.0, t)))
        };
        PrescribedMotion { velocity: of(&self.motion.velocity), spin: of(&self.motion.spin) }
    }

    /// Predicts the end of a step at `t_end` [s], where v* has these weights of the last velocities.
    ///
    /// # Errors
    /// Supports that contradict each other.
    pub(in crate::pfem2) fn predict(
        &self,
        state: &RigidState,
        t_end: f64,
        step_weights: StepWeights,
        weights: [f64; 3],
        held: &[HeldAxis],
    ) -> Result<RigidPrediction, Contradiction> {
        let StepWeights { dt, end, start, earlier } = step_weights;
        let explicit = |[now, before]: [Vector<3>; 2]| (now * start + before * earlier) * dt;
        let mean = |rates: &[Vector<3>; 3]| {
            rates.iter().zip(weights).map(|(rate, weight)| *rate * (weight * dt)).sum::<Vector<3>>()
        };
        let displacement_hat = state.displacement + explicit([state.velocity[0], state.velocity[1]]);
        let turned = explicit([state.spin[0], state.spin[1]]);
        let (mut displacement, mut turn) = (state.displacement + mean(&state.velocity), mean(&state.spin));
        let PrescribedMotion { velocity, spin } = self.motion_at(t_end);
        for axis in 0..3 {
            displacement[axis] = velocity[axis].map_or(displacement[axis], |v| displacement_hat[axis] + end * dt * v);
            turn[axis] = spin[axis].map_or(turn[axis], |w| turned[axis] + end * dt * w);
        }
        let rotation = turned_by(turn, &state.rotation);
        let supported: Vec<_> = held.iter().map(|held| (held.node, held.axis, held.displacement)).collect();
        displacement += self.miss(displacement, &rotation, &supported);
        Ok(RigidPrediction {
            displacement_hat,
            velocity_hat: state.velocity[0] + explicit(state.acceleration),
            momentum_hat: state.momentum + explicit(state.torque),
            turned,
            displacement,
            inertia: self.turned_inertia(&rotation),
            freedom: self.freedom(&rotation, t_end, held)?,
            rotation,
            first: 0,
            supported,
        })
    }

    /// Distance of supported nodes from their prescribed displacements along each axis, in the mean [m].
    fn miss(&self, displacement: Vector<3>, rotation: &Tensor<3>, supported: &[(usize, usize, f64)]) -> Vector<3> {
        let count = parallel::sum(supported.len(), |n| Vector::<3>::unit(supported[n].1));
        let sum = parallel::sum(supported.len(), |n| {
            let (node, axis, wanted) = supported[n];
            Vector::<3>::unit(axis) * (wanted - self.displacement(displacement, rotation, node)[axis])
        });
        Vector::from_fn(|axis| if count[axis] > 0.0 { sum[axis] / count[axis] } else { 0.0 })
    }

    /// Displacement of a node [m], with that of the centre of mass and the rotation.
    pub fn displacement(&self, center: Vector<3>, rotation: &Tensor<3>, node: usize) -> Vector<3> {
        center + rotation.apply(self.arms[node]) - self.arms[node]
    }

    /// The entries of the row of T of a node along an axis about a prediction, and v̄ [m/s].
    pub fn row(&self, prediction: &RigidPrediction, node: usize, axis: usize) -> (Vec<(u32, f64)>, f64) {
        /// Less than this of the largest is rounding: the node is held.
        const LEAST_RATE: f64 = 1e-12;
        let arm = prediction.rotation.apply(self.arms[node]);
        let Freedom { particular, free, .. } = &prediction.freedom;
        let size = |rates: &RigidRates| rates.velocity.norm() + rates.spin.norm() * arm.norm();
        let entries = (prediction.first..).zip(free).map(|(column, rates)| (column, rates.at(arm)[axis], size(rates)));
        let entries = entries.filter(|(_, value, size)| value.abs() > LEAST_RATE * size);
        (entries.map(|(column, value, _)| (column, value)).collect(), particular.at(arm)[axis])
    }

    /// Momenta of rates about a prediction [kg m/s, kg m²/s].
    fn momenta(&self, prediction: &RigidPrediction, rates: &RigidRates) -> RigidRates {
        RigidRates { velocity: rates.velocity * self.mass, spin: prediction.inertia.apply(rates.spin) }
    }

    /// Force and torque that rates ask for about a prediction [N, N m], M q (1/Δ + α) − (m V̂, L̂)/Δ, with Δ = `delta`
    /// [s] and α = `damping` [1/s].
    pub fn inertial(&self, prediction: &RigidPrediction, delta: f64, damping: f64, rates: &RigidRates) -> RigidRates {
        let RigidRates { velocity, spin } = self.momenta(prediction, rates);
        let rate = delta.recip() + damping;
        RigidRates {
            velocity: velocity * rate - prediction.velocity_hat * (self.mass / delta),
            spin: spin * rate - prediction.momentum_hat / delta,
        }
    }

    /// Force and torque that accelerations ask for about a prediction [N, N m], M q̇ (1 + α Δ), with Δ = `delta` [s]
    /// and α = `damping` [1/s].
    pub fn inertia_of(
        &self,
        prediction: &RigidPrediction,
        delta: f64,
        damping: f64,
        accelerations: &RigidRates,
    ) -> RigidRates {
        let RigidRates { velocity, spin } = self.momenta(prediction, accelerations);
        let factor = 1.0 + damping * delta;
        RigidRates { velocity: velocity * factor, spin: spin * factor }
    }

    /// Adds M_r and h along the independent velocities, with Δ = `delta` [s] and α = `damping` [1/s].
    pub fn add_inertia(
        &self,
        prediction: &RigidPrediction,
        delta: f64,
        damping: f64,
        inertia: &mut IndependentInertia,
    ) {
        let Freedom { particular, free, .. } = &prediction.freedom;
        let start = self.inertial(prediction, delta, damping, particular);
        for (row, left) in (prediction.first..).zip(free) {
            inertia.loads.push((row, -left.dot(&start)));
            for (column, right) in (prediction.first..).zip(free) {
                let entry = left.dot(&self.momenta(prediction, right)) * (delta.recip() + damping);
                inertia.entries.push(MatrixEntry::new(row, column, entry));
            }
        }
    }

    /// Vector from the centre of mass to a node as predicted [m].
    pub fn arm(&self, prediction: &RigidPrediction, node: usize) -> Vector<3> {
        prediction.rotation.apply(self.arms[node])
    }

    /// The accelerations that forces on nodes [N] give the solid about a prediction, with Δ = `delta` [s] and
    /// α = `damping` [1/s], along what supports leave free.
    pub fn accelerations(
        &self,
        prediction: &RigidPrediction,
        delta: f64,
        damping: f64,
        forces: impl Iterator<Item = (usize, Vector<3>)>,
    ) -> RigidRates {
        let mut force = RigidRates::default();
        for (node, own) in forces {
            force.velocity += own;
            force.spin += self.arm(prediction, node).cross(own);
        }
        // Gram and Schmidt's method with the mass: Σ q (q·f)/(q·M q).
        let mut accelerations = RigidRates::default();
        let mut basis: Vec<[RigidRates; 2]> = Vec::new();
        for free in &prediction.freedom.free {
            let mut q = *free;
            for [other, momenta] in &basis {
                q.add(other, -momenta.dot(&q) / momenta.dot(other));
            }
            let momenta = self.momenta(prediction, &q);
            accelerations.add(&q, q.dot(&force) / (momenta.dot(&q) * (1.0 + damping * delta)));
            basis.push([q, momenta]);
        }
        accelerations
    }

    /// The forces of the last step, without impulses, along the independent velocities.
    pub fn forces<'a>(&self, state: &RigidState, prediction: &'a RigidPrediction) -> impl Iterator<Item = f64> + 'a {
        let force = RigidRates { velocity: state.acceleration[0] * self.mass, spin: state.torque[0] };
        prediction.freedom.free.iter().map(move |free| free.dot(&force))
    }

    /// Takes accelerations out of those at the end of a step.
    pub fn take_out(&self, state: &mut RigidState, prediction: &RigidPrediction, accelerations: &RigidRates) {
        state.acceleration[0] -= accelerations.velocity;
        state.torque[0] -= prediction.inertia.apply(accelerations.spin);
    }

    /// Ends a step with the implicit part `delta` [s] and these rates.
    pub fn advance(&self, state: &mut RigidState, delta: f64, prediction: &RigidPrediction, rates: &RigidRates) {
        let RigidPrediction { displacement_hat, velocity_hat, momentum_hat, turned, .. } = prediction;
        state.rotation = turned_by(rates.spin * delta + *turned, &state.rotation);
        state.displacement = *displacement_hat + rates.velocity * delta;
        state.displacement += self.miss(state.displacement, &state.rotation, &prediction.supported);
        let momentum = prediction.inertia.apply(rates.spin);
        state.acceleration = [(rates.velocity - *velocity_hat) / delta, state.acceleration[0]];
        state.torque = [(momentum - *momentum_hat) / delta, state.torque[0]];
        state.momentum = momentum;
        state.velocity = [rates.velocity, state.velocity[0], state.velocity[1]];
        state.spin = [rates.spin, state.spin[0], state.spin[1]];
    }
}

/// exp(ψ) R (Rodrigues), a rotation to rounding.
pub fn turned_by(psi: Vector<3>, rotation: &Tensor<3>) -> Tensor<3> {
    let angle = psi.norm();
    let [first, second] = match angle {
        0.0 => [1.0, 0.5],
        _ => [angle.sin() / angle, 2.0 * ((0.5 * angle).sin() / angle).powi(2)],
    };
    let cross = Tensor([[0.0, -psi[2], psi[1]], [psi[2], 0.0, -psi[0]], [-psi[1], psi[0], 0.0]]);
    let turn = Tensor::identity() + cross * first + cross.dot(&cross) * second;
    let made = turn.dot(rotation);
    // Newton's step towards the nearest rotation: products of many would drift.
    made.dot(&((Tensor::identity() * 3.0 - made.transpose().dot(&made)) * 0.5))
}
