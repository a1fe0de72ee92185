//! The error of a linear system that was not solved: its residuals, and advice.

use crate::error::{Place, StepError};
use crate::linalg::{NotConverged, SolverKind, SolverOptions};
use crate::mesh::Mesh;

/// Residuals at the start, four times on the way and at the end.
fn residuals(history: &[f64], last: f64) -> String {
    const SHOWN: usize = 5;
    let end = history.len().saturating_sub(1);
    let mut shown: Vec<usize> = (0..SHOWN).map(|k| end * k / SHOWN).collect();
    shown.dedup();
    let on_the_way = shown.iter().filter_map(|&k| history.get(k).map(|r| format!("{r:.1e} after {k}")));
    let way: Vec<String> = on_the_way.chain([format!("{last:.1e} after {end} iterations")]).collect();
    format!("residuals {}", way.join(", "))
}

/// The error of a solution whose residual stayed too large, with the residuals on the way.
pub(super) fn not_converged<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    failure: &NotConverged,
    options: &SolverOptions,
) -> StepError {
    let NotConverged { worst_node, residual, ref history, .. } = *failure;
    let last = match options.kind {
        SolverKind::Direct => "choose `pfem2.solver = \"iterative\"`",
        SolverKind::Auto => "choose `pfem2.solver = \"iterative\"`, or `\"direct\"`",
        SolverKind::Iterative => "choose `pfem2.solver = \"direct\"`",
    };
    let (most, usual) = (options.max_iterations, SolverOptions::default().max_iterations);
    let few = if most < usual {
        format!("raise `pfem2.solver.max-iterations` ({most}, by default {usual}), ")
    } else {
        String::new()
    };
    let residuals = residuals(history, residual);
    let advice = format!("{residuals}: {few}halve the step, look for flat or tiny elements there, or {last}");
    StepError::new(place(mesh, worst_node), "the linear solver did not converge", "relative residual", residual, advice)
}

/// A node as the place of an error.
pub(super) fn place<const D: usize, const N: usize>(mesh: &Mesh<D, N>, node: usize) -> Place {
    Place::Node { body: "mesh".into(), index: node, position: mesh.nodes()[node].to3() }
}
