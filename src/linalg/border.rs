//! Unknowns of another kind at the border of a system on a mesh, such as the nodes of solids in a fluid.
//!
//! ```text
//! [ A    E ] [x]   [b]        A: the mesh, with its own preconditioner Â
//! [ F    S ] [y] = [c]        S: the border, solved exactly
//!
//! x ← Â⁻¹ b,   y ← S⁻¹ (c − F x)
//! ```
//!
//! Of the preconditioned matrix S⁻¹ (S − F A⁻¹ E) remains: for a solid in a fluid one and, for each of its motions, the added mass over
//! what resists the motion in the solid. Stiff motions are near one; each soft one costs an iteration.

/// The border of a system with B unknowns per node.
pub trait Border<const B: usize> {
    /// Scales s_i = |S_ii|^(−1/2).
    fn scaling(&self) -> Vec<f64>;

    /// Adds E y to the rows of the mesh, and sets those of the border to F x + S y; both arguments hold mesh and border.
    fn multiply(&self, x: (&[[f64; B]], &[f64]), rows: (&mut [[f64; B]], &mut [f64]));

    /// Subtracts F x from rows of the border.
    fn subtract(&self, x: &[[f64; B]], rows: &mut [f64]);

    /// y = S⁻¹ r.
    fn solve(&mut self, r: &[f64], y: &mut [f64]);
}
