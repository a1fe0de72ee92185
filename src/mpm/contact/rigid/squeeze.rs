//! Points of a sheet that are squeezed: between two solids that close on it, or held by supports in the way of one
//! (theory E.11).
//!
//! ```text
//! n₁·n₂ ≈ −1:   φ₁ + φ₂ < t,   −(g₁ + g₂) = t − (φ₁ + φ₂) > 0             wherever between them the point is
//! ```
//!
//! No impulse satisfies both contacts then, and the sheet would pass through one of the solids, unnoticed where that is
//! thin. Nor does an impulse move a node that supports hold along the normal.

use super::{RigidContact, RigidContacts};
use crate::error::{Place, StepError};
use crate::math::Vector;
use crate::mpm::wall::Walls;

/// Cosine between normals below which, within 26 degrees of opposite, nothing slips out sideways.
const OPPOSITE: f64 = -0.9;

/// The part of the thickness that may be squeezed away: what rounding and linear gaps are wrong by is far less. Below a
/// half, so that a node that an obstacle presses against a wall is found before it leaves the grid.
const LARGEST_SQUEEZE: f64 = 0.4;

/// A point is held along a normal if the axes that are free take up less than this of it.
const HELD: f64 = 1e-6;

/// Positions of a sheet's nodes now, and at the start of the run [m].
#[derive(Debug, Clone, Copy)]
pub struct NodePositions<'a, const D: usize> {
    /// Now.
    pub position: &'a [Vector<D>],
    /// Positions at the start of the run [m].
    pub reference: &'a [Vector<D>],
}

/// A point of a sheet that is squeezed.
#[derive(Debug, Clone, PartialEq)]
pub struct Squeeze<const D: usize> {
    /// Node of the point, of a point within an element the first.
    pub node: usize,
    /// Position [m].
    pub place: Vector<D>,
    /// The wall or obstacle that it is in, as histories name it.
    pub solid: String,
    /// The other one; without, supports hold the point.
    pub other: Option<String>,
    /// Distance between the two, negative where they overlap; or depth of the point in the one [m].
    pub distance: f64,
}

impl<const D: usize> Squeeze<D> {
    /// The error of the sheet `name`, which has no way out between walls, obstacles and supports.
    pub fn error(&self, name: &str) -> StepError {
        let Squeeze { node, place, solid, other, distance } = self;
        let place = Place::Node { body: name.to_owned(), index: *node, position: place.to3() };
        match other {
            Some(other) => StepError::new(
                place,
                format!("`{solid}` and `{other}` close on a membrane and leave it no way out"),
                "their distance",
                *distance,
                "keep them apart by its thickness at least (`velocity` of the obstacles), or end the run before they meet (`time.end`)",
            ),
            None => StepError::new(
                place,
                format!("supports hold a node of a membrane, and `{solid}` went over it"),
                "depth",
                *distance,
                "neither gives way: stop one of the two before they meet, or free that axis in `supports`",
            ),
        }
    }
}

impl<const D: usize> RigidContacts<D> {
    /// The first squeezed point, `elapsed` [s] after the start of the step. Nodes are `held` along some axes: those
    /// that were held in an obstacle from the start of the run may stay there.
    pub fn squeezed(
        &self,
        NodePositions { position, reference }: NodePositions<'_, D>,
        walls: &Walls<D>,
        elapsed: f64,
        held: &[[bool; D]],
    ) -> Option<Squeeze<D>> {
        let gap = |contact: &RigidContact<D>| contact.gap_after(position, elapsed);
        let distance = |contact: &RigidContact<D>| gap(contact) + contact.offset;
        let found = |contact: &RigidContact<D>, other: Option<&RigidContact<D>>, distance: f64| Squeeze {
            node: contact.nodes[0] as usize,
            place: contact.position(position),
            solid: walls.boundary_name(contact.solid as usize).to_owned(),
            other: other.map(|other| walls.boundary_name(other.solid as usize).to_owned()),
            distance,
        };
        // The contacts of a node, and those of an element, follow each other.
        for near in self.contacts.chunk_by(|a, b| a.nodes == b.nodes) {
            for contact in near.iter().filter(|contact| -gap(contact) > LARGEST_SQUEEZE * contact.half_thickness) {
                let too_near = |other: &&RigidContact<D>| {
                    contact.is_opposite(other)
                        && -(gap(contact) + gap(other))
                            > LARGEST_SQUEEZE * (contact.half_thickness + other.half_thickness)
                };
                if let Some(other) = near.iter().find(too_near) {
                    return Some(found(contact, Some(other), distance(contact) + distance(other)));
                }
                let depth = -distance(contact);
                let began = || walls.distance_at_the_start(contact.solid as usize, contact.position(reference));
                if depth > contact.half_thickness && contact.is_held(held) && began() > -contact.half_thickness {
                    return Some(found(contact, None, depth));
                }
            }
        }
        None
    }
}

impl<const D: usize> RigidContact<D> {
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
