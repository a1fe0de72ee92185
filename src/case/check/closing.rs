//! Obstacles that close on a membrane, along the motion that the case prescribes: with another obstacle, or with a
//! wall.
//!
//! A node that nothing else moves is pushed ahead by each of two solids, to half the thickness t that the sheet has in
//! contact:
//!
//! ```text
//! x ← x + max(½ t − φ, 0) n          no way out:  n₁·n₂ ≈ −1,  φ₁ + φ₂ < t        φ, n: distance and normal of a solid
//! ```
//!
//! The sum of the distances changes by no more than the two have moved, so that there is no need to look before they
//! can have closed. The run stops there if the sheet has not left in the meantime (`mpm/contact/rigid/squeeze`).

use super::meet::wall_name;
use crate::case::Case;
use crate::error::Diagnostic;
use crate::geometry::Region;
use crate::math::{Signal, Vector};
use crate::mpm::{Friction, MembraneSetup, Setup, WallKind};

/// Between normals that are nearer to opposite, within 26 degrees, nothing slips out sideways.
const OPPOSITE: f64 = -0.9;

/// The part of the thickness that must be missing: solids may be meant to close on just the thickness.
const MISSING: f64 = 0.1;

/// The part of the motion of an obstacle that may be unknown [thickness].
const UNKNOWN: f64 = 0.05;

/// The same for a sheet without thickness in contact [cells], which must also be missing between two solids.
const OVERLAP: f64 = 1e-3;

/// Nodes are pushed by at most this from one look to the next [cells], and by at least this [thickness, cells].
const PUSH: f64 = 0.1;
const LEAST_PUSH: [f64; 2] = [0.25, 0.01];

/// Times at which the displacement of an obstacle is known, and steps of its integration between two of them: two
/// numbers, for an estimate of the error.
const TIMES: usize = 512;
const STEPS: [usize; 2] = [8, 13];

/// Looks at distances in all: where there are more, the run will say it.
const LOOKS: usize = 4_000_000;

/// A warning for each two solids that close on a membrane before the end of the run.
pub(super) fn solids<const D: usize>(case: &Case, setup: &Setup<D>, findings: &mut Vec<Diagnostic>) {
    if setup.membranes.is_empty() || setup.obstacles.iter().all(|obstacle| is_still(&obstacle.velocity)) {
        return;
    }
    let (solids, mut looks) = (all(case, setup), LOOKS);
    for membrane in &setup.membranes {
        for (i, second) in solids.iter().enumerate() {
            for first in solids[..i].iter().filter(|first| !(first.way.is_empty() && second.way.is_empty())) {
                let pair = [first, second];
                if !pair.iter().all(|solid| solid.meets(setup, membrane)) {
                    continue;
                }
                let search = Search::new(pair, membrane, setup.grid.cell, case.file.time.end);
                let found = search.and_then(|search| search.first(membrane, &mut looks));
                findings.extend(found.map(|found| found.warning(pair, membrane)));
            }
        }
    }
}

fn is_still(velocity: &[Signal; 3]) -> bool {
    velocity.iter().all(Signal::is_zero)
}

/// A wall or an obstacle, and how it moves.
struct MovingSolid<'a, const D: usize> {
    /// Its name in histories.
    name: String,
    /// Its key, if it moves.
    key: String,
    surface: MeetingSurface<'a, D>,
    /// Displacements at equally distant times of the run [m]; none if it stands still.
    way: Vec<Vector<D>>,
    /// Bound of their error [m].
    unknown: f64,
}

enum MeetingSurface<'a, const D: usize> {
    /// The normal of a wall, and how far it is from the origin along it [m].
    Plane(Vector<D>, f64),
    Region(&'a Region),
}

/// All that sheets may meet.
fn all<'a, const D: usize>(case: &Case, setup: &'a Setup<D>) -> Vec<MovingSolid<'a, D>> {
    let grid = &setup.grid;
    let sides = (0..D).flat_map(|axis| [(axis, 0), (axis, 1)]);
    let closed = sides.filter(|&(axis, end)| grid.walls[axis][end].kind != WallKind::Open);
    let wall = |(axis, end): (usize, usize)| {
        let normal = Vector::unit(axis) * if end == 0 { 1.0 } else { -1.0 };
        let place = grid.lower[axis] + (end as f64) * f64::from(grid.cells[axis]) * grid.cell;
        let name = format!("wall:{}", wall_name(D, axis, end));
        let surface = MeetingSurface::Plane(normal, place * normal[axis]);
        MovingSolid { name, key: String::new(), surface, way: Vec::new(), unknown: 0.0 }
    };
    let obstacles = setup.obstacles.iter().enumerate().filter(|(_, obstacle)| obstacle.kind != WallKind::Open);
    let obstacle = |(i, obstacle): (usize, &'a crate::mpm::Obstacle)| {
        let (way, unknown) = way(&obstacle.velocity, case.file.time.end);
        let (name, key) = (format!("obstacle:{}", obstacle.name), format!("obstacle[{i}].velocity"));
        MovingSolid { name, key, surface: MeetingSurface::Region(&obstacle.region), way, unknown }
    };
    closed.map(wall).chain(obstacles.map(obstacle)).collect()
}

/// The way of an obstacle until `end` [s], and by how much it may be wrong [m]: infinitely where the velocity has no
/// value.
fn way<const D: usize>(velocity: &[Signal; 3], end: f64) -> (Vec<Vector<D>>, f64) {
    if is_still(velocity) {
        return (Vec::new(), 0.0);
    }
    let integrated = |steps: usize| -> Vec<Vector<D>> {
        let dt = end / (TIMES * steps) as f64;
        let during = |n: usize| {
            let of_step =
                |k: usize| Vector::from_fn(|a| velocity[a].value([0.0; 3], ((n * steps + k) as f64 + 0.5) * dt) * dt);
            (0..steps).map(of_step).fold(Vector::ZERO, |sum: Vector<D>, by| sum + by)
        };
        let mut at = Vector::ZERO;
        std::iter::once(at)
            .chain((0..TIMES).map(|n| {
                at += during(n);
                at
            }))
            .collect()
    };
    let [coarse, fine] = STEPS.map(integrated);
    let unknown = coarse.iter().zip(&fine).map(|(a, b)| (*a - *b).norm()).fold(0.0, f64::max);
    let known = fine.iter().all(|x| x.is_finite());
    (fine, if known { unknown } else { f64::INFINITY })
}

impl<const D: usize> MovingSolid<'_, D> {
    /// True unless the case takes the contact of the two away.
    fn meets(&self, setup: &Setup<D>, membrane: &MembraneSetup<D>) -> bool {
        let own = self.name.split_once(':').map_or("", |(_, own)| own);
        let named = |name: &String| *name == self.name || name == own;
        let of_both =
            |(a, b): (&String, &String)| (*a == membrane.name && named(b)) || (*b == membrane.name && named(a));
        let mut listed = setup.friction.iter().filter(|(a, b, _)| of_both((a, b)));
        listed.all(|(_, _, friction)| *friction != Friction::None)
    }

    /// Distance of `x` [m] and the normal, after the solid has moved.
    fn distance(&self, x: Vector<D>, moved: Vector<D>) -> (f64, Vector<D>) {
        match &self.surface {
            MeetingSurface::Plane(normal, place) => (x.dot(*normal) - place, *normal),
            MeetingSurface::Region(region) => {
                let (distance, normal) = region.distance_and_normal((x - moved).to3());
                (distance, Vector::from3(normal))
            }
        }
    }

    fn moved(&self, time: f64) -> Vector<D> {
        let (before, part) = (time.floor() as usize, time.fract());
        match (self.way.get(before), self.way.get(before + 1)) {
            (Some(&from), Some(&to)) => from + (to - from) * part,
            _ => self.way.last().copied().unwrap_or_default(),
        }
    }
}

/// Two solids along their ways, with a sheet between them.
struct Search<'a, const D: usize> {
    solids: [&'a MovingSolid<'a, D>; 2],
    /// Sum of the distances that both have moved at the times at which their ways are known [m].
    travelled: Vec<f64>,
    /// Time between two of them [s].
    interval: f64,
    /// Half the thickness in contact, the sum of the distances that is too small, the longest and the shortest push
    /// [m].
    half: f64,
    limit: f64,
    push: [f64; 2],
}

/// A node without a way out.
struct ClosingPlace<const D: usize> {
    time: f64,
    place: Vector<D>,
    distance: f64,
}

impl<'a, const D: usize> Search<'a, D> {
    /// `None` where the two don't move against each other, or nobody can foresee how.
    fn new(solids: [&'a MovingSolid<'a, D>; 2], membrane: &MembraneSetup<D>, cell: f64, end: f64) -> Option<Self> {
        let thickness = if membrane.contact_thickness { membrane.thickness } else { 0.0 };
        let known = (UNKNOWN * thickness).max(OVERLAP * cell);
        let at = |n: usize| solids.map(|solid| solid.moved(n as f64));
        let apart = |n: usize| {
            let [a, b] = at(n);
            (a - b).norm()
        };
        let against = (0..=TIMES).map(apart).fold(0.0, f64::max);
        if !solids.iter().all(|solid| solid.unknown <= known) || against <= known {
            return None;
        }
        let step = |n: usize| {
            let ([a, b], [c, d]) = (at(n), at(n + 1));
            (c - a).norm() + (d - b).norm()
        };
        let mut sum = 0.0;
        let travelled = std::iter::once(0.0)
            .chain((0..TIMES).map(|n| {
                sum += step(n);
                sum
            }))
            .collect();
        let limit = (1.0 - MISSING) * thickness - if thickness == 0.0 { OVERLAP * cell } else { 0.0 };
        let least = (LEAST_PUSH[0] * thickness).max(LEAST_PUSH[1] * cell);
        let (interval, push) = (end / TIMES as f64, [(PUSH * cell).max(least), least]);
        Some(Self { solids, travelled, interval, half: 0.5 * thickness, limit, push })
    }

    /// The earliest of the places where free nodes of a membrane have no way out.
    fn first(&self, membrane: &MembraneSetup<D>, looks: &mut usize) -> Option<ClosingPlace<D>> {
        let mut free = vec![true; membrane.position.len()];
        membrane.supports.iter().flat_map(|support| &support.nodes).for_each(|&node| free[node as usize] = false);
        let nodes = membrane.position.iter().zip(free).filter(|(_, free)| *free);
        let found = nodes.filter_map(|(&x, _)| self.follow(x, looks));
        found.reduce(|first, other| if other.time < first.time { other } else { first })
    }

    /// Follows a node from its start at `x` [m].
    fn follow(&self, mut x: Vector<D>, looks: &mut usize) -> Option<ClosingPlace<D>> {
        let whole = self.travelled.last().copied().unwrap_or(0.0);
        let mut way = 0.0;
        loop {
            let time = self.time(way);
            let [a, b] = self.solids.map(|solid| solid.distance(x, solid.moved(time)));
            let distance = a.0 + b.0;
            if a.1.dot(b.1) < OPPOSITE && distance < self.limit {
                return Some(ClosingPlace { time: time * self.interval, place: x, distance });
            }
            *looks = looks.checked_sub(1)?;
            if way >= whole {
                return None;
            }
            for (distance, normal) in [a, b] {
                x += normal * (self.half - distance).max(0.0);
            }
            let alone = (a.0.min(b.0) - self.half).max(self.push[0]);
            way = whole.min(way + (distance - self.limit).min(alone).max(self.push[1]));
        }
    }

    /// The time [intervals] at which the two have moved so far [m].
    fn time(&self, way: f64) -> f64 {
        let after = self.travelled.partition_point(|&travelled| travelled <= way).clamp(1, TIMES);
        let [from, to] = [self.travelled[after - 1], self.travelled[after]];
        let part = if to > from { ((way - from) / (to - from)).min(1.0) } else { 0.0 };
        (after - 1) as f64 + part
    }
}

impl<const D: usize> ClosingPlace<D> {
    fn warning(&self, [first, second]: [&MovingSolid<'_, D>; 2], membrane: &MembraneSetup<D>) -> Diagnostic {
        let (a, b, sheet, t, place) =
            (&first.name, &second.name, &membrane.name, self.time, super::coordinates(&self.place));
        let message = if membrane.contact_thickness {
            format!(
                "`{a}` and `{b}` close on `{sheet}`: at t = {t:.3e} s they are {:.3e} m apart at ({place}), less than its thickness of \
                 {:.3e} m",
                self.distance, membrane.thickness
            )
        } else {
            format!("`{a}` and `{b}` close on `{sheet}`: at t = {t:.3e} s they meet at ({place})")
        };
        let mover = if second.way.is_empty() { first } else { second };
        let help = "the run stops there, unless the sheet has left by then: keep them apart by its thickness, or end the run before \
                    (`time.end`)";
        Diagnostic::warning(mover.key.clone(), message).help(help)
    }
}
