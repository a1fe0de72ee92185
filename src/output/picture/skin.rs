//! The surface of a mesh of tetrahedra: the faces that belong to one element only.

/// A face of an element: where it comes from, and its nodes, turned outwards.
pub(super) type Face = (usize, [u32; 3]);

/// The faces around the elements that are shown, in the order of their nodes. What a cut hides leaves faces, too.
pub(super) fn skin(elements: &[&[u32]], shown: impl Fn(&[u32]) -> bool) -> Vec<Face> {
    let tetrahedra = elements.iter().enumerate().filter(|(_, nodes)| shown(nodes));
    let mut faces: Vec<([u32; 3], Face)> = tetrahedra.flat_map(|(e, nodes)| faces(e, nodes)).collect();
    faces.sort_unstable();
    let groups = faces.chunk_by(|a, b| a.0 == b.0).filter(|group| group.len() == 1);
    groups.map(|group| group[0].1).collect()
}

/// The four faces of a tetrahedron, behind their sorted nodes.
fn faces(element: usize, nodes: &[u32]) -> impl Iterator<Item = ([u32; 3], Face)> + use<'_> {
    [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]].into_iter().map(move |corners| {
        let face = corners.map(|corner: usize| nodes[corner]);
        let mut sorted = face;
        sorted.sort_unstable();
        (sorted, (element, face))
    })
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
            let of = |&(_, [a, b, c]): &Face| {
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
}
