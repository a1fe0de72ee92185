//! The contributions of particles to the grid, eight particles at a time.

use super::group::LaneGroup;
use super::view::{View, mean_pressure};
use crate::math::simd::{Lanes, WIDTH};
use crate::math::{SymTensor, Tensor, Vector};
use crate::mpm::particles::Body;
use std::ops::Range;

/// The quantities that a scatter adds to the nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ScatterContent {
    /// Mass and momentum, with the affine part if the particles have one.
    Momentum,
    /// Internal force, and the body force if given.
    Force,
    /// Both.
    MomentumAndForce,
    /// Volume before and after an increment, V and V ΔJ, as two scalars.
    Volumes,
    /// Volume and its product with the pressure, V and V p, as two scalars.
    Pressures,
}

/// The columns of particles that a scatter reads. Optional ones are empty.
#[derive(Clone, Copy)]
pub(crate) struct ScatterSource<'a, const D: usize> {
    pub position: &'a [Vector<D>],
    velocity: &'a [Vector<D>],
    mass: &'a [f64],
    volume: &'a [f64],
    pressure: &'a [f64],
    stress: &'a [SymTensor],
    affine: &'a [Tensor<D>],
    volume_ratio: &'a [f64],
    excess: &'a [f64],
    external: &'a [Vector<D>],
    /// Pressure of the atmosphere, which forces count from [Pa].
    ambient: f64,
    pub content: ScatterContent,
}

/// A value and slopes along the axes in four lanes, (s, v): a scalar and a vector.
pub(crate) type Sloped<L, const D: usize> = ([L; 4], [[L; 4]; D]);

impl<'a, const D: usize> ScatterSource<'a, D> {
    /// All particles of a body.
    pub fn of_body(body: &'a Body<D>, content: ScatterContent) -> Self {
        let (particles, work) = (&body.particles, &body.work);
        Self {
            position: &particles.position,
            velocity: &particles.velocity,
            mass: &particles.mass,
            volume: &particles.volume,
            pressure: &particles.pressure,
            stress: &particles.stress,
            affine: &particles.affine,
            volume_ratio: &work.volume_ratio,
            excess: &work.excess,
            external: &work.external,
            ambient: body.ambient,
            content,
        }
    }

    /// Some particles.
    pub fn of_view(view: &'a View<'_, D>, content: ScatterContent) -> Self {
        Self {
            position: view.position,
            velocity: view.velocity,
            mass: view.mass,
            volume: view.volume,
            pressure: view.pressure,
            stress: view.stress,
            affine: view.affine,
            volume_ratio: view.volume_ratio,
            excess: view.excess,
            external: view.external,
            ambient: view.ambient,
            content,
        }
    }

    /// A range of the particles.
    pub fn range(&self, range: Range<usize>) -> Self {
        fn part<'a, T>(column: &'a [T], range: &Range<usize>) -> &'a [T] {
            if column.is_empty() { column } else { &column[range.clone()] }
        }
        Self {
            position: part(self.position, &range),
            velocity: part(self.velocity, &range),
            mass: part(self.mass, &range),
            volume: part(self.volume, &range),
            pressure: part(self.pressure, &range),
            stress: part(self.stress, &range),
            affine: part(self.affine, &range),
            volume_ratio: part(self.volume_ratio, &range),
            excess: part(self.excess, &range),
            external: part(self.external, &range),
            ambient: self.ambient,
            content: self.content,
        }
    }

    /// True if momentum is sent with its affine part.
    pub fn is_affine(&self) -> bool {
        self.content == ScatterContent::Momentum && !self.affine.is_empty()
    }

    /// True if forces are sent.
    #[inline(always)]
    pub fn pushes(&self) -> bool {
        matches!(self.content, ScatterContent::Force | ScatterContent::MomentumAndForce)
    }

    /// True if every lane is a product of one number and one-dimensional weights.
    pub fn is_simple(&self) -> bool {
        let flat = self.content == ScatterContent::Force || self.affine.is_empty();
        let free = !self.pushes() || self.stress.is_empty() && self.external.is_empty();
        flat && free
    }

    /// Pressures that make forces [Pa]: with what averaging adds, above that of the atmosphere (theory A.13).
    #[inline(always)]
    fn acting_pressure<L: Lanes>(&self, group: LaneGroup) -> L {
        let p = group.scalars::<L>(self.pressure).sub(L::splat(self.ambient));
        if self.excess.is_empty() { p } else { p.add(group.scalars(self.excess)) }
    }

    /// Minus the mean of the normal stresses along the D axes [Pa].
    #[inline(always)]
    fn mean_pressure<L: Lanes>(&self, group: LaneGroup) -> L {
        if D == 3 || self.stress.is_empty() {
            return group.scalars(self.pressure);
        }
        group.each(|p| mean_pressure(&self.stress[p], D))
    }

    /// V and V q.
    #[inline(always)]
    pub fn scalars<L: Lanes>(&self, group: LaneGroup) -> [L; 2] {
        let volume = group.scalars::<L>(self.volume);
        let q = match self.content {
            ScatterContent::Volumes => group.scalars(self.volume_ratio),
            _ => self.mean_pressure(group),
        };
        [volume, volume.mul(q)]
    }

    /// Values of particles without shear stress: (m, m v, V p/h in every force lane), Lian (60, 61, 17).
    #[inline(always)]
    pub fn whole<L: Lanes>(&self, group: LaneGroup, per_cell: f64) -> [L; WIDTH] {
        let mut value = [L::splat(0.0); WIDTH];
        value[..4].copy_from_slice(&self.momentum(group));
        let area = group.scalars::<L>(self.volume).mul(L::splat(per_cell));
        value[1 + D..1 + 2 * D].fill(area.mul(self.acting_pressure(group)));
        value
    }

    /// Values of particles in four lanes, momentum (m, m v), Lian (60, 61), or the force of a pressure (0, V p/h),
    /// Lian (17).
    #[inline(always)]
    pub fn product<L: Lanes>(&self, group: LaneGroup, per_cell: f64) -> [L; 4] {
        if !self.pushes() {
            return self.momentum(group);
        }
        let area = group.scalars::<L>(self.volume).mul(L::splat(per_cell));
        let mut value = [area.mul(self.acting_pressure(group)); 4];
        value[0] = L::splat(0.0);
        value
    }

    /// m and m v, of which the nodes get the sums of Lian (60, 61).
    #[inline(always)]
    fn momentum<L: Lanes>(&self, group: LaneGroup) -> [L; 4] {
        let v = group.vectors::<L, D>(self.velocity);
        let mut value = [L::splat(0.0); 4];
        value[0] = group.scalars(self.mass); // Lian (60)
        for a in 0..D {
            value[1 + a] = value[0].mul(v[a]); // Lian (61)
        }
        value
    }

    /// Values and slopes along the axes: (m, m v) and (0, h m C), or (0, F) and (0, −V σ/h).
    #[inline(always)]
    pub fn sloped<L: Lanes>(&self, group: LaneGroup, per_cell: f64) -> Sloped<L, D> {
        if self.pushes() { self.sloped_force(group, per_cell) } else { self.sloped_momentum(group, per_cell) }
    }

    #[inline(always)]
    fn sloped_momentum<L: Lanes>(&self, group: LaneGroup, per_cell: f64) -> Sloped<L, D> {
        let value = self.momentum::<L>(group);
        let mut slopes = [[L::splat(0.0); 4]; D];
        let weight = value[0].mul(L::splat(1.0 / per_cell));
        if D == 3 {
            let c: [L; 9] = group.numbers(bytemuck::cast_slice(self.affine));
            for (i, c) in c.into_iter().enumerate() {
                slopes[i % D][1 + i / D] = weight.mul(c);
            }
        } else {
            let c: [L; 4] = group.numbers(bytemuck::cast_slice(self.affine));
            for (i, c) in c.into_iter().enumerate() {
                slopes[i % D][1 + i / D] = weight.mul(c);
            }
        }
        (value, slopes)
    }

    /// (0, F) and (0, −V σ/h), of which the nodes get the sums of Lian (18, 17).
    #[inline(always)]
    fn sloped_force<L: Lanes>(&self, group: LaneGroup, per_cell: f64) -> Sloped<L, D> {
        let zero = L::splat(0.0);
        let (mut value, mut slopes) = ([zero; 4], [[zero; 4]; D]);
        if !self.external.is_empty() {
            value[1..=D].copy_from_slice(&group.vectors::<L, D>(self.external)); // Lian (18)
        }
        let area = group.scalars::<L>(self.volume).mul(L::splat(per_cell));
        let minus_area = zero.sub(area);
        if self.stress.is_empty() {
            let push = area.mul(self.acting_pressure(group)); // Lian (17)
            for axis in 0..D {
                slopes[axis][1 + axis] = push;
            }
            return (value, slopes);
        }
        let sigma: [L; 6] = group.numbers(bytemuck::cast_slice(self.stress));
        for axis in 0..D {
            for a in 0..D {
                let sigma = sigma[VOIGT[a][axis]];
                // First the sum: a gas at the pressure of the atmosphere has no force at all.
                let above = if a == axis { sigma.add(L::splat(self.ambient)) } else { sigma };
                slopes[axis][1 + a] = minus_area.mul(above); // Lian (17)
            }
            if !self.excess.is_empty() {
                let slope = &mut slopes[axis][1 + axis];
                *slope = area.mul_add(group.scalars(self.excess), *slope);
            }
        }
        (value, slopes)
    }
}

/// Places of the components of a symmetric tensor.
const VOIGT: [[usize; 3]; 3] = [[0, 3, 5], [3, 1, 4], [5, 4, 2]];
