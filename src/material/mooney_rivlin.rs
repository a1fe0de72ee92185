//! Compressible Mooney–Rivlin solid, with shape and volume apart (theory B.9).
//!
//! ```text
//! W = c10 (Ī1 − 3) + c01 (Ī2 − 3) + ¼ K (J² − 1 − 2 ln J),      b̄ = J^(−2/3) b,  Ī1 = tr b̄,  Ī2 = ½ (Ī1² − b̄ : b̄)
//! J σ = τ = dev τ̄ + ½ K (J² − 1) 1,      τ̄ = 2 c10 b̄ + 2 c01 (Ī1 b̄ − b̄²)
//! ```

use super::bulk_viscosity::BulkViscosity;
use super::elastic::{Elastic, Moduli};
use super::hyperelastic::{Hyperelastic, left_cauchy_green, principal_bounds, square};
use super::increment::Response;
use super::stiffness::Stiffness;
use crate::math::{SymTensor, Tensor};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Rubber-like elastic solid whose pressure depends on its volume alone, p = −½ K (J − 1/J). At zero strain the shear
/// modulus is 2 (c10 + c01).
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct MooneyRivlin {
    /// Density ρ0 in the reference state.
    #[schemars(extend("unit" = "kg/m^3", "exclusiveMinimum" = 0.0))]
    pub density: f64,
    /// First constant c10.
    #[schemars(extend("unit" = "Pa", "exclusiveMinimum" = 0.0))]
    pub c10: f64,
    /// Second constant c01.
    #[serde(default)]
    #[schemars(extend("unit" = "Pa", "minimum" = 0.0))]
    pub c01: f64,
    /// Bulk modulus K at zero strain.
    #[schemars(extend("unit" = "Pa", "exclusiveMinimum" = 0.0))]
    pub bulk: f64,
    /// Artificial bulk viscosity [q1, q2]; 0 for none.
    #[serde(default)]
    #[schemars(extend("unit" = "1"))]
    pub bulk_viscosity: BulkViscosity,
}

/// The shape of a deformation.
#[derive(Debug, Clone, Copy)]
struct Isochoric {
    /// J.
    volume_ratio: f64,
    /// b̄.
    b: SymTensor,
    /// b̄².
    square: SymTensor,
    /// Ī1, Ī2.
    invariants: [f64; 2],
}

impl Isochoric {
    #[inline(always)]
    fn new(deformation: &Tensor<3>) -> Self {
        let volume_ratio = deformation.determinant();
        let b = left_cauchy_green(deformation) * volume_ratio.cbrt().powi(-2);
        let (first, square) = (b.trace(), square(&b));
        Self { volume_ratio, b, square, invariants: [first, 0.5 * (first * first - square.trace())] }
    }

    /// Ī1 b̄ − b̄².
    #[inline(always)]
    fn second(&self) -> SymTensor {
        self.b * self.invariants[0] - self.square
    }

    /// The cofactor b̄² − Ī1 b̄ + Ī2 1, which is the inverse of b̄.
    #[inline(always)]
    fn inverse(&self) -> SymTensor {
        SymTensor::isotropic(self.invariants[1]) - self.second()
    }
}

impl MooneyRivlin {
    /// J ρ c² is at most this [Pa] for a wave along n with any polarisation m, whose energy F → (1 + ε m ⊗ n) F is
    /// differentiated twice. With q = m·n the terms are linear in q² but for those of the shear b̄ can make between n
    /// and m, which Gershgorin's circles bound by half of the spread of the principal values.
    #[inline(always)]
    fn wave_bound(&self, shape: &Isochoric) -> f64 {
        let ([first, second], j) = (shape.invariants, shape.volume_ratio);
        let [b, largest_b] = principal_bounds(&shape.b);
        let [a, largest_a] = principal_bounds(&shape.inverse());
        // Principal values are positive where the circles are not.
        let (b, a) = (b.max(0.0), a.max(0.0));
        let along = self.c10 * (10.0 / 9.0 * first - 2.0 / 3.0 * b)
            + self.c01 * (10.0 / 3.0 * largest_a - 2.0 / 9.0 * second)
            + 0.5 * self.bulk * (j * j + 1.0);
        let across = 2.0 * (self.c10 * largest_b + self.c01 * largest_a);
        let mixed = 2.0 / 3.0 * self.c10 * (largest_b - b) + 1.0 / 3.0 * self.c01 * (largest_a - a);
        along.max(across) + mixed
    }
}

impl Hyperelastic for MooneyRivlin {
    const NAME: &'static str = "Mooney–Rivlin";

    #[inline(always)]
    fn elastic(&self) -> Elastic {
        let moduli = Moduli { bulk: self.bulk, shear: 2.0 * (self.c10 + self.c01) };
        Elastic {
            density: self.density,
            young: moduli.young(),
            poisson: moduli.poisson(),
            bulk_viscosity: self.bulk_viscosity,
        }
    }

    fn stored_energy(&self, deformation: &Tensor<3>) -> f64 {
        let Isochoric { volume_ratio: j, invariants: [first, second], .. } = Isochoric::new(deformation);
        self.c10 * (first - 3.0) + self.c01 * (second - 3.0) + 0.25 * self.bulk * (j * j - 1.0 - 2.0 * j.ln())
    }

    #[inline(always)]
    fn stress(&self, deformation: &Tensor<3>) -> Response {
        let shape = Isochoric::new(deformation);
        let (j, per_j) = (shape.volume_ratio, 1.0 / shape.volume_ratio);
        let unreduced = shape.b * (2.0 * self.c10) + shape.second() * (2.0 * self.c01);
        let kirchhoff = unreduced.deviator() + SymTensor::isotropic(0.5 * self.bulk * (j * j - 1.0));
        Response { stress: kirchhoff * per_j, modulus: self.wave_bound(&shape) * per_j }
    }

    /// As Holzapfel (2000, section 6.6): with τ̄ and the tangent c̄ of the unreduced energy and the deviatoric
    /// projection P, J c = P : c̄ : P + ⅔ tr τ̄ P − ⅔ (1 ⊗ dev τ̄ + dev τ̄ ⊗ 1) + K J² 1 ⊗ 1 − K (J² − 1) 1 ⊙ 1.
    fn tangent(&self, deformation: &Tensor<3>) -> Stiffness {
        let shape = Isochoric::new(deformation);
        let (j, one, [_, invariant]) = (shape.volume_ratio, SymTensor::isotropic(1.0), shape.invariants);
        let sides = |a: &SymTensor| Stiffness::dyad(&one, a) + Stiffness::dyad(a, &one);
        let projection = Stiffness::identity() - Stiffness::volumetric() * (1.0 / 3.0);
        let second = shape.second() * (2.0 * self.c01);
        let unreduced = shape.b * (2.0 * self.c10) + second;
        // c̄ = 4 c01 (b̄ ⊗ b̄ − b̄ ⊙ b̄), of which c̄ : 1 is twice the second part of τ̄, and 1 : c̄ : 1 = 8 c01 Ī2.
        let curvature = Stiffness::dyad(&shape.b, &shape.b) - Stiffness::product(&shape.b, &shape.b);
        let projected = curvature * (4.0 * self.c01) - sides(&second) * (2.0 / 3.0)
            + Stiffness::volumetric() * (8.0 / 9.0 * self.c01 * invariant);
        let isochoric =
            projected + projection * (2.0 / 3.0 * unreduced.trace()) - sides(&unreduced.deviator()) * (2.0 / 3.0);
        let volume =
            Stiffness::volumetric() * (self.bulk * j * j) - Stiffness::identity() * (self.bulk * (j * j - 1.0));
        (isochoric + volume) * (1.0 / j)
    }
}

#[cfg(test)]
mod tests {
    use super::MooneyRivlin;
    use crate::material::ElasticLaw;
    use crate::material::bulk_viscosity::BulkViscosity;
    use crate::material::hyperelastic::Hyperelastic;
    use crate::material::testing::check_law;
    use crate::material::testing::elastic::{check_hyperelastic, diagonal, simple_shear};
    use crate::material::{ElasticState, StartState};
    use crate::math::{SymTensor, Tensor};

    const C10: f64 = 0.2e6;
    const C01: f64 = 0.05e6;
    const BULK: f64 = 2e6;

    fn rubber() -> MooneyRivlin {
        MooneyRivlin { density: 1100.0, c10: C10, c01: C01, bulk: BULK, bulk_viscosity: BulkViscosity::default() }
    }

    #[test]
    fn passes_the_common_checks() {
        check_law(&rubber(), StartState::default());
        check_hyperelastic(&rubber());
        check_hyperelastic(&MooneyRivlin { c01: 0.0, ..rubber() });
        for stress in [[2e5, -1e5, 5e4, 3e4, -2e4, 8e4], [-5e5, -5e5, -5e5, 0.0, 0.0, 0.0]] {
            check_law(&rubber(), StartState { stress: Some(SymTensor(stress)), ..StartState::default() });
        }
    }

    /// J = 1: σ_xx − σ_yy = 2 (c10 + c01/λ)(λ² − 1/λ) along a bar, 2 (c10 + c01 λ²)(λ² − λ⁻⁴) of an evenly stretched
    /// sheet (Rivlin 1948), and no pressure.
    #[test]
    fn bars_and_sheets_of_rivlin() {
        for stretch in [0.6_f64, 1.3, 2.5] {
            let across = stretch.sqrt().recip();
            let bar = rubber().stress(&diagonal([stretch, across, across])).stress;
            let exact = 2.0 * (C10 + C01 / stretch) * (stretch * stretch - 1.0 / stretch);
            assert!(((bar.0[0] - bar.0[1]) / exact - 1.0).abs() < 1e-12 && bar.trace().abs() < 1e-9 * BULK);
            let sheet = rubber().stress(&diagonal([stretch, stretch, stretch.powi(-2)])).stress;
            let exact = 2.0 * (C10 + C01 * stretch * stretch) * (stretch * stretch - stretch.powi(-4));
            assert!(((sheet.0[0] - sheet.0[2]) / exact - 1.0).abs() < 1e-12 && sheet.trace().abs() < 1e-9 * BULK);
        }
    }

    /// Rivlin's simple shear: σ_xy = 2 (c10 + c01) γ, σ_xx − σ_yy = 2 (c10 + c01) γ², σ_zz − σ_yy = 2 c01 γ².
    #[test]
    fn simple_shear_has_normal_stresses() {
        let shear = 0.8;
        let [xx, yy, zz, xy, ..] = rubber().stress(&simple_shear(shear)).stress.0;
        let scale = 2.0 * (C10 + C01);
        assert!((xy / (scale * shear) - 1.0).abs() < 1e-12);
        assert!(((xx - yy) / (scale * shear * shear) - 1.0).abs() < 1e-12);
        assert!(((zz - yy) / (2.0 * C01 * shear * shear) - 1.0).abs() < 1e-10);
    }

    /// Shape and volume are apart: the pressure is −½ K (J − 1/J) in any shape, and couples to the volume alone.
    #[test]
    fn the_pressure_depends_on_the_volume_alone() {
        let f = Tensor([[1.2, 0.3, -0.1], [0.05, 0.8, 0.2], [-0.15, 0.1, 1.1]]);
        let j = f.determinant();
        let about = rubber().linearised(&ElasticState { deformation: f, stress: SymTensor::ZERO });
        assert!((about.pressure + 0.5 * BULK * (j - 1.0 / j)).abs() < 1e-9 * BULK);
        assert!((about.bulk - 0.5 * BULK * (j + 1.0 / j)).abs() < 1e-9 * BULK);
        let coupling = SymTensor(about.mixed().coupling) - SymTensor::isotropic(1.0);
        assert!(coupling.contract(&coupling).sqrt() < 1e-12);
    }
}
