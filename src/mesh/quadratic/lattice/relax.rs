//! Moves nodes so that hexahedra are as near to their wanted shape as they can be; nodes of the boundary slide on the
//! surface.
//!
//! ```text
//! at each corner of a hexahedron:   J = [e_1/l_1, e_2/l_2, e_3/l_3],   f = ‖J‖²/(3 χ^⅔),   f = 1 for the shape that is wanted
//! χ = ½ (det J + (det J² + ε²)^½) > 0 also where a corner is folded;   ε → 0 once none is
//! F = Σ f² over all corners → min,   one node at a time, by Newton's steps of half length until F falls
//! ```
//!
//! e_k: edges, l_k: lengths that they should have. (Escobar et al. 2003, DOI 10.1016/S0045-7825(03)00299-8.)

use super::features::Features;
use super::hexes::Hexes;
use super::holds::{Hold, Tangents};
use crate::math::Vector;
use std::collections::BTreeMap;

/// Sweeps over all nodes, at most.
const SWEEPS: usize = 50;

/// A node that moves by less, over the lengths of its edges, is at rest.
const AT_REST: f64 = 2e-3;

/// Step of the differences of the gradient, over the same.
const DIFFERENCE: f64 = 1e-5;

/// ε while corners are folded, less in each sweep by the factor.
const REGULAR: [f64; 3] = [0.4, 0.85, 1e-4];

/// Scaled determinant at all corners from which on nodes need not be spread first.
const GOOD: f64 = 0.1;

/// Rounds in which nodes are spread evenly along sharp edges, on patches, inside.
const SPREADING: [usize; 3] = [20, 15, 10];

/// A mesh, the constraints of its nodes, and the hexahedra around each of them.
pub struct Relaxation<'a> {
    mesh: &'a mut Hexes,
    holds: &'a [Hold],
    features: &'a Features,
    /// Hexahedra at each node, and the corner that it is there.
    around: Vec<Vec<(u32, u8)>>,
    epsilon: f64,
}

impl<'a> Relaxation<'a> {
    pub fn new(mesh: &'a mut Hexes, holds: &'a [Hold], features: &'a Features) -> Self {
        let mut around = vec![Vec::new(); mesh.nodes.len()];
        for (hex, own) in (0u32..).zip(&mesh.hexes) {
            (0u8..).zip(own).for_each(|(a, &node)| around[node as usize].push((hex, a)));
        }
        Self { mesh, holds, features, around, epsilon: 0.0 }
    }

    /// Puts nodes of the boundary on the surface, and moves all to better places.
    pub fn run(&mut self) {
        for node in 0..self.mesh.nodes.len() {
            self.mesh.nodes[node] = self.holds[node].place(self.features, self.mesh.nodes[node]).0;
        }
        if self.mesh.quality().0 < GOOD {
            self.spread();
        }
        let mut active = vec![true; self.mesh.nodes.len()];
        self.epsilon = REGULAR[0];
        for _ in 0..SWEEPS {
            let folded = self.mesh.quality().0 < 0.01;
            self.epsilon = if folded { (self.epsilon * REGULAR[1]).max(REGULAR[2]) } else { REGULAR[2] };
            let mut moved = vec![false; active.len()];
            for node in (0..active.len()).filter(|&node| active[node]) {
                moved[node] = self.improve(node);
            }
            if !moved.contains(&true) {
                break;
            }
            active = self.beside(&moved);
        }
    }

    /// Nodes with a marked one in one of their hexahedra.
    fn beside(&self, marked: &[bool]) -> Vec<bool> {
        let mut found = vec![false; marked.len()];
        for hex in self.mesh.hexes.iter().filter(|hex| hex.iter().any(|&node| marked[node as usize])) {
            hex.iter().for_each(|&node| found[node as usize] = true);
        }
        found
    }

    /// Moves nodes to the middle of their neighbours: along sharp edges first, on patches, inside at last.
    fn spread(&mut self) {
        let mut neighbours: [BTreeMap<u32, Vec<u32>>; 3] = Default::default();
        let mut add = |level: usize, [a, b]: [u32; 2]| {
            neighbours[level].entry(a).or_default().push(b);
            neighbours[level].entry(b).or_default().push(a);
        };
        for (ends, quads) in self.mesh.edges() {
            let [p, q] = quads.map(|q| self.mesh.quads[q].patch);
            add(1, ends);
            if p != q {
                add(0, ends);
            }
        }
        for hex in &self.mesh.hexes {
            let edges = (0..8).flat_map(|a| (0..3).map(move |k| [a, a | 1 << k])).filter(|[a, b]| a != b);
            edges.for_each(|[a, b]| add(2, [hex[a], hex[b]]));
        }
        for (level, all) in neighbours.iter().enumerate() {
            for _ in 0..SPREADING[level] {
                for (&node, others) in all {
                    let hold = &self.holds[node as usize];
                    if level
                        != match hold {
                            Hold::Edge(_) => 0,
                            Hold::Patch(_) => 1,
                            Hold::Free => 2,
                            Hold::Corner(_) => continue,
                        }
                    {
                        continue;
                    }
                    let sum = others.iter().map(|&other| self.mesh.nodes[other as usize]).sum::<Vector<3>>();
                    // Half of the way: the middle between opposite places of a round edge is at no place of it.
                    let x = (self.mesh.nodes[node as usize] + sum / others.len() as f64) * 0.5;
                    self.mesh.nodes[node as usize] = hold.place(self.features, x).0;
                }
            }
        }
    }

    /// One step of Newton for a node. True if it moved far enough to matter.
    fn improve(&mut self, node: usize) -> bool {
        let start = self.mesh.nodes[node];
        let (_, tangents) = self.holds[node].place(self.features, start);
        if tangents.count == 0 {
            return false;
        }
        let size = self.size(node);
        let (energy, gradient) = self.energy(node);
        let step = self.step(node, &tangents, gradient, DIFFERENCE * size);
        let longest = 0.5 * size;
        let mut step = step * (longest / step.norm().max(longest));
        for _ in 0..10 {
            if step.norm() < 0.1 * AT_REST * size {
                break;
            }
            self.mesh.nodes[node] = self.holds[node].place(self.features, start + step).0;
            if self.energy(node).0 < energy {
                return (self.mesh.nodes[node] - start).norm() > AT_REST * size;
            }
            step *= 0.5;
        }
        self.mesh.nodes[node] = start;
        false
    }

    /// The step along the tangents: Newton's, or down the gradient where F is not convex.
    fn step(&mut self, node: usize, tangents: &Tangents, gradient: Vector<3>, width: f64) -> Vector<3> {
        let along = &tangents.directions[..tangents.count];
        let start = self.mesh.nodes[node];
        let slope: Vec<f64> = along.iter().map(|t| t.dot(gradient)).collect();
        let mut matrix = [[0.0; 3]; 3];
        for (j, &t) in along.iter().enumerate() {
            self.mesh.nodes[node] = start + t * width;
            let changed = (self.energy(node).1 - gradient) / width;
            along.iter().enumerate().for_each(|(i, t)| matrix[i][j] = t.dot(changed));
        }
        self.mesh.nodes[node] = start;
        let most = (0..along.len()).map(|i| matrix[i][i].abs()).fold(f64::MIN_POSITIVE, f64::max);
        let down = || slope.iter().zip(along).map(|(s, t)| *t * (-s / most)).sum::<Vector<3>>();
        let Some(found) = solved(matrix, &slope) else { return down() };
        let newton = found.iter().zip(along).map(|(s, t)| *t * -*s).sum::<Vector<3>>();
        if newton.is_finite() && newton.dot(gradient) < 0.0 { newton } else { down() }
    }

    /// The least length that an edge at a node should have [m].
    fn size(&self, node: usize) -> f64 {
        let sizes = self.around[node].iter().flat_map(|&(hex, _)| self.mesh.sizes[hex as usize]);
        sizes.fold(f64::INFINITY, f64::min)
    }

    /// The part of F that depends on a node, and its gradient.
    fn energy(&self, node: usize) -> (f64, Vector<3>) {
        let (mut energy, mut gradient) = (0.0, Vector::ZERO);
        for &(hex, a) in &self.around[node] {
            let a = a as usize;
            for c in [a, a ^ 1, a ^ 2, a ^ 4] {
                let edges = self.mesh.corner(hex as usize, c);
                let (f, slopes) = shape(edges, self.epsilon);
                energy += f * f;
                for k in 0..3 {
                    let sign = if c >> k & 1 == 0 { 1.0 } else { -1.0 };
                    let own = if c == a {
                        -sign
                    } else if c ^ a == 1 << k {
                        sign
                    } else {
                        continue;
                    };
                    gradient += slopes[k] * (2.0 * f * own / self.mesh.sizes[hex as usize][k]);
                }
            }
        }
        (energy, gradient)
    }
}

impl Hexes {
    /// Edges at a corner of a hexahedron over the lengths that they should have, along its directions.
    fn corner(&self, hex: usize, c: usize) -> [Vector<3>; 3] {
        let own = &self.hexes[hex];
        let x = |a: usize| self.nodes[own[a] as usize];
        [0, 1, 2].map(|k| (x(c | 1 << k) - x(c & !(1 << k))) / self.sizes[hex][k])
    }

    /// The least determinant of the unit vectors along the edges at a corner, and its hexahedron.
    pub fn quality(&self) -> (f64, usize) {
        let at = |hex: usize, c: usize| {
            let [a, b, c] = self.corner(hex, c).map(|edge| edge.normalized().unwrap_or(Vector::ZERO));
            a.cross(b).dot(c)
        };
        let all = (0..self.hexes.len()).map(|hex| ((0..8).map(|c| at(hex, c)).fold(1.0, f64::min), hex));
        all.reduce(|best, next| if next.0 < best.0 { next } else { best }).unwrap_or((1.0, 0))
    }
}

/// f of a corner with these edges, and its slope with each edge.
fn shape([a, b, c]: [Vector<3>; 3], epsilon: f64) -> (f64, [Vector<3>; 3]) {
    let normals = [b.cross(c), c.cross(a), a.cross(b)];
    let det = a.dot(normals[0]);
    let root = (det * det + epsilon * epsilon).sqrt();
    // Without the difference of two large numbers where the corner is folded.
    let chi = if det > 0.0 { 0.5 * (det + root) } else { 0.5 * epsilon * epsilon / (root - det) };
    let sum = a.norm_squared() + b.norm_squared() + c.norm_squared();
    let scale = 1.0 / (3.0 * chi.cbrt().powi(2));
    let by_det = -2.0 / 3.0 * sum * scale / root.max(f64::MIN_POSITIVE);
    let slope = |edge: Vector<3>, normal: Vector<3>| edge * (2.0 * scale) + normal * by_det;
    (sum * scale, [slope(a, normals[0]), slope(b, normals[1]), slope(c, normals[2])])
}

/// The solution of up to three equations with a positive definite matrix; `None` for another one.
fn solved(mut a: [[f64; 3]; 3], right: &[f64]) -> Option<Vec<f64>> {
    let n = right.len();
    let mut x = right.to_vec();
    for k in 0..n {
        if a[k][k].is_nan() || a[k][k] <= 0.0 {
            return None;
        }
        for i in k + 1..n {
            let factor = a[i][k] / a[k][k];
            (k..n).for_each(|j| a[i][j] -= factor * a[k][j]);
            x[i] -= factor * x[k];
        }
    }
    for k in (0..n).rev() {
        let known = (k + 1..n).map(|j| a[k][j] * x[j]).sum::<f64>();
        x[k] = (x[k] - known) / a[k][k];
    }
    Some(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Slopes against differences, also of a folded corner.
    #[test]
    fn the_shape_has_its_slopes_and_is_one_for_a_cube() {
        let cube = [0, 1, 2].map(Vector::unit);
        assert!((shape(cube, 0.0).0 - 1.0).abs() < 1e-15);
        let corner = [Vector([1.0, 0.2, -0.1]), Vector([0.3, 0.8, 0.1]), Vector([-0.2, 0.1, 1.2])];
        for (corner, epsilon) in [(corner, 0.0), ([corner[1], corner[0], corner[2]], 0.3)] {
            for (k, axis) in (0..3).flat_map(|k| (0..3).map(move |axis| (k, axis))) {
                let at = |by: f64| {
                    let mut moved = corner;
                    moved[k][axis] += by;
                    shape(moved, epsilon).0
                };
                let difference = (at(1e-5) - at(-1e-5)) / 2e-5;
                let slope = shape(corner, epsilon).1[k][axis];
                assert!((slope - difference).abs() < 1e-7 * (1.0 + slope.abs()), "{slope} {difference}");
            }
        }
    }
}
