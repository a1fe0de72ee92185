//! Checks of openings: inflow and outflow through the boundary.

use super::super::Construction;
use super::mesh::{at, middle};
use crate::error::Diagnostic;
use crate::math::{Signal, Vector};
use crate::mesh::{Facet, Mesh};
use crate::pfem2::boundary::BoundarySetup;
use std::collections::HashMap;

/// Part of a wall's velocity that may be normal to it, as the rounding error of a formula.
const ACROSS: f64 = 1e-6;

/// Fraction of the extent of the mesh along gravity above which an open part is tall.
const TALL: f64 = 0.01;

impl Construction<'_> {
    /// The mesh stays where it is: a wall can only slide along itself.
    pub(super) fn through_walls<const D: usize, const N: usize>(
        &mut self,
        mesh: &Mesh<D, N>,
        sets: &[BoundarySetup<D>],
    ) {
        for (i, (set, spec)) in sets.iter().zip(&self.case.file.boundary).enumerate() {
            if set.condition.kind().admits_flow() {
                continue;
            }
            let Some(velocity) = set.condition.velocity_formula() else { continue };
            if velocity.iter().all(Signal::is_zero) {
                continue;
            }
            let bends = bends(mesh, &set.facets);
            let crossed = set.facets.iter().zip(bends).find_map(|(&facet, bend)| {
                let t = self.times().find(|&t| {
                    let (through, most) = flux(mesh, facet, velocity, t);
                    through.abs() > (ACROSS + bend) * most
                })?;
                Some((facet, t))
            });
            let Some((facet, t)) = crossed else { continue };
            let holds = |name: &&str| mesh.sets.get(*name).is_some_and(|facets| facets.contains(&facet));
            let name = spec.on.list().into_iter().find(holds).unwrap_or(&set.name);
            let message = format!(
                "the velocity of the wall `{name}` has a part across it at t = {t} s, first at ({}): it would let fluid \
                 through",
                at(middle(mesh, facet))
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

    /// An inflow needs an outflow somewhere.
    pub(super) fn through_flow<const D: usize, const N: usize>(
        &mut self,
        mesh: &Mesh<D, N>,
        sets: &[BoundarySetup<D>],
    ) {
        if sets.iter().any(|set| set.condition.kind().has_free_flux()) {
            return;
        }
        for t in self.times() {
            let (mut net, mut all) = (0.0, 0.0);
            for set in sets {
                let Some(v) = set.condition.velocity_formula() else { continue };
                for &facet in &set.facets {
                    let (through, most) = flux(mesh, facet, v, t);
                    (net, all) = (net + through, all + most);
                }
            }
            // The net flux from the rounding errors of formulas is no inflow, also for rotating walls.
            if net.abs() > 1e-6 * all {
                let first = sets.iter().position(|set| set.condition.kind().prescribes_inflow()).unwrap_or(0);
                let rate = if D == 2 { "m²/s" } else { "m³/s" };
                let message = format!("{:.4e} {rate} flow in at t = {t} s, but nothing lets them out", -net);
                let finding = Diagnostic::error(format!("boundary[{first}]"), message);
                self.findings.push(finding.help("add a boundary with `kind = \"outlet\"`"));
                return;
            }
        }
    }
}

impl Construction<'_> {
    /// Under one pressure a side that is open along gravity lets fluid fall out below and come in above.
    pub(super) fn falling_out<const D: usize, const N: usize>(
        &mut self,
        mesh: &Mesh<D, N>,
        sets: &[BoundarySetup<D>],
        gravity: &[Signal],
        density: f64,
    ) {
        for (i, set) in sets.iter().enumerate() {
            let nodes = set.facets.iter().flat_map(|&facet| mesh.facet_nodes(facet));
            let places: Vec<Vector<D>> = nodes.map(|node| mesh.nodes()[node as usize]).collect();
            let Some(&first) = places.first() else { continue };
            let pressure = |x: Vector<D>, t: f64| set.condition.outside_pressure(x, t);
            let same = |t: f64| places.iter().all(|&x| pressure(x, t) == pressure(first, t));
            if !set.condition.prescribes_pressure() || !self.times().all(same) {
                continue;
            }
            let pull = |t| Vector::<D>::from_fn(|axis| gravity[axis].value(first.to3(), t));
            let Some(pull) = self.times().map(pull).find(|pull| pull.norm() > 0.0) else { continue };
            let down = pull / pull.norm();
            let extent = |nodes: &mut dyn Iterator<Item = Vector<D>>| {
                let (low, high) = nodes.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
                    (low.min(x.dot(down)), high.max(x.dot(down)))
                });
                high - low
            };
            let open = extent(&mut places.iter().copied());
            if open > TALL * extent(&mut mesh.nodes().iter().copied()) {
                self.falls(i, &set.name, open, hydrostatic(mesh, pull, density));
            }
        }
    }

    fn falls(&mut self, i: usize, name: &str, open: f64, recipe: String) {
        let message = format!(
            "`{name}` is open over {open:.3} m along gravity under one pressure: fluid falls out below and comes in above"
        );
        let help = format!(
            "let the pressure outside grow with the depth below the surface: `kind = \"pressure\"` and {recipe}, with the \
             density of each fluid over its own height where there are two"
        );
        self.findings.push(Diagnostic::warning(format!("boundary[{i}].kind"), message).help(help));
    }
}

/// A pressure in balance with gravity in a fluid that fills the mesh, as a case says it.
fn hydrostatic<const D: usize, const N: usize>(mesh: &Mesh<D, N>, pull: Vector<D>, density: f64) -> String {
    let Some(axis) = (0..D).find(|&axis| pull[axis].abs() > (1.0 - ACROSS) * pull.norm()) else {
        return "`pressure` a formula in x, y and z".to_owned();
    };
    let (places, size) = (mesh.nodes().iter().map(|x| x[axis]), pull[axis].abs());
    let coordinate = ["x", "y", "z"][axis];
    let depth = if pull[axis] < 0.0 {
        format!("{} - {coordinate}", places.fold(f64::NEG_INFINITY, f64::max))
    } else {
        match places.fold(f64::INFINITY, f64::min) {
            0.0 => coordinate.to_owned(),
            lowest => format!("{coordinate} - {lowest}"),
        }
    };
    format!("`pressure = \"{density} * {size} * ({depth})\"`")
}

/// Outward flux through a facet at its nodes' mean velocity, and the flux if all velocities were normal to it [m³/s].
fn flux<const D: usize, const N: usize>(mesh: &Mesh<D, N>, facet: Facet, v: &[Signal; D], t: f64) -> (f64, f64) {
    let (area, nodes) = (mesh.facet_area(facet), mesh.facet_nodes(facet));
    let velocity = |node: &u32| Vector::<D>::from_fn(|i| v[i].value(mesh.nodes()[*node as usize].to3(), t));
    let sum = |measure: &dyn Fn(Vector<D>) -> f64| nodes.iter().map(velocity).map(measure).sum::<f64>();
    let count = nodes.len() as f64;
    (sum(&|v| v.dot(area)) / count, sum(&|v| v.norm() * area.norm()) / count)
}

/// The difference between the unit normals of each facet and of its neighbours: a round wall that turns moves along
/// itself up to that. Facets that meet at more than 45° are different walls.
fn bends<const D: usize, const N: usize>(mesh: &Mesh<D, N>, facets: &[Facet]) -> Vec<f64> {
    const EDGE: f64 = 0.765; // 2 sin(45°/2)
    let normals: Vec<Vector<D>> =
        facets.iter().map(|&facet| mesh.facet_area(facet).normalized().unwrap_or_default()).collect();
    let mut around: HashMap<u32, Vec<usize>> = HashMap::new();
    for (k, &facet) in facets.iter().enumerate() {
        mesh.facet_nodes(facet).into_iter().for_each(|node| around.entry(node).or_default().push(k));
    }
    let bend = |(k, &facet): (usize, &Facet)| {
        let nodes = mesh.facet_nodes(facet);
        let met = nodes.iter().flat_map(|node| &around[node]).map(|&other| (normals[k] - normals[other]).norm());
        met.filter(|&difference| difference < EDGE).fold(0.0, f64::max)
    };
    facets.iter().enumerate().map(bend).collect()
}
