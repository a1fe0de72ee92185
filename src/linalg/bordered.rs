//! A system with a border as the Krylov method sees it: products, residuals, preconditioning (theory F.15,
//! J.4).

use super::border::{Border, BorderedRows, BorderedVector, NearAndBorder};
use super::coarse::CoarseCorrection;
use super::direct::Analysis;
use super::krylov::System;
use super::matrix::BlockMatrix;
use super::preconditioner::Preconditioner;
use super::vectors::update;

/// A system: the matrix on the mesh, and what borders on it. Flat vectors hold the unknowns of the mesh first.
pub(super) struct BorderedMatrix<'a, const B: usize> {
    /// The matrix on the mesh.
    pub a: &'a BlockMatrix<B>,
    /// The right-hand side.
    pub b: &'a [f64],
    /// S.
    pub scaling: &'a [f64],
    /// Unknowns of another kind.
    pub border: Option<&'a dyn Border<B>>,
}

impl<const B: usize> BorderedMatrix<'_, B> {
    /// y = A x.
    fn multiply(&self, x: &[f64], y: &mut [f64]) {
        let own = self.a.pattern.rows() * B;
        let ((x, x_border), (y, y_border)) = (x.split_at(own), y.split_at_mut(own));
        let (x, y) = (x.as_chunks().0, y.as_chunks_mut().0);
        self.a.multiply(x, y);
        if let Some(border) = self.border {
            border.multiply(BorderedVector { mesh: x, border: x_border }, BorderedRows { mesh: y, border: y_border });
        }
    }
}

/// A system with its preconditioner: that of the mesh, then the block of the border (see `border`).
pub(super) struct Preconditioned<'a, 'b, const B: usize> {
    pub system: &'a BorderedMatrix<'b, B>,
    pub analysis: Option<&'a Analysis>,
    pub preconditioner: Option<&'a mut Preconditioner<B>>,
    pub coarse: Option<&'a CoarseCorrection<B>>,
    /// 1/D̂ of the compliance of the border to pressure that the preconditioner has; empty if it has none.
    pub inverse_diagonal: &'a [f64],
    pub workspace: Vec<f64>,
}

impl<const B: usize> System for Preconditioned<'_, '_, B> {
    fn multiply(&self, x: &[f64], y: &mut [f64]) {
        self.system.multiply(x, y);
        let s = self.system.scaling;
        update(y, |i, y| s[i] * y);
    }

    fn residual(&self, x: &[f64], r: &mut [f64]) {
        self.system.multiply(x, r);
        let &BorderedMatrix { scaling: s, b, .. } = self.system;
        update(r, |i, ax| s[i] * (b[i] - ax));
    }

    fn precondition(&mut self, r: &[f64], z: &mut [f64]) {
        let &BorderedMatrix { a, scaling: s, border, .. } = self.system;
        let workspace = &mut self.workspace[..];
        update(workspace, |i, _| r[i] / s[i]);
        if let Some(Preconditioner::Whole(factor)) = &mut self.preconditioner {
            factor.solve(workspace, z);
            return;
        }
        let own = a.pattern.rows() * B;
        let ((r, r_border), (z, z_border)) = (workspace.split_at_mut(own), z.split_at_mut(own));
        let (r, z) = (r.as_chunks_mut::<B>().0, z.as_chunks_mut().0);
        if let (Some(border), false) = (border, self.inverse_diagonal.is_empty()) {
            let motion: Vec<f64> = r_border.iter().zip(self.inverse_diagonal).map(|(r, y)| -r * y).collect();
            border.add_to_continuity(&motion, r);
        }
        match &mut self.preconditioner {
            Some(preconditioner) => preconditioner.apply(self.analysis, r, z),
            None => z.copy_from_slice(r),
        }
        let Some(border) = border else { return };
        border.subtract(z, r_border);
        let rest = |&node: &u32| {
            let (node, product) = (node as usize, a.row_product(node as usize, z));
            std::array::from_fn(|k| r[node][k] - product[k])
        };
        let near = border.near().iter().map(rest).collect();
        let mut motion = NearAndBorder { near, border: r_border.to_vec() };
        border.solve(std::slice::from_mut(&mut motion));
        if let Some(coarse) = self.coarse {
            coarse.correct(&mut motion);
        }
        z_border.copy_from_slice(&motion.border);
        for (&node, change) in border.near().iter().zip(&motion.near) {
            z[node as usize].iter_mut().zip(change).for_each(|(z, change)| *z += change);
        }
    }
}
