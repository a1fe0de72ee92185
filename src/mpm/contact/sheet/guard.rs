//! The side of a particle is a constant of the run: positions are corrected at the end of a step, after sheets and
//! particles have moved.
//!
//! ```text
//! c d(x_p) ≥ r_min:   else   x_p ← x_p + (c r_min − d) n   d, n: exact distance from the moved facets, c: the side of p
//! ```
//!
//! Contact stops velocities, not positions, so that particles under pressure creep towards a sheet, and through it
//! where its elements are large or folded. The least distance r_min is a quarter of the particle's size; where layers
//! are nearer to each other than that, it is halved until all distances are kept. A particle for which this fails is
//! put next to the facet that it was next to at the start of the step. No particle is ever on the wrong side of a sheet
//! that it has a side of (theory D.12). A particle is checked only when it and the sheet together have moved by as much
//! as it was farther away than r_min at the start of the step.
//!
//! Neither momentum nor energy changes; the work that the forces would have done along the displacement is booked
//! (`shifting`).

use super::closest_point::Nearest;
use crate::math::Vector;
use crate::mpm::contact::facet::SheetFacet;
use crate::mpm::particles::Bodies;
use crate::parallel;

/// The least distance from a sheet over the particle's half size.
const LEAST_SHEET_DISTANCE: f64 = 0.5;

/// Error of heights [cells] that are not those of the particle from the facets: beside folds as the nodes see them, and
/// where the point on a skin stands for its particles.
pub const HEIGHT_ERROR: f64 = 0.25;

/// Most halvings of the least distance where layers leave no room, and corrections of positions for each.
const HALVINGS: usize = 4;
const TRIES: usize = 3;

/// Fraction of the least distance that a correction may lack.
const DISTANCE_TOLERANCE: f64 = 1e-3;

/// Particles per parallel task.
const TASK: usize = 256;

/// Corrected particles per parallel task.
const CORRECTIONS: usize = 16;

/// The displacement of a particle at the end of a step.
#[derive(Debug, Clone, Copy)]
pub struct ParticleShift<const D: usize> {
    /// Index of the particle.
    pub particle: u32,
    /// Displacement [m].
    pub by: Vector<D>,
}

/// Indices of a particle, of its body, and of a sheet next to it.
#[derive(Debug, Clone, Copy)]
pub struct ParticleAtSheet {
    pub particle: usize,
    pub body: usize,
    pub sheet: usize,
}

/// The side of a sheet on which something is.
#[derive(Debug, Clone, Copy)]
pub struct SideOfSheet<const D: usize> {
    /// +1 where the normals of the sheet point.
    pub side: f64,
    /// Unit normal of the sheet.
    pub normal: Vector<D>,
    /// Lower bound of the distance from the sheet on that side [m].
    pub height: f64,
}

/// A particle next to a sheet of which it has a side.
#[derive(Debug, Clone, Copy)]
pub struct GuardedParticle<const D: usize> {
    /// Index of the particle, of its body, and of the sheet.
    pub particle: u32,
    pub body: u32,
    pub sheet: u32,
    /// +1 where the normals of the sheet point.
    pub side: f64,
    /// r_min [m].
    pub least_distance: f64,
    /// Lower bound of the distance at the start of the step, less r_min [m].
    pub margin: f64,
    /// Unit vector from the sheet to the particle.
    pub away: Vector<D>,
    /// Position at the start of the step [m].
    pub start: Vector<D>,
}

impl<const D: usize> GuardedParticle<D> {
    /// A particle of this half size [m] that is at `start` [m] at the start of the step.
    pub fn new(at: ParticleAtSheet, beside: SideOfSheet<D>, half_size: f64, start: Vector<D>) -> Self {
        let least_distance = LEAST_SHEET_DISTANCE * half_size;
        let [particle, body, sheet] = [at.particle, at.body, at.sheet].map(|index| index as u32);
        let SideOfSheet { side, normal, height } = beside;
        Self {
            particle,
            body,
            sheet,
            side,
            least_distance,
            margin: height - least_distance,
            away: normal * side,
            start,
        }
    }

    fn key(&self) -> (u32, u32, u32) {
        (self.body, self.particle, self.sheet)
    }

    /// Present position [m].
    fn position(&self, bodies: &Bodies<D>) -> Vector<D> {
        bodies[self.body as usize].particles.position[self.particle as usize]
    }
}

/// A sheet at the end of a step.
#[derive(Debug, Clone, Copy)]
pub struct MovedSheet<'a, const D: usize> {
    pub nearest: &'a Nearest<D>,
    pub facets: &'a [SheetFacet],
    /// Positions of its nodes at the start of the step, and now [m].
    pub before: &'a [Vector<D>],
    pub position: &'a [Vector<D>],
}

/// Particles that have moved farther than their margin in the step, with their bodies and sheets: each once for a
/// sheet, in the order of bodies and particles. `travel` [m]: how far the nodes of each sheet moved at most.
pub fn particles_to_check<const D: usize>(
    guarded: &[GuardedParticle<D>],
    travel: &[f64],
    bodies: &Bodies<D>,
) -> Vec<(u32, u32, u32)> {
    let moved = |near: &GuardedParticle<D>| (near.position(bodies) - near.start).norm() + travel[near.sheet as usize];
    let left = |n: usize| Some(&guarded[n]).filter(|near| near.margin < moved(near)).map(GuardedParticle::key);
    let mut left = parallel::collect_some(guarded.len(), TASK, left);
    left.sort_unstable();
    left.dedup();
    left
}

/// The displacements that keep the particles to check on their sides of all sheets next to them; those of `guarded`
/// that belong to one particle need not follow each other.
pub fn keep_sides<const D: usize>(
    guarded: &[GuardedParticle<D>],
    to_check: &[(u32, u32, u32)],
    sheets: &[MovedSheet<'_, D>],
    bodies: &Bodies<D>,
    cell: f64,
) -> Vec<(u32, ParticleShift<D>)> {
    let mut all: Vec<&GuardedParticle<D>> = guarded.iter().collect();
    all.sort_by_key(|near| near.key());
    let fails = |key: &&(u32, u32, u32)| {
        let same = &all[all.partition_point(|near| near.key() < **key)..];
        let own = same.iter().take_while(|near| near.key() == **key);
        let least_distance = own.map(|near| near.least_distance).fold(0.0, f64::max);
        correction(same[0], sheets, same[0].position(bodies), least_distance, cell).is_some()
    };
    let wrong = |n: usize| Some(&to_check[n]).filter(fails).map(|&(body, particle, _)| (body, particle));
    let mut wrong: Vec<(u32, u32)> = parallel::collect_some(to_check.len(), TASK, wrong);
    wrong.dedup();
    let correct = |n: usize| {
        let (body, particle) = wrong[n];
        let start = all.partition_point(|near| (near.body, near.particle) < (body, particle));
        let end = all.partition_point(|near| (near.body, near.particle) <= (body, particle));
        let x = all[start].position(bodies);
        (body, ParticleShift { particle, by: admissible_position(&all[start..end], sheets, x, cell) - x })
    };
    parallel::collect(wrong.len(), CORRECTIONS, correct)
}

/// The displacement from `x` [m] to the distance `least_distance` [m] from the sheet on the particle's side; `None`
/// where `x` is as far.
fn correction<const D: usize>(
    near: &GuardedParticle<D>,
    sheets: &[MovedSheet<'_, D>],
    x: Vector<D>,
    least_distance: f64,
    cell: f64,
) -> Option<Vector<D>> {
    let MovedSheet { nearest, facets, .. } = sheets[near.sheet as usize];
    let foot = nearest.foot(facets, x, cell).filter(|foot| !foot.beyond)?;
    let missing = least_distance - near.side * foot.distance;
    (missing > DISTANCE_TOLERANCE * least_distance).then(|| foot.normal * (near.side * missing))
}

/// A position near `x` [m] on the particle's sides of all sheets that it is next to.
fn admissible_position<const D: usize>(
    near: &[&GuardedParticle<D>],
    sheets: &[MovedSheet<'_, D>],
    x: Vector<D>,
    cell: f64,
) -> Vector<D> {
    for halving in 0..=HALVINGS {
        let fraction = 0.5_f64.powi(halving as i32);
        let mut position = x;
        for _ in 0..TRIES {
            let mut fits = true;
            for near in near {
                if let Some(by) = correction(near, sheets, position, fraction * near.least_distance, cell) {
                    (position, fits) = (position + by, false);
                }
            }
            if fits {
                return position;
            }
        }
    }
    near.iter().find_map(|near| beside_the_same_facet(near, sheets, cell)).unwrap_or(x)
}

/// The position next to the facet that the particle was next to at the start of the step, as far from it as then.
fn beside_the_same_facet<const D: usize>(
    near: &GuardedParticle<D>,
    sheets: &[MovedSheet<'_, D>],
    cell: f64,
) -> Option<Vector<D>> {
    let MovedSheet { nearest, facets, before, position } = sheets[near.sheet as usize];
    let foot = nearest.foot_at(facets, before, near.start, cell)?;
    let nodes = facets[foot.facet as usize].nodes.iter().zip(foot.weights);
    let point: Vector<D> = nodes.map(|(&k, weight)| position[k as usize] * weight).sum();
    // On the sheet itself the direction is that of its mean normal, into a wedge along its middle.
    let normal = nearest.foot(facets, point, cell)?.normal;
    let height = (near.side * foot.distance).clamp(LEAST_SHEET_DISTANCE * near.least_distance, near.least_distance);
    Some(point + normal * (near.side * height))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The place that a particle at `x` next to a chain is moved to, on the side that it has.
    fn kept(points: &[[f64; 2]], x: [f64; 2], side: f64) -> Vector<2> {
        let position: Vec<Vector<2>> = points.iter().copied().map(Vector).collect();
        let facets: Vec<SheetFacet> = (1..points.len() as u32).map(|k| SheetFacet::new(&[k - 1, k])).collect();
        let mut nearest = Nearest::new(&facets, position.len());
        nearest.refresh(&facets, &position, 0.5, 0.5);
        let sheet = MovedSheet { nearest: &nearest, facets: &facets, before: &position, position: &position };
        let (start, away) = (Vector(x), Vector::ZERO);
        let guarded =
            GuardedParticle { particle: 0, body: 0, sheet: 0, side, least_distance: 0.1, margin: 0.0, away, start };
        admissible_position(&[&guarded], &[sheet], start, 0.5)
    }

    /// On the wrong side of a plane, too near to it, and far enough.
    #[test]
    fn particles_keep_their_least_distance() {
        let line = [[0.0, 0.0], [0.5, 0.0], [1.0, 0.0]];
        // The normal of a segment is to the right of its direction: below this line.
        for (x, side, expected) in [(-0.05, 1.0, -0.1), (0.07, 1.0, -0.1), (0.05, -1.0, 0.1), (0.3, -1.0, 0.3)] {
            let place = kept(&line, [0.4, x], side);
            assert!((place - Vector([0.4, expected])).norm() < 1e-3, "{x} {side}: {place:?}");
        }
    }

    /// Between two layers that are nearer to each other than twice the least distance, and in the corner of a wedge.
    #[test]
    fn particles_between_close_layers_stay_between_them() {
        let hairpin = [[0.0, 0.0], [1.0, 0.0], [1.0, 0.12], [0.0, 0.12]];
        for y in [0.01, 0.06, 0.115, -0.02, 0.13] {
            let Vector([x, y]) = kept(&hairpin, [0.5, y], -1.0);
            assert!((x - 0.5).abs() < 1e-9 && (0.02..0.1).contains(&y), "{x} {y}");
        }
        let wedge = [[1.0, -0.2], [0.0, 0.0], [1.0, 0.2]];
        let Vector([x, y]) = kept(&wedge, [-0.05, 0.01], 1.0);
        assert!(y.abs() < 0.2 * x, "{x} {y}");
    }
}
