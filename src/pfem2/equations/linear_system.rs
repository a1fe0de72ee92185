//! The linear system of a step: matrix, right-hand side and solution, with the solids at its border (theory F.15, J.4).

use super::assemble::Assembly;
use super::convergence::not_converged;
use crate::error::{Place, StepError};
use crate::linalg::{BlockMatrix, BorderForm, LinearSolver, NotConverged, SolveOutcome, SolverOptions, SolverState};
use crate::mesh::Mesh;
use crate::pfem2::boundary::Constraints;
use crate::pfem2::solid::coupling::border::SolidBorder;
use crate::pfem2::solid::coupling::dilatation::GasDilatation;
use crate::pfem2::solid::coupling::immersed::Immersed;

/// Matrix and right-hand side of velocity and pressure, their solver, and the solution.
pub(in crate::pfem2) struct LinearSystem<const N: usize> {
    pub(super) assembly: Assembly<N>,
    pub(super) matrix: BlockMatrix<N>,
    pub(super) rhs: Vec<[f64; N]>,
    /// Unknowns of the nodes, velocity and pressure.
    pub unknowns: Vec<[f64; N]>,
    /// Outcome of the last solution.
    pub outcome: SolveOutcome,
    /// Power of the pressure on the dilatation of a closed box with solids in the last solution [W].
    pub dilatation_power: f64,
    /// Preconditioners made so far.
    pub preconditioners: u64,
    /// The solver, with the preconditioner that it keeps.
    solver: LinearSolver<N>,
    /// Options of the solver.
    options: SolverOptions,
}

impl<const N: usize> LinearSystem<N> {
    /// A system of zeros on a mesh.
    pub(super) fn new<const D: usize>(mesh: &Mesh<D, N>, options: SolverOptions) -> Self {
        let (assembly, nodes) = (Assembly::new(mesh), mesh.nodes().len());
        Self {
            matrix: BlockMatrix::zeros(assembly.pattern()),
            rhs: vec![[0.0; N]; nodes],
            unknowns: vec![[0.0; N]; nodes],
            outcome: SolveOutcome { iterations: 0, residual: 0.0, rebuilt: false },
            dilatation_power: 0.0,
            preconditioners: 0,
            solver: solver(mesh, &assembly, options),
            assembly,
            options,
        }
    }

    /// Solves for the unknowns, which hold a first guess, and for the velocity of the solids at the border.
    ///
    /// # Errors
    /// The matrix of the solids is singular, or the linear solver doesn't converge.
    pub(super) fn solve<const D: usize>(
        &mut self,
        mesh: &Mesh<D, N>,
        immersed: Option<&mut Immersed<D, N>>,
        constraints: &Constraints<D, N>,
        dilatation: Option<GasDilatation>,
    ) -> Result<(), StepError> {
        let outcome = match immersed {
            Some(immersed) => self.solve_bordered(mesh, immersed, constraints, dilatation)?,
            None => self.solver.solve(&self.matrix, &self.rhs, &mut self.unknowns),
        };
        self.outcome = outcome.map_err(|failure| not_converged(mesh, &failure, &self.options))?;
        self.preconditioners += u64::from(self.outcome.rebuilt);
        Ok(())
    }

    /// Solves the system with the solids at its border.
    ///
    /// # Errors
    /// The matrix of the solids is singular; inside, the linear solver doesn't converge.
    fn solve_bordered<const D: usize>(
        &mut self,
        mesh: &Mesh<D, N>,
        immersed: &mut Immersed<D, N>,
        constraints: &Constraints<D, N>,
        dilatation: Option<GasDilatation>,
    ) -> Result<Result<SolveOutcome, NotConverged>, StepError> {
        let border = SolidBorder::new(mesh, immersed, constraints, &self.matrix, &mut self.rhs, dilatation);
        let mut border = border.ok_or_else(|| {
            let advice = "check that each solid has a mass and a stiffness, and look at its last deformation";
            StepError::new(Place::Everywhere, "the matrix of the solids is singular", "pivot", 0.0, advice)
        })?;
        let load = std::mem::take(&mut border.load);
        let mut solids = border.start(&immersed.independent);
        let x = [self.unknowns.as_flattened_mut(), &mut solids[..]];
        let outcome = self.solver.solve_bordered(&self.matrix, &border, [self.rhs.as_flattened(), &load], x);
        immersed.independent = border.independent(&solids);
        immersed.velocity = border.velocity(&immersed.independent);
        self.dilatation_power = border.power_of_dilatation(&immersed.velocity, &self.unknowns);
        Ok(outcome)
    }

    /// Prepares the solver for solids at the border.
    pub(super) fn expect_border(&mut self) {
        self.solver.expect_border(BorderForm::Entries);
    }

    /// The state of the linear solver, kept from one step to the next.
    pub fn solver_state(&self) -> SolverState {
        self.solver.state()
    }

    /// True if a state is that of a run of the same case.
    pub fn fits(&self, state: &SolverState) -> bool {
        self.solver.fits(state)
    }

    /// Goes on from the state of another run of the same case.
    pub(super) fn restore<const D: usize>(&mut self, mesh: &Mesh<D, N>, state: &SolverState, has_border: bool) {
        // A state that doesn't fit belongs to no run of this case: the solver then starts afresh.
        if self.solver.restore(state).is_err() {
            self.solver = solver(mesh, &self.assembly, self.options);
            if has_border {
                self.solver.expect_border(BorderForm::Entries);
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
