//! Small coupled models for the tests.

use lateen::material::{EquationsOfState, Fluid, PointLaw, StartState, eos, sheet};
use lateen::math::{Signal, Vector};
use lateen::mpm::{
    BodySetup, Dissipation, Friction, GridSetup, KernelKind, Locking, MembraneSetup, Mpm, Setup, SheetContact,
    StressUpdate, SupportSetup, Transfer, Wall, WallKind,
};
use lateen::simulation::Solver;

pub const FLIP: Transfer = Transfer::Flip { relaxation: f64::INFINITY, filter_order: 0, filter_interval: 0 };

/// A domain with walls that let nothing out.
pub fn open<const D: usize>(lower: [f64; D], cell: f64, cells: [i32; D]) -> GridSetup<D> {
    GridSetup { lower: Vector(lower), cell, cells, walls: std::array::from_fn(|_| [Wall::default(), Wall::default()]) }
}

/// Quadratic splines, FLIP, stresses on average, sub-cycled membranes, no friction.
pub fn setup<const D: usize>(
    grid: GridSetup<D>,
    bodies: Vec<BodySetup<D>>,
    membranes: Vec<MembraneSetup<D>>,
) -> Setup<D> {
    Setup {
        grid,
        kernel: KernelKind::Quadratic,
        transfer: FLIP,
        dissipation: Dissipation::Lost,
        stress_update: StressUpdate::Average,
        locking: Locking::None,
        safety: 0.3,
        membrane_safety: 0.8,
        max_substeps: 500,
        contact_passes: 2,
        gravity: std::array::from_fn(|_| Signal::ZERO),
        bodies,
        membranes,
        obstacles: Vec::new(),
        friction: Vec::new(),
        default_friction: Friction::Slip(0.0),
        sheet_contact: SheetContact::Nodes,
        gap_tolerance: 0.0,
    }
}

pub fn symmetric<const D: usize>(mut grid: GridSetup<D>, axes: &[usize]) -> GridSetup<D> {
    for &axis in axes {
        grid.walls[axis][0].kind = WallKind::Slip;
    }
    grid
}

pub fn gas(viscosity: f64) -> Box<dyn PointLaw> {
    let eos = EquationsOfState::IdealGas(eos::IdealGas { gamma: 1.4 });
    Box::new(Fluid { density: 1.0, viscosity, bulk_viscosity: Default::default(), eos })
}

/// Particles at the centres of a lattice of spacing `spacing` where `inside` holds.
pub fn body<const D: usize>(
    name: &str,
    (law, start): (Box<dyn PointLaw>, StartState),
    (lower, count, spacing): ([f64; D], [usize; D], f64),
    inside: impl Fn(Vector<D>) -> bool,
    velocity: Vector<D>,
) -> BodySetup<D> {
    let at = |mut n: usize| {
        Vector::from_fn(|a| {
            let i = n % count[a];
            n /= count[a];
            lower[a] + (i as f64 + 0.5) * spacing
        })
    };
    let position: Vec<Vector<D>> = (0..count.iter().product()).map(at).filter(|&x| inside(x)).collect();
    BodySetup {
        name: name.into(),
        law,
        group: name.bytes().map(usize::from).sum(),
        skin: Vec::new(),
        depth: Vec::new(),
        volume: vec![spacing.powi(D as i32); position.len()],
        velocity: vec![velocity; position.len()],
        velocity_gradient: Vec::new(),
        state: vec![start; position.len()],
        position,
        traction: Vec::new(),
        ambient: 0.0,
    }
}

/// A membrane of linear elastic material; `material` is density, Young's modulus, Poisson's ratio, thickness.
pub fn membrane<const D: usize>(
    position: Vec<Vector<D>>,
    elements: Vec<Vec<u32>>,
    [density, young, poisson, thickness]: [f64; 4],
    supports: Vec<SupportSetup>,
) -> MembraneSetup<D> {
    MembraneSetup {
        name: "sheet".into(),
        sheet: Box::new(sheet::Elastic { density, young, poisson, wrinkling: false }),
        velocity: vec![Vector::ZERO; position.len()],
        position,
        elements,
        warp: Vec::new(),
        thickness,
        prestress: [0.0; 2],
        hourglass: [0.05, 0.0, 0.01],
        damping: [0.0; 2],
        supports,
        pressure: Signal::ZERO,
        follower: true,
        contact_thickness: false,
    }
}

/// A support that holds `nodes` along the marked axes.
pub fn support(nodes: Vec<u32>, held: [bool; 3]) -> SupportSetup {
    SupportSetup { nodes, velocity: held.map(|held| held.then_some(Signal::ZERO)) }
}

pub fn start<const D: usize>(setup: Setup<D>) -> Mpm<D> {
    Mpm::new(setup).expect("the model is sound")
}

/// Steps at the stable bound until `end`; calls `watch(t, mpm)` after every step.
pub fn run<const D: usize>(mpm: &mut Mpm<D>, end: f64, mut watch: impl FnMut(f64, &Mpm<D>)) {
    let mut t = 0.0;
    while t < end * (1.0 - 1e-12) {
        let dt = mpm.stable_dt().min(end - t);
        mpm.step(t, dt).unwrap_or_else(|error| panic!("{error}"));
        t += dt;
        watch(t, mpm);
    }
}

/// A term of the ledger.
pub fn term<const D: usize>(mpm: &Mpm<D>, name: &str) -> f64 {
    let ledger = mpm.snapshot().ledger;
    ledger.terms.iter().find(|term| term.name == name).unwrap_or_else(|| panic!("no term `{name}`")).value
}

/// Energy that the ledger can't explain, over the energy at the start.
pub fn closure<const D: usize>(mpm: &Mpm<D>) -> f64 {
    let start = term(mpm, "stored energy at the start");
    mpm.snapshot().ledger.closure(start) / start
}

/// Particles that have crossed the first sheet.
pub fn crossed<const D: usize>(mpm: &Mpm<D>) -> u64 {
    mpm.snapshot().counts[0].1
}

/// Nodes of the first membrane.
pub fn nodes<const D: usize>(mpm: &Mpm<D>) -> Vec<[f64; 3]> {
    mpm.snapshot().surfaces[0].position.to_vec()
}
