//! Checks of the parts of a case against each other.

mod closing;
mod meet;
pub(super) mod plausible;
mod sheets;
pub(super) mod solids;

use super::summary::CaseSummary;
use super::{Case, CaseFile, Method, names};
use crate::error::Diagnostic;
use crate::math::Vector;
use crate::mpm::{KernelKind, MembraneSetup, Setup, StressUpdate, Transfer};
use crate::output::picture::unseen_cut;
use crate::output::{Picture, Probe, UnitLabels};
use crate::simulation::{LEAST_STEPS, Snapshot};
use std::path::Path;

/// An element of a membrane may be this many cells long: the contact samples it at most every half cell.
const LONGEST_ELEMENT: f64 = 32.0;

/// A shape that reaches so many times the length of the grid beyond it probably has another unit.
const FARTHEST_SHAPE: f64 = 20.0;

/// Checks bodies, membranes and contacts.
pub(super) fn parts<const D: usize>(case: &Case, setup: &Setup<D>, findings: &mut Vec<Diagnostic>) {
    names::parts(&case.file, findings);
    meet::contacts(&case.file, findings);
    meet::pairs(setup, findings);
    meet::walls_of_sheets(&case.file, setup, findings);
    meet::obstacles(case, setup, findings);
    inside(setup, findings);
    meet::overlaps(case, setup, findings);
    coarse(setup, findings);
    sheets::supports(setup, findings);
    sheets::idle_stiffness(case, findings);
    sheets::obstacles(setup, findings);
    closing::solids(case, setup, findings);
    sheets::planes_of_symmetry(setup, findings);
    unstable(setup, findings);
    plausible::of_points(case, setup, findings);
    if setup.bodies.is_empty() && setup.membranes.is_empty() {
        let finding = Diagnostic::error("", "there is neither a body nor a membrane: nothing would move");
        findings.push(finding.help("add a `[[body]]`"));
    }
}

/// Checks that all bodies and membranes start inside the grid.
fn inside<const D: usize>(setup: &Setup<D>, findings: &mut Vec<Diagnostic>) {
    let grid = &setup.grid;
    let slack = 1e-9 * grid.cell;
    let upper = Vector::<D>::from_fn(|i| grid.lower[i] + f64::from(grid.cells[i]) * grid.cell);
    let outside = |x: &Vector<D>| (0..D).any(|i| x[i] < grid.lower[i] - slack || x[i] > upper[i] + slack);
    let mut look = |key: String, what: &str, name: &str, places: &[Vector<D>]| {
        let count = places.iter().filter(|x| outside(x)).count();
        let Some(first) = places.iter().find(|x| outside(x)) else { return };
        let message = format!(
            "{count} of {} {what} of `{name}` lie outside the grid, the first at ({}), {}",
            places.len(),
            coordinates(first),
            farthest_beyond(places, &grid.lower, &upper)
        );
        let mut help = format!(
            "enlarge the grid, which reaches from ({}) to ({}), or cut the part off at its ends",
            coordinates(&grid.lower),
            coordinates(&upper)
        );
        let far = places.iter().flat_map(|x| (0..D).map(|i| (x[i] - grid.lower[i]).abs().max((x[i] - upper[i]).abs())));
        let length = (0..D).map(|i| upper[i] - grid.lower[i]).fold(0.0, f64::max);
        if far.fold(0.0, f64::max) > FARTHEST_SHAPE * length {
            help += "; or is a unit wrong, of this region or of the grid?";
        }
        findings.push(Diagnostic::error(key, message).help(help));
    };
    for (i, body) in setup.bodies.iter().enumerate() {
        look(format!("body[{i}].region"), "particles", &body.name, &body.position);
    }
    for (i, membrane) in setup.membranes.iter().enumerate() {
        look(format!("membrane[{i}].geometry"), "nodes", &membrane.name, &membrane.position);
    }
}

/// The largest distance of places beyond an end of the grid, in words.
fn farthest_beyond<const D: usize>(places: &[Vector<D>], lower: &Vector<D>, upper: &Vector<D>) -> String {
    let beyond = |axis: usize, end: usize| {
        let distance = |x: &Vector<D>| if end == 0 { lower[axis] - x[axis] } else { x[axis] - upper[axis] };
        places.iter().map(distance).fold(0.0, f64::max)
    };
    let ends = (0..D).flat_map(|axis| [(axis, 0), (axis, 1)]).map(|(axis, end)| (beyond(axis, end), axis, end));
    let (most, axis, end) = ends.fold((0.0, 0, 0), |best, other| if other.0 > best.0 { other } else { best });
    format!("and up to {most:.3e} m beyond its end `{}`", meet::wall_name(D, axis, end))
}

/// Coordinates [m] without the noise of their last digits, and without a zero below zero.
fn coordinates<const D: usize>(x: &Vector<D>) -> String {
    x.0.map(|c| format!("{}", (1e9 * c).round() / 1e9 + 0.0)).join(", ")
}

fn coarse<const D: usize>(setup: &Setup<D>, findings: &mut Vec<Diagnostic>) {
    let longest_allowed = LONGEST_ELEMENT * setup.grid.cell;
    for (i, membrane) in setup.membranes.iter().enumerate() {
        let [_, longest] = sides(membrane);
        if longest > longest_allowed {
            let message = format!("the elements of `{}` are too coarse for the grid: {longest} m", membrane.name);
            let finding = Diagnostic::error(format!("membrane[{i}].geometry"), message);
            findings
                .push(finding.help(format!("sides up to {longest_allowed} m ({LONGEST_ELEMENT} cells) are allowed")));
        }
    }
}

/// Mean and greatest length of the sides of a membrane's elements [m].
fn sides<const D: usize>(membrane: &MembraneSetup<D>) -> [f64; 2] {
    let side = |nodes: &Vec<u32>, k: usize| {
        let (a, b) = (nodes[k] as usize, nodes[(k + 1) % nodes.len()] as usize);
        (membrane.position[a] - membrane.position[b]).norm()
    };
    let sides = membrane.elements.iter().flat_map(|nodes| (0..nodes.len()).map(move |k| side(nodes, k)));
    let (count, sum, longest) =
        sides.fold((0, 0.0, 0.0), |(n, sum, longest), s| (n + 1, sum + s, f64::max(longest, s)));
    [sum / f64::from(count.max(1)), longest]
}

/// At a free surface a node with little mass takes any velocity; APIC hands it on, and its gradient turns particles
/// inside out.
fn unstable<const D: usize>(setup: &Setup<D>, findings: &mut Vec<Diagnostic>) {
    if setup.kernel != KernelKind::Linear || setup.bodies.is_empty() {
        return;
    }
    if setup.stress_update == StressUpdate::Last {
        let message = "with linear shape functions the velocities of light nodes turn particles inside out";
        let finding = Diagnostic::warning("mpm.stress-update", message);
        findings.push(finding.help("write `stress-update = \"modified-last\"`, or `kernel = \"quadratic\"`"));
    }
    if setup.transfer == Transfer::Apic {
        let finding =
            Diagnostic::warning("mpm.kernel", "APIC with linear shape functions is unstable at free surfaces");
        findings.push(finding.help("write `kernel = \"quadratic\"`, or `transfer = { kind = \"flip\" }`"));
    }
}

/// More steps or outputs of a kind than this are an error: years of computing.
const MOST_STEPS: f64 = 1e10;

/// Checks that the run would come to its end between outputs.
fn intervals(file: &CaseFile, findings: &mut Vec<Diagnostic>) {
    let output = [("output.fields".to_owned(), file.output.fields), ("output.history".to_owned(), file.output.history)];
    let probes = file.probe.iter().enumerate().map(|(i, probe)| (format!("probe[{i}].every"), probe.every));
    let pictures = file.picture.iter().enumerate().map(|(i, picture)| (format!("picture[{i}].every"), picture.every));
    for (key, interval) in output.into_iter().chain(probes).chain(pictures) {
        let Some(interval) = interval.filter(|interval| file.time.end > MOST_STEPS * interval) else { continue };
        let message = format!("an output every {interval:.4e} s would be {:.0e} of them", file.time.end / interval);
        findings.push(Diagnostic::error(key, message).help("increase the interval; is its unit right?"));
    }
}

/// Checks steps and output intervals against the stable step.
pub(super) fn steps(case: &Case, summary: &CaseSummary, findings: &mut Vec<Diagnostic>) {
    let file = &case.file;
    intervals(file, findings);
    let stable = summary.stable_step;
    if stable.is_nan() || stable <= 0.0 {
        findings.push(Diagnostic::error("time", format!("the stable step is {stable} s")));
        return;
    }
    findings.extend(file.time.step.filter(|step| *step > stable).map(|step| too_long(file, step, stable)));
    let step = file.time.step.unwrap_or(stable.min(file.time.end / LEAST_STEPS));
    if file.time.end > MOST_STEPS * step {
        let message = format!("steps of {step:.4e} s would be {:.0e} of them", file.time.end / step);
        let key = if file.time.step.is_some() { "time.step" } else { "time.end" };
        findings.push(Diagnostic::error(key, message).help("take longer steps or a shorter run; are the units right?"));
    }
    outputs_between_steps(case, step, findings);
}

/// A step that is written and longer than the stable one.
fn too_long(file: &CaseFile, step: f64, stable: f64) -> Diagnostic {
    let message = format!("the step of {step:.4e} s is above the stable one of {stable:.4e} s");
    let help = match file.method {
        Method::Mpm => {
            let safety = file.mpm.safety;
            format!("decrease it, or leave `step` out: it then adapts (`mpm.safety` is {safety})")
        }
        // Only waves bound a step that is written.
        Method::Pfem2 => format!(
            "the shortest wave that gravity or surface tension make on an interface would grow: write `step = {}`, or \
             leave it out",
            below(stable)
        ),
    };
    Diagnostic::error("time.step", message).help(help)
}

/// Outputs closer than this part of a step are told of.
const CLOSE_OUTPUTS: f64 = 0.5;

/// Outputs that the case wants much more often than there are steps.
fn outputs_between_steps(case: &Case, step: f64, findings: &mut Vec<Diagnostic>) {
    let output = &case.file.output;
    for (key, interval, help) in [
        ("output.fields", output.fields, "there will be one frame per step"),
        (
            "output.history",
            output.history,
            "rows between both ends of a step will be on the straight line between its values",
        ),
    ] {
        let Some(interval) = interval.filter(|interval| *interval < CLOSE_OUTPUTS * step && case.says(key)) else {
            continue;
        };
        let message = format!("the interval of {interval:.4e} s is shorter than the step of {step:.4e} s");
        findings.push(Diagnostic::warning(key, message).help(help));
    }
}

/// Compares the memory that a run would take with the available memory.
pub(super) fn memory(summary: &CaseSummary, findings: &mut Vec<Diagnostic>) {
    if let Some(refusal) = crate::memory::refusal(summary.memory) {
        let message = format!("the run would take {refusal}");
        findings.push(
            Diagnostic::warning("", message)
                .help("take larger cells, elements or distances of particles; are the units right?"),
        );
    }
}

/// The number below `value` with two digits.
fn below(value: f64) -> f64 {
    let unit = 10f64.powf(value.log10().floor() - 1.0);
    let digits = (value / unit).floor() * unit;
    format!("{digits:.1e}").parse().unwrap_or(digits)
}

/// Checks that probes find their targets; returns the differences between the followed and the requested places, as
/// sentences.
pub(super) fn probes(
    file: &CaseFile,
    initial: &Snapshot<'_>,
    domain: [[f64; 3]; 2],
    findings: &mut Vec<Diagnostic>,
) -> Vec<String> {
    let nowhere = Path::new("");
    let mut notes = Vec::new();
    for (i, spec) in file.probe.iter().enumerate() {
        let key = format!("probe[{i}]");
        match Probe::new(spec.clone(), &key, initial, nowhere, 1.0, UnitLabels::default()) {
            Ok(probe) => {
                findings.extend(spec.at.as_ref().and_then(|at| outside(&key, at, domain)));
                let missed = probe.misses(initial);
                findings.extend(missed.map(|corners| nothing_within(&key, &spec.of, corners, initial.dimension)));
                findings.extend(spec.impulse.and_then(|window| too_late(&key, window, file.time.end)));
                notes.extend(probe.adjusted());
            }
            Err(finding) => findings.push(finding),
        }
    }
    notes
}

/// An impulse over a window that the run doesn't reach stays zero.
fn too_late(key: &str, [from, to]: [f64; 2], end: f64) -> Option<Diagnostic> {
    let message = || format!("the window from {from} s to {to} s begins after the end of the run at {end} s");
    (from >= end).then(|| Diagnostic::error(format!("{key}.impulse"), message()).help("move the window, or `time.end`"))
}

/// The finding about a box that contains nothing at the start: values are missing until something enters it.
fn nothing_within(key: &str, of: &str, corners: [[f64; 3]; 2], dimension: usize) -> Diagnostic {
    let [lower, upper] =
        corners.map(|x| if dimension == 2 { coordinates(&Vector([x[0], x[1]])) } else { coordinates(&Vector(x)) });
    let message = format!("the box holds nothing of `{of}` at the start: the history begins with NaN");
    let help =
        format!("right if something comes into it later; `{of}` reaches from ({lower}) to ({upper}) m at the start");
    Diagnostic::warning(format!("{key}.within"), message).help(help)
}

/// A probe outside of the domain would follow the nearest particle, far away.
fn outside(key: &str, at: &[f64], [lower, upper]: [[f64; 3]; 2]) -> Option<Diagnostic> {
    let slack = 1e-6 * (0..3).map(|i| upper[i] - lower[i]).fold(0.0, f64::max);
    let axis = at.iter().enumerate().position(|(i, x)| *x < lower[i] - slack || *x > upper[i] + slack)?;
    let (name, x) = (["x", "y", "z"][axis], at[axis]);
    let message = format!("the place lies outside the domain: {name} = {x} m");
    let help = format!("the domain reaches from {} m to {} m along {name}", lower[axis], upper[axis]);
    Some(Diagnostic::error(format!("{key}.at"), message).help(help))
}

/// Checks that pictures find their parts and fields, and that cuts show something.
pub(super) fn pictures(file: &CaseFile, initial: &Snapshot<'_>, domain: [[f64; 3]; 2], findings: &mut Vec<Diagnostic>) {
    let nowhere = Path::new("");
    for (i, spec) in file.picture.iter().enumerate() {
        let key = format!("picture[{i}]");
        match Picture::new(spec.clone(), &key, initial, domain, nowhere, 1.0) {
            Ok(_) => findings.extend(unseen_cut(spec, &key, initial)),
            Err(finding) => findings.push(finding),
        }
    }
}
