//! Unknowns of another kind at the border of a system on a mesh, such as the nodes of solids in a fluid (theory J.4).
//!
//! ```text
//! [ A    E ] [x]   [b]        A: the mesh, with its own preconditioner Â
//! [ F    S ] [y] = [c]        S: the border
//!
//! x ← Â⁻¹ b
//! [ A_tt  E_t ] [δ]   [ b_t − A_t x ]        t: velocities of nodes near the border, solved exactly with it
//! [ F_t   S   ] [y] = [ c − F x     ]        x_t ← x_t + δ
//! ```
//!
//! With the compliance of the border to pressure, D̂ in place of S (multigrid can take that): Â of A − E_p D̂⁻¹ F_p,
//! and x ← Â⁻¹ (b − E_p D̂⁻¹ c).
//!
//! Preconditioning leaves the matrix S_t⁻¹ (S − F A⁻¹ E) of the border, S_t = S − F_t A_tt⁻¹ E_t. For a solid in a
//! fluid it has one eigenvalue per motion, 1 + (added mass)/(inertia and stiffness of the solid). It is near one where
//! a motion is stiff; soft motions are left to the coarse correction (`coarse`).

use super::sparse::MatrixEntry;

/// Compliance of a border to the pressure of the mesh: Z = E_p D̂⁻¹ F_p with a diagonal D̂ in place of S
/// (theory (J.10c)).
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PressureCompliance {
    /// 1/D̂ of each unknown of the border; zero of those that are left out. Empty: of all.
    pub inverse_diagonal: Vec<f64>,
    /// Entries of Z between nodes of the mesh, by rows; values of one place add up.
    pub entries: Vec<MatrixEntry>,
}

/// What a border tells of itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BorderForm {
    /// Products alone.
    Products,
    /// Its entries, too, [`Border::entries`].
    Entries,
}

/// Values of all unknowns of a system with a border.
#[derive(Debug, Clone, Copy)]
pub struct BorderedVector<'a, const B: usize> {
    /// Values at the nodes of the mesh, x.
    pub mesh: &'a [[f64; B]],
    /// Values of the unknowns of the border, y.
    pub border: &'a [f64],
}

/// Values of the velocities of near nodes and of the unknowns of a border: the residuals of their rows, or the solution
/// for these.
#[derive(Debug, Clone)]
pub struct NearAndBorder<const B: usize> {
    /// Values at the near nodes, in the order of [`Border::near`]; their pressures, the last of each, are left out.
    pub near: Vec<[f64; B]>,
    /// Values of the unknowns of the border.
    pub border: Vec<f64>,
}

/// Rows of all equations of a system with a border, to be changed.
#[derive(Debug)]
pub struct BorderedRows<'a, const B: usize> {
    /// Rows of the nodes of the mesh.
    pub mesh: &'a mut [[f64; B]],
    /// Rows of the unknowns of the border.
    pub border: &'a mut [f64],
}

/// The border of a system with B unknowns per node, the last of which is a pressure.
pub trait Border<const B: usize> {
    /// Scales s_i = |S_ii|^(−1/2).
    fn scaling(&self) -> Vec<f64>;

    /// Adds E y to the rows of the mesh, and sets those of the border to F x + S y.
    fn multiply(&self, x: BorderedVector<'_, B>, rows: BorderedRows<'_, B>);

    /// Subtracts F x from rows of the border.
    fn subtract(&self, x: &[[f64; B]], rows: &mut [f64]);

    /// Adds E_p y to the rows of continuity.
    fn add_to_continuity(&self, y: &[f64], rows: &mut [[f64; B]]);

    /// Compliance of the border to pressure, for preconditioners that can take it.
    fn compliance(&self) -> PressureCompliance {
        PressureCompliance::default()
    }

    /// Entries of E, F and S, but for those that are many and small, in the matrix of the whole system, whose unknowns of
    /// the border come after `first` of the mesh; `None` if there is no whole matrix.
    fn entries(&self, first: u32) -> Option<Vec<MatrixEntry>> {
        let _ = first;
        None
    }

    /// Nodes of the mesh near the border, whose velocities are found together with it.
    fn near(&self) -> &[u32];

    /// Solves for the velocities δ of the near nodes and for y, for several right-hand sides at once: on entry the
    /// residuals of their rows, on return the solutions. Pressures of near nodes are left out: zero on return.
    fn solve(&self, sides: &mut [NearAndBorder<B>]);
}
