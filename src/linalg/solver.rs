//! The solver of a run: chooses the preconditioner, keeps it over steps, and says where it failed (theory F.15).

use super::border::{Border, BorderForm, PressureCompliance};
use super::bordered::{BorderedMatrix, Preconditioned};
use super::coarse::CoarseCorrection;
use super::direct::Analysis;
use super::krylov::{Attempt, Krylov, Limits};
use super::matrix::BlockMatrix;
use super::options::SolverOptions;
use super::pattern::Pattern;
use super::preconditioner::{Detour, Preconditioner, Preconditioning, ReusePolicy, bordered_methods, methods};
use super::solver_state::{CoarseState, SolverCounters, SolverState};
use super::sparse::MatrixEntry;
use super::vectors::{norm, update};
use std::sync::Arc;

/// Report about the solution of one system.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SolveOutcome {
    /// Iterations of FGMRES, with every preconditioner that was tried.
    pub iterations: usize,
    /// |S (b − A x)| / |S b| at the end.
    pub residual: f64,
    /// True if the preconditioner was made anew.
    pub rebuilt: bool,
}

/// The system could not be solved to the tolerance.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("the linear solver stopped at a relative residual of {residual:.3e} after {} iterations", self.iterations())]
pub struct NotConverged {
    /// |S (b − A x)| / |S b| at the end.
    pub residual: f64,
    /// The relative residual at the start and after every iteration, with every preconditioner that was tried.
    pub history: Vec<f64>,
    /// The node with the largest scaled residual.
    pub worst_node: usize,
    /// The unknown of that node: below D a velocity, D the pressure.
    pub worst_unknown: usize,
}

impl NotConverged {
    /// Iterations of FGMRES, with every preconditioner that was tried.
    pub fn iterations(&self) -> usize {
        self.history.len().saturating_sub(1)
    }
}

/// Iterations that a fresh factor in single precision may take; more, and double precision takes over.
const SINGLE_PATIENCE: usize = 10;

/// Iterations that a fresh factor in single precision may take for a system with a border, whose matrix is less
/// symmetric.
const BORDERED_PATIENCE: usize = 80;

/// Iterations that a fresh factor in double precision may take: more, and the part that isn't symmetric rules.
const DOUBLE_PATIENCE: usize = 80;

/// Cost of a new multigrid hierarchy, in iterations.
const HIERARCHY_PRICE: f64 = 8.0;

/// Cost of a new multigrid hierarchy for a system with a border, in iterations, beyond that of a kept one, which takes
/// the finest matrix.
const REFRESHED_PRICE: f64 = 4.5;

/// Cost of a new factor with row exchanges, in iterations.
const PIVOTED_PRICE: f64 = 30.0;

/// Solves system after system on one pattern.
pub struct LinearSolver<const B: usize> {
    pattern: Arc<Pattern>,
    places: Vec<[f64; 3]>,
    options: SolverOptions,
    /// Methods to try, the usual one first.
    methods: Vec<Preconditioning>,
    /// The method in use.
    method: Preconditioning,
    detour: Detour,
    analysis: Option<Analysis>,
    preconditioner: Option<Preconditioner<B>>,
    /// The matrix that the preconditioner was made from.
    source: Option<BlockMatrix<B>>,
    /// Compliance to pressure of the border of the system at hand; none where the preconditioner can't take it.
    compliance: PressureCompliance,
    /// Compliance to pressure of the border of the system of `source`.
    source_compliance: PressureCompliance,
    /// The coarse correction of the border, once there was one.
    coarse: Option<CoarseCorrection<B>>,
    reuse: ReusePolicy,
    krylov: Krylov,
}

impl<const B: usize> LinearSolver<B> {
    /// A solver for matrices on a pattern whose nodes lie at `places` [m].
    pub fn new(pattern: Arc<Pattern>, places: &[[f64; 3]], options: SolverOptions) -> Self {
        let methods = methods::<B>(options.kind, pattern.rows());
        Self {
            places: places.to_vec(),
            options,
            method: methods[0],
            methods,
            detour: Detour::default(),
            analysis: None,
            preconditioner: None,
            source: None,
            compliance: PressureCompliance::default(),
            source_compliance: PressureCompliance::default(),
            coarse: None,
            reuse: ReusePolicy::default(),
            krylov: Krylov::default(),
            pattern,
        }
    }

    /// The systems to come have a border: chooses the methods anew.
    pub fn expect_border(&mut self, form: BorderForm) {
        self.methods = bordered_methods::<B>(self.options.kind, self.pattern.rows(), form);
        self.method = self.methods[0];
    }

    /// Solves A x = b; `x` comes in as the first guess.
    ///
    /// # Errors
    /// The tolerance isn't reached: the residuals, and where the largest one is.
    pub fn solve(
        &mut self,
        a: &BlockMatrix<B>,
        b: &[[f64; B]],
        x: &mut [[f64; B]],
    ) -> Result<SolveOutcome, NotConverged> {
        let scaling = a.scaling();
        let system = BorderedMatrix { a, b: b.as_flattened(), scaling: scaling.as_flattened(), border: None };
        self.solve_flat(system, x.as_flattened_mut())
    }

    /// Solves a bordered system, in which unknowns of another kind are coupled to those of the mesh: `b` and `x` as
    /// above, `border_b` and `border_x` for the unknowns of the border.
    ///
    /// # Errors
    /// As [`LinearSolver::solve`].
    pub fn solve_bordered(
        &mut self,
        a: &BlockMatrix<B>,
        border: &dyn Border<B>,
        b: [&[f64]; 2],
        x: [&mut [f64]; 2],
    ) -> Result<SolveOutcome, NotConverged> {
        let [own, others] = x;
        let mut both = [&*own, &*others].concat();
        let scaling = [a.scaling().as_flattened(), &border.scaling()].concat();
        let system = BorderedMatrix { a, b: &b.concat(), scaling: &scaling, border: Some(border) };
        let outcome = self.solve_flat(system, &mut both);
        own.copy_from_slice(&both[..own.len()]);
        others.copy_from_slice(&both[own.len()..]);
        outcome
    }

    /// Solves a system whose unknowns are `x`: first with the kept preconditioner, if there is one; then with a fresh one
    /// of the same method; then with fresh ones of the other methods, each once. What failed says by `reuse.replace`
    /// that a fresh one is to be made, and from the first of these on all are fresh.
    fn solve_flat(&mut self, system: BorderedMatrix<B>, x: &mut [f64]) -> Result<SolveOutcome, NotConverged> {
        let mut residual = vec![0.0; x.len()];
        let reference = scaled_norm(system.b, system.scaling, &mut residual);
        if reference == 0.0 {
            x.fill(0.0);
            return Ok(SolveOutcome { iterations: 0, residual: 0.0, rebuilt: false });
        }
        let (mut best, mut history, mut failed_methods, mut is_fresh) = (x.to_vec(), Vec::new(), 0, false);
        self.begin(&system);
        loop {
            is_fresh |= self.rebuild_if_needed(&system);
            self.take_up(&system);
            let limits = self.limits(is_fresh, system.border.is_some(), self.options.tolerance * reference);
            let attempt = self.attempt(&system, x, &mut residual, limits);
            // An attempt begins where the one before has ended: its start is no iteration.
            let new = usize::from(!history.is_empty());
            history.extend(attempt.history[new..].iter().map(|r| r / reference));
            if attempt.converged {
                self.count(attempt.history.len() - 1);
                let (iterations, residual) = (history.len() - 1, norm(&residual) / reference);
                return Ok(SolveOutcome { iterations, residual, rebuilt: is_fresh });
            }
            // The next attempt begins with the best so far.
            match norm(&residual) <= attempt.history[0] {
                true => best.copy_from_slice(x),
                false => x.copy_from_slice(&best),
            }
            if !is_fresh {
                self.reuse.fail();
                continue;
            }
            failed_methods += 1;
            self.coarse = None;
            if failed_methods == self.methods.len() {
                self.reuse.replace = true;
                let own = &residual[..system.a.pattern.rows() * B];
                return Err(failure::<B>(history, norm(&residual) / reference, own));
            }
            self.turn_to_next();
        }
    }

    /// Makes a fresh preconditioner, if there is none or the kept one has failed; true if it did.
    fn rebuild_if_needed(&mut self, system: &BorderedMatrix<B>) -> bool {
        let is_needed = self.preconditioner.is_none() || self.reuse.replace;
        if is_needed {
            let price = if system.border.is_some() { REFRESHED_PRICE } else { HIERARCHY_PRICE };
            self.rebuild(system.a, system.border, price);
        }
        is_needed
    }

    /// Chooses the method for a system, and gives the kept preconditioner of one with a border its finest matrix.
    fn begin(&mut self, system: &BorderedMatrix<B>) {
        self.return_to_usual();
        self.compliance = match (&system.border, self.method) {
            (Some(border), Preconditioning::Iterative) => border.compliance(),
            _ => PressureCompliance::default(),
        };
        if let (Some(preconditioner), Some(_), false) = (&mut self.preconditioner, &system.border, self.reuse.replace) {
            preconditioner.refresh(system.a, &self.compliance);
        }
    }

    /// Counts a system that took these iterations with the preconditioner in use.
    fn count(&mut self, iterations: usize) {
        self.reuse.count(iterations);
        if let Some(coarse) = &mut self.coarse {
            coarse.count(iterations);
        }
        self.detour.rest = self.detour.rest.saturating_sub(1);
        // The factor of a whole system isn't in checkpoints, and solids move on.
        self.reuse.replace |= matches!(self.preconditioner, Some(Preconditioner::Whole(_)));
    }

    /// The state to keep in a checkpoint.
    pub fn state(&self) -> SolverState {
        let kept = self.source.as_ref().filter(|_| !self.reuse.replace);
        let entries = || kept.iter().flat_map(|_| &self.source_compliance.entries);
        SolverState {
            values: kept.map_or_else(Vec::new, |a| a.values.as_flattened().as_flattened().to_vec()),
            compliance_places: entries().map(|entry| [entry.row, entry.column]).collect(),
            compliance: entries().map(|entry| entry.value).collect(),
            coarse: self.coarse.as_ref().map_or_else(CoarseState::default, CoarseCorrection::state),
            counters: SolverCounters::new(self.method, &self.reuse, &self.detour),
        }
    }

    /// True if a state is that of a solver with the same pattern, and its counters are possible ones.
    pub fn fits(&self, state: &SolverState) -> bool {
        let coarse = CoarseCorrection::<B>::fits(&state.coarse);
        let places = &state.compliance_places;
        state.counters.are_possible()
            && coarse
            && places.len() == state.compliance.len()
            && places.as_flattened().iter().all(|&node| (node as usize) < self.pattern.rows())
            && places.is_sorted_by_key(|place| place[0])
            && state.compliance.iter().all(|value| value.is_finite())
            && (state.values.is_empty() || state.values.len() == self.pattern.entries() * B * B)
    }

    /// Goes on from the state of a solver with the same pattern and options.
    ///
    /// # Errors
    /// The state belongs to another pattern.
    pub fn restore(&mut self, state: &SolverState) -> Result<(), String> {
        if !self.fits(state) {
            let expected = self.pattern.entries() * B * B;
            let found = state.values.len();
            return Err(format!("a matrix of {found} numbers instead of {expected}, or counters that count nothing"));
        }
        let counters = &state.counters;
        (self.method, self.detour) = (counters.method(), counters.detour());
        self.preconditioner = None;
        if !state.values.is_empty() {
            let values = state.values.as_chunks::<B>().0.as_chunks::<B>().0.to_vec();
            let entries = state.compliance_places.iter().zip(&state.compliance);
            let entries = entries.map(|(&[row, column], &value)| MatrixEntry { row, column, value }).collect();
            self.compliance = PressureCompliance { entries, ..Default::default() };
            self.rebuild(&BlockMatrix { pattern: self.pattern.clone(), values }, None, HIERARCHY_PRICE);
        }
        self.coarse = CoarseCorrection::restored(&state.coarse);
        self.reuse = counters.reuse();
        Ok(())
    }

    fn limits(&self, is_fresh: bool, bordered: bool, target: f64) -> Limits {
        let all = self.options.max_iterations;
        let (iterations, patience) = match (is_fresh, self.method) {
            (false, _) => (self.reuse.patience().min(all), Some(self.reuse.patience())),
            (true, Preconditioning::Single) if bordered => (BORDERED_PATIENCE.min(all), None),
            (true, Preconditioning::Single) => (SINGLE_PATIENCE.min(all), None),
            (true, Preconditioning::Double) if self.methods.len() > 2 => (DOUBLE_PATIENCE.min(all), None),
            (true, _) => (all, None),
        };
        Limits { target, restart: self.options.restart, iterations, patience }
    }

    fn attempt(&mut self, system: &BorderedMatrix<B>, x: &mut [f64], residual: &mut [f64], limits: Limits) -> Attempt {
        let workspace = vec![0.0; x.len()];
        let (analysis, preconditioner) = (self.analysis.as_ref(), self.preconditioner.as_mut());
        let coarse = self.coarse.as_ref();
        let inverse_diagonal = &self.compliance.inverse_diagonal[..];
        let mut system = Preconditioned { system, analysis, preconditioner, coarse, inverse_diagonal, workspace };
        self.krylov.solve(&mut system, x, residual, limits)
    }

    /// Makes the coarse correction ready for the border of a system.
    fn take_up(&mut self, system: &BorderedMatrix<B>) {
        let Some(border) = system.border else { return };
        if matches!(self.preconditioner, Some(Preconditioner::Whole(_))) {
            // It has the whole Schur complement.
            return;
        }
        let own = system.a.pattern.rows() * B;
        let unknowns = system.b.len() - own;
        let is_kept = |coarse: &mut CoarseCorrection<B>| coarse.serves(unknowns) && coarse.take_up(border);
        if !self.coarse.as_mut().is_some_and(is_kept) {
            let (analysis, preconditioner) = (self.analysis.as_ref(), &mut self.preconditioner);
            let mut solve_mesh = |r: &[[f64; B]], x: &mut [[f64; B]]| match preconditioner {
                Some(preconditioner) => preconditioner.apply(analysis, r, x),
                None => x.copy_from_slice(r),
            };
            let mut coarse = CoarseCorrection::new(border, own / B, &self.compliance.inverse_diagonal, &mut solve_mesh);
            coarse.take_up(border);
            self.coarse = Some(coarse);
        }
    }

    /// Makes the preconditioner of a matrix; `hierarchy_price` is the cost of one by multigrid, in iterations.
    fn rebuild(&mut self, a: &BlockMatrix<B>, border: Option<&dyn Border<B>>, hierarchy_price: f64) {
        if self.method.symmetric() && self.analysis.is_none() {
            self.analysis = Analysis::new::<B>(&self.pattern, &self.places);
            if self.analysis.is_none() {
                self.method = Preconditioning::Iterative;
            }
        }
        self.preconditioner = None;
        self.preconditioner = Preconditioner::new(self.method, self.analysis.as_ref(), a, border, &self.compliance);
        self.source_compliance.clone_from(&self.compliance);
        let price = match (self.method, &self.analysis) {
            (Preconditioning::Pivoted, _) => PIVOTED_PRICE,
            (Preconditioning::Iterative, _) | (_, None) => hierarchy_price,
            (_, Some(analysis)) => analysis.price(),
        };
        self.reuse = self.reuse.renewed(price);
        match &mut self.source {
            Some(source) => source.values.copy_from_slice(&a.values),
            None => self.source = Some(a.clone()),
        }
    }

    /// Turns to the method after the one whose fresh preconditioner failed, for this system and some to come. Factors
    /// in single and double precision are of the symmetric part: where the rest rules, the ones behind them take over.
    fn turn_to_next(&mut self) {
        let place = self.methods.iter().position(|&method| method == self.method).unwrap_or(0);
        if place == 0 {
            self.detour.begin();
        }
        self.method = self.methods[(place + 1) % self.methods.len()];
        self.compliance = PressureCompliance::default();
        self.reuse.replace = true;
    }

    /// Turns back to the usual method once others have been in use for long enough.
    fn return_to_usual(&mut self) {
        if self.method == self.methods[0] {
            // It has solved a system since it failed.
            self.detour = Detour::default();
        } else if self.detour.rest == 0 {
            self.method = self.methods[0];
            self.coarse = None;
            self.reuse.replace = true;
        }
    }
}

fn scaled_norm(b: &[f64], scaling: &[f64], work: &mut [f64]) -> f64 {
    update(work, |i, _| scaling[i] * b[i]);
    norm(work)
}

/// The failure with a relative residual at the end, of which `own` are the entries of the mesh.
fn failure<const B: usize>(history: Vec<f64>, residual: f64, own: &[f64]) -> NotConverged {
    let size = |i: usize| if own[i].is_finite() { own[i].abs() } else { f64::INFINITY };
    let worst = (0..own.len()).max_by(|&i, &j| size(i).total_cmp(&size(j)).then(j.cmp(&i))).unwrap_or(0);
    NotConverged { residual, history, worst_node: worst / B, worst_unknown: worst % B }
}
