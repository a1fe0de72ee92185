//! Compliance of solids to pressure node by node, for the preconditioner of the fluid (theory (J.10c)).
//!
//! ```text
//! D_w = S_ww of nodes that move freely, infinite of others;      Z = E_p D⁻¹ F_p
//! ```
//!
//! Z is kept between nodes of the fluid that share an element; what it has between others is added to its diagonal, so
//! that even pressures see all of it.

use super::node_coupling::NodeCoupling;
use crate::linalg::{MatrixEntry, Pattern, PressureCompliance};
use crate::pfem2::solid::equations::independent::IndependentVelocities;
use std::collections::HashMap;

/// A coupling of a node of the fluid to a free velocity w: its number, E_pw / D_w and F_wp.
type FreeCoupling = (u32, f64, f64);

/// The compliance of solids whose independent velocities have this diagonal of S, by the blocks that couple them to the
/// fluid.
pub(super) fn compliance<const D: usize, const N: usize>(
    couplings: &[NodeCoupling<D, N>],
    velocities: &IndependentVelocities,
    diagonal: &[f64],
    pattern: &Pattern,
) -> PressureCompliance {
    let free: Vec<Vec<FreeCoupling>> =
        couplings.iter().map(|coupling| free_couplings(coupling, velocities, diagonal)).collect();
    let mut inverse_diagonal = vec![0.0; diagonal.len()];
    let mut sums = vec![0.0; diagonal.len()];
    for &(w, _, force) in free.iter().flatten() {
        inverse_diagonal[w as usize] = diagonal[w as usize].recip();
        sums[w as usize] += force;
    }
    let place: HashMap<u32, usize> = couplings.iter().enumerate().map(|(k, coupling)| (coupling.node, k)).collect();
    let mut entries = Vec::new();
    for (coupling, own) in couplings.iter().zip(&free) {
        let mut left: f64 = own.iter().map(|&(w, flux, _)| flux * sums[w as usize]).sum();
        for entry in pattern.row(coupling.node as usize) {
            let column = pattern.columns()[entry];
            let Some(&other) = place.get(&column) else { continue };
            let value = product(own, &free[other]);
            left -= value;
            entries.push(MatrixEntry::new(coupling.node, column, value));
        }
        entries.push(MatrixEntry::new(coupling.node, coupling.node, left.max(0.0)));
    }
    PressureCompliance { inverse_diagonal, entries }
}

/// Couplings of a node to velocities of nodes that move freely, ascending.
fn free_couplings<const D: usize, const N: usize>(
    coupling: &NodeCoupling<D, N>,
    velocities: &IndependentVelocities,
    diagonal: &[f64],
) -> Vec<FreeCoupling> {
    let mut all = Vec::new();
    for (column, &a) in coupling.solid.iter().enumerate() {
        for s in 0..D {
            let mut row = velocities.row(a as usize * D + s);
            let (Some((w, weight)), None) = (row.next(), row.next()) else { continue };
            let resistance = diagonal[w as usize];
            if resistance > 0.0 {
                let (flux, force) = (coupling.to_fluid[column][N - 1][s], coupling.to_solid[column][s][N - 1]);
                all.push((w, weight * flux / resistance, weight * force));
            }
        }
    }
    all.sort_unstable_by_key(|&(w, ..)| w);
    all
}

/// Σ_w E_iw D_w⁻¹ F_wj.
fn product(of_row: &[FreeCoupling], of_column: &[FreeCoupling]) -> f64 {
    let mut others = of_column.iter().peekable();
    let mut sum = 0.0;
    for &(w, flux, _) in of_row {
        while others.next_if(|other| other.0 < w).is_some() {}
        sum += others.peek().filter(|other| other.0 == w).map_or(0.0, |other| flux * other.2);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two nodes of the fluid at one free node of a solid, a third one too, in no element with the first.
    #[test]
    fn compliance_between_nodes_without_a_common_element_is_lumped_on_the_diagonal() {
        let pattern = Pattern::new(4, &[[0u32, 1, 3], [1, 2, 3]]);
        let coupling = |node: u32, flux: f64| NodeCoupling::<2, 3> {
            node,
            solid: vec![0],
            to_fluid: vec![[[0.0; 2], [0.0; 2], [0.0, flux]]],
            to_solid: vec![[[0.0; 3], [0.0, 0.0, flux]]],
        };
        let couplings = [coupling(0, 1.0), coupling(1, 2.0), coupling(2, 3.0)];
        let mut velocities = IndependentVelocities::default();
        let first = velocities.add(&[0.0, 0.0]);
        (0..2).for_each(|axis| velocities.push(&[(first + axis, 1.0)], 0.0));
        let found = compliance(&couplings, &velocities, &[5.0, 10.0], &pattern);
        assert_eq!(found.inverse_diagonal, [0.2, 0.1]);
        let sum = |i: u32, j: u32| -> f64 {
            found.entries.iter().filter(|e| (e.row, e.column) == (i, j)).map(|e| e.value).sum()
        };
        let rows = [[0.4, 0.2, 0.0], [0.2, 0.4, 0.6], [0.0, 0.6, 1.2]];
        for (i, row) in rows.iter().enumerate() {
            for (j, value) in row.iter().enumerate() {
                assert!((sum(i as u32, j as u32) - value).abs() < 1e-12, "{i} {j}: {}", sum(i as u32, j as u32));
            }
        }
    }
}
