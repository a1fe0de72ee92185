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
//! `fixed` and `slip` bind always: they act on p⁻ too. The others are contact: they act on p̄ only, and on p⁻ where
//! they held in the step before (`lasting`). Every change of p̄ changes f with it, so that p⁻ = p̄ − Δt f; the sums of
//! these forces are the reactions. A mirror carries further force in the ghosts beyond it (their normal parts change
//! sign when folded).
//!
//! Walls of the domain lie on nodes and act there, but for solids that may leave them (`domain`). Obstacles lie
//! anywhere, and act at points of their surface (`surface`); nodes deeper in them than half a support have conditions
//! too. `conditions` lists both, each node as a `node_condition`; `kind` is the table above, `constrain` applies it to nodes, `gap` measures gaps,
//! `lasting` follows contacts that last. `reaction` and `pushes` sum what walls do, `solid` is the rigid surface for
//! contact of membranes; `folded_stencil` finds the nodes around a point, with walls, for contact and obstacles. At the end of a step no particle is within an obstacle (`position_correction`).

mod conditions;
mod constrain;
mod domain;
pub(in crate::mpm) mod folded_stencil;
mod gap;
mod kind;
mod lasting;
mod node_condition;
mod position_correction;
mod pushes;
mod reaction;
mod solid;
mod surface;

use super::{GridSetup, Obstacle, Wall, WallKind};
use crate::math::{Signal, Vector};
use constrain::ConditionRange;
use folded_stencil::FoldedStencil;
pub(in crate::mpm) use gap::BodiesAtWalls;
use node_condition::NodeCondition;
pub use pushes::{Pushes, WallWork};
use reaction::FieldReaction;
pub use solid::{RigidBoundary, SheetPush};

/// Fraction of a cell for the central differences of an obstacle's normal.
const NORMAL_STEP: f64 = 1e-3;

/// A wall of the domain or an obstacle.
#[derive(Debug)]
struct WallOrObstacle {
    /// `wall:left`, `obstacle:floor`.
    name: String,
    kind: WallKind,
    velocity: [Signal; 3],
}

/// All walls and obstacles of a run.
#[derive(Debug)]
pub struct Walls<const D: usize> {
    boundaries: Vec<WallOrObstacle>,
    /// Lower and upper corner of the domain [m].
    bounds: [Vector<D>; 2],
    /// Shapes of the obstacles, which follow the 2·D sides among the boundaries.
    regions: Vec<crate::geometry::Region>,
    /// Displacement of each obstacle since the start of the run [m].
    pub displacement: Vec<Vector<3>>,
    conditions: Vec<NodeCondition<D>>,
    /// Ranges of conditions without common nodes.
    ranges: Vec<ConditionRange>,
    gap_conditions: gap::GapConditions,
    /// Points of surfaces at which obstacles bind.
    binding_points: Vec<surface::SurfacePoint<D>>,
    /// Bodies that start within an obstacle: number of the body, and of the boundary.
    overlaps: Vec<[u32; 2]>,
    /// Grid blocks near obstacles, and near walls with contact at the surface for some field.
    near: Vec<bool>,
    /// Fields all of whose bodies keep their shape.
    solid_fields: Vec<bool>,
    /// Shape functions of the bodies.
    stencil: FoldedStencil<D>,
    /// Forces on each velocity field during a step.
    field_reactions: Vec<FieldReaction<D>>,
    /// Reaction of each boundary during the last step: force on the material [N].
    pub force: Vec<Vector<D>>,
}

/// Names of the sides, by axis and end.
pub fn side_name(dimension: usize, axis: usize, end: usize) -> &'static str {
    let names = if axis + 1 == dimension { ["bottom", "top"] } else { [["left", "right"], ["front", "back"]][axis] };
    names[end]
}

impl<const D: usize> Walls<D> {
    /// The walls of `grid` and the obstacles; `stencil`: the shape functions of the bodies.
    pub fn new(grid: &GridSetup<D>, obstacles: Vec<Obstacle>, fields: usize, stencil: FoldedStencil<D>) -> Self {
        let side = |axis: usize, end: usize, wall: &Wall| WallOrObstacle {
            name: format!("wall:{}", side_name(D, axis, end)),
            kind: wall.kind,
            velocity: wall.velocity.clone(),
        };
        let sides = (0..2 * D).map(|s| side(s / 2, s % 2, &grid.walls[s / 2][s % 2]));
        let mut boundaries: Vec<_> = sides.collect();
        let mut regions = Vec::new();
        for Obstacle { name, region, kind, velocity } in obstacles {
            boundaries.push(WallOrObstacle { name: format!("obstacle:{name}"), kind, velocity });
            regions.push(region);
        }
        let force = vec![Vector::ZERO; boundaries.len()];
        let displacement = vec![Vector::ZERO; regions.len()];
        let field_reactions = vec![FieldReaction::default(); fields];
        let upper = grid.lower + Vector::from_fn(|a| f64::from(grid.cells[a]) * grid.cell);
        Self {
            boundaries,
            bounds: [grid.lower, upper],
            regions,
            displacement,
            conditions: Vec::new(),
            ranges: Vec::new(),
            gap_conditions: gap::GapConditions::default(),
            binding_points: Vec::new(),
            overlaps: Vec::new(),
            near: Vec::new(),
            solid_fields: Vec::new(),
            stencil,
            field_reactions,
            force,
        }
    }

    /// True if an obstacle moves, so that its nodes change.
    pub fn moving(&self) -> bool {
        self.boundaries[2 * D..].iter().any(|b| b.velocity.iter().any(|v| !v.is_zero()))
    }

    /// True if there are conditions with gaps on the active grid: membranes may lie within these gaps.
    pub fn have_gaps(&self) -> bool {
        self.gap_conditions.any() || self.near.contains(&true)
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

    /// True if the displacement `by` [m] leads from `x` [m] to less than `margin` [m] from a wall or an obstacle, and
    /// nearer to it.
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

    /// The velocity of a boundary at `x` and time `t`.
    fn velocity(&self, boundary: usize, x: Vector<D>, t: f64) -> Vector<D> {
        Vector::from_fn(|a| self.boundaries[boundary].velocity[a].value(x.to3(), t))
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
