//! Parts of a mesh that have no free edges, and to which side their elements look.

use super::Facets;
use super::facets::edges;
use crate::math::Vector;
use hashbrown::HashMap;

/// A part that encloses less than this, over its area to the power 3/2 (2D: squared), is flat, and has no inside.
const FLAT: f64 = 1e-9;

/// A connected part of a mesh without free edges.
#[derive(Debug, Clone, PartialEq)]
pub struct ClosedPart {
    /// The volume that it encloses [m³] (2D: area [m²]), negative if the normals point into it.
    pub volume: f64,
    /// Corners of the box around it [m].
    pub bounds: [[f64; 3]; 2],
    /// True if it is too flat to have an inside.
    flat: bool,
}

impl ClosedPart {
    /// True if the box around `other` lies in the box around this part.
    fn may_hold(&self, other: &Self) -> bool {
        (0..3).all(|a| self.bounds[0][a] < other.bounds[0][a] || self.bounds[0][a] == self.bounds[1][a])
            && (0..3).all(|a| self.bounds[1][a] > other.bounds[1][a] || self.bounds[0][a] == self.bounds[1][a])
    }
}

impl Facets {
    /// The closed parts, in the order of their first nodes.
    pub fn closed_parts(&self, dimension: usize) -> Vec<ClosedPart> {
        let mut parts: Vec<(u32, Vec<usize>)> = self.parts().into_iter().collect();
        parts.sort_unstable();
        parts
            .iter()
            .filter(|(_, part)| self.has_no_free_edge(part))
            .map(|(_, part)| self.closed(part, dimension))
            .collect()
    }

    /// The closed parts whose normals point into them, but for those that bound a hole in another part.
    pub fn turned_parts(&self, dimension: usize) -> Vec<ClosedPart> {
        let parts = self.closed_parts(dimension);
        let turned = |part: &&ClosedPart| {
            let hole = parts.iter().any(|other| other.volume > 0.0 && other.may_hold(part));
            part.volume < 0.0 && !part.flat && !hole
        };
        parts.iter().filter(turned).cloned().collect()
    }

    /// The elements of each connected part, by its first node.
    fn parts(&self) -> HashMap<u32, Vec<usize>> {
        let mut first: Vec<u32> = (0..self.nodes.len() as u32).collect();
        for nodes in &self.elements {
            for pair in nodes.windows(2) {
                let [a, b] = [pair[0], pair[1]].map(|node| root(&mut first, node));
                first[a.max(b) as usize] = a.min(b);
            }
        }
        let mut parts: HashMap<u32, Vec<usize>> = HashMap::new();
        for (element, nodes) in self.elements.iter().enumerate() {
            parts.entry(root(&mut first, nodes[0])).or_default().push(element);
        }
        parts
    }

    fn has_no_free_edge(&self, part: &[usize]) -> bool {
        let ascending = |[a, b]: [u32; 2]| [a.min(b), a.max(b)];
        let mut uses: Vec<_> = part.iter().flat_map(|&e| edges(&self.elements[e])).map(ascending).collect();
        uses.sort_unstable();
        uses.chunk_by(|a, b| a == b).all(|same| same.len() > 1)
    }

    fn closed(&self, part: &[usize], dimension: usize) -> ClosedPart {
        let places = || part.iter().flat_map(|&e| &self.elements[e]).map(|&node| self.nodes[node as usize]);
        let bound = |pick: fn(f64, f64) -> f64, start: f64| {
            places().fold([start; 3], |bound, x| std::array::from_fn(|a| pick(bound[a], x[a])))
        };
        let bounds = [bound(f64::min, f64::INFINITY), bound(f64::max, f64::NEG_INFINITY)];
        let middle = (Vector(bounds[0]) + Vector(bounds[1])) * 0.5;
        let cone = |&e: &usize| (self.center(e) - middle).dot(self.area_vector(e)) / dimension as f64;
        let volume: f64 = part.iter().map(cone).sum();
        let area: f64 = part.iter().map(|&e| self.area_vector(e).norm()).sum();
        let power = dimension as f64 / (dimension - 1) as f64;
        ClosedPart { volume, bounds, flat: volume.abs() < FLAT * area.powf(power) }
    }
}

/// The first node of the part of `node`, as far as it is known; ways to it are shortened.
fn root(first: &mut [u32], mut node: u32) -> u32 {
    while first[node as usize] != node {
        let next = first[node as usize];
        first[node as usize] = first[next as usize];
        node = next;
    }
    node
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Squares of sides 2r around these centres, which run clockwise where r is negative.
    fn squares(all: &[([f64; 2], f64)]) -> Facets {
        let mut facets = Facets::default();
        for &([x, y], r) in all {
            let start = facets.nodes.len() as u32;
            let corners = [[-r.abs(), -r], [r.abs(), -r], [r.abs(), r], [-r.abs(), r]];
            facets.nodes.extend(corners.map(|[a, b]| [x + a, y + b, 0.0]));
            facets.elements.extend((0..4).map(|k| vec![start + k, start + (k + 1) % 4]));
        }
        facets
    }

    /// The area of a square is that of one, and the sense tells its sign.
    #[test]
    fn parts_that_run_clockwise_are_turned() {
        let two = squares(&[([0.0, 0.0], 0.5), ([3.0, 0.0], -1.0)]);
        let volumes: Vec<f64> = two.closed_parts(2).iter().map(|part| part.volume).collect();
        assert!((volumes[0] - 1.0).abs() < 1e-12 && (volumes[1] + 4.0).abs() < 1e-12, "{volumes:?}");
        let [turned] = &two.turned_parts(2)[..] else { panic!("one of them") };
        assert_eq!(turned.bounds, [[2.0, -1.0, 0.0], [4.0, 1.0, 0.0]]);
        let mut open = two;
        open.elements.pop();
        assert_eq!(open.closed_parts(2).len(), 1);
        assert!(open.turned_parts(2).is_empty());
    }

    /// Facets around a hole have normals into the hole, out of the material: nothing of a ring is turned, but the
    /// outside of one that runs the other way is.
    #[test]
    fn facets_around_a_hole_point_into_it() {
        assert!(squares(&[([0.0, 0.0], 1.0), ([0.0, 0.0], -0.5)]).turned_parts(2).is_empty());
        let turned = squares(&[([0.0, 0.0], -1.0), ([0.0, 0.0], 0.5)]).turned_parts(2);
        assert!(turned.len() == 1 && turned[0].volume < -3.9, "{turned:?}");
    }

    /// A square that is folded to a line encloses nothing.
    #[test]
    fn a_flat_part_has_no_inside() {
        let mut flat = squares(&[([0.0, 0.0], -1.0)]);
        flat.nodes.iter_mut().for_each(|x| x[1] *= 1e-12);
        assert!(flat.closed_parts(2).len() == 1 && flat.turned_parts(2).is_empty());
    }
}
