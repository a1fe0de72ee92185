//! Solids that meet each other, themselves and walls, elastic and rigid, against closed forms.

use super::solids::{CELLS, GAP, solid, water};
use super::*;
use crate::material::{Elastic, NeoHookean, Rigid, StVenantKirchhoff};
use crate::pfem2::Pfem2;
use crate::pfem2::solid::mesh::SolidMesh;
use crate::pfem2::solid::setup::{HeldNodes, Inertia, SolidSetup, SurfaceTraction};
use crate::pfem2::solid::structure::Structure;
use crate::pfem2::solid::surface::tests::disc;
use crate::simulation::Solver;

/// A block of elements between two corners, with a modulus [Pa] or rigid (0), a coefficient of friction and a speed
/// [m/s].
fn block(corners: [[f64; 2]; 2], counts: [usize; 2], young: f64, friction: f64, speed: [f64; 2]) -> SolidSetup<2> {
    let mesh = SolidMesh::block(Vector(corners[0]), Vector(corners[1]), counts).unwrap();
    let mut block = solid(mesh, (young.max(1.0), 0.0), |_| [false; 2], |_| Vector(speed));
    block.friction = friction;
    if young == 0.0 {
        block.law = Box::new(Rigid { density: 1000.0 });
    }
    block
}

/// A gas a thousand times lighter than the solids, with this gravity [m/s²].
fn gas(gravity: [f64; 2]) -> Physics<2> {
    let fluids = physics(vec![fluid("gas", 1.0, 1e-5)], gravity.map(Signal::from));
    Physics { stabilisation: Stabilisation::Dynamic, ..fluids }
}

/// A stiff block that lands on the floor in the third of steps of 0.01 s, in which waves cross it a hundred times.
pub fn landing() -> Pfem2<2, 3> {
    let block = block([[0.35, GAP + 0.012], [0.65, GAP + 0.212]], [3, 2], 1e9, 0.3, [0.0, -0.5]);
    in_gas(vec![block], [0.0, -9.81])
}

/// Solids in a box of side 1 full of it.
fn in_gas(solids: Vec<SolidSetup<2>>, gravity: [f64; 2]) -> Pfem2<2, 3> {
    in_fluid(Structure::new(solids).unwrap(), gas(gravity))
}

fn in_fluid(structure: Structure<2>, physics: Physics<2>) -> Pfem2<2, 3> {
    in_fluid_within(SolverOptions::default().tolerance, structure, physics)
}

/// With this tolerance of the linear solver.
fn in_fluid_within(tolerance: f64, structure: Structure<2>, physics: Physics<2>) -> Pfem2<2, 3> {
    Pfem2::new(setup_in_fluid(tolerance, structure, physics))
}

fn setup_in_fluid(tolerance: f64, structure: Structure<2>, physics: Physics<2>) -> Setup<2, 3> {
    let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector([1.0, 1.0]), [CELLS; 2]).unwrap();
    let mut setup = setup(mesh, Vec::new(), physics, |_| 0, |_| Vector::ZERO);
    setup.solids = Some(structure);
    setup.linear = SolverOptions { tolerance, ..SolverOptions::default() };
    setup
}

fn structure(pfem: &Pfem2<2, 3>) -> &Structure<2> {
    &pfem.solids.as_ref().unwrap().structure
}

/// Places of the nodes of a solid [m].
fn places(pfem: &Pfem2<2, 3>, solid: usize) -> Vec<Vector<2>> {
    structure(pfem).bodies().nth(solid).unwrap().positions()
}

/// Mean velocity of the nodes of a solid [m/s].
fn velocity(pfem: &Pfem2<2, 3>, solid: usize) -> Vector<2> {
    let body = structure(pfem).bodies().nth(solid).unwrap();
    body.velocity.iter().copied().sum::<Vector<2>>() / body.velocity.len() as f64
}

fn lowest(places: &[Vector<2>]) -> f64 {
    places.iter().map(|x| x[1]).fold(f64::INFINITY, f64::min)
}

fn highest(places: &[Vector<2>]) -> f64 {
    places.iter().map(|x| x[1]).fold(f64::NEG_INFINITY, f64::max)
}

fn advance(pfem: &mut Pfem2<2, 3>, dt: f64, steps: u32) {
    (0..steps).for_each(|k| pfem.step(f64::from(k) * dt, dt).unwrap());
}

/// A rigid block that meets an elastic one within a few steps.
pub fn meeting() -> Pfem2<2, 3> {
    let lower = block([[0.25, GAP], [0.75, 0.2 + GAP]], [4, 2], 1e6, 0.5, [0.0; 2]);
    let upper = block([[0.35, 0.205 + 2.0 * GAP], [0.6, 0.45]], [3, 2], 0.0, 0.5, [0.1, -0.5]);
    in_gas(vec![lower, upper], [0.0, -9.81])
}

/// A block that falls on another comes to rest half an element above it, elastic or rigid; the floor bears both.
#[test]
fn a_block_that_falls_on_another_rests_half_an_element_above_it() {
    for young in [1e7, 0.0] {
        let lower = block([[0.25, GAP], [0.75, 0.2 + GAP]], [4, 2], young, 0.5, [0.0; 2]);
        let upper = block([[0.35, 0.3], [0.6, 0.5]], [3, 2], young, 0.5, [0.0; 2]);
        let mut pfem = in_gas(vec![lower, upper], [0.0, -9.81]);
        let (dt, mut force) = (0.005, 0.0);
        for k in 0..200 {
            pfem.step(f64::from(k) * dt, dt).unwrap();
            let contact = &pfem.solids.as_ref().unwrap().last.contact_forces.walls;
            force += if k >= 160 { contact.iter().map(|force| force[1]).sum::<f64>() / 40.0 } else { 0.0 };
        }
        let weight = 9.81 * 1000.0 * (0.5 * 0.2 + 0.25 * 0.2);
        assert!((force / weight - 1.0).abs() < 0.02, "{young}: {force} {weight}");
        let gap = lowest(&places(&pfem, 1)) - highest(&places(&pfem, 0));
        assert!((gap / GAP - 1.0).abs() < 0.05, "{young}: {gap} {GAP}");
        assert!(velocity(&pfem, 1).norm() < 5e-3, "{young}: {:?}", velocity(&pfem, 1));
    }
}

/// Forces of contact add up to nothing over a pair that collides: what the solids gain of momentum is what the fluid
/// gives, to rounding.
#[test]
fn contacts_leave_the_momentum_of_a_pair() {
    let left = block([[0.2, 0.4], [0.45, 0.6]], [4, 2], 1e6, 0.3, [1.0, 0.0]);
    let right = block([[0.5, 0.43], [0.75, 0.63]], [3, 2], 1e6, 0.3, [-1.0, 0.3]);
    // The gas gives a small part of the momentum that a step solves for.
    let mut pfem = in_fluid_within(1e-12, Structure::new(vec![left, right]).unwrap(), gas([0.0; 2]));
    let (dt, mut largest) = (5e-4, 0.0f64);
    for k in 0..60 {
        pfem.step(f64::from(k) * dt, dt).unwrap();
        let solids = pfem.solids.as_ref().unwrap();
        let inertia = structure(&pfem).weighted_by_mass(&structure(&pfem).state.acceleration);
        let gained = Vector::<2>::from_fn(|axis| inertia.iter().skip(axis).step_by(2).sum());
        let given: Vector<2> = solids.last.forces.last.iter().copied().sum();
        let pushed: f64 = solids.last.contact_forces.solids.iter().map(|force| force.norm()).sum();
        largest = largest.max(pushed);
        let size: f64 = inertia.iter().map(|force| force.abs()).sum();
        assert!((gained - given).norm() < 1e-9 * size, "{gained:?} {given:?} {pushed}");
    }
    assert!(largest > 1e3, "they met: {largest}");
}

/// Two equal bars that meet end to end exchange their speeds within two transits of their waves (St. Venant), if steps
/// resolve them.
#[test]
fn two_equal_bars_exchange_their_speeds() {
    let (length, young, speed) = (0.3, 1e6, 0.5);
    let transit = length / (young / 1000.0_f64).sqrt();
    let first = 0.15 + length;
    let bar = |x: f64, v: f64| block([[x, 0.4], [x + length, 0.6]], [12, 2], young, 0.0, [v, 0.0]);
    let mut pfem = in_gas(vec![bar(0.15, speed), bar(first + GAP + 0.005, 0.0)], [0.0; 2]);
    let dt = transit / 40.0;
    advance(&mut pfem, dt, ((0.005 / speed + 4.0 * transit) / dt) as u32);
    let [own, other] = [0, 1].map(|solid| velocity(&pfem, solid)[0] / speed);
    assert!(own.abs() < 0.08 && (0.9..1.02).contains(&other), "{own} {other}");
}

/// A bar that meets a wall with its end comes back with the speed with which it came (St. Venant), in steps that its
/// errors and what it comes near to decide about: a thirtieth of the waves' transit where it meets the wall, and
/// longer than it on the way. What lacks is left at the release, and in the gas between the two.
#[test]
fn a_bar_bounces_in_automatic_steps() {
    let (length, young, speed, way) = (0.3, 1e6, 0.5, 0.1);
    let transit = length / (young / 1000.0_f64).sqrt();
    let bar = block([[GAP + way, 0.4], [GAP + way + length, 0.6]], [12, 2], young, 0.0, [-speed, 0.0]);
    let mut automatic =
        setup_in_fluid(SolverOptions::default().tolerance, Structure::new(vec![bar]).unwrap(), gas([0.0; 2]));
    (automatic.courant, automatic.step_tolerance) = (3.0, 2.0);
    let mut pfem = Pfem2::new(automatic);
    let (mut t, mut dt, mut longest) = (0.0, 0.0, 0.0_f64);
    while t < way / speed + 3.0 * transit {
        dt = pfem.recommended_dt().min(if dt > 0.0 { pfem.largest_change() * dt } else { 0.01 });
        pfem.step(t, dt).unwrap();
        (t, longest) = (t + dt, longest.max(dt));
    }
    let own = velocity(&pfem, 0)[0] / speed;
    assert!((0.95..1.0).contains(&own) && longest > transit, "{own} {longest}");
}

/// A block on a slab that is held slides if and only if the slope is steeper than the root of the product of both
/// coefficients.
#[test]
fn a_block_slides_on_a_slab_only_if_it_is_steeper_than_the_friction_of_both() {
    let friction: [f64; 2] = [0.45, 0.2];
    let both = (friction[0] * friction[1]).sqrt();
    for young in [1e7, 0.0] {
        let way = |slope: f64| {
            let (sin, cos) = slope.atan().sin_cos();
            let mut slab = block([[0.1, 0.2], [0.9, 0.4]], [6, 2], 1e8, friction[0], [0.0; 2]);
            slab.held[0].nodes = (0..slab.mesh.nodes.len() as u32).collect();
            slab.held[1].nodes = slab.held[0].nodes.clone();
            let own = block([[0.2, 0.4 + GAP], [0.5, 0.55 + GAP]], [3, 2], young, friction[1], [0.0; 2]);
            let mut pfem = in_gas(vec![slab, own], [9.81 * sin, -9.81 * cos]);
            let mean =
                |pfem: &Pfem2<2, 3>| places(pfem, 1).iter().map(|x| x[0]).sum::<f64>() / places(pfem, 1).len() as f64;
            let start = mean(&pfem);
            let (dt, steps) = (0.004, 60);
            advance(&mut pfem, dt, steps);
            let time = dt * f64::from(steps);
            (mean(&pfem) - start, 0.5 * 9.81 * (sin - both * cos).max(0.0) * time * time)
        };
        let (rest, _) = way(0.25);
        assert!(rest.abs() < 0.05 * GAP, "{young}: {rest}");
        let (slid, expected) = way(0.6);
        assert!((slid / expected - 1.0).abs() < 0.06, "{young}: {slid} {expected}");
    }
}

/// A block that its friction holds on an incline stays where it is, elastic or rigid: in 100 steps its foot moves by
/// less than three ten-thousandths of the gap.
#[test]
fn a_block_that_friction_holds_does_not_creep() {
    let friction: f64 = 0.4;
    let (sin, cos) = (0.8 * friction).atan().sin_cos();
    for young in [1e7, 0.0] {
        let own = block([[0.2, GAP], [0.5, GAP + 0.15]], [3, 2], young, friction, [0.0; 2]);
        let foot: Vec<usize> = (0..own.mesh.nodes.len()).filter(|&node| own.mesh.nodes[node][1] < GAP + 1e-9).collect();
        let mut pfem = in_gas(vec![own], [9.81 * sin, -9.81 * cos]);
        let mut after = || {
            advance(&mut pfem, 0.002, 100);
            foot.iter().map(|&node| places(&pfem, 0)[node][0]).sum::<f64>() / foot.len() as f64
        };
        let way = [after(), after()];
        assert!((way[1] - way[0]).abs() < 3e-4 * GAP, "{young}: {way:?}");
    }
}

/// Water rests around a rigid block that lies on the floor, to a ten-thousandth of free fall: the impulses of the floor
/// give it no motion (theory (J.16c)).
#[test]
fn water_rests_around_a_rigid_block_that_lies_on_the_floor() {
    let mut own = block([[0.31, GAP], [0.69, GAP + 0.22]], [4, 2], 0.0, 0.3, [0.0; 2]);
    own.law = Box::new(Rigid { density: 2500.0 });
    let water = Physics { fluids: vec![fluid("water", 1000.0, 1e-3)], ..gas([0.0, -9.81]) };
    let mut pfem = in_fluid(Structure::new(vec![own]).unwrap(), water);
    for k in 0..100 {
        pfem.step(f64::from(k) * 0.002, 0.002).unwrap();
        let fastest = pfem.system.velocity.iter().map(|v| v.norm()).fold(0.0, f64::max);
        // In the first steps the block settles.
        assert!(k < 9 || fastest < 1e-4 * 9.81 * 0.002 * f64::from(k + 1), "{k}: {fastest}");
    }
}

/// A rigid block that lies on the floor leaves it in the step in which gravity turns: the floor never pulls. Its force
/// was found from those of the step before, and held the block for a step more.
#[test]
fn the_floor_does_not_hold_a_rigid_block_that_leaves_it() {
    let own = block([[0.31, GAP], [0.69, GAP + 0.22]], [4, 2], 0.0, 0.3, [0.0; 2]);
    let turning = Physics { gravity: [Signal::ZERO, formula("-9.81 + 39.24*step(t - 0.0595)")], ..gas([0.0; 2]) };
    let mut pfem = in_fluid(Structure::new(vec![own]).unwrap(), turning);
    for k in 0..30 {
        pfem.step(f64::from(k) * 0.002, 0.002).unwrap();
        let forces = &pfem.solids.as_ref().unwrap().last.contact_forces.walls;
        let pull = forces.iter().fold(0.0, |least: f64, force| least.min(force[1]));
        assert!(pull > -0.1, "step {k}: {pull} of {} N", 9.81 * 1000.0 * 0.38 * 0.22);
    }
    // The part θ of 3 g, and that of the free fall before, without the impulse of the floor.
    let Scheme::SecondOrder { theta } = Scheme::default() else { return };
    let expected = (3.0 * theta - (1.0 - theta)) * 9.81 * 0.002;
    let speed = velocity(&pfem, 0)[1];
    assert!((speed / expected - 1.0).abs() < 0.02, "{speed}, expected {expected}");
}

/// A rigid disc of radius 0.15 m on an incline rolls with (2/3) g sin θ where tan θ < 3 μ, and else slides with g (sin
/// θ − μ cos θ) and turns up with 2 μ g cos θ/R.
#[test]
fn a_disc_rolls_down_an_incline_and_slides_where_friction_does_not_hold_it() {
    let (radius, friction) = (0.15, 0.3);
    let run = |slope: f64| {
        let (sin, cos) = slope.atan().sin_cos();
        let mut mesh = disc(3);
        mesh.nodes.iter_mut().for_each(|x| *x = *x * radius + Vector([0.25, radius + GAP]));
        let mut disc = solid(mesh, (1.0, 0.0), |_| [false; 2], |_| Vector::ZERO);
        (disc.law, disc.friction) = (Box::new(Rigid { density: 1000.0 }), friction);
        let mut pfem = in_gas(vec![disc], [9.81 * sin, -9.81 * cos]);
        let (dt, steps) = (0.004, 75);
        advance(&mut pfem, dt, steps);
        let state = structure(&pfem).state.rigid[0];
        let time = dt * f64::from(steps);
        let rolling = sin < 3.0 * friction * cos;
        let fall = if rolling { 2.0 / 3.0 * sin } else { sin - friction * cos };
        let turn = if rolling { fall / radius } else { 2.0 * friction * cos / radius };
        (state.velocity[0][0] / (9.81 * fall * time), -state.spin[0][2] / (9.81 * turn * time))
    };
    let (speed, spin) = run(0.5);
    assert!((speed - 1.0).abs() < 0.06 && (spin - 1.0).abs() < 0.08, "rolls {speed} {spin}");
    let (speed, spin) = run(1.8);
    assert!((speed - 1.0).abs() < 0.06 && (spin - 1.0).abs() < 0.12, "slides {speed} {spin}");
}

/// Distance of a place from a segment [m].
fn segment(x: Vector<2>, [start, end]: [Vector<2>; 2]) -> f64 {
    let along = end - start;
    let t = ((x - start).dot(along) / along.norm_squared()).clamp(0.0, 1.0);
    (x - start - along * t).norm()
}

/// A strip bent into a U whose ends are pulled together: they meet, and keep the gap, or less by what the load presses.
#[test]
fn a_strip_that_folds_meets_itself() {
    let (thickness, inner, arm, shorter) = (0.1, 0.12, 0.4, 0.08);
    let mut mesh = SolidMesh::block(Vector([0.0, 0.0]), Vector([1.0, thickness]), [14, 1]).unwrap();
    let (middle, half) = (inner + 0.5 * thickness, std::f64::consts::PI * (inner + 0.5 * thickness));
    let total = 2.0 * arm + half - shorter;
    for x in &mut mesh.nodes {
        // Along the middle line from the end of the lower arm; across outward.
        let (s, out) = (x[0] * total, x[1] - 0.5 * thickness);
        let place = match s {
            s if s < arm => Vector([arm - s, -middle - out]),
            s if s > arm + half => Vector([s - arm - half, middle + out]),
            s => {
                let angle = -0.5 * std::f64::consts::PI - (s - arm) / middle;
                Vector([angle.cos(), angle.sin()]) * (middle + out)
            }
        };
        *x = place + Vector([0.4, 0.5]);
    }
    let mut strip = solid(mesh, (1e5, 0.0), |_| [false; 2], |_| Vector::ZERO);
    let mesh = &strip.mesh;
    let on = |upper: bool| {
        let outer =
            move |x: Vector<2>| (x[1] - 0.5).abs() > inner + 0.9 * thickness && x[0] > 0.6 && (x[1] > 0.5) == upper;
        let held = |f: &u32| mesh.facets[*f as usize].nodes.iter().all(|&a| outer(mesh.nodes[a as usize]));
        (0..mesh.facets.len() as u32).filter(held).collect::<Vec<u32>>()
    };
    let load = |upper: bool, y: f64| SurfaceTraction { facets: on(upper), traction: [Signal::ZERO, y.into()] };
    strip.tractions = vec![load(true, -300.0), load(false, 300.0)];
    assert!(strip.tractions.iter().all(|load| !load.facets.is_empty()));
    strip.law = Box::new(NeoHookean { elastic: Elastic::new(1000.0, 1e5, 0.0) });
    strip.damping.mass = 8.0;
    let mut pfem = in_gas(vec![strip], [0.0; 2]);
    // From the nodes of the upper arm's inner face to the line through those of the lower one's.
    let gap = |pfem: &Pfem2<2, 3>| {
        let (places, reference) = (places(pfem, 0), &structure(pfem).setups()[0].mesh.nodes);
        let face = |y: f64| {
            let on = |a: &usize| (reference[*a][1] - y).abs() < 1e-9 && reference[*a][0] > 0.5;
            let mut own: Vec<usize> = (0..places.len()).filter(on).collect();
            own.sort_by(|a, b| reference[*a][0].total_cmp(&reference[*b][0]));
            own.into_iter().map(|a| places[a]).collect::<Vec<_>>()
        };
        let lower = face(0.5 - inner);
        let from = |x: Vector<2>| lower.windows(2).map(move |ends| segment(x, [ends[0], ends[1]]));
        face(0.5 + inner).into_iter().flat_map(from).fold(f64::INFINITY, f64::min)
    };
    let mut least = f64::INFINITY;
    for k in 0..220 {
        pfem.step(0.004 * f64::from(k), 0.004).unwrap();
        least = least.min(gap(&pfem));
    }
    let pushed: f64 = pfem.solids.as_ref().unwrap().last.contact_forces.solids.iter().map(|force| force.norm()).sum();
    assert!(pushed > 10.0 && least > 0.5 * GAP, "{pushed} {least}");
    assert!((gap(&pfem) / GAP - 1.0).abs() < 0.15, "{} {GAP}", gap(&pfem));
}

/// Blocks that start a fifth of an element from each other keep this distance, under a weight and without.
#[test]
fn solids_that_start_close_keep_their_distance() {
    let start = 0.2 / CELLS as f64;
    for gravity in [0.0, -9.81] {
        let lower = block([[0.25, GAP], [0.75, 0.2 + GAP]], [4, 2], 1e7, 0.5, [0.0; 2]);
        let upper = block([[0.35, 0.2 + GAP + start], [0.6, 0.4]], [3, 2], 1e7, 0.5, [0.0; 2]);
        let mut pfem = in_gas(vec![lower, upper], [0.0, gravity]);
        advance(&mut pfem, 0.005, 60);
        let gap = lowest(&places(&pfem, 1)) - highest(&places(&pfem, 0));
        assert!((gap / start - 1.0).abs() < 0.1, "{gravity}: {gap} {start}");
    }
}

/// A soft column that stands clamped on the floor is pressed together by a tenth at its foot by its own weight, and
/// the nodes above it, which start little over half an element away, come nearer: the floor bears it through
/// the support alone.
#[test]
fn a_column_is_compressed_at_its_foot_without_contact() {
    let rows = (0.4 / (2.1 * GAP)) as usize;
    let mesh = SolidMesh::block(Vector([0.3, 0.0]), Vector([0.7, 0.4]), [4, rows]).unwrap();
    let spacing = 0.4 / (2 * rows) as f64;
    assert!(spacing > GAP && spacing < 1.09 * GAP, "{spacing} {GAP}");
    let young = 9.81 * 1000.0 * 0.4 / 0.1;
    let column = solid(mesh, (young, 0.0), |x| [x[1] < 1e-9; 2], |_| Vector::ZERO);
    let mut pfem = in_gas(vec![column], [0.0, -9.81]);
    let mut lowest_ring = f64::INFINITY;
    for k in 0..40 {
        pfem.step(f64::from(k) * 0.005, 0.005).unwrap();
        let above = places(&pfem, 0).into_iter().map(|x| x[1]).filter(|y| *y > 0.5 * GAP);
        lowest_ring = above.fold(lowest_ring, f64::min);
        let contact = &pfem.solids.as_ref().unwrap().last.contact_forces.walls;
        assert!(contact.iter().all(|force| *force == Vector::ZERO), "{k}: {contact:?}");
    }
    assert!(lowest_ring < 0.97 * GAP, "{lowest_ring} {GAP}");
}

/// Extremes: a modulus of 1e12 Pa in air, ten thousand times the density of the fluid and a ten-thousandth, and a plate
/// half as thick as an element. They fall as the closed form says where the fluid doesn't count, and rise where it
/// carries them.
#[test]
fn solids_of_extreme_stiffness_density_and_thickness_fall_and_rise() {
    let fall = |density: f64, fluid_density: f64, young: f64, height: f64| {
        let mut own = block([[0.3, 0.5], [0.6, 0.5 + height]], [3, 2], young, 0.0, [0.0; 2]);
        own.law = match young == 0.0 {
            true => Box::new(Rigid { density }),
            false => Box::new(StVenantKirchhoff { elastic: Elastic::new(density, young, 0.0) }),
        };
        let own = Structure::new(vec![own]).unwrap();
        let medium = Physics {
            stabilisation: Stabilisation::Dynamic,
            ..physics(vec![fluid("fluid", fluid_density, 1e-5)], [0.0, -9.81].map(Signal::from))
        };
        let mut pfem = in_fluid(own, medium);
        advance(&mut pfem, 0.005, 20);
        velocity(&pfem, 0)[1] / (-9.81 * 0.1)
    };
    for (density, young) in [(1000.0, 1e12), (1e4, 1e7), (1e4, 0.0)] {
        let part = fall(density, 1.0, young, 0.2);
        assert!((0.98..1.0).contains(&part), "{density} {young}: {part}");
    }
    // Less than g times the ratio of the densities less one, more than nothing: the added mass is many times its own.
    for young in [1e7, 0.0] {
        let rise = -fall(0.1, 1000.0, young, 0.2);
        assert!((0.1..10.0).contains(&rise), "{young}: {rise}");
    }
    let thin = fall(1000.0, 1.0, 1e9, GAP);
    assert!((0.9..1.0).contains(&thin), "{thin}");
}

/// A rigid disc as heavy as the water around it hovers, as an elastic one does.
#[test]
fn a_rigid_disc_as_heavy_as_the_water_hovers() {
    let mut mesh = disc(3);
    mesh.nodes.iter_mut().for_each(|x| *x = *x * 0.2 + Vector([0.47, 0.52]));
    let mut disc = solid(mesh, (1.0, 0.0), |_| [false; 2], |_| Vector::ZERO);
    disc.law = Box::new(Rigid { density: 1000.0 });
    let mut pfem = in_fluid(Structure::new(vec![disc]).unwrap(), water([Signal::ZERO, (-9.81).into()]));
    advance(&mut pfem, 0.01, 20);
    let force = pfem.solids.as_ref().unwrap().last.forces.last[0];
    let weight = 9.81 * structure(&pfem).mass();
    assert!((force[1] / weight - 1.0).abs() < 0.02 && force[0].abs() < 0.01 * weight, "{force:?} {weight}");
    let gained = pfem.balance.gained(&pfem.system);
    assert!(gained.abs() < 0.05 * weight * 0.2, "{gained}");
}

/// A block that lands in a step that doesn't resolve its impact stays: the floor gives it the impulse that it had, and
/// no more.
#[test]
fn a_stiff_block_that_lands_stays() {
    let (mut pfem, dt, mass, speed) = (landing(), 0.01, 1000.0 * 0.3 * 0.2, 0.5);
    let mut impulse = 0.0;
    for k in 0..20 {
        pfem.step(f64::from(k) * dt, dt).unwrap();
        let pushes = &pfem.solids.as_ref().unwrap().last.contact_forces.walls;
        assert!(pushes.iter().all(|push| push[1] >= -1e-6 * mass * speed / dt), "{k}: {pushes:?}");
        impulse += dt * pushes.iter().map(|push| push[1]).sum::<f64>();
        if k >= 4 {
            assert!(velocity(&pfem, 0)[1].abs() < 0.01 * speed, "{k}: {:?}", velocity(&pfem, 0));
        }
    }
    let given = mass * (speed + 9.81 * 20.0 * dt);
    assert!((impulse / given - 1.0).abs() < 0.02, "{impulse} {given}");
    assert!((lowest(&places(&pfem, 0)) / GAP - 1.0).abs() < 1e-3, "{}", lowest(&places(&pfem, 0)) / GAP);
}

/// A soft strip that is clamped above the floor and gets its weight slowly comes down until its far part lies on
/// the floor. With the bending stiffness E I, the weight q per length and the height h it is held up over L = (72 E I
/// h/q)^¼, as w = w' = w'' = 0 where it lands; at the distance s from there w = h − (q/E I) (L s³/18 − s⁴/24), and its
/// support bears 2/3 q L.
#[test]
fn a_strip_that_comes_down_lies_on_the_floor() {
    let [length, thickness, height, span]: [f64; 4] = [0.8, 0.03, 0.03, 0.4];
    let load = 1000.0 * 9.81 * thickness;
    let stiffness = load * span.powi(4) / (72.0 * height);
    let lower = Vector([0.0, GAP + height]);
    let mesh = SolidMesh::block(lower, lower + Vector([length, thickness]), [32, 2]).unwrap();
    let strip = solid(mesh, (12.0 * stiffness / thickness.powi(3), 0.0), |x| [x[0] < 1e-9; 2], |_| Vector::ZERO);
    let strip = SolidSetup { inertia: Inertia::QuasiStatic, ..strip };
    let gravity = [Signal::ZERO, formula("-9.81*min(t, 1)^2")];
    let mut pfem = in_fluid(Structure::new(vec![strip]).unwrap(), Physics { gravity, ..gas([0.0; 2]) });
    for k in 0..42 {
        pfem.step(f64::from(k) * 0.025, 0.025).unwrap();
        let pushes = pfem.solids.as_ref().unwrap().last.contact_forces.walls.iter().map(|force| force[1]);
        let [least, most] = pushes.fold([0.0f64; 2], |[least, most], push| [least.min(push), most.max(push)]);
        assert!(least >= -1e-3 * most, "the floor pulls: {least} {most}");
    }
    let floor = pfem.solids.as_ref().unwrap().last.contact_forces.walls.iter().map(|force| force[1]).sum::<f64>()
        / (load * length);
    assert!((floor / (1.0 - 2.0 / 3.0 * span / length) - 1.0).abs() < 0.01, "{floor}");
    let mesh = &structure(&pfem).setups()[0].mesh;
    for (start, end) in mesh.nodes.iter().zip(places(&pfem, 0)).filter(|(start, _)| start[1] == lower[1]) {
        let s = (span - start[0]).max(0.0);
        let down = height - load / stiffness * (span * s.powi(3) / 18.0 - s.powi(4) / 24.0);
        assert!((start[1] - end[1] - down).abs() < 0.015 * height, "{}: {} {down}", start[0], start[1] - end[1]);
    }
}

/// A block that its support drives through another one, which is held: the run stops once a node is deeper than the
/// gap behind its surface, and says which of both it is.
#[test]
fn a_run_stops_where_a_solid_is_driven_through_another() {
    let held = |corners, velocity: [f64; 2]| {
        let mut own = block(corners, [2, 2], 1e6, 0.0, velocity);
        let nodes = (0..own.mesh.nodes.len() as u32).collect();
        own.held = vec![HeldNodes { nodes, velocity: velocity.map(|v| Some(v.into())) }];
        own
    };
    let blocks = vec![held([[0.2, 0.42], [0.4, 0.62]], [1.0, 0.0]), held([[0.5, 0.33], [0.7, 0.73]], [0.0; 2])];
    let mut pfem = in_gas(blocks, [0.0; 2]);
    let dt = 0.01;
    pfem.begin(0.0, dt).unwrap();
    let error = (0..30).find_map(|k| pfem.step(f64::from(k) * dt, dt).err().map(|error| (k, error)));
    let (k, error) = error.expect("it is through");
    let message = error.to_string();
    assert!(message.contains("has gone through the surface of"), "{message}");
    let depth = f64::from(k + 1) * dt - 0.1;
    assert!(depth > GAP && depth < GAP + 2.0 * dt, "{depth} {GAP}");
}
