//! Plane Poiseuille flow, with its exact solution: disturbance by outlets, and forces on the walls.

use lateen::linalg::SolverOptions;
use lateen::material::Newtonian;
use lateen::math::{Signal, Vector};
use lateen::mesh::{Facet, Mesh};
use lateen::pfem2::Scheme;
use lateen::pfem2::ThetaStep;
use lateen::pfem2::boundary::{BoundarySetup, Condition};
use lateen::pfem2::cut_element::Enrichment;
use lateen::pfem2::element::{Mass, Stabilisation};
use lateen::pfem2::equations::system::{Physics, VelocityPressureSystem};
use lateen::pfem2::fluid::FluidSetup;
use lateen::pfem2::particles::Particles;
use lateen::pfem2::particles::project::AveragingKernel;
use lateen::pfem2::phases::Phases;
use lateen::pfem2::phases::phase_list::PhaseList;
use lateen::pfem2::phases::phase_list::Reseeding;
use lateen::pfem2::setup::InitialState;
use lateen::pfem2::tracking::Unresolved;
use lateen::pfem2::tracking::VolumeCorrection;
use lateen::pfem2::{Boundary, Pfem2, Setup};
use lateen::simulation::Solver;

/// Length of the plates; their distance is 1.
const LENGTH: f64 = 3.0;

/// u = 4 y (1 − y), with the pressure 8 μ (L − x) and the wall shear 4 μ.
fn profile(x: Vector<2>) -> Vector<2> {
    Vector([4.0 * x[1] * (1.0 - x[1]), 0.0])
}

fn plates(cells: usize) -> Mesh<2, 3> {
    Mesh::block(Vector::ZERO, Vector([LENGTH, 1.0]), [3 * cells, cells]).unwrap()
}

fn sets(mesh: &Mesh<2, 3>, outlet: Condition<2>) -> Vec<BoundarySetup<2>> {
    let at = |x: f64| -> Vec<Facet> {
        let on = |facet: &&Facet| mesh.facet_nodes(**facet).iter().all(|&node| mesh.nodes()[node as usize][0] == x);
        mesh.boundary().iter().filter(on).copied().collect()
    };
    let set = |name: &str, facets, condition| BoundarySetup { name: name.into(), facets, condition, brings: None };
    let inlet = Condition::Inlet([Signal::formula("4*y*(1 - y)").unwrap(), 0.0.into()]);
    vec![set("in", at(0.0), inlet), set("out", at(LENGTH), outlet)]
}

fn physics(viscosity: f64) -> Physics<2> {
    Physics {
        fluids: vec![FluidSetup::new("oil", Box::new(Newtonian { density: 1.0, viscosity }))],
        tension: Vec::new(),
        gravity: [Signal::ZERO, Signal::ZERO],
        mass: Mass::Lumped,
        stabilisation: Stabilisation::Oss,
        enrichment: Enrichment::None,
    }
}

/// The mesh stage alone, started with the profile: the largest deviations of velocity and pressure.
fn disturbed(outlet: Condition<2>) -> (f64, f64) {
    const VISCOSITY: f64 = 0.1;
    // The projected pressure gradient comes from the step before: it takes its time to settle.
    const STEPS: u32 = 100;
    let mesh = plates(8);
    let boundary = Boundary::new(&mesh, sets(&mesh, outlet), Vector::ZERO);
    let start = mesh.nodes().iter().map(|x| profile(*x)).collect();
    let options = SolverOptions { tolerance: 1e-13, ..SolverOptions::default() };
    let mut system = VelocityPressureSystem::new(mesh, boundary, physics(VISCOSITY), start, options);
    for k in 0..STEPS {
        let step = ThetaStep { t: 0.5 * f64::from(k), dt: 0.5, theta: 1.0 };
        let convected = system.velocity.clone();
        system
            .solve(step, &Phases { list: &PhaseList::fluids(&[1.0]), fraction: &[], level: &[] }, &convected)
            .unwrap();
    }
    let nodes = || system.mesh.nodes().iter();
    let exact = |x: &Vector<2>| 8.0 * VISCOSITY * (LENGTH - x[0]);
    let velocity = nodes().zip(&system.velocity).map(|(x, v)| (*v - profile(*x)).norm());
    let pressure = nodes().zip(&system.pressure).map(|(x, p)| (p - exact(x)).abs());
    (velocity.fold(0.0, f64::max), pressure.fold(0.0, f64::max))
}

/// On this lattice the differences of a parabola are exact at the nodes, so only an outlet can disturb it.
#[test]
fn outlets_leave_plane_poiseuille_flow_undisturbed() {
    for outlet in [Condition::Outlet, Condition::Pressure(0.0.into())] {
        let (velocity, pressure) = disturbed(outlet);
        assert!(velocity < 1e-10 && pressure < 1e-9, "{velocity:e} {pressure:e}");
    }
    // A traction-free end is another condition, with which the flow diverges.
    assert!(disturbed(Condition::Traction([0.0.into(), 0.0.into()])).0 > 1e-3);
}

/// The whole method, from inlet to outlet over one passage: the largest deviation between x = 1 and 2 and behind
/// x = 2.5, and the force along x on all that holds the fluid.
fn carried(cells: usize) -> (f64, f64, f64) {
    let (mesh, viscosity) = (plates(cells), 0.02);
    let Physics { fluids, tension, gravity, mass, stabilisation, enrichment } = physics(viscosity);
    let mut pfem = Pfem2::new(Setup {
        pin: None,
        boundaries: sets(&mesh, Condition::Outlet),
        particles: Particles::seed(&mesh, 4, |_| Some(0), profile),
        velocity: mesh.nodes().iter().map(|x| profile(*x)).collect(),
        mesh,
        fluids,
        moments: Vec::new(),
        tension,
        gravity,
        solids: None,
        particle_solids: Vec::new(),
        level_set: None,
        volume: VolumeCorrection::None,
        scheme: Scheme::default(),
        stabilisation,
        mass,
        enrichment,
        kernel: AveragingKernel::Linear,
        reseeding: Reseeding::default(),
        projectile_ratio: f64::INFINITY,
        relaxation: f64::INFINITY,
        unresolved: Unresolved::default(),
        courant: f64::INFINITY,
        step_tolerance: f64::INFINITY,
        start: InitialState::AsGiven,
        linear: SolverOptions::default(),
    });
    let dt = 1.0 / cells as f64;
    (0..4 * cells).for_each(|k| pfem.step(k as f64 * dt, dt).unwrap());
    let snapshot = pfem.snapshot();
    let surface = &snapshot.surfaces[0];
    let velocity = surface.node_fields[0].values().into_owned();
    let deviation = |from: f64, to: f64| {
        let nodes = surface.position.iter().zip(velocity.chunks(3)).filter(|(x, _)| (from..=to).contains(&x[0]));
        nodes.map(|(x, v)| (Vector([v[0], v[1]]) - profile(Vector([x[0], x[1]]))).norm()).fold(0.0, f64::max)
    };
    (deviation(1.0, 2.0), deviation(2.5, LENGTH), snapshot.forces.iter().map(|(_, force)| force[0]).sum())
}

/// The deviation from the profile falls with the square of the mesh, at the outlet as elsewhere (over two halvings:
/// where particles happen to stand changes it by half from one mesh to the next). In balance the
/// reactions of walls and inlet add up to nothing, within the same error of the shear on the walls, 2 · 4 μ L.
#[test]
fn the_error_of_plane_poiseuille_flow_is_of_second_order() {
    let ((middle, end, net), (fine, fine_end, fine_net)) = (carried(8), carried(32));
    let orders = [middle / fine, end / fine_end].map(|ratio| ratio.log2() / 2.0);
    assert!(orders.iter().all(|&order| order > 1.9), "{orders:?}");
    assert!(middle < 1.0 / 64.0 && end < 1.0 / 64.0, "{middle:e} {end:e}");
    let shear = 2.0 * 4.0 * 0.02 * LENGTH;
    assert!(net.abs() < 0.03 * shear && fine_net.abs() < 0.01 * shear, "{net} {fine_net} of {shear}");
}
