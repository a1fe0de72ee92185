//! The surface of elastic solids in the cut elements, point by point: what flows through it, and where the pressure
//! acts (theory (J.9a)).
//!
//! ```text
//! q_k = −∫_Γ N_k(x_h) n·(v_S − v_h) dA,      v_S = Σ_a N_a(ξ) v_a,      v_h = Σ_c φ_c P_s v_c      rows p_k;  their transpose: forces
//! ```
//!
//! Γ is the surface of the solid, n its normal, v_h the velocity of the fluid at the nearest place x_h of its own
//! boundary: the chords, or triangles, between cut points c. Between these the surface moves otherwise, and bulges
//! where its nodes lie closer than the nodes of the mesh. Without q the pressure would act on the nodes that happen to
//! be near cut points.
//!
//! In the plane the points are those of facets between cut points, each with its nearest place of a chord; in space
//! those of chords, each with its nearest place of the surface.

mod in_plane;
mod in_space;

use crate::math::Vector;
use crate::mesh::{Locator, Mesh};
use crate::pfem2::solid::cut::{Chords, SolidCut};
use crate::pfem2::solid::surface::{NodeWeights, SolidSurface};

/// A point of the surface in a cut element.
#[derive(Debug, Clone, PartialEq)]
pub struct TracePoint<const D: usize, const N: usize> {
    /// Its facet, among those of all solids.
    pub facet: u32,
    /// Its coordinates there, in −1..=1.
    pub local: [f64; 2],
    /// Its weight among the points of the facet, 2 per axis in sum.
    pub quadrature_weight: f64,
    /// n dA [m²], away from the solid.
    pub area: Vector<D>,
    /// Shape functions of the element at the nearest place of the boundary of its fluid part: beyond that they may
    /// belong to a node that hardly any fluid has, and whose pressure nothing else would bound.
    pub shape: [f64; N],
    /// Shape functions of the solids' nodes at it, by global node.
    pub weights: NodeWeights,
    /// φ_c of cut points, by their places in the list of the element.
    pub chord: Vec<(usize, f64)>,
}

/// The points of all facets of elastic solids, each with the place of its cut element.
#[derive(Debug, Clone, Default)]
pub struct SurfaceTrace<const D: usize, const N: usize> {
    /// Points of each facet, with the places of their cut elements.
    pub facets: Vec<Vec<(usize, TracePoint<D, N>)>>,
}

/// The mesh of the fluid, cut at the surface of solids.
#[derive(Debug, Clone)]
pub struct CutMesh<const D: usize, const N: usize> {
    /// The cut elements.
    pub cut: SolidCut<D, N>,
    /// Points of the surface in them.
    pub trace: SurfaceTrace<D, N>,
}

impl<const D: usize, const N: usize> SurfaceTrace<D, N> {
    /// The points of a surface in a mesh that it cuts. Rigid solids move between cut points as at these, and need none.
    pub fn new(
        mesh: &Mesh<D, N>,
        locator: &Locator<D>,
        surface: &SolidSurface<D>,
        cut: &SolidCut<D, N>,
        is_elastic: impl Fn(u32) -> bool + Sync,
    ) -> Self {
        let chords = Chords::new(mesh, cut);
        let is_elastic = |facet: u32| is_elastic(surface.nodes_of(facet)[0]);
        let facets = match D {
            2 => in_plane::points(&chords, locator, surface, is_elastic),
            _ => in_space::points(&chords, surface, is_elastic),
        };
        Self { facets }
    }

    /// The points in each of `count` cut elements, in their order.
    pub fn by_element(self, count: usize) -> Vec<Vec<TracePoint<D, N>>> {
        let mut all = vec![Vec::new(); count];
        self.facets.into_iter().flatten().for_each(|(place, point)| all[place].push(point));
        all
    }
}
