//! Who meets whom: pairs of `[[contact]]`, bodies in each other's place, obstacles.

use crate::case::{Case, CaseFile, ObstacleKind};
use crate::error::Diagnostic;
use crate::geometry::Region;
use crate::math::Vector;
use crate::mpm::{BodySetup, Setup};

/// Every pair has names that are there, and is named once.
pub(super) fn contacts(file: &CaseFile, findings: &mut Vec<Diagnostic>) {
    let membranes: Vec<&str> = file.membrane.iter().map(|m| m.name.as_str()).collect();
    let known: Vec<&str> = file.body.iter().map(|b| b.name.as_str()).chain(membranes.iter().copied()).collect();
    for (i, contact) in file.contact.iter().enumerate() {
        let [first, second] = contact.between.each_ref().map(String::as_str);
        for (j, name) in [first, second].into_iter().enumerate().filter(|(_, name)| !known.contains(name)) {
            let message = format!("there is no body or membrane named `{name}`");
            let finding = Diagnostic::error(format!("contact[{i}].between[{j}]"), message);
            findings.push(finding.help(format!("there are {}", known.join(", "))));
        }
        let mut wrong = |message: String, help: &str| {
            findings.push(Diagnostic::error(format!("contact[{i}].between"), message).help(help));
        };
        let together = |name: &str| {
            let group = file.body.iter().find(|body| body.name == name).and_then(|body| body.group.as_deref());
            group.map_or((name.to_owned(), false), |group| (group.to_owned(), true))
        };
        let sides = [first, second].map(together);
        let other = file.contact[..i].iter().position(|other| {
            let others = other.between.each_ref().map(|name| together(name));
            (others == sides || others == [sides[1].clone(), sides[0].clone()]) && other.friction != contact.friction
        });
        let twin = file.contact[..i].iter().position(|other| other.between.iter().all(|n| contact.between.contains(n)));
        if first == second {
            wrong("contact of a part with itself".to_owned(), "name two different parts");
        } else if membranes.contains(&first) && membranes.contains(&second) {
            let help = "membranes meet bodies only: name a body and a membrane, or two bodies";
            wrong(format!("`{first}` and `{second}` are membranes, which don't meet each other"), help);
        } else if let Some(twin) = twin {
            let message = format!("this pair already has a contact, contact[{twin}]");
            wrong(message, "a pair has one friction: take one of them out");
        } else if sides[0] == sides[1] {
            let message = format!("`{first}` and `{second}` are of one group: they share a velocity and don't meet");
            wrong(message, "take the contact out, or take one of them out of the group");
        } else if let Some(other) = other {
            let message = format!("contact[{other}] says something else of the same groups");
            wrong(
                message,
                "bodies of one group share a velocity, and so one friction: say the same, or part the group",
            );
        }
    }
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
    let regions = case.file.body.iter().filter_map(|body| body.region.build(&case.source.base, D).ok());
    let regions: Vec<Region> = regions.collect();
    if regions.len() != setup.bodies.len() {
        return;
    }
    for (j, (body, region)) in setup.bodies.iter().zip(&regions).enumerate() {
        for (other, place) in setup.bodies[..j].iter().zip(&regions) {
            let count = buried(other, region) + buried(body, place);
            if count > 0 {
                let message = format!("`{}` overlaps `{}`: {count} particles are in both", body.name, other.name);
                let finding = Diagnostic::error(format!("body[{j}].region"), message);
                findings.push(finding.help("move one of them, or take it away with `shape = \"difference\"`"));
            }
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
