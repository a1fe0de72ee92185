//! Interfaces, particles and solids of a run: each with the stages of a step that change it, between the solutions of
//! the system of velocity and pressure.
//!
//! ```text
//! interface         fractions of fluids and level set at the nodes                       theory G.2, G.11
//! particles         the particles with their rules and events
//! transport         the convective part of a step: motion, reseeding, and nodal values that go along
//! volumes           the volume of each fluid, kept by shifts of φ or weights of fractions theory G.6
//! unresolved        bound of the velocity of particles relative to the mesh              theory (F.37)
//! stray             particles of one fluid deep inside the other                         theory G.5
//! solids            solids on meshes: prediction, cut of the mesh, motion                theory J.1
//! solid_start       their start, and what its predicted first step leaves of them        theory H.9
//! particle_solids   solids on particles: turn, gather, update                            theory K.3
//! ```

pub(super) mod interface;
mod particle_solids;
pub(super) mod particles;
pub(super) mod solid_start;
pub(super) mod solids;
mod stray;
pub(super) mod transport;
mod unresolved;
mod volumes;

pub use particles::Unresolved;
pub use volumes::VolumeCorrection;
