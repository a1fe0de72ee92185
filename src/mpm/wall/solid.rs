//! Walls and obstacles in contact with membranes: rigid surfaces with a distance, a normal, a velocity and friction
//! (theory E.10).

use super::{WallKind, WallOrObstacle, WallWork, Walls};
use crate::math::Vector;
use crate::mpm::LeapfrogStep;

/// Impulse and work of a wall or an obstacle on sheets during a step.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct SheetPush<const D: usize> {
    /// Σ J on the sheets [N s].
    pub impulse: Vector<D>,
    /// Σ J·v_w, the work of what moves [J].
    pub work: f64,
    /// Σ J·v̂, the work on the sheets [J].
    pub received: f64,
}

impl<const D: usize> SheetPush<D> {
    /// Adds those of another sheet.
    pub fn add(&mut self, other: &Self) {
        self.impulse += other.impulse;
        self.work += other.work;
        self.received += other.received;
    }
}

/// A wall of the domain or an obstacle.
#[derive(Debug, Clone, Copy)]
pub struct RigidBoundary<'a, const D: usize> {
    walls: &'a Walls<D>,
    boundary: usize,
}

impl<const D: usize> Walls<D> {
    /// The solids that sheets have contact with: obstacles, and the walls that aren't open.
    pub fn solids(&self) -> impl Iterator<Item = RigidBoundary<'_, D>> {
        let closed = |boundary: &usize| self.boundaries[*boundary].kind != WallKind::Open;
        (0..self.boundaries.len()).filter(closed).map(|boundary| RigidBoundary { walls: self, boundary })
    }

    /// True if the wall at an end (0 or 1) of an axis holds sheets.
    pub fn is_closed(&self, axis: usize, end: usize) -> bool {
        self.boundaries[2 * axis + end].kind != WallKind::Open
    }

    /// True if there is a wall at an end (0 or 1) of an axis that doesn't move along it.
    pub fn stands(&self, axis: usize, end: usize) -> bool {
        self.is_closed(axis, end) && self.boundaries[2 * axis + end].velocity[axis].is_zero()
    }

    /// The name of a wall or an obstacle in histories: `wall:left`, `obstacle:floor`.
    pub fn boundary_name(&self, boundary: usize) -> &str {
        &self.boundaries[boundary].name
    }

    /// Distance of `x` [m] from a wall, or from an obstacle where it was at the start of the run, negative beyond its
    /// surface.
    pub fn distance_at_the_start(&self, boundary: usize, x: Vector<D>) -> f64 {
        let obstacle = boundary.checked_sub(2 * D);
        obstacle.map_or_else(|| self.distance(boundary, x), |obstacle| self.regions[obstacle].signed_distance(x.to3()))
    }

    /// Adds what sheets got, boundary by boundary, during a step of the momentum `dt` [s] to the reactions.
    pub fn book_sheets(&mut self, pushes: &[SheetPush<D>], dt: f64) -> WallWork<D> {
        let mut sum = WallWork::default();
        for (force, push) in self.force.iter_mut().zip(pushes) {
            *force += push.impulse / dt;
            sum.work += push.work;
            sum.dissipation += push.work - push.received;
            sum.impulse += push.impulse;
        }
        sum
    }
}

impl<'a, const D: usize> RigidBoundary<'a, D> {
    /// Number among the boundaries.
    pub fn number(self) -> usize {
        self.boundary
    }

    /// True if a case names it so: `wall:left` and `obstacle:floor`, or `left` and `floor`.
    pub fn is_named(self, name: &str) -> bool {
        let full = self.boundary().name.as_str();
        full == name || full.split_once(':').is_some_and(|(_, own)| own == name)
    }

    /// True if a plane bounds it, so that an element whose nodes lie outside does so, too.
    pub fn is_flat(self) -> bool {
        self.boundary < 2 * D || matches!(self.region(), Some(crate::geometry::Region::HalfSpace { .. }))
    }

    /// Distance of `x` [m] from its surface, negative inside, and the normal out of it, when it has moved on by
    /// `ahead` [m] since the start of the step.
    pub fn distance(self, x: Vector<D>, ahead: Vector<D>) -> (f64, Vector<D>) {
        let Some(region) = self.region() else {
            let (axis, end) = (self.boundary / 2, self.boundary % 2);
            let normal = Vector::unit(axis) * if end == 0 { 1.0 } else { -1.0 };
            return ((x[axis] - self.walls.bounds[end][axis]) * normal[axis], normal);
        };
        let moved = Vector::from3(self.walls.displacement[self.boundary - 2 * D].0);
        let (distance, normal) = region.distance_and_normal((x - moved - ahead).to3());
        (distance, Vector::from3(normal).normalized().unwrap_or(Vector::unit(D - 1)))
    }

    /// True if places within `reach` [m] of it may lie between these corners [m].
    pub fn is_near(self, lower: Vector<D>, upper: Vector<D>, reach: f64) -> bool {
        let Some(region) = self.region() else {
            let (axis, end) = (self.boundary / 2, self.boundary % 2);
            let bound = self.walls.bounds[end][axis];
            return if end == 0 { lower[axis] <= bound + reach } else { upper[axis] >= bound - reach };
        };
        let moved = self.walls.displacement[self.boundary - 2 * D];
        let bounds = region.bounds();
        (0..D).all(|a| upper[a] - moved[a] >= bounds.lower[a] - reach && lower[a] - moved[a] <= bounds.upper[a] + reach)
    }

    /// Velocity of the boundary at `x` [m] during a step [m/s]: obstacles move with that of the middle of the step.
    pub fn velocity(self, x: Vector<D>, step: &LeapfrogStep) -> Vector<D> {
        let at = if self.region().is_some() { [0.0; 3] } else { x.to3() };
        Vector::from_fn(|a| self.boundary().velocity[a].value(at, step.t + 0.5 * step.dt))
    }

    /// μ of ‖J_t‖ ≤ μ J_n: 0 where sheets glide, infinity where they stick as long as they are pressed.
    pub fn friction(self) -> f64 {
        match self.boundary().kind {
            WallKind::Fixed => f64::INFINITY,
            WallKind::Friction { coefficient } => coefficient,
            WallKind::Open | WallKind::Slip | WallKind::Separate => 0.0,
        }
    }

    fn boundary(self) -> &'a WallOrObstacle {
        &self.walls.boundaries[self.boundary]
    }

    fn region(self) -> Option<&'a crate::geometry::Region> {
        self.boundary.checked_sub(2 * D).map(|obstacle| &self.walls.regions[obstacle])
    }
}
