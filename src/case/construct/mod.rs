//! From a case to a solver: the only place that chooses method and dimension.
//!
//! Everything that is wrong is collected: parts are built as far as they can be, then checked against each
//! other, and only a description without errors becomes a solver.

mod body;
mod flow;
mod membrane;
mod signals;
mod support;
mod traction;

use super::mpm::GridSpec;
use super::resolution::PathResolution;
use super::schema::Method;
use super::summary::CaseSummary;
use super::{Case, Side, Units, check, names};
use crate::error::{Diagnostic, Error, Result, Severity};
use crate::geometry::{Region, Shape};
use crate::math::{Signal, Vector, simd};
use crate::mpm::{GridSetup, Mpm, Obstacle, Setup, Wall};
use crate::simulation::{DrivingFormula, Guarded, Solver};
use signals::TrialPoints;

/// A case that is right: the solver in its first state, and what to say about it.
pub struct Model {
    /// Ready to step.
    pub solver: Box<dyn Solver>,
    /// Sizes, memory, first step.
    pub summary: CaseSummary,
    /// Warnings: the case can be run.
    pub warnings: Vec<Diagnostic>,
}

impl Case {
    /// The solver in its first state.
    ///
    /// # Errors
    /// Everything that is wrong with the case, with its place ([`Error::Case`]).
    pub fn build(&self) -> Result<Box<dyn Solver>> {
        Ok(self.model()?.solver)
    }

    /// The solver in its first state, its summary, and warnings.
    ///
    /// # Errors
    /// Everything that is wrong with the case, with its place ([`Error::Case`]).
    pub fn model(&self) -> Result<Model> {
        if let Some(refusal) = simd::refusal() {
            return Err(Error::case(Diagnostic::error("method", refusal)));
        }
        let result = match (self.file.method, self.file.dimension) {
            (Method::Mpm, 2) => self.mpm::<2>(),
            (Method::Mpm, _) => self.mpm::<3>(),
            (Method::Pfem2, 2) => self.pfem2::<2, 3>(|mesh, base| mesh.as_dyn().triangles(base)),
            (Method::Pfem2, _) => self.pfem2::<3, 4>(|mesh, base| mesh.as_dyn().tetrahedra(base)),
        };
        result.map_err(|mut findings| {
            self.locate(&mut findings);
            findings.sort_by_key(|f| f.span.as_ref().map_or(usize::MAX, |s| s.start));
            Error::Case(findings)
        })
    }

    fn mpm<const D: usize>(&self) -> Result<Model, Vec<Diagnostic>> {
        let mut assembly = Construction::new(self);
        let setup = assembly.mpm_setup::<D>();
        let Construction { mut findings, formulas, .. } = assembly;
        if let Some(setup) = &setup {
            check::parts(self, setup, &mut findings);
        }
        let Some(setup) = setup.filter(|_| !has_errors(&findings)) else { return Err(findings) };
        findings.extend(crate::mpm::check_sides(&setup));
        findings.extend(crate::mpm::proximity::meetings_at_the_start(&setup));
        let domain = self.file.grid.as_ref().map_or([[0.0; 3]; 2], |grid| [grid.lower, grid.upper]);
        let summary = CaseSummary::of_points(&setup, domain);
        let mut solver = match Mpm::new(setup) {
            Ok(solver) => solver,
            Err(more) => {
                findings.extend(more);
                return Err(findings);
            }
        };
        let mut summary = summary.with_solver(&mut solver, &self.file);
        check::steps(self, &summary, &mut findings);
        check::memory(&summary, &mut findings);
        names::files(&self.file, &solver.snapshot(), &mut findings);
        summary.notes.extend(check::probes(&self.file, &solver.snapshot(), domain, &mut findings));
        check::pictures(&self.file, &solver.snapshot(), domain, &mut findings);
        if has_errors(&findings) {
            return Err(findings);
        }
        self.locate(&mut findings);
        Ok(Model { solver: guarded(solver, formulas), summary, warnings: findings })
    }
}

/// A solver with the formulas that drive it, if there are any.
fn guarded(solver: impl Solver + 'static, formulas: Vec<DrivingFormula>) -> Box<dyn Solver> {
    let solver: Box<dyn Solver> = Box::new(solver);
    if formulas.is_empty() { solver } else { Box::new(Guarded::new(solver, formulas)) }
}

fn has_errors(findings: &[Diagnostic]) -> bool {
    findings.iter().any(|f| f.severity == Severity::Error)
}

/// Most cells along an axis: nodes are counted with 32 bits, and have neighbours.
const MOST_CELLS: f64 = 5e8;

/// The extent of the grid along an axis, in cells.
fn extent_in_cells(grid: &GridSpec, axis: usize) -> f64 {
    (grid.upper[axis] - grid.lower[axis]) / grid.cell
}

/// Most nodes along an edge of a wall at which the formulas of its velocity are tried out, in 2D and in 3D.
const TRIED: [usize; 2] = [40_000, 200];

/// Grid nodes on one end of an axis [m]: all of them, or, on a wall that is longer, as many along an edge as are tried,
/// its ends included. The wall may be much longer than the part that the material ever reaches.
fn nodes_of_side(grid: &GridSpec, dimension: usize, axis: usize, upper: bool) -> Vec<Vector<3>> {
    let last = |a: usize| if a == axis || a >= dimension { 0.0 } else { extent_in_cells(grid, a).round().max(0.0) };
    let most = TRIED[usize::from(dimension == 3)];
    let count = |a: usize| (last(a) as usize).saturating_add(1).min(most);
    let side: [usize; 3] = std::array::from_fn(count);
    let node = |n: usize| {
        let ijk = [n % side[0], n / side[0] % side[1], n / side[0] / side[1]];
        Vector::from_fn(|a| {
            let along = (ijk[a] as f64 * last(a) / (side[a] - 1).max(1) as f64).round();
            if a == axis && upper { grid.upper[a] } else { grid.lower[a] + along * grid.cell }
        })
    };
    (0..side.iter().product()).map(node).collect()
}

/// A description in the making.
struct Construction<'c> {
    case: &'c Case,
    findings: Vec<Diagnostic>,
    /// Formulas that depend on the time or on the place.
    formulas: Vec<DrivingFormula>,
    /// Notes for the user on periods and conditions of the solids.
    notes: Vec<String>,
    /// Resolution of each solid along its way, where that can be foreseen.
    paths: Vec<Option<PathResolution>>,
}

impl<'c> Construction<'c> {
    fn new(case: &'c Case) -> Self {
        Self { case, findings: Vec::new(), formulas: Vec::new(), notes: Vec::new(), paths: Vec::new() }
    }
}

impl Construction<'_> {
    /// Notes a finding whose key is relative to `key`.
    fn find(&mut self, key: &str, mut finding: Diagnostic) {
        finding.key = if finding.key.is_empty() { key.to_owned() } else { format!("{key}.{}", finding.key) };
        self.findings.push(finding);
    }

    /// The set-up of `mpm` that the case describes; `None` if something is wrong.
    fn mpm_setup<const D: usize>(&mut self) -> Option<Setup<D>> {
        let file = &self.case.file;
        let grid = self.grid::<D>(file.grid.as_ref()?);
        let bodies: Vec<_> = (0..file.body.len()).filter_map(|i| self.body(i)).collect();
        let membranes: Vec<_> = (0..file.membrane.len()).filter_map(|i| self.membrane(i)).collect();
        let obstacles = (0..file.obstacle.len()).filter_map(|i| self.obstacle(i)).collect();
        let places = bodies.iter().flat_map(|b| &b.position).chain(membranes.iter().flat_map(|m| &m.position));
        let samples = TrialPoints::over(&places.copied().collect::<Vec<_>>(), file.time.end);
        let gravity = self.signals("mpm.gravity", &file.mpm.gravity, &samples);
        let complete = bodies.len() == file.body.len() && membranes.len() == file.membrane.len();
        let mpm = &file.mpm;
        Some(Setup {
            grid: grid.filter(|_| complete)?,
            kernel: mpm.kernel,
            transfer: (&mpm.transfer).into(),
            dissipation: mpm.dissipation.into(),
            stress_update: mpm.stress_update.into(),
            locking: (&mpm.locking).into(),
            safety: mpm.safety,
            membrane_safety: mpm.membrane_safety,
            max_substeps: mpm.max_substeps,
            contact_passes: mpm.contact_passes,
            gravity: std::array::from_fn(|i| gravity[i].clone()),
            bodies,
            membranes,
            obstacles,
            friction: file
                .contact
                .iter()
                .map(|c| (c.between[0].clone(), c.between[1].clone(), c.friction.into()))
                .collect(),
            default_friction: mpm.friction.into(),
            sheet_contact: mpm.sheet_contact.into(),
            gap_tolerance: mpm.gap_tolerance,
        })
    }

    fn grid<const D: usize>(&mut self, grid: &GridSpec) -> Option<GridSetup<D>> {
        let mut cells = [0; D];
        for (axis, count) in cells.iter_mut().enumerate() {
            *count = self.cells(grid, axis)?;
        }
        let walls = std::array::from_fn(|axis| [false, true].map(|upper| self.wall(grid, axis, upper)));
        if D == 2 {
            for (name, wall) in [("front", &grid.walls.front), ("back", &grid.walls.back)] {
                if !matches!(wall, super::WallSpec::Word(super::WallWord::Open)) {
                    let finding = Diagnostic::error(format!("grid.walls.{name}"), "this wall exists in 3D only");
                    self.findings.push(finding.help("in 2D the ends of y are `bottom` and `top`"));
                }
            }
        }
        Some(GridSetup { lower: Vector::from3(grid.lower), cell: grid.cell, cells, walls })
    }

    /// Cells along one axis: a whole number.
    fn cells(&mut self, grid: &GridSpec, axis: usize) -> Option<i32> {
        let (cell, lower, upper) = (grid.cell, grid.lower[axis], grid.upper[axis]);
        let (length, extent) = (upper - lower, extent_in_cells(grid, axis));
        let (count, name) = (extent.round(), ["x", "y", "z"][axis]);
        let (message, help) = if length <= 0.0 {
            let message = format!("`upper` must exceed `lower` along {name}: {upper} m is not above {lower} m");
            (message, "write the lower corner in `lower` and the upper one in `upper`".to_owned())
        } else if count < 1.0 {
            let message = format!("the grid is {length} m long along {name}, less than a cell of {cell} m");
            (message, self.unit_of("take smaller cells, or a larger grid", "one of the two"))
        } else if count > MOST_CELLS {
            let message = format!("{extent:.3e} cells along {name}: a grid of {length} m with cells of {cell} m");
            (message, self.unit_of(&format!("at most {MOST_CELLS:.0e} are possible"), "one of the two"))
        } else if (extent - count).abs() > 1e-6 * count.max(1.0) {
            let nearest = 1e-12 * (1e12 * (lower + count * cell)).round();
            let message = format!("{extent:.6} cells along {name}: not a whole number");
            (message, format!("the nearest upper end is {nearest} m"))
        } else {
            return Some(count as i32);
        };
        self.findings.push(Diagnostic::error(format!("grid.upper[{axis}]"), message).help(help));
        None
    }

    /// Advice with the likely cause: the unit of something, in a case that has units.
    fn unit_of(&self, advice: &str, what: &str) -> String {
        match self.case.file.units {
            Units::SI => format!("{advice}: is the unit of {what} right? a number without a unit is in m"),
            Units::None => advice.to_owned(),
        }
    }

    fn wall(&mut self, grid: &GridSpec, axis: usize, upper: bool) -> Wall {
        let sides = [Side::Left, Side::Right, Side::Front, Side::Back, Side::Bottom, Side::Top];
        let dimension = self.case.file.dimension;
        let side = sides.into_iter().find(|s| s.axis(dimension) == Some((axis, upper)));
        let walls = &grid.walls;
        let (name, spec) = match side {
            Some(Side::Left) | None => ("left", &walls.left),
            Some(Side::Right) => ("right", &walls.right),
            Some(Side::Front) => ("front", &walls.front),
            Some(Side::Back) => ("back", &walls.back),
            Some(Side::Bottom) => ("bottom", &walls.bottom),
            Some(Side::Top) => ("top", &walls.top),
        };
        let (kind, velocity) = spec.parts();
        let samples = TrialPoints::over(&nodes_of_side(grid, dimension, axis, upper), self.case.file.time.end);
        let velocity = self.signals(&format!("grid.walls.{name}.velocity"), &velocity, &samples);
        if !velocity[axis].is_zero() {
            let message = "a wall of the domain stays at the end of the grid: it can only move along itself";
            let finding = Diagnostic::error(format!("grid.walls.{name}.velocity"), message);
            self.findings.push(finding.help("let an `[[obstacle]]` with this velocity push instead"));
        }
        Wall { kind, velocity }
    }

    fn obstacle(&mut self, index: usize) -> Option<Obstacle> {
        let spec = &self.case.file.obstacle[index];
        let key = format!("obstacle[{index}]");
        let grid = self.case.file.grid.as_ref()?;
        let samples = TrialPoints::at(&[grid.lower, grid.upper], self.case.file.time.end);
        let velocity: [Signal; 3] = self.signals(&format!("{key}.velocity"), &spec.velocity, &samples);
        let region = self.region(&format!("{key}.region"), &spec.region)?;
        Some(Obstacle { name: spec.name.clone(), region, kind: spec.wall_kind(), velocity })
    }

    fn region(&mut self, key: &str, shape: &Shape) -> Option<Region> {
        match shape.build(&self.case.source.base, self.case.file.dimension) {
            Ok(region) => Some(region),
            Err(finding) => {
                self.find(key, finding);
                None
            }
        }
    }
}
