//! Bodies and membranes together.

mod gas;
mod model;
