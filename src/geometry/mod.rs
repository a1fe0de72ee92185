//! Regions of space: shapes, their unions, intersections and differences, triangulated surfaces;
//! sampling with particles.
//!
//! A region gives the signed distance and the direction of its boundary:
//!
//! ```text
//! d(x) < 0 inside, d(x) = 0 on the boundary, |∇d| = 1, n = ∇d points out
//! A ∪ B: min(d_A, d_B)     A ∩ B: max(d_A, d_B)     complement of A: −d_A
//! ```
//!
//! Distances of primitives are exact. Those of unions and intersections are exact on one side and a
//! bound of the right sign on the other; they never exceed the true distance in size.
//!
//! [`Shape`] is how a case file writes a region; [`Shape::build`] reads its surface files, checks it and
//! makes the [`Region`]. Points have three coordinates; in 2D the third is zero and ignored.

mod bins;
mod closest;
mod direction;
mod outline;
mod polygon;
mod primitive;
mod region;
mod sample;
mod shape;
mod skin;
mod surface;
mod triangles;
mod winding;

pub use bins::SpatialBins;
pub use closest::closest_on_triangle;
pub use direction::{Axis, Direction};
pub use outline::Edge;
pub use polygon::Polygon;
pub use region::{Bounds, Region};
pub use sample::{Sample, centred_origin, sample};
pub use shape::{
    BelowShape, BoxShape, BuildRegion, ComplementShape, CylinderShape, DifferenceShape, EllipsoidShape, HalfSpaceShape,
    Height, IntersectionShape, PolygonShape, RotatedShape, Shape, SphereShape, SurfaceShape, TranslatedShape,
    UnionShape,
};
pub use skin::{SkinPoint, skin};
pub(crate) use surface::IndexedTriangle;
pub use surface::Surface;
pub use triangles::{Faces, Triangles};
pub use winding::{FacetCorners, Winding};
