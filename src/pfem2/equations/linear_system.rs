//! The linear system of a step: matrix, right-hand side and solution, with the solids at its border (theory F.15, J.4).

use super::assemble::Assembly;
use super::system::{TimeStep, VelocityPressureSystem};
use crate::error::{Place, StepError};
use crate::linalg::{BlockMatrix, LinearSolver, NotConverged, SolveOutcome, SolverOptions, SolverState};
use crate::math::Vector;
use crate::mesh::Mesh;
use crate::pfem2::solid::coupling::border::SolidBorder;

/// Matrix and right-hand side of velocity and pressure, and their solver.
pub(in crate::pfem2) struct LinearSystem<const N: usize> {
    assembly: Assembly<N>,
    matrix: BlockMatrix<N>,
    rhs: Vec<[f64; N]>,
    /// The solver, with the preconditioner that it keeps.
    pub(super) solver: LinearSolver<N>,
    /// Options of the solver.
    pub(super) options: SolverOptions,
}

impl<const N: usize> LinearSystem<N> {
    /// A system of zeros on a mesh.
    pub(super) fn new<const D: usize>(mesh: &Mesh<D, N>, options: SolverOptions) -> Self {
        let assembly = Assembly::new(mesh);
        let (matrix, rhs) = (BlockMatrix::zeros(assembly.pattern()), vec![[0.0; N]; mesh.nodes().len()]);
        let solver = solver(mesh, &assembly, options);
        Self { assembly, matrix, rhs, solver, options }
    }
}

impl<const D: usize, const N: usize> VelocityPressureSystem<D, N> {
    /// Fills matrix and right-hand side.
    pub(super) fn assemble(&mut self, step: TimeStep, convected: &[Vector<D>]) {
        let mut rhs = std::mem::take(&mut self.linear.rhs);
        rhs.fill([0.0; N]);
        self.boundary.load(&self.mesh, step.end(), |node, force| (0..D).for_each(|r| rhs[node][r] += force[r]));
        let empty = BlockMatrix { pattern: self.linear.assembly.pattern(), values: Vec::new() };
        let mut matrix = std::mem::replace(&mut self.linear.matrix, empty);
        self.linear.assembly.assemble(&self.elements(convected), &self.constraints, &mut matrix, &mut rhs);
        (self.linear.matrix, self.linear.rhs) = (matrix, rhs);
    }

    /// Solves the linear system, with the solids at its border.
    ///
    /// # Errors
    /// The matrix of the solids is singular; inside, the linear solver doesn't converge.
    pub(super) fn solve_linear(&mut self) -> Result<Result<SolveOutcome, NotConverged>, StepError> {
        let linear = &mut self.linear;
        let Some(immersed) = &mut self.immersed else {
            return Ok(linear.solver.solve(&linear.matrix, &linear.rhs, &mut self.unknowns));
        };
        let mut border = SolidBorder::new(&self.mesh, immersed, &self.constraints, &linear.matrix, &mut linear.rhs)
            .ok_or_else(|| {
                let advice = "check that each solid has a mass and a stiffness, and look at its last deformation";
                StepError::new(Place::Everywhere, "the matrix of the solids is singular", "pivot", 0.0, advice)
            })?;
        let load = std::mem::take(&mut border.load);
        let mut solids = border.start(&immersed.independent);
        let x = [self.unknowns.as_flattened_mut(), &mut solids[..]];
        let outcome = linear.solver.solve_bordered(&linear.matrix, &mut border, [linear.rhs.as_flattened(), &load], x);
        immersed.independent = border.independent(&solids);
        immersed.velocity = border.velocity(&immersed.independent);
        Ok(outcome)
    }

    /// The state of the linear solver, kept from one step to the next.
    pub(in crate::pfem2) fn solver_state(&self) -> SolverState {
        self.linear.solver.state()
    }

    /// True if a state is that of a run of the same case.
    pub(in crate::pfem2) fn fits(&self, state: &SolverState) -> bool {
        self.linear.solver.fits(state)
    }

    /// Goes on from the state of another run of the same case.
    pub(in crate::pfem2) fn restore_solver(&mut self, state: &SolverState) {
        // A state that doesn't fit belongs to no run of this case: the solver then starts afresh.
        if self.linear.solver.restore(state).is_err() {
            self.linear.solver = solver(&self.mesh, &self.linear.assembly, self.linear.options);
            if self.immersed.is_some() {
                self.linear.solver.expect_border();
            }
        }
    }
}

fn solver<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    assembly: &Assembly<N>,
    options: SolverOptions,
) -> LinearSolver<N> {
    let places: Vec<[f64; 3]> = mesh.nodes().iter().map(|x| x.to3()).collect();
    LinearSolver::new(assembly.pattern(), &places, options)
}
