//! Lagrangian meshes of solids: quadrilaterals with 9 nodes in 2D, hexahedra with 27 nodes in 3D.
//!
//! ```text
//! N_a(ξ) = Π_k L_{a_k}(ξ_k),   L_0 = ½ ξ (ξ − 1),  L_1 = 1 − ξ²,  L_2 = ½ ξ (ξ + 1),   ξ_k ∈ [−1, 1]
//! local node a = a_0 + 3 a_1 (+ 9 a_2)
//! ```

mod enclosed;
pub mod gauss;
#[cfg(test)]
pub(in crate::pfem2) mod shapes;

use crate::math::Vector;
use std::collections::BTreeMap;

/// A mesh of biquadratic quadrilaterals or triquadratic hexahedra.
#[derive(Debug, Clone, PartialEq)]
pub struct SolidMesh<const D: usize> {
    /// Places of the nodes in the reference state [m].
    pub nodes: Vec<Vector<D>>,
    /// Nodes of each element, 3ᴰ of them in the order of the module's head; counter-clockwise in 2D, right-handed in
    /// 3D.
    pub elements: Vec<Vec<u32>>,
    /// Facets on the boundary.
    pub facets: Vec<SolidFacet>,
    /// Nodes with the volumes that stand for the inside of a surface without elements [m³].
    pub inner: Vec<(u32, f64)>,
}

/// A facet on the boundary of a solid: a line of 3 nodes in 2D, a patch of 9 nodes in 3D.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SolidFacet {
    /// Nodes of the facet, 3ᴰ⁻¹, in lexicographic order. The outward normal is (t_y, −t_x) with the tangent t = ∂x/∂ξ_0
    /// in 2D and ∂x/∂ξ_0 × ∂x/∂ξ_1 in 3D.
    pub nodes: Vec<u32>,
    /// The element that it belongs to.
    pub element: u32,
}

/// Nodes of an element.
pub const fn element_nodes<const D: usize>() -> usize {
    3usize.pow(D as u32)
}

impl<const D: usize> SolidMesh<D> {
    /// The mesh of nodes [m] and elements.
    ///
    /// # Errors
    /// No elements, a wrong number of nodes, a node that isn't there or isn't finite.
    pub fn new(nodes: Vec<Vector<D>>, elements: Vec<Vec<u32>>) -> Result<Self, String> {
        if elements.is_empty() {
            return Err("the mesh of the solid has no elements".into());
        }
        if let Some(node) = nodes.iter().position(|x| !x.is_finite()) {
            return Err(format!("node {node} of the solid has a position that is not finite"));
        }
        for (e, own) in elements.iter().enumerate() {
            if own.len() != element_nodes::<D>() || own.iter().any(|&node| node as usize >= nodes.len()) {
                return Err(format!("element {e} of the solid needs {} nodes that exist", element_nodes::<D>()));
            }
        }
        let facets = boundary::<D>(&elements);
        Ok(Self { nodes, elements, facets, inner: Vec::new() })
    }

    /// A block of `counts` elements between two corners [m].
    ///
    /// # Errors
    /// As [`SolidMesh::new`].
    pub fn block(lower: Vector<D>, upper: Vector<D>, counts: [usize; D]) -> Result<Self, String> {
        let lines = counts.map(|count| 2 * count + 1);
        let total: usize = lines.iter().product();
        let split = |mut index: usize, sizes: [usize; D]| {
            sizes.map(|size| {
                let own = index % size;
                index /= size;
                own
            })
        };
        let place = |index| {
            let at = split(index, lines);
            Vector::from_fn(|k| lower[k] + (upper[k] - lower[k]) * at[k] as f64 / (lines[k] - 1) as f64)
        };
        let number = |at: [usize; D]| (0..D).rev().fold(0, |sum, k| sum * lines[k] + at[k]) as u32;
        let element = |index| {
            let first = split(index, counts);
            let local = |a| {
                let own = split(a, [3; D]);
                number(std::array::from_fn(|k| 2 * first[k] + own[k]))
            };
            (0..element_nodes::<D>()).map(local).collect()
        };
        Self::new((0..total).map(place).collect(), (0..counts.iter().product()).map(element).collect())
    }
}

/// Facets that one element has alone, in the order of elements.
fn boundary<const D: usize>(elements: &[Vec<u32>]) -> Vec<SolidFacet> {
    let key = |nodes: &[u32]| {
        let mut key = nodes.to_vec();
        key.sort_unstable();
        key
    };
    let mut count: BTreeMap<Vec<u32>, usize> = BTreeMap::new();
    let all = |e: usize| sides::<D>().map(move |side| side.iter().map(|&a| elements[e][a]).collect::<Vec<u32>>());
    (0..elements.len()).flat_map(all).for_each(|nodes| *count.entry(key(&nodes)).or_default() += 1);
    (0..elements.len())
        .flat_map(|e| all(e).map(move |nodes| SolidFacet { nodes, element: e as u32 }))
        .filter(|facet| count[&key(&facet.nodes)] == 1)
        .collect()
}

/// Local nodes of the 2 D sides of an element, each turned outward.
fn sides<const D: usize>() -> impl Iterator<Item = Vec<usize>> {
    (0..2 * D).map(|side| {
        let (axis, upper) = (side / 2, side % 2 == 1);
        let rest: Vec<usize> = (1..D).map(|k| (axis + k) % D).collect();
        let stride = |k: usize| 3usize.pow(k as u32);
        let count = 3usize.pow(D as u32 - 1);
        // ξ_axis grows outward on the upper side; in 2D the outward normal of the tangent along ξ_1 is +ξ_0.
        let turned = if D == 2 { upper != (axis == 0) } else { !upper };
        let node = |index: usize| {
            let (mut own, mut index) = (if upper { 2 * stride(axis) } else { 0 }, index);
            for (place, &k) in rest.iter().enumerate() {
                let at = index % 3;
                own += stride(k) * if turned && place == 0 { 2 - at } else { at };
                index /= 3;
            }
            own
        };
        (0..count).map(node).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Σ over facets of the area vector times x/D is the volume: facets close and turn outward.
    #[test]
    fn facets_of_a_block_are_closed_and_turn_outward() {
        let mesh = SolidMesh::<2>::block(Vector([1.0, 2.0]), Vector([4.0, 3.0]), [3, 2]).unwrap();
        assert_eq!((mesh.nodes.len(), mesh.elements.len(), mesh.facets.len()), (35, 6, 10));
        let area: f64 = mesh
            .facets
            .iter()
            .map(|facet| {
                let [a, m, b] = [0, 1, 2].map(|k| mesh.nodes[facet.nodes[k] as usize]);
                let t = b - a;
                0.5 * Vector([t[1], -t[0]]).dot(m)
            })
            .sum();
        assert!((area - 3.0).abs() < 1e-14, "{area}");
        let mesh = SolidMesh::<3>::block(Vector([1.0, 2.0, -1.0]), Vector([4.0, 3.0, 1.0]), [3, 2, 1]).unwrap();
        assert_eq!((mesh.nodes.len(), mesh.facets.len()), (7 * 5 * 3, 22));
        let volume: f64 = mesh
            .facets
            .iter()
            .map(|facet| {
                let x = |k: usize| mesh.nodes[facet.nodes[k] as usize];
                (x(2) - x(0)).cross(x(6) - x(0)).dot(x(4)) / 3.0
            })
            .sum();
        assert!((volume - 6.0).abs() < 1e-13, "{volume}");
    }
}
