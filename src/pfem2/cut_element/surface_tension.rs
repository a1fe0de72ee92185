//! Surface tension as a stress in the interface (Laplace–Beltrami form, theory G.10).
//!
//! ```text
//! −σ ∫_Γ ∇_s·w dA   gives   f_i = −σ A_Γ ∇_s N_i,   ∇_s = (I − n n)·∇
//! open facets       f_i += σ ∫_∂Γ N_i t ds         t: out of the facet, in the interface and across its end ∂Γ
//! ```
//!
//! The pieces of the interface are flat, so the integral is exact, and no curvature is needed: the pull of two
//! neighbouring pieces differs by their angle. Natural contact angle: 90°. The pressure jump needs
//! [`Enrichment::Jump`](super::Enrichment::Jump).
//!
//! Beyond an open boundary the interface goes on as it is, and pulls at its end there. Without that pull the end would
//! run along the boundary: a drop that leaves would be pinched off, and air of a thousandth of its density be thrown
//! about.

use super::corners;
use crate::math::Vector;
use crate::mesh::Simplex;

/// Area of the interface in an element cut by `level` [m²]; length [m] in 2D. `x`: the element's nodes [m].
pub fn area<const D: usize, const N: usize>(level: &[f64; N], x: &[Vector<D>; N]) -> f64 {
    let place = |point: &[f64; N]| (0..N).map(|k| x[k] * point[k]).sum::<Vector<D>>();
    let corners: Vec<Vector<D>> = corners(level).iter().map(place).collect();
    match corners[..] {
        [a, b] => (b - a).norm(),
        [a, b, c] => triangle(a, b, c),
        [a, b, c, d] => triangle(a, b, c) + triangle(a, c, d),
        _ => 0.0,
    }
}

/// Area of a triangle.
fn triangle<const D: usize>(a: Vector<D>, b: Vector<D>, c: Vector<D>) -> f64 {
    let (u, v) = (b - a, c - a);
    0.5 * (u.norm_squared() * v.norm_squared() - u.dot(v).powi(2)).max(0.0).sqrt()
}

/// Forces on the nodes of an element [N]; `tension` σ [N/m]. Bit k of `open`: the facet opposite to local node k is
/// open.
pub fn forces<const D: usize, const N: usize>(
    level: &[f64; N],
    x: &[Vector<D>; N],
    simplex: &Simplex<D, N>,
    tension: f64,
    open: u8,
) -> [Vector<D>; N] {
    let slope = (0..N).map(|k| simplex.gradient[k] * level[k]).sum::<Vector<D>>();
    let Some(n) = slope.normalized() else { return [Vector::ZERO; N] };
    let pull = tension * area(level, x);
    let mut forces = simplex.gradient.map(|g| (n * n.dot(g) - g) * pull);
    for k in (0..N).filter(|k| open >> k & 1 == 1) {
        if let Some((end, outwards)) = end(level, x, k) {
            (0..N).for_each(|i| forces[i] += outwards * (tension * end[i]));
        }
    }
    forces
}

/// The end of the interface at the facet opposite to local node `k`: its middle, and the direction in which the
/// interface goes on, as long as the end is (1 in 2D).
fn end<const D: usize, const N: usize>(
    level: &[f64; N],
    x: &[Vector<D>; N],
    k: usize,
) -> Option<([f64; N], Vector<D>)> {
    let points = corners(level);
    let (on, off): (Vec<&[f64; N]>, Vec<&[f64; N]>) = points.iter().partition(|point| point[k] == 0.0);
    let mean = |points: &[&[f64; N]]| -> [f64; N] {
        std::array::from_fn(|i| points.iter().map(|point| point[i]).sum::<f64>() / points.len() as f64)
    };
    let place = |point: &[f64; N]| (0..N).map(|i| x[i] * point[i]).sum::<Vector<D>>();
    if on.len() != D - 1 || off.is_empty() {
        return None;
    }
    let (middle, length) = (mean(&on), place(on[on.len() - 1]) - place(on[0]));
    let away = place(&middle) - place(&mean(&off));
    let along = length.normalized().unwrap_or_default();
    let outwards = (away - along * along.dot(away)).normalized()?;
    Some((middle, outwards * if D == 2 { 1.0 } else { length.norm() }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Mesh;
    use crate::pfem2::cut_element::is_cut;

    /// The forces on all nodes, their sum over nodes times position, and the area.
    fn total<const D: usize, const N: usize>(mesh: &Mesh<D, N>, phi: impl Fn(Vector<D>) -> f64) -> (f64, f64, f64) {
        let (mut sum, mut virial, mut size) = (Vector::<D>::ZERO, 0.0, 0.0);
        for e in 0..mesh.elements().len() {
            let x = mesh.corners(e);
            let level = x.map(&phi);
            if is_cut(&level) {
                size += area(&level, &x);
                for (f, x) in forces(&level, &x, mesh.simplex(e), 1.0, 0).iter().zip(&x) {
                    sum += *f;
                    virial += f.dot(*x);
                }
            }
        }
        (sum.norm(), virial, size)
    }

    /// A closed interface pulls with no net force, and Σ f·x = −(d − 1) σ A by the divergence theorem on the surface.
    #[test]
    fn the_tension_forces_of_a_closed_interface_add_up_to_zero() {
        let mesh = Mesh::<2, 3>::block(Vector([-1.0; 2]), Vector([1.0; 2]), [40, 40]).unwrap();
        let (sum, virial, length) = total(&mesh, |x| x.norm() - 0.613);
        assert!(sum < 1e-12 && (virial + length).abs() < 1e-12);
        assert!((length / (2.0 * std::f64::consts::PI * 0.613) - 1.0).abs() < 1e-3);
        let miss = [12, 24].map(|cells| {
            let mesh = Mesh::<3, 4>::block(Vector([-1.0; 3]), Vector([1.0; 3]), [cells; 3]).unwrap();
            let (sum, virial, surface) = total(&mesh, |x| x.norm() - 0.613);
            assert!(sum < 1e-12 && (virial + 2.0 * surface).abs() < 1e-12);
            1.0 - surface / (4.0 * std::f64::consts::PI * 0.613f64.powi(2))
        });
        assert!(miss[1] < 0.01 && (3.3..4.7).contains(&(miss[0] / miss[1])), "{miss:?}");
    }

    /// A plane interface through a box that is open all around is in balance at every node.
    fn unbalanced<const D: usize, const N: usize>(mesh: &Mesh<D, N>, phi: impl Fn(Vector<D>) -> f64) -> f64 {
        let mut force = vec![Vector::<D>::ZERO; mesh.nodes().len()];
        for e in 0..mesh.elements().len() {
            let (x, outer) = (mesh.corners(e), (0..N).filter(|&k| mesh.neighbour(e, k).is_none()));
            let (level, open) = (x.map(&phi), outer.fold(0, |bits, k| bits | 1 << k));
            if is_cut(&level) {
                let own = forces(&level, &x, mesh.simplex(e), 1.0, open);
                mesh.elements()[e].iter().zip(own).for_each(|(&node, f)| force[node as usize] += f);
            }
        }
        force.iter().map(|f| f.norm()).fold(0.0, f64::max)
    }

    #[test]
    fn the_tension_of_a_plane_is_in_balance_at_open_boundaries() {
        let flat = Mesh::<2, 3>::block(Vector([-1.0; 2]), Vector([1.0; 2]), [7, 9]).unwrap();
        let full = Mesh::<3, 4>::block(Vector([-1.0; 3]), Vector([1.0; 3]), [3, 4, 5]).unwrap();
        let plane = unbalanced(&flat, |x| 0.8 * x[0] - 0.6 * x[1] - 0.123);
        let space = unbalanced(&full, |x| 0.48 * x[0] + 0.6 * x[1] - 0.64 * x[2] - 0.123);
        assert!(plane < 1e-12 && space < 1e-12, "{plane:e} {space:e}");
    }
}
