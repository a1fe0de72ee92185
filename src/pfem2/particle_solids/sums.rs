//! Sums over the particles of an element, and averages at the nodes (Becker (37), (38); theory (K.4), (K.5)).
//!
//! ```text
//! p̂_i = Σ N_i p_p / Σ N_i      over the particles of solids at nodes of a solid, of the fluid at others
//! â_i = Σ N_i a_p / Σ N_i      over the particles of solids
//! σ̄'  = Σ σ'_p / n_s,   V_s = V_e n_s/n_e,   ρ_i = Σ N_i ρ_p / Σ N_i   in an element with n_e particles, n_s of them of solids
//! ```

use super::averages::{ElementSums, NodalAverages};
use super::columns;
use super::solids::ParticleSolids;
use crate::math::{SymTensor, Vector};
use crate::mesh::Mesh;
use crate::parallel;
use crate::pfem2::particles::Particles;
use crate::pfem2::phases::Phases;

/// Nodes that see less than this of a particle, Σ N_i, keep their values.
const LEAST_WEIGHT: f64 = 1e-5;

impl<const D: usize, const N: usize> ParticleSolids<D, N> {
    /// Takes sums and averages of the particles; `pressure` [Pa] is that of nodes that see no particle of their phase.
    pub fn gather(&mut self, particles: &Particles<D>, mesh: &Mesh<D, N>, phases: &Phases, pressure: &[f64]) {
        self.sums = parallel::collect(mesh.elements().len(), 256, |e| self.sums_of(particles, mesh, e));
        let nodes = mesh.nodes().len();
        let solid: Vec<bool> = (0..nodes).map(|node| phases.at(node) >= self.first).collect();
        let average = |i: usize| {
            let side = usize::from(solid[i]);
            let (mut seen, mut p, mut solids, mut a) = (0.0, 0.0, 0.0, Vector::ZERO);
            for &e in mesh.elements_around(i) {
                let own = &self.sums[e as usize];
                let Some(k) = mesh.elements()[e as usize].iter().position(|&node| node as usize == i) else { continue };
                seen += own.shape[side][k];
                p += own.pressure[side][k];
                solids += own.shape[1][k];
                a += own.acceleration[k];
            }
            // Becker (38) of pressure and acceleration; theory (K.4).
            let pressure = if seen < LEAST_WEIGHT { pressure[i] } else { p / seen };
            (pressure, if solids < LEAST_WEIGHT { Vector::ZERO } else { a / solids })
        };
        let (pressure, acceleration) = parallel::collect(nodes, 256, average).into_iter().unzip();
        self.nodal = NodalAverages { pressure, acceleration, solid };
    }

    fn sums_of(&self, particles: &Particles<D>, mesh: &Mesh<D, N>, e: usize) -> ElementSums<D, N> {
        let (stress, pressure, acceleration) = columns::state(particles);
        let mut sums = ElementSums::NONE;
        for p in particles.of(e) {
            let shape = mesh.shape_functions(e, particles.position[p]);
            let law = self.law_of(particles.phase[p]);
            let (side, density) = (usize::from(law.is_some()), law.map_or(self.fluid_density, |law| law.density));
            sums.count[side] += 1.0;
            for k in 0..N {
                sums.shape[side][k] += shape[k];
                sums.pressure[side][k] += shape[k] * pressure[p];
                sums.density[k] += shape[k] * density;
            }
            if let Some(law) = law {
                (0..N).for_each(|k| sums.acceleration[k] += acceleration[p] * shape[k]);
                sums.stress += stress[p];
                sums.shear += law.shear;
                sums.compliance += 1.0 / law.bulk;
                sums.solid_density += law.density;
                sums.solid = sums.solid.or(Some(particles.phase[p]));
            }
        }
        sums
    }

    /// Mean stress σ̄' of the solid in an element [Pa]; where it holds no particle of one, that of the elements around
    /// its nodes of solids.
    pub(super) fn mean_stress(&self, mesh: &Mesh<D, N>, e: usize) -> SymTensor {
        let own = &self.sums[e];
        if own.count[1] > 0.0 {
            return own.stress * (1.0 / own.count[1]);
        }
        let nodes = mesh.elements()[e].iter().map(|&node| node as usize).filter(|&node| self.nodal.solid[node]);
        let mut around: Vec<u32> = nodes.flat_map(|node| mesh.elements_around(node)).copied().collect();
        around.sort_unstable();
        around.dedup();
        let all = around.iter().map(|&e| &self.sums[e as usize]);
        let (stress, count) =
            all.fold((SymTensor::ZERO, 0.0), |(stress, count), sums| (stress + sums.stress, count + sums.count[1]));
        if count > 0.0 { stress * (1.0 / count) } else { SymTensor::ZERO }
    }
}
