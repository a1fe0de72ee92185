//! The map of a sheet to the grid by its samples, and the way back.
//!
//! ```text
//! m_I^r = Σ_q m_q N_I(x_q),   p̄_I^r = Σ_qK W_qK v̄_K N_I(x_q),   ν_I = Σ_q w_q a_e N_I(x_q)     Lian (49), theory (D.3)
//! F_K   = Σ_q W_qK Σ_I N_I(x_q) f_I/m_I^r,   f_I = −ΣJ_I/Δt                                    Lian (59), theory (D.4)
//! ```
//!
//! The way back is the adjoint of the map, so that Σ F_K = Σ f_I exactly. Weights and masses stay as they
//! are at the start of the step; sub-steps of the membrane map only momentum.
//!
//! If supports hold the fraction s of m_I^r along the normal, an impulse moves the rest alone, and the velocity answers
//! as if the sheet weighed m_I^r/(1 − s) (theory D.8). Held and free nodes take their parts by the same weights: if
//! the map made held ones heavier, a support would take up the pressure of all cells around it, and the sheet there
//! none.

use super::contact_node::ContactNode;
use super::samples::{SampleWeight, Samples, corner_mass};
use crate::math::Vector;
use crate::mpm::contact::facet::SheetFacet;
use crate::mpm::contact::method::StepContext;
use crate::mpm::contact::partner::NONE;
use crate::mpm::contact::sheet::ContactSheet;
use crate::mpm::contact::surface::{SheetSource, SheetSurface};
use crate::mpm::wall::folded_stencil::{Flips, flip};

/// Weight of a contact node at a sample.
#[derive(Debug, Clone, Copy)]
struct NodeWeight {
    contact_node: u32,
    flips: Flips,
    weight: f64,
}

/// A sheet on the grid.
#[derive(Debug)]
pub struct Map<const D: usize> {
    /// The nodes that it shares with bodies.
    pub nodes: Vec<ContactNode<D>>,
    /// Index of the contact node at each grid node, `NONE` where there is none.
    lookup: Vec<u32>,
    corner_mass: Vec<[f64; 4]>,
    samples: Samples,
    weights: Vec<NodeWeight>,
    /// Samples with weights, and the end of their weights in the list.
    sample_ends: Vec<(u32, u32)>,
}

impl<const D: usize> Map<D> {
    pub fn new(source: &SheetSource<'_, D>) -> Self {
        Self {
            nodes: Vec::new(),
            lookup: Vec::new(),
            corner_mass: corner_mass(&source.facets, source.reference, source.mass),
            samples: Samples::default(),
            weights: Vec::new(),
            sample_ends: Vec::new(),
        }
    }

    /// True if the sheet reaches no node.
    pub fn is_empty(&self) -> bool {
        self.weights.is_empty()
    }

    /// Index of the contact node at a grid node.
    #[inline]
    pub fn contact_node(&self, node: usize) -> Option<usize> {
        match self.lookup.get(node) {
            Some(&index) if index != NONE => Some(index as usize),
            _ => None,
        }
    }

    /// Maps mass, area and position of the sheet to the nodes that it shares with bodies.
    pub fn map_mass(&mut self, sheet: &ContactSheet<D>, surface: &SheetSurface<'_, D>, context: &StepContext<'_, D>) {
        let (grid, facets) = (context.grid, &sheet.facets);
        for node in self.nodes.drain(..) {
            self.lookup[node.grid_node as usize] = NONE;
        }
        self.lookup.resize(grid.node_count(), NONE);
        self.weights.clear();
        self.sample_ends.clear();
        self.samples.divide(facets, surface.position, &self.corner_mass, grid.cell);
        let sample_weights = self.samples.weights(facets, surface.position, grid, context.stencil);
        let mut areas = Vec::new();
        for sample_weights in sample_weights.iter().flat_map(|list| list.chunk_by(|a, b| a.sample == b.sample)) {
            self.add_sample(sheet, surface, context, sample_weights, &mut areas);
        }
        self.find_normals(context, &areas);
    }

    /// Adds the contributions of one sample to the nodes in its support.
    fn add_sample(
        &mut self,
        sheet: &ContactSheet<D>,
        surface: &SheetSurface<'_, D>,
        context: &StepContext<'_, D>,
        sample_weights: &[SampleWeight],
        areas: &mut Vec<f64>,
    ) {
        let (q, facets) = (sample_weights[0].sample as usize, &sheet.facets);
        let e = self.samples.element[q] as usize;
        let x = self.samples.position(facets, surface.position, q);
        let mass: f64 = self.samples.mass[q].iter().sum();
        let held = self.samples.held_mass(facets, |k: usize| sheet.held_fraction(k), q);
        let area = facets[e].area(surface.position) * self.samples.area_fraction[q];
        let offset = surface.offset_of(e);
        for &SampleWeight { node: grid_node, flips, weight, .. } in sample_weights {
            let node = &mut self.lookup[grid_node as usize];
            if *node == NONE {
                *node = self.nodes.len() as u32;
                self.nodes.push(ContactNode::new(grid_node as usize));
                areas.push(0.0);
            }
            self.weights.push(NodeWeight { contact_node: *node, flips, weight });
            areas[*node as usize] += area.norm() * weight;
            let node = &mut self.nodes[*node as usize];
            node.mass += mass * weight;
            node.held_mass += held * weight;
            node.normal += flip(area, flips) * weight;
            node.centre += context.stencil.mirror(context.grid, x, flips) * (mass * weight);
            node.offset += offset * mass * weight;
        }
        self.sample_ends.push((q as u32, self.weights.len() as u32));
    }

    /// Turns sums into means, and areas into normals; nodes with a negligible part of the sheet get no
    /// normal and never act, those where it is folded get theirs from [`Self::find_folded_normals`].
    fn find_normals(&mut self, context: &StepContext<'_, D>, areas: &[f64]) {
        let heaviest = self.nodes.iter().map(|node| node.mass).fold(0.0, f64::max);
        for (node, area) in self.nodes.iter_mut().zip(areas) {
            node.free = context.stencil.free(context.grid, node.grid_node as usize);
            node.centre = node.centre / node.mass;
            node.offset /= node.mass;
            let normal = node.project(node.normal);
            let (heavy, clear) = (node.mass > LEAST_MASS_FRACTION * heaviest, normal.norm() > FOLDED * area);
            node.folded = heavy && !clear;
            // Lian (51).
            node.normal = if heavy && clear { normal / normal.norm() } else { Vector::ZERO };
            node.find_inertia();
        }
    }

    /// Normals where the sheet is folded: directions of the sums of arms to the particles around, each with the sign
    /// of its side (`Band::add_arms`; theory (D.9)). Where the arms cancel, as those of a sheet along a mirror do,
    /// the normal is zero.
    pub fn find_folded_normals(&mut self) {
        for node in self.nodes.iter_mut().filter(|node| node.folded) {
            let normal = node.project(node.normal);
            let clear = normal.norm() > FOLDED * node.arm_length;
            node.normal = if clear { normal / normal.norm() } else { Vector::ZERO };
            node.find_inertia();
        }
    }

    /// Keeps the weights of the contact nodes that act, by their index.
    pub fn retain(&mut self, acts: impl Fn(usize) -> bool) {
        let (mut kept, mut sample_ends, mut start) = (Vec::new(), Vec::new(), 0);
        for &(q, end) in &self.sample_ends {
            let before = kept.len();
            kept.extend(
                self.weights[start as usize..end as usize].iter().filter(|entry| acts(entry.contact_node as usize)),
            );
            if kept.len() > before {
                sample_ends.push((q, kept.len() as u32));
            }
            start = end;
        }
        (self.weights, self.sample_ends) = (kept, sample_ends);
    }

    /// p̄_I^r, and the mean with the momentum before the forces.
    pub fn map_momentum(&mut self, facets: &[SheetFacet], surface: &SheetSurface<'_, D>) {
        for node in &mut self.nodes {
            (node.momentum, node.average) = (Vector::ZERO, Vector::ZERO);
        }
        let mut start = 0;
        for &(q, end) in &self.sample_ends {
            let nodes = facets[self.samples.element[q as usize] as usize].nodes;
            let (mut momentum, mut average) = (Vector::ZERO, Vector::ZERO);
            for (k, mass) in nodes.into_iter().zip(self.samples.mass[q as usize]) {
                let (after, before) = (surface.velocity[k as usize], surface.previous[k as usize]);
                momentum += after * mass;
                average += (after + before) * (0.5 * mass);
            }
            for entry in &self.weights[start as usize..end as usize] {
                let node = &mut self.nodes[entry.contact_node as usize];
                // Lian (49).
                node.momentum += flip(momentum, entry.flips) * entry.weight;
                node.average += flip(average, entry.flips) * entry.weight;
            }
            start = end;
        }
    }

    /// Adds the impulses of the contact nodes to the forces F_K [N] by the adjoint of the map; they act for `dt` [s].
    pub fn map_back(&self, facets: &[SheetFacet], forces: &mut [Vector<D>], dt: f64) {
        let mut start = 0;
        for &(q, end) in &self.sample_ends {
            let mut pull = Vector::ZERO;
            for entry in &self.weights[start as usize..end as usize] {
                let node = &self.nodes[entry.contact_node as usize];
                pull += flip(node.impulse, entry.flips) * (entry.weight / node.mass);
            }
            start = end;
            let nodes = facets[self.samples.element[q as usize] as usize].nodes;
            for (k, mass) in nodes.into_iter().zip(self.samples.mass[q as usize]) {
                // Lian (59).
                forces[k as usize] += pull * (mass / dt);
            }
        }
    }
}

/// Nodes with less than this fraction of the heaviest node's mass are left out.
const LEAST_MASS_FRACTION: f64 = 1e-6;

/// Fraction of the area below which the vector area gives no direction: the sheet is folded.
const FOLDED: f64 = 0.1;
