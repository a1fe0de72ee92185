//! The pressure at nodes inside of thin solids, on one side (theory J.2b).
//!
//! ```text
//! p_k = 1/|O| Σ_{j ∈ O} (p_j + ρ b·(x_k − x_j)),   N_j ← N_j + 1/|O| Σ_k N_k                   theory (J.6f)
//!
//! k: nodes inside with fluid on several sides;   O: nodes outside of the element
//! ```
//!
//! With one pressure at such a node that of the two sides would be the same there, and a thin shell full of water would
//! hardly hold it.

use super::element::{CoupledElement, OneSidedPressure};
use super::fluid_part::FluidPart;
use crate::math::Vector;
use crate::pfem2::solid::cut::CutBySolid;

impl<const D: usize, const N: usize> CoupledElement<D, N> {
    /// Takes the pressures of nodes inside with fluid on two sides from those of the nodes outside of the element, whose
    /// places are `corners` [m].
    pub(super) fn take_sides(&mut self, cut: &CutBySolid<N>, fluid: &FluidPart<D, N>, corners: &[Vector<D>; N]) {
        if cut.nodes_of_two_sides().next().is_none() {
            return;
        }
        let outside: Vec<usize> = (0..N).filter(|&k| cut.outside[k]).collect();
        if outside.is_empty() {
            return;
        }
        let force = fluid.drive.force.iter().copied().sum::<Vector<D>>() / N as f64;
        let middle = outside.iter().map(|&j| corners[j]).sum::<Vector<D>>() / outside.len() as f64;
        let density = fluid.media[usize::from(fluid.level[outside[0]] >= 0.0)].density;
        for node in cut.nodes_of_two_sides() {
            let above = density * force.dot(corners[node] - middle);
            self.take_pressure(node, &outside, above);
            self.tied[node] = false;
            self.one_sided.push(OneSidedPressure { node, above });
        }
        self.outside = outside;
    }

    /// Replaces the pressure of a local node by the mean of others, plus a constant [Pa], in all rows, and adds its row to
    /// theirs.
    fn take_pressure(&mut self, node: usize, from: &[usize], above: f64) {
        let weight = 1.0 / from.len() as f64;
        for i in 0..N {
            for r in 0..N {
                let value = std::mem::take(&mut self.blocks[i][node][r][D]);
                from.iter().for_each(|&j| self.blocks[i][j][r][D] += weight * value);
                self.loads[i][r] -= value * above;
            }
        }
        for (rows, load) in self.to_solid.iter_mut().zip(&mut self.solid_loads) {
            for r in 0..D {
                let value = std::mem::take(&mut rows[node][r][D]);
                from.iter().for_each(|&j| rows[j][r][D] += weight * value);
                load[r] -= value * above;
            }
        }
        for i in 0..N {
            let row = std::mem::replace(&mut self.blocks[node][i][D], [0.0; N]);
            from.iter().for_each(|&j| (0..N).for_each(|s| self.blocks[j][i][D][s] += weight * row[s]));
        }
        for columns in &mut self.to_fluid {
            let row = std::mem::replace(&mut columns[node][D], [0.0; D]);
            from.iter().for_each(|&j| (0..D).for_each(|s| columns[j][D][s] += weight * row[s]));
        }
        let load = std::mem::take(&mut self.loads[node][D]);
        from.iter().for_each(|&j| self.loads[j][D] += weight * load);
        for wall in &mut self.on_walls {
            let area = std::mem::take(&mut wall.area[node]);
            from.iter().for_each(|&j| wall.area[j] += area * weight);
        }
    }

    /// Local nodes with a pressure of the side of the element.
    pub(super) fn one_sided(&self) -> impl Iterator<Item = usize> + '_ {
        self.one_sided.iter().map(|own| own.node)
    }

    /// The pressures of its nodes in its fluid part, given those of the nodes of the mesh [Pa].
    pub fn pressures(&self, mut nodal: [f64; N]) -> [f64; N] {
        let mean = self.outside.iter().map(|&j| nodal[j]).sum::<f64>() / self.outside.len().max(1) as f64;
        self.one_sided.iter().for_each(|own| nodal[own.node] = mean + own.above);
        nodal
    }
}
