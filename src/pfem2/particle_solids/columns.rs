//! Columns of the particles of a solid beside position, velocity and phase (theory K.2).
//!
//! A particle that comes to fill an empty element has no state yet: it takes the mean of the particles of its solid
//! around it.

use crate::math::{SymTensor, Vector};
use crate::mesh::Mesh;
use crate::parallel;
use crate::pfem2::particles::Particles;

/// Deviatoric stress σ'_p [Pa], six numbers.
pub const STRESS: &str = "stress";
/// Pressure p_p [Pa], of particles of fluids too.
pub const PRESSURE: &str = "pressure";
/// Acceleration a_p of the last step [m/s²].
pub const ACCELERATION: &str = "acceleration";
/// Number of a particle of a solid, from 1 on; 0: a particle without a state yet, or of a fluid.
pub const IDENTITY: &str = "identity";

/// Adds the columns; phases from `first` on are solids, which start without stress.
pub fn add<const D: usize>(particles: &mut Particles<D>, first: usize) {
    for (name, components) in [(STRESS, 6), (PRESSURE, 1), (ACCELERATION, D), (IDENTITY, 1)] {
        particles.add_column(name, components);
    }
    particles.change_column(IDENTITY, |identity, particles| {
        let solid = identity.iter_mut().zip(&particles.phase).filter(|(_, phase)| usize::from(**phase) >= first);
        solid.enumerate().for_each(|(count, (identity, _))| *identity = (count + 1) as f64);
    });
}

/// The columns of stress [Pa], pressure [Pa] and acceleration [m/s²].
pub fn state<const D: usize>(particles: &Particles<D>) -> (&[SymTensor], &[f64], &[Vector<D>]) {
    let column = |name| particles.column(name).unwrap_or_default();
    (bytemuck::cast_slice(column(STRESS)), column(PRESSURE), bytemuck::cast_slice(column(ACCELERATION)))
}

/// State of a particle of a solid.
#[derive(Debug, Clone, Copy, Default)]
struct ParticleState<const D: usize> {
    stress: SymTensor,
    pressure: f64,
    acceleration: Vector<D>,
}

/// Gives the particles that came to fill empty elements a number, and the mean state of those of their solid around
/// them.
pub fn admit<const D: usize, const N: usize>(particles: &mut Particles<D>, mesh: &Mesh<D, N>, first: usize) {
    let identity = particles.column(IDENTITY).unwrap_or_default();
    let is_new = |p: usize| usize::from(particles.phase[p]) >= first && identity[p] == 0.0;
    let newcomers = parallel::collect_some(particles.len(), parallel::CHUNK, |p| is_new(p).then_some(p));
    if newcomers.is_empty() {
        return;
    }
    let states: Vec<ParticleState<D>> = newcomers.iter().map(|&p| mean_around(particles, mesh, p)).collect();
    let last = identity.iter().copied().fold(0.0, f64::max);
    let each = || newcomers.iter().zip(&states);
    particles.change_column(IDENTITY, |identity, _| {
        newcomers.iter().enumerate().for_each(|(count, &p)| identity[p] = last + (count + 1) as f64);
    });
    particles.change_column(STRESS, |stress, _| {
        each().for_each(|(&p, state)| stress[6 * p..6 * (p + 1)].copy_from_slice(&state.stress.0));
    });
    particles.change_column(PRESSURE, |pressure, _| each().for_each(|(&p, state)| pressure[p] = state.pressure));
    particles.change_column(ACCELERATION, |acceleration, _| {
        each().for_each(|(&p, state)| acceleration[D * p..D * (p + 1)].copy_from_slice(&state.acceleration.0));
    });
}

/// The mean state of the particles of the same solid in the elements that share a node with that of `newcomer`; no
/// stress if there are none.
fn mean_around<const D: usize, const N: usize>(
    particles: &Particles<D>,
    mesh: &Mesh<D, N>,
    newcomer: usize,
) -> ParticleState<D> {
    let (identity, (stress, pressure, acceleration)) =
        (particles.column(IDENTITY).unwrap_or_default(), state(particles));
    let nodes = mesh.elements()[particles.element[newcomer] as usize];
    let mut around: Vec<u32> = nodes.iter().flat_map(|&node| mesh.elements_around(node as usize)).copied().collect();
    around.sort_unstable();
    around.dedup();
    let known = around.iter().flat_map(|&e| particles.of(e as usize));
    let known = known.filter(|&p| particles.phase[p] == particles.phase[newcomer] && identity[p] > 0.0);
    let (mut sum, mut count) = (ParticleState::<D>::default(), 0.0);
    for p in known {
        sum.stress += stress[p];
        sum.pressure += pressure[p];
        sum.acceleration += acceleration[p];
        count += 1.0;
    }
    if count == 0.0 {
        return sum;
    }
    ParticleState {
        stress: sum.stress * (1.0 / count),
        pressure: sum.pressure / count,
        acceleration: sum.acceleration / count,
    }
}
