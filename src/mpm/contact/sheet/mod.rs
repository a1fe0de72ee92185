//! A membrane as all methods of contact know it: its elements (`facet`), points and distances (`closest_point`, `signed_distance`), and
//! the sides of it on which particles are (`sides`, `guard`); theory D.3, D.12.
//!
//! ```text
//! x_c = Σ_K W_K x_K,   ΣW_K = 1,      d = ±|x − x_c|                closest point and signed distance of x
//! c = ±1                                                            side of a particle, kept while it is near
//! ```

mod bins;
mod closest_point;
mod facet;
mod guard;
mod sides;
mod signed_distance;
mod surface;

pub use closest_point::{Foot, Nearest};
pub use facet::Facet;
pub use guard::{DOUBT, Moved, Near, Shift, keep_sides, suspects};
pub use sides::{Label, Labels};
pub use signed_distance::{Locator, Place};
pub use surface::{SheetSource, Surface};

use crate::math::Vector;
use crate::mpm::contact::rigid::{Rigid, Squeeze};
use crate::mpm::wall::Walls;
use crate::mpm::{Body, Friction, SubStep};

/// A membrane, and the forces of contact on its nodes.
#[derive(Debug)]
pub struct Sheet<const D: usize> {
    pub name: String,
    /// Its number among all sheets.
    pub number: usize,
    pub facets: Vec<Facet>,
    /// Finds the points of the sheet that are closest to others, where it was refreshed last.
    pub nearest: Nearest<D>,
    /// What the particles of each body remember of it.
    pub labels: Vec<Labels>,
    /// Walls and obstacles that it touches.
    pub rigid: Rigid<D>,
    /// Where its nodes were at the start of the step [m].
    pub before: Vec<Vector<D>>,
    /// Friction with each field.
    pub friction: Vec<Friction>,
    /// Axes along which supports hold each node.
    held: Vec<[bool; D]>,
    /// 1/m_K along the axes that are free, 0 along the others [1/kg].
    pub softness: Vec<Vector<D>>,
    /// Change of the forces on the nodes in the last pass [N].
    pub forces: Vec<Vector<D>>,
    /// Node velocities after the impulses of the sub-step [m/s].
    pub after: Vec<Vector<D>>,
}

/// How far from the sheet particles are watched [cells].
pub const WATCHED: f64 = 1.0;

impl<const D: usize> Sheet<D> {
    /// The sheet of this number, its friction with each field, and what the case lists of its friction by name.
    pub fn new(
        number: usize,
        source: &SheetSource<'_, D>,
        bodies: &[Body<D>],
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
            rigid: Rigid::new(nodes, listed),
            before: Vec::new(),
            friction,
            held: source.held.clone(),
            softness: (0..nodes).map(|k| softness(source.mass, &source.held, k)).collect(),
            forces: vec![Vector::ZERO; nodes],
            after: Vec::new(),
        }
    }

    /// Starts a step.
    pub fn begin_step(&mut self, surface: &Surface<'_, D>, walls: &Walls<D>) {
        self.rigid.begin_step(walls);
        self.before.clear();
        self.before.extend_from_slice(surface.position);
    }

    /// Follows the sheet to `position` [m], for [`Self::foot`].
    pub fn refresh(&mut self, position: &[Vector<D>], cell: f64) {
        self.nearest.refresh(&self.facets, position, WATCHED * cell, cell);
    }

    /// Follows the sheet to where it was at the start of the step.
    pub fn refresh_to_start(&mut self, cell: f64) {
        self.nearest.refresh(&self.facets, &self.before, WATCHED * cell, cell);
    }

    /// The closest point to `x` [m] where the sheet was refreshed last, within `cell` [m], the size of a cell.
    pub fn foot(&self, x: Vector<D>, cell: f64) -> Option<Foot<D>> {
        self.nearest.foot(&self.facets, x, cell)
    }

    /// The farthest that any of its nodes has moved in the step, to `position` [m].
    pub fn travel(&self, position: &[Vector<D>]) -> f64 {
        let squares = position.iter().zip(&self.before).map(|(now, before)| (*now - *before).norm_squared());
        squares.fold(0.0, f64::max).sqrt()
    }

    /// The sheet, refreshed where its nodes have moved to, `position` [m].
    pub fn moved<'a>(&'a self, position: &'a [Vector<D>]) -> Moved<'a, D> {
        Moved { nearest: &self.nearest, facets: &self.facets, before: &self.before, position }
    }

    /// The share of a node's mass that supports, walls and obstacles hold along each axis.
    pub fn held_share(&self, k: usize) -> Vector<D> {
        Vector::from_fn(|a| if self.held[k][a] { 1.0 } else { self.rigid.held[k][a] })
    }

    /// Starts a pass of a sub-step: no forces yet; in the first, gaps from walls and obstacles as they are now.
    pub fn begin_pass(&mut self, pass: usize, surface: &Surface<'_, D>, walls: &Walls<D>, at: &SubStep<'_>, cell: f64) {
        self.forces.fill(Vector::ZERO);
        if pass == 0 {
            self.rigid.begin(walls, &self.facets, surface, at, cell);
        }
    }

    /// Contact with walls and obstacles alone, after the forces of this pass.
    pub fn meet_walls(&mut self, surface: &Surface<'_, D>, at: &SubStep<'_>) {
        if self.rigid.is_empty() {
            return;
        }
        let Self { rigid, softness, forces, after, .. } = self;
        let soft = |k: usize| softness[k];
        after.clear();
        after.extend((0..softness.len()).map(|k| {
            let (v, soft) = (surface.velocity[k], soft(k));
            Vector::from_fn(|a| v[a] + soft[a] * forces[k][a] * at.momentum_dt)
        }));
        rigid.settle(after, &soft, at.dt);
        rigid.hand_over(forces, at.momentum_dt);
    }

    /// Parts the sheet from walls and obstacles that it overlaps with, after its nodes have moved to `position` [m].
    pub fn part(&self, position: &mut [Vector<D>], at: &SubStep<'_>) {
        self.rigid.part(position, &|k: usize| self.softness[k], at.elapsed + at.dt);
    }

    /// A point that has no way out between walls, obstacles and supports `elapsed` [s] after the start of the step; positions of the
    /// nodes now and at the start of the run [m].
    pub fn squeezed(&self, positions: [&[Vector<D>]; 2], (walls, elapsed): (&Walls<D>, f64)) -> Option<Squeeze<D>> {
        self.rigid.squeezed((walls, elapsed), positions, &self.held)
    }
}

/// 1/m_K along the axes that are free, 0 along the others [1/kg].
fn softness<const D: usize>(mass: &[f64], held: &[[bool; D]], k: usize) -> Vector<D> {
    Vector::from_fn(|axis| if held[k][axis] { 0.0 } else { 1.0 / mass[k] })
}

/// The memory of a body's particles at the start of the run: the side that their region has of the sheet with this number.
fn labels<const D: usize>(body: &Body<D>, sheet: usize) -> Labels {
    let known = body.part.sides.get(sheet).copied().filter(|&side| side != 0.0);
    Labels { known, ..Labels::default() }
}
