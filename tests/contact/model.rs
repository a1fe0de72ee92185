//! Bodies and sheets without stresses: contact and gravity are all that acts in the solver's own step.

use lateen::material::{MaterialKind, PointBatch, PointLaw, PointState, Sheet, SheetKind, StartState, Storage};
use lateen::math::{Signal, SymTensor, Tensor, Vector};
use lateen::mpm::{
    BodySetup, Dissipation, Friction, GridSetup, KernelKind, Locking, MembraneSetup, Mpm, Setup, SheetContact,
    StressUpdate, SupportSetup, Transfer, Wall,
};
use lateen::simulation::{Column, Solver};

pub const PLACES: [SheetContact; 2] = [SheetContact::Nodes, SheetContact::Particles];

/// A wave speed that asks for no sub-steps [m/s].
const SLOW: f64 = 1e-6;

/// A material without stress.
#[derive(Debug)]
struct Dust {
    density: f64,
}

impl PointLaw for Dust {
    fn density(&self) -> f64 {
        self.density
    }
    fn phase(&self) -> MaterialKind {
        MaterialKind::Elastic
    }
    fn storage(&self) -> Storage {
        Storage::default()
    }
    fn initial(&self, _: &StartState) -> Result<PointState, String> {
        Ok(PointState {
            density: self.density,
            energy: 0.0,
            pressure: 0.0,
            stress: SymTensor::ZERO,
            deformation: Tensor::identity(),
            sound_speed: 0.0,
        })
    }
    fn update(&self, _: &mut PointBatch<'_>) {}
    fn reference_sound_speed(&self) -> f64 {
        0.0
    }
}

/// A sheet without stress, whose wave speed bounds its sub-steps.
#[derive(Debug)]
struct Limp {
    density: f64,
    wave_speed: f64,
}

impl Sheet for Limp {
    fn density(&self) -> f64 {
        self.density
    }
    fn wave_speed(&self) -> f64 {
        self.wave_speed
    }
    fn modulus(&self) -> f64 {
        0.0
    }
    fn shear_modulus(&self) -> f64 {
        0.0
    }
    fn kind(&self) -> SheetKind {
        SheetKind::Rate
    }
    fn rate(&self, _: [f64; 3], _: &mut [f64; 3]) -> f64 {
        0.0
    }
}

/// A body of particles at the centres of cells of size `spacing` [m] that fill a box, with a velocity field of its own.
pub fn block<const D: usize>(
    name: &str,
    lower: [f64; D],
    count: [usize; D],
    spacing: f64,
    density: f64,
    velocity: Vector<D>,
) -> BodySetup<D> {
    let position = |mut n: usize| {
        Vector::from_fn(|a| {
            let i = n % count[a];
            n /= count[a];
            lower[a] + (i as f64 + 0.5) * spacing
        })
    };
    let position: Vec<Vector<D>> = (0..count.iter().product()).map(position).collect();
    BodySetup {
        name: name.into(),
        law: Box::new(Dust { density }),
        group: name.bytes().map(usize::from).sum(),
        skin: Vec::new(),
        depth: Vec::new(),
        volume: vec![spacing.powi(D as i32); position.len()],
        velocity: vec![velocity; position.len()],
        velocity_gradient: Vec::new(),
        state: vec![StartState::default(); position.len()],
        position,
        traction: Vec::new(),
        ambient: 0.0,
    }
}

/// A sheet of this mass per area [kg/m²] at rest, of which contact sees the mid-surface.
pub fn sheet<const D: usize>(
    elements: Vec<Vec<u32>>,
    position: Vec<Vector<D>>,
    mass_per_area: f64,
) -> MembraneSetup<D> {
    MembraneSetup {
        name: "sheet".into(),
        sheet: Box::new(Limp { density: mass_per_area, wave_speed: SLOW }),
        velocity: vec![Vector::ZERO; position.len()],
        position,
        elements,
        warp: Vec::new(),
        thickness: 1.0,
        prestress: [0.0; 2],
        hourglass: [0.0; 3],
        damping: [0.0; 2],
        supports: Vec::new(),
        pressure: Signal::ZERO,
        follower: true,
        contact_thickness: false,
    }
}

/// The same, whose faces lie this far from the mid-surface [m].
pub fn with_half_thickness<const D: usize>(half: f64, sheet: MembraneSetup<D>) -> MembraneSetup<D> {
    let (mass_per_area, thickness) = (sheet.sheet.density() * sheet.thickness, 2.0 * half);
    let law = Limp { density: mass_per_area / thickness, wave_speed: sheet.sheet.wave_speed() };
    MembraneSetup { sheet: Box::new(law), thickness, contact_thickness: true, ..sheet }
}

/// The same, which takes about `count` sub-steps in a step of `dt` [s] if its elements are `length` [m] long.
pub fn with_substeps<const D: usize>(count: u32, length: f64, dt: f64, sheet: MembraneSetup<D>) -> MembraneSetup<D> {
    let wave_speed = if count > 1 { f64::from(count) * length / dt } else { SLOW };
    MembraneSetup { sheet: Box::new(Limp { density: sheet.sheet.density(), wave_speed }), ..sheet }
}

/// The same with these nodes held.
pub fn held<const D: usize>(nodes: impl Iterator<Item = u32>, mut sheet: MembraneSetup<D>) -> MembraneSetup<D> {
    let nodes: Vec<u32> = nodes.collect();
    nodes.iter().for_each(|&k| sheet.velocity[k as usize] = Vector::ZERO);
    sheet.supports = vec![SupportSetup { nodes, velocity: std::array::from_fn(|_| Some(Signal::ZERO)) }];
    sheet
}

/// FLIP on unit cells between open walls.
pub fn setup<const D: usize>(
    cells: [i32; D],
    bodies: Vec<BodySetup<D>>,
    membranes: Vec<MembraneSetup<D>>,
    friction: Friction,
) -> Setup<D> {
    let walls = std::array::from_fn(|_| [Wall::default(), Wall::default()]);
    Setup {
        grid: GridSetup { lower: Vector::ZERO, cell: 1.0, cells, walls },
        kernel: KernelKind::Quadratic,
        transfer: Transfer::Flip { relaxation: f64::INFINITY, filter_order: 0, filter_interval: 0 },
        dissipation: Dissipation::Lost,
        stress_update: StressUpdate::Last,
        locking: Locking::None,
        safety: 0.3,
        membrane_safety: 1.0,
        max_substeps: 100,
        contact_passes: 1,
        gravity: std::array::from_fn(|_| Signal::ZERO),
        bodies,
        membranes,
        obstacles: Vec::new(),
        friction: Vec::new(),
        default_friction: friction,
        sheet_contact: SheetContact::Nodes,
        gap_tolerance: 0.0,
    }
}

/// A body whose particles keep their places relative to each other: after each step they get the body's mean velocity,
/// and the deformation of the step is undone.
struct RigidBody<const D: usize> {
    name: String,
    fixed: bool,
    /// Places and volumes of the particles at the start, by identity [m, m³].
    places: Vec<Vector<D>>,
    volume: Vec<f64>,
    displacement: Vector<D>,
}

/// A model, stepped by the solver.
pub struct World<const D: usize> {
    pub mpm: Mpm<D>,
    t: f64,
    rigid: Vec<RigidBody<D>>,
}

impl<const D: usize> World<D> {
    pub fn new(setup: Setup<D>) -> Self {
        Self { mpm: Mpm::new(setup).expect("the model is sound"), t: 0.0, rigid: Vec::new() }
    }

    /// The same with bodies that are rigid from now on.
    pub fn with_rigid(self, names: &[&str]) -> Self {
        names.iter().fold(self, |world, name| world.with_rigid_body(name, false))
    }

    /// The same with a body that doesn't move from now on.
    pub fn with_fixed(self, name: &str) -> Self {
        self.with_rigid_body(name, true)
    }

    fn with_rigid_body(mut self, name: &str, fixed: bool) -> Self {
        let (places, volume) = (self.by_identity(name, "position"), self.by_identity(name, "volume"));
        self.rigid.push(RigidBody { name: name.into(), fixed, places, volume, displacement: Vector::ZERO });
        self
    }

    /// A step of length `dt` [s].
    pub fn step(&mut self, dt: f64) {
        self.mpm.step(self.t, dt).unwrap_or_else(|error| panic!("{error}"));
        self.t += dt;
        let mut bodies = std::mem::take(&mut self.rigid);
        bodies.iter_mut().for_each(|body| self.make_rigid(body, dt));
        self.rigid = bodies;
    }

    fn make_rigid(&mut self, body: &mut RigidBody<D>, dt: f64) {
        let mean = if body.fixed { Vector::ZERO } else { self.mean_velocity(&body.name) };
        body.displacement += mean * dt;
        let ids: Vec<u32> = self.column(&body.name, "id");
        let places: Vec<Vector<D>> = ids.iter().map(|&id| body.places[id as usize] + body.displacement).collect();
        let volume: Vec<f64> = ids.iter().map(|&id| body.volume[id as usize]).collect();
        self.replace(&body.name, "velocity", &vec![mean; ids.len()]);
        self.replace(&body.name, "position", &places);
        self.replace(&body.name, "volume", &volume);
        // They may have left the blocks that they were sorted by.
        self.replace(&body.name, "disorder", &[f64::INFINITY, 0.0, 0.0]);
    }

    /// A column of a body as a checkpoint stores it.
    fn visit(&mut self, body: &str, name: &str, mut visit: impl FnMut(Column<'_>)) {
        let (wanted, mut found) = (format!("body.{body}.{name}"), false);
        self.mpm.columns(&mut |name, column| {
            if name == wanted {
                visit(column);
                found = true;
            }
        });
        assert!(found, "no column `{wanted}`");
    }

    fn column<T: bytemuck::Pod>(&mut self, body: &str, name: &str) -> Vec<T> {
        let mut values = Vec::new();
        self.visit(body, name, |column| {
            let entries = column.data.bytes().chunks_exact(size_of::<T>());
            values = entries.map(bytemuck::pod_read_unaligned).collect();
        });
        values
    }

    fn replace<T: bytemuck::Pod>(&mut self, body: &str, name: &str, values: &[T]) {
        self.visit(body, name, |column| assert!(column.data.replace(bytemuck::cast_slice(values))));
    }

    /// A column in the order of the particles at the start.
    pub fn by_identity<T: bytemuck::Pod>(&mut self, body: &str, name: &str) -> Vec<T> {
        let ids: Vec<u32> = self.column(body, "id");
        let mut pairs: Vec<(u32, T)> = ids.into_iter().zip(self.column(body, name)).collect();
        pairs.sort_by_key(|(id, _)| *id);
        pairs.into_iter().map(|(_, value)| value).collect()
    }

    /// Momentum of a body [N s].
    pub fn momentum(&mut self, body: &str) -> Vector<D> {
        let mass: Vec<f64> = self.column(body, "mass");
        let velocity: Vec<Vector<D>> = self.column(body, "velocity");
        mass.iter().zip(velocity).map(|(&m, v)| v * m).sum()
    }

    /// Momentum of a body over its mass [m/s].
    pub fn mean_velocity(&mut self, body: &str) -> Vector<D> {
        let mass: f64 = self.column::<f64>(body, "mass").iter().sum();
        self.momentum(body) / mass
    }

    /// A term of the ledger.
    pub fn term(&self, name: &str) -> f64 {
        let ledger = self.mpm.snapshot().ledger;
        ledger.terms.iter().find(|term| term.name == name).unwrap_or_else(|| panic!("no term `{name}`")).value
    }

    /// Momentum of all bodies and sheets [N s].
    pub fn total_momentum(&self) -> Vector<D> {
        Vector::from_fn(|a| self.term(["momentum x", "momentum y", "momentum z"][a]))
    }

    /// Energy that the ledger can't explain, over the energy at the start.
    pub fn closure(&self) -> f64 {
        let start = self.term("stored energy at the start");
        self.mpm.snapshot().ledger.closure(start) / start
    }

    /// The only contact force, mean over the last step of the momentum: its name, and the force on the first of the two
    /// [N].
    pub fn contact_force(&self) -> (String, Vector<D>) {
        let forces = self.mpm.snapshot().forces;
        let (name, force) =
            forces.into_iter().find(|(name, _)| name.starts_with("contact:")).expect("contact is listed");
        (name, Vector::from_fn(|a| force[a]))
    }

    /// Particles that have crossed the sheet.
    pub fn crossed(&self) -> u64 {
        let counts = self.mpm.snapshot().counts;
        counts.iter().find(|(name, _)| name == "crossed:sheet").expect("there is a sheet").1
    }
}
