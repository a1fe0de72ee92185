//! Forces of bodies on the elements of a membrane (theory C.11).
//!
//! ```text
//! F_e = Σ_K∈e F_K (a_e/n_e)/(Σ_e'∋K a_e'/n_e'),    Σ_e F_e = Σ_K F_K,    p_e = F_e·n/a_e
//! ```
//!
//! with the mean contact force F_K of the last step on each node, whose parts follow from the areas a_e of its elements
//! (with n_e nodes): under an even pressure on a flat sheet p_e is that pressure, edges included.

use super::Membrane;
use crate::math::Vector;

impl<const D: usize> Membrane<D> {
    /// Begins a step of one or more sub-steps, whose mean contact force is shown.
    pub fn begin_step(&mut self) {
        self.touch.clear();
        self.touch_time = 0.0;
    }

    /// Mean contact force of the last step on node `k` [N].
    fn touch_at(&self, k: usize) -> Vector<D> {
        self.touch.get(k).filter(|_| self.touch_time > 0.0).map_or(Vector::ZERO, |&impulse| impulse / self.touch_time)
    }

    /// F_e of every element [N].
    fn contact_forces(&self) -> Vec<Vector<D>> {
        let own = |e: usize| self.area_vector(e).norm() / self.elements.nodes(e).len() as f64;
        let own: Vec<f64> = (0..self.elements.len()).map(own).collect();
        let around = |k: usize| self.elements.corners(k).iter().map(|&c| own[self.elements.element_of(c)]).sum::<f64>();
        let per_area: Vec<Vector<D>> = (0..self.mass.len()).map(|k| self.touch_at(k) / around(k)).collect();
        let force = |(e, nodes): (usize, &[u32])| nodes.iter().map(|&k| per_area[k as usize] * own[e]).sum();
        self.elements.iter().enumerate().map(force).collect()
    }

    /// p_e of every element, positive where bodies push along the normal [Pa].
    pub(super) fn contact_pressures(&self) -> Vec<f64> {
        let forces = self.contact_forces().into_iter().enumerate();
        let pressure = |(e, force): (usize, Vector<D>)| {
            let area = self.area_vector(e);
            force.dot(area) / area.norm_squared()
        };
        forces.map(pressure).collect()
    }

    /// Area of every element that bodies push on; 0 of the others [m²].
    pub(super) fn contact_areas(&self) -> Vec<f64> {
        let forces = self.contact_forces().into_iter().enumerate();
        forces.map(|(e, force)| if force == Vector::ZERO { 0.0 } else { self.area_vector(e).norm() }).collect()
    }
}
