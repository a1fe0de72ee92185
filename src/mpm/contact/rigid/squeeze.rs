//! Where a sheet has no way out: between two solids that close on it, or where supports hold it in the way of one.
//!
//! ```text
//! n₁·n₂ ≈ −1:   φ₁ + φ₂ < t,   −(g₁ + g₂) = t − (φ₁ + φ₂) > 0             wherever between them the point is
//! ```
//!
//! No impulse satisfies both contacts then, and a sheet that goes on leaves one of the solids on its other side, without a word where
//! that is thin. What supports hold along a normal, no impulse moves either.

use super::{Rest, Rigid};
use crate::math::Vector;
use crate::mpm::wall::Walls;

/// Between normals that are nearer to opposite, within 26 degrees, nothing slips out sideways.
const OPPOSITE: f64 = -0.9;

/// The part of the thickness that may be squeezed away: what rounding and linear gaps are wrong by is far less. Below a half, so that a
/// node that an obstacle presses against a wall is found before it leaves the grid.
const MOST: f64 = 0.4;

/// A point is held along a normal if the axes that are free take up less than this of it.
const HELD: f64 = 1e-6;

/// A point of a sheet that has no way out.
#[derive(Debug, Clone, PartialEq)]
pub struct Squeeze<const D: usize> {
    /// Its node, of a point within an element the first.
    pub node: usize,
    /// Where it is [m].
    pub place: Vector<D>,
    /// The wall or obstacle that it is in, as histories name it.
    pub solid: String,
    /// The other one; without, supports hold the point.
    pub other: Option<String>,
    /// How far the two are apart, negative where they overlap; or how deep the point lies in the one [m].
    pub distance: f64,
}

impl<const D: usize> Rigid<D> {
    /// The first point that has no way out, `elapsed` [s] after the start of the step. Nodes have these positions, now and at the
    /// start of the run [m], and are `held` along some axes: those that were held in an obstacle from the start may stay there.
    pub fn squeezed(
        &self,
        (walls, elapsed): (&Walls<D>, f64),
        [position, reference]: [&[Vector<D>]; 2],
        held: &[[bool; D]],
    ) -> Option<Squeeze<D>> {
        let gap = |rest: &Rest<D>| rest.gap_after(position, elapsed);
        let distance = |rest: &Rest<D>| gap(rest) + rest.offset;
        let found = |rest: &Rest<D>, other: Option<&Rest<D>>, distance: f64| Squeeze {
            node: rest.nodes[0] as usize,
            place: rest.place(position),
            solid: walls.boundary_name(rest.solid as usize).to_owned(),
            other: other.map(|other| walls.boundary_name(other.solid as usize).to_owned()),
            distance,
        };
        // The rests of a node, and those of an element, follow each other.
        for near in self.rests.chunk_by(|a, b| a.nodes == b.nodes) {
            for rest in near.iter().filter(|rest| -gap(rest) > MOST * rest.thickness) {
                let too_near = |other: &&Rest<D>| {
                    rest.is_opposite(other) && -(gap(rest) + gap(other)) > MOST * (rest.thickness + other.thickness)
                };
                if let Some(other) = near.iter().find(too_near) {
                    return Some(found(rest, Some(other), distance(rest) + distance(other)));
                }
                let depth = -distance(rest);
                let began = || walls.distance_at_the_start(rest.solid as usize, rest.place(reference));
                if depth > rest.thickness && rest.is_held(held) && began() > -rest.thickness {
                    return Some(found(rest, None, depth));
                }
            }
        }
        None
    }
}

impl<const D: usize> Rest<D> {
    /// True if `other` is the same point, at a solid opposite to this one.
    fn is_opposite(&self, other: &Self) -> bool {
        self.weights == other.weights && self.normal.dot(other.normal) < OPPOSITE
    }

    /// True for a node that supports hold along the normal.
    fn is_held(&self, held: &[[bool; D]]) -> bool {
        let fixed = held[self.nodes[0] as usize];
        let free: f64 = (0..D).filter(|&a| !fixed[a]).map(|a| self.normal[a] * self.normal[a]).sum();
        self.weights[0] == 1.0 && free < HELD
    }
}
