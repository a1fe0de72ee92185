//! Checks of pairs: those of `[[contact]]`, overlapping bodies, obstacles.

use crate::case::walk::nearest;
use crate::case::{Case, CaseFile, ObstacleKind};
use crate::error::Diagnostic;
use crate::geometry::{Bounds, Region};
use crate::math::Vector;
use crate::mpm::{BodySetup, Friction, Setup, WallKind};
use std::collections::{HashMap, HashSet};

/// Every pair has names that are there, and is named once.
pub(super) fn contacts(file: &CaseFile, findings: &mut Vec<Diagnostic>) {
    let parts = PartNames::of(file);
    let mut pairs: HashMap<_, usize> = HashMap::new();
    let mut sides: HashMap<_, usize> = HashMap::new();
    for (i, contact) in file.contact.iter().enumerate() {
        let names = contact.between.each_ref().map(String::as_str);
        findings.extend(parts.unknown(names, i));
        let (pair, both) = (in_order(names.map(|name| parts.own(name))), in_order(names.map(|name| parts.side(name))));
        let twin = pairs.get(&pair).copied();
        let other = sides.get(&both).copied().filter(|&other| file.contact[other].friction != contact.friction);
        if let Some((message, help)) = parts.mismatch(names).or_else(|| repeated(names, both, twin, other)) {
            findings.push(Diagnostic::error(format!("contact[{i}].between"), message).help(help));
        }
        pairs.entry(pair).or_insert(i);
        sides.entry(both).or_insert(i);
    }
}

/// The parts of a case that may meet, by their names.
struct PartNames<'a> {
    file: &'a CaseFile,
    /// Bodies, then membranes.
    names: Vec<&'a str>,
    known: HashSet<&'a str>,
    membranes: HashSet<&'a str>,
    /// The group of each body that has one.
    groups: HashMap<&'a str, &'a str>,
}

/// A name, and `true` if it is that of a group.
type Named<'a> = (&'a str, bool);

impl<'a> PartNames<'a> {
    fn of(file: &'a CaseFile) -> Self {
        let membranes = file.membrane.iter().map(|membrane| membrane.name.as_str());
        let names: Vec<&str> = file.body.iter().map(|body| body.name.as_str()).chain(membranes.clone()).collect();
        let groups = file.body.iter().filter_map(|body| Some((body.name.as_str(), body.group.as_deref()?)));
        let known = names.iter().copied().collect();
        Self { file, names, known, membranes: membranes.collect(), groups: groups.collect() }
    }

    /// The name of a part; a wall or an obstacle has two.
    fn own(&self, name: &'a str) -> &'a str {
        if self.known.contains(name) { name } else { without_kind(name) }
    }

    /// The group of a body, or the part itself.
    fn side(&self, name: &'a str) -> Named<'a> {
        self.groups.get(name).map_or((name, false), |group| (*group, true))
    }

    /// Names of the pair that no part has. A membrane's other may be a wall or an obstacle.
    fn unknown(&self, names: [&'a str; 2], contact: usize) -> impl Iterator<Item = Diagnostic> {
        let beside_membrane = move |j: usize| self.membranes.contains(names[1 - j]) && is_solid(self.file, names[j]);
        let wrong = (0..2).filter(move |&j| !self.known.contains(names[j]) && !beside_membrane(j));
        wrong.map(move |j| nobody(self.file, names[j], &self.names, format!("contact[{contact}].between[{j}]")))
    }

    /// Why two parts can have no contact, and what to write.
    fn mismatch(&self, [first, second]: [&str; 2]) -> Option<(String, &'static str)> {
        let sheets = [first, second].map(|name| self.membranes.contains(name));
        if first == second {
            let help = if sheets[0] {
                "contact of a membrane with itself comes later: until then it passes through itself, and the run says where"
            } else {
                "name two different parts"
            };
            return Some((format!("`{first}` is named twice: this is the contact of a part with itself"), help));
        }
        let help = "contact among membranes comes later: name a body and a membrane, or two bodies; until then membranes pass \
                    through each other, and the run says where";
        let message = || format!("`{first}` and `{second}` are membranes, which don't meet each other");
        (sheets == [true, true]).then(|| (message(), help))
    }
}

/// Message and help where an earlier contact names the same pair, `twin`, or its groups otherwise, `other`.
fn repeated(
    [first, second]: [&str; 2],
    sides: [Named<'_>; 2],
    twin: Option<usize>,
    other: Option<usize>,
) -> Option<(String, &'static str)> {
    if let Some(twin) = twin {
        let message = format!("this pair already has a contact, contact[{twin}]");
        return Some((message, "a pair has one friction: take one of them out"));
    }
    if sides[0] == sides[1] {
        let message = format!("`{first}` and `{second}` are of one group: they share a velocity and don't meet");
        return Some((message, "take the contact out, or take one of them out of the group"));
    }
    let message = format!("contact[{}] says something else of the same groups", other?);
    Some((message, "bodies of one group share a velocity, and so one friction: say the same, or part the group"))
}

/// More pairs of velocity fields than a run has contacts and histories for.
const MOST_PAIRS: usize = 100_000;

/// Every pair of bodies and groups has a contact, unless the case lists the pairs.
pub(super) fn pairs<const D: usize>(setup: &Setup<D>, findings: &mut Vec<Diagnostic>) {
    let fields = setup.bodies.iter().map(|body| body.group).collect::<HashSet<usize>>().len();
    let pairs = fields * fields.saturating_sub(1) / 2;
    if pairs > MOST_PAIRS && setup.default_friction != Friction::None {
        let message = format!(
            "{fields} bodies and groups, each with a velocity of its own, are {pairs} pairs that may meet, each with a history of its force"
        );
        let help = "let those that never meet share a `group`, or write `friction = \"none\"` in `[mpm]` and the pairs that meet as \
                    `[[contact]]`";
        findings.push(Diagnostic::error("body[1].group", message).help(help));
    }
}

/// The name of a wall or an obstacle without its kind.
fn without_kind(name: &str) -> &str {
    name.strip_prefix("wall:").or_else(|| name.strip_prefix("obstacle:")).unwrap_or(name)
}

fn in_order<T: Ord>(mut pair: [T; 2]) -> [T; 2] {
    pair.sort();
    pair
}

/// The walls of a grid.
const WALLS: [&str; 6] = ["left", "right", "front", "back", "bottom", "top"];

/// The name of the wall at an end (0 or 1) of an axis.
pub(super) fn wall_name(dimension: usize, axis: usize, end: usize) -> &'static str {
    let axis = if axis + 1 == dimension { 2 } else { axis };
    WALLS[2 * axis + end]
}

/// A wall that a membrane's contact names is there, and holds something.
pub(super) fn walls_of_sheets<const D: usize>(file: &CaseFile, setup: &Setup<D>, findings: &mut Vec<Diagnostic>) {
    let ends: Vec<(usize, usize)> = (0..D).flat_map(|axis| [(axis, 0), (axis, 1)]).collect();
    let sheet = |name: &str| file.membrane.iter().any(|membrane| membrane.name == name);
    let named = |name: &str| {
        let known = file.body.iter().any(|body| body.name == name) || sheet(name);
        known || file.obstacle.iter().any(|obstacle| obstacle.name == name)
    };
    for (i, contact) in file.contact.iter().enumerate() {
        for j in 0..2 {
            let (name, key) = (contact.between[j].as_str(), format!("contact[{i}].between[{j}]"));
            let wall = name.strip_prefix("wall:").unwrap_or(name);
            if named(name) || !sheet(&contact.between[1 - j]) || !WALLS.contains(&wall) {
                continue;
            }
            let finding = match ends.iter().find(|(axis, end)| wall_name(D, *axis, *end) == wall) {
                None => Diagnostic::error(key, format!("the wall `{wall}` exists in 3D only"))
                    .help("in 2D the ends of y are `bottom` and `top`"),
                Some(&(axis, end)) if setup.grid.walls[axis][end].kind == WallKind::Open => {
                    let message = format!("the wall `{wall}` is open: nothing meets it");
                    let help =
                        format!("write `walls = {{ {wall} = \"separate\" }}` in `[grid]`, or take the contact out");
                    Diagnostic::error(key, message).help(help)
                }
                Some(_) => continue,
            };
            findings.push(finding);
        }
    }
}

/// True if a wall or an obstacle has this name.
fn is_solid(file: &CaseFile, name: &str) -> bool {
    let own = |kind: &str| name.strip_prefix(kind).unwrap_or(name);
    file.obstacle.iter().any(|obstacle| obstacle.name == own("obstacle:")) || WALLS.contains(&own("wall:"))
}

/// Names that a message lists at most.
const LISTED: usize = 20;

/// A contact with something that is no body and no membrane: a wall, an obstacle, or nothing.
fn nobody(file: &CaseFile, name: &str, known: &[&str], key: String) -> Diagnostic {
    let own = |kind: &str| name.strip_prefix(kind).unwrap_or(name);
    if file.obstacle.iter().any(|obstacle| obstacle.name == own("obstacle:")) {
        let finding = Diagnostic::error(key, format!("`{name}` is an obstacle: all bodies meet it"));
        return finding.help("its friction is its own: `kind = \"friction\"` and `coefficient` in its `[[obstacle]]`");
    }
    if WALLS.contains(&own("wall:")) {
        let finding = Diagnostic::error(key, format!("`{name}` is a wall of the grid: all bodies meet it"));
        let wall = own("wall:");
        return finding.help(format!(
            "its friction is its own: `walls = {{ {wall} = {{ kind = \"friction\", coefficient = 0.3 }} }}` in `[grid]`"
        ));
    }
    let finding = Diagnostic::error(key, format!("there is no body or membrane named `{name}`"));
    let more = if known.len() > LISTED { format!(" and {} more", known.len() - LISTED) } else { String::new() };
    let there = format!("here are {}{more}", known[..known.len().min(LISTED)].join(", "));
    if let Some(meant) = nearest(name, known.iter().copied()) {
        return finding.help(format!("did you mean `{meant}`? T{there}"));
    }
    let obstacles = file.obstacle.iter().map(|obstacle| obstacle.name.as_str());
    if let Some(meant) = nearest(name, obstacles.chain(WALLS)) {
        return finding.help(format!("`{meant}` is an obstacle or a wall, whose friction is its own; t{there}"));
    }
    finding.help(format!("t{there}"))
}

/// Obstacles lie in the grid, hold no particles, and have a coefficient where it counts.
pub(super) fn obstacles<const D: usize>(case: &Case, setup: &Setup<D>, findings: &mut Vec<Diagnostic>) {
    let grid = &setup.grid;
    for (i, (spec, obstacle)) in case.file.obstacle.iter().zip(&setup.obstacles).enumerate() {
        if spec.coefficient != 0.0 && spec.kind != ObstacleKind::Friction {
            let message = "the coefficient has no effect: this obstacle has no friction";
            let finding = Diagnostic::error(format!("obstacle[{i}].coefficient"), message);
            findings.push(finding.help("write `kind = \"friction\"`, or take the coefficient away"));
        }
        let bounds = obstacle.region.bounds();
        let upper = |a: usize| grid.lower[a] + f64::from(grid.cells[a]) * grid.cell;
        let still = spec.velocity.iter().all(|v| *v == Default::default());
        if still && (0..D).any(|a| bounds.upper[a] < grid.lower[a] || bounds.lower[a] > upper(a)) {
            let finding = Diagnostic::warning(format!("obstacle[{i}].region"), "the obstacle lies outside the grid");
            findings.push(finding.help("nothing can meet it there: move it, or enlarge the grid"));
        }
        for (j, body) in setup.bodies.iter().enumerate() {
            let count = buried(body, &obstacle.region);
            if count > 0 {
                let message = format!("`{}` lies in the obstacle `{}` with {count} particles", body.name, spec.name);
                let finding = Diagnostic::error(format!("body[{j}].region"), message);
                findings.push(finding.help("move one of them: a body may touch an obstacle"));
            }
        }
    }
}

/// Two bodies may touch, but no particle may lie inside another body. Both are looked at: a strip that lies between
/// the lattice lines of a block holds no particle of the block.
pub(super) fn overlaps<const D: usize>(case: &Case, setup: &Setup<D>, findings: &mut Vec<Diagnostic>) {
    let regions = case.file.body.iter().filter_map(|body| body.region.as_ref()?.build(&case.source.base, D).ok());
    let regions: Vec<Region> = regions.collect();
    if regions.len() != setup.bodies.len() {
        return;
    }
    let boxes: Vec<Bounds> = regions.iter().map(Region::bounds).collect();
    // Sorted by their lower ends, a body can only overlap those that begin before it ends.
    let mut order: Vec<usize> = (0..boxes.len()).collect();
    order.sort_by(|&a, &b| boxes[a].lower[0].total_cmp(&boxes[b].lower[0]));
    let mut pairs = Vec::new();
    for (n, &a) in order.iter().enumerate() {
        let begins = |b: &&usize| boxes[**b].lower[0] <= boxes[a].upper[0];
        let meets = |b: &&usize| {
            (1..D).all(|i| boxes[a].lower[i] <= boxes[**b].upper[i] && boxes[**b].lower[i] <= boxes[a].upper[i])
        };
        let after = order[n + 1..].iter().take_while(begins).filter(meets);
        pairs.extend(after.map(|&b| (a.max(b), a.min(b))));
    }
    pairs.sort_unstable();
    for (j, i) in pairs {
        let (body, other) = (&setup.bodies[j], &setup.bodies[i]);
        let count = buried(other, &regions[j]) + buried(body, &regions[i]);
        if count > 0 {
            let message = format!("`{}` overlaps `{}`: {count} particles are in both", body.name, other.name);
            let finding = Diagnostic::error(format!("body[{j}].region"), message);
            findings.push(finding.help("move one of them, or take it away with `shape = \"difference\"`"));
        }
    }
}

/// Particles of a body inside a region, and not just on its surface.
fn buried<const D: usize>(body: &BodySetup<D>, region: &Region) -> usize {
    let bounds = region.bounds();
    let near = |x: &[f64; 3]| (0..D).all(|i| (bounds.lower[i]..=bounds.upper[i]).contains(&x[i]));
    let depth = -0.01 * body.volume[0].powf(1.0 / D as f64);
    let inside = |x: &&Vector<D>| near(&x.to3()) && region.signed_distance(x.to3()) < depth;
    body.position.iter().filter(inside).count()
}
