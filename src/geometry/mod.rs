//! Regions of space: shapes, their unions, intersections and differences, triangulated surfaces;
//! sampling with particles. Points have three coordinates; in 2D the third is zero and ignored.

/// A region of space.
#[derive(Debug, Clone)]
pub enum Region {
    /// An axis-aligned box (a rectangle in 2D).
    Box {
        /// Lower corner [m].
        lower: [f64; 3],
        /// Upper corner [m].
        upper: [f64; 3],
    },
}

impl Region {
    /// True inside or on the boundary.
    pub fn contains(&self, x: [f64; 3]) -> bool {
        self.signed_distance(x) <= 0.0
    }

    /// Distance to the boundary [m], negative inside.
    pub fn signed_distance(&self, x: [f64; 3]) -> f64 {
        match self {
            Self::Box { lower, upper } => {
                let outside: [f64; 3] = std::array::from_fn(|i| (lower[i] - x[i]).max(x[i] - upper[i]));
                outside.into_iter().fold(f64::NEG_INFINITY, f64::max)
            }
        }
    }
}
