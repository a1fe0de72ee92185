//! Options of the linear solver that a run sets.

/// The preconditioner.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SolverKind {
    /// Chosen by dimension, size and border; the next method if the first fails.
    #[default]
    Auto,
    /// A factorisation; with row exchanges where that of the symmetric part fails.
    Direct,
    /// Multigrid.
    Iterative,
}

/// Options of the linear solver.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SolverOptions {
    /// The preconditioner.
    pub kind: SolverKind,
    /// |S (b − A x)| to reach, relative to |S b|; S scales the diagonal to ±1.
    pub tolerance: f64,
    /// Iterations before giving up.
    pub max_iterations: usize,
    /// Vectors kept before a restart.
    pub restart: usize,
}

impl Default for SolverOptions {
    fn default() -> Self {
        Self { kind: SolverKind::Auto, tolerance: 1e-8, max_iterations: 300, restart: 40 }
    }
}
