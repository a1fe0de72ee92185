//! Closed triangulated surfaces.
//!
//! The sign of the distance is that of (x − closest point)·ñ, where ñ is the angle-weighted pseudo-normal
//! of the nearest face, edge or vertex (Baerentzen & Aanaes 2005), which is right for every closed surface.

use super::Triangles;
use super::closest::closest_on_triangle;
use super::primitive::{Distance, direction};
use crate::math::Vector;
use hashbrown::HashMap;
use rstar::{AABB, PointDistance, RTree, RTreeObject};
use std::path::Path;

/// A closed triangulated surface with outward normals, ready for distance queries.
#[derive(Debug, Clone)]
pub struct Surface {
    triangles: Triangles,
    volume: f64,
    facets: RTree<IndexedTriangle>,
    normals: PseudoNormals,
}

/// A triangle, or with two equal corners a segment, in the search for the nearest one.
#[derive(Debug, Clone)]
pub(crate) struct IndexedTriangle {
    /// Its number among all of its surface.
    pub index: usize,
    /// Corners [m].
    pub corners: [Vector<3>; 3],
}

/// Directions outward at faces, edges and vertices; those of edges and vertices aren't of unit length.
#[derive(Debug, Clone)]
struct PseudoNormals {
    faces: Vec<Vector<3>>,
    /// By their two vertices, ascending: the sum of those of the two faces.
    edges: HashMap<[u32; 2], Vector<3>>,
    /// The sum of those of the faces around, weighted with the angles there.
    vertices: Vec<Vector<3>>,
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
        let corners = |t: &[u32; 3]| t.map(|v| Vector(surface.vertices[v as usize]));
        let facet = |(index, t)| IndexedTriangle { index, corners: corners(t) };
        let facets = RTree::bulk_load(surface.triangles.iter().enumerate().map(facet).collect());
        let normals = PseudoNormals::new(&surface);
        Ok(Self { triangles: surface, volume, facets, normals })
    }

    /// Volume enclosed [m³].
    pub fn volume(&self) -> f64 {
        self.volume
    }

    /// Its vertices [m].
    pub fn vertices(&self) -> impl Iterator<Item = [f64; 3]> + '_ {
        self.triangles.vertices.iter().copied()
    }

    /// Its triangles, counter-clockwise seen from outside.
    pub fn triangles(&self) -> Triangles {
        self.triangles.clone()
    }

    /// Number of triangles.
    pub fn triangle_count(&self) -> usize {
        self.triangles.triangles.len()
    }

    /// Signed distance [m], below zero inside, and outward unit normal at `x` [m].
    pub(crate) fn distance(&self, x: Vector<3>) -> Distance {
        let Some(nearest) = self.facets.nearest_neighbor(x.0) else { return (f64::INFINITY, Vector::unit(0)) };
        let weights = closest_on_triangle(nearest.corners, x);
        let away = x - nearest.point(weights);
        let outward = self.normals.at(self.triangles.triangles[nearest.index], nearest.index, weights);
        let sign = if away.dot(outward) < 0.0 { -1.0 } else { 1.0 };
        let d = away.norm();
        let face = self.normals.faces[nearest.index];
        (sign * d, if d > 0.0 { direction(away * sign, face) } else { face })
    }
}

impl IndexedTriangle {
    /// Its place nearest to `x` [m].
    pub fn nearest(&self, x: Vector<3>) -> Vector<3> {
        self.point(closest_on_triangle(self.corners, x))
    }

    fn point(&self, weights: [f64; 3]) -> Vector<3> {
        let [a, b, c] = self.corners;
        a * weights[0] + b * weights[1] + c * weights[2]
    }
}

impl RTreeObject for IndexedTriangle {
    type Envelope = AABB<[f64; 3]>;

    fn envelope(&self) -> Self::Envelope {
        AABB::from_points(&self.corners.map(|corner| corner.0))
    }
}

impl PointDistance for IndexedTriangle {
    fn distance_2(&self, x: &[f64; 3]) -> f64 {
        let x = Vector(*x);
        (x - self.nearest(x)).norm_squared()
    }
}

impl PseudoNormals {
    fn new(surface: &Triangles) -> Self {
        let mut edges: HashMap<[u32; 2], Vector<3>> = HashMap::new();
        let mut vertices = vec![Vector::ZERO; surface.vertices.len()];
        let mut faces = Vec::with_capacity(surface.triangles.len());
        for triangle in &surface.triangles {
            let corners = triangle.map(|v| Vector(surface.vertices[v as usize]));
            let face = direction((corners[1] - corners[0]).cross(corners[2] - corners[0]), Vector::unit(0));
            faces.push(face);
            for k in 0..3 {
                let (next, last) = ((k + 1) % 3, (k + 2) % 3);
                *edges.entry(ascending(triangle[k], triangle[next])).or_insert(Vector::ZERO) += face;
                let (along, back) = (corners[next] - corners[k], corners[last] - corners[k]);
                vertices[triangle[k] as usize] += face * along.cross(back).norm().atan2(along.dot(back));
            }
        }
        Self { faces, edges, vertices }
    }

    /// At the place of triangle `index` with these barycentric weights.
    fn at(&self, triangle: [u32; 3], index: usize, weights: [f64; 3]) -> Vector<3> {
        if let Some(corner) = weights.iter().position(|&w| w == 1.0) {
            self.vertices[triangle[corner] as usize]
        } else if let Some(opposite) = weights.iter().position(|&w| w == 0.0) {
            self.edges[&ascending(triangle[(opposite + 1) % 3], triangle[(opposite + 2) % 3])]
        } else {
            self.faces[index]
        }
    }
}

fn ascending(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
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
