//! Files of a run: fields for ParaView, histories, checkpoints, plots and pictures.
//!
//! Everything here sees [`Snapshot`](crate::simulation::Snapshot)s only, so it works for both methods.
//! Every file is either whole or not there: files are written to a temporary name and then renamed
//! ([`atomic`]), and histories grow by whole rows ([`history`]).

pub mod atomic;
pub mod balance;
mod canvas;
pub mod checkpoint;
pub mod colour;
pub mod component;
pub mod fields;
pub mod force;
pub mod history;
pub mod image;
pub mod label;
pub mod picture;
pub mod plot;
pub mod probe;
mod set;
mod ticks;
pub mod vtk;

pub use balance::BalanceHistory;
pub use checkpoint::{Checkpoints, fingerprint};
pub use component::Component;
pub use fields::{FieldPrecision, Fields};
pub use force::{CountHistory, Forces};
pub use history::History;
pub use label::UnitLabels;
pub use picture::{Picture, PictureSpec};
pub use probe::{Probe, ProbeSpec};
