//! Moments of the forces of the fluid about points that the case gives (theory J.6).
//!
//! ```text
//! M = Σ_a (x_a − c) × f_a      f_a: nodal forces on a part of the boundary (theory (F.38)), or on a solid (theory J.6)
//! ```
//!
//! x_a is where the nodes are when the forces act: of solids, where the mesh was cut at their surface.

use crate::math::Vector;
use crate::pfem2::history::StepWeights;

/// A point about which the force of the fluid on a part has a moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MomentPoint<const D: usize> {
    /// The part.
    pub part: ForcedPart,
    /// The point [m].
    pub about: Vector<D>,
}

/// A part on which the fluid exerts a force.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ForcedPart {
    /// A set of facets, by its place among the conditions on the boundary.
    Boundary(usize),
    /// A solid, by its place among the solids.
    Solid(usize),
}

/// Forces [N], or moments [N m], at the ends of steps, and their means over the last one; moments in the plane have the
/// third component alone.
#[derive(Debug, Clone, Default, PartialEq)]
pub(in crate::pfem2) struct StepMeans<const D: usize> {
    /// At the end of the last step.
    pub last: Vec<Vector<D>>,
    /// At the end of the step before.
    pub previous: Vec<Vector<D>>,
    /// Means over the last step, with the weights that it gives each.
    pub mean: Vec<Vector<D>>,
}

impl<const D: usize> StepMeans<D> {
    /// Of so many, before the first step.
    pub fn none(count: usize) -> Self {
        let none = vec![Vector::ZERO; count];
        Self { last: none.clone(), previous: none.clone(), mean: none }
    }

    /// Takes those at the end of a step with its `step_weights`.
    pub fn update(&mut self, now: Vec<Vector<D>>, step_weights: StepWeights) {
        let all = self.previous.iter().zip(&self.last).zip(&now);
        self.mean = all
            .map(|((m0, m1), m2)| *m0 * step_weights.earlier + *m1 * step_weights.start + *m2 * step_weights.end)
            .collect();
        self.previous = std::mem::replace(&mut self.last, now);
    }

    /// Adds to the means over the last step what takes no part in the next one.
    pub fn add_to_means(&mut self, more: impl Iterator<Item = Vector<D>>) {
        self.mean.iter_mut().zip(more).for_each(|(mean, more)| *mean += more);
    }

    /// Takes these as those of all steps before.
    pub fn begin(&mut self, now: Vec<Vector<D>>) {
        self.previous.clone_from(&now);
        self.last = now;
    }
}

/// The moment of a force [N] at the end of an arm [m] [N m].
pub(in crate::pfem2) fn moment<const D: usize>(arm: Vector<D>, force: Vector<D>) -> Vector<3> {
    Vector(arm.to3()).cross(Vector(force.to3()))
}

/// The point that is asked for of each of `count` parts.
pub(in crate::pfem2) fn points<const D: usize>(
    asked: &[MomentPoint<D>],
    count: usize,
    part: impl Fn(usize) -> ForcedPart,
) -> Vec<Option<Vector<D>>> {
    let of = |k| asked.iter().find(|point| point.part == part(k)).map(|point| point.about);
    (0..count).map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A couple has the same moment about every point; of a single force it is arm times force.
    #[test]
    fn a_couple_has_its_moment_about_any_point() {
        let forces = [(Vector([1.0, 2.0]), Vector([0.0, 3.0])), (Vector([-1.0, 2.0]), Vector([0.0, -3.0]))];
        for about in [Vector::ZERO, Vector([7.0, -5.0])] {
            let sum: Vector<3> = forces.iter().map(|(x, f)| moment(*x - about, *f)).sum();
            assert_eq!(sum, Vector([0.0, 0.0, 6.0]));
        }
        assert_eq!(moment(Vector([0.0, 0.0, 2.0]), Vector([3.0, 0.0, 0.0])), Vector([0.0, 6.0, 0.0]));
    }

    /// The means of a step are those of the forces: weighted sums of those at three ends of steps.
    #[test]
    fn means_of_a_step_take_its_weights() {
        let mut moments = StepMeans::none(1);
        let at = |m: f64| vec![Vector([0.0, 0.0, m])];
        moments.begin(at(1.0));
        let step_weights = StepWeights { dt: 0.1, end: 0.6, start: 0.3, earlier: 0.1 };
        moments.update(at(2.0), step_weights);
        moments.update(at(4.0), step_weights);
        assert!((moments.mean[0][2] - (0.1 + 0.6 + 2.4)).abs() < 1e-15, "{moments:?}");
        assert_eq!((moments.last[0][2], moments.previous[0][2]), (4.0, 2.0));
    }
}
