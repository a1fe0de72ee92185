//! Bodies: particles on a lattice and their first state.

use super::Construction;
use super::signals::TrialPoints;
use crate::case::{BodySpec, LatticeSpec, Material};
use crate::error::Diagnostic;
use crate::geometry::{Region, Sample, centred_origin, sample, skin};
use crate::material::{PointLaw, PointLaws, StartState};
use crate::math::{Signal, SymTensor, Tensor, Vector};
use crate::mpm::BodySetup;

impl Construction<'_> {
    /// The body `body[index]`; `None` if it can't be made (and why was noted).
    pub(super) fn body<const D: usize>(&mut self, index: usize) -> Option<BodySetup<D>> {
        let spec = &self.case.file.body[index];
        let key = format!("body[{index}]");
        let region = self.region(&format!("{key}.region"), spec.region.as_ref()?)?;
        let spacing = self.spacing(spec, &key)?;
        let sample = self.sample(spec, &key, &region, spacing)?;
        let position: Vec<Vector<D>> = sample.position.iter().map(|&x| Vector::from3(x)).collect();
        let start = TrialPoints::start(&position);
        let velocity: [Signal; 3] = self.signals(&format!("{key}.velocity"), &spec.velocity, &start);
        let velocity_gradient = gradients(&velocity, &sample.position, spacing);
        let velocity = sample.position.iter().map(|&x| Vector::from_fn(|i| velocity[i].value(x, 0.0))).collect();
        let state = self.start_states(spec, &key, &sample, &start);
        let traction = spec.traction.iter().enumerate();
        let traction =
            traction.flat_map(|(i, t)| self.traction(t, &format!("{key}.traction[{i}]"), &position, spacing)).collect();
        let law = self.point_law(index)?;
        let touched = law.keeps_shape() && !self.case.file.membrane.is_empty();
        Some(BodySetup {
            name: spec.name.clone(),
            law,
            group: self.group(index),
            skin: if touched { skin(&region, &sample, D) } else { Vec::new() },
            depth: sample.position.iter().map(|&x| -region.signed_distance(x)).collect(),
            volume: vec![sample.volume; position.len()],
            position,
            velocity,
            velocity_gradient,
            state,
            traction,
            ambient: spec.ambient,
        })
    }

    fn point_law(&mut self, index: usize) -> Option<Box<dyn PointLaw>> {
        match &self.case.file.body[index].material {
            Material::Point(law) => Some(law.clone().into_box()),
            Material::Flow(law) => {
                let message = format!("the law `{}` is for `method = \"pfem2\"`", law.name());
                let finding = Diagnostic::error(format!("body[{index}].material"), message);
                self.findings
                    .push(finding.help(format!("laws of material points are {}", PointLaws::NAMES.join(", "))));
                None
            }
        }
    }

    /// Bodies with the same group name have the number of the first of them.
    fn group(&self, index: usize) -> usize {
        let bodies = &self.case.file.body;
        let Some(name) = &bodies[index].group else { return index };
        bodies.iter().position(|b| b.group.as_ref() == Some(name)).unwrap_or(index)
    }

    fn spacing(&mut self, spec: &BodySpec, key: &str) -> Option<f64> {
        match (spec.spacing, spec.particles_per_cell) {
            (Some(spacing), None) => Some(spacing),
            (None, Some(count)) => Some(self.case.file.grid.as_ref()?.cell / f64::from(count)),
            (Some(_), Some(_)) => {
                let message = "give `spacing` or `particles-per-cell`, not both";
                self.findings.push(Diagnostic::error(format!("{key}.particles-per-cell"), message));
                None
            }
            (None, None) => {
                let help = "add `particles-per-cell = 2` or `spacing`";
                self.findings.push(Diagnostic::error(key, "the distance of the particles is missing").help(help));
                None
            }
        }
    }

    fn sample(&mut self, spec: &BodySpec, key: &str, region: &Region, spacing: f64) -> Option<Sample> {
        let dimension = self.case.file.dimension;
        let origin = match spec.lattice {
            LatticeSpec::Grid => Ok(self.case.file.grid.as_ref()?.lower),
            LatticeSpec::Centred => centred_origin(region, spacing, dimension),
        };
        match origin.and_then(|origin| sample(region, spacing, dimension, origin)) {
            Ok(sample) if sample.position.is_empty() => {
                let message = format!("no particles: the region is smaller than the spacing of {spacing} m");
                let help = "decrease `spacing` or enlarge the region";
                self.findings.push(Diagnostic::error(format!("{key}.region"), message).help(help));
                None
            }
            Ok(sample) if spec.exact_volume => Some(sample.with_exact_volume(region, dimension)),
            Ok(sample) => Some(sample),
            Err(finding) => {
                self.find(key, finding);
                None
            }
        }
    }

    fn start_states(&mut self, spec: &BodySpec, key: &str, sample: &Sample, start: &TrialPoints) -> Vec<StartState> {
        let given = [
            ("pressure", spec.pressure.is_some()),
            ("energy", spec.energy.is_some()),
            ("stress", spec.stress.is_some()),
        ];
        let given: Vec<&str> = given.into_iter().filter(|(_, given)| *given).map(|(name, _)| name).collect();
        if let [first, second, ..] = given[..] {
            let message = format!("`{first}` and `{second}` both prescribe the state at the start: give one of them");
            self.findings.push(Diagnostic::error(format!("{key}.{second}"), message));
        }
        let mut one = |name: &str, value: &Option<_>| {
            value.as_ref().map(|value| self.signal(&format!("{key}.{name}"), value, start))
        };
        let (pressure, energy) = (one("pressure", &spec.pressure), one("energy", &spec.energy));
        let stress = spec.stress.as_ref().map(|s| self.signals(&format!("{key}.stress"), s, start));
        let state = |&x: &[f64; 3]| StartState {
            pressure: pressure.as_ref().map(|p| p.value(x, 0.0)),
            energy: energy.as_ref().map(|e| e.value(x, 0.0)),
            stress: stress.as_ref().map(|s| SymTensor(std::array::from_fn(|i| s[i].value(x, 0.0)))),
        };
        sample.position.iter().map(state).collect()
    }
}

/// ∂v_i/∂x_j at places [m], as the difference over a cube of the edge `spacing` [m]: a particle's own, so that a jump
/// of the velocity does not become a spike; over half of it where the formula ends beside the place, as a root does.
/// Empty where the velocity is the same everywhere.
fn gradients<const D: usize>(velocity: &[Signal; 3], places: &[[f64; 3]], spacing: f64) -> Vec<Tensor<D>> {
    if velocity.iter().all(Signal::is_uniform) {
        return Vec::new();
    }
    let along = |i: usize, j: usize, x: [f64; 3]| {
        let beside = |away: f64| {
            let mut place = x;
            place[j] += away;
            Some((away, velocity[i].value(place, 0.0))).filter(|(_, v)| v.is_finite())
        };
        let here = (0.0, velocity[i].value(x, 0.0));
        let [behind, ahead] = [-0.5, 0.5].map(|part| beside(part * spacing).unwrap_or(here));
        if ahead.0 > behind.0 { (ahead.1 - behind.1) / (ahead.0 - behind.0) } else { 0.0 }
    };
    places.iter().map(|&x| Tensor::from_fn(|i, j| along(i, j, x))).collect()
}
