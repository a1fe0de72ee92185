//! The mesh stage of a step: from convected velocities and phases to velocity and pressure at the nodes (theory F.6).
//!
//! ```text
//! M (v − v̂)/Δ + K v − Dᵀ p = M b + t̄ + surface tension,     D v + C p = τ V g·s,     Δ = θ Δt
//! ```
//!
//! v and p belong to the end of the step, where the particles are; with θ < 1 the particles have already received
//! the weight 1 − θ of the last acceleration (see `step/mod.rs`).

use super::assemble::ElementEquations;
use super::contents::ElementContents;
use super::convergence;
use super::linear_system::LinearSystem;
use super::mesh_data::MeshData;
pub use super::physics::Physics;
use super::prescribed::PrescribedUnknowns;
use super::subscale::Subscales;
use crate::error::{Place, StepError};
use crate::linalg::{BlockMatrix, SolverOptions, SolverState};
use crate::math::{Signal, Vector};
use crate::mesh::Mesh;
use crate::parallel;
use crate::pfem2::ThetaStep;
use crate::pfem2::boundary::Boundary;
use crate::pfem2::element::Equations;
use crate::pfem2::particle_solids::columns;
use crate::pfem2::particle_solids::setup::ParticleSolidSetup;
use crate::pfem2::particle_solids::solids::ParticleSolids;
use crate::pfem2::particles::Particles;
use crate::pfem2::phases::FluidRegion;
use crate::pfem2::phases::{Filling, Phases};
use crate::pfem2::solid::coupling::dilatation::GasDilatation;
use crate::pfem2::solid::coupling::immersed::Immersed;
use crate::pfem2::solid::cut::ElementState;

/// Velocity and pressure on the mesh.
pub struct VelocityPressureSystem<const D: usize, const N: usize> {
    /// The mesh.
    pub mesh: Mesh<D, N>,
    /// Conditions on its boundary.
    pub boundary: Boundary<D>,
    /// Sizes and boundary facets of the elements.
    pub(super) mesh_data: MeshData,
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
    /// Constants of the last step.
    pub(in crate::pfem2) equations: Equations,
    /// Contents of the elements in the last step.
    pub contents: ElementContents<D, N>,
    /// Unknowns that the boundary and solids prescribe.
    pub(super) prescribed: PrescribedUnknowns<D, N>,
    /// Matrix, right-hand side, solver and solution.
    pub(in crate::pfem2) linear: LinearSystem<N>,
    /// Solids in the mesh.
    pub immersed: Option<Immersed<D, N>>,
    /// Solids on particles.
    pub particle_solids: Option<ParticleSolids<D, N>>,
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
        let (nodes, elements) = (mesh.nodes().len(), mesh.elements().len());
        let density = physics.fluids.iter().map(|fluid| fluid.density).collect();
        Self {
            mesh_data: MeshData::new(&mesh, &boundary),
            pressure: vec![0.0; nodes],
            subscales: Subscales::at_rest(&mesh, physics.stabilisation),
            force: body_force(&mesh, &physics.gravity, 0.0),
            equations: Equations { delta: 1.0, mass: physics.mass, stabilisation: physics.stabilisation },
            contents: ElementContents::new(elements, density),
            prescribed: PrescribedUnknowns::new(&boundary, nodes),
            linear: LinearSystem::new(&mesh, options),
            immersed: None,
            particle_solids: None,
            mesh,
            boundary,
            physics,
            velocity,
        }
    }

    /// The system with solids on particles, whose phases follow those of the fluids.
    pub fn with_particle_solids(mut self, setups: Vec<ParticleSolidSetup<D>>) -> Self {
        if setups.is_empty() {
            return self;
        }
        self.contents.add_phases(setups.iter().map(|solid| solid.law.density));
        let first = self.physics.fluids.len();
        let solids = ParticleSolids::new(setups, first, self.contents.density[0]);
        solids.hold(&mut self.prescribed.constraints);
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
    pub fn solve(&mut self, step: ThetaStep, phases: &Phases, convected: &[Vector<D>]) -> Result<(), StepError> {
        self.equations.delta = step.delta();
        self.force = body_force(&self.mesh, &self.physics.gravity, step.end());
        self.fill(phases, convected);
        let (immersed, particle_solids) = (self.immersed.as_ref(), self.particle_solids.as_ref());
        self.prescribed.update(&self.mesh, step.end(), &self.boundary, immersed, particle_solids);
        self.load_openings_beside_solids(step.end());
        self.assemble(step, convected);
        self.start_from(convected);
        let dilatation = self.dilatation(phases);
        self.linear.solve(&self.mesh, self.immersed.as_mut(), &self.prescribed.constraints, dilatation)?;
        self.unpack();
        self.recover();
        self.find_subscales(convected);
        self.project_subscales();
        Ok(())
    }

    /// The gas that gives way to elastic solids where nothing opens the box.
    fn dilatation(&self, phases: &Phases) -> Option<GasDilatation> {
        let (immersed, pin) = (self.immersed.as_ref()?, self.boundary.pin.as_ref()?);
        let heaviest = self.physics.fluids.iter().map(|fluid| fluid.density).fold(immersed.density, f64::max);
        let fluids =
            parallel::collect(self.mesh.elements().len(), 256, |e| match phases.filling(&self.mesh.elements()[e]) {
                Filling::Pure(fluid) if immersed.cut.state[e] == ElementState::Fluid => Some(fluid),
                _ => None,
            });
        GasDilatation::of_gas(&self.mesh, &fluids, &self.contents.density, heaviest, pin.node)
    }

    /// Fills matrix and right-hand side.
    fn assemble(&mut self, step: ThetaStep, convected: &[Vector<D>]) {
        let mut rhs = std::mem::take(&mut self.linear.rhs);
        rhs.fill([0.0; N]);
        let add = |node: usize, force: Vector<D>| (0..D).for_each(|r| rhs[node][r] += force[r]);
        self.boundary.load(&self.mesh, step.end(), |element| self.is_whole(element), add);
        let empty = BlockMatrix { pattern: self.linear.assembly.pattern(), values: Vec::new() };
        let mut matrix = std::mem::replace(&mut self.linear.matrix, empty);
        let elements = self.elements(convected);
        self.linear.assembly.assemble(&elements, &self.prescribed.constraints, &mut matrix, &mut rhs);
        (self.linear.matrix, self.linear.rhs) = (matrix, rhs);
    }

    /// Takes back what a solution changes that it starts from, to solve anew: the velocity [m/s] and the subscales
    /// of the last step. The pressure stays.
    pub(in crate::pfem2) fn restart(&mut self, velocity: &[Vector<D>], subscales: &Subscales<D>) {
        self.velocity.copy_from_slice(velocity);
        self.subscales.clone_from(subscales);
    }

    /// Puts in solids.
    pub(in crate::pfem2) fn immerse(&mut self, immersed: Immersed<D, N>) {
        self.linear.expect_border();
        self.immersed = Some(immersed);
    }

    /// Prescribed unknowns of the boundary, without those of supports: bits as in
    /// [`PrescribedUnknowns::boundary_mask`].
    pub(in crate::pfem2) fn boundary_mask(&self) -> &[u8] {
        &self.prescribed.boundary_mask
    }

    /// Goes on from the state that the linear solver had in another run of the same case.
    pub(in crate::pfem2) fn restore_solver(&mut self, state: &SolverState) {
        self.linear.restore(&self.mesh, state, self.immersed.is_some());
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
        self.prescribed.is_free(node, axis)
    }

    /// The velocity of the nodes where walls and inlets take hold of theirs at time `t` [s] [m/s].
    pub(in crate::pfem2) fn held_velocity(&self, t: f64) -> Vec<Vector<D>> {
        let mut velocity = self.velocity.clone();
        self.boundary.held(&self.mesh, t).into_iter().for_each(|(node, held)| velocity[node] = held);
        velocity
    }

    /// The convected velocity v̂ of a step with that of nodes with a prescribed velocity [m/s] (theory (F.31)).
    pub fn imposed(&self, step: ThetaStep, convected: &[Vector<D>]) -> Vec<Vector<D>> {
        let mut convected = convected.to_vec();
        if let Some(immersed) = &self.immersed {
            immersed.extend(|node| immersed.velocity_hat[node], &mut convected);
        }
        self.boundary.impose(&self.mesh, step, &mut convected);
        if let Some(solids) = &self.particle_solids {
            solids.impose(&self.mesh, step.end(), &self.prescribed.boundary_mask, &mut convected);
        }
        convected
    }

    /// The equations of the last step.
    pub fn elements<'a>(&'a self, convected: &'a [Vector<D>]) -> ElementEquations<'a, D, N> {
        ElementEquations {
            mesh: &self.mesh,
            equations: self.equations,
            mesh_data: &self.mesh_data,
            contents: &self.contents,
            force: &self.force,
            convected,
            subscales: &self.subscales,
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
        self.contents.pure[element]
    }

    /// Shortest edge of an element [m].
    pub(in crate::pfem2) fn size(&self, element: usize) -> f64 {
        self.mesh_data.size[element]
    }

    /// Mass of a node: its part of what fills the elements around it [kg].
    pub(in crate::pfem2) fn nodal_mass(&self, node: usize) -> f64 {
        self.contents.nodal_mass(&self.mesh, node)
    }

    /// Energy of the interfaces, σ A [J].
    pub fn surface_energy(&self) -> f64 {
        let cuts = &self.contents.cuts;
        let beside_solids = self.immersed.as_ref().map_or(&[][..], |immersed| &immersed.elements);
        parallel::sum(cuts.len(), |n| cuts[n].energy) + parallel::sum(beside_solids.len(), |n| beside_solids[n].energy)
    }

    /// True for nodes on the boundary of the mesh.
    pub(in crate::pfem2) fn is_on_boundary(&self, node: usize) -> bool {
        self.mesh_data.on_boundary[node]
    }

    /// The shortest edge of the mesh [m].
    pub fn shortest(&self) -> f64 {
        self.mesh_data.shortest()
    }

    /// A node as the place of an error.
    pub fn place(&self, node: usize) -> Place {
        convergence::place(&self.mesh, node)
    }

    /// The first guess: convected velocity, last pressure, prescribed values.
    fn start_from(&mut self, convected: &[Vector<D>]) {
        for (i, x) in self.linear.unknowns.iter_mut().enumerate() {
            *x = self.prescribed.unknowns(i, convected[i], self.pressure[i]);
        }
    }

    /// Velocity and pressure from the unknowns, turned back to the axes.
    fn unpack(&mut self) {
        for (i, x) in self.linear.unknowns.iter_mut().enumerate() {
            let v = self.prescribed.constraints.out_of_frame(i, Vector::from_fn(|r| x[r]));
            self.velocity[i] = v;
            self.pressure[i] = x[D];
            x[..D].copy_from_slice(&v.0);
        }
        if let Some(immersed) = &self.immersed {
            immersed.extend(|node| immersed.velocity_of(node), &mut self.velocity);
            immersed.show_pressure_of_sides(&self.mesh, &self.prescribed.constraints, &mut self.pressure);
        }
    }

    /// The condensed pressures of the cut elements, and of those that hold solids on particles.
    fn recover(&mut self) {
        self.contents.recover(&self.mesh, &self.linear.unknowns);
        if let Some(solids) = &mut self.particle_solids {
            solids.recover(&self.mesh, &self.velocity, self.equations.delta);
        }
    }
}

/// Body force at the nodes at time `t` [m/s²].
fn body_force<const D: usize, const N: usize>(mesh: &Mesh<D, N>, gravity: &[Signal; D], t: f64) -> Vec<Vector<D>> {
    if gravity.iter().all(Signal::is_uniform) {
        return vec![Vector::from_fn(|i| gravity[i].value([0.0; 3], t)); mesh.nodes().len()];
    }
    let at = |node: usize| Vector::from_fn(|i| gravity[i].value(mesh.nodes()[node].to3(), t));
    parallel::collect(mesh.nodes().len(), 256, at)
}
