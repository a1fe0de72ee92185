//! Walls at which the surface of a solid ends: what they take up is no force on the solid (theory (J.9c)).
//!
//! ```text
//! −∫ p ∇·w dV = ∫ ∇p·w dV − ∮_Γ p w·n dA − ∮_W p w·n dA          Γ: surface of the solid, W: wall
//! A_ck += ∮_W N^s_c N^e_k n dA                                   c: cut points on W;   and its transpose
//! ```
//!
//! The function N^s_c of a cut point on a wall reaches along the wall, too, as far as the next node. Without this term
//! the pressure there would push the solid, and a solid that leaves the wall would draw fluid through it.

use super::fluid_part::PartGeometry;
use crate::math::Vector;
use crate::pfem2::cut_element::{at_corners, sides};

/// Shape functions of less than this are those of places on a facet.
const ROUND_OFF: f64 = 1e-12;

/// Area of the wall that belongs to a cut point on it, which the pressure of the fluid pushes.
#[derive(Debug, Clone, Copy)]
pub struct WallArea<const D: usize, const N: usize> {
    /// The facet of the mesh, by the local node opposite to it.
    pub facet: u32,
    /// The cut point [m].
    pub position: Vector<D>,
    /// ∮N^s_c N^e_k n dA of each node k of the element [m²].
    pub area: [Vector<D>; N],
}

/// A facet of a part that lies on a facet of the mesh.
pub(super) struct PartFacet<const D: usize> {
    /// The facet of the mesh, by the local node opposite to it.
    pub facet: u32,
    /// Its corners, by their places in the part.
    pub corners: [usize; D],
    /// Its area vector [m²], out of the mesh.
    pub area: Vector<D>,
}

/// The facets of a part that lie on some facets of its element, given as bits.
pub(super) fn part_facets<const D: usize, const N: usize>(part: &PartGeometry<D, N>, on: u8) -> Vec<PartFacet<D>> {
    let lies_on = |corners: &[usize; D], m: usize| corners.iter().all(|&c| part.shapes[c][m].abs() < ROUND_OFF);
    let facet = |opposite: usize| {
        let corners: [usize; D] = std::array::from_fn(|a| a + usize::from(a >= opposite));
        let facet = (0..N).find(|&m| on >> m & 1 == 1 && lies_on(&corners, m))? as u32;
        Some(PartFacet { facet, corners, area: part.simplex.facet_area(opposite) })
    };
    if on == 0 { Vec::new() } else { (0..N).filter_map(facet).collect() }
}

impl<const D: usize> PartFacet<D> {
    /// The areas of the cut points among its corners, with their vertices; `at` is the position of a vertex [m].
    pub fn wall_areas<const N: usize>(
        &self,
        part: &PartGeometry<D, N>,
        at: impl Fn(usize) -> Vector<D>,
    ) -> Vec<(usize, WallArea<D, N>)> {
        let wall_area = |&c: &usize| {
            let mean = |k: usize| {
                let products = self.corners.iter().map(|&b| part.shapes[b][k] * if b == c { 2.0 } else { 1.0 });
                products.sum::<f64>() / (D * (D + 1)) as f64
            };
            let area = std::array::from_fn(|k| self.area * mean(k));
            (part.vertices[c], WallArea { facet: self.facet, position: at(part.vertices[c]), area })
        };
        self.corners.iter().filter(|&&c| part.vertices[c] >= N).map(wall_area).collect()
    }

    /// Calls `add` with each vertex that is a cut point, each node k of the element and ∮N^s_c F_k n dA [m²], with the
    /// functions F_k of the enriched pressure; `level` at the nodes of the element.
    pub fn press_enriched<const N: usize>(
        &self,
        part: &PartGeometry<D, N>,
        level: &[f64; N],
        mut add: impl FnMut(usize, usize, Vector<D>),
    ) {
        let at = at_corners(&part.shapes, level);
        for piece in sides(&self.corners.map(|c| at[c])) {
            for (a, &c) in self.corners.iter().enumerate().filter(|(_, c)| part.vertices[**c] >= N) {
                for k in (0..N).filter(|&k| (level[k] < 0.0) != piece.negative) {
                    let mean: f64 =
                        self.corners.iter().zip(&piece.products[a]).map(|(&b, n)| part.shapes[b][k] * n).sum();
                    add(part.vertices[c], k, self.area * (piece.volume_fraction * mean));
                }
            }
        }
    }
}
