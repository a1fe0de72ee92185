//! The volume that a closed membrane encloses, as a sum over its elements: of cones to a point that stays
//! (theory C.11).
//!
//! ```text
//! 3D: V = Σ ⅙ a·(b × c) over triangles,    2D: V = Σ ½ a × b over segments
//! ```
//!
//! from any point that stays, exactly, for flat triangles. A quadrilateral is the fan of four triangles around its mean
//! point.

use super::Membrane;
use super::connectivity::MembraneElements;
use crate::math::Vector;
use crate::parallel;
use hashbrown::HashSet;

/// A point that volumes are measured from, and +1 where normals point outwards, −1 where they point inwards.
#[derive(Debug, Clone, Copy)]
pub(super) struct VolumeOrigin<const D: usize> {
    origin: Vector<D>,
    outward: f64,
}

impl<const D: usize> VolumeOrigin<D> {
    /// The origin for the volume within a membrane that has no free edges and whose elements all look to one side; else
    /// `None`.
    pub fn new(elements: &MembraneElements, position: &[Vector<D>]) -> Option<Self> {
        if !is_closed(elements) {
            return None;
        }
        let origin = parallel::sum(position.len(), |k| position[k]) / position.len() as f64;
        let volume = parallel::sum(elements.len(), |e| cone(elements.nodes(e), position, origin));
        Some(Self { origin, outward: volume.signum() })
    }
}

impl<const D: usize> Membrane<D> {
    /// True if the membrane encloses a volume.
    pub(super) fn is_closed(&self) -> bool {
        self.enclosure.is_some()
    }

    /// Contribution of each element to the enclosed volume [m³].
    pub(super) fn volumes(&self) -> Vec<f64> {
        let of = |at: &VolumeOrigin<D>| -> Vec<f64> {
            self.elements.iter().map(|nodes| at.outward * cone(nodes, &self.position, at.origin)).collect()
        };
        self.enclosure.as_ref().map_or_else(Vec::new, of)
    }
}

/// Volume of the cone from `origin` to an element, positive where its normal points away [m³].
fn cone<const D: usize>(nodes: &[u32], position: &[Vector<D>], origin: Vector<D>) -> f64 {
    let x = |k: usize| Vector::<3>((position[nodes[k % nodes.len()] as usize] - origin).to3());
    let spat = |a: Vector<3>, b: Vector<3>, c: Vector<3>| a.cross(b).dot(c) / 6.0;
    match nodes.len() {
        2 => 0.5 * x(0).cross(x(1))[2],
        3 => spat(x(0), x(1), x(2)),
        n => {
            let middle = (0..n).map(x).sum::<Vector<3>>() / n as f64;
            (0..n).map(|k| spat(x(k), x(k + 1), middle)).sum()
        }
    }
}

/// True if every side of an element belongs to one other element, which runs along it in the opposite sense.
fn is_closed(elements: &MembraneElements) -> bool {
    let mut sides = HashSet::new();
    for nodes in elements.iter() {
        let n = nodes.len();
        for k in 0..n {
            // The ends of a segment are where others begin and end.
            let side = match (n, k) {
                (2, 0) => [nodes[0], u32::MAX],
                (2, _) => [u32::MAX, nodes[1]],
                _ => [nodes[k], nodes[(k + 1) % n]],
            };
            if !sides.insert(side) {
                return false;
            }
        }
    }
    sides.iter().all(|&[a, b]| sides.contains(&[b, a]))
}
