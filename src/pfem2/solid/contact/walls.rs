//! Contact of solids with walls: their nodes keep a gap of half an element, in which fluid stays (theory J.8).
//!
//! ```text
//! d(x): distance from the wall,  n: its normal,  A_a = ∫ N_a dA,  k = 10 (λ + 2μ)/h
//! g = min(½ height of the element at the wall, d at the start):  gap;  half of that d for nodes beside a support
//! d(x*) near g:                          a candidate of node a, with the force of `force.rs`
//! d(x*) < g, or f_n > 0 in the last step:        it acts in the first solution of the step
//! ```
//!
//! Which of the candidates act in the end is found in the step, (J.11a): none pulls (`unilateral.rs`, `impulses.rs`).

use super::force::{ContactCandidate, ContactLaw, GAP, REACH, gap_scale};
use super::places::{ContactPlaces, NodeArea, node_areas};
use crate::geometry::closest_on_triangle;
use crate::math::Vector;
use crate::mesh::Mesh;
use crate::pfem2::boundary::{Boundary, BoundaryKind};
use crate::pfem2::solid::structure::Structure;
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};

/// Cosine of the angle of normals from which facets count as one wall.
const SAME_WALL_COSINE: f64 = 0.8;

/// Cosine of the angle to the normal up to which a place is straight over a facet.
const STRAIGHT_COSINE: f64 = 1.0 - 1e-9;

/// Distance from a wall, over its gap, that is rounding.
const ROUNDING: f64 = 1e-9;

/// Distance from a node that is held, over the distance from the wall, within which a node is beside the support
/// (theory J.8).
const BESIDE: f64 = 1.5;

/// The walls of a mesh.
#[derive(Debug)]
pub struct MeshWalls<const D: usize> {
    facets: Vec<WallFacet<D>>,
    boxes: RTree<GeomWithData<Rectangle<[f64; D]>, u32>>,
    /// The largest gap [m].
    largest: f64,
}

/// A facet of a wall.
#[derive(Debug)]
struct WallFacet<const D: usize> {
    /// Corners [m]; the last of a segment twice.
    corners: [Vector<D>; 3],
    /// Unit normal into the fluid.
    normal: Vector<D>,
    /// Gap that solids keep [m].
    gap: f64,
}

/// A wall near a place.
#[derive(Debug, Clone, Copy, PartialEq)]
struct NearWall<const D: usize> {
    /// Distance [m], negative behind it.
    distance: f64,
    /// Unit normal, away from it.
    normal: Vector<D>,
    /// Gap that solids keep [m].
    gap: f64,
    /// True where the place lies straight over, or behind, the facet.
    over: bool,
}

/// A node on the surface of a solid that may touch walls.
#[derive(Debug, Clone, Copy)]
struct SurfaceNode {
    node: u32,
    /// A_a [m²].
    area: f64,
    law: ContactLaw,
    /// Coefficient of friction.
    friction: f64,
    /// The gap that it keeps at most [m].
    gap: f64,
}

/// A facet of a rigid solid, which may touch walls between its nodes: else it would roll on these as a wheel on its
/// spokes.
#[derive(Debug, Clone, Copy)]
struct RigidFacet {
    /// Among the facets of all solids.
    facet: u32,
    law: ContactLaw,
    /// Coefficient of friction.
    friction: f64,
    /// The gap that it keeps at most [m].
    gap: f64,
}

/// Contact of the solids of a run with walls.
#[derive(Debug)]
pub struct WallContacts<const D: usize> {
    walls: MeshWalls<D>,
    nodes: Vec<SurfaceNode>,
    rigid_facets: Vec<RigidFacet>,
}

impl<const D: usize> MeshWalls<D> {
    /// The walls and slip walls of a mesh.
    pub fn new<const N: usize>(mesh: &Mesh<D, N>, boundary: &Boundary<D>) -> Self {
        let is_wall = |kind: &BoundaryKind| !kind.admits_flow();
        let walls = mesh.boundary().iter().zip(&boundary.kinds).filter(|(_, kind)| is_wall(kind));
        let facets: Vec<WallFacet<D>> = walls
            .map(|(&facet, _)| {
                let nodes = mesh.facet_nodes(facet);
                let area = mesh.facet_area(facet);
                let height = D as f64 * mesh.simplex(facet.element as usize).volume / area.norm();
                let corner = |k: usize| mesh.nodes()[nodes[k.min(nodes.len() - 1)] as usize];
                WallFacet {
                    corners: std::array::from_fn(corner),
                    normal: area * -area.norm().recip(),
                    gap: GAP * height,
                }
            })
            .collect();
        let entry = |(n, facet): (u32, &WallFacet<D>)| {
            let side = |pick: fn(f64, f64) -> f64| -> [f64; D] {
                std::array::from_fn(|i| facet.corners.iter().map(|x| x[i]).reduce(pick).unwrap_or(f64::NAN))
            };
            GeomWithData::new(Rectangle::from_corners(side(f64::min), side(f64::max)), n)
        };
        let boxes = RTree::bulk_load((0..).zip(&facets).map(entry).collect());
        let largest = facets.iter().fold(0.0, |most: f64, facet| most.max(facet.gap));
        Self { facets, boxes, largest }
    }

    /// Walls nearer than `reach` [m] to a place, the nearest first; facets with about the same normal are one wall.
    /// Edges count where they are nearest: others belong to walls that go on there, or are the far side of a corner.
    fn near(&self, x: Vector<D>, reach: f64) -> Vec<NearWall<D>> {
        if !x.is_finite() {
            return Vec::new();
        }
        let around = AABB::from_corners((x - Vector::splat(reach)).0, (x + Vector::splat(reach)).0);
        let mut facets: Vec<u32> = self.boxes.locate_in_envelope_intersecting(around).map(|entry| entry.data).collect();
        facets.sort_unstable();
        let at = |&n: &u32| self.facets[n as usize].at(x);
        let mut all: Vec<NearWall<D>> = facets.iter().map(at).filter(|wall| wall.distance.abs() < reach).collect();
        all.sort_by(|a, b| a.distance.abs().total_cmp(&b.distance.abs()));
        let mut walls: Vec<NearWall<D>> = Vec::new();
        for wall in all {
            if !walls.is_empty() && !wall.over {
                continue;
            }
            if walls.iter().all(|other| other.normal.dot(wall.normal) < SAME_WALL_COSINE) {
                walls.push(wall);
            }
        }
        walls
    }
}

impl<const D: usize> WallFacet<D> {
    fn at(&self, x: Vector<D>) -> NearWall<D> {
        let weights = closest_on_triangle(self.corners, x);
        let closest: Vector<D> = self.corners.iter().zip(weights).map(|(corner, weight)| *corner * weight).sum();
        let away = x - closest;
        // A point on the wall is not beside the facet, whatever rounding says.
        let away = if away.norm() > ROUNDING * self.gap { away } else { Vector::ZERO };
        let (distance, gap) = (away.norm(), self.gap);
        let side = away.dot(self.normal);
        let over = side.abs() >= STRAIGHT_COSINE * distance;
        // Beside the facet the wall ends in an edge or goes on in another facet.
        match away.normalized() {
            Some(direction) if side > 0.0 => NearWall { distance, normal: direction, gap, over },
            Some(_) if side < 0.0 => NearWall { distance: -distance, normal: self.normal, gap, over },
            Some(_) => NearWall { distance: f64::INFINITY, normal: self.normal, gap, over },
            None => NearWall { distance, normal: self.normal, gap, over },
        }
    }
}

impl<const D: usize> WallContacts<D> {
    /// Contact of solids in their reference state. Nodes of a supported solid that start nearer to a wall than the gap
    /// belong to its support and touch nothing; those of others keep the distance that they start with. Next to
    /// a support at the wall nodes keep half of it: a solid that is compressed there brings them nearer.
    pub fn new<const N: usize>(structure: &Structure<D>, mesh: &Mesh<D, N>, boundary: &Boundary<D>) -> Self {
        let walls = MeshWalls::new(mesh, boundary);
        let mut nodes = Vec::new();
        for (solid, setup) in structure.setups().iter().enumerate() {
            let (own, first) = structure.meshes()[solid];
            let held: Vec<Vector<D>> =
                setup.held.iter().flat_map(|held| &held.nodes).map(|&a| own.nodes[a as usize]).collect();
            let mass = structure.mass_of(solid);
            for NodeArea { node, area, size } in node_areas(setup) {
                let place = own.nodes[node as usize];
                let start = walls.near(place, 2.0 * walls.largest);
                let distance = start.iter().fold(f64::INFINITY, |least: f64, wall| least.min(wall.distance));
                if !held.is_empty() && start.iter().any(|wall| wall.distance < wall.gap) {
                    continue;
                }
                let beside_support = held.iter().any(|x| (*x - place).norm() < BESIDE * distance);
                let gap = if beside_support { 0.5 * distance } else { distance };
                let law = ContactLaw::new(structure, setup, mass, size);
                let friction = setup.friction;
                nodes.push(SurfaceNode { node: first + node, area, law, friction, gap });
            }
        }
        let rigid_facets = rigid_facets(structure, &nodes);
        Self { walls, nodes, rigid_facets }
    }

    /// The places where solids may touch walls in a step. Points are nodes, and then facets.
    pub(super) fn candidates(&self, places: &ContactPlaces<'_, D>) -> Vec<ContactCandidate<D>> {
        let mut candidates = Vec::new();
        for &SurfaceNode { node, area, law, friction, gap } in &self.nodes {
            let x = places.predicted[node as usize];
            let reach = REACH * self.walls.largest + (x - places.start[node as usize]).norm();
            candidates.extend(self.walls.near(x, reach).into_iter().map(|wall| ContactCandidate {
                point: node as usize,
                coefficients: vec![(node, 1.0)],
                normal: wall.normal,
                distance: wall.distance,
                gap: gap.min(wall.gap),
                scale: gap_scale(gap.min(wall.gap), wall.gap),
                area,
                law,
                friction,
            }));
        }
        self.rigid_facets.iter().for_each(|facet| self.add_between_nodes(facet, places, &mut candidates));
        candidates
    }

    /// Adds the places where a facet of a rigid solid may touch walls between its nodes.
    fn add_between_nodes(
        &self,
        rigid: &RigidFacet,
        places: &ContactPlaces<'_, D>,
        candidates: &mut Vec<ContactCandidate<D>>,
    ) {
        let &RigidFacet { facet, law, friction, gap } = rigid;
        let (size, middle) = places.surface.size_and_middle(facet);
        let x = places.predicted[middle as usize];
        let reach = REACH * self.walls.largest + (x - places.start[middle as usize]).norm();
        for around in self.walls.near(x, reach + size) {
            let Some((lowest, coefficients)) = places.surface.lowest(facet, around.normal) else { continue };
            let same = |wall: &NearWall<D>| wall.normal.dot(around.normal) > SAME_WALL_COSINE;
            let Some(wall) = self.walls.near(lowest, reach).into_iter().find(same) else { continue };
            candidates.push(ContactCandidate {
                point: places.predicted.len() + facet as usize,
                coefficients,
                normal: wall.normal,
                distance: wall.distance,
                gap: gap.min(wall.gap),
                scale: gap_scale(gap.min(wall.gap), wall.gap),
                area: 0.0,
                law,
                friction,
            });
        }
    }
}

/// Facets of rigid solids all of whose nodes may touch walls.
fn rigid_facets<const D: usize>(structure: &Structure<D>, nodes: &[SurfaceNode]) -> Vec<RigidFacet> {
    let (mut found, mut facet) = (Vec::new(), 0);
    for (setup, (mesh, first)) in structure.setups().iter().zip(structure.meshes()) {
        for own in &mesh.facets {
            let of = |node: &u32| nodes.binary_search_by_key(&(first + node), |own| own.node).ok().map(|k| nodes[k]);
            let touching: Option<Vec<SurfaceNode>> = own.nodes.iter().map(of).collect();
            if let Some(touching) = touching.filter(|_| setup.law.is_rigid()) {
                let gap = touching.iter().fold(f64::INFINITY, |least: f64, node| least.min(node.gap));
                let SurfaceNode { law, friction, .. } = touching[0];
                found.push(RigidFacet { facet, law, friction, gap });
            }
            facet += 1;
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square without its lower right quarter, whose corner stands out into the fluid at (½, ½).
    fn step() -> MeshWalls<2> {
        let block = Mesh::<2, 3>::block(Vector::ZERO, Vector([1.0, 1.0]), [8, 8]).unwrap();
        let kept = |e: &usize| block.center(*e)[0] < 0.5 || block.center(*e)[1] > 0.5;
        let elements: Vec<[u32; 3]> = (0..block.elements().len()).filter(kept).map(|e| block.elements()[e]).collect();
        let mut used: Vec<u32> = elements.iter().flatten().copied().collect();
        used.sort_unstable();
        used.dedup();
        let number = |node: u32| used.binary_search(&node).unwrap() as u32;
        let nodes = used.iter().map(|&node| block.nodes()[node as usize]).collect();
        let mesh = Mesh::new(nodes, elements.into_iter().map(|nodes| nodes.map(number)).collect()).unwrap();
        let boundary = Boundary::new(&mesh, Vec::new(), Vector([0.0, -1.0]));
        MeshWalls::new(&mesh, &boundary)
    }

    /// Over a wall that ends at a corner a place meets this wall alone, before the corner the corner, and in a corner
    /// of the box both walls.
    #[test]
    fn a_place_meets_the_walls_that_it_lies_over() {
        let walls = step();
        let near = |x: [f64; 2]| {
            let all = walls.near(Vector(x), 0.125).into_iter();
            all.map(|wall| (wall.normal, wall.distance)).collect::<Vec<_>>()
        };
        let [(normal, distance)] = near([0.53, 0.55])[..] else { panic!("{:?}", near([0.53, 0.55])) };
        assert!((normal - Vector([0.0, 1.0])).norm() < 1e-12 && (distance - 0.05).abs() < 1e-12);
        let [(normal, distance)] = near([0.47, 0.54])[..] else { panic!("{:?}", near([0.47, 0.54])) };
        assert!((normal - Vector([-0.6, 0.8])).norm() < 1e-12 && (distance - 0.05).abs() < 1e-12);
        assert_eq!(near([0.05, 0.95]).len(), 2);
        assert_eq!(near([0.3, 0.3]).len(), 0);
    }

    /// The closest point on a facet is off by rounding along it: what lies on the wall has its normal.
    #[test]
    fn places_on_a_wall_are_on_it_to_rounding() {
        let walls = step();
        for k in 1..1000 {
            let x = f64::from(k) / 2001.0;
            for place in [[x, 0.0], [0.0, 0.5 + x], [x + 1e-17, 1.0]] {
                let all = walls.near(Vector(place), 0.01);
                assert!(
                    matches!(all[..], [wall, ..] if wall.distance.abs() < 1e-15 && wall.over),
                    "{place:?}: {all:?}"
                );
            }
        }
    }
}
