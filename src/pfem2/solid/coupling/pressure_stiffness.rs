//! The pressure of the fluid follows the surface of elastic solids within a step, too (theory (J.9b)).
//!
//! ```text
//! f(uⁿ⁺¹) ≈ f(u*) + K_p (û + Δ vⁿ⁺¹ − u*),      K_p,ab = −∫ pⁿ N_a ∂m/∂x_b dξ
//! ```
//!
//! The fluid pushes on the surface at u*. The stiffness of a solid at u*, under a stress that bears the pressure p, is
//! that of a dead load without K_p: of the order of p too small for its short waves, which swing up where p comes near
//! the shear modulus.

use super::immersed::Immersed;
use super::trace::CutMesh;
use crate::math::{Tensor, Vector};
use crate::mesh::Mesh;
use crate::parallel;
use crate::pfem2::solid::mesh::gauss::{GaussPoint, shape_functions, shape_slopes};
use crate::pfem2::solid::structure::pressure::point_stiffness;
use crate::pfem2::solid::surface::SolidSurface;

/// Facets per piece of a parallel loop.
const PIECE: usize = 8;

/// The pressure of the fluid at the nodes where it has one, none where no fluid is near or several sides have their own [Pa].
pub struct FluidPressure(Vec<Option<f64>>);

impl FluidPressure {
    /// The nodal pressures [Pa] in a mesh that solids cut.
    pub fn new<const D: usize, const N: usize>(mesh: &Mesh<D, N>, immersed: &Immersed<D, N>, pressure: &[f64]) -> Self {
        let mut nodal: Vec<Option<f64>> = pressure.iter().copied().map(Some).collect();
        for inside in &immersed.cut.inside {
            let has_fluid = |e: &u32| immersed.has_fluid(*e as usize);
            let around = mesh.elements_around(inside.node as usize);
            if !around.iter().any(has_fluid) || immersed.has_two_sides(mesh, inside.node) {
                nodal[inside.node as usize] = None;
            }
        }
        Self(nodal)
    }

    /// Pressure at a place of an element with these shape functions, by the nodes that have one; zero where none has
    /// [Pa].
    fn at<const N: usize>(&self, nodes: &[u32; N], shape: &[f64; N]) -> f64 {
        let known = nodes.iter().zip(shape).filter_map(|(&node, weight)| Some((self.0[node as usize]?, *weight)));
        let (sum, all) = known.fold((0.0, 0.0), |(sum, all), (p, weight)| (sum + p * weight, all + weight));
        if all > 0.0 { sum / all } else { 0.0 }
    }

    /// Calls `add` with pairs of nodes (a, b) and the contribution of each facet to K_p [N/m]; all nodes of solids are
    /// at `positions` [m].
    pub fn stiffness<const D: usize, const N: usize>(
        &self,
        CutMesh { cut, trace }: &CutMesh<D, N>,
        surface: &SolidSurface<D>,
        positions: &[Vector<D>],
        mut add: impl FnMut((u32, u32), Tensor<D>),
    ) {
        let blocks = parallel::collect(trace.facets.len(), PIECE, |facet| {
            let nodes = surface.nodes_of(facet as u32);
            let count = if trace.facets[facet].is_empty() { 0 } else { nodes.len() };
            let mut sum = vec![Tensor::ZERO; count * count];
            for (place, point) in &trace.facets[facet] {
                let local = &point.local[..D - 1];
                let gauss = GaussPoint {
                    weight: point.quadrature_weight,
                    shape: shape_functions(local),
                    slopes: shape_slopes(local),
                };
                let pressure = self.at(&cut.elements[*place].nodes, &point.shape);
                point_stiffness(nodes, positions, &gauss, pressure, |(a, b), slope| sum[a * count + b] += slope);
            }
            sum
        });
        for (facet, block) in (0..).zip(blocks) {
            let nodes = surface.nodes_of(facet);
            let pairs = nodes.iter().flat_map(|&a| nodes.iter().map(move |&b| (a, b)));
            pairs.zip(block).for_each(|(pair, slope)| add(pair, slope));
        }
    }
}
