//! Volume, centre and second moments inside of a closed surface, for rigid solids without elements inside
//! (theory (J.17a)).
//!
//! ```text
//! V = ⅓ ∮ x·m dξ,      V c_i = ¼ ∮ x_i x·m dξ,      P_ij = ∫ r_i r_j dV = ⅕ ∮ r_i r_j r·m dξ,   r = x − c
//! seven points with V, c and P:   ¼ V at c,   ⅛ V at c ± 2 √(P_k/V) e_k       P_k, e_k: principal values and axes of P
//! ```
//!
//! m as in `pressure.rs`. The integrals are exact for flat patches. A body and points with the same volume, centre and
//! second moments are equimomental: they move alike.

use super::gauss::{GaussPoint, gauss_points};
use super::{SolidFacet, SolidMesh};
use crate::math::{SymTensor, Vector};

/// Volume [m³], centre [m], and second moments P about it [m⁵] inside of patches.
fn moments(nodes: &[Vector<3>], facets: &[SolidFacet]) -> (f64, Vector<3>, SymTensor) {
    let points = gauss_points(2);
    let about = |origin: Vector<3>| {
        let (mut volume, mut first, mut second) = (0.0, Vector::ZERO, SymTensor::ZERO);
        for facet in facets {
            let places: Vec<Vector<3>> = facet.nodes.iter().map(|&node| nodes[node as usize] - origin).collect();
            for point in &points {
                let x = point.interpolate(&places);
                let flux = x.dot(area(&places, point)) * point.weight;
                volume += flux / 3.0;
                first += x * (flux / 4.0);
                second += SymTensor([x[0] * x[0], x[1] * x[1], x[2] * x[2], x[0] * x[1], x[1] * x[2], x[2] * x[0]])
                    * (flux / 5.0);
            }
        }
        (volume, first, second)
    };
    let origin = nodes.first().copied().unwrap_or_default();
    let (volume, first, _) = about(origin);
    let center = origin + first / volume;
    (volume, center, about(center).2)
}

/// m [m²].
fn area(places: &[Vector<3>], point: &GaussPoint) -> Vector<3> {
    let tangent = |k: usize| places.iter().zip(&point.slopes).map(|(x, slope)| *x * slope[k]).sum::<Vector<3>>();
    tangent(0).cross(tangent(1))
}

impl SolidMesh<3> {
    /// The inside of a closed surface of patches of 9 nodes at `nodes` [m] in the order of [`SolidFacet`], without
    /// elements: seven nodes more stand for it.
    ///
    /// # Errors
    /// Patches with another number of nodes, or nodes that aren't there; a surface that encloses no volume.
    pub fn enclosed(mut nodes: Vec<Vector<3>>, patches: Vec<Vec<u32>>) -> Result<Self, String> {
        if patches.iter().any(|patch| patch.len() != 9 || patch.iter().any(|&node| node as usize >= nodes.len())) {
            return Err("a patch of the surface needs 9 nodes that exist".into());
        }
        let facets: Vec<_> = patches.into_iter().map(|nodes| SolidFacet { nodes, element: 0 }).collect();
        let (volume, center, second) = moments(&nodes, &facets);
        if !(volume > 0.0 && volume.is_finite()) {
            return Err(format!("the surface encloses a volume of {volume:e} m³: its triangles must look outward"));
        }
        let spectrum = second.spectrum();
        let mut inner = vec![(nodes.len() as u32, 0.25 * volume)];
        nodes.push(center);
        for (value, direction) in spectrum.values.into_iter().zip(spectrum.directions) {
            let reach = direction * (2.0 * (value.max(0.0) / volume).sqrt());
            for place in [center + reach, center - reach] {
                inner.push((nodes.len() as u32, 0.125 * volume));
                nodes.push(place);
            }
        }
        Ok(Self { nodes, elements: Vec::new(), facets, inner })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Triangles;
    use crate::mesh::SurfacePatches;

    fn enclosed(surface: &Triangles) -> SolidMesh<3> {
        let SurfacePatches { mesh, patches } = SurfacePatches::new(surface).unwrap();
        SolidMesh::enclosed(mesh.nodes.into_iter().map(Vector).collect(), patches).unwrap()
    }

    /// A box 1 × 2 × 3, turned and moved, of triangles: V, its centre, and l²/12 along the edges.
    #[test]
    fn a_box_has_its_volume_centre_and_moments() {
        let edges = [Vector([0.6, 0.8, 0.0]), Vector([-1.6, 1.2, 0.0]), Vector([0.0, 0.0, 3.0])];
        let corner = |n: usize| {
            let inside = edges.iter().enumerate().filter(|(k, _)| n >> k & 1 == 1).map(|(_, e)| *e);
            (Vector([5.0, -7.0, 2.0]) + inside.sum::<Vector<3>>()).0
        };
        let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        let mesh = enclosed(&Triangles { vertices: (0..8).map(corner).collect(), triangles });
        let sum = |of: &dyn Fn(Vector<3>) -> f64| {
            mesh.inner.iter().map(|&(node, volume)| volume * of(mesh.nodes[node as usize])).sum::<f64>()
        };
        let middle = Vector([5.0, -7.0, 2.0]) + (edges[0] + edges[1] + edges[2]) * 0.5;
        assert!((sum(&|_| 1.0) - 6.0).abs() < 1e-12, "{}", sum(&|_| 1.0));
        for axis in 0..3 {
            assert!((sum(&|x| x[axis]) / 6.0 - middle[axis]).abs() < 1e-12);
            let length = edges[axis].norm();
            for other in 0..3 {
                let along = |x: Vector<3>, k: usize| (x - middle).dot(edges[k]) / edges[k].norm();
                let expected = if axis == other { 6.0 * length * length / 12.0 } else { 0.0 };
                assert!((sum(&|x| along(x, axis) * along(x, other)) - expected).abs() < 1e-12, "{axis} {other}");
            }
        }
    }

    /// A sphere of triangles between circles of latitude: 4/3 π r³ and r²/5 along every axis, less what the triangles
    /// cut off.
    #[test]
    fn a_sphere_has_its_volume_and_moments() {
        let (count, radius) = (48usize, 2.0f64);
        let place = |i: usize, j: usize| {
            let [latitude, longitude] = [i, 2 * j].map(|k| std::f64::consts::PI * k as f64 / count as f64);
            let (sin, cos) = latitude.sin_cos();
            [radius * sin * longitude.cos(), radius * sin * longitude.sin(), radius * cos]
        };
        let mut vertices: Vec<[f64; 3]> =
            (1..count).flat_map(|i| (0..count).map(move |j| (i, j))).map(|(i, j)| place(i, j)).collect();
        let poles = [vertices.len() as u32, vertices.len() as u32 + 1];
        vertices.extend([[0.0, 0.0, radius], [0.0, 0.0, -radius]]);
        let at = |i: usize, j: usize| ((i - 1) * count + j % count) as u32;
        let mut triangles = Vec::new();
        for j in 0..count {
            triangles.push([poles[0], at(1, j), at(1, j + 1)]);
            triangles.push([poles[1], at(count - 1, j + 1), at(count - 1, j)]);
            for i in 1..count - 1 {
                triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
                triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
        let mesh = enclosed(&Triangles { vertices, triangles });
        let volume: f64 = mesh.inner.iter().map(|(_, volume)| volume).sum();
        let exact = 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
        assert!((-8e-3..0.0).contains(&(volume / exact - 1.0)), "{}", volume / exact);
        for axis in 0..3 {
            let second: f64 = mesh.inner.iter().map(|&(a, v)| v * mesh.nodes[a as usize][axis].powi(2)).sum();
            let part = second / volume / (radius * radius / 5.0) - 1.0;
            assert!((-8e-3..0.0).contains(&part), "{axis}: {part}");
        }
    }

    #[test]
    fn a_surface_turned_inward_is_refused() {
        let vertices = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 3.0]];
        let triangles = vec![[0, 1, 2], [0, 3, 1], [1, 3, 2], [0, 2, 3]];
        let SurfacePatches { mesh, patches } = SurfacePatches::new(&Triangles { vertices, triangles }).unwrap();
        let made = SolidMesh::enclosed(mesh.nodes.into_iter().map(Vector).collect(), patches);
        assert!(made.unwrap_err().contains("look outward"));
    }
}
