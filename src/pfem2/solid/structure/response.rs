//! Displacements of solids that are foreseen from their natural modes, without a fluid (theory J.15).
//!
//! ```text
//! u = Σ_k φ_k (φ_k·f)/ω_k²                     under forces f that rest
//! u = Σ_k φ_k (φ_k·M v) sin(min(ω_k t, π/2))/ω_k   at most, within a time t from a velocity v
//! ```
//!
//! over modes φ_k, with φ_k·M φ_k = 1, that have a stiffness.

use super::Structure;
use super::modes::{NaturalMode, by_node};
use super::pressure::area_vector;
use crate::math::Vector;
use crate::pfem2::solid::mesh::gauss::gauss_points;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Forces on all nodes [N].
pub type NodalForces<const D: usize> = Vec<Vector<D>>;

impl<const D: usize> NaturalMode<D> {
    /// ω [1/s]; zero for a motion without stiffness.
    pub fn frequency(&self) -> f64 {
        TAU / self.period
    }

    fn along(&self, forces: &[Vector<D>]) -> f64 {
        self.shape.iter().zip(forces).map(|(shape, force)| shape.dot(*force)).sum()
    }
}

/// Σ_k a_k φ_k over modes with a stiffness [m].
fn superposed<const D: usize>(
    modes: &[NaturalMode<D>],
    amplitude: impl Fn(&NaturalMode<D>) -> f64,
) -> Option<Vec<Vector<D>>> {
    let stiff = modes.iter().filter(|mode| mode.period.is_finite());
    stiff.fold(None, |sum, mode| {
        let a = amplitude(mode);
        let mut sum = sum.unwrap_or_else(|| vec![Vector::ZERO; mode.shape.len()]);
        sum.iter_mut().zip(&mode.shape).for_each(|(u, shape)| *u += *shape * a);
        Some(sum)
    })
}

/// Displacement of all nodes under forces [m]; `None` without a mode that has a stiffness.
pub fn deflection<const D: usize>(modes: &[NaturalMode<D>], forces: &[Vector<D>]) -> Option<Vec<Vector<D>>> {
    superposed(modes, |mode| mode.along(forces) / mode.frequency().powi(2))
}

/// Displacement of all nodes at most, within a time `span` [s] from the start with these momenta of the nodes
/// [kg m/s]; `None` without a mode that has a stiffness.
pub fn swing<const D: usize>(modes: &[NaturalMode<D>], momenta: &[Vector<D>], span: f64) -> Option<Vec<Vector<D>>> {
    let reached = |omega: f64| (omega * span).min(FRAC_PI_2).sin() / omega;
    superposed(modes, |mode| mode.along(momenta) * reached(mode.frequency()))
}

impl<const D: usize> Structure<D> {
    /// Forces of loads at time `t` [s] and of an acceleration by solid and place [m/s²], in the reference state.
    pub fn loads(&self, t: f64, acceleration: impl Fn(usize, Vector<D>) -> Vector<D>) -> NodalForces<D> {
        let of_solid = |(solid, setup): (usize, &crate::pfem2::solid::setup::SolidSetup<D>)| {
            setup.mesh.nodes.iter().map(|&x| acceleration(solid, x)).collect::<Vec<_>>()
        };
        let nodal: Vec<Vector<D>> = self.setups.iter().enumerate().flat_map(of_solid).collect();
        let mut force = self.weighted_by_mass(&nodal);
        self.supports.add_forces(t, &mut force);
        self.pressures.forces(t, &self.nodes, |node, own| {
            (0..D).for_each(|axis| force[node as usize * D + axis] += own[axis]);
        });
        by_node(&force)
    }

    /// M v of the nodes at the start [kg m/s].
    pub fn momenta(&self) -> Vec<Vector<D>> {
        by_node(&self.weighted_by_mass(&self.state.velocity))
    }

    /// Mass of each node [kg].
    pub fn nodal_masses(&self) -> Vec<f64> {
        let ones = vec![Vector::splat(1.0); self.nodes.len()];
        by_node::<D>(&self.weighted_by_mass(&ones)).into_iter().map(|mass| mass[0]).collect()
    }

    /// ∫ |n·e| e dA over the surface of a solid, at its nodes [m²].
    pub fn frontal_areas(&self, solid: usize, e: Vector<D>) -> NodalForces<D> {
        let mut areas = vec![Vector::ZERO; self.nodes.len()];
        self.visit_area(solid, |own, area| {
            own.for_each(|(node, shape)| areas[node] += e * (area.dot(e).abs() * shape))
        });
        areas
    }

    /// ∫ |φ·n| dA over the surface of a solid [m²], for a shape φ of the displacement of all nodes.
    pub fn swept_area(&self, solid: usize, shape: &[Vector<D>]) -> f64 {
        let mut sum = 0.0;
        self.visit_area(solid, |own, area| {
            let moved: Vector<D> = own.map(|(node, function)| shape[node] * function).sum();
            sum += moved.dot(area).abs();
        });
        sum
    }

    /// Calls `work` with the nodes of a facet of a solid, their shape functions at a Gauss point, and n dA there [m²].
    fn visit_area(&self, solid: usize, mut work: impl FnMut(&mut dyn Iterator<Item = (usize, f64)>, Vector<D>)) {
        let (points, mesh, first) = (gauss_points(D - 1), &self.setups[solid].mesh, self.first[solid] as usize);
        for facet in &mesh.facets {
            for point in &points {
                let area = area_vector(&facet.nodes, &mesh.nodes, point);
                let own = facet.nodes.iter().zip(&point.shape);
                work(&mut own.map(|(&node, &shape)| (first + node as usize, shape)), area);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pfem2::solid::mesh::SolidMesh;
    use crate::pfem2::solid::structure::tests::solid;

    const LENGTH: f64 = 2.0;
    const THICKNESS: f64 = 0.05;
    const YOUNG: f64 = 1e6;
    const DENSITY: f64 = 1000.0;

    fn cantilever() -> Structure<2> {
        let mesh = SolidMesh::block(Vector::ZERO, Vector([LENGTH, THICKNESS]), [20, 2]).unwrap();
        Structure::new(vec![solid(mesh, [DENSITY, YOUNG, 0.0], |x| x[0] == 0.0)]).unwrap()
    }

    /// Under its weight the end of a cantilever comes down by ρ g l⁴ A/(8 E I), with a rate of v (x/l)² at the start as
    /// far as an energy of motion in the first mode leads it: Euler's beam, I = h³/12, ω = 3.5160 √(E I/(ρ h))/l².
    #[test]
    fn a_cantilever_hangs_and_swings_as_euler_has_it() {
        let beam = cantilever();
        let modes = beam.natural_modes(6).found;
        let end = beam.nodes.iter().position(|x| *x == Vector([LENGTH, 0.5 * THICKNESS])).unwrap();
        let stiffness = YOUNG * THICKNESS.powi(3) / 12.0;
        let forces = beam.loads(0.0, |_, _| Vector([0.0, -0.01]));
        let hanging = deflection(&modes, &forces).unwrap()[end][1];
        let exact = -DENSITY * 0.01 * THICKNESS * LENGTH.powi(4) / (8.0 * stiffness);
        assert!((hanging / exact - 1.0).abs() < 5e-3, "{hanging} {exact}");
        let omega = 3.516_015 * (stiffness / (DENSITY * THICKNESS)).sqrt() / LENGTH.powi(2);
        let scale = modes[0].shape[end][1];
        let momenta: Vec<Vector<2>> = {
            let own: Vec<Vector<2>> = modes[0].shape.iter().map(|shape| *shape / scale).collect();
            by_node(&beam.weighted_by_mass(&own))
        };
        let swung = swing(&modes, &momenta, f64::INFINITY).unwrap()[end][1];
        assert!((swung * omega - 1.0).abs() < 5e-3, "{swung} {omega}");
        let brief = swing(&modes, &momenta, 1e-3).unwrap()[end][1];
        assert!((brief - 1e-3).abs() < 1e-6, "{brief}");
    }

    /// A plane wall of the length l and the thickness h has 2 l to both sides of a stream across it, 2 h of one along
    /// it; a shape that moves all nodes across it by one sweeps 2 l.
    #[test]
    fn a_beam_has_two_sides_in_a_stream() {
        let beam = cantilever();
        let along = |e: Vector<2>| beam.frontal_areas(0, e).into_iter().sum::<Vector<2>>().dot(e);
        assert!((along(Vector([0.0, 1.0])) - 2.0 * LENGTH).abs() < 1e-12);
        assert!((along(Vector([-1.0, 0.0])) - 2.0 * THICKNESS).abs() < 1e-12);
        let shape = vec![Vector([0.0, 1.0]); beam.nodes.len()];
        assert!((beam.swept_area(0, &shape) - 2.0 * LENGTH).abs() < 1e-12);
        let mass: f64 = beam.nodal_masses().iter().sum();
        assert!((mass - DENSITY * LENGTH * THICKNESS).abs() < 1e-9);
    }
}
