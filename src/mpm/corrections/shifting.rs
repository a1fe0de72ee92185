//! Particle shifting: keeps the particles of liquids evenly spaced, and their volumes those of the space that they fill
//! (theory A.11); keeps them off sheets and obstacles (theory D.12, E.8).
//!
//! ```text
//! φ_I = Σ_p V_p N_Ip / ∫N_I dx,   c_I = max(φ_I − 1, 0)   what particles fill of a node's space, and the excess
//! x_p ← x_p − α h² ‖ε̇_p‖ Δt ∇c(x_p)                    particle shifting (Lind, Xu, Stansby & Rogers 2012)
//! V_p ← V_p (1 − (α ‖ε̇_p‖ Δt + β) c(x_p))
//! ```
//!
//! Flow draws particles into strings along some lines and out of others. The volume that each carries follows
//! the divergence of the velocity and knows nothing of that: pressures don't push clusters apart. A row of particles
//! along a wall thins out until a single one bears the weight of what stands above it. Where a liquid fills more than
//! there is room for, particles therefore go where there is less; since volumes add up, that fills the holes, and free
//! surfaces, where φ < 1, keep their shape. The rate of strain ε̇ is what makes clusters, and sets the rate at which
//! they dissolve.
//!
//! A squeezed liquid keeps the volumes of its particles as long as the divergence of the velocity doesn't show it:
//! contact that parts overlapping particles from a sheet, again and again, pressed a water balloon to five sixths
//! of its volume within three seconds, at the same pressure. The excess is therefore taken from the volumes, slowly,
//! and the pressure that follows makes the liquid take its space back. The work is booked.
//!
//! Particles of a liquid that has parted (p at its limit) are left as they are, but for the void between them, which
//! closes as it fills.
//!
//! The free volume ∫N_I dx ends at walls (exactly), and at sheets and obstacles (as if they were flat). A gas that is
//! squeezed takes up less space, as it should, and its volumes follow its energy (`volumes`).

mod free_volume;

use crate::math::Vector;
use crate::mpm::contact::{Contacts, ParticleShift};
use crate::mpm::coupling::Coupling;
use crate::mpm::executor::{
    Executor, Gathering, Nodal, Operation, OperationParameters, Operations, Scattering, Targets,
};
use crate::mpm::grid::{GhostFractions, Ghosts};
use crate::mpm::kernel::Kernel;
use crate::mpm::particles::Bodies;
use crate::mpm::transfer::ScatterContent;
use crate::mpm::wall::folded_stencil::{FoldedStencil, flip};
use crate::mpm::wall::{BodiesAtWalls, Walls};
use crate::mpm::{Body, Grid, LeapfrogStep, Node, VelocityField};
use crate::parallel::{self, CHUNK};
use free_volume::{at_walls, fraction_beside, of_node};

/// Steps between two corrections.
const EVERY: u64 = 10;

/// Least distance from a wall or an obstacle to which a particle may be shifted [particle sizes].
const MARGIN: f64 = 0.25;

/// Nodes with less free volume than this, as a fraction of that of a free node, say nothing about an excess.
const LEAST_FREE_VOLUME: f64 = 0.3;

/// The grid and the walls among which bodies are corrected, and the executor of their sums.
#[derive(Clone, Copy)]
pub(in crate::mpm) struct GridContext<'a, const D: usize> {
    /// The grid.
    pub grid: &'a Grid<D>,
    /// Ghosts of the grid.
    pub ghosts: &'a Ghosts<D>,
    /// Walls and obstacles.
    pub walls: &'a Walls<D>,
    /// The executor of sums over particles.
    pub executor: &'a dyn Executor<D>,
}

/// Finds, every few steps, where the particles of liquids are to go at the end of this step, and corrects their
/// volumes; returns the work of that, field by field [J]. `parameters` are those of the step.
pub(in crate::mpm) fn even_out<const D: usize>(
    steps: u64,
    parameters: OperationParameters<D>,
    context: GridContext<'_, D>,
    bodies: &mut Bodies<D>,
    contact: &mut Contacts<D>,
) -> Vec<f64> {
    bodies.iter_mut().for_each(|body| body.work.shift.clear());
    if !steps.is_multiple_of(EVERY) {
        return Vec::new();
    }
    let parameters = OperationParameters { strain_dt: parameters.strain_dt * EVERY as f64, ..parameters };
    let mut works = Vec::new();
    for field in 0..context.grid.fields.len() {
        let liquid = bodies.field(field).iter().find(|body| is_liquid(body));
        if let Some(kernel) = liquid.map(|body| body.kernel) {
            let excess = find_excess(context, field, kernel, bodies, contact);
            works.push(apply_excess(context, field, bodies, &excess, &parameters));
        }
    }
    works
}

/// c_I of a field, ghosts filled.
fn find_excess<const D: usize>(
    context: GridContext<'_, D>,
    field: usize,
    kernel: Kernel,
    bodies: &mut Bodies<D>,
    contact: &mut Contacts<D>,
) -> Vec<[f64; 1]> {
    let GridContext { grid, ghosts, executor, .. } = context;
    let mut sums = vec![[0.0; 2]; grid.node_count()];
    for body in bodies.field_mut(field) {
        let targets = Targets::Sums(&mut sums);
        executor.scatter(grid, field, body, Scattering { content: ScatterContent::Pressures, targets });
    }
    ghosts.fold(&GhostFractions::default(), &mut sums, |_, _, _| {});
    let reached = |node: usize| sums[node][0] > 0.0;
    let free = free_volumes(context, field, kernel, &reached, bodies, contact);
    let volume = grid.cell.powi(D as i32);
    for body in bodies.field_mut(field).iter_mut().filter(|body| is_liquid(body)) {
        let filled =
            |node: usize| if free[node] > LEAST_FREE_VOLUME { sums[node][0] / (volume * free[node]) } else { 0.0 };
        close_voids(grid, contact.stencil(), body, filled);
    }
    let known = |node: usize| reached(node) && free[node] > LEAST_FREE_VOLUME;
    let filling_at = |node: usize| if known(node) { sums[node][0] / (volume * free[node]) } else { 0.0 };
    let filling: Vec<f64> = parallel::collect(free.len(), CHUNK, filling_at);
    // Nodes that say nothing, as those beyond a sheet, take the mean of their known neighbours.
    let mean_of_neighbours = |node: usize| {
        let excesses = grid.neighbours(node).filter(|&other| known(other)).map(|other| (filling[other] - 1.0).max(0.0));
        let (sum, count) = excesses.fold((0.0, 0.0), |(sum, count), other| (sum + other, count + 1.0));
        if count > 0.0 { sum / count } else { 0.0 }
    };
    let excess_at = |node: usize| match reached(node) {
        true if known(node) => [(filling[node] - 1.0).max(0.0)],
        true => [mean_of_neighbours(node)],
        false => [0.0],
    };
    let mut excess: Vec<[f64; 1]> = parallel::collect(free.len(), CHUNK, excess_at);
    ghosts.fill(&GhostFractions::default(), &mut excess);
    excess
}

/// The free volume around each node that particles of a field reach, which walls, obstacles and sheets leave, over the
/// volume of a cell.
fn free_volumes<const D: usize>(
    GridContext { grid, walls, .. }: GridContext<'_, D>,
    field: usize,
    kernel: Kernel,
    reached: &(impl Fn(usize) -> bool + Sync),
    bodies: &Bodies<D>,
    contact: &mut Contacts<D>,
) -> Vec<f64> {
    let rows = at_walls(grid, kernel);
    let free_at = |node| {
        if !reached(node) {
            return 0.0;
        }
        let beside = walls.clearance_of_obstacles(grid.position(node)) / grid.cell;
        of_node(grid, &rows, node).min(fraction_beside(beside))
    };
    let mut free: Vec<f64> = parallel::collect(grid.node_count(), CHUNK, free_at);
    contact.limit_free_volumes(grid, bodies, field, |node, distance| {
        free[node] = free[node].min(fraction_beside(distance / grid.cell));
    });
    free
}

/// Sets the shifts of the liquids in a field [m], and takes from their volumes; returns the work of that [J].
fn apply_excess<const D: usize>(
    GridContext { grid, ghosts, executor, .. }: GridContext<'_, D>,
    field: usize,
    bodies: &mut Bodies<D>,
    excess: &[[f64; 1]],
    parameters: &OperationParameters<D>,
) -> f64 {
    let mut velocity = velocities(&grid.fields[field]);
    ghosts.fill(&grid.fields[field].limits, &mut velocity);
    // The gradient of c is that of a velocity c along x.
    let along_x: Vec<Vector<D>> = parallel::collect(excess.len(), CHUNK, |n| Vector::unit(0) * excess[n][0]);
    let mut work = 0.0;
    for body in bodies.field_mut(field).iter_mut().filter(|body| is_liquid(body)) {
        body.work.shift.resize(body.particles.len(), Vector::ZERO);
        let reads = [
            (Operation::ShiftFactor, Nodal::Velocity { velocity: &velocity, scalar: &[] }),
            (Operation::Shift, Nodal::Velocity { velocity: &along_x, scalar: excess }),
        ];
        for (operation, nodal) in reads {
            let operations = Operations::new(std::slice::from_ref(&operation), parameters, grid, body);
            work += executor.gather(grid, field, body, Gathering { nodal, operations }).volume_work;
        }
    }
    work
}

/// Moves the particles of liquids to where there is free volume, undoes overlaps with sheets, and keeps all particles
/// on their sides of the sheets; returns the work that the forces on nodes would have done on the way [J]. Comes after
/// particles and sheets have moved.
pub(in crate::mpm) fn displace<const D: usize>(
    GridContext { grid, walls, .. }: GridContext<'_, D>,
    bodies: &mut Bodies<D>,
    coupling: &mut Coupling<D>,
    step: &LeapfrogStep,
) -> f64 {
    let mut work = 0.0;
    let shifted = bodies.with_fields_mut().enumerate().filter(|(_, (_, body))| !body.work.shift.is_empty());
    for (index, (field, body)) in shifted {
        let mut shifts = std::mem::take(&mut body.work.shift);
        coupling.contact.keep_off(index, &mut shifts);
        let keep = |(p, by): (usize, &mut Vector<D>)| {
            let margin = MARGIN * body.particles.volume[p].powf(1.0 / D as f64);
            if *by != Vector::ZERO && walls.obstruct(body.particles.position[p], *by, margin) {
                *by = Vector::ZERO;
            }
        };
        parallel::for_each_chunk(&mut shifts[..], CHUNK, |start, part| (start..).zip(part).for_each(keep));
        work += parallel::sum(shifts.len(), |p| work_over(grid, field, body, coupling.contact.stencil(), p, shifts[p]));
        parallel::for_each_chunk((&mut body.particles.position[..], &shifts[..]), CHUNK, |_, (x, by)| {
            x.iter_mut().zip(by).for_each(|(x, by)| *x += *by);
        });
        body.bins.disorder.drift += largest(shifts.len(), |n| shifts[n]) / grid.cell;
        body.work.shift = shifts;
    }
    coupling.find_membranes(walls, grid.cell);
    work += keep_out(grid, walls, bodies, coupling, step);
    let positions: Vec<&[Vector<D>]> = coupling.membranes.iter().map(|m| &m.position[..]).collect();
    let shifts = coupling.contact.restore(bodies, &positions).to_vec();
    for ((field, body), shifts) in bodies.with_fields_mut().zip(&shifts).filter(|(_, shifts)| !shifts.is_empty()) {
        let stencil = coupling.contact.stencil();
        let work_of = |s: &ParticleShift<D>| work_over(grid, field, body, stencil, s.particle as usize, s.by);
        work += parallel::sum(shifts.len(), |n| work_of(&shifts[n]));
        body.bins.disorder.drift += largest(shifts.len(), |n| shifts[n].by) / grid.cell;
    }
    work
}

/// Moves particles out of obstacles; returns what the forces on nodes would have done on the way [J].
fn keep_out<const D: usize>(
    grid: &Grid<D>,
    walls: &Walls<D>,
    bodies: &mut Bodies<D>,
    coupling: &Coupling<D>,
    step: &LeapfrogStep,
) -> f64 {
    let mut work = 0.0;
    for field in 0..grid.fields.len() {
        let shielded = |x, normal, distance| coupling.lies_between(grid.cell, field, x, normal, distance);
        let shifts =
            walls.position_corrections(grid.cell, field, &BodiesAtWalls::of_field(bodies, field, &shielded), step);
        work += parallel::sum(shifts.len(), |n| {
            let (number, particle, by) = shifts[n];
            work_over(grid, field, &bodies[number], coupling.contact.stencil(), particle as usize, by)
        });
        for own in shifts.chunk_by(|a, b| a.0 == b.0) {
            let body = &mut bodies[own[0].0];
            own.iter().for_each(|&(_, particle, by)| body.particles.position[particle as usize] += by);
            body.bins.disorder.drift += largest(own.len(), |n| own[n].2) / grid.cell;
        }
    }
    work
}

/// Closes the voids of particles that have parted and are back among others.
///
/// The volume of particles and voids beyond the free volume is taken from the voids. Strain alone doesn't close
/// them where pressure holds the neighbours: a drop that fell back into a pool was a hole in it, for good.
fn close_voids<const D: usize>(
    grid: &Grid<D>,
    stencil: &FoldedStencil<D>,
    body: &mut Body<D>,
    filled: impl Fn(usize) -> f64 + Sync,
) {
    let names = body.law.storage().history;
    let (stride, Some(column)) = (names.len(), names.iter().position(|name| *name == "void")) else { return };
    let particles = &body.particles;
    let volume = grid.cell.powi(D as i32);
    let closed = |p: usize| {
        let void = particles.history[p * stride + column];
        if void <= 0.0 {
            return void;
        }
        let (mut others, mut own) = (0.0, 0.0);
        stencil.for_each(grid, particles.position[p], |node, weight, _| {
            others += weight * filled(node);
            own += weight * weight * particles.volume[p] / volume;
        });
        // The particle itself is among what fills the nodes.
        let left = (1.0 - others).max(0.0) / own;
        void.min(left)
    };
    let voids = parallel::collect(particles.len(), CHUNK, closed);
    let entries = body.particles.history.iter_mut().skip(column).step_by(stride);
    entries.zip(voids).for_each(|(entry, void)| *entry = void);
}

fn is_liquid<const D: usize>(body: &Body<D>) -> bool {
    !body.law.keeps_shape() && !body.law.is_ideal_gas() && !body.particles.is_empty()
}

/// Length of the longest of so many shifts [m].
fn largest<const D: usize>(count: usize, shift: impl Fn(usize) -> Vector<D> + Sync + Send) -> f64 {
    parallel::max(count, |n| shift(n).norm_squared()).sqrt()
}

/// Work that stresses, gravity and tractions would have done over the displacement `by` [m] of a particle, m_p Σ N_I
/// a_I · u_p [J].
fn work_over<const D: usize>(
    grid: &Grid<D>,
    field: usize,
    body: &Body<D>,
    stencil: &FoldedStencil<D>,
    p: usize,
    by: Vector<D>,
) -> f64 {
    if by == Vector::ZERO {
        return 0.0;
    }
    let (own, mut sum, particles) = (&grid.fields[field], 0.0, &body.particles);
    stencil.of_field(grid, field).for_each(grid, particles.position[p], |node, weight, mirrored| {
        let mass = own.nodes[node].mass;
        if mass > 0.0 && node < own.applied.len() {
            sum += flip(own.applied[node], mirrored).dot(by) * (weight / mass);
        }
    });
    particles.mass[p] * sum
}

/// v_I of a field.
fn velocities<const D: usize>(field: &VelocityField<D>) -> Vec<Vector<D>> {
    let velocity = |node: &Node<D>| if node.mass > 0.0 { node.momentum / node.mass } else { Vector::ZERO };
    parallel::collect(field.nodes.len(), CHUNK, |n| velocity(&field.nodes[n]))
}
