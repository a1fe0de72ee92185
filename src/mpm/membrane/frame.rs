//! Components of strains and stresses of elements: on the tangents, in the frame that bisects them, and in the material
//! axes (theory C.2, C.3).

use super::lanes::ElementLanes;
use super::shape::Metric;

/// The orthonormal frame that bisects the normalised tangents, Lian (34–39), by its components on the metric
/// (theory C.2).
///
/// With the angle φ between the tangents, g₁ = |g₁| (C, S) and g₂ = |g₂| (S, C), where 2 C² = 1 + sin φ,
/// 2 S² = 1 − sin φ, 2 C S = cos φ.
pub(super) struct BisectingFrame {
    cc: ElementLanes,
    ss: ElementLanes,
    cs: ElementLanes,
    /// 1/(|g₁| sin φ)², 1/(|g₂| sin φ)² and their geometric mean.
    scale: [ElementLanes; 3],
}

impl BisectingFrame {
    /// The frame of elements with this metric.
    #[inline(always)]
    pub fn new(m: &Metric) -> Self {
        let lengths = (m.a * m.b).sqrt();
        let half = ElementLanes::splat(0.5) / lengths;
        let (sin, cos) = (m.det.sqrt() * half, m.c * half);
        let inverse = ElementLanes::splat(1.0) / m.det;
        // In place of the matrix of Lian (39): theory (C.7).
        Self { cc: sin + 0.5, ss: -sin + 0.5, cs: cos, scale: [m.b * inverse, m.a * inverse, lengths * inverse] }
    }

    /// Covariant components to the frame.
    #[inline(always)]
    pub fn local(&self, [e11, e22, e12]: [ElementLanes; 3]) -> [ElementLanes; 3] {
        let (e11, e22, e12) = (e11 * self.scale[0], e22 * self.scale[1], e12 * self.scale[2]);
        // Lian (41).
        let cross = self.cs * e12 * 2.0;
        [self.cc * e11 + self.ss * e22 - cross, self.ss * e11 + self.cc * e22 - cross, e12 - self.cs * (e11 + e22)]
    }

    /// Contravariant components of a stress in the frame.
    #[inline(always)]
    pub fn contravariant(&self, [s11, s22, s12]: [ElementLanes; 3]) -> [ElementLanes; 3] {
        let cross = self.cs * s12 * 2.0;
        [
            (self.cc * s11 + self.ss * s22 - cross) * self.scale[0],
            (self.ss * s11 + self.cc * s22 - cross) * self.scale[1],
            (s12 - self.cs * (s11 + s22)) * self.scale[2],
        ]
    }
}

/// s : d with d12 counted twice.
#[inline(always)]
pub(super) fn contract(s: [ElementLanes; 3], d: [ElementLanes; 3]) -> ElementLanes {
    s[0] * d[0] + s[1] * d[1] + s[2] * d[2] * 2.0
}

/// Mᵀ g M: covariant components to the material axes.
#[inline(always)]
pub(super) fn to_material([m11, m12, m21, m22]: [ElementLanes; 4], [a, b, c]: [ElementLanes; 3]) -> [ElementLanes; 3] {
    [
        m11 * m11 * a + m21 * m21 * b + m11 * m21 * c * 2.0,
        m12 * m12 * a + m22 * m22 * b + m12 * m22 * c * 2.0,
        m11 * m12 * a + m21 * m22 * b + (m11 * m22 + m12 * m21) * c,
    ]
}

/// M S Mᵀ: material axes to contravariant components.
#[inline(always)]
pub(super) fn to_contravariant(
    [m11, m12, m21, m22]: [ElementLanes; 4],
    [s11, s22, s12]: [ElementLanes; 3],
) -> [ElementLanes; 3] {
    [
        m11 * m11 * s11 + m12 * m12 * s22 + m11 * m12 * s12 * 2.0,
        m21 * m21 * s11 + m22 * m22 * s22 + m21 * m22 * s12 * 2.0,
        m11 * m21 * s11 + m12 * m22 * s22 + (m11 * m22 + m12 * m21) * s12,
    ]
}
