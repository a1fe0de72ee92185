//! Eight streamlines at once: the same walk as `streamline`, element by element, in vector registers (theory F.4).
//!
//! Of the shape functions of an element the first D are followed, λ, and the last goes with them:
//!
//! ```text
//! dλ_k/dt = Σ_j A_kj λ_j + b_k,   A_kj = B_kj − B_kD,   b_k = B_kD,   N_D = 1 − Σ λ_k
//! ```
//!
//! Every lane holds a particle and its element, and takes the next one when it has arrived. What is out of the
//! ordinary (walls, exits that the rates don't foresee, projectiles) goes on alone, from where it entered its element.
//! Lanes know nothing of each other, so that no result depends on who shares the registers.

use super::crossing::TERMS;
use super::streamline::{CROSSINGS, End, MISSED, MeshPoint, Rate, Walk, cross};
use crate::math::Vector;
use crate::math::simd::{Lanes, Row, Task, WIDTH, widest};
use crate::mesh::Mesh;
use crate::parallel;

/// Elements per parallel task.
const ELEMENTS: usize = 256;

/// Shape functions this little below zero are rounding.
const ROUNDING: f64 = 1e-14;

/// Exit of a lane whose particle ends its part of the way inside the element.
const INSIDE: f64 = -1.0;

/// Exit of a lane whose particle has to go on alone.
const ALONE: f64 = -2.0;

/// Owner of a lane that has nothing to do.
const NOBODY: usize = usize::MAX;

/// A and b by columns [1/s], and the reach of the Taylor polynomials [s], of all elements.
#[derive(Clone)]
pub struct Rates {
    rows: Vec<Row>,
}

/// Rows of an element.
const fn rows(dimension: usize) -> usize {
    (dimension * dimension + dimension + 1).div_ceil(WIDTH)
}

impl Rates {
    /// The motion by a nodal velocity [m/s]. Where it doesn't carry the particles of an element, they go on alone.
    pub fn new<const D: usize, const N: usize>(
        mesh: &Mesh<D, N>,
        velocity: &[Vector<D>],
        carries: impl Fn(usize) -> bool + Sync,
    ) -> Self {
        let mut rows = vec![Row::default(); rows(D) * mesh.elements().len()];
        let pack = |e: usize, rows: &mut [Row]| {
            let Rate { columns, reach } = Rate::of(mesh, velocity, e);
            let mut put = |i: usize, value: f64| rows[i / WIDTH].0[i % WIDTH] = value;
            for k in 0..D {
                (0..D).for_each(|j| put(j * D + k, columns[j][k] - columns[D][k]));
                put(D * D + k, columns[D][k]);
            }
            put(D * D + D, if carries(e) { reach } else { 0.0 });
        };
        let each = self::rows(D);
        parallel::for_each_chunk(&mut rows[..], ELEMENTS * each, |start, rows| {
            (start / each..).zip(rows.chunks_mut(each)).for_each(|(e, rows)| pack(e, rows));
        });
        Self { rows }
    }

    /// The numbers of eight elements, one after the other, each with a lane for every element.
    #[inline(always)]
    fn of<L: Lanes, const D: usize>(&self, elements: &[usize; WIDTH]) -> [[L; WIDTH]; 2] {
        let mut numbers = [[L::splat(0.0); WIDTH]; 2];
        for (r, numbers) in numbers.iter_mut().enumerate().take(rows(D)) {
            for lane in 0..WIDTH {
                numbers[lane] = L::load(&self.rows[elements[lane] * rows(D) + r].0);
            }
            *numbers = L::transpose(*numbers);
        }
        numbers
    }
}

/// Points that travel along the streamlines.
pub(super) trait Travellers<const N: usize> {
    /// The next one, by number, and where it starts.
    fn next(&mut self) -> Option<(usize, MeshPoint<N>)>;

    /// The rest of its way [s], where lanes can't follow it.
    fn alone(&self, who: usize, from: MeshPoint<N>, rest: f64) -> Walk<N>;

    /// The particle has arrived.
    fn arrive(&mut self, who: usize, walk: Walk<N>);
}

/// Takes all of them along for `time` [s], forwards (`sign` 1) or backwards (−1).
pub(super) fn travel<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    rates: &Rates,
    way: [f64; 2],
    travellers: &mut impl Travellers<N>,
) {
    let [time, sign] = way;
    widest(Journey { mesh, rates, time, sign, travellers });
}

struct Journey<'a, T, const D: usize, const N: usize> {
    mesh: &'a Mesh<D, N>,
    rates: &'a Rates,
    time: f64,
    sign: f64,
    travellers: &'a mut T,
}

/// State of the lanes: the points at which their particles entered their elements.
struct Pack<const N: usize> {
    shape: [Row; N],
    /// Time left [s].
    rest: Row,
    element: [usize; WIDTH],
    owner: [usize; WIDTH],
    visits: [usize; WIDTH],
}

/// Result of the visit of one element in each lane.
struct ElementVisit<const N: usize> {
    /// Shape functions at the end of the visit.
    shape: [Row; N],
    /// Time that it took [s].
    time: Row,
    /// Local node opposite to the exit, [`INSIDE`] or [`ALONE`].
    exit: Row,
}

impl<T: Travellers<N>, const D: usize, const N: usize> Task for Journey<'_, T, D, N> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(mut self) {
        let mut pack = Pack {
            shape: [Row::default(); N],
            rest: Row::default(),
            element: [0; WIDTH],
            owner: [NOBODY; WIDTH],
            visits: [0; WIDTH],
        };
        (0..WIDTH).for_each(|lane| self.board(&mut pack, lane));
        while pack.owner != [NOBODY; WIDTH] {
            let visit = visit::<L, D, N>(self.rates, &pack, self.sign);
            for lane in 0..WIDTH {
                if pack.owner[lane] != NOBODY {
                    self.go_on(&mut pack, &visit, lane);
                }
            }
        }
    }
}

impl<T: Travellers<N>, const D: usize, const N: usize> Journey<'_, T, D, N> {
    /// A lane takes the next traveller.
    #[inline(always)]
    fn board(&mut self, pack: &mut Pack<N>, lane: usize) {
        match self.travellers.next() {
            Some((who, place)) => {
                (pack.owner[lane], pack.visits[lane]) = (who, 0);
                pack.hold(lane, &place, self.time);
            }
            None => pack.owner[lane] = NOBODY,
        }
    }

    /// Takes a particle from one element to the next.
    #[inline(always)]
    fn go_on(&mut self, pack: &mut Pack<N>, visit: &ElementVisit<N>, lane: usize) {
        let element = pack.element[lane];
        let (rest, exit) = (pack.rest.0[lane] - visit.time.0[lane], visit.exit.0[lane]);
        let mut place = MeshPoint { element, shape: visit.shape.map(|row| row.0[lane].max(0.0)) };
        if exit != INSIDE {
            let behind = if exit == ALONE { None } else { self.mesh.neighbour(element, exit as usize) };
            let Some(behind) = behind else { return self.leave(pack, lane) };
            place.shape[exit as usize] = 0.0;
            place = cross(self.mesh, &place, behind);
        }
        pack.visits[lane] += 1;
        let end = if pack.visits[lane] < CROSSINGS { End::Inside } else { End::Stuck };
        if rest > 0.0 && end == End::Inside {
            pack.hold(lane, &place, rest);
        } else {
            self.travellers.arrive(pack.owner[lane], Walk { place, end, rest });
            self.board(pack, lane);
        }
    }

    /// The particle of a lane goes on alone.
    #[cold]
    fn leave(&mut self, pack: &mut Pack<N>, lane: usize) {
        let place = MeshPoint { element: pack.element[lane], shape: pack.shape.map(|row| row.0[lane]) };
        let walk = self.travellers.alone(pack.owner[lane], place, pack.rest.0[lane]);
        self.travellers.arrive(pack.owner[lane], walk);
        self.board(pack, lane);
    }
}

impl<const N: usize> Pack<N> {
    #[inline(always)]
    fn hold(&mut self, lane: usize, place: &MeshPoint<N>, rest: f64) {
        self.element[lane] = place.element;
        self.rest.0[lane] = rest;
        for k in 0..N {
            self.shape[k].0[lane] = place.shape[k];
        }
    }
}

/// Follows the particles of all lanes to the end of their time, the reach of their polynomials or their exits.
#[inline(always)]
fn visit<L: Lanes, const D: usize, const N: usize>(rates: &Rates, pack: &Pack<N>, sign: f64) -> ElementVisit<N> {
    let numbers = rates.of::<L, D>(&pack.element);
    let terms = taylor::<L, D, N>(&numbers, &pack.shape, sign);
    let reach = numbers[(D * D + D) / WIDTH][(D * D + D) % WIDTH];
    let end = L::load(&pack.rest.0).min(reach);
    let zero = L::splat(0.0);
    let (mut first, mut exit, mut polynomial) = (end, L::splat(INSIDE), [zero; TERMS]);
    for k in 0..N {
        let own = [terms[0][k], terms[1][k], terms[2][k], terms[3][k], terms[4][k]];
        let straight = zero.sub(own[0]).div(own[1]);
        let ahead = newton(&own, straight.if_at_most(zero, L::splat(f64::INFINITY), straight));
        let ahead = ahead.if_at_most(zero, L::splat(f64::INFINITY), ahead);
        exit = ahead.if_at_most(first, L::splat(k as f64), exit);
        for m in 0..TERMS {
            polynomial[m] = ahead.if_at_most(first, own[m], polynomial[m]);
        }
        first = ahead.if_at_most(first, ahead, first);
    }
    let root = newton(&polynomial, newton(&polynomial, first));
    let time = exit.if_at_most(L::splat(INSIDE), end, root);
    let mut found = ElementVisit { shape: [Row::default(); N], time: Row::default(), exit: Row::default() };
    let mut lowest = zero;
    for k in 0..N {
        let own = value(&[terms[0][k], terms[1][k], terms[2][k], terms[3][k], terms[4][k]], time);
        lowest = lowest.min(own);
        own.store(&mut found.shape[k].0);
    }
    time.store(&mut found.time.0);
    let alone = L::splat(ALONE);
    let missed = value(&polynomial, time);
    let missed = missed.max(zero.sub(missed));
    exit = time.if_at_most(end, exit, alone);
    exit = time.if_at_most(zero, alone, exit);
    exit = lowest.if_at_most(L::splat(-ROUNDING), alone, exit);
    exit = missed.if_at_most(L::splat(MISSED), exit, alone);
    exit.store(&mut found.exit.0);
    found
}

/// The Taylor polynomials of all shape functions, by power of the time.
#[inline(always)]
fn taylor<L: Lanes, const D: usize, const N: usize>(
    numbers: &[[L; WIDTH]; 2],
    shape: &[Row; N],
    sign: f64,
) -> [[L; N]; TERMS] {
    let mut terms = [[L::splat(0.0); N]; TERMS];
    for k in 0..N {
        terms[0][k] = L::load(&shape[k].0);
    }
    for m in 1..TERMS {
        // Becker (35): theory (F.13).
        let scale = L::splat(sign / m as f64);
        let mut last = L::splat(0.0);
        for k in 0..D {
            let b = D * D + k;
            let mut rate = if m == 1 { numbers[b / WIDTH][b % WIDTH] } else { L::splat(0.0) };
            for j in 0..D {
                let a = j * D + k;
                rate = numbers[a / WIDTH][a % WIDTH].mul_add(terms[m - 1][j], rate);
            }
            terms[m][k] = rate.mul(scale);
            last = last.sub(terms[m][k]);
        }
        terms[m][D] = last;
    }
    terms
}

/// Σ a_m t^m.
#[inline(always)]
fn value<L: Lanes>(a: &[L; TERMS], t: L) -> L {
    let square = t.mul(t);
    let [low, high] = [a[1].mul_add(t, a[0]), a[3].mul_add(t, a[2])];
    square.mul_add(a[4].mul_add(square, high), low)
}

/// One step of Newton's method.
#[inline(always)]
fn newton<L: Lanes>(a: &[L; TERMS], t: L) -> L {
    let square = t.mul(t);
    let low = a[2].add(a[2]).mul_add(t, a[1]);
    let high = a[4].mul(L::splat(4.0)).mul_add(t, a[3].mul(L::splat(3.0)));
    t.sub(value(a, t).div(square.mul_add(high, low)))
}
