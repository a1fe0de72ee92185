//! The same bits after a restart and for any number of threads: solids in space, bonds, automatic steps, impacts, films,
//! springs, solids without inertia, gases that make room, steps that are solved again.

use super::solids::solid;
use super::*;
use crate::material::{Elastic, Rigid, StVenantKirchhoff};
use crate::pfem2::Pfem2;
use crate::pfem2::solid::mesh::SolidMesh;
use crate::pfem2::solid::setup::{Inertia, SolidSetup, SpringSupport, SurfaceCondition};
use crate::pfem2::solid::structure::Structure;
use crate::simulation::{Column, Solver};

/// All columns, byte by byte.
fn bytes<const D: usize, const N: usize>(pfem: &mut Pfem2<D, N>) -> Vec<(String, Vec<u8>)> {
    let mut columns = Vec::new();
    pfem.columns(&mut |name, column| columns.push((name.to_owned(), column.data.bytes().to_vec())));
    columns
}

/// What a run did that was saved and resumed.
pub struct Resumed {
    /// How often its steps were solved.
    pub solutions: usize,
    /// The time at its end [s].
    pub end: f64,
    /// Sums of the forces of walls and of solids on solids when it was saved [N].
    pub pushes: [f64; 2],
}

/// Sums of the forces of walls and of solids on solids [N].
fn pushes<const D: usize, const N: usize>(pfem: &Pfem2<D, N>) -> [f64; 2] {
    let forces = &pfem.solids.as_ref().unwrap().last.contact_forces;
    [&forces.walls, &forces.solids].map(|forces| forces.iter().map(|force| force.norm()).sum())
}

/// Goes on for some steps, of `dt` [s] or as long as the run would have them from step to step; returns the time, and
/// how often steps were solved.
fn advance<const D: usize, const N: usize>(
    pfem: &mut Pfem2<D, N>,
    dt: Option<f64>,
    mut t: f64,
    steps: usize,
) -> (f64, usize) {
    let mut solutions = 0;
    for _ in 0..steps {
        let own = dt.unwrap_or_else(|| pfem.recommended_dt());
        pfem.step(t, own).unwrap();
        t += own;
        solutions += pfem.solids.as_ref().unwrap().last.solutions;
    }
    (t, solutions)
}

/// A run of eight steps, and one that is saved after four and goes on in a model made anew; with other numbers of
/// threads.
pub fn goes_on_with_the_same_bits<const D: usize, const N: usize>(
    case: impl Fn() -> Pfem2<D, N> + Sync,
    dt: Option<f64>,
) -> Resumed {
    let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let first = dt.unwrap_or(0.005);
    let (saved, half, whole, end, solutions, pushes) = pool(1).install(|| {
        let mut whole = case();
        whole.begin(0.0, first).unwrap();
        let (half, before) = advance(&mut whole, dt, 0.0, 4);
        let (saved, pushes) = (bytes(&mut whole), pushes(&whole));
        let (end, after) = advance(&mut whole, dt, half, 4);
        (saved, half, bytes(&mut whole), end, before + after, pushes)
    });
    let (resumed, resumed_end) = pool(2).install(|| {
        let mut resumed = case();
        let mut next = saved.iter();
        resumed.columns(&mut |name, column: Column<'_>| {
            let (saved, bytes) = next.next().unwrap();
            assert_eq!(saved, name);
            assert!(column.data.replace(bytes));
        });
        resumed.restored();
        assert!(bytes(&mut resumed) == saved);
        let (end, _) = advance(&mut resumed, dt, half, 4);
        (bytes(&mut resumed), end)
    });
    let differing: Vec<&str> = whole.iter().zip(&resumed).filter(|(a, b)| a != b).map(|(a, _)| a.0.as_str()).collect();
    assert!(differing.is_empty(), "{differing:?}");
    assert_eq!(end.to_bits(), resumed_end.to_bits());
    Resumed { solutions, end, pushes }
}

/// A soft block in water in space that begins to sink and is sheared.
fn block_in_space() -> Pfem2<3, 4> {
    let mesh = Mesh::<3, 4>::block(Vector::ZERO, Vector([1.0; 3]), [5; 3]).unwrap();
    let mesh = shaken(&mesh, 0.2);
    let own = SolidMesh::block(Vector([0.3, 0.31, 0.35]), Vector([0.7, 0.66, 0.72]), [2, 1, 1]).unwrap();
    let law = Box::new(StVenantKirchhoff { elastic: Elastic::new(2000.0, 1e5, 0.3) });
    let velocity = own.nodes.iter().map(|x| Vector([0.3 * x[2], 0.0, -0.1])).collect();
    let own = SolidSetup { velocity, surface: SurfaceCondition::Slip, ..SolidSetup::free("block", own, law) };
    let physics = physics(vec![fluid("water", 1000.0, 1e-3)], [Signal::ZERO, Signal::ZERO, (-9.81).into()]);
    let physics = Physics { stabilisation: Stabilisation::Dynamic, ..physics };
    let mut setup = setup(mesh, Vec::new(), physics, |_| 0, |_| Vector::ZERO);
    setup.solids = Some(Structure::new(vec![own]).unwrap());
    Pfem2::new(setup)
}

/// Water in the plane with solids.
pub fn in_water(structure: Structure<2>, gravity: f64, change: impl FnOnce(&mut Setup<2, 3>)) -> Pfem2<2, 3> {
    let mesh = shaken(&Mesh::<2, 3>::block(Vector::ZERO, Vector([1.0, 0.6]), [15, 9]).unwrap(), 1.0 / 15.0);
    let physics = super::solids::water([Signal::ZERO, (-gravity).into()]);
    let mut setup = setup(mesh, Vec::new(), physics, |_| 0, |_| Vector::ZERO);
    setup.solids = Some(structure);
    change(&mut setup);
    Pfem2::new(setup)
}

/// A beam that is clamped at the left, and swings.
pub fn beam(young: f64, speed: f64) -> SolidSetup<2> {
    let mesh = SolidMesh::block(Vector([0.0, 0.27]), Vector([0.6, 0.34]), [6, 1]).unwrap();
    solid(mesh, (young, 0.3), |x| [x[0] < 1e-9; 2], move |x| Vector([0.0, speed * x[0] * x[0]]))
}

/// The same with a rigid block bonded to its end.
fn hammer() -> Structure<2> {
    let mesh = SolidMesh::block(Vector([0.6, 0.2]), Vector([0.74, 0.41]), [1, 3]).unwrap();
    let mut block = solid(mesh, (1.0, 0.0), |_| [false; 2], |_| Vector([0.0, 0.1]));
    block.law = Box::new(Rigid { density: 3000.0 });
    Structure::new(vec![beam(1e6, 0.3), block]).unwrap().bonded(&[[1, 0]]).unwrap()
}

#[test]
fn a_solid_in_space_goes_on_with_the_same_bits() {
    goes_on_with_the_same_bits(block_in_space, Some(0.005));
}

#[test]
fn bonded_solids_go_on_with_the_same_bits() {
    goes_on_with_the_same_bits(|| in_water(hammer(), 9.81, |_| ()), Some(0.005));
}

/// Subscales that keep their velocity, in steps as long as the errors have them.
#[test]
fn automatic_steps_beside_a_solid_go_on_with_the_same_bits() {
    let case = || {
        in_water(Structure::new(vec![beam(1e6, 1.0)]).unwrap(), 9.81, |setup| {
            setup.step_tolerance = 2.0;
            setup.courant = 2.0;
        })
    };
    let Resumed { end, .. } = goes_on_with_the_same_bits(case, None);
    assert!(end.is_finite());
}

/// A block that flies against a wall in a gas, in steps that errors and the impact decide about: saved amid the impact.
#[test]
fn an_impact_in_automatic_steps_goes_on_with_the_same_bits() {
    let mesh = SolidMesh::block(Vector([0.053, 0.2]), Vector([0.353, 0.4]), [3, 2]).unwrap();
    let block = || solid(mesh.clone(), (1e6, 0.3), |_| [false; 2], |_| Vector([-1.0, 0.0]));
    let case = || {
        in_water(Structure::new(vec![block()]).unwrap(), 0.0, |setup| {
            setup.fluids = vec![fluid("gas", 1.0, 1e-5)];
            (setup.step_tolerance, setup.courant) = (2.0, 2.0);
        })
    };
    let Resumed { end, .. } = goes_on_with_the_same_bits(case, None);
    // Without the impact each of the eight steps is about 13 ms long.
    assert!(end < 0.04, "{end}");
}

/// Two soft blocks nearer to each other than an element, a film between them, one of them on a spring and both without
/// inertia or with it, in a gas that makes room for them.
#[test]
fn solids_beside_each_other_in_a_gas_go_on_with_the_same_bits() {
    let blocks = |inertia: Inertia| {
        let mesh = |x: f64| SolidMesh::block(Vector([x, 0.2]), Vector([x + 0.2, 0.41]), [2, 2]).unwrap();
        let mut on_spring = solid(mesh(0.21), (1e6, 0.3), |_| [false; 2], |_| Vector([0.4, 0.0]));
        on_spring.springs =
            vec![SpringSupport { weights: vec![(0, 0.5), (2, 0.5)], stiffness: [200.0; 2], damping: [1.0; 2] }];
        let mut held = solid(mesh(0.44), (1e6, 0.3), |x| [x[0] > 0.639; 2], |_| Vector::ZERO);
        held.inertia = inertia;
        Structure::new(vec![on_spring, held]).unwrap()
    };
    for inertia in [Inertia::Dynamic, Inertia::QuasiStatic] {
        let case = || in_water(blocks(inertia), 9.81, |setup| setup.fluids = vec![fluid("gas", 1.0, 1e-5)]);
        goes_on_with_the_same_bits(case, Some(0.005));
    }
}

/// A soft beam that is so fast that its steps are solved anew about where it comes to.
#[test]
fn steps_that_are_solved_again_go_on_with_the_same_bits() {
    let case = || {
        in_water(Structure::new(vec![beam(1e6, 1.0)]).unwrap(), 0.0, |setup| {
            setup.fluids = vec![fluid("gas", 1.0, 1e-5)];
            setup.gravity[1] = formula("200*sin(150*t)");
        })
    };
    let Resumed { solutions, .. } = goes_on_with_the_same_bits(case, Some(0.01));
    assert!(solutions > 10, "{solutions}");
}
