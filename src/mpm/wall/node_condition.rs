//! A node at which a wall or an obstacle acts (theory E.1).

use crate::math::Vector;

/// One node under one condition.
#[derive(Debug, Clone, Copy)]
pub struct NodeCondition<const D: usize> {
    pub node: u32,
    pub boundary: u32,
    pub normal: Vector<D>,
}
