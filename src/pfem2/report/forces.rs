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
use crate::mesh::Mesh;
use crate::parallel;
use crate::pfem2::boundary::{Boundary, BoundaryKind};
use crate::pfem2::equations::assemble::ElementEquations;
use crate::pfem2::equations::system::{TimeStep, VelocityPressureSystem};
use crate::pfem2::time::history::StepShares;
use std::collections::BTreeMap;

/// A part of the boundary that holds the fluid.
#[derive(Debug, Clone)]
pub(in crate::pfem2) struct BoundaryPart<const D: usize> {
    /// Name of its set.
    pub name: String,
    /// Nodes and the share of their reaction that belongs to the part.
    nodes: Vec<(u32, Vector<D>)>,
}

/// The parts of a boundary that hold the fluid: walls, slip planes, inlets.
fn parts<const D: usize, const N: usize>(mesh: &Mesh<D, N>, boundary: &Boundary<D>) -> Vec<BoundaryPart<D>> {
    let holds = |kind: BoundaryKind| kind != BoundaryKind::Outlet;
    let mut areas: Vec<BTreeMap<u32, Vector<D>>> = Vec::new();
    let mut total: BTreeMap<u32, Vector<D>> = BTreeMap::new();
    for set in boundary.sets() {
        let mut own = BTreeMap::new();
        let kind = set.condition.kind();
        for &facet in set.facets.iter().filter(|_| holds(kind)) {
            let area = mesh.facet_area(facet);
            let area = if kind == BoundaryKind::Slip { area.map(f64::abs) } else { Vector::splat(area.norm()) };
            for node in mesh.facet_nodes(facet) {
                *own.entry(node).or_default() += area;
                *total.entry(node).or_default() += area;
            }
        }
        areas.push(own);
    }
    let share = |own: Vector<D>, all: Vector<D>| {
        Vector::from_fn(|axis| if all[axis] > 0.0 { own[axis] / all[axis] } else { 0.0 })
    };
    let named = boundary.sets().iter().zip(areas).filter(|(_, own)| !own.is_empty());
    named
        .map(|(set, own)| {
            let nodes = own.into_iter().map(|(node, area)| (node, share(area, total[&node]))).collect();
            BoundaryPart { name: set.name.clone(), nodes }
        })
        .collect()
}

/// Forces of the fluid on the parts of a boundary [N].
#[derive(Debug, Clone)]
pub(in crate::pfem2) struct BoundaryForces<const D: usize> {
    /// The parts.
    pub parts: Vec<BoundaryPart<D>>,
    /// At the end of the last step.
    pub last: Vec<Vector<D>>,
    /// At the end of the step before.
    pub previous: Vec<Vector<D>>,
    /// Means over the last step, with the shares that the step takes of each.
    pub mean: Vec<Vector<D>>,
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
    pub fn new<const N: usize>(system: &VelocityPressureSystem<D, N>) -> Self {
        let parts = parts(&system.mesh, &system.boundary);
        let none = vec![Vector::ZERO; parts.len()];
        Self { parts, last: none.clone(), previous: none.clone(), mean: none }
    }

    /// Takes the forces at the end of a step with its `shares`.
    pub fn update<const N: usize>(
        &mut self,
        system: &VelocityPressureSystem<D, N>,
        step: TimeStep,
        convected: &[Vector<D>],
        shares: StepShares,
    ) -> BoundaryAction<D> {
        let (now, action) = self.measure(system, step, convected);
        let all = self.previous.iter().zip(&self.last).zip(&now);
        self.mean = all.map(|((f0, f1), f2)| *f0 * shares.earlier + *f1 * shares.start + *f2 * shares.end).collect();
        self.previous = std::mem::replace(&mut self.last, now);
        action
    }

    /// Takes the forces at the end of a step as those of all steps before.
    pub fn begin<const N: usize>(
        &mut self,
        system: &VelocityPressureSystem<D, N>,
        step: TimeStep,
        convected: &[Vector<D>],
    ) -> BoundaryAction<D> {
        let (now, action) = self.measure(system, step, convected);
        self.last = now;
        self.previous.clone_from(&self.last);
        action
    }

    /// The forces on the parts, and the action of the boundary on the fluid, at the end of a step.
    fn measure<const N: usize>(
        &self,
        system: &VelocityPressureSystem<D, N>,
        step: TimeStep,
        convected: &[Vector<D>],
    ) -> (Vec<Vector<D>>, BoundaryAction<D>) {
        let VelocityPressureSystem { mesh, boundary, velocity, .. } = system;
        let elements = system.elements(convected);
        let (mut force, mut power) = (Vector::<D>::ZERO, 0.0);
        let mut loads = vec![Vector::ZERO; velocity.len()];
        boundary.load(mesh, step.end(), |node, traction| {
            force += traction;
            power += traction.dot(velocity[node]);
            loads[node] += traction;
        });
        let on_part = |part: &BoundaryPart<D>| part.force(&elements, &loads, &system.unknowns);
        let reactions: Vec<_> = self.parts.iter().map(on_part).collect();
        for (reaction, work) in &reactions {
            force -= *reaction;
            power += work;
        }
        open_boundary_load(&elements, velocity, |node, traction| {
            force += traction;
            power += traction.dot(velocity[node]);
        });
        (reactions.into_iter().map(|(reaction, _)| reaction).collect(), BoundaryAction { force, power })
    }
}

impl<const D: usize> BoundaryPart<D> {
    /// The force of the fluid on the part [N], and the power with which the part drives the fluid [W]; `loads` are those of
    /// the boundary on the nodes [N].
    pub fn force<const N: usize>(
        &self,
        elements: &ElementEquations<D, N>,
        loads: &[Vector<D>],
        unknowns: &[[f64; N]],
    ) -> (Vector<D>, f64) {
        let push = |n: usize| {
            let (node, share) = self.nodes[n];
            let push = elements.nodal_force(node as usize, |i| unknowns[i]) + loads[node as usize];
            let push = Vector::from_fn(|axis| push[axis] * share[axis]);
            let velocity = Vector::from_fn(|r| unknowns[node as usize][r]);
            (push, -push.dot(velocity))
        };
        let pushes: Vec<(Vector<D>, f64)> = parallel::collect(self.nodes.len(), 64, push);
        pushes.iter().fold((Vector::ZERO, 0.0), |(force, power), (f, p)| (force + *f, power + p))
    }
}

/// Adds the tractions μ (∇v)ᵀ n + ½ρ (v·n)₋ v of the open facets to the nodal forces [N].
fn open_boundary_load<const D: usize, const N: usize>(
    elements: &ElementEquations<D, N>,
    velocity: &[Vector<D>],
    mut add: impl FnMut(usize, Vector<D>),
) {
    let mesh = elements.mesh;
    for e in (0..elements.open.len()).filter(|&e| elements.open[e] != 0 && elements.with_solid(e).is_none()) {
        let (simplex, nodes) = (mesh.simplex(e), mesh.elements()[e].map(|node| node as usize));
        for k in (0..N).filter(|&k| elements.open[e] >> k & 1 == 1) {
            let area = simplex.facet_area(k) * (elements.contents[e].viscosity / D as f64);
            let share = (0..N).map(|j| simplex.gradient[j] * velocity[nodes[j]].dot(area)).sum::<Vector<D>>();
            (0..N).filter(|&i| i != k).for_each(|i| add(nodes[i], share));
        }
        (0..N).for_each(|i| add(nodes[i], velocity[nodes[i]] * -elements.back(e, i)));
    }
}
