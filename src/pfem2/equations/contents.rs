//! Contents of the elements in a step, and the enriched equations of those that an interface cuts.

use crate::math::Vector;
use crate::mesh::Mesh;
use crate::parallel;
use crate::pfem2::cut_element::Enriched;
use crate::pfem2::element::Content;

/// An element that an interface cuts.
#[derive(Debug, Clone)]
pub struct CutElement<const D: usize, const N: usize> {
    /// The element.
    pub element: u32,
    /// Difference of its mass matrix from that of an element of its mean density [kg].
    pub inertia: [[f64; N]; N],
    /// Enriched pressure of the element.
    pub enriched: Enriched<N>,
    /// Forces of surface tension on its nodes [N].
    pub tension: [Vector<D>; N],
    /// Energy of the interface [J].
    pub energy: f64,
    /// Source s, against which the pressure gradient is stabilised, as a mean over both sides [m/s²].
    pub source: Vector<D>,
}

/// The fluids and the solids on particles in the elements of the last step.
#[derive(Debug)]
pub struct ElementContents<const D: usize, const N: usize> {
    /// Density of each phase: fluids, then solids on particles [kg/m³].
    pub density: Vec<f64>,
    /// Volume of each phase [m³].
    pub volumes: Vec<f64>,
    /// Content of each element.
    pub elements: Vec<Content<N>>,
    /// Elements with one fluid.
    pub pure: Vec<bool>,
    /// Elements that an interface cuts, ascending.
    pub cuts: Vec<CutElement<D, N>>,
    /// Recovered pressures of the cut elements [Pa].
    pub recovered: Vec<Vec<f64>>,
}

impl<const D: usize, const N: usize> ElementContents<D, N> {
    /// So many elements before the first step, with phases of these densities [kg/m³].
    pub(super) fn new(elements: usize, density: Vec<f64>) -> Self {
        let volumes = vec![0.0; density.len()];
        Self {
            density,
            volumes,
            elements: Vec::new(),
            pure: vec![true; elements],
            cuts: Vec::new(),
            recovered: Vec::new(),
        }
    }

    /// Adds phases of these densities [kg/m³].
    pub(super) fn add_phases(&mut self, density: impl IntoIterator<Item = f64>) {
        self.density.extend(density);
        self.volumes.resize(self.density.len(), 0.0);
    }

    /// An element that an interface cuts.
    pub fn cut(&self, element: usize) -> Option<&CutElement<D, N>> {
        let place = self.cuts.binary_search_by_key(&(element as u32), |cut| cut.element).ok()?;
        Some(&self.cuts[place])
    }

    /// Mass of a node: its part of what fills the elements around it [kg].
    pub fn nodal_mass(&self, mesh: &Mesh<D, N>, node: usize) -> f64 {
        let around = mesh.elements_around(node).iter().map(|&e| e as usize);
        let own = |e: usize| {
            let corners = mesh.elements()[e].iter().zip(&self.elements[e].mass);
            corners.filter(|(i, _)| **i as usize == node).map(|(_, mass)| mass).sum::<f64>()
        };
        around.map(own).sum()
    }

    /// Finds the condensed pressures of the cut elements from the unknowns of the nodes.
    pub(super) fn recover(&mut self, mesh: &Mesh<D, N>, unknowns: &[[f64; N]]) {
        let nodal = |cut: &CutElement<D, N>| mesh.elements()[cut.element as usize].map(|i| unknowns[i as usize]);
        let of = |cut: usize| self.cuts[cut].enriched.recover(&nodal(&self.cuts[cut]));
        self.recovered = parallel::collect(self.cuts.len(), 256, of);
    }
}
