//! Spheres: the cube blown up, and the subdivided icosahedron.

use super::{BuildFacets, ElementKind, Facets, Quad, divisions, finite, only, positive};
use crate::error::Diagnostic;
use crate::math::Vector;
use hashbrown::HashMap;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::FRAC_PI_4;
use std::path::Path;

/// A sphere with outward normals: a cube blown up at equal angles (quadrilaterals, union-jack) or a
/// subdivided icosahedron (triangles). Closed: it has no edges.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SphereMeshShape {
    /// Centre [m].
    #[schemars(extend("unit" = "m"))]
    pub center: [f64; 3],
    /// Radius of the nodes [m].
    #[schemars(extend("unit" = "m", "exclusiveMinimum" = 0.0))]
    pub radius: f64,
    /// Elements along an edge of the cube or icosahedron: 6 n² quadrilaterals, 12 n² or 20 n² triangles.
    pub divisions: usize,
    /// Elements.
    #[serde(default)]
    pub elements: ElementKind,
}

impl BuildFacets for SphereMeshShape {
    fn build(&self, _: &Path, dimension: usize) -> Result<Facets, Diagnostic> {
        only(dimension, 3, "in 2D use `shape = \"circle\"`")?;
        let center = Vector(finite("center", self.center)?);
        let radius = positive("radius", self.radius)?;
        let [count] = divisions("divisions", [self.divisions], 1)?;
        divisions("divisions", [20 * count, count], 1)?;
        let UnitSphere { directions, elements } = match self.elements {
            ElementKind::Triangles => icosahedron(count),
            kind => cube(count, kind),
        };
        let nodes = directions.into_iter().map(|direction| (center + direction * radius).0).collect();
        Ok(Facets { nodes, elements, ..Facets::default() })
    }
}

/// A mesh of the unit sphere.
struct UnitSphere {
    /// Directions of the nodes from the centre, unit vectors.
    directions: Vec<Vector<3>>,
    /// Nodes of the elements.
    elements: Vec<Vec<u32>>,
}

/// Gives every place a number and its direction, in the order of first use.
struct Numbering<Place> {
    known: HashMap<Place, u32>,
    directions: Vec<Vector<3>>,
}

impl<Place: std::hash::Hash + Eq> Numbering<Place> {
    fn new() -> Self {
        Self { known: HashMap::new(), directions: Vec::new() }
    }

    fn number(&mut self, place: Place, point: impl FnOnce(&Place) -> Vector<3>) -> u32 {
        if let Some(&number) = self.known.get(&place) {
            return number;
        }
        let point = point(&place);
        self.directions.push(point / point.norm());
        let number = self.directions.len() as u32 - 1;
        self.known.insert(place, number);
        number
    }
}

fn cube(n: usize, kind: ElementKind) -> UnitSphere {
    let mut numbering = Numbering::new();
    let coordinate = |i: usize| ((2.0 * i as f64 / n as f64 - 1.0) * FRAC_PI_4).tan();
    let mut quads = Vec::new();
    for (axis, end) in (0..3).flat_map(|axis| [(axis, 0), (axis, n)]) {
        let (u, v) = if end == n { ((axis + 1) % 3, (axis + 2) % 3) } else { ((axis + 2) % 3, (axis + 1) % 3) };
        for (j, i) in (0..n).flat_map(|j| (0..n).map(move |i| (j, i))) {
            let nodes = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| {
                let mut place = [end; 3];
                (place[u], place[v]) = (i, j);
                numbering.number(place, |place| Vector(place.map(coordinate)))
            });
            quads.push(Quad { nodes, even: (i + j) % 2 == 0 });
        }
    }
    UnitSphere { directions: numbering.directions, elements: kind.cut(quads.into_iter()) }
}

fn icosahedron(n: usize) -> UnitSphere {
    let corner = icosahedron_corners();
    let mut numbering = Numbering::new();
    let mut elements = Vec::with_capacity(20 * n * n);
    for face in ICOSAHEDRON_FACES {
        // A node is named by the corners that it lies between and their weights, alike from every face.
        let mut node = |i: usize, j: usize| {
            let mut place = [(face[0], n - i - j), (face[1], i), (face[2], j)];
            place.sort_unstable_by_key(|&(corner, weight)| (weight == 0, corner));
            let place = place.map(|(corner, weight)| if weight == 0 { (0, 0) } else { (corner, weight) });
            numbering.number(place, |place| place.iter().map(|&(c, weight)| corner[c] * weight as f64).sum())
        };
        for (i, j) in (0..n).flat_map(|i| (0..n - i).map(move |j| (i, j))) {
            elements.push(vec![node(i, j), node(i + 1, j), node(i, j + 1)]);
            if i + j + 1 < n {
                elements.push(vec![node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)]);
            }
        }
    }
    UnitSphere { directions: numbering.directions, elements }
}

/// (0, ±1, ±φ) and its cyclic permutations, φ the golden ratio.
fn icosahedron_corners() -> [Vector<3>; 12] {
    let golden = 0.5 * (1.0 + 5f64.sqrt());
    std::array::from_fn(|c| {
        let (axis, one, phi) = (c / 4, if c & 1 == 0 { 1.0 } else { -1.0 }, if c & 2 == 0 { golden } else { -golden });
        let mut corner = Vector::ZERO;
        (corner[(axis + 1) % 3], corner[(axis + 2) % 3]) = (one, phi);
        corner
    })
}

/// Its faces, counter-clockwise seen from outside.
#[rustfmt::skip]
const ICOSAHEDRON_FACES: [[usize; 3]; 20] = [
    [0, 1, 4], [0, 6, 1], [0, 4, 8], [0, 9, 6], [0, 8, 9],
    [1, 10, 4], [1, 6, 11], [1, 11, 10], [2, 5, 3], [2, 3, 7],
    [2, 8, 5], [2, 7, 9], [2, 9, 8], [3, 5, 10], [3, 11, 7],
    [3, 10, 11], [4, 5, 8], [4, 10, 5], [6, 9, 7], [6, 7, 11],
];
