//! The boundary of a plane domain as a closed chain of nodes: corners are kept, curves are followed.

use super::size::SizeField;
use crate::geometry::{Edge, Region};
use crate::math::Vector;
use std::collections::HashMap;

/// Nodes on the boundary and the segments between them.
pub struct BoundaryPoints {
    pub nodes: Vec<Vector<2>>,
    pub segments: Vec<[u32; 2]>,
    places: PointIndex,
}

/// Nodes by the square that they lie in, so that outlines of many corners close in linear time.
struct PointIndex {
    /// Within this distance places are one [m]; the edge of the squares.
    near: f64,
    squares: HashMap<[i64; 2], Vec<u32>>,
}

impl PointIndex {
    fn square(&self, x: Vector<2>) -> [i64; 2] {
        x.0.map(|x| (x / self.near).floor() as i64)
    }

    fn add(&mut self, x: Vector<2>, node: u32) {
        self.squares.entry(self.square(x)).or_default().push(node);
    }

    /// The first of the nodes near a place.
    fn find(&self, x: Vector<2>, nodes: &[Vector<2>]) -> Option<u32> {
        let [column, row] = self.square(x);
        let around = (-1..=1).flat_map(|i| (-1..=1).map(move |j| [column + i, row + j]));
        let known = around.filter_map(|square| self.squares.get(&square)).flatten().copied();
        known.filter(|&node| (x - nodes[node as usize]).norm() <= self.near).min()
    }
}

impl BoundaryPoints {
    /// Follows the outline of a region with nodes spaced by `size`.
    pub fn of(region: &Region, size: &SizeField) -> Result<Self, String> {
        let edges = region.outline()?;
        let reach = edges.iter().flat_map(|e| [e.at(0.0), e.at(1.0)]).map(|x| x.norm()).fold(0.0, f64::max);
        let places = PointIndex { near: 1e-9 * reach.max(size.finest()), squares: HashMap::new() };
        let mut boundary = Self { nodes: Vec::new(), segments: Vec::new(), places };
        edges.iter().for_each(|edge| boundary.follow(edge, size));
        boundary.check()?;
        Ok(boundary)
    }

    fn follow(&mut self, edge: &Edge, size: &SizeField) {
        let least = if edge.is_closed() { 8 } else { 1 };
        let chain = size.spread(|s| edge.at(s).to3(), least);
        let ends = [self.end(edge.at(0.0)), self.end(edge.at(1.0))];
        let mut last = ends[0];
        for &s in &chain[1..chain.len() - 1] {
            let next = self.add(edge.at(s));
            self.segments.push([last, next]);
            last = next;
        }
        self.segments.push([last, ends[1]]);
    }

    fn add(&mut self, x: Vector<2>) -> u32 {
        let node = self.nodes.len() as u32;
        self.nodes.push(x);
        self.places.add(x, node);
        node
    }

    /// The node at `x`, a new one if none is there.
    fn end(&mut self, x: Vector<2>) -> u32 {
        self.places.find(x, &self.nodes).unwrap_or_else(|| self.add(x))
    }

    fn check(&self) -> Result<(), String> {
        let mut ends = vec![0usize; self.nodes.len()];
        self.segments.iter().flatten().for_each(|&n| ends[n as usize] += 1);
        match ends.iter().position(|&count| count != 2) {
            Some(node) => Err(format!(
                "the outline of the domain is not closed, or touches itself, at {:?} m",
                self.nodes[node].0
            )),
            None if self.segments.len() < 3 => Err("the domain has no outline: do the holes cover all of it?".into()),
            None => Ok(()),
        }
    }
}
