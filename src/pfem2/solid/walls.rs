//! Contact of solids with walls: their nodes keep a gap of half an element, in which fluid stays (theory J.8).
//!
//! ```text
//! d(x): distance from the wall,  n: its normal,  g: gap,  A_a = ∫ N_a dA,  k = 10 (λ + 2μ)/h
//! d(x*) < g, or f_n > 0 in the last step:
//!               f_a = A_a k (g − d(u_aⁿ⁺¹)) n − c (1 − n ⊗ n) v_a,    d(uⁿ⁺¹) = d(u*) + n·(û + Δ v − u*)
//! c = μ_c f_n/max(|v_t|, ε),   f_n: normal force of the last step,   v_t: 2 vⁿ − vⁿ⁻¹ along the wall,   ε = 10⁻⁴ g/Δt
//! ```
//!
//! Linear in v, as all of the step: whether a node touches is told by the prediction. A force that would pull ends with the next step.

use super::setup::SolidSetup;
use super::structure::Structure;
use crate::geometry::closest_on_triangle;
use crate::math::{Tensor, Vector};
use crate::mesh::Mesh;
use crate::pfem2::boundary::{Boundary, BoundaryKind};
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};

/// The gap, over the height of the element at the wall.
const GAP: f64 = 0.5;

/// Stiffness of a contact over that of an element of the solid.
const STIFFNESS: f64 = 10.0;

/// Way per step, over the gap, up to which what sticks may creep.
const CREEP: f64 = 1e-4;

/// Cosine of the angle of normals from which facets count as one wall.
const SAME_WALL: f64 = 0.8;

/// The walls of a mesh.
#[derive(Debug)]
pub struct Walls<const D: usize> {
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
}

/// A node on the surface of a solid that may touch walls.
#[derive(Debug, Clone, Copy)]
struct SurfaceNode {
    node: u32,
    /// A k [N/m].
    stiffness: f64,
    /// Coefficient of friction.
    friction: f64,
    /// The gap that it keeps at most [m].
    gap: f64,
}

/// Force of a wall on a node during a step, linear in the velocity at its end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WallContact<const D: usize> {
    /// The node.
    pub node: u32,
    normal: Vector<D>,
    /// Normal force without a velocity [N].
    push: f64,
    /// Change of the normal force with the normal velocity [N s/m].
    resistance: f64,
    /// c [N s/m].
    friction: f64,
}

/// Contact of the solids of a run with walls.
#[derive(Debug)]
pub struct WallContacts<const D: usize> {
    walls: Walls<D>,
    nodes: Vec<SurfaceNode>,
}

impl<const D: usize> WallContact<D> {
    /// Minus the derivative of the force by the velocity [N s/m].
    pub fn matrix(&self) -> Tensor<D> {
        let normal = Tensor::outer(self.normal, self.normal);
        normal * self.resistance + (Tensor::identity() - normal) * self.friction
    }

    /// Force without a velocity [N].
    pub fn load(&self) -> Vector<D> {
        self.normal * self.push
    }

    /// Force at a velocity [m/s], and its part along the normal [N].
    pub fn force(&self, velocity: Vector<D>) -> (Vector<D>, f64) {
        let force = self.load() - self.matrix().apply(velocity);
        (force, force.dot(self.normal))
    }
}

impl<const D: usize> Walls<D> {
    /// The walls and slip walls of a mesh.
    pub fn new<const N: usize>(mesh: &Mesh<D, N>, boundary: &Boundary<D>) -> Self {
        let is_wall = |kind: &BoundaryKind| matches!(kind, BoundaryKind::Wall | BoundaryKind::Slip);
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
    fn near(&self, x: Vector<D>, reach: f64) -> Vec<NearWall<D>> {
        if !x.is_finite() {
            return Vec::new();
        }
        let around = AABB::from_corners((x - Vector::splat(reach)).0, (x + Vector::splat(reach)).0);
        let mut candidates: Vec<u32> =
            self.boxes.locate_in_envelope_intersecting(around).map(|entry| entry.data).collect();
        candidates.sort_unstable();
        let at = |&n: &u32| self.facets[n as usize].at(x);
        let mut all: Vec<NearWall<D>> = candidates.iter().map(at).filter(|wall| wall.distance.abs() < reach).collect();
        all.sort_by(|a, b| a.distance.abs().total_cmp(&b.distance.abs()));
        let mut walls: Vec<NearWall<D>> = Vec::new();
        for wall in all {
            if walls.iter().all(|other| other.normal.dot(wall.normal) < SAME_WALL) {
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
        let (distance, gap) = (away.norm(), self.gap);
        let side = away.dot(self.normal);
        // Beside the facet the wall ends in an edge or goes on in another facet.
        match away.normalized() {
            Some(direction) if side > 0.0 => NearWall { distance, normal: direction, gap },
            Some(_) if side < 0.0 => NearWall { distance: -distance, normal: self.normal, gap },
            Some(_) => NearWall { distance: f64::INFINITY, normal: self.normal, gap },
            None => NearWall { distance, normal: self.normal, gap },
        }
    }
}

impl<const D: usize> WallContacts<D> {
    /// Of solids in their reference state. Nodes of a supported solid that start nearer to a wall than the gap belong to its support and
    /// touch nothing; those of others keep the distance that they start with.
    pub fn new<const N: usize>(structure: &Structure<D>, mesh: &Mesh<D, N>, boundary: &Boundary<D>) -> Self {
        let walls = Walls::new(mesh, boundary);
        let mut nodes = Vec::new();
        for (setup, (solid, first)) in structure.setups().iter().zip(structure.meshes()) {
            let stiffness = STIFFNESS * structure.wave_modulus(setup);
            let supported = setup.held.iter().any(|held| !held.nodes.is_empty());
            for (node, area, size) in surface_areas(setup) {
                let start = walls.near(solid.nodes[node as usize], walls.largest);
                let distance = start.iter().fold(f64::INFINITY, |least: f64, wall| least.min(wall.distance));
                if supported && start.iter().any(|wall| wall.distance < wall.gap) {
                    continue;
                }
                let stiffness = stiffness * area / size;
                nodes.push(SurfaceNode { node: first + node, stiffness, friction: setup.friction, gap: distance });
            }
        }
        Self { walls, nodes }
    }

    /// The contacts of a step of length `dt` with the implicit part `delta` [s]: nodes of the prediction at `start`, `hat`, and `predicted`
    /// [m] (uⁿ, û, u* added to their places), with an extrapolated velocity [m/s] and the normal force of the last step [N].
    pub(super) fn of_step(
        &self,
        [dt, delta]: [f64; 2],
        [start, hat, predicted]: [&dyn Fn(usize) -> Vector<D>; 3],
        velocity: &[Vector<D>],
        normal_force: &[f64],
    ) -> Vec<WallContact<D>> {
        let mut contacts = Vec::new();
        for &SurfaceNode { node, stiffness, friction, gap } in &self.nodes {
            let a = node as usize;
            let x = predicted(a);
            let reach = self.walls.largest + (x - start(a)).norm();
            for wall in self.walls.near(x, reach) {
                let gap = gap.min(wall.gap);
                // What pushed in the last step goes on until it would pull: else contacts would chatter.
                if wall.distance >= gap && normal_force[a] <= 0.0 {
                    continue;
                }
                let normal = wall.normal;
                let along = velocity[a] - normal * velocity[a].dot(normal);
                let speed = along.norm().max(CREEP * wall.gap / dt);
                contacts.push(WallContact {
                    node,
                    normal,
                    push: stiffness * (gap - wall.distance - normal.dot(hat(a) - x)),
                    resistance: stiffness * delta,
                    friction: friction * normal_force[a].max(0.0) / speed,
                });
            }
        }
        contacts
    }
}

/// Nodes on the surface of a solid with their areas A_a [m²] and the size of the facets there [m], ascending.
fn surface_areas<const D: usize>(setup: &SolidSetup<D>) -> Vec<(u32, f64, f64)> {
    let mut areas = vec![(0.0, 0.0f64); setup.mesh.nodes.len()];
    for facet in 0..setup.mesh.facets.len() {
        let shares = super::support::facet_shares(setup, facet);
        let size = shares.iter().map(|(_, area)| area).sum::<f64>().powf(1.0 / (D - 1) as f64);
        for (node, area) in shares {
            let own = &mut areas[node as usize];
            *own = (own.0 + area, own.1.max(size));
        }
    }
    (0..).zip(areas).filter(|(_, (area, _))| *area > 0.0).map(|(node, (area, size))| (node, area, size)).collect()
}
