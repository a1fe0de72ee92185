//! Incompressible Mooney–Rivlin rubber in plane stress, total Lagrangian (theory (C.23)):
//!
//! ```text
//! W = c1 (I1 − 3) + c2 (I2 − 3),   I1 = tr C + λ3²,   I2 = det C + λ3² tr C,   λ3² = 1 / det C
//! S = 2 c1 (1 − λ3² C⁻¹) + 2 c2 [(det C − λ3² tr C) C⁻¹ + λ3² 1]
//! ∂S11/∂C11 = 4 (c1 + c2 tr C) C22² / det³ C − 4 c2 C22 / det² C
//! ```

use super::{
    LANES, Sheet, SheetKind, SheetLanes, SheetState, Smooth, smooth_lanes, stiffness_by_differences, stiffness_of,
    tension_field,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Incompressible Mooney–Rivlin sheet for any strain; its small-strain shear modulus is 2 (c1 + c2).
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct MooneyRivlin {
    /// Density.
    #[schemars(extend("unit" = "kg/m^3", "exclusiveMinimum" = 0.0))]
    pub density: f64,
    /// First constant c1.
    #[schemars(extend("unit" = "Pa", "exclusiveMinimum" = 0.0))]
    pub c1: f64,
    /// Second constant c2.
    #[schemars(extend("unit" = "Pa", "minimum" = 0.0))]
    pub c2: f64,
    /// Carry no compression: the sheet wrinkles instead.
    #[serde(default)]
    pub wrinkling: bool,
}

impl Smooth for MooneyRivlin {
    /// The flat sheet.
    #[inline(always)]
    fn respond(&self, c @ [c11, c22, c12]: [f64; 3]) -> (SheetState, f64) {
        let (det, trace) = (c11 * c22 - c12 * c12, c11 + c22);
        let per_det = 1.0 / det;
        let (c1, c2, square) = (2.0 * self.c1, 2.0 * self.c2, per_det * per_det);
        // S = a 1 + b adj C, with C⁻¹ = adj C / det C.
        let (a, b) = (c1 + c2 * per_det, c2 * (1.0 - trace * square) - c1 * square);
        let state = SheetState {
            stress: [a + b * c22, a + b * c11, -b * c12],
            energy: self.c1 * (trace + per_det - 3.0) + self.c2 * (det + per_det * trace - 3.0),
            thickness: per_det.sqrt(),
            volume: 1.0,
        };
        let (cubic, linear) = (2.0 * (c1 + c2 * trace) * square * per_det, 2.0 * c2 * square);
        let tangent = |other: f64| (cubic * other - linear) * other;
        (state, stiffness_of(state.stress, c, [tangent(c22), tangent(c11)]))
    }
}

impl Sheet for MooneyRivlin {
    fn density(&self) -> f64 {
        self.density
    }

    fn wave_speed(&self) -> f64 {
        (4.0 * self.shear_modulus() / self.density).sqrt()
    }

    fn modulus(&self) -> f64 {
        3.0 * self.shear_modulus()
    }

    fn shear_modulus(&self) -> f64 {
        2.0 * (self.c1 + self.c2)
    }

    fn kind(&self) -> SheetKind {
        SheetKind::Total
    }

    fn wrinkles(&self) -> bool {
        self.wrinkling
    }

    fn total(&self, c: [f64; 3]) -> SheetState {
        if self.wrinkling {
            tension_field::relaxed(c, |c1| 1.0 / c1.sqrt(), |c| self.respond(c).0)
        } else {
            self.respond(c).0
        }
    }

    fn stiffness(&self, c: [f64; 3]) -> f64 {
        if self.wrinkling { stiffness_by_differences(&|c| self.total(c), c) } else { self.respond(c).1 }
    }

    fn total_lanes(&self, c: &[[f64; LANES]; 3]) -> SheetLanes {
        if self.wrinkling { SheetLanes::one_by_one(self, c) } else { smooth_lanes(self, c) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::sheet::{NeoHookean, testing};

    #[test]
    fn common_checks() {
        for wrinkling in [false, true] {
            let law = MooneyRivlin { density: 1000.0, c1: 0.2e6, c2: 0.05e6, wrinkling };
            testing::isotropic_total_law(&law, 1.5e6, 0.5);
        }
    }

    #[test]
    fn without_second_constant_it_is_neo_hookean() {
        let (density, wrinkling) = (1000.0, false);
        let rubber = NeoHookean { density, shear: 0.4e6, poisson: 0.5, wrinkling };
        let c = [1.8, 0.9, -0.2];
        let (a, b) = (MooneyRivlin { density, c1: 0.2e6, c2: 0.0, wrinkling }.total(c), rubber.total(c));
        for i in 0..3 {
            assert!((a.stress[i] - b.stress[i]).abs() < 1e-9);
        }
    }

    #[test]
    fn balloon_stiffens() {
        // Equibiaxial Cauchy stress: 2 (c1 + c2 λ²)(λ² − λ⁻⁴) (theory C.6, (C.40): factor 1 + 0.1 λ² for c2/c1 = 0.1).
        let law = MooneyRivlin { density: 1000.0, c1: 1.0, c2: 0.1, wrinkling: false };
        for stretch in [1.2f64, 1.5, 2.5] {
            let l2 = stretch * stretch;
            let cauchy = l2 * law.total([l2, l2, 0.0]).stress[0];
            assert!((cauchy / (2.0 * (1.0 + 0.1 * l2) * (l2 - l2.powi(-2))) - 1.0).abs() < 1e-13);
        }
    }
}
