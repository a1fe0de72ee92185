//! Contact of bodies with the surface of a sheet itself (theory 8.2).
//!
//! ```text
//! x_s = Σ_p w_p x_p                                      a point on the skin of a body that keeps its shape, or a
//!                                                        particle of a fluid
//! g   = c (d − δ) − r − t/2                              its gap: d, δ and n from `nearest`, c its side, r how far the
//!                                                        body reaches from there
//! w   = (Σ_I N_Is v̄_I − Σ_K W_K v̄_K)·n                   velocity at which it opens, N_Is = Σ_p w_p N_Ip
//! J_n ≥ 0,  w + g/Δt ≥ 0,  J_n (w + g/Δt) = 0            the gap closes, at the earliest, at the end of the step
//! M⁻¹ = Σ_I N_Is²/m_I + Σ_K W_K²/m_K
//! p_I ← p_I + N_Is J,   v_K ← v_K − W_K J/m_K            the body through the grid, the sheet at its nodes
//! ```
//!
//! All points together are one complementarity problem (`solver`). Where g < 0
//! nothing is asked of the velocities but that the overlap does not grow, so that contact takes energy and never adds any. Velocities
//! that undo overlaps do add some, even where none exceeds that at which the two came together: of a light node between heavy particles
//! each contact throws back what the other has thrown. Friction follows the normal impulse: ‖J_t‖ ≤ μ_f J_n.
//!
//! Overlaps are undone at the end of the step, by positions alone: u_p = w_p n min(β |g|, ξ r). Only the particles move, for a sheet
//! is light and stiff, and its strains are its positions: moved, it would throw off what it got.
//!
//! The load on the sheet sits where the body touches it, whatever the cell: contact at grid nodes spreads it over
//! the support of the shape functions, and a sheet that meets a ball of a few cells wraps around a blunter one.
//! Because Σ N = Σ W = 1 momentum is conserved to round-off, and because n lies along the line from foot to
//! particle, so is angular momentum of the normal impulses. Nothing is mapped, so that no energy is lost on the way.

use super::band::{Labels, Shift, radius};
use super::guard::Near;
use super::impulse::{Impulse, Settled};
use super::nearest::Nearest;
use super::nodes::{Flips, Lattice, flip};
use super::partner::Partners;
use super::rigid::Rigid;
use super::sample::Facet;
use super::solver::{Moving, Reached, Solver, Spot, Stiffness};
use super::watch::{Member, Scene, Seen, WATCHED, Watch, label, stencil};
use crate::math::Vector;
use crate::mpm::{Body, Friction, Grid, SubStep};
use hashbrown::HashMap;
use rayon::prelude::*;

/// The fraction β of an overlap that is undone in one step, but no more than the share ξ of the size of what overlaps.
const RECOVERY: f64 = 0.2;
const MOST: f64 = 0.05;

/// Stencils per parallel task.
const STENCILS: usize = 64;

/// Allowance for forces when particles that may touch are chosen [cells].
const CLOSE: f64 = 0.02;

/// Part of its half size that is guarded of a particle on the skin itself.
const LEAST_REACH: f64 = 0.1;

/// Particles of all bodies that touch one sheet.
#[derive(Debug, Default)]
pub(super) struct Points<const D: usize> {
    nearest: Nearest<D>,
    solver: Solver<D>,
    /// The particles of all contacts.
    members: Vec<Member<D>>,
    /// Σ ± m_p N_Ip of the watched particles, by node and field.
    sides: HashMap<(u32, u32), f64>,
    /// The momentum's time of the last sub-step [s].
    dt: f64,
}

impl<const D: usize> Points<D> {
    /// For a sheet of these facets over `nodes` nodes.
    pub fn new(facets: &[Facet], nodes: usize) -> Self {
        Self { nearest: Nearest::new(facets, nodes), ..Self::default() }
    }

    /// True if no particle may touch the sheet during this step.
    pub fn is_empty(&self) -> bool {
        self.solver.spots.is_empty()
    }

    /// Forgets the last step and looks where the sheet is now.
    pub fn begin(&mut self, scene: &Scene<'_, D>) {
        self.solver.begin();
        self.members.clear();
        self.sides.clear();
        self.refresh(scene.facets, scene.surface.position, scene.grid.cell);
    }

    /// Follows the sheet to `position` [m].
    pub fn refresh(&mut self, facets: &[Facet], position: &[Vector<D>], cell: f64) {
        self.nearest.refresh(facets, position, WATCHED * cell, cell);
    }

    /// What finds the feet of particles within a cell.
    pub fn nearest(&self) -> &Nearest<D> {
        &self.nearest
    }

    /// Labels what a body touches with around the sheet of this number, and takes note of what may touch it during the step, and of
    /// what may come too close. Returns how much has crossed it since the last step.
    pub fn find(
        &mut self,
        (scene, sheet): (&Scene<'_, D>, usize),
        (index, body): (usize, &Body<D>),
        friction: Friction,
        (labels, guarded): (&mut Labels, &mut Vec<Near<D>>),
    ) -> u64 {
        let particles = &body.particles;
        let Self { nearest, solver, members, sides, .. } = self;
        let watch = Watch::new(scene, nearest, body);
        let fastest = scene.surface.velocity.iter().map(|v| v.norm_squared()).fold(0.0, f64::max).sqrt();
        let mut crossed = 0;
        for seen in watch.seen() {
            let old = labels.recall(seen.key, scene.step - 1);
            let (label, force) = (label(old, &seen), labels.take_force(seen.key, scene.step - 1));
            crossed += u64::from(label.crossed && old.is_none_or(|old| !old.crossed));
            labels.keep(seen.key, scene.step, label);
            vote(sides, scene, body, &seen, label.side);
            let offset = scene.surface.offset.get(seen.foot.facet as usize).copied().unwrap_or(0.0);
            let gap = label.side * (seen.foot.distance - seen.foot.bulge) - seen.radius - offset - scene.tolerance;
            let speed = particles.velocity[seen.particle].norm() + fastest;
            let near = gap < 2.0 * speed * scene.dt + CLOSE * scene.grid.cell;
            let height = label.side * seen.foot.distance;
            if label.side != 0.0 {
                let guard = |member: Member<D>| {
                    let (p, side) = (member.particle as usize, (label.side, seen.foot.normal));
                    let radius = guarded_size(body, p, seen.foot.normal, scene.grid.cell);
                    let moves = (particles.position[p], 2.0 * speed * scene.dt, scene.grid.cell);
                    Near::new([p, index, sheet], side, (height, radius), moves)
                };
                guarded.extend(watch.members(&seen).into_iter().map(guard));
            }
            if label.side != 0.0 && friction != Friction::None && near {
                members.extend(watch.members(&seen));
                solver.spots.push(Spot {
                    field: body.field as u32,
                    body: index as u32,
                    key: seen.key,
                    members: members.len() as u32,
                    radius: seen.radius,
                    nodes: scene.facets[seen.foot.facet as usize].nodes,
                    weights: seen.foot.weights,
                    normal: seen.foot.normal * label.side,
                    arm: label.side * seen.foot.distance,
                    gap,
                    allowed: 0.0,
                    end: 0,
                    softness: Vector::ZERO,
                    free: Stiffness::default(),
                    friction,
                    // The impulse of a second: only the ratios of what a sub-step starts from count.
                    pressed: force,
                    tangent: Vector::ZERO,
                    total: Impulse::default(),
                    work: [0.0; 2],
                });
            }
        }
        crossed
    }

    /// True if the sheet runs between the two fields at this grid node.
    pub fn parts(&self, node: usize, fields: [usize; 2]) -> bool {
        let [a, b] = fields.map(|field| self.sides.get(&(node as u32, field as u32)).copied().unwrap_or(0.0));
        a * b < 0.0
    }

    /// Finds the grid nodes of the particles among the partners, and how far an impulse moves them and the sheet, whose nodes have 1/m
    /// `softness` [1/kg].
    pub fn choose(&mut self, grid: &Grid<D>, lattice: &Lattice<D>, partners: &mut Partners<D>, softness: &[Vector<D>]) {
        let Self { solver: Solver { spots, reached, .. }, members, .. } = self;
        let stencils: Vec<Vec<(u32, Flips, f64)>> = (0..spots.len())
            .into_par_iter()
            .with_min_len(STENCILS)
            .map(|c| {
                let start = if c == 0 { 0 } else { spots[c - 1].members };
                let members = &members[start as usize..spots[c].members as usize];
                stencil(grid, lattice, spots[c].field as usize, members)
            })
            .collect();
        for (spot, stencil) in spots.iter_mut().zip(stencils) {
            for (node, flips, weight) in stencil {
                let partner = partners.add(grid, lattice, spot.field as usize, node as usize);
                spot.softness += partners.softness(partner) * (weight * weight);
                reached.push(Reached { partner, flips, weight });
            }
            spot.end = reached.len() as u32;
            spot.stiffen(softness);
        }
    }

    /// Contact at the end of a sub-step, with walls and obstacles last in each sweep. The sheet has the trial velocities
    /// `velocity` [m/s]; they are changed by the impulses, which are added to `forces` [N].
    pub fn resolve(
        &mut self,
        (partners, rigid): (&mut Partners<D>, &mut Rigid<D>),
        (velocity, softness): (&mut [Vector<D>], &[Vector<D>]),
        forces: &mut [Vector<D>],
        at: &SubStep<'_>,
    ) {
        let (t, dt) = (at.momentum_end, at.momentum_dt);
        if self.is_empty() {
            return;
        }
        self.dt = dt;
        self.solver.load(partners, t);
        self.solver.solve(&mut Moving { velocity: &mut *velocity, softness }, rigid, [dt, at.dt]);
        rigid.hand_over(forces, dt);
        self.solver.hand_over(partners, velocity, forces, dt);
    }

    /// Remembers with the labels of each body how hard it was pressed in the last sub-step, which the next step starts from.
    pub fn remember(&self, labels: &mut [Labels]) {
        for spot in self.solver.spots.iter().filter(|spot| spot.pressed > 0.0) {
            labels[spot.body as usize].put_force(spot.key, spot.pressed / self.dt);
        }
    }

    /// Books the work on the sheet, whose nodes had the mean velocities `mean` [m/s] during the sub-step.
    pub fn book(&mut self, mean: impl Fn(usize) -> Vector<D>) {
        for contact in self.solver.spots.iter_mut().filter(|spot| spot.impulse() != Impulse::default()) {
            let nodes = contact.nodes.iter().zip(contact.weights);
            let v: Vector<D> = nodes.map(|(&k, weight)| mean(k as usize) * weight).sum();
            contact.work[0] += contact.impulse().normal.dot(v);
            contact.work[1] += contact.tangent.dot(v);
        }
    }

    /// Undoes a part of what overlaps: how far the particles of each body are to move.
    pub fn part(&self, shifts: &mut [Vec<Shift<D>>]) {
        let mut first = 0;
        for contact in &self.solver.spots {
            let own = &self.members[first..contact.members as usize];
            first = contact.members as usize;
            if contact.gap < 0.0 {
                let by = contact.normal * (-RECOVERY * contact.gap).min(MOST * contact.radius);
                let shift = |member: &Member<D>| Shift { particle: member.particle, by: by * member.weight };
                shifts[contact.body as usize].extend(own.iter().map(shift));
            }
        }
    }

    /// Adds the impulses of the step, field by field, and what was lost: J·(v̂_r − v̂_s).
    pub fn settle(&self, partners: &Partners<D>, grid: &Grid<D>, dt: f64, sums: &mut [Settled<D>]) {
        let mut start = 0;
        for contact in &self.solver.spots {
            let near = &self.solver.reached[start as usize..contact.end as usize];
            start = contact.end;
            if contact.total == Impulse::default() {
                continue;
            }
            let v: Vector<D> =
                near.iter().map(|at| flip(partners.mean_velocity(at.partner, grid, dt), at.flips) * at.weight).sum();
            sums[contact.field as usize].add(&contact.total, contact.work, v, contact.normal * contact.arm);
        }
    }
}

/// Half the size of a particle that the guard of positions knows [m]: no more than what the body reaches from its centre, or the guard would
/// move particles, and with them the skin, that touch the sheet as they should.
fn guarded_size<const D: usize>(body: &Body<D>, p: usize, normal: Vector<D>, cell: f64) -> f64 {
    let whole = radius(&body.particles, p, normal, cell);
    if body.skin.is_empty() { whole } else { body.reach(p, normal, cell).max(LEAST_REACH * whole).min(whole) }
}

/// Where there are several bodies, the nodes remember on which side of the sheet each of them is.
fn vote<const D: usize>(
    sides: &mut HashMap<(u32, u32), f64>,
    scene: &Scene<'_, D>,
    body: &Body<D>,
    seen: &Seen<D>,
    side: f64,
) {
    if scene.grid.fields.len() < 2 || side == 0.0 {
        return;
    }
    let mass = body.particles.mass[seen.particle];
    scene.lattice.of_field(scene.grid, body.field).for_each(scene.grid, seen.inside, |node, weight, _| {
        *sides.entry((node as u32, body.field as u32)).or_insert(0.0) += side * mass * weight;
    });
}
