//! Regions: signed distance, normal, bounds, volume.

use super::primitive::{self, Distance};
use super::{Polygon, Surface, Triangles};
use crate::math::Vector;
use std::f64::consts::PI;
use std::sync::Arc;

/// A region of space. Made directly or from a [`Shape`](super::Shape) of a case file, which checks it.
///
/// ```
/// use lateen::geometry::{Region, sample};
///
/// let ball = Region::Sphere { center: [0.0; 3], radius: 2.0 };
/// assert_eq!(ball.signed_distance([0.0, 3.0, 0.0]), 1.0);
/// assert_eq!(ball.normal([0.0, 1.0, 0.0]), [0.0, 1.0, 0.0]);
/// let particles = sample(&ball, 0.25, 3, [0.0; 3]).unwrap();
/// assert!(particles.position.iter().all(|&x| ball.contains(x)));
/// ```
#[derive(Debug, Clone)]
pub enum Region {
    /// An axis-aligned box; in 2D a rectangle, whose third bounds are infinite.
    Box {
        /// Lower corner [m].
        lower: [f64; 3],
        /// Upper corner [m].
        upper: [f64; 3],
    },
    /// A sphere (a disc in 2D).
    Sphere {
        /// Centre [m].
        center: [f64; 3],
        /// Radius [m].
        radius: f64,
    },
    /// An ellipsoid with semi-axes along x, y, z (an ellipse in 2D).
    Ellipsoid {
        /// Centre [m].
        center: [f64; 3],
        /// Semi-axes [m]; the third is infinite in 2D.
        semi_axes: [f64; 3],
    },
    /// A cylinder with flat ends; 3D only.
    Cylinder {
        /// Centre of one end [m].
        from: [f64; 3],
        /// Centre of the other end [m].
        to: [f64; 3],
        /// Radius [m].
        radius: f64,
    },
    /// Everything behind a plane.
    HalfSpace {
        /// A point of the plane [m].
        point: [f64; 3],
        /// Unit normal, out of the region.
        normal: [f64; 3],
    },
    /// A polygon in the x-y plane; in 3D extruded along z.
    Polygon(Arc<Polygon>),
    /// The volume inside a closed triangulated surface; 3D only.
    Surface(Arc<Surface>),
    /// The union of regions.
    Union(Vec<Region>),
    /// The intersection of regions.
    Intersection(Vec<Region>),
    /// The complement of a region.
    Complement(Box<Region>),
    /// A region moved rigidly: x ↦ R x + shift.
    Placed {
        /// The region before the motion.
        region: Box<Region>,
        /// Rotation R, by rows.
        rotation: [[f64; 3]; 3],
        /// Translation after the rotation [m].
        shift: [f64; 3],
    },
}

/// An axis-aligned box around a region [m]; infinite where the region is unbounded.
/// In 2D the third entries are not used.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// Lower corner [m].
    pub lower: [f64; 3],
    /// Upper corner [m].
    pub upper: [f64; 3],
}

impl Bounds {
    /// All of space.
    pub const EVERYWHERE: Self = Self { lower: [f64::NEG_INFINITY; 3], upper: [f64::INFINITY; 3] };
    /// The empty box.
    pub const NOWHERE: Self = Self { lower: [f64::INFINITY; 3], upper: [f64::NEG_INFINITY; 3] };

    /// True if the region does not reach to infinity along the first `dimension` axes.
    pub fn is_bounded(&self, dimension: usize) -> bool {
        (0..dimension).all(|i| self.lower[i].is_finite() && self.upper[i].is_finite())
    }

    fn around(points: impl IntoIterator<Item = [f64; 3]>) -> Self {
        points.into_iter().fold(Self::NOWHERE, |b, x| b.hull(&Self { lower: x, upper: x }))
    }

    fn hull(&self, other: &Self) -> Self {
        Self {
            lower: std::array::from_fn(|i| self.lower[i].min(other.lower[i])),
            upper: std::array::from_fn(|i| self.upper[i].max(other.upper[i])),
        }
    }

    fn common(&self, other: &Self) -> Self {
        Self {
            lower: std::array::from_fn(|i| self.lower[i].max(other.lower[i])),
            upper: std::array::from_fn(|i| self.upper[i].min(other.upper[i])),
        }
    }

    /// Bounds of the rotated box, by the extreme of each term; zero times infinity is zero here.
    fn placed(&self, rotation: &[[f64; 3]; 3], shift: &[f64; 3]) -> Self {
        let extreme = |i: usize, pick: fn(f64, f64) -> f64| {
            let term = |j: usize| {
                let r = rotation[i][j];
                if r == 0.0 { 0.0 } else { pick(r * self.lower[j], r * self.upper[j]) }
            };
            shift[i] + term(0) + term(1) + term(2)
        };
        Self {
            lower: std::array::from_fn(|i| extreme(i, f64::min)),
            upper: std::array::from_fn(|i| extreme(i, f64::max)),
        }
    }
}

impl Region {
    /// True inside or on the boundary.
    pub fn contains(&self, x: [f64; 3]) -> bool {
        self.signed_distance(x) <= 0.0
    }

    /// Distance to the boundary [m], negative inside: exact for primitives; for unions, intersections and
    /// complements of them a value of the right sign that is not larger than the true distance.
    pub fn signed_distance(&self, x: [f64; 3]) -> f64 {
        self.distance(Vector(x)).0
    }

    /// Outward unit normal: the direction in which the signed distance grows at `x`.
    pub fn normal(&self, x: [f64; 3]) -> [f64; 3] {
        self.distance(Vector(x)).1.0
    }

    /// Signed distance [m] and outward unit normal together, at the price of one.
    pub fn distance_and_normal(&self, x: [f64; 3]) -> (f64, [f64; 3]) {
        let (d, n) = self.distance(Vector(x));
        (d, n.0)
    }

    fn distance(&self, x: Vector<3>) -> Distance {
        match self {
            Self::Box { lower, upper } => primitive::cuboid(*lower, *upper, x),
            Self::Sphere { center, radius } => primitive::sphere(Vector(*center), *radius, x),
            Self::Ellipsoid { center, semi_axes } => primitive::ellipsoid(Vector(*center), *semi_axes, x),
            Self::Cylinder { from, to, radius } => primitive::cylinder(Vector(*from), Vector(*to), *radius, x),
            Self::HalfSpace { point, normal } => primitive::half_space(Vector(*point), Vector(*normal), x),
            Self::Polygon(polygon) => polygon.distance(x),
            Self::Surface(surface) => surface.distance(x),
            Self::Union(members) => {
                let nearer = |a: Distance, b: Distance| if b.0 < a.0 { b } else { a };
                members.iter().map(|m| m.distance(x)).fold((f64::INFINITY, Vector::unit(0)), nearer)
            }
            Self::Intersection(members) => {
                let farther = |a: Distance, b: Distance| if b.0 > a.0 { b } else { a };
                members.iter().map(|m| m.distance(x)).fold((f64::NEG_INFINITY, Vector::unit(0)), farther)
            }
            Self::Complement(region) => {
                let (d, n) = region.distance(x);
                (-d, -n)
            }
            Self::Placed { region, rotation, shift } => {
                let back = Vector::from_fn(|i| (0..3).map(|j| rotation[j][i] * (x[j] - shift[j])).sum());
                let (d, n) = region.distance(back);
                (d, Vector::from_fn(|i| (0..3).map(|j| rotation[i][j] * n[j]).sum()))
            }
        }
    }

    /// A box around the region [m]: tight for primitives, not always for the others.
    pub fn bounds(&self) -> Bounds {
        let about = |center: &[f64; 3], reach: [f64; 3]| Bounds {
            lower: std::array::from_fn(|i| center[i] - reach[i]),
            upper: std::array::from_fn(|i| center[i] + reach[i]),
        };
        match self {
            Self::Box { lower, upper } => Bounds { lower: *lower, upper: *upper },
            Self::Sphere { center, radius } => about(center, [*radius; 3]),
            Self::Ellipsoid { center, semi_axes } => about(center, *semi_axes),
            Self::Cylinder { from, to, radius } => cylinder_bounds(from, to, *radius),
            Self::HalfSpace { point, normal } => half_space_bounds(point, normal),
            Self::Polygon(polygon) => {
                let corners = polygon.corners().iter().map(|c| c.to3());
                let [lower, upper] = polygon.heights();
                let plane = Bounds::around(corners);
                Bounds {
                    lower: [plane.lower[0], plane.lower[1], lower],
                    upper: [plane.upper[0], plane.upper[1], upper],
                }
            }
            Self::Surface(surface) => Bounds::around(surface.vertices()),
            Self::Union(members) => members.iter().fold(Bounds::NOWHERE, |b, m| b.hull(&m.bounds())),
            Self::Intersection(members) => members.iter().fold(Bounds::EVERYWHERE, |b, m| b.common(&m.bounds())),
            Self::Complement(region) => match region.as_ref() {
                Self::HalfSpace { point, normal } => half_space_bounds(point, &normal.map(|n| -n)),
                _ => Bounds::EVERYWHERE,
            },
            Self::Placed { region, rotation, shift } => region.bounds().placed(rotation, shift),
        }
    }

    /// The triangles around a region that comes from a file, also where it was moved; `None` for all others.
    pub fn triangles(&self) -> Option<Triangles> {
        match self {
            Self::Surface(surface) => Some(surface.triangles()),
            Self::Placed { region, rotation, shift } => {
                let mut own = region.triangles()?;
                for x in &mut own.vertices {
                    *x = std::array::from_fn(|i| shift[i] + (0..3).map(|j| rotation[i][j] * x[j]).sum::<f64>());
                }
                Some(own)
            }
            _ => None,
        }
    }

    /// Volume [m³], or area [m²] in 2D, where a formula gives it: primitives and moved primitives.
    /// `None` for unions, intersections, complements and unbounded regions.
    pub fn measure(&self, dimension: usize) -> Option<f64> {
        let value = match self {
            Self::Box { lower, upper } => (0..dimension).map(|i| upper[i] - lower[i]).product(),
            Self::Sphere { radius, .. } => ball(dimension) * radius.powi(dimension as i32),
            Self::Ellipsoid { semi_axes, .. } => ball(dimension) * semi_axes[..dimension].iter().product::<f64>(),
            Self::Cylinder { from, to, radius } => PI * radius * radius * (Vector(*to) - Vector(*from)).norm(),
            Self::Polygon(polygon) => {
                let [lower, upper] = polygon.heights();
                polygon.area() * if dimension == 3 { upper - lower } else { 1.0 }
            }
            Self::Surface(surface) => surface.volume(),
            Self::Placed { region, .. } => return region.measure(dimension),
            Self::HalfSpace { .. } | Self::Union(_) | Self::Intersection(_) | Self::Complement(_) => return None,
        };
        value.is_finite().then_some(value)
    }
}

/// Volume of the unit ball, area of the unit disc.
fn ball(dimension: usize) -> f64 {
    if dimension == 2 { PI } else { 4.0 / 3.0 * PI }
}

/// A disc of radius R normal to a reaches R √(1 − a_i²) along axis i.
fn cylinder_bounds(from: &[f64; 3], to: &[f64; 3], radius: f64) -> Bounds {
    let axis = Vector(*to) - Vector(*from);
    let reach = |i: usize| radius * (1.0 - axis[i] * axis[i] / axis.norm_squared()).max(0.0).sqrt();
    Bounds {
        lower: std::array::from_fn(|i| from[i].min(to[i]) - reach(i)),
        upper: std::array::from_fn(|i| from[i].max(to[i]) + reach(i)),
    }
}

/// Bounded on one side where the plane is normal to an axis.
fn half_space_bounds(point: &[f64; 3], normal: &[f64; 3]) -> Bounds {
    let mut bounds = Bounds::EVERYWHERE;
    if let Some(axis) = (0..3).find(|&i| normal.iter().enumerate().all(|(j, n)| (i == j) == (*n != 0.0))) {
        if normal[axis] > 0.0 { bounds.upper[axis] = point[axis] } else { bounds.lower[axis] = point[axis] }
    }
    bounds
}
