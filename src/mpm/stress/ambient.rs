//! The atmosphere around a gas, without modelling it (theory A.13).
//!
//! ```text
//! f_I = Σ_p V_p (p_p − p_a) ∇N_Ip,      de_p = −p_p dV_p
//! ```
//!
//! By the divergence theorem −Σ V_p p_a ∇N_Ip is the pressure p_a on whatever bounds the gas, from outside: sheets,
//! walls and free surfaces. As two loads p and p_a would cancel up to the noise of the sums over particles, which grows
//! with p; the difference in one sum leaves a gas at p_a without any force. State, energy and speed of sound know p
//! alone. Of the work p dV that a gas gives, the nodes then get (p − p_a) dV, and p_a dV is work on the atmosphere:
//!
//! ```text
//! W_a = −Δ Σ_p p_a V_p                  booked as gained: work of the atmosphere on the gas
//! ```
//!
//! It depends on the volumes that the particles stand for, and on nothing that happened in between: where `volumes`
//! leads these to what the gas fills, the internal energy pays for it, so that e + p_a V stays.

use crate::error::Diagnostic;
use crate::mpm::{Body, BodySetup};
use crate::parallel;

/// Findings about atmospheres without a pressure, or around bodies that are no gas.
pub(in crate::mpm) fn check<const D: usize>(bodies: &[BodySetup<D>]) -> Vec<Diagnostic> {
    let mut findings = Vec::new();
    for (index, body) in bodies.iter().enumerate() {
        let (key, ambient) = (format!("body[{index}].ambient"), body.ambient);
        if !(ambient >= 0.0 && ambient.is_finite()) {
            let message = format!("the pressure of the atmosphere must be finite and not below zero, is {ambient} Pa");
            findings.push(Diagnostic::error(key, message).help("write what the air outside has, such as `\"1 bar\"`"));
        } else if ambient > 0.0 && !body.law.is_ideal_gas() {
            let message = format!("`{}` is no ideal gas, the only kind of body that has an `ambient`", body.name);
            let help = "take it out: what starts without pressure is in balance with the atmosphere as it is";
            findings.push(Diagnostic::error(key, message).help(help));
        }
    }
    findings
}

impl<const D: usize> Body<D> {
    /// Σ p_a V_p [J].
    pub(in crate::mpm) fn displaced_atmosphere(&self) -> f64 {
        let volume = &self.particles.volume;
        if self.ambient > 0.0 { self.ambient * parallel::sum(volume.len(), |p| volume[p]) } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::check;
    use crate::material::{EquationsOfState, Fluid, StartState, eos};
    use crate::math::Vector;
    use crate::mpm::BodySetup;

    fn body(ambient: f64, eos: EquationsOfState) -> BodySetup<2> {
        BodySetup {
            name: "gas".into(),
            law: Box::new(Fluid { density: 1.2, viscosity: 0.0, bulk_viscosity: Default::default(), eos }),
            group: 0,
            position: vec![Vector([0.5, 0.5])],
            skin: Vec::new(),
            depth: Vec::new(),
            volume: vec![1.0],
            velocity: vec![Vector::ZERO],
            velocity_gradient: Vec::new(),
            state: vec![StartState { pressure: Some(1e5), ..StartState::default() }],
            traction: Vec::new(),
            ambient,
        }
    }

    fn gas(ambient: f64) -> BodySetup<2> {
        body(ambient, EquationsOfState::IdealGas(eos::IdealGas { gamma: 1.4 }))
    }

    #[test]
    fn an_atmosphere_has_a_pressure_and_is_around_gases() {
        let liquid = EquationsOfState::LinearLiquid(eos::LinearLiquid { sound_speed: 100.0, tensile_strength: 0.0 });
        let bodies = [gas(0.0), gas(1e5), gas(-1.0), gas(f64::NAN), gas(f64::INFINITY), body(1e5, liquid)];
        let found = check(&bodies);
        let keys: Vec<_> = found.iter().map(|finding| finding.key.as_str()).collect();
        assert_eq!(keys, ["body[2].ambient", "body[3].ambient", "body[4].ambient", "body[5].ambient"]);
        assert!(found[0].message.contains("-1 Pa") && found[3].message.contains("no ideal gas"), "{found:?}");
    }
}
