//! Contact at grid nodes, as in the paper (Lian, Liu & Zhang 2014, section 5, with Lian (55, 58, 59) corrected; theory
//! D.2 to D.8): where a sheet and a body both have mass at a node and the gap between them closes within the sub-step,
//! they exchange an impulse, which never pulls.
//!
//! ```text
//! g + min(0, c w) Δt ≤ tol,  w = (v̄_s − v̄_r)·n,  c = ±1      detection          theory (D.10)
//! J = M (v̄_r − v̄_s),  M = m_r m_s/(m_r + m_s)               stick, on s        Lian (54, 55)
//! J = J_n n + min(‖J_t‖, μ_f |J_n|) J_t/‖J_t‖,  no pulling   slip, on s         Lian (56–58)
//! p_s ← p_s + J                                              the body           Lian (53)
//! v_K ← v_K − 1/m_K Σ_q W_qK Σ_I N_I(x_q) J_I/m_I^r          the sheet          Lian (59)
//! ```
//!
//! n is the normal of the sheet r, on whose side c the body s lies.
//!
//! The sheet comes to the nodes by its samples (`samples`, `map`), the gaps from the particles around it (`band`), and
//! the impulses from the masses at a node (`contact_node`, [`super::impulse`]). The nodes of the sheet take up less
//! than the grid gives, so that contact is resolved in passes (theory D.7). Walls and obstacles follow in each.

mod band;
mod contact_node;
mod map;
mod samples;

use super::impulse::{self, ContactTotals, Impulse, Touch};
use super::method::{ContactMethod, StepContext};
use super::partner::{NONE, Partners};
use super::sheet::{ContactSheet, FacetLocator, GuardedParticle, ParticleShift};
use super::support_blocks::SupportBlocks;
use super::surface::{SheetSource, SheetSurface};
use crate::math::Vector;
use crate::mpm::{Body, Friction, Grid, SubStep};
use crate::parallel;
use band::Band;
use contact_node::{NodePair, update_gaps};
use map::Map;

/// Contact of one sheet at grid nodes.
#[derive(Debug)]
pub struct AtNodes<const D: usize> {
    map: Map<D>,
    /// One pair per node and field, fields running fastest.
    pairs: Vec<NodePair<D>>,
    fields: usize,
    /// Gap below which contact acts [m].
    tolerance: f64,
    /// Blocks from which particles reach contact nodes.
    support_blocks: SupportBlocks,
    /// True distances from the sheet, for particles that come near it or seem to have crossed it.
    locator: FacetLocator<D>,
    /// Forces on the nodes in the sub-step [N].
    received: Vec<Vector<D>>,
}

impl<const D: usize> AtNodes<D> {
    /// Contact of a sheet with so many fields; `tolerance` [m] is the gap below which contact acts.
    pub fn new(source: &SheetSource<'_, D>, fields: usize, tolerance: f64) -> Self {
        Self {
            map: Map::new(source),
            pairs: Vec::new(),
            fields,
            tolerance,
            support_blocks: SupportBlocks::default(),
            locator: FacetLocator::new(&source.facets),
            received: vec![Vector::ZERO; source.mass.len()],
        }
    }

    /// The particles of each body whose support reaches a node.
    fn particles_near(&mut self, context: &StepContext<'_, D>) -> Vec<Vec<u32>> {
        self.support_blocks.clear(context.grid);
        for node in &self.map.nodes {
            self.support_blocks.mark(context.grid, context.stencil, node.grid_node as usize);
        }
        let near =
            |body: &Body<D>| self.support_blocks.particles(context.grid, context.stencil, &body.particles.position);
        context.bodies.iter().map(near).collect()
    }

    /// Marks the pairs whose gap closes by the end of the sub-step, theory (D.10); they have exchanged nothing yet.
    fn detect(&mut self, partners: &Partners<D>, at: &SubStep<'_>) {
        self.received.fill(Vector::ZERO);
        let fields = self.fields;
        for (r, node) in self.map.nodes.iter().enumerate() {
            let velocity = node.project(node.momentum) / node.mass;
            for pair in self.pairs[r * fields..][..fields].iter_mut().filter(|pair| pair.partner != NONE) {
                let (_, v) = partners.trial(pair.partner, at.momentum_end);
                let w = (node.project(v) - velocity).dot(node.normal);
                let gap = pair.choose_side(w);
                // theory (D.10), in place of Lian (50), Lian (52): no test of approach, as the impulse never pulls.
                pair.touching = gap - node.offset + (w * pair.side * at.momentum_dt).min(0.0) <= self.tolerance;
                pair.impulse = Impulse::default();
            }
        }
    }

    /// Solves every node for the impulses of the whole sub-step, without the impulses of the last pass, so that they
    /// may shrink but never pull (theory (D.12), (D.15)). The contact nodes get the change.
    fn solve_nodes(&mut self, partners: &mut Partners<D>, friction: &[Friction], t: f64) {
        let fields = self.fields;
        let (mut touches, mut impulses) = (Vec::new(), Vec::new());
        for (r, node) in self.map.nodes.iter_mut().enumerate() {
            let pairs = &mut self.pairs[r * fields..][..fields];
            let velocity = node.project(node.momentum) / node.mass;
            let before: Vector<D> = pairs.iter().filter(|pair| pair.touching).map(|pair| pair.impulse.total()).sum();
            touches.clear();
            for (field, pair) in pairs.iter().enumerate().filter(|(_, pair)| pair.touching) {
                let (mass, v) = partners.trial(pair.partner, t);
                let (side, friction) = (pair.side, friction[field]);
                touches.push(Touch { mass, velocity: node.project(v) - pair.impulse.total() / mass, side, friction });
            }
            // Lian (54–58).
            impulse::solve(node.inertia, velocity + before / node.inertia, node.normal, &touches, &mut impulses);
            node.impulse = before;
            for (pair, &j) in pairs.iter_mut().filter(|pair| pair.touching).zip(&impulses) {
                node.impulse -= j.total();
                partners.add_impulse(pair.partner, j.total() - pair.impulse.total());
                pair.impulse = j;
            }
            node.impulse_velocity = velocity + node.impulse / node.inertia;
        }
    }

    /// Σ F_K·v̂_K Δt [J] over the forces of the sub-step.
    fn received_work(&self, surface: &SheetSurface<'_, D>, dt: f64) -> f64 {
        let (received, before, after) = (&self.received, surface.previous, surface.velocity);
        parallel::sum(received.len(), |k| received[k].dot(before[k] + after[k])) * (0.5 * dt)
    }
}

impl<const D: usize> ContactMethod<D> for AtNodes<D> {
    /// Maps the sheet to the grid, labels the particles around it, and measures the gaps at the nodes.
    fn find(
        &mut self,
        sheet: &mut ContactSheet<D>,
        surface: &SheetSurface<'_, D>,
        context: &StepContext<'_, D>,
        guarded: &mut Vec<GuardedParticle<D>>,
    ) -> u64 {
        self.map.map_mass(sheet, surface, context);
        self.pairs.clear();
        self.pairs.resize(self.map.nodes.len() * self.fields, NodePair::default());
        let near = self.particles_near(context);
        let ContactSheet { facets, labels, number, .. } = sheet;
        let Self { map, pairs, locator, .. } = self;
        let mut band = Band { context, surface, facets, number: *number, map, pairs, locator };
        if band.map.nodes.iter().any(|node| node.folded) {
            near.iter().enumerate().for_each(|(body, near)| band.add_arms(body, near, &labels[body]));
            band.map.find_folded_normals();
        }
        let measure = |(body, near): (usize, &Vec<u32>)| band.measure_gaps(body, near, &mut labels[body], guarded);
        near.iter().enumerate().map(measure).sum()
    }

    fn separates(&self, node: usize, fields: [usize; 2]) -> bool {
        self.map.contact_node(node).is_some_and(|node| {
            let [a, b] = fields.map(|field| self.pairs[node * self.fields + field].majority_side());
            a * b < 0.0
        })
    }

    /// Pairs with bodies that are close enough to touch during this step; all other contact nodes are dropped from
    /// the map.
    fn choose(&mut self, sheet: &ContactSheet<D>, context: &StepContext<'_, D>, partners: &mut Partners<D>) {
        let (grid, stencil) = (context.grid, context.stencil);
        let (fields, reach) = (self.fields, self.tolerance + grid.cell);
        for (r, node) in self.map.nodes.iter().enumerate() {
            for (field, pair) in self.pairs[r * fields..][..fields].iter_mut().enumerate() {
                let heavy = grid.fields[field].nodes[node.grid_node as usize].mass > stencil.cutoff
                    && node.normal != Vector::ZERO;
                if heavy && sheet.friction[field] != Friction::None && pair.least_gap() < reach + node.offset {
                    pair.partner = partners.add(grid, stencil, field, node.grid_node as usize);
                }
            }
        }
        let pairs = &self.pairs;
        self.map.retain(|node| pairs[node * fields..][..fields].iter().any(|pair| pair.partner != NONE));
    }

    fn resolve(
        &mut self,
        sheet: &mut ContactSheet<D>,
        surface: &SheetSurface<'_, D>,
        partners: &mut Partners<D>,
        pass: usize,
        at: &SubStep<'_>,
    ) {
        if !self.map.is_empty() {
            let (t, dt) = (at.momentum_end, at.momentum_dt);
            self.map.map_momentum(&sheet.facets, surface);
            if pass == 0 {
                self.detect(partners, at);
            }
            self.solve_nodes(partners, &sheet.friction, t);
            self.map.map_back(&sheet.facets, &mut sheet.forces, dt);
            self.received.iter_mut().zip(&sheet.forces).for_each(|(sum, force)| *sum += *force);
        }
        sheet.resolve_rigid_contact(surface, at);
    }

    /// Gaps follow the velocities.
    fn conclude(
        &mut self,
        sheet: &ContactSheet<D>,
        surface: &SheetSurface<'_, D>,
        partners: &Partners<D>,
        at: &SubStep<'_>,
    ) -> f64 {
        if self.map.is_empty() {
            return 0.0;
        }
        let dt = at.momentum_dt;
        self.map.map_momentum(&sheet.facets, surface);
        let mut work = 0.0;
        for (r, node) in self.map.nodes.iter().enumerate() {
            let pairs = &mut self.pairs[r * self.fields..][..self.fields];
            let after = node.project(node.momentum) / node.mass;
            let mean = node.project(node.average) / node.mass + (node.impulse_velocity - after) * 0.5;
            for pair in pairs.iter_mut().filter(|pair| pair.touching) {
                work -= pair.add_work(mean);
            }
            update_gaps(node, pairs, partners, after, at);
        }
        work - self.received_work(surface, dt)
    }

    /// No displacements and no forces to keep: contact at nodes knows no overlaps of particles, and has no warm start.
    fn finish(&self, _: &mut ContactSheet<D>, _: &mut [Vec<ParticleShift<D>>]) {}

    fn add_totals(&self, partners: &Partners<D>, grid: &Grid<D>, dt: f64, sums: &mut [ContactTotals<D>]) {
        for (index, pair) in self.pairs.iter().enumerate().filter(|(_, pair)| pair.partner != NONE) {
            let mean = partners.mean_velocity(pair.partner, grid, dt);
            let centre = self.map.nodes[index / self.fields].centre;
            let arm = if pair.mass > 0.0 { pair.moment / pair.mass - centre } else { Vector::ZERO };
            sums[index % self.fields].add(&pair.total, pair.work, mean, arm);
        }
    }

    fn meets(&self, node: usize) -> bool {
        self.map.contact_node(node).is_some()
    }
}
