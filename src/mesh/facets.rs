//! The mesh of a membrane.

use crate::geometry::Region;
use crate::math::Vector;
use std::collections::BTreeMap;

/// Quadrilaterals and triangles in 3D, segments in 2D.
///
/// Elements list their nodes counter-clockwise seen against their normal; a segment from a to b has the
/// normal (b − a) × z, out of a loop that runs counter-clockwise.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Facets {
    /// Node positions [m]; in 2D the third component is zero.
    pub nodes: Vec<[f64; 3]>,
    /// Nodes of each element: 4, 3 or 2.
    pub elements: Vec<Vec<u32>>,
    /// Named sets of nodes, in ascending order.
    pub sets: BTreeMap<String, Vec<u32>>,
    /// Numbers that nodes and elements have in the file.
    pub numbers: FileNumbers,
}

/// The numbers that a file has for its nodes and elements, for messages; both empty where there is no file: then nodes
/// and elements count from 0.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct FileNumbers {
    /// Numbers of nodes.
    pub nodes: Vec<i64>,
    /// Numbers of elements.
    pub elements: Vec<i64>,
}

impl FileNumbers {
    /// The name of a node in messages.
    pub fn node(&self, node: u32) -> i64 {
        self.nodes.get(node as usize).copied().unwrap_or(i64::from(node))
    }

    /// The name of an element in messages.
    pub fn element(&self, element: usize) -> i64 {
        self.elements.get(element).copied().unwrap_or(element as i64)
    }
}

impl Facets {
    /// The nodes of a named set: `all`, `edges` (nodes on free edges; ends in 2D) or one of `sets`.
    pub fn set(&self, name: &str) -> Option<Vec<u32>> {
        match (self.sets.get(name), name) {
            (Some(nodes), _) => Some(nodes.clone()),
            (None, "all") => Some((0..self.nodes.len() as u32).collect()),
            (None, "edges") => Some(self.boundary_nodes()),
            (None, _) => None,
        }
    }

    /// The names that [`Facets::set`] knows.
    pub fn set_names(&self) -> Vec<&str> {
        let own = self.sets.keys().map(String::as_str).filter(|name| !["all", "edges"].contains(name));
        ["all", "edges"].into_iter().chain(own).collect()
    }

    /// Nodes on edges (in 2D: at ends) that belong to one element only, ascending.
    pub fn boundary_nodes(&self) -> Vec<u32> {
        let ascending = |[a, b]: [u32; 2]| [a.min(b), a.max(b)];
        let mut uses: Vec<[u32; 2]> = self.elements.iter().flat_map(|e| edges(e)).map(ascending).collect();
        uses.sort_unstable();
        let free = uses.chunk_by(|a, b| a == b).filter(|same| same.len() == 1);
        let mut nodes: Vec<u32> = free.flat_map(|same| same[0]).collect();
        nodes.sort_unstable();
        nodes.dedup();
        nodes
    }

    /// The node nearest to `x` [m]; the first of several. `None` without nodes.
    pub fn nearest_node(&self, x: [f64; 3]) -> Option<u32> {
        let away = |node: &[f64; 3]| (Vector(*node) - Vector(x)).norm_squared();
        let nearest = self.nodes.iter().enumerate().min_by(|a, b| away(a.1).total_cmp(&away(b.1)));
        nearest.map(|(index, _)| index as u32)
    }

    /// Nodes inside or on the boundary of a region, ascending.
    pub fn nodes_in(&self, region: &Region) -> Vec<u32> {
        (0u32..).zip(&self.nodes).filter(|(_, x)| region.contains(**x)).map(|(index, _)| index).collect()
    }

    /// Area vector of an element [m²]: its area times its normal. In 2D: length times normal [m].
    ///
    /// For a quadrilateral half the cross product of its diagonals, which is exact for plane ones.
    pub fn area_vector(&self, element: usize) -> Vector<3> {
        let x = |i: usize| Vector(self.nodes[self.elements[element][i] as usize]);
        match self.elements[element].len() {
            4 => 0.5 * (x(2) - x(0)).cross(x(3) - x(1)),
            3 => 0.5 * (x(1) - x(0)).cross(x(2) - x(0)),
            _ => (x(1) - x(0)).cross(Vector::unit(2)),
        }
    }

    /// Area of all elements [m²]; in 2D their length [m].
    pub fn area(&self) -> f64 {
        (0..self.elements.len()).map(|e| self.area_vector(e).norm()).sum()
    }

    /// Volume that a closed mesh encloses [m³], or area [m²] in 2D; positive for outward normals.
    ///
    /// Divergence theorem: ∫ x·n dA / D with x at the centre of each element.
    pub fn enclosed(&self, dimension: usize) -> f64 {
        let flux = |e: usize| self.center(e).dot(self.area_vector(e)) / dimension as f64;
        (0..self.elements.len()).map(flux).sum()
    }

    /// Mean of an element's nodes [m].
    pub fn center(&self, element: usize) -> Vector<3> {
        let nodes = &self.elements[element];
        nodes.iter().map(|&n| Vector(self.nodes[n as usize])).sum::<Vector<3>>() / nodes.len() as f64
    }
}

/// The directed edges of a facet; for a segment its two ends, each as a pair with itself.
pub(super) fn edges(element: &[u32]) -> impl Iterator<Item = [u32; 2]> + '_ {
    let n = element.len();
    (0..n).map(move |i| if n == 2 { [element[i]; 2] } else { [element[i], element[(i + 1) % n]] })
}
