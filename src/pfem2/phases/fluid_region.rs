//! The part of the mesh that fluids fill: all of it, or what solids leave (theory G.14).
//!
//! ```text
//! element e without a solid    itself
//! element e that a solid cuts  the simplices s outside of the solid, φ at their corners that of e there
//! V⁻_e = Σ_s V_s⁻              of each the part where the linear φ is negative
//! ```

use crate::mesh::Mesh;
use crate::parallel;
use crate::pfem2::cut_element::{at_corners, negative_fraction, volume_fraction, whole};
use crate::pfem2::solid::cut::{ElementState, SolidCut};
use std::collections::BTreeSet;

/// Part of a mesh that fluids fill.
#[derive(Debug, Clone, Copy)]
pub struct FluidRegion<'a, const D: usize, const N: usize> {
    /// The mesh.
    pub mesh: &'a Mesh<D, N>,
    /// The solids in it.
    cut: Option<&'a SolidCut<D, N>>,
}

impl<'a, const D: usize, const N: usize> FluidRegion<'a, D, N> {
    /// A mesh with solids in it.
    pub fn new(mesh: &'a Mesh<D, N>, cut: Option<&'a SolidCut<D, N>>) -> Self {
        Self { mesh, cut }
    }

    /// A mesh without solids.
    pub fn whole(mesh: &'a Mesh<D, N>) -> Self {
        Self { mesh, cut: None }
    }

    /// Volume of the fluids in an element [m³]; area [m²] in 2D.
    pub fn volume(&self, element: usize) -> f64 {
        self.cut.map_or(self.mesh.simplex(element).volume, |cut| cut.volume_outside(self.mesh, element))
    }

    /// Volume of all fluids [m³].
    pub fn total(&self) -> f64 {
        let Some(_) = self.cut else { return self.mesh.volume() };
        parallel::sum(self.mesh.elements().len(), |e| self.volume(e))
    }

    /// Volume of the fluids in an element where the φ with these nodal values is negative [m³].
    pub fn negative_volume(&self, element: usize, level: &[f64; N]) -> f64 {
        let volume = self.mesh.simplex(element).volume;
        let Some(shapes) = self.cut_shapes(element) else { return volume * negative_fraction(level) };
        let of = |corners: &[[f64; N]; N]| volume_fraction(corners) * negative_fraction(&at_corners(corners, level));
        volume * shapes.iter().map(of).sum::<f64>()
    }

    /// The simplices that fluids fill in an element, by the shape functions of the element at their corners.
    pub fn simplices(&self, element: usize) -> Vec<[[f64; N]; N]> {
        self.cut_shapes(element).map_or_else(|| vec![whole()], <[_]>::to_vec)
    }

    /// True for a node inside of a solid.
    pub fn is_covered(&self, node: usize) -> bool {
        self.cut.is_some_and(|cut| cut.is_inside(node as u32))
    }

    /// The nodes inside of solids, ascending.
    pub fn covered(&self) -> impl Iterator<Item = usize> + 'a {
        self.cut.into_iter().flat_map(|cut| cut.inside.iter().map(|inside| inside.node as usize))
    }

    /// The nodes inside of solids in elements that hold fluid, too.
    pub fn covered_beside_fluid(&self) -> BTreeSet<usize> {
        let nodes = self.cut.into_iter().flat_map(|cut| cut.elements.iter().flat_map(|element| element.nodes));
        nodes.map(|node| node as usize).filter(|&node| self.is_covered(node)).collect()
    }

    /// The simplices of an element that a solid covers or cuts; none of other elements.
    fn cut_shapes(&self, element: usize) -> Option<&'a [[[f64; N]; N]]> {
        let cut = self.cut?;
        match cut.state[element] {
            ElementState::Fluid => None,
            ElementState::Solid => Some(&[]),
            ElementState::Cut(place) => Some(&cut.elements[place as usize].shapes),
        }
    }
}
