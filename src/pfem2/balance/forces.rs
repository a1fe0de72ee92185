//! Forces of the fluid on named parts of the boundary, as consistent nodal reactions (theory (F.38)).
//!
//! ```text
//! F = Σ_{i on the part} (f_i + t_i − Σ_j A_ij x_j)   the rows of the momentum equations that were replaced, with the loads t
//!                                                     of an open boundary that meets the part there
//! ```
//!
//! Gresho & Lee 1981: these are as accurate as the solution's energy, unlike stresses summed over facets, and with
//! them the momentum balance of the mesh closes to round-off. A node of several parts is shared by facet areas, axis by
//! axis: of a slip plane only its area across the axis counts, since nothing holds the fluid along it.

use crate::math::Vector;
use crate::mesh::{Facet, Mesh};
use crate::parallel;
use crate::pfem2::ThetaStep;
use crate::pfem2::boundary::{Boundary, BoundarySetup};
use crate::pfem2::equations::assemble::ElementEquations;
use crate::pfem2::equations::system::VelocityPressureSystem;
use crate::pfem2::history::StepWeights;
use crate::pfem2::moments::{self, ForcedPart, MomentPoint, StepMeans};
use std::collections::BTreeMap;

/// A part of the boundary that holds the fluid.
#[derive(Debug, Clone)]
pub(in crate::pfem2) struct BoundaryPart<const D: usize> {
    /// Name of its set.
    pub name: String,
    /// Place of its set.
    set: usize,
    /// Point about which its force has a moment [m].
    pub about: Option<Vector<D>>,
    /// Nodes and the fractions of their reactions that belong to the part, by axis.
    nodes: Vec<(u32, Vector<D>)>,
}

/// The parts of a boundary that hold the fluid: walls, slip planes, inlets.
fn parts<const D: usize, const N: usize>(mesh: &Mesh<D, N>, boundary: &Boundary<D>) -> Vec<BoundaryPart<D>> {
    let mut areas: Vec<BTreeMap<u32, Vector<D>>> = Vec::new();
    let mut total: BTreeMap<u32, Vector<D>> = BTreeMap::new();
    for set in boundary.sets() {
        let mut own = BTreeMap::new();
        let kind = set.condition.kind();
        for &facet in set.facets.iter().filter(|_| kind.carries_reaction()) {
            let area = mesh.facet_area(facet);
            let area = if kind.is_frictionless() { area.map(f64::abs) } else { Vector::splat(area.norm()) };
            for node in mesh.facet_nodes(facet) {
                *own.entry(node).or_default() += area;
                *total.entry(node).or_default() += area;
            }
        }
        areas.push(own);
    }
    let fraction = |own: Vector<D>, all: Vector<D>| {
        Vector::from_fn(|axis| if all[axis] > 0.0 { own[axis] / all[axis] } else { 0.0 })
    };
    let named = boundary.sets().iter().zip(areas).enumerate().filter(|(_, (_, own))| !own.is_empty());
    named
        .map(|(set, (BoundarySetup { name, .. }, own))| {
            let nodes = own.into_iter().map(|(node, area)| (node, fraction(area, total[&node]))).collect();
            BoundaryPart { name: name.clone(), set, about: None, nodes }
        })
        .collect()
}

/// Forces of the fluid on the parts of a boundary [N].
#[derive(Debug, Clone)]
pub(in crate::pfem2) struct BoundaryForces<const D: usize> {
    /// The parts.
    pub parts: Vec<BoundaryPart<D>>,
    /// On each part.
    pub on_parts: StepMeans<D>,
    /// Moments, about the points of the parts.
    pub moments: StepMeans<3>,
}

/// The force of the fluid on a part, its moment, and the power with which the part drives the fluid.
#[derive(Debug, Clone, Copy, Default)]
pub(in crate::pfem2) struct PartAction<const D: usize> {
    /// Force [N].
    pub force: Vector<D>,
    /// Its moment about the point of the part, or the origin [N m].
    pub moment: Vector<3>,
    /// Power [W].
    pub power: f64,
}

/// Sum of the forces on the fluid from its boundary, and their power.
#[derive(Debug, Clone, Copy)]
pub(in crate::pfem2) struct BoundaryAction<const D: usize> {
    /// Force of tractions and supports on the fluid [N].
    pub force: Vector<D>,
    /// Power of both [W].
    pub power: f64,
}

impl<const D: usize> BoundaryForces<D> {
    /// Of a fluid that begins.
    pub fn new<const N: usize>(system: &VelocityPressureSystem<D, N>, moments: &[MomentPoint<D>]) -> Self {
        let mut parts = parts(&system.mesh, &system.boundary);
        let sets: Vec<usize> = parts.iter().map(|part| part.set).collect();
        let about = moments::points(moments, parts.len(), |k| ForcedPart::Boundary(sets[k]));
        parts.iter_mut().zip(about).for_each(|(part, about)| part.about = about);
        let (on_parts, moments) = (StepMeans::none(parts.len()), StepMeans::none(parts.len()));
        Self { parts, on_parts, moments }
    }

    /// Takes the forces at the end of a step with its `step_weights`.
    pub fn update<const N: usize>(
        &mut self,
        system: &VelocityPressureSystem<D, N>,
        step: ThetaStep,
        convected: &[Vector<D>],
        step_weights: StepWeights,
    ) -> BoundaryAction<D> {
        let (parts, action) = self.measure(system, step, convected);
        self.on_parts.update(parts.iter().map(|part| part.force).collect(), step_weights);
        self.moments.update(parts.iter().map(|part| part.moment).collect(), step_weights);
        action
    }

    /// Takes the forces at the end of a step as those of all steps before.
    pub fn begin<const N: usize>(
        &mut self,
        system: &VelocityPressureSystem<D, N>,
        step: ThetaStep,
        convected: &[Vector<D>],
    ) -> BoundaryAction<D> {
        let (parts, action) = self.measure(system, step, convected);
        self.on_parts.begin(parts.iter().map(|part| part.force).collect());
        self.moments.begin(parts.iter().map(|part| part.moment).collect());
        action
    }

    /// The forces on the parts, and the action of the boundary on the fluid, at the end of a step.
    fn measure<const N: usize>(
        &self,
        system: &VelocityPressureSystem<D, N>,
        step: ThetaStep,
        convected: &[Vector<D>],
    ) -> (Vec<PartAction<D>>, BoundaryAction<D>) {
        let VelocityPressureSystem { mesh, boundary, velocity, .. } = system;
        let elements = system.elements(convected);
        let (mut force, mut power) = (Vector::<D>::ZERO, 0.0);
        let mut loads = vec![Vector::ZERO; velocity.len()];
        boundary.load(
            mesh,
            step.end(),
            |element| system.is_whole(element),
            |node, traction| {
                force += traction;
                power += traction.dot(velocity[node]);
                loads[node] += traction;
            },
        );
        let beside_solids = action_of_openings_beside_solids(system);
        force += beside_solids.force;
        power += beside_solids.power;
        let on_part = |part: &BoundaryPart<D>| part.action(&elements, &loads, &system.linear.unknowns);
        let mut reactions: Vec<_> = self.parts.iter().map(on_part).collect();
        self.add_feet(system, &mut reactions);
        for reaction in &reactions {
            force -= reaction.force;
            power += reaction.power;
        }
        open_boundary_load(&elements, velocity, |node, traction| {
            force += traction;
            power += traction.dot(velocity[node]);
        });
        (reactions, BoundaryAction { force, power })
    }
}

impl<const D: usize> BoundaryForces<D> {
    /// Adds the pressure on walls beside the ends of the surfaces of solids, which no node of the mesh takes up
    /// (theory (J.9c)).
    fn add_feet<const N: usize>(&self, system: &VelocityPressureSystem<D, N>, actions: &mut [PartAction<D>]) {
        let VelocityPressureSystem { mesh, boundary, linear, .. } = system;
        let elements = system.immersed.iter().flat_map(|immersed| &immersed.elements);
        for (element, wall) in elements.flat_map(|own| own.on_walls.iter().map(move |wall| (own.element, wall))) {
            let set = boundary.set_of(mesh, Facet { element, opposite: wall.facet });
            let Some(part) = self.parts.iter().position(|part| Some(part.set) == set) else { continue };
            let nodes = mesh.elements()[element as usize].iter().zip(wall.area);
            let push = nodes.map(|(&node, area)| area * linear.unknowns[node as usize][D]).sum::<Vector<D>>();
            let arm = wall.position - self.parts[part].about.unwrap_or_default();
            actions[part].force += push;
            actions[part].moment += moments::moment(arm, push);
        }
    }
}

impl<const D: usize> BoundaryPart<D> {
    /// The action of the fluid on the part; `loads` are those of the boundary on the nodes [N].
    pub fn action<const N: usize>(
        &self,
        elements: &ElementEquations<D, N>,
        loads: &[Vector<D>],
        unknowns: &[[f64; N]],
    ) -> PartAction<D> {
        let about = self.about.unwrap_or_default();
        let push = |n: usize| {
            let (node, fraction) = self.nodes[n];
            let push = elements.nodal_force(node as usize, |i| unknowns[i]) + loads[node as usize];
            let push = Vector::from_fn(|axis| push[axis] * fraction[axis]);
            let velocity = Vector::from_fn(|r| unknowns[node as usize][r]);
            let arm = elements.mesh.nodes()[node as usize] - about;
            PartAction { force: push, moment: moments::moment(arm, push), power: -push.dot(velocity) }
        };
        let pushes: Vec<PartAction<D>> = parallel::collect(self.nodes.len(), 64, push);
        pushes.iter().fold(PartAction::default(), |sum, own| PartAction {
            force: sum.force + own.force,
            moment: sum.moment + own.moment,
            power: sum.power + own.power,
        })
    }
}

/// Force and power of the tractions on the openings that solids meet (theory (J.9d)).
fn action_of_openings_beside_solids<const D: usize, const N: usize>(
    system: &VelocityPressureSystem<D, N>,
) -> BoundaryAction<D> {
    let mut sum = BoundaryAction { force: Vector::ZERO, power: 0.0 };
    let Some(immersed) = &system.immersed else { return sum };
    for own in &immersed.elements {
        let nodes = &system.mesh.elements()[own.element as usize];
        let of_node = |i: usize| system.velocity[nodes[i] as usize];
        let (force, power) = own.action_of_openings(of_node, |a| immersed.velocity_of(a as usize));
        sum.force += force;
        sum.power += power;
    }
    sum
}

/// Adds the tractions μ (∇v)ᵀ n + ½ρ (v·n)₋ v of the open facets to the nodal forces [N].
fn open_boundary_load<const D: usize, const N: usize>(
    elements: &ElementEquations<D, N>,
    velocity: &[Vector<D>],
    mut add: impl FnMut(usize, Vector<D>),
) {
    let mesh = elements.mesh;
    let whole = |e: &usize| elements.with_solid(*e).is_none() && elements.beside_solid(*e).is_none();
    for e in (0..elements.mesh_data.outlets.len()).filter(|&e| elements.mesh_data.outlets[e] != 0).filter(whole) {
        let (simplex, nodes) = (mesh.simplex(e), mesh.elements()[e].map(|node| node as usize));
        for k in (0..N).filter(|&k| elements.mesh_data.outlets[e] >> k & 1 == 1) {
            let area = simplex.facet_area(k) * (elements.contents.elements[e].viscosity / D as f64);
            let force = (0..N).map(|j| simplex.gradient[j] * velocity[nodes[j]].dot(area)).sum::<Vector<D>>();
            (0..N).filter(|&i| i != k).for_each(|i| add(nodes[i], force));
        }
        (0..N).for_each(|i| add(nodes[i], velocity[nodes[i]] * -elements.back(e, i)));
    }
}
