//! The volumes that particles of an ideal gas stand for, from the grid (theory A.12).
//!
//! ```text
//! p_I = Σ_p V_p p_p N_Ip / hᴰ     at nodes around which the gas fills space; next to them the mean of their neighbours
//! V_p ← V_p r,   p_p ← p_p/r,     r = (p_p / Σ_I N_Ip p_I)^β
//! ```
//!
//! A particle's volume follows the divergence of velocity along its path, V̇ = V tr L, and keeps for ever what it was
//! wrong by: paths wander through what the grid can't see, and in a bag at rest the sum of the volumes doubles in
//! thousands of steps. Nothing else shows that. Of an ideal gas V p = (γ − 1) e, so that forces, work and the speed
//! of sound γ (γ − 1) e/m are the same for every division of V between particles; but pressures and densities are read
//! from it, and how near a particle comes to a surface. The energy per volume of the grid is known, and volumes are
//! relaxed to it, slowly, so that waves stay as sharp as they are.
//!
//! Within an atmosphere p_a (`ambient`) forces and energy depend on the division of V, too: the force of a particle
//! is (p − p_a) V, and the atmosphere has taken the work p_a V. So volumes are relaxed in proportion to |1 − p_a/p|,
//! the rate at which p − p_a lets particles drift apart, and not at all at p_a, where p_I differs from p_p by the noise
//! of its sum alone. The work p_a dV on what was no volume of the gas comes back to the particle: e + p_a V stays.
//!
//! ```text
//! r = (p_p/p)^(β min(|1 − p_a/p|, 1)/(1 + w)) ≤ 1 + ½/w,      p = Σ_I N_Ip p_I,   w = p_a V_p/e_p
//! e_p ← e_p (1 − (r − 1) w),   p_p ← p_p (1 − (r − 1) w)/r
//! ```

use super::shifting::GridContext;
use crate::math::{SymTensor, Vector};
use crate::mpm::contact::Contacts;
use crate::mpm::executor::{Scattering, Targets};
use crate::mpm::grid::GhostFractions;
use crate::mpm::particles::Bodies;
use crate::mpm::transfer::ScatterContent;
use crate::mpm::wall::Walls;
use crate::mpm::wall::folded_stencil::FoldedStencil;
use crate::mpm::{Body, Grid, Particles, VelocityField};
use crate::parallel;

/// Steps between two corrections, and the exponent β of each.
const EVERY: u64 = 10;
const EXPONENT: f64 = 0.1;

/// Number of rows of nodes next to those that the gas fills which take their neighbours' mean.
const ROWS: usize = 3;

/// Obstacles and walls nearer than this [cells] take part of a node's volume.
const CLEAR: f64 = 1.5;

/// Particles per parallel task.
const TASK: usize = 1024;

/// Leads the volumes of ideal gases to the grid's, every few steps, in fields that such a gas has to itself.
pub(in crate::mpm) fn correct<const D: usize>(
    steps: u64,
    GridContext { grid, ghosts, walls, executor }: GridContext<'_, D>,
    bodies: &mut Bodies<D>,
    contact: &Contacts<D>,
) {
    if !steps.is_multiple_of(EVERY) {
        return;
    }
    for field in 0..grid.fields.len() {
        let [body] = bodies.field_mut(field) else { continue };
        if !body.law.is_ideal_gas() || body.particles.is_empty() {
            continue;
        }
        let mut sums = vec![[0.0; 2]; grid.node_count()];
        let targets = Targets::Sums(&mut sums);
        executor.scatter(grid, field, body, Scattering { content: ScatterContent::Pressures, targets });
        ghosts.fold(&GhostFractions::default(), &mut sums, |_, _, _| {});
        let full = |node: usize| !contact.meets(node) && is_clear(grid, walls, node);
        let pressure = grid_pressure(grid, &grid.fields[field], body, &sums, full);
        relax_volumes(grid, contact.stencil(), &pressure, body);
    }
}

/// True if neither the ends of the domain nor obstacles take part of the node's volume.
fn is_clear<const D: usize>(grid: &Grid<D>, walls: &Walls<D>, node: usize) -> bool {
    let ijk = grid.coordinates(node);
    let rows = CLEAR.ceil() as i32;
    (0..D).all(|a| (rows..=grid.cells[a] - rows).contains(&ijk[a]))
        && walls.solids().all(|solid| solid.distance(grid.position(node), Vector::ZERO).0 > CLEAR * grid.cell)
}

/// p_I by node; zero where it isn't known.
fn grid_pressure<const D: usize>(
    grid: &Grid<D>,
    field: &VelocityField<D>,
    body: &Body<D>,
    sums: &[[f64; 2]],
    full: impl Fn(usize) -> bool + Sync,
) -> Vec<f64> {
    let positions = &body.particles.position;
    let cell_of =
        |p: usize| grid.find(std::array::from_fn(|a| ((positions[p][a] - grid.origin[a]) / grid.cell).floor() as i32));
    let mut occupied = vec![false; grid.node_count()];
    parallel::collect_some(positions.len(), TASK, cell_of).into_iter().for_each(|node| occupied[node] = true);
    let filled = |node: usize| {
        let ijk = grid.coordinates(node);
        let cell = |n: usize| std::array::from_fn(|a| ijk[a] - (n >> a & 1) as i32);
        (0..1 << D).all(|n| grid.find(cell(n)).is_some_and(|corner| occupied[corner]))
    };
    let volume = grid.cell.powi(D as i32);
    let known = |node: usize| {
        let heavy = field.nodes[node].mass > 0.0;
        if heavy && filled(node) && full(node) { sums[node][1] / volume } else { 0.0 }
    };
    let mut pressure: Vec<f64> = parallel::collect(grid.node_count(), TASK, known);
    for _ in 0..ROWS {
        let next = |node: usize| {
            if pressure[node] > 0.0 || field.nodes[node].mass <= 0.0 {
                return pressure[node];
            }
            let around = grid.neighbours(node).map(|other| pressure[other]).filter(|p| *p > 0.0);
            let (sum, count) = around.fold((0.0, 0), |(sum, count), p| (sum + p, count + 1));
            if count > 0 { sum / f64::from(count) } else { 0.0 }
        };
        pressure = parallel::collect(grid.node_count(), TASK, next);
    }
    pressure
}

/// Relaxes the volumes of a body's particles towards those at which they have the pressures at the nodes.
fn relax_volumes<const D: usize>(grid: &Grid<D>, stencil: &FoldedStencil<D>, pressure: &[f64], body: &mut Body<D>) {
    let (particles, ambient) = (&mut body.particles, body.ambient);
    let there = |x: Vector<D>| {
        let (mut sum, mut weights) = (0.0, 0.0);
        stencil.for_each(grid, x, |node, weight, _| {
            if pressure[node] > 0.0 {
                sum += pressure[node] * weight;
                weights += weight;
            }
        });
        if weights > 0.5 { sum / weights } else { 0.0 }
    };
    let relaxed = parallel::collect(particles.len(), TASK, |p| {
        let wanted = there(particles.position[p]);
        (wanted > 0.0 && particles.pressure[p] > 0.0).then(|| GasState::of(particles, p).relaxed(wanted, ambient))
    });
    for (p, relaxed) in relaxed.into_iter().enumerate() {
        if let Some(relaxed) = relaxed {
            relaxed.store(particles, p);
        }
    }
}

/// Pressure [Pa], volume [m³] and internal energy [J] of a particle of gas.
#[derive(Clone, Copy)]
struct GasState {
    pressure: f64,
    volume: f64,
    energy: f64,
}

impl GasState {
    /// That of particle `p`.
    fn of<const D: usize>(particles: &Particles<D>, p: usize) -> Self {
        Self { pressure: particles.pressure[p], volume: particles.volume[p], energy: particles.energy[p] }
    }

    /// With the volume relaxed towards that at which the pressure is `wanted` [Pa], within the atmosphere `ambient`
    /// [Pa].
    fn relaxed(self, wanted: f64, ambient: f64) -> Self {
        let Self { pressure: own, volume, energy } = self;
        // w: the energy p_a V of the atmosphere's part of the volume, over the internal energy.
        let ambient_ratio = if energy > 0.0 { ambient * volume / energy } else { 0.0 };
        let exponent = EXPONENT * (1.0 - ambient / wanted).abs().min(1.0);
        // The energy changes the pressure, too; no more than half of it pays for volume.
        let ratio = (own / wanted).powf(exponent / (1.0 + ambient_ratio)).min(1.0 + 0.5 / ambient_ratio);
        let left = 1.0 - (ratio - 1.0) * ambient_ratio;
        Self { pressure: own * left / ratio, volume: volume * ratio, energy: energy * left }
    }

    /// Makes it that of particle `p`, whose stress follows the pressure.
    fn store<const D: usize>(self, particles: &mut Particles<D>, p: usize) {
        let before = std::mem::replace(&mut particles.pressure[p], self.pressure);
        (particles.volume[p], particles.energy[p]) = (self.volume, self.energy);
        if let Some(stress) = particles.stress.get_mut(p) {
            *stress += SymTensor::isotropic(before - self.pressure);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{EXPONENT, GasState};
    use crate::mpm::Particles;

    fn relax_volume(particles: &mut Particles<2>, p: usize, wanted: f64, ambient: f64) {
        GasState::of(particles, p).relaxed(wanted, ambient).store(particles, p);
    }

    /// A particle of an ideal gas (γ = 1.4) of volume 2 at this pressure.
    fn particle(pressure: f64) -> Particles<2> {
        let (volume, pressure) = (vec![2.0], vec![pressure]);
        Particles { energy: vec![pressure[0] * 2.0 / 0.4], volume, pressure, ..Particles::default() }
    }

    /// Without an atmosphere the energy stays, and the pressure comes nearer by a power of β.
    #[test]
    fn volumes_follow_the_pressure_at_constant_energy() {
        let mut gas = particle(1.5);
        let energy = gas.energy[0];
        relax_volume(&mut gas, 0, 1.0, 0.0);
        assert!(gas.energy[0] == energy && (gas.volume[0] - 2.0 * 1.5f64.powf(EXPONENT)).abs() < 1e-14);
        assert!((gas.pressure[0] - 1.5f64.powf(1.0 - EXPONENT)).abs() < 1e-14);
    }

    /// Within an atmosphere of 0.5 under a pressure of 1 it comes nearer by half of β; e + p_a V stays, and so does γ.
    #[test]
    fn the_atmosphere_pays_for_the_volume_that_it_gets_back() {
        for pressure in [0.98, 1.02] {
            let mut gas = particle(pressure);
            let before = gas.energy[0] + 0.5 * gas.volume[0];
            relax_volume(&mut gas, 0, 1.0, 0.5);
            assert!((gas.energy[0] + 0.5 * gas.volume[0] - before).abs() < 1e-14);
            assert!((gas.pressure[0] * gas.volume[0] / gas.energy[0] - 0.4).abs() < 1e-14);
            let closer = 1.0 - gas.pressure[0].ln() / pressure.ln();
            assert!((closer - 0.5 * EXPONENT).abs() < 0.01 * EXPONENT, "{closer}");
        }
    }

    /// At the pressure of the atmosphere nothing is led; a particle that hardly has energy keeps half of it.
    #[test]
    fn nothing_changes_at_the_pressure_of_the_atmosphere_and_thin_gas_keeps_half_its_energy() {
        let mut gas = particle(1.1);
        relax_volume(&mut gas, 0, 1.0, 1.0);
        assert!(gas.volume[0] == 2.0 && gas.pressure[0] == 1.1);
        let mut thin = particle(1e-3);
        relax_volume(&mut thin, 0, 1e-60, 1.0);
        assert!((thin.energy[0] / 5e-3 - 0.5).abs() < 1e-12 && thin.pressure[0] > 0.0, "{thin:?}");
    }
}
