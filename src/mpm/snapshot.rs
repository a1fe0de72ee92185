//! What outputs see: particles, ledger, reactions.

use super::Mpm;
use super::ledger::{other, stored};
use super::particles::Body;
use crate::math::{Tensor, Vector};
use crate::simulation::{BalanceTerm, Field, Ledger, PointSet, Snapshot};
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
    Field::computed(name, unit, 3, move || bytemuck::cast_slice(&padded(vectors)).to_vec())
}

/// The particles of a body.
fn points<const D: usize>(body: &Body<D>) -> PointSet<'_> {
    let particles = &body.particles;
    let density = || particles.mass.iter().zip(&particles.volume).map(|(m, v)| m / v).collect();
    let mut fields = vec![
        vector_field("velocity", "m/s", &particles.velocity),
        Field::scalar("pressure", "Pa", &particles.pressure),
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
    PointSet { name: &body.name, position: padded(&particles.position), id: Cow::Borrowed(&particles.id), fields }
}

/// The state of a run.
pub fn snapshot<const D: usize>(mpm: &Mpm<D>) -> Snapshot<'_> {
    Snapshot {
        step: mpm.steps,
        dt: mpm.dt_before,
        dimension: D,
        points: mpm.bodies.iter().map(points).collect(),
        ledger: ledger(mpm),
        forces: mpm.walls.reactions().map(|(name, force)| (name.to_owned(), force.to3())).collect(),
        ..Snapshot::default()
    }
}

/// All terms of the ledger.
fn ledger<const D: usize>(mpm: &Mpm<D>) -> Ledger {
    let mut terms = stored_energies(mpm);
    let (mut mass, mut momentum, mut spin) = (0.0, Vector::<3>::ZERO, Vector::<3>::ZERO);
    for body in &mpm.bodies {
        let (m, p, l) = moments(body, mpm.grid.cell);
        mass += m;
        momentum += p;
        spin += l;
    }
    terms.push(other("mass".into(), "kg", mass));
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        if axis < D {
            terms.push(other(format!("momentum {name}"), "N s", momentum[axis]));
        }
        if D == 3 || axis == 2 {
            terms.push(other(format!("angular momentum {name}"), "N m s", spin[axis]));
        }
    }
    mpm.books.ledger(D, terms)
}

/// The energies that are stored now.
pub(super) fn stored_energies<const D: usize>(mpm: &Mpm<D>) -> Vec<BalanceTerm> {
    let mut terms = Vec::new();
    for body in &mpm.bodies {
        terms.push(stored(format!("kinetic energy: {}", body.name), body.particles.kinetic_energy()));
        terms.push(stored(format!("internal energy: {}", body.name), body.particles.internal_energy()));
    }
    terms
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
