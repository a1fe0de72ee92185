//! Errors of the linear equations of a step, F(u*) + K (u − u*) less the loads likewise, against the forces at its end
//! (theory J.14, J.16).

use super::{Prediction, Structure};
use crate::error::StepError;
use crate::math::Vector;
use crate::pfem2::ThetaStep;
use crate::pfem2::solid::setup::Inertia;

impl<const D: usize> Structure<D> {
    /// Force that quasi-static solids are off balance by at the end of a step, over the largest of their internal
    /// forces: what the linear equations of the step have of F(u) and of pressures that follow the surface too little
    /// or too much.
    ///
    /// # Errors
    /// As [`Structure::equations`].
    pub(in crate::pfem2) fn linearisation_error(
        &self,
        step: ThetaStep,
        prediction: &Prediction<D>,
    ) -> Result<f64, StepError> {
        if self.setups().iter().all(|setup| setup.inertia == Inertia::Dynamic) {
            return Ok(0.0);
        }
        let quasi_static = self.by_node(|setup| 1.0 - setup.inertia_rate(1.0));
        let way = self.increment_from_prediction(prediction, |a| self.state.displacement[a]);
        let mut linear = vec![Vector::ZERO; way.len()];
        self.visit_step(prediction, |_, nodes, forces| {
            for (a, &row) in nodes.iter().enumerate() {
                let change =
                    nodes.iter().enumerate().map(|(b, &column)| forces.tangent(a, b).apply(way[column as usize]));
                linear[row as usize] += forces.internal[a] + change.sum::<Vector<D>>();
            }
        })?;
        let whole = self.internal_forces()?;
        let pressures = self.pressure_error(step.end(), prediction, &way);
        let most = |force: &dyn Fn(usize) -> Vector<D>| {
            (0..way.len()).map(|a| quasi_static[a] * force(a).norm()).fold(0.0, f64::max)
        };
        Ok(most(&|a| whole[a] - linear[a] - pressures[a]) / most(&|a| whole[a]).max(f64::MIN_POSITIVE))
    }

    /// Internal forces on all nodes in the present state [N].
    fn internal_forces(&self) -> Result<Vec<Vector<D>>, StepError> {
        let mut whole = vec![Vector::ZERO; self.node_count()];
        self.visit(&self.state.displacement, |_, nodes, forces| {
            nodes.iter().zip(&forces.internal).for_each(|(&row, force)| whole[row as usize] += *force);
        })?;
        Ok(whole)
    }

    /// Forces of pressures in the present state, less what the linear equations have for them [N].
    fn pressure_error(&self, t: f64, prediction: &Prediction<D>, way: &[Vector<D>]) -> Vec<Vector<D>> {
        let mut error: Vec<_> = self.pressure_changes(t, prediction, way).into_iter().map(|force| -force).collect();
        let [now, predicted] = [&self.state.displacement, &prediction.displacement].map(|u| self.positions(u));
        self.pressures.forces(t, &now, |node, force| error[node as usize] += force);
        self.pressures.forces(t, &predicted, |node, force| error[node as usize] -= force);
        error
    }

    /// The change K_p (u − u*) of the forces of pressures at time `t` [s] over the `way` u − u* [m] from a prediction
    /// [N].
    pub(in crate::pfem2::solid) fn pressure_changes(
        &self,
        t: f64,
        prediction: &Prediction<D>,
        way: &[Vector<D>],
    ) -> Vec<Vector<D>> {
        let mut change = vec![Vector::ZERO; way.len()];
        let predicted = self.positions(&prediction.displacement);
        self.pressures.stiffness(t, &predicted, |(row, column), slope| {
            change[row as usize] += slope.apply(way[column as usize]);
        });
        change
    }

    /// The increment from u* to a displacement of each node [m].
    pub(in crate::pfem2) fn increment_from_prediction(
        &self,
        prediction: &Prediction<D>,
        to: impl Fn(usize) -> Vector<D>,
    ) -> Vec<Vector<D>> {
        prediction.displacement.iter().enumerate().map(|(a, predicted)| to(a) - *predicted).collect()
    }
}
