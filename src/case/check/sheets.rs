//! Membranes with their supports, and at planes of symmetry.

use crate::error::Diagnostic;
use crate::math::{Signal, Vector};
use crate::mpm::{MembraneSetup, Setup, WallKind};

/// Nodes this far from a plane [cells] lie on it.
const ON_PLANE: f64 = 1e-6;

/// Where supports share a node, they agree about its motion.
pub(super) fn supports<const D: usize>(setup: &Setup<D>, findings: &mut Vec<Diagnostic>) {
    for (i, membrane) in setup.membranes.iter().enumerate() {
        let mut given: Vec<[Option<(usize, &Signal)>; 3]> = vec![[None; 3]; membrane.position.len()];
        for (j, support) in membrane.supports.iter().enumerate() {
            let conflict = support.nodes.iter().find_map(|&node| {
                (0..D).find_map(|axis| {
                    let new = support.velocity[axis].as_ref()?;
                    let (other, old) = given[node as usize][axis].replace((j, new))?;
                    (old != new).then_some((node, axis, other))
                })
            });
            if let Some((node, axis, other)) = conflict {
                let axis = ["x", "y", "z"][axis];
                let message = format!("supports[{other}] moves node {node} along {axis} with another velocity");
                let finding = Diagnostic::error(format!("membrane[{i}].supports[{j}]"), message);
                findings.push(finding.help("write \"free\" for that axis in one of them, or choose other nodes"));
            }
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

/// Which nodes a support holds or moves along `axis`.
fn held<const D: usize>(membrane: &MembraneSetup<D>, axis: usize) -> Vec<bool> {
    let mut held = vec![false; membrane.position.len()];
    let supports = membrane.supports.iter().filter(|support| support.velocity[axis].is_some());
    supports.flat_map(|support| &support.nodes).for_each(|&node| held[node as usize] = true);
    held
}

/// A node this deep in an obstacle, beyond half the thickness [cells], lies in it.
const INSIDE: f64 = 1e-3;

/// No node of a membrane starts in an obstacle: free ones would be parted from it, slowly, held ones never.
pub(super) fn obstacles<const D: usize>(setup: &Setup<D>, findings: &mut Vec<Diagnostic>) {
    for (i, membrane) in setup.membranes.iter().enumerate() {
        let mut free = vec![true; membrane.position.len()];
        let held = membrane.supports.iter().filter(|support| support.velocity.iter().take(D).any(Option::is_some));
        held.flat_map(|support| &support.nodes).for_each(|&node| free[node as usize] = false);
        let depth = 0.5 * membrane.thickness + INSIDE * setup.grid.cell;
        for obstacle in &setup.obstacles {
            let inside = |x: &Vector<D>| obstacle.region.signed_distance(x.to3()) < -depth;
            let count = |which: bool| {
                membrane.position.iter().zip(&free).filter(|(x, free)| **free == which && inside(x)).count()
            };
            let (loose, held) = (count(true), count(false));
            let (name, other) = (&membrane.name, &obstacle.name);
            if loose > 0 {
                let message = format!("{loose} free nodes of `{name}` lie in the obstacle `{other}`");
                let finding = Diagnostic::error(format!("membrane[{i}].geometry"), message);
                findings.push(finding.help("move one of the two apart: they may touch"));
            }
            if held > 0 {
                let message = format!("supports hold {held} nodes of `{name}` in the obstacle `{other}`");
                let finding = Diagnostic::warning(format!("membrane[{i}].supports"), message);
                findings.push(finding.help("the obstacle can't push these nodes out: the sheet stays in it there"));
            }
        }
    }
}
