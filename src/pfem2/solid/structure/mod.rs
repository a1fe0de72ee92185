//! The solids of a run: state, prediction, equations, energies (theory J.1).
//!
//! ```text
//! Δ = θ Δt,   û = uⁿ + Δt (β₁ vⁿ + β₂ vⁿ⁻¹),   v̂ = vⁿ + Δt (β₁ aⁿ + β₂ aⁿ⁻¹),   u* = uⁿ + Δt v*
//! [M (1/Δ + α) + Δ K(u*) + β C(u*)] v = f(u*) + M (v̂/Δ + b) − F(u*) − K(u*) (û − u*)
//! uⁿ⁺¹ = û + Δ vⁿ⁺¹,   aⁿ⁺¹ = (vⁿ⁺¹ − v̂)/Δ
//! ```
//!
//! F − f + K (uⁿ⁺¹ − u*) are the internal forces less the loads at the end of the step to first order about
//! the prediction: K has the load stiffness of pressures that follow the surface, too. α and β are those of the
//! damping; C is the stiffness where there is no strain, and takes energy from all motions but rigid ones (`damping.rs`).
//! Supports, bonds and rigid solids say which of the velocities are independent (`independent.rs`). Nodes are numbered
//! over all solids; unknown D a + i is the velocity of node a along axis i. A step that takes elastic solids far from
//! u* is solved anew with u* ← uⁿ⁺¹ (theory (J.3a)).

pub mod bodies;
mod constrained;
mod damping;
pub mod deformation;
mod dilatation;
pub mod element;
mod element_forces;
pub mod equilibrium;
mod linearisation;
pub mod modes;
pub mod outline;
mod predict;
pub mod pressure;
pub mod response;
pub mod springs;
mod state;
pub mod stress;
mod sums;
pub mod support;
pub mod tangent;
pub mod ties;

use crate::error::{Place, StepError};
use crate::linalg::SparseMatrix;
use crate::material::{ElasticState, Moduli};
use crate::math::{SymTensor, Tensor, Vector};
use crate::pfem2::solid::equations::{LinearForces, SolidEquations};
use crate::pfem2::solid::mesh::SolidMesh;
use crate::pfem2::solid::mesh::gauss::{GaussPoint, gauss_points};
use crate::pfem2::solid::rigid::RigidBody;
use crate::pfem2::solid::setup::{SolidSetup, SurfaceCondition};
use deformation::{ElementFault, SolidLaw};
use pressure::FollowerPressures;
use springs::Springs;
pub use state::{Prediction, SolidState};
use sums::mass_matrix;
use support::SolidSupports;
use ties::Ties;

/// Bulk modulus over shear modulus that contact counts with at most, that of ν = 0.49 (theory J.18).
const LARGEST_BULK: f64 = 50.0;

/// The solids of a run.
#[derive(Debug)]
pub struct Structure<const D: usize> {
    /// Displacement, velocity and their history.
    pub state: SolidState<D>,
    /// Nodes that follow others.
    pub ties: Ties,
    pub(in crate::pfem2::solid) setups: Vec<SolidSetup<D>>,
    /// First node of each solid, and the number of all.
    first: Vec<u32>,
    /// Places of all nodes in the reference state [m].
    pub(in crate::pfem2::solid) nodes: Vec<Vector<D>>,
    supports: SolidSupports<D>,
    pub(in crate::pfem2::solid) springs: Springs<D>,
    pub(in crate::pfem2::solid) pressures: FollowerPressures,
    /// M_ab [kg], one entry per pair of nodes that share an element.
    pub(in crate::pfem2::solid) mass: SparseMatrix,
    pub(in crate::pfem2::solid) points: Vec<GaussPoint>,
    /// The solids that are rigid.
    pub(in crate::pfem2::solid) rigid: Vec<RigidBody>,
}

impl<const D: usize> Structure<D> {
    /// Structure of solids in their reference states, with the velocities at time 0.
    ///
    /// # Errors
    /// A law that is neither rigid nor has an elastic tangent, or whose stress depends on the path; an element without
    /// a positive volume; velocities for another number of nodes; supports and loads of nodes and facets that aren't
    /// there; supports that a rigid solid can't follow.
    pub fn new(setups: Vec<SolidSetup<D>>) -> Result<Self, String> {
        let points = gauss_points(D);
        setups.iter().try_for_each(check)?;
        let mut first = vec![0];
        for setup in &setups {
            first.push(first[first.len() - 1] + setup.mesh.nodes.len() as u32);
        }
        let supports = SolidSupports::new(&setups, &first)?;
        let springs = Springs::new(&setups, &first)?;
        let pressures = FollowerPressures::new(&setups, &first)?;
        let nodes: Vec<_> = setups.iter().flat_map(|setup| setup.mesh.nodes.iter().copied()).collect();
        let mut velocity: Vec<_> = setups.iter().flat_map(|setup| setup.velocity.iter().copied()).collect();
        impose(&supports.velocities(nodes.len() * D, 0.0), &mut velocity);
        let mass = mass_matrix(&setups, &first, &points)?;
        let is_rigid = |(_, setup): &(usize, &SolidSetup<D>)| setup.law.is_rigid();
        let body = |(solid, setup): (usize, &SolidSetup<D>)| {
            let own = first[solid] as usize..first[solid + 1] as usize;
            RigidBody::new(solid, own, &nodes, &mass, setup.motion.clone())
        };
        let rigid = setups.iter().enumerate().filter(is_rigid).map(body).collect();
        let (state, ties) = (SolidState::new(velocity), Ties::default());
        let mut structure =
            Self { state, ties, setups, first, nodes, supports, springs, pressures, mass, points, rigid };
        structure.begin_rigid()?;
        Ok(structure)
    }

    /// The structure with the surface of the first solid of each pair tied to that of the second.
    ///
    /// # Errors
    /// Two rigid solids; solids that don't touch.
    pub fn bonded(mut self, bonds: &[[usize; 2]]) -> Result<Self, String> {
        self.ties = Ties::new(&self.setups, &self.meshes(), &self.nodes, bonds)?;
        let state = &mut self.state;
        for column in [&mut state.velocity, &mut state.velocity_previous, &mut state.velocity_earlier] {
            self.ties.follow(column);
        }
        Ok(self)
    }

    /// The solids as they were set up.
    pub fn setups(&self) -> &[SolidSetup<D>] {
        &self.setups
    }

    /// Sets the condition for the fluid on the surface of a solid: no slip, or slip (theory (J.6a)).
    pub fn set_surface(&mut self, solid: usize, surface: SurfaceCondition) {
        self.setups[solid].surface = surface;
    }

    /// The mesh of each solid with its first node.
    pub fn meshes(&self) -> Vec<(&SolidMesh<D>, u32)> {
        self.setups.iter().map(|setup| &setup.mesh).zip(self.first.iter().copied()).collect()
    }

    /// Number of nodes of all solids.
    pub fn node_count(&self) -> usize {
        self.nodes.len()
    }

    /// Number of facets of all solids.
    pub(in crate::pfem2::solid) fn facet_count(&self) -> usize {
        self.setups.iter().map(|setup| setup.mesh.facets.len()).sum()
    }

    /// Largest coordinate difference of nodes in the reference state [m].
    pub(in crate::pfem2::solid) fn extent(&self) -> f64 {
        let range = |axis: usize| {
            let all = || self.nodes.iter().map(|x| x[axis]);
            all().fold(f64::NEG_INFINITY, f64::max) - all().fold(f64::INFINITY, f64::min)
        };
        (0..D).map(range).fold(0.0, f64::max)
    }

    /// Places of all nodes [m] with a displacement [m].
    pub fn positions(&self, displacement: &[Vector<D>]) -> Vec<Vector<D>> {
        self.nodes.iter().zip(displacement).map(|(x, u)| *x + *u).collect()
    }

    /// Prescribed velocity of each unknown at time `t` [m/s].
    pub fn held_velocities(&self, t: f64) -> Vec<Option<f64>> {
        self.supports.velocities(self.nodes.len() * D, t)
    }

    /// The equations of a step with the implicit part `delta` [s] that ends at `t_end` [s]; gravity in a place [m/s²].
    ///
    /// # Errors
    /// An element that is turned inside out by the prediction, or has no thickness that is free of stress.
    pub fn equations(
        &self,
        t_end: f64,
        delta: f64,
        prediction: &Prediction<D>,
        gravity: impl Fn(Vector<D>) -> Vector<D>,
    ) -> Result<SolidEquations, StepError> {
        let Prediction { displacement_hat, velocity_hat, displacement, .. } = prediction;
        let mut matrix = self.zero_matrix();
        self.add_inertia(delta, &mut matrix);
        let places = self.positions(displacement);
        let rates = self.by_node(|setup| setup.inertia_rate(delta));
        let mut start: Vec<_> = velocity_hat.iter().zip(rates).map(|(hat, rate)| *hat * rate).collect();
        // Rigid solids have their inertia about their centre of mass.
        self.rigid.iter().for_each(|body| start[body.nodes.clone()].fill(Vector::ZERO));
        start.iter_mut().zip(&places).for_each(|(start, x)| *start += gravity(*x));
        let mut rhs = self.weighted_by_mass(&start);
        self.supports.add_forces(t_end, &mut rhs);
        self.add_internal_forces(delta, prediction, &mut matrix, &mut rhs)?;
        self.pressures.forces(t_end, &places, |node, force| {
            (0..D).for_each(|axis| rhs[node as usize * D + axis] += force[axis]);
        });
        let offset = self.displacement_offsets(prediction);
        self.pressures.stiffness(t_end, &places, |(row, column), slope| {
            let force = slope.apply(offset[column as usize]);
            (0..D).for_each(|axis| rhs[row as usize * D + axis] += force[axis]);
            self.add_block(&mut matrix, (row, column), &(slope * -delta));
        });
        let mut linear = LinearForces::default();
        self.springs.add(delta, displacement_hat, &mut linear);
        let inertia = self.rigid_inertia(delta, prediction);
        let (velocities, volume_slopes) = (prediction.velocities.clone(), self.volume_slopes(&places));
        Ok(SolidEquations { matrix, rhs, linear, inertia, velocities, volume_slopes })
    }

    /// Adds Δ K + β C to a matrix, and −F(u*) − K (û − u*) to a right-hand side [N].
    ///
    /// # Errors
    /// As [`Structure::equations`].
    fn add_internal_forces(
        &self,
        delta: f64,
        prediction: &Prediction<D>,
        matrix: &mut SparseMatrix,
        rhs: &mut [f64],
    ) -> Result<(), StepError> {
        let offset = self.displacement_offsets(prediction);
        self.add_damping(&prediction.displacement, matrix)?;
        self.visit_step(prediction, |_, nodes, forces| {
            for (a, &row) in nodes.iter().enumerate() {
                let mut force = forces.internal[a];
                for (b, &column) in nodes.iter().enumerate() {
                    let tangent = forces.tangent(a, b);
                    force += tangent.apply(offset[column as usize]);
                    self.add_block(matrix, (row, column), &(tangent * delta));
                }
                (0..D).for_each(|axis| rhs[row as usize * D + axis] -= force[axis]);
            }
        })
    }

    /// û − u* of all nodes [m].
    fn displacement_offsets(&self, prediction: &Prediction<D>) -> Vec<Vector<D>> {
        self.increment_from_prediction(prediction, |a| prediction.displacement_hat[a])
    }

    /// Ends a step with the implicit part `delta` [s] and the independent velocities that its equations gave.
    pub fn advance(&mut self, delta: f64, prediction: &Prediction<D>, w: &[f64]) {
        let velocity: Vec<Vector<D>> = prediction.velocities.nodal_vectors(w);
        let both = velocity.iter().zip(&prediction.displacement_hat);
        let mut displacement: Vec<_> = both.map(|(v, hat)| *hat + *v * delta).collect();
        for ((body, state), prediction) in self.rigid.iter().zip(&mut self.state.rigid).zip(&prediction.rigid) {
            body.advance(state, delta, prediction, &prediction.rates(w));
        }
        self.place_rigid(&mut displacement, |k| (self.state.rigid[k].displacement, self.state.rigid[k].rotation));
        self.ties.follow(&mut displacement);
        let both = displacement.iter().zip(&prediction.displacement);
        self.state.correction = both.map(|(u, predicted)| *u - *predicted).collect();
        self.state.displacement = displacement;
        let since = |hat: &[Vector<D>]| velocity.iter().zip(hat).map(|(v, hat)| (*v - *hat) / delta).collect();
        let (own, at_surface) = (since(&prediction.velocity_hat), since(&prediction.surface_velocity_hat));
        let state = &mut self.state;
        state.acceleration_previous = std::mem::replace(&mut state.acceleration, own);
        state.surface_acceleration_previous = std::mem::replace(&mut state.surface_acceleration, at_surface);
        let last = std::mem::replace(&mut state.velocity, velocity);
        state.velocity_earlier = std::mem::replace(&mut state.velocity_previous, last);
    }

    pub(in crate::pfem2::solid) fn law(&self, solid: usize) -> Result<SolidLaw<'_>, StepError> {
        let setup = &self.setups[solid];
        let law = setup.law.elastic_law();
        let law = law.map_err(|what| StepError::new(Place::Everywhere, what, "solid", solid as f64, "another law"))?;
        Ok(SolidLaw { law, plane: setup.plane })
    }

    /// The solids that aren't rigid.
    pub(in crate::pfem2::solid) fn elastic(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.setups.len()).filter(|&solid| !self.setups[solid].law.is_rigid())
    }

    /// True for nodes of solids that aren't rigid.
    pub(in crate::pfem2) fn is_elastic(&self, node: u32) -> bool {
        let solid = self.first.partition_point(|&first| first <= node) - 1;
        self.setups.get(solid).is_some_and(|setup| !setup.law.is_rigid())
    }

    /// The largest density of elastic solids in the reference state [kg/m³]; zero without one.
    pub fn largest_density(&self) -> f64 {
        let laws = self.setups.iter().filter_map(|setup| setup.law.elastic_law().ok());
        laws.map(|law| law.reference_density()).fold(0.0, f64::max)
    }

    /// λ + 2 μ of a solid [Pa], zero of a rigid one. The surface of a nearly incompressible one gives way by the shape
    /// of the solid: K counts with [`LARGEST_BULK`] G at most.
    pub(in crate::pfem2::solid) fn wave_modulus(&self, setup: &SolidSetup<D>) -> f64 {
        let of = |Moduli { bulk, shear }: Moduli| bulk.min(LARGEST_BULK * shear) + 4.0 / 3.0 * shear;
        setup.law.elastic_law().map_or(0.0, |law| of(law.moduli()))
    }

    pub(in crate::pfem2::solid) fn error(&self, solid: usize, element: usize, fault: ElementFault<D>) -> StepError {
        let body = self.setups[solid].name.clone();
        let place = Place::Element { body, index: element, position: fault.position.to3() };
        let advice = "take shorter steps, larger elements where the solid is distorted most, or a law that bears large compression \
                      (`neo-hookean`); where pictures show it crushed or folded before, the load is more than it bears: let it grow \
                      slower (`ramp`), or make the solid stiffer or thicker; where its nodes move to and fro, let the mesh of the \
                      fluid be finer there, or damp it (`damping.stiffness`)";
        StepError::new(place, fault.what, "volume ratio", fault.volume_ratio, advice)
    }

    /// Adds a block to the rows of node `row` and the columns of node `column`.
    pub(in crate::pfem2) fn add_block(&self, matrix: &mut SparseMatrix, (row, column): (u32, u32), block: &Tensor<D>) {
        let own = self.mass.row(row as usize);
        let Some(entry) = self.mass.entry(row as usize, column as usize) else { return };
        for i in 0..D {
            let first = own.start * D * D + i * own.len() * D + (entry - own.start) * D;
            for j in 0..D {
                matrix.values[first + j] += block[i][j];
            }
        }
    }

    /// `of(solid)` for each node of each solid.
    pub(in crate::pfem2::solid) fn by_node(&self, of: impl Fn(&SolidSetup<D>) -> f64) -> Vec<f64> {
        self.setups.iter().flat_map(|setup| vec![of(setup); setup.mesh.nodes.len()]).collect()
    }

    /// Adds M (1/Δ + α) of elastic solids, without 1/Δ for quasi-static ones.
    fn add_inertia(&self, delta: f64, matrix: &mut SparseMatrix) {
        for solid in self.elastic() {
            let setup = &self.setups[solid];
            let rate = setup.inertia_rate(delta) + setup.damping.mass;
            for row in self.first[solid]..self.first[solid + 1] {
                for entry in self.mass.row(row as usize) {
                    let block = Tensor::identity() * (self.mass.values[entry] * rate);
                    self.add_block(matrix, (row, self.mass.columns[entry]), &block);
                }
            }
        }
    }

    /// The product of a matrix with the sparsity pattern of the equations and a nodal vector.
    pub(in crate::pfem2) fn product(&self, matrix: &SparseMatrix, x: &[Vector<D>]) -> Vec<Vector<D>> {
        let x: Vec<f64> = x.iter().flat_map(|x| x.0).collect();
        let mut rows = vec![0.0; x.len()];
        matrix.multiply(&x, &mut rows);
        rows.chunks(D).map(|row| Vector::from_fn(|axis| row[axis])).collect()
    }

    /// Forces of loads and gravity on each unknown at time `t` [N], at a displacement [m].
    pub(in crate::pfem2::solid) fn external_forces(
        &self,
        t: f64,
        displacement: &[Vector<D>],
        gravity: impl Fn(Vector<D>) -> Vector<D>,
    ) -> Vec<f64> {
        let places = self.positions(displacement);
        let mut force = self.weighted_by_mass(&places.iter().map(|x| gravity(*x)).collect::<Vec<_>>());
        self.supports.add_forces(t, &mut force);
        self.pressures.forces(t, &places, |node, own| {
            (0..D).for_each(|axis| force[node as usize * D + axis] += own[axis]);
        });
        force
    }

    /// The zero matrix with the sparsity pattern of the equations.
    pub(in crate::pfem2) fn zero_matrix(&self) -> SparseMatrix {
        self.mass.zero_blocks(D)
    }
}

/// Replaces prescribed components.
fn impose<const D: usize>(held: &[Option<f64>], velocity: &mut [Vector<D>]) {
    for (unknown, held) in held.iter().enumerate() {
        if let Some(held) = held {
            velocity[unknown / D][unknown % D] = *held;
        }
    }
}

/// Checks that a solid has a law with a stored energy, elements, and velocities at all nodes.
///
/// # Errors
/// As [`Structure::new`].
fn check<const D: usize>(setup: &SolidSetup<D>) -> Result<(), String> {
    let rest = ElasticState { deformation: Tensor::identity(), stress: SymTensor::ZERO };
    let told = |error| format!("the solid `{}`: {error}", setup.name);
    if !setup.law.is_rigid() && setup.law.elastic_law().map_err(told)?.strain_energy(&rest).is_none() {
        return Err(format!(
            "the solid `{}` needs a law with a stored energy: the stress of a rate law depends on the path, which solids of `pfem2` don't \
             keep; for small strains `st-venant-kirchhoff` and `neo-hookean` agree with it",
            setup.name
        ));
    }
    if setup.mesh.elements.is_empty() && !setup.law.is_rigid() {
        return Err(format!("the elastic solid `{}` has a surface, but no elements inside of it", setup.name));
    }
    if setup.velocity.len() != setup.mesh.nodes.len() {
        let (given, nodes) = (setup.velocity.len(), setup.mesh.nodes.len());
        return Err(format!("the solid `{}` has {nodes} nodes, but {given} velocities", setup.name));
    }
    Ok(())
}

#[cfg(test)]
pub(in crate::pfem2::solid) mod tests;
