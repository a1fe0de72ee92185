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
            let near = &support_nodes[start as usize..contact.support_end as usize];
            start = contact.support_end;
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
            let near = &support_nodes[start as usize..contact.support_end as usize];
            start = contact.support_end;
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
            let near = &support_nodes[start as usize..contact.support_end as usize];
            start = contact.support_end;
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
mod tests;
