//! Hexahedra inside of a closed surface of triangles, from the cells of a lattice.
//!
//! 1. The lattice has the directions in which most of the surface is level, and planes through its large level parts
//!    ([`axes`], [`cells`]). Cells whose middle is inside are kept, and more where the boundary would touch itself.
//! 2. Sharp edges part the surface in patches ([`features`]). Each quadrilateral of the boundary of the cells belongs to
//!    a patch ([`labels`]); nodes between two of them go to the sharp edge there, nodes among three to a corner
//!    ([`holds`]).
//! 3. Where a cell would have two sides on one smooth patch, cells are kept only at some depth below the patch, and a
//!    layer of hexahedra fills what is left, so that each has one side there (pillowing: Mitchell & Tautges 1995,
//!    Schneiders 1996, DOI 10.1007/BF01198732); [`hexes`]. A layer ends in the patches beyond its sharp edges, if these
//!    are convex.
//! 4. Nodes move until hexahedra are as near to their wanted shape as they can be ([`relax`]), and nodes of second order
//!    are put between ([`raise`]).
//!
//! A box, a plate or a bracket is the lattice itself.

mod axes;
mod cells;
mod cover;
mod features;
mod hexes;
mod holds;
mod labels;
mod raise;
mod relax;
#[cfg(test)]
mod shapes;
#[cfg(test)]
mod tests;

use super::{Deviation, QuadraticMesh, divisions};
use crate::geometry::{Surface, Triangles};
use crate::math::Vector;
use crate::mesh::domain::size::too_many;
use axes::Axes;
use cells::{Cells, Lattice};
use features::{Features, SHARP_COSINES, find};
use hexes::Hexes;
use relax::Relaxation;
use std::collections::BTreeSet;

/// Depths below smooth patches, in cells, from which on cells are kept, in the order in which they are tried: of thin
/// walls the middles of few cells are inside.
const INSETS: [f64; 4] = [0.5, 0.25, 0.0, -0.25];

/// A layer is as thick as a cell less this part, plus the depth at which cells begin.
const LAYER: f64 = 0.5;

/// With this scaled determinant at all corners a mesh is good, and no other is tried.
const GOOD: f64 = 0.2;

/// With less the mesh of another choice of sharp edges may be better.
const POOR: f64 = 0.05;

/// Highest quality of a mesh with nodes off the surface: any mesh without is preferred.
const OFF_SURFACE: f64 = 0.01;

/// No place of the surface may lie farther from that of the mesh, in cells.
const FARTHEST: f64 = 0.5;

/// The surface along the axes of the lattice, how long cells are [m], and what a sharp edge is.
struct HexMesher<'a> {
    surface: &'a Surface,
    lattice: &'a Lattice,
    cell: f64,
    /// Cosine of the angle of a sharp edge.
    sharp: f64,
}

/// The volume may differ from what the surface encloses by this part.
const LARGEST_DIFFERENCE: f64 = 0.03;

/// A mesh that was tried.
struct Trial {
    mesh: QuadraticMesh,
    /// The least scaled determinant at a corner.
    quality: f64,
}

/// A mesh of what a surface encloses, with elements of about `cell` [m].
///
/// # Errors
/// A surface that encloses nothing, more elements than a mesh can have, a part that is thinner than its elements or has
/// details that they leave out, elements that fold.
pub fn of_surface(triangles: Triangles, cell: f64) -> Result<QuadraticMesh, String> {
    let triangles = Surface::new(triangles)?.triangles();
    let pieces = cover::pieces(&triangles);
    if pieces > 1 {
        return Err(format!("the surface has {pieces} pieces, and a solid is one: a body for each"));
    }
    let axes = Axes::of(&triangles);
    let vertices = triangles.vertices.iter().map(|&x| axes.along(Vector(x)).0).collect();
    let turned = Triangles { vertices, triangles: triangles.triangles };
    let lattice = Lattice::new(&turned, cell);
    if let Some(why) = too_many(lattice.counts().iter().map(|&count| count as f64).product()) {
        return Err(why);
    }
    let surface = Surface::new(turned)?;
    let [first, second] = SHARP_COSINES.map(|sharp| HexMesher { surface: &surface, lattice: &lattice, cell, sharp });
    let is_poor = |trial: &Trial| trial.quality < POOR;
    let best = match first.best() {
        Ok(trial) if !is_poor(&trial) || first.patch_count() == second.patch_count() => Ok(trial),
        Ok(trial) => Ok(second.best().ok().filter(|other| other.quality > trial.quality).unwrap_or(trial)),
        Err(why) => second.best().ok().filter(|other| !is_poor(other)).ok_or(why),
    };
    let mut mesh = best.map(|trial| trial.mesh).map_err(|(why, x)| match x.map(|x| axes.back(x).0) {
        Some([x, y, z]) => format!("{why} at ({x:.4e}, {y:.4e}, {z:.4e}) m"),
        None => why,
    })?;
    mesh.nodes.iter_mut().for_each(|x| *x = axes.back(Vector(*x)).0);
    Ok(mesh)
}

/// Why there is no mesh, and where.
type Refusal = (String, Option<Vector<3>>);

impl HexMesher<'_> {
    fn features(&self) -> Features {
        Features::new(self.surface.triangles(), self.sharp)
    }

    fn patch_count(&self) -> usize {
        self.features().patch_count()
    }

    /// The first good mesh, or the best of all.
    fn best(&self) -> Result<Trial, Refusal> {
        let (mut features, cells) = self.cells(0.0, &BTreeSet::new())?;
        let mut layered = needing(&self.labelled(&cells, &mut features));
        let mut best: Option<Trial> = None;
        let mut refusal = None;
        if layered.is_empty() {
            let trial = self.tried(0.0, &mut layered)?;
            if trial.quality >= GOOD {
                return Ok(trial);
            }
            best = Some(trial);
        }
        for inset in INSETS {
            match self.tried(inset, &mut layered) {
                Ok(trial) if trial.quality >= GOOD => return Ok(trial),
                Ok(trial) if best.as_ref().is_none_or(|best| trial.quality > best.quality) => best = Some(trial),
                Ok(_) => (),
                Err(why) => refusal = Some(why),
            }
        }
        best.ok_or_else(|| refusal.unwrap_or(("no element fits inside".into(), None)))
    }

    /// The features of the surface, and the cells that begin at some depth below patches that have layers.
    fn cells(&self, inset: f64, layered: &BTreeSet<u32>) -> Result<(Features, Cells<'_>), Refusal> {
        let features = self.features();
        let cells = Cells::inside(self.lattice, self.surface, &features, inset, layered).map_err(|why| (why, None))?;
        Ok((features, cells))
    }

    fn labelled(&self, cells: &Cells, features: &mut Features) -> Hexes {
        let mut mesh = Hexes::of_cells(cells);
        labels::label(&mut mesh, features, self.cell);
        mesh
    }

    /// A mesh whose cells begin at some depth below patches that have layers. Further patches that need one get it.
    fn tried(&self, inset: f64, layered: &mut BTreeSet<u32>) -> Result<Trial, Refusal> {
        let (mut features, cells) = self.cells(inset, layered)?;
        let mut mesh = self.labelled(&cells, &mut features);
        self.check_shape(&mesh)?;
        let has = |patch: &u32| mesh.quads.iter().any(|quad| quad.patch == *patch);
        let patches: BTreeSet<u32> = needing(&mesh).into_iter().chain(layered.iter().copied().filter(has)).collect();
        for group in groups(&patches, &features) {
            mesh.pillow(&group, LAYER + inset);
        }
        let holds = holds::holds(&mesh, &features, self.cell);
        Relaxation::new(&mut mesh, &holds, &features).run();
        let (quality, worst) = mesh.quality();
        let made = raise::raise(&mesh, &holds, &features);
        self.check_cover(&mesh, made.volume())?;
        layered.extend(patches);
        if layered.is_empty() && quality < GOOD {
            layered.extend(mesh.quads.iter().filter(|quad| quad.hex as usize == worst).map(|quad| quad.patch));
        }
        let most = if made.folded().is_some() {
            0.0
        } else if self.is_off_surface(&made) {
            OFF_SURFACE
        } else {
            1.0
        };
        Ok(Trial { mesh: made, quality: quality.min(most) })
    }

    /// True if a node of the boundary lies off the surface by more than what is good.
    fn is_off_surface(&self, mesh: &QuadraticMesh) -> bool {
        let distance = |x: [f64; 3]| self.surface.distance(Vector(x)).0;
        mesh.deviation_by(distance).is_some_and(|deviation| deviation.part() > Deviation::GOOD)
    }

    /// The boundary of the cells must have the parts and holes of the surface.
    fn check_shape(&self, mesh: &Hexes) -> Result<(), Refusal> {
        let surface = self.surface.triangles();
        if mesh.characteristic() == cover::characteristic(&surface) {
            return Ok(());
        }
        let (x, _) = cover::farthest(&surface, mesh, self.cell);
        Err(("the solid, or a hole or gap in it, is narrower than an element".into(), Some(x)))
    }

    /// The mesh must reach all of the surface, and have the volume that it encloses.
    fn check_cover(&self, mesh: &Hexes, volume: f64) -> Result<(), Refusal> {
        let (x, away) = cover::farthest(&self.surface.triangles(), mesh, self.cell);
        let difference = volume / self.surface.volume() - 1.0;
        if away <= FARTHEST * self.cell && difference.abs() < LARGEST_DIFFERENCE {
            return Ok(());
        }
        Err(("the solid is thinner than an element, or has a detail or a hollow as small as one,".into(), Some(x)))
    }
}

/// Patches on which a hexahedron has two sides, or beyond two edges of a quadrilateral that follow each other.
fn needing(mesh: &Hexes) -> BTreeSet<u32> {
    let mut sides = BTreeSet::new();
    let twice = mesh.quads.iter().filter(|quad| !sides.insert((quad.hex, quad.patch)));
    let mut found: BTreeSet<u32> = twice.map(|quad| quad.patch).collect();
    found.extend(mesh.bends().into_values());
    found
}

/// Patches that get one layer together: those that need one, each with all that are joined to it by concave edges, where
/// a layer can't end.
fn groups(patches: &BTreeSet<u32>, features: &Features) -> Vec<BTreeSet<u32>> {
    let mut root: Vec<usize> = (0..features.patch_count()).collect();
    for [p, q] in features.concave() {
        let (p, q) = (find(&mut root, p as usize), find(&mut root, q as usize));
        root[p.max(q)] = p.min(q);
    }
    let all: Vec<usize> = (0..root.len()).map(|patch| find(&mut root, patch)).collect();
    let chosen: BTreeSet<usize> = patches.iter().map(|&patch| all[patch as usize]).collect();
    let group = |own: usize| (0u32..).zip(&all).filter(|(_, root)| **root == own).map(|(patch, _)| patch).collect();
    chosen.into_iter().map(group).collect()
}
