//! Neo-Hookean rubber in plane stress, total Lagrangian (theory (C.22)):
//!
//! ```text
//! incompressible   W = ½ G (I1 − 3)                          S = G (1 − λ3² C⁻¹),  λ3² = 1 / det C
//! compressible     W = ½ G (I1 − 3 − 2 ln J) + ½ λ ln² J     S = G (1 − C⁻¹) + λ ln J C⁻¹
//!                  with λ3 from S33 = 0: G (λ3² − 1) + λ ln(λ3 √det C) = 0
//! ```
//!
//! S33 = 0 turns both into S = G (1 − λ3² C⁻¹), whose tangent is
//!
//! ```text
//! ∂S11/∂C11 = G λ3² (C22 / det C)² (1 + κ),   κ = ½ λ / (G λ3² + ½ λ)   (1 if incompressible)
//! ```

use super::{
    LANES, Sheet, SheetKind, SheetLanes, SheetState, Smooth, smooth_lanes, stiffness_by_differences, stiffness_of,
    tension_field,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Neo-Hookean sheet for any strain, incompressible unless `poisson` is below one half.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct NeoHookean {
    /// Density.
    #[schemars(extend("unit" = "kg/m^3", "exclusiveMinimum" = 0.0))]
    pub density: f64,
    /// Shear modulus G.
    #[schemars(extend("unit" = "Pa", "exclusiveMinimum" = 0.0))]
    pub shear: f64,
    /// Poisson's ratio ν at small strain; one half is incompressible.
    #[serde(default = "incompressible")]
    #[schemars(extend("unit" = "1", "minimum" = 0.0, "maximum" = 0.5))]
    pub poisson: f64,
    /// Carry no compression: the sheet wrinkles instead.
    #[serde(default)]
    pub wrinkling: bool,
}

/// Poisson's ratio of an incompressible material.
fn incompressible() -> f64 {
    0.5
}

impl NeoHookean {
    /// Lamé's first parameter λ [Pa]; infinite if incompressible.
    fn lame(&self) -> f64 {
        2.0 * self.shear * self.poisson / (1.0 - 2.0 * self.poisson)
    }

    /// The flat sheet.
    fn response(&self, c @ [c11, c22, c12]: [f64; 3]) -> SheetState {
        if self.lame().is_infinite() {
            return Incompressible { shear: self.shear }.respond(c).0;
        }
        let (g, det) = (self.shear, c11 * c22 - c12 * c12);
        let inverse = [c22 / det, c11 / det, -c12 / det];
        let thickness2 = free_stretch(g, 0.5 * self.lame(), det);
        let log_volume = 0.5 * (thickness2 * det).ln();
        let volumetric_stress = self.lame() * log_volume;
        SheetState {
            stress: std::array::from_fn(|i| g * (IDENTITY[i] - inverse[i]) + volumetric_stress * inverse[i]),
            energy: 0.5 * g * (c[0] + c[1] + thickness2 - 3.0 - 2.0 * log_volume)
                + 0.5 * volumetric_stress * log_volume,
            thickness: thickness2.sqrt(),
            volume: log_volume.exp(),
        }
    }

    /// [`Sheet::stiffness`] of the flat sheet.
    fn flat_stiffness(&self, c @ [c11, c22, c12]: [f64; 3]) -> f64 {
        if self.lame().is_infinite() {
            return Incompressible { shear: self.shear }.respond(c).1;
        }
        let state = self.response(c);
        let (l, det) = (0.5 * self.lame(), c11 * c22 - c12 * c12);
        let resistance = self.shear * state.thickness * state.thickness;
        let scale = resistance * (1.0 + l / (resistance + l)) / (det * det);
        stiffness_of(state.stress, c, [scale * c22 * c22, scale * c11 * c11])
    }

    /// C22 of uniaxial tension: both free directions stretch alike.
    fn width(&self, c1: f64) -> f64 {
        if self.lame().is_infinite() { 1.0 / c1.sqrt() } else { free_stretch(self.shear, self.lame(), c1.sqrt()) }
    }
}

/// The flat incompressible sheet.
struct Incompressible {
    /// G [Pa].
    shear: f64,
}

impl Smooth for Incompressible {
    #[inline(always)]
    fn respond(&self, c @ [c11, c22, c12]: [f64; 3]) -> (SheetState, f64) {
        let (g, per_det) = (self.shear, 1.0 / (c11 * c22 - c12 * c12));
        let square = per_det * per_det;
        let state = SheetState {
            stress: [g * (1.0 - square * c22), g * (1.0 - square * c11), g * square * c12],
            energy: 0.5 * g * (c11 + c22 + per_det - 3.0),
            thickness: per_det.sqrt(),
            volume: 1.0,
        };
        let scale = 2.0 * g * square * per_det;
        (state, stiffness_of(state.stress, c, [scale * c22 * c22, scale * c11 * c11]))
    }
}

/// The identity in the order 11, 22, 12.
const IDENTITY: [f64; 3] = [1.0, 1.0, 0.0];

/// Solves G (q − 1) + l ln(q d) = 0 for the squared stretch q of a stress-free direction, by Newton's method in ln q
/// (the residual is convex and increasing there).
fn free_stretch(g: f64, l: f64, d: f64) -> f64 {
    let mut y = -l * d.ln() / (g + l);
    for _ in 0..50 {
        let q = y.exp();
        let step = (g * (q - 1.0) + l * (y + d.ln())) / (g * q + l);
        y -= step;
        if step.abs() < 1e-15 {
            break;
        }
    }
    y.exp()
}

impl Sheet for NeoHookean {
    fn density(&self) -> f64 {
        self.density
    }

    fn wave_speed(&self) -> f64 {
        (self.modulus() / (1.0 - self.poisson * self.poisson) / self.density).sqrt()
    }

    fn modulus(&self) -> f64 {
        2.0 * self.shear * (1.0 + self.poisson)
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

    fn total(&self, c: [f64; 3]) -> SheetState {
        if self.wrinkling {
            tension_field::relaxed(c, |c1| self.width(c1), |c| self.response(c))
        } else {
            self.response(c)
        }
    }

    fn stiffness(&self, c: [f64; 3]) -> f64 {
        if self.wrinkling { stiffness_by_differences(&|c| self.total(c), c) } else { self.flat_stiffness(c) }
    }

    fn total_lanes(&self, c: &[[f64; LANES]; 3]) -> SheetLanes {
        if !self.wrinkling && self.lame().is_infinite() {
            smooth_lanes(&Incompressible { shear: self.shear }, c)
        } else {
            SheetLanes::one_by_one(self, c)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::sheet::testing;

    fn law(poisson: f64, wrinkling: bool) -> NeoHookean {
        NeoHookean { density: 1000.0, shear: 0.4e6, poisson, wrinkling }
    }

    #[test]
    fn common_checks() {
        for poisson in [0.5, 0.3, 0.45] {
            for wrinkling in [false, true] {
                testing::isotropic_total_law(&law(poisson, wrinkling), 0.8e6 * (1.0 + poisson), poisson);
            }
        }
    }

    #[test]
    fn uniaxial_and_equibiaxial_tension() {
        // Cauchy stress σ = λ² S for incompressible rubber: μ(λ² − 1/λ) and μ(λ² − λ⁻⁴).
        for stretch in [1.1f64, 1.5, 2.0, 3.0] {
            let l2 = stretch * stretch;
            let uniaxial = law(0.5, false).total([l2, 1.0 / stretch, 0.0]);
            assert!((l2 * uniaxial.stress[0] / 0.4e6 - (l2 - 1.0 / stretch)).abs() < 1e-13 * l2);
            assert!(uniaxial.stress[1].abs() < 1e-13 * 0.4e6 * l2);
            assert!((uniaxial.thickness - stretch.powf(-0.5)).abs() < 1e-14);
            let biaxial = law(0.5, false).total([l2, l2, 0.0]);
            assert!((l2 * biaxial.stress[0] / 0.4e6 - (l2 - l2.powi(-2))).abs() < 1e-13 * l2);
        }
    }

    #[test]
    fn nearly_incompressible_approaches_incompressible() {
        let c = [1.7, 1.2, 0.3];
        let (a, b) = (law(0.4999999, false).total(c), law(0.5, false).total(c));
        for i in 0..3 {
            assert!((a.stress[i] - b.stress[i]).abs() < 1e-5 * 0.4e6);
        }
    }
}
