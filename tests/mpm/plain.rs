//! Whole steps against the specification: the sweeps over sorted particles and the plain loops execute one schedule.

use super::model::{FLIP, KERNELS, body, grid, ideal_gas, liquid, rubber, setup, start};
use lateen::math::{Signal, Vector};
use lateen::mpm::{BodySetup, Dissipation, KernelKind, Locking, Mpm, Setup, StressUpdate, Transfer, WallKind};
use lateen::simulation::Solver;

const UPDATES: [StressUpdate; 4] =
    [StressUpdate::First, StressUpdate::Last, StressUpdate::ModifiedLast, StressUpdate::Average];
const LOCKING: [Locking; 2] = [Locking::None, Locking::Average { blend: 0.6 }];

/// Relative to the largest entry of a field. The two differ by the order of their sums and by fused multiplications,
/// some 10⁻¹⁵ per sum; stiffness and six steps make a few thousand times that of it. A sweep that is left out, or a
/// wrong weight, shows in the first digits.
const TOLERANCE: f64 = 1e-9;

const STEPS: usize = 6;

/// Velocities that strain a body in all directions.
fn swirl<const D: usize>(x: Vector<D>) -> Vector<D> {
    Vector::from_fn(|a| 0.3 * (2.0 * x[a] + x[(a + 1) % D]).sin())
}

/// A block of a material between walls that it may leave.
fn model<const D: usize>(material: BodySetup<D>, kernel: KernelKind, stress_update: StressUpdate) -> Setup<D> {
    Setup {
        kernel,
        stress_update,
        gravity: std::array::from_fn(|a| Signal::Constant(if a == D - 1 { -9.81 } else { 0.0 })),
        bodies: vec![material],
        ..setup(grid([0.0; D], 0.25, [6; D], WallKind::Separate))
    }
}

fn block<const D: usize>(law: Box<dyn lateen::material::PointLaw>) -> BodySetup<D> {
    body(law, ([0.02; D], [6; D], 0.125), |_| true, swirl)
}

/// Fields of all particles in the order of their identities, as numbers.
fn state<const D: usize>(mpm: &Mpm<D>) -> Vec<(String, Vec<f64>)> {
    let snapshot = mpm.snapshot();
    let points = &snapshot.points[0];
    let mut order: Vec<usize> = (0..points.id.len()).collect();
    order.sort_by_key(|&p| points.id[p]);
    let position = order.iter().flat_map(|&p| points.position[p]).collect();
    let mut all = vec![("position".to_owned(), position)];
    for field in &points.fields {
        let values = field.values();
        let own = |&p: &usize| values[p * field.components..][..field.components].to_vec();
        all.push((field.name.to_string(), order.iter().flat_map(own).collect()));
    }
    all
}

/// Steps of both, of the same lengths, leave the same particles.
fn agree<const D: usize>(model: impl Fn() -> Setup<D>, what: &str) {
    let (mut fast, mut plain) = (start(model()), start(model()).with_plain_transfers());
    let mut t = 0.0;
    for _ in 0..STEPS {
        let dt = 0.9 * fast.stable_dt();
        fast.step(t, dt).unwrap();
        plain.step(t, dt).unwrap();
        t += dt;
    }
    for ((name, fast), (_, plain)) in state(&fast).into_iter().zip(state(&plain)) {
        let largest = fast.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let error = fast.iter().zip(&plain).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(error <= TOLERANCE * largest, "{what}: {name} differs by {error:e} of {largest:e}");
    }
}

#[test]
fn solids_take_the_steps_of_the_plain_loops() {
    for update in UPDATES {
        for locking in LOCKING {
            for transfer in [FLIP, Transfer::Apic] {
                let model = || {
                    let material = block::<2>(rubber(1000.0, 1e5, 0.4));
                    Setup { locking, transfer, ..model(material, KernelKind::Quadratic, update) }
                };
                agree(model, &format!("{update:?} {locking:?} {transfer:?}"));
            }
        }
    }
}

#[test]
fn every_kernel_takes_the_steps_of_the_plain_loops() {
    for &kernel in KERNELS {
        let model = || model(block::<3>(rubber(1000.0, 1e5, 0.3)), kernel, StressUpdate::Average);
        agree(model, &format!("{kernel:?}"));
    }
}

/// With heat of the transfer, the noise filter in each step, and an atmosphere.
#[test]
fn gases_take_the_steps_of_the_plain_loops() {
    let filtered = Transfer::Flip { relaxation: 0.1, filter_order: 3, filter_interval: 1 };
    for (update, transfer) in UPDATES.into_iter().zip([filtered, FLIP, filtered, FLIP]) {
        let model = || {
            let mut gas = block::<2>(ideal_gas(1.2, 1.4));
            gas.ambient = 0.9e5;
            gas.state.iter_mut().for_each(|state| state.pressure = Some(1e5));
            let locking = Locking::Average { blend: 1.0 };
            Setup { transfer, locking, dissipation: Dissipation::Heat, ..model(gas, KernelKind::Quadratic, update) }
        };
        agree(model, &format!("{update:?} {transfer:?}"));
    }
}

#[test]
fn liquids_take_the_steps_of_the_plain_loops() {
    let model = || model(block::<2>(liquid(1000.0, 20.0)), KernelKind::Cubic, StressUpdate::Last);
    agree(model, "liquid");
}
