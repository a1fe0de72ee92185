//! Contact of a sheet with walls and obstacles, at its nodes and, over curved or sharp surfaces, at points of its
//! elements (theory E.10).
//!
//! ```text
//! w = Σ_K W_K v_K − v_w,   g = φ(x) − ½ t |n·ν|,   a = max(g, 0)/Δt        φ: distance, n = ∇φ, ν: normal of the sheet
//! J_n ≥ 0,   w·n + a ≥ 0,   J_n (w·n + a) = 0,   ‖J_t‖ ≤ μ J_n,   v_K ← v_K + W_K J/m_K
//! ```
//!
//! J acts on the sheet here, along n from the solid to the sheet, and the solid gets −J. In contact with bodies J acts
//! on the body, along n from the sheet to the body, and the sign for the sheet turns: v_K ← v_K − W_K J/m_K (theory
//! (D.20)).
//!
//! Moreau's law at the level of velocities: the gap closes at the end of a sub-step at the earliest, restitution is
//! zero, and there is no adhesion. The sheet's edge counts with its thickness only as far as it lies along the
//! surface, so that one that stands on a plane of symmetry is not pushed off. Overlaps are undone by positions alone, a
//! fifth of them in each sub-step.
//!
//! Walls come last in each sweep of the iteration, and take the impulses of bodies that press a sheet against them at
//! once ([`RigidContacts::apply_impulse`]), since a light node between a heavy body and a wall would take as many
//! sweeps to do so as it is lighter.

mod contact_point;
mod node_areas;
mod squeeze;
pub use squeeze::{NodePositions, Squeeze};

use crate::math::Vector;
use crate::mpm::contact::facet::SheetFacet;
use crate::mpm::contact::impulse::Impulse;
use crate::mpm::contact::surface::SheetSurface;
use crate::mpm::wall::{RigidBoundary, SheetPush, Walls};
use crate::mpm::{Friction, SubStep};
use crate::parallel;
use contact_point::RigidContact;
use node_areas::NodeAreas;

/// Distance from a surface within which points are listed [cells]; the list is made anew when sheet and solid may have
/// moved that far.
const REACH: f64 = 0.25;

/// A point that has moved this far [cells] is measured again: on its way along a tangent it leaves what is curved, and
/// what falls back is lost, as by a friction of half of this over the radius.
const MOVED: f64 = 1e-3;

/// The fraction of an overlap that is undone in a sub-step, and the most, in half thicknesses.
const RECOVERY: f64 = 0.2;
const LARGEST_CORRECTION: f64 = 0.05;

/// Sweeps where nothing but walls acts, and the change of an impulse, relative to the largest one, that ends them.
const SWEEPS: usize = 30;
const SETTLED: f64 = 1e-10;

/// A sheet next to walls and obstacles.
#[derive(Debug, Default)]
pub struct RigidContacts<const D: usize> {
    /// Walls and obstacles whose friction with this sheet is given for the pair, by name.
    listed: Vec<(String, Friction)>,
    /// μ with each wall and obstacle; `None` without contact.
    friction: Vec<Option<f64>>,
    contacts: Vec<RigidContact<D>>,
    /// The first of a node's contacts, which follow each other; `NONE` without.
    first: Vec<u32>,
    /// Upper bound of the displacement of sheet and solids since the list was made [m].
    travel: f64,
    /// Sums of the step, by boundary.
    pub pushes: Vec<SheetPush<D>>,
    /// Per node the fraction of its mass that solids held along each axis at the end of the last step.
    pub held: Vec<Vector<D>>,
}

const NONE: u32 = u32::MAX;

impl<const D: usize> RigidContacts<D> {
    /// Contacts of a sheet of so many nodes, with the friction that the case names.
    pub fn new(nodes: usize, listed: Vec<(String, Friction)>) -> Self {
        Self { held: vec![Vector::ZERO; nodes], listed, ..Self::default() }
    }

    /// True if nothing is near.
    pub fn is_empty(&self) -> bool {
        self.contacts.is_empty()
    }

    /// Starts a step: no sums yet, and a new list.
    pub fn begin_step(&mut self, walls: &Walls<D>) {
        let count = walls.solids().map(|solid| solid.number() + 1).max().unwrap_or(0);
        self.pushes.clear();
        self.pushes.resize(count, SheetPush::default());
        self.friction.clear();
        self.friction.resize(count, None);
        for solid in walls.solids() {
            let listed = self.listed.iter().find(|(name, _)| solid.is_named(name));
            self.friction[solid.number()] = match listed.map(|(_, friction)| *friction) {
                None => Some(solid.friction()),
                Some(Friction::None) => None,
                Some(Friction::Slip(coefficient)) => Some(coefficient),
                Some(Friction::Stick) => Some(f64::INFINITY),
            };
        }
        self.travel = f64::INFINITY;
    }

    /// Starts a sub-step: gaps as they are now, no impulses yet.
    pub fn begin(
        &mut self,
        walls: &Walls<D>,
        facets: &[SheetFacet],
        surface: &SheetSurface<'_, D>,
        at: &SubStep<'_>,
        cell: f64,
    ) {
        if self.pushes.is_empty() {
            return;
        }
        let sheet = surface.fastest();
        let origin = surface.position.first().copied().unwrap_or_default();
        let solid = walls.solids().map(|solid| solid.velocity(origin, at.step).norm()).fold(0.0, f64::max);
        self.travel += (sheet + solid) * at.dt;
        if self.travel.is_nan() || self.travel > REACH * cell {
            self.find_contacts(walls, facets, surface, at, cell);
            self.travel = (sheet + solid) * at.dt;
        }
        if self.contacts.is_empty() {
            return;
        }
        let solids: Vec<Option<RigidBoundary<'_, D>>> = self.by_number(walls);
        for contact in &mut self.contacts {
            let Some(solid) = solids[contact.solid as usize] else { continue };
            let x = contact.position(surface.position);
            contact.wall = solid.velocity(x, at.step);
            contact.friction = self.friction[contact.solid as usize].unwrap_or(0.0);
            contact.measure(solid, x, contact.wall * at.elapsed, MOVED * cell);
            contact.impulse = Impulse::default();
            contact.applied = Vector::ZERO;
        }
    }

    fn by_number<'a>(&self, walls: &'a Walls<D>) -> Vec<Option<RigidBoundary<'a, D>>> {
        let mut solids = vec![None; self.pushes.len()];
        walls.solids().for_each(|solid| solids[solid.number()] = Some(solid));
        solids
    }

    /// Lists the contacts near walls and obstacles: at nodes and, over curved or sharp surfaces, at points of elements.
    fn find_contacts(
        &mut self,
        walls: &Walls<D>,
        facets: &[SheetFacet],
        surface: &SheetSurface<'_, D>,
        at: &SubStep<'_>,
        cell: f64,
    ) {
        self.contacts.clear();
        self.first.clear();
        self.first.resize(surface.position.len(), NONE);
        let [lower, upper] = parallel::corners(surface.position.len(), |k| surface.position[k].0).map(Vector);
        let meets = |solid: &RigidBoundary<'_, D>| self.friction[solid.number()].is_some();
        let near: Vec<_> = walls.solids().filter(meets).filter(|s| s.is_near(lower, upper, 2.0 * cell)).collect();
        if near.is_empty() {
            return;
        }
        let areas = NodeAreas::of(facets, surface);
        let of_node =
            |k: usize| near.iter().filter_map(|&solid| areas.contact_at_node(solid, k, surface, at, cell)).collect();
        let lists: Vec<Vec<RigidContact<D>>> = parallel::collect(surface.position.len(), 256, of_node);
        for (k, contacts) in lists.into_iter().enumerate().filter(|(_, contacts)| !contacts.is_empty()) {
            self.first[k] = self.contacts.len() as u32;
            self.contacts.extend(contacts);
        }
        let first = &self.first;
        let of_facet = |e: usize| -> Vec<RigidContact<D>> {
            let facet = &facets[e];
            let close = facet.nodes().iter().any(|&k| first[k as usize] != NONE);
            let size = facet.size(surface.position);
            near.iter()
                .filter(|solid| !solid.is_flat() && (close || size > REACH * cell))
                .flat_map(|&solid| areas.contacts_within(solid, facet, surface, at, cell))
                .collect()
        };
        self.contacts.extend(parallel::collect_all(facets.len(), 256, of_facet));
    }

    /// One sweep over all contacts: the largest change of an impulse, and the largest impulse [N s]. The nodes have the
    /// velocities `v` [m/s] and 1/m `inverse_mass` [1/kg].
    pub fn sweep(&mut self, v: &mut [Vector<D>], inverse_mass: &impl Fn(usize) -> Vector<D>, dt: f64) -> (f64, f64) {
        let (mut change, mut largest) = (0.0_f64, 0.0_f64);
        for contact in &mut self.contacts {
            let delta = contact.update_impulse(v, inverse_mass, dt);
            change = change.max(delta.norm());
            largest = largest.max(contact.impulse.normal.norm());
            if delta != Vector::ZERO {
                for (&k, &weight) in contact.nodes.iter().zip(&contact.weights).filter(|(_, weight)| **weight > 0.0) {
                    let inverse_mass = inverse_mass(k as usize);
                    v[k as usize] += Vector::from_fn(|a| delta[a] * weight * inverse_mass[a]);
                }
            }
        }
        (change, largest)
    }

    /// Sweeps until nothing changes.
    pub fn solve(&mut self, v: &mut [Vector<D>], inverse_mass: &impl Fn(usize) -> Vector<D>, dt: f64) {
        for _ in 0..SWEEPS {
            let (change, largest) = self.sweep(v, inverse_mass, dt);
            if change <= SETTLED * largest {
                break;
            }
        }
    }

    /// True if one of these nodes is next to a wall or an obstacle.
    #[inline(always)]
    pub fn touches_any(&self, nodes: &[u32; 4]) -> bool {
        !self.contacts.is_empty()
            && nodes.iter().any(|&k| self.first.get(k as usize).is_some_and(|&first| first != NONE))
    }

    /// The contacts of a node that hold it.
    fn pressed_contacts(&self, node: usize) -> impl Iterator<Item = &RigidContact<D>> {
        let first = self.first.get(node).copied().unwrap_or(NONE) as usize;
        let own = self.contacts.iter().skip(first).take_while(move |contact| contact.nodes == [node as u32; 4]);
        own.filter(|contact| contact.impulse.normal != Vector::ZERO)
    }

    /// n·(1/m)·n of a node that may be pressed against a wall [1/kg].
    pub fn compliance(&self, node: usize, inverse_mass: Vector<D>, n: Vector<D>) -> f64 {
        let mut free = n;
        for contact in self.pressed_contacts(node) {
            if contact.sticks() {
                return 0.0;
            }
            free -= contact.normal * free.dot(contact.normal);
        }
        (0..D).map(|a| n[a] * inverse_mass[a] * free[a]).sum::<f64>().max(0.0)
    }

    /// True if a contact that holds a node would let go of it under the impulse `j` [N s], or slip.
    pub fn releases(&self, node: usize, j: Vector<D>) -> bool {
        let mut left = j;
        for contact in self.pressed_contacts(node) {
            let mut after = contact.clone();
            left = after.absorb(left);
            if left != Vector::ZERO && (after.impulse == contact.impulse || contact.sticks()) {
                return true;
            }
        }
        false
    }

    /// Gives the impulse `j` [N s] to a node; what it presses against a wall, the wall takes. Returns the change
    /// of the node's velocity [m/s].
    pub fn apply_impulse(&mut self, node: usize, j: Vector<D>, inverse_mass: Vector<D>) -> Vector<D> {
        let mut left = j;
        let first = self.first.get(node).copied().unwrap_or(NONE) as usize;
        let own = self.contacts.iter_mut().skip(first).take_while(|contact| contact.nodes == [node as u32; 4]);
        for contact in own.filter(|contact| contact.impulse.normal != Vector::ZERO) {
            left = contact.absorb(left);
        }
        Vector::from_fn(|a| left[a] * inverse_mass[a])
    }

    /// Adds what the nodes have not got yet to their forces in a sub-step of the momentum `dt` [N, s].
    pub fn apply_impulses(&mut self, forces: &mut [Vector<D>], dt: f64) {
        for contact in &mut self.contacts {
            let total = contact.impulse.total();
            let force = (total - contact.applied) / dt;
            contact.applied = total;
            for (&k, &weight) in contact.nodes.iter().zip(&contact.weights).filter(|(_, weight)| **weight > 0.0) {
                forces[k as usize] += force * weight;
            }
        }
    }

    /// Adds impulses and work of the sub-step, with the final velocities of the nodes.
    pub fn conclude(&mut self, surface: &SheetSurface<'_, D>) {
        for contact in self.contacts.iter().filter(|contact| contact.impulse.normal != Vector::ZERO) {
            let j = contact.impulse.total();
            let push = &mut self.pushes[contact.solid as usize];
            push.impulse += j;
            push.work += j.dot(contact.wall);
            push.received += j.dot((contact.at(surface.velocity) + contact.at(surface.previous)) * 0.5);
        }
    }

    /// Undoes a part of what overlaps after the nodes have moved until `elapsed` [s] after the start of the step,
    /// except along the axes on which they are held.
    pub fn undo_overlaps(&self, position: &mut [Vector<D>], inverse_mass: &impl Fn(usize) -> Vector<D>, elapsed: f64) {
        for contact in &self.contacts {
            let gap = contact.gap_after(position, elapsed);
            if gap < 0.0 {
                let by = contact.normal * (-RECOVERY * gap).min(LARGEST_CORRECTION * contact.half_thickness);
                for (&k, &weight) in contact.nodes.iter().zip(&contact.weights).filter(|(_, weight)| **weight > 0.0) {
                    let inverse_mass = inverse_mass(k as usize);
                    position[k as usize] +=
                        Vector::from_fn(|a| if inverse_mass[a] > 0.0 { by[a] * weight } else { 0.0 });
                }
            }
        }
    }

    /// Notes which nodes solids hold at the end of a step.
    pub fn record_held_fractions(&mut self) {
        self.held.fill(Vector::ZERO);
        for contact in
            self.contacts.iter().filter(|contact| contact.impulse.normal != Vector::ZERO && contact.weights[0] == 1.0)
        {
            let held = &mut self.held[contact.nodes[0] as usize];
            let fraction = |a: usize| if contact.sticks() { 1.0 } else { contact.normal[a] * contact.normal[a] };
            *held = Vector::from_fn(|a| (held[a] + fraction(a)).min(1.0));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A node that is pressed on a floor with 2 N s, in friction of 0.5: it is held against what presses it, and
    /// against pulls up to 2 N s and slides up to half of what is left.
    #[test]
    fn a_floor_lets_go_of_what_is_pulled_or_slides() {
        let impulse = Impulse { normal: Vector([0.0, 2.0]), tangent: Vector::ZERO };
        let contact = RigidContact {
            solid: 0,
            nodes: [0; 4],
            weights: [1.0, 0.0, 0.0, 0.0],
            offset: 0.0,
            half_thickness: 0.0,
            normal: Vector([0.0, 1.0]),
            measured: 0.0,
            anchor: Vector::ZERO,
            gap: 0.0,
            wall: Vector::ZERO,
            friction: 0.5,
            impulse,
            applied: Vector::ZERO,
        };
        let rigid = RigidContacts { contacts: vec![contact], first: vec![0], ..RigidContacts::default() };
        for (j, releases) in
            [([0.0, -5.0], false), ([0.0, 1.5], false), ([0.0, 2.5], true), ([0.9, 0.0], false), ([1.1, 0.0], true)]
        {
            assert_eq!(rigid.releases(0, Vector(j)), releases, "{j:?}");
        }
    }
}
