//! Membranes: thin sheets as explicit finite elements without bending (Lian, Liu & Zhang 2014, section 4; theory C.1 to
//! C.11).
//!
//! Quadrilaterals with one quadrature point and hourglass control (of sheets that wrinkle: 2 × 2 points),
//! constant-strain triangles, and in 2D two-node segments of unit width. One step, from positions xⁿ and velocities
//! v^{n−½}:
//!
//! ```text
//! σⁿ, hⁿ        from the strain of the last step                              Lian (32–41), corrected
//! f_K           = f_int + f_hourglass + f_ext                                 Lian (42–45)
//! v̄_K           = v_K + Δt f_K / m_K, prescribed components replaced          Lian (46)   trial
//! v_K           = v̄_K + Δt f_K^contact / m_K, prescribed components again     Lian (59)
//! x_K           ← x_K + Δt v_K                                                Lian (47)
//! ```
//!
//! Everything that does work is booked with the mean velocity v̂ = ½ (v^{n−½} + v^{n+½}), so that the kinetic energy
//! changes by exactly the sum of the booked works (theory C.11).

mod build;
mod connectivity;
mod element;
mod enclosed;
mod frame;
mod hourglass;
mod lanes;
mod ledger;
mod load;
mod output;
mod shape;
mod step;
mod task;
#[cfg(test)]
mod tests;
mod touch;

pub use connectivity::MembraneElements;
pub use ledger::Balance;

use crate::material::Sheet;
use crate::math::{Signal, Vector};
use element::{HistoryBlock, MembraneParameters, ReferenceBlock};
use enclosed::VolumeOrigin;
use ledger::MembraneLedger;
use load::{Pressure, Supports};

/// A membrane: nodes, elements, one sheet law, loads and supports.
///
/// In 2D masses, forces and energies are per metre of depth.
#[derive(Debug)]
pub struct Membrane<const D: usize> {
    /// Name, as the case gives it.
    pub name: String,
    /// Positions of the nodes xⁿ [m].
    pub position: Vec<Vector<D>>,
    /// Velocities of the nodes at half steps [m/s].
    pub velocity: Vec<Vector<D>>,
    /// Positions of the nodes at the start [m].
    pub reference: Vec<Vector<D>>,
    /// Lumped masses of the nodes [kg].
    pub mass: Vec<f64>,
    /// Nodes of the elements, sorted by shape: quadrilaterals, triangles, segments.
    pub elements: MembraneElements,
    /// Half the thickness counts in the contact gap.
    pub contact_thickness: bool,

    sheet: Box<dyn Sheet>,
    gravity: [Signal; D],
    pressure: Pressure<D>,
    supports: Supports,
    /// Mass-proportional damping rate [1/s].
    mass_damping: f64,
    parameters: MembraneParameters,

    blocks: Vec<HistoryBlock>,
    references: Vec<ReferenceBlock>,

    /// Velocities before the step, v^{n−½} [m/s].
    before: Vec<Vector<D>>,
    /// Force of each element corner on its node [N].
    corner_force: Vec<Vector<D>>,
    /// Sum of the element forces on each node [N].
    element_force: Vec<Vector<D>>,
    /// Contact force on each node in this step [N].
    contact_force: Vec<Vector<D>>,
    /// Impulse of contact on each node since the step began [N s], and the time of momentum in it [s].
    touch: Vec<Vector<D>>,
    touch_time: f64,
    /// Of a membrane without free edges.
    enclosure: Option<VolumeOrigin<D>>,
    /// The Δt of the momentum update under way [s].
    momentum_dt: f64,
    ledger: MembraneLedger,
}

impl<const D: usize> Membrane<D> {
    /// The same membrane under a body force per unit mass [m/s²].
    #[must_use]
    pub fn with_gravity(mut self, gravity: [Signal; D]) -> Self {
        self.gravity = gravity;
        self
    }

    /// Half the in-plane thickness that counts in contact [m]; zero if only the mid-surface counts.
    pub fn contact_half_thickness(&self, element: usize) -> f64 {
        if self.contact_thickness { 0.5 * self.thickness(element) } else { 0.0 }
    }

    /// Current thickness of an element [m]: the mean over its quadrature points.
    pub fn thickness(&self, element: usize) -> f64 {
        let (blocks, lane) = self.elements.blocks_and_lane(element);
        let points = blocks.len() as f64;
        self.blocks[blocks].iter().map(|block| block.thickness[lane]).sum::<f64>() / points
    }

    /// Area vector of an element in its current shape [m²] (2D: [m]): area times unit normal. The normal follows the
    /// right-hand rule of the node order; in 2D it is the tangent turned clockwise.
    pub fn area_vector(&self, element: usize) -> Vector<D> {
        load::area_vector(self.elements.nodes(element), &self.position)
    }

    /// True for the components of a node's motion that are prescribed.
    pub fn constrained(&self, node: usize) -> [bool; D] {
        std::array::from_fn(|axis| self.supports.is_prescribed(node, axis))
    }

    /// Reaction of the supports on the membrane, mean over the last step, one force per support [N].
    pub fn reactions(&self) -> &[[f64; 3]] {
        self.supports.reactions()
    }

    /// Total mass [kg].
    pub fn total_mass(&self) -> f64 {
        crate::parallel::sum(self.mass.len(), |k| self.mass[k])
    }

    /// The largest stable step of the elements as they were at the last force evaluation [s]
    /// (theory (C.34)). The caller applies its safety factor.
    pub fn stable_dt(&self) -> f64 {
        // In place of Lian (48).
        let zeta = self.parameters.damping;
        2.0 / self.ledger.frequency2.sqrt() * ((1.0 + zeta * zeta).sqrt() - zeta)
    }
}
