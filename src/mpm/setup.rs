//! The description of a run: complete and checked, made by the case layer.

use super::kernel::KernelKind;
use super::traction::Traction;
use crate::geometry::{Region, SkinPoint};
use crate::material::{PointLaw, Sheet, StartState};
use crate::math::{Signal, Tensor, Vector};

/// Everything that a run of the material point method starts from.
#[derive(Debug)]
pub struct Setup<const D: usize> {
    /// The background grid.
    pub grid: GridSetup<D>,
    /// Shape functions.
    pub kernel: KernelKind,
    /// Particle–grid transfer.
    pub transfer: Transfer,
    /// The fate of the energy that FLIP and its filter dissipate.
    pub dissipation: Dissipation,
    /// The time of the stress update in a step.
    pub stress_update: StressUpdate,
    /// Cure of volumetric locking.
    pub locking: Locking,
    /// Fraction of the stable step of the particles (theory A.15).
    pub safety: f64,
    /// Fraction of the stable step of the membranes.
    pub membrane_safety: f64,
    /// Most membrane sub-steps per step of the bodies (1: no sub-cycling, as in the paper).
    pub max_substeps: usize,
    /// Passes of contact between membranes and bodies per sub-step (theory D.7; 1: the paper).
    pub contact_passes: usize,
    /// Body force per unit mass, a formula per axis [m/s²].
    pub gravity: [Signal; D],
    /// Bodies of material points.
    pub bodies: Vec<BodySetup<D>>,
    /// Membranes.
    pub membranes: Vec<MembraneSetup<D>>,
    /// Rigid obstacles.
    pub obstacles: Vec<Obstacle>,
    /// Contact between named bodies and membranes; pairs not listed use `default_friction`.
    pub friction: Vec<(String, String, Friction)>,
    /// Contact of pairs that are not listed.
    pub default_friction: Friction,
    /// The method of contact between membranes and bodies.
    pub sheet_contact: SheetContact,
    /// Gap below which contact acts, in cells (theory D.3; default 0).
    pub gap_tolerance: f64,
}

/// The grid.
#[derive(Debug, Clone)]
pub struct GridSetup<const D: usize> {
    /// Lower corner of the domain [m].
    pub lower: Vector<D>,
    /// Cell size [m].
    pub cell: f64,
    /// Cells along each axis.
    pub cells: [i32; D],
    /// Walls: `[axis][0]` at the lower, `[axis][1]` at the upper end.
    pub walls: [[Wall; 2]; D],
}

/// A domain wall.
#[derive(Debug, Clone, Default)]
pub struct Wall {
    /// Effect of the wall on the grid velocity.
    pub kind: WallKind,
    /// Velocity of the wall along each axis (3 entries; unused ones zero) [m/s].
    pub velocity: [Signal; 3],
}

/// The effect of a wall or obstacle on the grid velocity relative to it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum WallKind {
    /// Nothing may pass; particles that leave stop the run with an error.
    #[default]
    Open,
    /// No motion at all (no slip).
    Fixed,
    /// No normal motion: a symmetry plane, mirrored exactly.
    Slip,
    /// No motion into the wall; free to leave, no friction.
    Separate,
    /// As `Separate`, with Coulomb friction.
    Friction {
        /// Coefficient.
        coefficient: f64,
    },
}

/// A rigid obstacle.
#[derive(Debug)]
pub struct Obstacle {
    /// Name, for reaction histories.
    pub name: String,
    /// Shape of the obstacle at the start.
    pub region: Region,
    /// Effect of the obstacle on the grid velocity.
    pub kind: WallKind,
    /// Velocity of the obstacle [m/s] (rigid translation).
    pub velocity: [Signal; 3],
}

/// Particle–grid transfer (theory A.6, A.7).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Transfer {
    /// FLIP, relaxed towards PIC with time constant `relaxation` [s] (infinity: pure FLIP): the PIC fraction
    /// of a step is 1 − exp(−Δt/relaxation). At fixed times one FMPM(k) update removes the
    /// noise that the grid can't see.
    Flip {
        /// Time constant [s].
        relaxation: f64,
        /// Order k of the filter; 0: never.
        filter_order: u32,
        /// Time between two filters, in steps of 0.3 h/c with the speed of sound at the start; 0: never.
        filter_interval: u32,
    },
    /// Affine particle-in-cell: conserves angular momentum.
    Apic,
}

/// The fate of the kinetic energy that FLIP and its filter dissipate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dissipation {
    /// Into the internal energy of bodies whose pressure depends on it.
    Heat,
    /// Nowhere (the paper).
    Lost,
}

/// The time of the stress update in a step (theory A.8).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StressUpdate {
    /// Stress update before the forces (the paper; USF).
    First,
    /// Stress update after the particles moved, with the grid velocity (USL).
    Last,
    /// Stress update after re-mapping the particles' new velocity (MUSL).
    ModifiedLast,
    /// Half first, half modified last (USAVG).
    Average,
}

/// Cure of volumetric locking (theory A.10).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Locking {
    /// None (the paper).
    None,
    /// Volume change averaged through the grid (J̄ / F̄), blended with weight `blend` in 0..=1.
    Average {
        /// Weight of the average.
        blend: f64,
    },
}

/// The method of contact between membranes and bodies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SheetContact {
    /// At grid nodes (the paper; theory D.5).
    Nodes,
    /// At the particles, on the surface of the membrane itself (theory D.9).
    Particles,
}

/// Friction between two bodies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Friction {
    /// The pair never meets (they pass through each other).
    None,
    /// Coulomb slip; 0: frictionless.
    Slip(f64),
    /// Stick: no relative motion while pressed together.
    Stick,
}

/// Particles of one body at the start.
#[derive(Debug)]
pub struct BodySetup<const D: usize> {
    /// Name.
    pub name: String,
    /// Law.
    pub law: Box<dyn PointLaw>,
    /// Bodies with the same group share a velocity field; by default no two share one.
    pub group: usize,
    /// Particle positions [m].
    pub position: Vec<Vector<D>>,
    /// Points on its surface, for a body that keeps its shape; empty: any particle may come to the surface.
    pub skin: Vec<SkinPoint>,
    /// Depth of each particle below the body's surface [m]; empty: half an edge of its volume.
    pub depth: Vec<f64>,
    /// Volume of each particle at the start [m³].
    pub volume: Vec<f64>,
    /// Velocity of each particle at the start [m/s].
    pub velocity: Vec<Vector<D>>,
    /// ∂v_i/∂x_j around each particle at the start [1/s], which affine particles carry from the first step on; empty:
    /// zero.
    pub velocity_gradient: Vec<Tensor<D>>,
    /// First state of each particle.
    pub state: Vec<StartState>,
    /// Loads on the surface; identities are indices of `position`.
    pub traction: Vec<Traction>,
    /// Pressure of the atmosphere around it, which isn't modelled [Pa]; above zero for ideal gases alone.
    pub ambient: f64,
}

/// A membrane at the start.
#[derive(Debug)]
pub struct MembraneSetup<const D: usize> {
    /// Name.
    pub name: String,
    /// Law.
    pub sheet: Box<dyn Sheet>,
    /// Node positions [m].
    pub position: Vec<Vector<D>>,
    /// Node velocities at the start [m/s].
    pub velocity: Vec<Vector<D>>,
    /// Elements: 4 (quadrilateral), 3 (triangle) nodes in 3D, 2 (segment) in 2D.
    pub elements: Vec<Vec<u32>>,
    /// Direction of the first material axis (warp) of each element in the reference state; empty: isotropic.
    pub warp: Vec<Vector<D>>,
    /// Thickness at the start [m].
    pub thickness: f64,
    /// Prestress in the sheet, true stress along the local axes (xx, yy) [Pa].
    pub prestress: [f64; 2],
    /// In-plane hourglass stiffness r_m (0.05; not of sheets that wrinkle), viscosity r_v (0), out-of-plane viscosity
    /// r_w (0.01) (theory C.5).
    pub hourglass: [f64; 3],
    /// Stiffness-proportional damping time β_d as a fraction of the step (≤ 0.05), and mass-proportional rate [1/s].
    pub damping: [f64; 2],
    /// Supports and prescribed motions.
    pub supports: Vec<SupportSetup>,
    /// Pressure along the element normal as a formula [Pa]; positive pushes along +n.
    pub pressure: Signal,
    /// True: the pressure follows the deformed normal; false: dead load on the reference shape.
    pub follower: bool,
    /// Half the thickness counts in the contact gap (true) or only the mid-surface (false).
    pub contact_thickness: bool,
}

/// Nodes whose motion is prescribed.
#[derive(Debug, Clone)]
pub struct SupportSetup {
    /// Nodes.
    pub nodes: Vec<u32>,
    /// Prescribed velocity per axis [m/s]; `None`: free in this axis.
    pub velocity: [Option<Signal>; 3],
}
