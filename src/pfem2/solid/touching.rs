//! Contact of solids with each other and with themselves: nodes on the surface of one keep a gap from the facets of the other, in which
//! fluid stays (theory J.9).
//!
//! ```text
//! d = (x_a − x_Γ(ξ_a))·n,  x_Γ = Σ_b N_b(ξ_a) x_b:  the point of the other surface that is nearest to node a at u*
//! d(u*) < g, or f_n > 0 in the last step:           a contact as in `contact.rs`, f on node a, −N_b f on the nodes b
//! g = ½ h(x_a),   of solids that start nearer the distance that they have;   of one solid at most ½ |X_a − X_Γ|
//! ```
//!
//! Of a pair the nodes of the solid with the smaller facets are asked, and of the other those at its edges and corners, which would dig in
//! between them: nodes of two smooth surfaces that are asked against each other take turns. Of one solid all are, with half of their area.
//! Forces on a pair add up to nothing, whatever meets.

use super::contact::{GAP, Hardness, Meeting, REACH};
use super::structure::Structure;
use super::surface::{FacetFoot, SolidSurface};
use super::walls::surface_areas;
use crate::error::{Place, StepError};
use crate::math::Vector;
use crate::mesh::{Location, Locator, Mesh};
use crate::parallel;
use std::collections::BTreeMap;

/// Cosine of the angle of normals from which facets are one surface.
const SAME_SURFACE: f64 = 0.8;

/// Product of normals below which two places of one solid face each other.
const FACING: f64 = -0.5;

/// Part of the way from a facet to a place straight through the solid at the start, from which the solid lies between them.
const THROUGH: f64 = -0.7;

/// Nearer than this part of the way at the start, places of one solid may touch.
const NEARER: f64 = 0.5;

/// Points per piece of a parallel loop.
const PIECE: usize = 32;

/// Contact among the solids of a run.
#[derive(Debug)]
pub struct SolidContacts<const D: usize> {
    points: Vec<SurfacePoint>,
    partners: Vec<Partner>,
    /// Gap of pairs that start nearer than others keep, the smaller number first [m].
    starts: BTreeMap<[usize; 2], f64>,
    /// The surface at the start.
    reference: SolidSurface<D>,
    pub(super) locator: Locator<D>,
    /// Size of the elements of the fluid's mesh at its nodes [m].
    sizes: Vec<f64>,
    /// The largest gap [m].
    largest: f64,
}

/// A node on the surface of a solid.
#[derive(Debug, Clone, Copy)]
struct SurfacePoint {
    node: u32,
    solid: usize,
    /// A_a [m²].
    area: f64,
    hardness: Hardness,
    /// True at edges and corners.
    is_sharp: bool,
}

/// A point that is asked what it meets.
struct Asked<const D: usize> {
    /// Its number.
    id: usize,
    solid: usize,
    /// Shape functions of nodes at it.
    shares: Vec<(u32, f64)>,
    /// As predicted [m].
    x: Vector<D>,
    /// How far to look [m].
    reach: f64,
    /// [m²].
    area: f64,
    hardness: Hardness,
}

/// A solid as others meet it.
#[derive(Debug, Clone, Copy)]
struct Partner {
    /// Of its largest facet [m].
    size: f64,
    hardness: Hardness,
    friction: f64,
}

/// Places of all nodes in a step [m].
pub(super) struct ContactPlaces<'a, const D: usize> {
    /// At its start.
    pub start: &'a [Vector<D>],
    /// As predicted for its end.
    pub predicted: &'a [Vector<D>],
    /// The surface there.
    pub surface: &'a SolidSurface<D>,
}

impl<const D: usize> SolidContacts<D> {
    /// Of solids in their reference state, in a mesh of the fluid.
    pub fn new<const N: usize>(structure: &Structure<D>, mesh: &Mesh<D, N>) -> Self {
        let (mut points, mut partners) = (Vec::new(), Vec::new());
        let reference = SolidSurface::new(&structure.meshes(), &structure.nodes);
        let sharp = reference.sharp_nodes();
        for (solid, setup) in structure.setups().iter().enumerate() {
            let (first, mass) = (structure.meshes()[solid].1, structure.mass_of(solid));
            let areas = surface_areas(setup);
            let hardness = |size: f64| Hardness::new(structure, setup, mass, size);
            let size = areas.iter().fold(0.0, |most: f64, (.., size)| most.max(*size));
            partners.push(Partner { size, hardness: hardness(size), friction: setup.friction });
            points.extend(areas.into_iter().map(|(node, area, size)| SurfacePoint {
                node: first + node,
                solid,
                area,
                hardness: hardness(size),
                is_sharp: sharp[(first + node) as usize],
            }));
        }
        let sizes = nodal_sizes(mesh);
        let largest = GAP * sizes.iter().copied().fold(0.0, f64::max);
        let locator = Locator::new(mesh);
        let mut contacts = Self { points, partners, starts: BTreeMap::new(), reference, locator, sizes, largest };
        contacts.starts = contacts.gaps_at_the_start(structure);
        contacts
    }

    /// The least distance of pairs that start within the largest gap [m].
    fn gaps_at_the_start(&self, structure: &Structure<D>) -> BTreeMap<[usize; 2], f64> {
        let (mut starts, surface) = (BTreeMap::new(), &self.reference);
        for &SurfacePoint { node, solid, .. } in &self.points {
            let x = structure.nodes[node as usize];
            for other in (0..self.partners.len()).filter(|&other| other != solid) {
                let Some(foot) = surface.feet(other, x, self.largest).first().copied() else { continue };
                let least = starts.entry([solid.min(other), solid.max(other)]).or_insert(f64::INFINITY);
                *least = f64::min(*least, surface.signed_distance(x, &foot));
            }
        }
        starts
    }

    /// Number of points that may touch: nodes of surfaces, and then facets of all solids.
    pub fn count(&self) -> usize {
        self.points.len() + self.reference.facet_count()
    }

    /// Where points meet facets in a step.
    ///
    /// # Errors
    /// A node has gone through the surface of another solid.
    pub(super) fn meetings<const N: usize>(
        &self,
        structure: &Structure<D>,
        mesh: &Mesh<D, N>,
        places: &ContactPlaces<'_, D>,
    ) -> Result<Vec<Meeting<D>>, StepError> {
        let normals = places.surface.nodal_normals();
        let all = parallel::collect(self.count(), PIECE, |id| {
            let solid = self.solid_of(id, structure);
            let asked = |other: usize| match id.checked_sub(self.points.len()) {
                None if !self.asks(id, other) => None,
                None => Some(self.node(id, places)),
                Some(facet) => self.between_nodes(facet as u32, [solid, other], structure, places),
            };
            let meets = |other: usize| -> Result<Vec<Meeting<D>>, StepError> {
                let Some(asked) = asked(other) else { return Ok(Vec::new()) };
                let mut feet = places.surface.feet(other, asked.x, asked.reach);
                if other == solid {
                    let node = asked.shares[0].0;
                    let own = (node, normals[node as usize]);
                    feet.retain(|foot| self.faces(structure, places.surface, own, (asked.x, foot)));
                }
                self.meet(&asked, other, (structure, mesh), (places.surface, &feet))
            };
            let others = (0..self.partners.len()).filter(|&other| self.may_meet(structure, solid, other));
            others.map(meets).collect::<Result<Vec<_>, _>>()
        });
        let all: Result<Vec<_>, StepError> = all.into_iter().collect();
        Ok(all?.into_iter().flatten().flatten().collect())
    }

    /// True for solids that aren't bonded, and for an elastic one and itself.
    fn may_meet(&self, structure: &Structure<D>, solid: usize, other: usize) -> bool {
        if other == solid { !structure.setups()[solid].law.is_rigid() } else { !structure.ties.bond(solid, other) }
    }

    /// True where a node is asked against a solid.
    fn asks(&self, id: usize, other: usize) -> bool {
        let SurfacePoint { solid, is_sharp, .. } = self.points[id];
        let order = |solid: usize| (self.partners[solid].size, solid);
        is_sharp || order(solid) <= order(other)
    }

    /// The solid of a point.
    fn solid_of(&self, id: usize, structure: &Structure<D>) -> usize {
        let Some(facet) = id.checked_sub(self.points.len()) else { return self.points[id].solid };
        let begins = |solid: &usize| self.reference.first_facet(*solid) as usize <= facet;
        (0..structure.setups().len()).rev().find(begins).unwrap_or(0)
    }

    /// A node of the surface.
    fn node(&self, id: usize, places: &ContactPlaces<'_, D>) -> Asked<D> {
        let SurfacePoint { node, solid, area, hardness, .. } = self.points[id];
        let x = places.predicted[node as usize];
        let reach = REACH * self.largest + (x - places.start[node as usize]).norm();
        Asked { id, solid, shares: vec![(node, 1.0)], x, reach, area, hardness }
    }

    /// The point of a facet of a rigid solid, between its nodes, that is nearest to another: on its nodes alone it would roll as a wheel on
    /// its spokes.
    fn between_nodes(
        &self,
        facet: u32,
        [solid, other]: [usize; 2],
        structure: &Structure<D>,
        places: &ContactPlaces<'_, D>,
    ) -> Option<Asked<D>> {
        if !structure.setups()[solid].law.is_rigid() {
            return None;
        }
        let (size, middle) = places.surface.size_and_middle(facet);
        let x = places.predicted[middle as usize];
        let reach = REACH * self.largest + (x - places.start[middle as usize]).norm();
        let foot = places.surface.feet(other, x, reach + size).first().copied()?;
        let up = away(x, &foot, places.surface.signed_distance(x, &foot))?;
        let (x, shares) = places.surface.lowest(facet, up)?;
        let (id, hardness) = (self.points.len() + facet as usize, self.partners[solid].hardness);
        Some(Asked { id, solid, shares, x, reach, area: 0.0, hardness })
    }

    /// Where a point meets a solid.
    ///
    /// # Errors
    /// As [`SolidContacts::meetings`].
    fn meet<const N: usize>(
        &self,
        asked: &Asked<D>,
        other: usize,
        (structure, mesh): (&Structure<D>, &Mesh<D, N>),
        (surface, feet): (&SolidSurface<D>, &[FacetFoot<D>]),
    ) -> Result<Vec<Meeting<D>>, StepError> {
        let &Asked { id, solid, x, area, hardness, .. } = asked;
        let mut meetings: Vec<Meeting<D>> = Vec::new();
        for foot in feet {
            let distance = surface.signed_distance(x, foot);
            // Edges count where they are nearest: elsewhere the surface goes on.
            if !meetings.is_empty() && (distance < 0.0 || !foot.is_inside()) {
                continue;
            }
            let normal = away(x, foot, distance).unwrap_or_else(|| surface.normal_at(foot));
            if meetings.iter().any(|meeting| meeting.normal.dot(normal) > SAME_SURFACE) {
                continue;
            }
            if distance < -self.largest {
                return Err(passed(structure, [solid, other], x, distance));
            }
            let weights = surface.weights_at(foot);
            let (share, at_most) = match solid == other {
                true => (0.5, NEARER * at_the_start(structure, asked.shares[0].0, &weights).norm()),
                false => (1.0, f64::INFINITY),
            };
            let both = [solid, other].map(|solid| self.partners[solid]);
            let against = weights.into_iter().map(|(b, weight)| (b, -weight));
            meetings.push(Meeting {
                point: id,
                shares: asked.shares.iter().copied().chain(against).collect(),
                normal,
                distance,
                gap: self.gap(mesh, x, [solid, other]).min(at_most),
                area: share * area,
                hardness: hardness.with(both[1].hardness),
                friction: (both[0].friction * both[1].friction).sqrt(),
            });
            if distance < 0.0 {
                break;
            }
        }
        Ok(meetings)
    }

    /// The gap that two solids keep at a place [m].
    fn gap<const N: usize>(&self, mesh: &Mesh<D, N>, x: Vector<D>, pair: [usize; 2]) -> f64 {
        let size = self.size_at(mesh, x);
        let start = self.starts.get(&[pair[0].min(pair[1]), pair[0].max(pair[1])]);
        (GAP * size).min(self.largest).min(start.copied().unwrap_or(f64::INFINITY))
    }

    /// Size of the elements of the fluid's mesh at a place [m]; infinite outside.
    fn size_at<const N: usize>(&self, mesh: &Mesh<D, N>, x: Vector<D>) -> f64 {
        match self.locator.search(mesh, x) {
            Some(Location::Inside { element, shape }) => {
                let nodes = mesh.elements()[element].iter().zip(shape);
                nodes.map(|(&node, share)| self.sizes[node as usize] * share).sum()
            }
            _ => f64::INFINITY,
        }
    }

    /// The largest distance of the nodes of surfaces from where they were `predicted`, in elements of the mesh there; both are positions [m].
    pub(super) fn largest_error<const N: usize>(&self, mesh: &Mesh<D, N>, [now, predicted]: [&[Vector<D>]; 2]) -> f64 {
        let of = |SurfacePoint { node, .. }: &SurfacePoint| {
            let [x, from] = [now, predicted].map(|places| places[*node as usize]);
            (x - from).norm() / self.size_at(mesh, x).min(self.size_at(mesh, from))
        };
        self.points.iter().map(of).fold(0.0, f64::max)
    }

    /// True where a place of a solid's own surface faces a node, and has come near since the start.
    fn faces(
        &self,
        structure: &Structure<D>,
        surface: &SolidSurface<D>,
        (node, normal): (u32, Vector<D>),
        (x, foot): (Vector<D>, &FacetFoot<D>),
    ) -> bool {
        if surface.holds(foot, node) || surface.normal_at(foot).dot(normal) > FACING {
            return false;
        }
        let weights = surface.weights_at(foot);
        let away = at_the_start(structure, node, &weights);
        let through = away.dot(self.reference.normal_at(foot)) < THROUGH * away.norm();
        !through && foot.distance < away.norm() && surface.signed_distance(x, foot) > -self.largest
    }
}

/// The way from a place of the surface to a node at the start [m].
fn at_the_start<const D: usize>(structure: &Structure<D>, node: u32, weights: &[(u32, f64)]) -> Vector<D> {
    let place = |a: u32| structure.nodes[a as usize];
    place(node) - weights.iter().map(|&(b, weight)| place(b) * weight).sum::<Vector<D>>()
}

/// Direction away from the surface, where a place is far enough from it to tell.
fn away<const D: usize>(x: Vector<D>, foot: &FacetFoot<D>, distance: f64) -> Option<Vector<D>> {
    /// Distance over the size of what is told apart in double precision, with some digits left.
    const NEAREST: f64 = 1e-9;
    let way = (x - foot.position) * distance.signum();
    way.normalized().filter(|_| foot.is_inside() || distance > NEAREST * x.norm())
}

/// A node has gone through a surface.
fn passed<const D: usize>(
    structure: &Structure<D>,
    [own, other]: [usize; 2],
    x: Vector<D>,
    distance: f64,
) -> StepError {
    let [own, other] = [own, other].map(|solid| &structure.setups()[solid].name);
    let place = Place::Point { position: x.to3() };
    let advice = "solids stay apart if they approach each other by less than half an element of the mesh per step: take shorter steps";
    StepError::new(place, format!("`{own}` has gone through the surface of `{other}`"), "distance", distance, advice)
}

/// Size of the elements at each node, the mean of (D! V)^(1/D) [m].
fn nodal_sizes<const D: usize, const N: usize>(mesh: &Mesh<D, N>) -> Vec<f64> {
    let factorial: f64 = (1..=D).map(|k| k as f64).product();
    let size = |e: u32| (factorial * mesh.simplex(e as usize).volume).powf(1.0 / D as f64);
    let mean = |node: usize| {
        let around = mesh.elements_around(node);
        around.iter().map(|&e| size(e)).sum::<f64>() / around.len().max(1) as f64
    };
    (0..mesh.nodes().len()).map(mean).collect()
}
