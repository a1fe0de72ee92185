//! What is computed beside the solution: forces, energies, checks, and what outputs and checkpoints see (theory F.12–F.14).
//!
//! ```text
//! forces      forces of the fluid on parts of the boundary                theory (F.38)
//! ledger      energy and momentum of the flow                             theory F.13
//! friction    viscous dissipation of a step                               theory (F.40)
//! through     energy and momentum that the flow carries through openings  theory F.13
//! available   available potential energy, and the check against it        theory F.14
//! checks      what a run is watched for
//! health      errors that stop a run
//! notices     notices of a run
//! snapshot    the state as outputs see it, and the columns of checkpoints
//! ```

pub(super) mod available;
mod checks;
pub mod forces;
pub(super) mod friction;
pub(super) mod health;
pub(super) mod ledger;
pub(super) mod notices;
pub(super) mod snapshot;
pub(super) mod through;
