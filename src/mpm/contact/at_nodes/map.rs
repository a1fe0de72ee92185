//! The map of a sheet to the grid by its samples, and the way back.
//!
//! ```text
//! m_I^r = Σ_q m_q N_I(x_q),   p̄_I^r = Σ_qK W_qK v̄_K N_I(x_q),   ν_I = Σ_q w_q a_e N_I(x_q)      (49; theory (D.3))
//! F_K   = Σ_q W_qK Σ_I N_I(x_q) f_I/m_I^r,   f_I = −ΣJ_I/Δt                                     (59; theory (D.4))
//! ```
//!
//! The way back is the adjoint of the map, so that Σ F_K = Σ f_I exactly. Weights and masses stay as they
//! are at the start of the step; sub-steps of the membrane map only momentum.
//!
//! Where supports hold the share s of m_I^r along the normal, an impulse moves the rest alone, and the velocity answers as
//! if the sheet weighed m_I^r/(1 − s) (theory D.8). Held and free nodes take their shares by the same weights: if the map
//! made held ones heavier, a support would take up the pressure of all cells around it, and the sheet there none.

use super::contact_node::ContactNode;
use super::samples::{Samples, Visit, corner_mass};
use crate::math::Vector;
use crate::mpm::contact::folded_stencil::{Flips, flip};
use crate::mpm::contact::method::StepContext;
use crate::mpm::contact::partner::NONE;
use crate::mpm::contact::sheet::{Facet, Sheet, SheetSource, Surface};

/// A row that a sample reaches.
#[derive(Debug, Clone, Copy)]
struct Entry {
    row: u32,
    flips: Flips,
    weight: f64,
}

/// A sheet on the grid.
#[derive(Debug)]
pub struct Map<const D: usize> {
    /// The nodes that it shares with bodies.
    pub rows: Vec<ContactNode<D>>,
    /// Row of each grid node, `NONE` where there is none.
    lookup: Vec<u32>,
    corner_mass: Vec<[f64; 4]>,
    samples: Samples,
    entries: Vec<Entry>,
    /// Samples that reach rows, and where their entries end.
    spans: Vec<(u32, u32)>,
}

impl<const D: usize> Map<D> {
    pub fn new(source: &SheetSource<'_, D>) -> Self {
        Self {
            rows: Vec::new(),
            lookup: Vec::new(),
            corner_mass: corner_mass(&source.facets, source.reference, source.mass),
            samples: Samples::default(),
            entries: Vec::new(),
            spans: Vec::new(),
        }
    }

    /// True if the sheet reaches no row.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
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
    pub fn lay(&mut self, sheet: &Sheet<D>, surface: &Surface<'_, D>, scene: &StepContext<'_, D>) {
        let (grid, facets) = (scene.grid, &sheet.facets);
        for row in self.rows.drain(..) {
            self.lookup[row.node as usize] = NONE;
        }
        self.lookup.resize(grid.node_count(), NONE);
        self.entries.clear();
        self.spans.clear();
        self.samples.lay(facets, surface.position, &self.corner_mass, grid.cell);
        let visits = self.samples.visits(facets, surface.position, grid, scene.lattice);
        let mut areas = Vec::new();
        for visits in visits.iter().flat_map(|list| list.chunk_by(|a, b| a.sample == b.sample)) {
            self.add_sample(sheet, surface, scene, visits, &mut areas);
        }
        self.close_rows(scene, &areas);
    }

    /// Adds what one sample brings to the nodes that it reaches.
    fn add_sample(
        &mut self,
        sheet: &Sheet<D>,
        surface: &Surface<'_, D>,
        scene: &StepContext<'_, D>,
        visits: &[Visit],
        areas: &mut Vec<f64>,
    ) {
        let (q, facets) = (visits[0].sample as usize, &sheet.facets);
        let e = self.samples.element[q] as usize;
        let x = self.samples.place(facets, surface.position, q);
        let mass: f64 = self.samples.mass[q].iter().sum();
        let held = self.samples.held_mass(facets, |k: usize| sheet.held_share(k), q);
        let area = facets[e].area(surface.position) * self.samples.share[q];
        let offset = surface.offset_of(e);
        for &Visit { node, flips, weight, .. } in visits {
            let row = &mut self.lookup[node as usize];
            if *row == NONE {
                *row = self.rows.len() as u32;
                self.rows.push(ContactNode::at(node as usize));
                areas.push(0.0);
            }
            self.entries.push(Entry { row: *row, flips, weight });
            areas[*row as usize] += area.norm() * weight;
            let row = &mut self.rows[*row as usize];
            row.mass += mass * weight;
            row.held += held * weight;
            row.normal += flip(area, flips) * weight;
            row.centre += scene.lattice.mirror(scene.grid, x, flips) * (mass * weight);
            row.offset += offset * mass * weight;
        }
        self.spans.push((q as u32, self.entries.len() as u32));
    }

    /// Turns sums into means, and areas into normals (51); rows with a negligible share of the sheet get no normal and never
    /// act, those where it is folded get theirs from [`Self::unfold`].
    fn close_rows(&mut self, scene: &StepContext<'_, D>, areas: &[f64]) {
        let heaviest = self.rows.iter().map(|row| row.mass).fold(0.0, f64::max);
        for (row, area) in self.rows.iter_mut().zip(areas) {
            row.free = scene.lattice.free(scene.grid, row.node as usize);
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
    /// to the side that it is on (`Band::lean`). Where the arms cancel, as those of a sheet along a mirror do, what is
    /// left of them is no direction.
    pub fn unfold(&mut self) {
        for row in self.rows.iter_mut().filter(|row| row.folded) {
            let normal = row.project(row.normal);
            let clear = normal.norm() > FOLDED * row.arms;
            row.normal = if clear { normal / normal.norm() } else { Vector::ZERO };
            row.find_inertia();
        }
    }

    /// Drops all entries of other rows than those that act.
    pub fn keep(&mut self, acts: impl Fn(usize) -> bool) {
        let (mut kept, mut spans, mut start) = (Vec::new(), Vec::new(), 0);
        for &(q, end) in &self.spans {
            let before = kept.len();
            kept.extend(self.entries[start as usize..end as usize].iter().filter(|entry| acts(entry.row as usize)));
            if kept.len() > before {
                spans.push((q, kept.len() as u32));
            }
            start = end;
        }
        (self.entries, self.spans) = (kept, spans);
    }

    /// p̄_I^r (49), and the mean with the momentum before the forces.
    pub fn map_momentum(&mut self, facets: &[Facet], surface: &Surface<'_, D>) {
        for row in &mut self.rows {
            (row.momentum, row.average) = (Vector::ZERO, Vector::ZERO);
        }
        let mut start = 0;
        for &(q, end) in &self.spans {
            let nodes = facets[self.samples.element[q as usize] as usize].nodes;
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

    /// Adds the impulses of the rows to the forces F_K [N] by the adjoint of the map (59); they act for `dt` [s].
    pub fn map_back(&self, facets: &[Facet], forces: &mut [Vector<D>], dt: f64) {
        let mut start = 0;
        for &(q, end) in &self.spans {
            let mut pull = Vector::ZERO;
            for entry in &self.entries[start as usize..end as usize] {
                let row = &self.rows[entry.row as usize];
                pull += flip(row.impulse, entry.flips) * (entry.weight / row.mass);
            }
            start = end;
            let nodes = facets[self.samples.element[q as usize] as usize].nodes;
            for (k, mass) in nodes.into_iter().zip(self.samples.mass[q as usize]) {
                forces[k as usize] += pull * (mass / dt);
            }
        }
    }
}

/// Nodes with less than this share of the heaviest node's mass are left out.
const LEAST: f64 = 1e-6;

/// Where the vector area is less than this share of the area, the sheet is folded and gives no direction.
const FOLDED: f64 = 0.1;
