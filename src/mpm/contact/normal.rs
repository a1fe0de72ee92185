//! The plane between two bodies near a grid node, by logistic regression (Nairn et al. 2020; theory 6.3 iv).
//!
//! ```text
//! particles of a carry c = −1, those of b carry c = +1;  X = (x − x_I)/h extended by 1
//! f(X) = 2/(1 + e^{−β·X}) − 1,      β = argmin Σ (c − f)² + λ|β₁…D|²
//! (Σ φφ X Xᵀ + Λ) δβ = Σ φ (c − f) X − Λβ,   φ = 2e^{−d}/(1 + e^{−d})²,  d = β·X
//! n = β₁…D/|β₁…D|                   from a to b
//! g = min_b(x·n − r) − max_a(x·n + r)
//! ```

use crate::math::Vector;

/// A particle near the node.
#[derive(Debug, Clone, Copy)]
pub struct Point<const D: usize> {
    /// Position relative to the node [cells].
    pub position: Vector<D>,
    /// Half its size [cells].
    pub radius: f64,
    /// False: body a; true: body b.
    pub second: bool,
}

/// Where two bodies face each other.
#[derive(Debug, Clone, Copy)]
pub struct Interface<const D: usize> {
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
pub fn separate<const D: usize>(cloud: &[Point<D>], free: [bool; D]) -> Option<Interface<D>> {
    let mut beta = linear(cloud, free)?;
    let mut normal = direction(&beta, free)?;
    for _ in 0..ITERATIONS {
        improve(cloud, &mut beta);
        let Some(next) = direction(&beta, free) else { break };
        let change = 1.0 - next.dot(normal);
        normal = next;
        if change < SETTLED {
            break;
        }
    }
    Some(Interface { normal, gap: gap(cloud, normal) })
}

/// Coefficients: D of the normal and the offset at index 3.
type Beta = [f64; 4];

fn extended<const D: usize>(point: &Point<D>) -> Beta {
    let [x, y, z] = point.position.to3();
    [x, y, z, 1.0]
}

fn direction<const D: usize>(beta: &Beta, free: [bool; D]) -> Option<Vector<D>> {
    Vector::<D>::from_fn(|i| if free[i] { beta[i] } else { 0.0 }).normalized()
}

/// Start: twice the linear least-squares fit of c, or the line between the centroids where that has no direction.
fn linear<const D: usize>(cloud: &[Point<D>], free: [bool; D]) -> Option<Beta> {
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
    let fit = solve(matrix, right).map(|b| 2.0 * b);
    match direction(&fit, free) {
        Some(normal) if normal.dot(line) > 0.0 => Some(fit),
        _ => {
            let [x, y, z] = line.to3();
            Some([x, y, z, 0.0])
        }
    }
}

/// One Gauss–Newton step.
fn improve<const D: usize>(cloud: &[Point<D>], beta: &mut Beta) {
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
    for (b, step) in beta.iter_mut().zip(solve(matrix, right)) {
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

/// Solves a symmetric positive semi-definite system; directions without information stay zero.
fn solve(mut a: [[f64; 4]; 4], mut b: Beta) -> Beta {
    let scale = (0..4).map(|i| a[i][i]).fold(0.0, f64::max);
    let mut done = [false; 4];
    for _ in 0..4 {
        let pivot = (0..4).filter(|&i| !done[i]).max_by(|&i, &j| a[i][i].total_cmp(&a[j][j]));
        let Some(pivot) = pivot.filter(|&i| a[i][i] > 1e-12 * scale) else { break };
        done[pivot] = true;
        for row in (0..4).filter(|&row| row != pivot) {
            let (above, factor) = (a[pivot], a[row][pivot] / a[pivot][pivot]);
            a[row].iter_mut().zip(above).for_each(|(entry, above)| *entry -= factor * above);
            b[row] -= factor * b[pivot];
        }
    }
    std::array::from_fn(|i| if done[i] { b[i] / a[i][i] } else { 0.0 })
}

fn gap<const D: usize>(cloud: &[Point<D>], normal: Vector<D>) -> f64 {
    let (mut first, mut second) = (f64::NEG_INFINITY, f64::INFINITY);
    for point in cloud {
        let height = point.position.dot(normal);
        if point.second {
            second = second.min(height - point.radius);
        } else {
            first = first.max(height + point.radius);
        }
    }
    second - first
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A half-space of lattice points against another, rotated: the fitted normal is the known one.
    #[test]
    fn the_normal_of_an_oblique_plane_is_found() {
        for degrees in [0.0, 17.0, 45.0, 80.0_f64] {
            let n = Vector([degrees.to_radians().cos(), degrees.to_radians().sin()]);
            let mut cloud = Vec::new();
            for i in -8..8 {
                for j in -8..8 {
                    let x = Vector([f64::from(i), f64::from(j)]) * 0.19 + Vector([0.07, 0.03]);
                    if x.dot(n).abs() > 0.1 && x.norm() < 1.5 {
                        cloud.push(Point { position: x, radius: 0.1, second: x.dot(n) > 0.0 });
                    }
                }
            }
            let interface = separate(&cloud, [true; 2]).unwrap();
            assert!(interface.normal.dot(n) > 0.998, "{degrees}: {:?}", interface.normal);
            assert!((interface.gap - gap(&cloud, n)).abs() < 0.06, "{degrees}: {}", interface.gap);
        }
    }

    /// Two particles: the line between them, and the distance between their faces.
    #[test]
    fn two_points_face_each_other() {
        let a = Vector([0.1, -0.2, 0.3]);
        let b = Vector([0.5, 0.4, -0.1]);
        let cloud =
            [Point { position: a, radius: 0.2, second: false }, Point { position: b, radius: 0.1, second: true }];
        let interface = separate(&cloud, [true; 3]).unwrap();
        let line = (b - a).normalized().unwrap();
        assert!(interface.normal.dot(line) > 1.0 - 1e-6);
        assert!((interface.gap - ((b - a).norm() - 0.3)).abs() < 1e-5);
    }

    /// On a symmetry plane the normal lies in the plane; a single body has no interface.
    #[test]
    fn symmetry_and_absence_are_respected() {
        let point = |x, y, second| Point { position: Vector([x, y]), radius: 0.1, second };
        let cloud = [point(0.5, -0.5, false), point(0.7, 0.5, true)];
        let interface = separate(&cloud, [false, true]).unwrap();
        assert_eq!(interface.normal, Vector([0.0, 1.0]));
        assert!(separate(&cloud[..1], [true; 2]).is_none());
    }
}
