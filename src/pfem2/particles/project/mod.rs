//! Stage `project`: from the particles to the nodes (Becker (37)–(39); theory G.11).
//!
//! ```text
//! shape      v̂_i = Σ N_i v_p / Σ N_i                                                   Becker (38), theory (G.22)
//! Wendland   v̂_i = Σ W v_p / Σ W,   W(q) = (1 − q)⁴₊ (4q + 1),   q = |x_p − x_i|/h_i    Becker (39), theory (G.23)
//! linear     v̂_i = Σ m_p N_i [u_p + G_e (x_i − x_p)] / Σ m_p N_i  of u_p = v_p,         theory (G.24)
//!            and the same of what this doesn't show, u_p = v_p − Σ N_i v̂_i, added to it   theory (G.24a)
//! ```
//!
//! The first two mix all fluids with equal weights and reproduce constants only: order 1, with a bias at boundaries.
//! The last weighs particles with their mass m_p = ρ V_e/n_e and takes the gradient G_e within each fluid (see
//! `gradient`): exact for linear fields, order 2 up to the boundary, and Σ m_i v̂_i = Σ m_p v_p. It also keeps the
//! average of each fluid by itself, of which that of all is the mean by mass.

mod gradient;
pub(in crate::pfem2) mod group_sums;
#[cfg(test)]
mod tests;

use super::Particles;
use crate::math::Vector;
use crate::mesh::Mesh;
use crate::parallel;
use group_sums::{GroupSumTable, GroupSums};

/// Nodes that see less than this of a particle, Σ N_i, keep their values, theory G.11.
const LEAST_WEIGHT: f64 = 1e-5;

/// Fluid fills an element if it has this part of its volume.
const WHOLE: f64 = 1.0 - 1e-9;

/// The average of particles at a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum AveragingKernel {
    /// Shape functions, as the paper does (Becker (38)).
    Shape,
    /// Wendland's function of the distance (Becker (39)).
    Wendland,
    /// Shape functions and mass, corrected to be exact for linear fields of each fluid.
    #[default]
    Linear,
}

/// Convected velocity of the nodes.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ConvectedVelocity<const D: usize> {
    /// v̂_i [m/s]; of bare nodes the one that they had.
    pub mean: Vec<Vector<D>>,
    /// Velocity of each fluid by itself, v̂_αi, by fluid and node [m/s]; v̂_i where the fluid isn't seen. Without
    /// entries if there is one fluid, or the kernel mixes them.
    pub own: Vec<Vec<Vector<D>>>,
}

impl<const D: usize> ConvectedVelocity<D> {
    /// The velocity increment for the particles of each of `fluids`, v_i − v̂_αi, where the nodes have `velocity` v
    /// [m/s].
    pub fn increments(&self, velocity: &[Vector<D>], fluids: usize) -> Vec<Vec<Vector<D>>> {
        let hat = |fluid: usize| self.own.get(fluid).unwrap_or(&self.mean);
        (0..fluids).map(|fluid| velocity.iter().zip(hat(fluid)).map(|(v, hat)| *v - *hat).collect()).collect()
    }
}

/// Averages at the nodes.
#[derive(Debug, Clone, Default)]
pub struct Projected<const D: usize> {
    /// Velocity.
    pub velocity: ConvectedVelocity<D>,
    /// Fraction of each fluid, by fluid and node; they add up to one except at bare nodes, where all are zero.
    pub fraction: Vec<Vec<f64>>,
    /// Weight of the average: mass [kg] with [`AveragingKernel::Linear`].
    pub weight: Vec<f64>,
    /// True for nodes that no particle reaches, or only some in elements that solids fill.
    pub bare: Vec<bool>,
}

/// Projects velocity and fluids onto the nodes.
///
/// `densities` [kg/m³] has one entry per fluid, `previous` [m/s] one per node for those that see no particle; `volume`
/// is that of the fluid in an element, which its particles share [m³].
pub fn project<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    particles: &Particles<D>,
    densities: &[f64],
    kernel: AveragingKernel,
    previous: &[Vector<D>],
    volume: &(dyn Fn(usize) -> f64 + Sync),
) -> Projected<D> {
    let (mut table, fluids) = (table(mesh, particles, volume), densities.len());
    let equal = vec![1.0; fluids];
    let (average, densities): (Vec<Average<D>>, _) = match kernel {
        AveragingKernel::Shape => {
            table.for_each(|_, entry| entry.weight = 1.0);
            (gather(mesh, |node| shape_average(mesh, &table, node, fluids)), &equal[..])
        }
        AveragingKernel::Linear => {
            let is_cut = |e: u32| volume(e as usize) < WHOLE * mesh.simplex(e as usize).volume;
            let is_shared = |node: usize| fluids > 1 || mesh.elements_around(node).iter().any(|&e| is_cut(e));
            (linear_averages(mesh, table, fluids, is_shared), densities)
        }
        AveragingKernel::Wendland => (gather(mesh, |node| wendland_average(mesh, particles, node, fluids)), &equal[..]),
    };
    let mut projected = mix(&average, densities, previous);
    if kernel == AveragingKernel::Linear && fluids > 1 {
        let ConvectedVelocity { mean, own } = &mut projected.velocity;
        *own = (0..fluids).map(|fluid| of_one(&average, fluid, mean)).collect();
    }
    projected
}

/// The sums of one node.
#[derive(Debug, Clone)]
struct Average<const D: usize> {
    /// Σ N_i, or Σ W.
    seen: f64,
    /// By fluid.
    fluids: Vec<FluidSums<D>>,
}

/// The sums of one fluid at a node.
#[derive(Debug, Clone, Copy, Default)]
struct FluidSums<const D: usize> {
    /// Σ w N_i with the volume w of the particles, or without.
    weight: f64,
    /// The same sum of velocities.
    velocity: Vector<D>,
    /// Σ N_i, or Σ W.
    seen: f64,
}

impl<const D: usize> FluidSums<D> {
    /// v̂ of the fluid; zero at nodes that it doesn't reach.
    fn mean(&self) -> Vector<D> {
        if self.weight > 0.0 { self.velocity / self.weight } else { Vector::ZERO }
    }
}

impl<const D: usize> Average<D> {
    fn new(fluids: usize) -> Self {
        Self { seen: 0.0, fluids: vec![FluidSums::default(); fluids] }
    }

    /// True for a node that no particle is near, or only some in elements that solids fill.
    fn is_bare(&self) -> bool {
        self.seen < LEAST_WEIGHT || self.fluids.iter().all(|sums| sums.weight <= 0.0)
    }
}

fn gather<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    average: impl Fn(usize) -> Average<D> + Sync,
) -> Vec<Average<D>> {
    parallel::collect(mesh.nodes().len(), 64, average)
}

/// The sums over all particles, each fluid by itself, weighted with the particle volume V_e/n_e.
fn table<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    particles: &Particles<D>,
    volume: &(dyn Fn(usize) -> f64 + Sync),
) -> GroupSumTable<D, N> {
    GroupSumTable::collect(mesh.elements().len(), |e, entries| {
        let own = particles.of(e);
        let count = own.len();
        let runs = particles.phase[own.clone()].chunk_by(|a, b| a == b);
        let mut p = own.start;
        for run in runs {
            let mut sums = GroupSums::new(run[0]);
            for _ in run {
                sums.add(&mesh.shape_functions(e, particles.position[p]), particles.velocity[p]);
                p += 1;
            }
            entries.put(&sums);
        }
        entries.weigh(volume(e) / count.max(1) as f64);
    })
}

fn shape_average<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    table: &GroupSumTable<D, N>,
    node: usize,
    fluids: usize,
) -> Average<D> {
    let mut average = Average::new(fluids);
    for &e in mesh.elements_around(node) {
        let nodes = &mesh.elements()[e as usize];
        let Some(k) = nodes.iter().position(|&n| n as usize == node) else { continue };
        for entry in table.of(e as usize) {
            let (sum, sums) = (entry.sum(k), &mut average.fluids[entry.group as usize]);
            // Becker (38), and its denominator, which is also that of Becker (37); with mass and gradient
            // theory (G.24).
            sums.velocity += entry.values[k] * entry.weight;
            sums.weight += sum * entry.weight;
            sums.seen += sum;
            average.seen += sum;
        }
    }
    average
}

/// Averages P v_p that are exact for linear fields (theory (G.24)), plus those of the residual v_p − Σ_j N_j v̂_j that
/// they leave (theory (G.24a)).
fn linear_averages<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    mut table: GroupSumTable<D, N>,
    fluids: usize,
    is_shared: impl Fn(usize) -> bool + Sync,
) -> Vec<Average<D>> {
    let average = |mut table: GroupSumTable<D, N>| {
        table.make_linear(mesh, fluids, &is_shared);
        gather(mesh, |node| shape_average(mesh, &table, node, fluids))
    };
    let mut sum = average(table.clone());
    table.subtract(mesh, |fluid, node| sum[node].fluids[fluid].mean());
    for (sum, rest) in sum.iter_mut().zip(average(table)) {
        sum.fluids.iter_mut().zip(rest.fluids).for_each(|(sum, rest)| sum.velocity += rest.velocity);
    }
    sum
}

fn wendland_average<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    particles: &Particles<D>,
    node: usize,
    fluids: usize,
) -> Average<D> {
    let around = mesh.elements_around(node);
    let reach = mean_edge(mesh, node);
    let mut average = Average::new(fluids);
    for p in around.iter().flat_map(|&e| particles.of(e as usize)) {
        let q = (particles.position[p] - mesh.nodes()[node]).norm() / reach;
        // Becker (39), theory (G.23).
        let w = (1.0 - q).max(0.0).powi(4) * (4.0 * q + 1.0);
        let sums = &mut average.fluids[particles.phase[p] as usize];
        sums.velocity += particles.velocity[p] * w;
        sums.weight += w;
        average.seen += w;
    }
    average
}

/// Mean length of the edges at a node [m], those that several elements share counted by each.
fn mean_edge<const D: usize, const N: usize>(mesh: &Mesh<D, N>, node: usize) -> f64 {
    let others = mesh.elements_around(node).iter().flat_map(|&e| mesh.elements()[e as usize]);
    let lengths =
        others.filter(|&n| n as usize != node).map(|n| (mesh.nodes()[n as usize] - mesh.nodes()[node]).norm());
    let (sum, count) = lengths.fold((0.0, 0.0), |(sum, count), length| (sum + length, count + 1.0));
    sum / count
}

/// The mean of all fluids, weighted with their densities, and their fractions.
fn mix<const D: usize>(average: &[Average<D>], densities: &[f64], previous: &[Vector<D>]) -> Projected<D> {
    let bare: Vec<bool> = average.iter().map(Average::is_bare).collect();
    let mass = |a: &Average<D>| a.fluids.iter().zip(densities).map(|(sums, rho)| sums.weight * rho).sum::<f64>();
    let momentum =
        |a: &Average<D>| a.fluids.iter().zip(densities).map(|(sums, &rho)| sums.velocity * rho).sum::<Vector<D>>();
    let velocity = average.iter().zip(previous).zip(&bare);
    let mean = velocity.map(|((a, &old), &bare)| if bare { old } else { momentum(a) / mass(a) }).collect();
    let part =
        |a: &Average<D>, fluid: usize| a.fluids[fluid].weight / a.fluids.iter().map(|sums| sums.weight).sum::<f64>();
    let fraction = (0..densities.len())
        .map(|fluid| average.iter().zip(&bare).map(|(a, &bare)| if bare { 0.0 } else { part(a, fluid) }).collect());
    let weight = average.iter().map(mass).collect();
    Projected { velocity: ConvectedVelocity { mean, own: Vec::new() }, fraction: fraction.collect(), weight, bare }
}

/// The mean of one fluid; that of all where it isn't seen.
fn of_one<const D: usize>(average: &[Average<D>], fluid: usize, mean: &[Vector<D>]) -> Vec<Vector<D>> {
    let own = average.iter().map(|a| &a.fluids[fluid]).zip(mean);
    own.map(|(own, &mean)| if own.seen < LEAST_WEIGHT || own.weight <= 0.0 { mean } else { own.velocity / own.weight })
        .collect()
}
