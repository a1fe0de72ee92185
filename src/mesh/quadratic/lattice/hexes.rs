//! Hexahedra with eight corners, the quadrilaterals on their boundary, and layers that are put beneath these.
//!
//! Corner a = a_0 + 2 a_1 + 4 a_2 of a hexahedron lies at the upper end of direction k where a_k = 1. Corners of a
//! quadrilateral run counter-clockwise, seen from outside.

use super::cells::Cells;
use crate::math::Vector;
use std::collections::{BTreeMap, BTreeSet};

/// Corners of the sides of a hexahedron, lower and upper along each direction, seen from outside.
const SIDES: [[usize; 4]; 6] = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];

/// A quadrilateral of the boundary.
#[derive(Debug, Clone)]
pub struct BoundaryQuad {
    pub nodes: [u32; 4],
    /// Its hexahedron.
    pub hex: u32,
    /// The patch of the surface that it belongs to.
    pub patch: u32,
}

/// A mesh of hexahedra.
#[derive(Debug, Clone)]
pub struct Hexes {
    pub nodes: Vec<Vector<3>>,
    pub hexes: Vec<[u32; 8]>,
    /// Lengths that the edges of each hexahedron should have along its directions [m].
    pub sizes: Vec<[f64; 3]>,
    pub quads: Vec<BoundaryQuad>,
}

impl Hexes {
    /// The cells that are kept; nodes in the order of the lattice. No quadrilateral has a patch yet.
    pub fn of_cells(cells: &Cells) -> Self {
        let lattice = cells.lattice;
        let lines = lattice.counts().map(|count| count + 1);
        let mut number = vec![u32::MAX; lines.iter().product()];
        let corner = |cell: usize, a: usize| {
            let [x, y, z] = std::array::from_fn(|k| lattice.at(cell)[k] + (a >> k & 1));
            x + lines[0] * (y + lines[1] * z)
        };
        let kept: Vec<usize> = (0..cells.kept.len()).filter(|&cell| cells.kept[cell]).collect();
        kept.iter().flat_map(|&cell| (0..8).map(move |a| (cell, a))).for_each(|(cell, a)| number[corner(cell, a)] = 0);
        let mut nodes = Vec::new();
        for (n, own) in number.iter_mut().enumerate().filter(|(_, own)| **own == 0) {
            *own = nodes.len() as u32;
            let at = [n % lines[0], n / lines[0] % lines[1], n / lines[0] / lines[1]];
            nodes.push(Vector::from_fn(|k| lattice.lines[k][at[k]]));
        }
        let mut mesh = Self { nodes, hexes: Vec::new(), sizes: Vec::new(), quads: Vec::new() };
        for cell in kept {
            let own: [u32; 8] = std::array::from_fn(|a| number[corner(cell, a)]);
            let outside = (0..6).filter(|&side| cells.is_boundary(cell, side));
            let hex = mesh.hexes.len() as u32;
            mesh.quads.extend(outside.map(|side| BoundaryQuad { nodes: SIDES[side].map(|a| own[a]), hex, patch: 0 }));
            mesh.hexes.push(own);
            mesh.sizes.push(lattice.sizes(lattice.at(cell)));
        }
        mesh
    }

    /// The two quadrilaterals at each edge of the boundary, by the ends of the edge, ascending.
    pub fn edges(&self) -> BTreeMap<[u32; 2], [usize; 2]> {
        let mut found: BTreeMap<[u32; 2], [usize; 2]> = BTreeMap::new();
        for (index, quad) in self.quads.iter().enumerate() {
            for [a, b] in quad.edges() {
                let ends = [a.min(b), a.max(b)];
                found.entry(ends).and_modify(|own| own[1] = index).or_insert([index, index]);
            }
        }
        found
    }

    /// The quadrilaterals beyond the four edges of each one.
    pub fn neighbours(&self) -> Vec<[usize; 4]> {
        let edges = self.edges();
        let beyond = |q: usize, [a, b]: [u32; 2]| {
            let [first, second] = edges[&[a.min(b), a.max(b)]];
            if first == q { second } else { first }
        };
        self.quads.iter().enumerate().map(|(q, quad)| quad.edges().map(|edge| beyond(q, edge))).collect()
    }

    /// Nodes between two edges of a quadrilateral that follow each other, beyond both of which there is the same patch,
    /// not its own; each with that patch.
    pub fn bends(&self) -> BTreeMap<u32, u32> {
        let mut found = BTreeMap::new();
        for (quad, neighbours) in self.quads.iter().zip(self.neighbours()) {
            let beyond = neighbours.map(|q| self.quads[q].patch);
            for k in (0..4).filter(|&k| beyond[k] == beyond[(k + 1) % 4] && beyond[k] != quad.patch) {
                found.insert(quad.nodes[(k + 1) % 4], beyond[k]);
            }
        }
        found
    }

    /// Characteristic of the boundary: vertices − edges + faces.
    pub fn characteristic(&self) -> isize {
        let nodes: BTreeSet<u32> = self.quads.iter().flat_map(|quad| quad.nodes).collect();
        nodes.len() as isize - self.quads.len() as isize
    }

    /// Patches of each node of the boundary, ascending.
    pub fn patches(&self) -> BTreeMap<u32, Vec<u32>> {
        let mut found: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for quad in &self.quads {
            quad.nodes.iter().for_each(|&node| found.entry(node).or_default().push(quad.patch));
        }
        for patches in found.values_mut() {
            patches.sort_unstable();
            patches.dedup();
        }
        found
    }

    /// Pushes the mesh away from the quadrilaterals on some patches by a layer of hexahedra, `thickness` times as thick
    /// as those that have these sides now (pillowing). At the rim of the patches the layer ends in the neighbouring
    /// ones.
    pub fn pillow(&mut self, patches: &BTreeSet<u32>, thickness: f64) {
        let neighbours = self.neighbours();
        let covered: Vec<usize> = (0..self.quads.len()).filter(|&q| patches.contains(&self.quads[q].patch)).collect();
        let lengths: Vec<[f64; 3]> = covered.iter().map(|&q| self.lengths(&self.quads[q])).collect();
        let inward = self.inward(&covered);
        let first = self.nodes.len() as u32;
        let mut copy: BTreeMap<u32, u32> = BTreeMap::new();
        for (&node, &shift) in &inward {
            copy.insert(node, first + copy.len() as u32);
            self.nodes.push(self.nodes[node as usize] + shift);
        }
        let copied = |node: u32| copy.get(&node).copied().unwrap_or(node);
        self.hexes.iter_mut().flatten().for_each(|node| *node = copied(*node));
        let mut sides = Vec::new();
        for (&q, [along, across, depth]) in covered.iter().zip(lengths) {
            let [a, b, c, d] = self.quads[q].nodes;
            let hex = self.hexes.len() as u32;
            self.hexes.push([copied(a), copied(b), copied(d), copied(c), a, b, d, c]);
            self.sizes.push([along, across, thickness * depth]);
            self.quads[q].hex = hex;
            for ([a, b], beyond) in self.quads[q].edges().into_iter().zip(neighbours[q]) {
                let beyond = self.quads[beyond].patch;
                if !patches.contains(&beyond) {
                    sides.push(BoundaryQuad { nodes: [a, copied(a), copied(b), b], hex, patch: beyond });
                }
            }
        }
        for quad in self.quads.iter_mut().filter(|quad| !patches.contains(&quad.patch)) {
            quad.nodes = quad.nodes.map(copied);
        }
        self.quads.extend(sides);
    }

    /// Displacements of the nodes of some quadrilaterals by a layer [m]: some way towards the other end of the edges
    /// that lead inside, or else of all edges of their hexahedra.
    fn inward(&self, covered: &[usize]) -> BTreeMap<u32, Vector<3>> {
        /// Part of the length of edges.
        const WAY: f64 = 0.4;
        let on: BTreeSet<u32> = covered.iter().flat_map(|&q| self.quads[q].nodes).collect();
        let mut sums: BTreeMap<u32, [(Vector<3>, f64); 2]> = BTreeMap::new();
        for hex in &self.hexes {
            for (a, &node) in hex.iter().enumerate().filter(|(_, node)| on.contains(node)) {
                for k in 0..3 {
                    let other = hex[a ^ 1 << k];
                    let own = &mut sums.entry(node).or_default()[usize::from(on.contains(&other))];
                    *own = (own.0 + self.nodes[other as usize] - self.nodes[node as usize], own.1 + 1.0);
                }
            }
        }
        let mean = |[inner, all]: [(Vector<3>, f64); 2]| {
            let (sum, count) = if inner.1 > 0.0 { inner } else { all };
            sum * (WAY / count)
        };
        sums.into_iter().map(|(node, own)| (node, mean(own))).collect()
    }

    /// Lengths that a quadrilateral should have along its first and last edge, and its hexahedron normal to it.
    fn lengths(&self, quad: &BoundaryQuad) -> [f64; 3] {
        let (hex, sizes) = (&self.hexes[quad.hex as usize], self.sizes[quad.hex as usize]);
        let place = |node: u32| hex.iter().position(|&own| own == node).unwrap_or(0);
        let [a, b, d] = [0, 1, 3].map(|k| place(quad.nodes[k]));
        let [along, across] = [a ^ b, a ^ d].map(|bit| bit.trailing_zeros().min(2) as usize);
        [sizes[along], sizes[across], sizes[3 - (along + across).min(3)]]
    }
}

impl BoundaryQuad {
    /// Its edges, counter-clockwise.
    pub fn edges(&self) -> [[u32; 2]; 4] {
        let [a, b, c, d] = self.nodes;
        [[a, b], [b, c], [c, d], [d, a]]
    }
}
