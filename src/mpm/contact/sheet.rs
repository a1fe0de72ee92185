//! One membrane on the grid: the sampled map, the nodes where it may meet bodies, and the way back.
//!
//! ```text
//! m_I^r = Σ_q m_q N_I(x_q),   p̄_I^r = Σ_qK W_qK v̄_K N_I(x_q),   ν_I = Σ_q w_q a_e N_I(x_q)      (theory 6.1)
//! F_K   = Σ_q W_qK Σ_I N_I(x_q) f_I/m_I^r                                                      (eq. 59)
//! ```
//!
//! The way back is the adjoint of the map, so that Σ F_K = Σ f_I exactly. Weights and masses stay as they
//! are at the start of the step; sub-steps of the membrane map only momentum.
//!
//! Where supports hold the share s of m_I^r along the normal, an impulse moves the rest alone, and the velocity answers as
//! if the sheet weighed m_I^r/(1 − s) (theory 6.5). Held and free nodes take their shares by the same weights: if the map
//! made held ones heavier, a support would take up the pressure of all cells around it, and the sheet there none.

use super::impulse::{self, Impulse, Settled, Touch};
use super::nodes::{Flips, Lattice, flip};
use super::partner::Partners;
use super::points::Points;
use super::rigid::{Rigid, Squeeze};
use super::row::{NONE, Pair, Row, close};
use super::sample::{Facet, Samples, Visit, corner_mass};
use crate::math::Vector;
use crate::mpm::wall::Walls;
use crate::mpm::{Friction, Grid, SubStep};

/// A membrane as contact first sees it.
#[derive(Debug, Clone)]
pub struct SheetSource<'a, const D: usize> {
    /// Name of the membrane.
    pub name: &'a str,
    /// Its elements.
    pub facets: Vec<Facet>,
    /// Node positions in the reference state [m].
    pub reference: &'a [Vector<D>],
    /// Lumped mass of each node [kg].
    pub mass: &'a [f64],
    /// Axes along which the motion of each node is prescribed.
    pub held: Vec<[bool; D]>,
}

/// A membrane as contact sees it during a step.
#[derive(Debug, Clone, Copy)]
pub struct Surface<'a, const D: usize> {
    /// Node positions [m].
    pub position: &'a [Vector<D>],
    /// Trial velocities v̄_K [m/s], with all forces but contact.
    pub velocity: &'a [Vector<D>],
    /// Velocities before the forces [m/s].
    pub previous: &'a [Vector<D>],
    /// Distance between the mid-surface and the face that bodies touch, per element [m]; empty: zero.
    pub offset: &'a [f64],
}

#[derive(Debug, Clone, Copy)]
struct Entry {
    row: u32,
    flips: Flips,
    weight: f64,
}

/// One membrane.
#[derive(Debug)]
pub(super) struct Sheet<const D: usize> {
    pub name: String,
    pub facets: Vec<Facet>,
    pub rows: Vec<Row<D>>,
    /// One pair per row and field, fields running fastest.
    pub pairs: Vec<Pair<D>>,
    /// Particles that touch the surface itself.
    pub points: Points<D>,
    /// Walls and obstacles that it touches.
    pub rigid: Rigid<D>,
    /// Where its nodes were at the start of the step [m].
    pub before: Vec<Vector<D>>,
    /// Friction with each field.
    pub friction: Vec<Friction>,
    held: Vec<[bool; D]>,
    /// 1/m_K along the axes that are free, 0 along the others [1/kg].
    softness: Vec<Vector<D>>,
    corner_mass: Vec<[f64; 4]>,
    samples: Samples,
    lookup: Vec<u32>,
    entries: Vec<Entry>,
    spans: Vec<(u32, u32)>,
    /// Change of the forces on the nodes in the last pass [N].
    forces: Vec<Vector<D>>,
    /// Node velocities after the impulses of the sub-step [m/s].
    after: Vec<Vector<D>>,
    /// Forces on the nodes in the sub-step [N].
    received: Vec<Vector<D>>,
}

impl<const D: usize> Sheet<D> {
    pub fn new(source: &SheetSource<'_, D>, friction: Vec<Friction>, listed: Vec<(String, Friction)>) -> Self {
        Self {
            name: source.name.to_owned(),
            corner_mass: corner_mass(&source.facets, source.reference, source.mass),
            facets: source.facets.clone(),
            points: Points::new(&source.facets, source.mass.len()),
            rigid: Rigid::new(source.mass.len(), listed),
            before: Vec::new(),
            forces: vec![Vector::ZERO; source.mass.len()],
            received: vec![Vector::ZERO; source.mass.len()],
            softness: (0..source.mass.len()).map(|k| softness(source.mass, &source.held, k)).collect(),
            held: source.held.clone(),
            friction,
            rows: Vec::new(),
            pairs: Vec::new(),
            samples: Samples::default(),
            lookup: Vec::new(),
            entries: Vec::new(),
            spans: Vec::new(),
            after: Vec::new(),
        }
    }

    /// The row of a grid node.
    #[inline]
    pub fn row(&self, node: usize) -> Option<usize> {
        match self.lookup.get(node) {
            Some(&row) if row != NONE => Some(row as usize),
            _ => None,
        }
    }

    /// Maps mass, area and place of the sheet to the nodes that it shares with bodies.
    pub fn map(&mut self, grid: &Grid<D>, lattice: &Lattice<D>, surface: &Surface<'_, D>) {
        for row in self.rows.drain(..) {
            self.lookup[row.node as usize] = NONE;
        }
        self.lookup.resize(grid.node_count(), NONE);
        self.entries.clear();
        self.spans.clear();
        self.samples.lay(&self.facets, surface.position, &self.corner_mass, grid.cell);
        let visits = self.samples.visits(&self.facets, surface.position, grid, lattice);
        let mut areas = Vec::new();
        for visits in visits.iter().flat_map(|list| list.chunk_by(|a, b| a.sample == b.sample)) {
            self.map_sample(grid, lattice, surface, visits, &mut areas);
        }
        self.close_rows(grid, lattice, &areas);
        self.pairs.clear();
        self.pairs.resize(self.rows.len() * self.friction.len(), Pair::default());
    }

    /// Adds what one sample brings to the nodes that it reaches.
    fn map_sample(
        &mut self,
        grid: &Grid<D>,
        lattice: &Lattice<D>,
        surface: &Surface<'_, D>,
        visits: &[Visit],
        areas: &mut Vec<f64>,
    ) {
        let q = visits[0].sample as usize;
        let e = self.samples.element[q] as usize;
        let x = self.samples.place(&self.facets, surface.position, q);
        let mass: f64 = self.samples.mass[q].iter().sum();
        let (supported, pressed) = (&self.held, &self.rigid.held);
        let held = |k: usize| Vector::from_fn(|a| if supported[k][a] { 1.0 } else { pressed[k][a] });
        let held = self.samples.held_mass(&self.facets, held, q);
        let area = self.facets[e].area(surface.position) * self.samples.share[q];
        let offset = surface.offset.get(e).copied().unwrap_or(0.0);
        for &Visit { node, flips, weight, .. } in visits {
            let row = &mut self.lookup[node as usize];
            if *row == NONE {
                *row = self.rows.len() as u32;
                self.rows.push(Row::at(node as usize));
                areas.push(0.0);
            }
            self.entries.push(Entry { row: *row, flips, weight });
            areas[*row as usize] += area.norm() * weight;
            let row = &mut self.rows[*row as usize];
            row.mass += mass * weight;
            row.held += held * weight;
            row.normal += flip(area, flips) * weight;
            row.centre += lattice.mirror(grid, x, flips) * (mass * weight);
            row.offset += offset * mass * weight;
        }
        self.spans.push((q as u32, self.entries.len() as u32));
    }

    /// Turns sums into means; rows with a negligible share of the sheet get no normal and never act, those where it is
    /// folded get theirs from [`Self::unfold`].
    fn close_rows(&mut self, grid: &Grid<D>, lattice: &Lattice<D>, areas: &[f64]) {
        let heaviest = self.rows.iter().map(|row| row.mass).fold(0.0, f64::max);
        for (row, area) in self.rows.iter_mut().zip(areas) {
            row.free = lattice.free(grid, row.node as usize);
            row.centre = row.centre / row.mass;
            row.offset /= row.mass;
            let normal = row.project(row.normal);
            let (heavy, clear) = (row.mass > LEAST * heaviest, normal.norm() > FOLDED * area);
            row.folded = heavy && !clear;
            row.normal = if heavy && clear { normal / normal.norm() } else { Vector::ZERO };
            row.find_inertia();
        }
    }

    /// Where the sheet is folded, the normals become directions: the sums of arms to the particles around, each turned
    /// to the side that it is on ([`super::band::Band::lean`]). Where the arms cancel, as those of a sheet along a mirror do, what is
    /// left of them is no direction.
    pub fn unfold(&mut self) {
        for row in self.rows.iter_mut().filter(|row| row.folded) {
            let normal = row.project(row.normal);
            let clear = normal.norm() > FOLDED * row.arms;
            row.normal = if clear { normal / normal.norm() } else { Vector::ZERO };
            row.find_inertia();
        }
    }

    /// True if the sheet runs between the two fields at this grid node.
    pub fn parts(&self, node: usize, [a, b]: [usize; 2]) -> bool {
        let fields = self.friction.len();
        self.row(node)
            .is_some_and(|r| self.pairs[r * fields + a].present() * self.pairs[r * fields + b].present() < 0.0)
            || self.points.parts(node, [a, b])
    }

    /// Finds, for the bodies that are close enough to touch during this step, their nodes among the partners;
    /// drops everything else from the map.
    pub fn choose(&mut self, grid: &Grid<D>, lattice: &Lattice<D>, partners: &mut Partners<D>, reach: f64) {
        self.points.choose(grid, lattice, partners, &self.softness);
        let fields = self.friction.len();
        for (r, row) in self.rows.iter().enumerate() {
            for (field, pair) in self.pairs[r * fields..][..fields].iter_mut().enumerate() {
                let heavy =
                    grid.fields[field].nodes[row.node as usize].mass > lattice.cutoff && row.normal != Vector::ZERO;
                if heavy && self.friction[field] != Friction::None && pair.distance() < reach + row.offset {
                    pair.partner = partners.add(grid, lattice, field, row.node as usize);
                }
            }
        }
        let acts = |row: u32| self.pairs[row as usize * fields..][..fields].iter().any(|pair| pair.partner != NONE);
        let (mut kept, mut spans, mut start) = (Vec::new(), Vec::new(), 0);
        for &(q, end) in &self.spans {
            let before = kept.len();
            kept.extend(self.entries[start as usize..end as usize].iter().filter(|entry| acts(entry.row)));
            if kept.len() > before {
                spans.push((q, kept.len() as u32));
            }
            start = end;
        }
        (self.entries, self.spans) = (kept, spans);
    }

    /// One pass of contact at the end of a sub-step: the force on each node [N], in further passes its change.
    pub fn resolve(
        &mut self,
        pass: usize,
        surface: &Surface<'_, D>,
        (partners, walls): (&mut Partners<D>, &Walls<D>),
        [tolerance, cell]: [f64; 2],
        at: &SubStep<'_>,
    ) -> &[Vector<D>] {
        let times = [at.momentum_end, at.momentum_dt];
        self.forces.fill(Vector::ZERO);
        if pass == 0 {
            self.rigid.begin(walls, &self.facets, surface, at, cell);
        }
        if pass == 0 && !self.points.is_empty() {
            self.touch(surface, partners, at);
        }
        if !self.entries.is_empty() {
            self.map_momentum(surface);
            if pass == 0 {
                self.meet(partners, tolerance, times);
            }
            self.push(partners, times);
        }
        // Where particles touch, walls had the last word in their sweeps, and the work is booked.
        if !self.rigid.is_empty() && self.points.is_empty() {
            self.rest(surface, at);
        }
        &self.forces
    }

    /// Contact with walls and obstacles alone, after the forces of this pass.
    fn rest(&mut self, surface: &Surface<'_, D>, at: &SubStep<'_>) {
        let Self { rigid, softness, forces, after, .. } = self;
        let soft = |k: usize| softness[k];
        after.clear();
        after.extend((0..softness.len()).map(|k| {
            let (v, soft) = (surface.velocity[k], soft(k));
            Vector::from_fn(|a| v[a] + soft[a] * forces[k][a] * at.momentum_dt)
        }));
        rigid.settle(after, &soft, at.dt);
        rigid.hand_over(forces, at.momentum_dt);
    }

    /// Ends the sub-step, with the velocities that the nodes have in the end: gaps, and the energy that the map
    /// loses [J].
    pub fn conclude(&mut self, surface: &Surface<'_, D>, partners: &Partners<D>, [t, dt]: [f64; 2]) -> f64 {
        self.rigid.conclude(surface);
        if self.entries.is_empty() {
            return 0.0;
        }
        self.map_momentum(surface);
        let fields = self.friction.len();
        let mut work = 0.0;
        for (r, row) in self.rows.iter().enumerate() {
            let pairs = &mut self.pairs[r * fields..][..fields];
            let after = row.project(row.momentum) / row.mass;
            let mean = row.project(row.average) / row.mass + (row.pushed - after) * 0.5;
            for pair in pairs.iter_mut().filter(|pair| pair.touching) {
                work -= pair.receive(mean);
            }
            close(row, pairs, partners, after, [t, dt]);
        }
        work - self.received_work(surface, dt)
    }

    /// Parts the sheet from walls and obstacles that it overlaps with, after its nodes have moved to `position` [m].
    pub fn part(&self, position: &mut [Vector<D>], at: &SubStep<'_>) {
        self.rigid.part(position, &|k: usize| self.softness[k], at.elapsed + at.dt);
    }

    /// A point that has no way out between walls, obstacles and supports `elapsed` [s] after the start of the step; positions of the
    /// nodes now and at the start of the run [m].
    pub fn squeezed(&self, positions: [&[Vector<D>]; 2], (walls, elapsed): (&Walls<D>, f64)) -> Option<Squeeze<D>> {
        self.rigid.squeezed((walls, elapsed), positions, &self.held)
    }

    /// Contact with the particles that touch the surface, and with walls and obstacles.
    fn touch(&mut self, surface: &Surface<'_, D>, partners: &mut Partners<D>, at: &SubStep<'_>) {
        let Self { points, rigid, softness, forces, after, .. } = self;
        after.clear();
        after.extend_from_slice(surface.velocity);
        points.resolve((partners, rigid), (after, softness), forces, at);
        points.book(|k| (surface.previous[k] + after[k]) * 0.5);
    }

    /// p̄_I^r, and the mean with the momentum before the forces.
    fn map_momentum(&mut self, surface: &Surface<'_, D>) {
        for row in &mut self.rows {
            (row.momentum, row.average) = (Vector::ZERO, Vector::ZERO);
        }
        let mut start = 0;
        for &(q, end) in &self.spans {
            let nodes = self.facets[self.samples.element[q as usize] as usize].nodes;
            let (mut momentum, mut average) = (Vector::ZERO, Vector::ZERO);
            for (k, mass) in nodes.into_iter().zip(self.samples.mass[q as usize]) {
                let (after, before) = (surface.velocity[k as usize], surface.previous[k as usize]);
                momentum += after * mass;
                average += (after + before) * (0.5 * mass);
            }
            for entry in &self.entries[start as usize..end as usize] {
                let row = &mut self.rows[entry.row as usize];
                row.momentum += flip(momentum, entry.flips) * entry.weight;
                row.average += flip(average, entry.flips) * entry.weight;
            }
            start = end;
        }
    }

    /// Marks the pairs whose gap closes by the time `t` [s] after the start of the step, at the end of a sub-step of
    /// length `dt` [s] (52); they have exchanged nothing yet.
    fn meet(&mut self, partners: &Partners<D>, tolerance: f64, [t, dt]: [f64; 2]) {
        self.received.fill(Vector::ZERO);
        let fields = self.friction.len();
        for (r, row) in self.rows.iter().enumerate() {
            let velocity = row.project(row.momentum) / row.mass;
            for pair in self.pairs[r * fields..][..fields].iter_mut().filter(|pair| pair.partner != NONE) {
                let (_, v) = partners.trial(pair.partner, t);
                let w = (row.project(v) - velocity).dot(row.normal);
                let gap = pair.turn(w);
                pair.touching = gap - row.offset + (w * pair.side * dt).min(0.0) <= tolerance;
                pair.held = Impulse::default();
            }
        }
    }

    /// Solves every row for the impulses of the whole sub-step, as if its last were not there yet: they may shrink,
    /// but never pull. The nodes get the change.
    fn push(&mut self, partners: &mut Partners<D>, [t, dt]: [f64; 2]) {
        let fields = self.friction.len();
        let (mut touches, mut impulses) = (Vec::new(), Vec::new());
        for (r, row) in self.rows.iter_mut().enumerate() {
            let pairs = &mut self.pairs[r * fields..][..fields];
            let velocity = row.project(row.momentum) / row.mass;
            let held: Vector<D> = pairs.iter().filter(|pair| pair.touching).map(|pair| pair.held.total()).sum();
            touches.clear();
            for (field, pair) in pairs.iter().enumerate().filter(|(_, pair)| pair.touching) {
                let (mass, v) = partners.trial(pair.partner, t);
                let (side, friction) = (pair.side, self.friction[field]);
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
        self.map_back(dt);
    }

    /// F_K by the adjoint of the map.
    fn map_back(&mut self, dt: f64) {
        let mut start = 0;
        for &(q, end) in &self.spans {
            let mut pull = Vector::ZERO;
            for entry in &self.entries[start as usize..end as usize] {
                let row = &self.rows[entry.row as usize];
                pull += flip(row.impulse, entry.flips) * (entry.weight / row.mass);
            }
            start = end;
            let nodes = self.facets[self.samples.element[q as usize] as usize].nodes;
            for (k, mass) in nodes.into_iter().zip(self.samples.mass[q as usize]) {
                self.forces[k as usize] += pull * (mass / dt);
            }
        }
        self.received.iter_mut().zip(&self.forces).for_each(|(sum, force)| *sum += *force);
    }

    /// Σ F_K·v̂_K Δt [J] over the forces of the sub-step.
    fn received_work(&self, surface: &Surface<'_, D>, dt: f64) -> f64 {
        let nodes = self.received.iter().zip(surface.previous.iter().zip(surface.velocity));
        nodes.map(|(force, (before, after))| force.dot(*before + *after)).sum::<f64>() * (0.5 * dt)
    }

    /// The impulses of the step, field by field, and what was lost: J·(v̂_r − v̂_s).
    pub fn settle(&self, partners: &Partners<D>, grid: &Grid<D>, dt: f64) -> Vec<Settled<D>> {
        let fields = self.friction.len();
        let mut sums = vec![Settled::default(); fields];
        for (index, pair) in self.pairs.iter().enumerate().filter(|(_, pair)| pair.partner != NONE) {
            let mean = partners.mean_velocity(pair.partner, grid, dt);
            let arm =
                if pair.mass > 0.0 { pair.moment / pair.mass - self.rows[index / fields].centre } else { Vector::ZERO };
            sums[index % fields].add(&pair.total, pair.work, mean, arm);
        }
        self.points.settle(partners, grid, dt, &mut sums);
        sums
    }
}

/// 1/m_K along the axes that are free, 0 along the others [1/kg].
fn softness<const D: usize>(mass: &[f64], held: &[[bool; D]], k: usize) -> Vector<D> {
    Vector::from_fn(|axis| if held[k][axis] { 0.0 } else { 1.0 / mass[k] })
}

/// Nodes with less than this share of the heaviest node's mass are left out.
const LEAST: f64 = 1e-6;

/// Where the vector area is less than this share of the area, the sheet is folded and gives no direction.
const FOLDED: f64 = 0.1;
