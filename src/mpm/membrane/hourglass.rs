//! Flanagan–Belytschko hourglass control of the quadrilateral (theory C.5).
//!
//! One quadrature point doesn't see the hourglass mode. Its shape vector γ_K = h_K − Σ_α p_αK (gᵅ·h·x) is orthogonal to
//! rigid motion and constant strain; with q̇ = Σ γ_K v_K and the current volume V
//!
//! ```text
//! in plane       Q̇ = r_m E V ⅛ Σ_K |∇N_K|² q̇  +  r_v ¼ ρ c V / √A q̇        ⅛ Σ |∇N_K|² = ½ (|g¹|² + |g²|²)
//! out of plane   Q = k_W n·Σ γ_K x_K  +  r_w ¼ ρ c V / √A n·q̇,            k_W = ⅓ V (T¹¹ + T²²)₊
//! f_K = −γ_K Q
//! ```
//!
//! k_W is the geometric stiffness of the bilinear element in this mode under the stress T, exact for parallelograms.
//! Sheets that wrinkle have 2 × 2 quadrature points in a quadrilateral, which see the mode: of the above only the
//! viscous terms act on them. A stiffness would be that of a taut element however little of it is stretched. The
//! in-plane Q is kept by its components on the tangents, which move with the element.

use super::lanes::{ElementLanes, LaneVector};
use super::shape::{Metric, Modes};

/// Coefficients of one membrane.
#[derive(Debug, Clone, Copy)]
pub struct Hourglass {
    /// r_m E [Pa].
    pub stiffness: f64,
    /// r_v ¼ ρ c [Pa s/m].
    pub viscosity: f64,
    /// r_w ¼ ρ c [Pa s/m].
    pub warping_viscosity: f64,
}

/// Numbers of the rest of the element.
pub struct HourglassInput<'a> {
    /// Tangents and hourglass mode of the positions.
    pub now: &'a Modes,
    /// Modes of the velocities.
    pub rate: &'a Modes,
    /// Metric of the tangents.
    pub metric: &'a Metric,
    /// 1 / det of the metric.
    pub inverse: ElementLanes,
    /// Area [m²].
    pub area: ElementLanes,
    /// Volume of the element [m³].
    pub volume: ElementLanes,
    /// V (T¹¹ + T²²) on the tangents [J/m²].
    pub tension: ElementLanes,
}

/// Resultants of the hourglass force on the patterns of g₁, g₂ and h, and the work done since the last step.
pub struct HourglassForce {
    /// Force on the pattern of g₁ [N].
    pub p: LaneVector,
    /// Force on the pattern of g₂ [N].
    pub r: LaneVector,
    /// Force on the hourglass pattern [N].
    pub h: LaneVector,
    /// Work taken up: elastic energy stored and viscous energy lost [J].
    pub work: ElementLanes,
}

impl HourglassInput<'_> {
    /// Components of a vector on the duals g¹ = (b g₁ − c g₂)/det and g² = (a g₂ − c g₁)/det.
    #[inline(always)]
    fn on_duals(&self, v: LaneVector) -> [ElementLanes; 2] {
        let (m, v1, v2) = (self.metric, v.dot(self.now.g1), v.dot(self.now.g2));
        [(m.b * v1 - m.c * v2) * self.inverse, (m.a * v2 - m.c * v1) * self.inverse]
    }
}

impl Hourglass {
    /// Advances the hourglass force `q` (on g₁, g₂ and n) by `dt` and returns the resisting force.
    #[inline(always)]
    pub fn resist(&self, s: &HourglassInput<'_>, q: &mut [ElementLanes; 3], dt: f64) -> HourglassForce {
        let (m, g1, g2) = (s.metric, s.now.g1, s.now.g2);
        let n = g1.cross(g2) * s.inverse.sqrt();
        let [x1, x2] = s.on_duals(s.now.h);
        let qdot = s.rate.h - s.rate.g1 * x1 - s.rate.g2 * x2;
        let ([q1, q2], qn) = (s.on_duals(qdot), qdot.dot(n));

        let stiffness = s.volume * (m.a + m.b) * (0.5 * self.stiffness) * s.inverse;
        let warping = (s.tension * (1.0 / 3.0)).max(0.0);
        let old = *q;
        *q = [q[0] + stiffness * q1 * dt, q[1] + stiffness * q2 * dt, warping * s.now.h.dot(n)];

        let damping = s.volume / s.area.sqrt();
        let viscous =
            qdot * (damping * self.viscosity) + n * (qn * damping * (self.warping_viscosity - self.viscosity));
        let h = g1 * q[0] + g2 * q[1] + n * q[2] + viscous;
        let mean = h - (g1 * (q[0] - old[0]) + g2 * (q[1] - old[1]) + n * (q[2] - old[2])) * 0.5;
        HourglassForce { p: -(h * x1), r: -(h * x2), h, work: mean.dot(qdot) * dt }
    }
}
