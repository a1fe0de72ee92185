//! The snapshot for outputs: particles, membranes, ledger, reactions (theory A.17).

use crate::math::{Tensor, Vector};
use crate::mpm::Mpm;
use crate::mpm::membrane::Membrane;
use crate::mpm::particles::Body;
use crate::simulation::TermKind::{Gain, Loss, Stored};
use crate::simulation::{BalanceTerm, Field, FieldValues, Ledger, PointSet, Snapshot};
use std::borrow::Cow;

/// Vectors with three components: borrowed in 3D, padded in 2D.
fn padded<const D: usize>(vectors: &[Vector<D>]) -> Cow<'_, [[f64; 3]]> {
    if D == 3 {
        Cow::Borrowed(bytemuck::cast_slice(vectors))
    } else {
        Cow::Owned(vectors.iter().map(|v| v.to3()).collect())
    }
}

/// A vector field.
fn vector_field<'a, const D: usize>(name: &'static str, unit: &'static str, vectors: &'a [Vector<D>]) -> Field<'a> {
    if D == 3 {
        let values = FieldValues::Stored(bytemuck::cast_slice(vectors));
        return Field { name, unit, components: 3, values };
    }
    Field::computed(name, unit, 3, move || bytemuck::cast_slice(&padded(vectors)).to_vec())
}

/// The bodies, each with all of its parts.
fn wholes<const D: usize>(mpm: &Mpm<D>) -> Vec<Vec<&Body<D>>> {
    let bodies: Vec<&Body<D>> = mpm.bodies.iter().collect();
    bodies.chunk_by(|_, next| next.part.number > 0).map(<[_]>::to_vec).collect()
}

/// The particles of a body, of all its parts.
fn points<'a, const D: usize>(parts: &[&'a Body<D>]) -> PointSet<'a> {
    match parts {
        [body] => points_of_part(body),
        _ => joined(parts.iter().map(|body| points_of_part(body)).collect()),
    }
}

/// One set of many with the same name and the same fields, part by part.
fn joined<'a>(parts: Vec<PointSet<'a>>) -> PointSet<'a> {
    let name = parts[0].name;
    let position = parts.iter().flat_map(|part| part.position.iter().copied()).collect();
    let id = parts.iter().flat_map(|part| part.id.iter().copied()).collect();
    let mut columns: Vec<Vec<Field<'a>>> = parts[0].fields.iter().map(|_| Vec::new()).collect();
    for part in parts {
        columns.iter_mut().zip(part.fields).for_each(|(column, field)| column.push(field));
    }
    let field = |own: Vec<Field<'a>>| -> Field<'a> {
        let Field { name, unit, components, .. } = own[0];
        Field::computed(name, unit, components, move || own.iter().flat_map(|f| f.values().into_owned()).collect())
    };
    let fields = columns.into_iter().map(field).collect();
    PointSet { name, position: Cow::Owned(position), id: Cow::Owned(id), fields, filled: None }
}

/// The particles of a body, or of a part of it.
fn points_of_part<const D: usize>(body: &Body<D>) -> PointSet<'_> {
    let particles = &body.particles;
    // The averaged pressure makes the forces: next to walls that of the law alternates about it.
    let acting = || particles.pressure.iter().zip(&body.work.excess).map(|(p, more)| p + more).collect();
    let pressure = if body.work.excess.len() == particles.len() {
        Field::computed("pressure", "Pa", 1, acting)
    } else {
        Field::scalar("pressure", "Pa", &particles.pressure)
    };
    let density = || particles.mass.iter().zip(&particles.volume).map(|(m, v)| m / v).collect();
    let mut fields = vec![
        vector_field("velocity", "m/s", &particles.velocity),
        pressure,
        Field::computed("density", "kg/m^3", 1, density),
        Field::scalar("internal energy", "J", &particles.energy),
        Field::scalar("volume", "m^3", &particles.volume),
        Field::scalar("mass", "kg", &particles.mass),
    ];
    if !particles.stress.is_empty() {
        fields.push(Field::symmetric("stress", "Pa", &particles.stress));
    }
    let names = body.law.storage().history;
    for (offset, name) in names.iter().copied().enumerate() {
        let values = move || particles.history.iter().skip(offset).step_by(names.len()).copied().collect();
        fields.push(Field::computed(name, "", 1, values));
    }
    PointSet {
        name: &body.name,
        position: padded(&particles.position),
        id: match body.part.before {
            0 => Cow::Borrowed(&particles.id),
            before => Cow::Owned(particles.id.iter().map(|id| before + id).collect()),
        },
        fields,
        filled: None,
    }
}

/// The state of a run.
pub fn snapshot<const D: usize>(mpm: &Mpm<D>) -> Snapshot<'_> {
    let membranes = &mpm.coupling.membranes;
    Snapshot {
        step: mpm.clock.steps,
        dt: mpm.clock.dt_previous,
        dimension: D,
        points: wholes(mpm).iter().map(|parts| points(parts)).collect(),
        surfaces: membranes.iter().map(Membrane::surface_set).collect(),
        ledger: ledger(mpm),
        forces: named_forces(mpm),
        counts: mpm.coupling.contact.counts(),
        ..Snapshot::default()
    }
}

/// Forces of the material on walls and obstacles, contact forces on the first of the two, forces of membranes on their
/// supports: means over the last step [N].
pub fn forces<const D: usize>(mpm: &Mpm<D>, visit: &mut dyn FnMut([f64; 3])) {
    // Reactions are kept as forces on the material; 0 − f has no negative zeros.
    let on_support = |reaction: [f64; 3]| reaction.map(|f| 0.0 - f);
    mpm.walls.reactions().for_each(|(_, reaction)| visit(on_support(reaction.to3())));
    mpm.coupling.contact.forces().for_each(|(_, force)| visit(force));
    mpm.coupling.membranes.iter().flat_map(Membrane::reactions).for_each(|reaction| visit(on_support(*reaction)));
}

/// Forces with their names.
fn named_forces<const D: usize>(mpm: &Mpm<D>) -> Vec<(String, [f64; 3])> {
    let mut names: Vec<_> = mpm.walls.reactions().map(|(name, _)| name.to_owned()).collect();
    names.extend(mpm.coupling.contact.forces().map(|(name, _)| name.to_owned()));
    for membrane in &mpm.coupling.membranes {
        names.extend((0..membrane.reactions().len()).map(|index| format!("support:{}[{index}]", membrane.name)));
    }
    let mut values = Vec::with_capacity(names.len());
    forces(mpm, &mut |force| values.push(force));
    names.into_iter().zip(values).collect()
}

/// All terms of the ledger.
fn ledger<const D: usize>(mpm: &Mpm<D>) -> Ledger {
    let mut terms = Vec::new();
    for parts in wholes(mpm) {
        let name = &parts[0].name;
        let sum = |of: &dyn Fn(&Body<D>) -> f64| parts.iter().map(|body| of(body)).sum::<f64>();
        terms.push(BalanceTerm::energy(
            Stored,
            format!("kinetic energy: {name}"),
            sum(&|b| b.particles.kinetic_energy()),
        ));
        terms.push(BalanceTerm::energy(
            Stored,
            format!("internal energy: {name}"),
            sum(&|b| b.particles.internal_energy()),
        ));
        if !parts[0].particles.affine.is_empty() {
            let affine = sum(&|body| affine_energy(body, mpm.grid.cell));
            terms.push(BalanceTerm::other(format!("affine kinetic energy: {name}"), "J", affine));
        }
    }
    let mut impulse = Vector(mpm.energy.sums.impulse());
    for membrane in &mpm.coupling.membranes {
        membrane_terms(membrane, &mut terms);
        let [external, _, supports] = membrane.impulses();
        impulse += Vector((external + supports).to3());
    }
    let losses = mpm.coupling.contact.losses();
    terms.push(BalanceTerm::energy(Loss, "contact dissipation", losses.normal));
    terms.push(BalanceTerm::energy(Loss, "friction dissipation", losses.friction));
    terms.push(BalanceTerm::energy(Loss, "contact mapping loss", losses.mapping));
    moment_terms(mpm, impulse, &mut terms);
    terms.extend(mpm.energy.sums.terms());
    Ledger { terms, largest: 0.0 }
}

/// Kinetic energy of the motion about the particles that APIC carries, Σ ½ m D C:C with its inertia D [J]. The ledger
/// counts it among what the transfer dissipates.
fn affine_energy<const D: usize>(body: &Body<D>, cell: f64) -> f64 {
    let (particles, inertia) = (&body.particles, body.kernel.inertia().unwrap_or(0.0) * cell * cell);
    let own = |p: usize| {
        let c = particles.affine(p);
        0.5 * particles.mass[p] * inertia * c.contract(&c)
    };
    crate::parallel::sum(particles.len(), own)
}

/// Energies and works of a membrane.
fn membrane_terms<const D: usize>(membrane: &Membrane<D>, terms: &mut Vec<BalanceTerm>) {
    let (name, balance) = (&membrane.name, membrane.balance());
    let rows = [
        (Stored, "kinetic energy", balance.kinetic),
        (Stored, "strain energy", balance.strain),
        (Stored, "hourglass energy", balance.hourglass),
        (Gain, "work of pressure", balance.pressure),
        (Gain, "work of gravity", balance.gravity),
        (Gain, "work of supports", balance.supports),
        (Gain, "stress update error", balance.mismatch),
        (Loss, "damping", balance.damping),
    ];
    terms.extend(rows.map(|(kind, what, value)| BalanceTerm::energy(kind, format!("{what}: {name}"), value)));
}

/// Mass, momentum, angular momentum, and the impulse from outside.
fn moment_terms<const D: usize>(mpm: &Mpm<D>, impulse: Vector<3>, terms: &mut Vec<BalanceTerm>) {
    let bodies = mpm.bodies.iter().map(|body| moments(body, mpm.grid.cell));
    let parts = bodies.chain(mpm.coupling.membranes.iter().map(membrane_moments));
    let (mass, momentum, spin) =
        parts.fold((0.0, Vector::ZERO, Vector::ZERO), |a, b| (a.0 + b.0, a.1 + b.1, a.2 + b.2));
    let added = mpm.coupling.contact.losses().spin;
    terms.push(BalanceTerm::other("mass", "kg", mass));
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        if axis < D {
            terms.push(BalanceTerm::other(format!("momentum {name}"), "N s", momentum[axis]));
            terms.push(BalanceTerm::other(format!("external impulse {name}"), "N s", impulse[axis]));
        }
        if D == 3 || axis == 2 {
            terms.push(BalanceTerm::other(format!("angular momentum {name}"), "N m s", spin[axis]));
            terms.push(BalanceTerm::other(format!("angular momentum of contact {name}"), "N m s", added[axis]));
        }
    }
}

/// Mass, momentum and angular momentum of a membrane about the origin.
fn membrane_moments<const D: usize>(membrane: &Membrane<D>) -> (f64, Vector<3>, Vector<3>) {
    let of_node = |k: usize| {
        let (x, v) = (Vector(membrane.position[k].to3()), Vector(membrane.velocity[k].to3()));
        x.cross(v) * membrane.mass[k]
    };
    let spin = crate::parallel::sum(membrane.mass.len(), of_node);
    (membrane.total_mass(), Vector(membrane.momentum().to3()), spin)
}

/// Mass, momentum and angular momentum about the origin, the affine motion of APIC included.
fn moments<const D: usize>(body: &Body<D>, cell: f64) -> (f64, Vector<3>, Vector<3>) {
    let particles = &body.particles;
    let inertia = body.kernel.inertia().unwrap_or(0.0) * cell * cell;
    let sum = |range: std::ops::Range<usize>| {
        range.fold((0.0, Vector::<3>::ZERO, Vector::<3>::ZERO), |(mass, momentum, spin), p| {
            let m = particles.mass[p];
            let (x, v) = (Vector(particles.position[p].to3()), Vector(particles.velocity[p].to3()));
            let c: Tensor<3> = particles.affine(p).embed(0.0);
            let own = Vector([c[2][1] - c[1][2], c[0][2] - c[2][0], c[1][0] - c[0][1]]) * inertia;
            (mass + m, momentum + v * m, spin + (x.cross(v) + own) * m)
        })
    };
    let zero = (0.0, Vector::ZERO, Vector::ZERO);
    crate::parallel::reduce(particles.len(), sum, |a, b| (a.0 + b.0, a.1 + b.1, a.2 + b.2)).unwrap_or(zero)
}
