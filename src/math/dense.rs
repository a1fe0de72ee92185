//! Small dense systems by elimination.

/// Solves a symmetric positive semi-definite system with the largest pivots first; unknowns whose pivot is below
/// `least_pivot` of the largest diagonal entry have no information, and are zero.
pub(crate) fn solve_semidefinite<const N: usize>(mut a: [[f64; N]; N], mut b: [f64; N], least_pivot: f64) -> [f64; N] {
    let scale = (0..N).map(|i| a[i][i]).fold(0.0, f64::max);
    let mut done = [false; N];
    for _ in 0..N {
        let pivot = (0..N).filter(|&i| !done[i]).max_by(|&i, &j| a[i][i].total_cmp(&a[j][j]));
        let Some(pivot) = pivot.filter(|&i| a[i][i] > least_pivot * scale) else { break };
        done[pivot] = true;
        for row in (0..N).filter(|&row| row != pivot) {
            let (above, factor) = (a[pivot], a[row][pivot] / a[pivot][pivot]);
            a[row].iter_mut().zip(above).for_each(|(entry, above)| *entry -= factor * above);
            b[row] -= factor * b[pivot];
        }
    }
    std::array::from_fn(|i| if done[i] { b[i] / a[i][i] } else { 0.0 })
}

/// Solves a system, whose last column is its right side, by Gauss–Jordan steps with row exchanges; `None` if it is
/// singular.
pub(crate) fn solve(mut rows: Vec<Vec<f64>>) -> Option<Vec<f64>> {
    let n = rows.len();
    for k in 0..n {
        let pivot = (k..n).max_by(|&a, &b| rows[a][k].abs().total_cmp(&rows[b][k].abs()))?;
        rows.swap(k, pivot);
        if rows[k][k] == 0.0 {
            return None;
        }
        for i in (0..n).filter(|&i| i != k) {
            let factor = rows[i][k] / rows[k][k];
            (k..=n).for_each(|j| rows[i][j] -= factor * rows[k][j]);
        }
    }
    Some((0..n).map(|k| rows[k][n] / rows[k][k]).collect())
}

/// The inverse of a symmetric positive semi-definite matrix by Gauss–Jordan steps; rows and columns whose pivot is
/// round-off of their diagonal are zero in it.
pub(crate) fn inverse_of_semidefinite(mut a: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
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

    #[test]
    fn the_inverse_of_a_small_matrix_drops_functions_without_support() {
        let a = vec![vec![4.0, 1.0, 0.0], vec![1.0, 3.0, 0.0], vec![0.0, 0.0, 0.0]];
        let b = inverse_of_semidefinite(a.clone());
        for i in 0..2 {
            for j in 0..2 {
                let product: f64 = (0..3).map(|k| a[i][k] * b[k][j]).sum();
                assert!((product - f64::from(u8::from(i == j))).abs() < 1e-15);
            }
        }
        assert_eq!(b[2], [0.0; 3]);
    }

    /// 2 x + y = 5, x + 3 y = 10: by hand; a third unknown without information is zero.
    #[test]
    fn small_systems_are_solved_as_by_hand() {
        let matrix = [[2.0, 1.0, 0.0], [1.0, 3.0, 0.0], [0.0; 3]];
        let [x, y, z] = solve_semidefinite(matrix, [5.0, 10.0, 0.0], 1e-12);
        assert!((x - 1.0).abs() < 1e-15 && (y - 3.0).abs() < 1e-15 && z == 0.0, "{x} {y} {z}");
        assert_eq!(solve(vec![vec![2.0, 1.0, 5.0], vec![1.0, 3.0, 10.0]]).unwrap(), [1.0, 3.0]);
        assert_eq!(solve(vec![vec![0.0, 1.0, 5.0], vec![2.0, 0.0, 10.0]]).unwrap(), [5.0, 5.0]);
        assert!(solve(vec![vec![1.0, 1.0, 5.0], vec![1.0, 1.0, 10.0]]).is_none());
    }
}
