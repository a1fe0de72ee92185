//! Closed triangulated surfaces.
//!
//! The sign of the distance is that of (x − closest point)·ñ, where ñ is the angle-weighted pseudo-normal
//! of the nearest face, edge or vertex (Baerentzen & Aanaes 2005), which is right for every closed surface.

use super::Triangles;
use super::primitive::{Distance, direction};
use crate::math::Vector;
use hashbrown::HashMap;
use parry3d_f64::query::PointQueryWithLocation;
use parry3d_f64::shape::{TriMesh, TriMeshFlags};
use std::path::Path;

/// A closed triangulated surface with outward normals, ready for distance queries.
#[derive(Clone)]
pub struct Surface {
    mesh: TriMesh,
    volume: f64,
}

impl std::fmt::Debug for Surface {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Surface").field("triangles", &self.mesh.num_triangles()).field("volume", &self.volume).finish()
    }
}

impl Surface {
    /// Reads an STL or OBJ file; `unit` is the length of one unit of the file [m].
    ///
    /// # Errors
    /// A problem with the file or with the surface in it.
    pub fn read(path: &Path, unit: f64) -> Result<Self, String> {
        Self::new(Triangles::read(path, unit)?)
    }

    /// From triangles; normals that all point inward are turned around.
    ///
    /// # Errors
    /// The surface is open, not oriented, not a manifold, degenerate, or encloses nothing.
    pub fn new(mut surface: Triangles) -> Result<Self, String> {
        check_closed(&surface)?;
        check_areas(&surface)?;
        let mut volume = enclosed_volume(&surface);
        if volume < 0.0 {
            surface.triangles.iter_mut().for_each(|t| t.swap(1, 2));
            volume = -volume;
        }
        if !(volume.is_finite() && volume > 0.0) {
            return Err("the surface encloses no volume".into());
        }
        let vertices = surface.vertices.iter().map(|&[x, y, z]| parry3d_f64::math::Vector::new(x, y, z)).collect();
        let mesh = TriMesh::with_flags(vertices, surface.triangles, TriMeshFlags::ORIENTED)
            .map_err(|why| format!("not a usable surface: {why}"))?;
        Ok(Self { mesh, volume })
    }

    /// Volume enclosed [m³].
    pub fn volume(&self) -> f64 {
        self.volume
    }

    /// Its vertices [m].
    pub fn vertices(&self) -> impl Iterator<Item = [f64; 3]> + '_ {
        self.mesh.vertices().iter().map(|v| [v.x, v.y, v.z])
    }

    /// Its triangles, counter-clockwise seen from outside.
    pub fn triangles(&self) -> Triangles {
        Triangles { vertices: self.vertices().collect(), triangles: self.mesh.indices().to_vec() }
    }

    /// Number of triangles.
    pub fn triangle_count(&self) -> usize {
        self.mesh.num_triangles()
    }

    pub(super) fn distance(&self, x: Vector<3>) -> Distance {
        let point = parry3d_f64::math::Vector::new(x[0], x[1], x[2]);
        let (nearest, (triangle, _)) = self.mesh.project_local_point_and_get_location(point, false);
        let away = x - Vector([nearest.point.x, nearest.point.y, nearest.point.z]);
        let sign = if nearest.is_inside { -1.0 } else { 1.0 };
        let d = away.norm();
        let face = || {
            let n = self.mesh.triangle(triangle).normal();
            n.map_or(Vector::unit(0), |n| Vector([n.x, n.y, n.z]))
        };
        (sign * d, if d > 0.0 { direction(away * sign, face()) } else { face() })
    }
}

/// Every directed edge occurs once, and so does its opposite.
fn check_closed(surface: &Triangles) -> Result<(), String> {
    let mut edges: HashMap<(u32, u32), u32> = HashMap::new();
    let directed = |t: &[u32; 3]| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])];
    for edge in surface.triangles.iter().flat_map(directed) {
        *edges.entry(edge).or_default() += 1;
    }
    let at = |v: u32| {
        let [x, y, z] = surface.vertices[v as usize];
        format!("({x:.6e}, {y:.6e}, {z:.6e}) m")
    };
    for (index, (a, b)) in surface.triangles.iter().enumerate().flat_map(|(i, t)| directed(t).map(|e| (i, e))) {
        let (along, against) = (edges[&(a, b)], edges.get(&(b, a)).copied().unwrap_or(0));
        let edge = || format!("at the edge of triangle {index} from {} to {}", at(a), at(b));
        if along + against > 2 {
            return Err(format!("the surface is not a manifold: {} triangles meet {}", along + against, edge()));
        }
        if along == 2 {
            return Err(format!("the triangles are not oriented alike: two neighbours disagree {}", edge()));
        }
        if against == 0 {
            let open = edges.keys().filter(|&&(a, b)| !edges.contains_key(&(b, a))).count();
            return Err(format!("the surface is not closed: it has {open} open edges, the first {}", edge()));
        }
    }
    Ok(())
}

/// No triangle is so thin that its normal is lost in rounding.
fn check_areas(surface: &Triangles) -> Result<(), String> {
    const THINNEST: f64 = 1e-12;
    for (index, triangle) in surface.triangles.iter().enumerate() {
        let [a, b, c] = triangle.map(|v| Vector(surface.vertices[v as usize]));
        let longest = (b - a).norm_squared().max((c - b).norm_squared()).max((a - c).norm_squared());
        if (b - a).cross(c - a).norm() <= THINNEST * longest {
            return Err(format!("triangle {index} is degenerate: its corners lie on one line"));
        }
    }
    Ok(())
}

/// Divergence theorem: V = Σ a·(b × c)/6, about the first vertex.
fn enclosed_volume(surface: &Triangles) -> f64 {
    let origin = Vector(surface.vertices[0]);
    let tetrahedron = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| Vector(surface.vertices[v as usize]) - origin);
        a.dot(b.cross(c)) / 6.0
    };
    surface.triangles.iter().map(tetrahedron).sum()
}
