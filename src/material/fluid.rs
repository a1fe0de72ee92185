//! Fluid: pressure from an equation of state, Newtonian shear viscosity with viscous heating
//! (the null material of Lian (26); theory B.3, B.5).

use super::bulk_viscosity::BulkViscosity;
use super::eos::FlowProperties;
use super::eos::{Coefficients, EquationsOfState};
use super::{MaterialKind, PointBatch, PointLaw, PointState, StartState, Storage};
use crate::math::{SymTensor, Tensor};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Liquid or gas: σ = −(p + q) 1 + 2 μ dev D, with p from an equation of state.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Fluid {
    /// Density ρ0 in the reference state.
    #[schemars(extend("unit" = "kg/m^3", "exclusiveMinimum" = 0.0))]
    pub density: f64,
    /// Shear viscosity μ; its work heats the fluid.
    #[serde(default)]
    #[schemars(extend("unit" = "Pa*s", "minimum" = 0.0))]
    pub viscosity: f64,
    /// Artificial bulk viscosity [q1, q2] against shocks: 1.5, 0.06 for strong ones, 0 for none.
    #[serde(default)]
    #[schemars(extend("unit" = "1"))]
    pub bulk_viscosity: BulkViscosity,
    /// Equation of state.
    pub eos: EquationsOfState,
}

impl Fluid {
    fn flow(&self) -> FlowProperties {
        FlowProperties { density: self.density, viscosity: self.viscosity, bulk_viscosity: self.bulk_viscosity }
    }

    fn at_rest(&self) -> Coefficients {
        self.eos.as_dyn().coefficients(self.density, 0.0)
    }
}

impl PointLaw for Fluid {
    fn density(&self) -> f64 {
        self.density
    }

    fn phase(&self) -> MaterialKind {
        self.eos.as_dyn().phase()
    }

    fn storage(&self) -> Storage {
        let parts = self.eos.as_dyn().least_pressure() > f64::NEG_INFINITY;
        Storage { stress: self.viscosity > 0.0, history: if parts { &["void"] } else { &[] }, ..Storage::default() }
    }

    fn initial(&self, start: &StartState) -> Result<PointState, String> {
        self.bulk_viscosity.check()?;
        if start.stress.is_some() {
            return Err("a fluid starts from a `pressure` or an `energy`, not from a stress".into());
        }
        let eos = self.eos.as_dyn();
        let state = eos.start(self.density, start)?;
        let k = eos.coefficients(self.density, state.compression);
        let modulus = k.modulus(state.energy, state.pressure, 1.0 / (1.0 + state.compression));
        Ok(PointState {
            density: self.density * (1.0 + state.compression),
            energy: state.energy,
            pressure: state.pressure,
            stress: SymTensor::isotropic(-state.pressure),
            deformation: Tensor::identity() * (1.0 + state.compression).powf(-1.0 / 3.0),
            sound_speed: (modulus / self.density).sqrt(),
        })
    }

    fn needs_gradient(&self) -> bool {
        self.viscosity > 0.0
    }

    fn update(&self, batch: &mut PointBatch<'_>) {
        self.eos.as_dyn().advance(&self.flow(), batch);
    }

    /// The cold speed of sound at ρ0; zero for a gas, whose speed depends on its state at the start.
    fn reference_sound_speed(&self) -> f64 {
        (self.at_rest().modulus(0.0, 0.0, 1.0) / self.density).sqrt()
    }

    fn is_ideal_gas(&self) -> bool {
        self.eos.as_dyn().is_ideal_gas()
    }

    fn is_thermal(&self) -> bool {
        self.at_rest().b != 0.0
    }

    fn diffusivity(&self) -> f64 {
        4.0 / 3.0 * self.viscosity / self.density
    }
}

#[cfg(test)]
mod tests {
    use super::Fluid;
    use crate::material::bulk_viscosity::BulkViscosity;
    use crate::material::eos::{EquationsOfState, IdealGas, LinearLiquid};
    use crate::material::testing::TestParticle;
    use crate::material::{PointLaw, StartState};
    use crate::math::{SymTensor, Tensor};

    fn air() -> Fluid {
        Fluid {
            density: 1.2,
            viscosity: 0.5,
            bulk_viscosity: BulkViscosity::default(),
            eos: EquationsOfState::IdealGas(IdealGas { gamma: 1.4 }),
        }
    }

    fn start() -> StartState {
        StartState { pressure: Some(1e5), ..StartState::default() }
    }

    /// Simple shear at the rate γ̇ for the time T: τ = μ γ̇, and the heat μ γ̇² T raises p by (γ − 1) μ γ̇² T.
    /// The stress starts from zero, so that the first increment gives half of its heat.
    #[test]
    fn shear_heats() {
        let (law, rate, steps, dt) = (air(), 300.0, 100, 1e-3);
        let mut sample = TestParticle::new(&law, start());
        let mut gradient = Tensor::ZERO;
        gradient[1][2] = rate;
        for _ in 0..steps {
            sample.step(&law, gradient, dt);
        }
        let heat = 0.5 * rate * rate * (f64::from(steps) - 0.5) * dt;
        assert!((sample.energy[0] - (1e5 / 0.4 + heat)).abs() < 1e-9 * heat);
        assert!((sample.pressure[0] - (1e5 + 0.4 * heat)).abs() < 1e-6);
        let shear = SymTensor([0.0, 0.0, 0.0, 0.0, 0.5 * rate, 0.0]);
        let error = sample.stress[0] + SymTensor::isotropic(sample.pressure[0]) - shear;
        assert!(error.contract(&error).sqrt() < 1e-9);
    }

    /// The viscous step limit ρ h²/(8 μ) for three dimensions is part of the wave speed.
    #[test]
    fn viscosity_bounds_the_step() {
        let law = Fluid { viscosity: 1e4, ..air() };
        let mut sample = TestParticle::new(&law, start());
        sample.step(&law, Tensor::ZERO, 1e-6);
        assert!((sample.wave_speed[0] - 8.0 * 1e4 / 1.2).abs() < 1e-6);
        assert!((law.diffusivity() - 4.0 / 3.0 * 1e4 / 1.2).abs() < 1e-9);
    }

    /// A gas stopped at once by a strong shock: with artificial viscosity the compression heats more than the
    /// isentrope, and what it gains is the work of the total pressure.
    #[test]
    fn artificial_viscosity_heats() {
        let smooth = Fluid { viscosity: 0.0, ..air() };
        let shocked = Fluid { bulk_viscosity: BulkViscosity([1.5, 0.06]), ..smooth.clone() };
        let compress = |law: &Fluid| {
            let (mut sample, mut work) = (TestParticle::new(law, start()), 0.0);
            for _ in 0..200 {
                let before = sample.clone();
                sample.step(law, Tensor::identity() * -100.0, 1e-5);
                work -= 0.5 * (before.pressure[0] + sample.pressure[0]) * (sample.volume[0] - before.volume[0]);
            }
            (sample.energy[0] - 1e5 / 0.4, work)
        };
        let ((isentropic, _), (gained, work)) = (compress(&smooth), compress(&shocked));
        assert!(gained > 1.2 * isentropic, "{gained} {isentropic}");
        assert!((gained / work - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_fluid_refuses_a_start_with_stress_or_below_its_least_pressure() {
        let stressed = StartState { stress: Some(SymTensor::ZERO), ..StartState::default() };
        assert!(air().initial(&stressed).unwrap_err().contains("stress"));
        let eos = EquationsOfState::LinearLiquid(LinearLiquid { sound_speed: 100.0, tensile_strength: 0.0 });
        let liquid = Fluid { eos, ..air() };
        let pulled = StartState { pressure: Some(-10.0), ..StartState::default() };
        assert!(liquid.initial(&pulled).unwrap_err().contains("least pressure"));
    }

    /// Water (K = 10 MPa) is pulled apart at 0.1 MPa: it keeps the volume at which it parted, 1 % more than at rest,
    /// and its mass; the void fills the cell (4 m³) and no more; the internal energy is the work of the tension on what
    /// opened. Pressed together, it resists when the void is closed, as ever.
    #[test]
    fn a_liquid_parts_at_its_tension_limit() {
        let eos = EquationsOfState::LinearLiquid(LinearLiquid { sound_speed: 100.0, tensile_strength: 1e5 });
        let liquid = Fluid { density: 1000.0, viscosity: 0.0, eos, ..air() };
        let mut sample = TestParticle::new(&liquid, StartState::default());
        let mut pull = |rate: f64, steps: u32| {
            (0..steps).for_each(|_| sample.step(&liquid, Tensor::identity() * (rate / 3.0), 1e-3));
            sample.clone()
        };
        let parted = pull(1.0, 100);
        let limit = 1000.0 / (1000.0 - 1e5 / 1e4);
        assert!((parted.volume[0] / limit - 1.0).abs() < 2e-3 && parted.mass[0] == 1000.0, "{}", parted.volume[0]);
        assert!((parted.volume[0] * (1.0 + parted.history[0]) / 0.1_f64.exp() - 1.0).abs() < 1e-12);
        // Half of the strain up to the limit, and all the rest against the tension.
        let work = 1e5 * limit * (0.1 - 0.5 * 0.01);
        assert_eq!(parted.pressure[0], -1e5);
        assert!((parted.energy[0] / work - 1.0).abs() < 0.02, "{} {work}", parted.energy[0]);
        let wide = pull(1.0, 5000);
        assert!(wide.volume == parted.volume && (wide.volume[0] * (1.0 + wide.history[0]) - 4.0).abs() < 1e-12);
        // Back to a tenth of a per cent less than the volume at rest.
        let pressed = pull(-1.0, (1000.0 * (4.0_f64 / 0.999).ln()).round() as u32);
        let total = pressed.volume[0];
        assert!(pressed.history[0] == 0.0 && (0.998..1.0).contains(&total), "{total}");
        assert!((pressed.pressure[0] - 1e4 * (1000.0 / total - 1000.0)).abs() < 1.0, "{}", pressed.pressure[0]);
    }

    /// A liquid under pressure starts at the density that carries it: p = c0² (ρ − ρ0).
    #[test]
    fn a_pressed_liquid_is_dense() {
        let eos = EquationsOfState::LinearLiquid(LinearLiquid { sound_speed: 100.0, tensile_strength: 0.0 });
        let liquid = Fluid { density: 1000.0, eos, ..air() };
        let state = liquid.initial(&start()).unwrap();
        assert!((state.density - 1010.0).abs() < 1e-9 && state.sound_speed == 100.0);
    }
}
