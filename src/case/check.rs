//! Checks of the parts of a case against each other.

use super::summary::Summary;
use super::{Case, CaseFile, Method};
use crate::error::Diagnostic;
use crate::math::Vector;
use crate::mpm::Setup;
use crate::output::{Picture, Probe, UnitLabels};
use crate::simulation::Snapshot;
use std::path::Path;

/// An element of a membrane may be this many cells long: the contact samples it at most every half cell.
const LONGEST_ELEMENT: f64 = 32.0;

/// Checks bodies, membranes and contacts.
pub(super) fn parts<const D: usize>(case: &Case, setup: &Setup<D>, findings: &mut Vec<Diagnostic>) {
    names(&case.file, findings);
    contacts(&case.file, findings);
    inside(setup, findings);
    overlaps(case, setup, findings);
    coarse(setup, findings);
    if setup.bodies.is_empty() && setup.membranes.is_empty() {
        let finding = Diagnostic::error("", "there is neither a body nor a membrane: nothing would move");
        findings.push(finding.help("add a `[[body]]`"));
    }
}

/// All named parts with the key of their name.
fn named(file: &CaseFile) -> Vec<(String, &str)> {
    let bodies = file.body.iter().enumerate().map(|(i, b)| (format!("body[{i}].name"), b.name.as_str()));
    let membranes = file.membrane.iter().enumerate().map(|(i, m)| (format!("membrane[{i}].name"), m.name.as_str()));
    let obstacles = file.obstacle.iter().enumerate().map(|(i, o)| (format!("obstacle[{i}].name"), o.name.as_str()));
    bodies.chain(membranes).chain(obstacles).collect()
}

/// Every name names one thing.
pub(super) fn names(file: &CaseFile, findings: &mut Vec<Diagnostic>) {
    let named = named(file);
    for (i, (key, name)) in named.iter().enumerate() {
        if name.trim().is_empty() {
            findings.push(Diagnostic::error(key, "the name is empty"));
        } else if named[..i].iter().any(|(_, other)| other == name) {
            findings.push(Diagnostic::error(key, format!("there is already something named `{name}`")));
        }
    }
}

fn contacts(file: &CaseFile, findings: &mut Vec<Diagnostic>) {
    let bodies = file.body.iter().map(|b| b.name.as_str());
    let known: Vec<&str> = bodies.chain(file.membrane.iter().map(|m| m.name.as_str())).collect();
    for (i, contact) in file.contact.iter().enumerate() {
        for (j, name) in contact.between.iter().enumerate() {
            if !known.contains(&name.as_str()) {
                let message = format!("there is no body or membrane named `{name}`");
                let finding = Diagnostic::error(format!("contact[{i}].between[{j}]"), message);
                findings.push(finding.help(format!("there are {}", known.join(", "))));
            }
        }
        if contact.between[0] == contact.between[1] {
            let finding = Diagnostic::error(format!("contact[{i}].between"), "contact of a part with itself");
            findings.push(finding.help("name two different parts"));
        }
    }
}

/// Nothing may start outside of the grid.
fn inside<const D: usize>(setup: &Setup<D>, findings: &mut Vec<Diagnostic>) {
    let grid = &setup.grid;
    let slack = 1e-9 * grid.cell;
    let upper = Vector::<D>::from_fn(|i| grid.lower[i] + f64::from(grid.cells[i]) * grid.cell);
    let outside = |x: &Vector<D>| (0..D).any(|i| x[i] < grid.lower[i] - slack || x[i] > upper[i] + slack);
    let mut look = |key: String, what: &str, name: &str, places: &[Vector<D>]| {
        let count = places.iter().filter(|x| outside(x)).count();
        let Some(first) = places.iter().find(|x| outside(x)) else { return };
        let message = format!(
            "{count} of {} {what} of `{name}` lie outside the grid, the first at ({})",
            places.len(),
            coordinates(first)
        );
        let help = format!(
            "enlarge the grid, which reaches from ({}) to ({}), or cut the part off at its ends",
            coordinates(&grid.lower),
            coordinates(&upper)
        );
        findings.push(Diagnostic::error(key, message).help(help));
    };
    for (i, body) in setup.bodies.iter().enumerate() {
        look(format!("body[{i}].region"), "particles", &body.name, &body.position);
    }
    for (i, membrane) in setup.membranes.iter().enumerate() {
        look(format!("membrane[{i}].geometry"), "nodes", &membrane.name, &membrane.position);
    }
}

/// Coordinates [m] without the noise of their last digits.
fn coordinates<const D: usize>(x: &Vector<D>) -> String {
    x.0.map(|c| format!("{}", 1e-9 * (1e9 * c).round())).join(", ")
}

/// Two bodies may touch, but no particle may lie inside another body.
fn overlaps<const D: usize>(case: &Case, setup: &Setup<D>, findings: &mut Vec<Diagnostic>) {
    for (j, spec) in case.file.body.iter().enumerate().skip(1) {
        let Ok(region) = spec.region.build(&case.source.base, D) else { continue };
        let bounds = region.bounds();
        let near = |x: &[f64; 3]| (0..D).all(|i| (bounds.lower[i]..=bounds.upper[i]).contains(&x[i]));
        for body in &setup.bodies[..j] {
            let depth = -0.01 * body.volume[0].powf(1.0 / D as f64);
            let buried = |x: &&Vector<D>| near(&x.to3()) && region.signed_distance(x.to3()) < depth;
            let count = body.position.iter().filter(buried).count();
            if count > 0 {
                let message = format!("`{}` overlaps `{}`: {count} particles are in both", spec.name, body.name);
                let finding = Diagnostic::error(format!("body[{j}].region"), message);
                findings.push(finding.help("move one of them, or take it away with `shape = \"difference\"`"));
            }
        }
    }
}

fn coarse<const D: usize>(setup: &Setup<D>, findings: &mut Vec<Diagnostic>) {
    let longest_allowed = LONGEST_ELEMENT * setup.grid.cell;
    for (i, membrane) in setup.membranes.iter().enumerate() {
        let side = |nodes: &Vec<u32>, k: usize| {
            let (a, b) = (nodes[k] as usize, nodes[(k + 1) % nodes.len()] as usize);
            (membrane.position[a] - membrane.position[b]).norm()
        };
        let sides = membrane.elements.iter().flat_map(|nodes| (0..nodes.len()).map(move |k| side(nodes, k)));
        let longest = sides.fold(0.0, f64::max);
        if longest > longest_allowed {
            let message = format!("the elements of `{}` are too coarse for the grid: {longest} m", membrane.name);
            let finding = Diagnostic::error(format!("membrane[{i}].geometry"), message);
            findings
                .push(finding.help(format!("sides up to {longest_allowed} m ({LONGEST_ELEMENT} cells) are allowed")));
        }
    }
}

/// Checks steps and output intervals against the stable step.
pub(super) fn steps(case: &Case, summary: &Summary, findings: &mut Vec<Diagnostic>) {
    let file = &case.file;
    let stable = summary.stable_step;
    if stable.is_nan() || stable <= 0.0 {
        findings.push(Diagnostic::error("time", format!("the stable step is {stable} s")));
        return;
    }
    let explicit = file.method == Method::Mpm;
    if let Some(step) = file.time.step.filter(|step| explicit && *step > stable) {
        let finding = Diagnostic::error(
            "time.step",
            format!("the step of {step:.4e} s is above the stable one of {stable:.4e} s"),
        );
        let safety = file.mpm.safety;
        let help = format!("decrease it, or leave `step` out: it then adapts (`mpm.safety` is {safety})");
        findings.push(finding.help(help));
    }
    let step = file.time.step.unwrap_or(stable);
    for (name, interval) in [("fields", file.output.fields), ("history", file.output.history)] {
        let key = format!("output.{name}");
        let Some(interval) = interval.filter(|interval| *interval < step) else { continue };
        let message = format!("the interval of {interval:.4e} s is shorter than the step of {step:.4e} s");
        match file.time.step {
            Some(_) => findings.push(Diagnostic::error(key, message).help("increase it, or let the step adapt")),
            // Membranes are sub-cycled in any case: short steps of the whole cost particles, and those only.
            None if case.says(&key) && !file.body.is_empty() => {
                findings.push(Diagnostic::warning(key, message).help("steps will be cut to land on every output"));
            }
            None => {}
        }
    }
}

/// Checks that probes find what they name.
pub(super) fn probes(file: &CaseFile, initial: &Snapshot<'_>, findings: &mut Vec<Diagnostic>) {
    let nowhere = Path::new("");
    for (i, spec) in file.probe.iter().enumerate() {
        let key = format!("probe[{i}]");
        if file.probe[..i].iter().any(|other| other.name == spec.name) {
            findings
                .push(Diagnostic::error(format!("{key}.name"), format!("there is already a probe `{}`", spec.name)));
        }
        findings.extend(Probe::new(spec.clone(), &key, initial, nowhere, 1.0, UnitLabels::default()).err());
    }
}

/// Checks that pictures find what they show.
pub(super) fn pictures(file: &CaseFile, initial: &Snapshot<'_>, domain: [[f64; 3]; 2], findings: &mut Vec<Diagnostic>) {
    let nowhere = Path::new("");
    for (i, spec) in file.picture.iter().enumerate() {
        let key = format!("picture[{i}]");
        if file.picture[..i].iter().any(|other| other.name == spec.name) {
            let message = format!("there is already a picture `{}`", spec.name);
            findings.push(Diagnostic::error(format!("{key}.name"), message));
        }
        let picture = Picture::new(spec.clone(), &key, initial, domain, nowhere, 1.0, UnitLabels::default());
        findings.extend(picture.err());
    }
}
