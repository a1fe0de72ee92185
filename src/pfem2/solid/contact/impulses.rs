//! The contacts of rigid solids that push in a step, and their friction, found from the rigid solids alone before
//! the step is solved (theory (J.16b)).
//!
//! ```text
//! min over q   ½ (q − q₀)·M (q − q₀) + ½ Σ R max(0, w − n·v)² + ½ Σ c |(1 − n ⊗ n) v|²,   M q₀ = h + Tᵀ f of the last step
//! c = μ R max(0, w − n·v)/max(|(1 − n ⊗ n) v|, ε),          v = Σ c_i v_i
//! ```
//!
//! q: independent velocities of the rigid solids. Convex but for c; by active sets, with c renewed in every pass.

use super::force::{Contact, ContactCandidate, ContactStep, LeastDistances, RigidImpulse};
use crate::linalg::{MatrixEntry, SparseFactor, SparseMatrix};
use crate::math::{Tensor, Vector};
use crate::pfem2::solid::equations::IndependentInertia;
use crate::pfem2::solid::equations::independent::IndependentVelocities;
use crate::pfem2::solid::structure::Structure;

/// Passes at most.
const PASSES: usize = 50;

/// Change of c in a pass, relative to it, that is none.
const SETTLED: f64 = 1e-3;

/// Cosine of the angle between normals from which places of two solids count as one contact.
const SAME_CONTACT_COSINE: f64 = 0.8;

impl<const D: usize> Structure<D> {
    /// The least distances that go with each candidate: over those of the same two solids, or of a solid and walls,
    /// with about the same normal.
    pub(super) fn least_distances(
        &self,
        candidates: &[ContactCandidate<D>],
        step: &ContactStep<'_, D>,
    ) -> Vec<LeastDistances> {
        let body = |node: u32| self.rigid.iter().position(|body| body.nodes.contains(&(node as usize)));
        let both = |candidate: &ContactCandidate<D>| {
            let [first, last] =
                [candidate.coefficients.first()?, candidate.coefficients.last()?].map(|&(node, _)| body(node));
            Some([first?, last?])
        };
        let bodies: Vec<Option<[usize; 2]>> = candidates.iter().map(both).collect();
        let distances = |candidate: &ContactCandidate<D>| LeastDistances {
            start: candidate.distance_at_start(step),
            predicted: candidate.distance,
        };
        let all: Vec<LeastDistances> = candidates.iter().map(distances).collect();
        let least = |k: usize| {
            let normal = candidates[k].normal;
            let is_same = |&n: &usize| bodies[n] == bodies[k] && candidates[n].normal.dot(normal) > SAME_CONTACT_COSINE;
            let same = (0..candidates.len()).filter(|_| bodies[k].is_some()).filter(is_same);
            same.fold(LeastDistances::NONE, |least, n| least.min(all[n]))
        };
        (0..candidates.len()).map(least).collect()
    }
}

/// The rigid solids of a step.
pub(in crate::pfem2::solid) struct RigidEquations<'a> {
    /// M and h.
    pub inertia: &'a IndependentInertia,
    /// Tᵀ f of the last step, without impulses [N].
    pub forces: &'a [f64],
    /// The velocities of nodes by the independent ones, of which those of rigid solids are the first.
    pub velocities: &'a IndependentVelocities,
}

/// A contact as a function of the independent velocities.
struct ContactRow<const D: usize> {
    /// ∂v/∂q of those that it depends on.
    entries: Vec<(u32, Vector<D>)>,
    /// v without these [m/s].
    prescribed: Vector<D>,
    normal: Vector<D>,
    resistance: f64,
    impulse: RigidImpulse<D>,
    pushes: bool,
    /// c [N s/m].
    friction: f64,
}

impl<const D: usize> ContactRow<D> {
    fn new(contact: &Contact<D>, velocities: &IndependentVelocities) -> Option<Self> {
        let impulse = *contact.impulse()?;
        let (mut entries, mut prescribed) = (Vec::<(u32, Vector<D>)>::new(), Vector::ZERO);
        for &(node, coefficient) in contact.coefficients() {
            for axis in 0..D {
                let unknown = node as usize * D + axis;
                prescribed[axis] += coefficient * velocities.prescribed(unknown);
                for (column, value) in velocities.row(unknown) {
                    let place = entries.iter().position(|entry| entry.0 == column).unwrap_or_else(|| {
                        entries.push((column, Vector::ZERO));
                        entries.len() - 1
                    });
                    entries[place].1[axis] += coefficient * value;
                }
            }
        }
        let (normal, resistance) = (contact.normal(), contact.resistance());
        Some(Self { entries, prescribed, normal, resistance, impulse, pushes: false, friction: 0.0 })
    }

    /// Adds minus the derivative of the force, and the force without a velocity.
    fn add(&self, entries: &mut Vec<MatrixEntry>, rhs: &mut [f64]) {
        if !self.pushes {
            return;
        }
        let along = Tensor::outer(self.normal, self.normal);
        let matrix = along * self.resistance + (Tensor::identity() - along) * self.friction;
        let load = self.normal * (self.resistance * self.impulse.target_velocity) - matrix.apply(self.prescribed);
        for &(row, left) in &self.entries {
            rhs[row as usize] += left.dot(load);
            let left = matrix.apply(left);
            entries.extend(self.entries.iter().map(|&(column, right)| MatrixEntry::new(row, column, left.dot(right))));
        }
    }

    /// c where the point pushes with this force [N], at the velocity along the surface with which the step begins [N s/m].
    fn friction_before(&self, force: f64) -> f64 {
        let before = self.impulse.before;
        let along = (before - self.normal * before.dot(self.normal)).norm();
        self.impulse.friction * force.max(0.0) / along.max(self.impulse.slowest)
    }

    /// Normal force [N], and c that belongs to it, at these velocities.
    fn force_and_friction(&self, q: &[f64]) -> [f64; 2] {
        let velocity = self.entries.iter().map(|&(column, entry)| entry * q[column as usize]).sum::<Vector<D>>();
        let velocity = velocity + self.prescribed;
        let speed = velocity.dot(self.normal);
        let force = self.resistance * (self.impulse.target_velocity - speed);
        let along = (velocity - self.normal * speed).norm();
        [force, self.impulse.friction * force.max(0.0) / along.max(self.impulse.slowest)]
    }
}

/// These contacts, with walls and among solids, of which those of rigid solids act that push, with their friction.
pub(super) fn pushing<const D: usize>(
    contacts: [Vec<Contact<D>>; 2],
    equations: &RigidEquations<'_>,
) -> [Vec<Contact<D>>; 2] {
    let row = |contact: &Contact<D>| ContactRow::new(contact, equations.velocities);
    let mut rows = contacts.each_ref().map(|contacts| contacts.iter().map(row).collect::<Vec<_>>());
    let mut all: Vec<&mut ContactRow<D>> = rows.iter_mut().flatten().flatten().collect();
    if !all.is_empty() {
        find_pushing(&mut all, equations);
    }
    let mut rows = rows.into_iter();
    contacts.map(|contacts| {
        let both = contacts.into_iter().zip(rows.next().unwrap_or_default());
        let found = both.map(|(contact, row)| match row {
            Some(row) => contact.found(row.pushes, row.friction),
            None => contact,
        });
        found.collect()
    })
}

/// Finds the contacts that push, and their friction, by active sets (theory (J.16b)).
fn find_pushing<const D: usize>(rows: &mut [&mut ContactRow<D>], equations: &RigidEquations<'_>) {
    let RigidEquations { inertia, forces, .. } = equations;
    let mut free = forces.to_vec();
    inertia.loads.iter().for_each(|&(k, load)| free[k as usize] += load);
    let (mut q, mut is_smooth) = (vec![0.0; free.len()], true);
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
        // A contact that stuck in the last step most likely sticks: from a solution that slides that takes many passes.
        for (row, [force, friction]) in rows.iter_mut().zip(found) {
            let friction = if is_smooth { row.friction_before(force) } else { friction };
            settled &= (friction - row.friction).abs() <= SETTLED * friction;
            row.friction = friction;
        }
        is_smooth = false;
        if settled {
            return;
        }
    }
}
