//! Elements that an interface cuts: sub-simplices, the enriched pressure, its condensation and recovery (theory G.7,
//! G.8).
//!
//! The interface is where the linear interpolant of the nodal level set φ vanishes. Each side is made of simplices
//! whose corners are nodes or edge points, kept in barycentric coordinates:
//!
//! ```text
//! P_ij = (φ_j x_i − φ_i x_j)/(φ_j − φ_i)
//! kink   F   = ½ (Σ|φ_i| N_i − |Σφ_i N_i|),   ∇F on side s = Σ_{i not on s} |φ_i| g_i    continuous, kinked
//! jump   F_k = N_k on the side where node k is not, 0 on that of k                       a jump and a kink
//!
//! ⎡K_ss  K_se⎤ ⎧x⎫   ⎧f_s⎫      K_se = (−Σ_s V_s F(c_s) g_j; −τ Σ_s V_s/ρ_s g_j·∇F_s)
//! ⎣K_es  K_ee⎦ ⎩q⎭ = ⎩f_e⎭      K_ee = −τ Σ_s V_s/ρ_s ∇F_s·∇F_s,   f_e = −τ Σ_s V_s ∇F_s·s_±
//!
//!                            s: a side;  s_±: the source there, of the negative or the positive side
//!
//! K̂ = K_ss − K_se K_ee⁻¹ K_es,  f̂ = f_s − K_se K_ee⁻¹ f_e,  q = K_ee⁻¹ (f_e − K_es x)   Becker (29)–(33), theory (G.17)
//! ```
//!
//! All functions vanish at the nodes, so the nodal unknowns keep their meaning, and each side has a pressure
//! gradient: two fluids at rest stay at rest wherever the interface cuts.
//!
//! ```text
//! sub_simplices     the sides of a cut element as simplices                          theory G.7
//! enriched          the enriched pressure: rows, condensation, recovery              Becker (29)–(33), theory G.8
//! surface_tension   forces of surface tension on the nodes                           theory G.10
//! ```

mod enriched;
mod sub_simplices;
pub mod surface_tension;

pub use enriched::{Enriched, ResidualTerms};
pub(in crate::pfem2) use sub_simplices::negative_fraction;
pub use sub_simplices::{
    SubSimplex, at_corners, corners, facets, inner, is_cut, negative_side, sides, split, volume_fraction, whole,
};

use crate::math::Vector;
use crate::pfem2::element::Content;

/// The functions that enrich the pressure of a cut element.
///
/// Both keep fluids at rest. In motion one kink ties the two gradients together: a standing wave of water under air
/// gains energy with it and loses a little with one function per node, which also carries the jump of surface tension.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Enrichment {
    /// None: for comparison.
    None,
    /// One kink (theory (G.13)): the paper.
    Kink,
    /// A jump and a kink, one function per node (theory (G.12)).
    #[default]
    Jump,
}

/// Density and viscosity of a fluid, as an element sees them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Medium {
    /// Density [kg/m³].
    pub density: f64,
    /// Viscosity [Pa s].
    pub viscosity: f64,
}

/// Sums of a cut element.
#[derive(Debug, Clone)]
pub struct CutGeometry<const N: usize> {
    /// Level set at the nodes, divided by the largest.
    level: [f64; N],
    /// Sub-simplices.
    pub parts: Vec<SubSimplex<N>>,
    /// Media of the negative and the positive side.
    pub media: [Medium; 2],
}

impl<const N: usize> CutGeometry<N> {
    /// An element cut by a level set; `media` of the negative and the positive side.
    pub fn new(level: [f64; N], media: [Medium; 2]) -> Self {
        let largest = level.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
        let level = level.map(|value| value / largest);
        Self { parts: split(&level), level, media }
    }

    /// Medium of a part.
    pub fn medium(&self, part: &SubSimplex<N>) -> Medium {
        self.media[usize::from(!part.negative)]
    }

    /// The nodes on the negative and on the positive side.
    pub fn sides(&self) -> [[bool; N]; 2] {
        [true, false].map(|negative| self.level.map(|level| (level < 0.0) == negative))
    }

    /// Fraction of the element on the negative side.
    pub fn negative_fraction(&self) -> f64 {
        self.parts.iter().filter(|part| part.negative).map(|part| part.volume_fraction).sum()
    }

    /// Mass, viscosity and ∫dV/ρ over the parts, with τ from their means.
    pub fn content(&self, volume: f64, tau: impl Fn(Medium) -> f64) -> Content<N> {
        let mut content = Content { mass: [0.0; N], viscosity: 0.0, tau: 0.0, volume_over_density: 0.0 };
        for part in &self.parts {
            let Medium { density, viscosity } = self.medium(part);
            for i in 0..N {
                content.mass[i] += volume * part.volume_fraction * density * part.center[i];
            }
            content.viscosity += part.volume_fraction * viscosity;
            content.volume_over_density += volume * part.volume_fraction / density;
        }
        let density = content.mass.iter().sum::<f64>() / volume;
        content.tau = tau(Medium { density, viscosity: content.viscosity });
        content
    }

    /// Consistent mass matrix ∫ρ N_i N_j [kg] of an element of this volume [m³].
    pub fn mass(&self, volume: f64) -> [[f64; N]; N] {
        let mut mass = [[0.0; N]; N];
        for part in &self.parts {
            let own = volume * part.volume_fraction * self.medium(part).density;
            for (row, products) in mass.iter_mut().zip(&part.products) {
                row.iter_mut().zip(products).for_each(|(m, product)| *m += own * product);
            }
        }
        mass
    }

    /// Functions of an enrichment.
    pub fn functions(&self, enrichment: Enrichment) -> usize {
        match enrichment {
            Enrichment::None => 0,
            Enrichment::Kink => 1,
            Enrichment::Jump => N,
        }
    }

    /// Value at the centre of a part and gradient of function `k` there.
    pub(super) fn function<const D: usize>(
        &self,
        enrichment: Enrichment,
        k: usize,
        part: &SubSimplex<N>,
        gradient: &[Vector<D>; N],
    ) -> (f64, Vector<D>) {
        let weights = self.weights(enrichment, k, part.negative);
        let value = weights.iter().zip(&part.center).map(|(w, n)| w * n).sum();
        (value, weights.iter().zip(gradient).map(|(&w, &g)| g * w).sum())
    }

    /// Function `k` on a side as a combination of the shape functions: those of the nodes of the other side.
    fn weights(&self, enrichment: Enrichment, k: usize, negative: bool) -> [f64; N] {
        std::array::from_fn(|i| match enrichment {
            _ if (self.level[i] < 0.0) == negative => 0.0,
            Enrichment::Kink => self.level[i].abs(),
            Enrichment::Jump if i == k => 1.0,
            Enrichment::Jump | Enrichment::None => 0.0,
        })
    }

    /// Means of F N_j over the facet opposite to a node, for function `k`.
    pub fn means_on_facet<const D: usize>(&self, enrichment: Enrichment, k: usize, opposite: usize) -> [f64; N] {
        let node: [usize; D] = std::array::from_fn(|a| a + usize::from(a >= opposite));
        let mut means = [0.0; N];
        for part in sub_simplices::sides(&node.map(|i| self.level[i])) {
            let weights = self.weights(enrichment, k, part.negative);
            for (a, products) in part.products.iter().enumerate() {
                (0..D).for_each(|b| means[node[b]] += part.volume_fraction * weights[node[a]] * products[b]);
            }
        }
        means
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Simplex;
    use crate::pfem2::cut_element::sub_simplices::tests::fraction;
    use crate::pfem2::cut_element::{Enriched, ResidualTerms};

    const MEDIA: [Medium; 2] = [Medium { density: 1000.0, viscosity: 1e-3 }, Medium { density: 1.0, viscosity: 1e-5 }];

    fn triangle() -> Simplex<2, 3> {
        Simplex::new([Vector([0.1, 0.0]), Vector([1.0, 0.2]), Vector([0.3, 0.9])]).unwrap()
    }

    /// Pressure −ρ g (distance) on both sides of a tilted plane lies in the enriched space, and its residual against
    /// gravity vanishes: the recovered unknown gives the one-sided gradients ρ g.
    #[test]
    fn recovery_returns_the_one_sided_gradients_of_two_fluids_at_rest() {
        let nodes = [Vector([0.1, 0.0]), Vector([1.0, 0.2]), Vector([0.3, 0.9])];
        let (normal, gravity) = (Vector([0.6, 0.8]), Vector([0.6, 0.8]) * -9.81);
        let level = nodes.map(|x| x.dot(normal) - 0.47);
        let cut = CutGeometry::new(level, MEDIA);
        let simplex = triangle();
        let pressure = |phi: f64| -phi * 9.81 * if phi < 0.0 { 1000.0 } else { 1.0 };
        let nodal = level.map(|phi| [0.0, 0.0, pressure(phi)]);
        for enrichment in [Enrichment::Kink, Enrichment::Jump] {
            let residual = ResidualTerms { source: [gravity; 2], convected: &[Vector::ZERO; 3], inertia: 0.0 };
            let enriched = Enriched::new(&cut, enrichment, &simplex, 0.01, residual);
            let q = enriched.recover(&nodal);
            for part in &cut.parts {
                let smooth = (0..3).map(|k| simplex.gradient[k] * nodal[k][2]).sum::<Vector<2>>();
                let own = |k: usize| cut.function(enrichment, k, part, &simplex.gradient).1 * q[k];
                let slope = smooth + (0..q.len()).map(own).sum::<Vector<2>>();
                let rest = slope - gravity * cut.medium(part).density;
                assert!(rest.norm() < 1e-9, "{enrichment:?}: {rest:?}");
            }
        }
    }

    #[test]
    fn content_of_a_cut_element_is_that_of_its_parts() {
        let cut = CutGeometry::new([-0.3, 0.9, 0.4], MEDIA);
        let content = cut.content(2.0, |_| 0.5);
        let heavy = fraction(&[-0.3, 0.9, 0.4]);
        assert!((cut.negative_fraction() - heavy).abs() < 1e-14);
        let mass = 2.0 * (heavy * 1000.0 + (1.0 - heavy));
        assert!((content.mass.iter().sum::<f64>() - mass).abs() < 1e-10);
        assert!((content.volume_over_density - 2.0 * (heavy / 1000.0 + (1.0 - heavy))).abs() < 1e-14);
    }
}
