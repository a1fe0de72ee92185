//! One point of a body close to a sheet, and the law of its contact (theory (D.19), (D.20)).

use crate::math::Vector;
use crate::mpm::Friction;
use crate::mpm::contact::impulse::{Impulse, limit};
use crate::mpm::contact::rigid::RigidContacts;
use crate::mpm::wall::folded_stencil::Flips;

/// A vector at a node of the grid.
pub type Packed = [f64; 4];

/// A grid node in the support of a touching particle.
#[derive(Debug, Clone, Copy)]
pub struct SupportNode {
    pub partner: u32,
    pub flips: Flips,
    pub weight: f64,
}

/// A point of a body close to the sheet, and its contact during the step.
#[derive(Debug, Clone)]
pub struct SurfaceContact<const D: usize> {
    pub field: u32,
    /// Index of its body, and the key of its label.
    pub body: u32,
    pub key: u32,
    /// End of its particles in the list of all, in which they follow those of the contact before.
    pub members_end: u32,
    /// Half the size of the particles there [m].
    pub half_size: f64,
    /// K, repeated where the facet has fewer than four nodes, and W_K.
    pub nodes: [u32; 4],
    pub weights: [f64; 4],
    /// n, from the sheet to the particle.
    pub normal: Vector<D>,
    /// Distance along n from the sheet to where the body is pushed [m].
    pub arm: f64,
    /// g at the start of the sub-step [m], and a [m/s].
    pub gap: f64,
    pub allowed: f64,
    /// End of its support nodes in the list of all, in which they follow those of the contact before.
    pub support_end: u32,
    /// Contribution of the body to M⁻¹ along each axis [1/kg].
    pub inverse_mass: Vector<D>,
    /// M along the normal [kg], and what the sheet adds to M⁻¹ across it [1/kg], where nothing holds the sheet.
    pub free: EffectiveMass,
    pub friction: Friction,
    /// J of this sub-step, on the particle [N s]: what is along the normal, and friction.
    pub normal_impulse: f64,
    pub tangent: Vector<D>,
    /// Σ J over the sub-steps [N s], and Σ J·v̂ of the sheet [J]: normal part and friction.
    pub total: Impulse<D>,
    pub work: [f64; 2],
}

/// M of a contact along the normal [kg], 0 where nothing can move; and the largest contribution of the sheet to M⁻¹
/// across it [1/kg].
#[derive(Debug, Clone, Copy, Default)]
pub struct EffectiveMass {
    normal: f64,
    tangential: f64,
}

impl<const D: usize> SurfaceContact<D> {
    /// J of this sub-step, on the particle [N s].
    pub fn impulse(&self) -> Impulse<D> {
        Impulse { normal: self.normal * self.normal_impulse, tangent: self.tangent }
    }

    /// v_p − v_c [m/s].
    #[inline(always)]
    pub fn opening(&self, near: &[SupportNode], body: &[Packed], sheet: &[Vector<D>]) -> Vector<D> {
        let mut sums = [[0.0; 4]; 2];
        let mut pairs = near.chunks_exact(2);
        for pair in &mut pairs {
            for (sum, at) in sums.iter_mut().zip(pair) {
                add(sum, &turned(body[at.partner as usize], at.flips), at.weight);
            }
        }
        for at in pairs.remainder() {
            add(&mut sums[0], &turned(body[at.partner as usize], at.flips), at.weight);
        }
        let mut opening = Vector::from_fn(|a| sums[0][a] + sums[1][a]);
        for (&k, weight) in self.nodes.iter().zip(self.weights) {
            opening -= sheet[k as usize] * weight;
        }
        opening
    }

    /// M for nodes of the sheet with 1/m `inverse_mass` [1/kg] and n·(1/m)·n `compliance` [1/kg].
    #[inline(always)]
    fn effective_mass(
        &self,
        inverse_mass: &[Vector<D>],
        compliance: impl Fn(usize, Vector<D>, Vector<D>) -> f64,
    ) -> EffectiveMass {
        let n = self.normal;
        let (mut along, mut across) = ((0..D).map(|a| n[a] * n[a] * self.inverse_mass[a]).sum::<f64>(), 0.0);
        for (&k, weight) in self.nodes.iter().zip(self.weights).filter(|(_, weight)| *weight > 0.0) {
            let inverse_mass = inverse_mass[k as usize];
            along += weight * weight * compliance(k as usize, inverse_mass, n);
            across += weight * weight * (0..D).map(|a| inverse_mass[a]).fold(0.0, f64::max);
        }
        EffectiveMass { normal: if along > 0.0 { 1.0 / along } else { 0.0 }, tangential: across }
    }

    /// Finds M where no wall holds the sheet, whose nodes have 1/m `inverse_mass` [1/kg].
    pub fn find_effective_mass(&mut self, inverse_mass: &[Vector<D>]) {
        self.free =
            self.effective_mass(inverse_mass, |_, inverse_mass, n| (0..D).map(|a| n[a] * n[a] * inverse_mass[a]).sum());
    }

    /// True if a wall or an obstacle that holds a node of the sheet would release it under the change `delta` of the
    /// impulse [N s]: M is larger while it is held (theory E.10).
    fn releases(&self, rigid: &RigidContacts<D>, delta: Vector<D>) -> bool {
        let mut nodes = self.nodes.iter().zip(self.weights).filter(|(_, weight)| *weight > 0.0);
        delta != Vector::ZERO && nodes.any(|(&k, weight)| rigid.releases(k as usize, delta * -weight))
    }

    /// Improves the impulse for the relative velocity `w` [m/s] where walls and obstacles may hold the sheet (theory
    /// E.10); returns its change [N s].
    pub fn improve_where_held(
        &mut self,
        w: Vector<D>,
        inverse_mass: &[Vector<D>],
        rigid: &RigidContacts<D>,
    ) -> Vector<D> {
        let before = (self.normal_impulse, self.tangent);
        let held = self.effective_mass(inverse_mass, |k, inverse_mass, n| rigid.compliance(k, inverse_mass, n));
        let delta = self.improve(w, held);
        if !self.releases(rigid, delta) {
            return delta;
        }
        (self.normal_impulse, self.tangent) = before;
        self.improve(w, self.free)
    }

    /// Improves the impulse for the relative velocity `w` [m/s]; returns its change [N s].
    #[inline(always)]
    pub fn improve(&mut self, w: Vector<D>, mass: EffectiveMass) -> Vector<D> {
        if mass.normal == 0.0 {
            return Vector::ZERO;
        }
        let (n, before) = (self.normal, self.normal_impulse);
        self.normal_impulse = (before - (w.dot(n) + self.allowed) * mass.normal).max(0.0);
        let delta = n * (self.normal_impulse - before);
        let most = limit(self.friction, self.normal_impulse);
        if most == 0.0 && self.tangent == Vector::ZERO {
            return delta;
        }
        delta + self.improve_friction(w - n * w.dot(n), mass.tangential, most)
    }

    /// Improves the friction, up to `most` [N s], for the velocity of slip [m/s]; returns its change [N s].
    #[inline]
    fn improve_friction(&mut self, slip: Vector<D>, across: f64, most: f64) -> Vector<D> {
        let before = self.tangent;
        self.tangent = if most > 0.0 {
            let inverse_mass = across + (0..D).map(|a| self.inverse_mass[a]).fold(0.0, f64::max);
            let wanted = before - slip / inverse_mass;
            let size = wanted.norm();
            if size > most { wanted * (most / size) } else { wanted }
        } else {
            Vector::ZERO
        };
        self.tangent - before
    }
}

#[inline(always)]
pub fn pack<const D: usize>(v: Vector<D>) -> Packed {
    std::array::from_fn(|a| if a < D { v[a] } else { 0.0 })
}

/// `v` with the components of the axes in `flips` reversed.
#[inline(always)]
pub fn turned(v: Packed, flips: Flips) -> Packed {
    if flips == 0 {
        return v;
    }
    std::array::from_fn(|axis| if flips >> axis & 1 == 1 { -v[axis] } else { v[axis] })
}

#[inline(always)]
pub fn add(sum: &mut Packed, v: &Packed, weight: f64) {
    for a in 0..4 {
        sum[a] += v[a] * weight;
    }
}
