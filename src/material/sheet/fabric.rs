//! Orthotropic woven fabric, total Lagrangian in the reference axes of warp (1) and weft (2) (theory (C.24)):
//!
//! ```text
//! E = ½ (C − 1),   ν21 = ν12 E2 / E1,   Q11 = E1/(1 − ν12 ν21),   Q22 = E2/(1 − ν12 ν21),   Q12 = ν21 Q11
//! W = ½ (Q11 E11² + 2 Q12 E11 E22 + Q22 E22²) + 2 G12 E12²,   S = ∂W/∂E
//! ```
//!
//! A wrinkling fabric buckles yarn by yarn: each yarn direction may be longer than it looks, and takes the length
//! that makes W least (a convex relaxation, so that S stays the derivative of the relaxed W).

use super::{Sheet, SheetKind, SheetState};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Orthotropic fabric; the thickness doesn't change.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Fabric {
    /// Density.
    #[schemars(extend("unit" = "kg/m^3", "exclusiveMinimum" = 0.0))]
    pub density: f64,
    /// Young's modulus along the warp, E1.
    #[schemars(extend("unit" = "Pa", "exclusiveMinimum" = 0.0))]
    pub young_warp: f64,
    /// Young's modulus along the weft, E2.
    #[schemars(extend("unit" = "Pa", "exclusiveMinimum" = 0.0))]
    pub young_weft: f64,
    /// Shear modulus G12.
    #[schemars(extend("unit" = "Pa", "exclusiveMinimum" = 0.0))]
    pub shear: f64,
    /// Poisson's ratio ν12: contraction of the weft when the warp is pulled.
    #[serde(default)]
    #[schemars(extend("unit" = "1", "minimum" = 0.0, "exclusiveMaximum" = 1.0))]
    pub poisson: f64,
    /// Carry no compression along the yarns.
    #[serde(default)]
    pub wrinkling: bool,
}

impl Fabric {
    /// Q11, Q22, Q12 [Pa].
    fn stiffnesses(&self) -> [f64; 3] {
        let nu21 = self.poisson * self.young_weft / self.young_warp;
        let scale = 1.0 / (1.0 - self.poisson * nu21);
        [self.young_warp * scale, self.young_weft * scale, nu21 * self.young_warp * scale]
    }

    /// Strains along the yarns after buckling: those of least energy that are at least the given ones.
    fn buckled(&self, [e1, e2]: [f64; 2]) -> [f64; 2] {
        let [q11, q22, q12] = self.stiffnesses();
        let (pushed1, pushed2) = (q11 * e1 + q12 * e2 < 0.0, q22 * e2 + q12 * e1 < 0.0);
        match (pushed1, pushed2) {
            (false, false) => [e1, e2],
            (true, _) if e2 > 0.0 => [-q12 / q11 * e2, e2],
            (_, true) if e1 > 0.0 => [e1, -q12 / q22 * e1],
            _ => [0.0, 0.0],
        }
    }
}

impl Sheet for Fabric {
    fn density(&self) -> f64 {
        self.density
    }

    fn wave_speed(&self) -> f64 {
        let [q11, q22, _] = self.stiffnesses();
        (q11.max(q22) / self.density).sqrt()
    }

    fn modulus(&self) -> f64 {
        self.young_warp.min(self.young_weft)
    }

    fn shear_modulus(&self) -> f64 {
        self.shear
    }

    fn kind(&self) -> SheetKind {
        SheetKind::Total
    }

    fn wrinkles(&self) -> bool {
        self.wrinkling
    }

    fn total(&self, [c11, c22, c12]: [f64; 3]) -> SheetState {
        let [q11, q22, q12] = self.stiffnesses();
        let flat = [0.5 * (c11 - 1.0), 0.5 * (c22 - 1.0)];
        let [e1, e2] = if self.wrinkling { self.buckled(flat) } else { flat };
        let [s1, s2] = [q11 * e1 + q12 * e2, q22 * e2 + q12 * e1];
        SheetState {
            stress: [s1, s2, self.shear * c12],
            energy: 0.5 * (s1 * e1 + s2 * e2 + self.shear * c12 * c12),
            thickness: 1.0,
            volume: ((1.0 + 2.0 * e1) * (1.0 + 2.0 * e2) - c12 * c12).sqrt(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::sheet::testing;

    fn law(wrinkling: bool) -> Fabric {
        let (young_warp, young_weft, shear, poisson) = (0.5e9, 0.3e9, 0.02e9, 0.2);
        Fabric { density: 700.0, young_warp, young_weft, shear, poisson, wrinkling }
    }

    #[test]
    fn common_checks() {
        testing::total_law(&law(false));
        testing::total_law(&law(true));
    }

    #[test]
    fn moduli_along_the_yarns() {
        let law = law(false);
        // Uniaxial stress along the warp: E22 = −ν12 E11, S11 = E1 E11.
        let e = 1e-3;
        let state = law.total([1.0 + 2.0 * e, 1.0 - 2.0 * 0.2 * e, 0.0]);
        assert!((state.stress[0] / e - 0.5e9).abs() < 1.0 && state.stress[1].abs() < 1e-4);
        // Along the weft with ν21 = ν12 E2/E1 = 0.12.
        let state = law.total([1.0 - 2.0 * 0.12 * e, 1.0 + 2.0 * e, 0.0]);
        assert!((state.stress[1] / e - 0.3e9).abs() < 1.0 && state.stress[0].abs() < 1e-4);
    }

    #[test]
    fn buckled_yarns_carry_nothing() {
        let law = law(true);
        let state = law.total([0.9, 1.1, 0.0]);
        assert!(state.stress[0].abs() < 1e-6);
        assert!((state.stress[1] - 0.3e9 * 0.05).abs() < 1e-3);
        assert_eq!(law.total([0.9, 0.95, 0.0]).stress, [0.0; 3]);
    }
}
