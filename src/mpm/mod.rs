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

mod ambient;
mod average;
mod build;
mod columns;
mod contact;
mod coupling;
mod filter;
pub mod ghost;
pub mod grid;
mod health;
mod heat;
pub mod kernel;
mod ledger;
mod light;
mod membrane;
mod motion;
mod notices;
mod particles;
pub mod plain;
pub mod proximity;
mod regions;
mod setup;
mod shifting;
mod sides;
mod snapshot;
mod stability;
pub mod stencil;
mod step;
mod strain;
mod stress;
mod sweep;
pub mod traction;
mod volumes;
pub mod wall;

pub use coupling::SubStep;
pub use grid::{ActiveBlocks, EDGE, Field, Grid, Node};
pub use heat::Dissipation;
pub use kernel::Kernel;
pub use membrane::{Balance, Elements, Membrane};
pub use particles::{Body, Part, Particles, Work};
pub use setup::{
    BodySetup, Friction, GridSetup, KernelKind, Locking, MembraneSetup, Obstacle, Setup, SheetContact, StressUpdate,
    SupportSetup, Transfer, Wall, WallKind,
};
pub use sides::astray;
use step::{Accounts, Tally};
pub use step::{Mpm, Step};
pub use traction::{Load, Traction};
