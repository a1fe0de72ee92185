//! Impulses of all points that touch a sheet in a sub-step: projected Gauss–Seidel in a fixed order (theory D.9, D.10).
//!
//! ```text
//! J_n ≥ 0,  w + a ≥ 0,  J_n (w + a) = 0                  w: velocity at which a contact opens, a = max(g, 0)/Δt
//! f(J) = ½ Jᵀ W J + Jᵀ (w⁰ + a),   ΔK = f − Jᵀ a         W = G M⁻¹ Gᵀ, w⁰: before the impulses; K: kinetic energy
//! J⁰ = ½ s J',   s = max(0, −J'ᵀ (w⁰ + a)/J'ᵀ W J')      J': normal impulses of the last sub-step
//! ```
//!
//! The law says that f is least under J_n ≥ 0, and each update minimises f over its impulse. The sweeps start from
//! the normal impulses of the last sub-step, scaled to half of where f is least, with three quarters of that f, which
//! is no more than f(0) = 0: without friction contact never adds energy in a sub-step, converged or not. Loads change
//! little from one sub-step to the next, so that sixteen sweeps do better than thirty from zero. The scale needs one
//! sum over nodes: Jᵀ w⁰ = Σ (GᵀJ)·v and Jᵀ W J = Σ (GᵀJ)²/m. Friction starts from zero.
//!
//! Over whole steps no such proof is known: where two bodies squeeze a light sheet, impulses that are solved to the end
//! give back 0.4 % of the energy, from zero, too, since the motion of particles within a body appears at its nodes, and
//! is stopped, anew in each step. Half of the scale and sixteen sweeps, which stop short of convergence, were chosen by
//! that case (`tests/coupled/slack.rs`); six variations of it only lose energy, too.
//!
//! Vectors at nodes are padded to four numbers, which registers take at once.

use super::surface_contact::{Packed, SupportNode, SurfaceContact, add, pack, turned};
use crate::math::Vector;
use crate::math::simd::{Lanes, Task, widest};
use crate::mpm::SubStep;
use crate::mpm::contact::partner::Partners;
use crate::mpm::contact::rigid::RigidContacts;

/// Most sweeps of the iteration, from zero and from the last sub-step, which it goes on from; and the change of an
/// impulse, relative to the largest one, that ends it.
const SWEEPS: usize = 30;
const SWEEPS_ON: usize = 16;
const SETTLED: f64 = 1e-4;

/// The part of the best scale with which the impulses of the last sub-step begin.
const START: f64 = 0.5;

/// All points that touch one sheet.
#[derive(Debug, Default)]
pub struct ContactSolver<const D: usize> {
    pub contacts: Vec<SurfaceContact<D>>,
    pub support_nodes: Vec<SupportNode>,
    /// Velocities of the partners with the impulses so far [m/s], and their 1/m [1/kg].
    velocity: Vec<Packed>,
    inverse_mass: Vec<Packed>,
    /// GᵀJ of the last sub-step on the partners and on the nodes of the sheet [N s].
    body_impulse: Vec<Packed>,
    sheet_impulse: Vec<Vector<D>>,
}

/// The nodes of a sheet in a sub-step: velocities [m/s] and 1/m [1/kg].
pub struct SheetMotion<'a, const D: usize> {
    pub velocity: &'a mut [Vector<D>],
    pub inverse_mass: &'a [Vector<D>],
}

impl<const D: usize> ContactSolver<D> {
    /// Drops the contacts of the last step.
    pub fn begin(&mut self) {
        self.contacts.clear();
        self.support_nodes.clear();
        self.body_impulse.clear();
    }

    /// Finds the impulses at the end of a sub-step, with walls and obstacles last in each sweep; changes the velocities
    /// of the sheet's nodes.
    pub fn solve(&mut self, sheet: &mut SheetMotion<'_, D>, rigid: &mut RigidContacts<D>, at: &SubStep<'_>) {
        for contact in &mut self.contacts {
            contact.allowed = contact.gap.max(0.0) / at.momentum_dt;
        }
        let sweeps = if self.warm_start(sheet, rigid) { SWEEPS_ON } else { SWEEPS };
        let inverse_mass = sheet.inverse_mass;
        let inverse_mass = |k: usize| inverse_mass[k];
        rigid.sweep(sheet.velocity, &inverse_mass, at.dt);
        for _ in 0..sweeps {
            let (change, largest) = self.sweep(sheet, rigid);
            let (last, most) = rigid.sweep(sheet.velocity, &inverse_mass, at.dt);
            if change <= SETTLED * largest && last <= SETTLED * most {
                break;
            }
        }
    }

    /// One sweep over all points: the largest change of an impulse, and the largest impulse [N s].
    fn sweep(&mut self, sheet: &mut SheetMotion<'_, D>, rigid: &mut RigidContacts<D>) -> (f64, f64) {
        let (contacts, support_nodes, inverse_mass) =
            (&mut self.contacts[..], &self.support_nodes[..], &self.inverse_mass[..]);
        let sheet = SheetMotion { velocity: &mut *sheet.velocity, inverse_mass: sheet.inverse_mass };
        widest(ContactSweep { contacts, support_nodes, body: &mut self.velocity[..], inverse_mass, sheet, rigid })
    }

    /// Reads where the bodies' nodes will be at the time `t` [s] after the start of the step without contact in this
    /// sub-step.
    pub fn begin_substep(&mut self, partners: &Partners<D>, t: f64) {
        self.velocity.clear();
        self.velocity.extend((0..partners.len()).map(|partner| pack(partners.trial(partner as u32, t).1)));
        if self.inverse_mass.len() != self.velocity.len() || self.body_impulse.is_empty() {
            self.inverse_mass.clear();
            self.inverse_mass.extend((0..partners.len()).map(|partner| pack(partners.inverse_mass(partner as u32))));
        }
    }

    /// Starts from the normal impulses of the last sub-step as far as they take energy; from zero, and returns false,
    /// where there were none or where walls and obstacles, which start from zero, are near.
    fn warm_start(&mut self, sheet: &mut SheetMotion<'_, D>, rigid: &RigidContacts<D>) -> bool {
        if self.body_impulse.is_empty() || self.contacts.iter().any(|contact| contact.tangent != Vector::ZERO) {
            self.contacts.iter_mut().for_each(|contact| contact.tangent = Vector::ZERO);
            self.sum_impulses(sheet.velocity.len());
        }
        let scale = if rigid.is_empty() { START * self.scale(sheet) } else { 0.0 };
        for contact in &mut self.contacts {
            contact.normal_impulse *= scale;
        }
        if scale > 0.0 {
            for ((v, body_impulse), inverse_mass) in
                self.velocity.iter_mut().zip(&self.body_impulse).zip(&self.inverse_mass)
            {
                for a in 0..4 {
                    v[a] += scale * body_impulse[a] * inverse_mass[a];
                }
            }
            for ((v, sheet_impulse), inverse_mass) in
                sheet.velocity.iter_mut().zip(&self.sheet_impulse).zip(sheet.inverse_mass)
            {
                *v += Vector::from_fn(|a| scale * sheet_impulse[a] * inverse_mass[a]);
            }
        }
        scale > 0.0
    }

    /// The length s of a step, for which f is least along the impulses of the last sub-step.
    fn scale(&self, sheet: &SheetMotion<'_, D>) -> f64 {
        let (mut slope, mut curvature) = (0.0, 0.0);
        for contact in &self.contacts {
            slope += contact.normal_impulse * contact.allowed;
        }
        for ((v, body_impulse), inverse_mass) in self.velocity.iter().zip(&self.body_impulse).zip(&self.inverse_mass) {
            for a in 0..D {
                slope += body_impulse[a] * v[a];
                curvature += body_impulse[a] * body_impulse[a] * inverse_mass[a];
            }
        }
        for ((v, sheet_impulse), inverse_mass) in sheet.velocity.iter().zip(&self.sheet_impulse).zip(sheet.inverse_mass)
        {
            slope += sheet_impulse.dot(*v);
            curvature += (0..D).map(|a| sheet_impulse[a] * sheet_impulse[a] * inverse_mass[a]).sum::<f64>();
        }
        if slope < 0.0 && curvature > 0.0 { -slope / curvature } else { 0.0 }
    }

    /// GᵀJ of the impulses as they are, on the partners and on so many nodes of the sheet.
    fn sum_impulses(&mut self, nodes: usize) {
        let Self { contacts, support_nodes, body_impulse, sheet_impulse, velocity, .. } = self;
        body_impulse.clear();
        body_impulse.resize(velocity.len(), [0.0; 4]);
        sheet_impulse.clear();
        sheet_impulse.resize(nodes, Vector::ZERO);
        let mut start = 0;
        for contact in contacts {
            let near = &support_nodes[start as usize..contact.end as usize];
            start = contact.end;
            let j = contact.impulse().total();
            if j == Vector::ZERO {
                continue;
            }
            let packed = pack(j);
            for at in near {
                add(&mut body_impulse[at.partner as usize], &turned(packed, at.flips), at.weight);
            }
            for (&k, weight) in contact.nodes.iter().zip(contact.weights) {
                sheet_impulse[k as usize] -= j * weight;
            }
        }
    }

    /// Adds the impulses of a sub-step of the momentum `dt` [s] to the partners and, as forces [N], to the nodes
    /// of the sheet, which then move with `sheet` [m/s]; advances the gaps.
    pub fn apply_impulses(
        &mut self,
        partners: &mut Partners<D>,
        sheet: &[Vector<D>],
        forces: &mut [Vector<D>],
        dt: f64,
    ) {
        self.sum_impulses(sheet.len());
        for (partner, body_impulse) in (0..).zip(&self.body_impulse) {
            partners.add_impulse(partner, Vector::from_fn(|a| body_impulse[a]));
        }
        for (force, sheet_impulse) in forces.iter_mut().zip(&self.sheet_impulse) {
            *force += *sheet_impulse / dt;
        }
        let Self { contacts, support_nodes, velocity, .. } = self;
        let mut start = 0;
        for contact in contacts {
            let near = &support_nodes[start as usize..contact.end as usize];
            start = contact.end;
            let impulse = contact.impulse();
            contact.total.normal += impulse.normal;
            contact.total.tangent += impulse.tangent;
            contact.gap += contact.opening(near, velocity, sheet).dot(contact.normal) * dt;
        }
    }
}

/// One sweep over all points of a sheet: the largest change of an impulse, and the largest impulse [N s].
struct ContactSweep<'a, const D: usize> {
    contacts: &'a mut [SurfaceContact<D>],
    support_nodes: &'a [SupportNode],
    body: &'a mut [Packed],
    inverse_mass: &'a [Packed],
    sheet: SheetMotion<'a, D>,
    rigid: &'a mut RigidContacts<D>,
}

impl<const D: usize> Task for ContactSweep<'_, D> {
    type Output = (f64, f64);

    #[inline(always)]
    fn run<L: Lanes>(self) -> (f64, f64) {
        let Self { contacts, support_nodes, body, inverse_mass, sheet, rigid } = self;
        let (mut start, mut change, mut largest) = (0, 0.0_f64, 0.0_f64);
        for contact in contacts {
            let near = &support_nodes[start as usize..contact.end as usize];
            start = contact.end;
            let opening = contact.opening(near, body, sheet.velocity);
            let beside_rigid = rigid.touches_any(&contact.nodes);
            let delta = if beside_rigid {
                contact.improve_where_held(opening, sheet.inverse_mass, rigid)
            } else {
                contact.improve(opening, contact.free)
            };
            largest = largest.max(contact.normal_impulse);
            if delta == Vector::ZERO {
                continue;
            }
            change = change.max(delta.norm_squared());
            let packed = pack(delta);
            for at in near {
                let (part, inverse_mass) = (turned(packed, at.flips), &inverse_mass[at.partner as usize]);
                let v = &mut body[at.partner as usize];
                for a in 0..4 {
                    v[a] += part[a] * inverse_mass[a] * at.weight;
                }
            }
            for (&k, weight) in contact.nodes.iter().zip(contact.weights).filter(|(_, weight)| *weight > 0.0) {
                let (k, inverse_mass) = (k as usize, sheet.inverse_mass[k as usize]);
                let j = delta * -weight;
                sheet.velocity[k] += if beside_rigid {
                    rigid.apply_impulse(k, j, inverse_mass)
                } else {
                    Vector::from_fn(|a| j[a] * inverse_mass[a])
                };
            }
        }
        (change.sqrt(), largest)
    }
}

#[cfg(test)]
mod tests {
    use super::super::surface_contact::EffectiveMass;
    use super::*;
    use crate::mpm::contact::impulse::Impulse;
    use crate::mpm::{Friction, Step};

    const DT: f64 = 0.01;

    /// Contacts between 12 heavy nodes of a grid and 7 light ones of a sheet, in a pseudo-random order; the impulses
    /// of the last sub-step are `last` [N s] times what `part` gives.
    struct Contacts {
        solver: ContactSolver<2>,
        velocity: Vec<Vector<2>>,
        inverse_mass: Vec<Vector<2>>,
    }

    fn part(n: u32) -> f64 {
        f64::from(n * 7919 % 1009) / 1009.0
    }

    fn problem(last: f64, friction: Friction) -> Contacts {
        let mut solver = ContactSolver::<2> {
            velocity: (0..12).map(|n| [part(n) - 0.5, -part(n + 100), 0.0, 0.0]).collect(),
            inverse_mass: vec![[1.0, 1.0, 0.0, 0.0]; 12],
            ..Default::default()
        };
        let inverse_mass = vec![Vector([100.0, 100.0]); 7];
        for s in 0..20_u32 {
            let support_nodes =
                |k: u32| SupportNode { partner: (s + 5 * k) % 12, flips: 0, weight: [0.5, 0.3, 0.2][k as usize] };
            solver.support_nodes.extend((0..3).map(support_nodes));
            let tilt = 0.3 * (part(s + 50) - 0.5);
            let mut contact = SurfaceContact {
                field: 0,
                body: 0,
                key: s,
                members: 0,
                half_size: 0.0,
                nodes: [s % 7, (s + 3) % 7, (s + 3) % 7, (s + 3) % 7],
                weights: [0.6, 0.4, 0.0, 0.0],
                normal: Vector([tilt.sin(), tilt.cos()]),
                arm: 0.0,
                gap: 1e-3 * (part(s + 300) - 0.5),
                allowed: 0.0,
                end: solver.support_nodes.len() as u32,
                inverse_mass: Vector([0.38, 0.38]),
                free: EffectiveMass::default(),
                friction,
                normal_impulse: last * part(s + 700),
                tangent: Vector::ZERO,
                total: Impulse::default(),
                work: [0.0; 2],
            };
            contact.find_effective_mass(&inverse_mass);
            solver.contacts.push(contact);
        }
        Contacts { solver, velocity: (0..7).map(|n| Vector([0.0, part(n + 500)])).collect(), inverse_mass }
    }

    impl Contacts {
        /// [J].
        fn energy(&self) -> f64 {
            let bodies = self.solver.velocity.iter().zip(&self.solver.inverse_mass);
            let bodies: f64 = bodies.map(|(v, inverse_mass)| 0.5 * (v[0] * v[0] + v[1] * v[1]) / inverse_mass[0]).sum();
            let nodes = self.velocity.iter().zip(&self.inverse_mass);
            bodies + nodes.map(|(v, inverse_mass)| 0.5 * v.norm_squared() / inverse_mass[0]).sum::<f64>()
        }

        fn solve(&mut self) {
            let Self { solver, velocity, inverse_mass } = self;
            let step = Step { t: 0.0, dt: DT, dt_before: DT, momentum_dt: DT };
            let at = SubStep { step: &step, elapsed: 0.0, dt: DT, momentum_end: DT, momentum_dt: DT };
            solver.solve(&mut SheetMotion { velocity, inverse_mass }, &mut RigidContacts::default(), &at);
        }

        /// Goes on with sweeps until nothing changes any more.
        fn solve_well(last: f64) -> Self {
            let mut solved = problem(last, Friction::Slip(0.0));
            solved.solve();
            let Self { solver, velocity, inverse_mass } = &mut solved;
            for _ in 0..1000 {
                solver.sweep(&mut SheetMotion { velocity, inverse_mass }, &mut RigidContacts::default());
            }
            solved
        }
    }

    /// From any start of the sweeps normal impulses are not negative, and the energy falls by Jᵀ a at least.
    #[test]
    fn no_start_adds_energy() {
        for last in [0.0, 1e-6, 1e-2, 1.0, 1e6] {
            for friction in [Friction::Slip(0.0), Friction::Slip(0.3)] {
                let mut problem = problem(last, friction);
                let before = problem.energy();
                problem.solve();
                let contacts = &problem.solver.contacts;
                // With friction it is not proven of the part for the gaps.
                let closing = if friction == Friction::Slip(0.0) { 1.0 } else { 0.0 };
                let approach: f64 =
                    contacts.iter().map(|contact| closing * contact.normal_impulse * contact.allowed).sum();
                assert!(contacts.iter().all(|contact| contact.normal_impulse >= 0.0));
                assert!(contacts.iter().any(|contact| contact.normal_impulse > 0.0));
                assert!(problem.energy() + approach <= before * (1.0 + 1e-12), "{last} {friction:?}");
            }
        }
    }

    /// From the solution times any number, the warm start is half of the solution.
    #[test]
    fn the_warm_start_is_half_of_the_best_scale() {
        let solved = Contacts::solve_well(1.0);
        let mut scaled = problem(0.0, Friction::Slip(0.0));
        for (contact, other) in scaled.solver.contacts.iter_mut().zip(&solved.solver.contacts) {
            (contact.normal_impulse, contact.allowed) = (1234.5 * other.normal_impulse, other.gap.max(0.0) / DT);
        }
        let Contacts { solver, velocity, inverse_mass } = &mut scaled;
        solver.warm_start(&mut SheetMotion { velocity, inverse_mass }, &RigidContacts::default());
        let largest = solved.solver.contacts.iter().map(|contact| contact.normal_impulse).fold(0.0, f64::max);
        for (contact, other) in scaled.solver.contacts.iter().zip(&solved.solver.contacts) {
            let begins = START * other.normal_impulse;
            assert!((contact.normal_impulse - begins).abs() < 1e-3 * largest, "{} {begins}", contact.normal_impulse);
        }
    }

    /// After enough sweeps w + a ≥ 0 at all contacts, and w + a = 0 where J_n > 0.
    #[test]
    fn enough_sweeps_solve_the_problem() {
        for last in [0.0, 1.0] {
            let Contacts { solver, velocity, .. } = Contacts::solve_well(last);
            let mut start = 0;
            for contact in &solver.contacts {
                let near = &solver.support_nodes[start as usize..contact.end as usize];
                start = contact.end;
                let opening = contact.opening(near, &solver.velocity, &velocity).dot(contact.normal) + contact.allowed;
                assert!(
                    opening > -1e-3 && (contact.normal_impulse == 0.0 || opening < 1e-3),
                    "{opening} {}",
                    contact.normal_impulse
                );
            }
        }
    }
}
