//! The method against closed forms and published values; problems small enough to run with every build.

mod added_mass;
mod bad_luck;
mod bad_luck_3d;
mod bubble;
mod cavity;
mod closed_boxes;
pub mod complex;
mod composite;
mod contact;
mod contact_3d;
mod contact_in_water;
mod corner_loads;
mod couette;
mod driven_square;
mod enclosed;
mod energy;
mod films;
mod floating;
mod holding;
mod incompressible;
mod inlet;
mod moving_disc;
mod moving_supports;
mod openings;
mod orders;
mod outflow;
mod particle_solids;
mod rest;
mod restitution;
mod resume;
mod resume_contacts;
mod resume_solids;
mod solids;
mod solids_at_rest;
mod stokes;
mod stray_particles;
mod three_fluids;
mod turning;
mod unresolved;
mod vortex;
mod waves;

use crate::linalg::SolverOptions;
use crate::material::Newtonian;
use crate::math::{Signal, Vector};
use crate::mesh::{Facet, Mesh};
use crate::pfem2::ThetaStep;
use crate::pfem2::boundary::{BoundarySetup, Condition};
use crate::pfem2::cut_element::Enrichment;
use crate::pfem2::element::{Mass, Stabilisation};
use crate::pfem2::equations::system::{Physics, VelocityPressureSystem};
use crate::pfem2::fluid::FluidSetup;
use crate::pfem2::particles::Particles;
use crate::pfem2::particles::project::AveragingKernel;
use crate::pfem2::phases::Phases;
use crate::pfem2::phases::phase_list::PhaseList;
use crate::pfem2::phases::phase_list::Reseeding;
use crate::pfem2::setup::{InitialState, Setup};
use crate::pfem2::theta_step::Scheme;
use crate::pfem2::tracking::Unresolved;
use crate::pfem2::tracking::VolumeCorrection;

/// Facets whose nodes all satisfy a test.
fn facets<const D: usize, const N: usize>(mesh: &Mesh<D, N>, on: impl Fn(Vector<D>) -> bool) -> Vec<Facet> {
    let all = |facet: &&Facet| mesh.facet_nodes(**facet).iter().all(|&node| on(mesh.nodes()[node as usize]));
    mesh.boundary().iter().filter(all).copied().collect()
}

/// A condition on the facets whose nodes all satisfy a test.
fn set<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    name: &str,
    condition: Condition<D>,
    on: impl Fn(Vector<D>) -> bool,
) -> BoundarySetup<D> {
    BoundarySetup { name: name.into(), facets: facets(mesh, on), condition, brings: None }
}

/// A formula in x, y, z and t.
fn formula(source: &str) -> Signal {
    Signal::formula(source).unwrap()
}

/// No body force.
fn weightless<const D: usize>() -> [Signal; D] {
    std::array::from_fn(|_| Signal::ZERO)
}

/// A Newtonian fluid.
fn fluid(name: &str, density: f64, viscosity: f64) -> FluidSetup {
    FluidSetup::new(name, Box::new(Newtonian { density, viscosity }))
}

/// The default choices, without surface tension.
fn physics<const D: usize>(fluids: Vec<FluidSetup>, gravity: [Signal; D]) -> Physics<D> {
    Physics {
        fluids,
        tension: Vec::new(),
        gravity,
        mass: Mass::default(),
        stabilisation: Stabilisation::default(),
        enrichment: Enrichment::default(),
    }
}

/// The default choices in a whole setup; every fluid starts where `fluid_at` says, with velocity `start`.
fn setup<const D: usize, const N: usize>(
    mesh: Mesh<D, N>,
    boundaries: Vec<BoundarySetup<D>>,
    physics: Physics<D>,
    fluid_at: impl Fn(Vector<D>) -> u8 + Sync,
    start: impl Fn(Vector<D>) -> Vector<D> + Sync,
) -> Setup<D, N> {
    let Physics { fluids, tension, gravity, mass, stabilisation, enrichment } = physics;
    let particles = Particles::seed(&mesh, if D == 2 { 5 } else { 4 }, |x| Some(fluid_at(x)), &start);
    let velocity = mesh.nodes().iter().map(|x| start(*x)).collect();
    Setup {
        mesh,
        boundaries,
        pin: None,
        fluids,
        moments: Vec::new(),
        tension,
        gravity,
        particles,
        solids: None,
        particle_solids: Vec::new(),
        level_set: None,
        volume: VolumeCorrection::default(),
        velocity,
        scheme: Scheme::default(),
        stabilisation,
        mass,
        enrichment,
        kernel: AveragingKernel::default(),
        reseeding: Reseeding::default(),
        projectile_ratio: f64::INFINITY,
        relaxation: f64::INFINITY,
        unresolved: Unresolved::default(),
        courant: f64::INFINITY,
        step_tolerance: f64::INFINITY,
        start: InitialState::AsGiven,
        linear: SolverOptions::default(),
    }
}

/// Marches the mesh alone, without convection: the θ-scheme of the step with particles that don't move.
fn march<const D: usize, const N: usize>(
    system: &mut VelocityPressureSystem<D, N>,
    phases: &Phases,
    dt: f64,
    steps: usize,
) {
    let Scheme::SecondOrder { theta } = Scheme::default() else { return };
    let still = vec![Vector::ZERO; system.velocity.len()];
    let (mut now, mut earlier) = (still.clone(), still);
    for k in 0..steps {
        let step = ThetaStep { t: k as f64 * dt, dt, theta: if k == 0 { 1.0 } else { theta } };
        let weight = if k == 0 { 0.0 } else { step.theta - 0.5 };
        let kick = |i: usize| now[i] * ((1.0 - step.theta - weight) * dt) + earlier[i] * (weight * dt);
        let mut convected: Vec<Vector<D>> = system.velocity.iter().enumerate().map(|(i, v)| *v + kick(i)).collect();
        system.boundary.impose(&system.mesh, step, &mut convected);
        system.solve(step, phases, &convected).unwrap();
        let gained = system.velocity.iter().zip(&convected).map(|(v, hat)| (*v - *hat) / step.delta()).collect();
        earlier = std::mem::replace(&mut now, gained);
        if k == 0 {
            earlier.clone_from(&now);
        }
    }
}

/// Phases of one fluid.
fn one(list: &PhaseList) -> Phases<'_> {
    Phases { list, fraction: &[], level: &[] }
}

/// Root of the mean square of the differences to an exact field.
fn rms<const D: usize>(nodes: &[Vector<D>], values: &[Vector<D>], exact: impl Fn(Vector<D>) -> Vector<D>) -> f64 {
    let sum: f64 = nodes.iter().zip(values).map(|(x, v)| (*v - exact(*x)).norm_squared()).sum();
    (sum / nodes.len() as f64).sqrt()
}

/// The largest speed [m/s].
fn fastest<const D: usize>(velocity: &[Vector<D>]) -> f64 {
    velocity.iter().map(|v| v.norm()).fold(0.0, f64::max)
}

/// A mesh whose inner nodes are shifted by up to a tenth of a cell, so that nothing holds by symmetry.
fn shaken<const D: usize, const N: usize>(mesh: &Mesh<D, N>, cell: f64) -> Mesh<D, N> {
    let mut edge = vec![false; mesh.nodes().len()];
    mesh.boundary().iter().flat_map(|&f| mesh.facet_nodes(f)).for_each(|node| edge[node as usize] = true);
    let shift = |i: usize| Vector::from_fn(|axis| 0.1 * cell * (i as f64 * (1.7 + axis as f64)).sin());
    let moved = |(i, x): (usize, &Vector<D>)| if edge[i] { *x } else { *x + shift(i) };
    Mesh::new(mesh.nodes().iter().enumerate().map(moved).collect(), mesh.elements().to_vec()).unwrap()
}

/// A disc of radius one, of rings of triangles.
fn disc(rings: u32, sectors: u32) -> Mesh<2, 3> {
    let angle = |k: u32| std::f64::consts::TAU * f64::from(k) / f64::from(sectors);
    let radius = |r: u32| f64::from(r) / f64::from(rings);
    let ring = |r: u32| (0..sectors).map(move |k| Vector([angle(k).cos(), angle(k).sin()]) * radius(r));
    let nodes: Vec<Vector<2>> = std::iter::once(Vector::ZERO).chain((1..=rings).flat_map(ring)).collect();
    let at = |r: u32, k: u32| if r == 0 { 0 } else { 1 + (r - 1) * sectors + k % sectors };
    let core = (0..sectors).map(|k| [0, at(1, k), at(1, k + 1)]);
    let shell = (1..rings).flat_map(|r| {
        (0..sectors).flat_map(move |k| {
            let quad = [at(r, k), at(r + 1, k), at(r + 1, k + 1), at(r, k + 1)];
            [[quad[0], quad[1], quad[2]], [quad[0], quad[2], quad[3]]]
        })
    });
    Mesh::new(nodes, core.chain(shell).collect()).unwrap()
}

/// A mesh whose nodes are moved to `to`.
fn bent<const D: usize, const N: usize>(mesh: &Mesh<D, N>, to: impl Fn(Vector<D>) -> Vector<D>) -> Mesh<D, N> {
    Mesh::new(mesh.nodes().iter().map(|&x| to(x)).collect(), mesh.elements().to_vec()).unwrap()
}
