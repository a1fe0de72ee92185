//! The state as outputs see it: particles, mesh, ledger, forces, counts.

use super::{filled, vorticity};
use crate::math::{SymTensor, Vector};
use crate::parallel;
use crate::pfem2::Pfem2;
use crate::pfem2::equations::system::VelocityPressureSystem;
use crate::pfem2::particle_solids::columns;
use crate::pfem2::solid::setup::Plane;
use crate::pfem2::solid::structure::Structure;
use crate::pfem2::solid::structure::bodies::SolidBody;
use crate::pfem2::solid::structure::outline::SolidOutline;
use crate::pfem2::solid::structure::stress::NodalStress;
use crate::pfem2::time::step_control::ErrorEstimates;
use crate::pfem2::tracking::solids::SolidTracking;
use crate::simulation::TermKind::Other;
use crate::simulation::{BalanceTerm, Elements, Field, Ledger, PointSet, Snapshot, SurfaceSet};
use std::borrow::Cow;

/// Name of the mesh among the sets that outputs see.
pub const MESH: &str = "mesh";
/// Name of the interfaces between the fluids.
pub const INTERFACE: &str = "interface";

/// A field of vectors with three components.
fn vectors<'a, const D: usize>(name: &'static str, unit: &'static str, values: &'a [Vector<D>]) -> Field<'a> {
    Field::computed(name, unit, 3, move || values.iter().flat_map(|v| v.to3()).collect())
}

/// The state of a run.
pub fn snapshot<const D: usize, const N: usize>(pfem: &Pfem2<D, N>) -> Snapshot<'_> {
    let forces = pfem.forces.parts.iter().zip(&pfem.forces.on_parts.mean);
    Snapshot {
        step: pfem.steps,
        dt: pfem.history.dt_previous,
        dimension: D,
        points: (0..pfem.interface.list.count()).map(|fluid| points(pfem, fluid)).collect(),
        surfaces: std::iter::once(mesh(pfem)).chain(interface(pfem)).chain(solids(pfem)).collect(),
        outlines: outlines(pfem).collect(),
        ledger: ledger(pfem),
        moments: moments(pfem).collect(),
        forces: forces
            .map(|(part, force)| (part.name.clone(), force.to3()))
            .chain(forces_on_solids(pfem))
            .chain(holding_forces(pfem))
            .chain(forces_on_particle_solids(pfem))
            .collect(),
        counts: counts(pfem),
        amounts: amounts(pfem),
        ..Snapshot::default()
    }
}

/// The particles of a fluid.
fn points<'a, const D: usize, const N: usize>(pfem: &'a Pfem2<D, N>, fluid: usize) -> PointSet<'a> {
    let particles = &pfem.particles.columns;
    let own: Vec<u32> =
        (0..particles.len() as u32).filter(|&p| usize::from(particles.phase[p as usize]) == fluid).collect();
    let position = own.iter().map(|&p| particles.position[p as usize].to3()).collect();
    let id = Cow::Owned(identities(pfem, fluid, &own));
    let count = own.len();
    let [here, there] = [own.clone(), own.clone()];
    let of_solid = solid_fields(pfem, fluid, &own);
    let volume = move || here.iter().map(|&p| pfem.particles.volume(&pfem.system, p as usize)).collect();
    let mass = move || {
        there
            .iter()
            .map(|&p| pfem.interface.list.density()[fluid] * pfem.particles.volume(&pfem.system, p as usize))
            .collect()
    };
    let velocity = move || own.iter().flat_map(|&p| particles.velocity[p as usize].to3()).collect();
    PointSet {
        name: pfem.system.phase_names().nth(fluid).unwrap_or_default(),
        position,
        id,
        fields: [
            Field::computed("velocity", "m/s", 3, velocity),
            Field::computed("volume", if D == 2 { "m^2" } else { "m^3" }, 1, volume),
            Field::computed("mass", "kg", 1, mass),
            Field::computed("fluid", "", 1, move || vec![fluid as f64; count]),
        ]
        .into_iter()
        .chain(of_solid)
        .collect(),
        filled: Some(Box::new(move |bounds: &filled::FluidBox| filled::pieces(pfem, fluid, bounds))),
    }
}

/// Identities of particles that stay theirs: of solids on particles their numbers, of fluids their places.
fn identities<const D: usize, const N: usize>(pfem: &Pfem2<D, N>, phase: usize, own: &[u32]) -> Vec<u32> {
    let solids = pfem.system.particle_solids.as_ref().filter(|solids| phase >= solids.first);
    match pfem.particles.columns.column(columns::IDENTITY).filter(|_| solids.is_some()) {
        Some(identity) => own.iter().map(|&p| identity[p as usize] as u32).collect(),
        None => own.to_vec(),
    }
}

/// Stress and pressure of the particles of a solid; of a fluid nothing.
fn solid_fields<'a, const D: usize, const N: usize>(
    pfem: &'a Pfem2<D, N>,
    phase: usize,
    own: &[u32],
) -> Vec<Field<'a>> {
    let Some(law) = pfem.system.particle_solids.as_ref().and_then(|solids| solids.law_of(phase as u8)) else {
        return Vec::new();
    };
    let (stress, pressure, _) = columns::state(&pfem.particles.columns);
    let [here, there] = [own.to_vec(), own.to_vec()];
    let plane = law.plane;
    let total = move |p: usize| {
        let mut total = stress[p] - SymTensor::isotropic(pressure[p]);
        // In plane stress the deviator is that of the stress in the plane, and nothing acts across it.
        total.0[2] = if D == 2 && plane == Plane::Stress { 0.0 } else { total.0[2] };
        total.0
    };
    vec![
        Field::computed("stress", "Pa", 6, move || here.iter().flat_map(|&p| total(p as usize)).collect()),
        Field::computed("pressure", "Pa", 1, move || there.iter().map(|&p| pressure[p as usize]).collect()),
    ]
}

/// Forces of the fluid on the solids on particles [N].
fn forces_on_particle_solids<const D: usize, const N: usize>(
    pfem: &Pfem2<D, N>,
) -> impl Iterator<Item = (String, [f64; 3])> {
    pfem.system.particle_solids.iter().flat_map(|solids| {
        solids.setups.iter().zip(&solids.forces).map(|(setup, force)| (setup.name.clone(), force.to3()))
    })
}

/// The mesh with its nodal fields: velocity, pressure, density, vorticity, and the level set if there is one.
fn mesh<const D: usize, const N: usize>(pfem: &Pfem2<D, N>) -> SurfaceSet<'_> {
    let system = &pfem.system;
    let mut node_fields = vec![
        vectors("velocity", "m/s", &system.velocity),
        Field::scalar("pressure", "Pa", &system.pressure),
        Field::computed("density", "kg/m^3", 1, || densities(pfem)),
        vorticities(system),
    ];
    if !pfem.interface.level.is_empty() {
        node_fields.push(Field::scalar("level set", "", &pfem.interface.level));
    }
    SurfaceSet {
        name: MESH,
        position: Cow::Borrowed(&pfem.places),
        reference: Cow::Borrowed(&pfem.places),
        elements: system.mesh.elements().iter().map(|nodes| &nodes[..]).collect(),
        kind: if D == 3 { Elements::Volume } else { Elements::Sheet },
        node_fields,
        element_fields: Vec::new(),
    }
}

/// Vorticity at the nodes of the mesh; in 2D its component across the plane.
fn vorticities<const D: usize, const N: usize>(system: &VelocityPressureSystem<D, N>) -> Field<'_> {
    let components = if D == 2 { 1 } else { 3 };
    let values = move || {
        let vorticity = vorticity::at_nodes(&system.mesh, &system.velocity);
        vorticity.iter().flat_map(|w| w.0[3 - components..].to_vec()).collect()
    };
    Field::computed("vorticity", "1/s", components, values)
}

/// The interfaces between fluids; none if there is only one.
fn interface<const D: usize, const N: usize>(pfem: &Pfem2<D, N>) -> Option<SurfaceSet<'_>> {
    let outline = &pfem.interface.outline;
    (pfem.interface.list.count() > 1).then(|| SurfaceSet {
        name: INTERFACE,
        position: Cow::Borrowed(&outline.position),
        reference: Cow::Borrowed(&outline.position),
        elements: outline.facets(D),
        kind: Elements::Sheet,
        node_fields: vec![Field::computed("velocity", "m/s", 3, || outline.velocity.as_flattened().to_vec())],
        element_fields: vec![Field::scalar("area", if D == 2 { "m" } else { "m^2" }, &outline.size)],
    })
}

/// The solids: their elements divided into linear ones, with displacement, velocity, and, of elastic ones, stress and strain.
fn solids<const D: usize, const N: usize>(pfem: &Pfem2<D, N>) -> impl Iterator<Item = SurfaceSet<'_>> {
    pfem.solids.iter().flat_map(|solids| {
        solids.structure.bodies().zip(&solids.cells).enumerate().map(|(solid, (body, cells))| SurfaceSet {
            name: body.name,
            position: Cow::Owned(body.positions().iter().map(|x| x.to3()).collect()),
            reference: Cow::Owned(body.mesh.nodes.iter().map(|x| x.to3()).collect()),
            elements: cells.iter().collect(),
            kind: if cells.are_volumes() { Elements::Volume } else { Elements::Sheet },
            node_fields: [vectors("displacement", "m", body.displacement), vectors("velocity", "m/s", body.velocity)]
                .into_iter()
                .chain(strained(&solids.structure, solid))
                .collect(),
            element_fields: Vec::new(),
        })
    })
}

/// The surfaces of the solids, with displacement, velocity and the traction of the fluid.
fn outlines<const D: usize, const N: usize>(pfem: &Pfem2<D, N>) -> impl Iterator<Item = SurfaceSet<'_>> {
    pfem.solids.iter().flat_map(|solids| {
        let all = solids.structure.bodies().zip(&solids.outlines).enumerate();
        all.map(move |(solid, (body, outline))| outline_of(solids, outline, body, solid))
    })
}

/// The surface of a solid.
fn outline_of<'a, const D: usize>(
    solids: &'a SolidTracking<D>,
    outline: &'a SolidOutline,
    body: SolidBody<'a, D>,
    solid: usize,
) -> SurfaceSet<'a> {
    let SolidBody { mesh, displacement, velocity, .. } = body;
    let own = solids.structure.nodes_of(solid);
    let tractions = move || {
        let cut = solids.structure.positions(&solids.last.predicted);
        outline.tractions(mesh, &cut[own.clone()], &solids.last.nodal[own.clone()])
    };
    let on_surface = |values: &[Vector<D>]| outline.gather(values).iter().flat_map(|v| v.to3()).collect::<Vec<_>>();
    SurfaceSet {
        name: &outline.name,
        position: outline.gather(&body.positions()).iter().map(|x| x.to3()).collect(),
        reference: outline.gather(&mesh.nodes).iter().map(|x| x.to3()).collect(),
        elements: outline.cells.iter().map(|nodes| &nodes[..]).collect(),
        kind: Elements::Sheet,
        node_fields: vec![
            Field::computed("displacement", "m", 3, move || on_surface(displacement)),
            Field::computed("velocity", "m/s", 3, move || on_surface(velocity)),
            Field::computed("traction", "Pa", 3, move || tractions().iter().flat_map(|t| t.to3()).collect()),
        ],
        element_fields: Vec::new(),
    }
}

/// Moments of the forces of the fluid on parts of the boundary and on solids, where the case asks for them [N m].
pub(in crate::pfem2) fn moments<const D: usize, const N: usize>(
    pfem: &Pfem2<D, N>,
) -> impl Iterator<Item = (String, [f64; 3])> {
    let parts = pfem.forces.parts.iter().zip(&pfem.forces.moments.mean);
    let on_parts = parts.filter(|(part, _)| part.about.is_some()).map(|(part, moment)| (part.name.clone(), moment.0));
    let on_solids = pfem.solids.iter().flat_map(|solids| {
        let named = solids.structure.bodies().zip(&solids.moment_points).zip(&solids.last.moments.mean);
        named.filter(|((_, about), _)| about.is_some()).map(|((body, _), moment)| (body.name.to_owned(), moment.0))
    });
    let holding = pfem.solids.iter().flat_map(|solids| {
        let names = solids.holders.names(&solids.structure).into_iter().zip(solids.holders.solids());
        let all = names.zip(&solids.last.holding_moments.mean);
        all.filter(|((_, solid), _)| solids.moment_points[*solid].is_some()).map(|((name, _), moment)| (name, moment.0))
    });
    on_parts.chain(on_solids).chain(holding)
}

/// Stress and strain of a solid that isn't rigid.
fn strained<const D: usize>(structure: &Structure<D>, solid: usize) -> impl Iterator<Item = Field<'_>> {
    let fields = move || {
        [
            tensors("stress", "Pa", structure, solid, |node| node.stress),
            tensors("strain", "", structure, solid, |node| node.strain),
        ]
    };
    (!structure.setups()[solid].law.is_rigid()).then(fields).into_iter().flatten()
}

/// A tensor at the nodes of a solid.
fn tensors<'a, const D: usize>(
    name: &'static str,
    unit: &'static str,
    structure: &'a Structure<D>,
    solid: usize,
    of: fn(&NodalStress) -> SymTensor,
) -> Field<'a> {
    Field::computed(name, unit, 6, move || structure.nodal_stresses(solid).iter().flat_map(|node| of(node).0).collect())
}

/// Forces of the fluid on the solids [N].
fn forces_on_solids<const D: usize, const N: usize>(pfem: &Pfem2<D, N>) -> impl Iterator<Item = (String, [f64; 3])> {
    pfem.solids.iter().flat_map(|solids| {
        let named = solids.structure.bodies().zip(&solids.last.forces.mean);
        named.map(|(body, force)| (body.name.to_owned(), force.to3()))
    })
}

/// Forces of solids on supports and springs, and of contacts on solids [N].
fn holding_forces<const D: usize, const N: usize>(pfem: &Pfem2<D, N>) -> impl Iterator<Item = (String, [f64; 3])> {
    pfem.solids.iter().flat_map(|solids| {
        let names = solids.holders.names(&solids.structure);
        names.into_iter().zip(&solids.last.holding.mean).map(|(name, force)| (name, force.to3()))
    })
}

/// Mean density at the nodes [kg/m³].
fn densities<const D: usize, const N: usize>(pfem: &Pfem2<D, N>) -> Vec<f64> {
    let at = |node: usize| {
        pfem.interface.fraction.iter().zip(pfem.interface.list.density()).map(|(f, rho)| f[node] * rho).sum()
    };
    (0..pfem.places.len()).map(at).collect()
}

/// Energies, momentum, and the volume of each fluid.
fn ledger<const D: usize, const N: usize>(pfem: &Pfem2<D, N>) -> Ledger {
    let (balance, system) = (&pfem.balance, &pfem.system);
    let mut ledger = balance.ledger.ledger::<D>(&balance.totals, system.surface_energy(), balance.gained(system));
    ledger.terms.extend(balance.solids.iter().flat_map(|solids| solids.terms()));
    ledger.terms.extend(balance.strain.iter().flat_map(|strain| strain.terms()));
    ledger.largest = pfem.balance.largest_energy();
    let unit = if D == 2 { "m^2" } else { "m^3" };
    for (name, &value) in pfem.system.phase_names().zip(&pfem.system.contents.volumes) {
        ledger.terms.push(BalanceTerm { name: format!("volume: {name}"), unit, kind: Other, value });
    }
    for (fluid, value) in pfem.interface.outflow_by_fluid() {
        let name = format!("outflow: {}", pfem.system.physics.fluids[fluid].name);
        ledger.terms.push(BalanceTerm { name, unit, kind: Other, value });
    }
    let velocity = &pfem.system.velocity;
    let fastest = parallel::max(velocity.len(), |node| velocity[node].norm());
    ledger.terms.push(BalanceTerm { name: "largest speed".into(), unit: "m/s", kind: Other, value: fastest });
    ledger.terms.push(moved(pfem));
    let name = "energy of unresolved velocities".to_owned();
    ledger.terms.push(BalanceTerm { name, unit: "J", kind: Other, value: pfem.particles.unresolved_energy });
    let ErrorEstimates { time, mesh, interface, solids } = pfem.limits.control.errors;
    let errors = [("error of the step", "1", time), ("error of the mesh", "1", mesh)];
    let errors = errors.into_iter().chain([("error of the interface", "elements", interface)]);
    let errors = errors.chain(pfem.solids.is_some().then_some(("error of the solids", "1", solids)));
    ledger.terms.extend(errors.map(|(name, unit, value)| BalanceTerm { name: name.into(), unit, kind: Other, value }));
    ledger
}

/// The shift or weights that keep the volumes.
fn moved<const D: usize, const N: usize>(pfem: &Pfem2<D, N>) -> BalanceTerm {
    let (name, unit, value) = match pfem.interface.list.count() {
        0..=2 => ("shift of the interface", "m", pfem.interface.shift),
        _ => ("factor between weights of shares", "1", pfem.interface.weight),
    };
    BalanceTerm { name: name.into(), unit, kind: Other, value }
}

fn counts<const D: usize, const N: usize>(pfem: &Pfem2<D, N>) -> Vec<(String, u64)> {
    // Solutions for the start belong to no step.
    let started = pfem.steps > 0;
    let counts = [
        ("particles", pfem.particles.columns.len() as u64),
        ("particles: left", pfem.particles.events.left),
        ("particles: stuck", pfem.particles.events.stuck),
        ("particles: added", pfem.particles.events.added),
        ("particles: inflow", pfem.particles.events.inflow),
        ("particles: merged", pfem.particles.events.merged),
        ("particles: joined", pfem.particles.events.joined),
        ("elements: empty", pfem.particles.events.empty),
        ("elements: cut", pfem.system.contents.cuts.len() as u64),
        ("solver: iterations", if started { pfem.system.linear.outcome.iterations as u64 } else { 0 }),
        ("solver: preconditioners", if started { pfem.system.linear.preconditioners } else { 0 }),
    ];
    let solutions = pfem.solids.as_ref().map(|solids| ("solver: solutions", solids.last.solutions as u64));
    counts.into_iter().chain(solutions).map(|(name, count)| (name.to_owned(), count)).collect()
}

/// Volume of the particles of each fluid where the level set shows the other.
fn amounts<const D: usize, const N: usize>(pfem: &Pfem2<D, N>) -> Vec<(String, &'static str, f64)> {
    let unit = if D == 2 { "m^2" } else { "m^3" };
    let fluids = pfem
        .system
        .physics
        .fluids
        .iter()
        .zip(pfem.particles.stray_volumes(&pfem.system.fluid_region(), &pfem.interface));
    fluids.map(|(fluid, volume)| (format!("stray volume: {}", fluid.name), unit, volume)).collect()
}
