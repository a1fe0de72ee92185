//! Signed distance to a sheet: the closest point on its facets, with the side from their pseudo-normal
//! (Bærentzen & Aanæs 2005; theory D.3).
//!
//! Exact but not cheap: contact asks only when a particle comes near a sheet for the first time, and when
//! the distance that the nodes see (theory (D.5)) says that one has crossed.

use crate::geometry::SpatialBins;
use crate::geometry::closest_on_triangle;
use crate::math::Vector;
use crate::mpm::contact::facet::{SheetFacet, free_edges};
use hashbrown::HashSet;

/// The position of a point relative to a sheet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SheetPosition {
    /// Beside the sheet, at a signed distance [m], positive on the side that the normals point to.
    Beside(f64),
    /// Beyond a free edge.
    Beyond,
    /// Farther away than facets are searched.
    Away,
}

/// Displacement of the sheet after which its facets are binned anew [cells].
const SLACK: f64 = 0.5;

/// Distance within which facets are searched [cells].
const RANGE: i32 = 4;

/// Finds the facets near a point.
#[derive(Debug, Default)]
pub struct FacetLocator<const D: usize> {
    bins: SpatialBins<D>,
    binned: Vec<Vector<D>>,
    free_edges: HashSet<[u32; 2]>,
}

impl<const D: usize> FacetLocator<D> {
    /// The distance to these facets; edges that belong to one facet only are free edges.
    pub fn new(facets: &[SheetFacet]) -> Self {
        Self { bins: SpatialBins::default(), binned: Vec::new(), free_edges: free_edges(facets) }
    }

    /// True if the sheet has no free edges.
    pub fn is_closed(&self) -> bool {
        self.free_edges.is_empty()
    }

    /// Bins the facets again if the sheet has moved too far.
    pub fn refresh(&mut self, facets: &[SheetFacet], position: &[Vector<D>], cell: f64) {
        let moved = |(a, b): (&Vector<D>, &Vector<D>)| (*a - *b).norm() > SLACK * cell;
        if self.binned.len() == position.len() && !position.iter().zip(&self.binned).any(moved) {
            return;
        }
        self.binned = position.to_vec();
        self.bins.clear(cell);
        for (e, facet) in (0..).zip(facets) {
            let x = facet.corners(position);
            let lower = Vector::from_fn(|a| x.iter().map(|x| x[a]).fold(f64::INFINITY, f64::min));
            let upper = Vector::from_fn(|a| x.iter().map(|x| x[a]).fold(f64::NEG_INFINITY, f64::max));
            self.bins.add(e, lower, upper);
        }
    }

    /// The position of `x` [m] relative to the sheet, if that is at most a few cells away.
    pub fn locate(&self, facets: &[SheetFacet], position: &[Vector<D>], cell: f64, x: Vector<D>) -> SheetPosition {
        let centre = self.bins.bin(x);
        let mut best = Closest::default();
        let mut compared = HashSet::new();
        for range in 1..=RANGE {
            SpatialBins::for_each(centre.map(|i| i - range), centre.map(|i| i + range), |bin| {
                for &e in self.bins.of(&bin) {
                    if compared.insert(e) {
                        self.compare(&facets[e as usize], position, x, &mut best);
                    }
                }
            });
            if best.distance <= (f64::from(range) - SLACK) * cell {
                break;
            }
        }
        best.place(x)
    }

    fn compare(&self, facet: &SheetFacet, position: &[Vector<D>], x: Vector<D>, best: &mut Closest<D>) {
        let corners = facet.corners(position);
        let normal = facet.area(position).normalized().unwrap_or_default();
        let pieces: &[[usize; 3]] = match facet.count {
            2 => &[[0, 1, 1]],
            3 => &[[0, 1, 2]],
            _ => &[[0, 1, 2], [0, 2, 3]],
        };
        for piece in pieces {
            let weights = closest_on_triangle(piece.map(|k| corners[k]), x);
            let point = piece.iter().zip(weights).map(|(&k, w)| corners[k] * w).sum::<Vector<D>>();
            let border = self.on_free_edge(facet, *piece, weights);
            best.offer((x - point).norm(), point, normal, border);
        }
    }

    /// True if the point with these weights lies on a free edge.
    fn on_free_edge(&self, facet: &SheetFacet, piece: [usize; 3], weights: [f64; 3]) -> bool {
        if facet.count == 2 {
            return (0..2).any(|k| weights[k] == 1.0 && self.free_edges.contains(&[facet.nodes[piece[k]]; 2]));
        }
        (0..3).any(|k| {
            let [a, b] = [piece[(k + 1) % 3], piece[(k + 2) % 3]].map(|c| facet.nodes[c]);
            weights[k] == 0.0 && self.free_edges.contains(&[a.min(b), a.max(b)])
        })
    }
}

/// The closest point found so far; facets that share it add their normals.
struct Closest<const D: usize> {
    distance: f64,
    point: Vector<D>,
    normal: Vector<D>,
    border: bool,
}

impl<const D: usize> Default for Closest<D> {
    fn default() -> Self {
        Self { distance: f64::INFINITY, point: Vector::ZERO, normal: Vector::ZERO, border: false }
    }
}

impl<const D: usize> Closest<D> {
    fn offer(&mut self, distance: f64, point: Vector<D>, normal: Vector<D>, border: bool) {
        let tie = 1e-9 * distance;
        if distance < self.distance - tie {
            *self = Self { distance, point, normal, border };
        } else if distance <= self.distance + tie {
            self.normal += normal;
            self.border |= border;
        }
    }

    fn place(&self, x: Vector<D>) -> SheetPosition {
        if self.distance.is_infinite() {
            return SheetPosition::Away;
        }
        let height = (x - self.point).dot(self.normal);
        if self.border && height.abs() < 0.5 * self.distance * self.normal.norm() {
            return SheetPosition::Beyond;
        }
        SheetPosition::Beside(if height < 0.0 { -self.distance } else { self.distance })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place<const D: usize>(facets: &[SheetFacet], position: &[Vector<D>], x: Vector<D>) -> SheetPosition {
        let mut locator = FacetLocator::new(facets);
        locator.refresh(facets, position, 0.3);
        locator.locate(facets, position, 0.3, x)
    }

    /// A loop that runs counter-clockwise: outside is positive, also across its corners.
    #[test]
    fn the_side_of_a_loop_is_right_around_its_corners() {
        let position = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(Vector);
        let facets: Vec<_> = (0..4).map(|k| SheetFacet::new(&[k, (k + 1) % 4])).collect();
        for (x, expected) in
            [([0.9, 0.8], -0.1), ([1.1, 0.5], 0.1), ([1.03, 1.04], 0.05), ([0.97, 0.99], -0.01), ([-0.3, -0.4], 0.5)]
        {
            match place(&facets, &position, Vector(x)) {
                SheetPosition::Beside(d) => assert!((d - expected).abs() < 1e-12, "{x:?}: {d}"),
                other => panic!("{x:?}: {other:?}"),
            }
        }
        assert_eq!(place(&facets, &position, Vector([9.0, 9.0])), SheetPosition::Away);
    }

    /// Beside a square sheet the distance is the height; beyond its edge there is no side.
    #[test]
    fn free_edges_have_no_side() {
        let position = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]].map(Vector);
        for facets in
            [vec![SheetFacet::new(&[0, 1, 2, 3])], vec![SheetFacet::new(&[0, 1, 2]), SheetFacet::new(&[0, 2, 3])]]
        {
            assert_eq!(place(&facets, &position, Vector([0.5, 0.5, 0.25])), SheetPosition::Beside(0.25));
            assert_eq!(place(&facets, &position, Vector([0.25, 0.75, -0.25])), SheetPosition::Beside(-0.25));
            assert_eq!(place(&facets, &position, Vector([1.3, 0.5, 0.01])), SheetPosition::Beyond);
            assert_eq!(place(&facets, &position, Vector([0.999, 0.5, 0.2])), SheetPosition::Beside(0.2));
        }
    }
}
