//! What flows through the boundary.

use super::super::Assembly;
use crate::error::Diagnostic;
use crate::math::{Signal, Vector};
use crate::mesh::{Facet, Mesh};
use crate::pfem2::boundary::{BoundarySetup, Condition};

/// Share of a wall's velocity that may be across it: what the rounding of a formula leaves.
const ACROSS: f64 = 1e-6;

impl Assembly<'_> {
    /// The mesh stays where it is: a flat wall can only slide along itself.
    pub(super) fn through_walls<const D: usize, const N: usize>(
        &mut self,
        mesh: &Mesh<D, N>,
        sets: &[BoundarySetup<D>],
    ) {
        for (i, (set, spec)) in sets.iter().zip(&self.case.file.boundary).enumerate() {
            let Condition::Wall(velocity) = &set.condition else { continue };
            let named = spec.on.list().into_iter().filter_map(|name| Some((name, mesh.sets.get(name)?)));
            let flat = named.filter(|(_, facets)| is_flat(mesh, facets));
            let across = flat.flat_map(|(name, facets)| facets.iter().map(move |&facet| (name, facet)));
            let Some((name, t)) = across
                .flat_map(|(name, facet)| self.times().map(move |t| (name, facet, t)))
                .find(|&(_, facet, t)| {
                    let (through, most) = flux(mesh, facet, velocity, t);
                    through.abs() > ACROSS * most
                })
                .map(|(name, _, t)| (name, t))
            else {
                continue;
            };
            let message = format!(
                "the velocity of the wall `{name}` has a part across it at t = {t} s: it would let fluid through"
            );
            let help = "the mesh does not move: a wall slides along itself; `kind = \"inlet\"` lets fluid in or out";
            self.findings.push(Diagnostic::error(format!("boundary[{i}].velocity"), message).help(help));
        }
    }

    /// Times at which velocities are tried out [s].
    fn times(&self) -> impl Iterator<Item = f64> + use<> {
        let end = self.case.file.time.end;
        (0..=16).map(move |i| end * f64::from(i) / 16.0)
    }

    /// What flows in must be able to leave.
    pub(super) fn through_flow<const D: usize, const N: usize>(
        &mut self,
        mesh: &Mesh<D, N>,
        sets: &[BoundarySetup<D>],
    ) {
        let is_open =
            |c: &Condition<D>| matches!(c, Condition::Outlet | Condition::Traction(_) | Condition::Pressure(_));
        if sets.iter().any(|set| is_open(&set.condition)) {
            return;
        }
        for t in self.times() {
            let (mut net, mut all) = (0.0, 0.0);
            for set in sets {
                let (Condition::Inlet(v) | Condition::Wall(v)) = &set.condition else { continue };
                for &facet in &set.facets {
                    let (through, most) = flux(mesh, facet, v, t);
                    (net, all) = (net + through, all + most);
                }
            }
            // A closed box can't take in what the rounding of a formula leaves, of a wall that turns as well.
            if net.abs() > 1e-6 * all {
                let first = sets.iter().position(|set| matches!(set.condition, Condition::Inlet(_))).unwrap_or(0);
                let rate = if D == 2 { "m²/s" } else { "m³/s" };
                let message = format!("{:.4e} {rate} flow in at t = {t} s, but nothing lets them out", -net);
                let finding = Diagnostic::error(format!("boundary[{first}]"), message);
                self.findings.push(finding.help("add a boundary with `kind = \"outlet\"`"));
                return;
            }
        }
    }
}

/// Flux through a facet at its nodes' mean velocity, outward, and what it would be if they all moved across [m³/s].
fn flux<const D: usize, const N: usize>(mesh: &Mesh<D, N>, facet: Facet, v: &[Signal; D], t: f64) -> (f64, f64) {
    let (area, nodes) = (mesh.facet_area(facet), mesh.facet_nodes(facet));
    let velocity = |node: &u32| Vector::<D>::from_fn(|i| v[i].value(mesh.nodes()[*node as usize].to3(), t));
    let sum = |measure: &dyn Fn(Vector<D>) -> f64| nodes.iter().map(velocity).map(measure).sum::<f64>();
    let count = nodes.len() as f64;
    (sum(&|v| v.dot(area)) / count, sum(&|v| v.norm() * area.norm()) / count)
}

/// True if all facets have one normal.
fn is_flat<const D: usize, const N: usize>(mesh: &Mesh<D, N>, facets: &[Facet]) -> bool {
    let normals = || facets.iter().filter_map(|&facet| mesh.facet_area(facet).normalized());
    let Some(first) = normals().next() else { return false };
    normals().all(|normal| (normal - first).norm() < 1e-6)
}
