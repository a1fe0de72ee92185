//! The point of a quadratic facet that is nearest to a place: ξ_c of theory (J.6), ξ_a of theory J.9.
//!
//! ```text
//! min ½ |x(ξ) − p|²,  ξ ∈ [−1, 1]ᴰ⁻¹:   g_k = r·x_k,  H_kl = x_k·x_l + r·x_kl,   r = x(ξ) − p,  x_k = ∂x/∂ξ_k
//! ```
//!
//! Newton's method in the coordinates that no bound holds, with x_k·x_l where H is not positive definite, from
//! the nearest points of a grid on the facet.

use super::quadratic::{bounds, line};
use crate::math::Vector;

/// Points of the grid along an axis.
const GRID: usize = 5;

/// A facet of a solid in a configuration: a line of 3 nodes in 2D, a patch of 9 in 3D.
#[derive(Debug, Clone)]
pub struct SurfaceFacet<const D: usize> {
    /// Global nodes, 3ᴰ⁻¹.
    pub nodes: Vec<u32>,
    /// Corners of a box around it [m].
    pub bounds: [Vector<D>; 2],
    /// Positions of the nodes [m]; in 2D the first three.
    x: [Vector<D>; 9],
    /// Points of the grid [m].
    grid: Vec<Vector<D>>,
    /// Longest diagonal of the cells between them [m]: no point of the facet is farther from the grid.
    cell: f64,
}

/// A point of a facet.
#[derive(Debug, Clone, Copy)]
pub struct Projection {
    /// Coordinates; in 2D the second is zero.
    pub local: [f64; 2],
    /// Square of the distance [m²].
    pub squared: f64,
}

/// Place and derivatives along the coordinates.
struct Jet<const D: usize> {
    x: Vector<D>,
    first: [Vector<D>; 2],
    /// ξξ, ηη, ξη.
    second: [Vector<D>; 3],
}

impl<const D: usize> SurfaceFacet<D> {
    /// A facet from its global nodes and the positions of all [m].
    pub fn new(nodes: Vec<u32>, positions: &[Vector<D>]) -> Self {
        let mut x = [Vector::ZERO; 9];
        x.iter_mut().zip(&nodes).for_each(|(x, &node)| *x = positions[node as usize]);
        let bounds = bounds(&x[..nodes.len()]);
        let mut facet = Self { nodes, bounds, x, grid: Vec::new(), cell: 0.0 };
        facet.grid = (0..GRID.pow(D as u32 - 1)).map(|n| facet.position(Self::grid_point(n))).collect();
        facet.cell = facet.longest_diagonal();
        facet
    }

    /// Length of the diagonal of its box [m].
    pub fn size(&self) -> f64 {
        (self.bounds[1] - self.bounds[0]).norm()
    }

    fn longest_diagonal(&self) -> f64 {
        let rows = if D == 3 { GRID } else { 0 };
        let cells = (0..self.grid.len()).filter(|n| n % GRID + 1 < GRID && n + rows + 1 < self.grid.len());
        let length = |a: usize, b: usize| (self.grid[a] - self.grid[b]).norm();
        cells.map(|n| length(n, n + rows + 1).max(length(n + 1, n + rows))).fold(0.0, f64::max)
    }

    fn grid_point(n: usize) -> [f64; 2] {
        let at = |index: usize| 2.0 * index as f64 / (GRID - 1) as f64 - 1.0;
        [at(n % GRID), if D == 3 { at(n / GRID) } else { 0.0 }]
    }

    /// Functions across the second coordinate, of which there is none in 2D.
    fn across(t: f64) -> [[f64; 3]; 3] {
        if D == 3 { line(t) } else { [[1.0, 0.0, 0.0], [0.0; 3], [0.0; 3]] }
    }

    /// The point at given coordinates [m].
    pub fn position(&self, [s, t]: [f64; 2]) -> Vector<D> {
        let ([along, ..], [across, ..]) = (line(s), Self::across(t));
        (0..3usize.pow(D as u32 - 2)).map(|b| self.row(b, &along) * across[b]).sum()
    }

    fn row(&self, b: usize, along: &[f64; 3]) -> Vector<D> {
        self.x[3 * b] * along[0] + self.x[3 * b + 1] * along[1] + self.x[3 * b + 2] * along[2]
    }

    fn jet(&self, [s, t]: [f64; 2]) -> Jet<D> {
        let (along, across) = (line(s), Self::across(t));
        let mut jet = Jet { x: Vector::ZERO, first: [Vector::ZERO; 2], second: [Vector::ZERO; 3] };
        for b in 0..3usize.pow(D as u32 - 2) {
            let [x, x_s, x_ss] = [0, 1, 2].map(|order| self.row(b, &along[order]));
            let [n, n_t, n_tt] = [0, 1, 2].map(|order: usize| across[order][b]);
            jet.x += x * n;
            jet.first[0] += x_s * n;
            jet.first[1] += x * n_t;
            jet.second[0] += x_ss * n;
            jet.second[1] += x * n_tt;
            jet.second[2] += x_s * n_t;
        }
        jet
    }

    /// Derivatives of the place along the coordinates [m].
    pub fn tangents(&self, local: [f64; 2]) -> [Vector<D>; 2] {
        self.jet(local).first
    }

    /// Outward unit normal, zero where the facet is degenerate.
    pub fn normal(&self, local: [f64; 2]) -> Vector<D> {
        let [a, b] = self.tangents(local).map(|tangent| Vector(tangent.to3()));
        let area = if D == 3 { a.cross(b) } else { a.cross(Vector::unit(2)) };
        Vector::from3(area.0).normalized().unwrap_or_default()
    }

    /// The nearest point to `p`; `None` if it is clearly farther than a distance with this square [m²].
    pub fn nearest(&self, p: Vector<D>, limit: f64) -> Option<Projection> {
        let mut away = [f64::INFINITY; GRID * GRID];
        let away = &mut away[..self.grid.len()];
        away.iter_mut().zip(&self.grid).for_each(|(away, x)| *away = (*x - p).norm_squared());
        let least = away.iter().copied().fold(f64::INFINITY, f64::min);
        if least.sqrt() - self.cell > limit.sqrt() {
            return None;
        }
        let starts = (0..away.len()).filter(|&n| is_least(away, n)).map(|n| self.project(p, Self::grid_point(n)));
        starts.reduce(|best, next| if next.squared < best.squared { next } else { best })
    }

    fn project(&self, p: Vector<D>, start: [f64; 2]) -> Projection {
        const PASSES: usize = 30;
        const TOLERANCE: f64 = 1e-12;
        let mut local = start;
        for _ in 0..PASSES {
            let jet = self.jet(local);
            let step = step(&jet, jet.x - p, local);
            let next = self.accepted(p, local, step, (jet.x - p).norm_squared());
            let change = (next[0] - local[0]).abs().max((next[1] - local[1]).abs());
            local = next;
            if change < TOLERANCE {
                break;
            }
        }
        Projection { local, squared: (self.position(local) - p).norm_squared() }
    }

    /// The longest of the step and its halves, within the bounds, that does not lead away from `p`.
    fn accepted(&self, p: Vector<D>, local: [f64; 2], step: [f64; 2], squared: f64) -> [f64; 2] {
        const HALVINGS: usize = 12;
        /// The square of the distance doesn't tell shorter steps from rounding.
        const SHORTEST_STEP: f64 = 1e-6;
        let mut factor = 1.0;
        for _ in 0..HALVINGS {
            let next: [f64; 2] = std::array::from_fn(|k| (local[k] + factor * step[k]).clamp(-1.0, 1.0));
            let short = (0..2).all(|k| (next[k] - local[k]).abs() < SHORTEST_STEP);
            if short || (self.position(next) - p).norm_squared() <= squared {
                return next;
            }
            factor *= 0.5;
        }
        local
    }
}

/// True for a point of the grid that is nearer than its neighbours; of equal ones the first is.
fn is_least(away: &[f64], n: usize) -> bool {
    let mut stride = 1;
    while stride < away.len() {
        let at = n / stride % GRID;
        if at > 0 && away[n - stride] <= away[n] || at + 1 < GRID && away[n + stride] < away[n] {
            return false;
        }
        stride *= GRID;
    }
    true
}

/// Newton's step in the coordinates that no bound holds.
fn step<const D: usize>(jet: &Jet<D>, r: Vector<D>, local: [f64; 2]) -> [f64; 2] {
    /// Curvature of the squared distance, relative to the metric of the facet, below which a minimum isn't near.
    const LEAST_CURVATURE: f64 = 1e-3;
    let gradient = jet.first.map(|tangent| tangent.dot(r));
    let is_free =
        |k: usize| k + 1 < D && !(local[k] <= -1.0 && gradient[k] > 0.0 || local[k] >= 1.0 && gradient[k] < 0.0);
    let metric = [jet.first[0].norm_squared(), jet.first[1].norm_squared(), jet.first[0].dot(jet.first[1])];
    let hessian: [f64; 3] = std::array::from_fn(|k| metric[k] + jet.second[k].dot(r));
    let along = |k: usize| {
        let curvature = if hessian[k] > LEAST_CURVATURE * metric[k] { hessian[k] } else { metric[k] };
        if curvature > 0.0 { -gradient[k] / curvature } else { 0.0 }
    };
    match [is_free(0), is_free(1)] {
        [true, true] => [hessian, metric]
            .into_iter()
            .find(|[a, b, c]| *a > 0.0 && a * b - c * c > LEAST_CURVATURE * metric[0] * metric[1])
            .map_or([along(0), along(1)], |[a, b, c]| {
                let determinant = a * b - c * c;
                [(c * gradient[1] - b * gradient[0]) / determinant, (c * gradient[0] - a * gradient[1]) / determinant]
            }),
        [true, false] => [along(0), 0.0],
        [false, true] => [0.0, along(1)],
        [false, false] => [0.0, 0.0],
    }
}
