//! An orthographic camera: lengths across the line of sight are true, so that a scale bar holds everywhere.

use crate::math::Vector;

/// Direction to the camera in space, where a picture doesn't say.
pub(super) const STANDARD_VIEW: [f64; 3] = [1.0, -2.0, 0.8];

/// From metres to pixels of the (supersampled) image.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Camera {
    /// Unit vectors in metres: to the right, up, and towards the eye.
    right: Vector<3>,
    up: Vector<3>,
    back: Vector<3>,
    /// The point in the middle of the picture [m].
    target: Vector<3>,
    /// The middle in the image, in pixels.
    middle: [f64; 2],
    /// Pixels per metre.
    pub scale: f64,
}

/// A point projected into the image, with its depth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ProjectedPoint {
    /// Pixels from the left.
    pub x: f64,
    /// Pixels from the top.
    pub y: f64,
    /// Pixels towards the eye.
    pub near: f64,
}

impl Camera {
    /// Looks along `−view` so that the box `[lower, upper]` [m] fits into the rectangle of pixels
    /// `[left, top, right, bottom]`.
    pub fn new(view: [f64; 3], up: [f64; 3], [lower, upper]: [[f64; 3]; 2], rectangle: [f64; 4]) -> Self {
        let back = Vector(view).normalized().unwrap_or(Vector::unit(2));
        // Looking along the axis that should be up: then y is up, or x.
        let ups = [Vector(up), Vector::unit(1), Vector::unit(0)];
        let right = ups.into_iter().find_map(|up| {
            let up = up.normalized()?;
            let across = up.cross(back);
            if across.norm() > 1e-6 { across.normalized() } else { None }
        });
        let right = right.unwrap_or(Vector::unit(0));
        let up = back.cross(right);
        let corners = || (0..8).map(|n| Vector::<3>::from_fn(|i| if n >> i & 1 == 0 { lower[i] } else { upper[i] }));
        let target = (Vector(lower) + Vector(upper)) * 0.5;
        let extent = |axis: Vector<3>| corners().map(|c| 2.0 * (c - target).dot(axis).abs()).fold(0.0, f64::max);
        let [from_left, from_top, to_right, to_bottom] = rectangle;
        let (width, height) = (to_right - from_left, to_bottom - from_top);
        let scale = (width / extent(right)).min(height / extent(up));
        let scale = if scale.is_finite() { scale } else { 1.0 };
        let middle = [0.5 * (from_left + to_right), 0.5 * (from_top + to_bottom)];
        Self { right, up, back, target, middle, scale }
    }

    /// Projects a point [m] into the image.
    pub fn project(&self, point: [f64; 3]) -> ProjectedPoint {
        let from_target = (Vector(point) - self.target) * self.scale;
        ProjectedPoint {
            x: self.middle[0] + from_target.dot(self.right),
            y: self.middle[1] - from_target.dot(self.up),
            near: from_target.dot(self.back),
        }
    }

    /// The point [m] at a place of the image.
    pub fn point(&self, projected: ProjectedPoint) -> [f64; 3] {
        let [x, y] = [projected.x - self.middle[0], self.middle[1] - projected.y];
        (self.target + (self.right * x + self.up * y + self.back * projected.near) / self.scale).0
    }

    /// A direction in the camera's frame: right, up, towards the eye.
    pub fn turn(&self, direction: Vector<3>) -> Vector<3> {
        Vector([direction.dot(self.right), direction.dot(self.up), direction.dot(self.back)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOX: [[f64; 3]; 2] = [[-1.0, -1.0, 0.0], [1.0, 1.0, 0.5]];

    #[test]
    fn the_top_view_maps_a_square_to_the_rectangle() {
        let camera = Camera::new([0.0, 0.0, 1.0], [0.0, 1.0, 0.0], BOX, [10.0, 20.0, 210.0, 220.0]);
        let projected = camera.project([-1.0, 1.0, 0.25]);
        assert!(
            (projected.x - 10.0).abs() < 1e-9 && (projected.y - 20.0).abs() < 1e-9 && projected.near.abs() < 1e-9,
            "{projected:?}"
        );
        assert_eq!(camera.scale, 100.0);
    }

    #[test]
    fn every_corner_is_inside_and_points_come_back() {
        for view in [[1.0, -2.0, 0.6], [0.0, 0.0, -3.0], [0.0, 1.0, 0.0]] {
            let camera = Camera::new(view, [0.0, 0.0, 1.0], BOX, [0.0, 0.0, 300.0, 100.0]);
            for corner in [BOX[0], BOX[1], [1.0, -1.0, 0.5]] {
                let projected = camera.project(corner);
                assert!((-1e-9..=300.0 + 1e-9).contains(&projected.x) && (-1e-9..=100.0 + 1e-9).contains(&projected.y));
                assert!((Vector(camera.point(projected)) - Vector(corner)).norm() < 1e-12);
            }
        }
    }

    #[test]
    fn points_nearer_to_the_eye_are_seen_nearer() {
        let camera = Camera::new([1.0, -2.0, 0.6], [0.0, 0.0, 1.0], BOX, [0.0, 0.0, 300.0, 100.0]);
        assert!(camera.project([0.1, -0.2, 0.06]).near > camera.project([0.0; 3]).near);
        assert!(camera.project([0.0, 0.0, 0.1]).y < camera.project([0.0; 3]).y, "up is up");
    }
}
