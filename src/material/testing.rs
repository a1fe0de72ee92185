//! Tests that every law of material points must pass: of one particle with a volume of 1 m³, which gets a velocity
//! gradient instead of a grid.

pub mod elastic;

use super::bulk_viscosity::BulkViscosity;
use super::eos::EquationsOfState;
use super::fluid::Fluid;
use super::kinematics;
use super::{PointBatch, PointLaw, StartState};
use crate::math::{SymTensor, Tensor};

/// One particle of a law; its volume is 1 m³ at the start.
#[derive(Debug, Clone)]
pub struct TestParticle {
    pub mass: [f64; 1],
    pub volume: [f64; 1],
    pub energy: [f64; 1],
    pub pressure: [f64; 1],
    pub stress: Vec<SymTensor>,
    pub deformation: Vec<Tensor<3>>,
    pub history: Vec<f64>,
    pub wave_speed: [f64; 1],
}

impl TestParticle {
    pub fn new(law: &dyn PointLaw, start: StartState) -> Self {
        let state = law.initial(&start).expect("the start is sound");
        let storage = law.storage();
        Self {
            mass: [state.density],
            volume: [1.0],
            energy: [state.energy * state.density / law.density()],
            pressure: [state.pressure],
            stress: vec![state.stress; usize::from(storage.stress)],
            deformation: vec![state.deformation; usize::from(storage.deformation)],
            history: vec![0.0; storage.history.len()],
            wave_speed: [state.sound_speed],
        }
    }

    /// One increment with the velocity gradient L½ in its middle; the volume grows by exp(Δt tr L½).
    pub fn step(&mut self, law: &dyn PointLaw, middle: Tensor<3>, dt: f64) {
        let over_start = (Tensor::identity() - middle * (0.5 * dt)).inverse().expect("a moderate increment");
        law.update(&mut PointBatch {
            dt,
            length: 1.0,
            room: 4.0,
            gradient: &[middle.dot(&over_start)],
            volume_ratio: &[(dt * middle.trace()).exp()],
            mass: &self.mass,
            volume: &mut self.volume,
            energy: &mut self.energy,
            pressure: &mut self.pressure,
            stress: &mut self.stress,
            deformation: &mut self.deformation,
            history: &mut self.history,
            wave_speed: &mut self.wave_speed,
        });
    }

    /// The Cauchy stress, −p 1 for laws that store only the pressure.
    pub fn cauchy(&self) -> SymTensor {
        self.stress.first().copied().unwrap_or(SymTensor::isotropic(-self.pressure[0]))
    }

    pub fn reference_volume(&self, law: &dyn PointLaw) -> f64 {
        self.mass[0] / law.density()
    }
}

/// An inviscid fluid with this equation of state.
pub fn fluid(density: f64, eos: EquationsOfState) -> Fluid {
    Fluid { density, viscosity: 0.0, bulk_viscosity: BulkViscosity::default(), eos }
}

/// Moves the sample in `steps` increments along a smooth path of compression, shear and spin that is out of
/// phase in its parts; strains reach about `size`.
pub fn smooth_path(sample: &mut TestParticle, law: &dyn PointLaw, steps: u32, size: f64) {
    for k in 0..steps {
        sample.step(law, path_gradient((f64::from(k) + 0.5) / f64::from(steps), size), 1.0 / f64::from(steps));
    }
}

fn path_gradient(t: f64, size: f64) -> Tensor<3> {
    let (a, b, c) = (size * (1.0 + t), size * (2.0 * t).cos(), size * (3.0 * t).sin());
    Tensor([[-0.5 * a, b, -0.3 * c], [0.2 * a, -0.2 * b, 0.4 * a], [0.1 * c, -0.5 * b, -0.3 * c - 0.1 * a]])
}

/// The checks that hold for every law without artificial or shear viscosity, from the state `start`.
pub fn check_law(law: &dyn PointLaw, start: StartState) {
    starts_in_equilibrium(law, start);
    turns_with_the_body(law, start);
    is_objective(law, start);
    waves_match_stress(law, start);
    energy_is_second_order(law, start);
}

fn norm(t: SymTensor) -> f64 {
    t.contract(&t).sqrt()
}

/// The first state is one that the law leaves alone when nothing moves.
fn starts_in_equilibrium(law: &dyn PointLaw, start: StartState) {
    let first = TestParticle::new(law, start);
    let mut sample = first.clone();
    sample.step(law, Tensor::ZERO, 1e-3);
    let scale = law.density() * first.wave_speed[0] * first.wave_speed[0];
    assert!((sample.pressure[0] - first.pressure[0]).abs() < 1e-12 * scale, "pressure moves at rest");
    assert!(norm(sample.cauchy() - first.cauchy()) < 1e-12 * scale, "stress moves at rest");
    assert!(
        (sample.energy[0] / first.energy[0].max(scale * 1e-12) - 1.0).abs() < 1e-12 || sample.energy == first.energy
    );
    assert!(
        (sample.wave_speed[0] / first.wave_speed[0] - 1.0).abs() < 1e-12,
        "the wave speed at rest is the sound speed at the start"
    );
}

/// A spin of finite increments turns the stress and changes nothing else.
fn turns_with_the_body(law: &dyn PointLaw, start: StartState) {
    let mut sample = TestParticle::new(law, start);
    smooth_path(&mut sample, law, 20, 1e-3);
    let before = sample.clone();
    let spin = Tensor([[0.0, -0.4, 0.1], [0.4, 0.0, -0.7], [-0.1, 0.7, 0.0]]);
    let mut turned = before.cauchy();
    for _ in 0..10 {
        sample.step(law, spin, 1.0);
        turned = turned.rotated(&kinematics::rotation(&spin, 1.0));
    }
    let scale = law.density() * before.wave_speed[0] * before.wave_speed[0];
    assert!(norm(sample.cauchy() - turned) < 1e-12 * scale, "stress does not turn with the body");
    assert!((sample.energy[0] - before.energy[0]).abs() < 1e-12 * scale, "a spin does work");
    assert!((sample.pressure[0] - before.pressure[0]).abs() < 1e-12 * scale, "a spin changes the pressure");
    assert_eq!(sample.volume, before.volume);
}

/// An observer who turns by Q(t) sees L' = Q L Qᵀ + Q̇ Qᵀ and must find σ' = Q σ Qᵀ, to second order in the step.
fn is_objective(law: &dyn PointLaw, start: StartState) {
    let spin = Tensor([[0.0, -0.9, 0.3], [0.9, 0.0, -0.5], [-0.3, 0.5, 0.0]]);
    let mismatch = |steps: u32| {
        let dt = 1.0 / f64::from(steps);
        let (mut still, mut turning) = (TestParticle::new(law, start), TestParticle::new(law, start));
        let (half, whole) = (kinematics::rotation(&spin, 0.5 * dt), kinematics::rotation(&spin, dt));
        let mut q = Tensor::identity();
        for k in 0..steps {
            let gradient = path_gradient((f64::from(k) + 0.5) * dt, 0.1);
            let middle = half.dot(&q);
            still.step(law, gradient, dt);
            turning.step(law, middle.dot(&gradient).dot(&middle.transpose()) + spin, dt);
            q = whole.dot(&q);
        }
        let scale = law.density() * still.wave_speed[0] * still.wave_speed[0];
        norm(turning.cauchy() - still.cauchy().rotated(&q)) / scale
    };
    let (coarse, fine) = (mismatch(50), mismatch(100));
    assert!(fine < 1e-4 && (coarse < 1e-12 || coarse / fine > 3.0), "not objective: {coarse:e}, {fine:e}");
}

/// A small uniaxial strain from a state of equal principal stresses changes −σ11 by ρ c² per unit: c is the
/// speed of the waves that the stress makes. From a sheared state c is an upper bound.
fn waves_match_stress(law: &dyn PointLaw, start: StartState) {
    let first = TestParticle::new(law, start);
    let strain = 1e-5;
    let change = |sign: f64| {
        let mut sample = first.clone();
        let mut gradient = Tensor::ZERO;
        gradient[0][0] = -sign * strain;
        sample.step(law, gradient, 1.0);
        -sample.cauchy().0[0]
    };
    let modulus = (change(1.0) - change(-1.0)) / (2.0 * strain);
    let speed = (modulus / first.mass[0]).sqrt();
    let isotropic = norm(first.cauchy().deviator()) <= 1e-12 * norm(first.cauchy());
    let ratio = first.wave_speed[0] / speed;
    assert!(ratio > 1.0 - 1e-3 && (ratio < 1.0 + 1e-3 || !isotropic), "sound speed {} of {speed}", first.wave_speed[0]);
}

/// The energy converges with second order to the work of the stress.
fn energy_is_second_order(law: &dyn PointLaw, start: StartState) {
    let energy = |steps| {
        let mut sample = TestParticle::new(law, start);
        smooth_path(&mut sample, law, steps, 0.1);
        sample.energy[0]
    };
    let (coarse, middle, fine) = (energy(40), energy(80), energy(160));
    let ratio = (coarse - middle) / (middle - fine);
    assert!((ratio - 4.0).abs() < 0.4, "energy differences fall by {ratio} instead of 4: {coarse:e} {fine:e}");
}
