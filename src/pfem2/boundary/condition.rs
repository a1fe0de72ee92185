//! Conditions on sets of boundary facets.

use crate::math::{Signal, Vector};
use crate::mesh::Facet;

/// Kind of a boundary facet for the flow and the particles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum BoundaryKind {
    /// The fluid sticks to it; no particle crosses it.
    #[default]
    Wall,
    /// The fluid glides along it; no particle crosses it.
    Slip,
    /// The velocity is prescribed; particles come in.
    Inlet,
    /// Traction or pressure is prescribed; particles leave and come in.
    Outlet,
}

impl BoundaryKind {
    /// True if fluid may come in or leave.
    pub fn is_open(self) -> bool {
        matches!(self, Self::Inlet | Self::Outlet)
    }
}

/// Condition on a set of facets.
#[derive(Debug, Clone)]
pub enum Condition<const D: usize> {
    /// No slip; the velocity of the wall [m/s].
    Wall([Signal; D]),
    /// No flow through it, no friction: also a plane of symmetry.
    Slip,
    /// Inflow with this velocity [m/s].
    Inlet([Signal; D]),
    /// Open: the flow leaves as it comes, without resistance.
    Outlet,
    /// Open, under a traction [Pa].
    Traction([Signal; D]),
    /// Open, under a pressure [Pa].
    Pressure(Signal),
}

impl<const D: usize> Condition<D> {
    /// A wall at rest.
    pub fn wall() -> Self {
        Self::Wall(std::array::from_fn(|_| Signal::ZERO))
    }

    /// Kind of the condition.
    pub fn kind(&self) -> BoundaryKind {
        match self {
            Self::Wall(_) => BoundaryKind::Wall,
            Self::Slip => BoundaryKind::Slip,
            Self::Inlet(_) => BoundaryKind::Inlet,
            Self::Outlet | Self::Traction(_) | Self::Pressure(_) => BoundaryKind::Outlet,
        }
    }

    /// The prescribed velocity at a place [m] and time [s], if there is one [m/s].
    pub fn velocity(&self, x: Vector<D>, t: f64) -> Option<Vector<D>> {
        match self {
            Self::Wall(v) | Self::Inlet(v) => Some(Vector::from_fn(|i| v[i].value(x.to3(), t))),
            _ => None,
        }
    }

    /// The traction at a place of a facet with outward normal `n`, if it isn't zero [Pa].
    pub(super) fn traction(&self, x: Vector<D>, n: Vector<D>, t: f64) -> Option<Vector<D>> {
        match self {
            Self::Traction(traction) => Some(Vector::from_fn(|i| traction[i].value(x.to3(), t))),
            Self::Pressure(pressure) => Some(n * -pressure.value(x.to3(), t)),
            _ => None,
        }
    }
}

/// A named set of facets with its condition.
#[derive(Debug, Clone)]
pub struct BoundarySetup<const D: usize> {
    /// Name.
    pub name: String,
    /// Facets of the mesh's boundary.
    pub facets: Vec<Facet>,
    /// The condition there.
    pub condition: Condition<D>,
    /// The fluid that comes in; `None`: that of the place at the start.
    pub brings: Option<u8>,
}

/// Inflow through a facet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inflow<const D: usize> {
    /// Velocity of what comes in, where one is prescribed [m/s].
    pub velocity: Option<Vector<D>>,
    /// Fluid of what comes in, where one is named.
    pub fluid: Option<u8>,
    /// The facet, as a place of [`crate::mesh::Mesh::boundary`].
    pub facet: usize,
}
