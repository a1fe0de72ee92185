//! VTK's XML formats: `.vtu` (meshes and membranes), `.vtp` (particles, surfaces of solids), `.pvd` (series over time).
//!
//! Source: *VTK File Formats* (Kitware), sections "XML File Formats" and "appended data". Arrays are
//! appended raw in little-endian blocks, each compressed by zlib; an array starts with
//! `[number of blocks][bytes per block][bytes of a partial last block][compressed bytes …]` as `UInt64`.
//! Arrays are written one at a time, so that a file needs little memory beside the state itself.

mod array;
mod data_set;
mod read;
mod series;

pub use array::FieldPrecision;
pub use data_set::{write_outline, write_points, write_surface};
pub use read::read_array;
pub use series::FileSeries;
