//! Streamlines of a frozen P1 velocity, integrated element by element.
//!
//! In an element the velocity is affine, so that the shape functions at a particle obey a linear equation with
//! constant coefficients (after Nadukandi et al.; theory 3.2 iii),
//!
//! ```text
//! dN_k/dt = g_k·v = c_k + Σ_{j<D} A_kj N_j,   c_k = g_k·v_D,   A_kj = g_k·(v_j − v_D)
//! N(t) = N + t ṙ + t²/2 A ṙ + t³/6 A² ṙ + t⁴/24 A³ ṙ,   ṙ = c + A N,   |∇v| t ≤ 1/4
//! ```
//!
//! The terms are g_k·(∇v)^m v: they and their reach don't depend on the order of the nodes.
//!
//! The first N_k that falls to zero names the facet through which the particle goes on. There is no search, and walls
//! are exact: where the velocity vanishes on a facet, dN_k/dt is proportional to N_k, which never reaches zero. On
//! facets that the velocity does cross, as those of a curved wall, the rate is projected onto the facet:
//! dN_j/dt ← dN_j/dt − (g_j·g_k/|g_k|²) dN_k/dt.

use super::crossing::{TERMS, leaves, value};
use crate::math::Vector;
use crate::mesh::Mesh;

/// Largest |∇v| t of one Taylor step: the first term left out is (1/4)⁴/120 = 3e-5 of the way.
const REACH: f64 = 0.25;

/// Most facets crossed in one step; a particle that needs more stays where it is and is counted.
const CROSSINGS: usize = 2000;

/// Rates this small, as a fraction of the largest, are rounding.
const ROUNDING: f64 = 1e-12;

/// A place in the mesh: an element and its shape functions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place<const N: usize> {
    /// The element.
    pub element: usize,
    /// Shape functions; none is negative, and their sum is one.
    pub shape: [f64; N],
}

impl<const N: usize> Place<N> {
    /// The place of a point that lies in `element`, up to rounding.
    #[inline(always)]
    pub fn of<const D: usize>(mesh: &Mesh<D, N>, element: usize, x: Vector<D>) -> Self {
        let inside = mesh.shape_functions(element, x).map(|n| n.max(0.0));
        // Without the sum, a point a hair outside would move away by |x|/h times its distance every time.
        let sum: f64 = inside.iter().sum();
        Self { element, shape: inside.map(|n| n / sum) }
    }

    /// Its position [m].
    #[inline(always)]
    pub fn position<const D: usize>(&self, mesh: &Mesh<D, N>) -> Vector<D> {
        crate::pfem2::particles::interpolate(&self.shape, &mesh.corners(self.element))
    }
}

/// How a walk ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// The time was over.
    Inside,
    /// It reached a boundary facet that lets it out, opposite this local node.
    Boundary(usize),
    /// It crossed too many facets.
    Stuck,
}

/// A walk: where it ended, how, and how much of its time was left [s].
#[derive(Debug, Clone, Copy)]
pub struct Walk<const N: usize> {
    /// Where.
    pub place: Place<N>,
    /// How.
    pub end: End,
    /// Time left [s].
    pub rest: f64,
}

/// Coefficients c and A of an element [1/s], and how long its Taylor polynomials are good [s].
#[derive(Debug, Clone, Copy)]
pub(super) struct Rate<const D: usize> {
    constant: Vector<D>,
    linear: [Vector<D>; D],
    reach: f64,
}

impl<const D: usize> Rate<D> {
    pub fn new<const N: usize>(gradient: &[Vector<D>; N], velocity: [Vector<D>; N]) -> Self {
        let last = velocity[D];
        let row = |i: usize| gradient.iter().zip(&velocity).map(|(&g, v)| g * v[i]).sum::<Vector<D>>();
        let slope = (0..D).map(|i| row(i).norm_squared()).sum::<f64>().sqrt();
        Self {
            constant: Vector::from_fn(|k| gradient[k].dot(last)),
            linear: std::array::from_fn(|k| Vector::from_fn(|j| gradient[k].dot(velocity[j] - last))),
            reach: REACH / slope,
        }
    }

    #[inline(always)]
    fn times(&self, n: &Vector<D>) -> Vector<D> {
        Vector::from_fn(|k| self.linear[k].dot(*n))
    }
}

/// The motion of a particle in one element as Taylor polynomials of its shape functions.
#[derive(Debug, Clone, Copy)]
pub(super) struct Taylor<const N: usize> {
    pub terms: [[f64; TERMS]; N],
    /// The longest time for which it is good [s].
    pub reach: f64,
}

impl<const N: usize> Taylor<N> {
    /// The fastest change of a shape function [1/s].
    #[cold]
    fn fastest(&self) -> f64 {
        self.terms.iter().map(|a| a[1].abs()).fold(0.0, f64::max)
    }
}

/// What moves a particle: the streamlines, or its own flight.
pub(super) trait Motion<const D: usize, const N: usize> {
    /// Its motion from a place on; `walls` are the local nodes opposite to the facets that it glides along.
    fn taylor(&mut self, mesh: &Mesh<D, N>, place: &Place<N>, walls: &Walls<D, N>) -> Taylor<N>;

    /// Takes note that time goes by [s].
    fn elapse(&mut self, _time: f64) {}
}

/// Facets of one element along which a particle glides.
#[derive(Debug, Clone, Copy)]
pub(super) struct Walls<const D: usize, const N: usize> {
    on: [bool; N],
    any: bool,
}

impl<const D: usize, const N: usize> Walls<D, N> {
    const NONE: Self = Self { on: [false; N], any: false };

    fn add(&mut self, k: usize) {
        self.on[k] = true;
        self.any = true;
    }

    /// Takes the part of a rate that would leave through one of the facets; where there are several, all of it.
    #[inline(always)]
    pub fn project(&self, gradient: &[Vector<D>; N], rate: Vector<D>) -> Vector<D> {
        if self.any { self.glide(gradient, rate) } else { rate }
    }

    /// Rounding doesn't take the particle off the facets either.
    #[inline(always)]
    fn hold(&self, taylor: &mut Taylor<N>) {
        if self.any {
            (0..N).filter(|&k| self.on[k]).for_each(|k| taylor.terms[k] = [0.0; TERMS]);
        }
    }

    #[cold]
    fn glide(&self, gradient: &[Vector<D>; N], rate: Vector<D>) -> Vector<D> {
        let mut on = (0..N).filter(|&k| self.on[k]);
        let (Some(k), None) = (on.next(), on.next()) else { return Vector::ZERO };
        let normal = complete::<D, N>(rate)[k] / gradient[k].norm_squared();
        Vector::from_fn(|j| if j == k { 0.0 } else { rate[j] - gradient[j].dot(gradient[k]) * normal })
    }
}

/// The rate of the last shape function completes those of the others to zero.
#[inline(always)]
pub(super) fn complete<const D: usize, const N: usize>(rate: Vector<D>) -> [f64; N] {
    let sum: f64 = rate.0.iter().sum();
    std::array::from_fn(|k| if k < D { rate[k] } else { -sum })
}

/// A particle that follows the streamlines, forwards (`sign` 1) or backwards (−1).
pub(super) struct Stream<'a, const D: usize> {
    pub rates: &'a [Rate<D>],
    pub sign: f64,
}

impl<const D: usize, const N: usize> Motion<D, N> for Stream<'_, D> {
    #[inline(always)]
    fn taylor(&mut self, mesh: &Mesh<D, N>, place: &Place<N>, walls: &Walls<D, N>) -> Taylor<N> {
        let rate = &self.rates[place.element];
        let gradient = &mesh.simplex(place.element).gradient;
        let project = |r| walls.project(gradient, r);
        let known = Vector::from_fn(|k| place.shape[k]);
        let first = project(rate.constant + rate.times(&known)) * self.sign;
        let second = project(rate.times(&first)) * (self.sign / 2.0);
        let third = project(rate.times(&second)) * (self.sign / 3.0);
        let fourth = project(rate.times(&third)) * (self.sign / 4.0);
        let [first, second, third, fourth] = [first, second, third, fourth].map(complete::<D, N>);
        let terms = std::array::from_fn(|k| [place.shape[k], first[k], second[k], third[k], fourth[k]]);
        Taylor { terms, reach: rate.reach }
    }
}

/// Walks for `time` [s] from a place on. `holds` tells if a boundary facet of an element holds particles back.
#[inline(always)]
pub(super) fn walk<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    motion: &mut impl Motion<D, N>,
    from: Place<N>,
    time: f64,
    holds: impl Fn(usize, usize) -> bool,
) -> Walk<N> {
    let (mut place, mut rest) = (from, time);
    let mut walls = Walls::NONE;
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
            None => walls = Walls::NONE,
            Some(k) => match mesh.neighbour(place.element, k) {
                Some(behind) => {
                    place = cross(mesh, &place, behind);
                    walls = Walls::NONE;
                }
                None if holds(place.element, k) => walls.add(k),
                None => return Walk { place, end: End::Boundary(k), rest },
            },
        }
    }
    Walk { place, end: End::Stuck, rest }
}

/// How long the particle stays in the element, at most until `end`, its shape functions then, and the local node
/// opposite to its exit.
///
/// Who is outside at `end` came out earlier; at that time another shape function may be negative that has become
/// positive again, so the search goes on until nobody is outside.
#[inline(always)]
fn stay<const N: usize>(taylor: &Taylor<N>, end: f64) -> (f64, [f64; N], Option<usize>) {
    let (mut time, mut exit) = (end, None);
    loop {
        let mut shape: [f64; N] = std::array::from_fn(|k| value(&taylor.terms[k], time));
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
#[inline(always)]
fn exit_before<const N: usize>(taylor: &Taylor<N>, shape: &[f64; N], time: f64) -> Option<(f64, usize)> {
    let mut first = None;
    for k in 0..N {
        if shape[k] < 0.0 {
            let a = &taylor.terms[k];
            let rounding = shape[k] > -ROUNDING && (a[0] > 0.0 || a[1].abs() <= ROUNDING * taylor.fastest());
            let exit = if rounding { f64::INFINITY } else { leaves(a, time) };
            if exit < first.map_or(f64::INFINITY, |(earliest, _)| earliest) {
                first = Some((exit, k));
            }
        }
    }
    first
}

/// The same point seen from the element behind one of the facets that it lies on.
#[inline(always)]
fn cross<const D: usize, const N: usize>(mesh: &Mesh<D, N>, place: &Place<N>, behind: usize) -> Place<N> {
    let before = mesh.elements()[place.element];
    let mut shape = mesh.elements()[behind].map(|node| {
        let mut value = 0.0;
        for i in 0..N {
            value = if before[i] == node { place.shape[i] } else { value };
        }
        value
    });
    let sum: f64 = shape.iter().sum();
    shape.iter_mut().for_each(|n| *n /= sum);
    Place { element: behind, shape }
}
