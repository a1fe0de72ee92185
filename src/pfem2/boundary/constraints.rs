//! The nodes that are held, and the directions in which they are (theory F.9).

use super::{BoundaryKind, BoundarySetup};
use crate::math::{Tensor, Vector};
use crate::mesh::Mesh;
use std::collections::{BTreeMap, BTreeSet};

/// A mask with a bit per prescribed unknown of each node, their values, and frames of nodes that are rotated.
#[derive(Debug, Clone)]
pub struct Constraints<const D: usize, const N: usize> {
    /// Bit r: component r is prescribed; bit D: pressure.
    pub mask: Vec<u8>,
    /// The prescribed values, in the node's frame.
    pub value: Vec<[f64; N]>,
    /// Place of the node's frame in `frames`, or [`Constraints::UPRIGHT`].
    pub(super) frame: Vec<u32>,
    pub(super) frames: Vec<Tensor<D>>,
}

impl<const D: usize, const N: usize> Constraints<D, N> {
    /// A node whose components are those of the axes.
    pub(super) const UPRIGHT: u32 = u32::MAX;

    /// The frame of a node: its rows are the directions of its components; `None`: the axes.
    #[inline]
    pub fn frame(&self, node: usize) -> Option<&Tensor<D>> {
        let place = self.frame[node];
        (place != Self::UPRIGHT).then(|| &self.frames[place as usize])
    }

    /// Components of a vector in the frame of a node.
    pub fn into_frame(&self, node: usize, v: Vector<D>) -> Vector<D> {
        self.frame(node).map_or(v, |frame| frame.apply(v))
    }

    /// The vector with these components in the frame of a node.
    pub fn out_of_frame(&self, node: usize, v: Vector<D>) -> Vector<D> {
        self.frame(node).map_or(v, |frame| frame.transpose().apply(v))
    }
}

/// Directions in which a slip node is held.
#[derive(Debug, Clone, Copy)]
pub(super) struct Glide<const D: usize> {
    pub node: u32,
    /// Rows: held directions first; orthonormal.
    pub frame: Tensor<D>,
    /// Number of held directions.
    pub held: usize,
}

/// Nodes of walls, and of inlets that are on no wall, with their sets in ascending order.
pub(super) fn fixed_nodes<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    sets: &[BoundarySetup<D>],
    owner: &[usize],
) -> BTreeMap<u32, Vec<u32>> {
    let nodes_of = |takes: fn(BoundaryKind) -> bool| {
        let facets = owner.iter().zip(mesh.boundary()).filter(move |(set, _)| takes(sets[**set].condition.kind()));
        let mut found: BTreeMap<u32, BTreeSet<u32>> = BTreeMap::new();
        for (&set, &facet) in facets {
            for node in mesh.facet_nodes(facet) {
                found.entry(node).or_default().insert(set as u32);
            }
        }
        found
    };
    let mut fixed = nodes_of(BoundaryKind::prescribes_inflow);
    fixed.append(&mut nodes_of(|kind| !kind.admits_flow() && !kind.is_frictionless()));
    fixed.into_iter().map(|(node, sets)| (node, sets.into_iter().collect())).collect()
}

/// Slip nodes that aren't fixed, with their normals.
pub(super) fn glides<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    kinds: &[BoundaryKind],
    fixed: &BTreeMap<u32, Vec<u32>>,
) -> Vec<Glide<D>> {
    /// Facets whose normals differ by more than 45° bind separately.
    const SMOOTH: f64 = std::f64::consts::FRAC_1_SQRT_2;
    let mut normals: BTreeMap<u32, Vec<Vector<D>>> = BTreeMap::new();
    let slip = mesh.boundary().iter().zip(kinds).filter(|(_, kind)| kind.is_frictionless());
    for (&facet, _) in slip {
        let area = mesh.facet_area(facet);
        for node in mesh.facet_nodes(facet).into_iter().filter(|node| !fixed.contains_key(node)) {
            let groups = normals.entry(node).or_default();
            match groups.iter_mut().find(|sum| sum.dot(area) > SMOOTH * sum.norm() * area.norm()) {
                Some(sum) => *sum += area,
                None => groups.push(area),
            }
        }
    }
    normals.iter().map(|(&node, normals)| glide(node, normals)).collect()
}

/// An orthonormal frame that begins with the span of the normals.
fn glide<const D: usize>(node: u32, normals: &[Vector<D>]) -> Glide<D> {
    /// A direction whose rest after orthogonalisation is shorter adds nothing.
    const DEPENDENT: f64 = 1e-3;
    let mut rows: Vec<Vector<D>> = Vec::with_capacity(D);
    let mut held = 0;
    let axes = (0..D).map(Vector::unit);
    let directions = normals.iter().filter_map(|n| n.normalized()).chain(axes);
    for (place, direction) in directions.enumerate() {
        let rest = rows.iter().fold(direction, |rest, row| rest - *row * row.dot(rest));
        if let Some(row) = rest.normalized().filter(|_| rest.norm() > DEPENDENT && rows.len() < D) {
            rows.push(row);
            held += usize::from(place < normals.len());
        }
    }
    Glide { node, frame: Tensor::from_fn(|i, j| rows[i][j]), held }
}

/// The bits of the held axes, if the held directions are axes.
pub(super) fn axes_of<const D: usize>(glide: &Glide<D>) -> Option<u8> {
    const EXACT: f64 = 1e-12;
    let axis = |row: &[f64; D]| row.iter().position(|c| 1.0 - c.abs() < EXACT);
    if glide.held == D {
        return Some((1 << D) - 1);
    }
    glide.frame.0[..glide.held].iter().try_fold(0, |mask, row| axis(row).map(|axis| mask | 1 << axis))
}
