//! A membrane as contact gets it: once at the start of the run, and in each step.

use super::facet::SheetFacet;
use crate::math::Vector;
use crate::parallel;

/// A membrane as contact first sees it.
#[derive(Debug, Clone)]
pub struct SheetSource<'a, const D: usize> {
    /// Name of the membrane.
    pub name: &'a str,
    /// Elements of the sheet.
    pub facets: Vec<SheetFacet>,
    /// Node positions in the reference state [m].
    pub reference: &'a [Vector<D>],
    /// Lumped mass of each node [kg].
    pub mass: &'a [f64],
    /// Axes along which the motion of each node is prescribed.
    pub held: Vec<[bool; D]>,
}

/// A membrane as contact sees it during a step.
#[derive(Debug, Clone, Copy)]
pub struct SheetSurface<'a, const D: usize> {
    /// Node positions [m].
    pub position: &'a [Vector<D>],
    /// Trial velocities v̄_K [m/s], with all forces but contact.
    pub velocity: &'a [Vector<D>],
    /// Velocities before the forces [m/s].
    pub previous: &'a [Vector<D>],
    /// Distance between the mid-surface and the face that bodies touch, per element [m]; empty: zero.
    pub offset: &'a [f64],
}

impl<const D: usize> SheetSurface<'_, D> {
    /// The largest speed of its nodes [m/s].
    pub fn fastest(&self) -> f64 {
        parallel::max(self.velocity.len(), |k| self.velocity[k].norm_squared()).sqrt()
    }

    /// Distance between the mid-surface and the face that bodies touch at an element [m].
    pub fn offset_of(&self, element: usize) -> f64 {
        self.offset.get(element).copied().unwrap_or(0.0)
    }
}
