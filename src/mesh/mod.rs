//! Meshes: facets of membranes, generated or read from files, and what can be wrong with them; volumes of
//! triangles and tetrahedra.
//!
//! * [`Facets`]: quadrilaterals and triangles in 3D, segments in 2D, with named sets of nodes;
//! * [`generate`]: sheets, discs, cylinders, tubes, spheres, chains and circles;
//! * [`gmsh`]: files of Gmsh, versions 2.2 and 4.1, ASCII and binary;
//! * [`check`]: inverted, degenerate, doubled, dangling;
//! * [`Mesh`]: simplices with their shape functions, neighbours and point location.

pub mod check;
mod facets;
pub mod generate;
pub mod gmsh;
mod simplex;

pub use facets::Facets;
pub use generate::MembraneShape;
pub use simplex::{Facet, Location, Locator, Mesh, Simplex};
