//! Bodies and membranes together.

mod gas;
mod impact;
mod leave;
mod model;
mod repeat;
