//! The stages of a step at the points of obstacles' surfaces, in their order (theory E.5, E.6, E.7).

use super::{ImpulseIterate, ImpulseLaw, SurfaceFoot, SurfaceImpulses, SurfacePoint};
use crate::math::Vector;
use crate::mpm::particles::Body;
use crate::mpm::wall::gap::BodiesAtWalls;
use crate::mpm::wall::lasting::ParticleContact;
use crate::mpm::wall::position_correction::LEAST_OBSTACLE_DISTANCE;
use crate::mpm::wall::solid::RigidBoundary;
use crate::mpm::wall::{Pushes, Walls};
use crate::mpm::{Grid, LeapfrogStep, Node, WallKind};
use std::iter::zip;

/// Allowance for the approach of bodies beyond that of their particles' velocities during a step [cells].
const APPROACH_ALLOWANCE: f64 = 0.02;

impl<const D: usize> Walls<D> {
    /// Finds the points at which a field, whose nodes hold (m, p⁻), may touch surfaces of obstacles in this step.
    pub(in crate::mpm::wall) fn find_surface(
        &mut self,
        grid: &Grid<D>,
        field: usize,
        nodes: &[Node<D>],
        bodies: &BodiesAtWalls<'_, D>,
        step: &LeapfrogStep,
    ) {
        if !self.has_surfaces(field) {
            return;
        }
        let stencil = self.stencil.of_field(grid, field);
        let mut points = self.points_of_particles(grid, field, bodies, step);
        let particle_contacts_before = &self.field_reactions[field].particle_contacts_before;
        for point in &mut points {
            point.held = point
                .particle
                .is_some_and(|own| particle_contacts_before.binary_search(&contact_of(point.boundary, own)).is_ok());
        }
        let mut surface = std::mem::take(&mut self.field_reactions[field].surface);
        surface.find(grid, &stencil, nodes, self.binding_points.iter().copied().chain(points));
        // APIC extrapolates to the place of the node; with FLIP a node has the velocity of the mean place of its
        // particles, for which `tilt` corrects (theory (E.9)).
        let is_flip_transfer = bodies.all.iter().all(|(_, body)| body.particles.affine.is_empty());
        if is_flip_transfer && surface.points.iter().any(|point| self.resists_sliding(point)) {
            let near = bodies.all.iter().flat_map(|&(_, body)| {
                let bins =
                    body.bins.bins.iter().zip(&body.bins.slots).filter(|(_, s)| self.near[s[s.len() / 2] as usize]);
                bins.flat_map(|(bin, _)| bin.range.clone())
                    .map(|p| (body.particles.mass[p], body.particles.position[p]))
            });
            let means = surface.mean_places(|add| {
                for (m, x) in near.clone() {
                    let give = |node, weight, mirrored| add(node, m * weight, stencil.mirror(grid, x, mirrored));
                    stencil.for_each(grid, x, give);
                }
            });
            surface.tilt(&means);
        }
        self.field_reactions[field].surface = surface;
    }

    /// True where sliding along an obstacle is resisted.
    fn resists_sliding(&self, point: &SurfacePoint<D>) -> bool {
        match self.boundaries[point.boundary as usize].kind {
            WallKind::Fixed => true,
            WallKind::Friction { coefficient } => coefficient > 0.0,
            WallKind::Open | WallKind::Slip | WallKind::Separate => false,
        }
    }

    /// Points of obstacles' surfaces beside the particles that may touch them in this step. An obstacle that binds
    /// holds the body at points of its own already; there these only stop particles that creep towards it.
    fn points_of_particles(
        &self,
        grid: &Grid<D>,
        field: usize,
        bodies: &BodiesAtWalls<'_, D>,
        step: &LeapfrogStep,
    ) -> Vec<SurfacePoint<D>> {
        let obstacles = self.surfaces(field);
        let point = |(number, body): (usize, &Body<D>), p: usize, obstacle: &RigidBoundary<'_, D>| {
            let (x, v, id) = (body.particles.position[p], body.particles.velocity[p], body.particles.id[p]);
            let (distance, normal) = obstacle.distance(x, Vector::ZERO);
            let factor = if self.boundaries[obstacle.number()].kind.binds() { LEAST_OBSTACLE_DISTANCE } else { 1.0 };
            let gap = distance - factor * body.reach(p, normal, grid.cell);
            let travel = 2.0 * step.longer() * (v - obstacle.velocity(x, step)).norm() + APPROACH_ALLOWANCE * grid.cell;
            let boundary = obstacle.number() as u32;
            let meets = gap < travel
                && !self.starts_within(number, obstacle.number())
                && !(bodies.shielded)(x, normal, distance);
            let foot = SurfaceFoot { boundary, place: x - normal * distance, normal };
            meets.then(|| SurfacePoint::new(foot, Some([number as u32, id]), gap))
        };
        bodies.collect(
            |block| self.near[block],
            |body, p| obstacles.iter().filter_map(|obstacle| point(body, p, obstacle)).collect(),
        )
    }

    /// Binding conditions on p⁻ at time `t` (theory (E.6)).
    pub(in crate::mpm::wall) fn surface_start(&mut self, field: usize, nodes: &mut [Node<D>], t: f64) {
        let law = |state: &ImpulseIterate<'_, D>| {
            if state.point.binds() { state.constrained(self.kind(state.point), 0.0) } else { state.impulse }
        };
        let solved = self.field_reactions[field].surface.solve(
            |node| velocity(&nodes[node]),
            |point| self.wall_at(point, t),
            |_| Vector::ZERO,
            &law,
        );
        self.change_start(field, nodes, &solved);
    }

    /// Conditions on p̄ whose gaps close, on p⁻ too where they held in the step before. Returns the largest impulse at
    /// a point so far [N s].
    pub(in crate::mpm::wall) fn surface_trial(
        &mut self,
        field: usize,
        nodes: &mut [Node<D>],
        step: &LeapfrogStep,
    ) -> f64 {
        let (dt, surface) = (step.momentum_dt, &self.field_reactions[field].surface);
        let law = |state: &ImpulseIterate<'_, D>| {
            let allowed = if state.point.lasts { 0.0 } else { state.point.gap.max(0.0) / dt };
            state.constrained(state.point.law(self.kind(state.point)), allowed)
        };
        let solved = surface.solve(
            |node| velocity(&nodes[node]),
            |point| self.wall_at(point, step.after()),
            |point| point.force * dt,
            &law,
        );
        for &(node, sum) in &solved.nodes {
            nodes[node].momentum += sum;
            nodes[node].force += sum / dt;
        }
        let surface = &mut self.field_reactions[field].surface;
        let mut largest = 0.0_f64;
        for (point, &change) in zip(&mut surface.points, &solved.points) {
            point.force += change / dt;
            point.touches = point.binds() || point.force != Vector::ZERO;
            largest = largest.max(point.force.norm() * dt);
        }
        for (side, kept) in solved.mirrored {
            self.field_reactions[field].mirrored[side] -= kept / dt;
        }
        largest
    }

    /// Binds p⁻ at the points that held in the step before and would close: the body is at rest there, whatever its gap
    /// is by rounding. If p̄ but not p⁻ might approach by that gap, the particles that are stopped here would get more
    /// than they lost.
    pub(in crate::mpm::wall) fn bind_lasting_contacts(
        &mut self,
        field: usize,
        nodes: &mut [Node<D>],
        step: &LeapfrogStep,
    ) {
        let (dt, surface) = (step.momentum_dt, &self.field_reactions[field].surface);
        if !surface.points.iter().any(|point| point.held) {
            return;
        }
        let lasts = |(point, u): (&SurfacePoint<D>, Vector<D>)| {
            let approach = (u - self.wall_at(point, step.after())).dot(point.normal);
            point.lasts || point.held && approach < 0.0 && point.gap + dt * approach <= 0.0
        };
        let lasts: Vec<bool> = surface.velocities(|node| velocity(&nodes[node])).map(lasts).collect();
        let surface = &mut self.field_reactions[field].surface;
        zip(&mut surface.points, lasts).for_each(|(point, lasts)| point.lasts = lasts);
        let law = |state: &ImpulseIterate<'_, D>| {
            if state.point.lasts { state.stopped() } else { state.impulse }
        };
        let before = |node: usize| (nodes[node].momentum - nodes[node].force * dt) / nodes[node].mass;
        let solved = self.field_reactions[field].surface.solve(
            before,
            |point| self.wall_at(point, step.before()),
            |_| Vector::ZERO,
            &law,
        );
        self.change_start(field, nodes, &solved);
    }

    /// Changes p⁻, and p̄ with it.
    fn change_start(&mut self, field: usize, nodes: &mut [Node<D>], solved: &SurfaceImpulses<D>) {
        solved.nodes.iter().for_each(|&(node, sum)| nodes[node].momentum += sum);
        let reaction = &mut self.field_reactions[field];
        for (point, &change) in zip(&reaction.surface.points, &solved.points) {
            reaction.start_change[point.boundary as usize] += change;
        }
        solved.mirrored.iter().for_each(|&(side, kept)| reaction.mirrored_start[side] -= kept);
    }

    /// As [`Self::constrain_velocity`], at the surface.
    pub(in crate::mpm::wall) fn surface_velocity(&self, field: usize, velocity: &mut [Vector<D>], t: f64) -> Pushes<D> {
        let law = |state: &ImpulseIterate<'_, D>| {
            if !state.point.touches {
                return state.impulse;
            }
            let kind = state.point.law(self.kind(state.point));
            let (constrained, n) = (state.constrained(kind, 0.0), state.point.normal);
            if state.point.binds() { constrained } else { constrained + n * (state.stopped() - constrained).dot(n) }
        };
        let solved = self.solve_velocity(field, velocity, &|point| self.wall_at(point, t), &law);
        self.pushes_of(field, &solved, t)
    }

    /// As [`Self::constrain_correction`], at the surface.
    pub(in crate::mpm::wall) fn surface_correction(
        &self,
        field: usize,
        correction: &mut [Vector<D>],
        t: f64,
    ) -> Pushes<D> {
        let law = |state: &ImpulseIterate<'_, D>| {
            if state.point.binds() { state.constrained(self.kind(state.point), 0.0) } else { state.impulse }
        };
        let solved = self.solve_velocity(field, correction, &|_| Vector::ZERO, &law);
        self.pushes_of(field, &solved, t)
    }

    /// As [`Self::bind_lasting_velocities`], at the surface.
    pub(in crate::mpm::wall) fn bind_lasting_at_surface(&self, field: usize, velocity: &mut [Vector<D>], t: f64) {
        let law = |state: &ImpulseIterate<'_, D>| {
            if state.point.held { state.stopped() } else { state.impulse }
        };
        self.solve_velocity(field, velocity, &|point| self.wall_at(point, t), &law);
    }

    /// Applies a law to velocities of nodes.
    fn solve_velocity(
        &self,
        field: usize,
        velocity: &mut [Vector<D>],
        walls: &dyn Fn(&SurfacePoint<D>) -> Vector<D>,
        law: ImpulseLaw<'_, D>,
    ) -> SurfaceImpulses<D> {
        let surface = &self.field_reactions[field].surface;
        let solved = surface.solve(|node| velocity[node], walls, |_| Vector::ZERO, law);
        for &(node, sum) in &solved.nodes {
            velocity[node] += sum * surface.inverse_mass_of(node);
        }
        solved
    }

    /// The impulses at points, with the velocity of the boundaries at time `t`.
    fn pushes_of(&self, field: usize, solved: &SurfaceImpulses<D>, t: f64) -> Pushes<D> {
        let mut pushes = self.pushes();
        for (point, &impulse) in zip(&self.field_reactions[field].surface.points, &solved.points) {
            pushes.add(point.boundary, impulse, self.wall_at(point, t));
        }
        solved.mirrored.iter().for_each(|&(side, kept)| pushes.add(side as u32, -kept, Vector::ZERO));
        pushes
    }

    /// The particles whose feet are in contact, in order.
    pub(in crate::mpm::wall) fn record_particle_contacts(&mut self) {
        for reaction in &mut self.field_reactions {
            let touching = reaction.surface.points.iter().filter(|point| point.touches);
            reaction.particle_contacts_before.clear();
            let contacts = touching.filter_map(|point| Some(contact_of(point.boundary, point.particle?)));
            reaction.particle_contacts_before.extend(contacts);
            reaction.particle_contacts_before.sort_unstable();
        }
    }

    /// The kind of the obstacle at a point.
    fn kind(&self, point: &SurfacePoint<D>) -> WallKind {
        self.boundaries[point.boundary as usize].kind
    }

    /// Velocity of the wall at a point at time `t` [m/s].
    fn wall_at(&self, point: &SurfacePoint<D>, t: f64) -> Vector<D> {
        self.velocity(point.boundary as usize, point.place, t)
    }
}

/// The contact of a body's particle with an obstacle.
fn contact_of(boundary: u32, [body, particle]: [u32; 2]) -> ParticleContact {
    ParticleContact { boundary, body, particle }
}

/// v of a node that holds (m, p) [m/s].
fn velocity<const D: usize>(node: &Node<D>) -> Vector<D> {
    node.momentum / node.mass
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Region;
    use crate::math::Signal;
    use crate::mpm::wall::folded_stencil::FoldedStencil;
    use crate::mpm::{GridSetup, Kernel, KernelKind, Obstacle, Wall};

    const CELL: f64 = 0.5;

    /// A floor of this kind whose surface lies `height` cells above a row of nodes, in a grid all of whose nodes have
    /// mass.
    fn floor(kind: WallKind, height: f64) -> (Grid<2>, Walls<2>, Vec<Node<2>>) {
        let walls = std::array::from_fn(|_| [Wall::default(), Wall::default()]);
        let setup = GridSetup { lower: Vector::ZERO, cell: CELL, cells: [12, 8], walls };
        let top = (2.0 + height) * CELL;
        let region = Region::Box { lower: [-9.0, -9.0, -9.0], upper: [99.0, top, 9.0] };
        let velocity = std::array::from_fn(|_| Signal::ZERO);
        let floor = Obstacle { name: "floor".into(), region, kind, velocity };
        let stencil = FoldedStencil::new(Kernel::new(KernelKind::Quadratic, 0.25), &setup.walls);
        let mut grid = Grid::new(setup.lower, setup.cell, setup.cells, 1);
        grid.set_blocks((0..4).flat_map(|i| (0..3).map(move |j| [i, j])).collect());
        let mut walls = Walls::new(&setup, vec![floor], 1, stencil);
        walls.find_nodes(&grid);
        walls.start_step(&grid);
        let inside = |node: usize| grid.contains(grid.coordinates(node));
        let mass = |node: usize| if inside(node) { 0.3 + random(node as u64) } else { 0.0 };
        let node = |n| Node { mass: mass(n), momentum: Vector::ZERO, force: Vector::ZERO };
        let nodes = (0..grid.node_count()).map(node).collect();
        (grid, walls, nodes)
    }

    /// Somewhere in 0..1.
    fn random(seed: u64) -> f64 {
        let mixed = (seed + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        ((mixed ^ mixed >> 29).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn step() -> LeapfrogStep {
        LeapfrogStep { t: 0.0, dt: 0.1, dt_previous: 0.1, momentum_dt: 0.1 }
    }

    /// A body with a constant pressure that ends at the surface pushes its nodes by p N_I(x_c) per point: the surface
    /// balances all of it, at any height between the nodes and for any masses.
    #[test]
    fn a_constant_pressure_is_given_back_at_every_node() {
        for height in [0.0, 0.2, 0.5, 0.9] {
            let (grid, mut walls, mut nodes) = floor(WallKind::Slip, height);
            let none = BodiesAtWalls { all: Vec::new(), shielded: &|_, _, _| false };
            walls.find_surface(&grid, 0, &nodes, &none, &step());
            let points = walls.field_reactions[0].surface.points.clone();
            assert_eq!(points.len(), 13, "one point per node along the floor");
            for point in &points {
                walls.stencil.for_each(&grid, point.place, |node, weight, _| {
                    nodes[node].momentum -= Vector([0.0, 7.0 * weight]);
                });
            }
            walls.surface_start(0, &mut nodes, 0.0);
            let left = nodes.iter().map(|node| node.momentum.norm()).fold(0.0, f64::max);
            assert!(left < 7e-3, "{left} at {height}");
            assert!((walls.field_reactions[0].start_change[4][1] - 7.0 * 13.0).abs() < 0.02 * 7.0);
        }
    }

    /// An obstacle at rest takes kinetic energy and never gives any, of whatever kind, and the impulses that are booked
    /// are what the nodes got.
    #[test]
    fn obstacles_at_rest_give_no_energy() {
        let rough = WallKind::Friction { coefficient: 0.4 };
        for (kind, seed) in [WallKind::Slip, WallKind::Fixed, WallKind::Separate, rough].into_iter().zip(1..) {
            let (grid, mut walls, mut nodes) = floor(kind, 0.3);
            for (n, node) in nodes.iter_mut().enumerate() {
                let v = |a: u64| random(seed * 1000 + 2 * n as u64 + a) - 0.5;
                node.momentum = Vector([v(0), v(1)]) * node.mass;
            }
            let point = |k: u64| {
                let (x, gap) = (0.4 + 5.2 * random(77 * k), 0.02 * (random(k) - 0.5));
                let particle = (!kind.binds()).then_some([0, k as u32]);
                let foot = SurfaceFoot { boundary: 4, place: Vector([x, 2.3 * CELL]), normal: Vector([0.0, 1.0]) };
                SurfacePoint::new(foot, particle, gap)
            };
            let mut surface = std::mem::take(&mut walls.field_reactions[0].surface);
            surface.find(&grid, &walls.stencil, &nodes, (0..40).map(point));
            walls.field_reactions[0].surface = surface;
            let energy = |nodes: &[Node<2>]| -> f64 {
                let moving = nodes.iter().filter(|node| node.mass > 0.0);
                moving.map(|node| 0.5 * node.momentum.norm_squared() / node.mass).sum()
            };
            let sum = |nodes: &[Node<2>]| nodes.iter().map(|node| node.momentum).sum::<Vector<2>>();
            let (before, momentum) = (energy(&nodes), sum(&nodes));
            walls.surface_trial(0, &mut nodes, &step());
            assert!(energy(&nodes) < before, "{kind:?}: {before} becomes {}", energy(&nodes));
            let booked: Vector<2> = walls.field_reactions[0].surface.points.iter().map(|point| point.force * 0.1).sum();
            assert!((sum(&nodes) - momentum - booked).norm() < 1e-12, "{kind:?}");
            assert!(kind.binds() || booked[1] > 0.0);
        }
    }
}
