//! Outlets that a developed flow leaves undisturbed (theory (F.34), (F.35)).
//!
//! ```text
//! σ n = −p n + μ (∂v/∂n + (∇v)ᵀ n)        (∇v)ᵀ n = Σ_j g_j (v_j·n)
//! outlet:   −p n + μ ∂v/∂n = 0      that is      σ n = μ (∇v)ᵀ n
//! A_ij −= μ/d g_j ⊗ S_f             for the nodes i of an open facet with area vector S_f
//!
//! where fluid comes in:   σ n += ½ρ (v·n)₋ v        the pressure outside is the total one, p + ½ρ|v|²
//! A_ii −= ½ρ/d (v̂_i·S_f)₋                           (a)₋ = min(a, 0); one point per node
//! ```
//!
//! Freedom from traction, σ n = 0, would ask a flow between plates for ∂v_x/∂y = 0 at the outlet: it flares there.
//! This is the condition of the benchmarks that are computed with ∫μ ∇v:∇w (Heywood, Rannacher & Turek 1996); for
//! viscosities that vary only the term on the boundary does the same. It makes the rows of open facets unsymmetric.
//!
//! Fluid that comes in brings kinetic energy ½ρ|v|² per volume. Under a static pressure from outside no work supplies
//! it, and what leaves below and comes back above is faster each time; under a total pressure the fluid outside pays
//! with its pressure, as on the way out of a large vessel at rest (Bruneau & Fabrie 1994; Esmaily Moghadam et al.
//! 2011). Where nothing comes in, the term vanishes.

use crate::math::Vector;
use crate::mesh::{Mesh, Simplex};
use crate::pfem2::boundary::{Boundary, Condition};
use crate::pfem2::element::Block;

/// The facets of each element that are open in this way: bit k for the one opposite to local node k.
pub fn outlet_facets<const D: usize, const N: usize>(mesh: &Mesh<D, N>, boundary: &Boundary<D>) -> Vec<u8> {
    boundary.facet_bits(mesh, Condition::prescribes_pressure)
}

/// Subtracts μ/d g_j ⊗ S_f from the block of rows of node `i` and columns of node `j`.
pub fn release<const D: usize, const N: usize>(
    block: &mut Block<N>,
    simplex: &Simplex<D, N>,
    viscosity: f64,
    open: u8,
    (i, j): (usize, usize),
) {
    for k in (0..N).filter(|&k| k != i && open >> k & 1 == 1) {
        let area = simplex.facet_area(k) * (viscosity / D as f64);
        for r in 0..D {
            for s in 0..D {
                block[r][s] -= simplex.gradient[j][r] * area[s];
            }
        }
    }
}

/// −½ρ/d (v̂_i·S_f)₋ of an element's local node `i` over its open facets [kg/s]; `density` [kg/m³], `convected`: v̂_i
/// [m/s].
pub fn back<const D: usize, const N: usize>(
    simplex: &Simplex<D, N>,
    density: f64,
    open: u8,
    convected: Vector<D>,
    i: usize,
) -> f64 {
    let facets = (0..N).filter(|&k| k != i && open >> k & 1 == 1);
    facets.map(|k| -0.5 * density / D as f64 * convected.dot(simplex.facet_area(k)).min(0.0)).sum()
}
