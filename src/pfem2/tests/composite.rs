//! Solids that are bonded, in fluids, against beams.

use super::solids::solid;
use super::*;
use crate::material::{Elastic, NeoHookean, Rigid, StVenantKirchhoff};
use crate::pfem2::Pfem2;
use crate::pfem2::solid::mesh::SolidMesh;
use crate::pfem2::solid::setup::{Plane, SolidSetup};
use crate::pfem2::solid::structure::Structure;
use crate::simulation::Solver;
use std::f64::consts::TAU;

/// A layer between two corners in plane stress without contraction, clamped at x = 0; of St. Venant & Kirchhoff's
/// material, or neo-Hookean.
fn layer(corners: [[f64; 2]; 2], counts: [usize; 2], young: f64, is_neo_hookean: bool) -> SolidSetup<2> {
    let mesh = SolidMesh::block(Vector(corners[0]), Vector(corners[1]), counts).unwrap();
    let own = solid(mesh, (young, 0.0), |x| [x[0] < 1e-9; 2], |_| Vector::ZERO);
    let elastic = Elastic::new(1000.0, young, 0.0);
    let law: Box<dyn crate::material::PointLaw> = match is_neo_hookean {
        true => Box::new(NeoHookean { elastic }),
        false => Box::new(StVenantKirchhoff { elastic }),
    };
    SolidSetup { law, plane: Plane::Stress, ..own }
}

/// Solids in a gas of this density [kg/m³] in a box of 1.25 m by 0.5 m, with a gravity [m/s²].
fn in_gas(structure: Structure<2>, density: f64, gravity: f64, start: InitialState) -> Pfem2<2, 3> {
    let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector([1.25, 0.5]), [30, 12]).unwrap();
    let mesh = shaken(&mesh, 1.0 / 24.0);
    let gas = physics(vec![fluid("gas", density, 1e-8)], [Signal::ZERO, (-gravity).into()]);
    let gas = Physics { stabilisation: Stabilisation::Dynamic, ..gas };
    let mut setup = setup(mesh, Vec::new(), gas, |_| 0, |_| Vector::ZERO);
    setup.solids = Some(structure);
    setup.start = start;
    Pfem2::new(setup)
}

/// Displacement of a node [m].
fn way(pfem: &Pfem2<2, 3>, at: [f64; 2]) -> Vector<2> {
    let structure = &pfem.solids.as_ref().unwrap().structure;
    let nodes: Vec<Vector<2>> = structure.setups().iter().flat_map(|setup| setup.mesh.nodes.iter().copied()).collect();
    let node = nodes.iter().position(|x| (*x - Vector(at)).norm() < 1e-9).unwrap();
    structure.state.displacement[node]
}

/// Length of the beams [m], the line at which two layers meet, and the lower side of both.
const LENGTH: f64 = 1.0;
const SEAM: f64 = 0.26;
const HEIGHT: [f64; 2] = [0.06, 0.04];

/// Σ E I about the axis through Σ E A y/Σ E A.
fn bending(young: [f64; 2]) -> f64 {
    let middle = [-0.5 * HEIGHT[0], 0.5 * HEIGHT[1]];
    let axial: f64 = young.iter().zip(HEIGHT).map(|(e, h)| e * h).sum();
    let axis = young.iter().zip(HEIGHT).zip(middle).map(|((e, h), y)| e * h * y).sum::<f64>() / axial;
    let part = |k: usize| young[k] * (HEIGHT[k].powi(3) / 12.0 + HEIGHT[k] * (middle[k] - axis).powi(2));
    part(0) + part(1)
}

/// A cantilever of two layers of other laws and moduli, meshes that don't match, sags under its weight in a gas by q
/// L⁴/(8 B), where it rests from the start; shear adds 4 B/(κ G A L²), a percent or so.
#[test]
fn a_strip_of_two_laws_sags_in_a_gas_as_a_beam_of_two_layers() {
    let (young, gas) = ([1e7, 4e7], 1.0);
    let lower = layer([[0.0, SEAM - HEIGHT[0]], [LENGTH, SEAM]], [12, 1], young[0], false);
    let upper = layer([[0.0, SEAM], [LENGTH, SEAM + HEIGHT[1]]], [9, 1], young[1], true);
    let structure = Structure::new(vec![lower, upper]).unwrap().bonded(&[[1, 0]]).unwrap();
    let gravity = 0.1;
    let mut pfem = in_gas(structure, gas, gravity, InitialState::Equilibrium);
    pfem.begin(0.0, 0.01).unwrap();
    let load = (1000.0 - gas) * gravity * (HEIGHT[0] + HEIGHT[1]);
    let exact = load * LENGTH.powi(4) / (8.0 * bending(young));
    let tip = [LENGTH, SEAM - HEIGHT[0]];
    let found = -way(&pfem, tip)[1] / exact - 1.0;
    (0..10).for_each(|k| pfem.step(0.01 * f64::from(k), 0.01).unwrap());
    let later = -way(&pfem, tip)[1] / exact - 1.0;
    assert!((0.0..0.01).contains(&found) && (later - found).abs() < 1e-5, "{found} {later}");
}

/// A rigid block on a soft stalk, clamped at its foot, that is let go: ω² = 3 E I/(L³ m) of a stalk without mass, less
/// what the turn of the block, whose middle is c beyond the tip, adds to it. With x = (w, φ) of the tip, K = E I/L³
/// [[12, −6 L], [−6 L, 4 L²]], M = m [[1, c], [c, c² + r²]].
#[test]
fn a_rigid_block_on_a_soft_stalk_swings_as_a_mass_on_a_beam() {
    let (young, thick, side, density) = (1e7, 0.04, 0.12, 2e5);
    let foot = 0.6;
    let stalk = layer([[0.0, SEAM - 0.5 * thick], [foot, SEAM + 0.5 * thick]], [10, 1], young, false);
    let mesh =
        SolidMesh::block(Vector([foot, SEAM - 0.5 * side]), Vector([foot + side, SEAM + 0.5 * side]), [2, 6]).unwrap();
    let mass = density * side * side;
    let (c, square, stiffness) = (0.5 * side, side * side / 6.0, young * thick.powi(3) / 12.0 / foot.powi(3));
    // det(K − λ M) = 0.
    let (k11, k12, k22) = (12.0 * stiffness, -6.0 * foot * stiffness, 4.0 * foot * foot * stiffness);
    let (m11, m12, m22) = (mass, mass * c, mass * (c * c + square));
    let a = m11 * m22 - m12 * m12;
    let b = k11 * m22 + k22 * m11 - 2.0 * k12 * m12;
    let d = k11 * k22 - k12 * k12;
    let omega = ((b - (b * b - 4.0 * a * d).sqrt()) / (2.0 * a)).sqrt();
    // The turn of the first motion per its way at the tip.
    let turn = (omega * omega * m11 - k11) / (k12 - omega * omega * m12);
    let speed = move |x: Vector<2>| Vector([-turn * (x[1] - SEAM), 1.0 + turn * (x[0] - foot)]) * 0.01;
    let mut block = solid(mesh, (1.0, 0.0), |_| [false; 2], speed);
    block.law = Box::new(Rigid { density });
    let structure = Structure::new(vec![stalk, block]).unwrap().bonded(&[[1, 0]]).unwrap();
    let (period, steps) = (TAU / omega, 100);
    let dt = period / f64::from(steps);
    let mut pfem = in_gas(structure, 1e-3, 0.0, InitialState::AsGiven);
    pfem.begin(0.0, dt).unwrap();
    let swing: Vec<f64> = (0..170)
        .map(|k| {
            pfem.step(f64::from(k) * dt, dt).unwrap();
            pfem.solids.as_ref().unwrap().structure.state.rigid[0].displacement[1]
        })
        .collect();
    let zero = |from: usize| {
        let k = (from..swing.len() - 1).find(|&k| swing[k] * swing[k + 1] <= 0.0).unwrap();
        (k as f64 + 1.0 + swing[k] / (swing[k] - swing[k + 1])) * dt
    };
    let measured = zero(120) - zero(20);
    assert!((measured / period - 1.0).abs() < 0.01, "{measured} {period}");
}
