//! Contact between bodies, each in its own velocity field (theory D.14; Bardenhagen 2001, Nairn 2020).
//!
//! ```text
//! g − Δt max(0, (v̄_a − v̄_b)·n) ≤ tol                     detection: n from body a to body b, g the gap between their particles
//! J = m_a m_b/(m_a + m_b) (v̄_a − v̄_b)·n n, no pulling, and friction    on b, −J on a          (theory (D.12), (D.13))
//! ```
//!
//! At every node with the mass of two bodies, the plane between their particles is found (`plane`, `separation`); if
//! they approach and the gap along its normal closes, they exchange an impulse. With three or more bodies at
//! a node the pairs take turns, in a fixed order. Bodies on opposite sides of a sheet don't meet here.

mod plane;
mod separation;

use super::folded_stencil::FoldedStencil;
use super::impulse::{self, Impulse, Touch};
use super::method::ContactMethod;
use super::support_blocks::Marks;
use crate::math::{Tensor, Vector};
use crate::mpm::{Body, Friction, Grid};
use crate::parallel::{self, CHUNK};
use plane::{Interface, Point, separate};

/// Turns that the pairs at a node take when there are several.
const SWEEPS: usize = 4;

/// What one pair of fields did at one node.
#[derive(Debug, Clone, Copy)]
struct Meeting<const D: usize> {
    node: usize,
    fields: [usize; 2],
    interface: Interface<D>,
    /// On the second field.
    impulse: Impulse<D>,
}

/// Contact between bodies during one step.
#[derive(Debug, Default)]
pub struct Pairwise<const D: usize> {
    /// Pairs of fields that may meet, and their friction.
    pairs: Vec<([usize; 2], Friction)>,
    rows: Vec<usize>,
    lookup: Vec<u32>,
    meetings: Vec<Meeting<D>>,
}

/// A particle near a node: the node's row, the field, and the point relative to the node.
type Near<const D: usize> = (u32, u32, Point<D>);

const NONE: u32 = u32::MAX;

impl<const D: usize> Pairwise<D> {
    /// For the given pairs of fields.
    pub fn new(pairs: Vec<([usize; 2], Friction)>) -> Self {
        Self { pairs, ..Self::default() }
    }

    /// Resolves all contacts between bodies: p̄ and f of both change, with p⁻ = p − Δt f kept.
    /// `tolerance` [m] is the gap below which contact acts.
    pub fn resolve(
        &mut self,
        grid: &mut Grid<D>,
        lattice: &FoldedStencil<D>,
        bodies: &[Body<D>],
        sheets: &[Box<dyn ContactMethod<D>>],
        tolerance: f64,
        dt: f64,
    ) {
        self.meetings.clear();
        self.find_shared(grid, lattice.cutoff);
        if self.rows.is_empty() {
            return;
        }
        let (starts, cloud) = self.gather(grid, lattice, bodies);
        let met: Vec<Vec<Meeting<D>>> = parallel::collect(self.rows.len(), 16, |row| {
            let near = &cloud[starts[row] as usize..starts[row + 1] as usize];
            self.meet(grid, lattice, sheets, self.rows[row], near, tolerance, dt)
        });
        for mut meetings in met {
            let sweeps = if meetings.len() > 1 { SWEEPS } else { 1 };
            for _ in 0..sweeps {
                for meeting in &mut meetings {
                    self.exchange(grid, meeting, dt);
                }
            }
            self.meetings.append(&mut meetings);
        }
    }

    /// Nodes with mass of both fields of a pair.
    fn find_shared(&mut self, grid: &Grid<D>, cutoff: f64) {
        let shared = |node: usize| {
            let heavy = |field: usize| grid.fields[field].nodes[node].mass > cutoff;
            self.pairs.iter().any(|&([a, b], _)| heavy(a) && heavy(b))
        };
        self.rows = if self.pairs.is_empty() {
            Vec::new()
        } else {
            parallel::collect_some(grid.node_count(), CHUNK, |node| shared(node).then_some(node))
        };
        self.lookup.clear();
        self.lookup.resize(if self.rows.is_empty() { 0 } else { grid.node_count() }, NONE);
        for (row, &node) in self.rows.iter().enumerate() {
            self.lookup[node] = row as u32;
        }
    }

    /// The particles around the shared nodes, node by node: starts, and the particles with their fields.
    fn gather(
        &self,
        grid: &Grid<D>,
        lattice: &FoldedStencil<D>,
        bodies: &[Body<D>],
    ) -> (Vec<u32>, Vec<(u32, Point<D>)>) {
        let mut marks = Marks::default();
        marks.clear(grid);
        for &node in &self.rows {
            marks.mark(grid, lattice, node);
        }
        let mut found: Vec<Near<D>> = Vec::new();
        for body in bodies {
            let near = marks.near(grid, lattice, &body.particles.position);
            let around = |n: usize| self.around(grid, lattice, body, near[n] as usize);
            found.extend(parallel::collect_all(near.len(), 256, around));
        }
        let mut starts = vec![0_u32; self.rows.len() + 1];
        for (row, ..) in &found {
            starts[*row as usize + 1] += 1;
        }
        for row in 0..self.rows.len() {
            starts[row + 1] += starts[row];
        }
        let mut next = starts.clone();
        let empty = Point { position: Vector::ZERO, shape: Tensor::ZERO, width: 0.0, second: false };
        let mut cloud = vec![(0, empty); found.len()];
        for (row, field, point) in found {
            cloud[next[row as usize] as usize] = (field, point);
            next[row as usize] += 1;
        }
        (starts, cloud)
    }

    fn around(&self, grid: &Grid<D>, lattice: &FoldedStencil<D>, body: &Body<D>, p: usize) -> Vec<Near<D>> {
        let (x, h) = (body.particles.position[p], grid.cell);
        // A deeper particle lies within the body; that is all it says.
        let shape = if body.shows_surface(p) { body.ball(p, h) * (1.0 / h) } else { Tensor::ZERO };
        let width = body.patch(p) / h;
        let mut list = Vec::new();
        lattice.of_field(grid, body.field).for_each(grid, x, |node, _, flips| {
            let row = self.lookup[node];
            if row != NONE {
                let position = (lattice.mirror(grid, x, flips) - grid.position(node)) / h;
                list.push((row, body.field as u32, Point { position, shape, width, second: false }));
            }
        });
        list
    }

    /// The pairs that touch at a node.
    #[allow(clippy::too_many_arguments)]
    fn meet(
        &self,
        grid: &Grid<D>,
        lattice: &FoldedStencil<D>,
        sheets: &[Box<dyn ContactMethod<D>>],
        node: usize,
        near: &[(u32, Point<D>)],
        tolerance: f64,
        dt: f64,
    ) -> Vec<Meeting<D>> {
        let free = lattice.free(grid, node);
        let mut meetings = Vec::new();
        for &(fields, _) in &self.pairs {
            let [a, b] = fields.map(|field| grid.fields[field].nodes[node]);
            let light = a.mass.min(b.mass) <= lattice.cutoff;
            if light || sheets.iter().any(|sheet| sheet.parts(node, fields)) {
                continue;
            }
            let cloud: Vec<Point<D>> = near
                .iter()
                .filter(|(field, _)| fields.contains(&(*field as usize)))
                .map(|(field, point)| Point { second: *field as usize == fields[1], ..*point })
                .collect();
            let slip = a.momentum / a.mass - b.momentum / b.mass;
            if let Some(interface) = separate(&cloud, free) {
                let gap = interface.gap * grid.cell - slip.dot(interface.normal).max(0.0) * dt;
                if gap <= tolerance {
                    meetings.push(Meeting { node, fields, interface, impulse: Impulse::default() });
                }
            }
        }
        meetings
    }

    /// Gives the pair its impulse and adds it to the meeting.
    fn exchange(&self, grid: &mut Grid<D>, meeting: &mut Meeting<D>, dt: f64) {
        let [a, b] = meeting.fields.map(|field| grid.fields[field].nodes[meeting.node]);
        let friction = self.pairs.iter().find(|(fields, _)| *fields == meeting.fields).map_or(Friction::None, |p| p.1);
        let touch = Touch { mass: b.mass, velocity: b.momentum / b.mass, side: 1.0, friction };
        let mut impulses = Vec::with_capacity(1);
        impulse::solve(a.mass, a.momentum / a.mass, meeting.interface.normal, &[touch], &mut impulses);
        for j in impulses {
            meeting.impulse.normal += j.normal;
            meeting.impulse.tangent += j.tangent;
            for (field, sign) in meeting.fields.into_iter().zip([-1.0, 1.0]) {
                let node = &mut grid.fields[field].nodes[meeting.node];
                node.momentum += j.total() * sign;
                node.force += j.total() * (sign / dt);
            }
        }
    }

    /// Per pair of fields: Σ J on the first [N s], and normal and friction dissipation J·(v̂_b − v̂_a) [J].
    pub fn settle(&self, grid: &Grid<D>, dt: f64) -> Vec<(Vector<D>, [f64; 2])> {
        let mut sums = vec![(Vector::ZERO, [0.0; 2]); self.pairs.len()];
        for meeting in &self.meetings {
            let [a, b] = meeting.fields.map(|field| {
                let node = &grid.fields[field].nodes[meeting.node];
                (node.momentum - node.force * (0.5 * dt)) / node.mass
            });
            let Some(pair) = self.pairs.iter().position(|(fields, _)| *fields == meeting.fields) else { continue };
            let (impulse, lost) = &mut sums[pair];
            *impulse -= meeting.impulse.total();
            lost[0] += meeting.impulse.normal.dot(a - b);
            lost[1] += meeting.impulse.tangent.dot(a - b);
        }
        sums
    }
}
