//! **lateen** — fluid–structure interaction with particles, without remeshing.
//!
//! Two methods, one program:
//! * [`mpm`]: the explicit material point method for fluids, gases and solids, coupled with membrane
//!   finite elements by contact on the background grid (Lian, Liu & Zhang 2014);
//! * [`pfem2`]: PFEM-2 for several incompressible fluids, and elastic and rigid solids in them, in one implicit system
//!   (Becker, Idelsohn & Oñate 2015).
//!
//! A case file describes a problem; [`case`] checks it and builds a [`simulation::Solver`]; the time
//! loop in [`simulation`] steps it, shows snapshots to the [`output`] monitors and writes checkpoints.

#![deny(unsafe_code)]
#![warn(missing_docs)]
// Units stand in brackets, [m], which rustdoc takes for links; `.ci/run` looks at the others.
#![allow(rustdoc::broken_intra_doc_links)]

pub mod error;
pub mod input;
pub mod memory;
pub mod registry;

pub mod math;

pub mod geometry;
pub mod material;
pub mod mesh;
pub mod parallel;

pub mod linalg;

pub mod simulation;

pub mod mpm;
pub mod pfem2;

pub mod output;

pub mod case;

pub mod catalog;

pub mod run;

pub mod verify;

pub use error::{Error, Result};
