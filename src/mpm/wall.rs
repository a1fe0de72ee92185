//! Walls of the domain and rigid obstacles: conditions on the velocity of grid nodes (theory E.1).
//!
//! A condition maps the velocity v of a node to v', relative to the velocity v_w of the wall with unit
//! normal ν (pointing into the material):
//!
//! ```text
//! fixed      v' = v_w
//! slip       v' = v − ((v − v_w)·ν) ν
//! separate   slip where (v − v_w)·ν < 0, else v
//! friction   as separate, and the relative tangential velocity shrinks by min(1, μ|Δv_n|/|v_t|)
//! ```
//!
//! `fixed` and `slip` bind always: they act on p⁻ too. The others are contact: they act on p̄ only, and on p⁻ where they held in the
//! step before (`hold`). Every change of p̄ changes f with it, so that p⁻ = p̄ − Δt f; the sums of these forces are the reactions.
//! A mirror carries further force in the ghosts beyond it (their normal parts change sign when folded).
//!
//! Walls of the domain lie on nodes and act there, but for solids that may leave them (`domain`). Obstacles lie anywhere, and act at points of their
//! surface (`surface`, `meet`); nodes deeper in them than half a support have conditions too. At the end of a step no particle is within an obstacle
//! (`keep_out`).

mod constrain;
mod domain;
mod gap;
mod hold;
mod keep_out;
mod meet;
mod pushes;
mod solid;
mod surface;

use super::contact::nodes::FoldedStencil;
use super::grid::{EDGE, Ghosts, Grid, Limits, Node, NodeMotion};
use super::{GridSetup, Obstacle, Step, Wall, WallKind};
use crate::math::{Signal, Vector};
use crate::parallel::{self, CHUNK};
use constrain::Part;
pub(in crate::mpm) use gap::Bodies;
pub use pushes::Pushes;
pub use solid::{SheetPush, Solid};

/// Fraction of a cell for the central differences of an obstacle's normal.
const NORMAL_STEP: f64 = 1e-3;

/// Nodes up to this far from the surface of an obstacle have their foot among the points where it binds [cells].
const BAND: f64 = 0.5;

/// The rounding of distances from it [cells]: a row of nodes on the surface of a box must not be left out because of how −0.3 + 6 · 0.05 is rounded.
const ROUNDING: f64 = 1e-6;

/// Blocks of the grid up to this far from an obstacle may hold particles whose nodes meet it [cells].
const NEAR: f64 = 4.0;

/// Something rigid that grid nodes meet.
#[derive(Debug)]
struct Boundary {
    /// `wall:left`, `obstacle:floor`.
    name: String,
    kind: WallKind,
    velocity: [Signal; 3],
}

/// One node under one condition.
#[derive(Debug, Clone, Copy)]
struct Condition<const D: usize> {
    node: u32,
    boundary: u32,
    normal: Vector<D>,
}

/// What the walls did to one velocity field during a step.
#[derive(Debug, Clone, Default)]
struct Reaction<const D: usize> {
    /// Force of each condition [N].
    force: Vec<Vector<D>>,
    /// Gap at the node of each condition [m], and whether it closes in this step.
    gap: Vec<f64>,
    closed: Vec<bool>,
    /// The contacts that held at the end of the last step; the conditions of them are true.
    holding: Vec<hold::Holding>,
    held: Vec<bool>,
    /// Changes of p⁻ per boundary [N s].
    start: Vec<Vector<D>>,
    /// Mirrored force and momentum per side, and the masses of the mirrored ghosts.
    mirrored: Vec<Vector<D>>,
    mirrored_start: Vec<Vector<D>>,
    ghosts: Vec<(u32, u32, f64)>,
    /// Where the field meets the surfaces of obstacles, and what was in contact there at the end of the last step.
    surface: surface::Surface<D>,
    resting: Vec<hold::Resting>,
}

/// Work of a step [J], and the impulse on the particles [N s].
#[derive(Debug, Clone, Copy, Default)]
pub struct WallWork<const D: usize> {
    /// Work that moving walls did on the material.
    pub work: f64,
    /// Energy lost to friction and stopping.
    pub dissipation: f64,
    /// Impulse on the particles.
    pub impulse: Vector<D>,
}

/// Sums over conditions: impulses on the material by boundary [N s], work of the moving walls and of all forces [J].
struct Sums<const D: usize> {
    impulse: Vec<Vector<D>>,
    work: f64,
    total: f64,
}

impl<const D: usize> Sums<D> {
    /// Adds what a boundary did at `x` [m] with a force [N] on what moved with `velocity` [m/s] on average.
    fn add(
        &mut self,
        walls: &Walls<D>,
        (boundary, x): (u32, Vector<D>),
        (force, velocity): (Vector<D>, Vector<D>),
        step: &Step,
    ) {
        let (boundary, dt) = (boundary as usize, step.momentum_dt);
        let wall = |t: f64| walls.velocity(boundary, x, t);
        self.impulse[boundary] += force * dt;
        self.total += force.dot(velocity) * dt;
        self.work += force.dot(wall(step.before()) + wall(step.after())) * (0.5 * dt);
    }

    fn and(mut self, other: Self) -> Self {
        self.impulse.iter_mut().zip(other.impulse).for_each(|(sum, impulse)| *sum += impulse);
        Self { work: self.work + other.work, total: self.total + other.total, ..self }
    }
}

/// All walls and obstacles of a run.
#[derive(Debug)]
pub struct Walls<const D: usize> {
    boundaries: Vec<Boundary>,
    /// Lower and upper corner of the domain [m].
    bounds: [Vector<D>; 2],
    /// Shapes of the obstacles, which follow the 2·D sides among the boundaries.
    regions: Vec<crate::geometry::Region>,
    /// How far each obstacle has moved [m].
    pub displacement: Vec<Vector<3>>,
    conditions: Vec<Condition<D>>,
    /// Parts of the conditions with nodes of their own.
    parts: Vec<Part>,
    places: gap::Places,
    /// Where obstacles bind.
    feet: Vec<surface::Point<D>>,
    /// Bodies that start within an obstacle: number of the body, and of the boundary.
    overlaps: Vec<[u32; 2]>,
    /// Grid blocks near obstacles, and near walls that some field meets at their surface.
    near: Vec<bool>,
    /// Fields all of whose bodies keep their shape.
    solid_fields: Vec<bool>,
    /// Shape functions of the bodies.
    lattice: FoldedStencil<D>,
    reactions: Vec<Reaction<D>>,
    /// Reaction of each boundary during the last step: force on the material [N].
    pub force: Vec<Vector<D>>,
}

/// Names of the sides, by axis and end.
pub fn side_name(dimension: usize, axis: usize, end: usize) -> &'static str {
    let names = if axis + 1 == dimension { ["bottom", "top"] } else { [["left", "right"], ["front", "back"]][axis] };
    names[end]
}

impl WallKind {
    /// True if the condition binds always, in both directions.
    fn binds(self) -> bool {
        matches!(self, Self::Fixed | Self::Slip)
    }

    /// The order in which several conditions of one node are applied: the strictest last.
    fn strictness(self) -> u8 {
        match self {
            Self::Open => 0,
            Self::Separate | Self::Friction { .. } => 1,
            Self::Slip => 2,
            Self::Fixed => 3,
        }
    }

    /// The velocity after the condition.
    fn constrain<const D: usize>(self, v: Vector<D>, wall: Vector<D>, normal: Vector<D>) -> Vector<D> {
        let relative = v - wall;
        let approach = relative.dot(normal);
        match self {
            Self::Open => v,
            Self::Fixed => wall,
            Self::Slip => v - normal * approach,
            Self::Separate | Self::Friction { .. } if approach >= 0.0 => v,
            Self::Separate => v - normal * approach,
            Self::Friction { coefficient } => {
                let tangential = relative - normal * approach;
                let speed = tangential.norm();
                let kept = if speed > 0.0 { (1.0 - coefficient * -approach / speed).max(0.0) } else { 0.0 };
                wall + tangential * kept
            }
        }
    }
}

impl<const D: usize> Walls<D> {
    /// The walls of `grid` and the obstacles; `lattice`: the shape functions of the bodies.
    pub fn new(grid: &GridSetup<D>, obstacles: Vec<Obstacle>, fields: usize, lattice: FoldedStencil<D>) -> Self {
        let side = |axis: usize, end: usize, wall: &Wall| Boundary {
            name: format!("wall:{}", side_name(D, axis, end)),
            kind: wall.kind,
            velocity: wall.velocity.clone(),
        };
        let sides = (0..2 * D).map(|s| side(s / 2, s % 2, &grid.walls[s / 2][s % 2]));
        let mut boundaries: Vec<_> = sides.collect();
        let mut regions = Vec::new();
        for Obstacle { name, region, kind, velocity } in obstacles {
            boundaries.push(Boundary { name: format!("obstacle:{name}"), kind, velocity });
            regions.push(region);
        }
        let force = vec![Vector::ZERO; boundaries.len()];
        let displacement = vec![Vector::ZERO; regions.len()];
        let reactions = vec![Reaction::default(); fields];
        let upper = grid.lower + Vector::from_fn(|a| f64::from(grid.cells[a]) * grid.cell);
        Self {
            boundaries,
            bounds: [grid.lower, upper],
            regions,
            displacement,
            conditions: Vec::new(),
            parts: Vec::new(),
            places: gap::Places::default(),
            feet: Vec::new(),
            overlaps: Vec::new(),
            near: Vec::new(),
            solid_fields: Vec::new(),
            lattice,
            reactions,
            force,
        }
    }

    /// True if an obstacle moves, so that its nodes change.
    pub fn moving(&self) -> bool {
        self.boundaries[2 * D..].iter().any(|b| b.velocity.iter().any(|v| !v.is_zero()))
    }

    /// True if bodies may meet walls or obstacles across gaps on the active grid, so that it matters what lies between.
    pub fn have_gaps(&self) -> bool {
        self.places.any() || self.near.contains(&true)
    }

    /// Finds the nodes under a condition, after the active blocks or an obstacle changed.
    pub fn find_nodes(&mut self, grid: &Grid<D>) {
        self.conditions = parallel::collect_all(grid.node_count(), CHUNK, |node| self.conditions_of(grid, node));
        self.parts = constrain::parts(&self.conditions);
        let has_gap = |condition: &Condition<D>| self.has_gap(condition);
        self.places = gap::Places::new(grid, &self.conditions, has_gap);
        self.feet = parallel::collect_all(grid.node_count(), CHUNK, |node| self.feet_of(grid, node));
        let reach = (0.5 * EDGE as f64 * (D as f64).sqrt() + NEAR) * grid.cell;
        let middle =
            |block: &[i32; D]| grid.origin + Vector::from_fn(|a| f64::from(block[a]) + 0.5) * (EDGE as f64 * grid.cell);
        self.near = grid.blocks().iter().map(|block| self.clearance_of_surfaces(middle(block)) < reach).collect();
    }

    /// Where obstacles bind next to a node.
    fn feet_of(&self, grid: &Grid<D>, node: usize) -> Vec<surface::Point<D>> {
        let (x, cell) = (grid.position(node), grid.cell);
        let binding = (0..self.regions.len()).filter(|obstacle| self.boundaries[2 * D + obstacle].kind.binds());
        let foot = |obstacle: usize| {
            let beside = self.obstacle_distance(obstacle, x) / cell;
            if !(grid.contains(grid.coordinates(node)) && (ROUNDING - BAND..=ROUNDING + BAND).contains(&beside)) {
                return None;
            }
            let normal = self.obstacle_normal(obstacle, x, cell);
            let onto = |x: Vector<D>| x - normal * self.obstacle_distance(obstacle, x);
            Some(surface::Point::new(((2 * D + obstacle) as u32, None), [onto(onto(x)), normal], f64::NEG_INFINITY))
        };
        binding.filter_map(foot).collect()
    }

    /// True if a condition acts where a gap closes: that of a wall or an obstacle that bodies may leave.
    fn has_gap(&self, condition: &Condition<D>) -> bool {
        !self.boundaries[condition.boundary as usize].kind.binds()
    }

    /// The conditions of a node, the strictest last.
    fn conditions_of(&self, grid: &Grid<D>, node: usize) -> Vec<Condition<D>> {
        let (mut conditions, ijk) = (Vec::new(), grid.coordinates(node));
        if !self.may_hold_mass(grid, ijk) {
            return conditions;
        }
        for (side, boundary) in self.boundaries[..2 * D].iter().enumerate() {
            let (axis, end) = (side / 2, side % 2);
            if boundary.kind != WallKind::Open && ijk[axis] == if end == 0 { 0 } else { grid.cells[axis] } {
                let normal = Vector::unit(axis) * if end == 0 { 1.0 } else { -1.0 };
                conditions.push(Condition { node: node as u32, boundary: side as u32, normal });
            }
        }
        let x = grid.position(node);
        for obstacle in 0..self.regions.len() {
            // Nodes that no body outside reaches hold what has entered; nearer ones hold a body that started there.
            let boundary = 2 * D + obstacle;
            let reach = if self.holds_a_body(boundary) { 0.0 } else { 0.5 * f64::from(self.lattice.support()) };
            if self.obstacle_distance(obstacle, x) < (ROUNDING - reach) * grid.cell {
                let normal = self.obstacle_normal(obstacle, x, grid.cell);
                conditions.push(Condition { node: node as u32, boundary: boundary as u32, normal });
            }
        }
        conditions.sort_by_key(|c| self.boundaries[c.boundary as usize].kind.strictness());
        conditions
    }

    /// The outward normal of an obstacle at `x`.
    fn obstacle_normal(&self, obstacle: usize, x: Vector<D>, cell: f64) -> Vector<D> {
        let step = NORMAL_STEP * cell;
        let slope = Vector::from_fn(|a| {
            let d = Vector::unit(a) * step;
            self.obstacle_distance(obstacle, x + d) - self.obstacle_distance(obstacle, x - d)
        });
        slope.normalized().unwrap_or(Vector::unit(D - 1))
    }

    /// True if the displacement `by` [m] leads from `x` [m] to less than `margin` [m] from a wall or an obstacle, and nearer to it.
    pub fn obstruct(&self, x: Vector<D>, by: Vector<D>, margin: f64) -> bool {
        (0..self.boundaries.len()).any(|boundary| {
            let distance = self.distance(boundary, x + by);
            distance < margin && distance < self.distance(boundary, x)
        })
    }

    /// Distance of `x` [m] from the nearest obstacle, negative inside; infinite without any.
    pub fn clearance_of_obstacles(&self, x: Vector<D>) -> f64 {
        (0..self.regions.len()).map(|obstacle| self.obstacle_distance(obstacle, x)).fold(f64::INFINITY, f64::min)
    }

    /// The name of an obstacle that `x` lies in, deeper than `depth` [m].
    pub fn obstacle_around(&self, x: Vector<D>, depth: f64) -> Option<&str> {
        let around = (0..self.regions.len()).find(|&obstacle| self.obstacle_distance(obstacle, x) < -depth)?;
        self.boundaries[2 * D + around].name.strip_prefix("obstacle:")
    }

    /// Distance of `x` [m] from a wall, or from an obstacle where it is now, negative beyond its surface.
    fn distance(&self, boundary: usize, x: Vector<D>) -> f64 {
        let Some(obstacle) = boundary.checked_sub(2 * D) else {
            let (axis, end) = (boundary / 2, boundary % 2);
            return if end == 0 { x[axis] - self.bounds[0][axis] } else { self.bounds[1][axis] - x[axis] };
        };
        self.obstacle_distance(obstacle, x)
    }

    /// Distance of `x` [m] from an obstacle where it is now, negative inside.
    fn obstacle_distance(&self, obstacle: usize, x: Vector<D>) -> f64 {
        let x = x - Vector::from3(self.displacement[obstacle].0);
        self.regions[obstacle].signed_distance(x.to3())
    }

    /// Starts a step: no reactions yet.
    pub fn start_step(&mut self, grid: &Grid<D>) {
        self.recall_contacts(grid);
        self.force.fill(Vector::ZERO);
        for reaction in &mut self.reactions {
            let zero = |column: &mut Vec<Vector<D>>, len: usize| {
                column.clear();
                column.resize(len, Vector::ZERO);
            };
            zero(&mut reaction.force, self.conditions.len());
            reaction.closed.clear();
            reaction.closed.resize(self.conditions.len(), false);
            zero(&mut reaction.start, self.boundaries.len());
            zero(&mut reaction.mirrored, 2 * D);
            zero(&mut reaction.mirrored_start, 2 * D);
            reaction.ghosts.clear();
        }
    }

    /// Folds the ghosts of a field's nodes into the domain and books what mirrors reflect.
    pub fn fold(&mut self, (ghosts, limits): (&Ghosts<D>, &Limits), field: usize, nodes: &mut [Node<D>]) {
        let reaction = &mut self.reactions[field];
        ghosts.fold(limits, nodes, |side, node, ghost| {
            let axis = Vector::unit(side / 2);
            reaction.mirrored[side] -= axis * (2.0 * ghost.force[side / 2]);
            reaction.mirrored_start[side] -= axis * (2.0 * ghost.momentum[side / 2]);
            if ghost.mass > 0.0 {
                reaction.ghosts.push((side as u32, node as u32, ghost.mass));
            }
        });
    }

    /// The velocity of a boundary at `x` and time `t`.
    fn velocity(&self, boundary: usize, x: Vector<D>, t: f64) -> Vector<D> {
        Vector::from_fn(|a| self.boundaries[boundary].velocity[a].value(x.to3(), t))
    }

    /// Closes a field's step: work, losses and impulses of the walls. Nodes hold (m, v⁺, a) with the ghosts
    /// filled; `share` is the part of the particles' velocity that comes from v⁺ itself (PIC, APIC).
    pub fn settle(
        &mut self,
        grid: &Grid<D>,
        field: usize,
        nodes: &[NodeMotion<D>],
        step: &Step,
        share: f64,
    ) -> WallWork<D> {
        let dt = step.momentum_dt;
        let reaction = &self.reactions[field];
        let Sums { mut impulse, work, total } = self.sum_reactions(grid, field, nodes, step);
        for (boundary, &start) in reaction.start.iter().enumerate() {
            impulse[boundary] += start * share;
        }
        let mirrored = reaction.mirrored.iter().zip(&reaction.mirrored_start);
        for (impulse, (&force, &start)) in impulse.iter_mut().zip(mirrored) {
            *impulse += force * dt + start * share;
        }
        for &(side, node, mass) in &reaction.ghosts {
            let (v, a) = (nodes[node as usize].velocity(), nodes[node as usize].acceleration());
            let carried = a * dt + (v - a * dt) * share;
            impulse[side as usize] += Vector::unit(side as usize / 2) * (2.0 * mass * carried[side as usize / 2]);
        }
        for (force, impulse) in self.force.iter_mut().zip(&impulse) {
            *force += *impulse / dt;
        }
        WallWork { work, dissipation: work - total, impulse: impulse.into_iter().sum() }
    }

    /// What the conditions of a field did, summed over their nodes.
    fn sum_reactions(&self, grid: &Grid<D>, field: usize, nodes: &[NodeMotion<D>], step: &Step) -> Sums<D> {
        let none = || Sums { impulse: vec![Vector::ZERO; self.boundaries.len()], work: 0.0, total: 0.0 };
        let force = &self.reactions[field].force;
        let mean = |node: usize| nodes[node].midstep_velocity(step.momentum_dt);
        let sum = |range: std::ops::Range<usize>| {
            let mut sums = none();
            for (condition, &force) in self.conditions[range.clone()].iter().zip(&force[range]) {
                let node = condition.node as usize;
                sums.add(self, (condition.boundary, grid.position(node)), (force, mean(node)), step);
            }
            sums
        };
        let mut sums = parallel::reduce(self.conditions.len(), sum, Sums::and).unwrap_or_else(none);
        for (point, velocity) in self.reactions[field].surface.velocities(mean) {
            sums.add(self, (point.boundary, point.place), (point.force, velocity), step);
        }
        sums
    }

    /// Moves the obstacles to the end of a step.
    pub fn advance(&mut self, t: f64, dt: f64) {
        for (obstacle, displacement) in self.displacement.iter_mut().enumerate() {
            let velocity = &self.boundaries[2 * D + obstacle].velocity;
            *displacement += Vector::from_fn(|a| velocity[a].value([0.0; 3], t + 0.5 * dt)) * dt;
        }
    }

    /// Names and reactions of the walls that do something: forces on the material [N].
    pub fn reactions(&self) -> impl Iterator<Item = (&str, Vector<D>)> {
        let active = self.boundaries.iter().zip(&self.force).filter(|(b, _)| b.kind != WallKind::Open);
        active.map(|(boundary, &force)| (boundary.name.as_str(), force))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Region;
    use crate::mpm::{Kernel, KernelKind};

    /// −0.3 + 6 · 0.05 is rounded to 6 · 10⁻¹⁷, and a surface halfway between two rows is as near to both: there is one point per node along it
    /// all the same.
    #[test]
    fn obstacles_bind_at_one_point_per_node_along_their_surface() {
        for top in [0.0, 0.01, 0.025, 0.04] {
            let walls = walls_with_a_floor(top);
            let places: Vec<_> = walls.feet.iter().map(|point| point.place).collect();
            assert_eq!(places.len(), 4, "{places:?}");
            assert!(places.iter().all(|place| (place[1] - top).abs() < 1e-12), "{places:?}");
            assert!(walls.feet.iter().all(|point| (point.normal - Vector([0.0, 1.0])).norm() < 1e-9));
        }
    }

    fn walls_with_a_floor(top: f64) -> Walls<2> {
        let walls = std::array::from_fn(|_| [Wall::default(), Wall::default()]);
        let setup = GridSetup::<2> { lower: Vector([0.0, -0.3]), cell: 0.05, cells: [8, 24], walls };
        let floor = Obstacle {
            name: "floor".into(),
            region: Region::Box { lower: [-1.0, -9.0, -1.0], upper: [9.0, top, 1.0] },
            kind: WallKind::Slip,
            velocity: std::array::from_fn(|_| Signal::ZERO),
        };
        let mut grid = Grid::new(setup.lower, setup.cell, setup.cells, 1);
        grid.set_blocks(vec![[0, 0], [0, 1], [0, 2]]);
        let lattice = FoldedStencil::new(Kernel::new(KernelKind::Quadratic, 0.25), &setup.walls);
        let mut walls = Walls::new(&setup, vec![floor], 1, lattice);
        walls.find_nodes(&grid);
        walls
    }
}
