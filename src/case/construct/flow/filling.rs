//! Meshes of solids whose case gives no length of elements, and how far those of surfaces from files stay off these.

use crate::error::Diagnostic;
use crate::geometry::Region;
use crate::mesh::{Deviation, ElementSize, QuadraticMesh};

/// Elements across the thinnest part of a solid where the case gives no length.
const ACROSS: usize = 2;

/// Length of elements over their thickness, at most, where the case gives none: of a shell of thickness t and radius R they
/// are 2.5 t long, well below (R t)^½, from where curved elements bend too stiffly.
const LONGEST: f64 = 5.0;

/// Lengths of elements, over the first one, that are tried for a surface from a file that is thinner than an element, or
/// off which nodes of the boundary stay, and for other regions where elements would fold.
const FINER: [f64; 5] = [0.7, 0.5, 0.35, 0.25, 0.18];

/// Cells around a region, at most, that are tried without a length in the case.
const MOST_TRIED: f64 = 50_000.0;

/// Length of elements that a warning advises, over that of an edge of the mesh.
const ADVISED: f64 = 0.5;

/// The mesh of a region with elements of `cell` [m], or smaller ones where fewer than two would lie across its thinnest
/// part, or where elements would fold. Inside a surface from a file it is the first one, from large to small elements, whose boundary lies on the
/// surface, or else the one that comes nearest.
pub(super) fn filled(region: &Region, cell: f64, dimension: usize) -> Result<QuadraticMesh, String> {
    let first = two_across(region, cell, dimension);
    let bounds = region.bounds();
    let divisions = |cell: f64| (0..dimension).map(move |k| ((bounds.upper[k] - bounds.lower[k]) / cell).max(1.0));
    let finer = FINER.map(|part| part * cell).into_iter();
    let finer = finer.filter(|&cell| divisions(cell).product::<f64>() < MOST_TRIED);
    let surface = region.triangles().is_some();
    let deviation = |mesh: &QuadraticMesh| if surface { mesh.deviation(region) } else { None };
    let part = |mesh: &QuadraticMesh| deviation(mesh).map_or(0.0, |deviation| deviation.part());
    nearest(first, finer, |cell| two_across(region, cell, dimension), part)
}

/// The first mesh, or one with shorter elements, that is off the surface by a part of an edge that is good; or else the
/// one that is off by the least; or else why there is no first one.
fn nearest<M>(
    first: Result<M, String>,
    finer: impl Iterator<Item = f64>,
    fill: impl Fn(f64) -> Result<M, String>,
    part: impl Fn(&M) -> f64,
) -> Result<M, String> {
    let mut best = first;
    for cell in finer {
        let least = best.as_ref().map_or(f64::INFINITY, &part);
        if least <= Deviation::GOOD {
            break;
        }
        best = match fill(cell) {
            Ok(next) if part(&next) < least => Ok(next),
            _ => best,
        };
    }
    best
}

/// A mesh with elements of `cell` [m], or such that two lie across the thinnest part. They may be longer than they are
/// thick there: what is thin bends over lengths that are greater, and with cubes a sheet would have as many as the square
/// of its length over its thickness.
fn two_across(region: &Region, cell: f64, dimension: usize) -> Result<QuadraticMesh, String> {
    let mesh = QuadraticMesh::fill(region, cell, dimension)?;
    let place = mesh.thinnest();
    if place.elements >= ACROSS {
        return Ok(mesh);
    }
    let thickness = place.length / ACROSS as f64;
    let size = ElementSize { cell: cell.min(LONGEST * thickness), across: ACROSS };
    let flat = QuadraticMesh::fill_across(region, size, dimension)?;
    if flat.thinnest().elements >= ACROSS { Ok(flat) } else { QuadraticMesh::fill(region, thickness, dimension) }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Surface, Triangles};

    /// Meshes that are off by the part of their elements' length that a table has.
    #[test]
    fn shorter_elements_are_tried_until_nodes_lie_on_the_surface() {
        let of = |first: Result<f64, String>, off: &'static [(f64, f64)]| {
            let part = |cell: &f64| off.iter().find(|(own, _)| own == cell).map(|(_, part)| *part);
            let fill = |cell: f64| part(&cell).map(|_| cell).ok_or_else(|| "folded".to_owned());
            nearest(first, [0.7, 0.5, 0.35].into_iter(), fill, |cell| part(cell).unwrap())
        };
        assert_eq!(of(Ok(1.0), &[(1.0, 0.019), (0.7, 0.0)]), Ok(1.0));
        assert_eq!(of(Ok(1.0), &[(1.0, 0.1), (0.7, 0.03), (0.5, 0.01), (0.35, 0.0)]), Ok(0.5));
        // None is good: the best, which is not the finest; one that has no mesh is passed over.
        assert_eq!(of(Ok(1.0), &[(1.0, 0.1), (0.5, 0.03), (0.35, 0.05)]), Ok(0.5));
        assert_eq!(of(Err("thin".into()), &[(0.5, 0.03)]), Ok(0.5));
        assert_eq!(of(Err("thin".into()), &[]), Err("thin".into()));
    }

    /// Triangles of twice the width of an elliptic ring fold on its curves.
    #[test]
    fn a_thin_region_is_meshed_with_elements_that_do_not_fold() {
        let ellipse = |a, b| Region::Ellipsoid { center: [0.0; 3], semi_axes: [a, b, f64::INFINITY] };
        let ring = Region::Intersection(vec![ellipse(0.1, 0.05), Region::Complement(ellipse(0.095, 0.045).into())]);
        assert!(QuadraticMesh::fill(&ring, 0.02, 2).unwrap_err().contains("folded"));
        let mesh = filled(&ring, 0.02, 2).unwrap();
        let area = std::f64::consts::PI * (0.1 * 0.05 - 0.095 * 0.045);
        assert!((mesh.volume() / area - 1.0).abs() < 1e-3, "{}", mesh.volume() / area);
    }

    /// Plates and tubes have two elements across, five times as long, not a million cubes.
    #[test]
    fn thin_solids_have_flat_elements() {
        let plate = Region::Box { lower: [0.0; 3], upper: [1.0, 1.0, 0.01] };
        let mesh = filled(&plate, 0.1, 3).unwrap();
        assert_eq!((mesh.elements.len(), mesh.thinnest().elements), (40 * 40 * 2, 2));
        let coarse = filled(&plate, 0.02, 3).unwrap();
        assert_eq!((coarse.elements.len(), coarse.thinnest().elements), (50 * 50 * 2, 2));
        let rod = |radius| Region::Cylinder { from: [0.0; 3], to: [0.05, 0.0, 0.0], radius };
        let tube = Region::Intersection(vec![rod(6e-3), Region::Complement(rod(5e-3).into())]);
        let mesh = filled(&tube, 2.5e-3, 3).unwrap();
        assert_eq!((mesh.elements.len(), mesh.thinnest().elements), (14 * 20 * 2, 2));
    }

    /// A block one of whose nodes was moved off its side, by 3 % of an edge of ½ m.
    #[test]
    fn a_node_off_the_surface_is_named_with_its_place() {
        let corner = |n: u32| [n & 1, n >> 1 & 1, n >> 2].map(f64::from);
        let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let triangles = quads.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        let cube = Triangles { vertices: (0..8).map(corner).collect(), triangles };
        let region = Region::Surface(Surface::new(cube).unwrap().into());
        let mut mesh = filled(&region, 0.5, 3).unwrap();
        assert_eq!(mesh.elements.len(), 8);
        assert_eq!(off_surface("body[0]", "block", &region, &mesh), None);
        let node = mesh.nearest_node([0.25, 0.25, 1.0]).unwrap() as usize;
        mesh.nodes[node][2] -= 0.009;
        assert_eq!(off_surface("body[0]", "block", &region, &mesh), None);
        mesh.nodes[node][2] -= 0.006;
        let found = off_surface("body[0]", "block", &region, &mesh).unwrap();
        assert!(found.key == "body[0].mesh" && found.message.contains("`block` lies 1.50e-2 m off"), "{found:?}");
        assert!(found.message.contains("(0.250000, 0.250000, 0.985000), 3 % of an edge"), "{found:?}");
        assert!(found.help.unwrap().contains("cell = 2.50e-1"));
    }
}
