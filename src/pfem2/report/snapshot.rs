//! What outputs and checkpoints see: particles, mesh, ledger, forces, counts.

use crate::math::Vector;
use crate::pfem2::Pfem2;
use crate::pfem2::interface::filled;
use crate::pfem2::particles::Particles;
use crate::pfem2::step::RunCounts;
use crate::pfem2::time::step_control::ErrorEstimates;
use crate::simulation::TermKind::Other;
use crate::simulation::{BalanceTerm, Column, Elements, Field, Ledger, MOST_COUNTED, PointSet, Snapshot, SurfaceSet};
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
    let forces = pfem.parts.iter().zip(&pfem.mean_forces);
    Snapshot {
        step: pfem.steps,
        dt: pfem.dt_before,
        dimension: D,
        points: (0..pfem.density.len()).map(|fluid| points(pfem, fluid)).collect(),
        surfaces: std::iter::once(mesh(pfem)).chain(interface(pfem)).collect(),
        ledger: ledger(pfem),
        forces: forces.map(|(part, force)| (part.name.clone(), force.to3())).collect(),
        counts: counts(pfem),
        amounts: amounts(pfem),
        ..Snapshot::default()
    }
}

/// The particles of a fluid.
fn points<'a, const D: usize, const N: usize>(pfem: &'a Pfem2<D, N>, fluid: usize) -> PointSet<'a> {
    let particles = &pfem.particles;
    let own: Vec<u32> =
        (0..particles.len() as u32).filter(|&p| usize::from(particles.fluid[p as usize]) == fluid).collect();
    let position = own.iter().map(|&p| particles.position[p as usize].to3()).collect();
    let id = Cow::Owned(own.clone());
    let count = own.len();
    let [here, there] = [own.clone(), own.clone()];
    let volume = move || here.iter().map(|&p| pfem.volume(p as usize)).collect();
    let mass = move || there.iter().map(|&p| pfem.density[fluid] * pfem.volume(p as usize)).collect();
    let velocity = move || own.iter().flat_map(|&p| particles.velocity[p as usize].to3()).collect();
    PointSet {
        name: &pfem.system.physics.fluids[fluid].name,
        position,
        id,
        fields: vec![
            Field::computed("velocity", "m/s", 3, velocity),
            Field::computed("volume", if D == 2 { "m^2" } else { "m^3" }, 1, volume),
            Field::computed("mass", "kg", 1, mass),
            Field::computed("fluid", "", 1, move || vec![fluid as f64; count]),
        ],
        filled: Some(Box::new(move |bounds: &filled::Bounds| filled::pieces(pfem, fluid, bounds))),
    }
}

impl<const D: usize, const N: usize> Pfem2<D, N> {
    /// What a particle stands for: its share of its element [m³], or per depth [m²].
    fn volume(&self, particle: usize) -> f64 {
        let element = self.particles.element[particle] as usize;
        self.system.mesh.simplex(element).volume / self.particles.of(element).len() as f64
    }
}

/// The mesh with what its nodes know.
fn mesh<const D: usize, const N: usize>(pfem: &Pfem2<D, N>) -> SurfaceSet<'_> {
    let system = &pfem.system;
    let mut node_fields = vec![
        vectors("velocity", "m/s", &system.velocity),
        Field::scalar("pressure", "Pa", &system.pressure),
        Field::computed("density", "kg/m^3", 1, || densities(pfem)),
    ];
    if !pfem.level.is_empty() {
        node_fields.push(Field::scalar("level set", "", &pfem.level));
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

/// Where fluids meet; nothing if there is only one.
fn interface<const D: usize, const N: usize>(pfem: &Pfem2<D, N>) -> Option<SurfaceSet<'_>> {
    let outline = &pfem.outline;
    (pfem.density.len() > 1).then(|| SurfaceSet {
        name: INTERFACE,
        position: Cow::Borrowed(&outline.position),
        reference: Cow::Borrowed(&outline.position),
        elements: outline.facets(D),
        kind: Elements::Sheet,
        node_fields: vec![Field::computed("velocity", "m/s", 3, || outline.velocity.as_flattened().to_vec())],
        element_fields: vec![Field::scalar("area", if D == 2 { "m" } else { "m^2" }, &outline.size)],
    })
}

/// Mean density at the nodes [kg/m³].
fn densities<const D: usize, const N: usize>(pfem: &Pfem2<D, N>) -> Vec<f64> {
    let at = |node: usize| pfem.fraction.iter().zip(&pfem.density).map(|(f, rho)| f[node] * rho).sum();
    (0..pfem.places.len()).map(at).collect()
}

/// Energies, momentum, and the volume of each fluid.
fn ledger<const D: usize, const N: usize>(pfem: &Pfem2<D, N>) -> Ledger {
    let mut ledger = pfem.books.ledger::<D>(&pfem.totals, pfem.system.surface_energy());
    ledger.largest = pfem.largest_energy();
    let unit = if D == 2 { "m^2" } else { "m^3" };
    for (fluid, &value) in pfem.system.physics.fluids.iter().zip(&pfem.system.volumes) {
        ledger.terms.push(BalanceTerm { name: format!("volume: {}", fluid.name), unit, kind: Other, value });
    }
    for (fluid, value) in pfem.left() {
        let name = format!("outflow: {}", pfem.system.physics.fluids[fluid].name);
        ledger.terms.push(BalanceTerm { name, unit, kind: Other, value });
    }
    let fastest = pfem.system.velocity.iter().fold(0.0, |v: f64, w| v.max(w.norm()));
    ledger.terms.push(BalanceTerm { name: "largest speed".into(), unit: "m/s", kind: Other, value: fastest });
    ledger.terms.push(moved(pfem));
    let name = "energy of unresolved velocities".to_owned();
    ledger.terms.push(BalanceTerm { name, unit: "J", kind: Other, value: pfem.unresolved_energy });
    let ErrorEstimates { time, mesh, interface } = pfem.step_control.errors;
    let errors = [("error of the step", "1", time), ("error of the mesh", "1", mesh)];
    let errors = errors.into_iter().chain([("error of the interface", "elements", interface)]);
    ledger.terms.extend(errors.map(|(name, unit, value)| BalanceTerm { name: name.into(), unit, kind: Other, value }));
    ledger
}

/// What keeps the volumes.
fn moved<const D: usize, const N: usize>(pfem: &Pfem2<D, N>) -> BalanceTerm {
    let (name, unit, value) = match pfem.density.len() {
        0..=2 => ("shift of the interface", "m", pfem.shift),
        _ => ("factor between weights of shares", "1", pfem.weight),
    };
    BalanceTerm { name: name.into(), unit, kind: Other, value }
}

fn counts<const D: usize, const N: usize>(pfem: &Pfem2<D, N>) -> Vec<(String, u64)> {
    // What was found for the start is no step.
    let started = pfem.steps > 0;
    let counts = [
        ("particles", pfem.particles.len() as u64),
        ("particles: left", pfem.counts.left),
        ("particles: stuck", pfem.counts.stuck),
        ("particles: added", pfem.counts.added),
        ("particles: inflow", pfem.counts.inflow),
        ("particles: merged", pfem.counts.merged),
        ("particles: joined", pfem.counts.joined),
        ("elements: empty", pfem.counts.empty),
        ("elements: cut", pfem.system.cuts.len() as u64),
        ("solver: iterations", if started { pfem.system.outcome.iterations as u64 } else { 0 }),
        ("solver: preconditioners", if started { pfem.system.preconditioners } else { 0 }),
    ];
    counts.map(|(name, count)| (name.to_owned(), count)).to_vec()
}

/// What particles of each fluid stand for where the other one is.
fn amounts<const D: usize, const N: usize>(pfem: &Pfem2<D, N>) -> Vec<(String, &'static str, f64)> {
    let unit = if D == 2 { "m^2" } else { "m^3" };
    let fluids = pfem.system.physics.fluids.iter().zip(pfem.astray());
    fluids.map(|(fluid, volume)| (format!("astray: {}", fluid.name), unit, volume)).collect()
}

/// What doesn't fit together in restored columns.
pub fn misfit<const D: usize, const N: usize>(pfem: &Pfem2<D, N>) -> Option<String> {
    let Particles { position, velocity, fluid, depth, element, .. } = &pfem.particles;
    let count = position.len();
    if [velocity.len(), fluid.len(), depth.len(), element.len()].iter().any(|&other| other != count) {
        return Some(format!("its columns hold different numbers of particles, {count} positions among them"));
    }
    let (elements, fluids) = (pfem.system.mesh.elements().len(), pfem.density.len());
    if element.iter().any(|&e| e as usize >= elements) {
        return Some(format!("a particle lies in an element that the mesh of {elements} doesn't have"));
    }
    if fluid.iter().any(|&f| usize::from(f) >= fluids) {
        return Some(format!("a particle is of a fluid beyond the {fluids} there are"));
    }
    let RunCounts { left, stuck, added, inflow, merged, joined, empty } = pfem.counts;
    let age = pfem.sharp.as_ref().map_or(0, |sharp| sharp.age as u64);
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
    (!pfem.system.fits(&pfem.memory)).then(|| "the kept matrix is that of another mesh".to_owned())
}

/// True if all numbers that the next step starts from are finite, and lengths and times positive.
fn finite<const D: usize, const N: usize>(pfem: &Pfem2<D, N>) -> bool {
    let vectors = [&pfem.particles.position, &pfem.particles.velocity, &pfem.system.velocity, &pfem.before];
    // A fluid that has the mesh to itself is infinitely far from any interface.
    let distances = [&pfem.particles.depth, &pfem.level];
    let level = pfem.sharp.as_ref().is_none_or(|sharp| {
        sharp.band > 0.0 && sharp.band.is_finite() && sharp.level.iter().all(|phi| phi.is_finite())
    });
    let times = [pfem.dt_before, pfem.dt_earlier, pfem.step_control.proposal];
    vectors.iter().all(|column| column.iter().all(|v| v.is_finite()))
        && pfem.system.pressure.iter().all(|pressure| pressure.is_finite())
        && distances.iter().all(|column| column.iter().all(|distance| !distance.is_nan()))
        && level
        && times.iter().all(|&time| time >= 0.0)
        && [pfem.shift, pfem.weight, pfem.unresolved_energy].iter().all(|number| number.is_finite())
}

/// The columns of a checkpoint, with what the linear solver keeps over steps: a resumed run repeats the same bits.
pub fn columns<const D: usize, const N: usize>(pfem: &mut Pfem2<D, N>, visit: &mut dyn FnMut(&str, Column<'_>)) {
    pfem.memory = pfem.system.memory();
    let mut counters = pfem.memory.counters.to_vec();
    visit("solver/matrix", Column::growing(&mut pfem.memory.values));
    visit("solver/counters", Column::new(&mut counters));
    pfem.memory.counters.iter_mut().zip(counters).for_each(|(kept, read)| *kept = read);
    let particles = &mut pfem.particles;
    visit("particles/position", Column::growing(&mut particles.position));
    visit("particles/velocity", Column::growing(&mut particles.velocity));
    visit("particles/fluid", Column::growing(&mut particles.fluid));
    visit("particles/depth", Column::growing(&mut particles.depth));
    visit("particles/element", Column::growing(&mut particles.element));
    visit("nodes/velocity", Column::new(&mut pfem.system.velocity));
    visit("nodes/pressure", Column::new(&mut pfem.system.pressure));
    visit("nodes/projected", Column::new(&mut pfem.system.subscales.projected));
    visit("nodes/followed", Column::new(&mut pfem.system.subscales.followed));
    visit("nodes/force", Column::new(&mut pfem.system.force));
    visit("nodes/before", Column::new(&mut pfem.before));
    visit("nodes/earlier", Column::new(&mut pfem.earlier));
    visit("nodes/acceleration", Column::new(&mut pfem.acceleration));
    visit("nodes/carried", Column::new(&mut pfem.carried));
    visit("nodes/level", Column::new(&mut pfem.level));
    for (fluid, fraction) in pfem.system.physics.fluids.iter().zip(&mut pfem.fraction) {
        visit(&format!("nodes/fraction: {}", fluid.name), Column::new(fraction));
    }
    visit("books/works", Column::new(&mut pfem.books.entries));
    visit("books/last", Column::new(&mut pfem.books.last));
    visit("books/start", Column::new(&mut pfem.books.start));
    visit("books/peak", Column::new(&mut pfem.books.peak));
    visit("friction/power", Column::new(&mut pfem.friction.power));
    visit("friction/change", Column::new(&mut pfem.friction.change));
    visit("forces", Column::new(&mut pfem.forces));
    visit("forces/earlier", Column::new(&mut pfem.earlier_forces));
    // Nothing depends on these, but the state is shown with them.
    visit("forces/mean", Column::new(&mut pfem.mean_forces));
    let mut shown = vec![pfem.shift, pfem.weight, pfem.unresolved_energy];
    visit("shift, weight, unresolved", Column::new(&mut shown));
    if let [shift, weight, unresolved] = shown[..] {
        (pfem.shift, pfem.weight, pfem.unresolved_energy) = (shift, weight, unresolved);
    }
    let errors = pfem.step_control.errors;
    let control = &mut pfem.step_control;
    let mut clock = vec![pfem.dt_before, pfem.dt_earlier, control.proposal, errors.time, errors.mesh, errors.interface];
    visit("dt", Column::new(&mut clock));
    if let [before, earlier, proposal, time, mesh, interface] = clock[..] {
        (pfem.dt_before, pfem.dt_earlier, control.proposal) = (before, earlier, proposal);
        control.errors = ErrorEstimates { time, mesh, interface };
    }
    pfem.notices.columns(visit);
    let counts = &mut pfem.counts;
    let RunCounts { left, stuck, added, inflow, merged, joined, empty } = *counts;
    let iterations = pfem.system.outcome.iterations as u64;
    let mut numbers =
        vec![pfem.steps, left, stuck, added, inflow, merged, joined, empty, pfem.system.preconditioners, iterations];
    visit("counts", Column::new(&mut numbers));
    if let [steps, left, stuck, added, inflow, merged, joined, empty, preconditioners, iterations] = numbers[..] {
        (pfem.steps, pfem.system.preconditioners) = (steps, preconditioners);
        pfem.system.outcome.iterations = iterations as usize;
        *counts = RunCounts { left, stuck, added, inflow, merged, joined, empty };
    }
    if let Some(sharp) = &mut pfem.sharp {
        let [inside, all] = pfem.outflow;
        let mut state = vec![sharp.band, sharp.age as f64, inside, all];
        visit("level set/level", Column::new(&mut sharp.level));
        visit("level set/state", Column::new(&mut state));
        if let [band, age, inside, all] = state[..] {
            (sharp.band, sharp.age) = (band, age as usize);
            pfem.outflow = [inside, all];
        }
    }
}
