//! Solids in the fluids: mesh, law, loads, first state.

use super::super::Construction;
use super::super::signals::TrialPoints;
use super::filling::{filled, off_surface};
use crate::case::resolution::size_of;
use crate::case::{Material, SolidMeshSpec};
use crate::error::Diagnostic;
use crate::geometry::{FacetCorners, Region, Winding};
use crate::material::{PointLaw, StartState};
use crate::math::{Signal, Vector};
use crate::mesh::{Mesh, QuadraticMesh};
use crate::pfem2::solid::mesh::{SolidFacet, SolidMesh};
use crate::pfem2::solid::setup::SolidSetup;
use crate::pfem2::solid::structure::Structure;
use crate::pfem2::solid::structure::modes::NaturalModes;

/// Length of the elements of a solid where the case gives none, in cells of the fluid's mesh.
const CELLS: f64 = 2.0;

/// Modes of each solid that are looked for, those without stiffness among them.
pub(super) const MODES: usize = 12;

/// Periods that are shown of a solid.
const PERIODS: usize = 3;

/// Pieces of a side that is a parabola.
const PIECES: usize = 4;

/// A solid as the case describes it: how it moves at the start, and where it is.
pub(super) struct InitialSolid<const D: usize> {
    /// Its place in `body`.
    body: usize,
    pub setup: SolidSetup<D>,
    velocity: [Signal; 3],
    lower: Vector<D>,
    upper: Vector<D>,
    surface: Winding<D>,
}

impl<const D: usize> InitialSolid<D> {
    /// True for a place inside of it [m].
    fn contains(&self, x: Vector<D>) -> bool {
        (0..D).all(|i| (self.lower[i]..=self.upper[i]).contains(&x[i])) && self.surface.number(x) > 0.5
    }

    /// Velocity at the start, at a place [m/s].
    pub fn velocity(&self, x: Vector<D>) -> Vector<D> {
        Vector::from_fn(|i| self.velocity[i].value(x.to3(), 0.0))
    }
}

/// The solid that a place is in [m].
pub(super) fn solid_at<const D: usize>(solids: &[InitialSolid<D>], x: Vector<D>) -> Option<&InitialSolid<D>> {
    solids.iter().find(|solid| solid.contains(x))
}

impl Construction<'_> {
    /// The solid `body[index]`; `None` if it can't be made (and why was noted).
    pub(super) fn solid<const D: usize, const N: usize>(
        &mut self,
        index: usize,
        background: &Mesh<D, N>,
    ) -> Option<InitialSolid<D>> {
        let spec = &self.case.file.body[index];
        let key = format!("body[{index}]");
        let (quadratic, mesh) = self.solid_meshes(index, background)?;
        let (start, over) = (TrialPoints::start(&mesh.nodes), TrialPoints::over(&mesh.nodes, self.case.file.time.end));
        let velocity: [Signal; 3] = self.signals(&format!("{key}.velocity"), &spec.velocity, &start);
        let (held, springs) = self.holding(index, (&quadratic, &mesh), &over);
        let motion = self.motion::<D>(index, &over);
        self.unused_by_rigid(index);
        self.unused_by_elastic(index);
        let (tractions, pressures) = self.loads(index, (&quadratic, &mesh), &over);
        let law = self.solid_law(index)?;
        let law = self.prestressed::<D>(index, law)?;
        self.plane_in_space::<D>(index);
        let [lower, upper] = quadratic.extent().map(Vector::from3);
        let at = |x: &Vector<D>| Vector::from_fn(|i| velocity[i].value(x.to3(), 0.0));
        let setup = SolidSetup {
            name: spec.name.clone(),
            velocity: mesh.nodes.iter().map(at).collect(),
            law,
            plane: spec.plane.unwrap_or_default().into(),
            held,
            springs,
            motion,
            tractions,
            pressures,
            damping: spec.damping.unwrap_or_default().into(),
            inertia: spec.inertia.unwrap_or_default().into(),
            friction: spec.friction.unwrap_or_default(),
            restitution: spec.restitution.unwrap_or_default(),
            surface: spec.surface.unwrap_or_default().into(),
            mesh,
        };
        let surface = Winding::new(setup.mesh.facets.iter().flat_map(|facet| pieces(&setup.mesh, facet)).collect());
        Some(InitialSolid { body: index, setup, velocity, lower, upper, surface })
    }

    /// The assumption of plane stress or plane strain is for two dimensions.
    pub(super) fn plane_in_space<const D: usize>(&mut self, body: usize) {
        if let (Some(_), 3) = (self.case.file.body[body].plane, D) {
            let finding = Diagnostic::error(format!("body[{body}].plane"), "a solid in 3D has no plane");
            self.findings.push(finding.help("take it out: it is for `dimension = 2`"));
        }
    }

    /// The solids of a case together; inside `None` if there are none.
    pub(super) fn structure<const D: usize>(&mut self, setups: Vec<SolidSetup<D>>) -> Option<Option<Structure<D>>> {
        if setups.is_empty() {
            return Some(None);
        }
        let bonds = self.bonds();
        let structure = Structure::new(setups).map_err(|why| ("body".to_owned(), why)).and_then(|structure| {
            let index = bonds.first().map_or(0, |[own, _]| self.case.file.solids()[*own]);
            structure.bonded(&bonds).map_err(|why| (format!("body[{index}].bond"), why))
        });
        match structure {
            Ok(structure) => Some(Some(structure)),
            Err((key, why)) => {
                self.findings.push(Diagnostic::error(key, why));
                None
            }
        }
    }

    /// Two solids may touch, but no element of one may lie in the other.
    pub(super) fn overlaps<const D: usize>(&mut self, solids: &[InitialSolid<D>]) {
        let middle = 3usize.pow(D as u32) / 2;
        for (a, solid) in solids.iter().enumerate() {
            for other in solids.iter().enumerate().filter(|(b, _)| *b != a).map(|(_, other)| other) {
                let SolidSetup { name, mesh, .. } = &solid.setup;
                let of_elements = mesh.elements.iter().map(|nodes| nodes[middle]);
                let inside = |node: &u32| other.contains(mesh.nodes[*node as usize]);
                let count = of_elements.chain(mesh.inner.iter().map(|(node, _)| *node)).filter(inside).count();
                if count > 0 {
                    let message = format!("{count} elements of `{name}` lie in `{}`", other.setup.name);
                    let finding = Diagnostic::error(format!("body[{}]", solid.body), message);
                    self.findings.push(finding.help("solids may touch: move one of them, or make one body of both"));
                    return;
                }
            }
        }
    }

    fn solid_law(&mut self, index: usize) -> Option<Box<dyn PointLaw>> {
        let Material::Point(law) = &self.case.file.body[index].material else { return None };
        let law = law.clone().into_box();
        if law.is_rigid() {
            return Some(law);
        }
        match law.initial(&StartState::default()) {
            Ok(_) => Some(law),
            Err(why) => {
                self.findings.push(Diagnostic::error(format!("body[{index}].material"), why));
                None
            }
        }
    }

    /// The mesh of a solid, as sets of nodes are named in it and as it is solved.
    fn solid_meshes<const D: usize, const N: usize>(
        &mut self,
        index: usize,
        background: &Mesh<D, N>,
    ) -> Option<(QuadraticMesh, SolidMesh<D>)> {
        if let Some(surface) = self.surface_of(index)? {
            return self.enclosed(index, &surface);
        }
        let quadratic = self.solid_mesh(index, background)?;
        let nodes: Vec<Vector<D>> = quadratic.nodes.iter().map(|&x| Vector::from3(x)).collect();
        match SolidMesh::new(nodes, quadratic.elements.clone()) {
            Ok(mesh) => Some((quadratic, mesh)),
            Err(why) => {
                self.findings.push(Diagnostic::error(format!("body[{index}].mesh"), why));
                None
            }
        }
    }

    /// The mesh of a solid, made of its region or read.
    fn solid_mesh<const D: usize, const N: usize>(
        &mut self,
        index: usize,
        background: &Mesh<D, N>,
    ) -> Option<QuadraticMesh> {
        let spec = &self.case.file.body[index];
        let key = format!("body[{index}]");
        if let Some(SolidMeshSpec::File(file)) = &spec.mesh {
            let read = file.read(&self.case.source.base, D);
            return read.map_err(|finding| self.find(&format!("{key}.mesh"), finding)).ok();
        }
        let region = self.region(&format!("{key}.region"), spec.region.as_ref()?)?;
        let made = match &spec.mesh {
            Some(SolidMeshSpec::Made(cells)) => QuadraticMesh::fill(&region, cells.cell, D),
            _ => filled(&region, CELLS * cell_at(background, &region), D),
        };
        let wrong = |why| {
            let help =
                "another size, `mesh = { cell = ... }`, or a mesh of your own, `mesh = { path = \"...\" }`, may help";
            self.findings.push(Diagnostic::error(format!("{key}.region"), why).help(help));
        };
        let mesh = made.map_err(wrong).ok()?;
        self.findings.extend(off_surface(&key, &spec.name, &region, &mesh));
        Some(mesh)
    }
}

/// The longest periods of each elastic solid, and for which none were looked for.
pub(super) fn natural_periods<const D: usize>(solids: &[SolidSetup<D>], modes: &NaturalModes<D>) -> Vec<String> {
    let of = |(solid, setup): (usize, &SolidSetup<D>)| {
        let own = modes.found.iter().filter(|mode| mode.solid == solid && mode.period.is_finite());
        let periods: Vec<String> = own.take(PERIODS).map(|mode| format!("{:.3e} s", mode.period)).collect();
        (!periods.is_empty()).then(|| format!("{} {}", setup.name, periods.join(", ")))
    };
    let all: Vec<String> = solids.iter().enumerate().filter_map(of).collect();
    let found = (!all.is_empty()).then(|| format!("longest periods of solids, without the fluid: {}", all.join("; ")));
    let too_large = modes.too_large.iter().map(|(solid, unknowns)| {
        let name = &solids[*solid].name;
        format!(
            "the periods of `{name}` are not looked for: its {unknowns} unknowns would take long; where `surface` \
             isn't given, the fluid sticks to it, however thin its layer is"
        )
    });
    found.into_iter().chain(too_large).collect()
}

/// The mean size of the elements of the fluid's mesh in a region [m]; where it holds none, in the box around it, or the
/// nearest one.
fn cell_at<const D: usize, const N: usize>(mesh: &Mesh<D, N>, region: &Region) -> f64 {
    let bounds = region.bounds();
    let middle = Vector::<D>::from_fn(|i| 0.5 * (bounds.lower[i] + bounds.upper[i]));
    let boxed = |x: Vector<D>| (0..D).all(|i| (bounds.lower[i]..=bounds.upper[i]).contains(&x[i]));
    let near: Vec<usize> = (0..mesh.elements().len()).filter(|&e| boxed(mesh.center(e))).collect();
    let held: Vec<usize> = near.iter().copied().filter(|&e| region.contains(mesh.center(e).to3())).collect();
    let away = |e: &usize| (mesh.center(*e) - middle).norm_squared();
    let nearest = || (0..mesh.elements().len()).min_by(|a, b| away(a).total_cmp(&away(b))).into_iter().collect();
    let chosen: Vec<usize> = [held, near].into_iter().find(|list| !list.is_empty()).unwrap_or_else(nearest);
    chosen.iter().map(|&e| size_of(mesh, e)).sum::<f64>() / chosen.len() as f64
}

/// A facet as segments (2D) or triangles (3D).
fn pieces<const D: usize>(mesh: &SolidMesh<D>, facet: &SolidFacet) -> Vec<FacetCorners<D>> {
    let node = |a: usize| mesh.nodes[facet.nodes[a] as usize];
    if D == 3 {
        let quarter = |corner: usize| [corner, corner + 1, corner + 4, corner + 3].map(node);
        let halves = |[a, b, c, d]: [Vector<D>; 4]| [[a, b, c], [a, c, d]];
        return [0, 1, 3, 4].into_iter().flat_map(|corner| halves(quarter(corner))).collect();
    }
    let at = |i: usize| {
        let xi = 2.0 * i as f64 / PIECES as f64 - 1.0;
        node(0) * (0.5 * xi * (xi - 1.0)) + node(1) * (1.0 - xi * xi) + node(2) * (0.5 * xi * (xi + 1.0))
    };
    (0..PIECES).map(|i| [at(i), at(i + 1), at(i + 1)]).collect()
}
