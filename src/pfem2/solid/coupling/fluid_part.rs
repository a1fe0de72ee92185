//! The fluid part of an element that a solid cuts: its simplices, and their pieces of one fluid (theory J.3, G.14).

use crate::math::Vector;
use crate::mesh::{Mesh, Simplex};
use crate::pfem2::cut_element::{Enrichment, Medium, SubSimplex, at_corners, sides};
use crate::pfem2::element::{Drive, Mass};
use crate::pfem2::solid::cut::{CutBySolid, CutPoint, FluidSimplex, Vertex};

/// Filling of the fluid part of a cut element.
#[derive(Debug, Clone, Copy)]
pub struct FluidPart<const D: usize, const N: usize> {
    /// Level set at the nodes; of one sign where there is one fluid.
    pub level: [f64; N],
    /// Media where it is negative and where it isn't.
    pub media: [Medium; 2],
    /// Enrichment of the pressure: [`Enrichment::Jump`] or none.
    pub enrichment: Enrichment,
    /// Surface tension between them [N/m].
    pub tension: f64,
    /// Facets of the element with a prescribed flux, as bits: walls, slip walls and inlets.
    pub held: u8,
    /// Facets of the element with a free flux, as bits.
    pub openings: u8,
    /// Those of them that are outlets or have a pressure.
    pub outlets: u8,
    /// Stabilisation time τ [s].
    pub tau: f64,
    /// Nodal values of the right-hand side.
    pub drive: Drive<D, N>,
    /// Source s on either side but for its inertia [m/s²].
    pub sources: [Vector<D>; 2],
}

impl<const D: usize, const N: usize> FluidPart<D, N> {
    /// Medium of a piece.
    pub(in crate::pfem2::solid) fn medium(&self, piece: &SubSimplex<N>) -> Medium {
        self.media[usize::from(!piece.negative)]
    }

    /// Source s of a piece but for its inertia [m/s²].
    pub(in crate::pfem2::solid) fn source(&self, piece: &SubSimplex<N>) -> Vector<D> {
        self.sources[usize::from(!piece.negative)]
    }
}

/// A simplex of the fluid part.
pub(in crate::pfem2::solid) struct PartGeometry<const D: usize, const N: usize> {
    pub simplex: Simplex<D, N>,
    /// Shape functions of the element at its corners.
    pub shapes: [[f64; N]; N],
    /// Its vertices, in the list of nodes and then cut points of the element.
    pub vertices: [usize; N],
    /// Its pieces of one fluid.
    pub pieces: Vec<SubSimplex<N>>,
}

impl<const D: usize, const N: usize> PartGeometry<D, N> {
    /// Shape functions of the element at a point, given by its own.
    pub fn at(&self, point: &[f64; N]) -> [f64; N] {
        std::array::from_fn(|k| point.iter().zip(&self.shapes).map(|(n, shape)| n * shape[k]).sum())
    }

    /// Mean over its volume of a quantity that is constant in each of its pieces.
    pub fn mean(&self, of: impl Fn(&SubSimplex<N>) -> f64) -> f64 {
        self.pieces.iter().map(|piece| piece.volume_fraction * of(piece)).sum()
    }
}

/// M_ij of a simplex [kg].
pub(in crate::pfem2::solid) fn masses<const D: usize, const N: usize>(
    kind: Mass,
    part: &PartGeometry<D, N>,
    fluid: &FluidPart<D, N>,
) -> [[f64; N]; N] {
    let mut masses = [[0.0; N]; N];
    for piece in &part.pieces {
        let own = fluid.medium(piece).density * part.simplex.volume * piece.volume_fraction;
        for i in 0..N {
            match kind {
                Mass::Lumped => masses[i][i] += own * piece.center[i],
                Mass::Consistent => (0..N).for_each(|j| masses[i][j] += own * piece.products[i][j]),
            }
        }
    }
    masses
}

/// The simplices of the fluid part that have a volume, divided by the level set at the nodes of the element.
pub(in crate::pfem2::solid) fn parts<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    cut: &CutBySolid<N>,
    points: &[&CutPoint<D>],
    level: &[f64; N],
) -> Vec<PartGeometry<D, N>> {
    let corners = mesh.corners(cut.element as usize);
    let part = |(part, &shapes): (&FluidSimplex<N>, &[[f64; N]; N])| {
        let places = part.vertices.map(|vertex| match vertex {
            Vertex::Node(k) => (k as usize, corners[k as usize]),
            Vertex::Point(k) => (N + k as usize, points[k as usize].position),
        });
        let simplex = Simplex::new(places.map(|(_, x)| x)).filter(|simplex| simplex.volume > 0.0)?;
        let pieces = sides(&at_corners(&shapes, level));
        Some(PartGeometry { simplex, shapes, vertices: places.map(|(vertex, _)| vertex), pieces })
    };
    cut.parts.iter().zip(&cut.shapes).filter_map(part).collect()
}
