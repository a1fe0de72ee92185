//! Dilatation of a gas in a closed box, which balances the change of the volume of elastic solids (theory (J.10d)).
//!
//! ```text
//! D v + C p = σ w,     σ Σ w_i = −dV_S/dt = −Σ_a ∂V_S/∂u_a·v_a,     w_i = ∫ N_i over the elements full of the gas
//! ```
//!
//! The fluids of a box that nothing opens have a fixed volume, and so would all solids together. Here a gas beside
//! heavier fluids or elastic solids gives way, evenly, as it does under an even pressure: σ is the rate at which it
//! dilates. Without it all of dV_S/dt would come in through the elements around the node whose pressure is held, as it
//! does in liquids alone. σ w is linear in the velocities of solids, and stands with them.

use crate::mesh::Mesh;
use crate::pfem2::is_gas;

/// Dilatation of a gas: its elements, in which σ w acts.
#[derive(Debug, Clone)]
pub struct GasDilatation {
    /// Nodes, ascending, and w_i [m³].
    volumes: Vec<(u32, f64)>,
    /// Σ w_i [m³].
    total: f64,
    /// The node whose pressure is held, in place of its row of continuity.
    held: u32,
}

impl GasDilatation {
    /// The dilatation of the elements full of the lightest fluid; `fluids`: the fluid of each element that is full of one,
    /// with these densities [kg/m³]; `heaviest`: the largest density of fluids and elastic solids [kg/m³]; `held`: the node
    /// whose pressure is prescribed. `None`: there is no gas beside something heavier.
    pub fn of_gas<const D: usize, const N: usize>(
        mesh: &Mesh<D, N>,
        fluids: &[Option<usize>],
        density: &[f64],
        heaviest: f64,
        held: u32,
    ) -> Option<Self> {
        let full = || fluids.iter().enumerate().filter_map(|(e, fluid)| Some((e, (*fluid)?)));
        let (_, lightest) = full().min_by(|(_, a), (_, b)| density[*a].total_cmp(&density[*b]))?;
        if !is_gas(density[lightest], heaviest) {
            return None;
        }
        let mut nodal_volume = vec![0.0; mesh.nodes().len()];
        for (e, _) in full().filter(|&(_, fluid)| fluid == lightest) {
            let part = mesh.simplex(e).volume / N as f64;
            mesh.elements()[e].iter().for_each(|&node| nodal_volume[node as usize] += part);
        }
        let total = nodal_volume.iter().sum();
        let nodes = (0..nodal_volume.len()).filter(|&node| nodal_volume[node] > 0.0);
        let volumes = nodes.map(|node| (node as u32, nodal_volume[node])).collect();
        Some(Self { volumes, total, held })
    }
}

/// The balance of volumes in a closed box: the gas dilates at the rate at which elastic solids lose volume.
#[derive(Debug)]
pub(super) struct VolumeBalance {
    dilatation: GasDilatation,
    /// ∂V_S/∂u of all nodes of solids, axis by axis [m²].
    volume_slopes: Vec<f64>,
}

impl VolumeBalance {
    /// The dilatation for solids whose volume has these slopes [m²].
    pub fn new(dilatation: GasDilatation, volume_slopes: &[f64]) -> Self {
        Self { dilatation, volume_slopes: volume_slopes.to_vec() }
    }

    /// σ where all nodes of solids have these velocities, axis by axis [1/s].
    fn rate(&self, velocity: &[f64]) -> f64 {
        let grown: f64 = self.volume_slopes.iter().zip(velocity).map(|(slope, v)| slope * v).sum();
        -grown / self.dilatation.total
    }

    /// Adds σ w, times `factor`, to the rows of continuity, which hold −D v.
    pub fn add<const N: usize>(&self, velocity: &[f64], factor: f64, rows: &mut [[f64; N]]) {
        let rate = factor * self.rate(velocity);
        let rows_of_continuity = self.dilatation.volumes.iter().filter(|(node, _)| *node != self.dilatation.held);
        rows_of_continuity.for_each(|&(node, volume)| rows[node as usize][N - 1] += rate * volume);
    }

    /// Power of the pressure on the dilatation, σ Σ w_i p_i, from velocity and pressure of the nodes [W].
    pub fn power<const N: usize>(&self, velocity: &[f64], unknowns: &[[f64; N]]) -> f64 {
        let sum: f64 =
            self.dilatation.volumes.iter().map(|&(node, volume)| volume * unknowns[node as usize][N - 1]).sum();
        self.rate(velocity) * sum
    }
}
