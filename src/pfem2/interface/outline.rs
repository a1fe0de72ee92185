//! The interfaces between fluids as a surface, so that probes, pictures and files can show where they are: the segments
//! (2D) or triangles (3D) in which the level set vanishes (theory G.1).

use crate::math::Vector;
use crate::pfem2::cut_element::{at_corners, facets, inner};
use crate::pfem2::particles::interpolate;
use crate::pfem2::phases::FluidRegion;
use crate::pfem2::phases::Phases;

/// The interfaces of one time. Facets share no corners, each with its neighbours' places.
#[derive(Debug, Clone, Default)]
pub struct Outline {
    /// Places of the corners [m].
    pub position: Vec<[f64; 3]>,
    /// Velocity at the corners [m/s].
    pub velocity: Vec<[f64; 3]>,
    /// Length [m] or area [m²] of each facet.
    pub size: Vec<f64>,
    /// Numbers of the corners, facet after facet.
    corners: Vec<u32>,
}

impl Outline {
    /// All interfaces, with the velocity of the nodes [m/s].
    pub fn new<const D: usize, const N: usize>(
        region: &FluidRegion<D, N>,
        phases: &Phases,
        velocity: &[Vector<D>],
    ) -> Self {
        let mesh = region.mesh;
        let mut outline = Self::default();
        for (e, nodes) in mesh.elements().iter().enumerate() {
            let Some(level) = phases.level_in(nodes) else { continue };
            let (places, speeds) = (mesh.corners(e), nodes.map(|node| velocity[node as usize]));
            let simplices = region.simplices(e).into_iter();
            let within = |corners: [[f64; N]; N]| {
                let facets = facets::<D, N>(&at_corners(&corners, &level)).into_iter();
                facets.map(move |facet| inner(&corners, &facet))
            };
            for facet in simplices.flat_map(within) {
                let corners = facet.map(|shape| interpolate(&shape, &places));
                outline.size.push(size(&corners));
                outline.position.extend(corners.map(|x| x.to3()));
                outline.velocity.extend(facet.map(|shape| interpolate(&shape, &speeds).to3()));
            }
        }
        outline.corners = (0..outline.position.len() as u32).collect();
        outline
    }

    /// The facets, by the numbers of their corners; `dimension` of them each.
    pub fn facets(&self, dimension: usize) -> Vec<&[u32]> {
        self.corners.chunks_exact(dimension).collect()
    }
}

/// Length of a segment or area of a triangle.
pub(in crate::pfem2) fn size<const D: usize>(facet: &[Vector<D>; D]) -> f64 {
    let u = facet[1] - facet[0];
    if D == 2 {
        return u.norm();
    }
    let v = facet[D - 1] - facet[0];
    0.5 * (u.norm_squared() * v.norm_squared() - u.dot(v).powi(2)).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Mesh;
    use crate::pfem2::phases::phase_list::PhaseList;
    use std::f64::consts::PI;

    /// Facets lie on a circle or sphere of radius r within h²/8r, and add up to its length or area.
    fn check<const D: usize, const N: usize>(mesh: &Mesh<D, N>, edge: f64, exact: f64) {
        let radius = 0.61;
        let level: Vec<f64> = mesh.nodes().iter().map(|x| x.norm() - radius).collect();
        let velocity: Vec<Vector<D>> = mesh.nodes().iter().map(|x| *x * 3.0).collect();
        let phases = Phases { list: &PhaseList::fluids(&[2.0, 1.0]), fraction: &[], level: &level };
        let outline = Outline::new(&FluidRegion::whole(mesh), &phases, &velocity);
        let facets = outline.facets(D);
        assert_eq!(facets.len(), outline.size.len());
        for &corner in facets.iter().copied().flatten() {
            let (x, v) = (Vector(outline.position[corner as usize]), Vector(outline.velocity[corner as usize]));
            assert!((x.norm() - radius).abs() < edge * edge / (8.0 * radius) * 1.2, "{x:?}");
            assert!((v - x * 3.0).norm() < 1e-12);
        }
        let total: f64 = outline.size.iter().sum();
        assert!((total / exact - 1.0).abs() < 0.02, "{total} {exact}");
    }

    #[test]
    fn outlines_of_a_circle_and_a_sphere_have_their_place_and_size() {
        let flat = Mesh::block(Vector([-1.0; 2]), Vector([1.0; 2]), [20, 20]).unwrap();
        check::<2, 3>(&flat, 0.1 * 2f64.sqrt(), 2.0 * PI * 0.61);
        let full = Mesh::block(Vector([-1.0; 3]), Vector([1.0; 3]), [16; 3]).unwrap();
        check::<3, 4>(&full, 0.125 * 3f64.sqrt(), 4.0 * PI * 0.61 * 0.61);
    }
}
