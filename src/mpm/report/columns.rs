//! The columns of a checkpoint: everything that the next step depends on.

use crate::math::Vector;
use crate::mpm::Mpm;
use crate::mpm::bins::Bins;
use crate::mpm::coupling::Coupling;
use crate::mpm::particles::Body;
use crate::simulation::{Column, ColumnData, MOST_COUNTED};
use bytemuck::Pod;

/// Shows one array to the visitor under its body's name.
fn show<T: Pod>(visit: &mut dyn FnMut(&str, Column<'_>), body: &str, name: &str, data: &mut Vec<T>)
where
    Vec<T>: ColumnData,
{
    visit(&format!("{body}.{name}"), Column::new(data));
}

/// The beginning of the names of a body's columns. Those of its further parts have another beginning: whatever
/// bodies are called, no two columns have one name.
fn prefix<const D: usize>(body: &Body<D>) -> String {
    match body.part.number {
        0 => format!("body.{}", body.name),
        part => format!("part-{part}.{}", body.name),
    }
}

/// The columns of a body's particles.
fn body_columns<const D: usize>(body: &mut Body<D>, visit: &mut dyn FnMut(&str, Column<'_>)) {
    let (name, particles) = (&*prefix(body), &mut body.particles);
    show(visit, name, "id", &mut particles.id);
    show(visit, name, "position", &mut particles.position);
    show(visit, name, "velocity", &mut particles.velocity);
    show(visit, name, "mass", &mut particles.mass);
    show(visit, name, "volume", &mut particles.volume);
    show(visit, name, "energy", &mut particles.energy);
    show(visit, name, "pressure", &mut particles.pressure);
    show(visit, name, "stress", &mut particles.stress);
    show(visit, name, "deformation", &mut particles.deformation);
    show(visit, name, "affine", &mut particles.affine);
    show(visit, name, "history", &mut particles.history);
    show(visit, name, "wave-speed", &mut particles.wave_speed);
    // No step depends on it, but the pressure is shown with it. A model that hasn't taken a step has none.
    visit(&format!("{name}.excess"), Column::growing(&mut body.work.excess));
    visit(&format!("{name}.largest-wave-speed"), Column::scalar(&mut body.largest_wave_speed));
}

/// The blocks by which a body is sorted: a resumed run must sum in the same order.
fn bin_columns<const D: usize>(body: &str, bins: &mut Bins<D>, visit: &mut dyn FnMut(&str, Column<'_>)) {
    let (mut blocks, mut ranges) = bins.to_columns();
    visit(&format!("{body}.bins"), Column::growing(&mut blocks));
    visit(&format!("{body}.bin-ranges"), Column::growing(&mut ranges));
    visit(&format!("{body}.disorder"), Column::record(&mut bins.disorder));
    *bins = Bins::from_columns(&blocks, &ranges, bins.disorder);
}

/// The first contradiction among restored columns, if there is one.
pub fn misfit<const D: usize>(mpm: &Mpm<D>) -> Option<String> {
    let Coupling { contact, proximity, .. } = &mpm.coupling;
    if mpm.clock.steps > MOST_COUNTED || contact.largest_count() > MOST_COUNTED {
        return Some("it counts more than any run does".to_owned());
    }
    if let Some(misfit) = contact.misfit().or_else(|| mpm.notices.misfit()).or_else(|| proximity.misfit()) {
        return Some(misfit);
    }
    mpm.bodies.iter().find_map(|body| {
        let (name, count, bins) = (&body.name, body.particles.id.len(), &body.bins);
        if body.particles.id.iter().any(|&id| id as usize >= count) {
            return Some(format!("a particle of `{name}` has a number beyond the {count} there are"));
        }
        let (lower, upper, cell) = (mpm.grid.origin, mpm.grid.upper(), mpm.grid.cell);
        let inside = |x: &Vector<D>| (0..D).all(|i| (lower[i] - cell..=upper[i] + cell).contains(&x[i]));
        if !body.particles.position.iter().all(inside) {
            return Some(format!("a particle of `{name}` lies outside the grid"));
        }
        // Bins that a particle may have left are made anew before the next step; those of a state before any step are
        // empty.
        let sorted = match bins.sorted() {
            0 => bins.is_empty(),
            sorted if bins.stale(body.kernel, count) => sorted == count,
            sorted => sorted == count && bins.hold(&body.particles.position, body.kernel, lower, cell),
        };
        (!sorted).then(|| format!("the particles of `{name}` don't lie in the blocks that they are sorted by"))
    })
}

/// Every array of the state, each with a unique name.
pub fn visit<const D: usize>(mpm: &mut Mpm<D>, visit: &mut dyn FnMut(&str, Column<'_>)) {
    for body in mpm.bodies.iter_mut() {
        body_columns(body, visit);
        bin_columns(&prefix(body), &mut body.bins, visit);
    }
    for membrane in &mut mpm.coupling.membranes {
        let prefix = format!("membrane.{}.", membrane.name);
        membrane.columns(&prefix, visit);
    }
    mpm.coupling.contact.columns("contact.", visit);
    let (clock, energy) = (&mut mpm.clock, &mut mpm.energy);
    visit("mpm.steps", Column::scalar(&mut clock.steps));
    visit("mpm.dt-before", Column::scalar(&mut clock.dt_previous));
    visit("mpm.step-bound", Column::scalar(&mut clock.bound));
    visit("mpm.kinetic-energy", Column::scalar(&mut energy.kinetic));
    visit("mpm.internal-energy", Column::scalar(&mut energy.internal));
    visit("mpm.displaced-atmosphere", Column::scalar(&mut energy.displaced));
    energy.sums.column("mpm.ledger", visit);
    mpm.notices.columns(visit);
    mpm.coupling.proximity.columns(visit);
    visit("mpm.obstacles", Column::new::<Vector<3>>(&mut mpm.walls.displacement));
    mpm.walls.columns(visit);
    visit("mpm.reactions", Column::new::<Vector<D>>(&mut mpm.walls.force));
}
