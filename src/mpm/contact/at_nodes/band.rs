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
use crate::mpm::contact::folded_stencil::flip;
use crate::mpm::contact::method::StepContext;
use crate::mpm::contact::particle_size::radius;
use crate::mpm::contact::sheet::{DOUBT, Facet, Label, Labels, Locator, Near, Place, Surface};
use crate::mpm::{Body, Particles};
use crate::parallel;

/// Distance of a particle from the sheet [m], its half size [m], and the direction of the distance.
#[derive(Debug, Clone, Copy)]
struct Reading<const D: usize> {
    distance: f64,
    radius: f64,
    normal: Vector<D>,
}

/// Particles per parallel task.
const TASK: usize = 1024;

/// One sheet and the particles around it.
pub struct Band<'a, const D: usize> {
    pub scene: &'a StepContext<'a, D>,
    pub surface: &'a Surface<'a, D>,
    pub facets: &'a [Facet],
    /// Number of the sheet.
    pub number: usize,
    pub map: &'a mut Map<D>,
    /// One pair per row and field, fields running fastest.
    pub pairs: &'a mut [NodePair<D>],
    pub locator: &'a mut Locator<D>,
}

impl<const D: usize> Band<'_, D> {
    /// Where the sheet is folded, adds the arms to the particles of a body `near` it, each turned to the side that it is on.
    pub fn lean(&mut self, body: usize, near: &[u32], labels: &Labels) {
        let StepContext { grid, lattice, step, .. } = *self.scene;
        let body = &self.scene.bodies[body];
        for &p in near {
            let (x, id) = (body.particles.position[p as usize], body.particles.id[p as usize]);
            let mut side = None;
            lattice.of_field(grid, body.field).for_each(grid, x, |node, weight, flips| {
                let Some(row) = self.map.row(node).filter(|&row| self.map.rows[row].folded) else { return };
                let side = *side.get_or_insert_with(|| match labels.recall(id, step - 1) {
                    Some(label) if label.side != 0.0 => label.side,
                    _ => match self.place(x) {
                        Place::Beside(d) => d.signum(),
                        Place::Beyond | Place::Away => 0.0,
                    },
                });
                let row = &mut self.map.rows[row];
                let arm = lattice.mirror(grid, x, flips) - row.centre;
                let share = body.particles.mass[p as usize] * weight;
                row.normal += arm * (side * share);
                row.arms += arm.norm() * share;
            });
        }
    }

    /// Labels the particles of a body `near` the sheet and lowers the gaps at its rows; returns how many have crossed,
    /// and adds those that may come too close to `guarded`.
    pub fn measure(&mut self, index: usize, near: &[u32], labels: &mut Labels, guarded: &mut Vec<Near<D>>) -> u64 {
        let (scene, body) = (self.scene, &self.scene.bodies[index]);
        let particles = &body.particles;
        let band = &*self;
        let readings: Vec<_> = parallel::collect(near.len(), TASK, |n| band.read(particles, near[n] as usize));
        let mut crossed = 0;
        for (&p, reading) in near.iter().zip(readings) {
            let Some(Reading { distance, radius, normal }) = reading else { continue };
            let (p, id) = (p as usize, particles.id[p as usize]);
            let old = labels.recall(id, scene.step - 1);
            let label = self.label(particles.position[p], old, distance);
            crossed += u64::from(label.crossed && old.is_none_or(|old| !old.crossed));
            labels.keep(id, scene.step, label);
            if label.side != 0.0 {
                let height = label.side * distance;
                self.lower_gaps(body, p, label.side, height - radius);
                let (least, from) = (height - DOUBT * scene.grid.cell, particles.position[p]);
                guarded.push(Near::new([p, index, self.number], (label.side, normal), (least, radius), from));
            }
        }
        crossed
    }

    /// δ_p and r_p, if a row with a normal is in reach.
    fn read(&self, particles: &Particles<D>, p: usize) -> Option<Reading<D>> {
        let StepContext { grid, lattice, .. } = *self.scene;
        let (map, x) = (&*self.map, particles.position[p]);
        let (mut height, mut share, mut normal) = (0.0, 0.0, Vector::ZERO);
        lattice.for_each(grid, x, |node, weight, flips| {
            let Some(row) = map.row(node).map(|r| &map.rows[r]).filter(|row| row.normal != Vector::ZERO) else {
                return;
            };
            height += (lattice.mirror(grid, x, flips) - row.centre).dot(row.normal) * weight;
            share += weight;
            normal += flip(row.normal, flips) * weight;
        });
        let normal = normal.normalized()?;
        let radius = radius(particles, p, normal, grid.cell);
        (share > 0.0).then(|| Reading { distance: height / share, radius, normal })
    }

    fn label(&mut self, x: Vector<D>, old: Option<Label>, distance: f64) -> Label {
        match old.filter(|label| label.side != 0.0) {
            Some(Label { side, .. }) if side * distance >= 0.0 => Label { side, crossed: false },
            Some(label) if label.crossed => label,
            Some(Label { side, .. }) => match self.place(x) {
                Place::Beside(d) => Label { side, crossed: d * side < 0.0 },
                Place::Beyond => Label { side: 0.0, crossed: false },
                Place::Away => Label { side, crossed: false },
            },
            None => {
                let side = match self.place(x) {
                    Place::Beside(d) => d.signum(),
                    Place::Beyond => 0.0,
                    Place::Away => distance.signum(),
                };
                Label { side, crossed: false }
            }
        }
    }

    /// Where `x` is, measured from the closest point of the sheet.
    fn place(&mut self, x: Vector<D>) -> Place {
        let cell = self.scene.grid.cell;
        self.locator.refresh(self.facets, self.surface.position, cell);
        self.locator.place(self.facets, self.surface.position, cell, x)
    }

    fn lower_gaps(&mut self, body: &Body<D>, p: usize, side: f64, gap: f64) {
        let StepContext { grid, lattice, .. } = *self.scene;
        let (mass, x) = (body.particles.mass[p], body.particles.position[p]);
        lattice.of_field(grid, body.field).for_each(grid, x, |node, weight, flips| {
            let Some(row) = self.map.row(node) else { return };
            let pair = &mut self.pairs[row * grid.fields.len() + body.field];
            let lowest = &mut pair.gap[usize::from(side > 0.0)];
            *lowest = lowest.min(gap);
            pair.vote += side * mass * weight;
            pair.mass += mass * weight;
            pair.moment += lattice.mirror(grid, x, flips) * (mass * weight);
        });
    }
}
