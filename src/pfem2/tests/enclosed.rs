//! Rigid solids that a surface of triangles encloses, in water.

use super::*;
use crate::geometry::Triangles;
use crate::material::Rigid;
use crate::mesh::SurfacePatches;
use crate::pfem2::Pfem2;
use crate::pfem2::solid::mesh::SolidMesh;
use crate::pfem2::solid::setup::{PrescribedMotion, SolidSetup};
use crate::pfem2::solid::structure::Structure;
use crate::simulation::Solver;

const LOWER: Vector<3> = Vector([0.23, 0.31, 0.27]);
const UPPER: Vector<3> = Vector([0.73, 0.66, 0.77]);

/// The box of twelve triangles.
pub fn of_triangles() -> SolidMesh<3> {
    let corner = |n: usize| std::array::from_fn(|k| if n >> k & 1 == 1 { UPPER[k] } else { LOWER[k] });
    let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let surface = Triangles { vertices: (0..8).map(corner).collect(), triangles };
    let SurfacePatches { mesh, patches } = SurfacePatches::new(&surface).unwrap();
    SolidMesh::enclosed(mesh.nodes.into_iter().map(Vector).collect(), patches).unwrap()
}

/// Force of water at rest on a rigid solid that may move or not [N], the volume of the box on the mesh [m³], and its
/// velocity.
fn in_water(solid: SolidMesh<3>, density: f64, is_free: bool) -> (Vector<3>, f64, Vector<3>) {
    let mesh = Mesh::<3, 4>::block(Vector::ZERO, Vector::splat(1.0), [5; 3]).unwrap();
    let none = || std::array::from_fn(|_| (!is_free).then_some(Signal::ZERO));
    let motion = PrescribedMotion { velocity: none(), spin: none() };
    let setup_of = SolidSetup { motion, ..SolidSetup::free("box", solid, Box::new(Rigid { density })) };
    let physics = Physics {
        stabilisation: Stabilisation::Dynamic,
        ..physics(vec![fluid("water", 1000.0, 1e-3)], [Signal::ZERO, Signal::ZERO, (-10.0).into()])
    };
    let mut setup = setup(mesh, Vec::new(), physics, |_| 0, |_| Vector::ZERO);
    setup.solids = Some(Structure::new(vec![setup_of]).unwrap());
    let mut pfem = Pfem2::new(setup);
    pfem.step(0.0, 0.01).unwrap();
    let solids = pfem.solids.as_ref().unwrap();
    let cut = pfem.system.immersed.as_ref().unwrap().cut.volume_inside(&pfem.system.mesh);
    (solids.last.forces.last[0], cut, Vector(solids.structure.state.rigid[0].velocity[0].0))
}

/// A box of triangles and one of hexahedra have one buoyancy, that of the volume that the mesh shows of them.
#[test]
fn a_box_of_triangles_has_the_buoyancy_of_one_with_elements() {
    let hexahedra = SolidMesh::block(LOWER, UPPER, [2; 3]).unwrap();
    let [(made, _, _), (read, cut, _)] = [hexahedra, of_triangles()].map(|mesh| in_water(mesh, 3000.0, false));
    let weight = 1e4 * cut;
    assert!((read - made).norm() < 1e-8 * weight, "{read:?} {made:?}");
    assert!((read - Vector([0.0, 0.0, weight])).norm() < 1e-6 * weight, "{read:?} {weight}");
}

/// Both begin to sink alike: mass and moments of inertia count as they should. Places where edges meet the surface are
/// found to 10⁻⁷ of an edge, on facets that aren't the same.
#[test]
fn a_box_of_triangles_sinks_as_one_with_elements() {
    let hexahedra = SolidMesh::block(LOWER, UPPER, [2; 3]).unwrap();
    let [(.., made), (.., read)] = [hexahedra, of_triangles()].map(|mesh| in_water(mesh, 3000.0, true));
    assert!(made[2] < -0.01 && (read - made).norm() < 1e-5 * made.norm(), "{read:?} {made:?}");
}
