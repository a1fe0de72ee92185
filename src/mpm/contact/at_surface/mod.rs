//! Contact of bodies with the surface of a sheet itself (theory D.9).
//!
//! ```text
//! x_s = Σ_p w_p x_p                             a point on the skin of a body that keeps its shape, or a
//!                                               particle of a fluid
//! g   = c (d − δ) − r − t/2                     its gap: d, δ and n from `sheet::closest_point`, c its side, r the distance
//!                                               from there to the surface of the body
//! w   = (Σ_I N_Is v̄_I − Σ_K W_K v̄_K)·n          velocity at which it opens, N_Is = Σ_p w_p N_Ip
//! J_n ≥ 0,  w + g/Δt ≥ 0,  J_n (w + g/Δt) = 0   the gap closes, at the earliest, at the end of the step
//! M⁻¹ = Σ_I N_Is²/m_I + Σ_K W_K²/m_K
//! p_I ← p_I + N_Is J,   v_K ← v_K − W_K J/m_K   the body through the grid, the sheet at its nodes
//! ```
//!
//! All points together are one complementarity problem (`solver`; theory D.10). Where g < 0
//! the condition on velocities is only that the overlap does not grow, so that contact dissipates energy and never adds
//! any. Velocities that undo overlaps do add some, even where none exceeds that of the approach: a light node between
//! heavy particles rebounds from one contact to the other. Friction follows the normal impulse: ‖J_t‖ ≤ μ_f J_n.
//!
//! Overlaps are undone at the end of the step, by positions alone: u_p = w_p n min(β |g|, ξ r_p) with half the size r_p
//! of the particles. Only the particles move, for a sheet is light and stiff: displacements of its nodes would be
//! strains, and rebound.
//!
//! The load on the sheet acts where the body touches it, for any size of cells: contact at grid nodes spreads it over
//! the support of the shape functions, and a sheet on a ball of a few cells takes the shape of a blunter one.
//! Because Σ N = Σ W = 1 momentum is conserved to round-off, and because n lies along the line from foot to
//! particle, so is angular momentum of the normal impulses. Nothing is mapped, so that no energy is lost on the way.

mod candidates;
mod solver;
mod surface_contact;

use super::impulse::{ContactTotals, Impulse};
use super::method::{ContactMethod, StepContext};
use super::particle_size::half_size;
use super::partner::Partners;
use super::sheet::{ContactSheet, GuardedParticle, HEIGHT_ERROR, Labels, ParticleAtSheet, ParticleShift, SideOfSheet};
use super::surface::SheetSurface;
use crate::math::Vector;
use crate::mpm::wall::folded_stencil::{Flips, flip};
use crate::mpm::{Body, Friction, Grid, SubStep};
use crate::parallel;
use candidates::{Candidate, CandidateSearch, WeightedParticle, side_label, support_of};
use hashbrown::HashMap;
use solver::{ContactSolver, SheetMotion};
use surface_contact::{EffectiveMass, SupportNode, SurfaceContact};

/// The fraction β of an overlap that is undone in one step, but no more than the fraction ξ of half the size of a
/// particle.
const RECOVERY: f64 = 0.2;
const LARGEST_CORRECTION: f64 = 0.05;

/// Stencils per parallel task.
const STENCILS: usize = 64;

/// Allowance for forces when particles that may touch are chosen [cells].
const APPROACH_ALLOWANCE: f64 = 0.02;

/// Least part of its half size that the guard of positions gives a particle on the skin.
const LEAST_REACH: f64 = 0.1;

/// Contact of one sheet at the particles of all bodies.
#[derive(Debug)]
pub struct AtSurface<const D: usize> {
    /// Gap below which contact acts [m].
    tolerance: f64,
    solver: ContactSolver<D>,
    /// The particles of all contacts.
    members: Vec<WeightedParticle<D>>,
    /// Σ ± m_p N_Ip of the candidates, by node and field.
    sides: HashMap<(u32, u32), f64>,
    /// Length of the last sub-step of the momentum [s].
    dt: f64,
}

impl<const D: usize> AtSurface<D> {
    /// Contact that acts below the gap `tolerance` [m].
    pub fn new(tolerance: f64) -> Self {
        Self { tolerance, solver: ContactSolver::default(), members: Vec::new(), sides: HashMap::default(), dt: 0.0 }
    }

    /// Labels the candidates of the body of this index, adds the contacts that may act during the step, and the
    /// particles with a side to `guarded`. Returns how many candidates have crossed the sheet since the last step.
    fn find_of(
        &mut self,
        index: usize,
        sheet: &mut ContactSheet<D>,
        surface: &SheetSurface<'_, D>,
        context: &StepContext<'_, D>,
        guarded: &mut Vec<GuardedParticle<D>>,
    ) -> u64 {
        let (body, cell, fastest) = (&context.bodies[index], context.grid.cell, surface.fastest());
        let ContactSheet { nearest, facets, friction, labels, number, .. } = sheet;
        let field = context.bodies.field_of(index);
        let (labels, friction) = (&mut labels[index], friction[field]);
        let search = CandidateSearch::new(nearest, facets, body, cell);
        let mut crossed = 0;
        for candidate in search.all() {
            let force = labels.take_force(candidate.key, context.step - 1);
            let (side, crosses) = relabel(labels, &candidate, context.step);
            crossed += u64::from(crosses);
            if side == 0.0 {
                continue;
            }
            let travel = 2.0 * (body.particles.velocity[candidate.particle].norm() + fastest) * context.dt;
            let found = SidedCandidate { members: search.members(&candidate), candidate, side, force };
            self.add_to_sides(context, field, body, &found);
            guarded.extend(found.members.iter().map(|member| {
                let at = ParticleAtSheet { particle: member.particle as usize, body: index, sheet: *number };
                found.guard(at, body, cell)
            }));
            let facet = found.candidate.foot.facet as usize;
            let gap = found.height() - found.candidate.radius - surface.offset_of(facet) - self.tolerance;
            if friction != Friction::None && gap < travel + APPROACH_ALLOWANCE * cell {
                self.members.extend_from_slice(&found.members);
                let half_size = half_size(&body.particles, found.candidate.particle, found.candidate.foot.normal, cell);
                let start = ContactStart { gap, half_size, members_end: self.members.len() as u32 };
                self.solver.contacts.push(found.contact(index, field, facets[facet].nodes, friction, &start));
            }
        }
        crossed
    }

    /// Adds a candidate to the sums by which nodes tell on which side of the sheet each body is, if there are several.
    fn add_to_sides(&mut self, context: &StepContext<'_, D>, field: usize, body: &Body<D>, found: &SidedCandidate<D>) {
        if context.grid.fields.len() < 2 {
            return;
        }
        let (candidate, mass) = (&found.candidate, body.particles.mass[found.candidate.particle]);
        context.stencil.of_field(context.grid, field).for_each(context.grid, candidate.inside, |node, weight, _| {
            *self.sides.entry((node as u32, field as u32)).or_insert(0.0) += found.side * mass * weight;
        });
    }

    /// Adds the work on the sheet, whose nodes had the mean velocities `mean` [m/s] during the sub-step.
    fn add_work(&mut self, mean: impl Fn(usize) -> Vector<D>) {
        for contact in self.solver.contacts.iter_mut().filter(|contact| contact.impulse() != Impulse::default()) {
            let nodes = contact.nodes.iter().zip(contact.weights);
            let v: Vector<D> = nodes.map(|(&k, weight)| mean(k as usize) * weight).sum();
            contact.work[0] += contact.impulse().normal.dot(v);
            contact.work[1] += contact.tangent.dot(v);
        }
    }
}

impl<const D: usize> ContactMethod<D> for AtSurface<D> {
    fn find(
        &mut self,
        sheet: &mut ContactSheet<D>,
        surface: &SheetSurface<'_, D>,
        context: &StepContext<'_, D>,
        guarded: &mut Vec<GuardedParticle<D>>,
    ) -> u64 {
        self.solver.begin();
        self.members.clear();
        self.sides.clear();
        sheet.refresh(surface.position, context.grid.cell);
        (0..context.bodies.len()).map(|index| self.find_of(index, sheet, surface, context, guarded)).sum()
    }

    fn separates(&self, node: usize, fields: [usize; 2]) -> bool {
        let [a, b] = fields.map(|field| self.sides.get(&(node as u32, field as u32)).copied().unwrap_or(0.0));
        a * b < 0.0
    }

    /// Finds the effective masses of the contacts, too.
    fn choose(&mut self, sheet: &ContactSheet<D>, context: &StepContext<'_, D>, partners: &mut Partners<D>) {
        let (grid, stencil) = (context.grid, context.stencil);
        let Self { solver: ContactSolver { contacts, support_nodes, .. }, members, .. } = self;
        let supports: Vec<Vec<(u32, Flips, f64)>> = parallel::collect(contacts.len(), STENCILS, |c| {
            let start = if c == 0 { 0 } else { contacts[c - 1].members_end };
            let members = &members[start as usize..contacts[c].members_end as usize];
            support_of(grid, stencil, contacts[c].field as usize, members)
        });
        for (contact, support) in contacts.iter_mut().zip(supports) {
            for (node, flips, weight) in support {
                let partner = partners.add(grid, stencil, contact.field as usize, node as usize);
                contact.inverse_mass += partners.inverse_mass(partner) * (weight * weight);
                support_nodes.push(SupportNode { partner, flips, weight });
            }
            contact.support_end = support_nodes.len() as u32;
            contact.find_effective_mass(&sheet.inverse_mass);
        }
    }

    /// Walls and obstacles come last in each sweep. Nothing is mapped, so that the nodes take up the impulses exactly,
    /// and one pass is enough.
    fn resolve(
        &mut self,
        sheet: &mut ContactSheet<D>,
        surface: &SheetSurface<'_, D>,
        partners: &mut Partners<D>,
        pass: usize,
        at: &SubStep<'_>,
    ) {
        if self.solver.contacts.is_empty() {
            return sheet.resolve_rigid_contact(surface, at);
        }
        if pass > 0 {
            return;
        }
        let ContactSheet { rigid, inverse_mass, forces, after, .. } = sheet;
        after.clear();
        after.extend_from_slice(surface.velocity);
        self.dt = at.momentum_dt;
        self.solver.begin_substep(partners, at.momentum_end);
        self.solver.solve(&mut SheetMotion { velocity: after, inverse_mass }, rigid, at);
        rigid.apply_impulses(forces, self.dt);
        self.solver.apply_impulses(partners, after, forces, self.dt);
        self.add_work(|k| (surface.previous[k] + after[k]) * 0.5);
    }

    /// Gaps have been advanced with the impulses, and nothing is lost in a mapping.
    fn conclude(&mut self, _: &ContactSheet<D>, _: &SheetSurface<'_, D>, _: &Partners<D>, _: &SubStep<'_>) -> f64 {
        0.0
    }

    /// Undoes a part of the overlaps, and keeps the normal force of each contact in the last sub-step.
    fn finish(&self, sheet: &mut ContactSheet<D>, shifts: &mut [Vec<ParticleShift<D>>]) {
        let mut first = 0;
        for contact in &self.solver.contacts {
            let own = &self.members[first..contact.members_end as usize];
            first = contact.members_end as usize;
            if contact.gap < 0.0 {
                let by = contact.normal * (-RECOVERY * contact.gap).min(LARGEST_CORRECTION * contact.half_size);
                let shift =
                    |member: &WeightedParticle<D>| ParticleShift { particle: member.particle, by: by * member.weight };
                shifts[contact.body as usize].extend(own.iter().map(shift));
            }
        }
        for contact in self.solver.contacts.iter().filter(|contact| contact.normal_impulse > 0.0) {
            sheet.labels[contact.body as usize].put_force(contact.key, contact.normal_impulse / self.dt);
        }
    }

    fn add_totals(&self, partners: &Partners<D>, grid: &Grid<D>, dt: f64, sums: &mut [ContactTotals<D>]) {
        let mut start = 0;
        for contact in &self.solver.contacts {
            let near = &self.solver.support_nodes[start as usize..contact.support_end as usize];
            start = contact.support_end;
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

/// Labels a candidate in a step: its side, and true if it has crossed the sheet since the last one.
fn relabel<const D: usize>(labels: &mut Labels, candidate: &Candidate<D>, step: u64) -> (f64, bool) {
    let old = labels.recall(candidate.key, step - 1);
    let label = side_label(old, candidate);
    labels.keep(candidate.key, step, label);
    (label.side, label.crossed && old.is_none_or(|old| !old.crossed))
}

/// Initial data of a contact besides its candidate.
struct ContactStart {
    /// Gap at the start of the step [m].
    gap: f64,
    /// Half the size of the particles there [m].
    half_size: f64,
    /// End of its particles in the list of all.
    members_end: u32,
}

/// A candidate with a side.
struct SidedCandidate<const D: usize> {
    candidate: Candidate<D>,
    /// Particles of the contact.
    members: Vec<WeightedParticle<D>>,
    /// +1 where the normals of the sheet point.
    side: f64,
    /// Normal contact force in the last step [N].
    force: f64,
}

impl<const D: usize> SidedCandidate<D> {
    /// Height above the curved surface of the sheet (theory (D.8)) [m].
    fn height(&self) -> f64 {
        self.side * (self.candidate.foot.distance - self.candidate.foot.bulge)
    }

    /// One of its particles for the guard of positions.
    fn guard(&self, at: ParticleAtSheet, body: &Body<D>, cell: f64) -> GuardedParticle<D> {
        let (p, normal) = (at.particle, self.candidate.foot.normal);
        let error = if body.skin.is_empty() { 0.0 } else { HEIGHT_ERROR * cell };
        let height = self.side * self.candidate.foot.distance - error;
        let beside = SideOfSheet { side: self.side, normal, height };
        GuardedParticle::new(at, beside, guarded_size(body, p, normal, cell), body.particles.position[p])
    }

    /// The contact of the body of this index, in its field, with an element of these nodes.
    fn contact(
        &self,
        index: usize,
        field: usize,
        nodes: [u32; 4],
        friction: Friction,
        &ContactStart { gap, half_size, members_end }: &ContactStart,
    ) -> SurfaceContact<D> {
        let (candidate, side) = (&self.candidate, self.side);
        SurfaceContact {
            field: field as u32,
            body: index as u32,
            key: candidate.key,
            members_end,
            half_size,
            nodes,
            weights: candidate.foot.weights,
            normal: candidate.foot.normal * side,
            arm: side * candidate.foot.distance,
            gap,
            allowed: 0.0,
            // The support nodes are found later.
            support_end: 0,
            inverse_mass: Vector::ZERO,
            free: EffectiveMass::default(),
            friction,
            // The impulse of a second: the warm start depends on the ratios of impulses alone.
            normal_impulse: self.force,
            tangent: Vector::ZERO,
            total: Impulse::default(),
            work: [0.0; 2],
        }
    }
}

/// Half size of a particle for the guard of positions [m]: no more than the distance from its centre to the surface of
/// the body, or the guard would move particles, and with them the skin, that touch the sheet without overlap.
fn guarded_size<const D: usize>(body: &Body<D>, p: usize, normal: Vector<D>, cell: f64) -> f64 {
    let whole = half_size(&body.particles, p, normal, cell);
    if body.skin.is_empty() { whole } else { body.reach(p, normal, cell).max(LEAST_REACH * whole).min(whole) }
}
