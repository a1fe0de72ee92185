//! Solids that are bonded: nodes on the surface of one follow the facets of the other (theory J.13).
//!
//! ```text
//! v_a = Σ_b N_b(ξ_a) v_b,    u_a likewise         ξ_a: the point of the other surface that is nearest to node a at the start
//! ```
//!
//! Nodes that coincide share their velocity; others follow the functions of the facet that they lie on. Forces on
//! a node that follows go to those that lead it with the same weights.

use crate::math::Vector;
use crate::pfem2::solid::mesh::SolidMesh;
use crate::pfem2::solid::setup::SolidSetup;
use crate::pfem2::solid::surface::SolidSurface;
use std::collections::{BTreeMap, BTreeSet};

/// Nodes nearer than this to a facet, over its size, lie on it.
const DISTANCE_ON_FACET: f64 = 0.01;

/// Shape functions below this are rounding of nodes that coincide.
const ROUNDING: f64 = 1e-9;

/// Nodes that follow others.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Ties {
    /// Leaders of each node that follows others, with their weights. None of these follows another.
    leaders: BTreeMap<u32, Vec<(u32, f64)>>,
    /// Pairs of solids that are bonded, each with the smaller number first.
    pairs: BTreeSet<[usize; 2]>,
}

impl Ties {
    /// Ties the surface of the first solid of each pair to that of the second in the reference state.
    ///
    /// # Errors
    /// Two rigid solids; solids that don't touch.
    pub fn new<const D: usize>(
        setups: &[SolidSetup<D>],
        meshes: &[(&SolidMesh<D>, u32)],
        nodes: &[Vector<D>],
        bonds: &[[usize; 2]],
    ) -> Result<Self, String> {
        let mut ties = Self::default();
        if bonds.is_empty() {
            return Ok(ties);
        }
        let surface = SolidSurface::new(meshes, nodes);
        for &[mut own, mut other] in bonds {
            if !ties.pairs.insert([own.min(other), own.max(other)]) {
                continue;
            }
            let name = |solid: usize| setups[solid].name.as_str();
            if setups[own].law.is_rigid() {
                (own, other) = (other, own);
            }
            if setups[own].law.is_rigid() {
                let (a, b) = (name(own), name(other));
                return Err(format!(
                    "`{a}` and `{b}` are both rigid: make one body of them, with their union as its region"
                ));
            }
            let (mesh, first) = meshes[own];
            let outer: BTreeSet<u32> =
                mesh.facets.iter().flat_map(|facet| &facet.nodes).map(|node| node + first).collect();
            if ties.tie(&outer, other, &surface, nodes) == 0 {
                let (a, b) = (name(own), name(other));
                return Err(format!(
                    "no node of `{a}` lies on the surface of `{b}`: only solids that touch at the start can be bonded"
                ));
            }
        }
        ties.resolve();
        Ok(ties)
    }

    /// Ties those of the nodes of a surface that lie on another solid; returns their number.
    fn tie<const D: usize>(
        &mut self,
        outer: &BTreeSet<u32>,
        other: usize,
        surface: &SolidSurface<D>,
        nodes: &[Vector<D>],
    ) -> usize {
        let mut count = 0;
        for &node in outer {
            let Some((foot, size)) = surface.foot_and_size(other, nodes[node as usize]) else { continue };
            if foot.distance.abs() > DISTANCE_ON_FACET * size {
                continue;
            }
            count += 1;
            let leaders = surface.weights(&foot).into_iter().filter(|(_, weight)| weight.abs() > ROUNDING);
            self.leaders.entry(node).or_insert_with(|| leaders.collect());
        }
        count
    }

    /// Puts those in the place of leaders that lead them. A node that would lead itself is free.
    fn resolve(&mut self) {
        /// Nodes that lead each other in a row; more is a circle.
        const ROW: usize = 16;
        let all: Vec<u32> = self.leaders.keys().copied().collect();
        for node in all {
            let mut own: BTreeMap<u32, f64> = BTreeMap::new();
            let next = |node: u32, weight: f64, row: usize| {
                let leaders = self.leaders.get(&node).into_iter().flatten();
                leaders.map(move |&(leader, part)| (leader, part * weight, row))
            };
            let mut open: Vec<(u32, f64, usize)> = next(node, 1.0, 0).collect();
            let mut circular = false;
            while let Some((leader, weight, row)) = open.pop() {
                circular |= leader == node || row > ROW;
                match self.leaders.contains_key(&leader) && !circular {
                    true => open.extend(next(leader, weight, row + 1)),
                    false => *own.entry(leader).or_default() += weight,
                }
            }
            match circular {
                true => drop(self.leaders.remove(&node)),
                false => drop(self.leaders.insert(node, own.into_iter().collect())),
            }
        }
    }

    /// The nodes that a node follows, with their weights.
    pub fn leaders(&self, node: u32) -> Option<&[(u32, f64)]> {
        self.leaders.get(&node).map(Vec::as_slice)
    }

    /// Sets the values of nodes that follow others, interpolated from those of their leaders: v_a = Σ_b N_b v_b.
    pub fn follow<const D: usize>(&self, nodal: &mut [Vector<D>]) {
        for (&node, leaders) in &self.leaders {
            nodal[node as usize] = leaders.iter().map(|&(leader, weight)| nodal[leader as usize] * weight).sum();
        }
    }

    /// True for two solids that are bonded.
    pub fn bond(&self, a: usize, b: usize) -> bool {
        self.pairs.contains(&[a.min(b), a.max(b)])
    }

    /// For each of some solids the first of those that it is bonded with, directly or by others; or itself.
    pub fn bonded_to(&self, solids: usize) -> Vec<usize> {
        let mut first: Vec<usize> = (0..solids).collect();
        for &[a, b] in &self.pairs {
            let [kept, gone] = [first[a].min(first[b]), first[a].max(first[b])];
            first.iter_mut().filter(|own| **own == gone).for_each(|own| *own = kept);
        }
        first
    }

    /// True for a solid that is bonded to another.
    pub fn is_bonded(&self, solid: usize) -> bool {
        self.pairs.iter().flatten().any(|&bonded| bonded == solid)
    }

    /// Number of nodes that follow others.
    pub fn count(&self) -> usize {
        self.leaders.len()
    }
}
