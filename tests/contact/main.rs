//! Contact alone: conservation, the laws of impact and friction, and when it begins.

mod conservation;
mod laws;
mod world;
