//! Aggregates of strongly coupled unknowns (Vaněk, Mandel & Brezina 1996).
//!
//! ```text
//! i and j are strongly coupled if  a_ij² > θ² a_ii a_jj
//! ```

use super::csr::Csr;

/// No aggregate: an unknown that is coupled to nothing, which the smoother solves alone.
pub(super) const ALONE: u32 = u32::MAX;

/// Aggregate of each unknown, and their number.
pub(super) struct Aggregates {
    pub of: Vec<u32>,
    pub count: usize,
}

/// The least part of a diagonal after lumping. A node of the heavy one of two fluids is weakly coupled to many of the
/// light one, whose `smooth` is greater by the root of the ratio of densities: their sum may outweigh the diagonal.
const KEPT: f32 = 0.25;

/// The strong part of a matrix; weak entries are lumped to the diagonal such that the product with `smooth` stays
/// the same, as long as that leaves enough of the diagonal.
pub(super) fn strong_part(a: &Csr, diagonal: &[f32], smooth: &[f32], threshold: f32) -> Csr {
    let strong = |i: usize, j: usize, v: f32| v * v > threshold * threshold * (diagonal[i] * diagonal[j]).abs();
    Csr::from_rows(a.rows(), a.width, |i, row| {
        let mut lumped = 0.0;
        for (j, v) in a.row(i) {
            if j == i || strong(i, j, v) {
                row.add(j, v);
            } else {
                lumped += v * smooth[j] / smooth[i];
            }
        }
        let away = (-lumped * diagonal[i].signum()).min((1.0 - KEPT) * diagonal[i].abs());
        row.add(i, -away * diagonal[i].signum());
    })
}

/// Groups each unknown with its strong neighbours: first where all are free, then the rest joins, then new groups.
pub(super) fn aggregate(strong: &Csr) -> Aggregates {
    const FREE: u32 = u32::MAX - 1;
    let n = strong.rows();
    let neighbours = |i: usize| strong.row(i).map(|(j, _)| j).filter(move |&j| j != i);
    let mut of: Vec<u32> = (0..n).map(|i| if neighbours(i).next().is_none() { ALONE } else { FREE }).collect();
    let mut count = 0;
    for i in 0..n {
        if of[i] == FREE && neighbours(i).all(|j| of[j] == FREE) {
            of[i] = count;
            neighbours(i).for_each(|j| of[j] = count);
            count += 1;
        }
    }
    let first_pass = of.clone();
    for i in (0..n).filter(|&i| first_pass[i] == FREE) {
        let strongest = strong
            .row(i)
            .filter(|&(j, _)| j != i && first_pass[j] < FREE)
            .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()).then(b.0.cmp(&a.0)));
        if let Some((j, _)) = strongest {
            of[i] = first_pass[j];
        }
    }
    for i in 0..n {
        if of[i] == FREE {
            of[i] = count;
            neighbours(i).filter(|&j| of[j] == FREE).collect::<Vec<_>>().into_iter().for_each(|j| of[j] = count);
            count += 1;
        }
    }
    Aggregates { of, count: count as usize }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A heavy node (w = 1) among light ones (w = 30), all weakly coupled to it.
    #[test]
    fn lumping_leaves_a_part_of_the_diagonal() {
        let couplings = [(0, 1.0), (1, -0.05), (2, -0.04), (3, 0.01)];
        let a = Csr::from_rows(4, 4, |i, row| match i {
            0 => couplings.iter().for_each(|&(j, v)| row.add(j, v)),
            _ => row.add(i, 1.0),
        });
        let strong = strong_part(&a, &a.diagonal(), &[1.0, 30.0, 30.0, 30.0], 0.06);
        assert_eq!(strong.diagonal()[0], KEPT, "1 − 30 · 0.08 < 0 is too little");
        let mild = strong_part(&a, &a.diagonal(), &[1.0, 2.0, 3.0, 2.0], 0.06);
        assert!((mild.diagonal()[0] - 0.8).abs() < 1e-6, "1 − 0.1 − 0.12 + 0.02");
    }
}
