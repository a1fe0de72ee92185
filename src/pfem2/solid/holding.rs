//! Forces of solids on their supports and springs, and of contacts on them (theory (J.14a)).
//!
//! ```text
//! F_k = f_k + (l − L v)_k − (S v − r)_k                   an elastic solid on the support of the unknown k
//! F   = Σ_a [f_a + (l − L v)_a − (S v − r)_a] − (m/Δ (V − V̂) + α m V)   a rigid one on its supports, hinges and guides
//! F   = Σ_a w_a (k u_a + c v_a)                           a solid on a spring
//! F   = Σ_i c_i f                                         walls and solids on a solid, over its contacts
//! ```
//!
//! f is the force of the fluid on a node. Impulses, of contacts of rigid solids and of the supports of these, take no
//! part in later steps (theory (J.16a)).

use super::contact::step::StepContacts;
use super::rigid::RigidLoad;
use super::setup::SolidSetup;
use super::structure::bodies::SolvedStep;
use super::structure::{Prediction, Structure};
use crate::linalg::MatrixEntry;
use crate::math::Vector;
use crate::pfem2::moments::moment;

/// Something that holds a solid, or pushes on it beside the fluid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Holder {
    /// One of the supports of an elastic solid, by its place among them.
    Support(usize),
    /// All supports of a rigid solid together, and its prescribed motion.
    Rigid,
    /// One of the springs, by its place among them.
    Spring(usize),
    /// Contacts with walls and solids.
    Contact,
}

/// A force of or on a solid, and its moment about the point of the solid, or the origin.
#[derive(Debug, Clone, Copy, Default)]
pub(in crate::pfem2) struct HoldingForce<const D: usize> {
    /// Force [N].
    pub force: Vector<D>,
    /// Moment [N m].
    pub moment: Vector<3>,
}

/// Forces at the end of a step.
#[derive(Debug, Clone)]
pub(in crate::pfem2) struct HoldingForces<const D: usize> {
    /// Those that take part in the next step.
    pub lasting: Vec<HoldingForce<D>>,
    /// Those of impulses, which act for Δ alone.
    pub impulses: Vec<HoldingForce<D>>,
}

/// All that holds the solids of a run.
#[derive(Debug, Clone)]
pub(in crate::pfem2) struct Holders {
    /// Solids, and what holds each.
    all: Vec<(usize, Holder)>,
    /// The place in the list of the support of each unknown; of several the last holds.
    of_unknown: Vec<Option<u32>>,
}

/// The end of a step.
pub(in crate::pfem2) struct HeldStep<'a, const D: usize> {
    /// Implicit part Δ of the step [s].
    pub delta: f64,
    /// The prediction.
    pub prediction: &'a Prediction<D>,
    /// The solution of its equations.
    pub solved: &'a SolvedStep<'a, D>,
    /// Contacts.
    pub contacts: &'a StepContacts<D>,
    /// Points about which forces on the solids have moments [m].
    pub moment_points: &'a [Option<Vector<D>>],
}

impl<const D: usize> HoldingForce<D> {
    /// Adds a force [N] at the end of an arm [m].
    fn add(&mut self, arm: Vector<D>, force: Vector<D>) {
        self.force += force;
        self.moment += moment(arm, force);
    }

    /// Less a load on a rigid solid, with moments about a `point` [m].
    fn less(self, other: Option<RigidLoad>, point: Vector<D>) -> Self {
        let Some(RigidLoad { load, center }) = other else { return self };
        let torque = load.spin + (center - Vector(point.to3())).cross(load.velocity);
        Self { force: self.force - Vector::from3(load.velocity.0), moment: self.moment - torque }
    }
}

impl<const D: usize> HeldStep<'_, D> {
    /// The point about which forces on a solid have moments [m].
    fn moment_point(&self, solid: usize) -> Vector<D> {
        self.moment_points[solid].unwrap_or_default()
    }
}

impl Holders {
    /// Those of solids.
    pub fn new<const D: usize>(structure: &Structure<D>) -> Self {
        let mut holders = Self { all: Vec::new(), of_unknown: vec![None; structure.node_count() * D] };
        for (solid, setup) in structure.setups().iter().enumerate() {
            holders.add_supports(structure.nodes_of(solid).start, solid, setup);
            holders.all.extend((0..setup.springs.len()).map(|index| (solid, Holder::Spring(index))));
            holders.all.push((solid, Holder::Contact));
        }
        holders
    }

    fn add_supports<const D: usize>(&mut self, first: usize, solid: usize, setup: &SolidSetup<D>) {
        if setup.law.is_rigid() {
            let rates = setup.motion.velocity.iter().chain(&setup.motion.spin);
            if !setup.held.is_empty() || rates.flatten().next().is_some() {
                self.all.push((solid, Holder::Rigid));
            }
            return;
        }
        for (index, held) in setup.held.iter().enumerate() {
            let place = self.all.len() as u32;
            for &node in &held.nodes {
                for axis in (0..D).filter(|&axis| held.velocity[axis].is_some()) {
                    self.of_unknown[(first + node as usize) * D + axis] = Some(place);
                }
            }
            self.all.push((solid, Holder::Support(index)));
        }
    }

    /// Their number.
    pub fn count(&self) -> usize {
        self.all.len()
    }

    /// The solid of each.
    pub fn solids(&self) -> impl Iterator<Item = usize> + '_ {
        self.all.iter().map(|&(solid, _)| solid)
    }

    /// Their names among forces: `support:beam[0]`, `support:rotor` of a rigid solid, `spring:beam[0]`,
    /// `contacts:beam`.
    pub fn names<const D: usize>(&self, structure: &Structure<D>) -> Vec<String> {
        let name = |&(solid, holder): &(usize, Holder)| {
            let name = &structure.setups()[solid].name;
            match holder {
                Holder::Support(index) => format!("support:{name}[{index}]"),
                Holder::Rigid => format!("support:{name}"),
                Holder::Spring(index) => format!("spring:{name}[{index}]"),
                Holder::Contact => format!("contacts:{name}"),
            }
        };
        self.all.iter().map(name).collect()
    }

    /// The forces at the end of a step: on supports and springs, and of contacts on solids; impulses stand apart.
    pub(in crate::pfem2) fn measure<const D: usize>(
        &self,
        structure: &Structure<D>,
        step: &HeldStep<'_, D>,
    ) -> HoldingForces<D> {
        let velocity = |node: usize| structure.state.velocity[node];
        let end = StepEnd {
            structure,
            step,
            places: structure.positions(&step.prediction.displacement),
            on_supports: forces_on_supports(step.solved),
            contacts: step.contacts.forces(velocity),
            impulses: step.contacts.impulses(velocity),
        };
        let all = self.all.iter().map(|&(solid, holder)| end.forces(solid, holder));
        let (mut lasting, impulses): (Vec<HoldingForce<D>>, _) = all.unzip();
        for (k, place) in self.of_unknown.iter().enumerate() {
            let Some(place) = place.map(|place| place as usize) else { continue };
            let force = Vector::from_fn(|axis| if axis == k % D { end.on_supports[k] } else { 0.0 });
            lasting[place].add(end.arm(self.all[place].0, k / D), force);
        }
        HoldingForces { lasting, impulses }
    }
}

/// The end of a step, with the forces on all nodes.
struct StepEnd<'a, const D: usize> {
    structure: &'a Structure<D>,
    step: &'a HeldStep<'a, D>,
    /// Positions of nodes [m].
    places: Vec<Vector<D>>,
    /// Forces on supports, by unknown [N].
    on_supports: Vec<f64>,
    /// Forces of contacts on nodes but for impulses [N].
    contacts: Vec<(usize, Vector<D>)>,
    /// Impulses on nodes, as forces that act for Δ [N].
    impulses: Vec<(usize, Vector<D>)>,
}

impl<const D: usize> StepEnd<'_, D> {
    /// Vector from the point of a solid to a node [m].
    fn arm(&self, solid: usize, node: usize) -> Vector<D> {
        self.places[node] - self.step.moment_point(solid)
    }

    /// Sum of forces on nodes over a solid.
    fn sum(&self, solid: usize, forces: &[(usize, Vector<D>)]) -> HoldingForce<D> {
        let (nodes, mut sum) = (self.structure.nodes_of(solid), HoldingForce::default());
        let own = forces.iter().filter(|(node, _)| nodes.contains(node));
        own.for_each(|&(node, force)| sum.add(self.arm(solid, node), force));
        sum
    }

    /// The force that lasts, and that of impulses; of the supports of elastic solids nothing yet.
    fn forces(&self, solid: usize, holder: Holder) -> (HoldingForce<D>, HoldingForce<D>) {
        let none = HoldingForce::default();
        match holder {
            Holder::Support(_) => (none, none),
            Holder::Rigid => self.on_rigid_supports(solid),
            Holder::Spring(index) => {
                let (spring, first) =
                    (&self.structure.setups()[solid].springs[index], self.structure.nodes_of(solid).start);
                let pull = |&(node, weight): &(u32, f64)| {
                    let node = first + node as usize;
                    (node, self.structure.pull_on_spring(spring, node) * weight)
                };
                (self.sum(solid, &spring.weights.iter().map(pull).collect::<Vec<_>>()), none)
            }
            Holder::Contact => (self.sum(solid, &self.contacts), self.sum(solid, &self.impulses)),
        }
    }

    fn on_rigid_supports(&self, solid: usize) -> (HoldingForce<D>, HoldingForce<D>) {
        let HeldStep { delta, prediction, solved, .. } = *self.step;
        let (structure, nodes) = (self.structure, self.structure.nodes_of(solid));
        let point = self.step.moment_point(solid);
        let own: Vec<_> = self.impulses.iter().filter(|(node, _)| nodes.contains(node)).copied().collect();
        let response = structure.rigid_response(solid, delta, prediction, &own);
        let impulses = self.sum(solid, &own).less(response, point);
        let on_node = |node: usize| (node, Vector::from_fn(|axis| self.on_supports[node * D + axis]));
        let all = self.sum(solid, &nodes.map(on_node).collect::<Vec<_>>());
        let all = all.less(structure.rigid_inertial(solid, delta, prediction, solved.independent), point);
        let lasting = HoldingForce { force: all.force - impulses.force, moment: all.moment - impulses.moment };
        (lasting, impulses)
    }
}

/// f + l − L v − (S v − r) of each unknown [N].
fn forces_on_supports<const D: usize>(solved: &SolvedStep<'_, D>) -> Vec<f64> {
    let SolvedStep { equations, velocity, fluid, .. } = solved;
    let mut forces = equations.missing(velocity);
    forces.iter_mut().enumerate().for_each(|(k, force)| *force = fluid[k / D][k % D] - *force);
    equations.linear.loads.iter().for_each(|&(k, load)| forces[k as usize] += load);
    for &MatrixEntry { row, column, value } in &equations.linear.entries {
        forces[row as usize] -= value * velocity[column as usize];
    }
    forces
}
