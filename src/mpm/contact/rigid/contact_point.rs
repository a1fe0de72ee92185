//! One point of a sheet next to a wall or an obstacle, and the law of its contact (theory E.10).

use crate::math::Vector;
use crate::mpm::contact::impulse::Impulse;
use crate::mpm::wall::RigidBoundary;

/// A point of the sheet next to a wall or an obstacle.
#[derive(Debug, Clone)]
pub struct RigidContact<const D: usize> {
    /// The wall or obstacle.
    pub solid: u32,
    /// The nodes K of the element on which the point lies; of a point at a node all are that node.
    pub nodes: [u32; 4],
    /// Their weights W_K at the point; at a node the first is 1.
    pub weights: [f64; 4],
    /// Distance of the middle surface from the solid at which the gap is zero: half the thickness, less the depth to
    /// which an element may cut in [m].
    pub offset: f64,
    /// Half the thickness at the point, of thin sheets a part of the element's size: corrections of overlaps in one
    /// sub-step, and overlaps that are allowed, are parts of it [m].
    pub half_thickness: f64,
    /// Unit normal of the solid, away from it.
    pub normal: Vector<D>,
    /// g where it was measured last [m].
    pub measured: f64,
    /// The place where g was measured last, less the way of the solid until then [m].
    pub anchor: Vector<D>,
    /// g at the start of the sub-step [m].
    pub gap: f64,
    /// v_w [m/s].
    pub wall: Vector<D>,
    /// Coefficient of friction.
    pub friction: f64,
    /// J of this sub-step on the sheet [N s].
    pub impulse: Impulse<D>,
    /// The part of J that has been added to the velocities of the nodes [N s].
    pub applied: Vector<D>,
}

impl<const D: usize> RigidContact<D> {
    /// The place of the point [m], with these positions of the nodes.
    pub fn position(&self, position: &[Vector<D>]) -> Vector<D> {
        self.at(position)
    }

    /// Σ W_K of values at the nodes.
    pub fn at(&self, values: &[Vector<D>]) -> Vector<D> {
        if self.weights[0] == 1.0 {
            return values[self.nodes[0] as usize];
        }
        self.nodes.iter().zip(self.weights).map(|(&k, weight)| values[k as usize] * weight).sum()
    }

    /// The gap of the point at `x` [m] from a solid that has moved on by `ahead` [m]: from its surface, if the point
    /// has moved further than `far` since it was last measured.
    pub fn measure(&mut self, solid: RigidBoundary<'_, D>, x: Vector<D>, ahead: Vector<D>, far: f64) {
        let there = x - ahead;
        if (there - self.anchor).norm_squared() > far * far {
            let (distance, normal) = solid.distance(x, ahead);
            (self.measured, self.normal, self.anchor) = (distance - self.offset, normal, there);
        }
        self.gap = self.measured + (there - self.anchor).dot(self.normal);
    }

    /// g [m] at these positions [m], `elapsed` [s] after the start of the step.
    pub fn gap_after(&self, position: &[Vector<D>], elapsed: f64) -> f64 {
        self.measured + (self.position(position) - self.wall * elapsed - self.anchor).dot(self.normal)
    }

    /// Updates the impulse to that of the velocities `v` [m/s]; returns its change [N s].
    pub fn update_impulse(
        &mut self,
        v: &[Vector<D>],
        inverse_mass: &impl Fn(usize) -> Vector<D>,
        dt: f64,
    ) -> Vector<D> {
        let n = self.normal;
        let (mut along, mut across) = (0.0, 0.0_f64);
        for (&k, weight) in self.nodes.iter().zip(self.weights).filter(|(_, weight)| *weight > 0.0) {
            let inverse_mass = inverse_mass(k as usize);
            along += weight * weight * (0..D).map(|a| n[a] * n[a] * inverse_mass[a]).sum::<f64>();
            across += weight * weight * (0..D).map(|a| inverse_mass[a]).fold(0.0, f64::max);
        }
        if along == 0.0 {
            return Vector::ZERO;
        }
        let (w, before) = (self.at(v) - self.wall, self.impulse);
        let normal_impulse = (before.normal.dot(n) - (w.dot(n) + self.gap.max(0.0) / dt) / along).max(0.0);
        self.impulse.normal = n * normal_impulse;
        self.impulse.tangent = Vector::ZERO;
        if self.friction > 0.0 && normal_impulse > 0.0 {
            let wanted = before.tangent - (w - n * w.dot(n)) / across;
            let (size, most) = (wanted.norm(), self.friction * normal_impulse);
            self.impulse.tangent = if size > most { wanted * (most / size) } else { wanted };
        }
        self.impulse.total() - before.total()
    }

    /// True if friction holds the point.
    pub fn sticks(&self) -> bool {
        self.friction > 0.0 && self.impulse.tangent.norm() < self.friction * self.impulse.normal.norm()
    }

    /// Takes the part of the impulse `j` that presses against the solid, as long as the normal impulse stays positive;
    /// returns the rest [N s].
    pub fn absorb(&mut self, j: Vector<D>) -> Vector<D> {
        let n = self.normal;
        let (along, normal_impulse) = (j.dot(n), self.impulse.normal.dot(n));
        if normal_impulse - along < 0.0 {
            return j;
        }
        let tangent = self.impulse.tangent - (j - n * along);
        if self.sticks() && tangent.norm() <= self.friction * (normal_impulse - along) {
            self.impulse = Impulse { normal: n * (normal_impulse - along), tangent };
            return Vector::ZERO;
        }
        self.impulse.normal = n * (normal_impulse - along);
        j - n * along
    }
}
