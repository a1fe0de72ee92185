//! Sums over solids: mass, momentum, energies, volume, and the stress at their Gauss points.

use super::Structure;
use super::element;
use super::pressure::area_vector;
use super::stress::NodalStress;
use crate::error::StepError;
use crate::linalg::{MatrixEntry, SparseMatrix};
use crate::math::{SymTensor, Vector};
use crate::parallel;
use crate::pfem2::solid::mesh::gauss::{GaussPoint, gauss_points};
use crate::pfem2::solid::setup::SolidSetup;

/// Elements per piece of a parallel loop.
const BATCH: usize = 64;

impl<const D: usize> Structure<D> {
    /// Mass of all solids [kg].
    pub fn mass(&self) -> f64 {
        parallel::sum(self.mass.values.len(), |entry| self.mass.values[entry])
    }

    /// Mass of a solid [kg].
    pub fn mass_of(&self, solid: usize) -> f64 {
        let nodes = self.nodes_of(solid);
        let entries = self.mass.row(nodes.start).start..self.mass.row(nodes.end - 1).end;
        parallel::sum(entries.len(), |n| self.mass.values[entries.start + n])
    }

    /// Momentum of all solids [kg m/s].
    pub fn momentum(&self) -> Vector<D> {
        let momentum = self.weighted_by_mass(&self.state.velocity);
        parallel::sum(self.nodes.len(), |node| Vector::from_fn(|axis| momentum[node * D + axis]))
    }

    /// M x at each unknown.
    pub(in crate::pfem2) fn weighted_by_mass(&self, x: &[Vector<D>]) -> Vec<f64> {
        let row = |row: usize| -> Vector<D> {
            self.mass.row(row).map(|n| x[self.mass.columns[n] as usize] * self.mass.values[n]).sum()
        };
        parallel::collect_all(self.nodes.len(), BATCH, |node| row(node).0)
    }

    /// Kinetic energy ½ v · M v of all solids [J].
    pub fn kinetic_energy(&self) -> f64 {
        let momentum = self.weighted_by_mass(&self.state.velocity);
        let inert = self.by_node(|setup| setup.inertia_rate(1.0));
        let velocity = &self.state.velocity;
        0.5 * parallel::sum(momentum.len(), |k| momentum[k] * (velocity[k / D][k % D] * inert[k / D]))
    }

    /// Stored energy of all solids [J].
    ///
    /// # Errors
    /// As [`Structure::equations`].
    pub fn strain_energy(&self) -> Result<f64, StepError> {
        let mut energy = 0.0;
        for solid in self.elastic() {
            let law = self.law(solid)?;
            let all = parallel::collect(self.setups()[solid].mesh.elements.len(), BATCH, |element| {
                let (_, [places, own]) = self.gather(solid, element, [&self.nodes, &self.state.displacement]);
                element::strain_energy(&self.points, law, &places, &own)
            });
            let of_element =
                |(element, own): (usize, Result<f64, _>)| own.map_err(|fault| self.error(solid, element, fault));
            let all = all.into_iter().enumerate().map(of_element).collect::<Result<Vec<f64>, _>>()?;
            energy += parallel::sum(all.len(), |element| all[element]);
        }
        Ok(energy)
    }

    /// Stress and strain at the Gauss points of an element; not a number where it is turned inside out, and in rigid
    /// solids.
    pub(in crate::pfem2::solid) fn point_stresses(&self, solid: usize, element: usize) -> Vec<NodalStress> {
        let (_, [places, own]) = self.gather(solid, element, [&self.nodes, &self.state.displacement]);
        let found = self.law(solid).ok().and_then(|law| element::stresses(&self.points, law, &places, &own).ok());
        let none = SymTensor::isotropic(f64::NAN);
        found.unwrap_or_else(|| vec![NodalStress { stress: none, strain: none }; self.points.len()])
    }

    /// ∂V/∂u_a = ∫ N_a n dA of the volume of elastic solids with their nodes at `positions` [m], axis by axis [m²].
    pub(in crate::pfem2::solid) fn volume_slopes(&self, positions: &[Vector<D>]) -> Vec<f64> {
        let (points, mut slopes) = (gauss_points(D - 1), vec![0.0; positions.len() * D]);
        for solid in self.elastic() {
            let first = self.nodes_of(solid).start as u32;
            for facet in &self.setups()[solid].mesh.facets {
                let nodes: Vec<u32> = facet.nodes.iter().map(|node| first + node).collect();
                for point in &points {
                    let area = area_vector(&nodes, positions, point);
                    for (&node, shape) in nodes.iter().zip(&point.shape) {
                        (0..D).for_each(|axis| slopes[node as usize * D + axis] += area[axis] * shape);
                    }
                }
            }
        }
        slopes
    }

    /// Volume of all solids with their nodes at `positions` [m³].
    pub fn volume(&self, positions: &[Vector<D>]) -> f64 {
        let of = |solid: usize, element: usize| {
            let (_, [places]) = self.gather(solid, element, [positions]);
            element::volume(&self.points, &places)
        };
        let of_solid = |(solid, setup): (usize, &SolidSetup<D>)| {
            let (elements, inner) = (&setup.mesh.elements, &setup.mesh.inner);
            parallel::sum(elements.len(), |element| of(solid, element)) + parallel::sum(inner.len(), |n| inner[n].1)
        };
        self.setups().iter().enumerate().map(of_solid).sum()
    }
}

/// M_ab of all solids.
///
/// # Errors
/// An element without a positive volume.
pub(in crate::pfem2::solid) fn mass_matrix<const D: usize>(
    setups: &[SolidSetup<D>],
    first: &[u32],
    points: &[GaussPoint],
) -> Result<SparseMatrix, String> {
    let mut entries = Vec::new();
    for (setup, &first) in setups.iter().zip(first) {
        if setup.mesh.elements.is_empty() {
            // Nodes without mass have their place in the matrix, too.
            entries
                .extend((first..first + setup.mesh.nodes.len() as u32).map(|node| MatrixEntry::new(node, node, 0.0)));
            let density = setup.law.density();
            let inner = setup.mesh.inner.iter();
            entries.extend(inner.map(|&(node, v)| MatrixEntry::new(first + node, first + node, density * v)));
        }
        for (index, nodes) in setup.mesh.elements.iter().enumerate() {
            let places: Vec<_> = nodes.iter().map(|&node| setup.mesh.nodes[node as usize]).collect();
            let mass = element::mass(points, &places).map_err(|fault| {
                format!("element {index} of the solid `{}` at {:?} m: {}", setup.name, fault.position.0, fault.what)
            })?;
            let density = setup.law.density();
            for (a, &row) in nodes.iter().enumerate() {
                let all = nodes.iter().zip(&mass[a * nodes.len()..]);
                entries
                    .extend(all.map(|(&column, mass)| MatrixEntry::new(first + row, first + column, density * mass)));
            }
        }
    }
    Ok(SparseMatrix::from_triplets(first.last().map_or(0, |&count| count as usize), entries))
}
