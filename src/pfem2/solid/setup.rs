//! A solid as a run starts with it.

use super::mesh::SolidMesh;
use crate::material::PointLaw;
use crate::math::{Signal, Vector};

/// A solid, made by the case layer.
#[derive(Debug)]
pub struct SolidSetup<const D: usize> {
    /// Name.
    pub name: String,
    /// Mesh of the solid, in the reference state.
    pub mesh: SolidMesh<D>,
    /// Its law: [`Rigid`](crate::material::Rigid), or one with an [`ElasticLaw`](crate::material::ElasticLaw).
    pub law: Box<dyn PointLaw>,
    /// The third direction, in two dimensions.
    pub plane: Plane,
    /// Velocity at its nodes at the start [m/s].
    pub velocity: Vec<Vector<D>>,
    /// Nodes with a prescribed velocity.
    pub held: Vec<HeldNodes<D>>,
    /// Springs and dashpots at its nodes.
    pub springs: Vec<SpringSupport<D>>,
    /// Prescribed rates of a rigid solid.
    pub motion: PrescribedMotion,
    /// Loads on its surface.
    pub tractions: Vec<SurfaceTraction<D>>,
    /// Pressures that follow its surface.
    pub pressures: Vec<SurfacePressure>,
    /// Damping.
    pub damping: Damping,
    /// Inertia.
    pub inertia: Inertia,
    /// Coefficient of Coulomb's friction at walls; of two solids that meet the root of their product counts.
    pub friction: f64,
    /// Coefficient of restitution e of a rigid solid at walls, 0 to 1; of two that meet the root of their product
    /// counts.
    pub restitution: f64,
    /// Condition for the fluid on its surface.
    pub surface: SurfaceCondition,
}

impl<const D: usize> SolidSetup<D> {
    /// A solid at rest that nothing holds or loads, in plane strain in two dimensions; the fluid sticks to it.
    pub fn free(name: impl Into<String>, mesh: SolidMesh<D>, law: Box<dyn PointLaw>) -> Self {
        Self {
            name: name.into(),
            law,
            plane: Plane::default(),
            velocity: vec![Vector::ZERO; mesh.nodes.len()],
            held: Vec::new(),
            springs: Vec::new(),
            motion: PrescribedMotion::default(),
            tractions: Vec::new(),
            pressures: Vec::new(),
            damping: Damping::default(),
            inertia: Inertia::default(),
            friction: 0.0,
            restitution: 0.0,
            surface: SurfaceCondition::default(),
            mesh,
        }
    }

    /// The rate 1/Δ with which its velocity changes in a step with the implicit part `delta` [s], as far as that takes
    /// a force [1/s].
    pub(super) fn inertia_rate(&self, delta: f64) -> f64 {
        match self.inertia {
            Inertia::Dynamic => 1.0 / delta,
            Inertia::QuasiStatic => 0.0,
        }
    }
}

/// Condition for the fluid on the surface of a solid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SurfaceCondition {
    /// The fluid sticks.
    #[default]
    NoSlip,
    /// The fluid glides: for elements that are wider than the layer in which it would be slowed down.
    Slip,
}

/// The third direction of a plane problem.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Plane {
    /// No strain across the plane.
    #[default]
    Strain,
    /// No stress across the plane.
    Stress,
}

/// Nodes whose velocity is prescribed along some axes.
#[derive(Debug, Clone)]
pub struct HeldNodes<const D: usize> {
    /// Nodes of the solid's mesh.
    pub nodes: Vec<u32>,
    /// Velocity along each axis [m/s]; `None`: free.
    pub velocity: [Option<Signal>; D],
}

/// Springs and dashpots that pull nodes to where they start, f_a = −w_a (k u_a + c v_a) along each axis.
#[derive(Debug, Clone, PartialEq)]
pub struct SpringSupport<const D: usize> {
    /// Nodes of the solid's mesh, with their weights w_a, whose sum is one.
    pub weights: Vec<(u32, f64)>,
    /// k of all together along each axis [N/m].
    pub stiffness: [f64; D],
    /// c of all together along each axis [N s/m].
    pub damping: [f64; D],
}

/// Prescribed rates of a rigid solid, along each axis; `None`: free.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PrescribedMotion<T = Signal> {
    /// Velocity of its centre of mass [m/s].
    pub velocity: [Option<T>; 3],
    /// Angular velocity [1/s]; in the plane the third alone.
    pub spin: [Option<T>; 3],
}

impl<T> Default for PrescribedMotion<T> {
    fn default() -> Self {
        Self { velocity: [None, None, None], spin: [None, None, None] }
    }
}

/// A load on facets of a solid.
#[derive(Debug, Clone)]
pub struct SurfaceTraction<const D: usize> {
    /// Places in [`SolidMesh::facets`].
    pub facets: Vec<u32>,
    /// Force per area in the reference state [Pa], with a fixed direction.
    pub traction: [Signal; D],
}

/// A pressure that follows facets of a solid.
#[derive(Debug, Clone)]
pub struct SurfacePressure {
    /// Places in [`SolidMesh::facets`].
    pub facets: Vec<u32>,
    /// Force per area of the deformed surface, against its outward normal where positive, by the place in the reference
    /// state [Pa].
    pub pressure: Signal,
}

/// Damping forces −(α M + β K) v.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Damping {
    /// α, in proportion to the mass [1/s].
    pub mass: f64,
    /// β, in proportion to the stiffness [s].
    pub stiffness: f64,
}

/// Inertia of a solid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Inertia {
    /// The solid has its mass.
    #[default]
    Dynamic,
    /// None: forces balance at every time.
    QuasiStatic,
}
