//! Solids that lie on the boundary of the mesh, or reach beyond it, at the start.

use super::super::Construction;
use super::mesh::at;
use super::path::SolidSurroundings;
use crate::error::Diagnostic;
use crate::mesh::{Location, Mesh};
use crate::pfem2::solid::setup::SolidSetup;
use crate::pfem2::solid::structure::Structure;

/// Shape functions below this are those of a place on the facet across from the node.
const ROUNDING: f64 = 1e-9;

/// Part of a moving solid outside of the mesh from which on it is likely to be a mistake.
const MOST_OUTSIDE: f64 = 0.1;

impl Construction<'_> {
    /// Solids end at the boundary of the mesh where something holds them; between others and the boundary there is
    /// fluid. Notes the first place of each solid where there is none, and solids that move and lie outside for a part.
    pub(super) fn solids_at_boundary<const D: usize, const N: usize>(
        &mut self,
        structure: &Structure<D>,
        around: &SolidSurroundings<D, N>,
    ) {
        let held = structure.held_velocities(0.0);
        let mut first = 0;
        for (setup, body) in structure.setups().iter().zip(self.case.file.solids()) {
            let moves_along = |node: usize, axis: usize| {
                held[(first + node) * D + axis].is_none() && setup.motion.velocity[axis].is_none()
            };
            let key = format!("body[{body}]");
            let follows = |node: u32| structure.ties.leaders(first as u32 + node).is_some();
            let is_free = |node: u32| !follows(node) && (0..D).all(|axis| moves_along(node as usize, axis));
            let is_moving = |node: u32| (0..D).any(|axis| moves_along(node as usize, axis));
            let outside = || outside(setup, around, is_moving, &key);
            self.findings.extend(touching(setup, around, is_free, &key).or_else(outside));
            first += setup.mesh.nodes.len();
        }
    }
}

/// The first free place of the surface of a solid that lies on the boundary.
fn touching<const D: usize, const N: usize>(
    setup: &SolidSetup<D>,
    around: &SolidSurroundings<D, N>,
    is_free: impl Fn(u32) -> bool,
    key: &str,
) -> Option<Diagnostic> {
    let SolidSurroundings { mesh, locator, .. } = around;
    let mut surface = setup.mesh.facets.iter().flat_map(|facet| facet.nodes.iter().copied());
    let on_boundary = |node: &u32| {
        let found = locator.search(mesh, setup.mesh.nodes[*node as usize]);
        is_free(*node) && found.is_some_and(|location| is_on_boundary(mesh, &location))
    };
    let place = setup.mesh.nodes[surface.find(on_boundary)? as usize];
    let message = format!(
        "`{}` touches the boundary of the mesh at ({}), where nothing holds it: no fluid is between the two",
        setup.name,
        at(place)
    );
    let help = "move it away, by a hundredth of an element or more (up to half an element, the distance is kept); or hold \
                its nodes there, `supports`, along the normal of the boundary at least";
    Some(Diagnostic::error(key.to_owned(), message).help(help))
}

/// A solid that moves, and of which a part lies outside of the mesh.
fn outside<const D: usize, const N: usize>(
    setup: &SolidSetup<D>,
    around: &SolidSurroundings<D, N>,
    is_moving: impl Fn(u32) -> bool,
    key: &str,
) -> Option<Diagnostic> {
    let middle = 3usize.pow(D as u32) / 2;
    let is_outside =
        |node: u32| is_moving(node) && around.locator.search(around.mesh, setup.mesh.nodes[node as usize]).is_none();
    let all: Vec<u32> = match setup.mesh.inner.is_empty() {
        true => setup.mesh.elements.iter().map(|nodes| nodes[middle]).collect(),
        false => setup.mesh.inner.iter().map(|(node, _)| *node).collect(),
    };
    let count = all.iter().filter(|&&node| is_outside(node)).count();
    (count as f64 > MOST_OUTSIDE * all.len() as f64).then(|| {
        let message = format!(
            "{:.0} % of the elements of `{}` lie outside of the mesh, where there is no fluid; its weight and its inertia \
             are those of all of it",
            100.0 * count as f64 / all.len() as f64,
            setup.name
        );
        let help = "of a solid that a plane of symmetry halves, give the half: `region = { shape = \"intersection\", ... }`, or \
                    a mesh of your own";
        Diagnostic::warning(key.to_owned(), message).help(help)
    })
}

/// True for a place on the boundary of the mesh.
fn is_on_boundary<const D: usize, const N: usize>(mesh: &Mesh<D, N>, location: &Location<N>) -> bool {
    let Location::Inside { element, shape } = location else { return false };
    let nodes: Vec<u32> = mesh.elements()[*element]
        .iter()
        .zip(shape)
        .filter(|(_, weight)| **weight > ROUNDING)
        .map(|(&node, _)| node)
        .collect();
    let has_facet = |element: usize| {
        let own = &mesh.elements()[element];
        let free = |k: usize| mesh.neighbour(element, k).is_none() && !nodes.contains(&own[k]);
        nodes.iter().all(|node| own.contains(node)) && (0..N).any(free)
    };
    nodes.first().is_some_and(|&node| mesh.elements_around(node as usize).iter().any(|&e| has_facet(e as usize)))
}
