//! Warnings about cases that can be run but are hardly meant: mostly a slip of unit.

use crate::case::{Case, Units};
use crate::error::Diagnostic;
use crate::math::{Signal, Vector};
use crate::mpm::{BodySetup, GridSetup, Setup, SheetContact, WallKind};
use crate::pfem2;

/// Densities of solids and liquids, from foams to heavy metals [kg/m³].
const DENSE: [f64; 2] = [10.0, 3e4];

/// Densities of anything that flows, from thin gases on [kg/m³].
const FLOWING: [f64; 2] = [1e-3, 3e4];

/// More than in any centrifuge for models [m/s²].
const STRONG: f64 = 1000.0;

/// Gravity on earth [m/s²], to its first digits.
const EARTH: [f64; 2] = [9.78, 9.84];

/// Sheets that are thinner would be a few molecules thick [m].
const THIN: f64 = 1e-7;

/// Sheets that are thicker, over the extent of the grid, are no sheets. (Their own may be that of a channel one cell
/// wide.)
const THICK: f64 = 0.3;

/// Elements of membranes that are shorter or longer, in cells: contact at nodes of the grid, for which half a cell to
/// one cell is right.
const AT_NODES: [f64; 2] = [0.25, 2.0];

/// The same where membranes meet bodies at their particles.
const AT_PARTICLES: [f64; 2] = [0.125, 8.0];

/// Largest length of a grid over the extent of its contents; a longer one is probably a mistake.
const VAST: f64 = 500.0;

/// Speeds above which a gas and a liquid are compressed [m/s], for a method that knows no sound.
const COMPRESSED: [f64; 2] = [300.0, 1000.0];

/// Fluids that are lighter are gases [kg/m³].
const GAS: f64 = 50.0;

/// A body within this many cells of a plane lies on it: by its bounds, and by its particles.
const ON_PLANE: [f64; 2] = [1e-6, 0.1];

const NO_UNIT: &str = "a number without a unit is in m, kg, s";

/// Looks at a case of material points.
pub(super) fn of_points<const D: usize>(case: &Case, setup: &Setup<D>, findings: &mut Vec<Diagnostic>) {
    vast(case, setup, findings);
    if case.file.units == Units::SI {
        findings.extend(gravity("mpm.gravity", &setup.gravity, case.file.time.end));
        for (i, body) in setup.bodies.iter().enumerate() {
            let range = if is_gas(body) { FLOWING } else { DENSE };
            findings.extend(density(&format!("body[{i}].material.density"), &body.name, body.law.density(), range));
        }
        for (i, membrane) in setup.membranes.iter().enumerate() {
            let key = format!("membrane[{i}].material.density");
            findings.extend(density(&key, &membrane.name, membrane.sheet.density(), DENSE));
        }
    }
    faster_than_sound(setup, findings);
    atmospheres(setup, findings);
    thickness(case, setup, findings);
    elements_and_cells(setup, findings);
    beside_slip(case, setup, findings);
}

/// Looks at a case of fluids on a mesh.
pub(in crate::case) fn of_flow<const D: usize, const N: usize>(
    case: &Case,
    setup: &pfem2::Setup<D, N>,
    findings: &mut Vec<Diagnostic>,
) {
    if case.file.units != Units::SI {
        return;
    }
    findings.extend(gravity("pfem2.gravity", &setup.gravity, case.file.time.end));
    let (fluids, solids) = (case.file.fluids(), case.file.solids());
    for (i, solid) in solids.iter().zip(setup.solid_setups()) {
        findings.extend(density(&format!("body[{i}].material.density"), &solid.name, solid.law.density(), DENSE));
    }
    for (i, solid) in case.file.particle_solids().iter().zip(&setup.particle_solids) {
        findings.extend(density(&format!("body[{i}].material.density"), &solid.name, solid.law.density, DENSE));
    }
    for (i, fluid) in fluids.iter().zip(&setup.fluids) {
        findings.extend(density(&format!("body[{i}].material.density"), &fluid.name, fluid.density, FLOWING));
    }
    let heaviest = setup.fluids.iter().map(|fluid| fluid.density).fold(0.0, f64::max);
    let most = COMPRESSED[usize::from(heaviest > GAS)];
    let too_fast = |key: String, speed: f64| {
        let message = format!(
            "{speed:.4e} m/s: fluids are compressed at such speeds, and this method takes them for incompressible"
        );
        let finding = Diagnostic::warning(key, message).help(format!("is the unit right? {NO_UNIT}"));
        (speed > most).then_some(finding)
    };
    let fastest = setup.velocity.iter().map(|v| v.norm()).fold(0.0, f64::max);
    findings.extend(too_fast(format!("body[{}].velocity", fluids.first().unwrap_or(&0)), fastest));
    for (i, set) in setup.boundaries.iter().enumerate() {
        let Some(v) = set.condition.velocity_formula() else { continue };
        let nodes = set.facets.iter().flat_map(|&facet| setup.mesh.facet_nodes(facet));
        let places: Vec<[f64; 3]> = nodes.map(|node| setup.mesh.nodes()[node as usize].to3()).collect();
        findings.extend(too_fast(format!("boundary[{i}].velocity"), largest(v, &places, case.file.time.end)));
    }
}

/// The largest norm of a vector of signals at places and times of a run; 0 where it is not finite.
fn largest<const D: usize>(signals: &[Signal; D], places: &[[f64; 3]], end: f64) -> f64 {
    let times = (0..=16).map(|i| end * f64::from(i) / 16.0);
    let all = times.flat_map(|t| places.iter().map(move |&x| (x, t)));
    let norms = all.map(|(x, t)| Vector::<D>::from_fn(|i| signals[i].value(x, t)).norm());
    norms.filter(|norm| norm.is_finite()).fold(0.0, f64::max)
}

fn gravity<const D: usize>(key: &str, gravity: &[Signal; D], end: f64) -> Option<Diagnostic> {
    let size = largest(gravity, &[[0.0; 3]], end);
    let digits = if size > 0.0 { size / 10f64.powf(size.log10().floor()) } else { 0.0 };
    let slipped = (EARTH[0]..EARTH[1]).contains(&digits) && !(1.0..10.0).contains(&size);
    let message = format!("a gravity of {size} m/s²: on earth it is 9.81 m/s²");
    let help = format!("is the unit right? `\"9810 mm/s^2\"` is 9.81 m/s²; {NO_UNIT}");
    (slipped || size > STRONG).then(|| Diagnostic::warning(key, message).help(help))
}

fn density(key: &str, name: &str, density: f64, [least, most]: [f64; 2]) -> Option<Diagnostic> {
    let message = format!("`{name}` has a density of {density} kg/m³; water has 1000, steel 7800, air 1.2");
    let help = format!("is the unit right? `\"1 g/cm^3\"` is 1000 kg/m³; {NO_UNIT}");
    (!(least..=most).contains(&density)).then(|| Diagnostic::warning(key, message).help(help))
}

/// Gases have no given speed of sound: it depends on their state.
fn is_gas<const D: usize>(body: &BodySetup<D>) -> bool {
    !body.law.keeps_shape() && body.law.reference_sound_speed() == 0.0
}

/// Gases that meet, through a sheet too, count their pressures from the same atmosphere.
fn atmospheres<const D: usize>(setup: &Setup<D>, findings: &mut Vec<Diagnostic>) {
    let mut gases = setup.bodies.iter().enumerate().filter(|(_, body)| body.law.is_ideal_gas());
    let Some((_, first)) = gases.next() else { return };
    for (i, body) in gases.filter(|(_, body)| body.ambient != first.ambient) {
        let message = format!(
            "`{}` counts its pressure from {} Pa and `{}` from {} Pa: where they meet, they don't agree on what is zero",
            first.name, first.ambient, body.name, body.ambient
        );
        let help = "give all gases the same `ambient`, unless nothing is ever between two of them";
        findings.push(Diagnostic::warning(format!("body[{i}].ambient"), message).help(help));
    }
}

fn faster_than_sound<const D: usize>(setup: &Setup<D>, findings: &mut Vec<Diagnostic>) {
    for (i, body) in setup.bodies.iter().enumerate().filter(|(_, body)| !is_gas(body)) {
        let speed = body.velocity.iter().map(|v| v.norm()).fold(0.0, f64::max);
        let sound = body.law.reference_sound_speed();
        if speed > sound {
            let message = format!("`{}` moves at {speed:.4e} m/s, faster than sound in it: {sound:.4e} m/s", body.name);
            let help = format!("are the units of its velocity, density and stiffness right? {NO_UNIT}");
            findings.push(Diagnostic::warning(format!("body[{i}].velocity"), message).help(help));
        }
    }
}

fn thickness<const D: usize>(case: &Case, setup: &Setup<D>, findings: &mut Vec<Diagnostic>) {
    for (i, membrane) in setup.membranes.iter().enumerate() {
        let (length, thickness) = (extent(&membrane.position).max(length(&setup.grid)), membrane.thickness);
        let message = if thickness > THICK * length {
            format!("`{}` is {thickness} m thick, in a grid of {length:.4} m: that is no thin sheet", membrane.name)
        } else if thickness < THIN && case.file.units == Units::SI {
            format!("`{}` is {thickness} m thick: that is a few molecules", membrane.name)
        } else {
            continue;
        };
        let help = format!("is the unit right? {NO_UNIT}");
        findings.push(Diagnostic::warning(format!("membrane[{i}].thickness"), message).help(help));
    }
}

/// Checks that the elements of membranes that meet bodies have about the size of cells.
fn elements_and_cells<const D: usize>(setup: &Setup<D>, findings: &mut Vec<Diagnostic>) {
    if setup.bodies.is_empty() {
        return;
    }
    let (least, most, leaks) = match setup.sheet_contact {
        SheetContact::Nodes => (AT_NODES[0], AT_NODES[1], "what meets it at nodes of the grid leaks between them"),
        SheetContact::Particles => (AT_PARTICLES[0], AT_PARTICLES[1], "what meets it sees flat pieces of that size"),
    };
    for (i, membrane) in setup.membranes.iter().enumerate() {
        let [mean, longest] = super::sides(membrane).map(|side| side / setup.grid.cell);
        let (cells, help) = if (most..super::LONGEST_ELEMENT).contains(&longest) {
            (
                longest,
                format!(
                    "{leaks}, and steps are as short as the small cells ask: take smaller elements, or larger cells"
                ),
            )
        } else if mean < least * (1.0 - 1e-9) {
            let help = "the grid doesn't see what they resolve, and their sub-steps cost: take larger elements, or smaller cells";
            (mean, help.to_owned())
        } else {
            continue;
        };
        let digits = if cells < 1.0 { 3 } else { 1 };
        let message = format!("the elements of `{}` are {cells:.digits$} cells long", membrane.name);
        let right = "; between half a cell and one cell is right";
        findings.push(Diagnostic::warning(format!("membrane[{i}].geometry"), message).help(help + right));
    }
}

/// The largest extent of places along an axis [m].
fn extent<const D: usize>(places: &[Vector<D>]) -> f64 {
    let along = |axis: usize| {
        let (low, high) = places
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x[axis]), high.max(x[axis])));
        high - low
    };
    (0..D).map(along).fold(0.0, f64::max)
}

/// The longest side of the grid [m].
fn length<const D: usize>(grid: &GridSetup<D>) -> f64 {
    grid.cells.iter().map(|&cells| f64::from(cells) * grid.cell).fold(0.0, f64::max)
}

/// A grid may be large: only the nodes around the material are stored. But not by a factor of 1000.
fn vast<const D: usize>(case: &Case, setup: &Setup<D>, findings: &mut Vec<Diagnostic>) {
    let places = setup.bodies.iter().map(|body| &body.position).chain(setup.membranes.iter().map(|m| &m.position));
    let places: Vec<Vector<D>> = places.flatten().copied().collect();
    let content = extent(&places).max(setup.grid.cell);
    let grid = &setup.grid;
    let Some(axis) = (0..D).max_by_key(|&axis| grid.cells[axis]) else { return };
    if places.is_empty() || length(grid) < VAST * content {
        return;
    }
    let name = ["x", "y", "z"][axis];
    let message =
        format!("the grid is {} m long along {name}, and what is in it is {content:.4} m large", length(grid));
    let mut help = "right if something flies so far: memory follows the material".to_owned();
    if case.file.units == Units::SI {
        help += &format!("; else, is the unit right? {NO_UNIT}");
    }
    findings.push(Diagnostic::warning(format!("grid.upper[{axis}]"), message).help(help));
}

/// A wall of kind `slip` is a plane of symmetry: what lies within a cell of it moves with its mirror image.
fn beside_slip<const D: usize>(case: &Case, setup: &Setup<D>, findings: &mut Vec<Diagnostic>) {
    let grid = &setup.grid;
    for (i, body) in setup.bodies.iter().enumerate().filter(|(_, body)| body.law.keeps_shape()) {
        let region = case.file.body[i].region.as_ref().map(|shape| shape.build(&case.source.base, D));
        let Some(Ok(region)) = region else { continue };
        let bounds = region.bounds();
        for (axis, end) in (0..D).flat_map(|axis| [(axis, 0), (axis, 1)]) {
            if grid.walls[axis][end].kind != WallKind::Slip {
                continue;
            }
            let upper = grid.lower[axis] + f64::from(grid.cells[axis]) * grid.cell;
            let inward = |x: f64| if end == 0 { x - grid.lower[axis] } else { upper - x };
            // The surface lies between what the bounds say and what the particles and their depths say.
            let least = inward(if end == 0 { bounds.lower[axis] } else { bounds.upper[axis] }) / grid.cell;
            let depths = body.position.iter().zip(&body.depth);
            let most = depths.map(|(x, depth)| inward(x[axis]) - depth).fold(f64::INFINITY, f64::min) / grid.cell;
            if (least > ON_PLANE[0] || most > ON_PLANE[1]) && most < 1.0 - ON_PLANE[0] {
                let name = ["x", "y", "z"][axis];
                let (gap, plane) = (most * grid.cell, if end == 0 { grid.lower[axis] } else { upper });
                let message = format!(
                    "`{}` begins {gap:.3e} m from the wall of kind `slip` at {name} = {plane} m, less than a cell",
                    body.name
                );
                let help = "such a wall is a plane of symmetry: the body sticks to its mirror image; let it lie on the wall, \
                            keep it a cell away, or write `kind = \"separate\"`";
                findings.push(Diagnostic::warning(format!("body[{i}].region"), message).help(help));
            }
        }
    }
}
