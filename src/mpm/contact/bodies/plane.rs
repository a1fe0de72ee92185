//! The plane between two bodies near a grid node: that of widest margin between their particles (`separation`),
//! or where the bodies embrace, so that no plane separates them, by logistic regression (Nairn et al. 2020;
//! theory (D.26)):
//!
//! ```text
//! particles of a carry c = −1, those of b carry c = +1;  X = (x − x_I)/h extended by 1
//! f(X) = 2/(1 + e^{−β·X}) − 1,      β = argmin Σ (c − f)² + λ|β₁…D|²
//! (Σ φφ X Xᵀ + Λ) δβ = Σ φ (c − f) X − Λβ,   φ = 2e^{−d}/(1 + e^{−d})²,  d = β·X
//! n = β₁…D/|β₁…D|                   from a to b
//! ```
//!
//! The gap is g = min_b(x·n − r) − max_a(x·n + r) over the particles next to the node along the surface: over the whole
//! support, a patch of contact would be wider by the support. With r = |Sᵀn| a particle is the ball that touched the
//! body's surface at the start, deformed: a disc is round, not a staircase of particles, and stays so when it turns.

use super::separation::{LEAST_PIVOT, separation};
use crate::math::dense::solve_semidefinite;
use crate::math::{Tensor, Vector};

/// A particle near the node.
#[derive(Debug, Clone, Copy)]
pub struct NodeParticle<const D: usize> {
    /// Position relative to the node [cells].
    pub position: Vector<D>,
    /// Linear map of the unit ball to the particle [cells].
    pub shape: Tensor<D>,
    /// Half width along the surface within which the particle stands for it [cells].
    pub width: f64,
    /// False: body a; true: body b.
    pub second: bool,
}

/// Round-off of positions at the edge of a particle's patch [cells].
const PATCH_ROUND_OFF: f64 = 1e-9;

/// The plane between two bodies at a node.
#[derive(Debug, Clone, Copy)]
pub struct ContactPlane<const D: usize> {
    /// Unit normal from a to b.
    pub normal: Vector<D>,
    /// Distance between the two along the normal [cells]; negative when they overlap.
    pub gap: f64,
}

/// Penalty λ on the normal, and the change of the normal, squared over two, that ends the iteration.
const PENALTY: f64 = 1e-7;
const SETTLED: f64 = 1e-5;
const ITERATIONS: usize = 15;

/// The plane that separates the two bodies best; `None` if one of them is missing or they coincide.
/// Components along axes where `free` is false (symmetry planes through the node) are zero.
pub fn contact_plane<const D: usize>(cloud: &[NodeParticle<D>], free: [bool; D]) -> Option<ContactPlane<D>> {
    let fit = linear(cloud, free)?;
    let guess = direction(&fit, free)?;
    let normal = widest(cloud, guess, free).unwrap_or_else(|| fitted(cloud, fit, guess, free));
    Some(ContactPlane { normal, gap: gap(cloud, normal)? })
}

/// The normal of widest margin, if a plane separates the particles.
fn widest<const D: usize>(cloud: &[NodeParticle<D>], guess: Vector<D>, free: [bool; D]) -> Option<Vector<D>> {
    let body = |second: bool| -> Vec<Vector<D>> {
        let own = cloud.iter().filter(|point| point.second == second);
        own.map(|point| Vector::from_fn(|a| if free[a] { point.position[a] } else { 0.0 })).collect()
    };
    separation(&body(false), &body(true), guess)?.normalized()
}

/// The normal of the regression, starting from a linear fit and its direction.
fn fitted<const D: usize>(
    cloud: &[NodeParticle<D>],
    mut beta: Beta,
    mut normal: Vector<D>,
    free: [bool; D],
) -> Vector<D> {
    for _ in 0..ITERATIONS {
        improve(cloud, &mut beta);
        let Some(next) = direction(&beta, free) else { break };
        let change = 1.0 - next.dot(normal);
        normal = next;
        if change < SETTLED {
            break;
        }
    }
    normal
}

/// Coefficients: D of the normal and the offset at index 3.
type Beta = [f64; 4];

fn extended<const D: usize>(point: &NodeParticle<D>) -> Beta {
    let [x, y, z] = point.position.to3();
    [x, y, z, 1.0]
}

fn direction<const D: usize>(beta: &Beta, free: [bool; D]) -> Option<Vector<D>> {
    Vector::<D>::from_fn(|i| if free[i] { beta[i] } else { 0.0 }).normalized()
}

/// Start: twice the linear least-squares fit of c, or the line between the centroids where that has no direction.
fn linear<const D: usize>(cloud: &[NodeParticle<D>], free: [bool; D]) -> Option<Beta> {
    let mut sums = [(0.0, Vector::<D>::ZERO); 2];
    let (mut matrix, mut right) = ([[0.0; 4]; 4], [0.0; 4]);
    for point in cloud {
        let (count, sum) = &mut sums[usize::from(point.second)];
        *count += 1.0;
        *sum += point.position;
        accumulate(&mut matrix, &mut right, extended(point), 1.0, if point.second { 1.0 } else { -1.0 });
    }
    if sums[0].0 == 0.0 || sums[1].0 == 0.0 {
        return None;
    }
    let line = (sums[1].1 / sums[1].0 - sums[0].1 / sums[0].0).normalized()?;
    let fit = solve_semidefinite(matrix, right, LEAST_PIVOT).map(|b| 2.0 * b);
    match direction(&fit, free) {
        Some(normal) if normal.dot(line) > 0.0 => Some(fit),
        _ => {
            let [x, y, z] = line.to3();
            Some([x, y, z, 0.0])
        }
    }
}

/// One Gauss–Newton step.
fn improve<const D: usize>(cloud: &[NodeParticle<D>], beta: &mut Beta) {
    let (mut matrix, mut right) = ([[0.0; 4]; 4], [0.0; 4]);
    for point in cloud {
        let x = extended(point);
        let d: f64 = x.iter().zip(&*beta).map(|(x, b)| x * b).sum();
        let decay = (-d.abs()).exp();
        let slope = 2.0 * decay / ((1.0 + decay) * (1.0 + decay));
        let fit = (1.0 - decay) / (1.0 + decay) * d.signum();
        let label = if point.second { 1.0 } else { -1.0 };
        accumulate(&mut matrix, &mut right, x, slope, label - fit);
    }
    for i in 0..3 {
        matrix[i][i] += PENALTY;
        right[i] -= PENALTY * beta[i];
    }
    for (b, step) in beta.iter_mut().zip(solve_semidefinite(matrix, right, LEAST_PIVOT)) {
        *b += step;
    }
}

fn accumulate(matrix: &mut [[f64; 4]; 4], right: &mut Beta, x: Beta, slope: f64, residual: f64) {
    for i in 0..4 {
        for j in 0..4 {
            matrix[i][j] += slope * slope * x[i] * x[j];
        }
        right[i] += slope * residual * x[i];
    }
}

/// The gap next to the node along the surface; `None` if a body has no particle there.
fn gap<const D: usize>(cloud: &[NodeParticle<D>], normal: Vector<D>) -> Option<f64> {
    let (mut first, mut second) = (f64::NEG_INFINITY, f64::INFINITY);
    for point in cloud {
        let height = point.position.dot(normal);
        if (point.position - normal * height).norm() > point.width + PATCH_ROUND_OFF {
            continue;
        }
        let radius = point.shape.transpose().apply(normal).norm();
        if point.second {
            second = second.min(height - radius);
        } else {
            first = first.max(height + radius);
        }
    }
    let gap = second - first;
    gap.is_finite().then_some(gap)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A half-space of stencil points against another, rotated: the fitted normal is the known one.
    #[test]
    fn the_normal_of_an_oblique_plane_is_found() {
        for degrees in [0.0, 17.0, 45.0, 80.0_f64] {
            let n = Vector([degrees.to_radians().cos(), degrees.to_radians().sin()]);
            let mut cloud = Vec::new();
            for i in -8..8 {
                for j in -8..8 {
                    let x = Vector([f64::from(i), f64::from(j)]) * 0.19 + Vector([0.07, 0.03]);
                    if x.dot(n).abs() > 0.1 && x.norm() < 1.5 {
                        cloud.push(NodeParticle {
                            position: x,
                            shape: Tensor::identity() * 0.1,
                            width: 0.5,
                            second: x.dot(n) > 0.0,
                        });
                    }
                }
            }
            let plane = contact_plane(&cloud, [true; 2]).unwrap();
            assert!(plane.normal.dot(n) > 0.998, "{degrees}: {:?}", plane.normal);
            assert!((plane.gap - gap(&cloud, n).unwrap()).abs() < 0.06, "{degrees}: {}", plane.gap);
        }
    }

    /// Two particles: the line between them, and the distance between their faces.
    #[test]
    fn two_points_face_each_other() {
        let a = Vector([0.1, -0.2, 0.3]);
        let b = Vector([0.5, 0.4, -0.1]);
        let ball = |radius| Tensor::identity() * radius;
        let cloud = [
            NodeParticle { position: a, shape: ball(0.2), width: 0.5, second: false },
            NodeParticle { position: b, shape: ball(0.1), width: 0.5, second: true },
        ];
        let plane = contact_plane(&cloud, [true; 3]).unwrap();
        let line = (b - a).normalized().unwrap();
        assert!(plane.normal.dot(line) > 1.0 - 1e-6);
        assert!((plane.gap - ((b - a).norm() - 0.3)).abs() < 1e-5);
    }

    /// On a symmetry plane the normal lies in the plane; a single body has no plane.
    #[test]
    fn a_normal_lies_in_a_symmetry_plane_and_a_single_body_has_no_plane() {
        let point = |x, y, second| NodeParticle {
            position: Vector([x, y]),
            shape: Tensor::identity() * 0.1,
            width: 0.5,
            second,
        };
        let cloud = [point(0.3, -0.5, false), point(0.4, 0.5, true)];
        let plane = contact_plane(&cloud, [false, true]).unwrap();
        assert_eq!(plane.normal, Vector([0.0, 1.0]));
        assert!(contact_plane(&cloud[..1], [true; 2]).is_none());
    }

    /// Next to the leading corner of a block that lies on a slab the normal is that of the slab; a fit tilts.
    #[test]
    fn a_corner_does_not_tilt_the_normal_of_a_face() {
        for node in [0.0, 0.2, 0.8, 1.2] {
            let mut cloud = Vec::new();
            for i in -6..6 {
                for j in -6..6 {
                    let x = Vector([(f64::from(i) + 0.5) * 0.25, (f64::from(j) + 0.5) * 0.25]);
                    if x[1] < 0.0 || x[0] < -node {
                        cloud.push(NodeParticle {
                            position: x,
                            shape: Tensor::identity() * 0.125,
                            width: 0.5,
                            second: x[1] > 0.0,
                        });
                    }
                }
            }
            let Some(plane) = contact_plane(&cloud, [true; 2]) else {
                assert!(node > 0.5, "the block lies above this node's strip");
                continue;
            };
            assert!(node < 0.5, "the block lies beside this node's strip");
            assert!((plane.normal - Vector([0.0, 1.0])).norm() < 1e-4, "{node}: {:?}", plane.normal);
            assert!(plane.gap.abs() < 1e-4, "{node}: {}", plane.gap);
        }
    }

    /// A particle that turns keeps its size; one that is stretched along the normal grows.
    #[test]
    fn sizes_follow_stretch_and_not_rotation() {
        let turned = Tensor::from_fn(|i, j| [[0.6, -0.8], [0.8, 0.6]][i][j] * 0.1);
        let long = Tensor::from_fn(|i, j| if i != j { 0.0 } else { [0.3, 0.05][i] });
        let gap_of = |shape| {
            let point = |x, second| NodeParticle { position: Vector([x, 0.0]), shape, width: 0.5, second };
            contact_plane(&[point(0.0, false), point(1.0, true)], [true; 2]).unwrap().gap
        };
        assert!((gap_of(turned) - 0.8).abs() < 1e-12 && (gap_of(long) - 0.4).abs() < 1e-12);
    }
}
