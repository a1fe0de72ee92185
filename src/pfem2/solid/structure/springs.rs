//! Springs and dashpots that pull nodes of solids to where they start (theory J.12).
//!
//! ```text
//! f_a = −w_a (k u_a^{n+1} + c v_a^{n+1}),    u^{n+1} = û + Δ v^{n+1}:    L = w_a (Δ k + c),   l = −w_a k û_a
//! ```

use super::Structure;
use crate::math::{Tensor, Vector};
use crate::pfem2::solid::equations::LinearForces;
use crate::pfem2::solid::setup::{SolidSetup, SpringSupport};

/// The springs of all solids.
#[derive(Debug, Clone)]
pub struct Springs<const D: usize> {
    all: Vec<NodeSpring<D>>,
}

/// A spring and a dashpot along each axis at a node.
#[derive(Debug, Clone)]
struct NodeSpring<const D: usize> {
    node: u32,
    /// w k [N/m].
    stiffness: [f64; D],
    /// w c [N s/m].
    damping: [f64; D],
}

impl<const D: usize> Springs<D> {
    /// The springs of solids whose nodes begin at `first`.
    ///
    /// # Errors
    /// A node that isn't there.
    pub fn new(setups: &[SolidSetup<D>], first: &[u32]) -> Result<Self, String> {
        let mut all = Vec::new();
        for (setup, first) in setups.iter().zip(first) {
            for spring in &setup.springs {
                if let Some((node, _)) =
                    spring.weights.iter().find(|(node, _)| *node as usize >= setup.mesh.nodes.len())
                {
                    return Err(format!("the solid `{}` has no node {node} for a spring", setup.name));
                }
                let part = |of: [f64; D], weight: f64| of.map(|value| value * weight);
                all.extend(spring.weights.iter().map(|&(node, weight)| NodeSpring {
                    node: first + node,
                    stiffness: part(spring.stiffness, weight),
                    damping: part(spring.damping, weight),
                }));
            }
        }
        Ok(Self { all })
    }

    /// Adds their forces in a step with the implicit part `delta` [s], at û [m].
    pub fn add(&self, delta: f64, displacement_hat: &[Vector<D>], forces: &mut LinearForces) {
        for NodeSpring { node, stiffness, damping } in &self.all {
            let hat = displacement_hat[*node as usize];
            let resistance = |i: usize, j: usize| if i == j { stiffness[i] * delta + damping[i] } else { 0.0 };
            forces.add_block((*node, *node), &Tensor::<D>::from_fn(resistance));
            forces.add_load(*node, Vector::<D>::from_fn(|i| -stiffness[i] * hat[i]));
        }
    }

    /// Calls `work` with each nodal unknown that a spring holds, its stiffness [N/m] and its force at a displacement
    /// [m] [N].
    pub fn visit(&self, displacement: &[Vector<D>], mut work: impl FnMut(u32, f64, f64)) {
        for NodeSpring { node, stiffness, .. } in &self.all {
            for (axis, &stiffness) in stiffness.iter().enumerate() {
                work(node * D as u32 + axis as u32, stiffness, -stiffness * displacement[*node as usize][axis]);
            }
        }
    }
}

impl<const D: usize> Structure<D> {
    /// k u + c v at a node in the present state: the force on a spring that holds it alone [N].
    pub(in crate::pfem2::solid) fn pull_on_spring(&self, spring: &SpringSupport<D>, node: usize) -> Vector<D> {
        let (displacement, velocity) = (self.state.displacement[node], self.state.velocity[node]);
        Vector::from_fn(|axis| spring.stiffness[axis] * displacement[axis] + spring.damping[axis] * velocity[axis])
    }
}
