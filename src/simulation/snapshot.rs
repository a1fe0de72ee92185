//! The state of a solver as outputs see it: named point sets and surfaces with fields, an energy ledger,
//! forces. Positions are in metres, padded with zeros to three components in 2D.

use super::Ledger;
use crate::math::SymTensor;
use std::borrow::Cow;

/// The state at one time. Borrowed; fields that must be computed are computed when asked for.
///
/// ```
/// use lateen::simulation::{Field, PointSet, Snapshot};
///
/// let (mass, speed) = ([2.0, 3.0], [4.0, 5.0]);
/// let energy = || mass.iter().zip(speed).map(|(m, v)| 0.5 * m * v * v).collect();
/// let water = PointSet {
///     name: "water",
///     position: vec![[0.0; 3], [1.0, 0.0, 0.0]].into(),
///     id: vec![0, 1].into(),
///     fields: vec![Field::scalar("mass", "kg", &mass), Field::computed("kinetic energy", "J", 1, energy)],
///     filled: None,
/// };
/// let snapshot = Snapshot { time: 0.5, dimension: 2, points: vec![water], ..Snapshot::default() };
/// assert_eq!(*snapshot.points[0].fields[1].values(), [16.0, 37.5]);
/// ```
#[derive(Default)]
pub struct Snapshot<'a> {
    /// Time [s].
    pub time: f64,
    /// Steps taken.
    pub step: u64,
    /// The step that led here [s].
    pub dt: f64,
    /// 2 or 3.
    pub dimension: usize,
    /// Particles, one set per body.
    pub points: Vec<PointSet<'a>>,
    /// Membranes and meshes.
    pub surfaces: Vec<SurfaceSet<'a>>,
    /// Surfaces of bodies that `surfaces` holds whole, for fields alone.
    pub outlines: Vec<SurfaceSet<'a>>,
    /// Mass, momentum and every energy term.
    pub ledger: Ledger,
    /// Named force vectors [N], e.g. `contact:water-sheet`, `wall:floor`: means over the last step, and in the time
    /// loop over all steps since they were last recorded. A wall, an obstacle, a part of the boundary or a support has
    /// the force that the material exerts on it; a contact that on the first of the two.
    pub forces: Vec<(String, [f64; 3])>,
    /// Moments of some of these forces about points [N m], by the names of the forces: means as they are.
    pub moments: Vec<(String, [f64; 3])>,
    /// Named counts, e.g. `crossed:sheet` (particles found on the wrong side).
    pub counts: Vec<(String, u64)>,
    /// Named amounts that stand beside the counts, with their units.
    pub amounts: Vec<(String, &'static str, f64)>,
}

/// Particles of one body.
pub struct PointSet<'a> {
    /// The body's name.
    pub name: &'a str,
    /// Positions [m].
    pub position: Cow<'a, [[f64; 3]]>,
    /// Stable identities.
    pub id: Cow<'a, [u32]>,
    /// Per-particle fields.
    pub fields: Vec<Field<'a>>,
    /// The region that the body fills, where that isn't just where its particles are.
    pub filled: Option<Filled<'a>>,
}

/// The part of a body inside a box with these lower and upper corners [m], infinite where it has no side: points
/// without a name, with the fields `volume` and `mass`, such that sums over them are integrals.
pub type Filled<'a> = Box<dyn Fn(&[[f64; 3]; 2]) -> PointSet<'static> + 'a>;

/// Kind of the elements of a mesh: four nodes make a quadrilateral or a tetrahedron.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Elements {
    /// Segments, triangles, quadrilaterals: membranes, and meshes in 2D.
    #[default]
    Sheet,
    /// Tetrahedra, hexahedra.
    Volume,
}

/// Corners of the sides of a hexahedron, seen from outside; its first four nodes are those of its lower side.
pub const SIDES_OF_HEXAHEDRON: [[usize; 4]; 6] =
    [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];

/// A mesh with fields: a membrane or the mesh of a domain.
pub struct SurfaceSet<'a> {
    /// The membrane's or mesh's name.
    pub name: &'a str,
    /// Node positions [m].
    pub position: Cow<'a, [[f64; 3]]>,
    /// Node positions at the start [m] (probes name points of the undeformed sheet).
    pub reference: Cow<'a, [[f64; 3]]>,
    /// Nodes of each element: 2 of a segment, 3 of a triangle, 4 of a quadrilateral or tetrahedron, 8 of a hexahedron
    /// (its lower side, then its upper one).
    pub elements: Vec<&'a [u32]>,
    /// Kind of the elements.
    pub kind: Elements,
    /// Per-node fields.
    pub node_fields: Vec<Field<'a>>,
    /// Per-element fields.
    pub element_fields: Vec<Field<'a>>,
}

/// A named field with its unit and number of components (1, 3, or 6 for symmetric tensors
/// in the order xx yy zz xy yz zx).
pub struct Field<'a> {
    /// Name of the field, for example `velocity`.
    pub name: &'static str,
    /// Unit of the field, for example `m/s`; empty when dimensionless.
    pub unit: &'static str,
    /// Numbers per entry.
    pub components: usize,
    /// The numbers.
    pub values: FieldValues<'a>,
}

/// Numbers of a field: borrowed, or computed when asked for.
pub enum FieldValues<'a> {
    /// Numbers as they are stored.
    Stored(&'a [f64]),
    /// Computed on demand.
    Computed(Box<dyn Fn() -> Vec<f64> + 'a>),
}

impl<'a> Field<'a> {
    /// A stored scalar field.
    pub fn scalar(name: &'static str, unit: &'static str, values: &'a [f64]) -> Self {
        Self { name, unit, components: 1, values: FieldValues::Stored(values) }
    }

    /// A stored field of symmetric tensors.
    pub fn symmetric(name: &'static str, unit: &'static str, values: &'a [SymTensor]) -> Self {
        Self { name, unit, components: 6, values: FieldValues::Stored(bytemuck::cast_slice(values)) }
    }

    /// A field computed on demand.
    pub fn computed(
        name: &'static str,
        unit: &'static str,
        components: usize,
        values: impl Fn() -> Vec<f64> + 'a,
    ) -> Self {
        Self { name, unit, components, values: FieldValues::Computed(Box::new(values)) }
    }

    /// The numbers, `components` per entry.
    pub fn values(&self) -> Cow<'_, [f64]> {
        match &self.values {
            FieldValues::Stored(values) => Cow::Borrowed(values),
            FieldValues::Computed(compute) => Cow::Owned(compute()),
        }
    }
}
