//! The linear systems of an implicit step on a fixed mesh (theory F.15).
//!
//! ```text
//! [ A   G ] [v]   [f_v]      A: mass/Δt and viscosity, positive definite
//! [ Gᵀ −C ] [p] = [f_p]      C: stabilisation, positive semi-definite
//! ```
//! The pattern never changes: the order of elimination, the structure of the factor and all workspace are found once,
//! and a step brings only numbers. Flexible GMRES solves; what differs is its preconditioner:
//! * **direct**: L D Lᵀ of the matrix, of this step or an earlier one, for small problems and, without solids on
//!   meshes, in two dimensions; where its unsymmetric part rules, L U with row exchanges;
//! * **iterative**: block-triangular, with multigrid for the Schur complement C + Gᵀ diag(A)⁻¹ G, for the rest.
//!
//! Results don't depend on the number of threads or on measured times: factors are kept while the iterations that they
//! cost weigh less than a new one, by counts of operations.

mod border;
mod bordered;
mod coarse;
mod direct;
mod dissection;
mod krylov;
mod matrix;
mod modes;
mod multigrid;
mod options;
mod pattern;
mod pivoted;
mod preconditioner;
mod schur;
mod solver;
mod solver_state;
mod sparse;
mod symmetric_factor;
mod vectors;

pub use border::{Border, BorderForm, BorderedRows, BorderedVector, NearAndBorder, PressureCompliance};
pub use matrix::BlockMatrix;
pub use modes::{Mode, lowest_modes};
pub use options::{SolverKind, SolverOptions};
pub use pattern::Pattern;
pub use solver::{LinearSolver, NotConverged, SolveOutcome};
pub use solver_state::{CoarseCounters, CoarseState, KEPT, REPLACED, SolverCounters, SolverState};
pub use sparse::{MatrixEntry, SparseFactor, SparseMatrix};
pub use symmetric_factor::{PreconditioningFactor, factor_numbers};
