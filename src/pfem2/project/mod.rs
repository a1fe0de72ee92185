//! Stage 2: from the particles to the nodes (eqs. 37–39; theory section 4).
//!
//! ```text
//! shape      v̂_i = Σ N_i v_p / Σ N_i                                                   eq. 38
//! Wendland   v̂_i = Σ W v_p / Σ W,   W(q) = (1 − q)⁴₊ (4q + 1),   q = |x_p − x_i|/h_i    eq. 39
//! linear     v̂_i = Σ m_p N_i [v_p + G_e (x_i − x_p)] / Σ m_p N_i                       theory 4.3
//! ```
//!
//! The first two mix all fluids with equal weights and reproduce constants only: order 1, with a bias at boundaries.
//! The last weighs particles with their mass m_p = ρ V_e/n_e and takes the gradient G_e within each fluid (see
//! `gradient`): exact for linear fields, order 2 up to the boundary, and Σ m_i v̂_i = Σ m_p v_p.

mod gradient;
pub(super) mod moments;
#[cfg(test)]
mod tests;

use super::particles::Particles;
use crate::math::Vector;
use crate::mesh::Mesh;
use moments::{Moments, Table};
use rayon::prelude::*;

/// Nodes that see less than this of a particle, Σ N_i, keep their values (as in the source).
const LEAST: f64 = 1e-5;

/// How particles are averaged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Kernel {
    /// Shape functions, as the paper does (eq. 38).
    Shape,
    /// Wendland's function of the distance (eq. 39).
    Wendland,
    /// Shape functions and mass, corrected to be exact for linear fields of each fluid.
    #[default]
    Linear,
}

/// What the nodes receive.
#[derive(Debug, Clone, Default)]
pub struct Projected<const D: usize> {
    /// Velocity v̂_i [m/s]; of bare nodes the one that they had.
    pub velocity: Vec<Vector<D>>,
    /// Share of each fluid, by fluid and node; they add up to one except at bare nodes, where all are zero.
    pub fraction: Vec<Vec<f64>>,
    /// Weight of the average: mass [kg] with [`Kernel::Linear`].
    pub weight: Vec<f64>,
    /// True for nodes that no particle reaches.
    pub bare: Vec<bool>,
}

/// Projects velocity and fluids onto the nodes.
///
/// `densities` [kg/m³] has one entry per fluid, `previous` [m/s] one per node for those that see no particle.
pub fn project<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    particles: &Particles<D>,
    densities: &[f64],
    kernel: Kernel,
    previous: &[Vector<D>],
) -> Projected<D> {
    let mut table = table(mesh, particles);
    let average: Vec<Average<D>> = match kernel {
        Kernel::Shape => {
            table.for_each(|_, entry| entry.weight = 1.0);
            gather(mesh, |node| shape_average(mesh, &table, node, &vec![1.0; densities.len()]))
        }
        Kernel::Linear => {
            table.make_linear(mesh, densities.len());
            gather(mesh, |node| shape_average(mesh, &table, node, densities))
        }
        Kernel::Wendland => gather(mesh, |node| wendland_average(mesh, particles, node, densities.len())),
    };
    unzip(average, densities.len(), previous)
}

/// The sums of one node.
#[derive(Debug, Clone)]
struct Average<const D: usize> {
    momentum: Vector<D>,
    weight: f64,
    /// Σ N_i, or Σ W.
    seen: f64,
    /// Weight without the density, by fluid.
    share: Vec<f64>,
}

impl<const D: usize> Average<D> {
    fn new(fluids: usize) -> Self {
        Self { momentum: Vector::ZERO, weight: 0.0, seen: 0.0, share: vec![0.0; fluids] }
    }
}

fn gather<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    average: impl Fn(usize) -> Average<D> + Sync + Send,
) -> Vec<Average<D>> {
    (0..mesh.nodes().len()).into_par_iter().map(average).collect()
}

/// The moments of all particles, each fluid by itself, weighted with the particle volume V_e/n_e.
fn table<const D: usize, const N: usize>(mesh: &Mesh<D, N>, particles: &Particles<D>) -> Table<D, N> {
    Table::collect(mesh.elements().len(), |e, entries| {
        let own = particles.of(e);
        let count = own.len();
        let runs = particles.fluid[own.clone()].chunk_by(|a, b| a == b);
        let mut p = own.start;
        for run in runs {
            let mut moments = Moments::new(run[0]);
            for _ in run {
                moments.add(&mesh.shape_functions(e, particles.position[p]), particles.velocity[p]);
                p += 1;
            }
            entries.put(&moments);
        }
        entries.weigh(mesh.simplex(e).volume / count.max(1) as f64);
    })
}

fn shape_average<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    table: &Table<D, N>,
    node: usize,
    densities: &[f64],
) -> Average<D> {
    let mut average = Average::new(densities.len());
    for &e in mesh.elements_around(node) {
        let nodes = &mesh.elements()[e as usize];
        let Some(k) = nodes.iter().position(|&n| n as usize == node) else { continue };
        for entry in table.of(e as usize) {
            let (sum, fluid) = (entry.sum(k), entry.group as usize);
            let mass = entry.weight * densities[fluid];
            average.momentum += entry.values[k] * mass;
            average.weight += sum * mass;
            average.seen += sum;
            average.share[fluid] += sum * entry.weight;
        }
    }
    average
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
        let w = (1.0 - q).max(0.0).powi(4) * (4.0 * q + 1.0);
        average.momentum += particles.velocity[p] * w;
        average.weight += w;
        average.share[particles.fluid[p] as usize] += w;
    }
    average.seen = average.weight;
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

fn unzip<const D: usize>(average: Vec<Average<D>>, fluids: usize, previous: &[Vector<D>]) -> Projected<D> {
    let bare: Vec<bool> = average.iter().map(|a| a.seen < LEAST).collect();
    let velocity = average.iter().zip(previous).zip(&bare);
    let velocity = velocity.map(|((a, &old), &bare)| if bare { old } else { a.momentum / a.weight }).collect();
    let share = |a: &Average<D>, fluid: usize| a.share[fluid] / a.share.iter().sum::<f64>();
    let fraction = (0..fluids)
        .map(|fluid| average.iter().zip(&bare).map(|(a, &bare)| if bare { 0.0 } else { share(a, fluid) }).collect());
    Projected { fraction: fraction.collect(), velocity, weight: average.iter().map(|a| a.weight).collect(), bare }
}
