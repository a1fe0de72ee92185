//! The coarse correction of a border: its Schur complement on its softest motions (theory (J.10a)).
//!
//! ```text
//! X ← S_t⁻¹ D X  (subspace iteration, orthonormal in D = diag S),   B = D X,   Φ = S_t⁻¹ B,   Φᵀ B = 1
//! C = Φᵀ (S − F Â⁻¹ E − S_t) Φ                                          the added mass, over what resists in the solid
//! S̃ = S_t + B C Bᵀ,   S̃⁻¹ r = y − Y (1 + C BᵀY)⁻¹ C Bᵀ y,   y = S_t⁻¹ r,   Y = S_t⁻¹ B
//! ```
//!
//! B and C, which move with the solids, are kept for some systems, longer than the preconditioner of the mesh where
//! the border moves. Y is that of the system at hand.

use super::border::Border;
use super::vectors::dot;

/// Number of motions at most.
const MOTIONS: usize = 14;

/// Steps of the subspace iteration.
const STEPS: usize = 6;

/// Systems that a correction is kept for.
const LIFE: f64 = 10.0;

/// xᵀ S_t x below this part of what it was before those of the vectors before it were taken out: nothing new.
const NOTHING: f64 = 1e-12;

/// Solves with the preconditioner of a mesh: x ← Â⁻¹ r.
type SolveMesh<'a, const B: usize> = dyn FnMut(&[[f64; B]], &mut [[f64; B]]) + 'a;

/// Rows of a small dense matrix.
type SmallMatrix = Vec<Vec<f64>>;

/// The coarse correction of the border of a system with B unknowns per node.
#[derive(Debug, Clone, Default)]
pub(super) struct CoarseCorrection<const B: usize> {
    /// The columns of B.
    forces: Vec<Vec<f64>>,
    /// C.
    added: SmallMatrix,
    /// Number of systems that it has been used for.
    systems: f64,
    /// The columns of Y, with the velocities of near nodes.
    responses: Vec<BorderResponse<B>>,
    /// (1 + C BᵀY)⁻¹ C.
    weights: SmallMatrix,
}

/// Velocities of near nodes, and those of the border.
#[derive(Debug, Clone)]
struct BorderResponse<const B: usize> {
    near: Vec<[f64; B]>,
    own: Vec<f64>,
}

impl<const B: usize> BorderResponse<B> {
    /// S_t⁻¹ r.
    fn new(border: &mut dyn Border<B>, r: &[f64]) -> Self {
        let mut response = Self { near: vec![[0.0; B]; border.near().len()], own: r.to_vec() };
        border.solve(&mut response.near, &mut response.own);
        response
    }
}

impl<const B: usize> CoarseCorrection<B> {
    /// The correction of a border of a mesh with `nodes` nodes and the preconditioner `solve_mesh`: x ← Â⁻¹ r.
    pub fn new(border: &mut dyn Border<B>, nodes: usize, solve_mesh: &mut SolveMesh<'_, B>) -> Self {
        let (forces, motions) = softest(border);
        let at_rest = vec![[0.0; B]; nodes];
        let mut x = at_rest.clone();
        let mut columns = Vec::new();
        for (motion, force) in motions.iter().zip(&forces) {
            let (mut rows, mut own) = (at_rest.clone(), vec![0.0; motion.len()]);
            border.multiply((&at_rest, motion), (&mut rows, &mut own));
            solve_mesh(&rows, &mut x);
            border.subtract(&x, &mut own);
            own.iter_mut().zip(force).for_each(|(own, force)| *own -= force);
            columns.push(own);
        }
        let added: SmallMatrix =
            motions.iter().map(|motion| columns.iter().map(|column| dot(motion, column)).collect()).collect();
        if added.iter().flatten().any(|entry| !entry.is_finite()) {
            return Self::default();
        }
        Self { forces, added, ..Self::default() }
    }

    /// The correction with a state, [`CoarseCorrection::state`].
    pub fn restored(state: &[f64]) -> Self {
        let [count, systems, rest @ ..] = state else { return Self::default() };
        let count = *count as usize;
        let (added, forces) = rest.split_at(count * count);
        let rows = |all: &[f64]| all.chunks((all.len() / count.max(1)).max(1)).map(<[f64]>::to_vec).collect();
        Self { forces: rows(forces), added: rows(added), systems: *systems, ..Self::default() }
    }

    /// State for a checkpoint: the number of motions, that of systems, C and B.
    pub fn state(&self) -> Vec<f64> {
        let counts = [self.forces.len() as f64, self.systems];
        [&counts[..], &self.added.concat(), &self.forces.concat()].concat()
    }

    /// True for a state that a correction can be restored from.
    pub fn fits(state: &[f64]) -> bool {
        let [count, _, rest @ ..] = state else { return state.is_empty() };
        let square = (*count as usize).saturating_pow(2);
        let possible = (0..=MOTIONS).any(|motions| *count == motions as f64) && rest.len() >= square;
        let whole =
            possible && (rest.len() - square).checked_rem(*count as usize).map_or(rest.is_empty(), |left| left == 0);
        whole && state.iter().all(|number| number.is_finite())
    }

    /// True if it belongs to a border with so many unknowns, and isn't too old.
    pub fn serves(&self, unknowns: usize) -> bool {
        self.systems < LIFE && self.forces.iter().all(|force| force.len() == unknowns)
    }

    /// Takes up the border of a system.
    pub fn take_up(&mut self, border: &mut dyn Border<B>) {
        self.systems += 1.0;
        self.responses = self.forces.iter().map(|force| BorderResponse::new(border, force)).collect();
        let count = self.forces.len();
        let compliance = |i: usize, j: usize| dot(&self.forces[i], &self.responses[j].own);
        let compliances: SmallMatrix = (0..count).map(|i| (0..count).map(|j| compliance(i, j)).collect()).collect();
        let entry = |i: usize, j: usize| {
            let product: f64 = (0..count).map(|k| self.added[i][k] * compliances[k][j]).sum();
            product + f64::from(u8::from(i == j))
        };
        let matrix = (0..count).map(|i| (0..count).map(|j| entry(i, j)).collect()).collect();
        self.weights = solved(matrix, self.added.clone());
    }

    /// Corrects a solution of the border and its near nodes.
    pub fn correct(&self, near: &mut [[f64; B]], own: &mut [f64]) {
        let parts: Vec<f64> = self.forces.iter().map(|force| dot(force, own)).collect();
        for (row, response) in self.weights.iter().zip(&self.responses) {
            let weight: f64 = row.iter().zip(&parts).map(|(a, b)| a * b).sum();
            own.iter_mut().zip(&response.own).for_each(|(y, response)| *y -= weight * response);
            let (near, response) = (near.as_flattened_mut(), response.near.as_flattened());
            near.iter_mut().zip(response).for_each(|(x, response)| *x -= weight * response);
        }
    }
}

/// B and Φ of the softest motions.
fn softest<const B: usize>(border: &mut dyn Border<B>) -> (SmallMatrix, SmallMatrix) {
    let stiffness: Vec<f64> = border.scaling().iter().map(|s| s.powi(-2)).collect();
    let unknowns = stiffness.len();
    let weighted = |x: &[f64]| -> Vec<f64> { x.iter().zip(&stiffness).map(|(x, d)| x * d).collect() };
    let mut motions: SmallMatrix = (0..MOTIONS.min(unknowns)).map(|k| super::modes::start(k, unknowns)).collect();
    let mut forces = Vec::new();
    for _ in 0..STEPS {
        forces = motions.iter().map(|x| weighted(x)).collect();
        motions = forces.iter().map(|force| BorderResponse::new(border, force).own).collect();
        orthonormalise(&mut motions, &mut forces);
    }
    (forces, motions)
}

/// Makes pairs (φ, b = S_t φ) orthonormal, φ_i·b_j = δ_ij, by Gram–Schmidt; what adds nothing to those before it goes.
fn orthonormalise(motions: &mut SmallMatrix, forces: &mut SmallMatrix) {
    let (mut all, mut duals): (SmallMatrix, SmallMatrix) = (Vec::new(), Vec::new());
    for (mut motion, mut force) in motions.drain(..).zip(forces.drain(..)) {
        let before = dot(&motion, &force);
        for _ in 0..2 {
            for (other, dual) in all.iter().zip(&duals) {
                let part = dot(other, &force);
                motion.iter_mut().zip(other).for_each(|(x, y)| *x -= part * y);
                force.iter_mut().zip(dual).for_each(|(x, y)| *x -= part * y);
            }
        }
        let left = dot(&motion, &force);
        if left > NOTHING * before {
            let scale = left.sqrt().recip();
            [&mut motion, &mut force].into_iter().flatten().for_each(|x| *x *= scale);
            all.push(motion);
            duals.push(force);
        }
    }
    (*motions, *forces) = (all, duals);
}

/// A⁻¹ B by elimination with row exchanges; zero where A is singular, so that nothing is corrected.
fn solved(mut a: SmallMatrix, mut b: SmallMatrix) -> SmallMatrix {
    for column in 0..a.len() {
        let largest = (column..a.len()).max_by(|&i, &j| a[i][column].abs().total_cmp(&a[j][column].abs()));
        let Some(pivot) = largest.filter(|&row| a[row][column].abs() > 0.0) else {
            b.iter_mut().flatten().for_each(|b| *b = 0.0);
            return b;
        };
        a.swap(column, pivot);
        b.swap(column, pivot);
        let (own, right) = (a[column].clone(), b[column].clone());
        for row in (0..a.len()).filter(|&row| row != column) {
            let factor = a[row][column] / own[column];
            a[row].iter_mut().zip(&own).for_each(|(x, y)| *x -= factor * y);
            b[row].iter_mut().zip(&right).for_each(|(x, y)| *x -= factor * y);
        }
    }
    for (row, b) in b.iter_mut().enumerate() {
        b.iter_mut().for_each(|b| *b /= a[row][row]);
    }
    b
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_whole_states_are_restored() {
        let state = [2.0, 3.0, 0.1, 0.2, 0.3, 0.4, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
        let restored = CoarseCorrection::<3>::restored(&state);
        assert_eq!(restored.state(), state);
        assert!(CoarseCorrection::<3>::fits(&state) && CoarseCorrection::<3>::fits(&[]));
        assert!(CoarseCorrection::<3>::fits(&CoarseCorrection::<3>::default().state()));
        assert!(restored.serves(3) && !restored.serves(2));
        let altered = |place: usize, value: f64| {
            let mut other = state;
            other[place] = value;
            CoarseCorrection::<3>::fits(&other)
        };
        assert!(![-1.0, 0.0, 1.5, 4.0, 15.0, f64::NAN, f64::INFINITY].iter().any(|&count| altered(0, count)));
        assert!(
            !altered(5, f64::NAN) && !CoarseCorrection::<3>::fits(&state[..11]) && !CoarseCorrection::<3>::fits(&[0.0])
        );
    }

    /// 2 x + y = 5, x + 3 y = 10 and a zero pivot: by hand.
    #[test]
    fn small_systems_are_solved_as_by_hand() {
        assert_eq!(solved(vec![vec![2.0, 1.0], vec![1.0, 3.0]], vec![vec![5.0], vec![10.0]]), [[1.0], [3.0]]);
        assert_eq!(solved(vec![vec![0.0, 1.0], vec![2.0, 0.0]], vec![vec![5.0], vec![10.0]]), [[5.0], [5.0]]);
        assert_eq!(solved(vec![vec![1.0, 1.0], vec![1.0, 1.0]], vec![vec![5.0], vec![10.0]]), [[0.0], [0.0]]);
    }
}
