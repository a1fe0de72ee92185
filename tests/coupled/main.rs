//! Bodies and membranes together.

#[path = "../mpm/bits.rs"]
mod bits;
mod gas;
mod impact;
mod leave;
mod lids;
mod model;
mod repeat;
mod rests;
mod slack;
