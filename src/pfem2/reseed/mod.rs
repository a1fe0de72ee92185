//! Keeps particles everywhere, and nowhere too many (theory 3.6).
//!
//! ```text
//! sub-cells of a simplex: 2^D simplices between its nodes and edge midpoints
//!   corner k:  N_k ≥ ½;  the middle of a tetrahedron by the signs of N_0 + N_3 − ½ and N_0 + N_1 − ½
//! none in a sub-cell, and the element below its nominal number:  a new particle at the centre of the sub-cell
//! more than `most` in a sub-cell:                     the closest two of one fluid become one at their mean
//! ```
//!
//! A new particle is traced back along its streamline for the whole step: it takes what the mesh had at the foot, or
//! what flowed in at the time when it crossed the inlet, so that it has the history of its place. The paper counts by
//! elements instead (see `elements`).

mod elements;

pub use elements::refill;

use super::convect::{End, Place, Streamlines};
use super::correct::at;
use super::particles::{GONE, Particles};
use crate::math::Vector;
use crate::mesh::Mesh;
use rayon::prelude::*;

/// By what particles are added and taken away.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Reseeding {
    /// By sub-cells: none stays empty, none is crowded.
    #[default]
    SubCells,
    /// By elements, before the projection and at the end of the step (the paper).
    Elements,
}

/// How many particles there should be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Density {
    /// In an element; empty sub-cells of elements that have as many are left alone.
    pub nominal: usize,
    /// Most in a sub-cell.
    pub most: usize,
}

impl Density {
    /// For elements seeded with `nominal` particles: a sub-cell may hold twice its share.
    pub fn new<const D: usize>(nominal: usize) -> Self {
        Self { nominal, most: (2 * nominal).div_ceil(1 << D).max(2) }
    }
}

/// Where new particles get their values from: the state at the start of the step.
pub struct Origin<'a, const D: usize, const N: usize> {
    /// The streamlines that the particles moved along.
    pub lines: &'a Streamlines<'a, D, N>,
    /// The step [s].
    pub dt: f64,
    /// Nodal velocity at its start [m/s].
    pub velocity: &'a [Vector<D>],
    /// Fluid at a place at its start, and the depth below the interface [m].
    pub fluid: &'a (dyn Fn(&Place<N>) -> (u8, f64) + Sync),
    /// Velocity [m/s] and fluid that flow in through the boundary facet of an element opposite to a local node, at a
    /// position [m] and a time after the start of the step [s]; `None` where nothing is prescribed.
    pub inflow: &'a (dyn Fn(usize, usize, Vector<D>, f64) -> Option<(Vector<D>, u8)> + Sync),
}

/// What was done.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Reseeded {
    /// New particles.
    pub added: usize,
    /// Of these, the ones that came in through an inlet.
    pub inflow: usize,
    /// Particles that were merged into another, or dropped where there were too many.
    pub merged: usize,
    /// Elements that had no particle.
    pub empty: usize,
}

/// A change of the columns.
enum Edit<const D: usize> {
    Add { position: Vector<D>, velocity: Vector<D>, fluid: u8, depth: f64, element: u32, inflow: bool },
    Merge { keep: usize, drop: usize },
    Drop { particle: usize },
}

impl<const D: usize> Particles<D> {
    /// Fills what is empty and thins out what is crowded, before the projection; `density` is that of sub-cells.
    pub fn reseed<const N: usize>(
        &mut self,
        mesh: &Mesh<D, N>,
        reseeding: Reseeding,
        density: Density,
        origin: &Origin<D, N>,
    ) -> Reseeded {
        let edits = |e: usize| match reseeding {
            Reseeding::SubCells => self.edits(mesh, e, density, origin),
            Reseeding::Elements => self.edits_of_element(mesh, e, origin),
        };
        let edits: Vec<Edit<D>> =
            (0..mesh.elements().len()).into_par_iter().with_min_len(256).flat_map_iter(edits).collect();
        let empty = self.first().windows(2).filter(|bounds| bounds[0] == bounds[1]).count();
        let mut done = Reseeded { empty, ..Reseeded::default() };
        for edit in &edits {
            self.apply(edit, &mut done);
        }
        if !edits.is_empty() {
            self.sort();
        }
        done
    }

    fn apply(&mut self, edit: &Edit<D>, done: &mut Reseeded) {
        match *edit {
            Edit::Add { position, velocity, fluid, depth, element, inflow } => {
                self.push(position, velocity, fluid, element);
                self.depth[self.position.len() - 1] = depth;
                done.added += 1;
                done.inflow += usize::from(inflow);
            }
            Edit::Merge { keep, drop } => {
                self.position[keep] = (self.position[keep] + self.position[drop]) * 0.5;
                self.velocity[keep] = (self.velocity[keep] + self.velocity[drop]) * 0.5;
                self.depth[keep] = (self.depth[keep] + self.depth[drop]) * 0.5;
                self.element[drop] = GONE;
                done.merged += 1;
            }
            Edit::Drop { particle } => {
                self.element[particle] = GONE;
                done.merged += 1;
            }
        }
    }

    /// By elements: a few particles where there are too few, none above the most.
    fn edits_of_element<const N: usize>(
        &self,
        mesh: &Mesh<D, N>,
        element: usize,
        origin: &Origin<D, N>,
    ) -> Vec<Edit<D>> {
        let own = self.of(element);
        if own.len() < elements::least::<D>() {
            let add = |shape| newcomer(mesh, &Place { element, shape }, origin);
            return elements::before::<N>().into_iter().map(add).collect();
        }
        own.skip(elements::most::<D>()).map(|particle| Edit::Drop { particle }).collect()
    }

    fn edits<const N: usize>(
        &self,
        mesh: &Mesh<D, N>,
        element: usize,
        density: Density,
        origin: &Origin<D, N>,
    ) -> Vec<Edit<D>> {
        let mut count = [0usize; 8];
        let own = self.of(element);
        own.clone().for_each(|p| count[sub_cell(&mesh.shape_functions(element, self.position[p]))] += 1);
        let count = &count[..1 << D];
        let mut edits = Vec::new();
        for cell in 0..count.len() {
            if count[cell] == 0 && own.len() < density.nominal {
                edits.push(newcomer(mesh, &Place { element, shape: center(cell) }, origin));
            }
            if count[cell] > density.most {
                let members =
                    own.clone().filter(|&p| sub_cell(&mesh.shape_functions(element, self.position[p])) == cell);
                self.merge(members.collect(), density.most, &mut edits);
            }
        }
        edits
    }

    /// Merges the closest pairs of one fluid until `most` are left, each particle at most once.
    fn merge(&self, mut members: Vec<usize>, most: usize, edits: &mut Vec<Edit<D>>) {
        let mut left = members.len();
        while left > most {
            let pairs = members.iter().enumerate().flat_map(|(i, &a)| members[i + 1..].iter().map(move |&b| (a, b)));
            let alike = pairs.filter(|&(a, b)| self.fluid[a] == self.fluid[b]);
            let distance = |&(a, b): &(usize, usize)| (self.position[a] - self.position[b]).norm_squared();
            let Some((keep, drop)) = alike.min_by(|a, b| distance(a).total_cmp(&distance(b))) else { return };
            members.retain(|&p| p != keep && p != drop);
            edits.push(Edit::Merge { keep, drop });
            left -= 1;
        }
    }
}

/// A new particle, with what it brings from the foot of its streamline.
fn newcomer<const D: usize, const N: usize>(mesh: &Mesh<D, N>, place: &Place<N>, origin: &Origin<D, N>) -> Edit<D> {
    let foot = origin.lines.trace(*place, origin.dt, -1.0);
    let inflow = match foot.end {
        End::Boundary(k) => (origin.inflow)(foot.place.element, k, foot.place.position(mesh), foot.rest),
        _ => None,
    };
    let (position, element) = (place.position(mesh), place.element as u32);
    let (own, depth) = (origin.fluid)(&foot.place);
    match inflow {
        Some((velocity, fluid)) => {
            let depth = if fluid == own { depth } else { 0.0 };
            Edit::Add { position, velocity, fluid, depth, element, inflow: true }
        }
        None => {
            let velocity = at(&foot.place.shape, &mesh.elements()[foot.place.element], origin.velocity);
            Edit::Add { position, velocity, fluid: own, depth, element, inflow: false }
        }
    }
}

/// The sub-cell of a point: 0..2^D.
#[inline(always)]
fn sub_cell<const N: usize>(shape: &[f64; N]) -> usize {
    for (k, &n) in shape.iter().enumerate() {
        if n >= 0.5 {
            return k;
        }
    }
    if N == 3 {
        return N;
    }
    N + usize::from(shape[0] + shape[N - 1] >= 0.5) + 2 * usize::from(shape[0] + shape[1] >= 0.5)
}

/// Shape functions at the centre of a sub-cell.
fn center<const N: usize>(cell: usize) -> [f64; N] {
    let corners: [[usize; 2]; N] = std::array::from_fn(|i| match (cell.checked_sub(N), N) {
        (None, _) => [cell, i],
        (Some(_), 3) => [i, (i + 1) % N],
        (Some(middle), _) => MIDDLE[middle][i],
    });
    let mut shape = [0.0; N];
    corners.iter().flatten().for_each(|&k| shape[k] += 0.5 / N as f64);
    shape
}

/// Corners of the four tetrahedra in the middle of one, as edges: all share the diagonal between the midpoints of
/// 02 and 13.
const MIDDLE: [[[usize; 2]; 4]; 4] = [
    [[0, 2], [1, 3], [1, 2], [2, 3]],
    [[0, 2], [1, 3], [2, 3], [0, 3]],
    [[0, 2], [1, 3], [0, 1], [1, 2]],
    [[0, 2], [1, 3], [0, 3], [0, 1]],
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pfem2::boundary::BoundaryKind;
    use crate::pfem2::convect::Flow;

    #[test]
    fn sub_cells_have_equal_volumes_and_hold_their_centres() {
        fn check<const N: usize>(cells: usize) {
            assert!((0..cells).all(|cell| sub_cell(&center::<N>(cell)) == cell));
            let points = crate::pfem2::particles::lattice::<N>(48);
            let mut count = vec![0.0; cells];
            points.iter().for_each(|n| count[sub_cell(n)] += cells as f64 / points.len() as f64);
            assert!(count.iter().all(|share| (share - 1.0).abs() < 0.07), "{count:?}");
        }
        check::<3>(4);
        check::<4>(8);
    }

    fn uniform(mesh: &Mesh<2, 3>) -> Vec<Vector<2>> {
        vec![Vector([1.0, 0.0]); mesh.nodes().len()]
    }

    #[test]
    fn a_channel_stays_full_of_what_flows_in() {
        // Fluid 1 comes in from t = 0.1 on with a velocity that tells the time.
        let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector([2.0, 1.0]), [16, 8]).unwrap();
        let velocity = uniform(&mesh);
        let boundary = vec![BoundaryKind::Outlet; mesh.boundary().len()];
        let flow = Flow { velocity: &velocity, boundary: &boundary, projectiles: None };
        let lines = Streamlines::new(&mesh, &flow);
        let mut particles = Particles::seed(&mesh, 5, |_| Some(0), |_| Vector::ZERO);
        let dt = 0.25;
        for step in 0..4 {
            particles.convect(&mesh, &flow, dt);
            let inflow = |_: usize, _: usize, x: Vector<2>, after: f64| {
                (x[0] < 1e-9).then(|| (Vector([dt * step as f64 + after, 0.0]), u8::from(step > 0)))
            };
            let origin = Origin { lines: &lines, dt, velocity: &velocity, fluid: &|_| (0, 0.0), inflow: &inflow };
            let done = particles.reseed(&mesh, Reseeding::SubCells, Density::new::<2>(15), &origin);
            assert!(done.inflow > 0 && done.empty > 0, "{done:?}");
        }
        assert!((0..mesh.elements().len()).all(|e| particles.of(e).len() >= 4));
        for p in 0..particles.len() {
            // It came in at t = 1 − x.
            let (x, v) = (particles.position[p][0], particles.velocity[p][0]);
            if x < 0.7 {
                assert!((v - (1.0 - x)).abs() < 1e-12, "{x} {v}");
                assert_eq!(particles.fluid[p], u8::from(1.0 - x > 0.25));
            }
        }
    }

    #[test]
    fn crowds_are_thinned_and_keep_their_centre_and_fluids() {
        let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector([1.0, 1.0]), [1, 1]).unwrap();
        let velocity = uniform(&mesh);
        let boundary = vec![BoundaryKind::Wall; mesh.boundary().len()];
        let lines = Streamlines::new(&mesh, &Flow { velocity: &velocity, boundary: &boundary, projectiles: None });
        let mut particles = Particles::seed(&mesh, 12, |x| Some(u8::from(x[1] > 0.37)), |x| x);
        let origin =
            Origin { lines: &lines, dt: 0.0, velocity: &velocity, fluid: &|_| (0, 0.0), inflow: &|_, _, _, _| None };
        let density = Density { nominal: 15, most: 14 };
        let before = particles.len();
        let done = particles.reseed(&mesh, Reseeding::SubCells, density, &origin);
        assert!(done.merged > 0 && particles.len() == before - done.merged);
        for (x, (v, &fluid)) in particles.position.iter().zip(particles.velocity.iter().zip(&particles.fluid)) {
            assert!((*x - *v).norm() < 1e-15 && fluid == u8::from(x[1] > 0.37));
        }
    }
}
