//! Files that runs write, read back.

mod checkpoint;
mod flow;
mod picture;
mod plot;
mod probe;
mod vtk;
