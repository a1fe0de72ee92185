//! Streamlines of a frozen P1 velocity, integrated element by element.
//!
//! In an element the velocity is affine, so that the shape functions at a particle obey a linear equation with
//! constant coefficients (after Nadukandi et al.; theory (F.12), (F.13)),
//!
//! ```text
//! dN_k/dt = g_k·v = Σ_j B_kj N_j,   B_kj = g_k·v_j
//! N(t) = N + t B N + t²/2 B² N + t³/6 B³ N + t⁴/24 B⁴ N,   |∇v| t ≤ 1/4
//! ```
//!
//! The terms are g_k·(∇v)^m v: they and their reach don't depend on the order of the nodes.
//!
//! The first N_k that falls to zero names the facet through which the particle goes on; nearly always it is the one
//! that N + t B N names, and two steps of Newton's method find the time. There is no search in the mesh, and walls
//! are exact: where the velocity vanishes on a facet, dN_k/dt is proportional to N_k, which never reaches zero. On
//! facets that the velocity does cross, as those of a curved wall, the rate is projected onto the facet:
//! dN_j/dt ← dN_j/dt − (g_j·g_k/|g_k|²) dN_k/dt.

use super::crossing::{TERMS, leaves, newton, value};
use crate::math::Vector;
use crate::mesh::Mesh;

/// Largest |∇v| t of one Taylor step: the first term left out is (1/4)⁴/120 = 3e-5 of the way.
const REACH: f64 = 0.25;

/// Most facets crossed in one step; a particle that needs more stays where it is and is counted.
pub(super) const CROSSINGS: usize = 2000;

/// Rates this small, as a fraction of the largest, are rounding.
const ROUNDING: f64 = 1e-12;

/// A shape function this far from zero at the time of an exit has not been followed to its root.
pub(super) const MISSED: f64 = 1e-10;

/// A place in the mesh: an element and its shape functions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshPoint<const N: usize> {
    /// The element.
    pub element: usize,
    /// Shape functions; none is negative, and their sum is one.
    pub shape: [f64; N],
}

impl<const N: usize> MeshPoint<N> {
    /// The place of a point that lies in `element`, up to rounding.
    #[inline(always)]
    pub fn of<const D: usize>(mesh: &Mesh<D, N>, element: usize, x: Vector<D>) -> Self {
        let inside = mesh.shape_functions(element, x).map(|n| n.max(0.0));
        // Without the sum, a point a hair outside would move away by |x|/h times its distance every time.
        let sum: f64 = inside.iter().sum();
        Self { element, shape: inside.map(|n| n / sum) }
    }

    /// Position of the point [m].
    #[inline(always)]
    pub fn position<const D: usize>(&self, mesh: &Mesh<D, N>) -> Vector<D> {
        crate::pfem2::particles::interpolate(&self.shape, &mesh.corners(self.element))
    }
}

/// The end of a walk.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// The time was over.
    Inside,
    /// The particle reached a boundary facet that lets it out, opposite this local node.
    Boundary(usize),
    /// The particle crossed too many facets.
    Stuck,
}

/// A walk: its last point, the way it ended, and the time that was left [s].
#[derive(Debug, Clone, Copy)]
pub struct Walk<const N: usize> {
    /// Last point of the streamline.
    pub place: MeshPoint<N>,
    /// The way it ended.
    pub end: End,
    /// Time left [s].
    pub rest: f64,
}

/// The matrix B of an element by columns [1/s], and how long its Taylor polynomials are good [s].
#[derive(Debug, Clone, Copy)]
pub(super) struct Rate<const N: usize> {
    pub columns: [[f64; N]; N],
    pub reach: f64,
}

impl<const N: usize> Rate<N> {
    /// The flow in an element with these velocities of the nodes [m/s].
    pub fn of<const D: usize>(mesh: &Mesh<D, N>, velocity: &[Vector<D>], element: usize) -> Self {
        let gradient = &mesh.simplex(element).gradient;
        let velocity = mesh.elements()[element].map(|node| velocity[node as usize]);
        let row = |i: usize| gradient.iter().zip(&velocity).map(|(&g, v)| g * v[i]).sum::<Vector<D>>();
        let slope = (0..D).map(|i| row(i).norm_squared()).sum::<f64>().sqrt();
        Self { columns: velocity.map(|v| gradient.map(|g| g.dot(v))), reach: REACH / slope }
    }

    /// B n · scale.
    #[inline(always)]
    fn times(&self, n: &[f64; N], scale: f64) -> [f64; N] {
        let mut sum = [0.0; N];
        for (column, n) in self.columns.iter().zip(n) {
            (0..N).for_each(|k| sum[k] += column[k] * n);
        }
        sum.map(|sum| sum * scale)
    }
}

/// The motion of a particle in one element as Taylor polynomials of its shape functions.
#[derive(Debug, Clone, Copy)]
pub(super) struct Taylor<const N: usize> {
    /// Coefficients by power of the time, then by shape function.
    pub terms: [[f64; N]; TERMS],
    /// The longest time for which it is good [s].
    pub reach: f64,
}

impl<const N: usize> Taylor<N> {
    /// The polynomial of one shape function.
    #[inline(always)]
    fn of(&self, k: usize) -> [f64; TERMS] {
        self.terms.map(|term| term[k])
    }

    /// All shape functions at a time.
    #[inline(always)]
    fn at(&self, time: f64) -> [f64; N] {
        std::array::from_fn(|k| value(&self.of(k), time))
    }

    /// The fastest change of a shape function [1/s].
    #[cold]
    fn fastest(&self) -> f64 {
        self.terms[1].iter().map(|a| a.abs()).fold(0.0, f64::max)
    }
}

/// The motion of a particle: along streamlines, or on a ballistic path.
pub(super) trait Motion<const D: usize, const N: usize> {
    /// Taylor series of the motion from a place on; `walls` are the local nodes opposite to the facets that it glides
    /// along.
    fn taylor(&mut self, mesh: &Mesh<D, N>, place: &MeshPoint<N>, walls: &GlidingFacets<D, N>) -> Taylor<N>;

    /// Takes note that time goes by [s].
    fn elapse(&mut self, _time: f64) {}
}

/// Facets of one element along which a particle glides.
#[derive(Debug, Clone, Copy)]
pub(super) struct GlidingFacets<const D: usize, const N: usize> {
    on: [bool; N],
    any: bool,
}

impl<const D: usize, const N: usize> GlidingFacets<D, N> {
    const NONE: Self = Self { on: [false; N], any: false };

    fn add(&mut self, k: usize) {
        self.on[k] = true;
        self.any = true;
    }

    /// Takes the part of a rate that would leave through one of the facets; where there are several, all of it.
    #[inline(always)]
    pub fn project(&self, gradient: &[Vector<D>; N], rate: [f64; N]) -> [f64; N] {
        if self.any { self.glide(gradient, rate) } else { rate }
    }

    /// Rounding doesn't take the particle off the facets either.
    #[inline(always)]
    fn hold(&self, taylor: &mut Taylor<N>) {
        if self.any {
            for term in &mut taylor.terms {
                (0..N).filter(|&k| self.on[k]).for_each(|k| term[k] = 0.0);
            }
        }
    }

    #[cold]
    fn glide(&self, gradient: &[Vector<D>; N], rate: [f64; N]) -> [f64; N] {
        let mut on = (0..N).filter(|&k| self.on[k]);
        let (Some(k), None) = (on.next(), on.next()) else { return [0.0; N] };
        let normal = rate[k] / gradient[k].norm_squared();
        std::array::from_fn(|j| if j == k { 0.0 } else { rate[j] - gradient[j].dot(gradient[k]) * normal })
    }
}

/// A particle that follows the streamlines, forwards (`sign` 1) or backwards (−1).
pub(super) struct Stream<'a, const D: usize> {
    /// Velocity of the nodes [m/s].
    pub velocity: &'a [Vector<D>],
    pub sign: f64,
}

impl<const D: usize, const N: usize> Motion<D, N> for Stream<'_, D> {
    #[inline(always)]
    fn taylor(&mut self, mesh: &Mesh<D, N>, place: &MeshPoint<N>, walls: &GlidingFacets<D, N>) -> Taylor<N> {
        let rate = Rate::of(mesh, self.velocity, place.element);
        let gradient = &mesh.simplex(place.element).gradient;
        // Becker (35), exact within the element: theory (F.13), at walls (F.14).
        let mut terms = [place.shape; TERMS];
        for m in 1..TERMS {
            terms[m] = walls.project(gradient, rate.times(&terms[m - 1], self.sign / m as f64));
        }
        Taylor { terms, reach: rate.reach }
    }
}

/// Walks for `time` [s] from a place on. `holds` tells if a boundary facet of an element holds particles back.
#[inline(always)]
pub(super) fn walk<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    motion: &mut impl Motion<D, N>,
    from: MeshPoint<N>,
    time: f64,
    holds: impl Fn(usize, usize) -> bool,
) -> Walk<N> {
    let (mut place, mut rest) = (from, time);
    let mut walls = GlidingFacets::NONE;
    for _ in 0..CROSSINGS {
        let mut taylor = motion.taylor(mesh, &place, &walls);
        walls.hold(&mut taylor);
        let end = rest.min(taylor.reach);
        let (taken, shape, exit) = stay(&taylor, end);
        place.shape = shape;
        rest -= taken;
        motion.elapse(taken);
        match exit {
            None if rest <= 0.0 => return Walk { place, end: End::Inside, rest: 0.0 },
            None => walls = GlidingFacets::NONE,
            Some(k) => match mesh.neighbour(place.element, k) {
                Some(behind) => {
                    place = cross(mesh, &place, behind);
                    walls = GlidingFacets::NONE;
                }
                None if holds(place.element, k) => walls.add(k),
                None => return Walk { place, end: End::Boundary(k), rest },
            },
        }
    }
    Walk { place, end: End::Stuck, rest }
}

/// The time that the particle stays in the element, at most until `end`, its shape functions then, and the local node
/// opposite to its exit.
#[inline(always)]
fn stay<const N: usize>(taylor: &Taylor<N>, end: f64) -> (f64, [f64; N], Option<usize>) {
    if let Some((time, shape, k)) = foreseen(taylor, end) {
        return (time, shape, Some(k));
    }
    let shape = taylor.at(end);
    if shape.iter().all(|&n| n >= 0.0) { (end, shape, None) } else { searched(taylor, end) }
}

/// The exit that the rates at the start name, unless there is none before `end` or somebody else is outside by then.
#[inline(always)]
fn foreseen<const N: usize>(taylor: &Taylor<N>, end: f64) -> Option<(f64, [f64; N], usize)> {
    let (mut first, mut exit) = (end, None);
    for k in 0..N {
        let straight = -taylor.terms[0][k] / taylor.terms[1][k];
        if straight > 0.0 && straight < first {
            (first, exit) = (straight, Some(k));
        }
    }
    let k = exit?;
    let a = taylor.of(k);
    let time = newton(&a, newton(&a, first));
    if !(time > 0.0 && time <= end) {
        return None;
    }
    let mut shape = taylor.at(time);
    let missed = shape[k].abs();
    shape[k] = 0.0;
    (missed <= MISSED && shape.iter().all(|&n| n >= 0.0)).then_some((time, shape, k))
}

/// A particle outside at `end` came out earlier; at that time another shape function may be negative that has become
/// positive again, so the search goes on until the particle isn't outside.
#[cold]
fn searched<const N: usize>(taylor: &Taylor<N>, end: f64) -> (f64, [f64; N], Option<usize>) {
    let (mut time, mut exit) = (end, None);
    loop {
        let mut shape = taylor.at(time);
        if let Some(k) = exit {
            shape[k] = 0.0;
        }
        match exit_before(taylor, &shape, time) {
            Some((earlier, k)) => (time, exit) = (earlier, Some(k)),
            None => return (time, shape.map(|n| n.max(0.0)), exit),
        }
    }
}

/// The first exit of those who are outside at a time.
fn exit_before<const N: usize>(taylor: &Taylor<N>, shape: &[f64; N], time: f64) -> Option<(f64, usize)> {
    let mut first = None;
    for k in 0..N {
        if shape[k] < 0.0 {
            let a = taylor.of(k);
            let rounding = shape[k] > -ROUNDING && (a[0] > 0.0 || a[1].abs() <= ROUNDING * taylor.fastest());
            let exit = if rounding { f64::INFINITY } else { leaves(&a, time) };
            if exit < first.map_or(f64::INFINITY, |(earliest, _)| earliest) {
                first = Some((exit, k));
            }
        }
    }
    first
}

/// The point seen from the element behind one of the facets that it lies on.
#[inline(always)]
pub(super) fn cross<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    place: &MeshPoint<N>,
    behind: usize,
) -> MeshPoint<N> {
    let before = mesh.elements()[place.element];
    let mut shape = mesh.elements()[behind].map(|node| {
        let mut value = 0.0;
        for i in 0..N {
            value = if before[i] == node { place.shape[i] } else { value };
        }
        value
    });
    let whole = shape.iter().sum::<f64>().recip();
    shape.iter_mut().for_each(|n| *n *= whole);
    MeshPoint { element: behind, shape }
}
