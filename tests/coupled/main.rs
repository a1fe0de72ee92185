//! Bodies and membranes together.

mod ambient;
#[path = "../mpm/bits.rs"]
mod bits;
mod enclose;
mod gas;
mod impact;
mod leave;
mod lids;
mod liquid;
mod meet;
mod model;
mod regions;
mod repeat;
mod rests;
mod slack;
