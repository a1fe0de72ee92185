//! Impulses of all points that touch a sheet in a sub-step: projected Gauss–Seidel in a fixed order.
//!
//! ```text
//! J_n ≥ 0,  w + a ≥ 0,  J_n (w + a) = 0                  w: velocity at which a contact opens, a = max(g, 0)/Δt
//! f(J) = ½ Jᵀ W J + Jᵀ (w⁰ + a),   ΔK = f − Jᵀ a         W = G M⁻¹ Gᵀ, w⁰: before the impulses; K: kinetic energy
//! J⁰ = ½ s J',   s = max(0, −J'ᵀ (w⁰ + a)/J'ᵀ W J')      J': normal impulses of the last sub-step
//! ```
//!
//! The law says that f is least under J_n ≥ 0, and each update lowers it as far as its impulse can. The sweeps start from the normal
//! impulses of the last sub-step, scaled to half of where f is least, with three quarters of that f, which is no more than f(0) = 0: without
//! friction contact never adds energy in a sub-step, converged or not. Loads change little from one sub-step to the next, so that sixteen
//! sweeps do better than thirty from zero. The scale needs one sum over nodes: Jᵀ w⁰ = Σ (GᵀJ)·v and Jᵀ W J = Σ (GᵀJ)²/m. Friction starts
//! from zero.
//!
//! Over whole steps no such proof is known: where two bodies squeeze a light sheet, impulses that are solved to the end give back 0.4 % of the
//! energy, from zero, too, since they stop anew in each step what particles show of their own motion. Half of the scale and sixteen sweeps,
//! which leave a little undone, were chosen by that case (`tests/coupled/slack.rs`); six variations of it only lose energy, too.
//!
//! Vectors at nodes are padded to four numbers, which registers take at once.

use super::surface_contact::{Packed, SupportNode, SurfaceContact, add, pack, turned};
use crate::math::Vector;
use crate::math::simd::{Lanes, Task, widest};
use crate::mpm::contact::partner::Partners;
use crate::mpm::contact::rigid::Rigid;

/// Most sweeps of the iteration, from zero and from the last sub-step, which it goes on from; and the change of an impulse, relative to the
/// largest one, that ends it.
const SWEEPS: usize = 30;
const SWEEPS_ON: usize = 16;
const SETTLED: f64 = 1e-4;

/// The part of the best scale with which the impulses of the last sub-step begin.
const START: f64 = 0.5;

/// All points that touch one sheet.
#[derive(Debug, Default)]
pub struct Solver<const D: usize> {
    pub spots: Vec<SurfaceContact<D>>,
    pub reached: Vec<SupportNode>,
    /// Velocities of the partners with the impulses so far [m/s], and their 1/m [1/kg].
    velocity: Vec<Packed>,
    softness: Vec<Packed>,
    /// GᵀJ of the last sub-step on the partners and on the nodes of the sheet [N s].
    push: Vec<Packed>,
    pull: Vec<Vector<D>>,
}

/// What a solver finds at a sheet in a sub-step: its nodes' velocities [m/s] and 1/m [1/kg].
pub struct Moving<'a, const D: usize> {
    pub velocity: &'a mut [Vector<D>],
    pub softness: &'a [Vector<D>],
}

impl<const D: usize> Solver<D> {
    /// Forgets the last step.
    pub fn begin(&mut self) {
        self.spots.clear();
        self.reached.clear();
        self.push.clear();
    }

    /// Finds the impulses at the end of a sub-step of the momentum `dt` [s], with walls and obstacles last in each sweep; changes the
    /// velocities of the sheet's nodes.
    pub fn solve(&mut self, sheet: &mut Moving<'_, D>, rigid: &mut Rigid<D>, [dt, rigid_dt]: [f64; 2]) {
        for spot in &mut self.spots {
            spot.allowed = spot.gap.max(0.0) / dt;
        }
        let sweeps = if self.start(sheet, rigid) { SWEEPS_ON } else { SWEEPS };
        let softness = sheet.softness;
        let soft = |k: usize| softness[k];
        rigid.sweep(sheet.velocity, &soft, rigid_dt);
        for _ in 0..sweeps {
            let (change, largest) = self.sweep(sheet, rigid);
            let (last, most) = rigid.sweep(sheet.velocity, &soft, rigid_dt);
            if change <= SETTLED * largest && last <= SETTLED * most {
                break;
            }
        }
    }

    /// One sweep over all points: the largest change of an impulse, and the largest impulse [N s].
    fn sweep(&mut self, sheet: &mut Moving<'_, D>, rigid: &mut Rigid<D>) -> (f64, f64) {
        let (spots, reached, softness) = (&mut self.spots[..], &self.reached[..], &self.softness[..]);
        let sheet = Moving { velocity: &mut *sheet.velocity, softness: sheet.softness };
        widest(Sweep { spots, reached, body: &mut self.velocity[..], softness, sheet, rigid })
    }

    /// Reads where the bodies' nodes will be at the time `t` [s] after the start of the step without contact in this sub-step.
    pub fn load(&mut self, partners: &Partners<D>, t: f64) {
        self.velocity.clear();
        self.velocity.extend((0..partners.len()).map(|partner| pack(partners.trial(partner as u32, t).1)));
        if self.softness.len() != self.velocity.len() || self.push.is_empty() {
            self.softness.clear();
            self.softness.extend((0..partners.len()).map(|partner| pack(partners.softness(partner as u32))));
        }
    }

    /// Starts from the normal impulses of the last sub-step as far as they take energy; from zero, and returns false, where there were
    /// none or where walls and obstacles, which start from zero, are near.
    fn start(&mut self, sheet: &mut Moving<'_, D>, rigid: &Rigid<D>) -> bool {
        if self.push.is_empty() || self.spots.iter().any(|spot| spot.tangent != Vector::ZERO) {
            self.spots.iter_mut().for_each(|spot| spot.tangent = Vector::ZERO);
            self.spread(sheet.velocity.len());
        }
        let scale = if rigid.is_empty() { START * self.scale(sheet) } else { 0.0 };
        for spot in &mut self.spots {
            spot.pressed *= scale;
        }
        if scale > 0.0 {
            for ((v, push), soft) in self.velocity.iter_mut().zip(&self.push).zip(&self.softness) {
                for a in 0..4 {
                    v[a] += scale * push[a] * soft[a];
                }
            }
            for ((v, pull), soft) in sheet.velocity.iter_mut().zip(&self.pull).zip(sheet.softness) {
                *v += Vector::from_fn(|a| scale * pull[a] * soft[a]);
            }
        }
        scale > 0.0
    }

    /// s, for which f is least along the impulses of the last sub-step.
    fn scale(&self, sheet: &Moving<'_, D>) -> f64 {
        let (mut slope, mut curvature) = (0.0, 0.0);
        for spot in &self.spots {
            slope += spot.pressed * spot.allowed;
        }
        for ((v, push), soft) in self.velocity.iter().zip(&self.push).zip(&self.softness) {
            for a in 0..D {
                slope += push[a] * v[a];
                curvature += push[a] * push[a] * soft[a];
            }
        }
        for ((v, pull), soft) in sheet.velocity.iter().zip(&self.pull).zip(sheet.softness) {
            slope += pull.dot(*v);
            curvature += (0..D).map(|a| pull[a] * pull[a] * soft[a]).sum::<f64>();
        }
        if slope < 0.0 && curvature > 0.0 { -slope / curvature } else { 0.0 }
    }

    /// GᵀJ of the impulses as they are, on the partners and on so many nodes of the sheet.
    fn spread(&mut self, nodes: usize) {
        let Self { spots, reached, push, pull, velocity, .. } = self;
        push.clear();
        push.resize(velocity.len(), [0.0; 4]);
        pull.clear();
        pull.resize(nodes, Vector::ZERO);
        let mut start = 0;
        for spot in spots {
            let near = &reached[start as usize..spot.end as usize];
            start = spot.end;
            let j = spot.impulse().total();
            if j == Vector::ZERO {
                continue;
            }
            let packed = pack(j);
            for at in near {
                add(&mut push[at.partner as usize], &turned(packed, at.flips), at.weight);
            }
            for (&k, weight) in spot.nodes.iter().zip(spot.weights) {
                pull[k as usize] -= j * weight;
            }
        }
    }

    /// Gives the impulses of a sub-step of the momentum `dt` [s] to the partners and, as forces [N], to the nodes of the sheet, which move
    /// with `sheet` [m/s] then; gaps follow.
    pub fn hand_over(&mut self, partners: &mut Partners<D>, sheet: &[Vector<D>], forces: &mut [Vector<D>], dt: f64) {
        self.spread(sheet.len());
        for (partner, push) in (0..).zip(&self.push) {
            partners.push(partner, Vector::from_fn(|a| push[a]));
        }
        for (force, pull) in forces.iter_mut().zip(&self.pull) {
            *force += *pull / dt;
        }
        let Self { spots, reached, velocity, .. } = self;
        let mut start = 0;
        for spot in spots {
            let near = &reached[start as usize..spot.end as usize];
            start = spot.end;
            let impulse = spot.impulse();
            spot.total.normal += impulse.normal;
            spot.total.tangent += impulse.tangent;
            spot.gap += spot.opening(near, velocity, sheet).dot(spot.normal) * dt;
        }
    }
}

/// One sweep over all points of a sheet: the largest change of an impulse, and the largest impulse [N s].
struct Sweep<'a, const D: usize> {
    spots: &'a mut [SurfaceContact<D>],
    reached: &'a [SupportNode],
    body: &'a mut [Packed],
    softness: &'a [Packed],
    sheet: Moving<'a, D>,
    rigid: &'a mut Rigid<D>,
}

impl<const D: usize> Task for Sweep<'_, D> {
    type Output = (f64, f64);

    #[inline(always)]
    fn run<L: Lanes>(self) -> (f64, f64) {
        let Self { spots, reached, body, softness, sheet, rigid } = self;
        let (mut start, mut change, mut largest) = (0, 0.0_f64, 0.0_f64);
        for spot in spots {
            let near = &reached[start as usize..spot.end as usize];
            start = spot.end;
            let opening = spot.opening(near, body, sheet.velocity);
            let rests = rigid.touches_any(&spot.nodes);
            let delta =
                if rests { spot.push_held(opening, sheet.softness, rigid) } else { spot.push(opening, spot.free) };
            largest = largest.max(spot.pressed);
            if delta == Vector::ZERO {
                continue;
            }
            change = change.max(delta.norm_squared());
            let packed = pack(delta);
            for at in near {
                let (part, soft) = (turned(packed, at.flips), &softness[at.partner as usize]);
                let v = &mut body[at.partner as usize];
                for a in 0..4 {
                    v[a] += part[a] * soft[a] * at.weight;
                }
            }
            for (&k, weight) in spot.nodes.iter().zip(spot.weights).filter(|(_, weight)| *weight > 0.0) {
                let (k, soft) = (k as usize, sheet.softness[k as usize]);
                let j = delta * -weight;
                sheet.velocity[k] += if rests { rigid.give(k, j, soft) } else { Vector::from_fn(|a| j[a] * soft[a]) };
            }
        }
        (change.sqrt(), largest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points between 12 heavy nodes of a grid and 7 light ones of a sheet, in an order without a pattern; the impulses of the last
    /// sub-step are `last` [N s] times what `part` gives.
    struct Problem {
        solver: Solver<2>,
        velocity: Vec<Vector<2>>,
        softness: Vec<Vector<2>>,
    }

    fn part(n: u32) -> f64 {
        f64::from(n * 7919 % 1009) / 1009.0
    }

    fn problem(last: f64, friction: Friction) -> Problem {
        let mut solver = Solver::<2> {
            velocity: (0..12).map(|n| [part(n) - 0.5, -part(n + 100), 0.0, 0.0]).collect(),
            softness: vec![[1.0, 1.0, 0.0, 0.0]; 12],
            ..Default::default()
        };
        let softness = vec![Vector([100.0, 100.0]); 7];
        for s in 0..20_u32 {
            let reached =
                |k: u32| SupportNode { partner: (s + 5 * k) % 12, flips: 0, weight: [0.5, 0.3, 0.2][k as usize] };
            solver.reached.extend((0..3).map(reached));
            let tilt = 0.3 * (part(s + 50) - 0.5);
            let mut spot = SurfaceContact {
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
                end: solver.reached.len() as u32,
                softness: Vector([0.38, 0.38]),
                free: Stiffness::default(),
                friction,
                pressed: last * part(s + 700),
                tangent: Vector::ZERO,
                total: Impulse::default(),
                work: [0.0; 2],
            };
            spot.stiffen(&softness);
            solver.spots.push(spot);
        }
        Problem { solver, velocity: (0..7).map(|n| Vector([0.0, part(n + 500)])).collect(), softness }
    }

    impl Problem {
        /// [J].
        fn energy(&self) -> f64 {
            let bodies = self.solver.velocity.iter().zip(&self.solver.softness);
            let bodies: f64 = bodies.map(|(v, soft)| 0.5 * (v[0] * v[0] + v[1] * v[1]) / soft[0]).sum();
            let nodes = self.velocity.iter().zip(&self.softness);
            bodies + nodes.map(|(v, soft)| 0.5 * v.norm_squared() / soft[0]).sum::<f64>()
        }

        fn solve(&mut self) {
            let Self { solver, velocity, softness } = self;
            solver.solve(&mut Moving { velocity, softness }, &mut Rigid::default(), [0.01; 2]);
        }

        /// Goes on with sweeps until nothing changes any more.
        fn solve_well(last: f64) -> Self {
            let mut solved = problem(last, Friction::Slip(0.0));
            solved.solve();
            let Self { solver, velocity, softness } = &mut solved;
            for _ in 0..1000 {
                solver.sweep(&mut Moving { velocity, softness }, &mut Rigid::default());
            }
            solved
        }
    }

    /// Whatever the sweeps start from, nothing is pulled and no energy made, by the impulses that approach takes over a gap least.
    #[test]
    fn no_start_adds_energy() {
        for last in [0.0, 1e-6, 1e-2, 1.0, 1e6] {
            for friction in [Friction::Slip(0.0), Friction::Slip(0.3)] {
                let mut problem = problem(last, friction);
                let before = problem.energy();
                problem.solve();
                let spots = &problem.solver.spots;
                // With friction it is not proven of the part for the gaps.
                let closing = if friction == Friction::Slip(0.0) { 1.0 } else { 0.0 };
                let approach: f64 = spots.iter().map(|spot| closing * spot.pressed * spot.allowed).sum();
                assert!(spots.iter().all(|spot| spot.pressed >= 0.0));
                assert!(spots.iter().any(|spot| spot.pressed > 0.0));
                assert!(problem.energy() + approach <= before * (1.0 + 1e-12), "{last} {friction:?}");
            }
        }
    }

    /// The start is half of the best one: of the impulses that solve the problem, times any number, half of the solution.
    #[test]
    fn the_start_finds_the_scale() {
        let solved = Problem::solve_well(1.0);
        let mut scaled = problem(0.0, Friction::Slip(0.0));
        for (spot, other) in scaled.solver.spots.iter_mut().zip(&solved.solver.spots) {
            (spot.pressed, spot.allowed) = (1234.5 * other.pressed, other.gap.max(0.0) / 0.01);
        }
        let Problem { solver, velocity, softness } = &mut scaled;
        solver.start(&mut Moving { velocity, softness }, &Rigid::default());
        let largest = solved.solver.spots.iter().map(|spot| spot.pressed).fold(0.0, f64::max);
        for (spot, other) in scaled.solver.spots.iter().zip(&solved.solver.spots) {
            let begins = START * other.pressed;
            assert!((spot.pressed - begins).abs() < 1e-3 * largest, "{} {begins}", spot.pressed);
        }
    }

    /// After enough sweeps nothing closes its gap too early, and what doesn't push may open.
    #[test]
    fn enough_sweeps_solve_the_problem() {
        for last in [0.0, 1.0] {
            let Problem { solver, velocity, .. } = Problem::solve_well(last);
            let mut start = 0;
            for spot in &solver.spots {
                let near = &solver.reached[start as usize..spot.end as usize];
                start = spot.end;
                let opening = spot.opening(near, &solver.velocity, &velocity).dot(spot.normal) + spot.allowed;
                assert!(opening > -1e-3 && (spot.pressed == 0.0 || opening < 1e-3), "{opening} {}", spot.pressed);
            }
        }
    }
}
