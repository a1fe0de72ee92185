//! Closed surfaces of triangles as patches of 9 nodes: three flat quadrilaterals to each triangle (theory J.11).
//!
//! ```text
//! triangle a, b, c with the middle g:      quadrilaterals  a, ab, g, ca;   b, bc, g, ab;   c, ca, g, bc
//! local node a = a_0 + 3 a_1;      ∂x/∂ξ_0 × ∂x/∂ξ_1 points outward
//! ```

use super::QuadraticMesh;
use crate::geometry::Triangles;
use crate::math::Vector;
use std::collections::BTreeMap;

/// Triangles of a surface, at most.
const MOST_TRIANGLES: usize = 50_000;

/// Nodes of a surface without elements, and its patches.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfacePatches {
    /// Nodes with the sets of their sides; no elements.
    pub mesh: QuadraticMesh,
    /// Nodes of each patch.
    pub patches: Vec<Vec<u32>>,
}

/// Nodes that are added between those of the triangles.
struct PatchNodes {
    places: Vec<Vector<3>>,
    between: BTreeMap<[u32; 2], u32>,
}

impl PatchNodes {
    fn add(&mut self, place: Vector<3>) -> u32 {
        self.places.push(place);
        self.places.len() as u32 - 1
    }

    /// The node in the middle of two.
    fn middle(&mut self, a: u32, b: u32) -> u32 {
        let key = [a.min(b), a.max(b)];
        if let Some(&node) = self.between.get(&key) {
            return node;
        }
        let node = self.add((self.places[key[0] as usize] + self.places[key[1] as usize]) * 0.5);
        self.between.insert(key, node);
        node
    }

    /// The patch with these corners, around it.
    fn patch(&mut self, [a, b, c, d]: [u32; 4]) -> Vec<u32> {
        let [ab, bc, cd, da] = [[a, b], [b, c], [c, d], [d, a]].map(|[a, b]| self.middle(a, b));
        let all = [a, b, c, d].map(|node| self.places[node as usize]);
        let middle = self.add(all.into_iter().sum::<Vector<3>>() * 0.25);
        vec![a, ab, b, da, middle, bc, d, cd, c]
    }
}

impl SurfacePatches {
    /// Patches of a closed surface.
    ///
    /// # Errors
    /// More triangles than a surface may have.
    pub fn new(surface: &Triangles) -> Result<Self, String> {
        let count = surface.triangles.len();
        if count > MOST_TRIANGLES {
            return Err(format!(
                "the surface has {count} triangles, and {MOST_TRIANGLES} at most can be used: coarsen it"
            ));
        }
        let places = surface.vertices.iter().map(|&x| Vector(x)).collect();
        let (mut nodes, mut patches) = (PatchNodes { places, between: BTreeMap::new() }, Vec::new());
        for &[a, b, c] in &surface.triangles {
            let corners = [a, b, c].map(|node| nodes.places[node as usize]);
            let middle = nodes.add(corners.into_iter().sum::<Vector<3>>() / 3.0);
            let [ab, bc, ca] = [[a, b], [b, c], [c, a]].map(|[a, b]| nodes.middle(a, b));
            for corners in [[a, ab, middle, ca], [b, bc, middle, ab], [c, ca, middle, bc]] {
                patches.push(nodes.patch(corners));
            }
        }
        let nodes = nodes.places.into_iter().map(|x| x.0).collect();
        let mut mesh = QuadraticMesh { dimension: 3, nodes, elements: Vec::new(), sets: BTreeMap::new() };
        mesh.name_sides();
        mesh.sets.insert("surface".into(), (0..mesh.nodes.len() as u32).collect());
        Ok(Self { mesh, patches })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tetrahedron: 4 corners, 6 edges with 3 nodes between, and 7 nodes inside of each triangle. Area vectors close
    /// and point outward.
    #[test]
    fn patches_cover_a_closed_surface_once() {
        let vertices = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 3.0]];
        let triangles = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];
        let SurfacePatches { mesh, patches } = SurfacePatches::new(&Triangles { vertices, triangles }).unwrap();
        assert_eq!((mesh.nodes.len(), patches.len()), (4 + 6 * 3 + 4 * 7, 12));
        let x = |node: u32| Vector(mesh.nodes[node as usize]);
        let of = |patch: &Vec<u32>| {
            let area = (x(patch[8]) - x(patch[0])).cross(x(patch[6]) - x(patch[2])) * 0.5;
            (area, area.dot(x(patch[4])) / 3.0)
        };
        let sums = patches.iter().map(of).fold((Vector::ZERO, 0.0), |sum, own| (sum.0 + own.0, sum.1 + own.1));
        assert!(sums.0.norm() < 1e-14 && (sums.1 - 1.0).abs() < 1e-14, "{sums:?}");
        assert!(mesh.sets["left"].len() == 3 * 3 + 3 + 7 && mesh.sets["right"].len() == 1, "{:?}", mesh.sets);
    }
}
