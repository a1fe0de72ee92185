//! Isotropic linear elasticity in plane stress, in rate form (Lian, Liu & Zhang 2014, eq. 41; theory 5.3):
//!
//! ```text
//! σ̂11 += E/(1−ν²) (D11 + ν D22) Δt      σ̂12 += 2 G D12 Δt      D33 = −ν/(1−ν) (D11 + D22)
//! ```

use super::{Sheet, SheetKind, tension_field};
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
        SheetKind::Rate
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

    /// Mixed criterion: taut by stress, slack by strain; in between uniaxial along the greatest strain,
    /// E ε1 with E ε1 = σ1 − ν σ2 (theory 5.8).
    #[inline(always)]
    fn carried(&self, stress: [f64; 3]) -> [f64; 3] {
        if !self.wrinkling {
            return stress;
        }
        tension_field::carried(stress, |s1, s2| s1 - self.poisson * s2)
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
        assert_eq!(law.carried([2e6, 1e6, 0.0]), [2e6, 1e6, 0.0]);
        // Compressed across: uniaxial, E ε1 = σ1 − ν σ2.
        let s = law.carried([2e6, -1e6, 0.0]);
        assert!((s[0] - 2.3e6).abs() < 1e-6 && s[1].abs() < 1e-6 && s[2] == 0.0);
        // Compressed both ways: nothing is left.
        assert_eq!(law.carried([-2e6, -1e6, 0.3e6]), [0.0; 3]);
        // Pure shear τ turns into tension (1 + ν) τ along 45°.
        let s = law.carried([0.0, 0.0, 1e6]);
        for component in s {
            assert!((component - 0.65e6).abs() < 1e-6, "{s:?}");
        }
    }
}
