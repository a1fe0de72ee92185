//! Which contacts of rigid solids push in a step, and their friction, found from the rigid solids alone before the step is solved
//! (theory (J.16b)).
//!
//! ```text
//! min over q   ½ (q − q₀)·M (q − q₀) + ½ Σ R max(0, w − n·v)² + ½ Σ c |(1 − n ⊗ n) v|²,     M q₀ = h + Tᵀ f of the last step
//! c = μ R max(0, w − n·v)/max(|(1 − n ⊗ n) v|, ε),          v = Σ c_i v_i
//! ```
//!
//! q: independent velocities of the rigid solids. Convex but for c; by active sets, with c renewed in every pass.

use super::contact::{Contact, ContactStep, Impulse, Meeting};
use super::equations::IndependentInertia;
use super::independent::IndependentVelocities;
use super::structure::Structure;
use crate::linalg::{SparseFactor, SparseMatrix};
use crate::math::{Tensor, Vector};

/// Passes at most.
const PASSES: usize = 50;

/// Change of c in a pass, relative to it, that is none.
const SETTLED: f64 = 1e-3;

/// Product of normals from which places of two solids count as one contact.
const SAME_CONTACT: f64 = 0.8;

impl<const D: usize> Structure<D> {
    /// The least distance, at the start of the step and as predicted for its end, of those that meet the same solid, or walls, with about the
    /// same normal [m]; infinite where an elastic solid meets.
    pub(super) fn nearest_places(&self, meetings: &[Meeting<D>], step: &ContactStep<'_, D>) -> Vec<[f64; 2]> {
        let body = |node: u32| self.rigid.iter().position(|body| body.nodes.contains(&(node as usize)));
        let both = |meeting: &Meeting<D>| {
            let [first, last] = [meeting.shares.first()?, meeting.shares.last()?].map(|&(node, _)| body(node));
            Some([first?, last?])
        };
        let distances = |meeting: &Meeting<D>| [meeting.distance_at_start(step), meeting.distance];
        let all: Vec<_> = meetings.iter().map(|meeting| (both(meeting), meeting.normal, distances(meeting))).collect();
        let nearest = |&(own, normal, _): &(Option<[usize; 2]>, Vector<D>, [f64; 2])| {
            let same = all.iter().filter(|(bodies, other, _)| *bodies == own && other.dot(normal) > SAME_CONTACT);
            match own {
                Some(_) => {
                    same.fold([f64::INFINITY; 2], |least, (.., own)| [least[0].min(own[0]), least[1].min(own[1])])
                }
                None => [f64::INFINITY; 2],
            }
        };
        all.iter().map(nearest).collect()
    }
}

/// The rigid solids of a step.
pub(super) struct RigidEquations<'a> {
    /// M and h.
    pub inertia: &'a IndependentInertia,
    /// Tᵀ f of the last step, without impulses [N].
    pub forces: &'a [f64],
    /// The velocities of nodes by the independent ones, of which those of rigid solids are the first.
    pub velocities: &'a IndependentVelocities,
}

/// A contact as a function of the independent velocities.
struct Row<const D: usize> {
    /// ∂v/∂q of those that it depends on.
    entries: Vec<(u32, Vector<D>)>,
    /// v without these [m/s].
    prescribed: Vector<D>,
    normal: Vector<D>,
    resistance: f64,
    impulse: Impulse<D>,
    pushes: bool,
    /// c [N s/m].
    friction: f64,
}

impl<const D: usize> Row<D> {
    fn new(contact: &Contact<D>, velocities: &IndependentVelocities) -> Option<Self> {
        let impulse = *contact.impulse()?;
        let (mut entries, mut prescribed) = (Vec::<(u32, Vector<D>)>::new(), Vector::ZERO);
        for &(node, share) in contact.shares() {
            for axis in 0..D {
                let unknown = node as usize * D + axis;
                prescribed[axis] += share * velocities.prescribed(unknown);
                for (column, value) in velocities.row(unknown) {
                    let place = entries.iter().position(|entry| entry.0 == column).unwrap_or_else(|| {
                        entries.push((column, Vector::ZERO));
                        entries.len() - 1
                    });
                    entries[place].1[axis] += share * value;
                }
            }
        }
        let (normal, resistance) = (contact.normal(), contact.resistance());
        Some(Self { entries, prescribed, normal, resistance, impulse, pushes: false, friction: 0.0 })
    }

    /// Adds minus the derivative of the force, and the force without a velocity.
    fn add(&self, entries: &mut Vec<(u32, u32, f64)>, rhs: &mut [f64]) {
        if !self.pushes {
            return;
        }
        let along = Tensor::outer(self.normal, self.normal);
        let matrix = along * self.resistance + (Tensor::identity() - along) * self.friction;
        let load = self.normal * (self.resistance * self.impulse.wanted) - matrix.apply(self.prescribed);
        for &(row, left) in &self.entries {
            rhs[row as usize] += left.dot(load);
            let left = matrix.apply(left);
            entries.extend(self.entries.iter().map(|&(column, right)| (row, column, left.dot(right))));
        }
    }

    /// Normal force [N], and c that belongs to it, at these velocities.
    fn force_and_friction(&self, q: &[f64]) -> [f64; 2] {
        let velocity = self.entries.iter().map(|&(column, entry)| entry * q[column as usize]).sum::<Vector<D>>();
        let velocity = velocity + self.prescribed;
        let speed = velocity.dot(self.normal);
        let force = self.resistance * (self.impulse.wanted - speed);
        let along = (velocity - self.normal * speed).norm();
        [force, self.impulse.friction * force.max(0.0) / along.max(self.impulse.slowest)]
    }
}

/// Those of these contacts, with walls and among solids, that push, with their friction; those of elastic solids stay.
pub(super) fn pushing<const D: usize>(
    contacts: [Vec<Contact<D>>; 2],
    equations: &RigidEquations<'_>,
) -> [Vec<Contact<D>>; 2] {
    let row = |contact: &Contact<D>| Row::new(contact, equations.velocities);
    let mut rows: [Vec<Option<Row<D>>>; 2] = contacts.each_ref().map(|contacts| contacts.iter().map(row).collect());
    let mut all: Vec<&mut Row<D>> = rows.iter_mut().flatten().flatten().collect();
    if !all.is_empty() {
        find_pushing(&mut all, equations);
    }
    let mut rows = rows.into_iter();
    contacts.map(|contacts| {
        let both = contacts.into_iter().zip(rows.next().unwrap_or_default());
        let kept = both.filter_map(|(contact, row)| match row {
            Some(row) => row.pushes.then(|| contact.with_friction(row.friction)),
            None => Some(contact),
        });
        kept.collect()
    })
}

fn find_pushing<const D: usize>(rows: &mut [&mut Row<D>], equations: &RigidEquations<'_>) {
    let RigidEquations { inertia, forces, .. } = equations;
    let mut free = forces.to_vec();
    inertia.loads.iter().for_each(|&(k, load)| free[k as usize] += load);
    let mut q = vec![0.0; free.len()];
    for _ in 0..PASSES {
        let (mut entries, mut rhs) = (inertia.entries.clone(), free.clone());
        rows.iter().for_each(|row| row.add(&mut entries, &mut rhs));
        if !free.is_empty() {
            let matrix = SparseMatrix::from_triplets(free.len(), entries);
            let Some(mut factor) = SparseFactor::new(&matrix) else { return };
            factor.solve(&rhs, &mut q);
        }
        let found: Vec<[f64; 2]> = rows.iter().map(|row| row.force_and_friction(&q)).collect();
        let mut settled = true;
        for (row, [force, _]) in rows.iter_mut().zip(&found) {
            settled &= row.pushes == (*force > 0.0);
            row.pushes = *force > 0.0;
        }
        // Forces of passes in which others pull are none of a solution, and no measure of friction.
        if !settled {
            continue;
        }
        for (row, [_, friction]) in rows.iter_mut().zip(found) {
            settled &= (friction - row.friction).abs() <= SETTLED * friction;
            row.friction = friction;
        }
        if settled {
            return;
        }
    }
}
