//! Plane Poiseuille flow along a slab that lies off the lines of the mesh and ends at the outlet.

use super::solids::solid;
use super::*;
use crate::pfem2::Pfem2;
use crate::pfem2::solid::mesh::SolidMesh;
use crate::pfem2::solid::structure::Structure;
use crate::simulation::Solver;

/// Height of the slab in the channel [m], whose other wall is at one; its length [m].
const BOTTOM: f64 = 0.27;
const LENGTH: f64 = 2.0;

const VISCOSITY: f64 = 0.1;

fn profile(x: Vector<2>) -> Vector<2> {
    let width = 1.0 - BOTTOM;
    Vector([6.0 * ((x[1] - BOTTOM) * (1.0 - x[1])).max(0.0) / (width * width), 0.0])
}

/// The flow three times as long as it takes to pass the height of the channel, from the profile on.
fn channel(cells: usize, outlet: Condition<2>) -> Pfem2<2, 3> {
    let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector([LENGTH, 1.0]), [2 * cells, cells]).unwrap();
    let speed = format!("6*max((y - {BOTTOM})*(1 - y), 0)/{}", (1.0 - BOTTOM) * (1.0 - BOTTOM));
    let inlet = Condition::Inlet([formula(&speed), Signal::ZERO]);
    let sets = vec![
        set(&mesh, "in", inlet, |x| x[0] == 0.0),
        set(&mesh, "out", outlet, |x| x[0] == LENGTH),
        set(&mesh, "top", Condition::Wall([Signal::ZERO, Signal::ZERO]), |x| x[1] == 1.0),
        set(&mesh, "bottom", Condition::Wall([Signal::ZERO, Signal::ZERO]), |x| x[1] == 0.0),
    ];
    let physics = physics(vec![fluid("fluid", 1.0, VISCOSITY)], weightless());
    let mut setup = setup(mesh, sets, physics, |_| 0, profile);
    setup.linear = SolverOptions { tolerance: 1e-12, ..SolverOptions::default() };
    let slab = SolidMesh::block(Vector::ZERO, Vector([LENGTH, BOTTOM]), [40, 3]).unwrap();
    let held = solid(slab, (1e8, 0.3), |_| [true; 2], |_| Vector::ZERO);
    setup.solids = Some(Structure::new(vec![held]).unwrap());
    let mut pfem = Pfem2::new(setup);
    let dt = 1.0 / cells as f64;
    (0..3 * cells).for_each(|k| pfem.step(k as f64 * dt, dt).unwrap());
    pfem
}

/// Largest deviation from the profile at the outlet, of nodes in the fluid.
fn deviation_at_the_outlet(pfem: &Pfem2<2, 3>) -> f64 {
    let nodes = pfem.system.mesh.nodes().iter().zip(&pfem.system.velocity);
    let at_the_outlet = nodes.filter(|(x, _)| x[0] == LENGTH && x[1] > BOTTOM);
    at_the_outlet.map(|(x, v)| (*v - profile(*x)).norm()).fold(0.0, f64::max)
}

/// An outlet leaves the flow undisturbed within an error of second order of the mesh, also in elements that the slab
/// cuts; a traction-free end is another condition, with which the flow diverges.
#[test]
fn outlets_leave_a_flow_undisturbed_beside_a_solid_that_ends_there() {
    let free = Condition::Traction([Signal::ZERO, Signal::ZERO]);
    let [coarse, fine] = [8, 16].map(|cells| deviation_at_the_outlet(&channel(cells, Condition::Outlet)));
    let diverging = deviation_at_the_outlet(&channel(8, free));
    assert!(coarse < 0.02 && fine < coarse / 3.0, "{coarse} {fine}");
    assert!(diverging > 0.1, "{diverging}");
}
