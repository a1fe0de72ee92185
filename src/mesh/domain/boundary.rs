//! The boundary of a plane domain as a closed chain of nodes: corners are kept, curves are followed.

use super::size::Size;
use crate::geometry::{Edge, Region};
use crate::math::Vector;

/// Nodes on the boundary and the segments between them.
pub struct Boundary {
    pub nodes: Vec<Vector<2>>,
    pub segments: Vec<[u32; 2]>,
}

impl Boundary {
    /// Follows the outline of a region with nodes spaced by `size`.
    pub fn of(region: &Region, size: &Size) -> Result<Self, String> {
        let mut boundary = Self { nodes: Vec::new(), segments: Vec::new() };
        let edges = region.outline()?;
        let reach = edges.iter().flat_map(|e| [e.at(0.0), e.at(1.0)]).map(|x| x.norm()).fold(0.0, f64::max);
        for edge in &edges {
            boundary.follow(edge, size, 1e-9 * reach.max(size.finest()));
        }
        boundary.check()?;
        Ok(boundary)
    }

    fn follow(&mut self, edge: &Edge, size: &Size, near: f64) {
        let least = if edge.is_closed() { 8 } else { 1 };
        let chain = size.spread(|s| edge.at(s).to3(), least);
        let ends = [self.end(edge.at(0.0), near), self.end(edge.at(1.0), near)];
        let mut last = ends[0];
        for &s in &chain[1..chain.len() - 1] {
            let next = self.nodes.len() as u32;
            self.nodes.push(edge.at(s));
            self.segments.push([last, next]);
            last = next;
        }
        self.segments.push([last, ends[1]]);
    }

    /// The node at `x`, a new one if none is there.
    fn end(&mut self, x: Vector<2>, near: f64) -> u32 {
        match self.nodes.iter().position(|y| (x - *y).norm() <= near) {
            Some(known) => known as u32,
            None => {
                self.nodes.push(x);
                self.nodes.len() as u32 - 1
            }
        }
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
