//! The solids as the fixed mesh sees them: elements that they cover or cut, and their velocity at the nodes inside
//! (theory J.2, J.3).

use super::assemble::CutParts;
use super::element::CoupledElement;
use super::fluid_part::FluidPart;
use super::trace::{CutMesh, TracePoint};
use super::viscous::{CutForces, cut_forces, cut_power};
use crate::math::Vector;
use crate::mesh::Mesh;
use crate::parallel;
use crate::pfem2::boundary::Constraints;
use crate::pfem2::cut_element::{Medium, volume_fraction};
use crate::pfem2::element::{Content, Equations};
use crate::pfem2::solid::cut::{ElementState, FluidSimplex, SolidCut, Vertex};
use crate::pfem2::solid::equations::SolidEquations;
use std::collections::BTreeMap;

/// Solids in the mesh of the fluid.
#[derive(Debug, Clone)]
pub struct Immersed<const D: usize, const N: usize> {
    /// The mesh cut by their surfaces.
    pub cut: SolidCut<D, N>,
    /// Points of the surface in each cut element, in their order.
    pub traces: Vec<Vec<TracePoint<D, N>>>,
    /// Equations of the cut elements, in their order.
    pub elements: Vec<CoupledElement<D, N>>,
    /// Velocity of the nodes of all solids at the end of the last step [m/s]: the unknowns, axis by axis.
    pub velocity: Vec<f64>,
    /// The independent ones of these; before the system is solved, their guess.
    pub independent: Vec<f64>,
    /// Their convected velocity v̂ [m/s].
    pub velocity_hat: Vec<Vector<D>>,
    /// Their equations without the terms of the fluid; none before the first step.
    pub equations: Option<SolidEquations>,
    /// The largest density of elastic solids [kg/m³]; zero without one.
    pub density: f64,
}

/// A mass at a place of the fluid.
#[derive(Debug, Clone, Copy)]
pub struct PointMass<const D: usize> {
    /// Mass [kg].
    pub mass: f64,
    /// Its place [m].
    pub position: Vector<D>,
    /// Its velocity [m/s].
    pub velocity: Vector<D>,
}

impl<const D: usize, const N: usize> Immersed<D, N> {
    /// Solids whose nodes have this velocity and convected velocity [m/s], and these equations.
    pub fn new(
        CutMesh { cut, trace }: CutMesh<D, N>,
        velocity: &[Vector<D>],
        velocity_hat: Vec<Vector<D>>,
        equations: Option<SolidEquations>,
        density: f64,
    ) -> Self {
        let velocity = velocity.iter().flat_map(|v| v.0).collect();
        let guess = equations.iter().flat_map(|equations| equations.velocities.guess());
        let traces = trace.by_element(cut.elements.len());
        Self {
            density,
            cut,
            traces,
            elements: Vec::new(),
            velocity,
            independent: guess.copied().collect(),
            velocity_hat,
            equations,
        }
    }

    /// True for places of an element that belong to the fluid, by the distance of its nodes to the surface.
    #[inline]
    pub fn is_fluid(&self, mesh: &Mesh<D, N>, element: usize, shape: &[f64; N]) -> bool {
        match self.cut.state[element] {
            ElementState::Fluid => true,
            ElementState::Solid => false,
            ElementState::Cut(_) => {
                let distance = mesh.elements()[element].map(|node| self.cut.distance[node as usize]);
                distance.iter().zip(shape).filter(|(_, n)| **n != 0.0).map(|(d, n)| d * n).sum::<f64>() > 0.0
            }
        }
    }

    /// True for elements that hold fluid.
    pub(in crate::pfem2::solid) fn has_fluid(&self, element: usize) -> bool {
        !matches!(self.cut.state[element], ElementState::Solid)
    }

    /// Assembles the equations of the cut elements, given the fluids in each (theory J.3).
    pub fn fill(&mut self, mesh: &Mesh<D, N>, equations: &Equations, fluids: &[FluidPart<D, N>]) {
        let SolidCut { elements, points, .. } = &self.cut;
        let hat = &self.velocity_hat;
        self.elements = parallel::collect(elements.len(), 16, |place| {
            let own = CutParts { cut: &elements[place], trace: &self.traces[place], points };
            CoupledElement::new(mesh, &own, &fluids[place], equations, hat)
        });
    }

    /// Viscous forces of a medium in the fluid part of a cut element on its nodes, at these nodal velocities [m/s] and
    /// that of the solids at the end of the last step.
    pub fn viscous_forces(
        &self,
        mesh: &Mesh<D, N>,
        place: usize,
        medium: Medium,
        velocity: &[Vector<D>],
    ) -> CutForces<D, N> {
        let SolidCut { elements, points, .. } = &self.cut;
        cut_forces(mesh, &elements[place], points, medium, [&|i| velocity[i], &|a| self.velocity_of(a)])
    }

    /// ∫2μ d:d over the fluid part of a cut element, at these nodal velocities [m/s] and that of the solids at the end
    /// of the last step [W]; `viscosity` is that of the fluid times its part of the element [Pa s].
    pub fn viscous_power(&self, mesh: &Mesh<D, N>, place: usize, viscosity: f64, velocity: &[Vector<D>]) -> f64 {
        let SolidCut { elements, points, .. } = &self.cut;
        let cut = &elements[place];
        if cut.volume_fraction <= 0.0 {
            return 0.0;
        }
        viscosity / cut.volume_fraction * cut_power(mesh, cut, points, [&|i| velocity[i], &|a| self.velocity_of(a)])
    }

    /// Masses of the fluid in a cut element with their places and velocities, at its nodes and cut points, at these
    /// nodal velocities [m/s] and that of the solids at the end of the last step; `None` for other elements.
    pub fn masses(
        &self,
        mesh: &Mesh<D, N>,
        element: usize,
        velocity: &[Vector<D>],
    ) -> Option<impl Iterator<Item = PointMass<D>>> {
        let ElementState::Cut(place) = self.cut.state[element] else { return None };
        let own = self.elements.get(place as usize)?;
        let points = &self.cut.elements[place as usize].points;
        let of_node = mesh.elements()[element].map(|node| (mesh.nodes()[node as usize], velocity[node as usize]));
        let of_point = points.iter().map(move |&c| {
            let point = &self.cut.points[c as usize];
            (point.position, point.velocity(&|i| velocity[i], &|a| self.velocity_of(a)))
        });
        let vertices = own.vertex_mass.iter().zip(of_node.into_iter().chain(of_point));
        Some(vertices.map(|(&mass, (position, velocity))| PointMass { mass, position, velocity }))
    }

    /// Reduces the content of an element, masses and viscosity, to that of its fluid part.
    pub fn reduce(&self, element: usize, content: &mut Content<N>) {
        match self.cut.state[element] {
            ElementState::Fluid => {}
            ElementState::Solid => {
                *content = Content { mass: [0.0; N], viscosity: 0.0, volume_over_density: 0.0, ..*content }
            }
            ElementState::Cut(place) => *content = self.elements[place as usize].content,
        }
    }

    /// Prescribes unknowns without an equation: velocities of nodes inside, and pressures of nodes with no fluid (of
    /// their own side of an interface) around them. `base` are the prescribed unknowns of the boundary.
    pub fn constrain(&self, mesh: &Mesh<D, N>, base: &[u8], constraints: &mut Constraints<D, N>) {
        constraints.mask.copy_from_slice(base);
        for inside in &self.cut.inside {
            let node = inside.node as usize;
            let acts = |e: &u32| self.pressure_acts(*e as usize, &mesh.elements()[*e as usize], inside.node);
            let dry = !mesh.elements_around(node).iter().any(acts);
            let new = ((1 << D) - 1) | u8::from(dry) << D;
            for k in (0..N).filter(|k| new & !base[node] & (1 << k) != 0) {
                constraints.value[node][k] = 0.0;
            }
            constraints.mask[node] |= new;
        }
    }

    /// True for a node inside whose pressure on each side of the solid follows from those of the nodes outside.
    pub(in crate::pfem2::solid) fn has_two_sides(&self, mesh: &Mesh<D, N>, node: u32) -> bool {
        let is_two_sided = |e: &u32| match self.cut.state[*e as usize] {
            ElementState::Cut(place) => {
                let own = &self.cut.elements[place as usize];
                own.nodes_of_two_sides().any(|k| own.nodes[k] == node)
            }
            _ => false,
        };
        mesh.elements_around(node as usize).iter().any(is_two_sided)
    }

    /// The pressures of the nodes of an element in its fluid, given those of the nodes of the mesh [Pa].
    pub fn pressures(&self, element: usize, nodal: [f64; N]) -> [f64; N] {
        match self.cut.state[element] {
            ElementState::Cut(place) => self.elements[place as usize].pressures(nodal),
            _ => nodal,
        }
    }

    /// Sets the pressure of nodes inside with fluid on several sides, which acts nowhere, to the mean of those of the
    /// sides by the volume of the fluid beside it [Pa]: for outputs.
    pub fn show_pressure_of_sides(&self, mesh: &Mesh<D, N>, constraints: &Constraints<D, N>, nodal: &mut [f64]) {
        let mut sums: BTreeMap<u32, (f64, f64)> = BTreeMap::new();
        for (element, cut) in self.elements.iter().zip(&self.cut.elements) {
            let own = element.pressures(cut.nodes.map(|node| nodal[node as usize]));
            let volume = cut.volume_fraction * mesh.simplex(cut.element as usize).volume;
            for k in element.one_sided() {
                let (sum, all) = sums.entry(cut.nodes[k]).or_default();
                (*sum, *all) = (*sum + own[k] * volume, *all + volume);
            }
        }
        let acts = |node: u32| constraints.mask[node as usize] >> D & 1 == 0;
        let shown = sums.into_iter().filter(|(node, (_, all))| !acts(*node) && *all > 0.0);
        shown.for_each(|(node, (sum, all))| nodal[node as usize] = sum / all);
    }

    /// True if the pressure of a node acts in an element.
    fn pressure_acts(&self, element: usize, nodes: &[u32; N], node: u32) -> bool {
        match self.cut.state[element] {
            ElementState::Fluid => true,
            ElementState::Solid => false,
            ElementState::Cut(place) => {
                let own = &self.elements[place as usize];
                nodes.iter().zip(own.tied).any(|(&other, tied)| other == node && tied)
            }
        }
    }

    /// Sets the velocity of nodes inside to that of the solid there [m/s]; along surfaces with slip plus the tangential
    /// velocity of the nodes outside relative to the solid, in the mean over the cut edges.
    pub fn extend(&self, solid: impl Fn(usize) -> Vector<D>, nodal: &mut [Vector<D>]) {
        for inside in &self.cut.inside {
            nodal[inside.node as usize] = inside.weights.iter().map(|&(a, w)| solid(a as usize) * w).sum();
        }
        let mut gliding: BTreeMap<u32, (Vector<D>, f64)> = BTreeMap::new();
        for point in &self.cut.points {
            let Some((along, [outside, inside])) = point.velocity_weights().node.zip(point.edge) else { continue };
            let (sum, count) = gliding.entry(inside).or_default();
            *sum += along.apply(nodal[outside as usize] - nodal[inside as usize]);
            *count += 1.0;
        }
        gliding.into_iter().for_each(|(inside, (sum, count))| nodal[inside as usize] += sum / count);
    }

    /// Mean of v − v̂ over the fluid of a cut element [m/s], given its values `gained` at the nodes of the mesh; zero
    /// without fluid.
    pub fn mean_of_fluid(&self, element: usize, gained: &dyn Fn(usize) -> Vector<D>) -> Vector<D> {
        let ElementState::Cut(place) = self.cut.state[element] else { return Vector::ZERO };
        let own = &self.cut.elements[place as usize];
        let of_solid = |a: usize| self.velocity_of(a) - self.velocity_hat[a];
        let at = |vertex: Vertex| match vertex {
            Vertex::Node(k) => gained(own.nodes[usize::from(k)] as usize),
            Vertex::Point(k) => self.cut.points[own.points[usize::from(k)] as usize].velocity(gained, &of_solid),
        };
        let part = |(part, shape): (&FluidSimplex<N>, &[[f64; N]; N])| {
            part.vertices.map(at).into_iter().sum::<Vector<D>>() * (volume_fraction(shape) / N as f64)
        };
        let sum = own.parts.iter().zip(&own.shapes).map(part).sum::<Vector<D>>();
        if own.volume_fraction > 0.0 { sum / own.volume_fraction } else { Vector::ZERO }
    }

    /// Velocity of a node of a solid at the end of the last step [m/s].
    pub fn velocity_of(&self, node: usize) -> Vector<D> {
        Vector::from_fn(|r| self.velocity[node * D + r])
    }

    /// Forces of the fluid on the nodes of solids [N], where the nodes of the mesh have the unknowns `x`.
    pub fn forces(&self, mesh: &Mesh<D, N>, x: &[[f64; N]]) -> Vec<Vector<D>> {
        let mut forces = vec![Vector::ZERO; self.velocity_hat.len()];
        for element in &self.elements {
            let own = mesh.elements()[element.element as usize].map(|node| x[node as usize]);
            for (place, &a) in element.solid.iter().enumerate() {
                forces[a as usize] += element.force(place, &own, &self.velocity);
            }
        }
        forces
    }
}
