//! Contact of solids with each other and with themselves: nodes on the surface of one keep a gap from the facets
//! of the other, in which fluid stays (theory J.9).
//!
//! ```text
//! d = (x_a − x_Γ(ξ_a))·n,  x_Γ = Σ_b N_b(ξ_a) x_b:  the point of the other surface that is nearest to node a at u*
//! d(u*) near g:                             a candidate with the force f of `force.rs` on node a, −N_b f on the nodes b
//! d(u*) < g, or f_n > 0 in the last step:   it acts in the first solution of the step
//! g = ½ h(x_a),   of solids that start nearer the distance that they have;   of one solid at most ½ |X_a − X_Γ|
//! ```
//!
//! Of a pair the nodes of the solid with the smaller facets are queried, and of the other those at its edges and
//! corners, which would dig in between them: nodes of two smooth surfaces that are queried against each other take
//! turns. Of one solid all are, with half of their area. Forces on a pair add up to nothing, whatever touches. Which
//! of the candidates act in the end is found in the step, (J.11a).

use super::force::{ContactCandidate, ContactLaw, GAP, REACH, gap_scale};
use super::places::{ContactPlaces, NodeArea, node_areas};
use crate::error::{Place, StepError};
use crate::math::Vector;
use crate::mesh::{Location, Locator, Mesh};
use crate::parallel;
use crate::pfem2::solid::structure::Structure;
use crate::pfem2::solid::surface::{FacetFoot, SolidSurface};
use std::collections::BTreeMap;

/// Cosine of the angle of normals from which facets are one surface.
const SAME_SURFACE_COSINE: f64 = 0.8;

/// Cosine of the angle between the normals of two places of one solid below which they face each other.
const FACING_COSINE: f64 = -0.5;

/// Cosine of the angle between the normal of a facet and the way from there to a place at the start, below which the
/// solid lies between them.
const THROUGH_COSINE: f64 = -0.7;

/// Places of one solid that have a node behind them by more than this part of the thickness of the solid there have
/// the solid between themselves and the node.
const LARGEST_DEPTH: f64 = 0.5;

/// Nearer than this part of the way at the start, places of one solid may touch.
const TOUCHABLE_FRACTION: f64 = 0.5;

/// Points per piece of a parallel loop.
const PIECE: usize = 32;

/// A place of a surface that a point may touch.
struct NearPlace<'a, const D: usize> {
    foot: &'a FacetFoot<D>,
    /// n, away from the surface.
    normal: Vector<D>,
    /// d* [m].
    distance: f64,
}

/// Contact among the solids of a run.
#[derive(Debug)]
pub struct SolidContacts<const D: usize> {
    nodes: Vec<MeetingNode>,
    bodies: Vec<ContactBody>,
    /// Gap of pairs that start nearer than others keep, the smaller number first [m].
    starts: BTreeMap<[usize; 2], f64>,
    /// The surface at the start.
    reference: SolidSurface<D>,
    pub(in crate::pfem2) locator: Locator<D>,
    /// Size of the elements of the fluid's mesh at its nodes [m].
    sizes: Vec<f64>,
    /// The largest gap [m].
    largest: f64,
}

/// A node on the surface of a solid.
#[derive(Debug, Clone, Copy)]
struct MeetingNode {
    node: u32,
    solid: usize,
    /// A_a [m²].
    area: f64,
    law: ContactLaw,
    /// True at edges and corners.
    is_sharp: bool,
}

/// A point of a surface whose distance to another solid is looked for.
struct ContactQuery<const D: usize> {
    /// Number of the point.
    id: usize,
    solid: usize,
    /// Shape functions of nodes at it.
    coefficients: Vec<(u32, f64)>,
    /// Predicted position [m].
    x: Vector<D>,
    /// Distance within which to look [m].
    reach: f64,
    /// Area that belongs to the point [m²].
    area: f64,
    law: ContactLaw,
}

/// A solid as others touch it.
#[derive(Debug, Clone, Copy)]
struct ContactBody {
    /// Size of its largest facet [m].
    size: f64,
    law: ContactLaw,
    friction: f64,
}

/// Input of the search for contacts among solids in a step.
pub(super) struct SearchContext<'a, const D: usize, const N: usize> {
    /// The solids.
    pub structure: &'a Structure<D>,
    /// The mesh of the fluid.
    pub mesh: &'a Mesh<D, N>,
    /// Places of all nodes.
    pub places: ContactPlaces<'a, D>,
}

impl<const D: usize> SolidContacts<D> {
    /// Contact of solids in their reference state, in a mesh of the fluid.
    pub fn new<const N: usize>(structure: &Structure<D>, mesh: &Mesh<D, N>) -> Self {
        let (mut nodes, mut bodies) = (Vec::new(), Vec::new());
        let reference = SolidSurface::new(&structure.meshes(), &structure.nodes);
        let sharp = reference.sharp_nodes();
        for (solid, setup) in structure.setups().iter().enumerate() {
            let (first, mass) = (structure.meshes()[solid].1, structure.mass_of(solid));
            let areas = node_areas(setup);
            let law = |size: f64| ContactLaw::new(structure, setup, mass, size);
            let size = areas.iter().fold(0.0, |most: f64, own| most.max(own.size));
            bodies.push(ContactBody { size, law: law(size), friction: setup.friction });
            nodes.extend(areas.into_iter().map(|NodeArea { node, area, size }| MeetingNode {
                node: first + node,
                solid,
                area,
                law: law(size),
                is_sharp: sharp[(first + node) as usize],
            }));
        }
        let sizes = nodal_sizes(mesh);
        let largest = GAP * sizes.iter().copied().fold(0.0, f64::max);
        let locator = Locator::new(mesh);
        let mut contacts = Self { nodes, bodies, starts: BTreeMap::new(), reference, locator, sizes, largest };
        contacts.starts = contacts.gaps_at_the_start(structure);
        contacts
    }

    /// The least distance of pairs that start within the largest gap [m].
    fn gaps_at_the_start(&self, structure: &Structure<D>) -> BTreeMap<[usize; 2], f64> {
        let (mut starts, surface) = (BTreeMap::new(), &self.reference);
        for &MeetingNode { node, solid, .. } in &self.nodes {
            let x = structure.nodes[node as usize];
            for other in (0..self.bodies.len()).filter(|&other| other != solid) {
                let Some(foot) = surface.feet(other, x, self.largest).first().copied() else { continue };
                let least = starts.entry([solid.min(other), solid.max(other)]).or_insert(f64::INFINITY);
                *least = f64::min(*least, surface.signed_distance(x, &foot));
            }
        }
        starts
    }

    /// Number of points that may touch: nodes of surfaces, and then facets of all solids.
    pub fn count(&self) -> usize {
        self.nodes.len() + self.reference.facet_count()
    }

    /// The places where points may touch facets in a step.
    ///
    /// # Errors
    /// A node has gone through the surface of another solid.
    pub(super) fn candidates<const N: usize>(
        &self,
        context: &SearchContext<'_, D, N>,
    ) -> Result<Vec<ContactCandidate<D>>, StepError> {
        let SearchContext { structure, places, .. } = context;
        let normals = places.surface.normals_at_nodes();
        let all = parallel::collect(self.count(), PIECE, |id| {
            let solid = self.solid_of(id, structure);
            let query = |other: usize| match id.checked_sub(self.nodes.len()) {
                None if !self.is_queried(id, other) => None,
                None => Some(self.at_node(id, places)),
                Some(facet) => self.between_nodes(facet as u32, [solid, other], structure, places),
            };
            let found = |other: usize| -> Result<Vec<ContactCandidate<D>>, StepError> {
                let Some(query) = query(other) else { return Ok(Vec::new()) };
                let mut feet = places.surface.feet(other, query.x, query.reach);
                if other == solid {
                    self.keep_facing(context, &query, &normals[query.coefficients[0].0 as usize], &mut feet);
                }
                self.at_feet(&query, other, context, &feet)
            };
            let others = (0..self.bodies.len()).filter(|&other| self.may_touch(structure, solid, other));
            others.map(found).collect::<Result<Vec<_>, _>>()
        });
        let all: Result<Vec<_>, StepError> = all.into_iter().collect();
        Ok(all?.into_iter().flatten().flatten().collect())
    }

    /// True for solids that aren't bonded, and for an elastic one and itself.
    fn may_touch(&self, structure: &Structure<D>, solid: usize, other: usize) -> bool {
        if other == solid { !structure.setups()[solid].law.is_rigid() } else { !structure.ties.bond(solid, other) }
    }

    /// True where a node is queried against a solid.
    fn is_queried(&self, id: usize, other: usize) -> bool {
        let MeetingNode { solid, is_sharp, .. } = self.nodes[id];
        let order = |solid: usize| (self.bodies[solid].size, solid);
        is_sharp || order(solid) <= order(other)
    }

    /// The solid of a point.
    fn solid_of(&self, id: usize, structure: &Structure<D>) -> usize {
        let Some(facet) = id.checked_sub(self.nodes.len()) else { return self.nodes[id].solid };
        let begins = |solid: &usize| self.reference.first_facet(*solid) as usize <= facet;
        (0..structure.setups().len()).rev().find(begins).unwrap_or(0)
    }

    /// The query at a node of the surface.
    fn at_node(&self, id: usize, places: &ContactPlaces<'_, D>) -> ContactQuery<D> {
        let MeetingNode { node, solid, area, law, .. } = self.nodes[id];
        let x = places.predicted[node as usize];
        let reach = REACH * self.largest + (x - places.start[node as usize]).norm();
        ContactQuery { id, solid, coefficients: vec![(node, 1.0)], x, reach, area, law }
    }

    /// The query at the point of a facet of a rigid solid, between its nodes, that is nearest to another solid: on its
    /// nodes alone it would roll as a wheel on its spokes.
    fn between_nodes(
        &self,
        facet: u32,
        [solid, other]: [usize; 2],
        structure: &Structure<D>,
        places: &ContactPlaces<'_, D>,
    ) -> Option<ContactQuery<D>> {
        if !structure.setups()[solid].law.is_rigid() {
            return None;
        }
        let (size, middle) = places.surface.size_and_middle(facet);
        let x = places.predicted[middle as usize];
        let reach = REACH * self.largest + (x - places.start[middle as usize]).norm();
        let foot = places.surface.feet(other, x, reach + size).first().copied()?;
        let up = away(x, &foot, places.surface.signed_distance(x, &foot))?;
        let (x, coefficients) = places.surface.lowest(facet, up)?;
        let (id, law) = (self.nodes.len() + facet as usize, self.bodies[solid].law);
        Some(ContactQuery { id, solid, coefficients, x, reach, area: 0.0, law })
    }

    /// The places of another solid, among the nearest points of its surface, that a queried point may touch.
    ///
    /// # Errors
    /// As [`SolidContacts::candidates`].
    fn at_feet<const N: usize>(
        &self,
        query: &ContactQuery<D>,
        other: usize,
        context: &SearchContext<'_, D, N>,
        feet: &[FacetFoot<D>],
    ) -> Result<Vec<ContactCandidate<D>>, StepError> {
        let (surface, mut found) = (context.places.surface, Vec::<ContactCandidate<D>>::new());
        for foot in feet {
            let distance = surface.signed_distance(query.x, foot);
            // Edges count where they are nearest: elsewhere the surface goes on.
            if !found.is_empty() && (distance < 0.0 || !foot.is_inside()) {
                continue;
            }
            let normal = away(query.x, foot, distance).unwrap_or_else(|| surface.normal_at(foot));
            if found.iter().any(|candidate| candidate.normal.dot(normal) > SAME_SURFACE_COSINE) {
                continue;
            }
            if distance < -self.largest {
                return Err(passed(context.structure, [query.solid, other], query.x, distance));
            }
            found.push(self.candidate(query, other, context, &NearPlace { foot, normal, distance }));
            if distance < 0.0 {
                break;
            }
        }
        Ok(found)
    }

    /// The candidate of a queried point at one place of another solid, or of the same.
    fn candidate<const N: usize>(
        &self,
        query: &ContactQuery<D>,
        other: usize,
        context: &SearchContext<'_, D, N>,
        place: &NearPlace<'_, D>,
    ) -> ContactCandidate<D> {
        let &ContactQuery { id, solid, x, area, law, .. } = query;
        let weights = context.places.surface.weights_at(place.foot);
        let (fraction, at_most) = match solid == other {
            true => {
                (0.5, TOUCHABLE_FRACTION * at_the_start(context.structure, query.coefficients[0].0, &weights).norm())
            }
            false => (1.0, f64::INFINITY),
        };
        let [own, body] = [solid, other].map(|solid| self.bodies[solid]);
        let [of_mesh, of_pair] = self.gaps(context.mesh, x, [solid, other]);
        let gap = of_pair.min(at_most);
        let against = weights.into_iter().map(|(b, weight)| (b, -weight));
        ContactCandidate {
            point: id,
            coefficients: query.coefficients.iter().copied().chain(against).collect(),
            normal: place.normal,
            distance: place.distance,
            gap,
            scale: gap_scale(gap, of_mesh),
            area: fraction * area,
            law: law.combined(body.law),
            friction: (own.friction * body.friction).sqrt(),
        }
    }

    /// The gap of the mesh at a place, and the one that two solids keep there, which may begin nearer [m].
    fn gaps<const N: usize>(&self, mesh: &Mesh<D, N>, x: Vector<D>, pair: [usize; 2]) -> [f64; 2] {
        let of_mesh = (GAP * self.size_at(mesh, x)).min(self.largest);
        let start = self.starts.get(&[pair[0].min(pair[1]), pair[0].max(pair[1])]);
        [of_mesh, of_mesh.min(start.copied().unwrap_or(f64::INFINITY))]
    }

    /// Size of the elements of the fluid's mesh at a place [m]; infinite outside.
    fn size_at<const N: usize>(&self, mesh: &Mesh<D, N>, x: Vector<D>) -> f64 {
        match self.locator.search(mesh, x) {
            Some(Location::Inside { element, shape }) => {
                let nodes = mesh.elements()[element].iter().zip(shape);
                nodes.map(|(&node, weight)| self.sizes[node as usize] * weight).sum()
            }
            _ => f64::INFINITY,
        }
    }

    /// The largest distance of the nodes of surfaces from where they were `predicted`, in elements of the mesh there;
    /// both are positions [m].
    pub(in crate::pfem2) fn largest_error<const N: usize>(
        &self,
        mesh: &Mesh<D, N>,
        [now, predicted]: [&[Vector<D>]; 2],
    ) -> f64 {
        let error = |MeetingNode { node, .. }: &MeetingNode| {
            let [x, from] = [now, predicted].map(|places| places[*node as usize]);
            (x - from).norm() / self.size_at(mesh, x).min(self.size_at(mesh, from))
        };
        self.nodes.iter().map(error).fold(0.0, f64::max)
    }

    /// Keeps the places on the surface of the same solid that face a queried node, one of the facets with these normals
    /// there, have come nearer since the start, and haven't the solid between themselves and the node. At edges and
    /// corners the facets count and no mean of theirs: two edges that meet face each other with some.
    fn keep_facing<const N: usize>(
        &self,
        context: &SearchContext<'_, D, N>,
        query: &ContactQuery<D>,
        normals: &[Vector<D>],
        feet: &mut Vec<FacetFoot<D>>,
    ) {
        let (surface, node) = (context.places.surface, query.coefficients[0].0);
        let way = |foot: &FacetFoot<D>| at_the_start(context.structure, node, &surface.weights_at(foot));
        let lies_behind = |foot: &FacetFoot<D>| {
            let way = way(foot);
            way.dot(self.reference.facet_normal_at(foot)) < THROUGH_COSINE * way.norm()
        };
        feet.retain(|foot| {
            let other = surface.facet_normal_at(foot);
            !surface.holds(foot, node) && normals.iter().any(|normal| other.dot(*normal) <= FACING_COSINE)
        });
        let behind = feet.iter().filter(|foot| lies_behind(foot)).map(|foot| foot.distance);
        let thickness = behind.fold(f64::INFINITY, f64::min);
        let deepest = f64::min(self.largest, LARGEST_DEPTH * thickness);
        feet.retain(|foot| {
            let is_nearer = foot.distance < way(foot).norm();
            is_nearer && !lies_behind(foot) && surface.signed_distance(query.x, foot) > -deepest
        });
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
    const LEAST_RELATIVE_DISTANCE: f64 = 1e-9;
    let way = (x - foot.position) * distance.signum();
    way.normalized().filter(|_| foot.is_inside() || distance > LEAST_RELATIVE_DISTANCE * x.norm())
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
