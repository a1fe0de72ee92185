//! Slip walls whose facets turn against the directions in which their nodes glide (theory (F.32)).
//!
//! ```text
//! σ n_f = −p n_f                                a slip facet has no shear
//! −∮ σ n_f·w dA = ∮ p n_f·w dA ≠ 0              w ⟂ n_i at the nodes, but not ⟂ n_f on the facets beside them
//! A_ij += ∮ N_i N_j n_f dA = S_f (1 + δ_ij)/(d (d + 1))        rows of velocity, columns of pressure; S_f: area vector
//! ```
//!
//! Behr 2004. The nodal normals n_i ∝ Σ_f ∫N_i n_f dA (Engelman, Sani & Gresho 1982) balance a constant pressure by
//! themselves; one that varies along the wall would push the fluid around it, and gravity would set a fluid at rest in
//! motion. With this term the rows of slip nodes hold ∫N_i ∇p: a linear pressure is in balance with gravity to the last
//! digits. It makes these rows unsymmetric, and it counts to the force on the wall, which takes up the pressure of its
//! facets.

use crate::mesh::{Mesh, Simplex};
use crate::pfem2::boundary::Boundary;
use crate::pfem2::cut_element::{CutGeometry, Enrichment};
use crate::pfem2::element::Block;

/// The slip facets of each element: bit k for the one opposite to local node k.
pub fn slip_facets<const D: usize, const N: usize>(mesh: &Mesh<D, N>, boundary: &Boundary<D>) -> Vec<u8> {
    boundary.facet_bits(mesh, |condition| condition.kind().is_frictionless())
}

/// Adds ∮N_i N_j n_f dA of an element's slip facets to the block of rows of node `i` and columns of node `j` [m²].
pub fn press<const D: usize, const N: usize>(
    block: &mut Block<N>,
    simplex: &Simplex<D, N>,
    slip: u8,
    (i, j): (usize, usize),
) {
    let weight = if i == j { 2.0 } else { 1.0 } / (D * (D + 1)) as f64;
    for k in (0..N).filter(|&k| k != i && k != j && slip >> k & 1 == 1) {
        let area = simplex.facet_area(k);
        (0..D).for_each(|r| block[r][D] += weight * area[r]);
    }
}

/// ∮F N_j n_f dA of the slip facets of a cut element [m²], for each function F of the enriched pressure: a column of
/// K_se (theory G.8).
pub fn press_enriched<const D: usize, const N: usize>(
    cut: &CutGeometry<N>,
    enrichment: Enrichment,
    simplex: &Simplex<D, N>,
    slip: u8,
) -> Vec<[[f64; N]; N]> {
    let column = |function: usize| {
        let mut column = [[0.0; N]; N];
        for k in (0..N).filter(|&k| slip >> k & 1 == 1) {
            let (area, means) = (simplex.facet_area(k), cut.means_on_facet::<D>(enrichment, function, k));
            for (row, mean) in column.iter_mut().zip(means) {
                (0..D).for_each(|r| row[r] += area[r] * mean);
            }
        }
        column
    };
    (0..cut.functions(enrichment)).map(column).collect()
}
