//! Mapped rectangles, and the flat one.

use super::{BuildFacets, ElementKind, Facets, Quad, divisions, finite, frame, only, positive};
use crate::error::Diagnostic;
use crate::geometry::Direction;
use crate::math::Vector;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;

/// A rectangle of `cells` quadrilaterals; nodes are numbered along u first.
pub(super) struct RectanglePatch {
    /// Cells along u and v.
    pub cells: [usize; 2],
    /// True if the last column of cells ends at the first column of nodes.
    pub closed: bool,
}

impl RectanglePatch {
    fn columns(&self) -> usize {
        if self.closed { self.cells[0] } else { self.cells[0] + 1 }
    }

    fn node(&self, i: usize, j: usize) -> u32 {
        (j * self.columns() + i % self.columns()) as u32
    }

    /// The mesh whose node (i, j) lies at `position(i, j)`.
    pub fn facets(&self, kind: ElementKind, position: impl Fn(usize, usize) -> Vector<3>) -> Facets {
        let [m, n] = self.cells;
        let columns = self.columns();
        let nodes = (0..=n).flat_map(|j| (0..columns).map(move |i| (i, j))).map(|(i, j)| position(i, j).0).collect();
        let quads = (0..n).flat_map(|j| (0..m).map(move |i| (i, j))).map(|(i, j)| Quad {
            nodes: [self.node(i, j), self.node(i + 1, j), self.node(i + 1, j + 1), self.node(i, j + 1)],
            even: (i + j) % 2 == 0,
        });
        Facets { nodes, elements: kind.cut(quads), sets: self.sets(), ..Facets::default() }
    }

    fn sets(&self) -> BTreeMap<String, Vec<u32>> {
        let [m, n] = self.cells;
        let row = |j: usize| (0..self.columns()).map(|i| self.node(i, j)).collect();
        let column = |i: usize| (0..=n).map(|j| self.node(i, j)).collect();
        let mut sets = BTreeMap::from([("front".to_owned(), row(0)), ("back".to_owned(), row(n))]);
        if !self.closed {
            sets.extend([("left".to_owned(), column(0)), ("right".to_owned(), column(m))]);
        }
        sets
    }
}

/// A flat rectangle. Its sides are `left` and `right` along the first, `front` and `back` along the second
/// direction; those are x and y for the normal z, y and z for x, z and x for y.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SheetShape {
    /// Centre [m].
    #[schemars(extend("unit" = "m"))]
    pub center: [f64; 3],
    /// Length along the first and second direction [m].
    #[schemars(extend("unit" = "m", "exclusiveMinimum" = 0.0))]
    pub size: [f64; 2],
    /// Elements along the first and second direction.
    pub divisions: [usize; 2],
    /// Normal: `"z"`, `"-x"` or a vector of any length.
    #[serde(default = "Direction::z")]
    pub normal: Direction,
    /// First direction, made perpendicular to the normal; by default the axis after the normal's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub along: Option<Direction>,
    /// Elements.
    #[serde(default)]
    pub elements: ElementKind,
}

impl BuildFacets for SheetShape {
    fn build(&self, _: &Path, dimension: usize) -> Result<Facets, Diagnostic> {
        only(dimension, 3, "in 2D use `shape = \"chain\"`")?;
        let cells = divisions("divisions", self.divisions, 1)?;
        let size = [positive("size", self.size[0])?, positive("size", self.size[1])?];
        let center = Vector(finite("center", self.center)?);
        let [e_u, e_v] = self.directions()?;
        let at = |i: usize, axis: usize| (i as f64 / cells[axis] as f64 - 0.5) * size[axis];
        Ok(RectanglePatch { cells, closed: false }
            .facets(self.elements, |i, j| center + e_u * at(i, 0) + e_v * at(j, 1)))
    }
}

impl SheetShape {
    fn directions(&self) -> Result<[Vector<3>; 2], Diagnostic> {
        let normal = self.normal.unit("normal", 3)?;
        let Some(along) = &self.along else { return Ok(frame(normal)) };
        let along = along.unit("along", 3)?;
        let first = along - normal * along.dot(normal);
        match first.normalized().filter(|_| first.norm() > 1e-6) {
            Some(first) => Ok([first, normal.cross(first)]),
            None => Err(Diagnostic::error("along", "`along` has the direction of the normal")),
        }
    }
}
