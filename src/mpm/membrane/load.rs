//! Pressure, and nodes whose motion is prescribed (theory C.1, C.8).

use super::connectivity::MembraneElements;
use crate::math::{Signal, Vector};
use crate::mpm::SupportSetup;
use crate::parallel;

/// Area vector [m²] (2D: [m]) of an element: ½ r31 × r42 of a quadrilateral, ½ r21 × r31 of a triangle,
/// r21 × e_z of a segment (theory (C.5)).
#[inline(always)]
pub(super) fn area_vector<const D: usize>(nodes: &[u32], position: &[Vector<D>]) -> Vector<D> {
    let x = |k: usize| Vector::<3>(position[nodes[k] as usize].to3());
    // Lian (34), with the area: 2 A n.
    let doubled = match nodes.len() {
        4 => (x(2) - x(0)).cross(x(3) - x(1)),
        3 => (x(1) - x(0)).cross(x(2) - x(0)),
        _ => (x(1) - x(0)).cross(Vector([0.0, 0.0, 2.0])),
    };
    Vector::from3((doubled * 0.5).0)
}

/// Pressure on the elements; positive pushes along +n.
#[derive(Debug)]
pub(super) struct Pressure<const D: usize> {
    /// Value [Pa].
    value: Signal,
    /// Area vector of each element over the number of its nodes [m²], empty without pressure: as it is now if the
    /// pressure follows the deformed sheet (the element pass refreshes it), in the reference state if not.
    area: Vec<Vector<D>>,
    follower: bool,
    /// Value at the centre of each element [Pa]; empty where it is the same everywhere.
    local: Vec<f64>,
    /// Force on each node [N]; empty without pressure.
    pub force: Vec<Vector<D>>,
}

impl<const D: usize> Pressure<D> {
    /// Prepares the load on `elements` at the reference positions.
    pub fn new(value: Signal, follower: bool, elements: &MembraneElements, reference: &[Vector<D>]) -> Self {
        let loaded = !value.is_zero();
        let nodal_area = |nodes: &[u32]| area_vector(nodes, reference) * (1.0 / nodes.len() as f64);
        let varies = loaded && !value.is_uniform();
        Self {
            area: elements.iter().filter(|_| loaded).map(nodal_area).collect(),
            follower,
            local: vec![0.0; if varies { elements.len() } else { 0 }],
            force: vec![Vector::ZERO; if loaded { reference.len() } else { 0 }],
            value,
        }
    }

    /// Force on a node [N].
    #[inline(always)]
    pub fn at(&self, node: usize) -> Vector<D> {
        self.force.get(node).copied().unwrap_or(Vector::ZERO)
    }

    /// Replaces the value by a constant [Pa].
    #[cfg(test)]
    pub fn set(&mut self, value: f64) {
        self.value = Signal::Constant(value);
        self.local.clear();
    }

    /// Area vectors of the elements over their number of nodes [m²], set by the element pass; empty if they aren't
    /// needed.
    pub fn areas(&mut self) -> &mut [Vector<D>] {
        if self.follower { &mut self.area } else { &mut [] }
    }

    /// The first element where the load has no value, and what it has instead [Pa].
    pub fn undefined(&self) -> Option<(usize, f64)> {
        let bad = parallel::first(self.local.len(), |e| !self.local[e].is_finite());
        bad.map(|e| (e, self.local[e]))
    }

    /// Evaluates the load at time `t`: each element gives equal parts of p·a to its nodes (theory (C.28)).
    pub fn update(&mut self, t: f64, elements: &MembraneElements, position: &[Vector<D>]) {
        let Self { value, area, local, force, .. } = self;
        parallel::fill(local, 1024, |e| {
            let nodes = elements.nodes(e);
            let centre = nodes.iter().map(|&k| position[k as usize]).sum::<Vector<D>>() * (1.0 / nodes.len() as f64);
            value.value(centre.to3(), t)
        });
        let everywhere = value.value([0.0; 3], t);
        let pushed = |c: &u32| {
            let e = elements.element_of(*c);
            area[e] * local.get(e).copied().unwrap_or(everywhere)
        };
        // Lian (31).
        parallel::fill(force, 1024, |k| elements.corners(k).iter().map(pushed).sum());
    }
}

/// One prescribed component of a node's motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Prescribed {
    pub node: u32,
    pub axis: u8,
    /// The support that prescribes it.
    pub support: u16,
}

/// Supports and prescribed motions. Where two supports name the same component the later one counts.
#[derive(Debug)]
pub(super) struct Supports {
    velocity: Vec<[Option<Signal>; 3]>,
    /// Sorted by node and axis, each at most once.
    prescribed: Vec<Prescribed>,
    /// Per node a bit per prescribed axis.
    mask: Vec<u8>,
    /// Mean reaction of each support over the last step [N].
    pub reaction: Vec<[f64; 3]>,
}

impl Supports {
    /// Collects the supports of a membrane with `node_count` nodes in `dimension` dimensions.
    pub fn new(setups: &[SupportSetup], node_count: usize, dimension: usize) -> Self {
        let mut prescribed: Vec<Prescribed> = Vec::new();
        for (support, setup) in setups.iter().enumerate() {
            for axis in (0..dimension).filter(|&axis| setup.velocity[axis].is_some()) {
                let of = |&node: &u32| Prescribed { node, axis: axis as u8, support: support as u16 };
                prescribed.extend(setup.nodes.iter().map(of));
            }
        }
        prescribed.sort_unstable_by_key(|p| (p.node, p.axis, std::cmp::Reverse(p.support)));
        prescribed.dedup_by_key(|p| (p.node, p.axis));
        let mut mask = vec![0u8; node_count];
        prescribed.iter().for_each(|p| mask[p.node as usize] |= 1 << p.axis);
        let velocity: Vec<_> = setups.iter().map(|s| s.velocity.clone()).collect();
        Self { reaction: vec![[0.0; 3]; velocity.len()], velocity, prescribed, mask }
    }

    /// True if this component is prescribed.
    #[inline(always)]
    pub fn is_prescribed(&self, node: usize, axis: usize) -> bool {
        self.mask[node] & (1 << axis) != 0
    }

    /// All prescribed components.
    pub fn prescribed(&self) -> &[Prescribed] {
        &self.prescribed
    }

    /// Mean reactions over the last step [N].
    pub fn reactions(&self) -> &[[f64; 3]] {
        &self.reaction
    }

    /// Replaces the prescribed components at time `t`; formulas see the reference position.
    pub fn impose<const D: usize>(&self, velocity: &mut [Vector<D>], reference: &[Vector<D>], t: f64) {
        for p in &self.prescribed {
            let (node, axis) = (p.node as usize, p.axis as usize);
            if let Some(signal) = &self.velocity[p.support as usize][axis] {
                velocity[node][axis] = signal.value(reference[node].to3(), t);
            }
        }
    }
}
