//! Solids that meet themselves, each other and walls in water, in the plane and in space.

use super::*;
use crate::material::{Elastic, NeoHookean, PointLaw, Rigid, StVenantKirchhoff};
use crate::pfem2::Pfem2;
use crate::pfem2::solid::mesh::SolidMesh;
use crate::pfem2::solid::mesh::shapes::Fold;
use crate::pfem2::solid::setup::{HeldNodes, Inertia, SolidSetup, SurfaceCondition, SurfaceTraction};
use crate::pfem2::solid::structure::Structure;
use crate::simulation::Solver;

const GRAVITY: f64 = 9.81;

/// Water in a box from the origin, with solids; gravity acts along the last axis.
fn in_water<const D: usize, const N: usize>(
    (upper, cells): ([f64; D], [usize; D]),
    gravity: Signal,
    solids: Vec<SolidSetup<D>>,
) -> Pfem2<D, N> {
    let mesh = Mesh::<D, N>::block(Vector::ZERO, Vector(upper), cells).unwrap();
    let down = std::array::from_fn(|axis| if axis + 1 == D { gravity.clone() } else { Signal::ZERO });
    let water = Physics { stabilisation: Stabilisation::Dynamic, ..physics(vec![fluid("water", 1000.0, 1e-3)], down) };
    let sets = vec![set(&mesh, "all", Condition::Slip, |_| true)];
    let mut setup = setup(mesh, sets, water, |_| 0, |_| Vector::ZERO);
    setup.solids = Some(Structure::new(solids).unwrap());
    Pfem2::new(setup)
}

fn structure<const D: usize, const N: usize>(pfem: &Pfem2<D, N>) -> &Structure<D> {
    &pfem.solids.as_ref().unwrap().structure
}

/// Places of the nodes of a solid [m].
fn places<const D: usize, const N: usize>(pfem: &Pfem2<D, N>, solid: usize) -> Vec<Vector<D>> {
    structure(pfem).bodies().nth(solid).unwrap().positions()
}

/// The force of walls along the last axis [N].
fn floor<const D: usize, const N: usize>(pfem: &Pfem2<D, N>) -> f64 {
    let walls = &pfem.solids.as_ref().unwrap().last.contact_forces.walls;
    walls.iter().map(|force| force[D - 1]).sum()
}

/// Two blocks, twice as heavy as water, that begin on the floor and on each other: they stay half an element above what
/// they stand on, the floor bears their weight in water, and they gain no energy.
fn blocks_stand<const D: usize, const N: usize>(cells: usize, young: f64) {
    let gap = 0.5 / cells as f64;
    let block = |inset: f64, lower: f64, upper: f64| {
        let corner = |side: f64, height: f64| {
            Vector::from_fn(|axis| if axis + 1 == D { height } else { 0.5 + side * (0.5 - inset - 0.01 * axis as f64) })
        };
        let mesh = SolidMesh::block(corner(-1.0, lower), corner(1.0, upper), [1; D]).unwrap();
        let law: Box<dyn PointLaw> = match young == 0.0 {
            true => Box::new(Rigid { density: 2000.0 }),
            false => Box::new(StVenantKirchhoff { elastic: Elastic::new(2000.0, young, 0.3) }),
        };
        SolidSetup { friction: 0.3, ..SolidSetup::free("block", mesh, law) }
    };
    let blocks = vec![block(0.23, gap, 0.44), block(0.31, 0.44 + gap, 0.8)];
    let mut pfem = in_water::<D, N>(([1.0; D], [cells; D]), (-GRAVITY).into(), blocks);
    let weight = GRAVITY * structure(&pfem).mass() / 2.0;
    let (dt, mut force) = (0.005, 0.0);
    pfem.begin(0.0, dt).unwrap();
    for k in 0..30 {
        pfem.step(f64::from(k) * dt, dt).unwrap();
        force += if k >= 15 { floor(&pfem) / 15.0 } else { 0.0 };
    }
    let height = |solid: usize, pick: fn(f64, f64) -> f64| {
        places(&pfem, solid).into_iter().map(|x| x[D - 1]).reduce(pick).unwrap()
    };
    let gaps = [height(0, f64::min), height(1, f64::min) - height(0, f64::max)];
    let gained = pfem.balance.gained(&pfem.system);
    assert!((force / weight - 1.0).abs() < 0.03, "{young}: {force} {weight}");
    assert!(gaps.iter().all(|own| (own / gap - 1.0).abs() < 0.03), "{young}: {gaps:?} {gap}");
    assert!(gained < 1e-3 * weight * gap, "{young}: {gained}");
}

#[test]
fn blocks_stand_on_each_other_in_water_in_the_plane() {
    [1e7, 0.0].into_iter().for_each(|young| blocks_stand::<2, 3>(16, young));
}

#[test]
fn blocks_stand_on_each_other_in_water_in_space() {
    [1e7, 0.0].into_iter().for_each(|young| blocks_stand::<3, 4>(6, young));
}

/// A folded strip in water whose ends are pulled together: they meet and keep the gap, or less by what the load presses;
/// both arms go the same way, none of them through the other, the strip keeps its volume.
fn strip_folds<const D: usize, const N: usize>(cells: usize, elements: usize) {
    let gap = 0.5 / cells as f64;
    let fold = Fold { thickness: 0.1, inner: 0.07, arm: 0.36, width: 0.2 };
    let middle = Vector::from_fn(|axis| [0.4, 0.5, 0.2][axis]);
    let mesh = fold.mesh(elements, middle);
    let load = |side: f64| {
        let outer = |a: &u32| {
            let x = mesh.nodes[*a as usize];
            side * (x[1] - 0.5) > 0.9 * fold.thickness + fold.inner && x[0] > 0.6
        };
        let facets = (0..mesh.facets.len() as u32).filter(|f| mesh.facets[*f as usize].nodes.iter().all(outer));
        let traction = std::array::from_fn(|axis| if axis == 1 { (-side * 800.0).into() } else { Signal::ZERO });
        SurfaceTraction { facets: facets.collect(), traction }
    };
    let tractions = vec![load(-1.0), load(1.0)];
    assert!(tractions.iter().all(|load| !load.facets.is_empty()));
    let law = Box::new(NeoHookean { elastic: Elastic::new(1000.0, 1e5, 0.49) });
    let mut strip = SolidSetup { tractions, ..SolidSetup::free("strip", mesh.clone(), law) };
    strip.damping.mass = 8.0;
    let size = std::array::from_fn(|axis| if axis < 2 { 1.0 } else { 0.4 });
    let counts = std::array::from_fn(|axis| if axis < 2 { cells } else { 2 * cells / 5 });
    let mut pfem = in_water::<D, N>((size, counts), Signal::ZERO, vec![strip]);
    let inside = |side: f64| {
        let is_there = |a: &usize| (mesh.nodes[*a][1] - side * fold.inner - 0.5).abs() < 1e-9;
        (0..mesh.nodes.len()).filter(is_there).collect::<Vec<usize>>()
    };
    let (lower, upper) = (inside(-1.0), inside(1.0));
    let between = |pfem: &Pfem2<D, N>| {
        let places = places(pfem, 0);
        let pairs = lower.iter().flat_map(|a| upper.iter().map(|b| (*a, *b)));
        pairs.map(|(a, b)| (places[b] - places[a]).norm()).fold(f64::INFINITY, f64::min)
    };
    let (dt, mut least, mut gained) = (0.02, f64::INFINITY, f64::NEG_INFINITY);
    let start = structure(&pfem).volume(&places(&pfem, 0));
    for k in 0..40 {
        pfem.step(f64::from(k) * dt, dt).unwrap();
        (least, gained) = (least.min(between(&pfem)), gained.max(pfem.balance.gained(&pfem.system)));
    }
    let pushed: f64 = pfem.solids.as_ref().unwrap().last.contact_forces.solids.iter().map(|force| force.norm()).sum();
    let volume = structure(&pfem).volume(&places(&pfem, 0)) / start - 1.0;
    let middle: Vector<D> = places(&pfem, 0).into_iter().sum::<Vector<D>>() / mesh.nodes.len() as f64;
    assert!(pushed > 1.0 && least > 0.97 * gap, "{pushed} {least} {gap}");
    assert!(between(&pfem) < 1.05 * gap && gained < 0.0, "{} {gap} {gained}", between(&pfem));
    assert!(volume.abs() < 2e-3, "{volume:e}");
    assert!((middle[1] - 0.5).abs() < 0.05 * gap, "{middle:?}");
}

#[test]
fn a_strip_folds_in_water_in_the_plane() {
    strip_folds::<2, 3>(16, 12);
}

#[test]
fn a_strip_folds_in_water_in_space() {
    strip_folds::<3, 4>(10, 10);
}

/// A soft strip, an element thick, that is clamped above the floor and gets its weight slowly: it comes down in water
/// until its far part lies on the floor half an element above it, as in a gas (`contact`), by its weight less the
/// buoyancy: held up over L its support bears 2/3 of that part of it.
#[test]
fn a_strip_in_space_comes_down_in_water_and_lies_on_the_floor() {
    let (cell, width) = (0.0625, 0.1);
    let gap = 0.5 * cell;
    let [length, thickness, height, span]: [f64; 4] = [0.9, 0.065, 0.03, 0.5];
    let load = 1000.0 * GRAVITY * thickness;
    let stiffness = load * span.powi(4) / (72.0 * height);
    let lower = Vector([0.0, 0.075, gap + height]);
    let mesh = SolidMesh::block(lower, lower + Vector([length, width, thickness]), [14, 1, 1]).unwrap();
    let young = 12.0 * stiffness / thickness.powi(3);
    let law = Box::new(StVenantKirchhoff { elastic: Elastic::new(2000.0, young, 0.0) });
    let nodes = (0..mesh.nodes.len() as u32).filter(|a| mesh.nodes[*a as usize][0] < 1e-9).collect();
    let held = vec![HeldNodes { nodes, velocity: std::array::from_fn(|_| Some(Signal::ZERO)) }];
    let strip = SolidSetup { held, inertia: Inertia::QuasiStatic, ..SolidSetup::free("strip", mesh.clone(), law) };
    let gravity = formula("-9.81*min(t, 1)^2");
    let mut pfem = in_water::<3, 4>(([1.0, 0.25, 0.25], [16, 4, 4]), gravity, vec![strip]);
    for k in 0..24 {
        pfem.step(f64::from(k) * 0.05, 0.05).unwrap();
        let pushes = pfem.solids.as_ref().unwrap().last.contact_forces.walls.iter().map(|force| force[2]);
        let [least, most] = pushes.fold([0.0f64; 2], |[least, most], push| [least.min(push), most.max(push)]);
        assert!(least >= -1e-3 * most.max(1e-3 * load * length * width), "the floor pulls: {least} {most}");
    }
    let bears = floor(&pfem) / (load * length * width);
    let expected = 1.0 - 2.0 / 3.0 * span / length;
    let lowest = places(&pfem, 0).into_iter().map(|x| x[2]).fold(f64::INFINITY, f64::min);
    assert!((bears / expected - 1.0).abs() < 0.05, "{bears} {expected}");
    assert!((lowest / gap - 1.0).abs() < 0.03, "{lowest} {gap}");
}

/// The largest speed of the centres of mass of two blocks as heavy as the water around them, over that of free fall,
/// with this gap between them [m].
fn beside<const D: usize, const N: usize>(cells: usize, gap: f64, young: f64) -> f64 {
    let block = |lower: f64, upper: f64| {
        let mesh = SolidMesh::block(
            Vector::from_fn(|axis| if axis == 0 { lower } else { 0.33 }),
            Vector::from_fn(|axis| if axis == 0 { upper } else { 0.64 }),
            [2; D],
        );
        let law: Box<dyn PointLaw> = match young == 0.0 {
            true => Box::new(Rigid { density: 1000.0 }),
            false => Box::new(StVenantKirchhoff { elastic: Elastic::new(1000.0, young, 0.3) }),
        };
        SolidSetup { surface: SurfaceCondition::NoSlip, ..SolidSetup::free("block", mesh.unwrap(), law) }
    };
    let blocks = vec![block(0.21, 0.52), block(0.52 + gap, 0.83)];
    let mut pfem = in_water::<D, N>(([1.0; D], [cells; D]), (-GRAVITY).into(), blocks);
    let (dt, steps) = (0.01, 4);
    pfem.begin(0.0, dt).unwrap();
    let mut speed: f64 = 0.0;
    for k in 0..steps {
        pfem.step(f64::from(k) * dt, dt).unwrap();
        let structure = structure(&pfem);
        let momenta = structure.weighted_by_mass(&structure.state.velocity);
        let half = momenta.len() / 2;
        for own in [&momenta[..half], &momenta[half..]] {
            let momentum = Vector::<D>::from_fn(|axis| own.iter().skip(axis).step_by(D).sum());
            speed = speed.max(momentum.norm() / (0.5 * structure.mass()));
        }
    }
    speed / (GRAVITY * dt * f64::from(steps))
}

/// Blocks as heavy as water rest in it side by side, elastic and rigid, whether they touch, have a millionth or less
/// than a thousandth of an element between them, or a film. (Rigid ones that touch were driven apart with a tenth of
/// free fall while no film bore the pressure of the water between them.)
#[test]
fn blocks_rest_in_water_that_touch_or_nearly_do() {
    for young in [1e8, 0.0] {
        for parts in [0.0, 1e-6, 5e-4, 0.1, 0.45] {
            let plane = beside::<2, 3>(20, parts / 20.0, young);
            assert!(plane < 0.02, "{young} {parts}: {plane}");
        }
        let space = beside::<3, 4>(10, 0.0, young);
        assert!(space < 0.03, "{young}: {space}");
    }
}
