//! Tests of elastic laws: stress against stored energy, tangents against differences of the stress.

use super::{TestParticle, smooth_path};
use crate::material::hyperelastic::Hyperelastic;
use crate::material::{
    ElasticLaw, ElasticState, Increment, Linearised, Moduli, Point, PointLaw, Solid, StartState, Stiffness, kinematics,
};
use crate::math::{SymTensor, Tensor};

/// Step of central differences: their error is of its square.
const STEP: f64 = 1e-5;

/// Largest relative difference between a tangent and differences of the stress.
const TOLERANCE: f64 = 1e-6;

pub fn diagonal([x, y, z]: [f64; 3]) -> Tensor<3> {
    Tensor([[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z]])
}

/// F = 1 + γ e_x ⊗ e_y.
pub fn simple_shear(shear: f64) -> Tensor<3> {
    Tensor([[1.0, shear, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
}

/// Deformations without symmetry: stretched, pressed and sheared.
fn deformations() -> [Tensor<3>; 3] {
    [
        Tensor([[1.2, 0.3, -0.1], [0.05, 0.8, 0.2], [-0.15, 0.1, 1.1]]),
        Tensor([[0.85, -0.1, 0.05], [0.2, 0.9, 0.1], [0.0, -0.15, 0.95]]),
        Tensor([[0.3, -1.4, 0.2], [1.1, 0.4, -0.1], [0.1, 0.2, 0.9]]),
    ]
}

/// The checks that hold for every law with a stored energy.
pub fn check_hyperelastic<L: Hyperelastic>(law: &L) {
    check_moduli_at_rest(law);
    follows_the_stored_energy(law);
    meets_prestress(law);
    for f in deformations() {
        is_slope_of_stored_energy(law, &f);
        let state = ElasticState { deformation: f, stress: SymTensor::ZERO };
        check_tangent(law, law, &state);
        is_symmetric(&law.linearised(&state));
        bounds_waves(law, &f);
        is_plane_stress(law, &f);
    }
}

/// Without strain: no stress, and the isotropic tangent of the moduli.
pub fn check_moduli_at_rest(law: &impl ElasticLaw) {
    let rest = law.linearised(&ElasticState { deformation: Tensor::identity(), stress: SymTensor::ZERO });
    let Moduli { bulk, shear } = law.moduli();
    let stress = rest.stress();
    assert!(stress.contract(&stress).sqrt() < 1e-12 * bulk, "stress without strain");
    let deviatoric = (Stiffness::identity() - Stiffness::volumetric() * (1.0 / 3.0)) * (2.0 * shear);
    close(&rest.tangent, &(deviatoric + Stiffness::volumetric() * bulk).0, 1e-12 * bulk, "tangent at rest");
    close(&rest.mixed().stiffness, &deviatoric.0, 1e-12 * bulk, "tangent without pressure at rest");
    close(&rest.deviatoric_tangent().0, &deviatoric.0, 1e-12 * bulk, "tangent of the deviator at rest");
    assert!((rest.bulk / bulk - 1.0).abs() < 1e-12, "bulk modulus at rest");
    let plane = rest.plane_stress().tangent;
    let young = law.moduli().young() / (1.0 - law.moduli().poisson().powi(2));
    assert!((plane[0][0] / young - 1.0).abs() < 1e-12, "plane stress at rest: E/(1 − ν²)");
    assert!((plane[0][1] / young - law.moduli().poisson()).abs() < 1e-12, "plane stress at rest: ν E/(1 − ν²)");
}

/// J σ Fᵀ⁻¹ = ∂W/∂F, by central differences.
fn is_slope_of_stored_energy<L: Hyperelastic>(law: &L, f: &Tensor<3>) {
    let piola = law.stress(f).stress.full().dot(&f.inverse().unwrap().transpose()) * f.determinant();
    let scale = law.moduli().wave();
    for i in 0..3 {
        for j in 0..3 {
            let (mut ahead, mut back) = (*f, *f);
            ahead[i][j] += STEP;
            back[i][j] -= STEP;
            let slope = (law.stored_energy(&ahead) - law.stored_energy(&back)) / (2.0 * STEP);
            assert!((slope - piola[i][j]).abs() < 1e-8 * scale, "{i}{j}: {slope} {}", piola[i][j]);
        }
    }
}

/// The trapezoidal energy converges to W with second order, from a stressed start too.
fn follows_the_stored_energy<L: Hyperelastic>(law: &L) {
    let bulk = law.moduli().bulk;
    let start = StartState { pressure: Some(0.03 * bulk), ..StartState::default() };
    let error = |steps| {
        let mut sample = TestParticle::new(law, start);
        smooth_path(&mut sample, law, steps, 0.4);
        sample.energy[0] / sample.reference_volume(law) - law.stored_energy(&sample.deformation[0])
    };
    let (coarse, fine) = (error(200), error(400));
    assert!(fine.abs() < 1e-5 * bulk && (coarse / fine - 4.0).abs() < 0.2, "{coarse:e} {fine:e}");
}

/// A stress at the start is that of a symmetric deformation gradient.
fn meets_prestress<L: Hyperelastic>(law: &L) {
    let g = law.moduli().shear;
    let stress = SymTensor([0.4 * g, -0.2 * g, 0.1 * g, 0.06 * g, -0.04 * g, 0.16 * g]);
    let state = law.initial(&StartState { stress: Some(stress), ..StartState::default() }).unwrap();
    let error = state.stress - stress;
    assert!(error.contract(&error).sqrt() < 1e-12 * law.moduli().wave(), "{:?} for {stress:?}", state.stress);
    assert!((state.density * state.deformation.determinant() / law.reference_density() - 1.0).abs() < 1e-12);
}

/// A tangent with both blocks of its mixed form, against central differences of the response to small increments from
/// the state.
pub fn check_tangent(solid: &impl Solid, law: &impl ElasticLaw, state: &ElasticState) {
    let about = law.linearised(state);
    let (stress, scale) = (about.stress(), law.moduli().wave() + about.stress().von_mises());
    for direction in directions() {
        let (rate, strain) = (truesdell(solid, state, &stress, &direction), direction.symmetric());
        let error = rate - Stiffness(about.tangent).contract(&strain);
        assert!(error.contract(&error).sqrt() < TOLERANCE * scale, "c : d is {error:?} off");
        // The deviator and the pressure one by one, and both put together again.
        let pressure_rate = -about.pressure_slope.iter().zip(twice_shears(&strain)).map(|(h, d)| h * d).sum::<f64>();
        let pressure = |sign: f64| -stepped(solid, state, &stress, &direction, sign * STEP).trace() / 3.0;
        let difference = (pressure(1.0) - pressure(-1.0)) / (2.0 * STEP);
        assert!((difference - pressure_rate).abs() < TOLERANCE * scale, "ṗ {difference} {pressure_rate}");
        let deviator = |sign: f64| stepped(solid, state, &stress, &direction, sign * STEP).deviator();
        let rate = objective(&((deviator(1.0) - deviator(-1.0)) * (0.5 / STEP)), &about.deviator, &direction);
        let error = rate - about.deviatoric_tangent().contract(&strain);
        assert!(error.contract(&error).sqrt() < TOLERANCE * scale, "c_s : d is {error:?} off");
        let mixed = about.mixed();
        let again = Stiffness(mixed.stiffness).contract(&strain) - SymTensor(mixed.coupling) * pressure_rate;
        let error = again - Stiffness(about.tangent).contract(&strain);
        assert!(error.contract(&error).sqrt() < 1e-12 * scale, "A : d − β ṗ is {error:?} off");
    }
    let plane = about.plane_strain();
    for (i, row) in [0, 1, 3].into_iter().enumerate() {
        for (j, column) in [0, 1, 3].into_iter().enumerate() {
            assert!(plane.tangent[i][j] == about.tangent[row][column]);
        }
    }
}

/// Velocity gradients: each component alone.
fn directions() -> impl Iterator<Item = Tensor<3>> {
    (0..9).map(|k| Tensor::from_fn(|i, j| f64::from(u8::from(3 * i + j == k))))
}

fn twice_shears(strain: &SymTensor) -> [f64; 6] {
    let [xx, yy, zz, xy, yz, zx] = strain.0;
    [xx, yy, zz, 2.0 * xy, 2.0 * yz, 2.0 * zx]
}

/// The Cauchy stress after the increment 1 + `step` l from the state with Cauchy stress `stress`.
fn stepped(solid: &impl Solid, state: &ElasticState, stress: &SymTensor, l: &Tensor<3>, step: f64) -> SymTensor {
    let motion = Tensor::identity() + *l * step;
    let deformation = motion.dot(&state.deformation);
    let gradient = kinematics::midpoint(l, step);
    let increment = Increment {
        dt: step,
        gradient,
        shear: gradient.symmetric().deviator() * step,
        volume_ratio: deformation.determinant(),
    };
    solid.response(&increment, Point { deviator: stress.deviator(), deformation, history: &mut [] }).stress
}

/// Truesdell's rate σ̇ − l σ − σ lᵀ + tr l σ of a stress with the rate `rate`.
fn objective(rate: &SymTensor, stress: &SymTensor, l: &Tensor<3>) -> SymTensor {
    let turned = l.dot(&stress.full()).symmetric() * 2.0;
    *rate - turned + *stress * l.trace()
}

fn truesdell(solid: &impl Solid, state: &ElasticState, stress: &SymTensor, l: &Tensor<3>) -> SymTensor {
    let at = |sign: f64| stepped(solid, state, stress, l, sign * STEP);
    objective(&((at(1.0) - at(-1.0)) * (0.5 / STEP)), stress, l)
}

/// Major symmetry, of the mixed form also. The minor ones hold by the form of [`Stiffness`]: `check_tangent` tries
/// every component of the velocity gradient.
fn is_symmetric(about: &Linearised<6>) {
    let stiffness = about.mixed().stiffness;
    for i in 0..6 {
        for j in 0..i {
            let scale = 1e-12 * about.bulk;
            assert!((about.tangent[i][j] - about.tangent[j][i]).abs() < scale, "c is unsymmetric in {i}{j}");
            assert!((stiffness[i][j] - stiffness[j][i]).abs() < scale, "A is unsymmetric in {i}{j}");
        }
    }
}

/// The modulus of the response bounds all waves: ρ c² m = [n_j c_ijkl n_l + (n·σn) δ_ik] m.
fn bounds_waves<L: Hyperelastic>(law: &L, f: &Tensor<3>) {
    let response = law.stress(f);
    let c = law.tangent(f);
    let places = [[0, 3, 5], [3, 1, 4], [5, 4, 2]];
    for k in 0..400 {
        let z = 1.0 - (2.0 * f64::from(k) + 1.0) / 400.0;
        let (angle, r) = (2.4 * f64::from(k), (1.0 - z * z).sqrt());
        let n = [r * angle.cos(), r * angle.sin(), z];
        let along: f64 = (0..9).map(|k| n[k / 3] * n[k % 3] * response.stress.full()[k / 3][k % 3]).sum();
        let acoustic = Tensor::from_fn(|i, k| {
            let sum: f64 = (0..9).map(|m| n[m / 3] * n[m % 3] * c.0[places[i][m / 3]][places[k][m % 3]]).sum();
            sum + if i == k { along } else { 0.0 }
        });
        let [fastest, ..] = acoustic.symmetric().spectrum().values;
        assert!(fastest <= response.modulus * (1.0 + 1e-12), "ρ c² {fastest:e} above {:e}", response.modulus);
    }
}

/// The thickness without stress across, and the condensed tangent against differences in the plane.
fn is_plane_stress<L: Hyperelastic>(law: &L, f: &Tensor<3>) {
    let plane = Tensor::<2>([[f[0][0], f[0][1]], [f[1][0], f[1][1]]]);
    let embedded = |plane: &Tensor<2>| plane.embed(law.thickness_stretch(plane).unwrap());
    let stressed = |plane: &Tensor<2>| law.stress(&embedded(plane)).stress;
    let scale = law.moduli().wave();
    let stress = stressed(&plane);
    assert!(stress.0[2].abs() < 1e-12 * scale, "stress across: {stress:?}");
    let state = ElasticState { deformation: embedded(&plane), stress };
    let about = law.linearised(&state);
    let (condensed, slope) = (about.plane_stress(), about.thickness_slope());
    for k in 0..4 {
        let l = Tensor::<2>::from_fn(|i, j| f64::from(u8::from(2 * i + j == k)));
        let moved = |sign: f64| (Tensor::identity() + l * (sign * STEP)).dot(&plane);
        let rate = (stressed(&moved(1.0)) - stressed(&moved(-1.0))) * (0.5 / STEP);
        let strain = [l[0][0], l[1][1], l[0][1] + l[1][0]];
        let across: f64 = slope.iter().zip(&strain).map(|(s, d)| s * d).sum();
        let rate = objective(&rate, &stress, &l.embed(across));
        for (i, place) in [0, 1, 3].into_iter().enumerate() {
            let found: f64 = condensed.tangent[i].iter().zip(&strain).map(|(c, d)| c * d).sum();
            assert!((found - rate.0[place]).abs() < TOLERANCE * scale, "plane stress {i}: {found} {}", rate.0[place]);
        }
    }
}

/// For a law in rate form at a state of σ_zz = 0: with the thickness rate of plane stress the stress across stays zero,
/// and the stress in the plane changes by the condensed tangent.
pub fn check_plane_stress_increment(solid: &impl Solid, law: &impl ElasticLaw, state: &ElasticState) {
    let about = law.linearised(state);
    let (stress, scale) = (about.stress(), law.moduli().wave());
    assert!(stress.0[2].abs() < 1e-12 * scale, "the state has a stress across: {stress:?}");
    let (condensed, slope) = (about.plane_stress(), about.thickness_slope());
    for k in 0..4 {
        let l = Tensor::<2>::from_fn(|i, j| f64::from(u8::from(2 * i + j == k)));
        let strain = [l[0][0], l[1][1], l[0][1] + l[1][0]];
        let across: f64 = slope.iter().zip(&strain).map(|(s, d)| s * d).sum();
        let rate = truesdell(solid, state, &stress, &l.embed(across));
        assert!(rate.0[2].abs() < TOLERANCE * scale, "a stress across grows");
        for (i, place) in [0, 1, 3].into_iter().enumerate() {
            let found: f64 = condensed.tangent[i].iter().zip(&strain).map(|(c, d)| c * d).sum();
            assert!((found - rate.0[place]).abs() < TOLERANCE * scale, "plane stress {i}: {found} {}", rate.0[place]);
        }
    }
}

fn close(found: &[[f64; 6]; 6], exact: &[[f64; 6]; 6], tolerance: f64, what: &str) {
    for i in 0..6 {
        for j in 0..6 {
            assert!((found[i][j] - exact[i][j]).abs() < tolerance, "{what} {i}{j}: {} {}", found[i][j], exact[i][j]);
        }
    }
}
