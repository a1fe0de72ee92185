//! Names: no two parts have the same, and no two files that a run writes.
//!
//! Histories, fields and pictures are called after parts, probes and pictures; what is not safe in a file name becomes
//! `-`, so that two names may mean one file. Upper and lower case count as one: not every file system tells them apart.

use super::{CaseFile, Method};
use crate::error::Diagnostic;
use crate::mesh::domain::DomainMesh;
use crate::output::label::file_name;
use crate::pfem2::{INTERFACE, MESH};
use crate::simulation::Snapshot;
use std::collections::{HashMap, HashSet};

/// The longest name [bytes]: the force of a contact has two of them in the name of its file, and file systems
/// allow 255.
const LONGEST_NAME: usize = 100;

/// True if a case may have this name, which is that of a folder.
pub fn is_case_name(name: &str) -> bool {
    let folder = name.trim();
    !(folder.is_empty() || folder.starts_with('.') || folder.contains(['/', '\\']) || unfit(name).is_some())
}

/// Why no file can be called after a name, and what to do.
fn unfit(name: &str) -> Option<(String, String)> {
    if name.len() > LONGEST_NAME {
        let message = format!("this name is too long: {} bytes", name.len());
        let help = format!(
            "files of the run are called after it: {LONGEST_NAME} at most, where letters beyond ASCII have 2 to 4"
        );
        return Some((message, help));
    }
    let control = name.chars().find(|&c| is_hidden(c))?;
    let kind = if control.is_control() { "control character" } else { "invisible character" };
    let message = format!("this name holds the {kind} U+{:04X}", u32::from(control));
    Some((message, "files of the run are called after it: write letters, digits, `-` and `_`".to_owned()))
}

/// True for characters that aren't seen, but change how text around them is shown or compared: controls, marks of
/// direction (UAX #9), spaces without width, ends of lines.
fn is_hidden(c: char) -> bool {
    let invisible = ['\u{ad}', '\u{61c}', '\u{180e}', '\u{feff}'];
    c.is_control()
        || invisible.contains(&c)
        || matches!(c, '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}' | '\u{e0000}'..='\u{e007f}')
}

/// Every name of a part names one thing, and no name is empty; that of the case is the name of a folder.
pub(super) fn parts(file: &CaseFile, findings: &mut Vec<Diagnostic>) {
    if unfit(&file.name).is_none() && !is_case_name(&file.name) {
        let finding = Diagnostic::error("name", "this can't be the name of a folder");
        findings.push(finding.help("the run goes to runs/<name>: write a word without `/`, or several with `-`"));
    }
    unfit_for_files(file, findings);
    let bodies = file.body.iter().enumerate().map(|(i, b)| (format!("body[{i}].name"), b.name.as_str()));
    let membranes = file.membrane.iter().enumerate().map(|(i, m)| (format!("membrane[{i}].name"), m.name.as_str()));
    let obstacles = file.obstacle.iter().enumerate().map(|(i, o)| (format!("obstacle[{i}].name"), o.name.as_str()));
    let named: Vec<_> = bodies.chain(membranes).chain(obstacles).collect();
    let mut taken = HashSet::new();
    for (key, name) in named.iter().filter(|(_, name)| !name.trim().is_empty()) {
        if !taken.insert(*name) {
            findings.push(Diagnostic::error(key, format!("there is already something named `{name}`")));
        }
    }
    let boundaries = file.boundary.iter().enumerate();
    let boundaries = boundaries.filter_map(|(i, b)| Some((format!("boundary[{i}].name"), b.name.as_deref()?)));
    let probes = file.probe.iter().enumerate().map(|(i, p)| (format!("probe[{i}].name"), p.name.as_str()));
    let pictures = file.picture.iter().enumerate().map(|(i, p)| (format!("picture[{i}].name"), p.name.as_str()));
    for (key, _) in named.into_iter().chain(boundaries).chain(probes).chain(pictures).filter(|n| n.1.trim().is_empty())
    {
        findings.push(Diagnostic::error(key, "the name is empty").help("files of the run are called after it"));
    }
}

/// Every name is one that files can have.
fn unfit_for_files(file: &CaseFile, findings: &mut Vec<Diagnostic>) {
    let bodies = file.body.iter().enumerate().map(|(i, b)| (format!("body[{i}].name"), b.name.clone()));
    let membranes = file.membrane.iter().enumerate().map(|(i, m)| (format!("membrane[{i}].name"), m.name.clone()));
    let obstacles = file.obstacle.iter().enumerate().map(|(i, o)| (format!("obstacle[{i}].name"), o.name.clone()));
    let boundaries = file.boundary.iter().enumerate().map(|(i, b)| (part_key(i, b), b.part_name()));
    let probes = file.probe.iter().enumerate().map(|(i, p)| (format!("probe[{i}].name"), p.name.clone()));
    let pictures = file.picture.iter().enumerate().map(|(i, p)| (format!("picture[{i}].name"), p.name.clone()));
    let groups = file.body.iter().enumerate();
    let groups = groups.filter_map(|(i, b)| Some((format!("body[{i}].group"), b.group.clone()?)));
    let holes = match &file.mesh {
        Some(DomainMesh::BoxMesh(mesh)) => &mesh.holes[..],
        _ => &[],
    };
    let holes = holes.iter().enumerate().map(|(i, hole)| (format!("mesh.holes[{i}].name"), hole.name.clone()));
    let case = std::iter::once(("name".to_owned(), file.name.clone()));
    let all = case
        .chain(bodies)
        .chain(groups)
        .chain(holes)
        .chain(membranes)
        .chain(obstacles)
        .chain(boundaries)
        .chain(probes)
        .chain(pictures);
    for (key, name) in all {
        let Some((message, help)) = unfit(&name) else { continue };
        let short = if key.ends_with(".on") { "; give this boundary a short `name`" } else { "" };
        findings.push(Diagnostic::error(key, message).help(help + short));
    }
}

/// The key that the name of a part of the boundary comes from.
fn part_key(i: usize, part: &super::BoundarySpec) -> String {
    format!("boundary[{i}].{}", if part.name.is_some() { "name" } else { "on" })
}

/// An output that writes a file.
struct Writer {
    /// The name of the part that gives the file its name.
    name: String,
    /// The key of the name; empty for what the case doesn't name.
    key: String,
    /// Its kind, for messages.
    what: String,
}

impl Writer {
    fn new(name: &str, key: impl Into<String>, what: impl Into<String>) -> Self {
        Self { name: name.to_owned(), key: key.into(), what: what.into() }
    }
}

/// Every file that a run writes has one writer. `initial`: the state at the start, with all forces.
pub(super) fn files(file: &CaseFile, initial: &Snapshot<'_>, findings: &mut Vec<Diagnostic>) {
    let mut histories = vec![
        Writer::new("balance", "", "the balance of the whole"),
        Writer::new("counts", "", "the counts of the whole"),
    ];
    histories.extend(forces(file, initial));
    let probes = file.probe.iter().enumerate();
    histories.extend(probes.map(|(i, p)| Writer::new(&p.name, format!("probe[{i}].name"), probe(&p.name))));
    distinct("history", ".csv", &histories, findings);

    let mut fields = Vec::new();
    if file.method == Method::Pfem2 {
        fields.extend([Writer::new(MESH, "", "the mesh"), Writer::new(INTERFACE, "", "the interface of the fluids")]);
    }
    let bodies = file.body.iter().enumerate();
    fields
        .extend(bodies.map(|(i, b)| Writer::new(&b.name, format!("body[{i}].name"), format!("the body `{}`", b.name))));
    fields.extend(file.solids().into_iter().map(|i| {
        let name = &file.body[i].name;
        Writer::new(&format!("{name}-surface"), format!("body[{i}].name"), format!("the surface of `{name}`"))
    }));
    let membranes = file.membrane.iter().enumerate();
    fields.extend(
        membranes
            .map(|(i, m)| Writer::new(&m.name, format!("membrane[{i}].name"), format!("the membrane `{}`", m.name))),
    );
    distinct("fields", ".pvd", &fields, findings);

    let pictures = file.picture.iter().enumerate();
    let pictures: Vec<_> = pictures
        .map(|(i, p)| Writer::new(&p.name, format!("picture[{i}].name"), format!("the picture `{}`", p.name)))
        .collect();
    distinct("pictures", ".csv", &pictures, findings);
}

fn probe(name: &str) -> String {
    format!("the probe `{name}`")
}

/// Forces of parts: those without a name in the case first, so that a finding is about a name that can be changed.
fn forces(file: &CaseFile, initial: &Snapshot<'_>) -> Vec<Writer> {
    let force = |name: &str| format!("the force on `{name}`");
    if file.method == Method::Pfem2 {
        let holding = file.boundary.iter().enumerate().filter(|(_, part)| part.kind.carries_reaction());
        let writer = |(i, part): (usize, &super::BoundarySpec)| {
            let name = part.part_name();
            Writer::new(&name, part_key(i, part), force(&name))
        };
        let solid = |i: usize| {
            let name = &file.body[i].name;
            Writer::new(name, format!("body[{i}].name"), force(name))
        };
        let solids = file.solids().into_iter().chain(file.particle_solids());
        return holding.map(writer).chain(solids.map(solid)).collect();
    }
    let key = |force: &str| {
        let obstacle = force.strip_prefix("obstacle:");
        let place = obstacle.and_then(|name| file.obstacle.iter().position(|spec| spec.name == name));
        place.map_or_else(String::new, |i| format!("obstacle[{i}].name"))
    };
    let mut writers: Vec<_> =
        initial.forces.iter().map(|(name, _)| Writer::new(name, key(name), force(name))).collect();
    writers.sort_by_key(|writer| !writer.key.is_empty());
    writers
}

fn distinct(folder: &str, ending: &str, writers: &[Writer], findings: &mut Vec<Diagnostic>) {
    let mut first: HashMap<String, &Writer> = HashMap::new();
    for writer in writers.iter().filter(|writer| !writer.name.trim().is_empty()) {
        let file = file_name(&writer.name);
        let Some(other) = first.get(&file.to_lowercase()) else {
            first.insert(file.to_lowercase(), writer);
            continue;
        };
        let key = if writer.key.is_empty() { &other.key } else { &writer.key };
        let message = format!("{} would be written to `{folder}/{file}{ending}`, as {} is", writer.what, other.what);
        findings.push(Diagnostic::error(key, message).help("give one of them another name"));
    }
}
