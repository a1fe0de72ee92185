//! Bonded solids against closed forms.

use super::*;
use crate::material::Rigid;

/// A block of elements between two corners of a material with Poisson's ratio zero, in plane stress, held along x (and
/// along y at one corner) at x = 0, with a traction [Pa] at x = `end`.
fn layer(corners: [[f64; 2]; 2], counts: [usize; 2], young: f64, traction: [f64; 2], end: f64) -> SolidSetup<2> {
    let mesh = SolidMesh::block(Vector(corners[0]), Vector(corners[1]), counts).unwrap();
    let mut setup = solid(mesh, [1000.0, young, 0.0], |x| x[0] == 0.0);
    setup.plane = Plane::Stress;
    let at_end =
        |facet: &SolidFacet| facet.nodes.iter().all(|&a| (setup.mesh.nodes[a as usize][0] - end).abs() < 1e-12);
    let facets = (0..setup.mesh.facets.len() as u32).filter(|&f| at_end(&setup.mesh.facets[f as usize])).collect();
    setup.tractions = vec![SurfaceTraction { facets, traction: traction.map(Signal::from) }];
    setup
}

/// Two layers of one and three parts of the stiffness in tension, meshes that match and meshes that don't: both have
/// the strain N/Σ E A, whatever of the load they bear themselves.
#[test]
fn two_layers_in_tension_have_one_strain() {
    for counts in [[8, 1], [5, 2]] {
        let (young, load) = ([1e6, 3e6], 100.0);
        let strain = load / (0.1 * young[0] + 0.1 * young[1]);
        // Each bears what its stiffness asks for.
        let traction = |e: f64| [e * strain, 0.0];
        let lower = layer([[0.0, 0.0], [1.0, 0.1]], [8, 1], young[0], traction(young[0]), 1.0);
        let upper = layer([[0.0, 0.1], [1.0, 0.2]], counts, young[1], traction(young[1]), 1.0);
        let mut structure = Structure::new(vec![lower, upper]).unwrap().bonded(&[[0, 1]]).unwrap();
        assert_eq!(structure.ties.count(), 17);
        structure.equilibrium(0.0, |_| Vector::ZERO).unwrap();
        for (x, u) in structure.nodes.iter().zip(&structure.state.displacement) {
            // Of large strains: Green's is what St. Venant and Kirchhoff's law takes, to first order.
            assert!((u[0] - strain * x[0]).abs() < 5.0 * strain * strain && u[1].abs() < 1e-9, "{x:?} {u:?} {strain}");
        }
    }
}

/// A cantilever of two layers with a force at its end: F L³/(3 B) with B = Σ E I about the axis through Σ E A y/Σ E A,
/// and the shear of the mean modulus.
#[test]
fn a_beam_of_two_layers_bends_as_one_about_its_weighted_axis() {
    for counts in [[20, 1], [14, 1]] {
        let (young, height, length, load) = ([1e6, 4e6], [0.06, 0.04], 2.0, 1e-3);
        let lower = layer([[0.0, 0.0], [length, height[0]]], [20, 1], young[0], [0.0, -load], length);
        let upper = layer([[0.0, height[0]], [length, 0.1]], counts, young[1], [0.0, -load], length);
        let mut structure = Structure::new(vec![lower, upper]).unwrap().bonded(&[[1, 0]]).unwrap();
        structure.equilibrium(0.0, |_| Vector::ZERO).unwrap();
        let middle = [0.5 * height[0], height[0] + 0.5 * height[1]];
        let axial: f64 = young.iter().zip(height).map(|(e, h)| e * h).sum();
        let axis = young.iter().zip(height).zip(middle).map(|((e, h), y)| e * h * y).sum::<f64>() / axial;
        let part = |k: usize| young[k] * (height[k].powi(3) / 12.0 + height[k] * (middle[k] - axis).powi(2));
        let bending = part(0) + part(1);
        let exact = load * 0.1 * length.powi(3) / (3.0 * bending);
        let tip = structure.nodes.iter().position(|x| (*x - Vector([length, 0.0])).norm() < 1e-12).unwrap();
        let error = -structure.state.displacement[tip][1] / exact - 1.0;
        // Shear adds 3 B/(κ G A L²), 0.2 % or so.
        assert!((-0.001..0.006).contains(&error), "{counts:?} {error}");
    }
}

/// A heavy rigid block at the end of a light bar, along the bar: ω² = E A/(L m), and a third of the bar's mass to the
/// block's.
#[test]
fn a_rigid_block_at_the_end_of_a_bar_swings_as_a_mass_on_a_spring() {
    let (young, length, height) = (1e6, 1.0, 0.1);
    let bar = layer([[0.0, 0.0], [length, height]], [6, 1], young, [0.0; 2], length);
    let mesh = SolidMesh::block(Vector([length, 0.0]), Vector([length + 0.1, height]), [1, 2]).unwrap();
    let mut block = solid(mesh, [1e5, 1.0, 0.0], |_| false);
    block.law = Box::new(Rigid { density: 1e5 });
    block.velocity.fill(Vector([0.01, 0.0]));
    let mass = 1e5 * 0.1 * height + 1000.0 * length * height / 3.0;
    let omega = (young * height / length / mass).sqrt();
    let dt = 2.0 * std::f64::consts::PI / omega / 100.0;
    // The bar names the block, and follows it.
    let structure = Structure::new(vec![bar, block]).unwrap().bonded(&[[1, 0]]).unwrap();
    let mut run = SolidsAlone::of(structure, dt, 0.6);
    let mut way = vec![0.0];
    for _ in 0..110 {
        run.solve_alone(Vector::ZERO);
        way.push(run.structure.state.rigid[0].displacement[0]);
    }
    let crossing = |from: usize| {
        let k = (from..way.len() - 1).find(|&k| way[k] * way[k + 1] < 0.0).unwrap();
        (k as f64 + way[k] / (way[k] - way[k + 1])) * dt
    };
    let period = 2.0 * (crossing(80) - crossing(30));
    assert!((period * omega / (2.0 * std::f64::consts::PI) - 1.0).abs() < 2e-3, "{period}");
    let of = |solid: usize| {
        run.structure.positions(&run.structure.state.displacement)[run.structure.nodes_of(solid)].to_vec()
    };
    let (bar, block) = (of(0), of(1));
    let end = bar.iter().filter(|x| (x[0] - block[0][0]).abs() < 1e-12).count();
    assert_eq!(end, 3);
}

#[test]
fn solids_apart_and_two_rigid_ones_cannot_be_bonded() {
    let at = |x: f64| layer([[x, 0.0], [x + 1.0, 0.1]], [4, 1], 1e6, [0.0; 2], x + 1.0);
    let apart = Structure::new(vec![at(0.0), at(1.1)]).unwrap().bonded(&[[0, 1]]);
    assert!(apart.unwrap_err().contains("only solids that touch"));
    let rigid = |x: f64| SolidSetup { law: Box::new(Rigid { density: 1.0 }), ..at(x) };
    let both = Structure::new(vec![rigid(0.0), rigid(1.0)]).unwrap().bonded(&[[0, 1]]);
    assert!(both.unwrap_err().contains("both rigid"));
}
