//! Element shapes: two tangents of the surface, and what a stress resultant along them does to the nodes.
//!
//! All shapes speak the same language. With the tangents g₁, g₂ of an element and their duals g¹, g²
//! (gᵅ·g_β = δ), the gradient of the shape function of node K at the centre is ∇N_K = Σ_α p_αK gᵅ with
//! constant patterns p. A quadrilateral with nodes 1-2-3-4 has (theory C.1; Lian (32, 33))
//!
//! ```text
//! g₁ = χ = x₂ − x₁ + x₃ − x₄     p₁ = ξ_K = (−1, 1, 1, −1)
//! g₂ = ψ = x₃ − x₁ + x₄ − x₂     p₂ = η_K = (−1, −1, 1, 1)      h_K = (1, −1, 1, −1)
//! ```

use super::lanes::{ElementLanes, LaneVector};

/// Tangents of the elements of a block, and the hourglass mode h·x of quadrilaterals (zero for others).
#[derive(Clone, Copy)]
pub struct Modes {
    /// First tangent.
    pub g1: LaneVector,
    /// Second tangent.
    pub g2: LaneVector,
    /// Hourglass mode Σ h_K x_K.
    pub h: LaneVector,
}

/// A kind of element.
pub trait ElementShape<const N: usize> {
    /// Area [m²] (2D: length [m]) over |g₁ × g₂|.
    const AREA: f64;
    /// True for shapes with an hourglass mode.
    const HOURGLASS: bool;
    /// Quadrature points, of equal weight.
    const POINTS: usize = 1;

    /// Tangents and hourglass mode of nodal vectors: positions or velocities.
    /// `depth` is the tangent along the depth of a plane problem: the unit vector for positions, zero for velocities.
    fn modes(x: [LaneVector; N], depth: f64) -> Modes;

    /// Nodal vectors of resultants `p` on g₁'s pattern, `r` on g₂'s and `h` on the hourglass pattern.
    fn spread(p: LaneVector, r: LaneVector, h: LaneVector) -> [LaneVector; N];

    /// Trace and determinant of Σ_K ∇N_K ⊗ ∇N_K from the metric.
    fn gram(m: &Metric) -> [ElementLanes; 2];

    /// Tangents at a quadrature point.
    #[inline(always)]
    fn at(modes: &Modes, _point: usize) -> Modes {
        *modes
    }

    /// Resultants on the patterns of g₁, g₂ and h of resultants `p` and `r` along the tangents of a quadrature point.
    #[inline(always)]
    fn resultants(p: LaneVector, r: LaneVector, _point: usize) -> [LaneVector; 3] {
        [p, r, LaneVector::ZERO]
    }
}

/// The metric g_αβ = g_α·g_β and its determinant.
#[derive(Clone, Copy)]
pub struct Metric {
    /// g₁·g₁.
    pub a: ElementLanes,
    /// g₂·g₂.
    pub b: ElementLanes,
    /// g₁·g₂.
    pub c: ElementLanes,
    /// ab − c² = |g₁ × g₂|².
    pub det: ElementLanes,
}

impl Metric {
    /// The metric of two tangents.
    #[inline(always)]
    pub fn new(g1: LaneVector, g2: LaneVector) -> Self {
        let (a, b, c) = (g1.dot(g1), g2.dot(g2), g1.dot(g2));
        Self { a, b, c, det: a * b - c * c }
    }
}

/// Four nodes, one quadrature point.
pub struct Quadrilateral;

impl ElementShape<4> for Quadrilateral {
    const AREA: f64 = 0.25;
    const HOURGLASS: bool = true;

    #[inline(always)]
    fn modes([x1, x2, x3, x4]: [LaneVector; 4], _depth: f64) -> Modes {
        // Lian (32): r21 + r34 = r31 − r42; Lian (33).
        let (r31, r42) = (x3 - x1, x4 - x2);
        Modes { g1: r31 - r42, g2: r31 + r42, h: (x1 - x2) + (x3 - x4) }
    }

    #[inline(always)]
    fn spread(p: LaneVector, r: LaneVector, h: LaneVector) -> [LaneVector; 4] {
        let (sum, difference) = (p + r, p - r);
        [h - sum, difference - h, sum + h, -(difference + h)]
    }

    #[inline(always)]
    fn gram(m: &Metric) -> [ElementLanes; 2] {
        [(m.a + m.b) * 4.0 / m.det, ElementLanes::splat(16.0) / m.det]
    }
}

/// (ξ, η) of the 2 × 2 points of Gauss, ±1/√3.
pub const GAUSS: [[f64; 2]; 4] = [[-ROOT, -ROOT], [ROOT, -ROOT], [ROOT, ROOT], [-ROOT, ROOT]];

/// 1/√3.
const ROOT: f64 = 0.577_350_269_189_625_8;

/// Four nodes, 2 × 2 quadrature points, for sheets that wrinkle: every mode costs what its strains cost, nothing where
/// the sheet is slack. The tangents at (ξ, η) are g₁ + η h and g₂ + ξ h.
pub struct FullQuadrilateral;

impl ElementShape<4> for FullQuadrilateral {
    const AREA: f64 = Quadrilateral::AREA;
    const HOURGLASS: bool = true;
    const POINTS: usize = GAUSS.len();

    #[inline(always)]
    fn modes(x: [LaneVector; 4], depth: f64) -> Modes {
        Quadrilateral::modes(x, depth)
    }

    #[inline(always)]
    fn spread(p: LaneVector, r: LaneVector, h: LaneVector) -> [LaneVector; 4] {
        Quadrilateral::spread(p, r, h)
    }

    /// As if the element had the tangents of the point throughout. The greatest of the four bounds that follow bounds
    /// the element: exactly for a parallelogram, whose stiffest modes are those of uniform strain.
    #[inline(always)]
    fn gram(m: &Metric) -> [ElementLanes; 2] {
        Quadrilateral::gram(m)
    }

    #[inline(always)]
    fn at(modes: &Modes, point: usize) -> Modes {
        let [xi, eta] = GAUSS[point];
        Modes { g1: modes.g1 + modes.h * eta, g2: modes.g2 + modes.h * xi, h: LaneVector::ZERO }
    }

    #[inline(always)]
    fn resultants(p: LaneVector, r: LaneVector, point: usize) -> [LaneVector; 3] {
        let [xi, eta] = GAUSS[point];
        [p, r, p * eta + r * xi]
    }
}

/// Three nodes, constant strain.
pub struct Triangle;

impl ElementShape<3> for Triangle {
    const AREA: f64 = 0.5;
    const HOURGLASS: bool = false;

    #[inline(always)]
    fn modes([x1, x2, x3]: [LaneVector; 3], _depth: f64) -> Modes {
        Modes { g1: x2 - x1, g2: x3 - x1, h: LaneVector::ZERO }
    }

    #[inline(always)]
    fn spread(p: LaneVector, r: LaneVector, _h: LaneVector) -> [LaneVector; 3] {
        [-(p + r), p, r]
    }

    #[inline(always)]
    fn gram(m: &Metric) -> [ElementLanes; 2] {
        [(m.a + m.b - m.c) * 2.0 / m.det, ElementLanes::splat(3.0) / m.det]
    }
}

/// Two nodes, unit width along z: the membrane of a plane-strain problem.
/// Its normal is the tangent × z: outward for a loop that runs counter-clockwise.
pub struct Segment;

impl ElementShape<2> for Segment {
    const AREA: f64 = 1.0;
    const HOURGLASS: bool = false;

    #[inline(always)]
    fn modes([x1, x2]: [LaneVector; 2], depth: f64) -> Modes {
        let zero = ElementLanes::splat(0.0);
        Modes { g1: x2 - x1, g2: LaneVector([zero, zero, ElementLanes::splat(depth)]), h: LaneVector::ZERO }
    }

    #[inline(always)]
    fn spread(p: LaneVector, _r: LaneVector, _h: LaneVector) -> [LaneVector; 2] {
        [-p, p]
    }

    #[inline(always)]
    fn gram(m: &Metric) -> [ElementLanes; 2] {
        [m.b * 2.0 / m.det, ElementLanes::splat(0.0)]
    }
}
