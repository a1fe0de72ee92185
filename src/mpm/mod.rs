//! The explicit material point method with membranes (Lian, Liu & Zhang 2014, corrected).
//!
//! Particles carry mass m_p, velocity v_p, stress σ_p; a background grid that is thrown away after each
//! step integrates momentum; membranes are finite elements that meet the particles on that grid:
//!
//! ```text
//! m_I = Σ m_p N_Ip                                   Lian (60)
//! p_I = Σ m_p v_p N_Ip                               Lian (61)
//! f_I = −Σ V_p σ_p ∇N_Ip + Σ m_p N_Ip b              Lian (17, 18)
//! p̄_I = p_I + Δt f_I                                 Lian (64)
//! v_K = v_K + Δt f_K / m_K                           Lian (46)
//! J_I = M (v̄_r − v̄_s), M = m_r m_s / (m_r + m_s)      Lian (49–58), corrected; on the body
//! v_p += Δt Σ N_Ip f_I / m_I,  x_p += Δt Σ N_Ip p_I / m_I   Lian (65, 19)
//! ```
//!
//! | room | what it holds |
//! |---|---|
//! | `kernel` | shape functions |
//! | `traction`, `setup`, `leapfrog` | loads on surfaces, what a run starts from, the times of a step |
//! | `grid` | velocity fields on a sparse lattice, ghosts, nodes of small mass |
//! | `bins` | the order of particles by blocks of the grid |
//! | `particles` | material points in columns, the bodies by velocity field, and checks of their state |
//! | `transfer` | scatter and gather over sorted particles |
//! | `motion`, `spacing`, `stress` | what is done with gathered sums: velocities, positions, shifts, strain, stress, averages against locking, heat |
//! | `executor` | the visits of a schedule, computed by transfers or by plain loops |
//! | `wall` | walls of the domain and rigid obstacles |
//! | `membrane` | finite elements of membranes |
//! | `contact` | impulses between membranes and bodies, and between bodies |
//! | `proximity` | membranes that meet each other or themselves |
//! | `coupling` | the sub-steps of membranes, with contact |
//! | `regions` | bodies on both sides of membranes at the start |
//! | `corrections` | spacing of the particles of liquids, volumes of the particles of gases |
//! | `state` | ledger, notices, checks, the stable step |
//! | `step` | the step, its stages and schedule, the noise filter |
//! | `report` | the solver as the time loop, outputs and checkpoints see it |
//! | `build` | from a description to a solver |
//!
//! A room imports those above it in this table, and no other.

mod bins;
mod build;
mod contact;
mod corrections;
mod coupling;
mod executor;
pub mod grid;
pub mod kernel;
mod leapfrog;
mod membrane;
mod motion;
mod particles;
pub mod proximity;
mod regions;
mod report;
mod setup;
mod spacing;
mod state;
mod step;
mod stress;
pub mod traction;
mod transfer;
pub mod wall;

pub use grid::{EDGE, Grid, Node, VelocityField};
pub use kernel::{Kernel, KernelKind};
pub use leapfrog::{LeapfrogStep, SubStep};
pub use membrane::{Balance, Membrane, MembraneElements};
pub use particles::{Body, Part, Particles, Work};
pub use regions::check_sides;
pub use setup::{
    BodySetup, Dissipation, Friction, GridSetup, Locking, MembraneSetup, Obstacle, Setup, SheetContact, StressUpdate,
    SupportSetup, Transfer, Wall, WallKind,
};
pub use step::Mpm;
pub use traction::{Load, Traction};
