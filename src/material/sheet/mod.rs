//! Laws of thin sheets in plane stress, as the membrane elements call them.
//!
//! Two kinds of law (theory C.6). *Rate laws* add a stress increment for a strain increment in a frame that
//! rotates with the element: `σ̂ += C : D Δt`. *Total laws* give the stress from the right Cauchy–Green tensor
//! of the reference configuration, `S = 2 ∂W/∂C`, and conserve energy exactly in space.
//!
//! Components are ordered 11, 22, 12. A sheet that wrinkles carries no compression (theory C.7): the relaxed
//! energy of a total law replaces the one of the flat sheet; a rate law has none, and doesn't wrinkle.

mod elastic;
mod fabric;
mod mooney_rivlin;
mod neo_hookean;
mod tension_field;
#[cfg(test)]
mod testing;

pub use elastic::Elastic;
pub use fabric::Fabric;
pub use mooney_rivlin::MooneyRivlin;
pub use neo_hookean::NeoHookean;
pub use tension_field::principal;

use crate::math::simd::{Lanes, Task, widest};

/// Elements that a law treats in one call.
pub const LANES: usize = 8;

crate::registry! {
    /// A law of sheets, as a case names it.
    pub enum SheetLaw: Sheet, tag = "law" {
        "elastic" => Elastic,
        "neo-hookean" => NeoHookean,
        "mooney-rivlin" => MooneyRivlin,
        "fabric" => Fabric,
    }
}

/// A law of thin sheets in plane stress.
pub trait Sheet: std::fmt::Debug + Send + Sync {
    /// Density in the reference state [kg/m³].
    fn density(&self) -> f64;

    /// Speed of the fastest in-plane wave in the reference state [m/s].
    fn wave_speed(&self) -> f64;

    /// Young-like modulus that scales the hourglass stiffness [Pa].
    fn modulus(&self) -> f64;

    /// Shear modulus [Pa].
    fn shear_modulus(&self) -> f64;

    /// Rate law or total law.
    fn kind(&self) -> SheetKind;

    /// True if the sheet wrinkles instead of carrying compression: total laws may.
    fn wrinkles(&self) -> bool {
        false
    }

    /// Rate laws: adds the stress increment for the strain increment (D11 Δt, D22 Δt, 2 D12 Δt) to `stress`
    /// (σ11, σ22, σ12) [Pa]; returns the thickness strain D33 Δt.
    fn rate(&self, strain: [f64; 3], stress: &mut [f64; 3]) -> f64 {
        let _ = (strain, stress);
        unreachable!("a total law has no rate form")
    }

    /// Total laws: the state for C = (C11, C22, C12) in the material axes, wrinkled if the law wrinkles.
    fn total(&self, c: [f64; 3]) -> SheetState {
        let _ = c;
        unreachable!("a rate law has no total form")
    }

    /// Total laws: the greatest stiffness against stretching along a material axis, d(λS)/dλ [Pa]. With the
    /// reference density it gives the speed of waves in reference lengths, which bounds the step.
    fn stiffness(&self, c: [f64; 3]) -> f64 {
        stiffness_by_differences(&|c| self.total(c), c)
    }

    /// [`Sheet::rate`] for [`LANES`] elements; returns their thickness strains.
    fn rate_lanes(&self, strain: &[[f64; LANES]; 3], stress: &mut [[f64; LANES]; 3]) -> [f64; LANES] {
        std::array::from_fn(|k| {
            let mut local = stress.map(|s| s[k]);
            let thickness = self.rate(strain.map(|d| d[k]), &mut local);
            (0..3).for_each(|i| stress[i][k] = local[i]);
            thickness
        })
    }

    /// [`Sheet::total`] and [`Sheet::stiffness`] for [`LANES`] elements.
    fn total_lanes(&self, c: &[[f64; LANES]; 3]) -> SheetLanes {
        SheetLanes::one_by_one(self, c)
    }
}

/// [`Sheet::stiffness`] by central differences, for laws whose response has corners.
fn stiffness_by_differences(total: &dyn Fn([f64; 3]) -> SheetState, c: [f64; 3]) -> f64 {
    const STEP: f64 = 1e-4;
    let along = |axis: usize| {
        let force = |stretch: f64| {
            let mut stretched = c;
            stretched[axis] *= stretch * stretch;
            stretch * total(stretched).stress[axis]
        };
        ((force(1.0 + STEP) - force(1.0 - STEP)) / (2.0 * STEP)).max(force(1.0))
    };
    along(0).max(along(1))
}

/// The greater stiffness d(λS)/dλ = S + 2 C ∂S/∂C along the axes 1 and 2, never below the stress itself [Pa].
#[inline(always)]
fn stiffness_of(stress: [f64; 3], c: [f64; 3], tangent: [f64; 2]) -> f64 {
    let along = |axis: usize| stress[axis] + larger(2.0 * c[axis] * tangent[axis], 0.0);
    larger(along(0), along(1))
}

/// The larger of two numbers; one instruction, unlike `f64::max`, whose care for NaN is not needed here.
#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}

/// A smooth total law that answers for one element without branching, so that eight become vectors.
trait Smooth {
    /// State and stiffness; inlined into functions compiled for wide registers.
    fn respond(&self, c: [f64; 3]) -> (SheetState, f64);
}

/// [`Sheet::total_lanes`] of a smooth law, with the widest registers.
fn smooth_lanes<T: Smooth>(law: &T, c: &[[f64; LANES]; 3]) -> SheetLanes {
    widest(SmoothLanes { law, c })
}

struct SmoothLanes<'a, T> {
    law: &'a T,
    c: &'a [[f64; LANES]; 3],
}

impl SheetLanes {
    /// The answer of a law that treats each element alone.
    fn one_by_one(law: &(impl Sheet + ?Sized), c: &[[f64; LANES]; 3]) -> Self {
        let states: [SheetState; LANES] = std::array::from_fn(|k| law.total(c.map(|component| component[k])));
        Self {
            stress: std::array::from_fn(|i| states.map(|s| s.stress[i])),
            energy: states.map(|s| s.energy),
            thickness: states.map(|s| s.thickness),
            stiffness: std::array::from_fn(|k| law.stiffness(c.map(|component| component[k]))),
        }
    }
}

impl<T: Smooth> Task for SmoothLanes<'_, T> {
    type Output = SheetLanes;

    #[inline(always)]
    fn run<L: Lanes>(self) -> SheetLanes {
        let zero = [0.0; LANES];
        let mut lanes = SheetLanes { stress: [zero; 3], energy: zero, thickness: zero, stiffness: zero };
        for k in 0..LANES {
            let (state, stiffness) = self.law.respond([self.c[0][k], self.c[1][k], self.c[2][k]]);
            (lanes.stress[0][k], lanes.stress[1][k], lanes.stress[2][k]) = state.stress.into();
            (lanes.energy[k], lanes.thickness[k], lanes.stiffness[k]) = (state.energy, state.thickness, stiffness);
        }
        lanes
    }
}

/// Formulation of a sheet law.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SheetKind {
    /// Stress rate from strain rate in the co-rotational frame (the paper).
    Rate,
    /// Stress from the total deformation (hyperelastic, orthotropic fabric).
    Total,
}

/// Answer of a total sheet law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SheetState {
    /// Second Piola–Kirchhoff stress S11, S22, S12 [Pa].
    pub stress: [f64; 3],
    /// Stored energy per reference volume [J/m³].
    pub energy: f64,
    /// Thickness stretch λ3.
    pub thickness: f64,
    /// Volume ratio J of the material, after wrinkling.
    pub volume: f64,
}

/// Answer of a total sheet law for several elements.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SheetLanes {
    /// Second Piola–Kirchhoff stress S11, S22, S12 [Pa].
    pub stress: [[f64; LANES]; 3],
    /// Stored energy per reference volume [J/m³].
    pub energy: [f64; LANES],
    /// Thickness stretch λ3.
    pub thickness: [f64; LANES],
    /// Greatest stiffness [Pa] of [`Sheet::stiffness`].
    pub stiffness: [f64; LANES],
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_case_names_its_law() {
        let read = |text: &str| toml::from_str::<SheetLaw>(text).map_err(|error| error.to_string());
        let law = read("law = 'elastic'\ndensity = 750.0\nyoung = 1e9\npoisson = 0.3\nwrinkling = true").unwrap();
        assert!(law.as_dyn().wrinkles() && law.as_dyn().modulus() == 1e9);
        let law = read("law = 'fabric'\ndensity = 1.0\nyoung-warp = 2.0\nyoung-weft = 1.0\nshear = 0.1").unwrap();
        assert_eq!((law.name(), law.as_dyn().shear_modulus()), ("fabric", 0.1));
        let rubber = read("law = 'neo-hookean'\ndensity = 1.0\nshear = 2.0").unwrap();
        assert_eq!(rubber.as_dyn().modulus(), 6.0);
        assert!(read("law = 'rubber'").unwrap_err().contains("rubber"));
        assert!(read("law = 'neo-hookean'\ndensity = 1.0\nshear = 2.0\nyung = 1.0").unwrap_err().contains("yung"));
    }
}
