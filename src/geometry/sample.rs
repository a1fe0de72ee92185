//! Filling a region with particles on a lattice.
//!
//! ```text
//! x = origin + (i + 1/2) h,   i integer,   kept where d(x) ≤ 0
//! ```
//!
//! Whole blocks of lattice points are accepted or rejected at once where |d| at the block's centre
//! exceeds its half diagonal (|∇d| ≤ 1), so that only blocks at the boundary are tested point by point.

use super::{Bounds, Region};
use crate::error::Diagnostic;
use crate::memory;
use crate::parallel;

/// Lattice points per block side.
const BLOCK: i64 = 8;

/// Points this near to the boundary, as a fraction of the spacing, count as inside, so that rounding does
/// not decide about points that lie on it.
const ON_BOUNDARY: f64 = 1e-9;

/// Advice about too many particles.
const FEWER_PARTICLES: &str = "increase `spacing`, or make the region smaller: are the units of both right?";

/// Most particles of one region: identities have 32 bits.
const MOST_PARTICLES: f64 = u32::MAX as f64;

/// Least memory per particle, with its columns in a solver.
const BYTES: f64 = 300.0;

/// Places along each axis at which the fraction of its bounds that a region fills is estimated, in 2D and in 3D.
const PLACES: [usize; 2] = [512, 64];

/// Particles of one region.
#[derive(Debug, Clone, PartialEq)]
pub struct Sample {
    /// Positions [m].
    pub position: Vec<[f64; 3]>,
    /// Volume of each particle: spacing^D [m³; m² in 2D], unless [`Sample::with_exact_volume`] changed it.
    pub volume: f64,
    /// Distance of the particles [m].
    pub spacing: f64,
    /// A corner of the lattice's cells [m].
    pub origin: [f64; 3],
}

impl Sample {
    /// The lattice index i of a particle at `x`: particles of one line or layer share entries of it.
    pub fn lattice_index(&self, x: [f64; 3]) -> [i64; 3] {
        std::array::from_fn(|i| ((x[i] - self.origin[i]) / self.spacing - 0.5).round() as i64)
    }

    /// Scales the particle volume so that the particles add up to the exact volume of the region, if a
    /// formula gives it.
    ///
    /// A lattice fills a curved body with a few percent of its volume too much or too little. The total
    /// mass is then wrong by as much, but each particle stands for just its lattice cell, so that a
    /// uniform density gives no spurious pressure. With the exact volume the mass is right and the
    /// density per cell slightly off: right for bodies whose momentum matters, as the paper's water
    /// sphere of 0.3817 g.
    #[must_use]
    pub fn with_exact_volume(mut self, region: &Region, dimension: usize) -> Self {
        if let (Some(exact), false) = (region.measure(dimension), self.position.is_empty()) {
            self.volume = exact / self.position.len() as f64;
        }
        self
    }
}

/// The particles of `region` on the lattice of `spacing` [m] whose cells have a corner at `origin` [m].
///
/// `origin` is the lower corner of the background grid, for particles that sit alike in every grid cell,
/// or [`centred_origin`], for bodies that keep their symmetry. The order is by blocks of the lattice and
/// does not depend on the number of threads.
///
/// # Errors
/// The spacing is not positive, the region is unbounded, or the particles would be too many. A region
/// that holds no lattice point is no error here: the sample is empty.
pub fn sample(region: &Region, spacing: f64, dimension: usize, origin: [f64; 3]) -> Result<Sample, Diagnostic> {
    if !(spacing > 0.0 && spacing.is_finite()) {
        return Err(Diagnostic::error("spacing", format!("must be positive and finite, not {spacing}")));
    }
    let bounds = finite_bounds(region, dimension)?;
    let lattice = ParticleLattice { spacing, dimension, origin };
    let blocks = lattice.blocks(region, &bounds)?;
    let position = parallel::collect_all(blocks.count(), 1, |block| lattice.fill(region, &blocks, block));
    Ok(Sample { position, volume: spacing.powi(dimension as i32), spacing, origin })
}

/// The lattice origin that makes the lattice symmetric about the centre of the region's bounds: as many
/// cells along each axis as fit best, so that a box is filled from face to face.
///
/// # Errors
/// The region is unbounded.
pub fn centred_origin(region: &Region, spacing: f64, dimension: usize) -> Result<[f64; 3], Diagnostic> {
    let Bounds { lower, upper } = finite_bounds(region, dimension)?;
    Ok(std::array::from_fn(|i| {
        if i >= dimension {
            return 0.0;
        }
        let cells = ((upper[i] - lower[i]) / spacing).round();
        0.5 * (lower[i] + upper[i]) - 0.5 * cells * spacing
    }))
}

fn finite_bounds(region: &Region, dimension: usize) -> Result<Bounds, Diagnostic> {
    let bounds = region.bounds();
    if bounds.is_bounded(dimension) {
        return Ok(bounds);
    }
    Err(Diagnostic::error("region", "the region reaches to infinity and can't be filled with particles")
        .help("intersect it with a box: `{ shape = \"intersection\", of = [...] }`"))
}

/// The lattice of particles, whose cells have a corner at the origin.
struct ParticleLattice {
    spacing: f64,
    dimension: usize,
    origin: [f64; 3],
}

/// Blocks that cover the bounds of a region.
struct Blocks {
    first: [i64; 3],
    last: [i64; 3],
    shape: [usize; 3],
}

impl Blocks {
    fn count(&self) -> usize {
        self.shape.iter().product()
    }

    /// First and last lattice index of a block along each axis.
    fn range(&self, block: usize) -> [(i64, i64); 3] {
        let [nx, ny, _] = self.shape;
        let number = [block % nx, block / nx % ny, block / (nx * ny)];
        std::array::from_fn(|i| {
            let first = self.first[i] + number[i] as i64 * BLOCK;
            (first, (first + BLOCK - 1).min(self.last[i]))
        })
    }
}

impl ParticleLattice {
    fn at(&self, index: [i64; 3]) -> [f64; 3] {
        std::array::from_fn(|i| {
            if i < self.dimension { self.origin[i] + (index[i] as f64 + 0.5) * self.spacing } else { 0.0 }
        })
    }

    /// The fraction of its bounds that a region fills, from its distance at the centres of cells: each is cut by a
    /// plane there.
    fn filled_fraction(&self, region: &Region, bounds: &Bounds) -> f64 {
        let n = PLACES[usize::from(self.dimension == 3)];
        let edge: [f64; 3] =
            std::array::from_fn(
                |i| {
                    if i < self.dimension { (bounds.upper[i] - bounds.lower[i]) / n as f64 } else { 0.0 }
                },
            );
        let diagonal = edge.iter().map(|h| h * h).sum::<f64>().sqrt();
        let filled = |cell: usize| {
            let index = [cell % n, cell / n % n, cell / (n * n)];
            let at =
                |i: usize| if i < self.dimension { bounds.lower[i] + (index[i] as f64 + 0.5) * edge[i] } else { 0.0 };
            (0.5 - region.signed_distance(std::array::from_fn(at)) / diagonal).clamp(0.0, 1.0)
        };
        let cells = n.pow(self.dimension as u32);
        let fractions: Vec<f64> = parallel::collect(cells, 256, filled);
        fractions.iter().sum::<f64>() / cells as f64
    }

    /// Why the particles don't fit into the memory, counted before any of them is made; `None` if they do.
    fn refusal(&self, region: &Region, bounds: &Bounds, points: f64) -> Option<String> {
        memory::refusal(BYTES * points)?;
        let particles = points * self.filled_fraction(region, bounds);
        let refusal = memory::refusal(BYTES * particles)?;
        Some(format!("about {particles:.1e} particles, {} m apart, take {refusal}", self.spacing))
    }

    fn blocks(&self, region: &Region, bounds: &Bounds) -> Result<Blocks, Diagnostic> {
        let extent = |i: usize| ((bounds.upper[i] - bounds.lower[i]) / self.spacing).max(0.0) + 2.0;
        let expected: f64 = (0..self.dimension).map(extent).product();
        let farthest = (0..self.dimension)
            .flat_map(|i| [bounds.lower[i], bounds.upper[i]].map(|b| ((b - self.origin[i]) / self.spacing).abs()))
            .fold(0.0, f64::max);
        if !(expected <= MOST_PARTICLES && farthest <= MOST_PARTICLES) {
            let size = (0..self.dimension).map(|i| bounds.upper[i] - bounds.lower[i]).fold(0.0, f64::max);
            let message = format!(
                "a lattice of {expected:.3e} points, {} m apart, covers the region of {size} m: too many",
                self.spacing
            );
            return Err(Diagnostic::error("spacing", message).help(FEWER_PARTICLES));
        }
        if let Some(message) = self.refusal(region, bounds, expected) {
            return Err(Diagnostic::error("spacing", message).help(FEWER_PARTICLES));
        }
        let index = |x: f64, i: usize| ((x - self.origin[i]) / self.spacing - 0.5).floor() as i64;
        let in_use = |i: usize| i < self.dimension;
        let first: [i64; 3] = std::array::from_fn(|i| if in_use(i) { index(bounds.lower[i], i) } else { 0 });
        let last: [i64; 3] = std::array::from_fn(|i| if in_use(i) { index(bounds.upper[i], i) + 1 } else { 0 });
        let points = |i: usize| (last[i] - first[i] + 1).max(0) as usize;
        let shape = std::array::from_fn(|i| points(i).div_ceil(BLOCK as usize));
        Ok(Blocks { first, last, shape })
    }

    /// The points of one block that lie in the region.
    fn fill(&self, region: &Region, blocks: &Blocks, block: usize) -> Vec<[f64; 3]> {
        let range = blocks.range(block);
        let (low, high) = (self.at(range.map(|r| r.0)), self.at(range.map(|r| r.1)));
        let centre = std::array::from_fn(|i| 0.5 * (low[i] + high[i]));
        let half_diagonal = 0.5 * (0..3).map(|i| (high[i] - low[i]).powi(2)).sum::<f64>().sqrt();
        let d = region.signed_distance(centre);
        let margin = half_diagonal + self.spacing;
        if d > margin {
            return Vec::new();
        }
        let inside = |x: [f64; 3]| d < -margin || region.signed_distance(x) <= ON_BOUNDARY * self.spacing;
        let [x, y, z] = range.map(|(first, last)| first..=last);
        let mut points = Vec::new();
        for k in z {
            for j in y.clone() {
                points.extend(x.clone().map(|i| self.at([i, j, k])).filter(|&x| inside(x)));
            }
        }
        points
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sphere(center: [f64; 3], radius: f64) -> Region {
        Region::Sphere { center, radius }
    }

    fn centred(region: &Region, spacing: f64, dimension: usize) -> Sample {
        let origin = centred_origin(region, spacing, dimension).unwrap();
        sample(region, spacing, dimension, origin).unwrap()
    }

    /// Half-integer points within radius R/h, counted with integers: (2i+1)² + (2j+1)² + (2k+1)² ≤ (2R/h)².
    fn lattice_points_in_sphere(radius_in_spacings: i64) -> usize {
        let (reach, limit) = (radius_in_spacings + 1, 4 * radius_in_spacings * radius_in_spacings);
        let odd = |i: i64| (2 * i + 1) * (2 * i + 1);
        let range = -reach..reach;
        range
            .clone()
            .flat_map(|i| range.clone().map(move |j| odd(i) + odd(j)))
            .flat_map(|ij| (-reach..reach).map(move |k| ij + odd(k)))
            .filter(|&sum| sum <= limit)
            .count()
    }

    #[test]
    fn a_sphere_holds_the_lattice_points_that_integers_count() {
        for (radius, center) in [(4.5, [0.0, 0.0, 5.5]), (15.0, [0.3, -0.7, 15.0])] {
            let count = centred(&sphere(center, radius), 0.5, 3).position.len();
            assert_eq!(count, lattice_points_in_sphere((radius / 0.5) as i64), "R = {radius}");
        }
    }

    #[test]
    fn the_paper_s_spheres_have_its_particle_numbers() {
        // 4π R³/3h³ = 3053.6 and 113 097: a lattice has a few more or less.
        let small = centred(&sphere([0.0, 0.0, 5.5], 4.5), 0.5, 3).position.len() as f64;
        let large = centred(&sphere([0.0, 0.0, 15.0], 15.0), 0.5, 3).position.len() as f64;
        assert!((small / 3053.6 - 1.0).abs() < 0.02, "{small}");
        assert!((large / 113_097.3 - 1.0).abs() < 0.002, "{large}");
    }

    #[test]
    fn the_exact_volume_gives_the_paper_s_mass_of_water() {
        let region = sphere([0.0, 0.0, 5.5e-3], 4.5e-3);
        let sample = centred(&region, 0.5e-3, 3).with_exact_volume(&region, 3);
        let grams = 1e6 * sample.volume * sample.position.len() as f64;
        assert!((grams - 0.3817).abs() < 5e-5, "{grams}");
    }

    #[test]
    fn a_box_is_filled_from_face_to_face_and_its_volume_is_exact() {
        let region = Region::Box { lower: [0.1, -0.2, 0.0], upper: [0.4, 0.3, 0.7] };
        let sample = centred(&region, 0.1, 3);
        assert_eq!(sample.position.len(), 3 * 5 * 7);
        assert!((sample.volume * 105.0 - 0.105).abs() < 1e-15);
        let least = sample.position.iter().map(|x| x[0]).fold(f64::INFINITY, f64::min);
        assert!((least - 0.15).abs() < 1e-15);
    }

    #[test]
    fn a_body_centred_on_its_lattice_has_its_momentum_at_its_centre() {
        let center = [0.123, -4.56, 7.89];
        let ring = Region::Intersection(vec![sphere(center, 1.0), Region::Complement(Box::new(sphere(center, 0.6)))]);
        let points = centred(&ring, 0.07, 3).position;
        let mean = |i: usize| points.iter().map(|x| x[i] - center[i]).sum::<f64>() / points.len() as f64;
        assert!(points.len() > 1000);
        (0..3).for_each(|i| assert!(mean(i).abs() < 1e-12, "{} along {i}", mean(i)));
    }

    #[test]
    fn blocks_taken_at_once_agree_with_testing_every_point() {
        let region = Region::Union(vec![
            Region::Cylinder { from: [-1.0, -1.0, -1.0], to: [1.0, 0.8, 1.2], radius: 0.4 },
            Region::Ellipsoid { center: [0.5, -0.5, 0.0], semi_axes: [0.9, 0.3, 0.6] },
        ]);
        let (h, origin) = (0.083, [0.01, 0.02, 0.03]);
        let mut points = sample(&region, h, 3, origin).unwrap().position;
        let range = -30..30;
        let at = |i: i32, axis: usize| origin[axis] + (f64::from(i) + 0.5) * h;
        let mut every: Vec<[f64; 3]> = range
            .clone()
            .flat_map(|i| range.clone().map(move |j| (i, j)))
            .flat_map(|(i, j)| range.clone().map(move |k| [at(i, 0), at(j, 1), at(k, 2)]))
            .filter(|&x| region.contains(x))
            .collect();
        let order = |a: &[f64; 3], b: &[f64; 3]| a.partial_cmp(b).unwrap();
        points.sort_by(order);
        every.sort_by(order);
        assert_eq!(points, every);
    }

    #[test]
    fn every_particle_has_a_lattice_index_of_its_own() {
        // Three particles across: the middle one lies at zero, where rounding has no preferred side.
        let region = Region::Box { lower: [-0.15, -0.15, -0.25], upper: [0.15, 0.15, 0.25] };
        let sample = centred(&region, 0.1, 3);
        let mut indices: Vec<_> = sample.position.iter().map(|&x| sample.lattice_index(x)).collect();
        indices.sort_unstable();
        indices.dedup();
        assert_eq!(indices.len(), 45);
        assert_eq!((indices[0], indices[44]), ([0; 3], [2, 2, 4]));
    }

    #[test]
    fn a_disc_is_sampled_in_the_plane() {
        let disc = sphere([0.0; 3], 1.0);
        let sample = centred(&disc, 0.01, 2);
        assert!(sample.position.iter().all(|x| x[2] == 0.0));
        let area = sample.volume * sample.position.len() as f64;
        assert!((area / std::f64::consts::PI - 1.0).abs() < 1e-3, "{area}");
    }

    #[test]
    fn the_fraction_of_its_bounds_that_a_region_fills_is_estimated() {
        const CENTRE: [f64; 3] = [1.0, 1.0, 0.0];
        let ring = |inner: f64| {
            Region::Intersection(vec![sphere(CENTRE, 2.0), Region::Complement(Box::new(sphere(CENTRE, inner)))])
        };
        for (dimension, ball) in [(2, std::f64::consts::PI / 4.0), (3, std::f64::consts::PI / 6.0)] {
            for inner in [0.0, 1.0, 1.8] {
                let exact = ball * (1.0 - (inner / 2.0_f64).powi(dimension as i32));
                let lattice = ParticleLattice { spacing: 1.0, dimension, origin: [0.0; 3] };
                let region = ring(inner);
                let fraction = lattice.filled_fraction(&region, &region.bounds());
                assert!((fraction / exact - 1.0).abs() < 0.01, "{fraction} {exact} in {dimension}D");
            }
        }
    }

    #[test]
    fn unbounded_and_huge_samples_are_refused() {
        let half = Region::HalfSpace { point: [0.0; 3], normal: [0.0, 0.0, 1.0] };
        assert!(sample(&half, 0.1, 3, [0.0; 3]).unwrap_err().message.contains("infinity"));
        let far = sphere([1e12, 0.0, 0.0], 1.0);
        assert_eq!(sample(&far, 1e-6, 3, [0.0; 3]).unwrap_err().key, "spacing");
        assert_eq!(sample(&far, f64::NAN, 3, [0.0; 3]).unwrap_err().key, "spacing");
    }

    #[test]
    fn a_region_between_lattice_points_gives_an_empty_sample() {
        let speck = sphere([0.0; 3], 0.01);
        assert!(sample(&speck, 1.0, 3, [0.0; 3]).unwrap().position.is_empty());
    }
}
