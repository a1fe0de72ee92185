//! The monitors that a case asks for.

use super::{RunDirectory, unit_labels};
use crate::case::Case;
use crate::error::{Diagnostic, Error, Result};
use crate::output::{BalanceHistory, CountHistory, FieldPrecision, Fields, Forces, Picture, Probe};
use crate::simulation::{Monitor, Simulation, Snapshot};

/// Frames of a run, where the case doesn't say.
const FRAMES: f64 = 50.0;
/// Rows of a history, where the case doesn't say.
const ROWS: f64 = 500.0;

/// Lower and upper corner of the domain in pictures: the grid, or else the mesh.
fn domain(case: &Case, initial: &Snapshot<'_>) -> [[f64; 3]; 2] {
    if let Some(grid) = &case.file.grid {
        return [grid.lower, grid.upper];
    }
    let nodes = || initial.surfaces.iter().flat_map(|surface| surface.position.iter());
    let bound = |i: usize, start: f64, pick: fn(f64, f64) -> f64| nodes().map(|x| x[i]).fold(start, pick);
    [
        std::array::from_fn(|i| bound(i, f64::INFINITY, f64::min)),
        std::array::from_fn(|i| bound(i, f64::NEG_INFINITY, f64::max)),
    ]
}

/// Adds the balance, forces, counts, fields, probes and pictures of a case to its run.
///
/// # Errors
/// Probes and pictures of parts that the model doesn't have: all of them, with their places in the case.
pub fn add_monitors(simulation: &mut Simulation, case: &Case, directory: &RunDirectory) -> Result<()> {
    let (file, units, history) = (&case.file, unit_labels(case), directory.history());
    let rows = file.output.history.unwrap_or(file.time.end / ROWS);
    let frames = file.output.fields.unwrap_or(file.time.end / FRAMES);

    let mut monitors: Vec<Box<dyn Monitor>> = vec![
        Box::new(BalanceHistory::new(&history, rows, units)),
        Box::new(Forces::new(&history, rows, units)),
        Box::new(CountHistory::new(&history, rows, units)),
        Box::new(Fields::new(&directory.fields(), frames, FieldPrecision::default(), units)),
    ];
    let mut findings: Vec<Diagnostic> = Vec::new();
    let initial = simulation.solver().snapshot();
    for (n, spec) in file.probe.iter().enumerate() {
        match Probe::new(spec.clone(), &format!("probe[{n}]"), &initial, &history, rows, units) {
            Ok(probe) => monitors.push(Box::new(probe)),
            Err(finding) => findings.push(finding),
        }
    }
    for (n, spec) in file.picture.iter().enumerate() {
        let (key, domain) = (format!("picture[{n}]"), domain(case, &initial));
        match Picture::new(spec.clone(), &key, &initial, domain, &directory.pictures(), frames) {
            Ok(picture) => {
                let picture = case.obstacles().into_iter().fold(picture.with_units(units), Picture::with_obstacle);
                monitors.push(Box::new(picture));
            }
            Err(finding) => findings.push(finding),
        }
    }
    drop(initial);
    if !findings.is_empty() {
        case.locate(&mut findings);
        return Err(Error::Case(findings));
    }
    monitors.into_iter().for_each(|monitor| simulation.add_monitor(monitor));
    Ok(())
}
