//! The way that solids are likely to take, and how well the mesh of the fluid resolves them there (theory J.15).
//!
//! | solid | its way |
//! |---|---|
//! | elastic, with supports | deflection under loads, weight less buoyancy and the drag of a stream; swings from its velocity at the start and in a stream (`deflected.rs`) |
//! | rigid, or elastic without supports | flight under weight less buoyancy, as springs, guides and prescribed motions let it, also with a stream (`drifting.rs`) |
//!
//! It is an estimate, without the resistance and the added mass of the fluid: where it says that three elements lie
//! across a solid, they lie there; where it warns, the solid may stay nearer.

mod deflected;
mod drifting;
mod resolution;
mod stream;

use super::fluids::{InitialBody, body_at};
use crate::case::CaseFile;
use crate::case::resolution::{MeshSizes, PathResolution};
use crate::math::{Signal, Vector};
use crate::mesh::{Locator, Mesh};
use crate::pfem2::boundary::BoundarySetup;
use crate::pfem2::fluid::FluidSetup;
use crate::pfem2::solid::setup::SolidSetup;
use crate::pfem2::solid::structure::Structure;
use crate::pfem2::solid::structure::modes::NaturalMode;
use std::ops::Range;
use stream::AmbientStream;
pub(super) use stream::{driven as driven_stream, of_inlets as speed_of_inlets};

/// Surroundings of solids at the start: mesh, boundaries, fluids, gravity.
pub(super) struct SolidSurroundings<'a, const D: usize, const N: usize> {
    pub file: &'a CaseFile,
    pub mesh: &'a Mesh<D, N>,
    pub locator: Locator<D>,
    /// Conditions on the boundary of the mesh.
    pub boundaries: &'a [BoundarySetup<D>],
    pub fluids: &'a [FluidSetup],
    /// The fluids in their regions at the start.
    pub bodies: &'a [InitialBody],
    pub gravity: &'a [Signal],
}

impl<const D: usize, const N: usize> SolidSurroundings<'_, D, N> {
    /// Density of the fluid that fills a place at the start, or would without the solids [kg/m³]; zero where none is.
    fn density(&self, x: Vector<D>) -> f64 {
        let fluid = body_at(self.bodies, x).and_then(|body| self.fluids.get(self.bodies[body].phase()));
        fluid.map_or(0.0, |fluid| fluid.density)
    }

    fn gravity(&self, x: Vector<D>, t: f64) -> Vector<D> {
        Vector::from_fn(|axis| self.gravity[axis].value(x.to3(), t))
    }
}

/// Places of a solid along its way: a displacement of each of its nodes [m].
type Placement<const D: usize> = Vec<Vector<D>>;

/// Resolution of each solid along its way; `None` for those that stay where they are, as far as it can be foreseen.
pub(super) fn of_solids<const D: usize, const N: usize>(
    structure: &Structure<D>,
    modes: &[NaturalMode<D>],
    around: &SolidSurroundings<D, N>,
) -> Vec<Option<PathResolution>> {
    let (stream, sizes) = (stream::strongest(around), MeshSizes::new(around.mesh));
    let way = |solid: usize| {
        let placements = match supported(structure, solid) {
            true => deflected::placements(structure, modes, solid, around, stream.as_ref()),
            false => drifting::placements(structure, solid, around, stream.as_ref()),
        };
        resolution::along(&structure.setups()[solid], &placements, around, &sizes)
    };
    (0..structure.setups().len()).map(way).collect()
}

/// True for an elastic solid that something holds.
fn supported<const D: usize>(structure: &Structure<D>, solid: usize) -> bool {
    let SolidSetup { law, held, springs, .. } = &structure.setups()[solid];
    !law.is_rigid() && (!held.is_empty() || !springs.is_empty() || structure.ties.is_bonded(solid))
}

/// The nodes of a solid among those of all.
fn nodes_of<const D: usize>(structure: &Structure<D>, solid: usize) -> Range<usize> {
    let (mesh, first) = structure.meshes()[solid];
    first as usize..first as usize + mesh.nodes.len()
}

/// The longest side of the box around a solid [m].
pub(super) fn longest_side<const D: usize>(setup: &SolidSetup<D>) -> f64 {
    (0..D).map(|axis| extent(&setup.mesh.nodes, axis)).map(|[lower, upper]| upper - lower).fold(0.0, f64::max)
}

/// Least and largest coordinate along an axis [m].
fn extent<const D: usize>(places: &[Vector<D>], axis: usize) -> [f64; 2] {
    let along = places.iter().map(|x| x[axis]);
    [along.clone().fold(f64::INFINITY, f64::min), along.fold(f64::NEG_INFINITY, f64::max)]
}

/// Length of the largest displacement [m].
fn largest<'a, const D: usize>(displacement: impl IntoIterator<Item = &'a Vector<D>>) -> f64 {
    displacement.into_iter().map(|u| u.norm()).fold(0.0, f64::max)
}
