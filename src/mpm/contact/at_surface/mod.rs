//! Contact of bodies with the surface of a sheet itself (theory D.9).
//!
//! ```text
//! x_s = Σ_p w_p x_p                                      a point on the skin of a body that keeps its shape, or a
//!                                                        particle of a fluid
//! g   = c (d − δ) − r − t/2                              its gap: d, δ and n from `sheet::closest_point`, c its side, r how far the
//!                                                        body reaches from there
//! w   = (Σ_I N_Is v̄_I − Σ_K W_K v̄_K)·n                   velocity at which it opens, N_Is = Σ_p w_p N_Ip
//! J_n ≥ 0,  w + g/Δt ≥ 0,  J_n (w + g/Δt) = 0            the gap closes, at the earliest, at the end of the step
//! M⁻¹ = Σ_I N_Is²/m_I + Σ_K W_K²/m_K
//! p_I ← p_I + N_Is J,   v_K ← v_K − W_K J/m_K            the body through the grid, the sheet at its nodes
//! ```
//!
//! All points together are one complementarity problem (`solver`; theory D.10). Where g < 0
//! nothing is asked of the velocities but that the overlap does not grow, so that contact takes energy and never adds any. Velocities
//! that undo overlaps do add some, even where none exceeds that at which the two came together: of a light node between heavy particles
//! each contact throws back what the other has thrown. Friction follows the normal impulse: ‖J_t‖ ≤ μ_f J_n.
//!
//! Overlaps are undone at the end of the step, by positions alone: u_p = w_p n min(β |g|, ξ r_p) with half the size
//! r_p of its particles. Only the particles move, for a sheet
//! is light and stiff, and its strains are its positions: moved, it would throw off what it got.
//!
//! The load on the sheet sits where the body touches it, whatever the cell: contact at grid nodes spreads it over
//! the support of the shape functions, and a sheet that meets a ball of a few cells wraps around a blunter one.
//! Because Σ N = Σ W = 1 momentum is conserved to round-off, and because n lies along the line from foot to
//! particle, so is angular momentum of the normal impulses. Nothing is mapped, so that no energy is lost on the way.

mod candidates;
mod solver;
mod surface_contact;

use super::folded_stencil::{Flips, flip};
use super::impulse::{Impulse, Settled};
use super::method::{ContactMethod, StepContext};
use super::particle_size::radius;
use super::partner::Partners;
use super::sheet::{DOUBT, Labels, Near, Sheet, Shift, Surface};
use crate::math::Vector;
use crate::mpm::{Body, Friction, Grid, SubStep};
use crate::parallel;
use candidates::{Candidate, CandidateSearch, Member, label, stencil};
use hashbrown::HashMap;
use solver::{Moving, Solver};
use surface_contact::{Stiffness, SupportNode, SurfaceContact};

/// The fraction β of an overlap that is undone in one step, but no more than the share ξ of half the size of a particle.
const RECOVERY: f64 = 0.2;
const MOST: f64 = 0.05;

/// Stencils per parallel task.
const STENCILS: usize = 64;

/// Allowance for forces when particles that may touch are chosen [cells].
const CLOSE: f64 = 0.02;

/// Part of its half size that is guarded of a particle on the skin itself.
const LEAST_REACH: f64 = 0.1;

/// Contact of one sheet at the particles of all bodies.
#[derive(Debug)]
pub struct AtParticles<const D: usize> {
    /// Gap below which contact acts [m].
    tolerance: f64,
    solver: Solver<D>,
    /// The particles of all contacts.
    members: Vec<Member<D>>,
    /// Σ ± m_p N_Ip of the watched particles, by node and field.
    sides: HashMap<(u32, u32), f64>,
    /// The momentum's time of the last sub-step [s].
    dt: f64,
}

impl<const D: usize> AtParticles<D> {
    /// Contact that acts below the gap `tolerance` [m].
    pub fn new(tolerance: f64) -> Self {
        Self { tolerance, solver: Solver::default(), members: Vec::new(), sides: HashMap::default(), dt: 0.0 }
    }

    /// Labels what the body of this index touches with around the sheet, and takes note of what may touch it during the step, and of
    /// what may come too close. Returns how much has crossed it since the last step.
    fn find_of(
        &mut self,
        index: usize,
        sheet: &mut Sheet<D>,
        surface: &Surface<'_, D>,
        scene: &StepContext<'_, D>,
        guarded: &mut Vec<Near<D>>,
    ) -> u64 {
        let (body, cell, fastest) = (&scene.bodies[index], scene.grid.cell, surface.fastest());
        let Sheet { nearest, facets, friction, labels, number, .. } = sheet;
        let (labels, friction) = (&mut labels[index], friction[body.field]);
        let watch = CandidateSearch::new(nearest, facets, body, cell);
        let mut crossed = 0;
        for seen in watch.seen() {
            let force = labels.take_force(seen.key, scene.step - 1);
            let (side, crosses) = relabel(labels, &seen, scene.step);
            crossed += u64::from(crosses);
            if side == 0.0 {
                continue;
            }
            let travel = 2.0 * (body.particles.velocity[seen.particle].norm() + fastest) * scene.dt;
            let found = Found { members: watch.members(&seen), seen, side, force };
            self.vote(scene, body, &found);
            guarded.extend(found.members.iter().map(|member| found.guard([index, *number], body, member, cell)));
            let facet = found.seen.foot.facet as usize;
            let gap = found.height() - found.seen.radius - surface.offset_of(facet) - self.tolerance;
            if friction != Friction::None && gap < travel + CLOSE * cell {
                self.members.extend_from_slice(&found.members);
                let members = self.members.len() as u32;
                let half_size = radius(&body.particles, found.seen.particle, found.seen.foot.normal, cell);
                let spot = found.spot(index, body, facets[facet].nodes, gap, friction);
                self.solver.spots.push(SurfaceContact { members, half_size, ..spot });
            }
        }
        crossed
    }

    /// Where there are several bodies, the nodes remember on which side of the sheet each of them is.
    fn vote(&mut self, scene: &StepContext<'_, D>, body: &Body<D>, found: &Found<D>) {
        if scene.grid.fields.len() < 2 {
            return;
        }
        let (seen, mass) = (&found.seen, body.particles.mass[found.seen.particle]);
        scene.lattice.of_field(scene.grid, body.field).for_each(scene.grid, seen.inside, |node, weight, _| {
            *self.sides.entry((node as u32, body.field as u32)).or_insert(0.0) += found.side * mass * weight;
        });
    }

    /// Books the work on the sheet, whose nodes had the mean velocities `mean` [m/s] during the sub-step.
    fn book(&mut self, mean: impl Fn(usize) -> Vector<D>) {
        for contact in self.solver.spots.iter_mut().filter(|spot| spot.impulse() != Impulse::default()) {
            let nodes = contact.nodes.iter().zip(contact.weights);
            let v: Vector<D> = nodes.map(|(&k, weight)| mean(k as usize) * weight).sum();
            contact.work[0] += contact.impulse().normal.dot(v);
            contact.work[1] += contact.tangent.dot(v);
        }
    }
}

impl<const D: usize> ContactMethod<D> for AtParticles<D> {
    fn find(
        &mut self,
        sheet: &mut Sheet<D>,
        surface: &Surface<'_, D>,
        scene: &StepContext<'_, D>,
        guarded: &mut Vec<Near<D>>,
    ) -> u64 {
        self.solver.begin();
        self.members.clear();
        self.sides.clear();
        sheet.refresh(surface.position, scene.grid.cell);
        (0..scene.bodies.len()).map(|index| self.find_of(index, sheet, surface, scene, guarded)).sum()
    }

    fn parts(&self, node: usize, fields: [usize; 2]) -> bool {
        let [a, b] = fields.map(|field| self.sides.get(&(node as u32, field as u32)).copied().unwrap_or(0.0));
        a * b < 0.0
    }

    /// Finds how far an impulse moves the particles and the sheet, too.
    fn choose(&mut self, sheet: &Sheet<D>, scene: &StepContext<'_, D>, partners: &mut Partners<D>) {
        let (grid, lattice) = (scene.grid, scene.lattice);
        let Self { solver: Solver { spots, reached, .. }, members, .. } = self;
        let stencils: Vec<Vec<(u32, Flips, f64)>> = parallel::collect(spots.len(), STENCILS, |c| {
            let start = if c == 0 { 0 } else { spots[c - 1].members };
            let members = &members[start as usize..spots[c].members as usize];
            stencil(grid, lattice, spots[c].field as usize, members)
        });
        for (spot, stencil) in spots.iter_mut().zip(stencils) {
            for (node, flips, weight) in stencil {
                let partner = partners.add(grid, lattice, spot.field as usize, node as usize);
                spot.softness += partners.softness(partner) * (weight * weight);
                reached.push(SupportNode { partner, flips, weight });
            }
            spot.end = reached.len() as u32;
            spot.stiffen(&sheet.softness);
        }
    }

    /// Walls and obstacles come last in each sweep. Nothing is mapped, so that the nodes take up what the bodies give, and one pass is
    /// enough.
    fn resolve(
        &mut self,
        sheet: &mut Sheet<D>,
        surface: &Surface<'_, D>,
        partners: &mut Partners<D>,
        pass: usize,
        at: &SubStep<'_>,
    ) {
        if self.solver.spots.is_empty() {
            return sheet.meet_walls(surface, at);
        }
        if pass > 0 {
            return;
        }
        let Sheet { rigid, softness, forces, after, .. } = sheet;
        after.clear();
        after.extend_from_slice(surface.velocity);
        self.dt = at.momentum_dt;
        self.solver.load(partners, at.momentum_end);
        self.solver.solve(&mut Moving { velocity: after, softness }, rigid, [self.dt, at.dt]);
        rigid.hand_over(forces, self.dt);
        self.solver.hand_over(partners, after, forces, self.dt);
        self.book(|k| (surface.previous[k] + after[k]) * 0.5);
    }

    /// Nothing is mapped and nothing lost, and gaps have followed the velocities already.
    fn conclude(&mut self, _: &Sheet<D>, _: &Surface<'_, D>, _: &Partners<D>, _: &SubStep<'_>) -> f64 {
        0.0
    }

    /// Undoes a part of what overlaps, and keeps how hard each point was pressed in the last sub-step.
    fn finish(&self, sheet: &mut Sheet<D>, shifts: &mut [Vec<Shift<D>>]) {
        let mut first = 0;
        for contact in &self.solver.spots {
            let own = &self.members[first..contact.members as usize];
            first = contact.members as usize;
            if contact.gap < 0.0 {
                let by = contact.normal * (-RECOVERY * contact.gap).min(MOST * contact.half_size);
                let shift = |member: &Member<D>| Shift { particle: member.particle, by: by * member.weight };
                shifts[contact.body as usize].extend(own.iter().map(shift));
            }
        }
        for spot in self.solver.spots.iter().filter(|spot| spot.pressed > 0.0) {
            sheet.labels[spot.body as usize].put_force(spot.key, spot.pressed / self.dt);
        }
    }

    fn settle(&self, partners: &Partners<D>, grid: &Grid<D>, dt: f64, sums: &mut [Settled<D>]) {
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

    /// Contact does not act at nodes.
    fn meets(&self, _: usize) -> bool {
        false
    }
}

/// Labels what was seen in a step: its side, and true if it has crossed the sheet since the last one.
fn relabel<const D: usize>(labels: &mut Labels, seen: &Candidate<D>, step: u64) -> (f64, bool) {
    let old = labels.recall(seen.key, step - 1);
    let label = label(old, seen);
    labels.keep(seen.key, step, label);
    (label.side, label.crossed && old.is_none_or(|old| !old.crossed))
}

/// A point of a body near the sheet, on a side of it.
struct Found<const D: usize> {
    seen: Candidate<D>,
    /// Its particles.
    members: Vec<Member<D>>,
    /// +1 where the normals of the sheet point.
    side: f64,
    /// How hard it was pressed in the last step [N].
    force: f64,
}

impl<const D: usize> Found<D> {
    /// Its height above the curved surface that the sheet stands for [m].
    fn height(&self) -> f64 {
        self.side * (self.seen.foot.distance - self.seen.foot.bulge)
    }

    /// One of its particles, of the body and the sheet with these indices, for the guard of positions.
    fn guard(&self, [index, sheet]: [usize; 2], body: &Body<D>, member: &Member<D>, cell: f64) -> Near<D> {
        let (p, normal) = (member.particle as usize, self.seen.foot.normal);
        let doubt = if body.skin.is_empty() { 0.0 } else { DOUBT * cell };
        let heights = (self.side * self.seen.foot.distance - doubt, guarded_size(body, p, normal, cell));
        Near::new([p, index, sheet], (self.side, normal), heights, body.particles.position[p])
    }

    /// The contact of the body of this index with an element of these nodes, from the gap [m] at the start of the step.
    fn spot(&self, index: usize, body: &Body<D>, nodes: [u32; 4], gap: f64, friction: Friction) -> SurfaceContact<D> {
        let (seen, side) = (&self.seen, self.side);
        SurfaceContact {
            field: body.field as u32,
            body: index as u32,
            key: seen.key,
            members: 0,
            half_size: 0.0,
            nodes,
            weights: seen.foot.weights,
            normal: seen.foot.normal * side,
            arm: side * seen.foot.distance,
            gap,
            allowed: 0.0,
            end: 0,
            softness: Vector::ZERO,
            free: Stiffness::default(),
            friction,
            // The impulse of a second: only the ratios of what a sub-step starts from count.
            pressed: self.force,
            tangent: Vector::ZERO,
            total: Impulse::default(),
            work: [0.0; 2],
        }
    }
}

/// Half the size of a particle that the guard of positions knows [m]: no more than what the body reaches from its centre, or the guard would
/// move particles, and with them the skin, that touch the sheet as they should.
fn guarded_size<const D: usize>(body: &Body<D>, p: usize, normal: Vector<D>, cell: f64) -> f64 {
    let whole = radius(&body.particles, p, normal, cell);
    if body.skin.is_empty() { whole } else { body.reach(p, normal, cell).max(LEAST_REACH * whole).min(whole) }
}
