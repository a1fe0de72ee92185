//! The fluid that comes in through open boundaries: the one that they name, or that of each place at the start
//! (theory F.10, G.4).

use super::level_set::{self, CameIn, InflowDepth, InflowFluid, LevelSet};
use crate::math::Vector;
use crate::mesh::Mesh;
use crate::pfem2::Boundary;
use crate::pfem2::boundary::{BoundaryKind, Inflow};
use crate::pfem2::particles::convect::MeshPoint;
use crate::pfem2::phases::Phases;
use crate::pfem2::phases::phase_list::PhaseList;

/// Fluids of the inflow, by places of [`Mesh::boundary`]. They follow from the start alone.
#[derive(Debug, Clone, Default)]
pub struct InflowComposition<const D: usize> {
    /// φ of a sharp level set at the corners of the open facets [m].
    level: Vec<Option<[f64; D]>>,
    /// Else: the fractions of the fluids at the nodes at the start.
    fraction: Vec<Vec<f64>>,
    /// The level set of two fluids at the start.
    level_at_start: Vec<f64>,
    /// The phases.
    list: PhaseList,
}

impl<const D: usize> InflowComposition<D> {
    /// The composition of the inflow by the state at the start.
    pub fn new<const N: usize>(
        mesh: &Mesh<D, N>,
        boundary: &Boundary<D>,
        sharp: Option<&LevelSet>,
        phases: &Phases,
    ) -> Self {
        let Some(set) = sharp else {
            let (level_at_start, list) = (phases.level.to_vec(), phases.list.clone());
            return Self { level: Vec::new(), fraction: phases.fraction.to_vec(), level_at_start, list };
        };
        let of = |(place, kind): (usize, &BoundaryKind)| match (boundary.inflow_fluid(place), kind) {
            (Some(fluid), _) => InflowFluid::Named(fluid == set.inside),
            (None, kind) if kind.admits_flow() => InflowFluid::Start,
            (None, _) => InflowFluid::Nothing,
        };
        let inflow: Vec<InflowFluid> = boundary.kinds.iter().enumerate().map(of).collect();
        Self { level: level_set::brought(mesh, &set.level, &inflow), ..Self::default() }
    }

    /// φ at the corners of a facet [m], if something may come in there.
    pub fn level(&self, facet: usize) -> Option<[f64; D]> {
        *self.level.get(facet)?
    }

    /// Fluid and depth of what came `way` [m] from beyond an open boundary to a place on it; `sharp` is the level set
    /// with what open boundaries see of it, if it is sharp.
    pub fn brought<const N: usize>(
        &self,
        mesh: &Mesh<D, N>,
        sharp: Option<(&LevelSet, &InflowDepth)>,
        place: &MeshPoint<N>,
        inflow: &Inflow<D>,
        way: Vector<D>,
    ) -> (u8, f64) {
        let Some(((set, entering), corners)) = sharp.zip(self.level(inflow.facet)) else {
            let phases = Phases { list: &self.list, fraction: &self.fraction, level: &self.level_at_start };
            let fluid = || phases.at_place(&mesh.elements()[place.element], &place.shape) as u8;
            return (inflow.fluid.unwrap_or_else(fluid), f64::INFINITY);
        };
        let facet = mesh.boundary()[inflow.facet];
        let held = level_set::on_facet(facet, &corners, place);
        let (own, depth) = set.inflow_at(mesh, &CameIn { place, facet, way, held }, entering);
        (inflow.fluid.unwrap_or(own), depth)
    }
}
