//! Elements that an interface cuts: sub-simplices, the enriched pressure, its condensation and recovery (theory 7).
//!
//! The interface is where the linear interpolant of the nodal level set φ vanishes. Each side is made of simplices
//! whose corners are nodes or edge points, kept in barycentric coordinates:
//!
//! ```text
//! P_ij = (φ_j x_i − φ_i x_j)/(φ_j − φ_i)
//! kink   F   = ½ (Σ|φ_i| N_i − |Σφ_i N_i|),   ∇F on side s = Σ_{i not on s} |φ_i| g_i        continuous, kinked
//! jump   F_k = N_k on the side where node k is not, 0 on its own                             a jump and a kink
//!
//! ⎡K_ss  K_se⎤ ⎧x⎫   ⎧f_s⎫      K_se = (−Σ_s V_s F(c_s) g_j; −τ Σ_s V_s/ρ_s g_j·∇F_s)
//! ⎣K_es  K_ee⎦ ⎩q⎭ = ⎩f_e⎭      K_ee = −τ Σ_s V_s/ρ_s ∇F_s·∇F_s,   f_e = −τ Σ_s V_s ∇F_s·s
//!
//! K̂ = K_ss − K_se K_ee⁻¹ K_es,  f̂ = f_s − K_se K_ee⁻¹ f_e,  q = K_ee⁻¹ (f_e − K_es x)       (29–33)
//! ```
//!
//! All functions vanish at the nodes, so the nodal unknowns keep their meaning, and each side has its own pressure
//! gradient: two fluids at rest stay at rest wherever the interface cuts.

use super::element::{Block, Content};
use crate::math::{Tensor, Vector};
use crate::mesh::Simplex;

/// A side whose nodes all have |φ| below this fraction of the largest is no side: its volume is round-off.
const THINNEST: f64 = 1e-14;

/// A simplex on one side of the interface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Part<const N: usize> {
    /// Volume as a fraction of the element's.
    pub share: f64,
    /// Shape functions of the element at its centre.
    pub center: [f64; N],
    /// Mean of N_i N_j over it.
    pub products: [[f64; N]; N],
    /// True on the side of negative φ.
    pub negative: bool,
}

/// True if the interface cuts an element with these level sets.
pub fn is_cut<const N: usize>(level: &[f64; N]) -> bool {
    let lowest = level.iter().copied().fold(0.0, f64::min);
    let highest = level.iter().copied().fold(0.0, f64::max);
    lowest.abs().min(highest) > THINNEST * lowest.abs().max(highest)
}

/// Barycentric coordinates of a point.
type Point<const N: usize> = [f64; N];

/// Node `i`.
fn node<const N: usize>(i: usize) -> Point<N> {
    std::array::from_fn(|k| if k == i { 1.0 } else { 0.0 })
}

/// Where the interface meets the edge between nodes `i` and `j` of different sides.
fn edge_point<const N: usize>(level: &[f64; N], i: usize, j: usize) -> Point<N> {
    let (a, b) = (level[i].abs(), level[j].abs());
    let mut point = [0.0; N];
    point[i] = b / (a + b);
    point[j] = a / (a + b);
    point
}

/// The sub-simplices of a cut element, side by side.
pub fn split<const N: usize>(level: &[f64; N]) -> Vec<Part<N>> {
    let mut parts = Vec::with_capacity(6);
    for negative in [true, false] {
        let on_side = |i: &usize| (level[*i] < 0.0) == negative;
        let own: Vec<usize> = (0..N).filter(on_side).collect();
        let other: Vec<usize> = (0..N).filter(|i| !on_side(i)).collect();
        parts.extend(side(level, &own, &other).iter().map(|corners| part(corners, negative)));
    }
    parts
}

/// The simplices of the side of the nodes `own`.
fn side<const N: usize>(level: &[f64; N], own: &[usize], other: &[usize]) -> Vec<[Point<N>; N]> {
    let cut = |i: usize, j: usize| edge_point(level, i, j);
    match (own, other) {
        // A corner: a node and the edge points around it.
        (&[a], _) => vec![std::array::from_fn(|k| if k == 0 { node(a) } else { cut(a, other[k - 1]) })],
        // What a corner leaves, and a tetrahedron between two edges: a prism (a quadrilateral in 2D) between
        // lateral edges.
        (_, &[a]) => {
            let lower: Vec<_> = own.iter().map(|&i| cut(a, i)).collect();
            let upper: Vec<_> = own.iter().map(|&i| node(i)).collect();
            prism(&lower, &upper)
        }
        (&[a, b], &[c, d]) => prism(&[node(a), cut(a, c), cut(a, d)], &[node(b), cut(b, c), cut(b, d)]),
        _ => Vec::new(),
    }
}

/// A prism between two facets with corresponding corners, as simplices: {(p,b,c,d), (p,q,c,d), (p,q,r,d)}.
fn prism<const N: usize>(lower: &[Point<N>], upper: &[Point<N>]) -> Vec<[Point<N>; N]> {
    let simplex = |k: usize| std::array::from_fn(|i| if i <= k { lower[i] } else { upper[i - 1] });
    (0..lower.len()).map(simplex).collect()
}

/// Volume and centre of a sub-simplex.
fn part<const N: usize>(corners: &[Point<N>; N], negative: bool) -> Part<N> {
    // The fraction is |det λ|; rows sum to one, so a column may be dropped against differences of rows.
    let edges = Tensor::<3>::from_fn(|i, j| match (i + 1 < N, j + 1 < N) {
        (true, true) => corners[i + 1][j + 1] - corners[0][j + 1],
        (false, false) => 1.0,
        _ => 0.0,
    });
    let sum: [f64; N] = std::array::from_fn(|k| corners.iter().map(|corner| corner[k]).sum());
    // ∫λ_a λ_b dV = V (1 + δ_ab)/(d + 1)(d + 2) for its own shape functions λ.
    let product =
        |i: usize, j: usize| sum[i] * sum[j] + corners.iter().map(|corner| corner[i] * corner[j]).sum::<f64>();
    let products = std::array::from_fn(|i| std::array::from_fn(|j| product(i, j) / (N * (N + 1)) as f64));
    Part { share: edges.determinant().abs(), center: sum.map(|sum| sum / N as f64), products, negative }
}

/// Corners of the interface in a cut element: 2 in a triangle, 3 or 4, in order around it, in a tetrahedron.
pub fn corners<const N: usize>(level: &[f64; N]) -> Vec<Point<N>> {
    let (own, other): (Vec<usize>, Vec<usize>) = (0..N).partition(|&i| level[i] < 0.0);
    let cut = |i: usize, j: usize| edge_point(level, i, j);
    match (&own[..], &other[..]) {
        (&[a], rest) | (rest, &[a]) => rest.iter().map(|&i| cut(a, i)).collect(),
        (&[a, b], &[c, d]) => vec![cut(a, c), cut(a, d), cut(b, d), cut(b, c)],
        _ => Vec::new(),
    }
}

/// The interface in an element as simplices: a segment in a triangle, one or two triangles in a tetrahedron. An element
/// that isn't cut has one if it lies on the negative side of an interface that runs along one of its facets.
pub fn facets<const D: usize, const N: usize>(level: &[f64; N]) -> Vec<[[f64; N]; D]> {
    let points = if is_cut(level) { corners(level) } else { touched(level) };
    let facet = |fan: &[Point<N>]| std::array::from_fn(|i| if i == 0 && D == 3 { points[0] } else { fan[i + 2 - D] });
    points.windows(2).skip(D - 2).map(facet).collect()
}

/// Corners of the facet on which φ vanishes, up to rounding, if the node opposite to it is negative.
fn touched<const N: usize>(level: &[f64; N]) -> Vec<Point<N>> {
    let largest = level.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
    let (on, off): (Vec<usize>, Vec<usize>) = (0..N).partition(|&i| level[i].abs() <= THINNEST * largest);
    match off[..] {
        [only] if level[only] < 0.0 => on.into_iter().map(node).collect(),
        _ => Vec::new(),
    }
}

/// Which functions enrich the pressure of a cut element.
///
/// Both keep fluids at rest. In motion one kink ties the two gradients together: a standing wave of water under air
/// gains energy with it and loses a little with one function per node, which also carries the jump of surface tension.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Enrichment {
    /// None: for comparison.
    None,
    /// One kink (theory 7.5): the paper.
    Kink,
    /// A jump and a kink, one function per node.
    #[default]
    Jump,
}

/// Density and viscosity of a fluid, as an element sees them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Medium {
    /// Density [kg/m³].
    pub density: f64,
    /// Viscosity [Pa s].
    pub viscosity: f64,
}

/// Sums of a cut element.
#[derive(Debug, Clone)]
pub struct Cut<const N: usize> {
    /// Level set at the nodes, divided by the largest.
    level: [f64; N],
    /// Sub-simplices.
    pub parts: Vec<Part<N>>,
    /// Media of the negative and the positive side.
    pub media: [Medium; 2],
}

impl<const N: usize> Cut<N> {
    /// An element cut by a level set; `media` of the negative and the positive side.
    pub fn new(level: [f64; N], media: [Medium; 2]) -> Self {
        let largest = level.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
        let level = level.map(|value| value / largest);
        Self { parts: split(&level), level, media }
    }

    /// Medium of a part.
    pub fn medium(&self, part: &Part<N>) -> Medium {
        self.media[usize::from(!part.negative)]
    }

    /// Fraction of the element on the negative side.
    pub fn negative_share(&self) -> f64 {
        self.parts.iter().filter(|part| part.negative).map(|part| part.share).sum()
    }

    /// Mass, viscosity and ∫dV/ρ over the parts, with τ from their means.
    pub fn content(&self, volume: f64, tau: impl Fn(Medium) -> f64) -> Content<N> {
        let mut content = Content { mass: [0.0; N], viscosity: 0.0, tau: 0.0, lightness: 0.0 };
        for part in &self.parts {
            let Medium { density, viscosity } = self.medium(part);
            for i in 0..N {
                content.mass[i] += volume * part.share * density * part.center[i];
            }
            content.viscosity += part.share * viscosity;
            content.lightness += volume * part.share / density;
        }
        let density = content.mass.iter().sum::<f64>() / volume;
        content.tau = tau(Medium { density, viscosity: content.viscosity });
        content
    }

    /// Consistent mass matrix ∫ρ N_i N_j [kg] of an element of this volume [m³].
    pub fn mass(&self, volume: f64) -> [[f64; N]; N] {
        let mut mass = [[0.0; N]; N];
        for part in &self.parts {
            let own = volume * part.share * self.medium(part).density;
            for (row, products) in mass.iter_mut().zip(&part.products) {
                row.iter_mut().zip(products).for_each(|(m, product)| *m += own * product);
            }
        }
        mass
    }

    /// Functions of an enrichment.
    fn functions(&self, enrichment: Enrichment) -> usize {
        match enrichment {
            Enrichment::None => 0,
            Enrichment::Kink => 1,
            Enrichment::Jump => N,
        }
    }

    /// Value at the centre of a part and gradient of function `k` there.
    fn function<const D: usize>(
        &self,
        enrichment: Enrichment,
        k: usize,
        part: &Part<N>,
        gradient: &[Vector<D>; N],
    ) -> (f64, Vector<D>) {
        let opposite = |i: usize| (self.level[i] < 0.0) != part.negative;
        match enrichment {
            Enrichment::None => (0.0, Vector::ZERO),
            Enrichment::Kink => {
                let others = (0..N).filter(|&i| opposite(i));
                others.fold((0.0, Vector::ZERO), |(value, slope), i| {
                    let size = self.level[i].abs();
                    (value + size * part.center[i], slope + gradient[i] * size)
                })
            }
            Enrichment::Jump if opposite(k) => (part.center[k], gradient[k]),
            Enrichment::Jump => (0.0, Vector::ZERO),
        }
    }
}

/// The enriched pressure of a cut element, ready to be condensed.
#[derive(Debug, Clone)]
pub struct Enriched<const N: usize> {
    /// K_es, a row of nodal blocks per function.
    rows: Vec<[[f64; N]; N]>,
    /// K_se transposed.
    columns: Vec<[[f64; N]; N]>,
    /// (−K_ee)⁻¹.
    inverse: Vec<Vec<f64>>,
    /// f_e.
    load: Vec<f64>,
}

impl<const N: usize> Enriched<N> {
    /// The enrichment of a cut element. `source` is s [m/s²]; `inertia` is τ/Δ with consistent PSPG, else 0.
    pub fn new<const D: usize>(
        cut: &Cut<N>,
        enrichment: Enrichment,
        simplex: &Simplex<D, N>,
        tau: f64,
        source: Vector<D>,
        inertia: f64,
    ) -> Self {
        let count = cut.functions(enrichment);
        let mut columns = vec![[[0.0; N]; N]; count];
        let mut extra = vec![[[0.0; N]; N]; count];
        let mut matrix = vec![vec![0.0; count]; count];
        let mut load = vec![0.0; count];
        for part in &cut.parts {
            let volume = simplex.volume * part.share;
            let weight = tau * volume / cut.medium(part).density;
            let at = |k| cut.function(enrichment, k, part, &simplex.gradient);
            for k in 0..count {
                let (value, slope) = at(k);
                load[k] -= tau * volume * slope.dot(source);
                for (l, entry) in matrix[k].iter_mut().enumerate() {
                    *entry += weight * slope.dot(at(l).1);
                }
                for j in 0..N {
                    for s in 0..D {
                        columns[k][j][s] -= volume * value * simplex.gradient[j][s];
                        extra[k][j][s] -= inertia * volume * part.center[j] * slope[s];
                    }
                    columns[k][j][D] -= weight * simplex.gradient[j].dot(slope);
                }
            }
        }
        let sum = |(column, extra): (&[[f64; N]; N], &[[f64; N]; N])| {
            std::array::from_fn(|j| std::array::from_fn(|s| column[j][s] + extra[j][s]))
        };
        let rows = columns.iter().zip(&extra).map(sum).collect();
        Self { rows, columns, inverse: inverse(matrix), load }
    }

    /// What condensation adds to the block of nodes `i` and `j`.
    pub fn block(&self, i: usize, j: usize) -> Block<N> {
        let mut block = [[0.0; N]; N];
        for (k, column) in self.columns.iter().enumerate() {
            for (l, row) in self.rows.iter().enumerate() {
                for r in 0..N {
                    for s in 0..N {
                        block[r][s] += column[i][r] * self.inverse[k][l] * row[j][s];
                    }
                }
            }
        }
        block
    }

    /// What condensation adds to the right-hand side of node `i`.
    pub fn load(&self, i: usize) -> [f64; N] {
        let mut sum = [0.0; N];
        for (k, column) in self.columns.iter().enumerate() {
            let amount: f64 = self.load.iter().zip(&self.inverse[k]).map(|(load, entry)| load * entry).sum();
            (0..N).for_each(|r| sum[r] += column[i][r] * amount);
        }
        sum
    }

    /// The condensed pressures q [Pa] that belong to the nodal unknowns of the element.
    pub fn recover(&self, nodal: &[[f64; N]; N]) -> Vec<f64> {
        let rest = |(row, load): (&[[f64; N]; N], &f64)| {
            let sum: f64 = row.iter().zip(nodal).flat_map(|(a, x)| a.iter().zip(x)).map(|(a, x)| a * x).sum();
            sum - load
        };
        let rest: Vec<f64> = self.rows.iter().zip(&self.load).map(rest).collect();
        self.inverse.iter().map(|row| row.iter().zip(&rest).map(|(a, r)| a * r).sum()).collect()
    }
}

/// The inverse of a small symmetric positive definite matrix by Gauss–Jordan steps; functions without support
/// (a pivot that is round-off of its diagonal) are dropped.
fn inverse(mut a: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    const ROUND_OFF: f64 = 1e-13;
    let n = a.len();
    let diagonal: Vec<f64> = (0..n).map(|k| a[k][k]).collect();
    for k in 0..n {
        let pivot = a[k][k];
        let dropped = pivot <= ROUND_OFF * diagonal[k];
        for i in 0..n {
            if i != k {
                let factor = if dropped { 0.0 } else { a[i][k] / pivot };
                for j in 0..n {
                    if j != k {
                        a[i][j] -= factor * a[k][j];
                    }
                }
                a[i][k] = -factor;
            }
        }
        for j in 0..n {
            a[k][j] = match (dropped, j == k) {
                (true, _) => 0.0,
                (false, true) => 1.0 / pivot,
                (false, false) => a[k][j] / pivot,
            };
        }
    }
    a
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Mesh;

    const MEDIA: [Medium; 2] = [Medium { density: 1000.0, viscosity: 1e-3 }, Medium { density: 1.0, viscosity: 1e-5 }];

    /// Numbers in −1..1 from a seed (a linear congruential sequence).
    fn numbers(seed: &mut u64) -> f64 {
        *seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (*seed >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    /// The fraction of a simplex where a linear function with nodal values φ is negative (Curry & Schoenberg 1966):
    /// Σ_{φ_i<0} (−φ_i)^d / Π_{j≠i} (φ_j − φ_i).
    fn fraction<const N: usize>(level: &[f64; N]) -> f64 {
        let term = |i: usize| {
            let product: f64 = (0..N).filter(|&j| j != i).map(|j| level[j] - level[i]).product();
            (-level[i]).powi(N as i32 - 1) / product
        };
        (0..N).filter(|&i| level[i] < 0.0).map(term).sum()
    }

    fn check_volumes<const N: usize>() {
        let mut seed = 7;
        for _ in 0..2000 {
            let level: [f64; N] = std::array::from_fn(|_| numbers(&mut seed));
            if !is_cut(&level) {
                continue;
            }
            let parts = split(&level);
            let at = |center: &[f64; N]| (0..N).map(|k| center[k] * level[k]).sum::<f64>();
            assert!(parts.iter().all(|part| (at(&part.center) < 0.0) == part.negative));
            assert!((parts.iter().map(|part| part.share).sum::<f64>() - 1.0).abs() < 1e-12);
            for k in 0..N {
                let moment: f64 = parts.iter().map(|part| part.share * part.center[k]).sum();
                assert!((moment - 1.0 / N as f64).abs() < 1e-12);
                for j in 0..N {
                    let product: f64 = parts.iter().map(|part| part.share * part.products[k][j]).sum();
                    let exact = if j == k { 2.0 } else { 1.0 } / (N * (N + 1)) as f64;
                    assert!((product - exact).abs() < 1e-12);
                }
            }
            let negative: f64 = parts.iter().filter(|part| part.negative).map(|part| part.share).sum();
            // Nodes with nearly the same level cancel in the closed form.
            assert!((negative - fraction(&level)).abs() < 1e-6, "{level:?}: {negative} {}", fraction(&level));
            assert!(corners(&level).iter().all(|corner| at(corner).abs() < 1e-14));
        }
    }

    #[test]
    fn volumes_of_the_parts_are_exact() {
        check_volumes::<3>();
        check_volumes::<4>();
    }

    #[test]
    fn a_side_of_round_off_does_not_cut() {
        assert!(!is_cut(&[0.0, 1.0, 2.0]) && !is_cut(&[-1.0, -2.0, -0.5]) && !is_cut(&[-1e-16, 1.0, 0.3]));
        assert!(is_cut(&[-1e-9, 1.0, 1.0]) && is_cut(&[0.0, -1.0, 1.0]));
    }

    fn triangle() -> Simplex<2, 3> {
        Simplex::new([Vector([0.1, 0.0]), Vector([1.0, 0.2]), Vector([0.3, 0.9])]).unwrap()
    }

    /// Pressure −ρ g (distance) on both sides of a tilted plane lies in the enriched space, and its residual against
    /// gravity vanishes: the recovered unknown gives the one-sided gradients ρ g.
    #[test]
    fn recovery_returns_the_one_sided_gradients_of_two_fluids_at_rest() {
        let nodes = [Vector([0.1, 0.0]), Vector([1.0, 0.2]), Vector([0.3, 0.9])];
        let (normal, gravity) = (Vector([0.6, 0.8]), Vector([0.6, 0.8]) * -9.81);
        let level = nodes.map(|x| x.dot(normal) - 0.47);
        let cut = Cut::new(level, MEDIA);
        let simplex = triangle();
        let pressure = |phi: f64| -phi * 9.81 * if phi < 0.0 { 1000.0 } else { 1.0 };
        let nodal = level.map(|phi| [0.0, 0.0, pressure(phi)]);
        for enrichment in [Enrichment::Kink, Enrichment::Jump] {
            let enriched = Enriched::new(&cut, enrichment, &simplex, 0.01, gravity, 0.0);
            let q = enriched.recover(&nodal);
            for part in &cut.parts {
                let smooth = (0..3).map(|k| simplex.gradient[k] * nodal[k][2]).sum::<Vector<2>>();
                let own = |k: usize| cut.function(enrichment, k, part, &simplex.gradient).1 * q[k];
                let slope = smooth + (0..q.len()).map(own).sum::<Vector<2>>();
                let rest = slope - gravity * cut.medium(part).density;
                assert!(rest.norm() < 1e-9, "{enrichment:?}: {rest:?}");
            }
        }
    }

    #[test]
    fn content_of_a_cut_element_is_that_of_its_parts() {
        let cut = Cut::new([-0.3, 0.9, 0.4], MEDIA);
        let content = cut.content(2.0, |_| 0.5);
        let heavy = fraction(&[-0.3, 0.9, 0.4]);
        assert!((cut.negative_share() - heavy).abs() < 1e-14);
        let mass = 2.0 * (heavy * 1000.0 + (1.0 - heavy));
        assert!((content.mass.iter().sum::<f64>() - mass).abs() < 1e-10);
        assert!((content.lightness - 2.0 * (heavy / 1000.0 + (1.0 - heavy))).abs() < 1e-14);
    }

    #[test]
    fn a_small_inverse_is_one_and_drops_what_has_no_support() {
        let a = vec![vec![4.0, 1.0, 0.0], vec![1.0, 3.0, 0.0], vec![0.0, 0.0, 0.0]];
        let b = inverse(a.clone());
        for i in 0..2 {
            for j in 0..2 {
                let product: f64 = (0..3).map(|k| a[i][k] * b[k][j]).sum();
                assert!((product - f64::from(u8::from(i == j))).abs() < 1e-15);
            }
        }
        assert_eq!(b[2], [0.0; 3]);
    }

    #[test]
    fn the_interface_of_a_plane_through_a_block_has_the_area_of_the_plane() {
        let mesh = Mesh::<3, 4>::block(Vector([0.0; 3]), Vector([1.0; 3]), [3, 4, 5]).unwrap();
        let area: f64 = (0..mesh.elements().len())
            .map(|e| {
                let x = mesh.corners(e);
                let level = x.map(|x| x[2] - 0.413);
                if is_cut(&level) { crate::pfem2::surface_tension::area(&level, &x) } else { 0.0 }
            })
            .sum();
        assert!((area - 1.0).abs() < 1e-12);
    }
}
