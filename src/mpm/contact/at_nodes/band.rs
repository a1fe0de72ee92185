//! Particles near a sheet: their side, their distance, and the gaps at the nodes.
//!
//! ```text
//! δ_p = Σ_I N_Ip (x_p − x̄_I)·n_I / Σ_I N_Ip             signed distance to the sheet as the grid sees it
//! c_p = the side of the particle's region of a closed sheet; of others sign δ_p when the
//!       particle comes near, then kept while it stays near                               (theory D.3)
//! g_I = min {c_p δ_p − r_p : p in the support of I} − t/2                                 (theory (D.5))
//! ```
//!
//! On a sheet of curvature κ the planes of δ lie κh²/8 beside the surface in the mean, and the centroids
//! x̄_I as much on the other side: with quadratic shape functions δ is exact to third order. Particles found
//! at δ_p c_p < 0 are checked with the true distance and counted as crossed.

use super::contact_node::NodePair;
use super::map::Map;
use crate::math::Vector;
use crate::mpm::contact::facet::SheetFacet;
use crate::mpm::contact::method::StepContext;
use crate::mpm::contact::particle_size::half_size;
use crate::mpm::contact::sheet::{
    FacetLocator, GuardedParticle, HEIGHT_ERROR, Label, Labels, ParticleAtSheet, SheetPosition, SideOfSheet,
};
use crate::mpm::contact::surface::SheetSurface;
use crate::mpm::wall::folded_stencil::flip;
use crate::mpm::{Body, Particles};
use crate::parallel;

/// Signed distance δ_p of a particle from the planes of the sheet at the nodes around it [m], its half size r_p [m],
/// and the mean normal.
#[derive(Debug, Clone, Copy)]
struct PlaneDistance<const D: usize> {
    distance: f64,
    radius: f64,
    normal: Vector<D>,
}

/// Particles per parallel task.
const TASK: usize = 1024;

/// The measurement of gaps between one sheet and the particles around it.
pub struct Band<'a, const D: usize> {
    pub context: &'a StepContext<'a, D>,
    pub surface: &'a SheetSurface<'a, D>,
    pub facets: &'a [SheetFacet],
    /// Number of the sheet.
    pub number: usize,
    pub map: &'a mut Map<D>,
    /// One pair per contact node and field, fields running fastest.
    pub pairs: &'a mut [NodePair<D>],
    pub locator: &'a mut FacetLocator<D>,
}

impl<const D: usize> Band<'_, D> {
    /// Adds the arms to the particles of a body `near` the sheet to the normals of nodes where it is folded, each with
    /// the sign of the particle's side (theory (D.9)).
    pub fn add_arms(&mut self, body: usize, near: &[u32], labels: &Labels) {
        let StepContext { grid, stencil, step, .. } = *self.context;
        let (field, body) = (self.context.bodies.field_of(body), &self.context.bodies[body]);
        for &p in near {
            let (x, id) = (body.particles.position[p as usize], body.particles.id[p as usize]);
            let mut side = None;
            stencil.of_field(grid, field).for_each(grid, x, |node, weight, flips| {
                let index = self.map.contact_node(node).filter(|&index| self.map.nodes[index].folded);
                let Some(index) = index else { return };
                let side = *side.get_or_insert_with(|| match labels.recall(id, step - 1) {
                    Some(label) if label.side != 0.0 => label.side,
                    _ => match self.position_of(x) {
                        SheetPosition::Beside(d) => d.signum(),
                        SheetPosition::Beyond | SheetPosition::Away => 0.0,
                    },
                });
                let contact_node = &mut self.map.nodes[index];
                let arm = stencil.mirror(grid, x, flips) - contact_node.centre;
                let mass = body.particles.mass[p as usize] * weight;
                contact_node.normal += arm * (side * mass);
                contact_node.arm_length += arm.norm() * mass;
            });
        }
    }

    /// Labels the particles of a body `near` the sheet and lowers the gaps at the contact nodes; adds those with
    /// a side to `guarded`. Returns how many have crossed the sheet since the last step.
    pub fn measure_gaps(
        &mut self,
        index: usize,
        near: &[u32],
        labels: &mut Labels,
        guarded: &mut Vec<GuardedParticle<D>>,
    ) -> u64 {
        let (context, field) = (self.context, self.context.bodies.field_of(index));
        let body = &context.bodies[index];
        let particles = &body.particles;
        let band = &*self;
        let distances: Vec<_> =
            parallel::collect(near.len(), TASK, |n| band.distance_from_planes(particles, near[n] as usize));
        let mut crossed = 0;
        for (&p, distance) in near.iter().zip(distances) {
            let Some(PlaneDistance { distance, radius, normal }) = distance else { continue };
            let (p, id) = (p as usize, particles.id[p as usize]);
            let old = labels.recall(id, context.step - 1);
            let label = self.label(particles.position[p], old, distance);
            crossed += u64::from(label.crossed && old.is_none_or(|old| !old.crossed));
            labels.keep(id, context.step, label);
            if label.side != 0.0 {
                let height = label.side * distance;
                self.lower_gaps(field, body, p, label.side, height - radius);
                let at = ParticleAtSheet { particle: p, body: index, sheet: self.number };
                let height = height - HEIGHT_ERROR * context.grid.cell;
                let beside = SideOfSheet { side: label.side, normal, height };
                guarded.push(GuardedParticle::new(at, beside, radius, particles.position[p]));
            }
        }
        crossed
    }

    /// δ_p and r_p, if a contact node with a normal is in the support.
    fn distance_from_planes(&self, particles: &Particles<D>, p: usize) -> Option<PlaneDistance<D>> {
        let StepContext { grid, stencil, .. } = *self.context;
        let (map, x) = (&*self.map, particles.position[p]);
        let (mut height, mut weights, mut normal) = (0.0, 0.0, Vector::ZERO);
        stencil.for_each(grid, x, |node, weight, flips| {
            let known = map.contact_node(node).map(|index| &map.nodes[index]);
            let Some(contact_node) = known.filter(|node| node.normal != Vector::ZERO) else { return };
            height += (stencil.mirror(grid, x, flips) - contact_node.centre).dot(contact_node.normal) * weight;
            weights += weight;
            normal += flip(contact_node.normal, flips) * weight;
        });
        let normal = normal.normalized()?;
        let radius = half_size(particles, p, normal, grid.cell);
        (weights > 0.0).then(|| PlaneDistance { distance: height / weights, radius, normal })
    }

    fn label(&mut self, x: Vector<D>, old: Option<Label>, distance: f64) -> Label {
        match old.filter(|label| label.side != 0.0) {
            Some(Label { side, .. }) if side * distance >= 0.0 => Label { side, crossed: false },
            Some(label) if label.crossed => label,
            Some(Label { side, .. }) => match self.position_of(x) {
                SheetPosition::Beside(d) => Label { side, crossed: d * side < 0.0 },
                SheetPosition::Beyond => Label { side: 0.0, crossed: false },
                SheetPosition::Away => Label { side, crossed: false },
            },
            None => {
                let side = match self.position_of(x) {
                    SheetPosition::Beside(d) => d.signum(),
                    SheetPosition::Beyond => 0.0,
                    SheetPosition::Away => distance.signum(),
                };
                Label { side, crossed: false }
            }
        }
    }

    /// The position of `x` [m] relative to the closest point of the sheet.
    fn position_of(&mut self, x: Vector<D>) -> SheetPosition {
        let cell = self.context.grid.cell;
        self.locator.refresh(self.facets, self.surface.position, cell);
        self.locator.locate(self.facets, self.surface.position, cell, x)
    }

    fn lower_gaps(&mut self, field: usize, body: &Body<D>, p: usize, side: f64, gap: f64) {
        let StepContext { grid, stencil, .. } = *self.context;
        let (mass, x) = (body.particles.mass[p], body.particles.position[p]);
        stencil.of_field(grid, field).for_each(grid, x, |node, weight, flips| {
            let Some(index) = self.map.contact_node(node) else { return };
            let pair = &mut self.pairs[index * grid.fields.len() + field];
            let lowest = &mut pair.gap[usize::from(side > 0.0)];
            *lowest = lowest.min(gap);
            pair.vote += side * mass * weight;
            pair.mass += mass * weight;
            pair.moment += stencil.mirror(grid, x, flips) * (mass * weight);
        });
    }
}
