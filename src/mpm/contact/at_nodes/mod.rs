//! Contact at grid nodes, as in the paper (Lian, Liu & Zhang 2014, section 5, with eqs. 55, 58 and 59 corrected; theory
//! D.2 to D.8): where a sheet and a body both have mass at a node, approach, and have closed their gap, they exchange an impulse.
//!
//! ```text
//! (v̄_r − v̄_s)·n > 0  and  g − Δt (v̄_r − v̄_s)·n ≤ tol                    detection          (50, 52)
//! J = M (v̄_r − v̄_s),  M = m_r m_s/(m_r + m_s)                           stick, on s        (54, 55)
//! J = J_n n + min(‖J_t‖, μ_f |J_n|) J_t/‖J_t‖,  no pulling               slip, on s         (56–58)
//! p_s ← p_s + J                                                          the body           (53)
//! v_K ← v_K − 1/m_K Σ_q W_qK Σ_I N_I(x_q) J_I/m_I^r                      the sheet          (59)
//! ```
//!
//! The sheet comes to the nodes by its samples (`samples`, `map`), the gaps from the particles around it (`band`), and the impulses
//! from the masses at a node (`contact_node`, [`super::impulse`]). The nodes of the sheet take up less than the grid gives, so
//! that contact is resolved in passes (theory D.7). Walls and obstacles follow in each.

mod band;
mod contact_node;
mod map;
mod samples;

use super::impulse::{self, Impulse, Settled, Touch};
use super::method::{ContactMethod, StepContext};
use super::partner::{NONE, Partners};
use super::sheet::{Locator, Near, Sheet, SheetSource, Shift, Surface};
use super::support_blocks::Marks;
use crate::math::Vector;
use crate::mpm::{Body, Friction, Grid, SubStep};
use band::Band;
use contact_node::{NodePair, close};
use map::Map;

/// Contact of one sheet at grid nodes.
#[derive(Debug)]
pub struct AtNodes<const D: usize> {
    map: Map<D>,
    /// One pair per row and field, fields running fastest.
    pairs: Vec<NodePair<D>>,
    fields: usize,
    /// Gap below which contact acts [m].
    tolerance: f64,
    /// Particles near the rows.
    marks: Marks,
    /// True distances from the sheet, where those to its rows are in doubt.
    locator: Locator<D>,
    /// Forces on the nodes in the sub-step [N].
    received: Vec<Vector<D>>,
}

impl<const D: usize> AtNodes<D> {
    /// For a sheet and so many fields; `tolerance` [m] is the gap below which contact acts.
    pub fn new(source: &SheetSource<'_, D>, fields: usize, tolerance: f64) -> Self {
        Self {
            map: Map::new(source),
            pairs: Vec::new(),
            fields,
            tolerance,
            marks: Marks::default(),
            locator: Locator::new(&source.facets),
            received: vec![Vector::ZERO; source.mass.len()],
        }
    }

    /// The particles of each body whose support reaches a row.
    fn near(&mut self, scene: &StepContext<'_, D>) -> Vec<Vec<u32>> {
        self.marks.clear(scene.grid);
        for row in &self.map.rows {
            self.marks.mark(scene.grid, scene.lattice, row.node as usize);
        }
        let near = |body: &Body<D>| self.marks.near(scene.grid, scene.lattice, &body.particles.position);
        scene.bodies.iter().map(near).collect()
    }

    /// Marks the pairs whose gap closes by the time `t` [s] after the start of the step, at the end of a sub-step of
    /// length `dt` [s] (50, 52; theory (D.10)); they have exchanged nothing yet.
    fn meet(&mut self, partners: &Partners<D>, [t, dt]: [f64; 2]) {
        self.received.fill(Vector::ZERO);
        let fields = self.fields;
        for (r, row) in self.map.rows.iter().enumerate() {
            let velocity = row.project(row.momentum) / row.mass;
            for pair in self.pairs[r * fields..][..fields].iter_mut().filter(|pair| pair.partner != NONE) {
                let (_, v) = partners.trial(pair.partner, t);
                let w = (row.project(v) - velocity).dot(row.normal);
                let gap = pair.turn(w);
                pair.touching = gap - row.offset + (w * pair.side * dt).min(0.0) <= self.tolerance;
                pair.held = Impulse::default();
            }
        }
    }

    /// Solves every row for the impulses of the whole sub-step, as if its last were not there yet: they may shrink,
    /// but never pull (53–58; theory (D.12), (D.15)). The rows get the change.
    fn push(&mut self, partners: &mut Partners<D>, friction: &[Friction], t: f64) {
        let fields = self.fields;
        let (mut touches, mut impulses) = (Vec::new(), Vec::new());
        for (r, row) in self.map.rows.iter_mut().enumerate() {
            let pairs = &mut self.pairs[r * fields..][..fields];
            let velocity = row.project(row.momentum) / row.mass;
            let held: Vector<D> = pairs.iter().filter(|pair| pair.touching).map(|pair| pair.held.total()).sum();
            touches.clear();
            for (field, pair) in pairs.iter().enumerate().filter(|(_, pair)| pair.touching) {
                let (mass, v) = partners.trial(pair.partner, t);
                let (side, friction) = (pair.side, friction[field]);
                touches.push(Touch { mass, velocity: row.project(v) - pair.held.total() / mass, side, friction });
            }
            impulse::solve(row.inertia, velocity + held / row.inertia, row.normal, &touches, &mut impulses);
            row.impulse = held;
            for (pair, &j) in pairs.iter_mut().filter(|pair| pair.touching).zip(&impulses) {
                row.impulse -= j.total();
                partners.push(pair.partner, j.total() - pair.held.total());
                pair.held = j;
            }
            row.pushed = velocity + row.impulse / row.inertia;
        }
    }

    /// Σ F_K·v̂_K Δt [J] over the forces of the sub-step.
    fn received_work(&self, surface: &Surface<'_, D>, dt: f64) -> f64 {
        let nodes = self.received.iter().zip(surface.previous.iter().zip(surface.velocity));
        nodes.map(|(force, (before, after))| force.dot(*before + *after)).sum::<f64>() * (0.5 * dt)
    }
}

impl<const D: usize> ContactMethod<D> for AtNodes<D> {
    /// Maps the sheet to the grid, labels the particles around it, and measures the gaps at the nodes.
    fn find(
        &mut self,
        sheet: &mut Sheet<D>,
        surface: &Surface<'_, D>,
        scene: &StepContext<'_, D>,
        guarded: &mut Vec<Near<D>>,
    ) -> u64 {
        self.map.lay(sheet, surface, scene);
        self.pairs.clear();
        self.pairs.resize(self.map.rows.len() * self.fields, NodePair::default());
        let near = self.near(scene);
        let Sheet { facets, labels, number, .. } = sheet;
        let Self { map, pairs, locator, .. } = self;
        let mut band = Band { scene, surface, facets, number: *number, map, pairs, locator };
        if band.map.rows.iter().any(|row| row.folded) {
            near.iter().enumerate().for_each(|(body, near)| band.lean(body, near, &labels[body]));
            band.map.unfold();
        }
        let measure = |(body, near): (usize, &Vec<u32>)| band.measure(body, near, &mut labels[body], guarded);
        near.iter().enumerate().map(measure).sum()
    }

    fn parts(&self, node: usize, fields: [usize; 2]) -> bool {
        self.map.row(node).is_some_and(|row| {
            let [a, b] = fields.map(|field| self.pairs[row * self.fields + field].present());
            a * b < 0.0
        })
    }

    /// Takes the bodies that are close enough to touch during this step, and drops everything else from the map.
    fn choose(&mut self, sheet: &Sheet<D>, scene: &StepContext<'_, D>, partners: &mut Partners<D>) {
        let (grid, lattice) = (scene.grid, scene.lattice);
        let (fields, reach) = (self.fields, self.tolerance + grid.cell);
        for (r, row) in self.map.rows.iter().enumerate() {
            for (field, pair) in self.pairs[r * fields..][..fields].iter_mut().enumerate() {
                let heavy =
                    grid.fields[field].nodes[row.node as usize].mass > lattice.cutoff && row.normal != Vector::ZERO;
                if heavy && sheet.friction[field] != Friction::None && pair.distance() < reach + row.offset {
                    pair.partner = partners.add(grid, lattice, field, row.node as usize);
                }
            }
        }
        let pairs = &self.pairs;
        self.map.keep(|row| pairs[row * fields..][..fields].iter().any(|pair| pair.partner != NONE));
    }

    fn resolve(
        &mut self,
        sheet: &mut Sheet<D>,
        surface: &Surface<'_, D>,
        partners: &mut Partners<D>,
        pass: usize,
        at: &SubStep<'_>,
    ) {
        if !self.map.is_empty() {
            let (t, dt) = (at.momentum_end, at.momentum_dt);
            self.map.map_momentum(&sheet.facets, surface);
            if pass == 0 {
                self.meet(partners, [t, dt]);
            }
            self.push(partners, &sheet.friction, t);
            self.map.map_back(&sheet.facets, &mut sheet.forces, dt);
            self.received.iter_mut().zip(&sheet.forces).for_each(|(sum, force)| *sum += *force);
        }
        sheet.meet_walls(surface, at);
    }

    /// Gaps follow the velocities.
    fn conclude(
        &mut self,
        sheet: &Sheet<D>,
        surface: &Surface<'_, D>,
        partners: &Partners<D>,
        at: &SubStep<'_>,
    ) -> f64 {
        if self.map.is_empty() {
            return 0.0;
        }
        let (t, dt) = (at.momentum_end, at.momentum_dt);
        self.map.map_momentum(&sheet.facets, surface);
        let mut work = 0.0;
        for (r, row) in self.map.rows.iter().enumerate() {
            let pairs = &mut self.pairs[r * self.fields..][..self.fields];
            let after = row.project(row.momentum) / row.mass;
            let mean = row.project(row.average) / row.mass + (row.pushed - after) * 0.5;
            for pair in pairs.iter_mut().filter(|pair| pair.touching) {
                work -= pair.receive(mean);
            }
            close(row, pairs, partners, after, [t, dt]);
        }
        work - self.received_work(surface, dt)
    }

    /// Nothing is left to do: nodes don't see particles that overlap, and remember no forces.
    fn finish(&self, _: &mut Sheet<D>, _: &mut [Vec<Shift<D>>]) {}

    fn settle(&self, partners: &Partners<D>, grid: &Grid<D>, dt: f64, sums: &mut [Settled<D>]) {
        for (index, pair) in self.pairs.iter().enumerate().filter(|(_, pair)| pair.partner != NONE) {
            let mean = partners.mean_velocity(pair.partner, grid, dt);
            let centre = self.map.rows[index / self.fields].centre;
            let arm = if pair.mass > 0.0 { pair.moment / pair.mass - centre } else { Vector::ZERO };
            sums[index % self.fields].add(&pair.total, pair.work, mean, arm);
        }
    }

    fn meets(&self, node: usize) -> bool {
        self.map.row(node).is_some()
    }
}
