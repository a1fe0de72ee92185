//! The mesh of a case, and warnings about it.

use super::super::Construction;
use super::MakeMesh;
use crate::case::{InterfaceSpec, VolumeSpec};
use crate::error::Diagnostic;
use crate::math::Vector;
use crate::mesh::domain::{BoxMesh, DomainMesh, Refinement};
use crate::mesh::{Facet, Locator, Mesh};
use crate::pfem2::boundary::BoundarySetup;
use std::path::Path;

/// Volume over the longest edge to the power of the dimension under which an element is said to be nearly flat; 0.43 in
/// an equilateral triangle, 0.12 in a regular tetrahedron.
const NEARLY_FLAT: f64 = 1e-4;

impl Construction<'_> {
    /// The mesh, or `None` if it can't be made (and why was noted).
    pub(super) fn mesh<const D: usize, const N: usize>(&mut self, make: MakeMesh<D, N>) -> Option<Mesh<D, N>> {
        let spec = self.case.file.mesh.as_ref()?;
        if let DomainMesh::BoxMesh(spec) = spec {
            self.findings.extend(coarser(spec));
        }
        match make(spec, &self.case.source.base) {
            Ok(mesh) => {
                self.findings.extend(unrefined(spec, &self.case.source.base, &mesh));
                Some(mesh)
            }
            Err(finding) => {
                self.find("mesh", finding);
                None
            }
        }
    }

    /// Pieces of a mesh must not overlap, and every one must be open somewhere: one pressure is held, that of the
    /// whole.
    pub(super) fn pieces<const D: usize, const N: usize>(&mut self, mesh: &Mesh<D, N>, sets: &[BoundarySetup<D>]) {
        let (piece, count) = mesh.pieces();
        if count == 1 {
            return;
        }
        let locator = Locator::new(mesh);
        if let Some(e) = (0..piece.len()).find(|&e| locator.overlapping(mesh, e).is_some()) {
            let message = format!("pieces of the mesh overlap: two elements hold the place ({})", at(mesh.center(e)));
            let help = "a place belongs to one element: leave one of the pieces out, or choose a `group`";
            self.findings.push(Diagnostic::error("mesh", message).help(help));
            return;
        }
        let mut open = vec![false; count];
        for set in sets.iter().filter(|set| set.condition.kind().has_free_flux()) {
            set.facets.iter().for_each(|facet| open[piece[facet.element as usize]] = true);
        }
        let Some(closed) = open.iter().rposition(|open| !open) else { return self.one_shift(count) };
        let elements: Vec<usize> = (0..piece.len()).filter(|&e| piece[e] == closed).collect();
        let center = elements.iter().map(|&e| mesh.center(e)).sum::<Vector<D>>() / elements.len() as f64;
        let message = format!(
            "the mesh falls into {count} pieces that don't touch, and nothing is open in the one of {} elements around ({}): \
             its pressure would be arbitrary",
            elements.len(),
            at(center)
        );
        let help = "compute every piece in a case of its own, join them, or open each with an outlet";
        self.findings.push(Diagnostic::error("mesh", message).help(help));
    }

    /// One shift of the interface keeps the volumes of the whole: it would fill one piece from another.
    fn one_shift(&mut self, pieces: usize) {
        let (spec, fluids) = (&self.case.file.pfem2, self.case.file.fluids().len());
        let kept = fluids > 2 || (fluids == 2 && spec.interface == InterfaceSpec::Sharp);
        if kept && spec.volume == VolumeSpec::Shift {
            let message = format!(
                "the mesh falls into {pieces} pieces, and the volumes of the whole would be kept, not those of each"
            );
            let finding = Diagnostic::error("pfem2.volume", message);
            self.findings.push(finding.help("write `volume = \"none\"`, or compute every piece in a case of its own"));
        }
    }

    /// Elements that are nearly flat spoil the accuracy, and the linear solver.
    pub(super) fn nearly_flat<const D: usize, const N: usize>(&mut self, mesh: &Mesh<D, N>) {
        let thickness = |e: usize| {
            let x = mesh.corners(e);
            let sides = (0..N).flat_map(|i| (i + 1..N).map(move |j| (i, j)));
            let longest = sides.map(|(i, j)| (x[j] - x[i]).norm()).fold(0.0, f64::max);
            mesh.simplex(e).volume / longest.powi(D as i32)
        };
        let flat: Vec<(f64, usize)> =
            (0..mesh.elements().len()).map(|e| (thickness(e), e)).filter(|(t, _)| *t < NEARLY_FLAT).collect();
        let Some((least, worst)) = flat.iter().min_by(|a, b| a.0.total_cmp(&b.0)) else { return };
        let power = if D == 2 { "square" } else { "cube" };
        let message = format!(
            "{} elements are nearly flat, the worst at ({}): its volume is {least:.1e} of the {power} of its longest edge",
            flat.len(),
            at(mesh.center(*worst))
        );
        let help = "mesh the geometry anew there: flat elements spoil the accuracy, and the linear solver";
        self.findings.push(Diagnostic::warning("mesh", message).help(help));
    }

    /// Warns of parts that are left out of a mesh, and of parts of its boundary without a name.
    pub(super) fn left_over<const D: usize, const N: usize>(&mut self, mesh: &Mesh<D, N>, sets: &[BoundarySetup<D>]) {
        if let Some(&first) = mesh.isolated.first() {
            let message = format!("{} nodes belong to no element, the first at ({})", mesh.isolated.len(), at(first));
            self.findings.push(Diagnostic::warning("mesh", message).help("they are left out"));
        }
        let named: usize = sets.iter().map(|set| set.facets.len()).sum();
        let facets = mesh.boundary();
        let bare = || facets.iter().filter(|facet| !sets.iter().any(|set| set.facets.contains(facet)));
        if named < facets.len() {
            let Some(&first) = bare().next() else { return };
            let (count, place) = (facets.len() - named, at(middle(mesh, first)));
            let message = format!("{count} facets of the boundary are in no named part, the first at ({place})");
            let help = "they are walls at rest: say so with `on = \"rest\"`, or give them a physical group";
            self.findings.push(Diagnostic::warning("boundary", message).help(help));
        }
    }
}

/// Regions too far away from the mesh to make any element of it smaller.
fn unrefined<const D: usize, const N: usize>(spec: &DomainMesh, base: &Path, mesh: &Mesh<D, N>) -> Vec<Diagnostic> {
    let DomainMesh::BoxMesh(spec) = spec else { return Vec::new() };
    let places = || mesh.nodes().iter().copied().chain((0..mesh.elements().len()).map(|e| mesh.center(e)));
    let useless = |fine: &Refinement| {
        let Ok(region) = fine.region.build(base, D) else { return false };
        let growth = fine.growth.unwrap_or(spec.growth);
        let size = |x: Vector<D>| fine.cell + growth * region.signed_distance(x.to3()).max(0.0);
        fine.cell <= spec.cell && places().all(|x| size(x) >= spec.cell)
    };
    let (message, help) = (
        "this region changes nothing: no element lies in it or near it",
        format!(
            "the box reaches from {:?} m to {:?} m: move the region into it, or take it out",
            spec.lower, spec.upper
        ),
    );
    let found = spec.refine.iter().enumerate().filter(|(_, fine)| useless(fine));
    found.map(|(i, _)| Diagnostic::warning(format!("mesh.refine[{i}].region"), message).help(&help)).collect()
}

/// Regions that ask for larger elements than there are anyway.
fn coarser(spec: &BoxMesh) -> Vec<Diagnostic> {
    let refined = spec.refine.iter().enumerate().map(|(i, fine)| (format!("mesh.refine[{i}].cell"), Some(fine.cell)));
    let holes = spec.holes.iter().enumerate().map(|(i, hole)| (format!("mesh.holes[{i}].cell"), hole.cell));
    let useless = refined.chain(holes).filter(|(_, cell)| cell.is_some_and(|cell| cell > spec.cell));
    useless
        .map(|(key, _)| {
            let message = format!("this is coarser than `mesh.cell`, {} m, and changes nothing", spec.cell);
            Diagnostic::warning(key, message).help("write a smaller size, or take it out")
        })
        .collect()
}

/// A place, for messages [m].
pub(super) fn at<const D: usize>(x: Vector<D>) -> String {
    x.0.map(|c| format!("{c:.6}")).join(", ")
}

/// The middle of a facet [m].
pub(super) fn middle<const D: usize, const N: usize>(mesh: &Mesh<D, N>, facet: Facet) -> Vector<D> {
    mesh.facet_nodes(facet).iter().map(|&n| mesh.nodes()[n as usize]).sum::<Vector<D>>() / D as f64
}
