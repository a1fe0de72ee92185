//! Loads on the surface of a body: each particle of the outermost layer bears the force on its part of the surface
//! (theory A.14).
//!
//! ```text
//! dead       f = t A                                     traction t per area A of the undeformed surface
//! pressure   f = −P a,   a = s (x_b − x_a) × (x_d − x_c)      along the normal of the deformed surface (in 2D × e_z)
//! ```
//!
//! The neighbours a, b (and c, d) of a particle in its layer span the surface there; s is the fraction of the span that
//! is the particle's, with the sign that makes the area vector point outward. Nothing is stored from step to step.

use crate::error::{Place, StepError};
use crate::math::{Signal, Vector};

/// A load on one particle.
#[derive(Debug, Clone)]
pub struct Traction {
    /// The particle's identity.
    pub particle: u32,
    /// Load of the particle.
    pub load: Load,
}

/// The load of a particle of the surface.
#[derive(Debug, Clone)]
pub enum Load {
    /// A force that is fixed in direction.
    Dead {
        /// Traction t [Pa].
        value: [Signal; 3],
        /// Area A of the undeformed surface [m²].
        area: f64,
    },
    /// A pressure that follows the surface.
    Pressure {
        /// Pressure P [Pa], into the body where positive.
        value: Signal,
        /// Identities of the neighbours [a, b] and [c, d]; in 2D [a, b] only.
        span: Vec<[u32; 2]>,
        /// Fraction s of the span.
        fraction: f64,
    },
}

impl Traction {
    /// The force at time `t` [s], where particles are at `position` by identity [N].
    pub fn force<const D: usize>(&self, t: f64, position: impl Fn(u32) -> Vector<D>) -> Vector<D> {
        let x = position(self.particle).to3();
        match &self.load {
            Load::Dead { value, area } => Vector::from_fn(|a| value[a].value(x, t)) * *area,
            Load::Pressure { value, span, fraction } => area(span, position) * (-fraction * value.value(x, t)),
        }
    }
}

/// The area vector that neighbours span [m²].
pub fn area<const D: usize>(span: &[[u32; 2]], position: impl Fn(u32) -> Vector<D>) -> Vector<D> {
    let side = |n: usize| match span.get(n) {
        Some(&[a, b]) => Vector((position(b) - position(a)).to3()),
        None => Vector::unit(2),
    };
    Vector::from3(side(0).cross(side(1)).0)
}

/// The error of a load that is not a number at a place; `value` is the norm of its force [N].
pub(in crate::mpm) fn no_load(place: Place, value: f64) -> StepError {
    let advice = "look for a formula or value of gravity, pressure or traction beyond what numbers can hold";
    StepError::new(place, "an external force is not a number", "force", value, advice)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An arc of half a turn, of radius r under pressure P: the forces add up to 2 r P across it, whatever the number
    /// of particles (the polygon's sum is exact), and each points to the centre.
    #[test]
    fn a_pressure_on_an_arc_pushes_along_its_normals() {
        let (n, radius, pressure) = (40_u32, 2.0, 3.0);
        let place = |id: u32| {
            let angle = std::f64::consts::PI * f64::from(id) / f64::from(n);
            Vector([radius * angle.cos(), radius * angle.sin()])
        };
        let mut sum = Vector::<2>::ZERO;
        for id in 0..=n {
            let (a, b) = (id.saturating_sub(1), (id + 1).min(n));
            let load = Load::Pressure { value: Signal::Constant(pressure), span: vec![[a, b]], fraction: 0.5 };
            let force = Traction { particle: id, load }.force(0.0, place);
            if id > 0 && id < n {
                assert!((force.normalized().unwrap() + place(id) * (1.0 / radius)).norm() < 1e-12);
            }
            sum += force;
        }
        assert!((sum - Vector([0.0, -2.0 * radius * pressure])).norm() < 1e-12, "{sum:?}");
    }

    /// A square of four particles that is turned keeps its area; a dead load its direction.
    #[test]
    fn a_pressure_turns_with_the_surface_and_a_dead_load_does_not() {
        let turned = |id: u32| {
            let (x, y) = (f64::from(id % 2), f64::from(id / 2));
            Vector([x, 0.6 * y, 0.8 * y])
        };
        let pressure = Load::Pressure { value: Signal::Constant(5.0), span: vec![[0, 1], [0, 2]], fraction: 1.0 };
        let force = Traction { particle: 0, load: pressure }.force::<3>(0.0, turned);
        assert!((force - Vector([0.0, 4.0, -3.0])).norm() < 1e-12, "{force:?}");
        let dead = Load::Dead { value: [0.0, 0.0, -5.0].map(Signal::Constant), area: 2.0 };
        assert_eq!(Traction { particle: 0, load: dead }.force::<3>(0.0, turned), Vector([0.0, 0.0, -10.0]));
    }
}
