//! Impulses at one grid node: one partner in the middle (a sheet, or a body) and those that touch it.
//!
//! ```text
//! u_b = v̄_b·n                                    normal trial velocity, n the normal of the middle partner
//! V:  m_r (V − u_r) + Σ₊ m_b ⟨V − u_b⟩₊ − Σ₋ m_b ⟨u_b − V⟩₊ = 0
//! λ_b = m_b |V − u_b|  where + bodies have u_b < V, − bodies u_b > V     (theory (D.12); Lian (54, 55))
//! T_b = m_b (V_t − v̄_b,t),  ‖T_b‖ ≤ μ_f λ_b                              (theory D.6; Lian (56–58), corrected)
//! J_b = c λ_b n + T_b  on the body, c = ±1 its side;  −Σ J_b on the middle partner
//! ```
//!
//! `+` bodies lie on the side that n points to. The first equation is the exact solution of the strictly
//! convex problem with the constraints v₊·n ≥ V ≥ v₋·n: its left side grows with V, so that V is unique and
//! no enumeration of active sets is needed. With one body the normal part is that of J = M (v̄_r − v̄_s), with M = m_r
//! m_s/(m_r + m_s): Lian (55) with the right sign, which has −J on the sheet r.

use crate::math::Vector;
use crate::mpm::Friction;

/// A body that touches the middle partner at this node.
#[derive(Debug, Clone, Copy)]
pub struct Touch<const D: usize> {
    /// Nodal mass m_b [kg].
    pub mass: f64,
    /// Trial velocity v̄_b [m/s].
    pub velocity: Vector<D>,
    /// +1: on the side that the normal points to; −1: on the other.
    pub side: f64,
    /// Law in the tangential direction.
    pub friction: Friction,
}

/// The impulse that a body receives; the middle partner receives the opposite.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Impulse<const D: usize> {
    /// Impulse along the normal [N s].
    pub normal: Vector<D>,
    /// Friction [N s].
    pub tangent: Vector<D>,
}

impl<const D: usize> Impulse<D> {
    /// Normal and tangential part together [N s].
    pub fn total(&self) -> Vector<D> {
        self.normal + self.tangent
    }
}

/// Energy that one pair has dissipated [J].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PairDissipation {
    /// Inelastic impact along the normals.
    pub normal: f64,
    pub friction: f64,
}

/// Sums over the contact with one body in a step.
#[derive(Debug, Clone, Copy, Default)]
pub struct ContactTotals<const D: usize> {
    /// Σ J on the body [N s].
    pub impulse: Vector<D>,
    /// Energy dissipated.
    pub dissipated: PairDissipation,
    /// Angular momentum that appeared because the two impulses of a pair act at different places: Σ (x_s − x_r) × J
    /// [N m s] (theory (D.28)).
    pub spin: Vector<3>,
}

impl<const D: usize> ContactTotals<D> {
    /// Adds a pair: its impulse `j` on the body; the `work` J·v̂_r of its normal and its tangential part at the
    /// velocity of the middle partner [J]; the mean velocity `v` of the body, v̂_b [m/s]; the `arm` from the middle
    /// partner to the body [m]. J·(v̂_r − v̂_b) is dissipated (theory (D.29)).
    pub fn add(&mut self, j: &Impulse<D>, work: [f64; 2], v: Vector<D>, arm: Vector<D>) {
        self.impulse += j.total();
        self.dissipated.normal += work[0] - j.normal.dot(v);
        self.dissipated.friction += work[1] - j.tangent.dot(v);
        self.spin += Vector(arm.to3()).cross(Vector(j.total().to3()));
    }
}

/// Solves one node: `mass` [kg] and trial `velocity` [m/s] of the middle partner, its unit `normal`, and the
/// bodies that touch it. Fills `impulses` with one entry per touch.
pub fn solve<const D: usize>(
    mass: f64,
    velocity: Vector<D>,
    normal: Vector<D>,
    touches: &[Touch<D>],
    impulses: &mut Vec<Impulse<D>>,
) {
    let common = common_velocity(mass, velocity.dot(normal), normal, touches);
    impulses.clear();
    impulses.extend(touches.iter().map(|touch| {
        let approach = touch.side * (common - touch.velocity.dot(normal));
        // Of one body the normal part of Lian (55), with the right sign: theory (D.11), (D.12).
        Impulse { normal: normal * (touch.side * touch.mass * approach.max(0.0)), tangent: Vector::ZERO }
    }));
    let rough = touches.iter().any(|t| t.friction != Friction::Slip(0.0));
    if rough {
        add_friction(mass, velocity, normal, touches, impulses);
    }
}

/// The normal velocity V that the middle partner and all bodies pressed against it share (theory (D.12)).
fn common_velocity<const D: usize>(mass: f64, u: f64, normal: Vector<D>, touches: &[Touch<D>]) -> f64 {
    let excess = |v: f64| {
        touches
            .iter()
            .fold(mass * (v - u), |sum, t| sum + t.side * t.mass * (t.side * (v - t.velocity.dot(normal))).max(0.0))
    };
    let (mut below, mut above) = (f64::NEG_INFINITY, f64::INFINITY);
    for touch in touches {
        let kink = touch.velocity.dot(normal);
        if excess(kink) <= 0.0 {
            below = below.max(kink);
        } else {
            above = above.min(kink);
        }
    }
    // Lian (54): those that touch move on together, with the momentum that they had.
    let (mut m, mut p) = (mass, mass * u);
    for touch in touches {
        let kink = touch.velocity.dot(normal);
        if (touch.side > 0.0 && kink <= below) || (touch.side < 0.0 && kink >= above) {
            m += touch.mass;
            p += touch.mass * kink;
        }
    }
    p / m
}

/// Friction: all rough contacts stick at first; those beyond Coulomb's limit slide, and the rest stick
/// again (theory D.6).
fn add_friction<const D: usize>(
    mass: f64,
    velocity: Vector<D>,
    normal: Vector<D>,
    touches: &[Touch<D>],
    impulses: &mut [Impulse<D>],
) {
    let tangential = |v: Vector<D>| v - normal * v.dot(normal);
    let mut slides: Vec<bool> =
        touches.iter().zip(&*impulses).map(|(t, j)| limit(t.friction, j.normal.norm()) == 0.0).collect();
    loop {
        let (mut m, mut p) = (mass, tangential(velocity) * mass);
        for ((touch, impulse), &slides) in touches.iter().zip(&*impulses).zip(&slides) {
            if slides {
                p -= impulse.tangent;
            } else {
                m += touch.mass;
                p += tangential(touch.velocity) * touch.mass;
            }
        }
        let mut settled = true;
        for ((touch, impulse), slides) in touches.iter().zip(&mut *impulses).zip(&mut slides) {
            if *slides {
                continue;
            }
            // Lian (57), whose normal part is Lian (56); no more than Lian (58) allows.
            impulse.tangent = (p / m - tangential(touch.velocity)) * touch.mass;
            let (size, most) = (impulse.tangent.norm(), limit(touch.friction, impulse.normal.norm()));
            if size > most {
                impulse.tangent *= most / size;
                *slides = true;
                settled = false;
            }
        }
        if settled {
            return;
        }
    }
}

/// The largest friction impulse [N s] under the normal impulse [N s].
pub(super) fn limit(friction: Friction, normal_impulse: f64) -> f64 {
    match friction {
        Friction::None => 0.0,
        Friction::Slip(coefficient) => coefficient * normal_impulse,
        Friction::Stick if normal_impulse > 0.0 => f64::INFINITY,
        Friction::Stick => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn touch(mass: f64, velocity: [f64; 2], side: f64, friction: Friction) -> Touch<2> {
        Touch { mass, velocity: Vector(velocity), side, friction }
    }

    /// All subsets of touching bodies: the one of which none would be pulled, and none left out that comes nearer
    /// (theory D.5).
    fn enumerate(mass: f64, u: f64, touches: &[Touch<2>]) -> f64 {
        let n = touches.len();
        for active in 0..1_u32 << n {
            let held = |b: usize| active >> b & 1 == 1;
            let (mut m, mut p) = (mass, mass * u);
            for b in (0..n).filter(|&b| held(b)) {
                m += touches[b].mass;
                p += touches[b].mass * touches[b].velocity[1];
            }
            let common = p / m;
            let valid = (0..n).all(|b| {
                let approach = touches[b].side * (common - touches[b].velocity[1]);
                if held(b) { approach >= -1e-12 } else { approach <= 1e-12 }
            });
            if valid {
                return common;
            }
        }
        unreachable!("a strictly convex problem has a solution")
    }

    proptest! {
        /// The root agrees with brute-force enumeration of the active sets, momentum is conserved, and no
        /// body is pulled.
        #[test]
        fn the_common_velocity_is_the_valid_active_set(
            mass in 0.01..10.0_f64,
            u in -2.0..2.0_f64,
            bodies in prop::collection::vec((0.01..10.0_f64, -2.0..2.0_f64, prop::bool::ANY), 1..5),
        ) {
            let touches: Vec<_> = bodies
                .iter()
                .map(|&(m, v, plus)| touch(m, [0.3, v], if plus { 1.0 } else { -1.0 }, Friction::Slip(0.0)))
                .collect();
            let mut impulses = Vec::new();
            let normal = Vector([0.0, 1.0]);
            solve(mass, Vector([0.0, u]), normal, &touches, &mut impulses);
            let expected = enumerate(mass, u, &touches);
            let sum: Vector<2> = impulses.iter().map(Impulse::total).sum();
            let after = u - sum[1] / mass;
            prop_assert!((after - expected).abs() < 1e-10, "{after} {expected}");
            for (touch, impulse) in touches.iter().zip(&impulses) {
                prop_assert!(touch.side * impulse.normal[1] >= 0.0);
                let v = touch.velocity[1] + impulse.normal[1] / touch.mass;
                prop_assert!(touch.side * (v - after) >= -1e-10);
                prop_assert_eq!(impulse.tangent, Vector::ZERO);
            }
        }
    }

    /// Two blocks head-on share (m₁v₁ + m₂v₂)/(m₁ + m₂).
    #[test]
    fn a_head_on_impact_is_inelastic() {
        let mut impulses = Vec::new();
        solve(
            2.0,
            Vector([0.0, 3.0]),
            Vector([0.0, 1.0]),
            &[touch(1.0, [0.0, -1.0], 1.0, Friction::Slip(0.0))],
            &mut impulses,
        );
        let j = impulses[0].normal[1];
        assert!((-1.0 + j - 5.0 / 3.0).abs() < 1e-14);
        assert!((3.0 - j / 2.0 - 5.0 / 3.0).abs() < 1e-14);
    }

    /// Parting bodies are left alone, whatever the friction.
    #[test]
    fn there_is_no_adhesion() {
        let mut impulses = Vec::new();
        solve(
            2.0,
            Vector([1.0, -3.0]),
            Vector([0.0, 1.0]),
            &[touch(1.0, [0.0, -1.0], 1.0, Friction::Stick)],
            &mut impulses,
        );
        assert_eq!(impulses[0].total(), Vector::ZERO);
    }

    /// Below Coulomb's limit the pair sticks; above it slides with exactly μ times the normal impulse.
    #[test]
    fn friction_sticks_up_to_its_limit() {
        let mut impulses = Vec::new();
        let mut tangent = |slip: f64, friction: Friction| {
            let bodies = [touch(1.0, [slip, -1.0], 1.0, friction)];
            solve(1.0, Vector::ZERO, Vector([0.0, 1.0]), &bodies, &mut impulses);
            assert!((impulses[0].normal[1] - 0.5).abs() < 1e-15);
            impulses[0].tangent[0]
        };
        assert!((tangent(0.2, Friction::Slip(0.3)) + 0.1).abs() < 1e-15, "sticks: half the slip");
        assert!((tangent(0.4, Friction::Slip(0.3)) + 0.15).abs() < 1e-15, "slides: 0.3 · 0.5");
        assert!((tangent(0.4, Friction::Stick) + 0.2).abs() < 1e-15);
    }

    /// A light sheet held by two sticking bodies moves with their common velocity.
    #[test]
    fn sticking_on_both_sides_gives_one_velocity() {
        let mut impulses = Vec::new();
        let bodies = [touch(1.0, [1.0, -1.0], 1.0, Friction::Stick), touch(3.0, [0.0, 1.0], -1.0, Friction::Stick)];
        solve(1e-6, Vector([0.5, 0.0]), Vector([0.0, 1.0]), &bodies, &mut impulses);
        let after: Vec<_> = bodies.iter().zip(&impulses).map(|(b, j)| b.velocity + j.total() / b.mass).collect();
        assert!((after[0] - after[1]).norm() < 1e-12);
        assert!((after[0] - Vector([0.25, 0.5])).norm() < 1e-6);
    }
}
