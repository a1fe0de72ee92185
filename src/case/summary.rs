//! Size of a case: particles, nodes, memory, steps.

mod solid;

use super::resolution::PathResolution;
use super::{CaseFile, LinearKind};
use crate::linalg::Pattern;
use crate::math::Vector;
use crate::mpm::{EDGE, Setup};
use crate::parallel;
use crate::pfem2::solid::setup::SolidSetup;
use crate::pfem2::solid::structure::Structure;
use crate::pfem2::{self, boundary::Pin};
use crate::simulation::{LEAST_STEPS, Solver};
pub use solid::SolidSummary;
use solid::{factor_memory, solid_summaries};
use std::collections::BTreeSet;

/// Size of a case.
#[derive(Debug, Clone, PartialEq)]
pub struct CaseSummary {
    /// Bodies.
    pub bodies: Vec<BodySummary>,
    /// Membranes.
    pub membranes: Vec<MembraneSummary>,
    /// Solids in fluids.
    pub solids: Vec<SolidSummary>,
    /// Cells of the whole grid, or elements of the mesh.
    pub cells: f64,
    /// Grid nodes that are stored at the start, over all velocity fields; nodes of the mesh.
    pub nodes: usize,
    /// Unknowns of the implicit system; 0 without one.
    pub unknowns: usize,
    /// Lower and upper corner of the domain [m].
    pub domain: [[f64; 3]; 2],
    /// Choices that were made for the user, in sentences.
    pub notes: Vec<String>,
    /// Estimated memory at the start [bytes].
    pub memory: f64,
    /// First stable step [s].
    pub stable_step: f64,
    /// Number of steps if the step stays as it is, or the most that can be foreseen.
    pub steps: f64,
    /// The fewest steps that can be foreseen.
    pub fewest: f64,
    /// True if the number of steps can be foreseen.
    pub foreseen: bool,
    /// Sub-steps of the membranes in these steps; 0 without any.
    pub substeps: f64,
}

/// One body.
#[derive(Debug, Clone, PartialEq)]
pub struct BodySummary {
    /// Name.
    pub name: String,
    /// Particles.
    pub particles: usize,
    /// Volume [m³; m² in 2D].
    pub volume: f64,
}

/// One membrane.
#[derive(Debug, Clone, PartialEq)]
pub struct MembraneSummary {
    /// Name.
    pub name: String,
    /// Nodes.
    pub nodes: usize,
    /// Elements.
    pub elements: usize,
}

fn body_summary<const D: usize>(body: &crate::mpm::BodySetup<D>) -> BodySummary {
    let volume = parallel::sum(body.volume.len(), |p| body.volume[p]);
    BodySummary { name: body.name.clone(), particles: body.position.len(), volume }
}

fn membrane_summary<const D: usize>(membrane: &crate::mpm::MembraneSetup<D>) -> MembraneSummary {
    MembraneSummary { name: membrane.name.clone(), nodes: membrane.position.len(), elements: membrane.elements.len() }
}

/// Nodes of the blocks that hold a particle or a membrane node, in every velocity field.
fn stored_nodes<const D: usize>(setup: &Setup<D>) -> usize {
    let edge = EDGE as f64 * setup.grid.cell;
    let block = |x: &crate::math::Vector<D>| -> [i64; D] {
        std::array::from_fn(|i| ((x[i] - setup.grid.lower[i]) / edge).floor() as i64)
    };
    let places = setup.bodies.iter().flat_map(|b| &b.position);
    let places = places.chain(setup.membranes.iter().flat_map(|m| &m.position));
    let blocks: BTreeSet<[i64; D]> = places.map(block).collect();
    let groups: BTreeSet<usize> = setup.bodies.iter().map(|b| b.group).collect();
    blocks.len() * EDGE.pow(D as u32) * (groups.len() + setup.membranes.len()).max(1)
}

/// Memory that fields and checkpoints need while they are written, as measured as peaks of ten cases of both methods.
const OUTPUTS: f64 = 1.6;

/// Memory of a step of PFEM-2, in stored columns: sorting and solving take about as much again.
const FLOW: f64 = 2.0;

/// Memory of a step of MPM, in stored columns.
const POINTS: f64 = 1.25;

/// The program, and the fonts of plots [bytes].
const PLOTS: f64 = 6e7;

/// Canvas and depths of pictures [bytes].
const PICTURES: f64 = 4.5e7;

/// Numbers of the factor of a matrix of n blocks, in 2D and 3D: n log n and n^(4/3), as measured.
fn factor_numbers(nodes: f64, dimension: usize) -> f64 {
    if dimension == 2 { 9.0 * 3.1 * nodes * nodes.log2() } else { 16.0 * 7.0 * nodes.powf(4.0 / 3.0) }
}

/// Says where the pressure of a closed box is held.
fn pin_note<const D: usize, const N: usize>(setup: &pfem2::Setup<D, N>) -> Option<String> {
    if setup.boundaries.iter().any(|set| set.condition.kind().has_free_flux()) {
        return None;
    }
    // Without the noise of the last digits, and without the sign of zero.
    let shown = |c: f64| ((1e9 * c).round() / 1e9 + 0.0).to_string();
    let place = |pin: Pin| setup.mesh.nodes()[pin.node as usize].0.map(shown).join(", ");
    let text = match &setup.pin {
        Some(pin) => {
            let asked = pin.at.0.map(|c| c.to_string()).join(", ");
            format!("held at the node nearest to ({asked}), which is at ({})", place(pin.held(&setup.mesh)))
        }
        None => {
            let gravity = Vector::from_fn(|i| setup.gravity[i].value([0.0; 3], 0.0));
            format!("zero at the highest node of the boundary, ({})", place(Pin::highest(&setup.mesh, gravity)))
        }
    };
    let is_elastic = |solid: &SolidSetup<D>| !solid.law.is_rigid();
    let solids = setup.solids.as_ref().map_or(0.0, Structure::largest_density);
    let heaviest = setup.fluids.iter().map(|fluid| fluid.density).fold(solids, f64::max);
    let gas = setup.fluids.iter().filter(|fluid| pfem2::is_gas(fluid.density, heaviest));
    let gas = gas.min_by(|a, b| a.density.total_cmp(&b.density));
    let room = match (&setup.solids, gas) {
        (Some(solids), gas) if solids.setups().iter().any(is_elastic) => match gas {
            Some(gas) => format!("; {} expands as elastic solids are compressed", gas.name),
            None => "; fluid comes in there as elastic solids are compressed".into(),
        },
        _ => String::new(),
    };
    Some(format!("pressure: {text}, since no part of the boundary is open{room}"))
}

impl CaseSummary {
    /// Size of the bodies, membranes and grid before the solver is made.
    pub(super) fn of_points<const D: usize>(setup: &Setup<D>, domain: [[f64; 3]; 2]) -> Self {
        let nodes = stored_nodes(setup);
        Self {
            bodies: setup.bodies.iter().map(body_summary).collect(),
            membranes: setup.membranes.iter().map(membrane_summary).collect(),
            solids: Vec::new(),
            cells: setup.grid.cells.iter().map(|&n| f64::from(n)).product(),
            nodes,
            unknowns: 0,
            domain,
            notes: Vec::new(),
            memory: (nodes * 8 * (1 + 2 * D)) as f64,
            stable_step: 0.0,
            steps: 0.0,
            fewest: 0.0,
            foreseen: true,
            substeps: 0.0,
        }
    }

    /// Size of the fluids and the mesh before the solver is made.
    pub(super) fn of_flow<const D: usize, const N: usize>(
        setup: &pfem2::Setup<D, N>,
        file: &CaseFile,
        paths: &[Option<PathResolution>],
    ) -> Self {
        let mesh = &setup.mesh;
        let nodes = mesh.nodes().len();
        let solids = solid_summaries(setup, paths);
        let axis = |i: usize| mesh.nodes().iter().map(move |x| x.to3()[i]);
        let lower = std::array::from_fn(|i| axis(i).fold(f64::INFINITY, f64::min));
        let upper = std::array::from_fn(|i| axis(i).fold(f64::NEG_INFINITY, f64::max));
        let matrix = (Pattern::new(nodes, mesh.elements()).entries() * N * N * 8) as f64;
        let direct =
            file.pfem2.solver.choices().kind == LinearKind::Direct || (D == 2 && nodes < 400_000) || nodes < 6_000;
        let solver = if direct { 4.0 * factor_numbers(nodes as f64, D) } else { 60.0 * 8.0 * (nodes * N) as f64 };
        Self {
            bodies: bodies_of_flow(setup),
            membranes: Vec::new(),
            solids,
            cells: mesh.elements().len() as f64,
            nodes,
            unknowns: nodes * N,
            domain: [lower, upper],
            notes: pin_note(setup).into_iter().collect(),
            memory: 2.0 * matrix
                + solver
                + factor_memory(setup.solid_setups())
                + (mesh.elements().len() * N * (D + 8) * 8) as f64,
            stable_step: 0.0,
            steps: 0.0,
            fewest: 0.0,
            foreseen: true,
            substeps: 0.0,
        }
    }

    /// Adds the numbers that the solver gives: columns, first step.
    pub(super) fn with_solver(self, solver: &mut dyn Solver, file: &CaseFile) -> Self {
        let mut columns = 0;
        solver.columns(&mut |_, column| columns += column.data.bytes().len());
        let fixed = file.time.step.is_some();
        let stable_step = if fixed { solver.stable_dt() } else { solver.recommended_dt() };
        let end = file.time.end;
        let least = if fixed { 1.0 } else { LEAST_STEPS };
        let count = |step: f64| (end / step).ceil().max(least);
        let foreseen = if fixed { file.time.step.map(|step| [step; 2]) } else { solver.foreseen_dt(end) };
        let [steps, fewest] = foreseen.unwrap_or([f64::INFINITY; 2]).map(count);
        let own = self.memory + if self.unknowns > 0 { FLOW } else { POINTS } * columns as f64;
        let drawing = PLOTS + if file.picture.is_empty() { 0.0 } else { PICTURES };
        let substeps = if steps > 0.0 { steps * solver.substeps(end / steps) as f64 } else { 0.0 };
        let memory = OUTPUTS * own + drawing;
        Self { memory, stable_step, steps, fewest, foreseen: foreseen.is_some(), substeps, ..self }
    }

    /// Particles of all bodies.
    pub fn particles(&self) -> usize {
        self.bodies.iter().map(|b| b.particles).sum()
    }

    /// Elements of all membranes.
    pub fn elements(&self) -> usize {
        self.membranes.iter().map(|membrane| membrane.elements).sum()
    }

    /// Sub-steps of the membranes, and the work of all steps in particles and elements moved.
    fn write_work(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let count = |number: f64| if number < 1e6 { format!("{number:.0}") } else { format!("{number:.2e}") };
        let particle_steps = count(self.steps * self.particles() as f64);
        if self.substeps == 0.0 {
            return write!(f, "\nwork: about {particle_steps} particle-steps");
        }
        let (substeps, in_a_step) = (count(self.substeps), self.substeps / self.steps);
        write!(f, "\nsub-steps of membranes: about {substeps}, {in_a_step:.0} in a step")?;
        let element_steps = count(self.substeps * self.elements() as f64);
        write!(f, "\nwork: about {particle_steps} particle-steps and {element_steps} element-steps")
    }
}

impl std::fmt::Display for CaseSummary {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for body in &self.bodies {
            writeln!(f, "body {}: {} particles", body.name, body.particles)?;
        }
        for solid in &self.solids {
            writeln!(f, "{solid}")?;
        }
        for membrane in &self.membranes {
            writeln!(f, "membrane {}: {} nodes, {} elements", membrane.name, membrane.nodes, membrane.elements)?;
        }
        if self.unknowns > 0 {
            writeln!(f, "mesh: {} elements, {} nodes, {} unknowns", self.cells, self.nodes, self.unknowns)?;
        } else {
            writeln!(f, "grid: {} cells, {} nodes stored at the start", self.cells, self.nodes)?;
        }
        for note in &self.notes {
            writeln!(f, "{note}")?;
        }
        writeln!(f, "memory: about {:.1} MB", self.memory / 1e6)?;
        if self.stable_step.is_finite() {
            writeln!(f, "first stable step: {:.4e} s", self.stable_step)?;
        } else {
            writeln!(f, "first stable step: nothing bounds it")?;
        }
        match self.fewest {
            _ if !self.foreseen => write!(
                f,
                "steps: can't be foreseen, since nothing says how fast the flow will be; {:.0} at least",
                self.steps
            ),
            fewest if fewest < self.steps => {
                write!(f, "steps: about {fewest:.0} to {:.0}, as the flow and its waves ask for", self.steps)
            }
            _ => write!(f, "steps: about {:.0}", self.steps),
        }?;
        if self.foreseen && self.unknowns == 0 { self.write_work(f) } else { Ok(()) }
    }
}

/// Particles and volume of each phase.
fn bodies_of_flow<const D: usize, const N: usize>(setup: &pfem2::Setup<D, N>) -> Vec<BodySummary> {
    let (mesh, particles) = (&setup.mesh, &setup.particles);
    let is_of = |p: usize, phase: usize| usize::from(particles.phase[p]) == phase;
    let count = |phase: usize| parallel::count(particles.len(), |p| is_of(p, phase));
    // Elements that a solid cuts have fewer particles, not larger ones.
    let full = parallel::max(mesh.elements().len(), |e| particles.of(e).len() as f64).max(1.0);
    let is_cut = setup.solids.is_some();
    let within = |e: usize| if is_cut { full } else { particles.of(e).len().max(1) as f64 };
    let particle_volume = |e: usize| mesh.simplex(e).volume / within(e);
    let own =
        |p: usize, phase: usize| if is_of(p, phase) { particle_volume(particles.element[p] as usize) } else { 0.0 };
    let volume = |phase: usize| parallel::sum(particles.len(), |p| own(p, phase));
    let fluids = setup.fluids.iter().map(|fluid| &fluid.name);
    let names = fluids.chain(setup.particle_solids.iter().map(|solid| &solid.name));
    names
        .enumerate()
        .map(|(phase, name)| BodySummary { name: name.clone(), particles: count(phase), volume: volume(phase) })
        .collect()
}
