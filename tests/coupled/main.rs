//! Bodies and membranes together.

mod gas;
mod impact;
mod model;
