//! What a step does at the points where bodies meet obstacles (`surface`), in its order.

use super::gap::Bodies;
use super::surface::{Law, Point, Solved, State};
use super::{Pushes, Walls};
use crate::math::Vector;
use crate::mpm::{Grid, Node, Step, WallKind};
use std::iter::zip;

/// Bodies may come nearer during a step than their particles' velocities tell by so much [cells].
const CLOSE: f64 = 0.02;

impl<const D: usize> Walls<D> {
    /// Finds where a field, whose nodes hold (m, p⁻), may meet the surfaces of obstacles in this step.
    pub(super) fn find_surface(
        &mut self,
        (grid, field): (&Grid<D>, usize),
        nodes: &[Node<D>],
        bodies: &Bodies<'_, D>,
        step: &Step,
    ) {
        if self.regions.is_empty() {
            return;
        }
        let mut points = self.feet_of_particles(grid, bodies, step);
        let resting = &self.reactions[field].resting;
        for point in &mut points {
            point.held =
                point.foot_of.is_some_and(|[body, id]| resting.binary_search(&[point.boundary, body, id]).is_ok());
        }
        let mut surface = std::mem::take(&mut self.reactions[field].surface);
        surface.find((grid, &self.lattice), nodes, self.feet.iter().copied().chain(points));
        if surface.points.iter().any(|point| self.resists_sliding(point)) {
            let bodies = bodies.all.iter().filter(|(_, body, _)| body.particles.affine.is_empty());
            let near = bodies.flat_map(|&(_, body, bins)| {
                let bins = bins.bins.iter().zip(&bins.slots).filter(|(_, s)| self.near[s[s.len() / 2] as usize]);
                bins.flat_map(|(bin, _)| bin.range.clone())
                    .map(|p| (body.particles.mass[p], body.particles.position[p]))
            });
            let means = surface.mean_places(|add| {
                for (m, x) in near.clone() {
                    let give = |node, weight, flips| add(node, m * weight, self.lattice.mirror(grid, x, flips));
                    self.lattice.for_each(grid, x, give);
                }
            });
            surface.tilt(&means);
        }
        self.reactions[field].surface = surface;
    }

    /// True where what slides along an obstacle meets a resistance.
    fn resists_sliding(&self, point: &Point<D>) -> bool {
        match self.boundaries[point.boundary as usize].kind {
            WallKind::Fixed => true,
            WallKind::Friction { coefficient } => coefficient > 0.0,
            WallKind::Open | WallKind::Slip | WallKind::Separate => false,
        }
    }

    /// The feet of the particles that may touch an obstacle that bodies may leave during the step.
    fn feet_of_particles(&self, grid: &Grid<D>, bodies: &Bodies<'_, D>, step: &Step) -> Vec<Point<D>> {
        let contacts: Vec<_> = self.solids().filter(|solid| self.may_leave(solid.number())).collect();
        bodies.collect(
            |block| self.near[block],
            |(index, body), p| {
                let (x, v, id) = (body.particles.position[p], body.particles.velocity[p], body.particles.id[p]);
                contacts
                    .iter()
                    .filter_map(move |solid| {
                        let (distance, normal) = solid.distance(x, Vector::ZERO);
                        let gap = distance - body.reach(p, normal, grid.cell);
                        let reach = 2.0 * step.longer() * (v - solid.velocity(x, step)).norm() + CLOSE * grid.cell;
                        let meets = gap < reach && !(bodies.shielded)(x, normal, distance);
                        let point = || {
                            Point::new(
                                (solid.number() as u32, Some([index as u32, id])),
                                [x - normal * distance, normal],
                                gap,
                            )
                        };
                        meets.then(point)
                    })
                    .collect()
            },
        )
    }

    /// True for obstacles that bodies may leave.
    fn may_leave(&self, boundary: usize) -> bool {
        boundary >= 2 * D && !self.boundaries[boundary].kind.binds()
    }

    /// Binding conditions on p⁻ at time `t` (theory 9, 2b).
    pub(super) fn surface_start(&mut self, field: usize, nodes: &mut [Node<D>], t: f64) {
        let law = |state: &State<'_, D>| {
            let (kind, wall) = self.at_point(state.point, t);
            if state.point.binds() { state.constrained(kind, wall, 0.0) } else { state.impulse }
        };
        let solved = self.reactions[field].surface.solve(|node| velocity(&nodes[node]), |_| Vector::ZERO, &law);
        self.change_start(field, nodes, &solved);
    }

    /// Conditions on p̄ whose gaps close, on p⁻ too where they held in the step before. Returns true if they pushed.
    pub(super) fn surface_trial(&mut self, field: usize, nodes: &mut [Node<D>], step: &Step) -> bool {
        if self.reactions[field].surface.points.is_empty() {
            return false;
        }
        self.hold_points(field, nodes, step);
        let (dt, surface) = (step.momentum_dt, &self.reactions[field].surface);
        let law = |state: &State<'_, D>| {
            let (kind, wall) = self.at_point(state.point, step.after());
            let allowed = if state.point.rests { 0.0 } else { state.point.gap.max(0.0) / dt };
            state.constrained(kind, wall, allowed)
        };
        let solved = surface.solve(|node| velocity(&nodes[node]), |point| point.force * dt, &law);
        for &(node, sum) in &solved.nodes {
            nodes[node].momentum += sum;
            nodes[node].force += sum / dt;
        }
        let surface = &mut self.reactions[field].surface;
        for (point, &change) in zip(&mut surface.points, &solved.points) {
            point.force += change / dt;
            point.touches = point.binds() || point.force != Vector::ZERO;
        }
        !solved.nodes.is_empty()
    }

    /// Binds p⁻ at the points that held in the step before and would close: the body is at rest there, whatever its gap is by rounding. To
    /// let it approach by that gap all the same, p̄ but not p⁻, would give the particles that are stopped here more than they lost.
    fn hold_points(&mut self, field: usize, nodes: &mut [Node<D>], step: &Step) {
        let (dt, surface) = (step.momentum_dt, &self.reactions[field].surface);
        if !surface.points.iter().any(|point| point.held) {
            return;
        }
        let rests = |(point, u): (&Point<D>, Vector<D>)| {
            let approach = (u - self.at_point(point, step.after()).1).dot(point.normal);
            point.rests || point.held && approach < 0.0 && point.gap + dt * approach <= 0.0
        };
        let rests: Vec<bool> = surface.velocities(|node| velocity(&nodes[node])).map(rests).collect();
        let surface = &mut self.reactions[field].surface;
        zip(&mut surface.points, rests).for_each(|(point, rests)| point.rests = rests);
        let law = |state: &State<'_, D>| {
            let (_, wall) = self.at_point(state.point, step.before());
            if state.point.rests { state.stopped(wall) } else { state.impulse }
        };
        let before = |node: usize| (nodes[node].momentum - nodes[node].force * dt) / nodes[node].mass;
        let solved = self.reactions[field].surface.solve(before, |_| Vector::ZERO, &law);
        self.change_start(field, nodes, &solved);
    }

    /// Changes p⁻, and p̄ with it.
    fn change_start(&mut self, field: usize, nodes: &mut [Node<D>], solved: &Solved<D>) {
        solved.nodes.iter().for_each(|&(node, sum)| nodes[node].momentum += sum);
        let reaction = &mut self.reactions[field];
        for (point, &change) in zip(&reaction.surface.points, &solved.points) {
            reaction.start[point.boundary as usize] += change;
        }
    }

    /// As [`Self::constrain_velocity`], at the surface.
    pub(super) fn surface_velocity(&self, field: usize, velocity: &mut [Vector<D>], t: f64) -> Pushes<D> {
        let law = |state: &State<'_, D>| {
            let (kind, wall) = self.at_point(state.point, t);
            if !state.point.touches {
                return state.impulse;
            }
            let (constrained, n) = (state.constrained(kind, wall, 0.0), state.point.normal);
            if state.point.binds() { constrained } else { constrained + n * (state.stopped(wall) - constrained).dot(n) }
        };
        self.push_velocity((field, t), velocity, &law)
    }

    /// As [`Self::constrain_correction`], at the surface.
    pub(super) fn surface_correction(&self, field: usize, correction: &mut [Vector<D>], t: f64) -> Pushes<D> {
        let law = |state: &State<'_, D>| {
            let (kind, _) = self.at_point(state.point, t);
            if state.point.binds() { state.constrained(kind, Vector::ZERO, 0.0) } else { state.impulse }
        };
        self.push_velocity((field, t), correction, &law)
    }

    /// As [`Self::hold_velocity`], at the surface.
    pub(super) fn hold_surface(&self, field: usize, velocity: &mut [Vector<D>], t: f64) {
        let law = |state: &State<'_, D>| {
            if state.point.held { state.stopped(self.at_point(state.point, t).1) } else { state.impulse }
        };
        self.push_velocity((field, t), velocity, &law);
    }

    /// Applies a law to velocities; returns what that pushes.
    fn push_velocity(&self, (field, t): (usize, f64), velocity: &mut [Vector<D>], law: Law<'_, D>) -> Pushes<D> {
        let (mut pushes, surface) = (self.pushes(), &self.reactions[field].surface);
        let solved = surface.solve(|node| velocity[node], |_| Vector::ZERO, law);
        for (node, sum) in solved.nodes {
            velocity[node] += sum * surface.softness_of(node);
        }
        for (point, impulse) in zip(&surface.points, solved.points) {
            pushes.push(point.boundary, impulse, self.at_point(point, t).1);
        }
        pushes
    }

    /// The particles whose feet are in contact, in order.
    pub(super) fn note_resting(&mut self) {
        for reaction in &mut self.reactions {
            let touching = reaction.surface.points.iter().filter(|point| point.touches);
            reaction.resting.clear();
            reaction.resting.extend(touching.filter_map(|p| p.foot_of.map(|[body, id]| [p.boundary, body, id])));
            reaction.resting.sort_unstable();
        }
    }

    /// The kind of the boundary at a point, and its velocity there at time `t`.
    fn at_point(&self, point: &Point<D>, t: f64) -> (WallKind, Vector<D>) {
        let boundary = point.boundary as usize;
        (self.boundaries[boundary].kind, self.velocity(boundary, point.place, t))
    }
}

/// v of a node that holds (m, p) [m/s].
fn velocity<const D: usize>(node: &Node<D>) -> Vector<D> {
    node.momentum / node.mass
}
