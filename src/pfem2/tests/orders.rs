//! Oscillating shear of a viscous fluid by a rigid and by an elastic slab: errors against the exact solutions, and
//! their orders in the size of elements and of steps.
//!
//! ```text
//! fluid    u = Re [(P sinh ks + Q cosh ks) e^{iωt}],   k = √(iω/ν),   s = y − d above the surface of the slab
//! slab     a sin(k_s y) sin ωt,   k_s = ω √(ρ/G)
//! s = 0    Q = a ω sin k_s d,   μ k P = −i G k_s a cos k_s d         as fast, and with the same traction
//! ```
//!
//! A rigid slab with the velocity U cos ωt has Q = U, and P = −U coth kH where the fluid ends at a wall at s = H
//! (Stokes' second problem).

use super::complex::{Complex, over, times};
use super::solids::{bar, solid};
use super::*;
use crate::pfem2::Pfem2;
use crate::pfem2::solid::mesh::SolidMesh;
use crate::pfem2::solid::setup::{SolidSetup, SurfaceTraction};
use crate::pfem2::solid::structure::Structure;
use crate::simulation::Solver;
use std::f64::consts::TAU;

/// ω [1/s], and √(ω/2ν), the inverse of the depth to which the shear reaches [1/m].
const OMEGA: f64 = TAU;
const DEPTH: f64 = 4.0;

/// Height of the slab, of the fluid above it, length of both [m].
const SLAB: f64 = 0.31;
const FLUID: f64 = 1.0 - SLAB;
const LENGTH: f64 = 0.5;

/// Amplitude of the slab [m]: its way is far below the size of an element.
const AMPLITUDE: f64 = 1e-4;

/// k_s of the elastic slab [1/m].
const WAVE: f64 = 4.0;

/// Density of both [kg/m³], viscosity [Pa s], shear modulus of the elastic slab [Pa].
const DENSITY: f64 = 1000.0;
const VISCOSITY: f64 = DENSITY * OMEGA / (2.0 * DEPTH * DEPTH);
const SHEAR: f64 = DENSITY * OMEGA * OMEGA / (WAVE * WAVE);

/// sinh and cosh of ks = (1 + i) κ s.
fn hyperbolic(s: f64) -> [Complex; 2] {
    let ((sin, cos), x) = ((DEPTH * s).sin_cos(), DEPTH * s);
    [[x.sinh() * cos, x.cosh() * sin], [x.cosh() * cos, x.sinh() * sin]]
}

/// k [1/m].
const NUMBER: Complex = [DEPTH, DEPTH];

/// P and Q [m/s].
#[derive(Debug, Clone, Copy)]
struct Shear {
    p: Complex,
    q: Complex,
}

impl Shear {
    /// Above a rigid slab.
    fn rigid() -> Self {
        let q = [AMPLITUDE * OMEGA, 0.0];
        let [sinh, cosh] = hyperbolic(FLUID);
        Self { p: over(times([-q[0], 0.0], cosh), sinh), q }
    }

    /// Above an elastic one.
    fn elastic() -> Self {
        let traction = [0.0, -SHEAR * WAVE * AMPLITUDE * (WAVE * SLAB).cos()];
        let p = over(traction, times([VISCOSITY, 0.0], NUMBER));
        Self { p, q: [AMPLITUDE * OMEGA * (WAVE * SLAB).sin(), 0.0] }
    }

    fn velocity(&self, s: f64, t: f64) -> f64 {
        let [sinh, cosh] = hyperbolic(s);
        let [a, b] = [times(self.p, sinh), times(self.q, cosh)];
        (a[0] + b[0]) * (OMEGA * t).cos() - (a[1] + b[1]) * (OMEGA * t).sin()
    }

    /// μ k P [Pa]: its real part times cos ωt less its imaginary part times sin ωt is the traction on the slab.
    fn traction(&self) -> Complex {
        times([VISCOSITY, 0.0], times(NUMBER, self.p))
    }

    /// The velocity as a formula; below the surface that of the surface.
    fn formula(&self) -> Signal {
        let ([pr, pi], [qr, qi]) = (self.p, self.q);
        let x = format!("{DEPTH:?}*max(y-{SLAB:?},0)");
        let [sr, si] = [format!("sinh({x})*cos({x})"), format!("cosh({x})*sin({x})")];
        let [cr, ci] = [format!("cosh({x})*cos({x})"), format!("sinh({x})*sin({x})")];
        let real = format!("({pr:?})*{sr}-({pi:?})*{si}+({qr:?})*{cr}-({qi:?})*{ci}");
        let imaginary = format!("({pr:?})*{si}+({pi:?})*{sr}+({qr:?})*{ci}+({qi:?})*{cr}");
        formula(&format!("({real})*cos({OMEGA:?}*t)-({imaginary})*sin({OMEGA:?}*t)"))
    }
}

/// A slab that reaches `beyond` the mesh on both sides, with this velocity at the start; no node moves along y.
fn slab(elements: usize, velocity: impl Fn(f64) -> f64) -> SolidSetup<2> {
    let corners = [[-0.5 * LENGTH, 0.0], [1.5 * LENGTH, SLAB]].map(Vector);
    let mesh = SolidMesh::block(corners[0], corners[1], [4, elements]).unwrap();
    let young = 2.0 * SHEAR;
    solid(mesh, (young, 0.0), |x| [x[1] < 1e-9, true], |x| Vector([velocity(x[1]), 0.0]))
}

/// A slab that moves with the velocity AMPLITUDE ω cos ωt.
fn rigid_slab() -> SolidSetup<2> {
    let mut setup = slab(1, |_| AMPLITUDE * OMEGA);
    setup.held[0].nodes = setup.held[1].nodes.clone();
    setup.held[0].velocity[0] = Some(formula(&format!("{:?}*cos({OMEGA:?}*t)", AMPLITUDE * OMEGA)));
    setup
}

/// An elastic one, with the traction of the fluid where it is beyond the mesh.
fn elastic_slab(elements: usize) -> SolidSetup<2> {
    let mut setup = slab(elements, |y| AMPLITUDE * OMEGA * (WAVE * y).sin());
    let mesh = &setup.mesh;
    let beyond = |facet: &u32| {
        let nodes = &mesh.facets[*facet as usize].nodes;
        let at = |a: usize| mesh.nodes[nodes[a] as usize];
        (at(0)[1] - SLAB).abs() + (at(2)[1] - SLAB).abs() < 1e-9 && !(0.0..LENGTH).contains(&at(1)[0])
    };
    let facets = (0..mesh.facets.len() as u32).filter(beyond).collect();
    let [real, imaginary] = Shear::elastic().traction();
    let along = formula(&format!("({real:?})*cos({OMEGA:?}*t)-({imaginary:?})*sin({OMEGA:?}*t)"));
    setup.tractions = vec![SurfaceTraction { facets, traction: [along, Signal::ZERO] }];
    setup
}

/// The fluid above a slab, with `cells` elements per metre.
fn sheared(cells: usize, exact: Shear, slab: SolidSetup<2>) -> Pfem2<2, 3> {
    let size = 1.0 / cells as f64;
    let mesh = shaken(&Mesh::<2, 3>::block(Vector::ZERO, Vector([LENGTH, 1.0]), [cells / 2, cells]).unwrap(), size);
    let around = Condition::Wall([exact.formula(), Signal::ZERO]);
    let sets = vec![set(&mesh, "around", around, |x| x[0] < 1e-9 || x[0] > LENGTH - 1e-9 || x[1] > 1.0 - 1e-9)];
    let oil = Physics {
        stabilisation: Stabilisation::Dynamic,
        ..physics(vec![fluid("oil", DENSITY, VISCOSITY)], weightless())
    };
    let start = |x: Vector<2>| Vector([exact.velocity((x[1] - SLAB).max(0.0), 0.0), 0.0]);
    let mut setup = setup(mesh, sets, oil, |_| 0, start);
    setup.solids = Some(Structure::new(vec![slab]).unwrap());
    setup.linear = SolverOptions { tolerance: 1e-10, ..SolverOptions::default() };
    Pfem2::new(setup)
}

/// Errors of the velocity at the end, root mean square over the amplitude of the surface, and of the traction after the
/// first quarter of a turn, the largest over the amplitude, of `steps` steps in half a period.
fn errors(pfem: &mut Pfem2<2, 3>, exact: Shear, steps: usize) -> [f64; 2] {
    let dt = 0.5 / steps as f64;
    let [real, imaginary] = exact.traction();
    let mut traction = 0.0f64;
    for k in 0..steps {
        pfem.step(k as f64 * dt, dt).unwrap();
        let (sin, cos) = (OMEGA * (k + 1) as f64 * dt).sin_cos();
        let found = pfem.solids.as_ref().unwrap().last.forces.last[0][0] / LENGTH;
        if k >= steps / 2 {
            traction = traction.max((found - (real * cos - imaginary * sin)).abs() / real.hypot(imaginary));
        }
    }
    let distance = &pfem.system.immersed.as_ref().unwrap().cut.distance;
    let outside: Vec<usize> = (0..distance.len()).filter(|&i| distance[i] > 0.0).collect();
    let off = |&i: &usize| {
        let x = pfem.system.mesh.nodes()[i];
        (pfem.system.velocity[i] - Vector([exact.velocity(x[1] - SLAB, 0.5), 0.0])).norm_squared()
    };
    let mean = outside.iter().map(off).sum::<f64>() / outside.len() as f64;
    [mean.sqrt() / exact.q[0], traction]
}

/// Mean order of errors that follow one another, each with half the size.
fn order(errors: &[[f64; 2]]) -> [f64; 2] {
    let halvings = (errors.len() - 1) as f64;
    [0, 1].map(|k| (errors[0][k] / errors[errors.len() - 1][k]).log2() / halvings)
}

/// A rigid slab that is moved to and fro, and an elastic one that swings with the fluid: elements and steps of a half
/// and a quarter of the size. (From one to the next the order of the traction varies, as the surface lies at other
/// places in the elements.)
#[test]
fn the_shear_above_slabs_converges() {
    for (exact, slab) in [(Shear::rigid(), (|_| rigid_slab()) as fn(usize) -> _), (Shear::elastic(), elastic_slab)] {
        let errors = [8, 16, 32].map(|cells| errors(&mut sheared(cells, exact, slab(cells / 4)), exact, cells));
        let [velocity, traction] = order(&errors);
        assert!(velocity > 1.8 && traction > 1.0, "{velocity} {traction} {errors:?}");
    }
}

/// Iterations of the coupled system for a bar that pushes twice its mass of water, four steps from the start: 35, 43,
/// 51 and 51 for steps of a tenth, one, ten and a hundred times the time in which a wave crosses an element. As soon as
/// the stiffness rules they hardly grow any more.
#[test]
fn long_steps_take_hardly_more_iterations_than_steps_that_resolve_waves() {
    // Three elements over 0.1 m, E = 1 MPa, ρ = 1000 kg/m³.
    let crossing = 0.1 / 3.0 / (1e6_f64 / 1000.0).sqrt();
    let iterations = [1.0, 10.0, 100.0].map(|crossings| {
        let (dt, mut pfem) = (crossings * crossing, bar(4, 1e-3));
        let step = |k: u32| {
            pfem.step(f64::from(k) * dt, dt).unwrap();
            pfem.system.linear.outcome.iterations
        };
        (0..4).map(step).sum::<usize>()
    });
    let [least, most] = [iterations.iter().min(), iterations.iter().max()].map(|own| *own.unwrap());
    assert!(4 * most <= 5 * least, "{iterations:?}");
}
