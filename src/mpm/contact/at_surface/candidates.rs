//! Candidates for contact: particles of a body, or points on its skin, near a sheet, and their sides (theory D.3, D.9).

use crate::geometry::SkinPoint;
use crate::math::Vector;
use crate::mpm::contact::facet::SheetFacet;
use crate::mpm::contact::particle_size::half_size;
use crate::mpm::contact::sheet::{Foot, Label, Nearest, SEARCH_DISTANCE};
use crate::mpm::wall::folded_stencil::{Flips, FoldedStencil};
use crate::mpm::{Body, Grid};
use crate::parallel;

/// Particles per parallel task.
const TASK: usize = 256;

/// A particle, or a point on the skin of a body, within the search distance.
pub struct Candidate<const D: usize> {
    /// Number of the particle or point, the key of its label, and index of (one of) its particles.
    pub key: u32,
    pub particle: usize,
    /// Place inside the body, which tells the side of the particle [m].
    pub inside: Vector<D>,
    /// Signed distance of that place from the sheet, and whether it is beyond an edge.
    pub distance: f64,
    pub beyond: bool,
    /// Foot of the place that touches.
    pub foot: Foot<D>,
    /// Distance from there to the surface of the body [m].
    pub radius: f64,
}

/// A particle that takes part of an impulse.
#[derive(Debug, Clone, Copy)]
pub struct WeightedParticle<const D: usize> {
    /// Index of the particle.
    pub particle: u32,
    /// Place of the particle [m].
    pub place: Vector<D>,
    /// Fraction of the impulse that the particle takes.
    pub weight: f64,
}

/// Search for candidates of a body next to a sheet.
pub struct CandidateSearch<'a, const D: usize> {
    nearest: &'a Nearest<D>,
    facets: &'a [SheetFacet],
    /// Size of a cell [m].
    cell: f64,
    body: &'a Body<D>,
    /// Index of the particle of each identity; empty without a skin.
    index: Vec<u32>,
}

impl<'a, const D: usize> CandidateSearch<'a, D> {
    /// The search among particles of `body` next to a sheet of these facets, on a grid with cells of size `cell` [m].
    pub fn new(nearest: &'a Nearest<D>, facets: &'a [SheetFacet], body: &'a Body<D>, cell: f64) -> Self {
        let mut index = vec![0_u32; if body.skin.is_empty() { 0 } else { body.particles.len() }];
        if !index.is_empty() {
            body.particles.id.iter().zip(0..).for_each(|(&id, p)| index[id as usize] = p);
        }
        Self { nearest, facets, cell, body, index }
    }

    /// The candidates of the body, in a fixed order.
    pub fn all(&self) -> Vec<Candidate<D>> {
        let skin = &self.body.skin;
        let count = if skin.is_empty() { self.body.particles.len() } else { skin.len() };
        let find = |key: usize| match skin.get(key) {
            Some(point) => self.at_skin_point(key, point),
            None => self.at_particle(key),
        };
        parallel::collect_some(count, TASK, find)
    }

    /// The particles that take the impulse.
    pub fn members(&self, candidate: &Candidate<D>) -> Vec<WeightedParticle<D>> {
        match self.body.skin.get(candidate.key as usize).filter(|_| !self.index.is_empty()) {
            Some(point) => self.particles_of(point).collect(),
            None => {
                vec![WeightedParticle { particle: candidate.particle as u32, place: candidate.inside, weight: 1.0 }]
            }
        }
    }

    fn particles_of(&self, point: &SkinPoint) -> impl Iterator<Item = WeightedParticle<D>> {
        point.members.iter().map(|&(id, weight)| {
            let particle = self.index[id as usize];
            WeightedParticle { particle, place: self.body.particles.position[particle as usize], weight }
        })
    }

    fn at_particle(&self, p: usize) -> Option<Candidate<D>> {
        let inside = self.body.particles.position[p];
        let foot = self.foot(inside)?;
        let radius = half_size(&self.body.particles, p, foot.normal, self.cell);
        let (distance, beyond) = (foot.distance, foot.beyond);
        Some(Candidate { key: self.body.particles.id[p], particle: p, inside, distance, beyond, foot, radius })
    }

    fn at_skin_point(&self, key: usize, point: &SkinPoint) -> Option<Candidate<D>> {
        let tip: Vector<D> = self.particles_of(point).map(|member| member.place * member.weight).sum();
        let foot = self.foot(tip)?;
        let particles = self.particles_of(point).map(|member| member.place);
        let inside = particles.sum::<Vector<D>>() / point.members.len() as f64;
        let within = self.foot(inside)?;
        let particle = self.index[point.members[0].0 as usize] as usize;
        let (distance, beyond) = (within.distance, within.beyond || foot.beyond);
        Some(Candidate { key: key as u32, particle, inside, distance, beyond, foot, radius: point.radius })
    }

    fn foot(&self, x: Vector<D>) -> Option<Foot<D>> {
        self.nearest.foot(self.facets, x, SEARCH_DISTANCE * self.cell)
    }
}

/// The label of a candidate with the label `old` a step before, or with that of its region: kept while it stays near.
pub fn side_label<const D: usize>(old: Option<Label>, candidate: &Candidate<D>) -> Label {
    let (distance, beyond) = (candidate.distance, candidate.beyond);
    match old.filter(|label| label.side != 0.0) {
        Some(Label { side, .. }) if side * distance >= 0.0 => Label { side, crossed: false },
        Some(label) if label.crossed => label,
        Some(Label { side, .. }) if !beyond => Label { side, crossed: true },
        _ => Label { side: if beyond { 0.0 } else { distance.signum() }, crossed: false },
    }
}

/// Σ_p w_p N_Ip at the nodes of a field around some particles, normalised over the nodes that have mass.
pub fn support_of<const D: usize>(
    grid: &Grid<D>,
    stencil: &FoldedStencil<D>,
    field: usize,
    members: &[WeightedParticle<D>],
) -> Vec<(u32, Flips, f64)> {
    let (mut all, stencil) = (Vec::new(), stencil.of_field(grid, field));
    for member in members {
        stencil.for_each(grid, member.place, |node, weight, flips| {
            if grid.fields[field].nodes[node].mass > stencil.cutoff {
                all.push((node as u32, flips, member.weight * weight));
            }
        });
    }
    // A single particle comes to no node twice.
    if members.len() > 1 {
        all.sort_by_key(|&(node, flips, _)| (node, flips));
        all.dedup_by(|next, kept| {
            let same = (next.0, next.1) == (kept.0, kept.1);
            if same {
                kept.2 += next.2;
            }
            same
        });
    }
    let total: f64 = all.iter().map(|(.., weight)| weight).sum();
    all.iter_mut().for_each(|(.., weight)| *weight /= total);
    all
}
