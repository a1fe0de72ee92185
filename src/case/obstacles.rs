//! Obstacles as pictures show them.

use super::Case;
use crate::geometry::Region;
use crate::math::Signal;
use crate::output::picture::PictureObstacle;

/// An obstacle of the case, as pictures show it.
struct ObstacleRegion {
    region: Region,
    velocity: [Signal; 3],
}

impl PictureObstacle for ObstacleRegion {
    fn distance(&self, x: [f64; 3]) -> f64 {
        self.region.signed_distance(x)
    }

    /// Displacement by the midpoint rule: exact for constant velocities, and accurate enough for pictures.
    fn displacement(&self, t: f64) -> [f64; 3] {
        const INTERVALS: usize = 256;
        let dt = t / INTERVALS as f64;
        let midpoints = || (0..INTERVALS).map(move |n| (n as f64 + 0.5) * dt);
        std::array::from_fn(|axis| midpoints().map(|t| self.velocity[axis].value([0.0; 3], t) * dt).sum())
    }
}

impl Case {
    /// The obstacles, for pictures; those that can't be built are left out (building the case reports them).
    pub fn obstacles(&self) -> Vec<Box<dyn PictureObstacle>> {
        let base = &self.source.base;
        let standing = self.file.obstacle.iter().filter_map(|spec| {
            let region = spec.region.build(base, self.file.dimension).ok()?;
            let velocity = spec.velocity.each_ref().map(|signal| signal.build(base).unwrap_or(Signal::ZERO));
            Some(Box::new(ObstacleRegion { region, velocity }) as Box<dyn PictureObstacle>)
        });
        standing.collect()
    }
}
