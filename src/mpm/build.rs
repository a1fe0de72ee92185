//! From a description to a solver that is ready to step (theory A.15).

use super::contact::FrictionTable;
use super::coupling::{Coupling, CouplingSettings, build_membranes};
use super::executor::{Plain, Tiles};
use super::grid::{Ghosts, MassCutoffs};
use super::kernel::Kernel;
use super::particles::{Bodies, Body, Particles};
use super::regions::parts;
use super::state::energy::Energy;
use super::state::notices::Notices;
use super::state::stability;
use super::step::method::{MethodChoices, StepCount};
use super::step::schedule::SweepSchedule;
use super::stress::ambient;
use super::transfer::{CHUNK_LEN, View};
use super::wall::Walls;
use super::wall::folded_stencil::FoldedStencil;
use super::{BodySetup, Dissipation, Grid, GridSetup, KernelKind, Locking, Membrane, Mpm, Setup, Transfer};
use crate::error::Diagnostic;
use crate::material::{PointLaw, StartState};
use crate::math::{Tensor, Vector};
use crate::parallel;
use crate::simulation::Timer;

impl<const D: usize> Mpm<D> {
    /// A solver in the state that `setup` describes.
    ///
    /// # Errors
    /// Everything in the description that can't be run, with the keys of the case.
    pub fn new(mut setup: Setup<D>) -> Result<Self, Vec<Diagnostic>> {
        let (bodies, membranes) = build_parts(&mut setup)?;
        let friction = FrictionTable { listed: std::mem::take(&mut setup.friction), default: setup.default_friction };
        let bodies = parts::divide(bodies, &membranes, &friction)?;
        let kernel = Kernel::new(setup.kernel, 0.25);
        let cutoffs = mass_cutoffs(&bodies, kernel, &setup.transfer);
        let touching = cutoffs.iter().map(|cutoffs| cutoffs.contact).fold(f64::INFINITY, f64::min);
        let stencil = FoldedStencil::new(kernel, &setup.grid.walls).without_nodes_below(touching);
        let coupling = Coupling::new(membranes, &bodies, stencil, &friction, coupling_settings(&setup));
        let method = build_method(&setup, &bodies);
        let mut walls = Walls::new(&setup.grid, setup.obstacles, bodies.field_count(), stencil);
        walls.note_overlaps(&bodies);
        walls.note_solids(&bodies);
        let grid = build_grid(&setup.grid, &walls, cutoffs);
        let mut mpm = Self {
            grid,
            ghosts: Ghosts::default(),
            walls,
            bodies,
            coupling,
            method,
            executor: Box::new(Tiles),
            filter_order: 0,
            energy: Energy::new(),
            notices: Notices::default(),
            clock: StepCount::default(),
            timer: Timer::default(),
        };
        mpm.start();
        Ok(mpm)
    }

    /// The first bound of the step and the energy that the ledger starts from.
    fn start(&mut self) {
        for body in self.bodies.iter_mut() {
            // An increment of no time leaves the state as it is and gives the wave speeds.
            let (law, view) = body.view();
            let still = [Tensor::ZERO; CHUNK_LEN];
            let cell = self.grid.cell;
            view.visit(&|chunk: &mut View<'_, D>| chunk.update_law(law, &still[..chunk.len()], 0.0, cell));
        }
        for body in self.bodies.iter_mut() {
            body.largest_wave_speed = stability::largest_wave_speed(body);
        }
        self.clock.bound = self.step_bound();
        let membranes = self.coupling.membranes.iter().map(Membrane::balance);
        let stored = membranes.map(|balance| balance.kinetic_start + balance.strain_start).sum::<f64>();
        self.energy.start(&self.bodies, stored);
        self.notices = Notices::new(self.energy.internal);
    }

    /// The bound of all bodies and membranes [s].
    pub(super) fn step_bound(&self) -> f64 {
        let bounds = self.bodies.iter().map(|body| stability::bound(body, self.grid.cell));
        (self.method.safety * bounds.fold(f64::INFINITY, f64::min)).min(self.coupling.bound())
    }

    /// The solver with transfers as plain loops over the particles: the specification of the fast ones, to compare
    /// with.
    #[must_use]
    pub fn with_plain_transfers(mut self) -> Self {
        self.executor = Box::new(Plain);
        self
    }
}

/// Bodies and membranes of a description, which are taken out of it.
///
/// # Errors
/// Everything in the description that can't be run.
fn build_parts<const D: usize>(setup: &mut Setup<D>) -> Result<(Bodies<D>, Vec<Membrane<D>>), Vec<Diagnostic>> {
    let mut findings = check(setup);
    let fields = field_numbers(&setup.bodies);
    let mut bodies = Vec::new();
    for (index, (body, field)) in std::mem::take(&mut setup.bodies).into_iter().zip(fields).enumerate() {
        match build_body(body, setup.kernel, setup.transfer, setup.grid.cell) {
            Ok(body) => bodies.push((field, body)),
            Err(message) => findings.push(Diagnostic::error(format!("body[{index}].material"), message)),
        }
    }
    let membranes = build_membranes(std::mem::take(&mut setup.membranes), &setup.gravity).unwrap_or_else(|found| {
        findings.extend(found);
        Vec::new()
    });
    let fails = findings.iter().any(|finding| finding.severity == crate::error::Severity::Error);
    if fails { Err(findings) } else { Ok((Bodies::new(bodies), membranes)) }
}

fn coupling_settings<const D: usize>(setup: &Setup<D>) -> CouplingSettings {
    CouplingSettings {
        contact: setup.sheet_contact,
        gap_tolerance: setup.gap_tolerance * setup.grid.cell,
        safety: setup.membrane_safety,
        max_substeps: setup.max_substeps,
        passes: setup.contact_passes,
    }
}

fn build_method<const D: usize>(setup: &Setup<D>, bodies: &Bodies<D>) -> MethodChoices<D> {
    MethodChoices {
        transfer: setup.transfer,
        schedule: SweepSchedule::new(setup.stress_update, setup.locking),
        locking: setup.locking,
        filter_time: filter_time(setup.transfer, bodies, setup.grid.cell),
        // With APIC the nodes lose more than what their forces do.
        dissipation: if setup.transfer == Transfer::Apic { Dissipation::Lost } else { setup.dissipation },
        safety: setup.safety,
        gravity: setup.gravity.clone(),
    }
}

/// The grid with a velocity field for each of the cutoffs.
fn build_grid<const D: usize>(setup: &GridSetup<D>, walls: &Walls<D>, cutoffs: Vec<MassCutoffs>) -> Grid<D> {
    let mut grid = Grid::new(setup.lower, setup.cell, setup.cells, cutoffs.len());
    grid.folds = walls.folds();
    grid.own_folds = (0..cutoffs.len()).map(|field| walls.folds_in(field)).collect();
    grid.fields.iter_mut().zip(cutoffs).for_each(|(field, cutoffs)| field.cutoffs = cutoffs);
    grid
}

/// Findings about descriptions that can't be run, whatever the laws say.
fn check<const D: usize>(setup: &Setup<D>) -> Vec<Diagnostic> {
    let mut findings = Vec::new();
    let mut require = |good: bool, key: &str, message: String| {
        if !good {
            findings.push(Diagnostic::error(key, message));
        }
    };
    let grid = &setup.grid;
    require(grid.cell > 0.0 && grid.cell.is_finite(), "grid.cell", format!("must be positive, is {}", grid.cell));
    require(grid.cells.iter().all(|&n| n > 0), "grid", "needs at least one cell along each axis".into());
    require(grid.lower.is_finite(), "grid.lower", "must be finite".into());
    let membrane_safety = setup.membrane_safety > 0.0 && setup.membrane_safety <= 1.0;
    let message = format!("must be in 0..1, is {}", setup.membrane_safety);
    require(setup.membranes.is_empty() || membrane_safety, "mpm.membrane-safety", message);
    require(setup.safety > 0.0 && setup.safety <= 1.0, "mpm.safety", format!("must be in 0..1, is {}", setup.safety));
    if let Locking::Average { blend } = setup.locking {
        require((0.0..=1.0).contains(&blend), "mpm.locking.blend", format!("must be in 0..=1, is {blend}"));
    }
    if let Transfer::Flip { relaxation, .. } = setup.transfer {
        require(relaxation > 0.0, "mpm.transfer.relaxation", format!("must be positive, is {relaxation}"));
    }
    for (index, body) in setup.bodies.iter().enumerate() {
        check_body(body, grid, |good, key, message| require(good, &format!("body[{index}]{key}"), message));
    }
    findings.extend(ambient::check(&setup.bodies));
    findings
}

/// Checks one body; `require` takes a condition, a key of the body with a dot before it, and the message if the
/// condition fails.
fn check_body<const D: usize>(body: &BodySetup<D>, grid: &GridSetup<D>, mut require: impl FnMut(bool, &str, String)) {
    let upper = grid.lower + Vector::from_fn(|a| f64::from(grid.cells[a])) * grid.cell;
    let inside = |x: &Vector<D>| (0..D).all(|a| (grid.lower[a]..=upper[a]).contains(&x[a]));
    let outside = parallel::count(body.position.len(), |p| !inside(&body.position[p]));
    require(outside == 0, ".region", format!("{outside} particles of `{}` lie outside the grid", body.name));
    let message = format!("`{}` has no particles: the region is smaller than the spacing", body.name);
    require(!body.position.is_empty(), ".region", message);
    let volumes = body.volume.iter().all(|&v| v > 0.0 && v.is_finite());
    require(volumes, ".spacing", "every particle needs a positive volume".into());
    let velocities = body.velocity.iter().all(|v| v.is_finite());
    let gradients = body.velocity_gradient.iter().flat_map(|l| l.0).flatten().all(f64::is_finite);
    require(velocities && gradients, ".velocity", "is not finite everywhere".into());
    let n = body.position.len();
    let lengths = [body.volume.len(), body.velocity.len(), body.state.len()];
    let gradients = body.velocity_gradient.len();
    let message = "positions, volumes, velocities (and their gradients) and states differ in number".into();
    require(lengths == [n; 3] && [0, n].contains(&gradients), "", message);
}

/// The velocity field of each body: groups are numbered as they appear.
fn field_numbers<const D: usize>(bodies: &[BodySetup<D>]) -> Vec<usize> {
    let mut groups = Vec::new();
    let mut number = |group: usize| {
        groups.iter().position(|&g| g == group).unwrap_or_else(|| {
            groups.push(group);
            groups.len() - 1
        })
    };
    bodies.iter().map(|body| number(body.group)).collect()
}

/// The material points of one body in their first state.
fn build_body<const D: usize>(
    setup: BodySetup<D>,
    kernel: KernelKind,
    transfer: Transfer,
    cell: f64,
) -> Result<Body<D>, String> {
    let n = setup.position.len();
    let mut affine = setup.velocity_gradient;
    affine.resize(if transfer == Transfer::Apic { n } else { 0 }, Tensor::ZERO);
    let mut particles = Particles {
        id: (0..n as u32).collect(),
        position: setup.position,
        velocity: setup.velocity,
        affine,
        wave_speed: vec![0.0; n],
        ..Particles::default()
    };
    set_first_state(&mut particles, &*setup.law, &setup.state, &setup.volume)?;
    let depth = depth_in_edges::<D>(&setup.depth, &particles.volume, setup.law.keeps_shape());
    let width = parallel::sum(n, |p| particles.volume[p].powf(1.0 / D as f64)) / n.max(1) as f64;
    let kernel = Kernel::new(kernel, 0.5 * width / cell);
    let body = Body::new(setup.name, setup.law.into(), kernel, particles);
    Ok(Body { skin: setup.skin, depth, traction: setup.traction, ambient: setup.ambient, ..body })
}

/// Gives placed particles their volumes [m³] and the masses, energies, pressures and stresses that the law makes of
/// their start.
fn set_first_state<const D: usize>(
    particles: &mut Particles<D>,
    law: &dyn PointLaw,
    start: &[StartState],
    volume: &[f64],
) -> Result<(), String> {
    let storage = law.storage();
    particles.allocate(storage);
    let reference = law.density();
    for (p, (start, &volume)) in start.iter().zip(volume).enumerate() {
        let state = law.initial(start)?;
        let mass = state.density * volume;
        particles.mass.push(mass);
        particles.volume.push(volume);
        particles.energy.push(state.energy * mass / reference);
        particles.pressure.push(state.pressure);
        particles.wave_speed[p] = state.sound_speed;
        if storage.stress {
            particles.stress[p] = state.stress;
        }
        if storage.deformation {
            particles.deformation[p] = state.deformation;
        }
    }
    Ok(())
}

/// The masses below which the nodes of each field are small, from the lightest particle among its bodies.
fn mass_cutoffs<const D: usize>(bodies: &Bodies<D>, kernel: Kernel, transfer: &Transfer) -> Vec<MassCutoffs> {
    let lightest_of = |body: &Body<D>| parallel::min(body.particles.len(), |p| body.particles.mass[p]);
    let lightest = |field: usize| bodies.field(field).iter().map(lightest_of).fold(f64::INFINITY, f64::min);
    (0..bodies.field_count()).map(|field| MassCutoffs::new(kernel, transfer, lightest(field))).collect()
}

/// Time between two noise filters [s], from the interval in steps of 0.3 h/c; c: the greatest speed of sound at the
/// start, which the columns of wave speeds hold before the first step.
fn filter_time<const D: usize>(transfer: Transfer, bodies: &Bodies<D>, cell: f64) -> f64 {
    let largest = |body: &Body<D>| parallel::max(body.particles.len(), |p| body.particles.wave_speed[p]);
    let sound = bodies.iter().map(largest).fold(0.0, f64::max);
    match transfer {
        Transfer::Flip { filter_interval: steps @ 1.., .. } if sound > 0.0 => f64::from(steps) * 0.3 * cell / sound,
        _ => f64::INFINITY,
    }
}

/// Depths below the surface [m] in edges of the particles' volumes. A fluid's particles may come to the surface from
/// below: they don't reach farther than half an edge.
fn depth_in_edges<const D: usize>(depth: &[f64], volume: &[f64], keeps_shape: bool) -> Vec<f64> {
    let most = if keeps_shape { f64::INFINITY } else { 0.5 };
    depth.iter().zip(volume).map(|(d, v)| (d / v.powf(1.0 / D as f64)).clamp(0.0, most)).collect()
}
