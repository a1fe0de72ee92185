//! Contact between bodies, each in a velocity field of its own (theory D.14; Bardenhagen 2001, Nairn 2020).
//!
//! ```text
//! g − Δt max(0, (v̄_a − v̄_b)·n) ≤ tol             detection: n from body a to body b, g the gap between their particles
//! J = m_a m_b/(m_a + m_b) (v̄_a − v̄_b)·n n, no pulling, and friction    on b, −J on a          (theory (D.12), (D.13))
//! ```
//!
//! At every node with the mass of two bodies, the plane between their particles is found (`plane`, `separation`); if
//! they approach and the gap along its normal closes, they exchange an impulse. With three or more bodies at
//! a node the pairs take turns, in a fixed order. Bodies on opposite sides of a sheet have no contact at that node.

mod plane;
mod separation;

use super::impulse::{self, ContactTotals, Impulse, Touch};
use super::method::ContactMethod;
use super::support_blocks::SupportBlocks;
use crate::math::Tensor;
use crate::mpm::particles::Bodies;
use crate::mpm::wall::folded_stencil::FoldedStencil;
use crate::mpm::{Body, Friction, Grid};
use crate::parallel::{self, CHUNK, Groups};
use plane::{ContactPlane, NodeParticle, contact_plane};

/// Turns that the pairs at a node take when there are several.
const SWEEPS: usize = 4;

/// Shared nodes per parallel task.
const NODES: usize = 16;

/// The state in which contacts are searched.
struct ContactSearch<'a, const D: usize> {
    grid: &'a Grid<D>,
    stencil: &'a FoldedStencil<D>,
    sheets: &'a [Box<dyn ContactMethod<D>>],
    /// Gap below which contact acts [m].
    tolerance: f64,
    /// Length of the step [s].
    dt: f64,
}

/// Contact of one pair of fields at one node.
#[derive(Debug, Clone, Copy)]
struct BodyContact<const D: usize> {
    node: usize,
    fields: [usize; 2],
    plane: ContactPlane<D>,
    /// Impulse on the second field.
    impulse: Impulse<D>,
}

/// Contact between bodies during one step.
#[derive(Debug, Default)]
pub struct Pairwise<const D: usize> {
    /// Pairs of fields with contact, and their friction.
    pairs: Vec<([usize; 2], Friction)>,
    /// Grid nodes with mass of both fields of a pair.
    nodes: Vec<usize>,
    /// Index among these of each grid node, `NONE` where there is none.
    lookup: Vec<u32>,
    contacts: Vec<BodyContact<D>>,
}

/// A particle near a shared node.
#[derive(Debug, Clone, Copy)]
struct PointNearNode<const D: usize> {
    /// Index among the shared nodes.
    node: u32,
    field: u32,
    /// Relative to the node.
    particle: NodeParticle<D>,
}

const NONE: u32 = u32::MAX;

impl<const D: usize> Pairwise<D> {
    /// Contact between the fields of the given pairs.
    pub fn new(pairs: Vec<([usize; 2], Friction)>) -> Self {
        Self { pairs, ..Self::default() }
    }

    /// Resolves all contacts between bodies: p̄ and f of both change, with p⁻ = p − Δt f kept.
    /// `tolerance` [m] is the gap below which contact acts.
    pub fn resolve(
        &mut self,
        grid: &mut Grid<D>,
        stencil: &FoldedStencil<D>,
        bodies: &Bodies<D>,
        sheets: &[Box<dyn ContactMethod<D>>],
        tolerance: f64,
        dt: f64,
    ) {
        self.contacts.clear();
        self.find_shared_nodes(grid, stencil.cutoff);
        if self.nodes.is_empty() {
            return;
        }
        let points = self.points_near_nodes(grid, stencil, bodies);
        let by_node = Groups::from_pairs(self.nodes.len(), (0..).zip(&points).map(|(n, point)| (point.node, n)));
        let search = ContactSearch { grid: &*grid, stencil, sheets, tolerance, dt };
        let found: Vec<Vec<BodyContact<D>>> = parallel::collect(self.nodes.len(), NODES, |index| {
            let near = by_node.of(index).iter().map(|&n| &points[n as usize]);
            self.contacts_at(&search, self.nodes[index], near)
        });
        for mut contacts in found {
            let sweeps = if contacts.len() > 1 { SWEEPS } else { 1 };
            for _ in 0..sweeps {
                for contact in &mut contacts {
                    self.exchange_impulse(grid, contact, dt);
                }
            }
            self.contacts.append(&mut contacts);
        }
    }

    /// Nodes with mass of both fields of a pair.
    fn find_shared_nodes(&mut self, grid: &Grid<D>, cutoff: f64) {
        let shared = |node: usize| {
            let heavy = |field: usize| grid.fields[field].nodes[node].mass > cutoff;
            self.pairs.iter().any(|&([a, b], _)| heavy(a) && heavy(b))
        };
        self.nodes = if self.pairs.is_empty() {
            Vec::new()
        } else {
            parallel::collect_some(grid.node_count(), CHUNK, |node| shared(node).then_some(node))
        };
        self.lookup.clear();
        self.lookup.resize(if self.nodes.is_empty() { 0 } else { grid.node_count() }, NONE);
        for (index, &node) in self.nodes.iter().enumerate() {
            self.lookup[node] = index as u32;
        }
    }

    /// The particles around the shared nodes, body by body.
    fn points_near_nodes(
        &self,
        grid: &Grid<D>,
        stencil: &FoldedStencil<D>,
        bodies: &Bodies<D>,
    ) -> Vec<PointNearNode<D>> {
        let mut marked = SupportBlocks::default();
        marked.clear(grid);
        for &node in &self.nodes {
            marked.mark(grid, stencil, node);
        }
        let mut found = Vec::new();
        for (field, body) in bodies.with_fields() {
            let near = marked.particles(grid, stencil, &body.particles.position);
            let around = |n: usize| self.points_of_particle(grid, stencil, field, body, near[n] as usize);
            found.extend(parallel::collect_all(near.len(), 256, around));
        }
        found
    }

    fn points_of_particle(
        &self,
        grid: &Grid<D>,
        stencil: &FoldedStencil<D>,
        field: usize,
        body: &Body<D>,
        p: usize,
    ) -> Vec<PointNearNode<D>> {
        let (x, h) = (body.particles.position[p], grid.cell);
        // Particles below the surface count as points.
        let shape = if body.shows_surface(p) { body.ball(p, h) * (1.0 / h) } else { Tensor::ZERO };
        let width = body.patch(p) / h;
        let mut list = Vec::new();
        stencil.of_field(grid, field).for_each(grid, x, |node, _, flips| {
            let index = self.lookup[node];
            if index != NONE {
                let position = (stencil.mirror(grid, x, flips) - grid.position(node)) / h;
                let particle = NodeParticle { position, shape, width, second: false };
                list.push(PointNearNode { node: index, field: field as u32, particle });
            }
        });
        list
    }

    /// The pairs in contact at a node.
    fn contacts_at<'a>(
        &self,
        search: &ContactSearch<'_, D>,
        node: usize,
        near: impl Iterator<Item = &'a PointNearNode<D>> + Clone,
    ) -> Vec<BodyContact<D>> {
        let &ContactSearch { grid, stencil, sheets, tolerance, dt } = search;
        let free = stencil.free(grid, node);
        let mut contacts = Vec::new();
        for &(fields, _) in &self.pairs {
            let [a, b] = fields.map(|field| grid.fields[field].nodes[node]);
            let light = a.mass.min(b.mass) <= stencil.cutoff;
            if light || sheets.iter().any(|sheet| sheet.separates(node, fields)) {
                continue;
            }
            let cloud: Vec<NodeParticle<D>> = near
                .clone()
                .filter(|point| fields.contains(&(point.field as usize)))
                .map(|point| NodeParticle { second: point.field as usize == fields[1], ..point.particle })
                .collect();
            let slip = a.momentum / a.mass - b.momentum / b.mass;
            if let Some(plane) = contact_plane(&cloud, free) {
                let gap = plane.gap * grid.cell - slip.dot(plane.normal).max(0.0) * dt;
                if gap <= tolerance {
                    contacts.push(BodyContact { node, fields, plane, impulse: Impulse::default() });
                }
            }
        }
        contacts
    }

    /// Applies the impulse of the pair to both nodes and adds it to the contact.
    fn exchange_impulse(&self, grid: &mut Grid<D>, contact: &mut BodyContact<D>, dt: f64) {
        let [a, b] = contact.fields.map(|field| grid.fields[field].nodes[contact.node]);
        let friction = self.pairs.iter().find(|(fields, _)| *fields == contact.fields).map_or(Friction::None, |p| p.1);
        let touch = Touch { mass: b.mass, velocity: b.momentum / b.mass, side: 1.0, friction };
        let mut impulses = Vec::with_capacity(1);
        impulse::solve(a.mass, a.momentum / a.mass, contact.plane.normal, &[touch], &mut impulses);
        for j in impulses {
            contact.impulse.normal += j.normal;
            contact.impulse.tangent += j.tangent;
            for (field, sign) in contact.fields.into_iter().zip([-1.0, 1.0]) {
                let node = &mut grid.fields[field].nodes[contact.node];
                node.momentum += j.total() * sign;
                node.force += j.total() * (sign / dt);
            }
        }
    }

    /// Per pair of fields: the impulse −Σ J on the first [N s], and normal and friction dissipation J·(v̂_a − v̂_b) [J]
    /// (theory (D.29)).
    pub fn totals(&self, grid: &Grid<D>, dt: f64) -> Vec<ContactTotals<D>> {
        let mut sums = vec![ContactTotals::default(); self.pairs.len()];
        for contact in &self.contacts {
            let [a, b] = contact.fields.map(|field| {
                let node = &grid.fields[field].nodes[contact.node];
                (node.momentum - node.force * (0.5 * dt)) / node.mass
            });
            let Some(pair) = self.pairs.iter().position(|(fields, _)| *fields == contact.fields) else { continue };
            let ContactTotals { impulse, dissipated, .. } = &mut sums[pair];
            *impulse -= contact.impulse.total();
            dissipated.normal += contact.impulse.normal.dot(a - b);
            dissipated.friction += contact.impulse.tangent.dot(a - b);
        }
        sums
    }
}
