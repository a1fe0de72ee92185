//! The side of a particle is a constant of the run: what guards it at the end of a step, after sheets and particles have moved.
//!
//! ```text
//! c (d(x_p) − 0) ≥ r_min:   else   x_p ← x_p + (c r_min − d) n          d, n: exact distance from the moved facets, c: the side of p
//! ```
//!
//! Contact stops velocities, not positions, so that particles under pressure creep towards a sheet, and through it where its elements
//! are large or folded. The least distance r_min is a quarter of the particle's size; where layers are nearer to each other than that, it is
//! halved until all have room. What still finds no place keeps its place next to the facet that it was next to. No particle is ever on the
//! wrong side of a sheet that it has a side of (theory D.12). A particle is looked at when it and the sheet together have moved by as much as
//! it was farther away than r_min at the start of the step.
//!
//! Neither momentum nor energy changes; what the forces would have done on the way is booked (`shifting`).

use super::closest_point::Nearest;
use super::facet::Facet;
use crate::math::Vector;
use crate::mpm::Body;
use crate::parallel;

/// The least distance from a sheet over the particle's half size.
const CLOSEST: f64 = 0.5;

/// By how much [cells] heights may be off that are not those of the particle from the facets: beside folds as the nodes see them, and where the
/// point on a skin stands for its particles.
pub const DOUBT: f64 = 0.25;

/// How often the least distance is halved where layers leave no room, and how often places are corrected for each.
const HALVINGS: usize = 4;
const TRIES: usize = 3;

/// Share of the least distance that a correction may lack.
const CLOSE: f64 = 1e-3;

/// Particles per parallel task.
const TASK: usize = 256;

/// A particle that is to be displaced.
#[derive(Debug, Clone, Copy)]
pub struct Shift<const D: usize> {
    /// Index of the particle.
    pub particle: u32,
    /// By how much [m].
    pub by: Vector<D>,
}

/// A particle next to a sheet of which it has a side.
#[derive(Debug, Clone, Copy)]
pub struct Near<const D: usize> {
    /// Index of the particle, of its body, and of the sheet.
    pub particle: u32,
    pub body: u32,
    pub sheet: u32,
    /// +1 where the normals of the sheet point.
    pub side: f64,
    /// r_min, and how much farther from the sheet it was at the start of the step, at least [m].
    pub least: f64,
    pub room: f64,
    /// Unit vector from the sheet to the particle.
    pub away: Vector<D>,
    /// Where the particle was at the start of the step [m].
    pub from: Vector<D>,
}

impl<const D: usize> Near<D> {
    /// A particle of this half size that was at `from` [m], at least `height` [m] from the sheet on its side.
    pub fn new(
        [particle, body, sheet]: [usize; 3],
        (side, normal): (f64, Vector<D>),
        (height, radius): (f64, f64),
        from: Vector<D>,
    ) -> Self {
        let least = CLOSEST * radius;
        let [particle, body, sheet] = [particle, body, sheet].map(|index| index as u32);
        Self { particle, body, sheet, side, least, room: height - least, away: normal * side, from }
    }

    fn key(&self) -> (u32, u32, u32) {
        (self.body, self.particle, self.sheet)
    }
}

/// Where a particle is now [m].
fn place<const D: usize>(near: &Near<D>, bodies: &[Body<D>]) -> Vector<D> {
    bodies[near.body as usize].particles.position[near.particle as usize]
}

/// A sheet at the end of a step.
#[derive(Debug, Clone, Copy)]
pub struct Moved<'a, const D: usize> {
    pub nearest: &'a Nearest<D>,
    pub facets: &'a [Facet],
    /// Where its nodes were at the start of the step, and where they are now [m].
    pub before: &'a [Vector<D>],
    pub position: &'a [Vector<D>],
}

/// Those of `near` that have left their room in the step, and may be too near to their sheets now: each once for a sheet, in the order of
/// their bodies and particles. `travel` [m]: how far the nodes of each sheet moved at most.
pub fn suspects<const D: usize>(near: &[Near<D>], travel: &[f64], bodies: &[Body<D>]) -> Vec<(u32, u32, u32)> {
    let moved = |near: &Near<D>| (place(near, bodies) - near.from).norm() + travel[near.sheet as usize];
    let left = |n: usize| Some(&near[n]).filter(|near| near.room < moved(near)).map(Near::key);
    let mut left = parallel::collect_some(near.len(), TASK, left);
    left.sort_unstable();
    left.dedup();
    left
}

/// The displacements that keep the suspected particles on their sides, in the order of `near`, in which a particle's sheets may be anywhere.
pub fn keep_sides<const D: usize>(
    near: &[Near<D>],
    suspects: &[(u32, u32, u32)],
    sheets: &[Moved<'_, D>],
    bodies: &[Body<D>],
    cell: f64,
) -> Vec<(u32, Shift<D>)> {
    let mut all: Vec<&Near<D>> = near.iter().collect();
    all.sort_by_key(|near| near.key());
    let fails = |suspect: &&(u32, u32, u32)| {
        let same = &all[all.partition_point(|near| near.key() < **suspect)..];
        let least = same.iter().take_while(|near| near.key() == **suspect).map(|near| near.least).fold(0.0, f64::max);
        lack(same[0], sheets, place(same[0], bodies), least, cell).is_some()
    };
    let wrong = |n: usize| Some(&suspects[n]).filter(fails).map(|&(body, particle, _)| (body, particle));
    let mut wrong: Vec<(u32, u32)> = parallel::collect_some(suspects.len(), TASK, wrong);
    wrong.dedup();
    let correct = |n: usize| {
        let (body, particle) = wrong[n];
        let start = all.partition_point(|near| (near.body, near.particle) < (body, particle));
        let end = all.partition_point(|near| (near.body, near.particle) <= (body, particle));
        let x = place(all[start], bodies);
        (body, Shift { particle, by: admissible(&all[start..end], sheets, x, cell) - x })
    };
    parallel::collect(wrong.len(), 16, correct)
}

/// What has to be added to `x` [m] to be `least` [m] from the sheet on the right side; `None` if it is.
fn lack<const D: usize>(
    near: &Near<D>,
    sheets: &[Moved<'_, D>],
    x: Vector<D>,
    least: f64,
    cell: f64,
) -> Option<Vector<D>> {
    let Moved { nearest, facets, .. } = sheets[near.sheet as usize];
    let foot = nearest.foot(facets, x, cell).filter(|foot| !foot.beyond)?;
    let missing = least - near.side * foot.distance;
    (missing > CLOSE * least).then(|| foot.normal * (near.side * missing))
}

/// A place near `x` [m] on the right side of all sheets that the particle is `near` to.
fn admissible<const D: usize>(near: &[&Near<D>], sheets: &[Moved<'_, D>], x: Vector<D>, cell: f64) -> Vector<D> {
    for halving in 0..=HALVINGS {
        let share = 0.5_f64.powi(halving as i32);
        let mut place = x;
        for _ in 0..TRIES {
            let mut fits = true;
            for near in near {
                if let Some(by) = lack(near, sheets, place, share * near.least, cell) {
                    (place, fits) = (place + by, false);
                }
            }
            if fits {
                return place;
            }
        }
    }
    near.iter().find_map(|near| beside_the_same_facet(near, sheets, cell)).unwrap_or(x)
}

/// The place next to the facet that the particle was next to at the start of the step, as far from it as then.
fn beside_the_same_facet<const D: usize>(near: &Near<D>, sheets: &[Moved<'_, D>], cell: f64) -> Option<Vector<D>> {
    let Moved { nearest, facets, before, position } = sheets[near.sheet as usize];
    let foot = nearest.foot_at(facets, before, near.from, cell)?;
    let nodes = facets[foot.facet as usize].nodes.iter().zip(foot.weights);
    let point: Vector<D> = nodes.map(|(&k, weight)| position[k as usize] * weight).sum();
    // On the sheet itself the direction is that of its mean normal, into a wedge along its middle.
    let normal = nearest.foot(facets, point, cell)?.normal;
    let height = (near.side * foot.distance).clamp(CLOSEST * near.least, near.least);
    Some(point + normal * (near.side * height))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A particle at `x` on the inner side of a chain that is folded once around a point.
    fn kept(points: &[[f64; 2]], x: [f64; 2], side: f64) -> Vector<2> {
        let position: Vec<Vector<2>> = points.iter().copied().map(Vector).collect();
        let facets: Vec<Facet> = (1..points.len() as u32).map(|k| Facet::new(&[k - 1, k])).collect();
        let mut nearest = Nearest::new(&facets, position.len());
        nearest.refresh(&facets, &position, 0.5, 0.5);
        let sheet = Moved { nearest: &nearest, facets: &facets, before: &position, position: &position };
        let (from, away) = (Vector(x), Vector::ZERO);
        let near = Near { particle: 0, body: 0, sheet: 0, side, least: 0.1, room: 0.0, away, from };
        admissible(&[&near], &[sheet], from, 0.5)
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
    fn between_layers_there_is_a_place() {
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
