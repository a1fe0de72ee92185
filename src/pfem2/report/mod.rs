//! Results beside the solution: forces, energies, checks, snapshots and checkpoints (theory F.12–F.14).
//!
//! ```text
//! forces      forces of the fluid on parts of the boundary                theory (F.38)
//! moments     their moments about points                              theory J.6
//! ledger      energy and momentum of the flow                             theory F.13
//! dissipation viscous dissipation of a step                               theory (F.40)
//! through     energy and momentum that the flow carries through openings  theory F.13
//! available   available potential energy, and the check against it        theory F.14
//! balance     the energy balance of a run, and its checks
//! solids      energy of solids                                        theory J.6
//! strain      energy of solids on particles                               theory K.6
//! health      errors that stop a run
//! notices     notices of a run
//! snapshot    the state as outputs see it
//! checkpoint  the columns of a checkpoint
//! ```

pub(super) mod available;
pub(super) mod balance;
pub(super) mod checkpoint;
pub(super) mod dissipation;
pub(super) mod forces;
pub(super) mod health;
pub(super) mod ledger;
pub mod moments;
pub(super) mod notices;
pub(super) mod snapshot;
pub(super) mod solids;
pub(super) mod strain;
pub(super) mod through;
