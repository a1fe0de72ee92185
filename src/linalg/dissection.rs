//! Nested dissection of a mesh by its coordinates: an order of elimination with little fill (theory F.15).
//!
//! The nodes are cut into halves at the median along an axis; the nodes of one half that touch the other separate
//! the two and are eliminated last; each half is cut again (George 1973). Of all axes and both sides the smallest
//! separator is taken, which follows holes and grading.

use super::pattern::Pattern;

/// Sets of this many nodes are no longer cut.
const LEAF: usize = 40;

/// The order of elimination: `order[k]` is the k-th node.
pub(super) fn nested_dissection(pattern: &Pattern, places: &[[f64; 3]], axes: usize) -> Vec<u32> {
    let nodes = pattern.rows();
    let mut order: Vec<u32> = (0..nodes as u32).collect();
    let mut cutter = Cutter { pattern, places, axes, side: vec![0; nodes], stamp: 0 };
    let mut open = Vec::from([(0, nodes)]);
    while let Some((start, end)) = open.pop() {
        if end - start > LEAF {
            let [low, high] = cutter.cut(&mut order[start..end]);
            open.push((start, start + low));
            open.push((start + low, start + low + high));
        }
    }
    order
}

struct Cutter<'a> {
    pattern: &'a Pattern,
    places: &'a [[f64; 3]],
    axes: usize,
    /// The mark of each node's present side; marks are never used twice.
    side: Vec<u32>,
    stamp: u32,
}

impl Cutter<'_> {
    /// Reorders `nodes` to [low half, high half, separator]; gives the sizes of the halves.
    fn cut(&mut self, nodes: &mut [u32]) -> [usize; 2] {
        let best = (0..self.axes)
            .map(|axis| {
                self.halve(nodes, axis);
                let [low, high] = self.touching(nodes);
                (low.min(high), axis)
            })
            .min();
        self.halve(nodes, best.map_or(0, |(_, axis)| axis));
        let [low, high] = self.touching(nodes);
        let half = nodes.len() / 2;
        let (separator_side, other_side) =
            if low < high { (self.stamp - 1, self.stamp) } else { (self.stamp, self.stamp - 1) };
        let separates: Vec<bool> =
            nodes.iter().map(|&n| self.side[n as usize] == separator_side && self.touches(n, other_side)).collect();
        let pick = |range: std::ops::Range<usize>, wanted: bool| -> Vec<u32> {
            range.filter(|&k| separates[k] == wanted).map(|k| nodes[k]).collect()
        };
        let parts = [pick(0..half, false), pick(half..nodes.len(), false), pick(0..nodes.len(), true)];
        nodes.copy_from_slice(&parts.concat());
        [parts[0].len(), parts[1].len()]
    }

    /// Puts the lower half along an axis first and marks the halves with two fresh stamps.
    fn halve(&mut self, nodes: &mut [u32], axis: usize) {
        let half = nodes.len() / 2;
        let at = |n: u32| self.places[n as usize][axis];
        // Ties are broken by number: the order never depends on how the nodes came.
        nodes.select_nth_unstable_by(half, |&a, &b| at(a).total_cmp(&at(b)).then(a.cmp(&b)));
        self.stamp += 2;
        nodes[..half].sort_unstable();
        nodes[half..].sort_unstable();
        nodes[..half].iter().for_each(|&n| self.side[n as usize] = self.stamp - 1);
        nodes[half..].iter().for_each(|&n| self.side[n as usize] = self.stamp);
    }

    /// Number of nodes of each half with a neighbour in the other.
    fn touching(&self, nodes: &[u32]) -> [usize; 2] {
        let (low, high) = nodes.split_at(nodes.len() / 2);
        let count = |half: &[u32], other: u32| half.iter().filter(|&&n| self.touches(n, other)).count();
        [count(low, self.stamp), count(high, self.stamp - 1)]
    }

    fn touches(&self, node: u32, side: u32) -> bool {
        self.pattern.columns()[self.pattern.row(node as usize)].iter().any(|&n| self.side[n as usize] == side)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vector;
    use crate::mesh::Mesh;

    #[test]
    fn a_permutation_whose_first_separator_is_a_line() {
        let mesh = Mesh::<2, 3>::block(Vector::from([0.0, 0.0]), Vector::from([4.0, 1.0]), [64, 16]).unwrap();
        let pattern = Pattern::new(mesh.nodes().len(), mesh.elements());
        let places: Vec<[f64; 3]> = mesh.nodes().iter().map(|x| x.to3()).collect();
        let order = nested_dissection(&pattern, &places, 2);
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert!(sorted.iter().enumerate().all(|(i, &n)| i as u32 == n));
        // The last 17 nodes form the cut across the shorter side.
        let last: Vec<f64> = order[order.len() - 17..].iter().map(|&n| places[n as usize][0]).collect();
        assert!(last.iter().all(|&x| (x - last[0]).abs() < 0.1), "{last:?}");
    }
}
