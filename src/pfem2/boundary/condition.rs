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
    /// True if fluid may come in or leave; other facets hold particles back, and solids touch them.
    pub fn admits_flow(self) -> bool {
        match self {
            Self::Wall | Self::Slip => false,
            Self::Inlet | Self::Outlet => true,
        }
    }

    /// True if the flux is unknown, because a traction or pressure is prescribed: with no such facet the pressure is
    /// known up to a constant only.
    pub fn has_free_flux(self) -> bool {
        match self {
            Self::Wall | Self::Slip | Self::Inlet => false,
            Self::Outlet => true,
        }
    }

    /// True if the flux is prescribed and may differ from zero.
    pub fn prescribes_inflow(self) -> bool {
        self.admits_flow() && !self.has_free_flux()
    }

    /// True if nodes have reactions to a prescribed velocity: the force on such facets is known by them.
    pub fn carries_reaction(self) -> bool {
        !self.has_free_flux()
    }

    /// True if only the velocity along the normal is prescribed.
    pub fn is_frictionless(self) -> bool {
        match self {
            Self::Slip => true,
            Self::Wall | Self::Inlet | Self::Outlet => false,
        }
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

    /// Components of the prescribed velocity, if there is one [m/s].
    pub fn velocity_formula(&self) -> Option<&[Signal; D]> {
        match self {
            Self::Wall(v) | Self::Inlet(v) => Some(v),
            Self::Slip | Self::Outlet | Self::Traction(_) | Self::Pressure(_) => None,
        }
    }

    /// The prescribed velocity at a place [m] and time [s], if there is one [m/s].
    pub fn velocity(&self, x: Vector<D>, t: f64) -> Option<Vector<D>> {
        self.velocity_formula().map(|v| Vector::from_fn(|i| v[i].value(x.to3(), t)))
    }

    /// True if −p n + μ ∂v/∂n is prescribed, as by a pressure outside.
    pub fn prescribes_pressure(&self) -> bool {
        match self {
            Self::Outlet | Self::Pressure(_) => true,
            Self::Wall(_) | Self::Slip | Self::Inlet(_) | Self::Traction(_) => false,
        }
    }

    /// The pressure outside at a place [m] and time [s], where one is prescribed [Pa].
    pub fn outside_pressure(&self, x: Vector<D>, t: f64) -> Option<f64> {
        match self {
            Self::Pressure(pressure) => Some(pressure.value(x.to3(), t)),
            _ => self.prescribes_pressure().then_some(0.0),
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
