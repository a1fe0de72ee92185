//! Solids against closed forms, and against the benchmark of Turek & Hron (2006).

mod bonds;
mod loads;
mod oscillator;
mod rigid;
mod waves;

use super::*;
use crate::linalg::SparseFactor;
use crate::material::{Elastic, Hypoelastic, StVenantKirchhoff};
use crate::math::Signal;
use crate::pfem2::history::StepWeights;
use crate::pfem2::solid::mesh::SolidFacet;
use crate::pfem2::solid::setup::{Damping, HeldNodes, Plane, PrescribedMotion, SurfaceTraction};

/// A solid of St. Venant–Kirchhoff material with density [kg/m³], Young's modulus [Pa] and Poisson's ratio, whose nodes
/// with `fixed` places are held along all axes.
pub(in crate::pfem2::solid) fn solid<const D: usize>(
    mesh: SolidMesh<D>,
    [density, young, poisson]: [f64; 3],
    fixed: impl Fn(Vector<D>) -> bool,
) -> SolidSetup<D> {
    let nodes = (0..mesh.nodes.len() as u32).filter(|&node| fixed(mesh.nodes[node as usize])).collect();
    let held = vec![HeldNodes { nodes, velocity: std::array::from_fn(|_| Some(Signal::ZERO)) }];
    let law = Box::new(StVenantKirchhoff { elastic: Elastic::new(density, young, poisson) });
    SolidSetup { held, ..SolidSetup::free("solid", mesh, law) }
}

/// Solids without a fluid, in equal steps.
struct SolidsAlone<const D: usize> {
    structure: Structure<D>,
    dt: f64,
    theta: f64,
    steps: usize,
    factor: Option<SparseFactor>,
}

impl<const D: usize> SolidsAlone<D> {
    fn new(setup: SolidSetup<D>, dt: f64, theta: f64) -> Self {
        Self::of(Structure::new(vec![setup]).unwrap(), dt, theta)
    }

    fn of(structure: Structure<D>, dt: f64, theta: f64) -> Self {
        Self { structure, dt, theta, steps: 0, factor: None }
    }

    /// Weights of equal steps in forces and in v*: the first of first order, the second without the second difference
    /// (theory (F.8), (F.15)).
    fn step_weights(&self) -> (StepWeights, [f64; 3]) {
        let (dt, theta) = (self.dt, self.theta);
        let part = 5.0 / 12.0 * (2.0 - 2.4 * theta);
        match self.steps {
            0 => (StepWeights { dt, end: 1.0, start: 0.0, earlier: 0.0 }, [1.0, 0.0, 0.0]),
            1 => (StepWeights { dt, end: theta, start: 1.5 - 2.0 * theta, earlier: theta - 0.5 }, [1.5, -0.5, 0.0]),
            _ => (
                StepWeights { dt, end: theta, start: 1.5 - 2.0 * theta, earlier: theta - 0.5 },
                [1.5 + part, -0.5 - 2.0 * part, part],
            ),
        }
    }

    /// Takes a step; returns the forces that nodes lack [N]: of the supports, where they hold them.
    fn solve_alone(&mut self, gravity: Vector<D>) -> Vec<f64> {
        let (step_weights, weights) = self.step_weights();
        let (t_end, delta) = ((self.steps + 1) as f64 * self.dt, step_weights.end * step_weights.dt);
        let prediction = self.structure.predict(t_end, step_weights, weights).unwrap();
        let equations = self.structure.equations(t_end, delta, &prediction, |_| gravity).unwrap();
        let (matrix, rhs) = equations.independent(&[], &vec![0.0; equations.rhs.len()]);
        let factor = match self.factor.take() {
            Some(factor) => factor.renewed(&matrix),
            None => SparseFactor::new(&matrix),
        };
        let mut w = vec![0.0; rhs.len()];
        self.factor.insert(factor.unwrap()).solve(&rhs, &mut w);
        self.structure.advance(delta, &prediction, &w);
        self.steps += 1;
        equations.missing(&equations.velocities.nodal(&w))
    }

    fn energy(&self) -> f64 {
        self.structure.kinetic_energy() + self.structure.strain_energy().unwrap()
    }
}

/// A patch of distorted elements whose boundary follows a homogeneous deformation: so does the interior, without any
/// force.
fn patch<const D: usize>() {
    let mut mesh = SolidMesh::<D>::block(Vector::ZERO, Vector::splat(1.0), [2; D]).unwrap();
    let inside = |x: Vector<D>| x.0.iter().all(|x| *x > 0.0 && *x < 1.0);
    for x in mesh.nodes.iter_mut().filter(|x| inside(**x)) {
        *x += Vector::from_fn(|k| 0.05 * (7.0 * x[(k + 1) % D] + 3.0 * x[k] + k as f64).sin());
    }
    let setup = solid(mesh, [1000.0, 1e6, 0.3], |x| !inside(x));
    let stretch = Tensor::<D>::from_fn(|i, j| [0.11, -0.07, 0.05, 0.2][(2 * i + 3 * j) % 4]);
    let exact: Vec<_> = setup.mesh.nodes.iter().map(|x| stretch.apply(*x)).collect();
    let interior: Vec<bool> = setup.mesh.nodes.iter().map(|x| inside(*x)).collect();
    let mut structure = Structure::new(vec![setup]).unwrap();
    let boundary = exact.iter().zip(&interior).map(|(u, inside)| if *inside { *u * 0.8 } else { *u });
    structure.state.displacement = boundary.collect();
    structure.equilibrium(0.0, |_| Vector::ZERO).unwrap();
    let error = structure.state.displacement.iter().zip(&exact).map(|(u, exact)| (*u - *exact).norm());
    let error = error.fold(0.0, f64::max);
    assert!(error < 1e-10, "{error:e}");
}

#[test]
fn distorted_patches_deform_evenly() {
    patch::<2>();
    patch::<3>();
}

/// Tip of a cantilever under its own weight by Timoshenko's theory, per q/(E I): L⁴/8 + E I L²/(2 κ G A).
fn timoshenko(length: f64, bending: f64, shear: f64) -> f64 {
    length.powi(4) / (8.0 * bending) + length.powi(2) / (2.0 * shear)
}

/// The continuum has −0.44 % with ν = 0.3, as its clamped end can't contract. Displacements alone would have −2.3 and
/// −1.3 % here.
#[test]
fn a_cantilever_bends_as_timoshenkos_beam() {
    for (counts, poisson) in [([5, 1], 0.3), ([10, 1], 0.3), ([10, 1], 0.45)] {
        let (young, density, g) = (1e6, 1.0, 0.1);
        let mesh = SolidMesh::block(Vector::ZERO, Vector([10.0, 1.0]), counts).unwrap();
        let mut structure = Structure::new(vec![solid(mesh, [density, young, poisson], |x| x[0] == 0.0)]).unwrap();
        structure.equilibrium(0.0, |_| Vector([0.0, -g])).unwrap();
        let deflection = -structure.state.displacement[tip(counts)][1];
        let (plane, shear) = (young / (1.0 - poisson * poisson), 5.0 / 6.0 * young / (2.0 * (1.0 + poisson)));
        let exact = density * g * timoshenko(10.0, plane / 12.0, shear);
        assert!((-0.012..0.0).contains(&(deflection / exact - 1.0)), "{counts:?} {poisson}: {}", deflection / exact);
    }
}

#[test]
fn a_cantilever_in_space_bends_as_timoshenkos_beam() {
    let (young, poisson, density, g) = (1e6, 0.3, 1.0, 0.1);
    let mesh = SolidMesh::block(Vector::ZERO, Vector([20.0, 1.0, 1.0]), [12, 1, 1]).unwrap();
    let mut structure = Structure::new(vec![solid(mesh, [density, young, poisson], |x| x[0] == 0.0)]).unwrap();
    structure.equilibrium(0.0, |_| Vector([0.0, 0.0, -g])).unwrap();
    let tip = -structure.state.displacement.last().unwrap()[2];
    let exact = density * g * timoshenko(20.0, young / 12.0, 5.0 / 6.0 * young / (2.0 * (1.0 + poisson)));
    assert!((tip / exact - 1.0).abs() < 0.005, "{}", tip / exact - 1.0);
}

/// A quarter of a thick ring under pressure p inside, in plane strain (Lamé): u_r = (1 + ν) p a² ((1 − 2ν) r + b²/r)/(E
/// (b² − a²)), with a = 3 and b = 9 as of MacNeal & Harder (1985). Displacements alone would miss half of it for ν =
/// 0.4999.
#[test]
fn a_thick_ring_of_nearly_incompressible_material_widens() {
    for poisson in [0.3, 0.49, 0.4999] {
        let mut mesh = SolidMesh::block(Vector([3.0, 0.0]), Vector([9.0, 1.0]), [4, 3]).unwrap();
        for x in &mut mesh.nodes {
            let (sin, cos) = (x[1] * std::f64::consts::FRAC_PI_2).sin_cos();
            *x = Vector([x[0] * cos, x[0] * sin]);
        }
        let (a, b, pressure) = (3.0f64, 9.0f64, 0.01);
        let mut setup = solid(mesh, [1.0, 1000.0, poisson], |_| false);
        let nodes = |axis: usize| {
            let on = |node: &u32| setup.mesh.nodes[*node as usize][axis] < 1e-9;
            (0..setup.mesh.nodes.len() as u32).filter(on).collect()
        };
        let along = |axis: usize| std::array::from_fn(|k| (k == axis).then_some(Signal::ZERO));
        setup.held = [0, 1].map(|axis| HeldNodes { nodes: nodes(axis), velocity: along(axis) }).into();
        let inside = |facet: &SolidFacet| facet.nodes.iter().all(|&k| setup.mesh.nodes[k as usize].norm() < 3.0 + 1e-9);
        let facets = (0..setup.mesh.facets.len() as u32).filter(|&k| inside(&setup.mesh.facets[k as usize])).collect();
        let push = |axis: &str| Signal::formula(&format!("{pressure}*{axis}/3")).unwrap();
        setup.tractions = vec![SurfaceTraction { facets, traction: [push("x"), push("y")] }];
        let mut structure = Structure::new(vec![setup]).unwrap();
        structure.equilibrium(0.0, |_| Vector::ZERO).unwrap();
        let exact =
            (1.0 + poisson) * pressure * a * a * ((1.0 - 2.0 * poisson) * a + b * b / a) / (1000.0 * (b * b - a * a));
        let error = structure.state.displacement[0][0] / exact - 1.0;
        assert!(error.abs() < 2e-3, "{poisson}: {error}");
    }
}

/// The beam behind the cylinder of Turek & Hron (2006), clamped along the arc, of elements along and across it.
fn turek_beam(counts: [usize; 2], young: f64) -> SolidSetup<2> {
    let mut mesh = SolidMesh::block(Vector([0.0, 0.19]), Vector([1.0, 0.21]), counts).unwrap();
    let arc = |y: f64| 0.2 + (0.05f64.powi(2) - (y - 0.2f64).powi(2)).sqrt();
    for x in &mut mesh.nodes {
        x[0] = arc(x[1]) + x[0] * (0.6 - arc(x[1]));
    }
    solid(mesh, [1000.0, young, 0.4], |x| x[0] <= arc(x[1]))
}

/// Young's modulus of their μ_s = 0.5 MPa with ν = 0.4.
const YOUNG: f64 = 1.4e6;

/// The node in the middle of the end of a beam of elements along and across it.
fn tip(counts: [usize; 2]) -> usize {
    counts[1] * (2 * counts[0] + 1) + 2 * counts[0]
}

/// CSM1: the displacement of the tip under gravity, (−7.187, −66.10) mm.
#[test]
fn the_beam_of_turek_and_hron_sags() {
    let counts = [40, 1];
    let mut structure = Structure::new(vec![turek_beam(counts, YOUNG)]).unwrap();
    structure.equilibrium(0.0, |_| Vector([0.0, -2.0])).unwrap();
    let [x, y] = structure.state.displacement[tip(counts)].0;
    assert!((x / -7.187e-3 - 1.0).abs() < 0.01 && (y / -66.10e-3 - 1.0).abs() < 0.01, "{x} {y}");
}

/// CSM3: the tip swings from rest by −63.607 ± 65.160 mm at 1.0995 Hz.
#[test]
fn the_beam_of_turek_and_hron_swings() {
    let (counts, dt) = ([18, 1], 5e-3);
    let mut run = SolidsAlone::new(turek_beam(counts, YOUNG), dt, 0.6);
    let (mut last, mut lowest, mut highest, mut crossings) = (0.0, 0.0f64, f64::MIN, Vec::new());
    while crossings.len() < 3 {
        run.solve_alone(Vector([0.0, -2.0]));
        let now = run.structure.state.displacement[tip(counts)][1];
        let level = -63.607e-3;
        if (last - level) * (now - level) < 0.0 {
            crossings.push(dt * ((run.steps - 1) as f64 + (level - last) / (now - last)));
        }
        lowest = lowest.min(now);
        highest = if crossings.len() == 2 { highest.max(now) } else { highest };
        last = now;
    }
    let frequency = 1.0 / (crossings[2] - crossings[0]);
    assert!((frequency / 1.0995 - 1.0).abs() < 0.007, "{frequency}");
    assert!((lowest / -128.767e-3 - 1.0).abs() < 0.01, "{lowest}");
    assert!((highest - 1.553e-3).abs() < 0.03 * 65.160e-3, "{highest}");
}

/// A free block that spins and stretches.
fn spinning() -> SolidSetup<2> {
    let mesh = SolidMesh::block(Vector([-1.0, -0.25]), Vector([1.0, 0.25]), [4, 1]).unwrap();
    let mut setup = solid(mesh, [1000.0, 1e6, 0.3], |_| false);
    setup.velocity =
        setup.mesh.nodes.iter().map(|x| Vector([3.0 - 4.0 * x[1] + 2.0 * x[0], 4.0 * x[0] - 1.0])).collect();
    setup
}

#[test]
fn momentum_stays_and_energy_never_grows() {
    // Largest rise above the energy after the first step, and what is left of it in the end.
    for (theta, rise, kept) in [(0.5, 1e-4, 1.0 - 1e-4), (0.6, 0.0, 0.999)] {
        let mut run = SolidsAlone::new(spinning(), 2e-3, theta);
        let momentum = run.structure.momentum();
        assert!((momentum - Vector([3e3, -1e3])).norm() < 1e-9, "{momentum:?}");
        run.solve_alone(Vector::ZERO);
        let start = run.energy();
        for _ in 0..150 {
            run.solve_alone(Vector::ZERO);
            assert!((run.structure.momentum() - momentum).norm() < 1e-7);
            assert!(run.energy() / start < 1.0 + rise, "{theta}: {}", run.energy() / start);
        }
        assert!(run.energy() / start > kept, "{theta}: {}", run.energy() / start);
    }
}

/// A support that moves by sin t carries its nodes along exactly, and its force is the change of momentum.
#[test]
fn a_moving_support_carries_its_nodes_and_takes_their_change_of_momentum() {
    let mesh = SolidMesh::block(Vector::ZERO, Vector([2.0, 0.5]), [3, 1]).unwrap();
    let mut setup = solid(mesh, [1000.0, 1e6, 0.3], |x| x[0] == 0.0);
    setup.held[0].velocity = [Some(Signal::formula("cos(t)").unwrap()), Some(Signal::ZERO)];
    let held = setup.held[0].nodes.clone();
    let gravity = Vector([0.0, -9.81]);
    let mut run = SolidsAlone::new(setup, 0.01, 0.6);
    assert_eq!(run.structure.state.velocity[held[0] as usize], Vector([1.0, 0.0]));
    for step in 1..=20 {
        let (step_weights, weights) = run.step_weights();
        let predicted = run.structure.predict(f64::from(step) * 0.01, step_weights, weights).unwrap().displacement;
        let reactions = run.solve_alone(gravity);
        let carried = &run.structure.state.displacement;
        assert!(held.iter().all(|&node| (predicted[node as usize] - carried[node as usize]).norm() < 1e-14));
        let force =
            Vector::<2>::from_fn(|axis| held.iter().map(|&node| reactions[node as usize * 2 + axis]).sum::<f64>());
        let inertia: f64 = run.structure.weighted_by_mass(&run.structure.state.acceleration).iter().step_by(2).sum();
        assert!((force[0] - inertia).abs() < 1e-8 * 1e4, "{force:?} {inertia}");
        let inertia: f64 =
            run.structure.weighted_by_mass(&run.structure.state.acceleration).iter().skip(1).step_by(2).sum();
        assert!((force[1] + 1000.0 * gravity[1] - inertia).abs() < 1e-8 * 1e4, "{force:?} {inertia}");
    }
    let u = run.structure.state.displacement[held[1] as usize];
    // sin 0.2; the first step is of first order
    assert!((u[0] - 0.2f64.sin()).abs() < 1e-4 && u[1] == 0.0, "{u:?}");
}

/// Damping in proportion to the stiffness leaves a free flight alone; that in proportion to the mass slows it by exp(−α
/// t).
#[test]
fn damping_of_rigid_motion_is_that_of_the_mass() {
    for (damping, left) in
        [(Damping { mass: 0.0, stiffness: 0.1 }, 1.0), (Damping { mass: 2.0, stiffness: 0.0 }, (-0.4f64).exp())]
    {
        let mut setup = spinning();
        setup.damping = damping;
        setup.velocity.fill(Vector([3.0, -1.0]));
        let mut run = SolidsAlone::new(setup, 2e-3, 0.6);
        (0..100).for_each(|_| drop(run.solve_alone(Vector::ZERO)));
        let momentum = run.structure.momentum();
        assert!((momentum - Vector([3e3, -1e3]) * left).norm() < 5e-3 * 3e3 * (1.0 - left) + 1e-7, "{momentum:?}");
    }
}

/// Damping in proportion to the stiffness slows vibrations: the stretching of a spinning block fades, and its spin
/// stays.
#[test]
fn damping_of_strain_leaves_the_spin() {
    let mut setup = spinning();
    setup.damping.stiffness = 0.01;
    let mut run = SolidsAlone::new(setup, 2e-3, 0.6);
    let spin = |run: &SolidsAlone<2>| {
        let structure = &run.structure;
        let centre = structure.momentum() / structure.mass();
        let momentum =
            structure.weighted_by_mass(&structure.state.velocity.iter().map(|v| *v - centre).collect::<Vec<_>>());
        let places = structure.positions(&structure.state.displacement);
        places.iter().zip(momentum.chunks(2)).map(|(x, p)| x[0] * p[1] - x[1] * p[0]).sum::<f64>()
    };
    let before = spin(&run);
    (0..150).for_each(|_| drop(run.solve_alone(Vector::ZERO)));
    let after = spin(&run);
    assert!((after / before - 1.0).abs() < 0.01, "{}", after / before);
}

#[test]
fn unfit_solids_are_refused() {
    let block = || SolidMesh::<2>::block(Vector::ZERO, Vector([1.0, 1.0]), [1, 1]).unwrap();
    let mut rate = solid(block(), [1.0, 1.0, 0.3], |_| false);
    rate.law = Box::new(Hypoelastic { elastic: Elastic::new(1.0, 1.0, 0.3) });
    assert!(Structure::new(vec![rate]).unwrap_err().contains("stored energy"));
    let mut turned = solid(block(), [1.0, 1.0, 0.3], |_| false);
    turned.mesh.elements[0].reverse();
    assert!(Structure::new(vec![turned]).is_ok(), "half a turn");
    let mut mirrored = solid(block(), [1.0, 1.0, 0.3], |_| false);
    mirrored.mesh.nodes.iter_mut().for_each(|x| x[0] = -x[0]);
    assert!(Structure::new(vec![mirrored]).unwrap_err().contains("no positive volume"));
}

#[test]
fn a_solid_that_nothing_holds_has_no_equilibrium() {
    let mesh = SolidMesh::<2>::block(Vector::ZERO, Vector([1.0, 1.0]), [1, 1]).unwrap();
    let mut structure = Structure::new(vec![solid(mesh, [1.0, 1.0, 0.3], |_| false)]).unwrap();
    let error = structure.equilibrium(0.0, |_| Vector([0.0, -1.0])).unwrap_err();
    assert!(error.advice.contains("hold"), "{error}");
    assert!(structure.state.displacement.iter().all(|u| *u == Vector::ZERO));
}
