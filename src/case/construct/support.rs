//! Nodes whose motion is prescribed, of membranes and of solids.

use super::Construction;
use super::signals::TrialPoints;
use crate::case::{AxisMotion, SupportPlace, SupportSpec};
use crate::error::Diagnostic;
use crate::geometry::Region;
use crate::math::Signal;
use crate::mesh::{Facets, QuadraticMesh};

/// A mesh whose nodes can be named.
pub(super) trait NodeSets {
    /// The nodes of a named set.
    fn set(&self, name: &str) -> Option<Vec<u32>>;
    /// The names that there are.
    fn set_names(&self) -> Vec<&str>;
    /// The node nearest to a place [m].
    fn nearest_node(&self, x: [f64; 3]) -> Option<u32>;
    /// Nodes inside or on the boundary of a region.
    fn nodes_in(&self, region: &Region) -> Vec<u32>;
}

macro_rules! node_sets {
    ($($Mesh:ty),+) => {
        $(impl NodeSets for $Mesh {
            fn set(&self, name: &str) -> Option<Vec<u32>> {
                <$Mesh>::set(self, name)
            }

            fn set_names(&self) -> Vec<&str> {
                <$Mesh>::set_names(self)
            }

            fn nearest_node(&self, x: [f64; 3]) -> Option<u32> {
                <$Mesh>::nearest_node(self, x)
            }

            fn nodes_in(&self, region: &Region) -> Vec<u32> {
                <$Mesh>::nodes_in(self, region)
            }
        })+
    };
}

node_sets!(Facets, QuadraticMesh);

impl Construction<'_> {
    /// The nodes of a support of a `part` (membrane, solid), and their velocity along the first N axes; `None` where an
    /// axis is free.
    pub(super) fn support<const N: usize>(
        &mut self,
        spec: &SupportSpec,
        key: &str,
        part: &str,
        mesh: &impl NodeSets,
        over: &TrialPoints,
    ) -> Option<(Vec<u32>, [Option<Signal>; N])> {
        let nodes = self.nodes_on(&spec.on, &format!("{key}.on"), part, mesh)?;
        let velocity = std::array::from_fn(|i| match &spec.velocity[i] {
            AxisMotion::Free(_) => None,
            AxisMotion::Velocity(v) => Some(self.signal(&format!("{key}.velocity[{i}]"), v, over)),
        });
        Some((nodes, velocity))
    }

    /// The nodes of a `part` (membrane, solid) in a place, ascending.
    pub(super) fn nodes_on(
        &mut self,
        on: &SupportPlace,
        key: &str,
        part: &str,
        mesh: &impl NodeSets,
    ) -> Option<Vec<u32>> {
        let nodes = match on {
            SupportPlace::Named(name) => mesh.set(name),
            SupportPlace::Point(x) => mesh.nearest_node(*x).map(|node| vec![node]),
            SupportPlace::Region(shape) => {
                let region = self.region(key, shape)?;
                Some(mesh.nodes_in(&region))
            }
        };
        let finding = match nodes {
            Some(nodes) if !nodes.is_empty() => return Some(nodes),
            Some(_) => Diagnostic::error(key, format!("there is no node of the {part} here")),
            None => Diagnostic::error(key, format!("the {part} has no such set of nodes"))
                .help(format!("its sets are {}", mesh.set_names().join(", "))),
        };
        self.findings.push(finding);
        None
    }
}
