//! The visits as plain loops over the particles, one at a time: the specification (theory A.1).
//!
//! ```text
//! m_I = Σ m_p N_Ip                                           Lian (60)
//! p_I = Σ m_p N_Ip (v_p + C_p (x_I − x_p))                   Lian (61); C = 0 for FLIP
//! f_I = Σ −V_p (σ_p + p_a 1) ∇N_Ip + F_p N_Ip                Lian (17, 18); F: external force, p_a: atmosphere
//! v_p ← (1 − β)(v_p + Δt Σ N_Ip a_I) + β Σ N_Ip v_I⁺       β: PIC fraction; 1 for APIC       Lian (65)
//! ẋ_p = Σ N_Ip v_I⁺                                                                         Lian (19)
//! C_p = Σ N_Ip v_I⁺ ⊗ (x_I − x_p) D⁻¹,  or Σ v_I⁺ ⊗ ∇N_Ip where D is not constant
//! L_p = Σ v_I ⊗ ∇N_Ip                                                                       Lian (62, 63)
//! ΔJ_p = det(1 + Δt L_p),  or 1/det(1 − Δt L_p) for gradients over the positions at the end
//! ```
//!
//! Runs use [`super::tiles`], which compute the same sums over sorted particles, many at a time. Tests compare the two,
//! sum by sum and whole steps (`Mpm::with_plain_transfers`).

use super::operations::Operations;
use super::visit::{MoveBy, Operation};
use super::visitor::{Executor, Gathering, Nodal, Scattering, Targets};
use crate::material::PointLaw;
use crate::math::{SymTensor, Tensor, Vector};
use crate::mpm::Grid;
use crate::mpm::grid::stencil::Stencil;
use crate::mpm::grid::{Fold, Node};
use crate::mpm::kernel::{ShapeFunction, with_shape};
use crate::mpm::particles::{Body, Reduce, Summary};
use crate::mpm::spacing::{ExcessAtParticle, shift, shift_factor};
use crate::mpm::stress::heat::filter_heat;
use crate::mpm::stress::strain::Positions;
use crate::mpm::transfer::{ScatterContent, View, mean_pressure};

/// Executes visits particle by particle.
#[derive(Debug)]
pub(in crate::mpm) struct Plain;

impl<const D: usize> Executor<D> for Plain {
    fn scatter(&self, grid: &Grid<D>, field: usize, body: &mut Body<D>, scattering: Scattering<'_, D>) {
        let Scattering { content, targets } = scattering;
        with_shape!(body.kernel, shape => match targets {
            Targets::Nodes(nodes) => {
                if content != ScatterContent::Force {
                    scatter_mass_and_momentum(shape, grid, field, body, nodes);
                }
                if content != ScatterContent::Momentum {
                    scatter_force(shape, grid, body, nodes);
                }
            }
            Targets::Momentum(momentum) => scatter_momentum(shape, grid, field, body, momentum),
            Targets::Sums(sums) => scatter_sums(shape, grid, body, content, sums),
        });
    }

    fn gather(&self, grid: &Grid<D>, _: usize, body: &mut Body<D>, gathering: Gathering<'_, D>) -> Summary {
        let Gathering { nodal, operations } = gathering;
        let (count, kernel) = (body.particles.len(), body.kernel);
        let (law, view) = body.view();
        let mut summary = Summary::default();
        for mut particle in view.in_parts(std::iter::repeat_n(1, count)) {
            let x = particle.position[0];
            let sums = with_shape!(kernel, shape => gather(shape, grid, x, nodal));
            summary = summary.plus(perform(&operations, law, sums, &mut particle));
        }
        summary
    }
}

/// The stencil of a particle, whose blocks the step has activated.
#[inline(always)]
fn stencil<const D: usize, const S: usize>(
    grid: &Grid<D>,
    shape: impl ShapeFunction<S>,
    x: Vector<D>,
) -> Stencil<D, S> {
    Stencil::new(grid, shape, x).expect("blocks around every particle are active")
}

/// Mass and momentum of the particles.
pub(super) fn scatter_mass_and_momentum<const D: usize, const S: usize>(
    shape: impl ShapeFunction<S>,
    grid: &Grid<D>,
    field: usize,
    body: &Body<D>,
    nodes: &mut [Node<D>],
) {
    let particles = &body.particles;
    for p in 0..particles.len() {
        let m = particles.mass[p];
        // Lian (60), and then Lian (61).
        stencil(grid, shape, particles.position[p]).for_each(|i, n| nodes[i].mass += m * n);
        momentum_of(shape, grid, field, body, p, |i, momentum| nodes[i].momentum += momentum);
    }
}

/// Momentum of the particles alone.
fn scatter_momentum<const D: usize, const S: usize>(
    shape: impl ShapeFunction<S>,
    grid: &Grid<D>,
    field: usize,
    body: &Body<D>,
    momentum: &mut [Vector<D>],
) {
    for p in 0..body.particles.len() {
        momentum_of(shape, grid, field, body, p, |i, part| momentum[i] += part);
    }
}

/// Calls `add(node, momentum)` for the parts of a particle's momentum, m_p N_Ip (v_p + C_p (x_I − x_p)).
///
/// A ghost beyond a wall that extrapolates hands 2 N_g to the node on the wall and −N_g to the next; there the affine
/// part is that of the place of the node that receives it (theory A.3).
fn momentum_of<const D: usize, const S: usize>(
    shape: impl ShapeFunction<S>,
    grid: &Grid<D>,
    field: usize,
    body: &Body<D>,
    p: usize,
    mut add: impl FnMut(usize, Vector<D>),
) {
    let (particles, folds) = (&body.particles, grid.folds_in(field));
    let (m, v, c) = (particles.mass[p], particles.velocity[p], particles.affine(p));
    let stencil = stencil(grid, shape, particles.position[p]);
    stencil.for_each_offset(|i, n, dx| add(i, (v + c.apply(dx)) * (m * n)));
    stencil.for_each(|i, n| {
        let ijk = grid.coordinates(i);
        for (a, end) in (0..D).flat_map(|a| [(a, 0), (a, 1)]) {
            let (plane, inward) = if end == 0 { (0, 1) } else { (grid.cells[a], -1) };
            if folds[a][end] != Fold::Extrapolate || ijk[a] != plane - inward {
                continue;
            }
            for (depth, factor) in [(1, 2.0), (2, -1.0)] {
                let mut place = ijk;
                place[a] += depth * inward;
                let further = Vector::unit(a) * (factor * f64::from(depth * inward) * grid.cell);
                add(grid.find(place).expect("supports are active"), c.apply(further) * (m * n));
            }
        }
    });
}

/// Forces of stresses above the atmosphere, with the pressure that averaging adds, and of external forces.
pub(super) fn scatter_force<const D: usize, const S: usize>(
    shape: impl ShapeFunction<S>,
    grid: &Grid<D>,
    body: &Body<D>,
    nodes: &mut [Node<D>],
) {
    let (particles, work) = (&body.particles, &body.work);
    for p in 0..particles.len() {
        let excess = work.excess.get(p).copied().unwrap_or_default();
        let sigma = particles.stress(p) + SymTensor::isotropic(body.ambient - excess);
        let v_sigma = sigma.full() * particles.volume[p];
        let f = work.external.get(p).copied().unwrap_or_default();
        stencil(grid, shape, particles.position[p]).for_each_gradient(|i, n, dn| {
            let internal = Vector::from_fn(|a| (0..D).map(|b| v_sigma[a][b] * dn[b]).sum());
            // Lian (18) less Lian (17).
            nodes[i].force += f * n - internal;
        });
    }
}

/// Σ V N and Σ V q N, where q is the volume ratio or the pressure (theory A.10).
fn scatter_sums<const D: usize, const S: usize>(
    shape: impl ShapeFunction<S>,
    grid: &Grid<D>,
    body: &Body<D>,
    content: ScatterContent,
    sums: &mut [[f64; 2]],
) {
    let particles = &body.particles;
    for p in 0..particles.len() {
        let q = match content {
            ScatterContent::Volumes => body.work.volume_ratio[p],
            _ => pressure(particles.pressure[p], particles.stress.get(p), D),
        };
        let v = particles.volume[p];
        stencil(grid, shape, particles.position[p]).for_each(|i, n| {
            sums[i][0] += v * n;
            sums[i][1] += v * q * n;
        });
    }
}

/// Minus the mean of the normal stresses along the axes [Pa].
fn pressure(pressure: f64, stress: Option<&SymTensor>, axes: usize) -> f64 {
    stress.filter(|_| axes < 3).map_or(pressure, |stress| mean_pressure(stress, axes))
}

/// The sums over the nodes around a particle.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Sums<const D: usize> {
    /// Σ N s of a scalar.
    pub scalar: f64,
    /// Σ N v [m/s].
    pub velocity: Vector<D>,
    /// Σ N a [m/s²].
    pub acceleration: Vector<D>,
    /// Σ v ⊗ ∇N [1/s].
    pub gradient: Tensor<D>,
    /// Σ N v ⊗ (x_I − x) [m²/s].
    pub moment: Tensor<D>,
}

/// Gathers at the place `x` [m].
pub(super) fn gather<const D: usize, const S: usize>(
    shape: impl ShapeFunction<S>,
    grid: &Grid<D>,
    x: Vector<D>,
    nodal: Nodal<'_, D>,
) -> Sums<D> {
    let mut sums = Sums::default();
    let node = |i: usize| match nodal {
        Nodal::Motion(nodes) => (0.0, nodes[i].velocity(), nodes[i].acceleration()),
        Nodal::MidstepVelocity(nodes, dt) => (0.0, nodes[i].midstep_velocity(dt), Vector::ZERO),
        Nodal::Velocity { velocity, scalar } => {
            (scalar.get(i).map_or(0.0, |s| s[0]), velocity.get(i).copied().unwrap_or_default(), Vector::ZERO)
        }
    };
    let stencil = stencil(grid, shape, x);
    stencil.for_each_gradient(|i, n, dn| {
        let (scalar, v, a) = node(i);
        sums.scalar += scalar * n;
        sums.velocity += v * n;
        sums.acceleration += a * n;
        // Lian (62, 63): its symmetric and its skew part.
        sums.gradient += Tensor::outer(v, dn);
    });
    stencil.for_each_offset(|i, n, dx| sums.moment += Tensor::outer(node(i).1, dx) * n);
    sums
}

/// Performs operations on one particle, the only one of the view, with the sums at its place.
fn perform<const D: usize>(
    operations: &Operations<'_, D>,
    law: &dyn PointLaw,
    mut sums: Sums<D>,
    particle: &mut View<'_, D>,
) -> Summary {
    let (mut summary, dt) = (Summary::default(), operations.strain_dt);
    for operation in operations.list {
        match operation {
            Operation::MidstepVelocity => particle.mean[0] = sums.velocity,
            // ẋ_p, Lian (19).
            Operation::Rate => particle.rate.iter_mut().for_each(|rate| *rate = sums.velocity),
            Operation::Velocity => move_with(operations, &sums, particle),
            Operation::TakeVelocity => particle.velocity[0] = sums.velocity,
            Operation::FilterHeat { stage, order } => {
                particle.noise[0] -= sums.velocity;
                let per_mass = filter_heat(*stage, *order, particle.noise[0], sums.velocity, sums.scalar);
                summary.heat += add_heat(per_mass, particle);
            }
            Operation::VolumeRatio(positions) => {
                particle.volume_ratio[0] = volume_ratio(sums.gradient * dt, *positions);
            }
            Operation::Heat if operations.heated => summary.heat += add_heat(sums.scalar, particle),
            Operation::Heat => {}
            Operation::ReferToStart => sums.gradient = referred_to_start(sums.gradient, dt),
            Operation::AverageVolumeRatio => average_volume_ratio(operations, &mut sums, particle),
            Operation::Stress => {
                if !update_stress(operations, law, &sums, particle) {
                    return Summary::inverted();
                }
            }
            Operation::AveragePressure => {
                particle.excess[0] = operations.blend * (sums.scalar - particle.mean_pressure(0));
            }
            Operation::ShiftFactor => particle.shift[0][0] = shift_factor(&sums.gradient, dt),
            Operation::Shift => {
                let excess = ExcessAtParticle { value: sums.scalar, slope: Vector(sums.gradient[0]) };
                summary.volume_work += shift(particle, 0, excess, operations.cell, law.reference_sound_speed());
            }
            Operation::Land(by) => {
                summary = Summary { heat: summary.heat, ..land(operations, *by, &sums, particle) };
            }
        }
    }
    summary
}

/// Updates the stress of the particle by its law, which reads the velocity gradient only if it needs it; false for
/// a particle that is turned inside out.
fn update_stress<const D: usize>(
    operations: &Operations<'_, D>,
    law: &dyn PointLaw,
    sums: &Sums<D>,
    particle: &mut View<'_, D>,
) -> bool {
    let ratio = particle.volume_ratio[0];
    let is_possible = ratio > 0.0 && ratio.is_finite();
    if is_possible {
        let gradient = [sums.gradient.embed(0.0)];
        let gradient = if law.needs_gradient() { &gradient[..] } else { &[] };
        particle.update_law(law, gradient, operations.strain_dt, operations.cell);
    }
    is_possible
}

/// Adds a heat per mass [J/kg] to the energy of the particle; returns the heat [J].
fn add_heat<const D: usize>(per_mass: f64, particle: &mut View<'_, D>) -> f64 {
    let heat = particle.mass[0] * per_mass;
    particle.energy[0] += heat;
    heat
}

/// ΔJ_p, from the increment of strain L_p Δt over the positions at the start or at the end of the step.
fn volume_ratio<const D: usize>(increment: Tensor<D>, positions: Positions) -> f64 {
    match positions {
        Positions::Start => (Tensor::identity() + increment).embed(1.0).determinant(),
        Positions::End => 1.0 / (Tensor::identity() - increment).embed(1.0).determinant(),
    }
}

/// A gradient over the positions at the end of a step, referred to those at its start [1/s].
fn referred_to_start<const D: usize>(gradient: Tensor<D>, dt: f64) -> Tensor<D> {
    let back = (Tensor::identity() - gradient * dt).embed(1.0).inverse().unwrap_or_default();
    let start = gradient.embed(0.0).dot(&back);
    Tensor::from_fn(|a, b| start[a][b])
}

/// Blends ΔJ_p with its average at the nodes, and gives the gradient the same change of volume.
fn average_volume_ratio<const D: usize>(
    operations: &Operations<'_, D>,
    sums: &mut Sums<D>,
    particle: &mut View<'_, D>,
) {
    let (own, dt) = (particle.volume_ratio[0], operations.strain_dt);
    let blended = own + operations.blend * (sums.scalar - own);
    let growth = (blended / own).powf(1.0 / D as f64);
    particle.volume_ratio[0] = blended;
    sums.gradient = ((Tensor::identity() + sums.gradient * dt) * growth - Tensor::identity()) * (1.0 / dt);
}

/// Moves the particle to the place where it ends the step.
fn land<const D: usize>(
    operations: &Operations<'_, D>,
    by: MoveBy,
    sums: &Sums<D>,
    particle: &mut View<'_, D>,
) -> Summary {
    if by == MoveBy::Gathered || operations.strain_moves {
        operations.landing.land_by(particle, &[sums.velocity][..])
    } else {
        operations.landing.land(particle)
    }
}

/// v_p and C_p of one particle.
fn move_with<const D: usize>(operations: &Operations<'_, D>, sums: &Sums<D>, particle: &mut View<'_, D>) {
    let transport = operations.transport;
    let pic_fraction = if particle.affine.is_empty() { transport.pic_fraction } else { 1.0 };
    let v = particle.velocity[0];
    // Lian (65).
    particle.velocity[0] = (v + sums.acceleration * transport.dt) * (1.0 - pic_fraction) + sums.velocity * pic_fraction;
    for c in particle.affine.iter_mut() {
        *c = transport.per_inertia.map_or(sums.gradient, |scale| sums.moment * scale);
    }
}
