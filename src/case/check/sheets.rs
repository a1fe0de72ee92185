//! Membranes with their supports, and at planes of symmetry.

use crate::case::Case;
use crate::case::membrane::HourglassSpec;
use crate::error::Diagnostic;
use crate::math::{Signal, Vector};
use crate::mpm::{MembraneSetup, Obstacle, Setup, WallKind};
use std::fmt;

/// Nodes this far from a plane [cells] lie on it.
const ON_PLANE: f64 = 1e-6;

/// Sheets that wrinkle have 2 × 2 points in a quadrilateral instead of an hourglass stiffness. (A resolved case that is
/// run again gives the default.)
pub(super) fn idle_stiffness(case: &Case, findings: &mut Vec<Diagnostic>) {
    for (i, spec) in case.file.membrane.iter().enumerate().filter(|(_, spec)| spec.material.as_dyn().wrinkles()) {
        let (key, stiffness) = (format!("membrane[{i}].hourglass.stiffness"), spec.hourglass.stiffness);
        if stiffness == 0.0 || !case.says(&key) {
            continue;
        }
        let message = "has no effect: quadrilaterals of a sheet that wrinkles have 2 × 2 points instead";
        let finding = match stiffness == HourglassSpec::default().stiffness {
            true => Diagnostic::warning(key, message),
            false => Diagnostic::error(key, message),
        };
        findings.push(finding.help("take it out, or the material's `wrinkling`"));
    }
}

/// Checks that supports that share a node prescribe the same motion.
pub(super) fn supports<const D: usize>(setup: &Setup<D>, findings: &mut Vec<Diagnostic>) {
    for (i, membrane) in setup.membranes.iter().enumerate() {
        let supports: Vec<_> =
            membrane.supports.iter().map(|support| (&support.nodes[..], &support.velocity[..D])).collect();
        conflicts(&format!("membrane[{i}]"), membrane.position.len(), &supports, findings);
    }
}

/// Checks that supports of the part `key`, nodes with a velocity per axis, that share one of `count` nodes prescribe
/// the same motion.
pub(super) fn conflicts(
    key: &str,
    count: usize,
    supports: &[(&[u32], &[Option<Signal>])],
    findings: &mut Vec<Diagnostic>,
) {
    let mut given: Vec<[Option<(usize, &Signal)>; 3]> = vec![[None; 3]; count];
    for (j, (nodes, velocity)) in supports.iter().enumerate() {
        let conflict = nodes.iter().find_map(|&node| {
            (0..velocity.len()).find_map(|axis| {
                let new = velocity[axis].as_ref()?;
                let (other, old) = given[node as usize][axis].replace((j, new))?;
                (old != new).then_some((node, axis, other))
            })
        });
        if let Some((node, axis, other)) = conflict {
            let axis = ["x", "y", "z"][axis];
            let message = format!("supports[{other}] moves node {node} along {axis} with another velocity");
            let finding = Diagnostic::error(format!("{key}.supports[{j}]"), message);
            findings.push(finding.help("write \"free\" for that axis in one of them, or choose other nodes"));
        }
    }
}

/// A membrane that ends on a wall of kind `slip` needs supports there: the wall itself holds bodies only.
pub(super) fn planes_of_symmetry<const D: usize>(setup: &Setup<D>, findings: &mut Vec<Diagnostic>) {
    let grid = &setup.grid;
    for (i, membrane) in setup.membranes.iter().enumerate() {
        for (axis, end) in (0..D).flat_map(|axis| [(axis, 0), (axis, 1)]) {
            if grid.walls[axis][end].kind != WallKind::Slip {
                continue;
            }
            let held = held(membrane, axis);
            let plane = grid.lower[axis] + (end as f64) * f64::from(grid.cells[axis]) * grid.cell;
            let loose = |k: &usize| (membrane.position[*k][axis] - plane).abs() < ON_PLANE * grid.cell;
            let loose = (0..membrane.position.len()).filter(|k| !held[*k] && loose(k)).count();
            if loose > 0 {
                let name = ["x", "y", "z"][axis];
                let message = format!(
                    "{loose} nodes of `{}` on the plane of symmetry {name} = {plane} m are free to leave it",
                    membrane.name
                );
                let finding = Diagnostic::warning(format!("membrane[{i}].geometry"), message);
                let help = format!(
                    "the wall keeps them from crossing it, not from leaving: hold these nodes along {name} with `supports`"
                );
                findings.push(finding.help(help));
            }
        }
    }
}

/// The nodes that a support holds or moves along `axis`.
fn held<const D: usize>(membrane: &MembraneSetup<D>, axis: usize) -> Vec<bool> {
    let mut held = vec![false; membrane.position.len()];
    let supports = membrane.supports.iter().filter(|support| support.velocity[axis].is_some());
    supports.flat_map(|support| &support.nodes).for_each(|&node| held[node as usize] = true);
    held
}

/// A node this deep in an obstacle, beyond half the thickness [cells], lies in it.
const INSIDE: f64 = 1e-3;

/// A node is held along a normal if the axes that are free take up less than this of it.
const HELD: f64 = 1e-6;

/// No node of a membrane starts in an obstacle: free ones would be parted from it, slowly, held ones never. And no
/// element has an obstacle between its nodes.
pub(super) fn obstacles<const D: usize>(setup: &Setup<D>, findings: &mut Vec<Diagnostic>) {
    for (i, membrane) in setup.membranes.iter().enumerate() {
        let held: [Vec<bool>; D] = std::array::from_fn(|axis| held(membrane, axis));
        for obstacle in &setup.obstacles {
            let [mut loose, mut stuck] = [Inside::default(); 2];
            for (k, x) in membrane.position.iter().enumerate() {
                let (distance, normal) = obstacle.region.distance_and_normal(x.to3());
                let free: f64 = (0..D).filter(|&axis| !held[axis][k]).map(|axis| normal[axis] * normal[axis]).sum();
                let depth = -distance;
                if depth > 0.5 * membrane.thickness + INSIDE * setup.grid.cell {
                    let nodes = if free < HELD { &mut stuck } else { &mut loose };
                    nodes.add(depth, *x);
                }
            }
            let (name, other) = (&membrane.name, &obstacle.name);
            if loose.count > 0 {
                let message = format!("{} free nodes of `{name}` lie in the obstacle `{other}`, {loose}", loose.count);
                let finding = Diagnostic::error(format!("membrane[{i}].geometry"), message);
                findings.push(finding.help("move one of the two apart: they may touch"));
            } else if let Some((x, y)) = pierced(membrane, obstacle, INSIDE * setup.grid.cell) {
                let [x, y] = [x, y].map(|x| super::coordinates(&x));
                let message =
                    format!("`{name}` goes through the obstacle `{other}`, between its nodes at ({x}) and ({y})");
                let finding = Diagnostic::error(format!("membrane[{i}].geometry"), message);
                findings.push(finding.help("move one of the two apart: they may touch"));
            }
            if stuck.count > 0 {
                let message =
                    format!("supports hold {} nodes of `{name}` in the obstacle `{other}`, {stuck}", stuck.count);
                let finding = Diagnostic::warning(format!("membrane[{i}].supports"), message);
                findings.push(finding.help(
                    "the obstacle can't push these nodes out: the sheet stays in it there, pressed for ever; right where the obstacle \
                     clamps it, else hold it outside",
                ));
            }
        }
    }
}

/// Nodes in an obstacle.
#[derive(Debug, Clone, Copy, Default)]
struct Inside<const D: usize> {
    count: usize,
    /// The greatest depth [m], and where it is [m].
    depth: f64,
    place: Vector<D>,
}

impl<const D: usize> Inside<D> {
    fn add(&mut self, depth: f64, place: Vector<D>) {
        self.count += 1;
        if depth > self.depth {
            (self.depth, self.place) = (depth, place);
        }
    }
}

impl<const D: usize> fmt::Display for Inside<D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the deepest at ({}), {:.3e} m below its surface", super::coordinates(&self.place), self.depth)
    }
}

/// Two neighbours on opposite sides of an obstacle that the side between them goes through: deeper than `depth` [m]. (A
/// chord of what a sheet hugs dips into it, too, but the normals at its ends agree.)
fn pierced<const D: usize>(
    membrane: &MembraneSetup<D>,
    obstacle: &Obstacle,
    depth: f64,
) -> Option<(Vector<D>, Vector<D>)> {
    let at = |x: Vector<D>| obstacle.region.distance_and_normal(x.to3());
    let through = |[a, b]: [Vector<D>; 2]| {
        let [start, end] = [a, b].map(at);
        let length = (b - a).norm();
        let opposite = (0..D).map(|axis| start.1[axis] * end.1[axis]).sum::<f64>() < 0.0;
        // Two balls without an obstacle, around the ends, that leave nothing between them.
        opposite && start.0.min(end.0) > -depth && start.0 + end.0 < length && deepest([a, b], at, depth) > depth
    };
    let sides = membrane.elements.iter().flat_map(|nodes| {
        let count = if nodes.len() == 2 { 1 } else { nodes.len() };
        (0..count).map(|k| [nodes[k], nodes[(k + 1) % nodes.len()]].map(|node| membrane.position[node as usize]))
    });
    sides.into_iter().find(|&side| through(side)).map(|[a, b]| (a, b))
}

/// Greatest depth of a side in an obstacle [m]. Steps along the side are as long as the distance to the surface, within
/// which no point can be on its other side, and at least `least` [m].
fn deepest<const D: usize>([a, b]: [Vector<D>; 2], at: impl Fn(Vector<D>) -> (f64, [f64; 3]), least: f64) -> f64 {
    let (length, mut s, mut deepest) = ((b - a).norm(), 0.0, 0.0_f64);
    while s < length {
        let distance = at(a + (b - a) * (s / length)).0;
        deepest = deepest.max(-distance);
        s += distance.abs().max(least);
    }
    deepest
}
