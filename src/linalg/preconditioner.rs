//! Preconditioners of FGMRES, and the rule for replacing them (theory F.15).

use super::border::{Border, BorderForm, PressureCompliance};
use super::direct::{Analysis, Factor};
use super::matrix::BlockMatrix;
use super::options::SolverKind;
use super::pivoted::PivotedFactor;
use super::schur::BlockTriangular;
use super::sparse::{MatrixEntry, SparseFactor, SparseMatrix};

/// Nodes up to which a factorisation is worth its time and memory, in 2D and 3D. In 3D it costs 1.8 times what
/// multigrid does at 1,700 nodes and 6 times at 5,800.
const DIRECT_NODES: [usize; 2] = [400_000, 1_000];

/// Nodes up to which a factorisation helps where nothing else converges, in 2D and 3D.
const LAST_RESORT_NODES: [usize; 2] = [1_000_000, 40_000];

/// Nodes up to which a factorisation with row exchanges is tried, in 2D and 3D.
const PIVOTED_NODES: [usize; 2] = [200_000, 8_000];

/// The methods for so many nodes with B = D + 1 unknowns each, in the order in which they are tried.
pub(super) fn methods<const B: usize>(kind: SolverKind, nodes: usize) -> Vec<Preconditioning> {
    let most = |limits: [usize; 2]| nodes <= limits[usize::from(B > 3)];
    let mut factors = vec![Preconditioning::Single, Preconditioning::Double];
    if most(PIVOTED_NODES) {
        factors.push(Preconditioning::Pivoted);
    }
    match kind {
        SolverKind::Direct => factors,
        SolverKind::Iterative => vec![Preconditioning::Iterative],
        SolverKind::Auto if most(DIRECT_NODES) => [factors, vec![Preconditioning::Iterative]].concat(),
        SolverKind::Auto if most(LAST_RESORT_NODES) => [vec![Preconditioning::Iterative], factors].concat(),
        SolverKind::Auto => vec![Preconditioning::Iterative],
    }
}

/// Methods for systems with a border. The stabilisation that solids need leaves little of the symmetric part
/// (theory J.4): multigrid for the Schur complement comes first in two dimensions, too, and the factor of the whole
/// system next, where its entries are known.
pub(super) fn bordered_methods<const B: usize>(
    kind: SolverKind,
    nodes: usize,
    form: BorderForm,
) -> Vec<Preconditioning> {
    let mut methods = methods::<B>(kind, nodes);
    if let Some(place) = methods.iter().position(|&method| method == Preconditioning::Iterative) {
        methods[..=place].rotate_right(1);
    }
    let pivoted = methods.iter().position(|&method| method == Preconditioning::Pivoted);
    if let Some(place) = pivoted.filter(|_| form == BorderForm::Entries) {
        let first = usize::from(methods[0] == Preconditioning::Iterative);
        methods[first..=place].rotate_right(1);
    }
    methods
}

/// Kinds of approximate inverses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Preconditioning {
    /// Multigrid.
    Iterative,
    /// L D Lᵀ in single precision.
    Single,
    /// L D Lᵀ in double precision.
    Double,
    /// L U with row exchanges, of the whole system where it has a border.
    Pivoted,
}

impl Preconditioning {
    /// All methods, by the numbers that checkpoints have for them.
    const ALL: [Self; 4] = [Self::Iterative, Self::Single, Self::Double, Self::Pivoted];

    /// Number of the method in checkpoints.
    pub fn number(self) -> usize {
        Self::ALL.iter().position(|&method| method == self).unwrap_or(0)
    }

    /// The method with a number; the last one for numbers beyond.
    pub fn numbered(number: usize) -> Self {
        Self::ALL[number.min(Self::ALL.len() - 1)]
    }

    /// True for factors of the symmetric part, which need the analysis of the pattern.
    pub fn symmetric(self) -> bool {
        matches!(self, Self::Single | Self::Double)
    }
}

/// An approximate inverse of one matrix.
pub(super) enum Preconditioner<const B: usize> {
    Blocks(Box<BlockTriangular<B>>),
    Single(Factor<f32>),
    Double(Factor<f64>),
    Pivoted(Box<PivotedFactor>),
    /// Of the matrix on the mesh together with its border.
    Whole(Box<SparseFactor>),
}

impl<const B: usize> Preconditioner<B> {
    /// The preconditioner of a matrix; `None` if the factorisation breaks down.
    pub fn new(
        method: Preconditioning,
        analysis: Option<&Analysis>,
        a: &BlockMatrix<B>,
        border: Option<&dyn Border<B>>,
        compliance: &PressureCompliance,
    ) -> Option<Self> {
        let scaling = a.scaling();
        match (method, analysis) {
            (Preconditioning::Single, Some(analysis)) => Factor::new(analysis, a, &scaling).map(Self::Single),
            (Preconditioning::Double, Some(analysis)) => Factor::new(analysis, a, &scaling).map(Self::Double),
            (Preconditioning::Pivoted, _) => {
                let first = (a.pattern.rows() * B) as u32;
                match border.and_then(|border| border.entries(first)) {
                    Some(entries) => whole_factor(a, entries).map(|factor| Self::Whole(Box::new(factor))),
                    None => PivotedFactor::new(a, &scaling).map(|factor| Self::Pivoted(Box::new(factor))),
                }
            }
            _ => Some(Self::Blocks(Box::new(BlockTriangular::new(a, compliance)))),
        }
    }

    /// Takes a matrix that differs in few rows, as where a solid has moved, if that costs little: with multigrid, whose
    /// coarse levels stay.
    pub fn refresh(&mut self, a: &BlockMatrix<B>, border: &PressureCompliance) {
        if let Self::Blocks(blocks) = self {
            blocks.refresh(a, border);
        }
    }

    /// z ≈ A⁻¹ r.
    pub fn apply(&mut self, analysis: Option<&Analysis>, r: &[[f64; B]], z: &mut [[f64; B]]) {
        match (self, analysis) {
            (Self::Blocks(blocks), _) => blocks.apply(r, z),
            (Self::Pivoted(factor), _) => factor.solve(r, z),
            (Self::Single(factor), Some(analysis)) => factor.solve(analysis, r, z),
            (Self::Double(factor), Some(analysis)) => factor.solve(analysis, r, z),
            // That of the whole system is applied to all of it (`bordered`).
            (Self::Whole(_), _) | (_, None) => z.copy_from_slice(r),
        }
    }
}

/// The factor of a matrix with these entries of its border; `None` where it is singular or too large.
fn whole_factor<const B: usize>(a: &BlockMatrix<B>, mut entries: Vec<MatrixEntry>) -> Option<SparseFactor> {
    let pattern = &a.pattern;
    let rows = entries.iter().fold(pattern.rows() * B, |most, entry| most.max(entry.row as usize + 1));
    for node in 0..pattern.rows() {
        for entry in pattern.row(node) {
            let (block, other) = (&a.values[entry], pattern.columns()[entry] as usize);
            let of =
                |k: usize| MatrixEntry::new((node * B + k / B) as u32, (other * B + k % B) as u32, block[k / B][k % B]);
            entries.extend((0..B * B).map(of));
        }
    }
    SparseFactor::new(&SparseMatrix::from_triplets(rows, entries))
}

/// Decides when a kept preconditioner has cost more than a new one: replacement at the least average cost
/// (theory (F.45)).
///
/// If matrices change so much from one system to the next that a kept preconditioner fails, as with an interface
/// between water and air that crosses elements, keeping one is tried more and more rarely.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct ReusePolicy {
    /// Cost of a new one, in iterations.
    pub price: f64,
    /// Iterations since it was made.
    pub spent: f64,
    /// Systems since it was made.
    pub systems: f64,
    /// The next system gets a new one.
    pub replace: bool,
    /// Number of failures of kept preconditioners in a row.
    pub failures: u32,
    /// Systems to come that get a new one without a trial.
    pub rest: u32,
}

/// Systems, at most, after which keeping a preconditioner is tried again.
const LONGEST_REST: u32 = 64;

impl ReusePolicy {
    /// The policy after a new preconditioner replaced the last one.
    pub fn renewed(self, price: f64) -> Self {
        Self { price, failures: self.failures, rest: self.rest, ..Self::default() }
    }

    /// Counts a kept preconditioner that failed.
    pub fn fail(&mut self) {
        self.failures += 1;
        self.rest = (1 << self.failures.min(6)).min(LONGEST_REST);
        self.replace = true;
    }

    /// Counts a system. Once one costs more than the average so far, the next gets a new preconditioner.
    pub fn count(&mut self, iterations: usize) {
        self.systems += 1.0;
        self.spent += iterations as f64;
        self.replace = self.systems > 1.0 && iterations as f64 > (self.price + self.spent) / self.systems;
        if self.systems > 1.0 {
            self.failures = 0;
        } else if self.rest > 0 {
            self.rest -= 1;
            self.replace = true;
        }
    }

    /// Iterations with a kept preconditioner beyond which it is replaced at once.
    pub fn patience(&self) -> usize {
        let usual = if self.systems > 0.0 { self.spent / self.systems } else { 0.0 };
        (1.5 * usual + self.price + 2.0) as usize
    }
}

/// Number of systems that another method is used for after the usual one failed: 2, 4, … 64, doubled with every failure
/// in a row.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Detour {
    /// Failures of the usual method in a row.
    pub failures: u32,
    /// Systems until it is tried again.
    pub rest: u32,
}

impl Detour {
    /// Counts a failure of the usual method.
    pub fn begin(&mut self) {
        self.failures += 1;
        self.rest = (1 << self.failures.min(6)).min(LONGEST_REST);
    }
}
