//! Bodies on both sides of membranes at the start: fluids are divided by the regions of closed membranes (`parts`,
//! theory D.13), and `sides` warns of bodies that membranes cut.

pub(in crate::mpm) mod parts;
mod sides;

pub use sides::check_sides;
