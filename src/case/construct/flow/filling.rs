//! Meshes of solids whose case gives no length of elements, and how far those of surfaces from files stay off these.

use crate::error::Diagnostic;
use crate::geometry::Region;
use crate::mesh::{Deviation, QuadraticMesh};

/// Elements across the thinnest part of a solid where the case gives no length.
const ACROSS: usize = 2;

/// Lengths of elements, over the first one, that are tried for a surface from a file that is thinner than an element, or
/// off which nodes of the boundary stay.
const FINER: [f64; 5] = [0.7, 0.5, 0.35, 0.25, 0.18];

/// Cells around a surface, at most, that are tried without a length in the case.
const MOST_TRIED: f64 = 50_000.0;

/// Length of elements that a warning advises, over that of an edge of the mesh.
const ADVISED: f64 = 0.5;

/// The mesh of a region with elements of `cell` [m], or smaller ones where fewer than two would lie across its thinnest
/// part. Inside a surface from a file it is the first one, from large to small elements, whose boundary lies on the
/// surface, or else the one that comes nearest.
pub(super) fn filled(region: &Region, cell: f64, dimension: usize) -> Result<QuadraticMesh, String> {
    let mut best = two_across(region, cell, dimension);
    if region.triangles().is_none() {
        return best;
    }
    let part = |mesh: &QuadraticMesh| mesh.deviation(region).map_or(0.0, |deviation| deviation.part());
    let bounds = region.bounds();
    let count = |cell: f64| (0..3).map(|k| ((bounds.upper[k] - bounds.lower[k]) / cell).max(1.0)).product::<f64>();
    for cell in FINER.map(|part| part * cell).into_iter().filter(|&cell| count(cell) < MOST_TRIED) {
        let most = best.as_ref().map_or(f64::INFINITY, part);
        if most <= Deviation::GOOD {
            break;
        }
        best = match two_across(region, cell, dimension) {
            Ok(next) if part(&next) < most => Ok(next),
            _ => best,
        };
    }
    best
}

fn two_across(region: &Region, cell: f64, dimension: usize) -> Result<QuadraticMesh, String> {
    let mesh = QuadraticMesh::fill(region, cell, dimension)?;
    let place = mesh.thinnest();
    if place.elements >= ACROSS {
        return Ok(mesh);
    }
    QuadraticMesh::fill(region, place.length / ACROSS as f64, dimension)
}

/// A warning if nodes on the boundary of a solid stay off the surface of its file.
pub(super) fn off_surface(key: &str, name: &str, region: &Region, mesh: &QuadraticMesh) -> Option<Diagnostic> {
    region.triangles()?;
    let most = mesh.deviation(region).filter(|most| most.part() > Deviation::GOOD)?;
    let place = most.place.map(|c| format!("{c:.6}")).join(", ");
    let message = format!(
        "the surface of `{name}` lies {:.2e} m off that of the file at ({place}), {:.0} % of an edge there: elements that \
         follow it would fold",
        most.length,
        100.0 * most.part()
    );
    let help = format!(
        "smaller elements follow it, as with `mesh = {{ cell = {:.2e} }}`, or a mesh of your own from Gmsh, \
         `mesh = {{ path = \"...\" }}`",
        ADVISED * most.edge
    );
    Some(Diagnostic::warning(format!("{key}.mesh"), message).help(help))
}
