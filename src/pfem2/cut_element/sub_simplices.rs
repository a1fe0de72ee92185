//! The sides of a cut element as sub-simplices, and the interface between them (theory G.7).

use crate::math::Tensor;

/// A side whose nodes all have |φ| below this fraction of the largest is no side: its volume is round-off.
const THINNEST: f64 = 1e-14;

/// A simplex on one side of the interface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SubSimplex<const N: usize> {
    /// Volume as a fraction of the element's.
    pub volume_fraction: f64,
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
type Barycentric<const N: usize> = [f64; N];

/// Node `i`.
fn node<const N: usize>(i: usize) -> Barycentric<N> {
    std::array::from_fn(|k| if k == i { 1.0 } else { 0.0 })
}

/// The point of the interface on the edge between nodes `i` and `j` of different sides.
fn edge_point<const N: usize>(level: &[f64; N], i: usize, j: usize) -> Barycentric<N> {
    let (a, b) = (level[i].abs(), level[j].abs());
    let mut point = [0.0; N];
    point[i] = b / (a + b);
    point[j] = a / (a + b);
    point
}

/// The sub-simplices of a cut element, side by side.
pub fn split<const N: usize>(level: &[f64; N]) -> Vec<SubSimplex<N>> {
    let mut parts = Vec::with_capacity(6);
    for negative in [true, false] {
        let on_side = |i: &usize| (level[*i] < 0.0) == negative;
        let own: Vec<usize> = (0..N).filter(on_side).collect();
        let other: Vec<usize> = (0..N).filter(|i| !on_side(i)).collect();
        parts.extend(side(level, &own, &other).iter().map(|corners| part(corners, negative)));
    }
    parts
}

/// The sub-simplices of an element or facet that may be cut, or it as a whole.
pub fn sides<const N: usize>(level: &[f64; N]) -> Vec<SubSimplex<N>> {
    if is_cut(level) {
        return split(level);
    }
    vec![part(&whole(), level.iter().sum::<f64>() < 0.0)]
}

/// Fraction of an element where the linear φ with these nodal values is negative, as the cut elements count it.
pub(in crate::pfem2) fn negative_fraction<const N: usize>(level: &[f64; N]) -> f64 {
    if is_cut(level) {
        return split(level).iter().filter(|part| part.negative).map(|part| part.volume_fraction).sum();
    }
    if level.iter().sum::<f64>() < 0.0 { 1.0 } else { 0.0 }
}

/// The linear function with these nodal values at the barycentric corners of a simplex in an element.
pub fn at_corners<const N: usize>(corners: &[Barycentric<N>; N], level: &[f64; N]) -> [f64; N] {
    corners.map(|corner| corner.iter().zip(level).map(|(n, value)| n * value).sum())
}

/// Points of a simplex in an element, given by the shape functions of the simplex, as points of the element.
pub fn inner<const N: usize, const K: usize>(
    corners: &[Barycentric<N>; N],
    points: &[Barycentric<N>; K],
) -> [Barycentric<N>; K] {
    points.map(|point| std::array::from_fn(|k| (0..N).map(|c| point[c] * corners[c][k]).sum()))
}

/// A simplex as a whole, by its barycentric corners.
pub fn whole<const N: usize>() -> [Barycentric<N>; N] {
    std::array::from_fn(node)
}

/// The part of a simplex in which the linear function with these nodal values is negative, as simplices by their
/// barycentric corners.
pub fn negative_side<const N: usize>(level: &[f64; N]) -> Vec<[Barycentric<N>; N]> {
    let (own, other): (Vec<usize>, Vec<usize>) = (0..N).partition(|&i| level[i] < 0.0);
    if is_cut(level) {
        return side(level, &own, &other);
    }
    if level.iter().sum::<f64>() < 0.0 { vec![whole()] } else { Vec::new() }
}

/// The simplices of the side of the nodes `own`.
fn side<const N: usize>(level: &[f64; N], own: &[usize], other: &[usize]) -> Vec<[Barycentric<N>; N]> {
    let cut = |i: usize, j: usize| edge_point(level, i, j);
    match (own, other) {
        // A corner: a node and the edge points around it.
        (&[a], _) => vec![std::array::from_fn(|k| if k == 0 { node(a) } else { cut(a, other[k - 1]) })],
        // The rest beside a corner and, below, the part of a tetrahedron at one edge: a prism (a quadrilateral in 2D)
        // between lateral edges.
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
fn prism<const N: usize>(lower: &[Barycentric<N>], upper: &[Barycentric<N>]) -> Vec<[Barycentric<N>; N]> {
    let simplex = |k: usize| std::array::from_fn(|i| if i <= k { lower[i] } else { upper[i - 1] });
    (0..lower.len()).map(simplex).collect()
}

/// Volume of a sub-simplex as a fraction of the element's.
pub fn volume_fraction<const N: usize>(corners: &[Barycentric<N>; N]) -> f64 {
    // The fraction is |det λ|; rows sum to one, so a column may be dropped against differences of rows.
    let edges = Tensor::<3>::from_fn(|i, j| match (i + 1 < N, j + 1 < N) {
        (true, true) => corners[i + 1][j + 1] - corners[0][j + 1],
        (false, false) if i == j => 1.0,
        _ => 0.0,
    });
    edges.determinant().abs()
}

/// Volume and centre of a sub-simplex.
fn part<const N: usize>(corners: &[Barycentric<N>; N], negative: bool) -> SubSimplex<N> {
    let sum: [f64; N] = std::array::from_fn(|k| corners.iter().map(|corner| corner[k]).sum());
    // ∫λ_a λ_b dV = V (1 + δ_ab)/(d + 1)(d + 2) for the shape functions λ of the simplex.
    let product =
        |i: usize, j: usize| sum[i] * sum[j] + corners.iter().map(|corner| corner[i] * corner[j]).sum::<f64>();
    let products = std::array::from_fn(|i| std::array::from_fn(|j| product(i, j) / (N * (N + 1)) as f64));
    SubSimplex { volume_fraction: volume_fraction(corners), center: sum.map(|sum| sum / N as f64), products, negative }
}

/// Corners of the interface in a cut element: 2 in a triangle, 3 or 4, in order around it, in a tetrahedron.
pub fn corners<const N: usize>(level: &[f64; N]) -> Vec<Barycentric<N>> {
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
    let facet =
        |fan: &[Barycentric<N>]| std::array::from_fn(|i| if i == 0 && D == 3 { points[0] } else { fan[i + 2 - D] });
    points.windows(2).skip(D - 2).map(facet).collect()
}

/// Corners of the facet on which φ vanishes, up to rounding, if the node opposite to it is negative.
fn touched<const N: usize>(level: &[f64; N]) -> Vec<Barycentric<N>> {
    let largest = level.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
    let (on, off): (Vec<usize>, Vec<usize>) = (0..N).partition(|&i| level[i].abs() <= THINNEST * largest);
    match off[..] {
        [only] if level[only] < 0.0 => on.into_iter().map(node).collect(),
        _ => Vec::new(),
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::mesh::Mesh;

    /// Numbers in −1..1 from a seed (a linear congruential sequence).
    fn numbers(seed: &mut u64) -> f64 {
        *seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (*seed >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    /// The fraction of a simplex where a linear function with nodal values φ is negative (Curry & Schoenberg 1966):
    /// Σ_{φ_i<0} (−φ_i)^d / Π_{j≠i} (φ_j − φ_i).
    pub fn fraction<const N: usize>(level: &[f64; N]) -> f64 {
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
            assert!((parts.iter().map(|part| part.volume_fraction).sum::<f64>() - 1.0).abs() < 1e-12);
            for k in 0..N {
                let moment: f64 = parts.iter().map(|part| part.volume_fraction * part.center[k]).sum();
                assert!((moment - 1.0 / N as f64).abs() < 1e-12);
                for j in 0..N {
                    let product: f64 = parts.iter().map(|part| part.volume_fraction * part.products[k][j]).sum();
                    let exact = if j == k { 2.0 } else { 1.0 } / (N * (N + 1)) as f64;
                    assert!((product - exact).abs() < 1e-12);
                }
            }
            let negative: f64 = parts.iter().filter(|part| part.negative).map(|part| part.volume_fraction).sum();
            // Nodes with nearly the same level cancel in the closed form.
            assert!((negative - fraction(&level)).abs() < 1e-6, "{level:?}: {negative} {}", fraction(&level));
            assert!(corners(&level).iter().all(|corner| at(corner).abs() < 1e-14));
        }
    }

    #[test]
    fn volumes_of_the_parts_are_exact() {
        check_volumes::<2>();
        check_volumes::<3>();
        check_volumes::<4>();
    }

    #[test]
    fn a_side_of_round_off_does_not_cut() {
        assert!(!is_cut(&[0.0, 1.0, 2.0]) && !is_cut(&[-1.0, -2.0, -0.5]) && !is_cut(&[-1e-16, 1.0, 0.3]));
        assert!(is_cut(&[-1e-9, 1.0, 1.0]) && is_cut(&[0.0, -1.0, 1.0]));
    }

    #[test]
    fn the_interface_of_a_plane_through_a_block_has_the_area_of_the_plane() {
        let mesh =
            Mesh::<3, 4>::block(crate::math::Vector([0.0; 3]), crate::math::Vector([1.0; 3]), [3, 4, 5]).unwrap();
        let area: f64 = (0..mesh.elements().len())
            .map(|e| {
                let x = mesh.corners(e);
                let level = x.map(|x| x[2] - 0.413);
                if is_cut(&level) { super::super::surface_tension::area(&level, &x) } else { 0.0 }
            })
            .sum();
        assert!((area - 1.0).abs() < 1e-12);
    }
}
