//! Particle shifting: what keeps the particles of fluids evenly spaced (Lind, Xu, Stansby & Rogers 2012, here with the grid).
//!
//! ```text
//! φ_I = Σ_p V_p N_Ip / ∫N_I dx,     c_I = max(φ_I − 1, 0)          what particles fill of a node's share of space, and the excess
//! x_p ← x_p − α h² ‖ε̇_p‖ Δt ∇c(x_p)
//! ```
//!
//! Flow draws particles into strings along some lines and out of others. The volume that each carries follows the divergence of the
//! velocity and knows nothing of that: pressures don't push clusters apart. A row of particles along a wall thins out until a
//! single one bears the weight of what stands above it. Where fluid fills more than there is room for, particles therefore go where
//! there is less; since volumes add up, that fills the holes, and free surfaces, where φ < 1, keep their shape. The rate of strain ε̇
//! is what makes clusters, and sets the pace at which they dissolve: a fluid at rest or in rigid motion is left alone.
//!
//! Places change and nothing else. What gravity does on the way is booked apart.

use super::contact::nodes::{Lattice, flip};
use super::ghost::Fold;
use super::kernel::{Kernel, Shape, with_shape};
use super::step::of_field;
use super::sweep::{Content, Record, Sweep, Wanted, put_velocity};
use super::{Body, Field, Grid, Mpm, Node, Step};
use crate::math::{Tensor, Vector};
use crate::parallel::{self, CHUNK};
use rayon::prelude::*;

/// Steps between two shifts.
const EVERY: u64 = 10;

/// α, and the most of α ‖ε̇‖ Δt that is stable.
const PACE: f64 = 1.0;
const MOST: f64 = 0.1;

/// No nearer to a wall or an obstacle than this is a particle shifted [particle sizes].
const MARGIN: f64 = 0.25;

/// Rows of nodes next to a wall that lack a part of their support.
const ROWS: usize = 3;

/// ∫N_I dx / hᴰ of the rows of nodes next to the ends of each axis.
type Rooms<const D: usize> = [[[f64; ROWS]; 2]; D];

impl<const D: usize> Mpm<D> {
    /// Finds out, every few steps, where the particles of fluids are to go at the end of this step.
    pub(super) fn find_shifts(&mut self, step: &Step) {
        self.bodies.iter_mut().for_each(|body| body.work.shift.clear());
        if !self.steps.is_multiple_of(EVERY) {
            return;
        }
        for field in 0..self.grid.fields.len() {
            let fluids = self.bodies.iter().filter(|body| body.field == field && is_fluid(body));
            if let Some(kernel) = fluids.map(|body| body.kernel).next() {
                let excess = self.excess(field, kernel);
                self.shift_down(field, &excess, step.dt * EVERY as f64);
            }
        }
    }

    /// c_I of a field, ghosts filled.
    fn excess(&self, field: usize, kernel: Kernel) -> Vec<[f64; 1]> {
        let Self { grid, bodies, bins, ghosts, .. } = self;
        let mut sums = vec![[0.0; 2]; grid.node_count()];
        for (body, bins) in of_field(bodies, bins, field) {
            Sweep::new(grid, body.kernel, bins).scatter(&mut sums, body, Content::Pressures);
        }
        ghosts.fold(&mut sums, |_, _, _| {});
        let (rooms, volume) = (rooms(grid, kernel), grid.cell.powi(D as i32));
        let excess = |(node, [filled, _]): (usize, &[f64; 2])| {
            if *filled > 0.0 { [(filled / (volume * room(grid, &rooms, node)) - 1.0).max(0.0)] } else { [0.0] }
        };
        let mut excess: Vec<[f64; 1]> = sums.par_iter().enumerate().with_min_len(CHUNK).map(excess).collect();
        ghosts.fill(&mut excess);
        excess
    }

    /// −α h² ‖ε̇_p‖ Δt ∇c of the fluids in a field [m].
    fn shift_down(&mut self, field: usize, excess: &[[f64; 1]], dt: f64) {
        let Self { grid, bodies, bins, ghosts, .. } = self;
        let mut velocity = velocities(&grid.fields[field]);
        ghosts.fill(&mut velocity);
        let square = grid.cell * grid.cell;
        for (body, bins) in bodies.iter_mut().zip(&*bins).filter(|(body, _)| body.field == field && is_fluid(body)) {
            body.work.shift.resize(body.particles.len(), Vector::ZERO);
            let sweep = Sweep::new(grid, body.kernel, bins);
            let node = |n: usize, record: &mut Record| put_velocity(record, &velocity[n]);
            sweep.gather(node, body.view().1, Wanted::Gradient, |chunk| {
                for p in 0..chunk.particles.len() {
                    let rate = rate_of_strain(&chunk.rows.gradient(p));
                    chunk.particles.shift[p][0] = (PACE * rate * dt).min(MOST);
                }
            });
            let node = |n: usize, record: &mut Record| put_velocity(record, &(Vector::<D>::unit(0) * excess[n][0]));
            sweep.gather(node, body.view().1, Wanted::Gradient, |chunk| {
                for p in 0..chunk.particles.len() {
                    let slope = Vector::from_fn(|b| chunk.rows.gradient[b][0][p]);
                    chunk.particles.shift[p] = slope * (-square * chunk.particles.shift[p][0]);
                }
            });
        }
    }

    /// Moves the particles of fluids to where there is room, parts what overlaps with a sheet, and keeps all particles on their sides of
    /// the sheets; books what the forces on nodes would have done on the way. Comes after particles and sheets have moved.
    pub(super) fn displace_particles(&mut self) {
        let Self { grid, bodies, bins, walls, coupling, .. } = self;
        let mut work = 0.0;
        let shifted =
            bodies.iter_mut().zip(&mut *bins).enumerate().filter(|(_, (body, _))| !body.work.shift.is_empty());
        for (index, (body, bins)) in shifted {
            let mut shifts = std::mem::take(&mut body.work.shift);
            coupling.contact.keep_off(index, &mut shifts);
            let keep = |(p, by): (usize, &mut Vector<D>)| {
                let margin = MARGIN * body.particles.volume[p].powf(1.0 / D as f64);
                if *by != Vector::ZERO && walls.obstruct(body.particles.position[p], *by, margin) {
                    *by = Vector::ZERO;
                }
            };
            shifts.par_iter_mut().enumerate().with_min_len(CHUNK).for_each(keep);
            work += parallel::sum(shifts.len(), |p| work_over(grid, body, coupling.contact.lattice(), p, shifts[p]));
            body.particles.position.par_iter_mut().zip(&shifts).for_each(|(x, by)| *x += *by);
            bins.disorder.drift += largest(shifts.iter()) / grid.cell;
            body.work.shift = shifts;
        }
        let positions: Vec<&[Vector<D>]> = coupling.membranes.iter().map(|m| &m.position[..]).collect();
        let shifts = coupling.contact.restore(bodies, &positions).to_vec();
        for ((body, bins), shifts) in bodies.iter().zip(bins).zip(&shifts).filter(|(_, shifts)| !shifts.is_empty()) {
            let lattice = coupling.contact.lattice();
            work += shifts.iter().map(|s| work_over(grid, body, lattice, s.particle as usize, s.by)).sum::<f64>();
            bins.disorder.drift += largest(shifts.iter().map(|shift| &shift.by)) / grid.cell;
        }
        self.books.add(self.accounts.displacement, work);
    }
}

fn is_fluid<const D: usize>(body: &Body<D>) -> bool {
    !body.law.keeps_shape() && !body.particles.is_empty()
}

/// The length of the longest [m].
fn largest<'a, const D: usize>(shifts: impl Iterator<Item = &'a Vector<D>>) -> f64 {
    shifts.map(|by| by.norm_squared()).fold(0.0, f64::max).sqrt()
}

/// What stresses, gravity and tractions would have done on the way `by` [m] of a particle, m_p Σ N_I a_I · u_p [J].
fn work_over<const D: usize>(grid: &Grid<D>, body: &Body<D>, lattice: &Lattice<D>, p: usize, by: Vector<D>) -> f64 {
    if by == Vector::ZERO {
        return 0.0;
    }
    let (field, mut sum, particles) = (&grid.fields[body.field], 0.0, &body.particles);
    lattice.for_each(grid, particles.position[p], |node, weight, flips| {
        let mass = field.nodes[node].mass;
        if mass > 0.0 && node < field.applied.len() {
            sum += flip(field.applied[node], flips).dot(by) * (weight / mass);
        }
    });
    particles.mass[p] * sum
}

/// v_I of a field.
fn velocities<const D: usize>(field: &Field<D>) -> Vec<Vector<D>> {
    let velocity = |node: &Node<D>| if node.mass > 0.0 { node.momentum / node.mass } else { Vector::ZERO };
    field.nodes.iter().map(velocity).collect()
}

/// ‖½(L + Lᵀ)‖ [1/s].
fn rate_of_strain<const D: usize>(gradient: &Tensor<D>) -> f64 {
    let entry = |n: usize| 0.5 * (gradient[n / D][n % D] + gradient[n % D][n / D]);
    (0..D * D).map(|n| entry(n).powi(2)).sum::<f64>().sqrt()
}

fn room<const D: usize>(grid: &Grid<D>, rooms: &Rooms<D>, node: usize) -> f64 {
    let ijk = grid.coordinates(node);
    let along = |a: usize| {
        let ends = [ijk[a], grid.cells[a] - ijk[a]];
        let of_end = |end: usize| usize::try_from(ends[end]).ok().and_then(|row| rooms[a][end].get(row)).copied();
        of_end(0).unwrap_or(1.0) * of_end(1).unwrap_or(1.0)
    };
    (0..D).map(along).product()
}

/// Points per cell that integrate the shape functions.
const POINTS: usize = 64;

fn rooms<const D: usize>(grid: &Grid<D>, kernel: Kernel) -> Rooms<D> {
    grid.folds.map(|folds| folds.map(|fold| with_shape!(kernel, shape => integrate(shape, fold))))
}

fn integrate<const S: usize>(shape: impl Shape<S>, fold: Fold) -> [f64; ROWS] {
    let mut rooms = [0.0; ROWS];
    let mut add = |row: i32, weight: f64| {
        if let Some(room) = usize::try_from(row).ok().and_then(|row| rooms.get_mut(row)) {
            *room += weight / POINTS as f64;
        }
    };
    for point in 0..POINTS * (ROWS + 2) {
        let at = shape.at((point as f64 + 0.5) / POINTS as f64);
        for (i, weight) in at.weight.into_iter().enumerate() {
            match (at.first + i as i32, fold) {
                (row, Fold::Mirror) if row < 0 => add(-row, weight),
                (row, Fold::Extrapolate) if row < 0 => {
                    add(0, f64::from(1 - row) * weight);
                    add(1, f64::from(row) * weight);
                }
                (row, _) => add(row, weight),
            }
        }
    }
    rooms
}
