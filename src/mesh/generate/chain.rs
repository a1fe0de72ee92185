//! Membranes in 2D: chains of segments and circles.

use super::{BuildFacets, Facets, MOST_ELEMENTS, divisions, finite, only, positive};
use crate::error::Diagnostic;
use crate::math::Vector;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;

/// A line through points, in 2D. The normal of a segment lies to the right of its direction: out of a loop
/// that runs counter-clockwise. An open chain begins at `left` and ends at `right`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ChainShape {
    /// Points [m], `[[x, y], ...]`.
    #[schemars(extend("unit" = "m"), length(min = 2))]
    pub points: Vec<[f64; 2]>,
    /// Elements between two points; a single number holds for all.
    #[schemars(length(min = 1))]
    pub divisions: Vec<usize>,
    /// True: the last point is joined to the first.
    #[serde(default)]
    pub closed: bool,
}

impl BuildFacets for ChainShape {
    fn build(&self, _: &Path, dimension: usize) -> Result<Facets, Diagnostic> {
        only(dimension, 2, "in 3D use `shape = \"tube\"` or `shape = \"sheet\"`")?;
        let line = polyline(&self.points, &self.divisions, self.closed)?;
        let mut facets = segments(&line, self.closed);
        if !self.closed {
            let last = line.len() as u32 - 1;
            facets.sets = BTreeMap::from([("left".to_owned(), vec![0]), ("right".to_owned(), vec![last])]);
        }
        Ok(facets)
    }
}

/// A circle, in 2D, with outward normals. The first node lies at the angle zero.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CircleShape {
    /// Centre [m].
    #[schemars(extend("unit" = "m"))]
    pub center: [f64; 2],
    /// Radius of the nodes [m].
    #[schemars(extend("unit" = "m", "exclusiveMinimum" = 0.0))]
    pub radius: f64,
    /// Elements around.
    pub divisions: usize,
}

impl BuildFacets for CircleShape {
    fn build(&self, _: &Path, dimension: usize) -> Result<Facets, Diagnostic> {
        only(dimension, 2, "in 3D use `shape = \"cylinder\"` or `shape = \"sphere\"`")?;
        let center = Vector(finite("center", self.center)?);
        let radius = positive("radius", self.radius)?;
        let [count] = divisions("divisions", [self.divisions], 3)?;
        let angle = |i: usize| std::f64::consts::TAU * i as f64 / count as f64;
        let line: Vec<_> = (0..count).map(|i| center + Vector([angle(i).cos(), angle(i).sin()]) * radius).collect();
        Ok(segments(&line, true))
    }
}

fn segments(line: &[Vector<2>], closed: bool) -> Facets {
    let count = line.len();
    let last = if closed { count } else { count - 1 };
    Facets {
        nodes: line.iter().map(|x| x.to3()).collect(),
        elements: (0..last).map(|i| vec![i as u32, ((i + 1) % count) as u32]).collect(),
        ..Facets::default()
    }
}

/// The nodes of a line through `points` with `counts` elements between them; without the repeated first
/// node if it is closed.
pub(super) fn polyline(points: &[[f64; 2]], counts: &[usize], closed: bool) -> Result<Vec<Vector<2>>, Diagnostic> {
    let least = if closed { 3 } else { 2 };
    if points.len() < least {
        return Err(Diagnostic::error("points", format!("at least {least} points are needed")));
    }
    let sides = if closed { points.len() } else { points.len() - 1 };
    if counts.len() != 1 && counts.len() != sides {
        let message = format!("{} numbers of divisions for {sides} sides", counts.len());
        return Err(Diagnostic::error("divisions", message).help("one number for all sides, or one for each"));
    }
    let mut line = Vec::new();
    for side in 0..sides {
        let [a, b] = [side, (side + 1) % points.len()].map(|i| Vector(points[i]));
        finite("points", a.0).and(finite("points", b.0))?;
        if a == b {
            return Err(Diagnostic::error(format!("points[{side}]"), "this point and the next coincide"));
        }
        let [count] = divisions("divisions", [counts[side.min(counts.len() - 1)]], 1)?;
        if line.len() + count > MOST_ELEMENTS {
            return Err(Diagnostic::error("divisions", format!("more than {MOST_ELEMENTS} elements")));
        }
        line.extend((0..count).map(|i| a + (b - a) * (i as f64 / count as f64)));
    }
    if !closed {
        line.push(Vector(points[sides]));
    }
    Ok(line)
}
