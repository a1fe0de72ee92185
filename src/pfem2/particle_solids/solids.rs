//! The solids on particles in the system of velocity and pressure: the elements that hold them, and the forces on them
//! (theory K.4–K.6).
//!
//! ```text
//! nodes of solid and of fluid                       cut: a pressure on each side                          theory K.5
//! all nodes of solid                                solid, r = 2/Δt                                       theory K.4
//! particles of solids elsewhere, or several solids  not split: V_s = V n_s/n_e, one continuous pressure   theory (K.9)
//! ```

use super::averages::{ElementSums, NodalAverages};
use super::element::{ElementIntegrals, ElementLoads, NodalSolution, SolidElement, SolidPart, SplitPressure};
use super::setup::{ParticleSolidSetup, RateLaw};
use crate::math::{Signal, Vector};
use crate::mesh::Mesh;
use crate::parallel;
use crate::pfem2::boundary::Constraints;
use crate::pfem2::cut_element::{CutGeometry, Medium};
use crate::pfem2::element::{self, Content, Drive, Equations, Mass};
use crate::pfem2::phases::{Filling, Phases};

/// An element without solid.
const NONE: u32 = u32::MAX;

/// The pressures p̂* with which cut elements begin a step.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum GhostPressures<const N: usize> {
    /// Means of the nodes of each side (the paper).
    #[default]
    Means,
    /// Given by element [Pa]: where particles stay where they are, those that the step before has left.
    Given(Vec<[f64; N]>),
}

/// Solids on particles.
#[derive(Debug, Clone)]
pub struct ParticleSolids<const D: usize, const N: usize> {
    /// The solids, in the order of their phases.
    pub setups: Vec<ParticleSolidSetup<D>>,
    /// The phase of the first; those before are fluids.
    pub first: usize,
    /// Density of the fluid [kg/m³].
    pub fluid_density: f64,
    /// Pressures with which cut elements begin.
    pub ghosts: GhostPressures<N>,
    /// Averages at the nodes.
    pub nodal: NodalAverages<D>,
    /// Sums by element.
    pub sums: Vec<ElementSums<D, N>>,
    /// Elements that hold solid.
    pub elements: Vec<SolidElement<D, N>>,
    /// Force of the fluid on each solid at the end of the last step [N].
    pub forces: Vec<Vector<D>>,
    /// Volume that the mesh shows of them at the start [m³].
    pub start_volume: f64,
    /// The place of each element in `elements`, or [`NONE`].
    place: Vec<u32>,
}

/// Filling of an element that isn't cut.
struct Mixture {
    /// Part of its volume that is solid.
    solid_fraction: f64,
    /// Shear modulus of that [Pa].
    shear: f64,
    /// 1/κ of that [1/Pa].
    compliance: f64,
    /// Density of the solid [kg/m³].
    solid_density: f64,
    /// Mean density [kg/m³].
    density: f64,
}

/// Content of an element that holds solid.
struct SolidFilling<const D: usize, const N: usize> {
    /// Number of the solid.
    solid: usize,
    part: SolidPart<D, N>,
    /// Pressures of the two sides, if the element is cut.
    split: Option<SplitPressure<N>>,
    /// τ V_f of the fluid in it [m³ s].
    diffused: f64,
}

/// The fluid as the equations of an element with solid need it.
pub struct SurroundingFluid<'a, const D: usize, const N: usize> {
    /// The mesh.
    pub mesh: &'a Mesh<D, N>,
    /// Constants of the step.
    pub equations: Equations,
    /// Body force and v̂ at the nodes of an element.
    pub drive: &'a (dyn Fn(usize) -> Drive<D, N> + Sync),
    /// Viscosity of the fluid in an element [Pa s].
    pub viscosity: &'a (dyn Fn(usize) -> f64 + Sync),
    /// Stabilisation time of an element with such a content [s].
    pub tau: &'a (dyn Fn(usize, Medium) -> f64 + Sync),
}

impl<const D: usize, const N: usize> ParticleSolids<D, N> {
    /// Solids whose phases follow those of `first` fluids, the first of which has a density [kg/m³].
    pub fn new(setups: Vec<ParticleSolidSetup<D>>, first: usize, fluid_density: f64) -> Self {
        Self {
            forces: vec![Vector::ZERO; setups.len()],
            start_volume: 0.0,
            setups,
            first,
            fluid_density,
            ghosts: GhostPressures::default(),
            nodal: NodalAverages::default(),
            sums: Vec::new(),
            elements: Vec::new(),
            place: Vec::new(),
        }
    }

    /// The law of a phase, if it is a solid.
    pub fn law_of(&self, phase: u8) -> Option<&RateLaw> {
        usize::from(phase).checked_sub(self.first).map(|solid| &self.setups[solid].law)
    }

    /// The equations of an element, if it holds solid.
    #[inline]
    pub fn of(&self, element: usize) -> Option<&SolidElement<D, N>> {
        self.elements.get(*self.place.get(element)? as usize)
    }

    /// Pressures whose interpolation holds in an element on the side of a solid, or of the fluid, from those of its
    /// nodes [Pa].
    pub fn pressures_in(&self, element: usize, nodal: [f64; N], solid: bool) -> [f64; N] {
        let split = self.of(element).and_then(|own| own.split.as_ref());
        split.map_or(nodal, |split| split.on_side(nodal, solid))
    }

    /// Makes the equations of the elements that hold solid, and their contents; others keep theirs.
    pub fn fill(&mut self, around: &SurroundingFluid<'_, D, N>, phases: &Phases, contents: &mut [Content<N>]) {
        let made = parallel::collect_some(contents.len(), 256, |e| self.element(around, phases, e));
        self.place = vec![NONE; contents.len()];
        self.elements.clear();
        for (place, (element, content)) in (0u32..).zip(made) {
            let e = element.element as usize;
            (self.place[e], contents[e]) = (place, content);
            self.elements.push(element);
        }
    }

    /// The element `e`, if it holds solid.
    fn element(
        &self,
        around: &SurroundingFluid<'_, D, N>,
        phases: &Phases,
        e: usize,
    ) -> Option<(SolidElement<D, N>, Content<N>)> {
        let nodes = &around.mesh.elements()[e];
        let solid = nodes.iter().map(|&node| phases.at(node as usize)).find(|&phase| phase >= self.first);
        let solid = solid.or_else(|| self.sums[e].solid.map(usize::from))? - self.first;
        match phases.filling(nodes) {
            Filling::Cut([a, b], level) if a >= self.first && b < self.first => Some(self.cut(around, level, e, solid)),
            _ => Some(self.unsplit(around, e, solid)),
        }
    }

    /// An element that isn't cut: solid, or a mixture (theory K.4, (K.9)).
    fn unsplit(&self, around: &SurroundingFluid<'_, D, N>, e: usize, solid: usize) -> (SolidElement<D, N>, Content<N>) {
        let (volume, dt) = (around.mesh.simplex(e).volume, around.equations.delta);
        let nodes = around.mesh.elements()[e].map(|node| node as usize);
        let Mixture { solid_fraction, shear, compliance, solid_density, density } = self.mixture(e, solid);
        let is_solid = self.sums[e].count[1] > 0.0 && nodes.iter().all(|&i| self.nodal.solid[i]);
        let (of_fluid, corner) = (1.0 - solid_fraction, volume / N as f64);
        let viscosity = if of_fluid > 0.0 { (around.viscosity)(e) * of_fluid } else { 0.0 };
        let content = self.content(e, volume, density, viscosity);
        let medium = Medium { density, viscosity: viscosity + shear * dt * solid_fraction };
        let tau = if of_fluid > 0.0 { (around.tau)(e, medium) } else { 0.0 };
        let mass = |i, j| element::mass(&content, around.equations.mass, (i, j));
        let integrals = ElementIntegrals {
            mass: std::array::from_fn(|i| std::array::from_fn(|j| mass(i, j))),
            // Becker (22); theory (K.7).
            rate: if is_solid { 2.0 / dt } else { 1.0 / dt },
            elastic: dt * shear * solid_fraction * volume,
            viscous: viscosity * volume,
            own: [corner; N],
            compression: [solid_fraction * corner * compliance / dt; N],
            ghost: 0.0,
            diffusion: tau * of_fluid * volume / density,
        };
        let part = SolidPart {
            volume: solid_fraction * volume,
            mass: [solid_fraction * corner * solid_density; N],
            weights: [solid_fraction * corner; N],
            stress: self.mean_stress(around.mesh, e),
            shear,
            rate: integrals.rate,
            acceleration: nodes.map(|i| if is_solid { self.nodal.acceleration[i] } else { Vector::ZERO }),
        };
        let filling = SolidFilling { solid, part, split: None, diffused: tau * of_fluid * volume };
        (self.assembled(around, e, &integrals, filling), content)
    }

    /// Filling of an element that isn't cut, by its particles; without any, its solid.
    fn mixture(&self, e: usize, solid: usize) -> Mixture {
        let (sums, law) = (&self.sums[e], &self.setups[solid].law);
        let solid_fraction = sums.solid_fraction().unwrap_or(1.0);
        let mean = |sum: f64, own: f64| if sums.count[1] > 0.0 { sum / sums.count[1] } else { own };
        let solid_density = mean(sums.solid_density, law.density);
        Mixture {
            solid_fraction,
            shear: mean(sums.shear, law.shear),
            compliance: mean(sums.compliance, 1.0 / law.bulk),
            solid_density,
            density: solid_fraction * solid_density + (1.0 - solid_fraction) * self.fluid_density,
        }
    }

    /// Content of an element of this volume [m³] with the nodal densities of its particles; `density` [kg/m³] without
    /// any.
    fn content(&self, e: usize, volume: f64, density: f64, viscosity: f64) -> Content<N> {
        let sums = &self.sums[e];
        let mut content = Content::uniform(volume, density, viscosity, 0.0);
        for k in 0..N {
            let seen = sums.shape[0][k] + sums.shape[1][k];
            let own = if seen > 0.0 { sums.density[k] / seen } else { density };
            content.mass[k] = volume / N as f64 * own;
        }
        content
    }

    /// An element that the interface between a solid and the fluid cuts (theory K.5).
    fn cut(
        &self,
        around: &SurroundingFluid<'_, D, N>,
        level: [f64; N],
        e: usize,
        solid: usize,
    ) -> (SolidElement<D, N>, Content<N>) {
        let (volume, law, dt) = (around.mesh.simplex(e).volume, &self.setups[solid].law, around.equations.delta);
        let pressure = around.mesh.elements()[e].map(|node| self.nodal.pressure[node as usize]);
        let media = [
            Medium { density: law.density, viscosity: 0.0 },
            Medium { density: self.fluid_density, viscosity: (around.viscosity)(e) },
        ];
        let cut = CutGeometry::new(level, media);
        let mut split = SplitPressure::new(&cut, volume, law.bulk, &pressure);
        if let GhostPressures::Given(given) = &self.ghosts {
            split.estimate = given[e];
        }
        let (content, solid_fraction, rate) = (cut.content(volume, |_| 0.0), cut.negative_fraction(), 1.0 / dt);
        let integrals = ElementIntegrals {
            mass: cut_mass(&cut, volume, around.equations.mass, &content),
            rate,
            elastic: dt * law.shear * solid_fraction * volume,
            viscous: content.viscosity * volume,
            own: split.own,
            compression: split.own.map(|own| own / (law.bulk * dt)),
            ghost: dt * law.bulk * split.ghost.iter().sum::<f64>(),
            diffusion: 0.0,
        };
        let part = SolidPart {
            volume: solid_fraction * volume,
            mass: split.in_solid().map(|weight| law.density * weight),
            weights: split.in_solid(),
            stress: self.mean_stress(around.mesh, e),
            shear: law.shear,
            rate,
            acceleration: [Vector::ZERO; N],
        };
        let filling = SolidFilling { solid, part, split: Some(split), diffused: 0.0 };
        (self.assembled(around, e, &integrals, filling), content)
    }

    /// Matrix and right-hand side of an element from its integrals and what fills it.
    fn assembled(
        &self,
        around: &SurroundingFluid<'_, D, N>,
        e: usize,
        integrals: &ElementIntegrals<N>,
        filling: SolidFilling<D, N>,
    ) -> SolidElement<D, N> {
        let SolidFilling { solid, part, split, diffused } = filling;
        let g = &around.mesh.simplex(e).gradient;
        let drive = (around.drive)(e);
        let ghosts =
            split.map_or(0.0, |split| split.ghost.iter().zip(&split.estimate).map(|(w, p)| w * p).sum::<f64>());
        let forces = ElementLoads {
            drive: &drive,
            acceleration: part.acceleration,
            pressure: around.mesh.elements()[e].map(|node| self.nodal.pressure[node as usize]),
            stress: part.stress * part.volume,
            ghosts,
            source: drive.source(&around.equations) * diffused,
        };
        SolidElement {
            element: e as u32,
            solid,
            blocks: std::array::from_fn(|i| std::array::from_fn(|j| integrals.block(g, (i, j)))),
            loads: std::array::from_fn(|i| integrals.load(g, &forces, i)),
            part,
            split,
        }
    }

    /// Finds the condensed pressures of cut elements from the velocity of the nodes [m/s] after a step `dt` [s].
    pub fn recover(&mut self, mesh: &Mesh<D, N>, velocity: &[Vector<D>], dt: f64) {
        parallel::change(&mut self.elements, 256, |_, own| {
            let e = own.element as usize;
            let nodes = mesh.simplex(e).gradient.iter().zip(&mesh.elements()[e]);
            let divergence: f64 = nodes.map(|(g, &node)| g.dot(velocity[node as usize])).sum();
            own.split.iter_mut().for_each(|split| split.recover(dt, divergence));
        });
    }

    /// Finds the forces of the fluid on the solids from the `solution` in each element: the sum of what their
    /// equations lack at nodes that are `free` along an axis; what they lack at others is what holds them
    /// (theory (K.13)).
    pub fn find_forces(
        &mut self,
        mesh: &Mesh<D, N>,
        solution: impl Fn(usize) -> ([Vector<D>; N], [f64; N], Drive<D, N>) + Sync,
        dt: f64,
        free: impl Fn(usize, usize) -> bool + Sync,
    ) {
        let of = |place: usize| -> Vector<D> {
            let own = &self.elements[place];
            let e = own.element as usize;
            let (velocity, pressure, drive) = solution(e);
            let solution = NodalSolution { drive: &drive, velocity, pressure, dt };
            let forces = own.force_on_solid(mesh.simplex(e), &solution);
            let at_node = |(force, &node): (Vector<D>, &u32)| {
                Vector::from_fn(|axis| if free(node as usize, axis) { force[axis] } else { 0.0 })
            };
            forces.into_iter().zip(&mesh.elements()[e]).map(at_node).sum()
        };
        let each = parallel::collect(self.elements.len(), 256, of);
        self.forces.fill(Vector::ZERO);
        each.into_iter().zip(&self.elements).for_each(|(force, own)| self.forces[own.solid] += force);
    }

    /// Marks the unknowns that supports prescribe; those of the boundary's walls and inlets stay as they are.
    pub fn hold(&self, constraints: &mut Constraints<D, N>) {
        let all = (1 << D) - 1;
        for (node, axis, _) in self.held() {
            let taken = constraints.mask[node] & all == all || constraints.frame(node).is_some();
            constraints.mask[node] |= if taken { 0 } else { 1 << axis };
        }
    }

    /// Sets the velocities that supports prescribe at time `t` [s] where `boundary`, the masks without supports, leaves
    /// them to them.
    pub fn prescribe(&self, mesh: &Mesh<D, N>, t: f64, boundary: &[u8], constraints: &mut Constraints<D, N>) {
        for (node, axis, signal) in self.held() {
            if boundary[node] >> axis & 1 == 0 && constraints.mask[node] >> axis & 1 == 1 {
                constraints.value[node][axis] = signal.value(mesh.nodes()[node].to3(), t);
            }
        }
    }

    /// Takes the same velocities for the convected ones of these nodes [m/s], as walls do.
    pub fn impose(&self, mesh: &Mesh<D, N>, t: f64, boundary: &[u8], convected: &mut [Vector<D>]) {
        for (node, axis, signal) in self.held().filter(|(node, axis, _)| boundary[*node] >> axis & 1 == 0) {
            convected[node][axis] = signal.value(mesh.nodes()[node].to3(), t);
        }
    }

    /// Nodes, axes and velocities [m/s] of supports that move at time `t` [s].
    pub fn driven(&self, mesh: &Mesh<D, N>, t: f64, boundary: &[u8]) -> Vec<(usize, usize, f64)> {
        let left = self.held().filter(|(node, axis, _)| boundary[*node] >> axis & 1 == 0);
        let at = left.map(|(node, axis, signal)| (node, axis, signal.value(mesh.nodes()[node].to3(), t)));
        at.filter(|(_, _, velocity)| *velocity != 0.0).collect()
    }

    /// Nodes, axes and velocities of all supports.
    fn held(&self) -> impl Iterator<Item = (usize, usize, &Signal)> {
        let all = self.setups.iter().flat_map(|setup| &setup.held);
        all.flat_map(|held| {
            let axes = held.velocity.iter().enumerate().filter_map(|(axis, signal)| Some((axis, signal.as_ref()?)));
            axes.flat_map(|(axis, signal)| held.nodes.iter().map(move |&node| (node as usize, axis, signal)))
        })
    }
}

/// M_ij of a cut element of this volume [m³], lumped as its content or consistent.
fn cut_mass<const N: usize>(cut: &CutGeometry<N>, volume: f64, mass: Mass, content: &Content<N>) -> [[f64; N]; N] {
    let lumped = |i, j| if i == j { content.mass[i] } else { 0.0 };
    match mass {
        Mass::Lumped => std::array::from_fn(|i| std::array::from_fn(|j| lumped(i, j))),
        Mass::Consistent => cut.mass(volume),
    }
}
