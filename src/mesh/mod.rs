//! Meshes: facets of membranes, generated or read from files, and their checks; volumes of
//! triangles and tetrahedra.
//!
//! * [`Facets`]: quadrilaterals and triangles in 3D, segments in 2D, with named sets of nodes;
//! * [`generate`]: sheets, discs, cylinders, tubes, spheres, chains and circles;
//! * [`domain`]: whole domains of triangles or tetrahedra, refined, with holes;
//! * [`QuadraticMesh`]: quadrilaterals and hexahedra of second order, of solids;
//! * [`gmsh`]: files of Gmsh, versions 2.2 and 4.1, ASCII and binary;
//! * [`check`]: inverted, degenerate, doubled, dangling;
//! * [`Mesh`]: simplices with their shape functions, neighbours and point location.

pub mod check;
mod closed;
pub mod domain;
mod facets;
pub mod generate;
pub mod gmsh;
pub mod quadratic;
mod simplex;
mod turned;

pub use closed::{ClosedSurface, closed_surfaces};
pub use domain::DomainMesh;
pub use facets::{Facets, FileNumbers};
pub use generate::MembraneShape;
pub use quadratic::{Deviation, ElementSize, QuadraticMesh, SurfacePatches};
pub use simplex::{CellCut, Facet, Location, Locator, Mesh, Simplex, side_names};
pub use turned::ClosedPart;
