//! Isotropic linear elasticity in plane stress, in rate form (theory (C.20)), for the strain rates of Lian (40):
//!
//! ```text
//! σ̂11 += E/(1−ν²) (D11 + ν D22) Δt      σ̂12 += 2 G D12 Δt      D33 = −ν/(1−ν) (D11 + D22)
//! ```
//!
//! A sheet that wrinkles has an energy (theory (C.21)), in the logarithmic strains ε_i = ½ ln c_i of the principal
//! stretches (Hencky 1928), for the sum of a relaxed stress over a path that leaves and enters wrinkles gives back what
//! was never stored:
//!
//! ```text
//! W = ½ E/(1−ν²) (ε1² + ε2² + 2 ν ε1 ε2),   S_i = E/(1−ν²) (ε_i + ν ε_j) / c_i,   ε3 = −ν/(1−ν) (ε1 + ε2)
//! wrinkled (ε2 < −ν ε1): ε2 = −ν ε1, W = ½ E ε1²;   slack (ε1 ≤ 0): 0
//! ```

use super::tension_field::{self, compose, principal};
use super::{Sheet, SheetKind, SheetState, stiffness_of};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Plane-stress linear elastic sheet in rate form; for strains up to a few per cent.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Elastic {
    /// Density.
    #[schemars(extend("unit" = "kg/m^3", "exclusiveMinimum" = 0.0))]
    pub density: f64,
    /// Young's modulus E.
    #[schemars(extend("unit" = "Pa", "exclusiveMinimum" = 0.0))]
    pub young: f64,
    /// Poisson's ratio ν.
    #[schemars(extend("unit" = "1", "minimum" = 0.0, "maximum" = 0.5))]
    pub poisson: f64,
    /// Carry no compression: the sheet wrinkles instead.
    #[serde(default)]
    pub wrinkling: bool,
}

impl Elastic {
    /// E/(1−ν²) [Pa].
    fn plane_modulus(&self) -> f64 {
        self.young / (1.0 - self.poisson * self.poisson)
    }

    /// The flat sheet, of logarithmic strains.
    fn response(&self, c: [f64; 3]) -> SheetState {
        let ([c1, c2], axis) = principal(c);
        let [e1, e2] = [c1, c2].map(|c| 0.5 * c.ln());
        let (modulus, nu) = (self.plane_modulus(), self.poisson);
        let (t1, t2) = (modulus * (e1 + nu * e2), modulus * (e2 + nu * e1));
        let e3 = -nu / (1.0 - nu) * (e1 + e2);
        SheetState {
            stress: compose([t1 / c1, t2 / c2], axis),
            energy: 0.5 * (t1 * e1 + t2 * e2),
            thickness: e3.exp(),
            volume: (e1 + e2 + e3).exp(),
        }
    }
}

impl Sheet for Elastic {
    fn density(&self) -> f64 {
        self.density
    }

    fn wave_speed(&self) -> f64 {
        (self.plane_modulus() / self.density).sqrt()
    }

    fn modulus(&self) -> f64 {
        self.young
    }

    fn shear_modulus(&self) -> f64 {
        0.5 * self.young / (1.0 + self.poisson)
    }

    fn kind(&self) -> SheetKind {
        if self.wrinkling { SheetKind::Total } else { SheetKind::Rate }
    }

    fn wrinkles(&self) -> bool {
        self.wrinkling
    }

    #[inline(always)]
    fn rate(&self, [d11, d22, d12]: [f64; 3], stress: &mut [f64; 3]) -> f64 {
        let (e, nu) = (self.plane_modulus(), self.poisson);
        stress[0] += e * (d11 + nu * d22);
        stress[1] += e * (d22 + nu * d11);
        stress[2] += self.shear_modulus() * d12;
        -nu / (1.0 - nu) * (d11 + d22)
    }

    fn total(&self, c: [f64; 3]) -> SheetState {
        tension_field::relaxed(c, |c1| c1.powf(-self.poisson), |c| self.response(c))
    }

    /// From ∂S_i/∂c_j of the principal values and (S1 − S2)/(c1 − c2), which turns the principal axes.
    fn stiffness(&self, c: [f64; 3]) -> f64 {
        let ([c1, c2], axis) = principal(c);
        let [e1, e2] = [c1, c2].map(|c| 0.5 * c.ln());
        let (modulus, nu) = (self.plane_modulus(), self.poisson);
        let ([t1, t2], [d1, d2, d12]) = if e1 <= 0.0 {
            return 0.0;
        } else if e2 < -nu * e1 {
            let t1 = self.young * e1;
            ([t1, 0.0], [(0.5 * self.young - t1) / (c1 * c1), 0.0, 0.0])
        } else {
            let (t1, t2) = (modulus * (e1 + nu * e2), modulus * (e2 + nu * e1));
            let own = |t: f64, c: f64| (0.5 * modulus - t) / (c * c);
            ([t1, t2], [own(t1, c1), own(t2, c2), 0.5 * modulus * nu / (c1 * c2)])
        };
        let (s1, s2) = (t1 / c1, t2 / c2);
        let turn = if c1 - c2 > 1e-6 * c1 { (s1 - s2) / (c1 - c2) } else { d1 - d12 };
        let along = |p: f64, q: f64| p * p * d1 + q * q * d2 + 2.0 * p * q * (d12 + turn);
        let (p, q) = (axis[0] * axis[0], axis[1] * axis[1]);
        stiffness_of(compose([s1, s2], axis), c, [along(p, q), along(q, p)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::sheet::testing;

    fn law(wrinkling: bool) -> Elastic {
        Elastic { density: 750.0, young: 60e9, poisson: 0.3, wrinkling }
    }

    #[test]
    fn common_checks() {
        testing::rate_law(&law(false), 60e9, 0.3);
        testing::isotropic_total_law(&law(true), 60e9, 0.3);
    }

    #[test]
    fn uniaxial_stress_gives_young() {
        let law = law(false);
        let mut stress = [0.0; 3];
        let d33 = law.rate([1e-3, -0.3e-3, 0.0], &mut stress);
        assert!((stress[0] - 60e6).abs() < 1e-6 && stress[1].abs() < 1e-6);
        assert!((d33 + 0.3e-3).abs() < 1e-12);
    }

    #[test]
    fn wrinkled_sheet_carries_tension_alone() {
        let law = law(true);
        let stress = |e1: f64, e2: f64| law.total([(2.0 * e1).exp(), (2.0 * e2).exp(), 0.0]).stress;
        // Taut: the plane-stress law of small strains.
        let s = stress(1e-6, 0.0);
        assert!((s[0] / (60e9 / 0.91 * 1e-6) - 1.0).abs() < 1e-5 && (s[1] / s[0] - 0.3).abs() < 1e-5, "{s:?}");
        // Narrower than it would hang freely: E ε1 along its length, nothing across.
        let s = stress(1e-3, -1e-2);
        assert!((s[0] * 2e-3_f64.exp() / 60e6 - 1.0).abs() < 1e-12 && s[1].abs() < 1e-6, "{s:?}");
        // Compressed both ways: nothing is left.
        assert_eq!(stress(-1e-3, -1e-4), [0.0; 3]);
        // Pure shear γ turns into tension E γ/2 along 45°.
        let s = law.total([1.0, 1.0, 1e-6]).stress;
        for component in s {
            assert!((component / (60e9 * 0.25e-6) - 1.0).abs() < 1e-5, "{s:?}");
        }
    }
}
