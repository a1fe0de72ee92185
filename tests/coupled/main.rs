//! Bodies and membranes together.

mod ambient;
#[path = "../mpm/bits.rs"]
mod bits;
mod enclose;
mod gas;
mod impact;
mod lids;
mod liquid;
mod model;
mod proximity;
mod regions;
mod repeat;
mod rigid_contact;
mod slack;
mod stopped_runs;
mod wrinkling;
