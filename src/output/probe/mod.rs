//! Probes: histories of one quantity at a place, or reduced over a body or membrane.

mod fragments;
mod hexahedron;
mod impulse;
mod place;
mod reduce;
mod simple_elements;
mod spec;

pub use spec::{ProbeAxis, ProbeSpec, Reduction, Within};

use super::component::Component;
use super::history::{History, StepStart};
use super::label::{UnitLabels, component_names, file_name};
use super::set::{Set, SetQuantity, Start, expected};
use crate::error::{Diagnostic, Result};
use crate::simulation::{Column, Monitor, Snapshot};
use impulse::ProbeIntegral;
use place::{NearestEntry, find, follow};
use std::path::Path;

/// Writes `<name>.csv` for one [`ProbeSpec`].
#[derive(Debug)]
pub struct Probe {
    spec: ProbeSpec,
    dimension: usize,
    /// The particle, element or point of an element that is followed, and where it is at the start.
    found: Option<NearestEntry>,
    impulse: Option<ProbeIntegral>,
    start: Start,
    heads: Vec<String>,
    history: History,
    interval: f64,
    step_start: StepStart,
}

impl Probe {
    /// A probe whose history is in `directory`, every `interval` seconds unless the probe says otherwise.
    ///
    /// `initial` is the state at the start, also of a run that is going to be resumed: it tells which
    /// particle or node is followed. `key` is the probe's place in the case, for messages.
    ///
    /// # Errors
    /// A name that the model doesn't have, or keys that don't fit each other.
    pub fn new(
        spec: ProbeSpec,
        key: &str,
        initial: &Snapshot<'_>,
        directory: &Path,
        interval: f64,
        units: UnitLabels,
    ) -> Result<Self, Diagnostic> {
        spec.check(key, initial.dimension)?;
        let names: Vec<&str> = Set::all(initial).map(Set::name).collect();
        let set = Set::find(initial, &spec.of).ok_or_else(|| {
            let message = format!("there is no body, membrane or mesh named `{}`", spec.of);
            Diagnostic::error(format!("{key}.of"), message).help(expected(&spec.of, &names))
        })?;
        let start = if spec.quantity == "displacement" { set.start() } else { Start::new() };
        let quantity = set.quantity(&spec.quantity, &start).ok_or_else(|| {
            let message = format!("`{}` has no quantity `{}`", spec.of, spec.quantity);
            let help = set.lacks(&spec.quantity).unwrap_or_else(|| expected(&spec.quantity, &set.quantity_names()));
            Diagnostic::error(format!("{key}.quantity"), message).help(help)
        })?;
        check_whole(&spec, key, set)?;
        check_component(&spec, key, &quantity, initial.dimension)?;
        check_weight(&spec, key, set, &quantity)?;

        let dimension = initial.dimension;
        let found = spec.at.as_ref().and_then(|place| find(set, quantity.on, place));
        let mut heads = vec![units.head("time", "s")];
        heads.extend(columns(&spec, &quantity, dimension).iter().map(|(name, unit)| match spec.impulse {
            Some(_) => units.head(&format!("{name} impulse"), format!("{unit} s").trim_start()),
            None => units.head(name, unit),
        }));
        let history = History::new(directory.join(format!("{}.csv", file_name(&spec.name))));
        let interval = spec.every.unwrap_or(interval);
        let impulse = spec.impulse.map(|window| ProbeIntegral::new(&spec.name, window));
        Ok(Self { spec, dimension, found, impulse, start, heads, history, interval, step_start: StepStart::default() })
    }

    /// The heads of the history, time first.
    pub fn heads(&self) -> &[String] {
        &self.heads
    }

    /// The corners of the bounds of the target, if the probe's box holds nothing of it and the probe has no value.
    pub fn misses(&self, snapshot: &Snapshot<'_>) -> Option<[[f64; 3]; 2]> {
        let within = self.spec.within.as_ref()?;
        let set = Set::find(snapshot, &self.spec.of)?;
        let places = set.places(set.quantity(&self.spec.quantity, &self.start)?.on);
        let valued = || self.evaluate(snapshot).iter().any(|value| !value.is_nan());
        if places.is_empty() || places.iter().any(|x| within.contains(x)) || valued() {
            return None;
        }
        let bound = |i: usize, worst: f64, pick: fn(f64, f64) -> f64| places.iter().map(|x| x[i]).fold(worst, pick);
        let lower = std::array::from_fn(|i| bound(i, f64::INFINITY, f64::min));
        Some([lower, std::array::from_fn(|i| bound(i, f64::NEG_INFINITY, f64::max))])
    }

    /// The difference between the followed particle or element and the requested place, as a sentence.
    pub fn adjusted(&self) -> Option<String> {
        let (asked, NearestEntry { followed, place }) = (self.spec.at.as_ref()?, self.found.as_ref()?);
        let away = asked.iter().zip(place).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
        let size = place.iter().chain(asked).fold(0.0, |size: f64, c| size.max(c.abs()));
        // Not to the last digit, and without the sign of zero.
        let digits = 10f64.powi(9 - size.max(f64::MIN_POSITIVE).log10().ceil() as i32);
        let shown = |c: &f64| ((digits * c).round() / digits + 0.0).to_string();
        let places = |x: &[f64]| x.iter().take(self.dimension).map(shown).collect::<Vec<_>>().join(", ");
        let Self { spec: ProbeSpec { name, of, .. }, .. } = self;
        let what = match followed {
            place::Followed::Particle(_) => format!("follows the nearest particle of `{of}`, at the start"),
            _ => format!("looks at the nearest point of `{of}`,"),
        };
        (away > 1e-9 * size)
            .then(|| format!("probe {name}: {what} at ({}), {away:.3e} m from ({})", places(place), places(asked)))
    }

    /// The present values: as many numbers as heads after the time; NaN for a part that is gone.
    pub fn evaluate(&self, snapshot: &Snapshot<'_>) -> Vec<f64> {
        let count = self.heads.len() - 1;
        let Some(set) = Set::find(snapshot, &self.spec.of) else { return vec![f64::NAN; count] };
        let Some(quantity) = set.quantity(&self.spec.quantity, &self.start) else { return vec![f64::NAN; count] };
        let values = match &self.found {
            Some(found) => {
                follow(set, &found.followed, &quantity).unwrap_or_else(|| vec![f64::NAN; quantity.components])
            }
            None => return reduce::reduce(&self.spec, set, &quantity, self.dimension),
        };
        selected(&self.spec, &values, self.dimension)
    }
}

impl Probe {
    /// The numbers of a row, after the time.
    fn values(&self, snapshot: &Snapshot<'_>) -> Vec<f64> {
        match &self.impulse {
            Some(impulse) => impulse.values(snapshot.time, self.heads.len() - 1),
            None => self.evaluate(snapshot),
        }
    }
}

impl Monitor for Probe {
    fn interval(&self) -> f64 {
        self.interval
    }

    fn interpolates(&self) -> bool {
        true
    }

    fn begin_step(&mut self, snapshot: &Snapshot<'_>) {
        let values = self.values(snapshot);
        self.step_start.keep(snapshot.time, values);
    }

    /// Counts are those at the end of the step.
    fn sample(&mut self, snapshot: &Snapshot<'_>, due: f64) -> Result<()> {
        let values = self.values(snapshot);
        let counts = matches!(self.spec.reduction(), Some(Reduction::Count | Reduction::CountFragments));
        let values = if counts { values } else { self.step_start.between(due, snapshot.time, values) };
        self.history.append(&self.heads, &[vec![due], values].concat())
    }

    fn follows(&self, from: f64, to: f64) -> bool {
        self.impulse.as_ref().is_some_and(|impulse| impulse.holds(from, to))
    }

    fn follow(&mut self, snapshot: &Snapshot<'_>) {
        let values = self.evaluate(snapshot);
        self.impulse.iter_mut().for_each(|impulse| impulse.add(snapshot.time, &values));
    }

    fn columns(&mut self, visit: &mut dyn FnMut(&str, Column<'_>)) {
        self.impulse.iter_mut().for_each(|impulse| impulse.columns(visit));
    }

    fn resume(&mut self, time: f64) -> Result<()> {
        self.history.resume(time)?;
        self.history.begin(&self.heads)
    }
}

/// The components of a value that a history shows.
fn selected(spec: &ProbeSpec, value: &[f64], dimension: usize) -> Vec<f64> {
    match spec.component {
        Some(component) => vec![component.of(value)],
        None => value[..shown(value.len(), dimension)].to_vec(),
    }
}

/// Vectors have two components in 2D.
fn shown(components: usize, dimension: usize) -> usize {
    if components == 3 { dimension } else { components }
}

/// Names and units of the columns after the time.
fn columns<'q>(spec: &ProbeSpec, quantity: &SetQuantity<'q>, dimension: usize) -> Vec<(String, &'q str)> {
    let named = |name: &str, unit| vec![(name.to_owned(), unit)];
    match spec.reduction() {
        Some(Reduction::Top) => named("top", "m"),
        Some(Reduction::Bottom) => named("bottom", "m"),
        Some(Reduction::MaxRadius | Reduction::MeanRadius) => named("radius", "m"),
        Some(Reduction::CountFragments) => named("fragments", ""),
        Some(Reduction::Count) => named("count", ""),
        Some(Reduction::CenterOfMass) => {
            component_names(3).into_iter().take(dimension).map(|axis| (axis, "m")).collect()
        }
        _ => value_columns(spec, quantity, dimension),
    }
}

/// `x`, `ux` and `vx` for positions, displacements and velocities, `stress-xx` for others.
fn value_columns<'q>(spec: &ProbeSpec, quantity: &SetQuantity<'q>, dimension: usize) -> Vec<(String, &'q str)> {
    let name = |component: &str| match (spec.quantity.as_str(), component) {
        (quantity, "") => quantity.to_owned(),
        ("position", axis @ ("x" | "y" | "z")) => axis.to_owned(),
        ("displacement", axis @ ("x" | "y" | "z")) => format!("u{axis}"),
        ("velocity", axis @ ("x" | "y" | "z")) => format!("v{axis}"),
        (quantity, component) => format!("{quantity}-{component}"),
    };
    match spec.component {
        Some(component) => vec![(name(component.name()), quantity.unit)],
        None => {
            let names = component_names(quantity.components).into_iter().take(shown(quantity.components, dimension));
            names.map(|component| (name(&component), quantity.unit)).collect()
        }
    }
}

/// An element's part of the volume that a membrane encloses means nothing alone.
fn check_whole(spec: &ProbeSpec, key: &str, set: Set<'_>) -> Result<(), Diagnostic> {
    let whole = spec.reduction() == Some(Reduction::Sum) && spec.within.is_none() && spec.weight.is_none();
    if whole || spec.quantity != "volume" || !matches!(set, Set::Surface(_)) {
        return Ok(());
    }
    let message = format!("the volume that `{}` encloses is the sum over all of its elements", spec.of);
    Err(Diagnostic::error(format!("{key}.quantity"), message)
        .help("write `reduce = \"sum\"`, without `within` and `weight`"))
}

fn check_component(
    spec: &ProbeSpec,
    key: &str,
    quantity: &SetQuantity<'_>,
    dimension: usize,
) -> Result<(), Diagnostic> {
    let vertical = matches!(spec.reduce, Some(Reduction::Top | Reduction::Bottom));
    if dimension == 2 && vertical && spec.axis == Some(ProbeAxis::Z) {
        let finding = Diagnostic::error(format!("{key}.axis"), "there is no `z` in two dimensions");
        return Err(finding.help("take x or y"));
    }
    let misfit = |component: Component| {
        component.misfit(&format!("{key}.component"), &spec.quantity, quantity.components, dimension)
    };
    spec.component.and_then(misfit).map_or(Ok(()), Err)
}

fn check_weight(spec: &ProbeSpec, key: &str, set: Set<'_>, quantity: &SetQuantity<'_>) -> Result<(), Diagnostic> {
    let Some(weight) = &spec.weight else { return Ok(()) };
    match set.quantity(weight, &Start::new()) {
        Some(found) if found.components == 1 && found.on == quantity.on => Ok(()),
        _ => {
            let message = format!("`{weight}` is no scalar field of `{}` beside `{}`", spec.of, spec.quantity);
            Err(Diagnostic::error(format!("{key}.weight"), message).help(expected(weight, &set.quantity_names())))
        }
    }
}
