//! The convective part of a step: particles move, empty places are filled, and what the nodes keep of the last step goes
//! along.
//!
//! ```text
//! v* = vⁿ + ½Δt (vⁿ − vⁿ⁻¹)/Δtⁿ + c (vⁿ − 2vⁿ⁻¹ + vⁿ⁻²)  frozen over the step (vⁿ in the paper's), c = 5/6 − θ (equal steps); theory F.5
//! x_p ← x_p + ∫ v*(x_p) dτ
//! aⁿ⁻¹_i ← aⁿ at the foot of the streamline of node i
//! ```

use super::convect::{self, ConvectionCounts, MeshPoint, Projectiles, Streamlines, Walk};
use super::correct;
use super::reseed::{NewParticle, ParticleSource, Reseeded};
use crate::math::Vector;
use crate::mesh::Mesh;
use crate::parallel;
use crate::pfem2::Pfem2;
use crate::pfem2::equations::system::{TimeStep, VelocityPressureSystem};
use crate::pfem2::interface::inflow::InflowComposition;
use crate::pfem2::interface::level_set::{InflowDepth, LevelSet};
use crate::pfem2::interface::phases::Phases;
use crate::pfem2::interface::volumes;
use crate::pfem2::setup::Scheme;
use crate::pfem2::step::RunCounts;

impl<const D: usize, const N: usize> Pfem2<D, N> {
    /// v* at the nodes [m/s].
    fn carrier(&self, step: TimeStep) -> Vec<Vector<D>> {
        let Scheme::SecondOrder { theta } = self.scheme else { return self.system.velocity.clone() };
        if !self.follows(step.dt) {
            return self.system.velocity.clone();
        }
        let bend = if self.follows_twice(step.dt) { bend(theta) } else { 0.0 };
        let weights = carrier_weights(step.dt, [self.dt_before, self.dt_earlier], bend);
        let all = self.system.velocity.iter().zip(&self.before).zip(&self.earlier);
        all.map(|((v, before), earlier)| *v * weights[0] + *before * weights[1] + *earlier * weights[2]).collect()
    }

    /// Moves the particles, fills what runs empty, and carries the acceleration along.
    pub(in crate::pfem2) fn convect(&mut self, step: TimeStep) {
        let (carrier, kicks) = (self.carrier(step), self.kicks(step));
        let start: Vec<Vector<D>> = self.system.velocity.iter().zip(&kicks).map(|(v, kick)| *v + *kick).collect();
        let rule = Projectiles { fluids: &self.is_projectile, level: &self.level, gravity: self.system.force[0] };
        let VelocityPressureSystem { mesh, boundary, .. } = &self.system;
        let flow = convect::Flow {
            velocity: &carrier,
            boundary: &boundary.kinds,
            projectiles: self.is_projectile.contains(&true).then_some(rule),
        };
        let lines = Streamlines::new(mesh, &flow);
        let (openings, particles) = (&self.openings[..], &mut self.particles);
        let entering = self.sharp.as_ref().filter(|_| !openings.is_empty());
        let entering = entering.map(|set| InflowDepth::new(mesh, set, openings, &carrier, particles));
        let fate = self.particles.carry(&lines, step.dt);
        let phases = Phases { density: &self.density, fraction: &self.fraction, level: &self.level };
        let (supply, sharp) = (&self.supply, self.sharp.as_ref());
        let fluid = |place: &MeshPoint<N>| fluid_at(mesh, &phases, sharp, place);
        let inflow = |place: &MeshPoint<N>, opposite: usize, after: f64| {
            let (element, x) = (place.element, place.position(mesh));
            let inflow = boundary.inflow(mesh, (element, opposite), x, step.t + after.max(0.0))?;
            let here = || correct::at(&place.shape, &mesh.elements()[element], &start);
            let velocity = inflow.velocity.unwrap_or_else(here);
            let (fluid, depth) = supply.brought(mesh, sharp.zip(entering.as_ref()), place, &inflow, velocity * after);
            Some(NewParticle { velocity, fluid, depth })
        };
        let origin = ParticleSource { lines: &lines, dt: step.dt, velocity: &start, fluid: &fluid, inflow: &inflow };
        let done = self.particles.reseed(mesh, self.reseeding, self.crowd, &origin);
        let left = self.sharp.as_ref().map(|set| volumes::left(mesh, set, &self.openings, &carrier, &origin));
        let feet = feet(mesh, &lines, step.dt);
        self.carried = at_feet(mesh, &feet, &self.acceleration);
        self.friction.start = at_feet(mesh, &feet, &self.velocity_before(step));
        self.counts.add(&fate, &done);
        left.iter().for_each(|left| (0..2).for_each(|k| self.outflow[k] += left[k]));
    }
}

impl<const D: usize, const N: usize> Pfem2<D, N> {
    /// Nodal velocities at the start of a step; before the first, walls and inlets take hold of their nodes [m/s].
    fn velocity_before(&self, step: TimeStep) -> Vec<Vector<D>> {
        let VelocityPressureSystem { mesh, boundary, velocity, .. } = &self.system;
        let mut velocity = velocity.clone();
        if self.steps == 0 {
            boundary.held(mesh, step.t).into_iter().for_each(|(node, held)| velocity[node] = held);
        }
        velocity
    }

    /// What flows in at the start, and from then on.
    pub(in crate::pfem2) fn supply_at_the_start(&self) -> InflowComposition<D> {
        let phases = Phases { density: &self.density, fraction: &self.fraction, level: &self.level };
        InflowComposition::new(&self.system.mesh, &self.system.boundary, self.sharp.as_ref(), &phases)
    }
}

/// The share of the second difference in v* with which errors of forces and of streamlines cancel in a wave:
/// both change its frequency, by parts θ − 5/12 and (1 − share) 5/12 of (ωΔt)²/2. Theory (F.15)–(F.18).
fn bend(theta: f64) -> f64 {
    (2.0 - 2.4 * theta).max(0.0)
}

/// Weights of vⁿ, vⁿ⁻¹ and vⁿ⁻² in v*, the mean over a step `dt` of the line through the first two, and of the part `bend` of what a
/// parabola through all three adds; `last` and `earlier` are the steps between them [s]. Theory (F.15).
fn carrier_weights(dt: f64, [last, earlier]: [f64; 2], bend: f64) -> [f64; 3] {
    let slope = 0.5 * dt / last;
    // ∫ s (s + Δtⁿ) ds/Δt over the step, divided as the divided difference is
    let curve = bend * dt * (dt / 3.0 + 0.5 * last) / (last + earlier);
    let [near, far] = if bend > 0.0 { [curve / last, curve / earlier] } else { [0.0; 2] };
    [1.0 + slope + near, -slope - near - far, far]
}

impl RunCounts {
    fn add(&mut self, fate: &ConvectionCounts, done: &Reseeded) {
        self.left += fate.left as u64;
        self.stuck += fate.stuck as u64;
        self.added += done.added as u64;
        self.inflow += done.inflow as u64;
        self.merged += done.merged as u64;
        self.empty += done.empty as u64;
    }
}

/// The fluid at a place and the depth below the interface [m].
fn fluid_at<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    phases: &Phases,
    sharp: Option<&LevelSet>,
    place: &MeshPoint<N>,
) -> (u8, f64) {
    let nodes = &mesh.elements()[place.element];
    match sharp {
        Some(set) => set.at(mesh, place, 1 - set.inside),
        None => (phases.at_place(nodes, &place.shape) as u8, f64::INFINITY),
    }
}

/// The feet of the nodes' streamlines, `dt` [s] before.
fn feet<const D: usize, const N: usize>(mesh: &Mesh<D, N>, lines: &Streamlines<D, N>, dt: f64) -> Vec<Walk<N>> {
    let place = |node: usize| {
        let element = mesh.elements_around(node).first().map_or(0, |&e| e as usize);
        MeshPoint::of(mesh, element, mesh.nodes()[node])
    };
    let places = parallel::collect(mesh.nodes().len(), 256, place);
    lines.trace_all(&places, dt, -1.0)
}

/// Nodal values that are carried along: each node takes what was at the foot of its streamline.
fn at_feet<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    feet: &[Walk<N>],
    values: &[Vector<D>],
) -> Vec<Vector<D>> {
    let there = |MeshPoint { element, shape }: &MeshPoint<N>| correct::at(shape, &mesh.elements()[*element], values);
    parallel::collect(feet.len(), parallel::CHUNK, |node| there(&feet[node].place))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The mean over the step of what is known at three times is exact for parabolas, whatever the steps.
    #[test]
    fn a_whole_bend_makes_the_mean_of_a_parabola_exact() {
        let (dt, last, earlier) = (0.3, 0.2, 0.15);
        let v = |t: f64| 2.0 - 3.0 * t + 5.0 * t * t;
        let weights = carrier_weights(dt, [last, earlier], 1.0);
        let mean = weights[0] * v(0.0) + weights[1] * v(-last) + weights[2] * v(-last - earlier);
        let exact = 2.0 - 3.0 * dt / 2.0 + 5.0 * dt * dt / 3.0;
        assert!((mean - exact).abs() < 1e-14, "{mean} {exact}");
        let line = carrier_weights(dt, [last, earlier], 0.0);
        assert!((line[0] * 1.0 + line[1] * (1.0 - last) - (1.0 + 0.5 * dt)).abs() < 1e-15 && line[2] == 0.0);
    }

    /// η' = w along v*, w' = −ω² η with the weights of the scheme: amplitude and phase after ten periods.
    fn wave(theta: f64, bend: f64, steps: usize) -> (f64, f64) {
        let dt = std::f64::consts::TAU / steps as f64;
        let [w0, w1, w2] = carrier_weights(dt, [dt, dt], bend);
        let (b1, b2) = (1.5 - 2.0 * theta, theta - 0.5);
        let at = |n: f64| (n * dt).cos();
        let (mut eta, mut v, mut a) = (1.0, [0.0, (dt).sin(), (2.0 * dt).sin()], [-1.0, -at(-1.0)]);
        for _ in 0..10 * steps {
            eta += dt * (w0 * v[0] + w1 * v[1] + w2 * v[2]);
            let now = -eta;
            let next = v[0] + dt * (theta * now + b1 * a[0] + b2 * a[1]);
            (v, a) = ([next, v[0], v[1]], [now, a[0]]);
        }
        (eta.hypot(v[0]), (-v[0]).atan2(eta))
    }

    /// With c = 5/6 − θ the frequency of a wave is exact to fourth order, and none grows; without, phase is of second order and
    /// waves grow.
    #[test]
    fn waves_keep_their_frequency_and_never_grow() {
        let (amplitude, phase) = wave(0.6, bend(0.6), 20);
        assert!(amplitude < 1.0 && amplitude > 0.8, "{amplitude}");
        let order = (phase.abs() / wave(0.6, bend(0.6), 40).1.abs()).log2();
        assert!(order > 3.7, "{order}");
        let (grown, late) = wave(0.6, 0.0, 20);
        assert!(grown > 1.1 && late.abs() > 10.0 * phase.abs(), "{grown} {late} {phase}");
        // ωΔt from 0.1 to 1.5
        let steps = [4, 5, 6, 8, 12, 20, 60];
        assert!(steps.into_iter().all(|steps| wave(0.6, bend(0.6), steps).0 < 1.0));
    }
}
