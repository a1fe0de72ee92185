//! Sums over particles, and what a step finds out about those of a body.

/// Sums over particles, added in a fixed order.
pub(crate) trait Reduce: Send + Default {
    /// The sum of both.
    fn plus(self, other: Self) -> Self;
}

impl Reduce for () {
    fn plus(self, (): ()) {}
}

/// A sum.
impl Reduce for f64 {
    fn plus(self, other: Self) -> Self {
        self + other
    }
}

/// Sums over the particles of a body, and the findings of a step about them.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(in crate::mpm) struct Summary {
    /// Kinetic energy [J].
    pub kinetic: f64,
    /// Internal energy [J].
    pub internal: f64,
    /// The part of it that the transfer has dissipated on the grid in this step [J].
    pub heat: f64,
    /// Work on volumes that the shifting of particles takes from [J].
    pub volume_work: f64,
    /// Largest wave speed + |v| [m/s].
    pub largest_wave_speed: f64,
    /// Largest displacement along an axis [m].
    pub shift: f64,
    /// A particle was turned inside out.
    pub inverted: bool,
    /// A particle is not finite, or not in the domain.
    pub lost: bool,
    /// Number of times nodes were read in the last gather: the fewer, the better the particles are sorted.
    pub visits: usize,
}

impl Summary {
    /// A particle was turned inside out.
    pub fn inverted() -> Self {
        Self { inverted: true, ..Self::default() }
    }
}

impl Reduce for Summary {
    fn plus(self, other: Self) -> Self {
        Self {
            kinetic: self.kinetic + other.kinetic,
            internal: self.internal + other.internal,
            heat: self.heat + other.heat,
            volume_work: self.volume_work + other.volume_work,
            largest_wave_speed: self.largest_wave_speed.max(other.largest_wave_speed),
            shift: self.shift.max(other.shift),
            inverted: self.inverted | other.inverted,
            lost: self.lost | other.lost,
            visits: self.visits + other.visits,
        }
    }
}
