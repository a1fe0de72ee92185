//! Normals where facets meet, by which a place is outside or inside (Baerentzen & Aanaes 2005).
//!
//! ```text
//! line end in 2D   Σ n_f           edge of two patches   n_f + n_g           corner of patches   Σ α_f n_f
//! ```
//!
//! α_f: angle of the patch at the corner. The vector from the nearest point of a closed surface to a place has
//! a positive product with this normal if and only if the place is outside.

use super::facet::SurfaceFacet;
use crate::math::Vector;

/// No facet.
const NONE: u32 = u32::MAX;

/// Normals at corners, and facets on both sides of edges.
#[derive(Debug, Clone)]
pub struct Normals<const D: usize> {
    /// Sum over facets with a corner at each global node.
    corner: Vec<Vector<D>>,
    /// Patches that meet at each global node in the middle of an edge.
    edge: Vec<[u32; 2]>,
}

/// Local nodes in the middle of a patch's sides.
const SIDES: [usize; 4] = [1, 3, 5, 7];

/// First and last local node of a side, by the local node in its middle.
fn ends(middle: usize) -> [usize; 2] {
    match middle {
        1 => [0, 2],
        3 => [0, 6],
        5 => [2, 8],
        _ => [6, 8],
    }
}

/// Coordinates of a point of a side, `along` from its first to its last node.
fn on_side(middle: usize, along: f64) -> [f64; 2] {
    match middle {
        1 => [along, -1.0],
        3 => [-1.0, along],
        5 => [1.0, along],
        _ => [along, 1.0],
    }
}

impl<const D: usize> Normals<D> {
    /// Normals of all facets; `nodes`: number of global nodes.
    pub fn new(facets: &[SurfaceFacet<D>], nodes: usize) -> Self {
        let mut made = Self { corner: vec![Vector::ZERO; nodes], edge: Vec::new() };
        if D == 3 {
            made.edge = vec![[NONE; 2]; nodes];
        }
        for (f, facet) in (0u32..).zip(facets) {
            for (a, local) in corners::<D>() {
                made.corner[facet.nodes[a] as usize] += facet.normal(local) * angle(facet, local);
            }
            for middle in SIDES.into_iter().filter(|_| D == 3) {
                let [first, second] = &mut made.edge[facet.nodes[middle] as usize];
                *if *first == NONE { first } else { second } = f;
            }
        }
        made
    }

    /// The outward normal at a point of a facet, that of all facets which meet there; not a unit vector.
    pub fn at(&self, facets: &[SurfaceFacet<D>], f: u32, local: [f64; 2]) -> Vector<D> {
        let facet = &facets[f as usize];
        let end = local.map(|s| s.abs() >= 1.0);
        match (D, end) {
            (2, [true, _]) => self.corner[facet.nodes[if local[0] < 0.0 { 0 } else { 2 }] as usize],
            (3, [true, true]) => {
                let index = |s: f64| if s < 0.0 { 0 } else { 2 };
                self.corner[facet.nodes[index(local[0]) + 3 * index(local[1])] as usize]
            }
            (3, [true, false]) => self.across(facets, f, if local[0] < 0.0 { 3 } else { 5 }, local[1]),
            (3, [false, true]) => self.across(facets, f, if local[1] < 0.0 { 1 } else { 7 }, local[0]),
            _ => facet.normal(local),
        }
    }

    /// The normals of the two patches at a point of the edge between them.
    fn across(&self, facets: &[SurfaceFacet<D>], f: u32, middle: usize, along: f64) -> Vector<D> {
        let facet = &facets[f as usize];
        let own = facet.normal(on_side(middle, along));
        let [a, b] = self.edge[facet.nodes[middle] as usize];
        let Some(other) = facets.get(if a == f { b } else { a } as usize) else { return own };
        let side = SIDES.into_iter().find(|&side| other.nodes[side] == facet.nodes[middle]);
        let Some(side) = side else { return own };
        let same = other.nodes[ends(side)[0]] == facet.nodes[ends(middle)[0]];
        own + other.normal(on_side(side, if same { along } else { -along }))
    }
}

/// Local nodes and coordinates of a facet's corners.
fn corners<const D: usize>() -> impl Iterator<Item = (usize, [f64; 2])> {
    let rows: &[(usize, f64)] = if D == 3 { &[(0, -1.0), (6, 1.0)] } else { &[(0, 0.0)] };
    rows.iter().flat_map(|&(first, t)| [(first, [-1.0, t]), (first + 2, [1.0, t])])
}

/// Angle of a patch at one of its corners; one in 2D.
fn angle<const D: usize>(facet: &SurfaceFacet<D>, local: [f64; 2]) -> f64 {
    if D == 2 {
        return 1.0;
    }
    let [a, b] = facet.tangents(local).map(|tangent| tangent.normalized().unwrap_or_default());
    // The sides leave the corner against the coordinates that end there.
    (a.dot(b) * local[0] * local[1]).clamp(-1.0, 1.0).acos()
}
