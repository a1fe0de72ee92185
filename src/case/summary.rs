//! What a case amounts to: particles, nodes, memory, steps.

use super::CaseFile;
use crate::mpm::{EDGE, Setup};
use crate::simulation::Solver;
use std::collections::BTreeSet;

/// What a case amounts to.
#[derive(Debug, Clone, PartialEq)]
pub struct Summary {
    /// Bodies.
    pub bodies: Vec<BodySummary>,
    /// Membranes.
    pub membranes: Vec<MembraneSummary>,
    /// Cells of the whole domain.
    pub cells: f64,
    /// Grid nodes that are stored at the start, over all velocity fields.
    pub nodes: usize,
    /// Estimated memory at the start [bytes].
    pub memory: f64,
    /// First stable step [s].
    pub stable_step: f64,
    /// Number of steps if the step stays as it is; steps end at every output.
    pub steps: f64,
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

/// What is known before the solver is made: bodies, membranes, cells, nodes and bytes of the grid.
pub(super) struct Parts {
    bodies: Vec<BodySummary>,
    membranes: Vec<MembraneSummary>,
    cells: f64,
    nodes: usize,
    grid_bytes: f64,
}

pub(super) fn parts<const D: usize>(setup: &Setup<D>) -> Parts {
    let nodes = stored_nodes(setup);
    Parts {
        bodies: setup.bodies.iter().map(body_summary).collect(),
        membranes: setup.membranes.iter().map(membrane_summary).collect(),
        cells: setup.grid.cells.iter().map(|&n| f64::from(n)).product(),
        nodes,
        grid_bytes: (nodes * 8 * (1 + 2 * D)) as f64,
    }
}

fn body_summary<const D: usize>(body: &crate::mpm::BodySetup<D>) -> BodySummary {
    BodySummary { name: body.name.clone(), particles: body.position.len(), volume: body.volume.iter().sum() }
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

impl Summary {
    pub(super) fn new(solver: &mut dyn Solver, parts: Parts, file: &CaseFile) -> Self {
        let mut columns = 0;
        solver.columns(&mut |_, column| columns += column.data.bytes().len());
        let stable_step = solver.stable_dt();
        let (end, output) = (file.time.end, &file.output);
        let between_outputs = [output.fields, output.history].into_iter().flatten().fold(end, f64::min);
        let steps = end / between_outputs * (between_outputs / file.time.step.unwrap_or(stable_step)).ceil();
        Self {
            // Beside the stored columns a step needs about as much again for what it works with.
            memory: 2.0 * columns as f64 + parts.grid_bytes,
            bodies: parts.bodies,
            membranes: parts.membranes,
            cells: parts.cells,
            nodes: parts.nodes,
            stable_step,
            steps: steps.ceil(),
        }
    }

    /// Particles of all bodies.
    pub fn particles(&self) -> usize {
        self.bodies.iter().map(|b| b.particles).sum()
    }
}

impl std::fmt::Display for Summary {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for body in &self.bodies {
            writeln!(f, "body {}: {} particles", body.name, body.particles)?;
        }
        for membrane in &self.membranes {
            writeln!(f, "membrane {}: {} nodes, {} elements", membrane.name, membrane.nodes, membrane.elements)?;
        }
        writeln!(f, "grid: {} cells, {} nodes stored at the start", self.cells, self.nodes)?;
        writeln!(f, "memory: about {:.1} MB", self.memory / 1e6)?;
        writeln!(f, "first stable step: {:.4e} s", self.stable_step)?;
        write!(f, "steps: about {:.0}", self.steps)
    }
}
