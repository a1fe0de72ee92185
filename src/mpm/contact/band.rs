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

use super::guard::{DOUBT, Near};
use super::locate::{Locator, Place};
use super::map::Map;
use super::method::StepContext;
use super::nodes::{FoldedStencil, flip};
use super::row::NodePair;
use super::sample::Facet;
use super::sheet::Surface;
use crate::math::Vector;
use crate::mpm::{Body, EDGE, Grid, Particles};
use crate::parallel;

/// Particles whose support reaches a marked node.
#[derive(Debug, Default)]
pub(super) struct Marks {
    blocks: Vec<bool>,
}

impl Marks {
    /// Nothing marked on this grid.
    pub fn clear<const D: usize>(&mut self, grid: &Grid<D>) {
        self.blocks.clear();
        self.blocks.resize(grid.blocks().len(), false);
    }

    /// Marks the blocks in which the support of a particle that reaches `node` may start.
    pub fn mark<const D: usize>(&mut self, grid: &Grid<D>, lattice: &FoldedStencil<D>, node: usize) {
        let ijk = grid.coordinates(node);
        for corner in 0..1 << D {
            let first = std::array::from_fn(|a| ijk[a] - (corner >> a & 1) * (lattice.support() - 1));
            if let Some(start) = grid.find(first) {
                self.blocks[start / Grid::<D>::BLOCK] = true;
            }
        }
    }

    /// Indices of the particles whose support starts in a marked block, ascending.
    pub fn near<const D: usize>(&self, grid: &Grid<D>, lattice: &FoldedStencil<D>, position: &[Vector<D>]) -> Vec<u32> {
        if !self.blocks.contains(&true) {
            return Vec::new();
        }
        let collect = |range: std::ops::Range<usize>| {
            let (mut found, mut last, mut marked) = (Vec::new(), None, false);
            for p in range {
                let first = lattice.first(grid, position[p]);
                let block = first.map(|i| i.div_euclid(EDGE as i32));
                if last != Some(block) {
                    last = Some(block);
                    marked = grid.find(first).is_some_and(|node| self.blocks[node / Grid::<D>::BLOCK]);
                }
                if marked {
                    found.push(p as u32);
                }
            }
            found
        };
        let join = |mut all: Vec<u32>, mut more: Vec<u32>| {
            all.append(&mut more);
            all
        };
        if position.len() <= parallel::CHUNK {
            return collect(0..position.len());
        }
        parallel::reduce(position.len(), collect, join).unwrap_or_default()
    }
}

/// Half the size of a particle along `normal` [m] (theory (D.6)).
///
/// From its deformation gradient where it has one; else half the edge of its volume, kept within 0.3 to 1
/// half cells.
pub(super) fn radius<const D: usize>(particles: &Particles<D>, p: usize, normal: Vector<D>, cell: f64) -> f64 {
    let edge = |volume: f64| if D == 2 { volume.sqrt() } else { volume.cbrt() };
    match particles.deformation.get(p) {
        Some(f) => {
            let size = edge(particles.volume[p] / f.determinant());
            let extent = |k: usize| (0..D).map(|i| f[i][k] * normal[i]).sum::<f64>().abs();
            0.5 * size * (0..D).map(extent).sum::<f64>()
        }
        None => 0.5 * edge(particles.volume[p]).clamp(0.3 * cell, cell),
    }
}

/// What the particles of one body remember of one sheet, by identity: the step in which each was near, and
/// its side.
#[derive(Debug, Default)]
pub(super) struct Labels {
    /// Step · 8 + (1: +, 2: −, 0: beyond an edge) + (4: counted as crossed).
    pub stamps: Vec<u32>,
    /// The side of all of them for good, as their region has it.
    pub known: Option<f64>,
    /// How hard each was pressed against the sheet when it was near last [N]; fewer where the others weren't.
    pub force: Vec<f32>,
}

/// A particle that is to be displaced.
#[derive(Debug, Clone, Copy)]
pub struct Shift<const D: usize> {
    /// Index of the particle.
    pub particle: u32,
    /// By how much [m].
    pub by: Vector<D>,
}

/// Distance of a particle from the sheet [m], its half size [m], and the direction of the distance.
#[derive(Debug, Clone, Copy)]
struct Reading<const D: usize> {
    distance: f64,
    radius: f64,
    normal: Vector<D>,
}

/// Particles per parallel task.
const TASK: usize = 1024;

/// A particle's memory of a sheet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Label {
    pub side: f64,
    pub crossed: bool,
}

impl Labels {
    /// What is known of a particle after `step`: its side from its region, else what was kept then.
    pub fn recall(&self, id: u32, step: u64) -> Option<Label> {
        let kept = self.kept(id, step);
        let known = |side| Label { side, crossed: kept.is_some_and(|label| label.crossed) };
        self.known.map(known).or(kept)
    }

    fn kept(&self, id: u32, step: u64) -> Option<Label> {
        let stamp = *self.stamps.get(id as usize)?;
        let side = [0.0, 1.0, -1.0, 0.0][(stamp & 3) as usize];
        (stamp >> 3 == Self::clock(step) && stamp != 0).then_some(Label { side, crossed: stamp & 4 != 0 })
    }

    pub fn keep(&mut self, id: u32, step: u64, label: Label) {
        if self.stamps.len() <= id as usize {
            self.stamps.resize(id as usize + 1, 0);
        }
        let side = if label.side > 0.0 { 1 } else { u32::from(label.side < 0.0) * 2 };
        self.stamps[id as usize] = Self::clock(step) << 3 | u32::from(label.crossed) << 2 | side;
    }

    /// How hard a particle was pressed in `step` [N], which is then forgotten.
    pub fn take_force(&mut self, id: u32, step: u64) -> f64 {
        let near = self.kept(id, step).is_some();
        let force = self.force.get_mut(id as usize).map_or(0.0, std::mem::take);
        if near && force.is_finite() { f64::from(force).max(0.0) } else { 0.0 }
    }

    /// Remembers how hard a particle was pressed [N].
    pub fn put_force(&mut self, id: u32, force: f64) {
        if self.force.len() <= id as usize {
            self.force.resize(id as usize + 1, 0.0);
        }
        self.force[id as usize] = force as f32;
    }

    fn clock(step: u64) -> u32 {
        (step & 0x1fff_ffff) as u32
    }
}

/// One sheet and the particles around it.
pub(super) struct Band<'a, const D: usize> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Tensor;

    /// A cube stretched along x is longer along x, and a fluid's particle is kept within half a cell.
    #[test]
    fn particle_sizes_follow_the_deformation() {
        let mut particles = Particles::<3> { volume: vec![2.0 * 0.001], ..Particles::default() };
        assert!((radius(&particles, 0, Vector::unit(0), 1.0) - 0.15).abs() < 1e-15);
        assert!((radius(&particles, 0, Vector::unit(0), 0.1) - 0.05).abs() < 1e-15);
        particles.deformation = vec![Tensor([[2.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])];
        assert!((radius(&particles, 0, Vector::unit(0), 1.0) - 0.1).abs() < 1e-15);
        assert!((radius(&particles, 0, Vector::unit(1), 1.0) - 0.05).abs() < 1e-15);
    }

    /// A label is remembered from one step to the next, and forgotten after a step away.
    #[test]
    fn labels_last_while_the_particle_stays() {
        let mut labels = Labels::default();
        assert_eq!(labels.recall(3, 0), None);
        labels.keep(3, 7, Label { side: -1.0, crossed: true });
        assert_eq!(labels.recall(3, 7), Some(Label { side: -1.0, crossed: true }));
        assert_eq!(labels.recall(3, 8), None);
    }

    /// The side that a region has is known of particles that were never near; that one has crossed is forgotten after a step away.
    #[test]
    fn the_side_of_a_region_is_known_for_good() {
        let mut labels = Labels { known: Some(-1.0), ..Labels::default() };
        assert_eq!(labels.recall(3, 0), Some(Label { side: -1.0, crossed: false }));
        labels.keep(3, 7, Label { side: -1.0, crossed: true });
        assert_eq!(labels.recall(3, 7), Some(Label { side: -1.0, crossed: true }));
        assert_eq!(labels.recall(3, 8), Some(Label { side: -1.0, crossed: false }));
    }
}
