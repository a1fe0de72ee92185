//! Viscous dissipation of a step, as the scheme takes it (theory (F.40)).
//!
//! A step gives the fluid the momentum Δt Σ_k w_k F_k, with the viscous forces F_k of its end, its start and the start
//! of the step before, and the weights w = θ, β₁, β₂ (see `step`). Its kinetic energy changes by this times the mean of
//! the velocities before and after, v̄ = ½ (vⁿ + vⁿ⁺¹); powers of the forces on their own velocities differ from that
//! by a factor where the step is long for viscosity (vortices that decay within a step: 0.3; layers that a force keeps
//! up: 2):
//!
//! ```text
//! D = Δt Σ_k w_k q(v̄, u_k),        q(a, b) = ∫2μ d(a):d(b),        u_k the velocity that makes F_k
//! 4 q(v̄, u_k) = q(vⁿ⁺¹) + q(vⁿ) + 2 q(u_k) − q(vⁿ⁺¹ − u_k) − q(vⁿ − u_k)
//! ```
//!
//! The first three powers are sums over the fluid, wherever it was at their time. Differences follow the fluid: what
//! was at a node is taken at the foot of its streamline. u_k = vᵏ, but for the first step, whose explicit part is that
//! of the predictor step.
//!
//! In elements that solids cut, q is the sum over the simplices of the fluid part with the velocity of the surface at
//! cut points: a fluid that sticks loses most of its energy there. They may be slivers, over which nothing follows the
//! fluid: their powers are those of the forces on their own velocities, D = Δt Σ_k w_k q(u_k).

use crate::math::Vector;
use crate::parallel;
use crate::pfem2::element::shear::shear_rate;
use crate::pfem2::equations::system::VelocityPressureSystem;
use crate::pfem2::history::StepWeights;
use crate::pfem2::solid::coupling::immersed::Immersed;
use crate::pfem2::solid::cut::{CutBySolid, ElementState};

/// Powers and velocities of the steps before.
#[derive(Debug, Clone, Default)]
pub struct ViscousDissipation<const D: usize> {
    /// q(u_n) [W]; without a predictor step q(vⁿ).
    pub power_last: f64,
    /// q(u_n−1) [W].
    pub power_earlier: f64,
    /// q(u_n) and q(u_n−1) in the elements that solids cut [W].
    pub in_cut: [f64; 2],
    /// vⁿ − u_n−1 at the nodes [m/s]: one column of a checkpoint.
    pub change: Vec<Vector<D>>,
    /// vⁿ at the feet of the nodes' streamlines of this step [m/s].
    pub start: Vec<Vector<D>>,
}

impl<const D: usize> ViscousDissipation<D> {
    /// The dissipation of a fluid without history: `nodes` nodes.
    pub fn at_rest(nodes: usize) -> Self {
        Self {
            power_last: 0.0,
            power_earlier: 0.0,
            in_cut: [0.0; 2],
            change: vec![Vector::ZERO; nodes],
            start: vec![Vector::ZERO; nodes],
        }
    }

    /// Begins after the predictor of the first step, whose end makes the forces at the start and before.
    pub fn begin<const N: usize>(&mut self, system: &VelocityPressureSystem<D, N>) {
        let both = self.start.iter().zip(&system.velocity);
        self.change = both.map(|(start, end)| *start - *end).collect();
        let [end] = powers(system, |i| [system.velocity[i]]);
        (self.power_last, self.power_earlier) = (end, end);
        self.in_cut = [power_in_cut(system); 2];
    }

    /// Viscous dissipation of the step [J]; by its `step_weights`; `first`: nothing came before it but the predictor
    /// step.
    pub fn of_step<const N: usize>(
        &mut self,
        system: &VelocityPressureSystem<D, N>,
        step_weights: StepWeights,
        first: bool,
    ) -> f64 {
        let grown = |i: usize| system.velocity[i] - self.start[i];
        let lag = |i: usize| if first { self.change[i] } else { Vector::ZERO };
        let [start, end, of_growth, of_lag_to_end, of_lag, of_change_to_end, of_change] = powers(system, |i| {
            let (grown, lag, change) = (grown(i), lag(i), self.change[i]);
            [self.start[i], system.velocity[i], grown, grown + lag, lag, grown + change, change]
        });
        let (power_last, power_earlier) = (self.power_last, self.power_earlier);
        let start = if first { start } else { power_last };
        let work = |own: f64, differences: f64| 0.25 * (end + start + 2.0 * own - differences);
        let work_end = work(end, of_growth);
        let work_last = work(power_last, of_lag_to_end + of_lag);
        let work_earlier = work(power_earlier, of_change_to_end + of_change);
        self.change = (0..self.change.len()).map(|i| grown(i) + lag(i)).collect();
        (self.power_last, self.power_earlier) = (end, power_last);
        let [last_in_cut, earlier_in_cut] = self.in_cut;
        let in_cut = power_in_cut(system);
        self.in_cut = [in_cut, last_in_cut];
        let weighted = |own: f64, last: f64, earlier: f64| {
            step_weights.dt * (step_weights.end * own + step_weights.start * last + step_weights.earlier * earlier)
        };
        weighted(work_end, work_last, work_earlier) + weighted(in_cut, last_in_cut, earlier_in_cut)
    }
}

/// q of several velocities, given by node, in the elements that no solid cuts [W].
fn powers<const D: usize, const N: usize, const K: usize>(
    system: &VelocityPressureSystem<D, N>,
    velocity: impl Fn(usize) -> [Vector<D>; K] + Sync,
) -> [f64; K] {
    let of_element = |e: usize| {
        let (simplex, content) = (system.mesh.simplex(e), &system.contents.elements[e]);
        let is_cut = |immersed: &Immersed<D, N>| matches!(immersed.cut.state[e], ElementState::Cut(_));
        if system.immersed.as_ref().is_some_and(is_cut) {
            return [0.0; K];
        }
        let nodal = system.mesh.elements()[e].map(|node| velocity(node as usize));
        std::array::from_fn(|k| {
            let rate = shear_rate(&simplex.gradient, &nodal.map(|velocities| velocities[k]));
            simplex.volume * content.viscosity * rate.powi(2)
        })
    };
    let add = |a: [f64; K], b: [f64; K]| std::array::from_fn(|k| a[k] + b[k]);
    let chunk = |range: std::ops::Range<usize>| range.map(of_element).fold([0.0; K], add);
    parallel::reduce(system.contents.elements.len(), chunk, add).unwrap_or([0.0; K])
}

/// q of the velocity at the end of the step, in the elements that solids cut [W].
fn power_in_cut<const D: usize, const N: usize>(system: &VelocityPressureSystem<D, N>) -> f64 {
    let Some(immersed) = &system.immersed else { return 0.0 };
    let of_element = |place: usize| {
        let CutBySolid { element, .. } = immersed.cut.elements[place];
        let viscosity = system.contents.elements[element as usize].viscosity;
        immersed.viscous_power(&system.mesh, place, viscosity, &system.velocity)
    };
    let chunk = |range: std::ops::Range<usize>| range.map(of_element).sum::<f64>();
    parallel::reduce(immersed.cut.elements.len(), chunk, |a, b| a + b).unwrap_or(0.0)
}
