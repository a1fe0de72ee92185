//! Energy and momentum that the flow carries through open boundaries (theory F.13).
//!
//! ```text
//! energy     −∮ ½ρ |v|² v·n dA          momentum     −∮ ρ v v·n dA          into the mesh, per second
//! ```
//!
//! ρ is that of the element behind the facet where the flow leaves, and that of the fluid that is brought where it
//! comes in: what is behind an inlet into which another fluid begins to flow is of another density for the first steps.
//!
//! Velocities are linear on a facet of d nodes, so that means of their products are exact sums over nodes:
//! ∫N_a N_b N_c dA = A (d − 1)!/(d + 2)! α! with α! = 6 for three equal nodes, 2 for two, 1 for none.

use crate::math::Vector;
use crate::pfem2::equations::system::VelocityPressureSystem;

/// Powers and forces of what comes in, less what leaves.
#[derive(Debug, Clone, Copy, Default)]
pub struct OpenBoundaryFlux<const D: usize> {
    /// Kinetic energy per second [W].
    pub energy: f64,
    /// Momentum per second [N].
    pub momentum: Vector<D>,
}

impl<const D: usize> OpenBoundaryFlux<D> {
    /// The flux of a state; `brought` is the density of what comes in through a facet by its place in
    /// [`Mesh::boundary`](crate::mesh::Mesh) [kg/m³], where that is known.
    pub fn of<const N: usize>(system: &VelocityPressureSystem<D, N>, brought: impl Fn(usize) -> Option<f64>) -> Self {
        let VelocityPressureSystem { mesh, boundary, contents, velocity, .. } = system;
        let mut sum = Self::default();
        let facets = mesh.boundary().iter().enumerate().zip(&boundary.kinds);
        for ((place, facet), _) in facets.filter(|(_, kind)| kind.admits_flow()) {
            let element = facet.element as usize;
            let area = mesh.facet_area(*facet);
            let nodes = mesh.facet_nodes(*facet);
            let v: Vec<Vector<D>> = nodes.iter().map(|&node| velocity[node as usize]).collect();
            let comes_in = v.iter().map(|v| v.dot(area)).sum::<f64>() < 0.0;
            let behind = || contents.elements[element].mass.iter().sum::<f64>() / mesh.simplex(element).volume;
            let density = comes_in.then(|| brought(place)).flatten().unwrap_or_else(behind);
            let [pair, triple] = [D * (D + 1), D * (D + 1) * (D + 2)].map(|count| density / count as f64);
            for a in 0..D {
                for b in 0..D {
                    let flux = v[b].dot(area) * pair * if a == b { 2.0 } else { 1.0 };
                    sum.momentum -= v[a] * flux;
                    for c in 0..D {
                        let equal = [6.0, 2.0, 1.0][usize::from(a != b) + usize::from(c != a && c != b)];
                        sum.energy -= 0.5 * triple * equal * v[a].dot(v[b]) * v[c].dot(area);
                    }
                }
            }
        }
        sum
    }
}
