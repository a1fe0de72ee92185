//! The level φ_in of what flows in: that of the state at the start, or of the fluid that a boundary names (theory G.4).
//!
//! ```text
//! cut facet     φ_in = φ₀/|∇_s φ₀|             ∇_s: along the facet
//! other facets  φ_in = ± the distance from where two fluids meet on the boundary
//! ```
//!
//! It depends on the start alone. Taken from the line as it is, a deviation at an inlet would come in again and grow:
//! through flow is uniform, and nothing else holds the line there.

use crate::math::Vector;
use crate::mesh::{Facet, Mesh};
use crate::pfem2::cut_element::{corners, is_cut};
use crate::pfem2::particles::convect::MeshPoint;
use std::collections::BTreeMap;

/// Farther than any place where fluids meet [m].
const BEYOND_ALL: f64 = 1e30;

/// The fluid that a facet of the boundary brings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InflowFluid {
    /// Nothing.
    Nothing,
    /// The fluid of each place at the start.
    Start,
    /// A fluid with a name: true for the one inside.
    Named(bool),
}

/// φ_in at the corners of each facet of [`Mesh::boundary`] [m]; `None` where nothing comes in.
/// `level` is φ at the nodes at the start [m].
pub fn brought<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    level: &[f64],
    inflow: &[InflowFluid],
) -> Vec<Option<[f64; D]>> {
    let first = |(&facet, inflow): (&Facet, &InflowFluid)| match inflow {
        InflowFluid::Nothing => None,
        InflowFluid::Start => Some(nodes_of(mesh, facet).map(|node| level[node as usize])),
        InflowFluid::Named(inside) => Some([if *inside { -BEYOND_ALL } else { BEYOND_ALL }; D]),
    };
    let first: Vec<Option<[f64; D]>> = mesh.boundary().iter().zip(inflow).map(first).collect();
    let meetings = meetings(mesh, &first);
    let scaled = |(&facet, first): (&Facet, &Option<[f64; D]>)| {
        let phi = (*first)?;
        if is_cut(&phi) {
            let slope = slope(mesh, facet, &phi);
            return Some(phi.map(|phi| phi / slope));
        }
        let x = nodes_of(mesh, facet).map(|node| mesh.nodes()[node as usize]);
        let away = x.map(|x| meetings.iter().map(|ends| distance(ends, x)).fold(BEYOND_ALL, f64::min));
        Some(if is_inside(&phi) { away.map(|away| -away) } else { away })
    };
    mesh.boundary().iter().zip(&first).map(scaled).collect()
}

/// φ_in at a place on a facet of the boundary, with its values at the corners of that facet [m].
pub fn on_facet<const D: usize, const N: usize>(facet: Facet, corners: &[f64; D], place: &MeshPoint<N>) -> f64 {
    let local = (0..N).filter(|&k| k != facet.opposite as usize);
    local.zip(corners).map(|(k, phi)| place.shape[k] * phi).sum()
}

/// Lines between fluids on the boundary: points (2D) or segments (3D), by their ends [m].
fn meetings<const D: usize, const N: usize>(mesh: &Mesh<D, N>, level: &[Option<[f64; D]>]) -> Vec<[Vector<D>; 2]> {
    let mut found = Vec::new();
    let mut sides: BTreeMap<Vec<u32>, [bool; 2]> = BTreeMap::new();
    let x = |node: u32| mesh.nodes()[node as usize];
    for (&facet, level) in mesh.boundary().iter().zip(level) {
        let Some(phi) = level else { continue };
        let (nodes, cut) = (nodes_of(mesh, facet), is_cut(phi));
        if cut {
            let place = |shape: &[f64; D]| (0..D).map(|k| x(nodes[k]) * shape[k]).sum::<Vector<D>>();
            let points: Vec<Vector<D>> = corners(phi).iter().map(place).collect();
            found.extend(points.first().zip(points.last()).map(|(a, b)| [*a, *b]));
        }
        for k in 0..D {
            let rest = (0..D).filter(|&j| j != k);
            let negative = rest.clone().filter(|&j| if cut { phi[j] < 0.0 } else { is_inside(phi) }).count();
            let mut ridge: Vec<u32> = rest.map(|j| nodes[j]).collect();
            ridge.sort_unstable();
            // The line crosses what has both sides.
            if negative == 0 || negative == ridge.len() {
                sides.entry(ridge).or_default()[usize::from(negative > 0)] = true;
            }
        }
    }
    let between = sides.iter().filter(|(_, sides)| **sides == [true; 2]);
    found.extend(between.filter_map(|(ridge, _)| Some([x(*ridge.first()?), x(*ridge.last()?)])));
    found
}

/// True if a facet that isn't cut lies in the fluid inside.
fn is_inside<const D: usize>(level: &[f64; D]) -> bool {
    level.iter().sum::<f64>() < 0.0
}

/// |∇_s φ| of the linear φ on a facet.
fn slope<const D: usize, const N: usize>(mesh: &Mesh<D, N>, facet: Facet, phi: &[f64; D]) -> f64 {
    let local = (0..N).filter(|&k| k != facet.opposite as usize);
    let gradients = &mesh.simplex(facet.element as usize).gradient;
    let gradient: Vector<D> = local.zip(phi).map(|(k, phi)| gradients[k] * *phi).sum();
    let normal = gradients[facet.opposite as usize];
    (gradient - normal * (gradient.dot(normal) / normal.norm_squared())).norm()
}

/// Distance of a place from a segment between two ends [m].
fn distance<const D: usize>([a, b]: &[Vector<D>; 2], x: Vector<D>) -> f64 {
    let (along, away) = (*b - *a, x - *a);
    let length = along.norm_squared();
    let t = if length > 0.0 { (away.dot(along) / length).clamp(0.0, 1.0) } else { 0.0 };
    (away - along * t).norm()
}

/// The nodes of a facet, in the order of its element's.
fn nodes_of<const D: usize, const N: usize>(mesh: &Mesh<D, N>, facet: Facet) -> [u32; D] {
    let nodes = &mesh.elements()[facet.element as usize];
    std::array::from_fn(|j| nodes[j + usize::from(j >= facet.opposite as usize)])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// On the side x = 0 of a block: φ_in of every facet at its middle, with the middle.
    fn on_the_left<const D: usize, const N: usize>(
        mesh: &Mesh<D, N>,
        level: &[f64],
        inflow: impl Fn(Vector<D>) -> InflowFluid,
    ) -> Vec<(Vector<D>, f64)> {
        let middle = |facet: &Facet| {
            nodes_of(mesh, *facet).iter().map(|&node| mesh.nodes()[node as usize]).sum::<Vector<D>>() / D as f64
        };
        let of = |facet: &Facet| if middle(facet)[0] == 0.0 { inflow(middle(facet)) } else { InflowFluid::Nothing };
        let inflow: Vec<InflowFluid> = mesh.boundary().iter().map(of).collect();
        let found = brought(mesh, level, &inflow);
        let facets = mesh.boundary().iter().zip(found);
        facets.filter_map(|(f, phi)| phi.map(|phi| (middle(f), phi.iter().sum::<f64>() / D as f64))).collect()
    }

    /// φ₀ is that of a jet that ends a hair behind the inlet: only its edges count.
    #[test]
    fn a_jet_has_the_distance_from_its_edges() {
        let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector([2.0, 1.0]), [20, 10]).unwrap();
        let jet = |x: Vector<2>| (x[0] - 0.01).max(((x[1] - 0.5).abs() - 0.23) * 0.3);
        let level: Vec<f64> = mesh.nodes().iter().map(|&x| jet(x)).collect();
        let found = on_the_left(&mesh, &level, |_| InflowFluid::Start);
        assert_eq!(found.len(), 10);
        for (x, phi) in found {
            // The nodes beside an edge have −0.009 and 0.021, or −0.01 and 0.021 where the end of the jet is nearer.
            let exact = (x[1] - 0.5).abs() - 0.23;
            assert!((phi - exact).abs() < 1e-2 && phi * exact > 0.0, "{x:?}: {phi} {exact}");
        }
    }

    #[test]
    fn named_fluids_have_the_distance_from_where_they_meet() {
        let mesh = Mesh::<3, 4>::block(Vector::ZERO, Vector::splat(1.0), [4; 3]).unwrap();
        let found = on_the_left(&mesh, &[], |x| InflowFluid::Named(x[2] < 0.5));
        assert_eq!(found.len(), 32);
        found.iter().for_each(|(x, phi)| assert!((phi - (x[2] - 0.5)).abs() < 1e-14, "{x:?}: {phi}"));
        let alone = on_the_left(&mesh, &[], |_| InflowFluid::Named(true));
        assert!(alone.iter().all(|(_, phi)| *phi <= -0.99 * BEYOND_ALL));
    }
}
