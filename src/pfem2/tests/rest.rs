//! Fluids at rest stay at rest (theory G.9).

use super::*;
use crate::pfem2::Pfem2;
use crate::pfem2::boundary::Boundary;
use crate::pfem2::interface::level_set::{LevelSet, negative_volume};
use crate::simulation::Solver;

const GRAVITY: f64 = 9.81;

/// Two fluids at rest under gravity along `normal`, with the interface at the distance `offset` from the origin: the
/// largest speed after a step, over g Δt. Theory G.9.
fn stirred<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    normal: Vector<D>,
    offset: f64,
    enrichment: Enrichment,
    mass: Mass,
    condition: Condition<D>,
) -> f64 {
    let (g, dt) = (9.81, 0.01);
    let gravity = std::array::from_fn(|axis| Signal::Constant(-g * normal[axis]));
    let level: Vec<f64> = mesh.nodes().iter().map(|x| x.dot(normal) - offset).collect();
    let physics =
        Physics { enrichment, mass, ..physics(vec![fluid("water", 1000.0, 1e-3), fluid("air", 1.0, 1e-5)], gravity) };
    let sets = vec![BoundarySetup { name: "all".into(), facets: mesh.boundary().to_vec(), condition, brings: None }];
    let boundary = Boundary::new(mesh, sets, normal * -g);
    let still = vec![Vector::ZERO; mesh.nodes().len()];
    let options = SolverOptions { tolerance: 1e-13, ..SolverOptions::default() };
    let mut system = VelocityPressureSystem::new(mesh.clone(), boundary, physics, still.clone(), options);
    let phases = Phases { list: &PhaseList::fluids(&[1000.0, 1.0]), fraction: &[], level: &level };
    system.solve(ThetaStep { t: 0.0, dt, theta: 1.0 }, &phases, &still).unwrap();
    assert!(!system.contents.cuts.is_empty());
    fastest(&system.velocity) / (g * dt)
}

/// Interfaces through the middle of elements, through nodes, and a hair beside them.
fn offsets<const D: usize>(node: f64) -> [f64; 7] {
    [0.35, 0.61, node, node + 1e-6, node + 1e-9, node - 1e-11, node + 1e-13]
}

#[test]
fn two_fluids_of_ratio_1000_stay_at_rest_wherever_the_interface_cuts() {
    let mesh = shaken(&Mesh::<2, 3>::block(Vector::ZERO, Vector([1.0, 1.3]), [7, 9]).unwrap(), 0.14);
    for normal in [Vector([0.0, 1.0]), Vector([0.6, 0.8])] {
        for offset in offsets::<2>(mesh.nodes()[30].dot(normal)) {
            for enrichment in [Enrichment::Kink, Enrichment::Jump] {
                for condition in [Condition::Slip, Condition::wall()] {
                    let speed = stirred(&mesh, normal, offset, enrichment, Mass::default(), condition);
                    assert!(speed < 1e-10, "{normal:?} {offset} {enrichment:?}: {speed:e}");
                }
            }
        }
    }
}

#[test]
fn two_fluids_of_ratio_1000_stay_at_rest_in_three_dimensions() {
    let mesh = shaken(&Mesh::<3, 4>::block(Vector::ZERO, Vector([1.0, 1.0, 1.3]), [3, 3, 4]).unwrap(), 0.33);
    for normal in [Vector([0.0, 0.0, 1.0]), Vector([0.48, 0.6, 0.64])] {
        let node = mesh.nodes()[37].dot(normal);
        for offset in offsets::<3>(node) {
            let speed = stirred(&mesh, normal, offset, Enrichment::Kink, Mass::default(), Condition::Slip);
            assert!(speed < 1e-10, "{normal:?} {offset}: {speed:e}");
        }
    }
}

/// A disc that is bent into an egg: no two of the facets around it are alike.
fn egg() -> Mesh<2, 3> {
    bent(&disc(5, 24), |x| Vector([x[0] + 0.15 * (x[0] * x[0] - x[1] * x[1]), x[1] + 0.3 * x[0] * x[1]]))
}

/// A block between curved faces.
fn cushion() -> Mesh<3, 4> {
    let block = shaken(&Mesh::<3, 4>::block(Vector::ZERO, Vector([1.0, 1.0, 1.3]), [3, 3, 4]).unwrap(), 0.33);
    let bulge = |a: f64, b: f64| 0.4 * a * (1.0 - a) + 0.3 * b * (1.2 - b);
    bent(&block, |x| {
        let out = |axis: usize| (2.0 * x[axis] - 1.0) * bulge(x[(axis + 1) % 3], x[(axis + 2) % 3]);
        Vector::from_fn(|axis| x[axis] + 0.5 * out(axis))
    })
}

/// The largest speed of a fluid at rest in a slip wall after some steps, over the time and gravity that acts along no
/// axis, and the force on the wall over the weight.
fn stirred_alone<const D: usize, const N: usize>(mesh: Mesh<D, N>) -> (f64, Vector<D>) {
    let (dt, steps) = (0.05, 20);
    let gravity = Vector::from_fn(|axis| [0.6, -0.8, 0.5][axis]);
    let physics = physics(vec![fluid("water", 1000.0, 1e-2)], std::array::from_fn(|axis| gravity[axis].into()));
    let sets = vec![set(&mesh, "all", Condition::Slip, |_| true)];
    let weight = gravity * (1000.0 * mesh.volume());
    let setup = setup(mesh, sets, physics, |_| 0, |_| Vector::ZERO);
    let mut pfem =
        Pfem2::new(Setup { linear: SolverOptions { tolerance: 1e-13, ..SolverOptions::default() }, ..setup });
    (0..steps).for_each(|k| pfem.step(f64::from(k) * dt, dt).unwrap());
    let speed = fastest(&pfem.system.velocity) / (gravity.norm() * f64::from(steps) * dt);
    (speed, (pfem.forces.on_parts.last[0] - weight) / weight.norm())
}

/// The nodes of a curved slip wall glide along directions that none of its facets has. The wall carries the fluid.
#[test]
fn a_fluid_in_a_curved_slip_wall_stays_at_rest() {
    let (speed, force) = stirred_alone(egg());
    assert!(speed < 1e-10 && force.norm() < 1e-10, "{speed:e} {force:?}");
    let (speed, force) = stirred_alone(cushion());
    assert!(speed < 1e-10 && force.norm() < 1e-10, "{speed:e} {force:?}");
}

/// A force that is the same everywhere has a potential; what is projected for the stabilisation is what it leaves over,
/// nothing.
#[test]
fn a_fluid_stays_at_rest_under_a_force_that_changes_in_time() {
    let (mesh, dt, steps) = (egg(), 0.05, 40);
    let physics = physics(vec![fluid("water", 1000.0, 1e-2)], ["3*sin(2*t)", "-10*cos(3*t)"].map(formula));
    let sets = vec![set(&mesh, "all", Condition::Slip, |_| true)];
    let setup = setup(mesh, sets, physics, |_| 0, |_| Vector::ZERO);
    let mut pfem =
        Pfem2::new(Setup { linear: SolverOptions { tolerance: 1e-13, ..SolverOptions::default() }, ..setup });
    (0..steps).for_each(|k| pfem.step(f64::from(k) * dt, dt).unwrap());
    let speed = fastest(&pfem.system.velocity);
    assert!(speed < 1e-10, "{speed:e}");
}

#[test]
fn two_fluids_in_a_curved_slip_wall_stay_at_rest() {
    let normal = Vector([0.6, 0.8]);
    for offset in offsets::<2>(egg().nodes()[30].dot(normal)) {
        for enrichment in [Enrichment::Kink, Enrichment::Jump] {
            let speed = stirred(&egg(), normal, offset, enrichment, Mass::default(), Condition::Slip);
            assert!(speed < 1e-10, "{offset} {enrichment:?}: {speed:e}");
        }
    }
    let speed =
        stirred(&cushion(), Vector([0.48, 0.6, 0.64]), 0.7, Enrichment::default(), Mass::default(), Condition::Slip);
    assert!(speed < 1e-10, "{speed:e}");
}

/// Without it they fall nearly freely, by g Δt in a step: what the enrichment is for (theory G.9).
#[test]
fn two_fluids_at_rest_fall_without_enrichment() {
    let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector([1.0, 1.3]), [7, 9]).unwrap();
    let speed = stirred(&mesh, Vector([0.0, 1.0]), 0.613, Enrichment::None, Mass::Lumped, Condition::Slip);
    assert!((0.9..1.05).contains(&speed), "{speed}");
}

/// The floor carries the water and what presses on it; the sides carry nothing downwards.
#[test]
fn an_open_box_carries_its_weight_on_its_floor() {
    let mesh = shaken(&Mesh::<2, 3>::block(Vector::ZERO, Vector([2.0, 1.0]), [8, 5]).unwrap(), 0.2);
    let sets = vec![
        set(&mesh, "floor", Condition::wall(), |x| x[1] == 0.0),
        set(&mesh, "sides", Condition::Slip, |x| x[0] == 0.0 || x[0] == 2.0),
        set(&mesh, "top", Condition::Pressure(500.0.into()), |x| x[1] == 1.0),
    ];
    let setup = setup(
        mesh,
        sets,
        physics(vec![fluid("water", 1000.0, 1e-3)], [0.0.into(), (-9.81).into()]),
        |_| 0,
        |_| Vector::ZERO,
    );
    let mut pfem = crate::pfem2::Pfem2::new(Setup {
        linear: SolverOptions { tolerance: 1e-13, ..SolverOptions::default() },
        ..setup
    });
    crate::simulation::Solver::step(&mut pfem, 0.0, 0.01).unwrap();
    let snapshot = crate::simulation::Solver::snapshot(&pfem);
    let force = |name: &str| snapshot.forces.iter().find(|(part, _)| part == name).unwrap().1;
    assert!((force("floor")[1] / -(1000.0 * 9.81 * 2.0 + 500.0 * 2.0) - 1.0).abs() < 1e-9, "{:?}", force("floor"));
    assert!(force("sides")[0].abs() < 1e-6);
}

/// Water under air at rest, with particles and a sharp level set.
fn at_rest<const D: usize, const N: usize>(mesh: Mesh<D, N>, height: f64) -> Pfem2<D, N> {
    let gravity = std::array::from_fn(|axis| Signal::Constant(if axis == D - 1 { -GRAVITY } else { 0.0 }));
    let fluids = vec![fluid("water", 1000.0, 1e-3), fluid("air", 1.0, 1e-5)];
    let sets = vec![set(&mesh, "all", Condition::Slip, |_| true)];
    let under = |x: Vector<D>| u8::from(x[D - 1] > height);
    let mut start = setup(mesh, sets, physics(fluids, gravity), under, |_| Vector::ZERO);
    let phi = |x: Vector<D>| x[D - 1] - height;
    start.level_set = Some(LevelSet::new(&start.mesh, 0, phi, &mut start.particles));
    start.linear = SolverOptions { tolerance: 1e-13, ..SolverOptions::default() };
    Pfem2::new(start)
}

/// The interface through nodes and along the facets of the mesh: after so many steps that depths have been measured
/// anew, nothing moves and no fluid has become the other.
fn rests_on_facets<const D: usize, const N: usize>(mesh: Mesh<D, N>, height: f64) {
    let exact: f64 = height / mesh.nodes().iter().map(|x| x[D - 1]).fold(0.0, f64::max);
    let volume: f64 = (0..mesh.elements().len()).map(|e| mesh.simplex(e).volume).sum();
    let mut pfem = at_rest(mesh, height);
    let dt = 0.01;
    for k in 0..12 {
        pfem.step(f64::from(k) * dt, dt).unwrap();
        let speed = fastest(&pfem.system.velocity);
        assert!(speed < 1e-10 * GRAVITY * dt, "{speed:e}");
        let water = negative_volume(&pfem.system.fluid_region(), &pfem.interface.level) / volume;
        assert!((water - exact).abs() < 1e-12, "{water} {exact}");
    }
    // Probes and pictures see it where it is.
    assert!(!pfem.interface.outline.position.is_empty());
    assert!(pfem.interface.outline.position.iter().all(|x| (x[D - 1] - height).abs() < 1e-12));
    let size: f64 = pfem.interface.outline.size.iter().sum();
    assert!((size - 1.0).abs() < 1e-12, "{size}");
    assert_eq!(pfem.notices(), Vec::<String>::new());
}

#[test]
fn an_interface_along_the_facets_of_the_mesh_stays_there() {
    rests_on_facets(Mesh::<2, 3>::block(Vector::ZERO, Vector([1.0, 1.25]), [8, 10]).unwrap(), 0.5);
    rests_on_facets(Mesh::<3, 4>::block(Vector::ZERO, Vector([1.0, 1.0, 1.25]), [4, 4, 5]).unwrap(), 0.5);
}

/// The interface through the middle of elements, above or below nodes by a hair, particles at odd places: after so many
/// steps that depths have been measured anew several times, nothing moves but by round-off of the linear solver.
fn rests_in_elements<const D: usize, const N: usize>(mesh: Mesh<D, N>, steps: u32) {
    let cell = 0.125;
    for part in [0.03, 0.31, 0.742] {
        let height = 0.5 + part * cell;
        let mut pfem = at_rest(mesh.clone(), height);
        let (dt, volume) = (0.01, negative_volume(&pfem.system.fluid_region(), &pfem.interface.level));
        for k in 0..steps {
            pfem.step(f64::from(k) * dt, dt).unwrap();
        }
        let speed = fastest(&pfem.system.velocity);
        assert!(speed < 1e-9 * GRAVITY * dt, "{part}: {speed:e}");
        let off = pfem.interface.outline.position.iter().map(|x| (x[D - 1] - height).abs()).fold(0.0, f64::max);
        assert!(off < 1e-9 * cell, "{part}: the interface is off by {off:e}");
        let change = negative_volume(&pfem.system.fluid_region(), &pfem.interface.level) / volume - 1.0;
        assert!(change.abs() < 1e-12, "{part}: {change:e}");
        assert_eq!(pfem.notices(), Vec::<String>::new());
    }
}

#[test]
fn an_interface_inside_elements_stays_there_over_many_steps() {
    rests_in_elements(Mesh::<2, 3>::block(Vector::ZERO, Vector([1.0, 1.25]), [8, 10]).unwrap(), 120);
    rests_in_elements(shaken(&Mesh::<2, 3>::block(Vector::ZERO, Vector([1.0, 1.25]), [8, 10]).unwrap(), 0.125), 60);
    rests_in_elements(Mesh::<3, 4>::block(Vector::ZERO, Vector([0.5, 0.5, 1.25]), [4, 4, 10]).unwrap(), 30);
}

/// Water reaches a little beyond a line of the mesh, or nearly to the next, and both fluids are stirred by a micrometre
/// per second: that stays what it was, however often it passes from the particles of the sliver to the nodes of the air
/// and back.
#[test]
fn stirred_slivers_of_water_and_air_do_not_grow() {
    for stabilisation in [Stabilisation::Oss, Stabilisation::ConsistentPspg, Stabilisation::Dynamic] {
        for height in [0.51, 0.525] {
            let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector([1.0, 1.0]), [10, 10]).unwrap();
            let fluids = vec![fluid("water", 1000.0, 1e-3), fluid("air", 1.0, 1e-5)];
            let physics = Physics { stabilisation, ..physics(fluids, [Signal::ZERO, Signal::Constant(-GRAVITY)]) };
            let sets = vec![set(&mesh, "all", Condition::Slip, |_| true)];
            let stirred = |x: Vector<2>| Vector([1e-6 * (37.0 * x[0]).sin() * (23.0 * x[1]).sin(), 0.0]);
            let mut setup = setup(mesh, sets, physics, |x| u8::from(x[1] > height), stirred);
            setup.level_set = Some(LevelSet::new(&setup.mesh, 0, |x: Vector<2>| x[1] - height, &mut setup.particles));
            let mut pfem = Pfem2::new(setup);
            (0..100).for_each(|k| pfem.step(0.01 * f64::from(k), 0.01).unwrap());
            let speed = fastest(&pfem.system.velocity);
            assert!(speed < 2e-6, "{stabilisation:?} {height}: {speed:e}");
        }
    }
}

#[test]
fn a_volume_that_could_not_be_kept_gives_a_notice() {
    let mut pfem = at_rest(Mesh::<2, 3>::block(Vector::ZERO, Vector([1.0, 1.25]), [8, 10]).unwrap(), 0.55);
    pfem.interface.kept_volume = pfem.interface.kept_volume.map(|volume| volume + 0.3);
    pfem.step(0.0, 0.01).unwrap();
    let said = pfem.notices();
    assert!(said.iter().any(|text| text.contains("volume of `water` could not be kept")), "{said:?}");
}

/// A viscous column, 0.5 wide and 0.8 high in a box of 1 under a light fluid, ends flat: (ρ₁ − ρ₂) g V falls by 0.2,
/// and the work is Σ m g y less than at the start to round-off, which the work on the velocity of the nodes isn't.
#[test]
fn the_work_of_gravity_is_the_loss_of_potential_energy() {
    let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector::splat(1.0), [20; 2]).unwrap();
    let sets = vec![set(&mesh, "all", Condition::Slip, |_| true)];
    let fluids = vec![fluid("column", 1000.0, 1000.0), fluid("light", 1.0, 1.0)];
    let surface = |x: Vector<2>| (x[0] - 0.5).max(x[1] - 0.8);
    let physics = physics(fluids, [0.0.into(), (-9.81).into()]);
    let mut setup = setup(mesh, sets, physics, |x| u8::from(surface(x) >= 0.0), |_| Vector::ZERO);
    setup.level_set = Some(LevelSet::new(&setup.mesh, 0, surface, &mut setup.particles));
    let mut pfem = Pfem2::new(setup);
    let height = |pfem: &Pfem2<2, 3>| -> f64 {
        let VelocityPressureSystem { mesh, contents, .. } = &pfem.system;
        let both = contents.elements.iter().zip(mesh.elements());
        both.flat_map(|(content, nodes)| (0..3).map(|k| content.mass[k] * mesh.nodes()[nodes[k] as usize][1])).sum()
    };
    let start = height(&pfem);
    for k in 0..60 {
        pfem.step(f64::from(k) * 0.2, 0.2).unwrap();
    }
    let lost = (start - height(&pfem)) * GRAVITY;
    assert!(
        (pfem.balance.ledger.external().gravity / lost - 1.0).abs() < 1e-9,
        "{} {lost}",
        pfem.balance.ledger.external().gravity
    );
    let work = pfem.balance.ledger.external().gravity / (999.0 * GRAVITY * 0.4 * 0.2);
    assert!((work - 1.0).abs() < 0.01, "{work}");
}
