//! Weights of the fractions of three and more fluids, which keep the volume of each (theory (G.8)).
//!
//! ```text
//! f_k ← w_k f_k / Σ_j w_j f_j,      V_k(w) = V_k at the start,      ∂V_k/∂ln w_j = ∂V_j/∂ln w_k
//! ```
//!
//! V_k is what elements hold of a fluid, cut or mixed as [`Phases`] find them. A weight moves the places where
//! fractions are equal, and nothing where a fluid is alone; interfaces move by less than an element. With a fixed
//! weight of the largest fluid the derivatives are a symmetric matrix of positive eigenvalues, and Newton steps, halved
//! where they don't help, find the weights. The largest fluid takes what others can't have: a fluid that began or has
//! become too small for a node of its own. Where an element begins to hold a third fluid, V jumps by a part of it: what
//! is missing then is in the history.

use crate::math::dense::inverse_of_semidefinite;
use crate::parallel;
use crate::pfem2::phases::FluidRegion;
use crate::pfem2::phases::Phases;
use crate::pfem2::phases::phase_list::PhaseList;

/// Most Newton steps.
const STEPS: usize = 20;

/// Most halvings of one.
const HALVINGS: usize = 6;

/// Largest |ln w|: a weight of ten.
const REACH: f64 = std::f64::consts::LN_10;

/// Step of ln w for derivatives.
const NUDGE: f64 = 1e-5;

/// Gives fractions the weights with which each fluid has the volume `wanted` [m³]; `fraction` by fluid and node.
/// Returns the largest factor between two weights.
pub fn keep_volumes<const D: usize, const N: usize>(
    region: &FluidRegion<D, N>,
    list: &PhaseList,
    fraction: &mut [Vec<f64>],
    wanted: &[f64],
) -> f64 {
    let fractions = WeightedFractions::new(*region, list, fraction, wanted);
    let mut log = vec![0.0; wanted.len()];
    let mut missing = fractions.missing(&log);
    for _ in 0..STEPS {
        let Some((nearer, rest)) = fractions.nearer(&log, &missing) else { break };
        (log, missing) = (nearer, rest);
    }
    let weighed = fractions.weighed(&log);
    fraction.iter_mut().zip(weighed).for_each(|(own, weighed)| *own = weighed);
    let largest = log.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    (largest - log.iter().copied().fold(f64::INFINITY, f64::min)).exp()
}

/// Fractions with weights.
struct WeightedFractions<'a, const D: usize, const N: usize> {
    region: FluidRegion<'a, D, N>,
    list: &'a PhaseList,
    fraction: &'a [Vec<f64>],
    /// Elements in which several fluids are.
    band: Vec<u32>,
    /// Volume of each fluid that is wanted in them [m³].
    wanted: Vec<f64>,
    /// Fluids that take weights.
    free: Vec<usize>,
}

impl<'a, const D: usize, const N: usize> WeightedFractions<'a, D, N> {
    fn new(region: FluidRegion<'a, D, N>, list: &'a PhaseList, fraction: &'a [Vec<f64>], wanted: &[f64]) -> Self {
        let mesh = region.mesh;
        let alone = |e: usize| {
            let nodes = mesh.elements()[e];
            fraction.iter().position(|own| nodes.iter().all(|&node| own[node as usize] == 1.0))
        };
        let alone = parallel::collect(mesh.elements().len(), parallel::CHUNK, alone);
        let largest = (0..wanted.len()).max_by(|&a, &b| wanted[a].total_cmp(&wanted[b]));
        let free = (0..wanted.len()).filter(|&k| wanted[k] > 0.0 && Some(k) != largest).collect();
        let mut wanted = wanted.to_vec();
        let mut band = Vec::new();
        for (e, fluid) in alone.into_iter().enumerate() {
            match fluid {
                Some(fluid) => wanted[fluid] -= region.volume(e),
                None => band.push(e as u32),
            }
        }
        Self { region, list, fraction, band, wanted, free }
    }

    /// The fractions with the weights e^`log`.
    fn weighed(&self, log: &[f64]) -> Vec<Vec<f64>> {
        let weight: Vec<f64> = log.iter().map(|log| log.exp()).collect();
        let nodes = self.region.mesh.nodes().len();
        let sum = |node: usize| weight.iter().zip(self.fraction).map(|(w, own)| w * own[node]).sum::<f64>();
        let sums = parallel::collect(nodes, parallel::CHUNK, sum);
        let of = |(own, w): (&Vec<f64>, &f64)| parallel::collect(nodes, parallel::CHUNK, |i| w * own[i] / sums[i]);
        self.fraction.iter().zip(&weight).map(of).collect()
    }

    /// Missing volumes of the fluids that take weights [m³].
    fn missing(&self, log: &[f64]) -> Vec<f64> {
        let weighed = self.weighed(log);
        let phases = Phases { list: self.list, fraction: &weighed, level: &[] };
        let volumes = phases.volumes_in(&self.region, self.band.len(), |i| self.band[i] as usize);
        self.free.iter().map(|&k| self.wanted[k] - volumes[k]).collect()
    }

    /// Weights with which less is missing, and what that is; `None` if nothing is missing, or if no halving of the
    /// Newton step helps.
    fn nearer(&self, log: &[f64], missing: &[f64]) -> Option<(Vec<f64>, Vec<f64>)> {
        let exact = 8.0 * f64::EPSILON * self.region.mesh.volume();
        if missing.iter().all(|missing| missing.abs() <= exact) {
            return None;
        }
        let slopes = self.slopes(log, missing);
        // A fluid that no node belongs to can't be had by weights, and is not to keep the others from theirs.
        let there: Vec<bool> = (0..missing.len()).map(|k| slopes[k][k] > exact).collect();
        let size = |missing: &[f64]| {
            missing.iter().zip(&there).filter(|(_, there)| **there).fold(0.0, |most: f64, (own, _)| most.max(own.abs()))
        };
        let now = size(missing);
        if now <= exact {
            return None;
        }
        let step =
            inverse_of_semidefinite(slopes).into_iter().map(|row| row.iter().zip(missing).map(|(a, m)| a * m).sum());
        let step: Vec<f64> = step.collect();
        let part = |halvings: usize| {
            let part = 0.5f64.powi(halvings as i32);
            let mut nearer = log.to_vec();
            for (&k, step) in self.free.iter().zip(&step) {
                nearer[k] = (nearer[k] + part * step).clamp(-REACH, REACH);
            }
            let rest = self.missing(&nearer);
            (size(&rest) < now).then_some((nearer, rest))
        };
        (0..HALVINGS).find_map(part)
    }

    /// ∂V_k/∂ln w_j of the fluids that take weights [m³].
    fn slopes(&self, log: &[f64], missing: &[f64]) -> Vec<Vec<f64>> {
        let column = |&j: &usize| {
            let mut nudged = log.to_vec();
            nudged[j] += NUDGE;
            let rest = self.missing(&nudged);
            missing.iter().zip(rest).map(|(before, after)| (before - after) / NUDGE).collect::<Vec<f64>>()
        };
        let columns: Vec<Vec<f64>> = self.free.iter().map(column).collect();
        let mean = |k: usize, j: usize| 0.5 * (columns[j][k] + columns[k][j]);
        (0..missing.len()).map(|k| (0..missing.len()).map(|j| mean(k, j)).collect()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vector;
    use crate::mesh::Mesh;

    const DENSITY: [f64; 3] = [3.0, 2.0, 1.0];

    /// Three layers that meet obliquely, each fading into the next over two cells.
    fn layers(mesh: &Mesh<2, 3>) -> Vec<Vec<f64>> {
        let fade = |depth: f64| (0.5 + 2.5 * depth).clamp(0.0, 1.0);
        let at = |x: &Vector<2>| {
            let [below, above] = [fade(0.31 + 0.2 * x[0] - x[1]), fade(x[1] - 0.63 - 0.1 * x[0])];
            [below, (1.0 - below) * (1.0 - above), (1.0 - below) * above]
        };
        let fractions: Vec<[f64; 3]> = mesh.nodes().iter().map(at).collect();
        (0..3).map(|k| fractions.iter().map(|at_node| at_node[k]).collect()).collect()
    }

    fn volumes(mesh: &Mesh<2, 3>, fraction: &[Vec<f64>]) -> Vec<f64> {
        Phases { list: &PhaseList::fluids(&DENSITY), fraction, level: &[] }.volumes(&FluidRegion::whole(mesh))
    }

    #[test]
    fn weights_give_each_fluid_its_volume() {
        let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector([1.0, 1.0]), [20, 20]).unwrap();
        let mut fraction = layers(&mesh);
        let start = volumes(&mesh, &fraction);
        let wanted = [start[0] * 1.03, start[1] * 0.95, 1.0 - start[0] * 1.03 - start[1] * 0.95];
        let factor = keep_volumes(&FluidRegion::whole(&mesh), &PhaseList::fluids(&DENSITY), &mut fraction, &wanted);
        for (own, wanted) in volumes(&mesh, &fraction).iter().zip(wanted) {
            assert!((own - wanted).abs() < 1e-13, "{own} {wanted}");
        }
        assert!(factor > 1.05 && factor < 3.0, "{factor}");
        let sums = (0..mesh.nodes().len()).map(|node| fraction.iter().map(|own| own[node]).sum::<f64>());
        assert!(sums.map(|sum| (sum - 1.0).abs()).fold(0.0, f64::max) < 1e-14);
    }

    #[test]
    fn fractions_with_the_wanted_volumes_stay_as_they_are() {
        let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector([1.0, 1.0]), [20, 20]).unwrap();
        let mut fraction = layers(&mesh);
        let before = fraction.clone();
        let wanted = volumes(&mesh, &fraction);
        let region = FluidRegion::whole(&mesh);
        assert_eq!(keep_volumes(&region, &PhaseList::fluids(&DENSITY), &mut fraction, &wanted), 1.0);
        let change = fraction.iter().flatten().zip(before.iter().flatten()).map(|(a, b)| (a - b).abs());
        assert!(change.fold(0.0, f64::max) < 1e-15);
    }

    /// A fluid of which no node is left takes no weight, and the others keep theirs.
    #[test]
    fn a_fluid_without_a_node_does_not_keep_the_others_from_their_volumes() {
        let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector([1.0, 1.0]), [20, 20]).unwrap();
        let mut fraction = layers(&mesh);
        let speck: Vec<f64> = mesh.nodes().iter().map(|x| if x[1] > 0.9 { 0.3 } else { 0.0 }).collect();
        fraction[2].iter_mut().zip(&speck).for_each(|(air, speck)| *air -= speck);
        fraction.push(speck);
        let density = [3.0, 2.0, 1.0, 2.5];
        let region = FluidRegion::whole(&mesh);
        let of = |fraction: &[Vec<f64>]| {
            Phases { list: &PhaseList::fluids(&density), fraction, level: &[] }.volumes(&region)
        };
        let start = of(&fraction);
        let wanted = [start[0] - 0.01, 0.97 * start[1], start[2] + 0.03 * start[1], 0.01];
        keep_volumes(&region, &PhaseList::fluids(&density), &mut fraction, &wanted);
        let missing: Vec<f64> = wanted.iter().zip(of(&fraction)).map(|(wanted, now)| wanted - now).collect();
        for (missing, expected) in missing.iter().zip([-0.01, 0.0, 0.0, 0.01]) {
            assert!((missing - expected).abs() < 1e-13, "{missing} {expected}");
        }
    }
}
