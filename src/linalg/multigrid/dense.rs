//! The coarsest level: L D Lᵀ of a small dense matrix.

/// A pivot smaller than this part of its diagonal has nothing left: a constant that nothing fixes.
const LEAST_PIVOT: f64 = 1e-6;

/// The factor, row by row; D on the diagonal.
#[derive(Debug, Clone, Default)]
pub(super) struct Dense {
    n: usize,
    factor: Vec<f64>,
}

impl Dense {
    /// The factor of the symmetric matrix with these rows.
    pub fn new(n: usize, mut a: Vec<f64>) -> Self {
        for j in 0..n {
            let original = a[j * n + j];
            let taken: f64 = (0..j).map(|k| a[j * n + k].powi(2) * finite(a[k * n + k])).sum();
            let pivot = original - taken;
            a[j * n + j] = if pivot.abs() > LEAST_PIVOT * original.abs() { pivot } else { f64::INFINITY };
            for i in j + 1..n {
                let taken: f64 = (0..j).map(|k| a[i * n + k] * a[j * n + k] * finite(a[k * n + k])).sum();
                a[i * n + j] = (a[i * n + j] - taken) / a[j * n + j];
            }
        }
        Self { n, factor: a }
    }

    /// True if there is no matrix.
    pub fn is_empty(&self) -> bool {
        self.n == 0
    }

    /// Solves; an unknown without pivot stays zero.
    pub fn solve(&self, b: &[f32], x: &mut [f32]) {
        let (n, l) = (self.n, &self.factor);
        let mut y: Vec<f64> = b.iter().map(|&b| f64::from(b)).collect();
        for i in 0..n {
            y[i] -= (0..i).map(|k| l[i * n + k] * y[k]).sum::<f64>();
        }
        for i in (0..n).rev() {
            y[i] /= l[i * n + i];
            y[i] -= (i + 1..n).map(|k| l[k * n + i] * y[k]).sum::<f64>();
        }
        x.iter_mut().zip(y).for_each(|(x, y)| *x = y as f32);
    }
}

fn finite(pivot: f64) -> f64 {
    if pivot.is_finite() { pivot } else { 0.0 }
}
