//! Small models for the tests.

use lateen::error::StepError;
use lateen::material::{Elastic, EquationsOfState, Fluid, NeoHookean, PointLaw, StartState, eos};
use lateen::math::{Signal, Vector};
use lateen::mpm::{
    BodySetup, Dissipation, Friction, GridSetup, KernelKind, Locking, Mpm, Setup, SheetContact, StressUpdate, Transfer,
    Wall, WallKind,
};
use lateen::simulation::Solver;

pub const KERNELS: &[KernelKind] = KernelKind::ALL;

pub const FLIP: Transfer = Transfer::Flip { relaxation: f64::INFINITY, filter_order: 0, filter_interval: 0 };

pub fn wall(kind: WallKind) -> Wall {
    Wall { kind, ..Wall::default() }
}

/// A domain from `lower` with walls of one kind all around.
pub fn grid<const D: usize>(lower: [f64; D], cell: f64, cells: [i32; D], kind: WallKind) -> GridSetup<D> {
    let walls = std::array::from_fn(|_| [wall(kind), wall(kind)]);
    GridSetup { lower: Vector(lower), cell, cells, walls }
}

/// An empty model: quadratic splines, pure FLIP, stress update `average`, no gravity.
pub fn setup<const D: usize>(grid: GridSetup<D>) -> Setup<D> {
    Setup {
        grid,
        kernel: KernelKind::Quadratic,
        transfer: FLIP,
        dissipation: Dissipation::Lost,
        stress_update: StressUpdate::Average,
        locking: Locking::None,
        safety: 0.3,
        membrane_safety: 0.8,
        max_substeps: 1,
        contact_passes: 2,
        gravity: std::array::from_fn(|_| Signal::ZERO),
        bodies: Vec::new(),
        membranes: Vec::new(),
        obstacles: Vec::new(),
        friction: Vec::new(),
        default_friction: Friction::Slip(0.0),
        sheet_contact: SheetContact::Nodes,
        gap_tolerance: 0.0,
    }
}

pub fn rubber(density: f64, young: f64, poisson: f64) -> Box<dyn PointLaw> {
    Box::new(NeoHookean { elastic: Elastic::new(density, young, poisson) })
}

pub fn liquid(density: f64, sound_speed: f64) -> Box<dyn PointLaw> {
    let eos = EquationsOfState::LinearLiquid(eos::LinearLiquid { sound_speed, tensile_strength: f64::INFINITY });
    Box::new(Fluid { density, viscosity: 0.0, bulk_viscosity: Default::default(), eos })
}

pub fn ideal_gas(density: f64, gamma: f64) -> Box<dyn PointLaw> {
    let eos = EquationsOfState::IdealGas(eos::IdealGas { gamma });
    Box::new(Fluid { density, viscosity: 0.0, bulk_viscosity: Default::default(), eos })
}

/// Particles at the centres of a lattice of spacing `spacing` where `inside` holds.
pub fn body<const D: usize>(
    law: Box<dyn PointLaw>,
    (lower, count, spacing): ([f64; D], [usize; D], f64),
    inside: impl Fn(Vector<D>) -> bool,
    velocity: impl Fn(Vector<D>) -> Vector<D>,
) -> BodySetup<D> {
    let total: usize = count.iter().product();
    let at = |mut n: usize| {
        Vector::from_fn(|a| {
            let i = n % count[a];
            n /= count[a];
            lower[a] + (i as f64 + 0.5) * spacing
        })
    };
    let position: Vec<Vector<D>> = (0..total).map(at).filter(|&x| inside(x)).collect();
    BodySetup {
        name: "body".into(),
        law,
        group: 0,
        skin: Vec::new(),
        depth: Vec::new(),
        volume: vec![spacing.powi(D as i32); position.len()],
        velocity: position.iter().map(|&x| velocity(x)).collect(),
        velocity_gradient: Vec::new(),
        state: vec![StartState::default(); position.len()],
        position,
        traction: Vec::new(),
        ambient: 0.0,
    }
}

pub fn start<const D: usize>(setup: Setup<D>) -> Mpm<D> {
    Mpm::new(setup).expect("the model is sound")
}

/// Steps at the stable bound, cut by `factor`, until `end`; calls `watch(t, dt, mpm)` after every step.
pub fn run<const D: usize>(
    mpm: &mut Mpm<D>,
    end: f64,
    factor: f64,
    mut watch: impl FnMut(f64, f64, &Mpm<D>),
) -> Result<(), StepError> {
    let mut t = 0.0;
    while t < end * (1.0 - 1e-12) {
        let dt = (mpm.stable_dt() * factor).min(end - t);
        mpm.step(t, dt)?;
        t += dt;
        watch(t, dt, mpm);
    }
    Ok(())
}

/// A term of the ledger.
pub fn term<const D: usize>(mpm: &Mpm<D>, name: &str) -> f64 {
    let ledger = mpm.snapshot().ledger;
    ledger.terms.iter().find(|term| term.name == name).unwrap_or_else(|| panic!("no term `{name}`")).value
}

/// The residual of the energy balance [J].
pub fn closure<const D: usize>(mpm: &Mpm<D>) -> f64 {
    mpm.snapshot().ledger.closure(term(mpm, "stored energy at the start"))
}

/// A field of the first body.
pub fn field<const D: usize>(mpm: &Mpm<D>, name: &str) -> Vec<f64> {
    let snapshot = mpm.snapshot();
    let field = snapshot.points[0].fields.iter().find(|field| field.name == name).expect("the field exists");
    let values = field.values();
    order(mpm).into_iter().flat_map(|p| values[p * field.components..][..field.components].to_vec()).collect()
}

/// Indices of the first body's particles in the order of their identities.
fn order<const D: usize>(mpm: &Mpm<D>) -> Vec<usize> {
    let id = mpm.snapshot().points[0].id.to_vec();
    let mut order: Vec<usize> = (0..id.len()).collect();
    order.sort_by_key(|&p| id[p]);
    order
}

/// Positions of the first body.
pub fn positions<const D: usize>(mpm: &Mpm<D>) -> Vec<[f64; 3]> {
    let position = mpm.snapshot().points[0].position.to_vec();
    order(mpm).into_iter().map(|p| position[p]).collect()
}
