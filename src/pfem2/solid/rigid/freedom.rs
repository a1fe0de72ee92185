//! Motions that supports leave free to a rigid solid (theory J.11).
//!
//! ```text
//! q = (V, ω),     c_k · q = b_k  of supports k:      q = q₀ + Σ_j z_j q_j,      c_k · q_j = 0
//! ```
//!
//! By Gram and Schmidt's method, with lengths over the radius of gyration.

use crate::math::Vector;

/// Velocity of the centre of mass and angular velocity; or coefficients of these.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RigidRates {
    /// V [m/s].
    pub velocity: Vector<3>,
    /// ω [1/s].
    pub spin: Vector<3>,
}

/// The motions that supports leave.
#[derive(Debug, Clone, PartialEq)]
pub struct Freedom {
    /// q₀.
    pub particular: RigidRates,
    /// q_j, orthonormal with the radius of gyration.
    pub free: Vec<RigidRates>,
    length: f64,
}

/// A support that asks for what others make impossible.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contradiction {
    /// Distance of the motion from its velocity [m/s].
    pub missed: f64,
}

impl RigidRates {
    /// Velocity at an arm from the centre of mass [m/s].
    pub fn at(&self, arm: Vector<3>) -> Vector<3> {
        self.velocity + self.spin.cross(arm)
    }

    /// The coefficients by which the velocity at an arm along an axis depends on these.
    pub fn of_point(arm: Vector<3>, axis: usize) -> Self {
        Self { velocity: Vector::unit(axis), spin: arm.cross(Vector::unit(axis)) }
    }

    /// Σ of products.
    pub fn dot(&self, other: &Self) -> f64 {
        self.velocity.dot(other.velocity) + self.spin.dot(other.spin)
    }

    /// Adds others times a factor.
    pub fn add(&mut self, other: &Self, factor: f64) {
        self.velocity += other.velocity * factor;
        self.spin += other.spin * factor;
    }

    fn scaled(&self, length: f64) -> [f64; 6] {
        let [v, w] = [self.velocity.0, self.spin.0];
        [v[0], v[1], v[2], w[0] * length, w[1] * length, w[2] * length]
    }

    fn unscaled(q: [f64; 6], length: f64) -> Self {
        Self { velocity: Vector([q[0], q[1], q[2]]), spin: Vector([q[3], q[4], q[5]]) / length }
    }
}

fn dot(a: &[f64; 6], b: &[f64; 6]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Part of a vector that is orthogonal to orthonormal ones, as a unit vector with its length; `None` if it is rounding.
fn rest(vector: [f64; 6], basis: &[[f64; 6]]) -> Option<([f64; 6], f64)> {
    /// Less than this is rounding.
    const LEAST_REST: f64 = 1e-7;
    let size = dot(&vector, &vector).sqrt();
    let mut left = vector;
    // Twice, for orthogonality to rounding.
    for other in basis.iter().chain(basis) {
        let along = dot(&left, other);
        left.iter_mut().zip(other).for_each(|(left, other)| *left -= along * other);
    }
    let length = dot(&left, &left).sqrt();
    (length > LEAST_REST * size).then(|| (left.map(|x| x / length), length))
}

impl Freedom {
    /// Freedom of a solid with the radius of gyration `length` [m], where supports give the product of these
    /// coefficients with the rates.
    ///
    /// # Errors
    /// Supports that no motion of a rigid solid satisfies, to 1 % of the largest velocity that they prescribe.
    pub fn new(length: f64, supports: &[(RigidRates, f64)]) -> Result<Self, Contradiction> {
        /// Mismatch of supports, relative to the velocities that they prescribe.
        const MISMATCH: f64 = 0.01;
        let (mut basis, mut along): (Vec<[f64; 6]>, Vec<f64>) = (Vec::new(), Vec::new());
        let largest = supports.iter().fold(0.0, |most: f64, (_, value)| most.max(value.abs()));
        for (coefficients, value) in supports {
            let row = coefficients.scaled(length.recip());
            let known: f64 = basis.iter().zip(&along).map(|(direction, y)| dot(&row, direction) * y).sum();
            match rest(row, &basis) {
                Some((direction, size)) => {
                    basis.push(direction);
                    along.push((value - known) / size);
                }
                None if (value - known).abs() > MISMATCH * largest => {
                    return Err(Contradiction { missed: (value - known).abs() });
                }
                None => {}
            }
        }
        let sum = |k: usize| basis.iter().zip(&along).map(|(direction, y)| direction[k] * y).sum();
        let particular = RigidRates::unscaled(std::array::from_fn(sum), length);
        let held = basis.len();
        for k in 0..6 {
            let unit = std::array::from_fn(|i| f64::from(u8::from(i == k)));
            basis.extend(rest(unit, &basis).map(|(direction, _)| direction));
        }
        Ok(Self { particular, free: basis[held..].iter().map(|&q| RigidRates::unscaled(q, length)).collect(), length })
    }

    /// z of rates.
    pub fn coordinates(&self, rates: &RigidRates) -> Vec<f64> {
        let [q, start] = [rates, &self.particular].map(|rates| rates.scaled(self.length));
        let away: [f64; 6] = std::array::from_fn(|k| q[k] - start[k]);
        self.free.iter().map(|free| dot(&free.scaled(self.length), &away)).collect()
    }

    /// The rates at z.
    pub fn rates(&self, z: &[f64]) -> RigidRates {
        self.free.iter().zip(z).fold(self.particular, |sum, (free, &z)| RigidRates {
            velocity: sum.velocity + free.velocity * z,
            spin: sum.spin + free.spin * z,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A point that is held leaves three turns about it, a second one the turn about the line through both, a third
    /// none.
    #[test]
    fn points_that_are_held_leave_turns_about_them() {
        let points = [Vector([1.0, 0.5, -0.2]), Vector([1.0, 2.0, 0.7]), Vector([-1.0, 0.3, 0.1])];
        for (held, left) in [(0, 6), (1, 3), (2, 1), (3, 0)] {
            let rows: Vec<_> = points[..held]
                .iter()
                .flat_map(|&x| (0..3).map(move |axis| (RigidRates::of_point(x, axis), Vector([1.0, 2.0, 3.0])[axis])))
                .collect();
            let freedom = Freedom::new(0.4, &rows).unwrap();
            assert_eq!(freedom.free.len(), left);
            let z: Vec<f64> = (0..left).map(|k| 1.0 + k as f64).collect();
            let rates = freedom.rates(&z);
            assert!(points[..held].iter().all(|&x| (rates.at(x) - Vector([1.0, 2.0, 3.0])).norm() < 1e-12));
            let back = freedom.coordinates(&rates);
            assert!(z.iter().zip(back).all(|(z, back)| (z - back).abs() < 1e-12));
        }
    }

    #[test]
    fn supports_that_pull_a_solid_apart_are_told() {
        let apart = |x: f64, speed: f64| (RigidRates::of_point(Vector([x, 0.0, 0.0]), 0), speed);
        let told = Freedom::new(1.0, &[apart(0.0, 0.0), apart(1.0, 0.5)]).unwrap_err();
        assert!((told.missed - 0.5).abs() < 1e-12, "{told:?}");
        assert!(Freedom::new(1.0, &[apart(0.0, 0.5), apart(1.0, 0.5)]).is_ok());
    }
}
