//! Meshes of solids with slots, hollows and folds.

use super::SolidMesh;
use crate::math::Vector;
use std::f64::consts::PI;

/// A block whose elements end at these places along each axis [m], without one of its elements.
fn block_without<const D: usize>(lines: [Vec<f64>; D], element: usize) -> SolidMesh<D> {
    let counts = lines.each_ref().map(|ends| ends.len() - 1);
    let upper = Vector::from_fn(|axis| counts[axis] as f64);
    let block = SolidMesh::block(Vector::ZERO, upper, counts).unwrap();
    let along = |ends: &[f64], x: f64| {
        let own = (x as usize).min(ends.len() - 2);
        ends[own] + (x - own as f64) * (ends[own + 1] - ends[own])
    };
    let kept: Vec<&Vec<u32>> =
        block.elements.iter().enumerate().filter(|(e, _)| *e != element).map(|(_, own)| own).collect();
    let mut used: Vec<u32> = kept.iter().flat_map(|own| own.iter().copied()).collect();
    used.sort_unstable();
    used.dedup();
    let place = |node: &u32| Vector::from_fn(|axis| along(&lines[axis], block.nodes[*node as usize][axis]));
    let renumbered = |own: &&Vec<u32>| own.iter().map(|node| used.binary_search(node).unwrap() as u32).collect();
    SolidMesh::new(used.iter().map(place).collect(), kept.iter().map(renumbered).collect()).unwrap()
}

/// A block with a slot from above between two places along the first axis [m].
pub fn slotted<const D: usize>([lower, upper]: [Vector<D>; 2], slot: [f64; 2]) -> SolidMesh<D> {
    let lines = std::array::from_fn(|axis| match axis {
        0 => vec![lower[0], slot[0], slot[1], upper[0]],
        _ if axis == D - 1 => vec![lower[axis], 0.6 * lower[axis] + 0.4 * upper[axis], upper[axis]],
        _ => vec![lower[axis], upper[axis]],
    });
    block_without(lines, 4)
}

/// A cube about a place, with a cubic hollow; both are this wide [m].
pub fn hollow([outer, inner]: [f64; 2], center: Vector<3>) -> SolidMesh<3> {
    let ends = [-0.5 * outer, -0.5 * inner, 0.5 * inner, 0.5 * outer];
    block_without(std::array::from_fn(|axis| ends.iter().map(|x| center[axis] + x).collect()), 13)
}

/// A strip that is folded to a U, which opens along x and lies symmetric about y = 0 and around z = 0.
#[derive(Debug, Clone, Copy)]
pub struct Fold {
    /// Thickness of the strip, and half of the distance between both arms [m].
    pub thickness: f64,
    pub inner: f64,
    /// Lengths of the arms [m].
    pub arm: f64,
    /// Width along z, in space [m].
    pub width: f64,
}

impl Fold {
    /// The mesh with so many elements along the strip, the middle of its bend at a place.
    pub fn mesh<const D: usize>(self, elements: usize, at: Vector<D>) -> SolidMesh<D> {
        let Self { thickness, inner, arm, width } = self;
        let counts = std::array::from_fn(|axis| if axis == 0 { elements } else { 1 });
        let lower = Vector::from_fn(|axis| if axis == 0 { 0.0 } else { -0.5 });
        let upper = Vector::from_fn(|axis| if axis == 0 { 1.0 } else { 0.5 });
        let mut mesh = SolidMesh::block(lower, upper, counts).unwrap();
        let middle = inner + 0.5 * thickness;
        let half = PI * middle;
        for x in &mut mesh.nodes {
            // Along the middle line from the end of the lower arm; across outward.
            let (s, out) = (x[0] * (2.0 * arm + half), middle + x[1] * thickness);
            let place = match s {
                s if s < arm => [arm - s, -out],
                s if s > arm + half => [s - arm - half, out],
                s => {
                    let angle = -0.5 * PI - (s - arm) / middle;
                    [angle.cos() * out, angle.sin() * out]
                }
            };
            *x = at + Vector::from_fn(|axis| if axis < 2 { place[axis] } else { x[axis] * width });
        }
        mesh
    }
}
