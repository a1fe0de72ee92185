//! The solids as the border of the system of velocity and pressure (theory J.4, J.10).
//!
//! ```text
//! [ A     E T   ] [v, p]   [ b − E v̄      ]      A: the fluid, with the solids as rigid walls
//! [ TᵀF   TᵀS T ] [w   ] = [ Tᵀ(c − S v̄) ]      S = M_S/Δ + Δ K + what cut points give it,   v_S = T w + v̄
//! ```
//!
//! Prescribed unknowns of the fluid are eliminated: their columns go to the right-hand sides. In a closed box E has the
//! dilatation that balances the volume of the solids, too (`dilatation`).

use super::compliance::compliance;
use super::dilatation::{GasDilatation, VolumeBalance};
use super::element::CoupledElement;
use super::immersed::Immersed;
use super::near_nodes::NearNodes;
use super::node_coupling::NodeCoupling;
use crate::linalg::{
    BlockMatrix, Border, BorderedRows, BorderedVector, MatrixEntry, NearAndBorder, PressureCompliance, SparseMatrix,
};
use crate::mesh::Mesh;
use crate::parallel;
use crate::pfem2::boundary::Constraints;
use crate::pfem2::solid::equations::SolidEquations;
use crate::pfem2::solid::equations::independent::IndependentVelocities;
use std::collections::BTreeMap;

/// Nodes per piece of a parallel loop.
const PIECE: usize = 16;

/// The border that solids are: their independent velocities.
pub struct SolidBorder<const D: usize, const N: usize> {
    couplings: Vec<NodeCoupling<D, N>>,
    velocities: IndependentVelocities,
    /// After the independent velocities, where some are prescribed and not zero, rows s v = s v̄ of all that are
    /// prescribed, with s of the diagonal of S: the solution is measured by all that moves.
    matrix: SparseMatrix,
    near: NearNodes,
    compliance: PressureCompliance,
    /// Prescribed velocities of these rows [m/s].
    prescribed: Vec<f64>,
    /// The balance of volumes in a closed box with a gas.
    volume_balance: Option<VolumeBalance>,
    /// Right-hand side [N].
    pub load: Vec<f64>,
}

impl<const D: usize, const N: usize> SolidBorder<D, N> {
    /// The border, from the equations of solids and cut elements, and the matrix of the fluid; its right-hand side, in
    /// the frames of its nodes, takes what prescribed velocities of solids bring. `None` if the matrix of the solids is
    /// singular.
    pub fn new(
        mesh: &Mesh<D, N>,
        immersed: &Immersed<D, N>,
        constraints: &Constraints<D, N>,
        fluid: &BlockMatrix<N>,
        rhs_of_fluid: &mut [[f64; N]],
        dilatation: Option<GasDilatation>,
    ) -> Option<Self> {
        let equations = immersed.equations.as_ref()?;
        let mut load = loads(&immersed.elements, equations.rhs.len());
        let mut couplings = NodeCoupling::all(mesh, &immersed.elements);
        for coupling in &mut couplings {
            coupling.turn(constraints);
            coupling.eliminate_fluid(constraints, &mut load);
            coupling.move_prescribed(&equations.velocities, rhs_of_fluid);
        }
        let volume_balance = dilatation.map(|dilatation| VolumeBalance::new(dilatation, &equations.volume_slopes));
        let at_rest = vec![0.0; equations.velocities.count()];
        volume_balance
            .iter()
            .for_each(|balance| balance.add(&equations.velocities.nodal(&at_rest), -1.0, rhs_of_fluid));
        let entries = among_solids(&immersed.elements);
        let fixed = prescribed(equations, &entries);
        let (mut matrix, mut load) = equations.independent(&entries, &load);
        matrix.append_diagonal(fixed.iter().map(|&(size, _)| size));
        load.extend(fixed.iter().map(|(size, velocity)| size * velocity));
        let near = NearNodes::new(&matrix, &couplings, &equations.velocities, fluid)?;
        let diagonal: Vec<f64> = matrix.scaling().iter().map(|s| s.powi(-2)).collect();
        let compliance = compliance(&couplings, &equations.velocities, &diagonal, &fluid.pattern);
        let prescribed = fixed.into_iter().map(|(_, velocity)| velocity).collect();
        let velocities = equations.velocities.clone();
        Some(Self { couplings, velocities, matrix, near, compliance, prescribed, volume_balance, load })
    }

    /// Guess with which iterations begin, by the independent velocities.
    pub fn start(&self, independent: &[f64]) -> Vec<f64> {
        [independent, &self.prescribed].concat()
    }

    /// The independent velocities of a solution.
    pub fn independent(&self, solution: &[f64]) -> Vec<f64> {
        solution[..self.velocities.count()].to_vec()
    }

    /// Power of the pressure on the dilatation of a closed box, where the nodes of solids have the velocity `velocity`
    /// [m/s] and those of the mesh these unknowns [W].
    pub fn power_of_dilatation(&self, velocity: &[f64], unknowns: &[[f64; N]]) -> f64 {
        self.volume_balance.as_ref().map_or(0.0, |balance| balance.power(velocity, unknowns))
    }

    /// Velocity of all nodes of solids, by the independent ones [m/s].
    pub fn velocity(&self, independent: &[f64]) -> Vec<f64> {
        self.velocities.nodal(independent)
    }
}

/// Diagonal of S, with what the fluid adds, and velocity of prescribed unknowns, where some of them move: all, so that
/// a solid that turns has the same number in every step.
fn prescribed(equations: &SolidEquations, fluid: &[MatrixEntry]) -> Vec<(f64, f64)> {
    let velocities = &equations.velocities;
    let all = || (0..velocities.unknowns()).filter(|&k| velocities.is_prescribed(k));
    if all().all(|k| velocities.prescribed(k) == 0.0) {
        return Vec::new();
    }
    let mut diagonal = vec![0.0; velocities.unknowns()];
    let entries = equations.matrix.triplets().chain(fluid.iter().copied());
    entries.filter(|entry| entry.row == entry.column).for_each(|entry| diagonal[entry.row as usize] += entry.value);
    // Nodes inside a rigid solid have no entry, and count for nothing.
    let of = |k: usize| if diagonal[k] > 0.0 { (diagonal[k], velocities.prescribed(k)) } else { (1.0, 0.0) };
    all().map(of).collect()
}

/// Right-hand side that cut elements have in rows of solids, of `unknowns` of all nodes [N].
fn loads<const D: usize, const N: usize>(elements: &[CoupledElement<D, N>], unknowns: usize) -> Vec<f64> {
    let mut loads = vec![0.0; unknowns];
    for element in elements {
        for (&a, load) in element.solid.iter().zip(&element.solid_loads) {
            (0..D).for_each(|r| loads[a as usize * D + r] += load[r]);
        }
    }
    loads
}

/// Entries that cut elements have among the nodes of solids, summed over the elements.
fn among_solids<const D: usize, const N: usize>(elements: &[CoupledElement<D, N>]) -> Vec<MatrixEntry> {
    let mut around: BTreeMap<u32, Vec<(usize, usize)>> = BTreeMap::new();
    for (place, element) in elements.iter().enumerate() {
        element.solid.iter().enumerate().for_each(|(own, &a)| around.entry(a).or_default().push((place, own)));
    }
    let around: Vec<(u32, Vec<(usize, usize)>)> = around.into_iter().collect();
    let rows = parallel::collect(around.len(), PIECE, |n| {
        let (a, places) = &around[n];
        let mut columns: Vec<u32> =
            places.iter().flat_map(|&(place, _)| elements[place].solid.iter().copied()).collect();
        columns.sort_unstable();
        columns.dedup();
        let mut blocks = vec![[[0.0; D]; D]; columns.len()];
        for &(place, own) in places {
            let CoupledElement { solid, among_solid, .. } = &elements[place];
            for (b, block) in solid.iter().zip(&among_solid[own * solid.len()..]) {
                let Ok(column) = columns.binary_search(b) else { continue };
                let sums = blocks[column].as_flattened_mut();
                sums.iter_mut().zip(block.as_flattened()).for_each(|(sum, value)| *sum += value);
            }
        }
        let unknown = |a: u32, axis: usize| a * D as u32 + axis as u32;
        let entry = |k: usize, b: u32, block: &[[f64; D]; D]| {
            MatrixEntry::new(unknown(*a, k / D), unknown(b, k % D), block[k / D][k % D])
        };
        let all = columns.iter().zip(&blocks).flat_map(|(&b, block)| (0..D * D).map(move |k| entry(k, b, block)));
        all.collect::<Vec<_>>()
    });
    rows.concat()
}

impl<const D: usize, const N: usize> Border<N> for SolidBorder<D, N> {
    fn scaling(&self) -> Vec<f64> {
        let diagonal = |k: usize| self.matrix.entry(k, k).map_or(0.0, |entry| self.matrix.values[entry].abs());
        let scale = |k: usize| if diagonal(k) == 0.0 { 1.0 } else { diagonal(k).sqrt().recip() };
        (0..self.matrix.rows()).map(scale).collect()
    }

    fn multiply(&self, x: BorderedVector<'_, N>, rows: BorderedRows<'_, N>) {
        let (BorderedVector { mesh: x, border: w }, BorderedRows { mesh: rows, border: own }) = (x, rows);
        self.matrix.multiply(w, own);
        let velocity = self.velocities.added(w);
        self.volume_balance.iter().for_each(|balance| balance.add(&velocity, 1.0, rows));
        let mut forces = vec![0.0; velocity.len()];
        for coupling in &self.couplings {
            coupling.add_flux(&velocity, rows);
            coupling.add_forces(x, &mut forces);
        }
        own.iter_mut().zip(self.velocities.gathered(&forces)).for_each(|(own, force)| *own += force);
    }

    fn add_to_continuity(&self, w: &[f64], rows: &mut [[f64; N]]) {
        let velocity = self.velocities.added(w);
        for coupling in &self.couplings {
            rows[coupling.node as usize][N - 1] += coupling.volume_flux(&velocity);
        }
        self.volume_balance.iter().for_each(|balance| balance.add(&velocity, 1.0, rows));
    }

    fn compliance(&self) -> PressureCompliance {
        self.compliance.clone()
    }

    fn subtract(&self, x: &[[f64; N]], rows: &mut [f64]) {
        let mut forces = vec![0.0; self.velocities.unknowns()];
        self.couplings.iter().for_each(|coupling| coupling.add_forces(x, &mut forces));
        rows.iter_mut().zip(self.velocities.gathered(&forces)).for_each(|(row, force)| *row -= force);
    }

    /// Without the dilatation of a gas, which couples all of its nodes to all of the surface.
    fn entries(&self, first: u32) -> Option<Vec<MatrixEntry>> {
        let own = self.matrix.triplets();
        let own = own.map(|MatrixEntry { row, column, value }| MatrixEntry::new(first + row, first + column, value));
        let mut entries: Vec<MatrixEntry> = own.collect();
        for coupling in &self.couplings {
            coupling.add_entries(&self.velocities, first, &mut entries);
        }
        Some(entries)
    }

    fn near(&self) -> &[u32] {
        &self.near.nodes
    }

    fn solve(&self, sides: &mut [NearAndBorder<N>]) {
        self.near.solve(sides);
    }
}
