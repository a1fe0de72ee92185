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

use super::ghost::Fold;
use super::kernel::{Kernel, Shape, with_shape};
use super::sweep::{Content, Record, Sweep, Wanted, put_velocity};
use super::{Field, Grid, Mpm, Step};
use crate::math::{Tensor, Vector};

/// Steps between two shifts.
const EVERY: u64 = 10;

/// α, and the most of α ‖ε̇‖ Δt that is stable.
const PACE: f64 = 1.0;
const MOST: f64 = 0.1;

/// Rows of nodes next to a wall that lack a part of their support.
const ROWS: usize = 3;

/// ∫N_I dx / hᴰ of the rows of nodes next to the ends of each axis.
type Rooms<const D: usize> = [[[f64; ROWS]; 2]; D];

impl<const D: usize> Mpm<D> {
    /// Finds out where the particles of fluids are to go at the end of this step.
    pub(super) fn find_shifts(&mut self, step: &Step) {
        for body in &mut self.bodies {
            body.work.shift.clear();
        }
        if !self.steps.is_multiple_of(EVERY) {
            return;
        }
        let dt = step.dt * EVERY as f64;
        let Self { grid, bodies, bins, ghosts, .. } = self;
        for field in 0..grid.fields.len() {
            let fluid =
                |body: &super::Body<D>| body.field == field && !body.law.keeps_shape() && !body.particles.is_empty();
            let Some(kernel) = bodies.iter().find(|body| fluid(body)).map(|body| body.kernel) else { continue };
            let mut sums = vec![[0.0; 2]; grid.node_count()];
            for (body, bins) in bodies.iter().zip(&*bins).filter(|(body, _)| body.field == field) {
                Sweep::new(grid, body.kernel, bins).scatter(&mut sums, body, Content::Pressures);
            }
            ghosts.fold(&mut sums, |_, _, _| {});
            let rooms = rooms(grid, kernel);
            let volume = grid.cell.powi(D as i32);
            let excess = |node: usize| (sums[node][0] / (volume * room(grid, &rooms, node)) - 1.0).max(0.0);
            let mut excess: Vec<[f64; 1]> = (0..grid.node_count()).map(|node| [excess(node)]).collect();
            ghosts.fill(&mut excess);
            let mut velocity = velocities(&grid.fields[field]);
            ghosts.fill(&mut velocity);
            let h2 = grid.cell * grid.cell;
            for (body, bins) in bodies.iter_mut().zip(&*bins).filter(|(body, _)| fluid(body)) {
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
                        chunk.particles.shift[p] = slope * (-h2 * chunk.particles.shift[p][0]);
                    }
                });
            }
        }
    }

    /// Shifts the particles; returns the largest displacement [m].
    pub(super) fn shift_particles(&mut self) -> f64 {
        let (lower, upper) = (self.grid.origin, self.grid.upper());
        let mut largest = 0.0_f64;
        for body in self.bodies.iter_mut().filter(|body| !body.work.shift.is_empty()) {
            let particles = &mut body.particles;
            for (p, by) in body.work.shift.iter().enumerate() {
                let margin = 0.25 * particles.volume[p].powf(1.0 / D as f64);
                let x = &mut particles.position[p];
                for a in 0..D {
                    let to = x[a] + by[a];
                    if to > lower[a] + margin && to < upper[a] - margin {
                        x[a] = to;
                    }
                }
                largest = largest.max(by.norm());
            }
        }
        largest
    }
}

/// v_I of a field.
fn velocities<const D: usize>(field: &Field<D>) -> Vec<Vector<D>> {
    let velocity = |node: &super::Node<D>| if node.mass > 0.0 { node.momentum / node.mass } else { Vector::ZERO };
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
