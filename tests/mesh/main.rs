//! Meshes, generated and read, and the geometry that they are made from.

mod domain;
mod generated;
mod geometry;
mod gmsh;
mod simplex;
