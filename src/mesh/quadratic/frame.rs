//! The place of a shape in a region: what turns and moves it.

use crate::geometry::Region;
use crate::math::Vector;

/// A rigid motion x ↦ R x + s.
#[derive(Debug, Clone, Copy)]
pub struct Frame {
    rotation: [[f64; 3]; 3],
    shift: Vector<3>,
}

impl Frame {
    /// No motion.
    pub const FIXED: Self =
        Self { rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], shift: Vector([0.0; 3]) };

    /// The frame whose third axis is `axis`, a unit vector, with its origin at `shift` [m].
    pub fn along(axis: Vector<3>, shift: [f64; 3]) -> Self {
        let least = (0..3).fold(0, |best, i| if axis[i].abs() < axis[best].abs() { i } else { best });
        let first = axis.cross(Vector::unit(least)).normalized().unwrap_or_else(|| Vector::unit(0));
        let second = axis.cross(first);
        Self { rotation: std::array::from_fn(|i| [first[i], second[i], axis[i]]), shift: Vector(shift) }
    }

    /// The place of x [m].
    pub fn place(&self, x: [f64; 3]) -> [f64; 3] {
        (self.turn(Vector(x)) + self.shift).0
    }

    fn turn(&self, x: Vector<3>) -> Vector<3> {
        Vector::from_fn(|i| (0..3).map(|j| self.rotation[i][j] * x[j]).sum())
    }

    /// First `inner`, then this.
    pub fn after(&self, inner: &Self) -> Self {
        let column = |j: usize| self.turn(Vector::from_fn(|i| inner.rotation[i][j]));
        let columns = [0, 1, 2].map(column);
        let rotation = std::array::from_fn(|i| std::array::from_fn(|j| columns[j][i]));
        Self { rotation, shift: self.turn(inner.shift) + self.shift }
    }

    /// The region before all motions that it was placed by, and their product.
    pub fn of(region: &Region) -> (Self, &Region) {
        let (mut frame, mut inner) = (Self::FIXED, region);
        while let Region::Placed { region, rotation, shift } = inner {
            frame = frame.after(&Self { rotation: *rotation, shift: Vector(*shift) });
            inner = region;
        }
        (frame, inner)
    }
}
