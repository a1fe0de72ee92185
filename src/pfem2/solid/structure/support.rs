//! Prescribed nodes of solids (theory J.10) and loads on their surfaces, part of f in theory (J.4).
//!
//! ```text
//! v_a = v̄(X_a, t),      f_a = ∫ N_a t̄(X, t) dA
//! ```
//!
//! X and A are those of the reference state. Unknown D a + i is the velocity of node a along axis i; nodes are numbered
//! over all solids.

use crate::math::{Signal, Vector};
use crate::pfem2::solid::mesh::SolidMesh;
use crate::pfem2::solid::mesh::gauss::{GaussPoint, gauss_points};
use crate::pfem2::solid::setup::SolidSetup;

/// Supports and loads of all solids.
#[derive(Debug, Clone)]
pub struct SolidSupports<const D: usize> {
    held: Vec<HeldUnknown>,
    loads: Vec<PointLoad<D>>,
}

/// An unknown whose value is prescribed.
#[derive(Debug, Clone)]
struct HeldUnknown {
    unknown: u32,
    place: [f64; 3],
    velocity: Signal,
}

/// The load at a Gauss point of a facet.
#[derive(Debug, Clone)]
struct PointLoad<const D: usize> {
    place: [f64; 3],
    traction: [Signal; D],
    /// Nodes, and N_a dA [m²].
    areas: Vec<(u32, f64)>,
}

impl<const D: usize> SolidSupports<D> {
    /// The supports and loads of solids whose nodes begin at `first`.
    ///
    /// # Errors
    /// A node or a facet that isn't there.
    pub fn new(setups: &[SolidSetup<D>], first: &[u32]) -> Result<Self, String> {
        let mut supports = Self { held: Vec::new(), loads: Vec::new() };
        let points = gauss_points(D - 1);
        for (setup, &first) in setups.iter().zip(first) {
            supports.add_held(setup, first)?;
            supports.add_loads(setup, first, &points)?;
        }
        Ok(supports)
    }

    fn add_held(&mut self, setup: &SolidSetup<D>, first: u32) -> Result<(), String> {
        for held in &setup.held {
            for &node in &held.nodes {
                let missing = || format!("the solid `{}` has no node {node} to hold", setup.name);
                let place = setup.mesh.nodes.get(node as usize).ok_or_else(missing)?.to3();
                for (axis, velocity) in held.velocity.iter().enumerate() {
                    let unknown = (first + node) * D as u32 + axis as u32;
                    self.held.extend(velocity.iter().map(|v| HeldUnknown { unknown, place, velocity: v.clone() }));
                }
            }
        }
        Ok(())
    }

    fn add_loads(&mut self, setup: &SolidSetup<D>, first: u32, points: &[GaussPoint]) -> Result<(), String> {
        for load in &setup.tractions {
            for &facet in &load.facets {
                let missing = || format!("the solid `{}` has no facet {facet} to load", setup.name);
                let nodes = &setup.mesh.facets.get(facet as usize).ok_or_else(missing)?.nodes;
                let places = places(&setup.mesh, nodes);
                self.loads.extend(points.iter().map(|point| {
                    let area = point.weight * area(&places, &point.slopes);
                    let place: Vector<D> = places.iter().zip(&point.shape).map(|(x, shape)| *x * *shape).sum();
                    let areas = nodes.iter().zip(&point.shape).map(|(&node, shape)| (first + node, shape * area));
                    PointLoad { place: place.to3(), traction: load.traction.clone(), areas: areas.collect() }
                }));
            }
        }
        Ok(())
    }

    /// Prescribed velocity of each of `unknowns` unknowns at time `t` [m/s]; of several for one the last holds.
    pub fn velocities(&self, unknowns: usize, t: f64) -> Vec<Option<f64>> {
        let mut all = vec![None; unknowns];
        for held in &self.held {
            all[held.unknown as usize] = Some(held.velocity.value(held.place, t));
        }
        all
    }

    /// Adds the loads at time `t` to the force on each unknown [N].
    pub fn add_forces(&self, t: f64, force: &mut [f64]) {
        for load in &self.loads {
            for (axis, traction) in load.traction.iter().enumerate() {
                let traction = traction.value(load.place, t);
                for &(node, area) in &load.areas {
                    force[node as usize * D + axis] += traction * area;
                }
            }
        }
    }
}

fn places<const D: usize>(mesh: &SolidMesh<D>, nodes: &[u32]) -> Vec<Vector<D>> {
    nodes.iter().map(|&node| mesh.nodes[node as usize]).collect()
}

/// ∫ N_a dA [m²] of the nodes of a facet.
pub fn facet_node_areas<const D: usize>(mesh: &SolidMesh<D>, facet: usize) -> Vec<(u32, f64)> {
    node_areas_at(&mesh.nodes, &mesh.facets[facet].nodes)
}

/// ∫ N_a dA [m²] of the nodes of a facet, where all nodes are at `positions` [m].
pub(in crate::pfem2::solid) fn node_areas_at<const D: usize>(
    positions: &[Vector<D>],
    nodes: &[u32],
) -> Vec<(u32, f64)> {
    let places: Vec<Vector<D>> = nodes.iter().map(|&node| positions[node as usize]).collect();
    let points = gauss_points(D - 1);
    let own_area =
        |a: usize| points.iter().map(|point| point.weight * area(&places, &point.slopes) * point.shape[a]).sum();
    nodes.iter().enumerate().map(|(a, &node)| (node, own_area(a))).collect()
}

/// Area per reference area of a facet with nodes at `places`: |t_0| of a line, |t_0 × t_1| of a patch, of tangents t_k
/// = Σ X_a ∂N_a/∂ξ_k.
fn area<const D: usize>(places: &[Vector<D>], slopes: &[[f64; 3]]) -> f64 {
    let tangent = |k: usize| places.iter().zip(slopes).map(|(x, slope)| *x * slope[k]).sum::<Vector<D>>();
    if D == 2 {
        return tangent(0).norm();
    }
    let [a, b] = [0, 1].map(|k| Vector(tangent(k).to3()));
    a.cross(b).norm()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::{Elastic, StVenantKirchhoff};
    use crate::pfem2::solid::setup::{HeldNodes, SurfaceTraction};

    /// A block of unit density with loads on all facets with places that satisfy `on`.
    fn loaded<const D: usize>(
        counts: [usize; D],
        traction: [Signal; D],
        on: impl Fn(Vector<D>) -> bool,
    ) -> SolidSetup<D> {
        let mesh = SolidMesh::block(Vector::ZERO, Vector::from_fn(|k| 1.0 + k as f64), counts).unwrap();
        let inside = |facet: &u32| mesh.facets[*facet as usize].nodes.iter().all(|&node| on(mesh.nodes[node as usize]));
        let facets = (0..mesh.facets.len() as u32).filter(inside).collect();
        let law = Box::new(StVenantKirchhoff { elastic: Elastic::new(1.0, 1.0, 0.3) });
        let tractions = vec![SurfaceTraction { facets, traction }];
        SolidSetup { tractions, ..SolidSetup::free("block", mesh, law) }
    }

    /// A traction y² t on the side x = 1 of a block of height 2: ∫ y² dy = 8/3, with the moment ∫ y³ dy = 4.
    #[test]
    fn a_traction_has_its_force_and_moment() {
        let setup = loaded([3, 2], [Signal::formula("y^2 * t").unwrap(), Signal::ZERO], |x| x[0] == 1.0);
        let nodes = setup.mesh.nodes.clone();
        let mut force = vec![0.0; 2 * nodes.len()];
        SolidSupports::new(&[setup], &[0]).unwrap().add_forces(0.5, &mut force);
        let sum: f64 = force.iter().step_by(2).sum();
        let moment: f64 = force.iter().step_by(2).zip(&nodes).map(|(f, x)| f * x[1]).sum();
        assert!((sum - 4.0 / 3.0).abs() < 1e-14 && (moment - 2.0).abs() < 1e-14, "{sum} {moment}");
    }

    /// In three dimensions, on the side z = 3 of 1 × 2: ∫∫ x y dx dy = 1. The nodes of the second solid follow those
    /// of the first.
    #[test]
    fn a_traction_on_a_patch_has_its_force() {
        let setup = || loaded([1, 2, 1], [Signal::ZERO, Signal::formula("x*y").unwrap(), 3.0.into()], |x| x[2] == 3.0);
        let count = setup().mesh.nodes.len();
        let mut force = vec![0.0; 6 * count];
        SolidSupports::new(&[setup(), setup()], &[0, count as u32]).unwrap().add_forces(0.0, &mut force);
        for half in force.chunks(3 * count) {
            let sum: Vec<f64> = (0..3).map(|axis| half.iter().skip(axis).step_by(3).sum()).collect();
            assert!(sum[0] == 0.0 && (sum[1] - 1.0).abs() < 1e-14 && (sum[2] - 6.0).abs() < 1e-14, "{sum:?}");
        }
    }

    #[test]
    fn a_support_may_hold_one_axis_alone() {
        let mut setup = loaded([1, 1], [Signal::ZERO, Signal::ZERO], |_| false);
        setup.held = vec![HeldNodes { nodes: vec![4], velocity: [None, Some(Signal::formula("x + t").unwrap())] }];
        let all = SolidSupports::new(&[setup], &[3]).unwrap().velocities(24, 2.0);
        assert_eq!(all.iter().flatten().count(), 1);
        assert_eq!(all[(3 + 4) * 2 + 1], Some(2.5));
        let mut setup = loaded([1, 1], [Signal::ZERO, Signal::ZERO], |_| false);
        setup.held = vec![HeldNodes { nodes: vec![9], velocity: [None, None] }];
        assert!(SolidSupports::new(&[setup], &[0]).unwrap_err().contains("node 9"));
    }
}
