//! Contact impulses of a sub-step: their energy, the warm start, and the solution that many sweeps reach.

use super::super::surface_contact::EffectiveMass;
use super::*;
use crate::mpm::contact::impulse::Impulse;
use crate::mpm::{Friction, LeapfrogStep};

const DT: f64 = 0.01;

/// Contacts between 12 heavy nodes of a grid and 7 light ones of a sheet, in a pseudo-random order; the impulses
/// of the last sub-step are `last` [N s] times what `part` gives.
struct ContactProblem {
    solver: ContactSolver<2>,
    velocity: Vec<Vector<2>>,
    inverse_mass: Vec<Vector<2>>,
}

fn part(n: u32) -> f64 {
    f64::from(n * 7919 % 1009) / 1009.0
}

fn problem(last: f64, friction: Friction) -> ContactProblem {
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
            members_end: 0,
            half_size: 0.0,
            nodes: [s % 7, (s + 3) % 7, (s + 3) % 7, (s + 3) % 7],
            weights: [0.6, 0.4, 0.0, 0.0],
            normal: Vector([tilt.sin(), tilt.cos()]),
            arm: 0.0,
            gap: 1e-3 * (part(s + 300) - 0.5),
            allowed: 0.0,
            support_end: solver.support_nodes.len() as u32,
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
    ContactProblem { solver, velocity: (0..7).map(|n| Vector([0.0, part(n + 500)])).collect(), inverse_mass }
}

impl ContactProblem {
    /// [J].
    fn energy(&self) -> f64 {
        let bodies = self.solver.velocity.iter().zip(&self.solver.inverse_mass);
        let bodies: f64 = bodies.map(|(v, inverse_mass)| 0.5 * (v[0] * v[0] + v[1] * v[1]) / inverse_mass[0]).sum();
        let nodes = self.velocity.iter().zip(&self.inverse_mass);
        bodies + nodes.map(|(v, inverse_mass)| 0.5 * v.norm_squared() / inverse_mass[0]).sum::<f64>()
    }

    fn solve(&mut self) {
        let Self { solver, velocity, inverse_mass } = self;
        let step = LeapfrogStep { t: 0.0, dt: DT, dt_previous: DT, momentum_dt: DT };
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
            let approach: f64 = contacts.iter().map(|contact| closing * contact.normal_impulse * contact.allowed).sum();
            assert!(contacts.iter().all(|contact| contact.normal_impulse >= 0.0));
            assert!(contacts.iter().any(|contact| contact.normal_impulse > 0.0));
            assert!(problem.energy() + approach <= before * (1.0 + 1e-12), "{last} {friction:?}");
        }
    }
}

/// From the solution times any number, the warm start is half of the solution.
#[test]
fn the_warm_start_is_half_of_the_best_scale() {
    let solved = ContactProblem::solve_well(1.0);
    let mut scaled = problem(0.0, Friction::Slip(0.0));
    for (contact, other) in scaled.solver.contacts.iter_mut().zip(&solved.solver.contacts) {
        (contact.normal_impulse, contact.allowed) = (1234.5 * other.normal_impulse, other.gap.max(0.0) / DT);
    }
    let ContactProblem { solver, velocity, inverse_mass } = &mut scaled;
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
        let ContactProblem { solver, velocity, .. } = ContactProblem::solve_well(last);
        let mut start = 0;
        for contact in &solver.contacts {
            let near = &solver.support_nodes[start as usize..contact.support_end as usize];
            start = contact.support_end;
            let opening = contact.opening(near, &solver.velocity, &velocity).dot(contact.normal) + contact.allowed;
            assert!(
                opening > -1e-3 && (contact.normal_impulse == 0.0 || opening < 1e-3),
                "{opening} {}",
                contact.normal_impulse
            );
        }
    }
}
