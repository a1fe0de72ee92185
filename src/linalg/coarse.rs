//! The coarse correction of a border: its Schur complement on its softest motions (theory (J.10a)).
//!
//! ```text
//! X ← S_t⁻¹ D X  (subspace iteration, orthonormal in D = diag S),   B = D X,   Φ = S_t⁻¹ B,   Φᵀ B = 1
//! W = −F_p (Â⁻¹)_pp E_p (1 − D̂⁻¹ S) Φ,   C = Φᵀ W                                   forces by the pressure of motions: the added mass
//! C = V Λ Vᵀ,   W ← W V                                                  ordered by what the added mass is over what resists in the solid
//! S̃ = S_t + W Λ⁻¹ Wᵀ,   S̃⁻¹ r = y − Y (Λ + WᵀY)⁻¹ Wᵀ y,   y = S_t⁻¹ r,   Y = S_t⁻¹ W
//! ```
//!
//! On the motions Φ this is the added mass, and on others never more than it (Nyström's approximation, as the added
//! mass is symmetric and not negative). Where λ is small there is nothing to correct. W and Λ, which move with the
//! solids, are kept by the rule for preconditioners, (F.45). Y is that of the system at hand.

use super::border::{Border, BorderedRows, BorderedVector, NearAndBorder};
use super::modes::diagonalise;
use super::preconditioner::ReusePolicy;
use super::solver_state::{CoarseCounters, CoarseState, KEPT, REPLACED};
use super::vectors::{dot, start_vector};

/// Number of motions at most.
const MOTIONS: usize = 14;

/// Steps of the subspace iteration.
const STEPS: usize = 6;

/// Part by which trace(WᵀY) may differ from that of the first system: beyond, the step or the stiffness is another.
const TRACE_CHANGE_ALLOWED: f64 = 0.25;

/// Least λ of a motion that is corrected: below, the preconditioned eigenvalue 1 + λ is near enough to 1, and Λ⁻¹ would
/// magnify errors of Â⁻¹.
const LEAST_ADDED_MASS: f64 = 0.1;

/// A vector depends linearly on those before it if orthogonalisation leaves less than this part of its xᵀ S_t x.
const DEPENDENT: f64 = 1e-12;

/// Solves with the preconditioner of a mesh: x ← Â⁻¹ r.
type SolveMesh<'a, const B: usize> = dyn FnMut(&[[f64; B]], &mut [[f64; B]]) + 'a;

/// Rows of a small dense matrix.
type SmallMatrix = Vec<Vec<f64>>;

/// The coarse correction of the border of a system with B unknowns per node.
#[derive(Debug, Clone, Default)]
pub(super) struct CoarseCorrection<const B: usize> {
    /// The columns of W.
    forces: Vec<Vec<f64>>,
    /// The diagonal of Λ.
    added: Vec<f64>,
    /// trace(WᵀY) of the first system, 0 before it.
    compliance: f64,
    /// Use of the correction.
    reuse: ReusePolicy,
    /// The columns of Y, with the velocities of near nodes.
    responses: Vec<NearAndBorder<B>>,
    /// (Λ + WᵀY)⁻¹.
    weights: SmallMatrix,
}

/// S_t⁻¹ r of forces on a border.
fn responses<const B: usize>(border: &dyn Border<B>, forces: &[Vec<f64>]) -> Vec<NearAndBorder<B>> {
    let at_rest = vec![[0.0; B]; border.near().len()];
    let side = |force: &Vec<f64>| NearAndBorder { near: at_rest.clone(), border: force.clone() };
    let mut sides: Vec<_> = forces.iter().map(side).collect();
    border.solve(&mut sides);
    sides
}

impl<const B: usize> CoarseCorrection<B> {
    /// The correction of a border of a mesh with `nodes` nodes and the preconditioner `solve_mesh`: x ← Â⁻¹ r.
    /// `inverse_diagonal` is 1/D̂ where that has the compliance of the border, and else empty.
    pub fn new(
        border: &dyn Border<B>,
        nodes: usize,
        inverse_diagonal: &[f64],
        solve_mesh: &mut SolveMesh<'_, B>,
    ) -> Self {
        let motions = softest(border);
        let at_rest = vec![[0.0; B]; nodes];
        let mut x = at_rest.clone();
        let mut force_on = |motion: &Vec<f64>| {
            let (mut rows, mut force) = (at_rest.clone(), vec![0.0; motion.len()]);
            let moving = BorderedVector { mesh: &at_rest, border: motion };
            border.multiply(moving, BorderedRows { mesh: &mut rows, border: &mut force });
            let answer = |k: usize| inverse_diagonal.get(k).map_or(0.0, |inverse| inverse * force[k]);
            let rest: Vec<f64> = motion.iter().enumerate().map(|(k, x)| x - answer(k)).collect();
            rows.fill([0.0; B]);
            border.add_to_continuity(&rest, &mut rows);
            solve_mesh(&rows, &mut x);
            x.iter_mut().for_each(|x| x[..B - 1].fill(0.0));
            force.fill(0.0);
            border.subtract(&x, &mut force);
            force
        };
        let mut forces: Vec<Vec<f64>> = motions.iter().map(&mut force_on).collect();
        let half = |i: usize, j: usize| 0.5 * dot(&motions[i], &forces[j]);
        let mut added = small_matrix(forces.len(), |i, j| half(i, j) + half(j, i));
        if added.iter().flatten().any(|entry| !entry.is_finite()) {
            return Self::default();
        }
        diagonalise(&mut added, &mut forces);
        let all = forces.into_iter().enumerate().map(|(k, force)| (added[k][k], force));
        let (added, forces): (Vec<f64>, Vec<Vec<f64>>) = all.filter(|(added, _)| *added > LEAST_ADDED_MASS).unzip();
        // A motion costs an application of the preconditioner of the mesh.
        let reuse = ReusePolicy::default().renewed(motions.len() as f64);
        Self { forces, added, reuse, ..Self::default() }
    }

    /// The correction of a state, [`CoarseCorrection::state`]; none if there was none.
    pub fn restored(state: &CoarseState) -> Option<Self> {
        let CoarseState { counters, added_mass, forces } = state;
        let CoarseCounters { made, compliance, price, spent, systems, replacement } = *counters;
        let unknowns = (forces.len() / added_mass.len().max(1)).max(1);
        let forces = forces.chunks(unknowns).map(<[f64]>::to_vec).collect();
        let replace = replacement != KEPT;
        let reuse = ReusePolicy { spent, systems, replace, ..ReusePolicy::default().renewed(price) };
        (made != 0.0).then(|| Self { forces, added: added_mass.clone(), compliance, reuse, ..Self::default() })
    }

    /// The state for a checkpoint.
    pub fn state(&self) -> CoarseState {
        let ReusePolicy { price, spent, systems, replace, .. } = self.reuse;
        let replacement = if replace { REPLACED } else { KEPT };
        let counters = CoarseCounters { made: 1.0, compliance: self.compliance, price, spent, systems, replacement };
        CoarseState { counters, added_mass: self.added.clone(), forces: self.forces.concat() }
    }

    /// True for a state that a correction can be restored from.
    pub fn fits(state: &CoarseState) -> bool {
        let CoarseState { counters, added_mass, forces } = state;
        let CoarseCounters { made, compliance, price, spent, systems, replacement } = *counters;
        let motions = added_mass.len();
        let is_whole = forces.len().checked_rem(motions).map_or(forces.is_empty(), |left| left == 0);
        let is_possible = made == 1.0 && motions <= MOTIONS && is_whole;
        (is_possible || *state == CoarseState::default())
            && [price, spent, systems].iter().all(|sum| *sum >= 0.0)
            && [compliance, price, spent, systems, replacement].iter().all(|number| number.is_finite())
            && added_mass.iter().chain(forces).all(|number| number.is_finite())
    }

    /// True if it belongs to a border with so many unknowns, and hasn't cost more than a new one.
    pub fn serves(&self, unknowns: usize) -> bool {
        !self.reuse.replace && self.forces.iter().all(|force| force.len() == unknowns)
    }

    /// Counts a system that took these iterations.
    pub fn count(&mut self, iterations: usize) {
        self.reuse.count(iterations);
    }

    /// Takes up the border of a system; false if that is one of another step or stiffness than it was made for.
    pub fn take_up(&mut self, border: &dyn Border<B>) -> bool {
        self.responses = responses(border, &self.forces);
        let count = self.forces.len();
        let compliances = small_matrix(count, |i, j| dot(&self.forces[i], &self.responses[j].border));
        let trace: f64 = (0..count).map(|i| compliances[i][i]).sum();
        if self.reuse.systems == 0.0 && self.compliance == 0.0 {
            self.compliance = trace;
        }
        let unit = |i: usize, j: usize| f64::from(u8::from(i == j));
        let sum = |i: usize, j: usize| self.added[i] * unit(i, j) + compliances[i][j];
        self.weights = solved(small_matrix(count, sum), small_matrix(count, unit));
        (trace - self.compliance).abs() <= TRACE_CHANGE_ALLOWED * self.compliance.abs()
    }

    /// Corrects a solution of the border and its near nodes.
    pub fn correct(&self, motion: &mut NearAndBorder<B>) {
        let parts: Vec<f64> = self.forces.iter().map(|force| dot(force, &motion.border)).collect();
        for (row, response) in self.weights.iter().zip(&self.responses) {
            let weight: f64 = row.iter().zip(&parts).map(|(a, b)| a * b).sum();
            motion.border.iter_mut().zip(&response.border).for_each(|(y, response)| *y -= weight * response);
            let (near, response) = (motion.near.as_flattened_mut(), response.near.as_flattened());
            near.iter_mut().zip(response).for_each(|(x, response)| *x -= weight * response);
        }
    }
}

/// The square matrix with these entries.
fn small_matrix(rows: usize, entry: impl Fn(usize, usize) -> f64) -> SmallMatrix {
    (0..rows).map(|i| (0..rows).map(|j| entry(i, j)).collect()).collect()
}

/// Φ, the softest motions.
fn softest<const B: usize>(border: &dyn Border<B>) -> SmallMatrix {
    let stiffness: Vec<f64> = border.scaling().iter().map(|s| s.powi(-2)).collect();
    let unknowns = stiffness.len();
    let weighted = |x: &[f64]| -> Vec<f64> { x.iter().zip(&stiffness).map(|(x, d)| x * d).collect() };
    let mut motions: SmallMatrix = (0..MOTIONS.min(unknowns)).map(|k| start_vector(k, unknowns)).collect();
    for _ in 0..STEPS {
        let mut forces: SmallMatrix = motions.iter().map(|x| weighted(x)).collect();
        motions = responses(border, &forces).into_iter().map(|response| response.border).collect();
        orthonormalise(&mut motions, &mut forces);
    }
    motions
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
        if left > DEPENDENT * before {
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
        type Correction = CoarseCorrection<3>;
        let counters =
            CoarseCounters { made: 1.0, compliance: 0.7, price: 14.0, spent: 30.0, systems: 3.0, replacement: KEPT };
        let forces = vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
        let state = CoarseState { counters, added_mass: vec![0.1, 0.2], forces };
        let restored = Correction::restored(&state).unwrap();
        assert_eq!(restored.state(), state);
        assert!(restored.serves(3) && !restored.serves(2));
        assert!(Correction::restored(&CoarseState::default()).is_none());
        let without_motions = Correction::default().state();
        assert!([&state, &CoarseState::default(), &without_motions].into_iter().all(Correction::fits));
        let altered = |alter: fn(&mut CoarseState)| {
            let mut other = state.clone();
            alter(&mut other);
            Correction::fits(&other)
        };
        assert!(!altered(|state| state.counters.made = 0.0) && !altered(|state| state.counters.made = f64::NAN));
        assert!(
            !altered(|state| state.counters.spent = -1.0) && !altered(|state| state.counters.price = f64::INFINITY)
        );
        assert!(!altered(|state| state.counters.compliance = f64::NAN) && !altered(|state| state.forces[2] = f64::NAN));
        assert!(!altered(|state| state.forces.truncate(5)) && !altered(|state| state.added_mass.clear()));
        assert!(!altered(|state| state.added_mass = vec![0.1; 15]));
    }

    /// 2 x + y = 5, x + 3 y = 10 and a zero pivot: by hand.
    #[test]
    fn small_systems_are_solved_as_by_hand() {
        assert_eq!(solved(vec![vec![2.0, 1.0], vec![1.0, 3.0]], vec![vec![5.0], vec![10.0]]), [[1.0], [3.0]]);
        assert_eq!(solved(vec![vec![0.0, 1.0], vec![2.0, 0.0]], vec![vec![5.0], vec![10.0]]), [[5.0], [5.0]]);
        assert_eq!(solved(vec![vec![1.0, 1.0], vec![1.0, 1.0]], vec![vec![5.0], vec![10.0]]), [[0.0], [0.0]]);
    }
}
