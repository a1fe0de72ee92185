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
//! | `grid` | velocity fields on a sparse lattice, shape functions, ghosts, nodes of small mass |
//! | `particles` | material points in columns, their motion, tractions, shifting, volumes, regions |
//! | `stress` | strain, stress update, averages against locking, noise filter, heat, atmosphere |
//! | `transfer` | scatter and gather over sorted particles, and the same sums as plain loops |
//! | `membrane` | finite elements of membranes |
//! | `contact` | impulses between membranes and bodies, and between bodies |
//! | `wall` | walls of the domain and rigid obstacles |
//! | `state` | ledger, checkpoints, snapshots, checks, the stable step |

mod build;
mod contact;
mod coupling;
pub mod grid;
mod leapfrog;
mod membrane;
mod particles;
mod setup;
mod state;
mod step;
mod stress;
mod transfer;
pub mod wall;

pub use coupling::SubStep;
pub use grid::kernel::KernelKind;
pub use grid::{EDGE, Grid, Kernel, Node, VelocityField};
pub use leapfrog::LeapfrogStep;
pub use membrane::{Balance, Membrane, MembraneElements};
pub use particles::sides::check_sides;
pub use particles::traction::{self, Load, Traction};
pub use particles::{Body, Part, Particles, Work};
pub use setup::{
    BodySetup, Dissipation, Friction, GridSetup, Locking, MembraneSetup, Obstacle, Setup, SheetContact, StressUpdate,
    SupportSetup, Transfer, Wall, WallKind,
};
pub use state::proximity;
pub use step::Mpm;
