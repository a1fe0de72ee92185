//! The surface of a mesh of tetrahedra or hexahedra: the faces that belong to one element only.

use crate::simulation::SIDES_OF_HEXAHEDRON;

/// A face of an element: where it comes from, and its nodes, turned outwards.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Face {
    pub element: usize,
    corners: [u32; 4],
    count: usize,
}

impl Face {
    /// Its nodes, three or four.
    pub fn nodes(&self) -> &[u32] {
        &self.corners[..self.count]
    }
}

/// Corners of the sides of a tetrahedron, seen from outside.
const SIDES_OF_TETRAHEDRON: [[usize; 3]; 4] = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];

/// The faces around the elements that are shown, in the order of their nodes. What a cut hides leaves faces, too.
pub(super) fn skin(elements: &[&[u32]], shown: impl Fn(&[u32]) -> bool) -> Vec<Face> {
    let mut faces: Vec<([u32; 4], Face)> = Vec::new();
    for (e, nodes) in elements.iter().enumerate().filter(|(_, nodes)| shown(nodes)) {
        match nodes.len() {
            8 => faces.extend(SIDES_OF_HEXAHEDRON.iter().map(|corners| face(e, nodes, corners))),
            _ => faces.extend(SIDES_OF_TETRAHEDRON.iter().map(|corners| face(e, nodes, corners))),
        }
    }
    faces.sort_unstable();
    let groups = faces.chunk_by(|a, b| a.0 == b.0).filter(|group| group.len() == 1);
    groups.map(|group| group[0].1).collect()
}

/// A face of an element, behind its sorted nodes.
fn face(element: usize, nodes: &[u32], corners: &[usize]) -> ([u32; 4], Face) {
    let mut own = [u32::MAX; 4];
    own.iter_mut().zip(corners).for_each(|(own, &corner)| *own = nodes[corner]);
    let mut sorted = own;
    sorted.sort_unstable();
    (sorted, Face { element, corners: own, count: corners.len() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vector;
    use crate::mesh::Mesh;

    /// Its area is that of the box, its normals point outwards: ∫ x·n dA = 3 V.
    #[test]
    fn the_skin_of_a_box_encloses_its_volume_and_a_cut_opens_it() {
        let mesh = Mesh::<3, 4>::block(Vector::ZERO, Vector([1.0, 2.0, 3.0]), [3, 4, 5]).unwrap();
        let elements: Vec<&[u32]> = mesh.elements().iter().map(|nodes| &nodes[..]).collect();
        let measure = |faces: &[Face]| {
            let at = |n: u32| mesh.nodes()[n as usize];
            let of = |face: &Face| {
                let &[a, b, c] = face.nodes() else { panic!("a triangle") };
                let area = (at(b) - at(a)).cross(at(c) - at(a)) * 0.5;
                [area.norm(), area.dot(at(a)) / 3.0]
            };
            faces.iter().map(of).fold([0.0, 0.0], |sum, own| [sum[0] + own[0], sum[1] + own[1]])
        };
        let [area, volume] = measure(&skin(&elements, |_| true));
        assert!((area - 22.0).abs() < 1e-12 && (volume - 6.0).abs() < 1e-12, "{area} {volume}");
        let [area, volume] =
            measure(&skin(&elements, |nodes| nodes.iter().all(|&n| mesh.nodes()[n as usize][1] <= 1.0)));
        assert!((area - 14.0).abs() < 1e-12 && (volume - 3.0).abs() < 1e-12, "{area} {volume}");
    }

    /// Two cubes side by side.
    #[test]
    fn the_skin_of_hexahedra_leaves_the_side_between_them_out() {
        let node = |i: u32, j: u32, k: u32| i + 3 * j + 6 * k;
        let lower = |i: u32, k: u32| [node(i, 0, k), node(i + 1, 0, k), node(i + 1, 1, k), node(i, 1, k)];
        let cubes = [0, 1].map(|i| [lower(i, 0), lower(i, 1)].concat());
        let elements: Vec<&[u32]> = cubes.iter().map(|cube| &cube[..]).collect();
        let at = |n: u32| Vector([f64::from(n % 3), f64::from(n / 3 % 2), f64::from(n / 6)]);
        let volume = |face: &Face| {
            let &[a, b, c, d] = face.nodes() else { panic!("a quadrilateral") };
            (at(c) - at(a)).cross(at(d) - at(b)).dot(at(a)) / 6.0
        };
        let faces = skin(&elements, |_| true);
        assert_eq!(faces.len(), 10);
        assert!((faces.iter().map(volume).sum::<f64>() - 2.0).abs() < 1e-12);
        assert_eq!(skin(&elements, |nodes| nodes.contains(&0)).len(), 6);
    }
}
