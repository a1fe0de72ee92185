//! Openings that the surface of a solid meets: tractions act on the fluid part of their facets alone.
//!
//! ```text
//! t_c = ∮_O N^s_c t̄ dA = Σ_b A (1 + δ_cb)/(d (d + 1)) t̄(x_b)        theory (J.9d)
//!
//! O: facets of the fluid part at an opening; c, b: their corners
//! ```
//!
//! Corners are nodes and cut points; what pushes at these pushes the solid, as the pressure of the fluid does there in
//! the other direction. With the tractions of whole facets fluid beside a solid would be pushed by what acts on the
//! other side of it, and wouldn't rest under an even pressure.

use super::element::{CoupledElement, Opening, Unknown, VelocityMap};
use super::fluid_part::{FluidPart, PartGeometry};
use super::walls::part_facets;
use crate::math::Vector;

impl<const D: usize> Opening<D> {
    /// Loads at the corners under the tractions there [Pa].
    fn loads(&self, tractions: &[Vector<D>; D]) -> [Vector<D>; D] {
        let share = self.area.norm() / (D * (D + 1)) as f64;
        let sum = tractions.iter().copied().sum::<Vector<D>>();
        tractions.map(|own| (sum + own) * share)
    }
}

impl<const D: usize, const N: usize> CoupledElement<D, N> {
    /// Adds the facets of a part at openings.
    pub(super) fn add_openings(
        &mut self,
        part: &PartGeometry<D, N>,
        fluid: &FluidPart<D, N>,
        corners: &[Vector<D>; N],
        (maps, positions): (&[VelocityMap<D>], &[Vector<D>]),
    ) {
        for facet in part_facets(part, fluid.openings) {
            let vertices = facet.corners.map(|c| part.vertices[c]);
            self.openings.push(Opening {
                facet: facet.facet,
                area: facet.area,
                positions: vertices.map(|vertex| if vertex < N { corners[vertex] } else { positions[vertex - N] }),
                velocities: vertices.map(|vertex| maps[vertex].clone()),
                loads: [Vector::ZERO; D],
            });
        }
    }

    /// Adds the loads of openings to the right-hand side; `traction` of a facet, by the local node opposite to it, at a
    /// place [Pa].
    pub fn load_openings(&mut self, traction: impl Fn(u32, Vector<D>) -> Vector<D>) {
        let mut openings = std::mem::take(&mut self.openings);
        for opening in &mut openings {
            opening.loads = opening.loads(&opening.positions.map(|x| traction(opening.facet, x)));
            for (vertex, load) in opening.velocities.iter().zip(opening.loads) {
                self.add_load(vertex, load);
            }
        }
        self.openings = openings;
    }

    /// Force of the tractions at openings on the fluid [N], and their power [W], where nodes of the element and of
    /// solids have these velocities [m/s].
    pub fn action_of_openings(
        &self,
        of_node: impl Fn(usize) -> Vector<D>,
        of_solid: impl Fn(u32) -> Vector<D>,
    ) -> (Vector<D>, f64) {
        let of = |unknown: Unknown| match unknown {
            Unknown::Node(i) => of_node(i),
            Unknown::Solid(a) => of_solid(self.solid[a]),
        };
        let corners = self.openings.iter().flat_map(|opening| opening.velocities.iter().zip(opening.loads));
        corners.fold((Vector::ZERO, 0.0), |(force, power), (vertex, load)| {
            let velocity: Vector<D> = vertex.iter().map(|&(unknown, p)| p.apply(of(unknown))).sum();
            (force + load, power + load.dot(velocity))
        })
    }
}
