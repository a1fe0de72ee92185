//! PFEM-2: mesh, conditions on its boundary, fluids and their particles.

mod at_boundary;
mod boundary;
mod closed_off;
mod enclosed;
mod filling;
mod fluids;
mod holding;
mod layers;
mod loads;
mod mesh;
mod particle_solids;
mod path;
mod prestress;
mod solids;
mod through;

use path::SolidSurroundings;
use prestress::incompressible;
use solids::{MODES, natural_periods};

use super::signals::TrialPoints;
use super::{Construction, Model, guarded, has_errors};
use crate::case::summary::CaseSummary;
use crate::case::{Case, CaseFile, check, names};
use crate::error::Diagnostic;
use crate::math::{Signal, Vector};
use crate::mesh::domain::DomainMesh;
use crate::mesh::{Locator, Mesh};
use crate::pfem2::boundary::{BoundarySetup, PressurePin};
use crate::pfem2::fluid::FluidSetup;
use crate::pfem2::interface::level_set::LevelSet;
use crate::pfem2::particle_solids::setup::ParticleSolidSetup;
use crate::pfem2::particles::Particles;
use crate::pfem2::solid::structure::Structure;
use crate::pfem2::{MomentPoint, Pfem2, Setup};
use crate::simulation::Solver;
use fluids::{InitialBody, sharp, velocity_at};
use solids::{InitialSolid, solid_at};

/// Makes the mesh of a case in its dimension.
pub(super) type MakeMesh<const D: usize, const N: usize> =
    fn(&crate::mesh::domain::DomainMesh, &std::path::Path) -> Result<Mesh<D, N>, Diagnostic>;

impl Case {
    /// The solver of PFEM-2, or everything that is wrong.
    pub(super) fn pfem2<const D: usize, const N: usize>(&self, make: MakeMesh<D, N>) -> Result<Model, Vec<Diagnostic>> {
        let mut assembly = Construction::new(self);
        let setup = assembly.pfem2_setup(make);
        let Construction { mut findings, formulas, notes, paths, .. } = assembly;
        names::parts(&self.file, &mut findings);
        let Some(setup) = setup.filter(|_| !has_errors(&findings)) else { return Err(findings) };
        check::plausible::of_flow(self, &setup, &mut findings);
        let summary = CaseSummary::of_flow(&setup, &self.file, &paths);
        check::solids::of_flow(self, &setup, &summary.solids, &mut findings);
        check::solids::rest(self, &setup, &mut findings);
        let mut solver = Pfem2::new(setup);
        let mut summary = summary.with_solver(&mut solver, &self.file);
        summary.notes.extend(self.file.mesh.iter().filter_map(DomainMesh::adjusted));
        summary.notes.extend(notes);
        summary.notes.extend(incompressible(&self.file));
        check::steps(self, &summary, &mut findings);
        check::memory(&summary, &mut findings);
        names::files(&self.file, &solver.snapshot(), &mut findings);
        let notes = check::probes(&self.file, &solver.snapshot(), summary.domain, &mut findings);
        summary.notes.extend(notes);
        check::pictures(&self.file, &solver.snapshot(), summary.domain, &mut findings);
        if has_errors(&findings) {
            return Err(findings);
        }
        self.locate(&mut findings);
        Ok(Model { solver: guarded(solver, formulas), summary, warnings: findings })
    }
}

/// The bodies of a case as the solver takes them.
struct FlowBodies<const D: usize> {
    fluids: Vec<FluidSetup>,
    /// Fluids and solids on particles at the start.
    initial: Vec<InitialBody>,
    particle_solids: Vec<ParticleSolidSetup<D>>,
    solids: Vec<InitialSolid<D>>,
}

/// Mesh, conditions and bodies of a flow, as a case describes them.
struct DescribedFlow<const D: usize, const N: usize> {
    mesh: Mesh<D, N>,
    boundaries: Vec<BoundarySetup<D>>,
    pin: Option<PressurePin<D>>,
    moments: Vec<MomentPoint<D>>,
    /// Surface tensions between pairs of fluids [N/m].
    tension: Vec<([usize; 2], f64)>,
    gravity: [Signal; 3],
    bodies: FlowBodies<D>,
}

/// The state that a flow starts with.
struct FlowStart<const D: usize> {
    particles: Particles<D>,
    level_set: Option<LevelSet>,
    /// Velocity at the nodes [m/s].
    velocity: Vec<Vector<D>>,
}

impl Construction<'_> {
    /// Notes the longest periods of elastic solids, lets fluids glide where their layers aren't resolved, and foresees
    /// where solids come to.
    fn foresee<const D: usize, const N: usize>(
        &mut self,
        structure: &mut Structure<D>,
        around: &SolidSurroundings<D, N>,
    ) {
        let modes = structure.natural_modes(MODES);
        self.notes.extend(natural_periods(structure.setups(), &modes));
        self.notes.extend(layers::choose(structure, &modes.found, around));
        self.paths = path::of_solids(structure, &modes.found, around);
    }

    /// The fluids and the solids of the case.
    fn bodies<const D: usize, const N: usize>(&mut self, mesh: &Mesh<D, N>) -> FlowBodies<D> {
        let file = &self.case.file;
        let (flowing, solid, on_particles) = (file.fluids(), file.solids(), file.particle_solids());
        let fluids: Vec<FluidSetup> = flowing.iter().filter_map(|&i| self.fluid(i)).collect();
        // Solids come before fluids where regions overlap; their phases come after those of the fluids.
        let phases = (flowing.len()..).zip(&on_particles).chain(flowing.iter().enumerate());
        let initial: Vec<InitialBody> = phases.filter_map(|(phase, &i)| self.initial_body(i, phase, mesh)).collect();
        let particle_solids = self.particle_solids(&on_particles, &initial, mesh);
        let solids: Vec<InitialSolid<D>> = solid.iter().filter_map(|&i| self.solid(i, mesh)).collect();
        if flowing.is_empty() {
            let what = if file.body.is_empty() { "body" } else { "fluid" };
            let finding = Diagnostic::error("", format!("there is no {what}: nothing fills the mesh"));
            self.findings.push(finding.help("add a `[[body]]` with the region of a fluid"));
        }
        FlowBodies { fluids, initial, particle_solids, solids }
    }

    /// Looks for what is likely to be a mistake: leaks, pieces without an opening, what falls out, empty elements.
    fn check_flow<const D: usize, const N: usize>(
        &mut self,
        mesh: &Mesh<D, N>,
        boundaries: &[BoundarySetup<D>],
        gravity: &[Signal],
        bodies: &FlowBodies<D>,
    ) {
        self.pieces(mesh, boundaries);
        self.through_walls(mesh, boundaries);
        self.through_flow(mesh, boundaries);
        self.falling_out(mesh, boundaries, gravity, bodies.fluids[0].density);
        self.left_over(mesh, boundaries);
        self.nearly_flat(mesh);
        self.closed_off(mesh, boundaries, &bodies.solids);
        self.unfilled(mesh, &bodies.initial, &bodies.solids);
    }

    /// The set-up of `pfem2` that the case describes; `None` if something is wrong.
    fn pfem2_setup<const D: usize, const N: usize>(&mut self, make: MakeMesh<D, N>) -> Option<Setup<D, N>> {
        let mut flow = self.describe_flow(make)?;
        let start = self.flow_start(&flow)?;
        let solids = std::mem::take(&mut flow.bodies.solids);
        let structure = self.structure(solids.into_iter().map(|solid| solid.setup).collect())?;
        let structure = structure.map(|structure| self.surrounded(structure, &flow));
        Some(setup_of(&self.case.file, flow, start, structure))
    }

    /// The flow as the case describes it; `None` if something is wrong.
    fn describe_flow<const D: usize, const N: usize>(&mut self, make: MakeMesh<D, N>) -> Option<DescribedFlow<D, N>> {
        let file = &self.case.file;
        let mesh = self.mesh(make)?;
        let samples = TrialPoints::over(mesh.nodes(), file.time.end);
        let gravity = self.signals("pfem2.gravity", &file.pfem2.gravity, &samples);
        let boundaries = self.boundaries(&mesh);
        let pin = self.pin(&mesh, &boundaries);
        let moments = self.moments(&boundaries);
        let tension = self.tensions();
        let bodies = self.bodies(&mesh);
        self.several_fluids(&boundaries);
        self.overlaps(&bodies.solids);
        if has_errors(&self.findings) {
            return None;
        }
        self.check_flow(&mesh, &boundaries, &gravity, &bodies);
        Some(DescribedFlow { mesh, boundaries, pin, moments, tension, gravity, bodies })
    }

    /// Particles, interface and velocity at the start; `None` if something is wrong.
    fn flow_start<const D: usize, const N: usize>(&mut self, flow: &DescribedFlow<D, N>) -> Option<FlowStart<D>> {
        let DescribedFlow { mesh, bodies: FlowBodies { fluids, initial, solids, .. }, .. } = flow;
        let mut particles = self.seed(mesh, initial, solids)?;
        let level_set = sharp(&self.case.file.pfem2, mesh, fluids, initial, &mut particles);
        let start =
            |x: Vector<D>| solid_at(solids, x).map_or_else(|| velocity_at(initial, x), |solid| solid.velocity(x));
        let velocity = mesh.nodes().iter().map(|&x| start(x)).collect();
        Some(FlowStart { particles, level_set, velocity })
    }

    /// Solids, looked at in the flow around them.
    fn surrounded<const D: usize, const N: usize>(
        &mut self,
        mut structure: Structure<D>,
        DescribedFlow { mesh, boundaries, gravity, bodies, .. }: &DescribedFlow<D, N>,
    ) -> Structure<D> {
        let (file, locator) = (&self.case.file, Locator::new(mesh));
        let (fluids, bodies) = (&bodies.fluids, &bodies.initial);
        let around = SolidSurroundings { file, mesh, locator, boundaries, fluids, bodies, gravity };
        self.solids_at_boundary(&structure, &around);
        self.foresee(&mut structure, &around);
        structure
    }
}

/// The set-up of a flow, with the choices of the case for the method.
fn setup_of<const D: usize, const N: usize>(
    file: &CaseFile,
    flow: DescribedFlow<D, N>,
    start: FlowStart<D>,
    solids: Option<Structure<D>>,
) -> Setup<D, N> {
    let DescribedFlow { mesh, boundaries, pin, moments, tension, gravity, bodies } = flow;
    let FlowStart { particles, level_set, velocity } = start;
    let spec = &file.pfem2;
    Setup {
        mesh,
        boundaries,
        pin,
        fluids: bodies.fluids,
        solids,
        particle_solids: bodies.particle_solids,
        moments,
        tension,
        gravity: std::array::from_fn(|axis| gravity[axis].clone()),
        particles,
        level_set,
        velocity,
        volume: spec.volume.into(),
        scheme: (&spec.scheme).into(),
        stabilisation: spec.stabilisation.into(),
        mass: spec.mass.into(),
        enrichment: spec.enrichment.into(),
        kernel: spec.kernel.into(),
        reseeding: spec.reseeding.into(),
        projectile_ratio: spec.projectile_ratio,
        relaxation: spec.relaxation,
        unresolved: spec.unresolved.into(),
        courant: if file.time.step.is_some() { f64::INFINITY } else { spec.courant },
        step_tolerance: if file.time.step.is_some() { f64::INFINITY } else { spec.step_tolerance },
        start: spec.start.into(),
        linear: spec.solver.choices().options(),
    }
}
