//! The columns of a checkpoint: all that a run goes on from with the same bits.

use crate::linalg::SolverCounters;
use crate::pfem2::Pfem2;
use crate::pfem2::particles::Particles;
use crate::pfem2::particles::tracking::ParticleEvents;
use crate::pfem2::time::step_control::ErrorEstimates;
use crate::simulation::{Column, MOST_COUNTED, Number, Record};

/// The contradiction in restored columns, if there is one.
pub fn misfit<const D: usize, const N: usize>(pfem: &Pfem2<D, N>) -> Option<String> {
    let particles = &pfem.particles.columns;
    let (count, Particles { fluid, element, .. }) = (particles.len(), particles);
    if !particles.is_consistent() {
        return Some(format!("its columns hold different numbers of particles, {count} positions among them"));
    }
    let (elements, fluids) = (pfem.system.mesh.elements().len(), pfem.interface.list.count());
    if element.iter().any(|&e| e as usize >= elements) {
        return Some(format!("a particle lies in an element that the mesh of {elements} doesn't have"));
    }
    if fluid.iter().any(|&f| usize::from(f) >= fluids) {
        return Some(format!("a particle is of a fluid beyond the {fluids} there are"));
    }
    let ParticleEvents { left, stuck, added, inflow, merged, joined, empty } = pfem.particles.events;
    let age = pfem.interface.sharp.as_ref().map_or(0, |sharp| sharp.age as u64);
    let counted = [pfem.steps, left, stuck, added, inflow, merged, joined, empty, pfem.system.preconditioners, age];
    if counted.iter().any(|&count| count > MOST_COUNTED) {
        return Some("it counts more than any run does".to_owned());
    }
    if !finite(pfem) {
        return Some("it holds numbers that are not finite".to_owned());
    }
    if let Some(misfit) = pfem.notices.misfit() {
        return Some(misfit);
    }
    (!pfem.system.fits(&pfem.solver_state)).then(|| "the kept matrix is that of another mesh".to_owned())
}

/// True if all numbers that the next step starts from are finite, and lengths and times positive.
fn finite<const D: usize, const N: usize>(pfem: &Pfem2<D, N>) -> bool {
    let vectors = [
        &pfem.particles.columns.position,
        &pfem.particles.columns.velocity,
        &pfem.system.velocity,
        &pfem.history.velocity_previous,
    ];
    // A fluid that has the mesh to itself is infinitely far from any interface.
    let distances = [&pfem.particles.columns.depth, &pfem.interface.level];
    let level = pfem.interface.sharp.as_ref().is_none_or(|sharp| {
        sharp.band > 0.0 && sharp.band.is_finite() && sharp.level.iter().all(|phi| phi.is_finite())
    });
    let times = [pfem.history.dt_previous, pfem.history.dt_earlier, pfem.limits.control.proposal];
    vectors.iter().all(|column| column.iter().all(|v| v.is_finite()))
        && pfem.system.pressure.iter().all(|pressure| pressure.is_finite())
        && distances.iter().all(|column| column.iter().all(|distance| !distance.is_nan()))
        && level
        && times.iter().all(|&time| time >= 0.0)
        && [pfem.interface.shift, pfem.interface.weight, pfem.particles.unresolved_energy]
            .iter()
            .all(|number| number.is_finite())
}

impl Record for SolverCounters {
    type Number = f64;
}

/// The columns of a checkpoint, with what the linear solver keeps over steps: a resumed run repeats the same bits.
pub fn columns<const D: usize, const N: usize>(pfem: &mut Pfem2<D, N>, visit: &mut dyn FnMut(&str, Column<'_>)) {
    pfem.solver_state = pfem.system.solver_state();
    visit("solver/matrix", Column::growing(&mut pfem.solver_state.values));
    visit("solver/counters", Column::record(&mut pfem.solver_state.counters));
    pfem.particles.columns.visit_columns(visit);
    visit("nodes/velocity", Column::new(&mut pfem.system.velocity));
    visit("nodes/pressure", Column::new(&mut pfem.system.pressure));
    visit("nodes/projected", Column::new(&mut pfem.system.subscales.projected));
    visit("nodes/followed", Column::new(&mut pfem.system.subscales.followed));
    visit("nodes/force", Column::new(&mut pfem.system.force));
    visit("nodes/before", Column::new(&mut pfem.history.velocity_previous));
    visit("nodes/earlier", Column::new(&mut pfem.history.velocity_earlier));
    visit("nodes/acceleration", Column::new(&mut pfem.history.acceleration));
    visit("nodes/carried", Column::new(&mut pfem.history.acceleration_previous));
    visit("nodes/level", Column::new(&mut pfem.interface.level));
    for (fluid, fraction) in pfem.system.physics.fluids.iter().zip(&mut pfem.interface.fraction) {
        visit(&format!("nodes/fraction: {}", fluid.name), Column::new(fraction));
    }
    visit("energy ledger", Column::record(&mut pfem.balance.ledger));
    let dissipation = &mut pfem.balance.dissipation;
    [dissipation.power_last, dissipation.power_earlier] =
        visit_numbers(visit, "friction/power", [dissipation.power_last, dissipation.power_earlier]);
    visit("friction/change", Column::new(&mut dissipation.change));
    visit("forces", Column::new(&mut pfem.forces.last));
    visit("forces/earlier", Column::new(&mut pfem.forces.previous));
    // Nothing depends on these, but the state is shown with them.
    visit("forces/mean", Column::new(&mut pfem.forces.mean));
    let (interface, particles) = (&mut pfem.interface, &mut pfem.particles);
    let shown = [interface.shift, interface.weight, particles.unresolved_energy];
    [interface.shift, interface.weight, particles.unresolved_energy] =
        visit_numbers(visit, "shift, weight, unresolved", shown);
    let (history, control) = (&mut pfem.history, &mut pfem.limits.control);
    let ErrorEstimates { time, mesh, interface } = control.errors;
    let clock = [history.dt_previous, history.dt_earlier, control.proposal, time, mesh, interface];
    let [previous, earlier, proposal, time, mesh, interface] = visit_numbers(visit, "dt", clock);
    (history.dt_previous, history.dt_earlier, control.proposal) = (previous, earlier, proposal);
    control.errors = ErrorEstimates { time, mesh, interface };
    pfem.notices.columns(visit);
    let ParticleEvents { left, stuck, added, inflow, merged, joined, empty } = pfem.particles.events;
    let (preconditioners, iterations) = (pfem.system.preconditioners, pfem.system.outcome.iterations as u64);
    let counts = [pfem.steps, left, stuck, added, inflow, merged, joined, empty, preconditioners, iterations];
    let [steps, left, stuck, added, inflow, merged, joined, empty, preconditioners, iterations] =
        visit_numbers(visit, "counts", counts);
    pfem.particles.events = ParticleEvents { left, stuck, added, inflow, merged, joined, empty };
    (pfem.steps, pfem.system.preconditioners) = (steps, preconditioners);
    pfem.system.outcome.iterations = iterations as usize;
    if let Some(sharp) = &mut pfem.interface.sharp {
        visit("level set/level", Column::new(&mut sharp.level));
        let [inside, all] = pfem.interface.outflow;
        let state = [sharp.band, sharp.age as f64, inside, all];
        let [band, age, inside, all] = visit_numbers(visit, "level set/state", state);
        (sharp.band, sharp.age, pfem.interface.outflow) = (band, age as usize, [inside, all]);
    }
}

/// Shows named numbers as one column; returns them as they are afterwards.
pub(super) fn visit_numbers<T: Number, const K: usize>(
    visit: &mut dyn FnMut(&str, Column<'_>),
    name: &str,
    mut numbers: [T; K],
) -> [T; K] {
    visit(name, Column::record(&mut numbers));
    numbers
}
