//! The contacts that push in a step, found from its solutions (theory (J.11a), (J.11b)).
//!
//! ```text
//! A v − b = Σ c_j n_j max(0, f_j(v)),      the minimum of a convex function of v
//! f_j(v) = A_j k (g − d_j(v))              of elastic solids,      10⁴ m/Δ (w_j − n·v_j)   of rigid ones
//! A v_s − b = Σ c_j n_j F_j,               F_j = f_j(v_s) of those that act in a solution v_s, else 0
//! v ← v + s (v_s − v),   s in (0, 1]:   Σ_j [(1 − s) F_j(v) + s F_j(v_s) − max(0, f_j)] (v_s − v)·n_j = 0
//! ```
//!
//! Newton's method, of which each solution of the step is one: those with f_j(v) > 0 act in the next one. With
//! the exact length s along its direction it comes to an end, where sets that are simply taken from solutions can go
//! round in circles. Rigid solids begin with those that `impulses` has found with the forces of the
//! step before, and keep the friction that it has given them: none where a contact is found here.

use super::force::Contact;
use crate::math::Vector;

/// A contact that pulls with less than this part of the largest push does no harm, ...
const PULL: f64 = 1e-3;

/// ... nor does one that doesn't act, nearer than the gap by less than this part of it.
const DEPTH: f64 = 0.01;

/// Halvings for the length of a step.
const HALVINGS: usize = 40;

/// f_j(v) and F_j of the iterate.
#[derive(Debug, Clone, Copy, PartialEq)]
struct PushIterate {
    /// f_j(v) [N].
    force: f64,
    /// F_j [N].
    given: f64,
}

/// The search in a step.
#[derive(Debug, Clone, Default)]
pub(in crate::pfem2::solid) struct PushSearch {
    /// The iterate, by contact; empty before the first solution.
    iterate: Vec<PushIterate>,
    solutions: usize,
}

/// f_j and F_j of all contacts in a solution, at the velocities of nodes in it [m/s].
fn solution<const D: usize>(contacts: &[&mut Contact<D>], velocity: &[Vector<D>]) -> Vec<PushIterate> {
    let each = contacts.iter().map(|contact| {
        let force = contact.push(|node| velocity[node]);
        PushIterate { force, given: if contact.is_active { force } else { 0.0 } }
    });
    each.collect()
}

impl PushSearch {
    /// Number of solutions that the search has taken.
    pub fn solutions(&self) -> usize {
        self.solutions
    }

    /// Takes a solution, the velocities of nodes in it [m/s], with which contacts are wrong; returns true if others are
    /// to act in the next one.
    pub fn take_solution<const D: usize>(&mut self, contacts: &mut [&mut Contact<D>], velocity: &[Vector<D>]) -> bool {
        self.solutions += 1;
        let found = solution(contacts, velocity);
        if self.iterate.len() != found.len() {
            self.iterate = found;
        } else {
            let s = self.length(contacts, &found);
            for (own, found) in self.iterate.iter_mut().zip(found) {
                own.force += s * (found.force - own.force);
                own.given += s * (found.given - own.given);
            }
        }
        let mut changed = false;
        for (contact, own) in contacts.iter_mut().zip(&self.iterate) {
            let is_active = own.force > 0.0;
            changed |= is_active != contact.is_active;
            contact.is_active = is_active;
        }
        changed
    }

    /// The length s of the step from the iterate to a solution, (J.11b).
    fn length<const D: usize>(&self, contacts: &[&mut Contact<D>], found: &[PushIterate]) -> f64 {
        let slope = |s: f64| -> f64 {
            let all = contacts.iter().zip(&self.iterate).zip(found);
            let each = all.map(|((contact, own), found)| {
                let change = found.force - own.force;
                let lacks = own.given + s * (found.given - own.given) - (own.force + s * change).max(0.0);
                -lacks * change / contact.resistance()
            });
            each.sum()
        };
        if slope(1.0) <= 0.0 {
            return 1.0;
        }
        let [mut low, mut high] = [0.0, 1.0];
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            *(if slope(middle) > 0.0 { &mut high } else { &mut low }) = middle;
        }
        high
    }
}

/// True if the contacts that act push at these velocities of nodes [m/s], and others don't lie deep in the gap.
pub(in crate::pfem2::solid) fn is_settled<const D: usize>(
    contacts: &[&mut Contact<D>],
    velocity: &[Vector<D>],
) -> bool {
    let found = solution(contacts, velocity);
    let most = found.iter().fold(0.0, |most: f64, contact| most.max(contact.given));
    contacts.iter().zip(&found).all(|(contact, found)| match contact.is_active {
        true => found.force >= -PULL * most,
        false => contact.depth(found.force) <= DEPTH,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::{SparseFactor, SparseMatrix};
    use crate::pfem2::solid::contact::force::{ContactCandidate, ContactLaw, ContactStep, LeastDistances};

    /// Bending stiffness over the third power of the distance of nodes, of a beam that is clamped before the first one:
    /// ½ Σ (w″)².
    fn bending(count: usize) -> Vec<(u32, u32, f64)> {
        let mut entries = Vec::new();
        for middle in 0..count as i64 - 1 {
            let three = [(middle - 1, 1.0), (middle, -2.0), (middle + 1, 1.0)];
            let free = || three.iter().filter(|(node, _)| *node >= 0);
            free().for_each(|&(i, a)| entries.extend(free().map(|&(j, b)| (i as u32, j as u32, a * b))));
        }
        entries.push((0, 0, 1.0));
        entries
    }

    /// Contacts of a beam over a flat floor, one at each of its nodes.
    fn contacts(count: usize, height: f64) -> Vec<Contact<2>> {
        let none = |_: usize| Vector::ZERO;
        let step = ContactStep {
            anew: false,
            dt: 1.0,
            delta: 1.0,
            displacement_offset: &none,
            predicted_increment: &none,
            velocity: &none,
            velocity_increment: &none,
            acceleration: &none,
        };
        let candidate = |node: usize| ContactCandidate {
            point: node,
            coefficients: vec![(node as u32, 1.0)],
            normal: Vector([0.0, 1.0]),
            distance: 1.0 + height,
            gap: 1.0,
            scale: 1.0,
            area: 1.0,
            law: ContactLaw::Elastic(1e3),
            friction: 0.0,
        };
        (0..count).map(|node| Contact::new(Vector::ZERO, candidate(node), LeastDistances::NONE, &step)).collect()
    }

    /// Deflections of the beam under a load at every node, the contacts that act among these, and the number
    /// of solutions.
    fn land(count: usize, load: f64, contacts: &mut [Contact<2>]) -> (Vec<f64>, usize) {
        let mut search = PushSearch::default();
        for solutions in 1..100 {
            let (mut entries, mut rhs) = (bending(count), vec![-load; count]);
            for contact in contacts.iter().filter(|contact| contact.is_active) {
                let node = contact.point;
                entries.push((node as u32, node as u32, contact.resistance()));
                rhs[node] += contact.push(|_| Vector::ZERO);
            }
            let mut found = vec![0.0; count];
            SparseFactor::new(&SparseMatrix::from_triplets(count, entries)).unwrap().solve(&rhs, &mut found);
            let velocity: Vec<Vector<2>> = found.iter().map(|w| Vector([0.0, *w])).collect();
            let mut all: Vec<&mut Contact<2>> = contacts.iter_mut().collect();
            if is_settled(&all, &velocity) || !search.take_solution(&mut all, &velocity) {
                return (found, solutions);
            }
        }
        panic!("no end");
    }

    /// A beam that falls on a floor in one step, whatever its load, lies on it from (72 E I h/q)^¼ on (w = w' = w'' = 0
    /// there), and nothing pulls.
    #[test]
    fn a_beam_lands_in_one_step() {
        let (count, height) = (120, 0.01);
        for span in [25.0f64, 50.0, 90.0] {
            let load = 72.0 * height / span.powi(4);
            let mut contacts = contacts(count, height);
            let (found, solutions) = land(count, load, &mut contacts);
            assert!(solutions <= count, "{span}: {solutions}");
            let first = contacts.iter().position(|contact| contact.is_active).unwrap() as f64;
            assert!((first + 1.0 - span).abs() < 2.0, "{span}: {first}");
            let pushes = contacts.iter().filter(|contact| contact.is_active);
            let forces: Vec<f64> = pushes.map(|contact| contact.push(|k| Vector([0.0, found[k]]))).collect();
            assert!(forces.iter().all(|force| *force > 0.0), "{span}: {forces:?}");
            let rest = count as f64 + 0.5 - 2.0 / 3.0 * span;
            assert!(
                (forces.iter().sum::<f64>() / load / rest - 1.0).abs() < 0.01,
                "{span}: {}",
                forces.iter().sum::<f64>() / load
            );
        }
    }
}
