//! The mesh stage of a step: from convected velocities and phases to velocity and pressure at the nodes.
//!
//! ```text
//! M (v − v̂)/Δ + K v − Dᵀ p = M b + t̄ + surface tension,     D v + C p = τ V g·s,     Δ = θ Δt
//! ```
//!
//! v and p belong to the end of the step, where the particles are; with θ < 1 the particles have already received
//! the share 1 − θ of the last acceleration (see `step.rs`).

use super::assemble::{CutElement, ElementEquations};
use super::convergence::not_converged;
use super::element::{Content, Equations, Stabilisation};
use super::linear_system::LinearSystem;
use super::outflow;
pub use super::physics::{Physics, TimeStep};
use super::slip;
use super::subscale::{self, Subscales};
use super::viscous::ViscousFlow;
use crate::error::{Place, StepError};
use crate::linalg::{SolveOutcome, SolverOptions};
use crate::math::{Signal, Vector};
use crate::mesh::Mesh;
use crate::parallel;
use crate::pfem2::boundary::{Boundary, BoundaryKind, Constraints};
use crate::pfem2::interface::FluidRegion;
use crate::pfem2::interface::phases::Phases;
use crate::pfem2::particle_solids::columns;
use crate::pfem2::particle_solids::setup::ParticleSolidSetup;
use crate::pfem2::particle_solids::solids::ParticleSolids;
use crate::pfem2::particles::Particles;
use crate::pfem2::solid::coupling::immersed::Immersed;

/// Velocity and pressure on the mesh.
pub struct VelocityPressureSystem<const D: usize, const N: usize> {
    /// The mesh.
    pub mesh: Mesh<D, N>,
    /// Conditions on its boundary.
    pub boundary: Boundary<D>,
    /// The fluids and the body force.
    pub physics: Physics<D>,
    /// Velocity at the nodes [m/s].
    pub velocity: Vec<Vector<D>>,
    /// Pressure at the nodes [Pa].
    pub pressure: Vec<f64>,
    /// Projected parts of the residual, for the stabilisation.
    pub subscales: Subscales<D>,
    /// Body force at the nodes [m/s²].
    pub force: Vec<Vector<D>>,
    /// Content of each element in the last step.
    pub contents: Vec<Content<N>>,
    /// Elements that an interface cut in the last step.
    pub cuts: Vec<CutElement<D, N>>,
    /// Recovered pressures of the cut elements [Pa].
    pub recovered: Vec<Vec<f64>>,
    /// Volume of each fluid in the last step [m³].
    pub volumes: Vec<f64>,
    /// Solids in the mesh.
    pub immersed: Option<Immersed<D, N>>,
    /// Solids on particles.
    pub particle_solids: Option<ParticleSolids<D, N>>,
    /// Outcome of the last solution.
    pub outcome: SolveOutcome,
    pub(in crate::pfem2) equations: Equations,
    pub(super) density: Vec<f64>,
    /// Shortest edge of each element [m].
    pub(super) size: Vec<f64>,
    /// Elements with one fluid.
    pub(super) pure: Vec<bool>,
    /// Open facets of each element, as bits.
    pub(super) open: Vec<u8>,
    /// Slip facets of each element, as bits.
    pub(super) slip: Vec<u8>,
    /// Facets of each element that fluid doesn't leave through, as bits.
    pub(super) walls: Vec<u8>,
    pub(super) constraints: Constraints<D, N>,
    /// True for nodes on the boundary of the mesh.
    boundary_nodes: Vec<bool>,
    /// Prescribed unknowns of the boundary, as the masks of `constraints`.
    boundary_mask: Vec<u8>,
    /// Matrix, right-hand side and solver.
    pub(super) linear: LinearSystem<N>,
    /// Unknowns of the nodes, velocity and pressure.
    pub(in crate::pfem2) unknowns: Vec<[f64; N]>,
    /// Preconditioners made so far.
    pub(in crate::pfem2) preconditioners: u64,
}

impl<const D: usize, const N: usize> VelocityPressureSystem<D, N> {
    /// A state that starts with these nodal velocities [m/s].
    pub fn new(
        mesh: Mesh<D, N>,
        boundary: Boundary<D>,
        physics: Physics<D>,
        velocity: Vec<Vector<D>>,
        options: SolverOptions,
    ) -> Self {
        let nodes = mesh.nodes().len();
        let force = body_force(&mesh, &physics.gravity, 0.0);
        let equations = Equations { delta: 1.0, mass: physics.mass, stabilisation: physics.stabilisation };
        let constraints = boundary.constraints(nodes);
        Self {
            size: (0..mesh.elements().len()).map(|e| mesh.shortest_edge(e)).collect(),
            density: physics.fluids.iter().map(|fluid| fluid.density).collect(),
            open: outflow::open_facets(&mesh, &boundary),
            slip: slip::slip_facets(&mesh, &boundary),
            walls: boundary.facet_bits(&mesh, |condition| condition.kind() != BoundaryKind::Outlet),
            boundary_nodes: boundary_nodes(&mesh),
            boundary_mask: constraints.mask.clone(),
            constraints,
            immersed: None,
            particle_solids: None,
            linear: LinearSystem::new(&mesh, options),
            unknowns: vec![[0.0; N]; nodes],
            pressure: vec![0.0; nodes],
            subscales: Subscales::at_rest(&mesh, physics.stabilisation),
            contents: Vec::new(),
            cuts: Vec::new(),
            recovered: Vec::new(),
            volumes: vec![0.0; physics.fluids.len()],
            outcome: SolveOutcome { iterations: 0, residual: 0.0, rebuilt: false },
            pure: vec![true; mesh.elements().len()],
            velocity,
            mesh,
            boundary,
            physics,
            force,
            equations,
            preconditioners: 0,
        }
    }

    /// The system with solids on particles, whose phases follow those of the fluids.
    pub fn with_particle_solids(mut self, setups: Vec<ParticleSolidSetup<D>>) -> Self {
        if setups.is_empty() {
            return self;
        }
        self.density.extend(setups.iter().map(|solid| solid.law.density));
        self.volumes.resize(self.density.len(), 0.0);
        let first = self.physics.fluids.len();
        let solids = ParticleSolids::new(setups, first, self.density[0]);
        solids.hold(&mut self.constraints);
        self.particle_solids = Some(solids);
        self
    }

    /// Names of the phases: fluids, then solids on particles.
    pub fn phase_names(&self) -> impl Iterator<Item = &str> {
        let solids = self.particle_solids.iter().flat_map(|solids| &solids.setups).map(|solid| solid.name.as_str());
        self.physics.fluids.iter().map(|fluid| fluid.name.as_str()).chain(solids)
    }

    /// True for an element that holds a solid on particles.
    pub(in crate::pfem2) fn holds_solid(&self, element: usize) -> bool {
        self.particle_solids.as_ref().is_some_and(|solids| solids.of(element).is_some())
    }

    /// Solves for velocity and pressure at the end of the step, and for the velocity of immersed solids.
    ///
    /// # Errors
    /// The linear solver doesn't converge.
    pub fn solve(&mut self, step: TimeStep, phases: &Phases, convected: &[Vector<D>]) -> Result<(), StepError> {
        self.equations.delta = step.delta();
        self.force = body_force(&self.mesh, &self.physics.gravity, step.end());
        self.fill(phases, convected);
        if let Some(immersed) = &self.immersed {
            immersed.constrain(&self.mesh, &self.boundary_mask, &mut self.constraints);
        }
        self.boundary.prescribe(&self.mesh, step.end(), &mut self.constraints);
        if let Some(solids) = &self.particle_solids {
            solids.prescribe(&self.mesh, step.end(), &self.boundary_mask, &mut self.constraints);
        }
        self.assemble(step, convected);
        self.start_from(convected);
        self.outcome = self.solve_linear()?.map_err(|failure| {
            let place = self.place(failure.worst_node);
            not_converged(place, &failure.history, failure.residual, &self.linear.options)
        })?;
        self.preconditioners += u64::from(self.outcome.rebuilt);
        self.unpack();
        self.recover();
        self.find_subscales(convected);
        self.project_subscales();
        Ok(())
    }

    /// Takes back what a solution changes that it starts from, to solve anew: the velocity [m/s] and the subscales
    /// of the last step. The pressure stays.
    pub(in crate::pfem2) fn restart(&mut self, velocity: &[Vector<D>], subscales: &Subscales<D>) {
        self.velocity.copy_from_slice(velocity);
        self.subscales.clone_from(subscales);
    }

    /// Puts in solids.
    pub(in crate::pfem2) fn immerse(&mut self, immersed: Immersed<D, N>) {
        self.linear.solver.expect_border();
        self.immersed = Some(immersed);
    }

    /// Prescribed unknowns of the boundary, without those of supports: bits as in [`Constraints::mask`].
    pub(in crate::pfem2) fn boundary_mask(&self) -> &[u8] {
        &self.boundary_mask
    }

    /// Particles with the columns that solids on particles ask for.
    pub(in crate::pfem2) fn with_columns(&self, mut particles: Particles<D>) -> Particles<D> {
        if let Some(solids) = &self.particle_solids {
            columns::add(&mut particles, solids.first);
        }
        particles
    }

    /// True for a component of a node that neither the boundary nor a support holds.
    pub(in crate::pfem2) fn is_free(&self, node: usize, axis: usize) -> bool {
        self.constraints.mask[node] >> axis & 1 == 0
    }

    /// The convected velocity v̂ of a step with that of nodes with a prescribed velocity [m/s] (theory (F.31)).
    pub fn imposed(&self, step: TimeStep, convected: &[Vector<D>]) -> Vec<Vector<D>> {
        let mut convected = convected.to_vec();
        if let Some(immersed) = &self.immersed {
            immersed.extend(|node| immersed.velocity_hat[node], &mut convected);
        }
        self.boundary.impose(&self.mesh, step, &mut convected);
        if let Some(solids) = &self.particle_solids {
            solids.impose(&self.mesh, step.end(), &self.boundary_mask, &mut convected);
        }
        convected
    }

    /// The equations of the last step.
    pub fn elements<'a>(&'a self, convected: &'a [Vector<D>]) -> ElementEquations<'a, D, N> {
        ElementEquations {
            mesh: &self.mesh,
            equations: self.equations,
            contents: &self.contents,
            cuts: &self.cuts,
            force: &self.force,
            convected,
            subscales: &self.subscales,
            open: &self.open,
            slip: &self.slip,
            immersed: self.immersed.as_ref(),
            particle_solids: self.particle_solids.as_ref(),
        }
    }

    /// The part of the mesh that the fluids fill.
    pub(in crate::pfem2) fn fluid_region(&self) -> FluidRegion<'_, D, N> {
        FluidRegion::new(&self.mesh, self.immersed.as_ref().map(|immersed| &immersed.cut))
    }

    /// Volume of the fluid in an element [m³].
    pub(in crate::pfem2) fn fluid_volume(&self, element: usize) -> f64 {
        self.fluid_region().volume(element)
    }

    /// True where one fluid fills the element.
    pub(in crate::pfem2) fn is_pure(&self, element: usize) -> bool {
        self.pure[element]
    }

    /// Shortest edge of an element [m].
    pub(in crate::pfem2) fn size(&self, element: usize) -> f64 {
        self.size[element]
    }

    /// Mass of a node: its share of what fills the elements around it [kg].
    pub(in crate::pfem2) fn nodal_mass(&self, node: usize) -> f64 {
        let around = self.mesh.elements_around(node).iter().map(|&e| e as usize);
        let own = |e: usize| {
            let corners = self.mesh.elements()[e].iter().zip(&self.contents[e].mass);
            corners.filter(|(i, _)| **i as usize == node).map(|(_, mass)| mass).sum::<f64>()
        };
        around.map(own).sum()
    }

    /// Energy of the interfaces, σ A [J].
    pub fn surface_energy(&self) -> f64 {
        let beside_solids = self.immersed.iter().flat_map(|immersed| &immersed.elements).map(|element| element.energy);
        self.cuts.iter().map(|cut| cut.energy).chain(beside_solids).sum()
    }

    /// True for nodes on the boundary of the mesh.
    pub(in crate::pfem2) fn is_on_boundary(&self, node: usize) -> bool {
        self.boundary_nodes[node]
    }

    /// The shortest edge of the mesh [m].
    pub fn shortest(&self) -> f64 {
        self.size.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// A node as the place of an error.
    pub fn place(&self, node: usize) -> Place {
        Place::Node { body: "mesh".into(), index: node, position: self.mesh.nodes()[node].to3() }
    }

    /// The first guess: convected velocity, last pressure, prescribed values.
    fn start_from(&mut self, convected: &[Vector<D>]) {
        for (i, x) in self.unknowns.iter_mut().enumerate() {
            x[..D].copy_from_slice(&self.constraints.into_frame(i, convected[i]).0);
            x[D] = self.pressure[i];
            let mask = self.constraints.mask[i];
            (0..N).filter(|r| mask >> r & 1 == 1).for_each(|r| x[r] = self.constraints.value[i][r]);
        }
    }

    /// Velocity and pressure from the unknowns, turned back to the axes.
    fn unpack(&mut self) {
        for (i, x) in self.unknowns.iter_mut().enumerate() {
            let v = self.constraints.out_of_frame(i, Vector::from_fn(|r| x[r]));
            self.velocity[i] = v;
            self.pressure[i] = x[D];
            x[..D].copy_from_slice(&v.0);
        }
        if let Some(immersed) = &self.immersed {
            immersed.extend(|node| immersed.velocity_of(node), &mut self.velocity);
        }
    }

    /// The condensed pressures of the cut elements.
    fn recover(&mut self) {
        let nodal =
            |cut: &CutElement<D, N>| self.mesh.elements()[cut.element as usize].map(|i| self.unknowns[i as usize]);
        let of = |cut: usize| self.cuts[cut].enriched.recover(&nodal(&self.cuts[cut]));
        self.recovered = parallel::collect(self.cuts.len(), 256, of);
        if let Some(solids) = &mut self.particle_solids {
            solids.recover(&self.mesh, &self.velocity, self.equations.delta);
        }
    }

    /// Projects on the nodes what the next step is stabilised against.
    fn project_subscales(&mut self) {
        let mut subscales = std::mem::take(&mut self.subscales);
        let Self { mesh, contents, velocity, immersed, .. } = &*self;
        let (pure, pressure) = (|e: usize| self.pure[e], |node: usize| self.pressure[node]);
        match self.physics.stabilisation {
            Stabilisation::Pspg => {}
            Stabilisation::ConsistentPspg | Stabilisation::Dynamic => {
                let flow = ViscousFlow { mesh, contents, velocity, immersed: immersed.as_ref() };
                subscales.projected = flow.accelerations(pure, |node| self.boundary_nodes[node]);
            }
            Stabilisation::Oss => {
                subscale::project(mesh, contents, pure, pressure, &self.force, &mut subscales.projected);
                subscales.average();
            }
        }
        self.subscales = subscales;
    }
}

/// True for nodes on the boundary of a mesh.
fn boundary_nodes<const D: usize, const N: usize>(mesh: &Mesh<D, N>) -> Vec<bool> {
    let mut on_boundary = vec![false; mesh.nodes().len()];
    mesh.boundary()
        .iter()
        .flat_map(|&facet| mesh.facet_nodes(facet))
        .for_each(|node| on_boundary[node as usize] = true);
    on_boundary
}

/// Body force at the nodes at time `t` [m/s²].
fn body_force<const D: usize, const N: usize>(mesh: &Mesh<D, N>, gravity: &[Signal; D], t: f64) -> Vec<Vector<D>> {
    if gravity.iter().all(Signal::is_uniform) {
        return vec![Vector::from_fn(|i| gravity[i].value([0.0; 3], t)); mesh.nodes().len()];
    }
    let at = |node: usize| Vector::from_fn(|i| gravity[i].value(mesh.nodes()[node].to3(), t));
    parallel::collect(mesh.nodes().len(), 256, at)
}
