//! Solids in fluids: supports, place and thickness.

use super::sheets::conflicts;
use crate::case::resolution::{MeshSizes, PathResolution, quadratic, shown};
use crate::case::{Case, SolidSummary};
use crate::error::Diagnostic;
use crate::math::{Signal, Vector};
use crate::mesh::{Locator, Mesh, QuadraticMesh};
use crate::pfem2;
use crate::pfem2::boundary::Boundary;
use crate::pfem2::setup::InitialState;
use crate::pfem2::solid::setup::{HeldNodes, SolidSetup};

/// Elements across the thinnest part of a solid below which it bends too stiffly.
const ACROSS: usize = 2;

/// Elements of the fluid's mesh across the thinnest part of a solid below which the flow on its two sides isn't told
/// apart.
const CELLS_ACROSS: f64 = 3.0;

/// Elements of the fluid's mesh across a solid below which fluid flows through it, between the nodes of the mesh; rounding
/// aside.
const LEAST_CELLS: f64 = 0.99;

/// Largest part of its sides behind which a solid may be thinner: edges and tips are.
const LARGEST_THIN_PART: f64 = 0.25;

impl SolidSummary {
    /// Sizes of a solid in the mesh of the fluid.
    pub(in crate::case) fn new<const D: usize, const N: usize>(
        solid: &SolidSetup<D>,
        background: &Mesh<D, N>,
        locator: &Locator<D>,
        sizes: &MeshSizes,
        path: Option<PathResolution>,
    ) -> Self {
        let mesh = quadratic(solid);
        let thinnest = mesh.thinnest();
        let enclosed: f64 = solid.mesh.inner.iter().map(|(_, volume)| volume).sum();
        let cell = |x: [f64; 3]| sizes.at(background, &locator.search(background, Vector::from3(x))?);
        Self {
            name: solid.name.clone(),
            is_rigid: solid.law.is_rigid(),
            dimension: D,
            elements: mesh.elements.len(),
            nodes: mesh.nodes.len(),
            mass: (mesh.volume() + enclosed) * solid.law.density(),
            thickness: thinnest.length,
            thinnest: thinnest.middle,
            across: thinnest.elements,
            cells_across: cell(thinnest.middle).map(|cell| thinnest.length / cell),
            thin_part: thin_part(&mesh, cell),
            path,
        }
    }
}

/// Part of the sides of a solid behind which it is thinner than an element, of the size `cell` at a place [m]; none where
/// it is outside of the mesh.
fn thin_part(mesh: &QuadraticMesh, cell: impl Fn([f64; 3]) -> Option<f64>) -> f64 {
    let sides = mesh.thicknesses();
    let thin = sides.iter().filter(|side| cell(side.middle).is_some_and(|cell| side.length < LEAST_CELLS * cell));
    thin.count() as f64 / sides.len().max(1) as f64
}

/// Checks the solids of a case of PFEM-2.
pub(in crate::case) fn of_flow<const D: usize, const N: usize>(
    case: &Case,
    setup: &pfem2::Setup<D, N>,
    summaries: &[SolidSummary],
    findings: &mut Vec<Diagnostic>,
) {
    let locator = Locator::new(&setup.mesh);
    let keys: Vec<String> = case.file.solids().into_iter().map(|i| format!("body[{i}]")).collect();
    for ((key, solid), summary) in keys.iter().zip(setup.solid_setups()).zip(summaries) {
        let supports: Vec<_> = solid.held.iter().map(|held| (&held.nodes[..], &held.velocity[..])).collect();
        conflicts(key, solid.mesh.nodes.len(), &supports, findings);
        if !solid.mesh.nodes.iter().any(|&x| locator.search(&setup.mesh, x).is_some()) {
            let message = format!("`{}` lies outside the mesh: no fluid meets it", solid.name);
            let finding = Diagnostic::error(key, message);
            findings.push(finding.help("move its region into the mesh, or enlarge the mesh; are the units right?"));
        }
        thickness(key, summary, findings);
    }
}

/// A start in equilibrium is one at rest, with solids in it.
pub(in crate::case) fn rest<const D: usize, const N: usize>(
    case: &Case,
    setup: &pfem2::Setup<D, N>,
    findings: &mut Vec<Diagnostic>,
) {
    if setup.start == InitialState::AsGiven {
        return;
    }
    if setup.solids.is_none() {
        let finding = Diagnostic::error("pfem2.start", "there is no solid whose equilibrium could be found");
        findings.push(finding.help("take it out: fluids begin as they are given"));
    }
    let at_start = |signal: &Signal, x: [f64; 3]| signal.value(x, 0.0) != 0.0;
    let moving = |held: &HeldNodes<D>, x: &[Vector<D>]| {
        let signals = || held.velocity.iter().flatten();
        held.nodes.iter().any(|&node| signals().any(|signal| at_start(signal, x[node as usize].to3())))
    };
    for (solid, index) in setup.solid_setups().iter().zip(case.file.solids()) {
        if solid.velocity.iter().any(|v| *v != Vector::ZERO) {
            findings.push(in_motion(format!("body[{index}].velocity")));
        }
        let supports = solid.held.iter().enumerate();
        let moving = supports.filter(|(_, held)| moving(held, &solid.mesh.nodes));
        findings.extend(moving.map(|(support, _)| in_motion(format!("body[{index}].supports[{support}]"))));
    }
    if setup.particles.velocity.iter().any(|v| *v != Vector::ZERO) {
        findings.push(in_motion("pfem2.start".into()));
    }
    let boundary = Boundary::new(&setup.mesh, setup.boundaries.clone(), Vector::ZERO);
    if boundary.held(&setup.mesh, 0.0).into_iter().any(|(_, v)| v != Vector::ZERO) {
        findings.push(in_motion("boundary".into()));
    }
}

fn in_motion(key: String) -> Diagnostic {
    let finding = Diagnostic::error(key, "a start in equilibrium is one at rest, but something moves at time 0");
    finding.help("let velocities grow from zero, as `0.1 m/s * ramp(t, 1 s)` does, or take `start` out of `[pfem2]`")
}

fn thickness(key: &str, solid: &SolidSummary, findings: &mut Vec<Diagnostic>) {
    let place = solid.thinnest[..solid.dimension].iter().map(|c| format!("{c:.6}")).collect::<Vec<_>>().join(", ");
    let (name, thin) = (&solid.name, solid.thickness);
    if solid.across < ACROSS && !solid.is_rigid {
        let message = format!(
            "`{name}` has one element across its thinnest part, {thin:.4e} m at ({place}): it bends too stiffly"
        );
        let help = format!("write `mesh = {{ cell = {:.2e} }}`: two elements or more", thin / ACROSS as f64);
        findings.push(Diagnostic::warning(format!("{key}.mesh"), message).help(help));
    }
    if solid.thin_part > LARGEST_THIN_PART {
        findings.push(too_thin(key, solid, &place));
    } else if let Some(cells) = solid.cells_across.filter(|&cells| is_coarse(cells)) {
        let message = format!(
            "`{name}` is {thin:.4e} m thick at ({place}), {cells:.1} elements of the mesh: the flow on its two sides is hardly told apart"
        );
        let help = format!(
            "let elements of {:.2e} m or smaller lie where it is and where it comes to: `[[mesh.refine]]`",
            thin / CELLS_ACROSS
        );
        findings.push(Diagnostic::warning(key.to_owned(), message).help(help));
    } else if let Some(path) = solid.path.filter(|path| is_coarse(path.cells)) {
        findings.push(coarse_path(key, solid, &path));
    }
}

/// A solid that is thinner than an element, not at its edges alone.
fn too_thin(key: &str, solid: &SolidSummary, place: &str) -> Diagnostic {
    let message = format!(
        "`{}` is thinner than an element of the mesh behind {:.0} % of its surface, {:.4e} m at ({place}): fluid would flow \
         through it",
        solid.name,
        100.0 * solid.thin_part,
        solid.thickness
    );
    let help = format!(
        "let elements of {:.2e} m or smaller lie where it is and where it comes to, `[[mesh.refine]]`: as large as it is thick \
         at most, better a third of it; or make it n times as thick, with a density n times and a Young's modulus n³ times \
         as small, which bends and weighs the same",
        solid.thickness / CELLS_ACROSS
    );
    Diagnostic::error(key.to_owned(), message).help(help)
}

/// Fewer elements than three, as they are shown.
fn is_coarse(cells: f64) -> bool {
    cells + 0.05 < CELLS_ACROSS
}

fn coarse_path(key: &str, solid: &SolidSummary, path: &PathResolution) -> Diagnostic {
    let at = |place| shown(place, solid.dimension);
    let message = format!(
        "`{}` is likely to come to ({}), where {:.1} elements of the mesh lie across its {:.1e} m: the flow on its two sides is hardly \
         told apart there",
        solid.name,
        at(path.place),
        path.cells,
        path.thickness
    );
    let help = format!(
        "let elements of {:.1e} m or smaller lie in all that it may sweep, from ({}) to ({}): `[[mesh.refine]]`; the estimate is a large one",
        path.thickness / CELLS_ACROSS,
        at(path.swept[0]),
        at(path.swept[1])
    );
    Diagnostic::warning(key.to_owned(), message).help(help)
}
