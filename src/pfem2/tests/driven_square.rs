//! A rigid square that swings in a closed box of fluid: added mass and damping from its force, against potential flow.
//!
//! ```text
//! velocity V sin ωt,  F = −m_a a − c v       least squares over two periods, ωΔt = 0.1
//! no viscosity        m_a = 1.693 ρ b² in a box of 2.5 b, c = 0
//! ```

use super::*;
use crate::material::{Elastic, Rigid};
use crate::pfem2::Pfem2;
use crate::pfem2::particle_solids::setup::{HeldMeshNodes, ParticleSolidSetup, RateLaw};
use crate::pfem2::solid::mesh::SolidMesh;
use crate::pfem2::solid::setup::{Plane, PrescribedMotion, SolidSetup, SurfaceCondition};
use crate::pfem2::solid::structure::Structure;
use crate::simulation::Solver;
use std::f64::consts::TAU;

const DENSITY: f64 = 1000.0;

/// Speed [m/s] at ω = 1/s: the way is a hundred-thousandth of an element.
const SPEED: f64 = 1e-6;

/// Step [s].
const DT: f64 = 0.1;

/// Added mass over ρ b² and damping over ρ b² ω of a side b [m] with the force that `step` gives after the step from a
/// time [N].
fn fitted(side: f64, mut step: impl FnMut(f64) -> f64) -> [f64; 2] {
    // The first steps aren't of the second order.
    let (before, steps) = (10, (2.0 * TAU / DT).round() as usize);
    let mut sums = [[0.0; 2]; 2];
    let mut rhs = [0.0; 2];
    for k in 0..before + steps {
        let t = k as f64 * DT;
        let force = step(t);
        if k >= before {
            let own = [-(t + DT).cos() * SPEED, -(t + DT).sin() * SPEED];
            for i in 0..2 {
                (0..2).for_each(|j| sums[i][j] += own[i] * own[j]);
                rhs[i] += own[i] * force;
            }
        }
    }
    let determinant = sums[0][0] * sums[1][1] - sums[0][1] * sums[1][0];
    let solved = [
        (rhs[0] * sums[1][1] - rhs[1] * sums[0][1]) / determinant,
        (rhs[1] * sums[0][0] - rhs[0] * sums[1][0]) / determinant,
    ];
    solved.map(|value| value / (DENSITY * side * side))
}

/// A rigid square of 0.4 m in the middle of a box of 1 m, `cells` elements along its sides.
fn on_a_mesh(stabilisation: Stabilisation, scheme: Scheme, surface: SurfaceCondition, cells: usize) -> [f64; 2] {
    let mesh = Mesh::<2, 3>::block(Vector::splat(-0.5), Vector::splat(0.5), [cells; 2]).unwrap();
    let mesh = shaken(&mesh, 1.0 / cells as f64);
    let square = SolidMesh::block(Vector::splat(-0.2), Vector::splat(0.2), [2, 2]).unwrap();
    let sets = vec![set(&mesh, "all", Condition::Slip, |_| true)];
    swinging(mesh, square, sets, Choice { stabilisation, mass: Mass::Consistent, scheme, surface }, 0.4)
}

/// The choices of a case that added mass and damping depend on.
struct Choice {
    stabilisation: Stabilisation,
    mass: Mass,
    scheme: Scheme,
    surface: SurfaceCondition,
}

/// Added mass and damping of a rigid square of a side [m] that swings in a mesh.
fn swinging(
    mesh: Mesh<2, 3>,
    square: SolidMesh<2>,
    sets: Vec<BoundarySetup<2>>,
    Choice { stabilisation, mass, scheme, surface }: Choice,
    side: f64,
) -> [f64; 2] {
    let swing = formula(&format!("{SPEED:e}*sin(t)"));
    let motion =
        PrescribedMotion { velocity: [Some(swing), Some(Signal::ZERO), None], spin: [None, None, Some(Signal::ZERO)] };
    let own = SolidSetup::free("square", square, Box::new(Rigid { density: DENSITY }));
    let physics = physics(vec![fluid("water", DENSITY, 1e-9)], weightless());
    let physics = Physics { stabilisation, mass, ..physics };
    let mut setup = setup(mesh, sets, physics, |_| 0, |_| Vector::ZERO);
    setup.scheme = scheme;
    setup.solids = Some(Structure::new(vec![SolidSetup { motion, surface, ..own }]).unwrap());
    let mut pfem = Pfem2::new(setup);
    pfem.begin(0.0, DT).unwrap();
    fitted(side, |t| {
        pfem.step(t, DT).unwrap();
        pfem.solids.as_ref().unwrap().last.forces.last[0][0]
    })
}

/// The same of a square of side one in a box of 7, on lines of a mesh with 8 elements along it, where the fluid sticks
/// and nothing resolves its layer.
fn fitted_to_the_mesh(stabilisation: Stabilisation) -> [f64; 2] {
    let (fine, grown): (f64, f64) = (0.125, 1.2);
    let mut sizes: Vec<f64> = (1..60)
        .scan(fine, |size, _| {
            *size *= grown;
            Some(*size)
        })
        .collect();
    let count = (1..).find(|&n| sizes[..n].iter().sum::<f64>() > 2.4).unwrap();
    sizes.truncate(count);
    let scale = 2.5 / sizes.iter().sum::<f64>();
    let mut half: Vec<f64> = (0..=8).map(|k| f64::from(k) * fine).collect();
    sizes.iter().for_each(|size| half.push(half[half.len() - 1] + size * scale));
    let line: Vec<f64> = half[1..].iter().rev().map(|x| -x).chain(half.iter().copied()).collect();
    let mesh = Mesh::<2, 3>::lattice(&[line.clone(), line], crate::mesh::CellCut::Mirrored).unwrap();
    let square = SolidMesh::block(Vector::splat(-0.5), Vector::splat(0.5), [4, 4]).unwrap();
    let (scheme, surface) = (Scheme::BackwardEuler, SurfaceCondition::NoSlip);
    swinging(mesh, square, Vec::new(), Choice { stabilisation, mass: Mass::Lumped, scheme, surface }, 1.0)
}

/// Published (own finite elements, body-fitted, lumped masses): added mass and damping of a square in a box of seven of
/// its sides, two periods of backward Euler. The mesh here is coarser away from the square.
#[test]
fn a_square_has_the_published_added_mass_and_damping() {
    for (stabilisation, added, damping) in
        [(Stabilisation::Pspg, 1.77, 0.322), (Stabilisation::ConsistentPspg, 1.81, 0.183)]
    {
        let found = fitted_to_the_mesh(stabilisation);
        assert!((found[0] / added - 1.0).abs() < 0.04, "{stabilisation:?}: {found:?}");
        assert!((found[1] / damping - 1.0).abs() < 0.12, "{stabilisation:?}: {found:?}");
    }
}

/// The square has, where the fluid glides, the added mass of potential flow, and next to no damping with the default;
/// other subscales take a part of the motion. A step of backward Euler gives the force of half a step before, ½ ω Δt
/// m_a.
#[test]
fn a_square_that_glides_has_the_added_mass_of_potential_flow_and_no_damping() {
    let of =
        |stabilisation: Stabilisation, scheme: Scheme| on_a_mesh(stabilisation, scheme, SurfaceCondition::Slip, 20);
    let exact = 1.693;
    for (stabilisation, error, damping) in [(Stabilisation::Dynamic, 0.02, 0.004), (Stabilisation::Oss, 0.05, 0.06)] {
        let found = of(stabilisation, Scheme::default());
        assert!((found[0] / exact - 1.0).abs() < error, "{stabilisation:?}: {found:?}");
        assert!(found[1] >= 0.0 && found[1] < damping, "{stabilisation:?}: {found:?}");
    }
    let [own, backward] = [Scheme::default(), Scheme::BackwardEuler].map(|scheme| of(Stabilisation::Dynamic, scheme));
    let more = (backward[1] - own[1]) / (0.5 * DT * own[0]);
    assert!((more - 1.0).abs() < 0.03, "{own:?} {backward:?}");
}

/// A stiff square on particles of a side of one in a box of 7, `n` elements along it, its surface in the middle of
/// elements; the choices of the paper. Nodes at least one element below its surface are held.
fn on_particles(stabilisation: Stabilisation, n: usize, speed: &str) -> Pfem2<2, 3> {
    let h = 1.0 / n as f64;
    let mesh = Mesh::<2, 3>::block(Vector::splat(0.0), Vector::splat(7.0), [7 * n; 2]).unwrap();
    // Half an element off the lines of the mesh.
    let centre = Vector::<2>::splat(3.5 + 0.5 * h);
    let inside = move |x: Vector<2>, by: f64| (0..2).all(|k| (x[k] - centre[k]).abs() < 0.5 - by);
    let nodes = (0..mesh.nodes().len() as u32).filter(|&i| inside(mesh.nodes()[i as usize], 0.9 * h)).collect();
    let held = vec![HeldMeshNodes { nodes, velocity: [Some(formula(speed)), Some(Signal::ZERO)] }];
    let law = RateLaw::new(DENSITY, Elastic::new(DENSITY, 1e8, 0.3).moduli(), Plane::Strain);
    let sets = vec![set(&mesh, "all", Condition::Slip, |_| true)];
    let physics = physics(vec![fluid("water", DENSITY, 1e-9)], weightless());
    let physics = Physics { stabilisation, mass: Mass::Lumped, enrichment: Enrichment::Kink, ..physics };
    let setup = setup(mesh, sets, physics, move |x| u8::from(inside(x, 0.0)), |_| Vector::ZERO);
    Pfem2::new(Setup {
        particle_solids: vec![ParticleSolidSetup { name: "square".into(), law, held }],
        scheme: Scheme::BackwardEuler,
        kernel: AveragingKernel::Shape,
        volume: VolumeCorrection::None,
        unresolved: Unresolved::Kept,
        reseeding: Reseeding::Elements,
        projectile_ratio: 10.0,
        ..setup
    })
}

/// The residual of the paper's stabilisation lacks its inertia: the fluid keeps its volume for the velocity of a time τ
/// before, which damps by ω τ m_a, τ ≈ Δt, beside what backward Euler and the rest do.
#[test]
fn the_stabilisation_of_the_paper_damps_a_square_by_its_delay() {
    let [own, orthogonal] = [Stabilisation::Pspg, Stabilisation::Oss].map(|stabilisation| {
        let mut pfem = on_particles(stabilisation, 3, &format!("{SPEED:e}*sin(t)"));
        fitted(1.0, |t| {
            pfem.step(t, DT).unwrap();
            pfem.system.particle_solids.as_ref().unwrap().forces[0][0]
        })
    });
    let delay = (own[1] - orthogonal[1]) / (DT * own[0]);
    assert!((0.7..1.1).contains(&delay), "{own:?} {orthogonal:?}");
}
