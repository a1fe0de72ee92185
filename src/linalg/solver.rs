//! The solver of a run: chooses the preconditioner, keeps it over steps, and says where it failed.

use super::direct::Analysis;
use super::krylov::{Attempt, Krylov, Limits, System};
use super::matrix::BlockMatrix;
use super::pattern::Pattern;
use super::preconditioner::{Detour, Method, Preconditioner, ReusePolicy, methods};
use super::vectors::{norm, update};
use std::sync::Arc;

/// Which preconditioner.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Kind {
    /// By dimension and size; another one where the first fails.
    #[default]
    Auto,
    /// A factorisation; with row exchanges where that of the symmetric part fails.
    Direct,
    /// Multigrid.
    Iterative,
}

/// How to solve, and how well.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Which preconditioner.
    pub kind: Kind,
    /// |S (b − A x)| to reach, relative to |S b|; S scales the diagonal to ±1.
    pub tolerance: f64,
    /// Iterations before giving up.
    pub max_iterations: usize,
    /// Vectors kept before a restart.
    pub restart: usize,
}

impl Default for Options {
    fn default() -> Self {
        Self { kind: Kind::Auto, tolerance: 1e-8, max_iterations: 300, restart: 40 }
    }
}

/// How a system was solved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outcome {
    /// Iterations of FGMRES, with every preconditioner that was tried.
    pub iterations: usize,
    /// |S (b − A x)| / |S b| at the end.
    pub residual: f64,
    /// True if the preconditioner was made anew.
    pub rebuilt: bool,
}

/// The system could not be solved to the tolerance.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("the linear solver stopped at a relative residual of {residual:.3e} after {} iterations", history.len())]
pub struct NotConverged {
    /// |S (b − A x)| / |S b| at the end.
    pub residual: f64,
    /// The same at the start and after every iteration.
    pub history: Vec<f64>,
    /// The node with the largest scaled residual.
    pub worst_node: usize,
    /// Its unknown: below D a velocity, D the pressure.
    pub worst_unknown: usize,
}

/// Iterations that a fresh factor in single precision may take; more, and double precision takes over.
const SINGLE_PATIENCE: usize = 10;

/// Iterations that a fresh factor in double precision may take: more, and the part that isn't symmetric rules.
const DOUBLE_PATIENCE: usize = 80;

/// Cost of a new multigrid hierarchy, in iterations.
const HIERARCHY_PRICE: f64 = 8.0;

/// Cost of a new factor with row exchanges, in iterations.
const PIVOTED_PRICE: f64 = 30.0;

/// Solves system after system on one pattern.
pub struct LinearSolver<const B: usize> {
    pattern: Arc<Pattern>,
    places: Vec<[f64; 3]>,
    options: Options,
    /// Methods to try, the usual one first.
    methods: Vec<Method>,
    /// The one in use.
    method: Method,
    detour: Detour,
    analysis: Option<Analysis>,
    preconditioner: Option<Preconditioner<B>>,
    /// The matrix that the preconditioner was made from.
    source: Option<BlockMatrix<B>>,
    wear: ReusePolicy,
    krylov: Krylov,
}

/// State that a solver carries from one system to the next: with it a resumed run repeats the same bits.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SolverState {
    /// The matrix of the kept preconditioner, entry by entry; empty if none is kept.
    pub values: Vec<f64>,
    /// How it is used: method, price, iterations spent, systems solved, whether the next one is new, failures, rest; failures
    /// of the usual method, systems until it is tried again.
    pub counters: [f64; 9],
}

impl<const B: usize> LinearSolver<B> {
    /// For a pattern whose nodes lie at `places` [m].
    pub fn new(pattern: Arc<Pattern>, places: &[[f64; 3]], options: Options) -> Self {
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
            wear: ReusePolicy::default(),
            krylov: Krylov::default(),
            pattern,
        }
    }

    /// Solves A x = b; `x` comes in as the first guess.
    ///
    /// # Errors
    /// The tolerance isn't reached: the residuals, and where the largest one is.
    pub fn solve(&mut self, a: &BlockMatrix<B>, b: &[[f64; B]], x: &mut [[f64; B]]) -> Result<Outcome, NotConverged> {
        let scaling = a.scaling();
        let mut residual = vec![[0.0; B]; x.len()];
        let reference = scaled_norm(b, &scaling, &mut residual);
        if reference == 0.0 {
            x.fill([0.0; B]);
            return Ok(Outcome { iterations: 0, residual: 0.0, rebuilt: false });
        }
        let guess = x.to_vec();
        let mut history = Vec::new();
        let (mut iterations, mut failed) = (0, 0);
        let mut fresh = false;
        self.return_to_usual();
        loop {
            if self.preconditioner.is_none() || self.wear.replace {
                self.rebuild(a);
                fresh = true;
            }
            let limits = self.limits(fresh, self.options.tolerance * reference);
            let attempt = self.attempt(a, b, &scaling, x, &mut residual, limits);
            iterations += attempt.history.len() - 1;
            history.extend(attempt.history.iter().map(|r| r / reference));
            if attempt.converged {
                self.wear.count(attempt.history.len() - 1);
                self.detour.rest = self.detour.rest.saturating_sub(1);
                let residual = norm(residual.as_flattened()) / reference;
                return Ok(Outcome { iterations, residual, rebuilt: fresh });
            }
            if !norm(residual.as_flattened()).is_finite() {
                // What comes next begins where this began.
                x.copy_from_slice(&guess);
            }
            if !fresh {
                self.wear.fail();
                continue;
            }
            failed += 1;
            if failed == self.methods.len() {
                self.wear.replace = true;
                return Err(failure(history, &residual, reference));
            }
            self.turn_to_next();
        }
    }

    /// The state to keep in a checkpoint.
    pub fn memory(&self) -> SolverState {
        let method = Method::ALL.iter().position(|&method| method == self.method);
        let kept = self.source.as_ref().filter(|_| !self.wear.replace);
        SolverState {
            values: kept.map_or_else(Vec::new, |a| a.values.as_flattened().as_flattened().to_vec()),
            counters: [
                method.unwrap_or(0) as f64,
                self.wear.price,
                self.wear.spent,
                self.wear.systems,
                f64::from(u8::from(self.wear.replace)),
                f64::from(self.wear.failures),
                f64::from(self.wear.rest),
                f64::from(self.detour.failures),
                f64::from(self.detour.rest),
            ],
        }
    }

    /// True if a memory is of a solver with the same pattern, and its counters are such.
    pub fn fits(&self, memory: &SolverState) -> bool {
        let [method, price, spent, systems, replace, failures, rest, detours, detour] = memory.counters;
        let counts = [method, failures, rest, detours, detour];
        let counted = counts.iter().all(|count| (0.0..=f64::from(u32::MAX / 2)).contains(count));
        let summed = [price, spent, systems, replace].iter().all(|sum| *sum >= 0.0);
        counted && summed && (memory.values.is_empty() || memory.values.len() == self.pattern.entries() * B * B)
    }

    /// Goes on from the memory of a solver with the same pattern and options.
    ///
    /// # Errors
    /// The memory belongs to another pattern.
    pub fn restore(&mut self, memory: &SolverState) -> Result<(), String> {
        if !self.fits(memory) {
            let expected = self.pattern.entries() * B * B;
            let found = memory.values.len();
            return Err(format!("a matrix of {found} numbers instead of {expected}, or counters that count nothing"));
        }
        let [method, price, spent, systems, replace, failures, rest, detours, detour] = memory.counters;
        self.method = Method::ALL[(method as usize).min(Method::ALL.len() - 1)];
        self.detour = Detour { failures: detours as u32, rest: detour as u32 };
        self.preconditioner = None;
        if !memory.values.is_empty() {
            let values = memory.values.as_chunks::<B>().0.as_chunks::<B>().0.to_vec();
            self.rebuild(&BlockMatrix { pattern: self.pattern.clone(), values });
        }
        self.wear = ReusePolicy {
            price,
            spent,
            systems,
            replace: replace != 0.0,
            failures: failures as u32,
            rest: rest as u32,
        };
        Ok(())
    }

    fn limits(&self, fresh: bool, target: f64) -> Limits {
        let all = self.options.max_iterations;
        let (iterations, patience) = match (fresh, self.method) {
            (false, _) => (self.wear.patience().min(all), Some(self.wear.patience())),
            (true, Method::Single) => (SINGLE_PATIENCE.min(all), None),
            (true, Method::Double) if self.methods.len() > 2 => (DOUBLE_PATIENCE.min(all), None),
            (true, _) => (all, None),
        };
        Limits { target, restart: self.options.restart, iterations, patience }
    }

    fn attempt(
        &mut self,
        a: &BlockMatrix<B>,
        b: &[[f64; B]],
        scaling: &[[f64; B]],
        x: &mut [[f64; B]],
        residual: &mut [[f64; B]],
        limits: Limits,
    ) -> Attempt {
        let room = vec![[0.0; B]; x.len()];
        let (analysis, preconditioner) = (self.analysis.as_ref(), self.preconditioner.as_mut());
        let mut system = Preconditioned { a, b, scaling, analysis, preconditioner, room };
        self.krylov.solve(&mut system, x.as_flattened_mut(), residual.as_flattened_mut(), limits)
    }

    fn rebuild(&mut self, a: &BlockMatrix<B>) {
        if self.method.symmetric() && self.analysis.is_none() {
            self.analysis = Analysis::new::<B>(&self.pattern, &self.places);
            if self.analysis.is_none() {
                self.method = Method::Iterative;
            }
        }
        self.preconditioner = None;
        self.preconditioner = Preconditioner::new(self.method, self.analysis.as_ref(), a);
        let price = match (self.method, &self.analysis) {
            (Method::Pivoted, _) => PIVOTED_PRICE,
            (Method::Iterative, _) | (_, None) => HIERARCHY_PRICE,
            (_, Some(analysis)) => analysis.price(),
        };
        self.wear = self.wear.renewed(price);
        match &mut self.source {
            Some(source) => source.values.copy_from_slice(&a.values),
            None => self.source = Some(a.clone()),
        }
    }

    /// Turns to the method after the one whose fresh preconditioner failed, for this system and some to come. Factors in
    /// single and double precision are of the symmetric part: where the rest rules, the ones behind them take over.
    fn turn_to_next(&mut self) {
        let place = self.methods.iter().position(|&method| method == self.method).unwrap_or(0);
        if place == 0 {
            self.detour.begin();
        }
        self.method = self.methods[(place + 1) % self.methods.len()];
        self.wear.replace = true;
    }

    /// Turns back to the usual method once others have been in use for long enough.
    fn return_to_usual(&mut self) {
        if self.method == self.methods[0] {
            // It has solved a system since it failed.
            self.detour = Detour::default();
        } else if self.detour.rest == 0 {
            self.method = self.methods[0];
            self.wear.replace = true;
        }
    }
}

fn scaled_norm<const B: usize>(b: &[[f64; B]], scaling: &[[f64; B]], work: &mut [[f64; B]]) -> f64 {
    let (b, s) = (b.as_flattened(), scaling.as_flattened());
    update(work.as_flattened_mut(), |i, _| s[i] * b[i]);
    norm(work.as_flattened())
}

fn failure<const B: usize>(history: Vec<f64>, residual: &[[f64; B]], reference: f64) -> NotConverged {
    let flat = residual.as_flattened();
    let size = |i: usize| if flat[i].is_finite() { flat[i].abs() } else { f64::INFINITY };
    let worst = (0..flat.len()).max_by(|&i, &j| size(i).total_cmp(&size(j)).then(j.cmp(&i))).unwrap_or(0);
    NotConverged { residual: norm(flat) / reference, history, worst_node: worst / B, worst_unknown: worst % B }
}

/// The scaled system with its preconditioner.
struct Preconditioned<'a, const B: usize> {
    a: &'a BlockMatrix<B>,
    b: &'a [[f64; B]],
    scaling: &'a [[f64; B]],
    analysis: Option<&'a Analysis>,
    preconditioner: Option<&'a mut Preconditioner<B>>,
    room: Vec<[f64; B]>,
}

impl<const B: usize> System for Preconditioned<'_, B> {
    fn multiply(&self, x: &[f64], y: &mut [f64]) {
        self.a.multiply(x.as_chunks().0, y.as_chunks_mut().0);
        let s = self.scaling.as_flattened();
        update(y, |i, y| s[i] * y);
    }

    fn residual(&self, x: &[f64], r: &mut [f64]) {
        self.a.multiply(x.as_chunks().0, r.as_chunks_mut().0);
        let (s, b) = (self.scaling.as_flattened(), self.b.as_flattened());
        update(r, |i, ax| s[i] * (b[i] - ax));
    }

    fn precondition(&mut self, r: &[f64], z: &mut [f64]) {
        let s = self.scaling.as_flattened();
        let room = self.room.as_flattened_mut();
        update(room, |i, _| r[i] / s[i]);
        match &mut self.preconditioner {
            Some(preconditioner) => preconditioner.apply(self.analysis, &self.room, z.as_chunks_mut().0),
            None => z.copy_from_slice(room),
        }
    }
}
