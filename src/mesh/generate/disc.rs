//! Discs of quadrilaterals that are all well shaped: a square in the middle that bulges towards a circle,
//! and rings around it.

use super::{BuildFacets, ElementKind, Facets, Quad, divisions, finite, frame, only, positive};
use crate::error::Diagnostic;
use crate::geometry::Direction;
use crate::math::Vector;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};
use std::path::Path;

/// Bulge of the middle square: 0 leaves a square, 1 makes a circle with flat corners.
const BULGE: f64 = 0.5;

/// A flat disc. Its rim is `edges`, its middle node `center`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DiscShape {
    /// Centre [m].
    #[schemars(extend("unit" = "m"))]
    pub center: [f64; 3],
    /// Radius of the rim's nodes [m].
    #[schemars(extend("unit" = "m", "exclusiveMinimum" = 0.0))]
    pub radius: f64,
    /// Elements between the centre and the rim.
    pub divisions: usize,
    /// Normal: `"z"`, `"-x"` or a vector of any length.
    #[serde(default = "Direction::z")]
    pub normal: Direction,
    /// Elements.
    #[serde(default)]
    pub elements: ElementKind,
}

impl BuildFacets for DiscShape {
    fn build(&self, _: &Path, dimension: usize) -> Result<Facets, Diagnostic> {
        only(dimension, 3, "in 2D use `shape = \"chain\"`")?;
        let [count] = divisions("divisions", [self.divisions], 2)?;
        divisions("divisions", [8 * count, count], 2)?;
        let radius = positive("radius", self.radius)?;
        let center = Vector(finite("center", self.center)?);
        let [e_1, e_2] = frame(self.normal.unit("normal", 3)?);
        let plan = DiscLayout { half: count.div_ceil(2), rings: count - count.div_ceil(2) };
        let nodes = plan.nodes().into_iter().map(|x| (center + (e_1 * x[0] + e_2 * x[1]) * radius).0).collect();
        let middle = plan.square(plan.half, plan.half);
        let rim = (0..plan.around()).map(|i| plan.ring(i, plan.rings)).collect();
        let sets = BTreeMap::from([("center".to_owned(), vec![middle]), ("edges".to_owned(), rim)]);
        Ok(Facets { nodes, elements: self.elements.cut(plan.quads()), sets, ..Facets::default() })
    }
}

/// The unit disc: a square of 2·`half` cells along each side within `rings` rings.
struct DiscLayout {
    half: usize,
    rings: usize,
}

impl DiscLayout {
    fn side(&self) -> usize {
        2 * self.half
    }

    fn around(&self) -> usize {
        4 * self.side()
    }

    fn square(&self, i: usize, j: usize) -> u32 {
        (j * (self.side() + 1) + i) as u32
    }

    /// Place (i, j) on the rim of the square, counter-clockwise from its lower left corner.
    fn square_rim(&self, place: usize) -> (usize, usize) {
        let n = self.side();
        let along = place % n;
        match place / n % 4 {
            0 => (along, 0),
            1 => (n, along),
            2 => (n - along, n),
            _ => (0, n - along),
        }
    }

    /// Node `place` of a ring; ring 0 is the rim of the square.
    fn ring(&self, place: usize, ring: usize) -> u32 {
        if ring == 0 {
            let (i, j) = self.square_rim(place);
            return self.square(i, j);
        }
        let square = (self.side() + 1).pow(2);
        (square + (ring - 1) * self.around() + place % self.around()) as u32
    }

    fn nodes(&self) -> Vec<Vector<2>> {
        let n = self.side();
        let mut nodes: Vec<_> =
            (0..=n).flat_map(|j| (0..=n).map(move |i| (i, j))).map(|(i, j)| self.square_node(i, j)).collect();
        for ring in 1..=self.rings {
            let fraction = ring as f64 / self.rings as f64;
            nodes.extend((0..self.around()).map(|place| {
                let (i, j) = self.square_rim(place);
                let angle = (place as f64 / n as f64 - 1.5) * FRAC_PI_2;
                let rim = Vector([angle.cos(), angle.sin()]);
                self.square_node(i, j) * (1.0 - fraction) + rim * fraction
            }));
        }
        nodes
    }

    /// Equal angles along the sides of the square; its corners are drawn in towards the circle.
    fn square_node(&self, i: usize, j: usize) -> Vector<2> {
        let coordinate = |i: usize| ((i as f64 / self.half as f64 - 1.0) * FRAC_PI_4).tan();
        let x = Vector([coordinate(i), coordinate(j)]);
        let radius = x[0].abs().max(x[1].abs());
        let round = if radius > 0.0 { x * (radius / x.norm()) } else { x };
        let size = self.half as f64 / (self.half + self.rings) as f64;
        (x * (1.0 - BULGE) + round * BULGE) * size
    }

    fn quads(&self) -> impl Iterator<Item = Quad> + '_ {
        let n = self.side();
        let middle = (0..n).flat_map(move |j| (0..n).map(move |i| (i, j))).map(|(i, j)| Quad {
            nodes: [self.square(i, j), self.square(i + 1, j), self.square(i + 1, j + 1), self.square(i, j + 1)],
            even: (i + j) % 2 == 0,
        });
        let around = self.around();
        let rings = (0..self.rings).flat_map(move |r| (0..around).map(move |p| (r, p))).map(|(r, p)| Quad {
            nodes: [self.ring(p, r), self.ring(p, r + 1), self.ring(p + 1, r + 1), self.ring(p + 1, r)],
            even: (r + p) % 2 == 0,
        });
        middle.chain(rings)
    }
}
