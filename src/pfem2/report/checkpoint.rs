//! The columns of a checkpoint: all that a run goes on from with the same bits.

use crate::linalg::{CoarseCounters, SolverCounters};
use crate::pfem2::Pfem2;
use crate::pfem2::moments::StepMeans;
use crate::pfem2::particles::Particles;
use crate::pfem2::time::step_control::{ErrorEstimates, StepControl};
use crate::pfem2::time::vibration::Vibration;
use crate::pfem2::tracking::interface::InterfaceTracking;
use crate::pfem2::tracking::particles::ParticleEvents;
use crate::simulation::{Column, MOST_COUNTED, Record};

/// The contradiction in restored columns, if there is one.
pub fn misfit<const D: usize, const N: usize>(pfem: &Pfem2<D, N>) -> Option<String> {
    let particles = &pfem.particles.columns;
    let (count, Particles { phase, element, .. }) = (particles.len(), particles);
    if !particles.is_consistent() {
        return Some(format!("its columns hold different numbers of particles, {count} positions among them"));
    }
    let (elements, fluids) = (pfem.system.mesh.elements().len(), pfem.interface.list.count());
    if element.iter().any(|&e| e as usize >= elements) {
        return Some(format!("a particle lies in an element that the mesh of {elements} doesn't have"));
    }
    if phase.iter().any(|&phase| usize::from(phase) >= fluids) {
        return Some(format!("a particle is of a phase beyond the {fluids} there are"));
    }
    let age = pfem.interface.sharp.as_ref().map_or(0, |sharp| sharp.age as u64);
    let counts = [pfem.steps, pfem.system.linear.preconditioners, age];
    let events: &[u64] = bytemuck::cast_slice(std::slice::from_ref(&pfem.particles.events));
    if counts.iter().chain(events).any(|&count| count > MOST_COUNTED) {
        return Some("it counts more than any run does".to_owned());
    }
    if !finite(pfem) {
        return Some("it holds numbers that are not finite".to_owned());
    }
    if let Some(misfit) = pfem.notices.misfit() {
        return Some(misfit);
    }
    (!pfem.system.linear.fits(&pfem.solver_state)).then(|| "the kept matrix is that of another mesh".to_owned())
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
    let StepControl { proposal, recommended, solids_curvature, solids_peak, .. } = pfem.limits.control;
    let steps = [pfem.history.dt_previous, pfem.history.dt_earlier, proposal, recommended];
    let times = [&steps[..], &[solids_curvature, solids_peak]].concat();
    vectors.iter().all(|column| column.iter().all(|v| v.is_finite()))
        && pfem.system.pressure.iter().all(|pressure| pressure.is_finite())
        && distances.iter().all(|column| column.iter().all(|distance| !distance.is_nan()))
        && level
        && times.iter().all(|&time| time >= 0.0 && time.is_finite())
        && [pfem.interface.shift, pfem.interface.weight, pfem.particles.unresolved_energy]
            .iter()
            .all(|number| number.is_finite())
}

impl Record for SolverCounters {
    type Number = f64;
}

impl Record for CoarseCounters {
    type Number = f64;
}

impl Record for ErrorEstimates {
    type Number = f64;
}

impl Record for Vibration {
    type Number = f64;
}

impl Record for ParticleEvents {
    type Number = u64;
}

/// The columns of a checkpoint, with what the linear solver keeps over steps: a resumed run repeats the same bits.
pub fn columns<const D: usize, const N: usize>(pfem: &mut Pfem2<D, N>, visit: &mut dyn FnMut(&str, Column<'_>)) {
    visit("steps", Column::scalar(&mut pfem.steps));
    solver_columns(pfem, visit);
    pfem.particles.columns.visit_columns(visit);
    visit("particles/unresolved energy", Column::scalar(&mut pfem.particles.unresolved_energy));
    visit("particles/events", Column::record(&mut pfem.particles.events));
    node_columns(pfem, visit);
    interface_columns(&mut pfem.interface, visit);
    visit("energy ledger", Column::record(&mut pfem.balance.ledger));
    solid_columns(pfem, visit);
    let dissipation = &mut pfem.balance.dissipation;
    visit("dissipation/power", Column::scalar(&mut dissipation.power_last));
    visit("dissipation/power earlier", Column::scalar(&mut dissipation.power_earlier));
    visit("dissipation/power in cut elements", Column::record(&mut dissipation.in_cut));
    visit("dissipation/change", Column::new(&mut dissipation.change));
    // Nothing depends on means, but the state is shown with them.
    mean_columns("forces", &mut pfem.forces.on_parts, visit);
    mean_columns("moments", &mut pfem.forces.moments, visit);
    visit("dt/previous", Column::scalar(&mut pfem.history.dt_previous));
    visit("dt/earlier", Column::scalar(&mut pfem.history.dt_earlier));
    visit("dt/proposal", Column::scalar(&mut pfem.limits.control.proposal));
    visit("dt/errors", Column::record(&mut pfem.limits.control.errors));
    visit("dt/recommended", Column::scalar(&mut pfem.limits.control.recommended));
    visit("dt/impact", Column::scalar(&mut pfem.limits.control.impact));
    visit("dt/curvature of solids", Column::scalar(&mut pfem.limits.control.solids_curvature));
    visit("dt/recent curvatures of solids", Column::record(&mut pfem.limits.control.solids_recent));
    visit("dt/vibration of solids", Column::record(&mut pfem.limits.control.vibration));
    visit("dt/largest energy of solids", Column::scalar(&mut pfem.limits.control.solids_peak));
    pfem.notices.columns(visit);
}

/// The matrix that the linear solver keeps, and its counts.
fn solver_columns<const D: usize, const N: usize>(pfem: &mut Pfem2<D, N>, visit: &mut dyn FnMut(&str, Column<'_>)) {
    pfem.solver_state = pfem.system.linear.solver_state();
    visit("solver/matrix", Column::growing(&mut pfem.solver_state.values));
    visit("solver/compliance places", Column::growing(&mut pfem.solver_state.compliance_places));
    visit("solver/compliance", Column::growing(&mut pfem.solver_state.compliance));
    visit("solver/coarse added mass", Column::growing(&mut pfem.solver_state.coarse.added_mass));
    visit("solver/coarse forces", Column::growing(&mut pfem.solver_state.coarse.forces));
    visit("solver/coarse counters", Column::record(&mut pfem.solver_state.coarse.counters));
    visit("solver/counters", Column::record(&mut pfem.solver_state.counters));
    visit("solver/preconditioners", Column::scalar(&mut pfem.system.linear.preconditioners));
    visit_count(visit, "solver/iterations", &mut pfem.system.linear.outcome.iterations);
}

/// Values at the nodes.
fn node_columns<const D: usize, const N: usize>(pfem: &mut Pfem2<D, N>, visit: &mut dyn FnMut(&str, Column<'_>)) {
    visit("nodes/velocity", Column::new(&mut pfem.system.velocity));
    visit("nodes/pressure", Column::new(&mut pfem.system.pressure));
    visit("nodes/projected", Column::new(&mut pfem.system.subscales.projected));
    visit("nodes/followed", Column::new(&mut pfem.system.subscales.followed));
    let dynamic = &mut pfem.system.subscales.dynamic;
    visit("elements/subscale", Column::new(&mut dynamic.velocity));
    visit("elements/subscale: convected", Column::new(&mut dynamic.convected));
    visit("elements/subscale: acceleration", Column::new(&mut dynamic.acceleration));
    visit("elements/subscale: acceleration previous", Column::new(&mut dynamic.acceleration_previous));
    visit("nodes/force", Column::new(&mut pfem.system.force));
    visit("nodes/velocity previous", Column::new(&mut pfem.history.velocity_previous));
    visit("nodes/velocity earlier", Column::new(&mut pfem.history.velocity_earlier));
    visit("nodes/acceleration", Column::new(&mut pfem.history.acceleration));
    visit("nodes/acceleration previous", Column::new(&mut pfem.history.acceleration_previous));
    for (name, fraction) in pfem.system.phase_names().zip(&mut pfem.interface.fraction) {
        visit(&format!("nodes/fraction: {name}"), Column::new(fraction));
    }
}

/// The level sets, and how their volumes are kept.
fn interface_columns<const D: usize>(interface: &mut InterfaceTracking<D>, visit: &mut dyn FnMut(&str, Column<'_>)) {
    visit("interface/level", Column::new(&mut interface.level));
    visit("interface/shift", Column::scalar(&mut interface.shift));
    visit("interface/weight", Column::scalar(&mut interface.weight));
    if let Some(sharp) = &mut interface.sharp {
        visit("level set/level", Column::new(&mut sharp.level));
        visit("level set/band", Column::scalar(&mut sharp.band));
        visit_count(visit, "level set/age", &mut sharp.age);
        visit("level set/outflow", Column::record(&mut interface.outflow));
    }
}

/// State of solids, and the forces on them.
fn solid_columns<const D: usize, const N: usize>(pfem: &mut Pfem2<D, N>, visit: &mut dyn FnMut(&str, Column<'_>)) {
    if let Some(energy) = &mut pfem.balance.solids {
        visit("solids/energy", Column::record(energy));
    }
    if let Some(strain) = &mut pfem.balance.strain {
        visit("solids/strain energy", Column::record(strain));
    }
    if let Some(solids) = &mut pfem.system.particle_solids {
        visit("solids/forces", Column::new(&mut solids.forces));
    }
    let Some(solids) = &mut pfem.solids else { return };
    let (state, last) = (&mut solids.structure.state, &mut solids.last);
    visit("solids/displacement", Column::new(&mut state.displacement));
    visit("solids/correction", Column::new(&mut state.correction));
    visit("solids/velocity", Column::new(&mut state.velocity));
    visit("solids/velocity previous", Column::new(&mut state.velocity_previous));
    visit("solids/velocity earlier", Column::new(&mut state.velocity_earlier));
    visit("solids/acceleration", Column::new(&mut state.acceleration));
    visit("solids/acceleration previous", Column::new(&mut state.acceleration_previous));
    visit("solids/surface acceleration", Column::new(&mut state.surface_acceleration));
    visit("solids/surface acceleration previous", Column::new(&mut state.surface_acceleration_previous));
    visit("solids/velocity change", Column::new(&mut state.velocity_change));
    visit("solids/predicted", Column::new(&mut last.predicted));
    mean_columns("solids/forces", &mut last.forces, visit);
    visit("solids/nodal forces", Column::new(&mut last.nodal));
    mean_columns("solids/moments", &mut last.moments, visit);
    mean_columns("solids/holding", &mut last.holding, visit);
    mean_columns("solids/holding moments", &mut last.holding_moments, visit);
    visit("solids/contact forces of walls", Column::new(&mut last.contact_forces.walls));
    visit_count(visit, "solids/solutions", &mut last.solutions);
    visit_count(visit, "solids/backward steps", &mut last.backward_steps);
    visit("solids/contact forces of solids", Column::new(&mut last.contact_forces.solids));
    for (k, rigid) in state.rigid.iter_mut().enumerate() {
        visit(&format!("solids/rigid {k}"), Column::record(rigid));
    }
    visit("solids/energies", Column::record(&mut last.energies));
}

/// Forces or moments of the last steps.
fn mean_columns<const D: usize>(name: &str, forces: &mut StepMeans<D>, visit: &mut dyn FnMut(&str, Column<'_>)) {
    visit(name, Column::new(&mut forces.last));
    visit(&format!("{name}/earlier"), Column::new(&mut forces.previous));
    visit(&format!("{name}/mean"), Column::new(&mut forces.mean));
}

/// Shows a count as one number.
fn visit_count(visit: &mut dyn FnMut(&str, Column<'_>), name: &str, count: &mut usize) {
    let mut number = *count as u64;
    visit(name, Column::scalar(&mut number));
    *count = number as usize;
}
