//! Walls of the domain: how the grid ends there, field by field (theory E.2).
//!
//! Walls lie on nodes, and most of them are the end of the grid: ghosts beyond follow the domain (`ghost`), conditions
//! act at the nodes of the wall. That suits materials that fill the cells up to the wall, and walls that always bind. A
//! solid that comes to a wall and leaves it again has gaps there of any width, corners and rounded edges: shape
//! functions that are folded back interact with the wall one and a half cells ahead, and the body would rest or roll up
//! to a cell above it. Such walls are surfaces like those of obstacles, in a grid that goes on beyond them:
//!
//! ```text
//! mirror        slip, at rest along its normal
//! continue      separate, friction: fields all of whose bodies keep their shape meet the surface (`surface`)
//! extrapolate   all others; `separate` and `friction` for liquids and gases, whose gaps are measured (`gap`)
//! ```

use super::{RigidBoundary, WallKind, WallOrObstacle, Walls};
use crate::math::{Signal, Vector};
use crate::mpm::Grid;
use crate::mpm::grid::Fold;
use crate::mpm::particles::Bodies;

impl WallKind {
    /// The rule for the ghosts beyond a wall of this kind that moves with `speed` along its normal: slip walls at rest
    /// are exact mirrors.
    pub(in crate::mpm) fn fold(self, speed: &Signal) -> Fold {
        if self == Self::Slip && speed.is_zero() { Fold::Mirror } else { Fold::Extrapolate }
    }

    /// True if bodies may leave it.
    fn may_be_left(self) -> bool {
        matches!(self, Self::Separate | Self::Friction { .. })
    }
}

impl<const D: usize> Walls<D> {
    /// Records the fields all of whose bodies keep their shape.
    pub fn note_solids(&mut self, bodies: &Bodies<D>) {
        let is_solid = |field: usize| bodies.field(field).iter().all(|body| body.law.keeps_shape());
        self.solid_fields = (0..bodies.field_count()).map(is_solid).collect();
    }

    /// The rule for the ghosts beyond each side.
    pub fn folds(&self) -> [[Fold; 2]; D] {
        std::array::from_fn(|axis| {
            std::array::from_fn(|end| {
                let WallOrObstacle { kind, velocity, .. } = &self.boundaries[2 * axis + end];
                kind.fold(&velocity[axis])
            })
        })
    }

    /// The rule for the ghosts of a field beyond each side.
    pub fn folds_in(&self, field: usize) -> [[Fold; 2]; D] {
        let mut folds = self.folds();
        for side in (0..2 * D).filter(|&side| self.continues(field, side)) {
            folds[side / 2][side % 2] = Fold::Continue;
        }
        folds
    }

    /// True if the nodes of a field go on beyond a wall of the domain.
    pub(super) fn continues(&self, field: usize, boundary: usize) -> bool {
        boundary < 2 * D && self.solid_fields.get(field) == Some(&true) && self.boundaries[boundary].kind.may_be_left()
    }

    /// True if those of any field do.
    fn continues_somewhere(&self, boundary: usize) -> bool {
        (0..self.solid_fields.len()).any(|field| self.continues(field, boundary))
    }

    /// The obstacles and walls with contact at their surface for a field.
    pub(super) fn surfaces(&self, field: usize) -> Vec<RigidBoundary<'_, D>> {
        let met = |boundary: usize| boundary >= 2 * D || self.continues(field, boundary);
        self.solids().filter(|solid| met(solid.number())).collect()
    }

    /// True if there are any.
    pub(super) fn has_surfaces(&self, field: usize) -> bool {
        !self.regions.is_empty() || (0..2 * D).any(|side| self.continues(field, side))
    }

    /// True for nodes of the domain, and for those beyond it that a field goes on to.
    pub(super) fn may_hold_mass(&self, grid: &Grid<D>, ijk: [i32; D]) -> bool {
        (0..D).all(|axis| {
            let (below, above) = (ijk[axis] < 0, ijk[axis] > grid.cells[axis]);
            !(below || above) || self.continues_somewhere(2 * axis + usize::from(above))
        })
    }

    /// Distance of `x` [m] from the nearest obstacle or wall that some field meets at its surface, negative beyond it;
    /// infinite without any.
    pub(super) fn clearance_of_surfaces(&self, x: Vector<D>) -> f64 {
        let walls = (0..2 * D).filter(|&side| self.continues_somewhere(side)).map(|side| self.distance(side, x));
        walls.fold(self.clearance_of_obstacles(x), f64::min)
    }
}
