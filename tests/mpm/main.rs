//! The material point core against exact solutions, conservation laws and itself (threads, resumed runs).

mod atmosphere;
mod beams;
mod bits;
mod bodies;
mod exact;
mod floors;
mod heat;
mod ledger;
mod manufactured;
mod material_laws;
mod model;
mod plain;
mod resume;
mod spray;
