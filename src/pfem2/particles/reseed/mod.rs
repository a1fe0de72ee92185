//! Reseeding: particles are added where there are too few and merged where there are too many (theory G.12).
//!
//! ```text
//! sub-cells of a simplex, 2^D of one size
//!   corner k   N_k ≥ ½
//!   middle     all N_k ≤ ½; in a tetrahedron four of them, by the smallest N_k
//! none in a sub-cell, and the element below its nominal number:  a new particle at the centre of the sub-cell
//! more than `most` in a sub-cell:                     the closest two of one fluid become one at their mean
//! ```
//!
//! None of this asks for the order of the nodes or the particles, up to rounding: particles, mesh and flow that mirror
//! each other go on doing so.
//!
//! A new particle is traced back along its streamline for the whole step: it takes what the mesh had at the foot, or
//! what flowed in at the time when it crossed the inlet, so that it has the history of its place. The paper counts by
//! elements instead (see `elements`).

mod elements;
#[cfg(test)]
mod tests;

pub use elements::refill;

use super::convect::{End, MeshPoint, Streamlines, Walk};
use super::interpolate_nodal;
use super::{GONE, Particles};
use crate::math::Vector;
use crate::mesh::Mesh;
use crate::parallel;
use crate::pfem2::phases::phase_list::{PhaseList, Reseeding};

/// Differences of shape functions, and relative ones of distances, that are rounding.
const ROUNDING: f64 = 1e-9;

/// Numbers of particles to be held in elements and sub-cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ParticleCounts {
    /// In an element; empty sub-cells of elements that have as many are left alone.
    pub nominal: usize,
    /// Most in a sub-cell.
    pub most: usize,
}

impl ParticleCounts {
    /// For elements seeded with `nominal` particles: a sub-cell may hold twice the mean number.
    pub fn new<const D: usize>(nominal: usize) -> Self {
        Self { nominal, most: (2 * nominal).div_ceil(1 << D).max(2) }
    }
}

/// The state at the start of the step, from which new particles take their values (theory F.10).
pub struct ParticleSource<'a, const D: usize, const N: usize> {
    /// The streamlines that the particles moved along.
    pub lines: &'a Streamlines<'a, D, N>,
    /// The step [s].
    pub dt: f64,
    /// Nodal velocity at its start [m/s].
    pub velocity: &'a [Vector<D>],
    /// Fluid at a place at its start, and the depth below the interface [m].
    pub fluid: &'a (dyn Fn(&MeshPoint<N>) -> (u8, f64) + Sync),
    /// The particle that flows in through the boundary facet of an element opposite to a local node, at a place on it
    /// and a time after the start of the step [s], negative before it; `None` where nothing is prescribed.
    pub inflow: &'a (dyn Fn(&MeshPoint<N>, usize, f64) -> Option<NewParticle<D>> + Sync),
    /// True for places in the fluid at the end of the step, false inside solids.
    pub is_fluid: &'a (dyn Fn(&MeshPoint<N>) -> bool + Sync),
}

/// Velocity, fluid and depth of a new particle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NewParticle<const D: usize> {
    /// Its velocity [m/s].
    pub velocity: Vector<D>,
    /// Its fluid.
    pub fluid: u8,
    /// Its depth below the surface of its fluid [m].
    pub depth: f64,
}

/// Counts of particles that were added or merged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Reseeded {
    /// New particles.
    pub added: usize,
    /// Of these, the ones that came in through an inlet.
    pub inflow: usize,
    /// Particles that were merged into another, or dropped where there were too many.
    pub merged: usize,
    /// Elements with fluid in their middle that had no particle.
    pub empty: usize,
}

/// A change of the columns.
enum Edit<const N: usize> {
    Add(MeshPoint<N>),
    Merge { keep: usize, drop: usize },
    Drop { particle: usize },
}

impl<const D: usize> Particles<D> {
    /// Fills what is empty and thins out what is crowded, before the projection, and sorts; `target` has the numbers of
    /// particles by which sub-cells are judged.
    pub fn reseed<const N: usize>(
        &mut self,
        mesh: &Mesh<D, N>,
        list: &PhaseList,
        target: ParticleCounts,
        origin: &ParticleSource<D, N>,
    ) -> Reseeded {
        self.group_by_element();
        let edits = |e: usize| {
            let own = self.by_element.of(e);
            match self.reseeding_of(list, own.iter().map(|&p| p as usize)) {
                Reseeding::SubCells => self.edits(mesh, e, own, target),
                Reseeding::Elements => edits_of_element::<D, N>(e, own),
                Reseeding::EmptyElements if own.is_empty() => edits_of_element::<D, N>(e, own),
                Reseeding::EmptyElements => Vec::new(),
            }
        };
        let edits = parallel::collect_all(mesh.elements().len(), 256, edits);
        let holds_fluid = |element| (origin.is_fluid)(&MeshPoint { element, shape: [1.0 / N as f64; N] });
        let all = 0..mesh.elements().len();
        let empty = all.filter(|&e| self.by_element.of(e).is_empty() && holds_fluid(e)).count();
        let places = edits.iter().filter_map(|edit| if let Edit::Add(place) = edit { Some(*place) } else { None });
        let places = places.filter(|place| (origin.is_fluid)(place));
        let added = self.fill(mesh, list, &places.collect::<Vec<_>>(), origin);
        let merged = edits.iter().filter(|edit| self.thin(edit)).count();
        self.sort();
        Reseeded { merged, empty, ..added }
    }

    /// Rule for an element with the particles `own`: that of the first of them, unless one asks to be left alone; for
    /// an element without particles that of the first phase.
    fn reseeding_of(&self, list: &PhaseList, own: impl Iterator<Item = usize>) -> Reseeding {
        let mut rules = own.map(|p| list.reseeding(usize::from(self.phase[p])));
        let Some(first) = rules.next() else { return list.reseeding(0) };
        if !list.has_solids() {
            return first;
        }
        if rules.any(|rule| rule == Reseeding::EmptyElements) { Reseeding::EmptyElements } else { first }
    }

    /// Puts new particles at places.
    fn fill<const N: usize>(
        &mut self,
        mesh: &Mesh<D, N>,
        list: &PhaseList,
        places: &[MeshPoint<N>],
        origin: &ParticleSource<D, N>,
    ) -> Reseeded {
        let mut done = Reseeded::default();
        for (place, (newcomer, inflow)) in places.iter().zip(origin.newcomers(mesh, places)) {
            let fills_empty = list.reseeding(usize::from(newcomer.fluid)) == Reseeding::EmptyElements;
            if fills_empty && !self.by_element.of(place.element).is_empty() {
                continue;
            }
            done.added += 1;
            self.push(place.position(mesh), newcomer.velocity, newcomer.fluid, place.element as u32);
            self.depth[self.position.len() - 1] = newcomer.depth;
            done.inflow += usize::from(inflow);
        }
        done
    }

    /// Makes one particle of two, or drops one; false where one is to be added.
    fn thin<const N: usize>(&mut self, edit: &Edit<N>) -> bool {
        match *edit {
            Edit::Add(_) => return false,
            Edit::Merge { keep, drop } => self.merge(keep, drop),
            Edit::Drop { particle } => self.element[particle] = GONE,
        }
        true
    }

    /// By sub-cells, where an element holds the particles `own`.
    fn edits<const N: usize>(
        &self,
        mesh: &Mesh<D, N>,
        element: usize,
        own: &[u32],
        target: ParticleCounts,
    ) -> Vec<Edit<N>> {
        let cells = |p: u32| sub_cells(&mesh.shape_functions(element, self.position[p as usize]));
        let mut count = [0usize; 8];
        for cells in own.iter().map(|&p| cells(p)) {
            (0..1 << D).for_each(|cell| count[cell] += usize::from(cells >> cell & 1));
        }
        let mut edits = Vec::new();
        for (cell, &count) in count[..1 << D].iter().enumerate() {
            let place = MeshPoint { element, shape: center(cell) };
            if count == 0 && own.len() < target.nominal {
                edits.push(Edit::Add(place));
            }
            if count > target.most {
                let members = own.iter().filter(|&&p| cells(p) >> cell & 1 == 1).map(|&p| p as usize);
                let members = members.filter(|&p| !merges(&edits, p)).collect();
                self.merge_closest(members, target.most, place.position(mesh), &mut edits);
            }
        }
        edits
    }

    /// Merges the closest pairs of one fluid until `most` are left, each particle at most once; of pairs that are
    /// equally close, the one whose middle is nearest to the centre of the sub-cell [m].
    fn merge_closest<const N: usize>(
        &self,
        mut members: Vec<usize>,
        most: usize,
        center: Vector<D>,
        edits: &mut Vec<Edit<N>>,
    ) {
        let distance = |&(a, b): &(usize, usize)| (self.position[a] - self.position[b]).norm_squared();
        let aside = |&(a, b): &(usize, usize)| ((self.position[a] + self.position[b]) * 0.5 - center).norm_squared();
        let mut left = members.len();
        while left > most {
            let pairs = members.iter().enumerate().flat_map(|(i, &a)| members[i + 1..].iter().map(move |&b| (a, b)));
            let alike: Vec<(usize, usize)> = pairs.filter(|&(a, b)| self.phase[a] == self.phase[b]).collect();
            let closest = alike.iter().map(distance).fold(f64::INFINITY, f64::min) * (1.0 + ROUNDING);
            let equal = alike.iter().filter(|&pair| distance(pair) <= closest);
            let Some(&(keep, drop)) = equal.min_by(|a, b| aside(a).total_cmp(&aside(b))) else { return };
            members.retain(|&p| p != keep && p != drop);
            edits.push(Edit::Merge { keep, drop });
            left -= 1;
        }
    }
}

/// By elements: a few particles where there are too few, none above the most.
fn edits_of_element<const D: usize, const N: usize>(element: usize, own: &[u32]) -> Vec<Edit<N>> {
    if own.len() < elements::least::<D>() {
        return elements::before::<N>().into_iter().map(|shape| Edit::Add(MeshPoint { element, shape })).collect();
    }
    own.iter().skip(elements::most::<D>()).map(|&p| Edit::Drop { particle: p as usize }).collect()
}

/// True if a particle is about to be merged.
fn merges<const N: usize>(edits: &[Edit<N>], particle: usize) -> bool {
    edits.iter().any(|edit| matches!(*edit, Edit::Merge { keep, drop } if keep == particle || drop == particle))
}

impl<const D: usize, const N: usize> ParticleSource<'_, D, N> {
    /// New particles at the end of the step, with the values at the feet of their streamlines; true for those that came
    /// in since its start.
    fn newcomers(&self, mesh: &Mesh<D, N>, places: &[MeshPoint<N>]) -> Vec<(NewParticle<D>, bool)> {
        let feet = self.lines.trace_all(places, self.dt, -1.0);
        let newcomer = |n: usize| {
            let (mut newcomer, inflow) = self.at_foot(mesh, &feet[n]);
            if let Some(before) = self.before(mesh, &places[n]).filter(|_| !inflow) {
                (newcomer.fluid, newcomer.depth) = (before.fluid, before.depth);
            }
            (newcomer, inflow)
        };
        parallel::collect(places.len(), 64, newcomer)
    }

    /// The particle that came in before the step and is now at a place of the same element: where steps are so short
    /// that no streamline reaches the inlet, an element there would for ever be filled with what it already holds.
    fn before(&self, mesh: &Mesh<D, N>, place: &MeshPoint<N>) -> Option<NewParticle<D>> {
        /// Times the time that it takes at the velocity of the place.
        const REACH: f64 = 2.0;
        let gradient = &mesh.simplex(place.element).gradient;
        let velocity = interpolate_nodal(&place.shape, &mesh.elements()[place.element], self.velocity);
        let outer =
            (0..N).filter(|&k| mesh.neighbour(place.element, k).is_none() && !self.lines.holds(place.element, k));
        let times = outer.map(|k| REACH * place.shape[k] / gradient[k].dot(velocity));
        let time = times.filter(|time| *time > self.dt).reduce(f64::min)?;
        let foot = self.lines.trace(*place, time, -1.0);
        match foot.end {
            End::Boundary(k) if foot.place.element == place.element => {
                (self.inflow)(&foot.place, k, foot.rest - (time - self.dt))
            }
            _ => None,
        }
    }

    /// The particle at a place some `time` [s] after the start of the step; true if it came in since.
    pub fn of(&self, mesh: &Mesh<D, N>, place: &MeshPoint<N>, time: f64) -> (NewParticle<D>, bool) {
        self.at_foot(mesh, &self.lines.trace(*place, time, -1.0))
    }

    fn at_foot(&self, mesh: &Mesh<D, N>, foot: &Walk<N>) -> (NewParticle<D>, bool) {
        let inflow = match foot.end {
            End::Boundary(k) => (self.inflow)(&foot.place, k, foot.rest),
            _ => None,
        };
        match inflow {
            Some(newcomer) => (newcomer, true),
            None => {
                let (fluid, depth) = (self.fluid)(&foot.place);
                let velocity =
                    interpolate_nodal(&foot.place.shape, &mesh.elements()[foot.place.element], self.velocity);
                (NewParticle { velocity, fluid, depth }, false)
            }
        }
    }
}

/// The sub-cells that a point belongs to, one bit each; more than one where rounding could decide.
#[inline(always)]
fn sub_cells<const N: usize>(shape: &[f64; N]) -> u8 {
    let (least, largest) = shape.iter().fold((1.0, 0.0), |(low, high): (f64, f64), &n| (low.min(n), high.max(n)));
    let mut cells = 0;
    for (k, &n) in shape.iter().enumerate() {
        cells |= u8::from(n >= 0.5 - ROUNDING) << k;
        if N == 4 {
            cells |= u8::from(largest <= 0.5 + ROUNDING && n <= least + ROUNDING) << (N + k);
        }
    }
    if N == 3 { cells | u8::from(largest <= 0.5 + ROUNDING) << N } else { cells }
}

/// Shape functions at the centroid of a sub-cell.
fn center<const N: usize>(cell: usize) -> [f64; N] {
    let own = match (cell.checked_sub(N), N) {
        (None, _) => 0.5 + 0.5 / N as f64,
        (Some(_), 3) => return [1.0 / N as f64; N],
        (Some(_), _) => 1.0 / 12.0,
    };
    std::array::from_fn(|k| if k == cell % N { own } else { (1.0 - own) / (N - 1) as f64 })
}
