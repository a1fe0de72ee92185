//! Nodes of a sheet, and points of its elements, near a wall or an obstacle (theory E.10).

use super::REACH;
use super::contact_point::RigidContact;
use crate::math::Vector;
use crate::mpm::SubStep;
use crate::mpm::contact::facet::SheetFacet;
use crate::mpm::contact::impulse::Impulse;
use crate::mpm::contact::surface::SheetSurface;
use crate::mpm::wall::RigidBoundary;

/// A sheet counts as at least this thick where overlaps are undone [element sizes].
const THIN: f64 = 0.02;

/// An element of size L may cut this deep into what is curved [L]: its nodes lie on a surface whose radius is above 2
/// L.
const SAGITTA: f64 = 1.0 / 16.0;

/// Points of a segment, a triangle and a quadrilateral besides the nodes: weights of the corners.
const ON_SEGMENT: [[f64; 4]; 3] = [[0.75, 0.25, 0.0, 0.0], [0.5, 0.5, 0.0, 0.0], [0.25, 0.75, 0.0, 0.0]];
const ON_TRIANGLE: [[f64; 4]; 4] =
    [[0.5, 0.5, 0.0, 0.0], [0.0, 0.5, 0.5, 0.0], [0.5, 0.0, 0.5, 0.0], [1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0, 0.0]];
const ON_QUADRILATERAL: [[f64; 4]; 5] =
    [[0.5, 0.5, 0.0, 0.0], [0.0, 0.5, 0.5, 0.0], [0.0, 0.0, 0.5, 0.5], [0.5, 0.0, 0.0, 0.5], [0.25; 4]];

/// A point of a sheet that may touch a solid.
struct SheetPoint {
    nodes: [u32; 4],
    weights: [f64; 4],
    /// Depth to which it may lie in the solid [m].
    depth: f64,
    /// Size of the element [m].
    size: f64,
}

/// Areas and thicknesses around the nodes of a sheet.
pub struct NodeAreas<const D: usize> {
    /// Sum of the area vectors, and of their sizes [m²].
    area: Vec<Vector<D>>,
    size: Vec<f64>,
    /// Mean half thickness times the sum of areas [m³], and of element sizes [m].
    thickness: Vec<f64>,
    length: Vec<f64>,
}

impl<const D: usize> NodeAreas<D> {
    pub fn of(facets: &[SheetFacet], surface: &SheetSurface<'_, D>) -> Self {
        let count = surface.position.len();
        let zeros = || vec![0.0; count];
        let mut nodes = Self { area: vec![Vector::ZERO; count], size: zeros(), thickness: zeros(), length: zeros() };
        for (e, facet) in facets.iter().enumerate() {
            let (area, half) = (facet.area(surface.position), surface.offset.get(e).copied().unwrap_or(0.0));
            let (size, length) = (area.norm(), facet.size(surface.position));
            for &k in facet.nodes() {
                let k = k as usize;
                nodes.area[k] += area;
                nodes.size[k] += size;
                nodes.thickness[k] += half * size;
                nodes.length[k] = nodes.length[k].max(length);
            }
        }
        nodes
    }

    /// ½ t |n·ν| at a node; where the sheet is folded, it lies along everything [m].
    fn offset(&self, k: usize, normal: Vector<D>) -> f64 {
        let (area, size) = (self.area[k], self.size[k]);
        if size == 0.0 {
            return 0.0;
        }
        let along = if area.norm() > FOLDED * size { area.dot(normal).abs() / area.norm() } else { 1.0 };
        self.thickness[k] / size * along
    }

    /// A node, if it is near.
    pub fn contact_at_node(
        &self,
        solid: RigidBoundary<'_, D>,
        k: usize,
        surface: &SheetSurface<'_, D>,
        at: &SubStep<'_>,
        cell: f64,
    ) -> Option<RigidContact<D>> {
        let weights = [1.0, 0.0, 0.0, 0.0];
        let point = SheetPoint { nodes: [k as u32; 4], weights, depth: 0.0, size: self.length[k] };
        self.contact_at(solid, point, surface, at, cell)
    }

    /// Points of an element that are near.
    pub fn contacts_within(
        &self,
        solid: RigidBoundary<'_, D>,
        facet: &SheetFacet,
        surface: &SheetSurface<'_, D>,
        at: &SubStep<'_>,
        cell: f64,
    ) -> Vec<RigidContact<D>> {
        let points: &[[f64; 4]] = match facet.count {
            2 => &ON_SEGMENT,
            3 => &ON_TRIANGLE,
            _ => &ON_QUADRILATERAL,
        };
        let size = facet.size(surface.position);
        let of_point = |&weights: &[f64; 4]| {
            let point = SheetPoint { nodes: facet.nodes, weights, depth: SAGITTA * size, size };
            self.contact_at(solid, point, surface, at, cell)
        };
        points.iter().filter_map(of_point).collect()
    }

    /// A point, if it is near.
    fn contact_at(
        &self,
        solid: RigidBoundary<'_, D>,
        SheetPoint { nodes, weights, depth, size }: SheetPoint,
        surface: &SheetSurface<'_, D>,
        at: &SubStep<'_>,
        cell: f64,
    ) -> Option<RigidContact<D>> {
        let mean = |values: &[Vector<D>]| -> Vector<D> {
            nodes.iter().zip(weights).map(|(&k, weight)| values[k as usize] * weight).sum()
        };
        let x = mean(surface.position);
        let wall = solid.velocity(x, at.step);
        let ahead = wall * at.elapsed;
        let (distance, normal) = solid.distance(x, ahead);
        let half: f64 = nodes.iter().zip(weights).map(|(&k, weight)| self.offset(k as usize, normal) * weight).sum();
        let offset = half - depth;
        (distance - offset <= REACH * cell).then(|| RigidContact {
            solid: solid.number() as u32,
            nodes,
            weights,
            offset,
            half_thickness: half.max(THIN * size),
            normal,
            measured: distance - offset,
            anchor: x - ahead,
            gap: distance - offset,
            wall,
            friction: 0.0,
            impulse: Impulse::default(),
            applied: Vector::ZERO,
        })
    }
}

/// Fraction of the area below which a vector area is that of a folded sheet.
const FOLDED: f64 = 0.1;
