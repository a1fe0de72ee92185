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
//! All points together are one complementarity problem, solved by projected Gauss–Seidel in a fixed order. Where g < 0
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
use super::impulse::{Impulse, Settled, limit};
use super::nearest::Nearest;
use super::nodes::{Flips, Lattice, flip};
use super::partner::Partners;
use super::rigid::Rigid;
use super::sample::Facet;
use super::watch::{Member, Scene, Seen, WATCHED, Watch, label, stencil};
use crate::math::Vector;
use crate::mpm::{Body, Friction, Grid, SubStep};
use hashbrown::HashMap;
use rayon::prelude::*;

/// The fraction β of an overlap that is undone in one step, but no more than the share ξ of the size of what overlaps.
const RECOVERY: f64 = 0.2;
const MOST: f64 = 0.05;

/// Most sweeps of the iteration, and the change of an impulse, relative to the largest one, that ends it.
const SWEEPS: usize = 30;
const SETTLED: f64 = 1e-4;

/// Allowance for forces when particles that may touch are chosen [cells].
const CLOSE: f64 = 0.02;

/// Part of its half size that is guarded of a particle on the skin itself.
const LEAST_REACH: f64 = 0.1;

/// A grid node in the support of a touching particle.
#[derive(Debug, Clone, Copy)]
struct Reached {
    partner: u32,
    flips: Flips,
    weight: f64,
}

/// A particle close to the sheet, and what it does there during the step.
#[derive(Debug, Clone)]
struct Spot<const D: usize> {
    field: u32,
    /// Index of its body.
    body: u32,
    /// Its particles end here in the list of all.
    members: u32,
    /// How far the body reaches from there [m].
    radius: f64,
    /// K, repeated where the facet has fewer than four nodes, and W_K.
    nodes: [u32; 4],
    weights: [f64; 4],
    /// n, from the sheet to the particle.
    normal: Vector<D>,
    /// Distance along n from the sheet to where the body is pushed [m].
    arm: f64,
    /// g at the start of the sub-step [m].
    gap: f64,
    /// Its nodes end here in the list of all.
    end: u32,
    /// What the body adds to M⁻¹ along each axis [1/kg].
    softness: Vector<D>,
    friction: Friction,
    /// J of this sub-step, on the particle [N s].
    impulse: Impulse<D>,
    /// Σ J over the sub-steps [N s], and Σ J·v̂ of the sheet [J]: normal part and friction.
    total: Impulse<D>,
    work: [f64; 2],
}

/// Particles of all bodies that touch one sheet.
#[derive(Debug, Default)]
pub(super) struct Points<const D: usize> {
    nearest: Nearest<D>,
    contacts: Vec<Spot<D>>,
    /// The particles of all contacts.
    members: Vec<Member<D>>,
    reached: Vec<Reached>,
    /// Σ ± m_p N_Ip of the watched particles, by node and field.
    sides: HashMap<(u32, u32), f64>,
    /// Trial velocities of the partners with the impulses so far [m/s].
    velocity: Vec<Vector<D>>,
    /// 1/m of the partners [1/kg].
    softness: Vec<Vector<D>>,
}

impl<const D: usize> Points<D> {
    /// For a sheet of these facets over `nodes` nodes.
    pub fn new(facets: &[Facet], nodes: usize) -> Self {
        Self { nearest: Nearest::new(facets, nodes), ..Self::default() }
    }

    /// True if no particle may touch the sheet during this step.
    pub fn is_empty(&self) -> bool {
        self.contacts.is_empty()
    }

    /// Forgets the last step and looks where the sheet is now.
    pub fn begin(&mut self, scene: &Scene<'_, D>) {
        self.contacts.clear();
        self.members.clear();
        self.reached.clear();
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
        let Self { nearest, contacts, members, sides, .. } = self;
        let watch = Watch::new(scene, nearest, body);
        let fastest = scene.surface.velocity.iter().map(|v| v.norm_squared()).fold(0.0, f64::max).sqrt();
        let mut crossed = 0;
        for seen in watch.seen() {
            let old = labels.recall(seen.key, scene.step - 1);
            let label = label(old, &seen);
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
                contacts.push(Spot {
                    field: body.field as u32,
                    body: index as u32,
                    members: members.len() as u32,
                    radius: seen.radius,
                    nodes: scene.facets[seen.foot.facet as usize].nodes,
                    weights: seen.foot.weights,
                    normal: seen.foot.normal * label.side,
                    arm: label.side * seen.foot.distance,
                    gap,
                    end: 0,
                    softness: Vector::ZERO,
                    friction,
                    impulse: Impulse::default(),
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

    /// Finds the grid nodes of the particles among the partners, and how far an impulse moves them.
    pub fn choose(&mut self, grid: &Grid<D>, lattice: &Lattice<D>, partners: &mut Partners<D>) {
        let Self { contacts, members, reached, .. } = self;
        let stencils: Vec<Vec<(u32, Flips, f64)>> = (0..contacts.len())
            .into_par_iter()
            .map(|c| {
                let start = if c == 0 { 0 } else { contacts[c - 1].members };
                let members = &members[start as usize..contacts[c].members as usize];
                stencil(grid, lattice, contacts[c].field as usize, members)
            })
            .collect();
        for (contact, stencil) in contacts.iter_mut().zip(stencils) {
            for (node, flips, weight) in stencil {
                let partner = partners.add(grid, lattice, contact.field as usize, node as usize);
                contact.softness += partners.softness(partner) * (weight * weight);
                reached.push(Reached { partner, flips, weight });
            }
            contact.end = reached.len() as u32;
        }
    }

    /// Contact at the end of a sub-step, with walls and obstacles last in each sweep. The sheet has the trial velocities
    /// `velocity` [m/s]; they are changed by the impulses, which are added to `forces` [N].
    pub fn resolve(
        &mut self,
        (partners, rigid): (&mut Partners<D>, &mut Rigid<D>),
        velocity: &mut [Vector<D>],
        softness: impl Fn(usize) -> Vector<D>,
        forces: &mut [Vector<D>],
        at: &SubStep<'_>,
    ) {
        let (t, dt) = (at.momentum_end, at.momentum_dt);
        if self.contacts.is_empty() {
            return;
        }
        self.velocity.clear();
        self.velocity.extend((0..partners.len()).map(|partner| partners.trial(partner as u32, t).1));
        self.softness.clear();
        self.softness.extend((0..partners.len()).map(|partner| partners.softness(partner as u32)));
        self.contacts.iter_mut().for_each(|contact| contact.impulse = Impulse::default());
        rigid.sweep(velocity, &softness, at.dt);
        for _ in 0..SWEEPS {
            let (change, largest) = self.sweep(velocity, rigid, &softness, dt);
            let (last, most) = rigid.sweep(velocity, &softness, at.dt);
            if change <= SETTLED * largest && last <= SETTLED * most {
                break;
            }
        }
        rigid.hand_over(forces, dt);
        let mut start = 0;
        for contact in &mut self.contacts {
            let near = &self.reached[start as usize..contact.end as usize];
            start = contact.end;
            let j = contact.impulse.total();
            near.iter().for_each(|at| partners.push(at.partner, flip(j, at.flips) * at.weight));
            for (&k, weight) in contact.nodes.iter().zip(contact.weights) {
                forces[k as usize] -= j * (weight / dt);
            }
            contact.total.normal += contact.impulse.normal;
            contact.total.tangent += contact.impulse.tangent;
            contact.gap += contact.opening(near, &self.velocity, velocity).dot(contact.normal) * dt;
        }
    }

    /// One sweep over all particles: the largest change of an impulse, and the largest impulse [N s].
    fn sweep(
        &mut self,
        sheet: &mut [Vector<D>],
        rigid: &mut Rigid<D>,
        softness: &impl Fn(usize) -> Vector<D>,
        dt: f64,
    ) -> (f64, f64) {
        let (mut start, mut change, mut largest) = (0, 0.0_f64, 0.0_f64);
        for contact in &mut self.contacts {
            let near = &self.reached[start as usize..contact.end as usize];
            start = contact.end;
            let opening = contact.opening(near, &self.velocity, sheet);
            let before = contact.impulse;
            let held = contact.sheet_softness(softness, |k, soft, n| rigid.compliance(k, soft, n));
            let mut delta = contact.push(opening, held, dt);
            if contact.loosens(rigid, delta) {
                contact.impulse = before;
                let free = |_, soft: Vector<D>, n: Vector<D>| (0..D).map(|a| n[a] * n[a] * soft[a]).sum();
                delta = contact.push(opening, contact.sheet_softness(softness, free), dt);
            }
            change = change.max(delta.norm());
            largest = largest.max(contact.impulse.normal.norm());
            if delta == Vector::ZERO {
                continue;
            }
            for at in near {
                let soft = self.softness[at.partner as usize];
                let part = flip(delta, at.flips) * at.weight;
                self.velocity[at.partner as usize] += Vector::from_fn(|a| part[a] * soft[a]);
            }
            for (&k, weight) in contact.nodes.iter().zip(contact.weights).filter(|(_, weight)| *weight > 0.0) {
                let k = k as usize;
                sheet[k] += rigid.give(k, delta * -weight, softness(k));
            }
        }
        (change, largest)
    }

    /// Books the work on the sheet, whose nodes had the mean velocities `mean` [m/s] during the sub-step.
    pub fn book(&mut self, mean: impl Fn(usize) -> Vector<D>) {
        for contact in self.contacts.iter_mut().filter(|contact| contact.impulse != Impulse::default()) {
            let nodes = contact.nodes.iter().zip(contact.weights);
            let v: Vector<D> = nodes.map(|(&k, weight)| mean(k as usize) * weight).sum();
            contact.work[0] += contact.impulse.normal.dot(v);
            contact.work[1] += contact.impulse.tangent.dot(v);
        }
    }

    /// Undoes a part of what overlaps: how far the particles of each body are to move.
    pub fn part(&self, shifts: &mut [Vec<Shift<D>>]) {
        let mut first = 0;
        for contact in &self.contacts {
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
        for contact in &self.contacts {
            let near = &self.reached[start as usize..contact.end as usize];
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

impl<const D: usize> Spot<D> {
    /// v_p − v_c [m/s].
    #[inline]
    fn opening(&self, near: &[Reached], body: &[Vector<D>], sheet: &[Vector<D>]) -> Vector<D> {
        let of_body: Vector<D> = near.iter().map(|at| flip(body[at.partner as usize], at.flips) * at.weight).sum();
        let nodes = self.nodes.iter().zip(self.weights);
        of_body - nodes.map(|(&k, weight)| sheet[k as usize] * weight).sum::<Vector<D>>()
    }

    /// What the sheet adds to M⁻¹, along the normal and, at most, across it [1/kg].
    #[inline]
    fn sheet_softness(
        &self,
        softness: &impl Fn(usize) -> Vector<D>,
        compliance: impl Fn(usize, Vector<D>, Vector<D>) -> f64,
    ) -> [f64; 2] {
        let mut sums = [0.0; 2];
        for (&k, weight) in self.nodes.iter().zip(self.weights).filter(|(_, weight)| *weight > 0.0) {
            let soft = softness(k as usize);
            sums[0] += weight * weight * compliance(k as usize, soft, self.normal);
            sums[1] += weight * weight * (0..D).map(|a| soft[a]).fold(0.0, f64::max);
        }
        sums
    }

    /// True if a wall or an obstacle that holds a node of the sheet would let go under the change `delta` of the impulse
    /// [N s]: the sheet is softer then than it is while held.
    fn loosens(&self, rigid: &Rigid<D>, delta: Vector<D>) -> bool {
        let mut nodes = self.nodes.iter().zip(self.weights).filter(|(_, weight)| *weight > 0.0);
        delta != Vector::ZERO && nodes.any(|(&k, weight)| rigid.loosens(k as usize, delta * -weight))
    }

    /// Improves the impulse for the relative velocity `w` [m/s] and what the sheet adds to M⁻¹ along the normal and across it;
    /// returns its change [N s].
    #[inline]
    fn push(&mut self, w: Vector<D>, [along, across]: [f64; 2], dt: f64) -> Vector<D> {
        let n = self.normal;
        let allowed = self.gap.max(0.0) / dt;
        let soft = along + (0..D).map(|a| n[a] * n[a] * self.softness[a]).sum::<f64>();
        if soft == 0.0 {
            return Vector::ZERO;
        }
        let before = self.impulse;
        let pressed = (before.normal.dot(n) - (w.dot(n) + allowed) / soft).max(0.0);
        self.impulse.normal = n * pressed;
        let most = limit(self.friction, pressed);
        if most > 0.0 {
            let soft = across + (0..D).map(|a| self.softness[a]).fold(0.0, f64::max);
            let wanted = before.tangent - (w - n * w.dot(n)) / soft;
            let size = wanted.norm();
            self.impulse.tangent = if size > most { wanted * (most / size) } else { wanted };
        } else {
            self.impulse.tangent = Vector::ZERO;
        }
        self.impulse.total() - before.total()
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
    scene.lattice.for_each(scene.grid, seen.inside, |node, weight, _| {
        *sides.entry((node as u32, body.field as u32)).or_insert(0.0) += side * mass * weight;
    });
}
