//! One point of a sheet next to a wall or an obstacle.

use crate::math::Vector;
use crate::mpm::contact::impulse::Impulse;
use crate::mpm::wall::Solid;

/// A point of the sheet next to a wall or an obstacle.
#[derive(Debug, Clone)]
pub struct Rest<const D: usize> {
    /// The wall or obstacle.
    pub solid: u32,
    /// K and W_K; a node has one.
    pub nodes: [u32; 4],
    pub weights: [f64; 4],
    /// What of the thickness, less what an element may cut in, lies between it and the surface [m].
    pub offset: f64,
    /// The step in which overlaps are undone is measured by this length [m].
    pub thickness: f64,
    pub normal: Vector<D>,
    /// g where it was measured last, relative to the solid [m].
    pub measured: f64,
    pub anchor: Vector<D>,
    /// g at the start of the sub-step [m].
    pub gap: f64,
    /// v_w [m/s].
    pub wall: Vector<D>,
    pub friction: f64,
    /// J of this sub-step on the sheet, and what of it the nodes have got [N s].
    pub impulse: Impulse<D>,
    pub given: Vector<D>,
}

impl<const D: usize> Rest<D> {
    pub fn place(&self, position: &[Vector<D>]) -> Vector<D> {
        self.at(position)
    }

    /// Σ W_K of values at the nodes.
    pub fn at(&self, values: &[Vector<D>]) -> Vector<D> {
        if self.weights[0] == 1.0 {
            return values[self.nodes[0] as usize];
        }
        self.nodes.iter().zip(self.weights).map(|(&k, weight)| values[k as usize] * weight).sum()
    }

    /// The gap of the point at `x` [m] from a solid that has moved on by `ahead` [m]: from its surface, if the point has
    /// moved further than `far` since it was last measured.
    pub fn measure(&mut self, solid: Solid<'_, D>, x: Vector<D>, ahead: Vector<D>, far: f64) {
        let there = x - ahead;
        if (there - self.anchor).norm_squared() > far * far {
            let (distance, normal) = solid.distance(x, ahead);
            (self.measured, self.normal, self.anchor) = (distance - self.offset, normal, there);
        }
        self.gap = self.measured + (there - self.anchor).dot(self.normal);
    }

    /// g [m] at these positions [m], `elapsed` [s] after the start of the step.
    pub fn gap_after(&self, position: &[Vector<D>], elapsed: f64) -> f64 {
        self.measured + (self.place(position) - self.wall * elapsed - self.anchor).dot(self.normal)
    }

    /// Improves the impulse; returns its change [N s].
    pub fn push(&mut self, v: &[Vector<D>], soft: &impl Fn(usize) -> Vector<D>, dt: f64) -> Vector<D> {
        let n = self.normal;
        let (mut along, mut across) = (0.0, 0.0_f64);
        for (&k, weight) in self.nodes.iter().zip(self.weights).filter(|(_, weight)| *weight > 0.0) {
            let soft = soft(k as usize);
            along += weight * weight * (0..D).map(|a| n[a] * n[a] * soft[a]).sum::<f64>();
            across += weight * weight * (0..D).map(|a| soft[a]).fold(0.0, f64::max);
        }
        if along == 0.0 {
            return Vector::ZERO;
        }
        let (w, before) = (self.at(v) - self.wall, self.impulse);
        let pressed = (before.normal.dot(n) - (w.dot(n) + self.gap.max(0.0) / dt) / along).max(0.0);
        self.impulse.normal = n * pressed;
        self.impulse.tangent = Vector::ZERO;
        if self.friction > 0.0 && pressed > 0.0 {
            let wanted = before.tangent - (w - n * w.dot(n)) / across;
            let (size, most) = (wanted.norm(), self.friction * pressed);
            self.impulse.tangent = if size > most { wanted * (most / size) } else { wanted };
        }
        self.impulse.total() - before.total()
    }

    /// True if friction holds the point.
    pub fn sticks(&self) -> bool {
        self.friction > 0.0 && self.impulse.tangent.norm() < self.friction * self.impulse.normal.norm()
    }

    /// Takes what the impulse `j` presses against the solid, as long as that doesn't pull; returns the rest [N s].
    pub fn take(&mut self, j: Vector<D>) -> Vector<D> {
        let n = self.normal;
        let (along, pressed) = (j.dot(n), self.impulse.normal.dot(n));
        if pressed - along < 0.0 {
            return j;
        }
        let tangent = self.impulse.tangent - (j - n * along);
        if self.sticks() && tangent.norm() <= self.friction * (pressed - along) {
            self.impulse = Impulse { normal: n * (pressed - along), tangent };
            return Vector::ZERO;
        }
        self.impulse.normal = n * (pressed - along);
        j - n * along
    }
}
