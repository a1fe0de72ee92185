//! The convective part of a step: particles move, empty places are filled, and what the nodes keep of the last step goes
//! along.
//!
//! ```text
//! v* = vⁿ + ½Δt (vⁿ − vⁿ⁻¹)/Δtⁿ                        frozen over the step (vⁿ in the paper's)
//! x_p ← x_p + ∫ v*(x_p) dτ
//! aⁿ⁻¹_i ← aⁿ at the foot of the streamline of node i
//! ```

use super::convect::{self, Convected, Place, Projectiles, Streamlines, Walk};
use super::correct;
use super::implicit::{Implicit, Step};
use super::inflow::Supply;
use super::level_set::LevelSet;
use super::phases::Phases;
use super::reseed::{Newcomer, Origin, Reseeded};
use super::setup::Scheme;
use super::step::Counts;
use super::{Pfem2, volumes};
use crate::math::Vector;
use crate::mesh::Mesh;
use rayon::prelude::*;

impl<const D: usize, const N: usize> Pfem2<D, N> {
    /// v* at the nodes [m/s].
    fn carrier(&self, step: Step) -> Vec<Vector<D>> {
        let ahead = match self.scheme {
            Scheme::SecondOrder { .. } if self.follows(step.dt) => 0.5 * step.dt / self.dt_before,
            _ => 0.0,
        };
        let both = self.implicit.velocity.iter().zip(&self.before);
        both.map(|(v, before)| *v + (*v - *before) * ahead).collect()
    }

    /// Moves the particles, fills what runs empty, and carries the acceleration along.
    pub(super) fn convect(&mut self, step: Step) {
        let (carrier, kicks) = (self.carrier(step), self.kicks(step));
        let start: Vec<Vector<D>> = self.implicit.velocity.iter().zip(&kicks).map(|(v, kick)| *v + *kick).collect();
        let rule = Projectiles { fluids: &self.flying, level: &self.level, gravity: self.implicit.force[0] };
        let Implicit { mesh, boundary, .. } = &self.implicit;
        let flow = convect::Flow {
            velocity: &carrier,
            boundary: &boundary.kinds,
            projectiles: self.flying.contains(&true).then_some(rule),
        };
        let lines = Streamlines::new(mesh, &flow);
        let fate = self.particles.carry(&lines, step.dt);
        let phases = Phases { density: &self.density, fraction: &self.fraction, level: &self.level };
        let (supply, sharp) = (&self.supply, self.sharp.as_ref());
        let fluid = |place: &Place<N>| fluid_at(mesh, &phases, sharp, place);
        let inflow = |place: &Place<N>, opposite: usize, after: f64| {
            let (element, x) = (place.element, place.position(mesh));
            let inflow = boundary.inflow(mesh, (element, opposite), x, step.t + after.max(0.0))?;
            if inflow.velocity.is_none() && inflow.fluid.is_none() {
                return None;
            }
            let here = || correct::at(&place.shape, &mesh.elements()[element], &start);
            let velocity = inflow.velocity.unwrap_or_else(here);
            let (fluid, depth) = supply.brought(mesh, sharp, place, &inflow, velocity * after);
            Some(Newcomer { velocity, fluid, depth })
        };
        let origin = Origin { lines: &lines, dt: step.dt, velocity: &start, fluid: &fluid, inflow: &inflow };
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
    fn velocity_before(&self, step: Step) -> Vec<Vector<D>> {
        let Implicit { mesh, boundary, velocity, .. } = &self.implicit;
        let mut velocity = velocity.clone();
        if self.steps == 0 {
            boundary.held(mesh, step.t).into_iter().for_each(|(node, held)| velocity[node] = held);
        }
        velocity
    }

    /// What flows in at the start, and from then on.
    pub(super) fn supply_at_the_start(&self) -> Supply<D> {
        let phases = Phases { density: &self.density, fraction: &self.fraction, level: &self.level };
        Supply::new(&self.implicit.mesh, &self.implicit.boundary, self.sharp.as_ref(), &phases)
    }
}

impl Counts {
    fn add(&mut self, fate: &Convected, done: &Reseeded) {
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
    place: &Place<N>,
) -> (u8, f64) {
    let nodes = &mesh.elements()[place.element];
    match sharp {
        Some(set) => set.at(mesh, place, 1 - set.inside),
        None => (phases.at_place(nodes, &place.shape) as u8, f64::INFINITY),
    }
}

/// The feet of the nodes' streamlines, `dt` [s] before.
fn feet<const D: usize, const N: usize>(mesh: &Mesh<D, N>, lines: &Streamlines<D, N>, dt: f64) -> Vec<Walk<N>> {
    let place = |(node, x): (usize, &Vector<D>)| {
        let element = mesh.elements_around(node).first().map_or(0, |&e| e as usize);
        Place::of(mesh, element, *x)
    };
    let places: Vec<Place<N>> = mesh.nodes().par_iter().enumerate().map(place).collect();
    lines.trace_all(&places, dt, -1.0)
}

/// Nodal values that are carried along: each node takes what was at the foot of its streamline.
fn at_feet<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    feet: &[Walk<N>],
    values: &[Vector<D>],
) -> Vec<Vector<D>> {
    let there = |walk: &Walk<N>| correct::at(&walk.place.shape, &mesh.elements()[walk.place.element], values);
    feet.par_iter().map(there).collect()
}
