//! Contact alone: conservation, the laws of impact and friction, when it begins, folds and both sides of a sheet.

mod conservation;
mod laws;
mod model;
mod passes;
mod random;
mod sides;
