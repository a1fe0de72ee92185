//! The length of automatic steps: what a step does wrong in time is kept below what the mesh does wrong in space
//! (theory H.1–H.5).
//!
//! ```text
//! in time       e = ½ max(‖vⁿ⁺¹ − vⁿ − Δt (vⁿ − vⁿ⁻¹)/Δtⁿ‖, Δt ‖aⁿ⁺¹ − aⁿ at the feet of the streamlines‖)
//! on the mesh   η² = 1/30 Σ_e m_e h_e² mean over the corners i of |∇v_e − G_i|²,   G_i the mean of ∇v around node i
//! interface     d = ½ Δt |vⁿ⁺¹ − vⁿ − Δt (vⁿ − vⁿ⁻¹)/Δtⁿ|/h at the corners of cut elements, mean of 8th powers
//! solids        s² = ¼ dⁿ⁺¹·dⁿ⁺¹ max(cos(dⁿ⁺¹, dⁿ), 0.01) / largest v·v so far,
//!               dⁿ⁺¹ = vⁿ⁺¹ − vⁿ − Δt (vⁿ − vⁿ⁻¹)/Δtⁿ, products by their mass; less of weak vibrations (`vibration.rs`)
//! next step     Δt² = Δt_proposed Δt min((tolerance η/e)^½, (0.1/d)^⅓, (0.005 tolerance V/κ)^½/Δt),
//!               κ ← max(least s V/Δt² of three steps, 0.99 κ)
//! ```
//!
//! Time: e is by how much the velocity that moves the particles, and the mean force on their way, would be wrong if
//! they were extrapolated with one order less: an upper estimate, O(Δt²). The tolerance is 2 by default: the scheme is
//! one order better than e.
//!
//! Mesh: η is how far linear elements are from a velocity with the curvature that the jumps of its gradient show
//! (Zienkiewicz & Zhu 1987). Norms are weighted with mass, ‖v‖² = Σ m_i |v_i|². Elements that hold two fluids don't
//! count, since slip along an interface is no curvature. e and η fall with the square of their lengths, so the step
//! falls with the mesh and both errors vanish together.
//!
//! Interface: d is how far an interface runs ahead of the flow in one step. A tenth of an element is allowed; more
//! makes fingers where a heavy fluid runs into a light one.
//!
//! Solids: an oscillation with ω has s = ½ (ωΔt)². Motions slower than a quarter of the speed of the fluid are measured
//! by that speed. Noise, with changes d that have other signs in each step, counts a tenth, and a jump, as where a
//! surface passes a node of the mesh, not at all: it is as large in a shorter step, and s falls back after two. κ
//! remembers s over a period, and a proposal that grows by less than a fifth is ignored: steps that followed the phase
//! of an oscillation would drive it.
//!
//! The reasons, and the numbers, are in theory H.2–H.5.

use super::vibration::Vibration;
use crate::math::{Tensor, Vector};
use crate::parallel;
use crate::pfem2::equations::system::VelocityPressureSystem;
use crate::pfem2::history::TimeHistory;
use crate::pfem2::solid::structure::Structure;
use bytemuck::{Pod, Zeroable};

/// Growth from one step to the next.
const GROWTH: f64 = 1.25;

/// Errors in time below this part of the velocity shorten no step, whatever the mesh resolves.
const FLOOR: f64 = 1e-3;

/// Errors in time above this part of the velocity do, however coarse the mesh.
const CEILING: f64 = 0.05;

/// Least error that is allowed, as [`FLOOR`], in parts of the largest velocity so far, for flows that come to rest.
const AT_REST: f64 = 1e-4;

/// Least error that is allowed in parts of what gravity gives in a step: round-off of a fluid at rest is far below it.
const ROUND_OFF: f64 = 1e-6;

/// Elements that the interface may be off after a step.
const INTERFACE: f64 = 0.1;

/// Elements that the surface of a solid may be off its prediction, which cuts the mesh.
const SURFACE: f64 = 0.05;

/// The largest error of solids, over the tolerance.
const SOLIDS: f64 = 0.005 / 3.0;

/// Least speed by which the error of solids is measured, over the speed of the fluid: that of solids that move more
/// slowly counts as part of this.
const SLOW_SOLIDS: f64 = 0.25;

/// The least part of d·d that counts of changes d of the velocity: those that are unlike in each two steps are no
/// motion that shorter steps would follow, but noise.
const NOISE: f64 = 0.01;

/// Part of the error of solids, over the square of the step, that is forgotten in the longest step: half of it in one
/// and a half swings.
const FORGETTING: f64 = 0.01;

/// Beside solids, a proposed growth by less than this factor is ignored.
const RISE: f64 = 1.2;

/// Errors let steps be so many times longer than an impact asked for when it is over.
const IMPACT_OVER: f64 = 4.0;

/// Estimated errors of a step.
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct ErrorEstimates {
    /// Error of the velocity, in time, over the velocity.
    pub time: f64,
    /// Error of the velocity on the mesh, over the velocity.
    pub mesh: f64,
    /// Error of the interface, in elements.
    pub interface: f64,
    /// Error of the velocity of solids, in time, over the largest so far.
    pub solids: f64,
}

/// Automatic steps by the errors of the last ones.
#[derive(Debug, Clone, Copy)]
pub struct StepControl {
    /// The largest error in time over that of the mesh; infinity: steps follow the other bounds alone.
    tolerance: f64,
    /// The longest next step with errors that are allowed [s]; 0 before the first.
    pub(in crate::pfem2) proposal: f64,
    /// Errors of the last step.
    pub(in crate::pfem2) errors: ErrorEstimates,
    /// The largest kinetic energy of solids so far [J].
    pub(in crate::pfem2) solids_peak: f64,
    /// The error of the velocity of solids over the square of the step, as it is remembered [m/s³ √kg].
    pub(in crate::pfem2) solids_curvature: f64,
    /// The same error of the last two steps alone, the last first; infinite before the first [m/s³ √kg].
    pub(in crate::pfem2) solids_recent: [f64; 2],
    /// The vibration of solids over the last steps.
    pub(in crate::pfem2) vibration: Vibration,
    /// The next step as far as errors go [s]: the proposal, which small rises don't change where there are solids.
    pub(in crate::pfem2) recommended: f64,
    /// The step that an impact of solids asked for which is being resolved [s]; infinite without one.
    pub(in crate::pfem2) impact: f64,
}

impl StepControl {
    /// Control by the largest error in time over that of the mesh.
    pub fn new(tolerance: f64) -> Self {
        Self {
            tolerance,
            proposal: 0.0,
            errors: ErrorEstimates::default(),
            solids_peak: 0.0,
            solids_curvature: 0.0,
            solids_recent: [f64::INFINITY; 2],
            vibration: Vibration::default(),
            recommended: 0.0,
            impact: f64::INFINITY,
        }
    }

    /// True if errors decide about steps.
    pub fn is_active(&self) -> bool {
        self.tolerance.is_finite()
    }

    /// Learns from a step of `dt` [s] with these errors; `least` is the part of the velocity that doesn't matter,
    /// `speed` that by which errors of solids are measured [√kg m/s].
    fn learn(&mut self, dt: f64, errors: ErrorEstimates, least: f64, speed: f64) {
        let allowed = (self.tolerance * errors.mesh).clamp(FLOOR, CEILING).max(least);
        let [velocity, interface] = [(allowed / errors.time).sqrt(), (INTERFACE / errors.interface).cbrt()];
        let proposal = if self.proposal > 0.0 { self.proposal } else { dt };
        let kept = 1.0 - FORGETTING * (dt / proposal).min(1.0);
        let own = errors.solids * speed / dt.powi(2);
        let lasting = self.solids_recent.into_iter().fold(own, f64::min);
        self.solids_recent = [own, self.solids_recent[0]];
        self.solids_curvature = lasting.max(kept * self.solids_curvature);
        let solids = (SOLIDS * self.tolerance * speed / self.solids_curvature).sqrt() / dt;
        let wanted = (proposal * dt * velocity.min(interface).min(solids)).sqrt();
        self.proposal = wanted.clamp(0.5 * proposal, GROWTH * proposal);
        let follows = self.proposal < self.recommended || self.proposal > RISE * self.recommended;
        if follows || errors.solids == 0.0 {
            self.recommended = self.proposal;
        }
        self.errors = errors;
    }
}

impl StepControl {
    /// Estimates the errors of the step of `dt` [s] that is done, for the next one; `peak` is the largest kinetic
    /// energy so far [J], `solids` are those with meshes of their own, with the elements that their surface was off its
    /// prediction.
    pub(in crate::pfem2) fn estimate<const D: usize, const N: usize>(
        &mut self,
        dt: f64,
        system: &VelocityPressureSystem<D, N>,
        history: &TimeHistory<D>,
        peak: f64,
        solids: Option<(&mut Structure<D>, f64)>,
    ) {
        let TimeHistory { velocity_previous: previous, velocity_earlier: earlier, .. } = history;
        let (acceleration, acceleration_previous) = (&history.acceleration, &history.acceleration_previous);
        let nodes = system.velocity.len();
        let mass = parallel::collect(nodes, 256, |node| system.nodal_mass(node));
        let norm = |value: &(dyn Fn(usize) -> Vector<D> + Sync)| {
            parallel::sum(nodes, |i| mass[i] * value(i).norm_squared()).sqrt()
        };
        let extends = if history.dt_previous > 0.0 { dt / history.dt_previous } else { 0.0 };
        let off = |i: usize| system.velocity[i] - previous[i] - (previous[i] - earlier[i]) * extends;
        let velocity = norm(&|i| system.velocity[i]);
        let time = 0.5 * norm(&off).max(dt * norm(&|i| acceleration[i] - acceleration_previous[i]));
        let fall = norm(&|i| system.force[i]) * dt;
        let least = AT_REST * (2.0 * peak).sqrt() + ROUND_OFF * fall;
        let surface = solids.as_ref().map_or(0.0, |(_, off)| off * INTERFACE / SURFACE);
        let interface = interface_error(system, |i| 0.5 * dt * off(i).norm()).max(surface);
        let scale = velocity.max(f64::MIN_POSITIVE);
        let stream = (2.0 * peak / parallel::sum(nodes, |i| mass[i])).sqrt();
        let mut errors =
            ErrorEstimates { time: time / scale, mesh: mesh_error(system) / scale, interface, solids: 0.0 };
        let mut speed = 1.0;
        if let Some((structure, _)) = solids {
            let found = self.solids_error(structure, extends, stream);
            self.vibration = found.vibration;
            (speed, self.solids_peak) = (found.speed, found.peak);
            errors.solids = found.error * self.vibration.counts(speed);
            structure.state.velocity_change = found.change;
        }
        self.learn(dt, errors, least / scale, speed);
    }

    /// Lets the next step be no longer than an impact asks for [s], and those after it grow from there (theory J.8).
    pub(in crate::pfem2) fn shorten(&mut self, longest: f64) {
        if longest < self.recommended {
            (self.proposal, self.recommended) = (self.proposal.min(longest), longest);
            self.impact = self.impact.min(longest);
        }
        if self.recommended > IMPACT_OVER * self.impact {
            self.impact = f64::INFINITY;
        }
    }

    /// The error of solids in a step that is `extends` times as long as the last one, in a `stream` of this speed
    /// [m/s].
    fn solids_error<const D: usize>(&self, structure: &Structure<D>, extends: f64, stream: f64) -> SolidsError<D> {
        let state = &structure.state;
        let (now, before, earlier) = (&state.velocity, &state.velocity_previous, &state.velocity_earlier);
        let off = |i: usize| now[i] - before[i] - (before[i] - earlier[i]) * extends;
        let product = |a: &[Vector<D>], b: &[Vector<D>]| {
            let weighted = structure.weighted_by_mass(a);
            parallel::sum(weighted.len(), |k| weighted[k] * b[k / D][k % D])
        };
        let peak = self.solids_peak.max(0.5 * product(now, now));
        let slow = SLOW_SOLIDS * stream * structure.mass().sqrt();
        let speed = (2.0 * peak).sqrt().max(slow).max(f64::MIN_POSITIVE);
        let change: Vec<Vector<D>> = (0..now.len()).map(off).collect();
        let [own, both, last] = [
            product(&change, &change),
            product(&change, &state.velocity_change),
            product(&state.velocity_change, &state.velocity_change),
        ];
        let vibration = self.vibration.after(own, (own - 2.0 * both + last).max(0.0));
        SolidsError { error: 0.5 * resolved([own, both, last]).sqrt() / speed, speed, peak, vibration, change }
    }
}

/// The error of solids in a step, and what the next estimate needs of it.
struct SolidsError<const D: usize> {
    /// Error of the velocity, in time, over `speed`.
    error: f64,
    /// Speed by which it is measured [√kg m/s].
    speed: f64,
    /// The largest kinetic energy of solids so far [J].
    peak: f64,
    /// The vibration that the changes show.
    vibration: Vibration,
    /// d at the nodes, by how much the velocity differs from what the last two steps let expect [m/s].
    change: Vec<Vector<D>>,
}

/// The part of d·d that counts, given d·d of this step, the product of d with that of the step before, and d·d of that
/// one.
fn resolved([own, both, last]: [f64; 3]) -> f64 {
    let alike = if last > 0.0 && own > 0.0 { both / (own * last).sqrt() } else { 1.0 };
    own.max(0.0) * alike.max(NOISE)
}

/// Estimated distance of the velocity from that of which it is an interpolation, ‖·‖ by mass [√kg m/s].
fn mesh_error<const D: usize, const N: usize>(system: &VelocityPressureSystem<D, N>) -> f64 {
    let (mesh, velocity) = (&system.mesh, &system.velocity);
    let gradient = |e: usize| -> Tensor<D> {
        let mut sum = Tensor::ZERO;
        for (g, &i) in mesh.simplex(e).gradient.iter().zip(&mesh.elements()[e]) {
            sum += Tensor::from_fn(|r, c| velocity[i as usize][r] * g[c]);
        }
        sum
    };
    let gradients = parallel::collect(mesh.elements().len(), 256, gradient);
    let mean = |node: usize| -> Tensor<D> {
        let (mut sum, mut volume) = (Tensor::ZERO, 0.0);
        for e in mesh.elements_around(node).iter().map(|&e| e as usize).filter(|&e| system.is_pure(e)) {
            let own = mesh.simplex(e).volume;
            sum += gradients[e] * own;
            volume += own;
        }
        if volume > 0.0 { sum * volume.recip() } else { sum }
    };
    let means = parallel::collect(velocity.len(), 256, mean);
    let square = |e: usize| {
        let mass: f64 = system.contents.elements[e].mass.iter().sum();
        let jumps = mesh.elements()[e].iter().map(|&i| {
            let jump = gradients[e] - means[i as usize];
            jump.contract(&jump)
        });
        if system.is_pure(e) { mass * system.size(e).powi(2) * jumps.sum::<f64>() / N as f64 } else { 0.0 }
    };
    (parallel::sum(gradients.len(), square) / 30.0).sqrt()
}

/// The distance `off` of nodes [m], in elements, at the corners of cut elements; 8th powers let the largest count.
fn interface_error<const D: usize, const N: usize>(
    system: &VelocityPressureSystem<D, N>,
    off: impl Fn(usize) -> f64 + Sync,
) -> f64 {
    let cuts = &system.contents.cuts;
    let of = |cut: usize| {
        let e = cuts[cut].element as usize;
        let corners = system.mesh.elements()[e].iter();
        corners.map(|&i| (off(i as usize) / system.size(e)).powi(8)).sum::<f64>() / N as f64
    };
    (parallel::sum(cuts.len(), of) / cuts.len().max(1) as f64).powf(0.125)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Errors that go with Δt² lead to the step at which they are as large as allowed, from both sides and without
    /// leaps.
    #[test]
    fn steps_settle_where_the_error_in_time_is_the_tolerance_times_that_of_the_mesh() {
        for first in [0.001, 0.3] {
            let mut control = StepControl::new(2.0);
            let mut dt: f64 = first;
            for _ in 0..60 {
                control.learn(
                    dt,
                    ErrorEstimates { time: 3.0 * dt * dt, mesh: 0.006, interface: 0.0, solids: 0.0 },
                    0.0,
                    1.0,
                );
                assert!((0.5..=GROWTH * 1.000001).contains(&(control.proposal / dt)), "{dt} {}", control.proposal);
                dt = control.proposal;
            }
            assert!((dt / (0.012_f64 / 3.0).sqrt() - 1.0).abs() < 1e-6, "{dt}");
        }
    }

    /// Outputs that cut steps don't change what the control would take.
    #[test]
    fn steps_cut_by_outputs_do_not_shorten_what_is_proposed() {
        let mut control = StepControl::new(2.0);
        for _ in 0..200 {
            let dt = control.proposal.clamp(0.001, 0.01);
            control.learn(
                dt,
                ErrorEstimates { time: 3.0 * dt * dt, mesh: 0.006, interface: 0.0, solids: 0.0 },
                0.0,
                1.0,
            );
        }
        assert!((control.proposal / (0.012_f64 / 3.0).sqrt() - 1.0).abs() < 1e-6, "{}", control.proposal);
    }

    #[test]
    fn an_interface_that_would_run_ahead_shortens_steps() {
        let mut control = StepControl::new(2.0);
        let mut dt: f64 = 0.1;
        for _ in 0..60 {
            control.learn(
                dt,
                ErrorEstimates { time: 0.0, mesh: 0.01, interface: 800.0 * dt.powi(3), solids: 0.0 },
                0.0,
                1.0,
            );
            dt = control.proposal;
        }
        assert!((dt / 0.05 - 1.0).abs() < 1e-6, "{dt}");
    }

    /// Of a swing with 77 steps per period the changes of the velocity count but for 1 %, of white noise, whose second
    /// differences have the product −⅔ from one step to the next, a tenth; the first step counts whole, as there is
    /// none to compare with.
    #[test]
    fn noise_of_solids_hardly_shortens_steps() {
        let phase = 2.0 * std::f64::consts::PI / 77.0;
        let swing = |k: f64| [(phase * k).cos(), (phase * k).sin()];
        let change = |k: f64| [0, 1].map(|i| swing(k)[i] - 2.0 * swing(k - 1.0)[i] + swing(k - 2.0)[i]);
        let product = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
        let (now, before) = (change(7.0), change(6.0));
        let own = product(now, now);
        let counted = resolved([own, product(now, before), product(before, before)]) / own;
        assert!((counted - phase.cos()).abs() < 1e-9 && counted > 0.98, "{counted}");
        assert!((resolved([6.0, -4.0, 6.0]) / 6.0 - 0.01).abs() < 1e-12);
        assert_eq!(resolved([6.0, 0.0, 0.0]), 6.0);
    }

    /// An error that is there at some phases of a swing alone doesn't lengthen steps in between.
    #[test]
    fn steps_beside_solids_do_not_follow_the_phase_of_a_swing() {
        let mut control = StepControl::new(2.0);
        let (omega, mut dt, mut t): (f64, f64, f64) = (34.3, 0.001, 0.0);
        let mut steps = Vec::new();
        for k in 0..500 {
            let solids = 0.5 * (omega * dt).powi(2) * (omega * t).cos().abs();
            control.learn(dt, ErrorEstimates { time: 0.0, mesh: 0.01, interface: 0.0, solids }, 0.0, 1.0);
            t += dt;
            dt = control.recommended;
            if k >= 200 {
                steps.push(dt);
            }
        }
        let (least, most) = steps.iter().fold((f64::INFINITY, 0.0f64), |(a, b), dt| (a.min(*dt), b.max(*dt)));
        assert!(
            most < 1.05 * least && steps.windows(2).filter(|pair| pair[0] != pair[1]).count() < 40,
            "{least} {most}"
        );
    }

    /// A jump of the velocity, which is as large whatever the step is, shows in two steps: it shortens none.
    #[test]
    fn jumps_of_solids_shorten_no_steps() {
        let mut control = StepControl::new(2.0);
        let mut dt: f64 = 0.001;
        let mut least = f64::INFINITY;
        for k in 0..400 {
            let jump = if k % 40 > 37 { 0.02 } else { 0.0 };
            let solids = 0.5 * (34.3 * dt).powi(2) + jump;
            control.learn(dt, ErrorEstimates { time: 0.0, mesh: 0.01, interface: 0.0, solids }, 0.0, 1.0);
            dt = control.recommended;
            if k >= 100 {
                least = least.min(dt);
            }
        }
        // The swing alone, whose steps may be shorter by what counts as no growth.
        let steps = 2.0 * std::f64::consts::PI / 34.3 / least;
        assert!(steps < 76.95 * RISE, "{steps}");
    }

    /// A solid that begins to move, v ∝ t², is measured by what it has so far: its steps may grow with the time.
    #[test]
    fn steps_grow_while_a_solid_gathers_speed() {
        let mut control = StepControl::new(2.0);
        let (mut dt, mut t): (f64, f64) = (0.001, 0.01);
        for _ in 0..100 {
            t += dt;
            let speed = t * t;
            control.learn(
                dt,
                ErrorEstimates { time: 0.0, mesh: 0.01, interface: 0.0, solids: dt * dt / speed },
                0.0,
                speed,
            );
            dt = control.recommended;
        }
        assert!(dt > 0.05 * t, "{dt} {t}");
    }

    /// A swing with ω has the error ½ (ωΔt)², and gets 2π/√(0.02/3) = 77 steps per period with the tolerance of 2.
    #[test]
    fn a_swing_of_a_solid_gets_77_steps() {
        let mut control = StepControl::new(2.0);
        let (omega, mut dt): (f64, f64) = (34.3, 0.02);
        for _ in 0..60 {
            let solids = 0.5 * (omega * dt).powi(2);
            control.learn(dt, ErrorEstimates { time: 0.0, mesh: 0.01, interface: 0.0, solids }, 0.0, 1.0);
            dt = control.proposal;
        }
        let steps = 2.0 * std::f64::consts::PI / omega / dt;
        assert!((steps / 76.95 - 1.0).abs() < 1e-3, "{steps}");
    }
}
