//! The solids as the border of the system of velocity and pressure (theory J.4, J.10).
//!
//! ```text
//! [ A     E T   ] [v, p]   [ b − E v̄      ]      A: the fluid, with the solids as rigid walls
//! [ TᵀF   TᵀS T ] [w   ] = [ Tᵀ(c − S v̄) ]      S = M_S/Δ + Δ K + what cut points give it,   v_S = T w + v̄
//! ```
//!
//! Prescribed unknowns of the fluid are eliminated: their columns go to the right-hand sides.

use super::coupling::CoupledElement;
use super::equations::SolidEquations;
use super::immersed::Immersed;
use super::independent::IndependentVelocities;
use super::near::NearNodes;
use super::node_coupling::NodeCoupling;
use crate::linalg::{BlockMatrix, Border, SparseMatrix};
use crate::mesh::Mesh;
use crate::pfem2::boundary::Constraints;

/// The border that solids are: their independent velocities.
pub struct SolidBorder<const D: usize, const N: usize> {
    couplings: Vec<NodeCoupling<D, N>>,
    velocities: IndependentVelocities,
    /// After the independent velocities, rows s v = s v̄ of those that are prescribed and not zero, with s of the diagonal of S: the
    /// solution is measured by all that moves.
    matrix: SparseMatrix,
    near: NearNodes,
    /// Prescribed velocities of these rows [m/s].
    prescribed: Vec<f64>,
    /// Right-hand side [N].
    pub load: Vec<f64>,
}

impl<const D: usize, const N: usize> SolidBorder<D, N> {
    /// From the equations of solids and cut elements, and the matrix of the fluid; its right-hand side, in the frames of its nodes, takes
    /// what prescribed velocities of solids bring. `None` if the matrix of the solids is singular.
    pub fn new(
        mesh: &Mesh<D, N>,
        immersed: &Immersed<D, N>,
        constraints: &Constraints<D, N>,
        (fluid, rhs_of_fluid): (&BlockMatrix<N>, &mut [[f64; N]]),
    ) -> Option<Self> {
        let equations = immersed.equations.as_ref()?;
        let (mut entries, mut load) = (Vec::new(), vec![0.0; equations.rhs.len()]);
        let mut couplings = NodeCoupling::all(mesh, &immersed.elements);
        for coupling in &mut couplings {
            coupling.turn(constraints);
            coupling.eliminate_fluid(constraints, &mut load);
            coupling.move_prescribed(&equations.velocities, rhs_of_fluid);
        }
        immersed.elements.iter().for_each(|element| add_solid_rows(element, &mut entries, &mut load));
        let fixed = prescribed(equations, &entries);
        let (matrix, mut load) = equations.independent(entries, &load);
        let first = load.len() as u32;
        let rows = (first..).zip(&fixed).map(|(k, &(size, _))| (k, k, size));
        let matrix = SparseMatrix::from_triplets(load.len() + fixed.len(), matrix.triplets().chain(rows).collect());
        load.extend(fixed.iter().map(|(size, velocity)| size * velocity));
        let near = NearNodes::new(&matrix, &couplings, &equations.velocities, fluid)?;
        let prescribed = fixed.into_iter().map(|(_, velocity)| velocity).collect();
        Some(Self { couplings, velocities: equations.velocities.clone(), matrix, near, prescribed, load })
    }

    /// What iterations begin with, by the independent velocities.
    pub fn start(&self, independent: &[f64]) -> Vec<f64> {
        [independent, &self.prescribed].concat()
    }

    /// The independent velocities of a solution.
    pub fn independent(&self, solution: &[f64]) -> Vec<f64> {
        solution[..self.velocities.count()].to_vec()
    }

    /// Velocity of all nodes of solids, by the independent ones [m/s].
    pub fn velocity(&self, independent: &[f64]) -> Vec<f64> {
        self.velocities.nodal(independent)
    }
}

/// Diagonal of S, with what the fluid adds, and velocity of prescribed unknowns that move.
fn prescribed(equations: &SolidEquations, fluid: &[(u32, u32, f64)]) -> Vec<(f64, f64)> {
    let velocities = &equations.velocities;
    let moves = |k: &u32| velocities.is_prescribed(*k as usize) && velocities.prescribed(*k as usize) != 0.0;
    let mut diagonal = vec![0.0; velocities.unknowns()];
    let all = equations.matrix.triplets().chain(fluid.iter().copied());
    all.filter(|(row, column, _)| row == column).for_each(|(row, _, value)| diagonal[row as usize] += value);
    let of = |k: u32| (diagonal[k as usize], velocities.prescribed(k as usize));
    (0..velocities.unknowns() as u32).filter(moves).map(of).filter(|(size, _)| *size > 0.0).collect()
}

/// Adds what the fluid puts on the rows of solids in a cut element.
fn add_solid_rows<const D: usize, const N: usize>(
    element: &CoupledElement<D, N>,
    entries: &mut Vec<(u32, u32, f64)>,
    load: &mut [f64],
) {
    let unknown = |a: u32, r: usize| a * D as u32 + r as u32;
    for (place, &a) in element.solid.iter().enumerate() {
        (0..D).for_each(|r| load[unknown(a, r) as usize] += element.solid_loads[place][r]);
        for (other, &b) in element.solid.iter().enumerate() {
            let block = &element.among_solid[place * element.solid.len() + other];
            for r in 0..D {
                entries.extend((0..D).map(|s| (unknown(a, r), unknown(b, s), block[r][s])));
            }
        }
    }
}

impl<const D: usize, const N: usize> Border<N> for SolidBorder<D, N> {
    fn scaling(&self) -> Vec<f64> {
        let diagonal = |k: usize| self.matrix.entry(k, k).map_or(0.0, |entry| self.matrix.values[entry].abs());
        let scale = |k: usize| if diagonal(k) == 0.0 { 1.0 } else { diagonal(k).sqrt().recip() };
        (0..self.matrix.rows()).map(scale).collect()
    }

    fn multiply(&self, (x, w): (&[[f64; N]], &[f64]), (rows, own): (&mut [[f64; N]], &mut [f64])) {
        self.matrix.multiply(w, own);
        let velocity = self.velocities.added(w);
        let mut forces = vec![0.0; velocity.len()];
        for coupling in &self.couplings {
            coupling.add_flux(&velocity, rows);
            coupling.add_forces(x, &mut forces);
        }
        own.iter_mut().zip(self.velocities.gathered(&forces)).for_each(|(own, force)| *own += force);
    }

    fn subtract(&self, x: &[[f64; N]], rows: &mut [f64]) {
        let mut forces = vec![0.0; self.velocities.unknowns()];
        self.couplings.iter().for_each(|coupling| coupling.add_forces(x, &mut forces));
        rows.iter_mut().zip(self.velocities.gathered(&forces)).for_each(|(row, force)| *row -= force);
    }

    fn near(&self) -> &[u32] {
        &self.near.nodes
    }

    fn solve(&mut self, near: &mut [[f64; N]], own: &mut [f64]) {
        self.near.solve(near, own);
    }
}
