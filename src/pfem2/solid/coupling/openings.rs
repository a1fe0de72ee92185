//! Openings that the surface of a solid meets: tractions act on the fluid part of their facets alone.
//!
//! ```text
//! t_c = ∮_O N^s_c t̄ dA = Σ_b A (1 + δ_cb)/(d (d + 1)) t̄(x_b)        theory (J.9d)
//!
//! O: facets of the fluid part at an opening; c, b: their corners
//!
//! A_cj −= μ/d g^s_j ⊗ S,   A_cc −= ½ρ/d (v̂_c·S)₋                             theory (J.9e), at outlets
//! ```
//!
//! Corners are nodes and cut points; what pushes at these pushes the solid, as the pressure of the fluid does there in
//! the other direction. With the tractions of whole facets fluid beside a solid would be pushed by what acts on the
//! other side of it, and wouldn't rest under an even pressure.

use super::element::{CoupledElement, Opening, OutflowBlock, Unknown, VelocityMap, VertexVelocities};
use super::fluid_part::{FluidPart, PartGeometry};
use super::walls::{PartFacet, part_facets};
use crate::math::{Tensor, Vector};

impl<const D: usize> Opening<D> {
    /// Loads at the corners under the tractions there [Pa].
    fn loads(&self, tractions: &[Vector<D>; D]) -> [Vector<D>; D] {
        let weight = self.area.norm() / (D * (D + 1)) as f64;
        let sum = tractions.iter().copied().sum::<Vector<D>>();
        tractions.map(|own| (sum + own) * weight)
    }
}

impl<const D: usize, const N: usize> CoupledElement<D, N> {
    /// Adds the facets of a part at openings.
    pub(super) fn add_openings(
        &mut self,
        part: &PartGeometry<D, N>,
        fluid: &FluidPart<D, N>,
        corners: &[Vector<D>; N],
        velocities: &VertexVelocities<D>,
    ) {
        let VertexVelocities { maps, positions, .. } = velocities;
        for facet in part_facets(part, fluid.openings) {
            let vertices = facet.corners.map(|c| part.vertices[c]);
            let is_outlet = fluid.outlets >> facet.facet & 1 == 1;
            let outflow = if is_outlet { outflow(&facet, part, fluid, velocities) } else { Vec::new() };
            for OutflowBlock { row, column, block } in &outflow {
                self.add_velocities(row, column, block);
            }
            self.openings.push(Opening {
                facet: facet.facet,
                area: facet.area,
                positions: vertices.map(|vertex| if vertex < N { corners[vertex] } else { positions[vertex - N] }),
                velocities: vertices.map(|vertex| maps[vertex].clone()),
                loads: [Vector::ZERO; D],
                outflow,
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

    /// Force of the tractions at openings on the fluid [N], and their power [W], with what outlets add, where nodes of
    /// the element and of solids have these velocities [m/s].
    pub fn action_of_openings(
        &self,
        of_node: impl Fn(usize) -> Vector<D>,
        of_solid: impl Fn(u32) -> Vector<D>,
    ) -> (Vector<D>, f64) {
        let of = |unknown: Unknown| match unknown {
            Unknown::Node(i) => of_node(i),
            Unknown::Solid(a) => of_solid(self.solid[a]),
        };
        let velocity = |vertex: &VelocityMap<D>| vertex.iter().map(|&(unknown, p)| p.apply(of(unknown))).sum();
        let mut sum = (Vector::ZERO, 0.0);
        let mut add = |corner: &VelocityMap<D>, load: Vector<D>| {
            sum.0 += load;
            sum.1 += load.dot(velocity(corner));
        };
        for opening in &self.openings {
            opening.velocities.iter().zip(opening.loads).for_each(|(corner, load)| add(corner, load));
            opening.outflow.iter().for_each(|own| add(&own.row, -own.block.apply(velocity(&own.column))));
        }
        sum
    }
}

/// Blocks of an outlet in the rows of the corners of a facet of a part (theory (J.9e)).
fn outflow<const D: usize, const N: usize>(
    facet: &PartFacet<D>,
    part: &PartGeometry<D, N>,
    fluid: &FluidPart<D, N>,
    VertexVelocities { maps, hats, .. }: &VertexVelocities<D>,
) -> Vec<OutflowBlock<D>> {
    let viscosity = part.mean(|piece| fluid.medium(piece).viscosity);
    let density = part.mean(|piece| fluid.medium(piece).density);
    let block = |c: usize, j: usize| {
        let inflow = if c == j { hats[part.vertices[c]].dot(facet.area).min(0.0) } else { 0.0 };
        let back = 0.5 * density * inflow;
        let release = |r: usize, s: usize| viscosity * part.simplex.gradient[j][r] * facet.area[s];
        let block = Tensor::from_fn(|r, s| -(release(r, s) + if r == s { back } else { 0.0 }) / D as f64);
        OutflowBlock { row: maps[part.vertices[c]].clone(), column: maps[part.vertices[j]].clone(), block }
    };
    facet.corners.iter().flat_map(|&c| (0..N).map(move |j| (c, j))).map(|(c, j)| block(c, j)).collect()
}
