//! A membrane as all methods of contact know it: points and distances (`closest_point`, `signed_distance`), and
//! the sides of it on which particles are (`sides`, `guard`); theory D.3, D.12, E.10.
//!
//! ```text
//! x_c = Σ_K W_K x_K,   ΣW_K = 1,      d = ±|x − x_c|                closest point and signed distance of x
//! c = ±1                                                            side of a particle, kept while it is near
//! ```

mod closest_point;
mod guard;
mod sides;
mod signed_distance;

pub use closest_point::{Foot, Nearest};
pub use guard::{
    GuardedParticle, HEIGHT_ERROR, MovedSheet, ParticleAtSheet, ParticleShift, SideOfSheet, keep_sides,
    particles_to_check,
};
pub use sides::{Label, Labels};
pub use signed_distance::{FacetLocator, SheetPosition};

use crate::math::Vector;
use crate::mpm::contact::facet::SheetFacet;
use crate::mpm::contact::rigid::{NodePositions, RigidContacts, Squeeze};
use crate::mpm::contact::surface::{SheetSource, SheetSurface};
use crate::mpm::particles::Bodies;
use crate::mpm::wall::Walls;
use crate::mpm::{Body, Friction, SubStep};
use crate::parallel;

/// A membrane, and the forces of contact on its nodes.
#[derive(Debug)]
pub struct ContactSheet<const D: usize> {
    pub name: String,
    /// Number of the sheet among all sheets.
    pub number: usize,
    pub facets: Vec<SheetFacet>,
    /// Search for the closest points of the sheet.
    pub nearest: Nearest<D>,
    /// Sides of the particles of each body.
    pub labels: Vec<Labels>,
    /// Walls and obstacles that it touches.
    pub rigid: RigidContacts<D>,
    /// Positions of its nodes at the start of the step [m].
    pub before: Vec<Vector<D>>,
    /// Friction with each field.
    pub friction: Vec<Friction>,
    /// Axes along which supports hold each node.
    held: Vec<[bool; D]>,
    /// 1/m_K along the axes that are free, 0 along the others [1/kg].
    pub inverse_mass: Vec<Vector<D>>,
    /// Change of the forces on the nodes in the last pass [N].
    pub forces: Vec<Vector<D>>,
    /// Node velocities after the impulses of the sub-step [m/s].
    pub after: Vec<Vector<D>>,
}

/// Distance from a sheet within which particles may touch it [cells].
pub const SEARCH_DISTANCE: f64 = 1.0;

impl<const D: usize> ContactSheet<D> {
    /// The sheet of this number, its friction with each field, and what the case lists of its friction by name.
    pub fn new(
        number: usize,
        source: &SheetSource<'_, D>,
        bodies: &Bodies<D>,
        friction: Vec<Friction>,
        listed: Vec<(String, Friction)>,
    ) -> Self {
        let nodes = source.mass.len();
        Self {
            name: source.name.to_owned(),
            number,
            facets: source.facets.clone(),
            nearest: Nearest::new(&source.facets, nodes),
            labels: bodies.iter().map(|body| labels(body, number)).collect(),
            rigid: RigidContacts::new(nodes, listed),
            before: Vec::new(),
            friction,
            held: source.held.clone(),
            inverse_mass: (0..nodes).map(|k| inverse_mass(source.mass, &source.held, k)).collect(),
            forces: vec![Vector::ZERO; nodes],
            after: Vec::new(),
        }
    }

    /// Starts a step.
    pub fn begin_step(&mut self, surface: &SheetSurface<'_, D>, walls: &Walls<D>) {
        self.rigid.begin_step(walls);
        self.before.clear();
        self.before.extend_from_slice(surface.position);
    }

    /// Sets the positions of the nodes [m] for [`Self::foot`].
    pub fn refresh(&mut self, position: &[Vector<D>], cell: f64) {
        self.nearest.refresh(&self.facets, position, SEARCH_DISTANCE * cell, cell);
    }

    /// Sets the positions of the nodes for [`Self::foot`] to those at the start of the step.
    pub fn refresh_to_start(&mut self, cell: f64) {
        self.nearest.refresh(&self.facets, &self.before, SEARCH_DISTANCE * cell, cell);
    }

    /// The closest point to `x` [m] where the sheet was refreshed last, within `cell` [m], the size of a cell.
    pub fn foot(&self, x: Vector<D>, cell: f64) -> Option<Foot<D>> {
        self.nearest.foot(&self.facets, x, cell)
    }

    /// The farthest that any of its nodes has moved in the step, to `position` [m].
    pub fn travel(&self, position: &[Vector<D>]) -> f64 {
        parallel::max(self.before.len(), |k| (position[k] - self.before[k]).norm_squared()).sqrt()
    }

    /// The sheet, refreshed where its nodes have moved to, `position` [m].
    pub fn moved<'a>(&'a self, position: &'a [Vector<D>]) -> MovedSheet<'a, D> {
        MovedSheet { nearest: &self.nearest, facets: &self.facets, before: &self.before, position }
    }

    /// The fraction of a node's mass that supports, walls and obstacles hold along each axis.
    pub fn held_fraction(&self, k: usize) -> Vector<D> {
        Vector::from_fn(|a| if self.held[k][a] { 1.0 } else { self.rigid.held[k][a] })
    }

    /// Starts a pass of a sub-step: no forces yet; in the first, gaps from walls and obstacles as they are now.
    pub fn begin_pass(
        &mut self,
        pass: usize,
        surface: &SheetSurface<'_, D>,
        walls: &Walls<D>,
        at: &SubStep<'_>,
        cell: f64,
    ) {
        self.forces.fill(Vector::ZERO);
        if pass == 0 {
            self.rigid.begin(walls, &self.facets, surface, at, cell);
        }
    }

    /// Contact with walls and obstacles alone, after the forces of this pass.
    pub fn resolve_rigid_contact(&mut self, surface: &SheetSurface<'_, D>, at: &SubStep<'_>) {
        if self.rigid.is_empty() {
            return;
        }
        let Self { rigid, inverse_mass, forces, after, .. } = self;
        let of_node = |k: usize| inverse_mass[k];
        after.clear();
        after.extend((0..inverse_mass.len()).map(|k| {
            let (v, inverse_mass) = (surface.velocity[k], inverse_mass[k]);
            Vector::from_fn(|a| v[a] + inverse_mass[a] * forces[k][a] * at.momentum_dt)
        }));
        rigid.solve(after, &of_node, at.dt);
        rigid.apply_impulses(forces, at.momentum_dt);
    }

    /// Undoes a part of the overlaps with walls and obstacles, after the nodes have moved to `position` [m].
    pub fn undo_overlaps(&self, position: &mut [Vector<D>], at: &SubStep<'_>) {
        self.rigid.undo_overlaps(position, &|k: usize| self.inverse_mass[k], at.elapsed + at.dt);
    }

    /// A point that is squeezed between walls, obstacles and supports `elapsed` [s] after the start of the step.
    pub fn squeezed(&self, positions: NodePositions<'_, D>, walls: &Walls<D>, elapsed: f64) -> Option<Squeeze<D>> {
        self.rigid.squeezed(positions, walls, elapsed, &self.held)
    }
}

/// 1/m_K along the axes that are free, 0 along the others [1/kg].
fn inverse_mass<const D: usize>(mass: &[f64], held: &[[bool; D]], k: usize) -> Vector<D> {
    Vector::from_fn(|axis| if held[k][axis] { 0.0 } else { 1.0 / mass[k] })
}

/// Sides of a body's particles at the start of the run: that of their region with respect to the sheet with this
/// number.
fn labels<const D: usize>(body: &Body<D>, sheet: usize) -> Labels {
    let region_side = body.part.sides.get(sheet).copied().filter(|&side| side != 0.0);
    Labels { region_side, ..Labels::default() }
}
