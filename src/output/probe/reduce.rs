//! Reductions, in the order of the entries, so that they don't depend on the number of threads.

use super::fragments::count_fragments;
use super::{ProbeSpec, Reduction, Within, selected};
use crate::output::set::{Set, SetQuantity, Start};
use crate::parallel::{self, CHUNK};
use crate::simulation::PointSet;
use std::ops::Range;

/// The reduced values: as many as the probe has columns. Means and sums of a body that fills a region are integrals
/// over that region.
pub(super) fn reduce(spec: &ProbeSpec, set: Set<'_>, quantity: &SetQuantity<'_>, dimension: usize) -> Vec<f64> {
    if let Set::Points(PointSet { filled: Some(filled), .. }) = set
        && integrates(spec)
    {
        let pieces = filled(&bounds(spec));
        let set = Set::Points(&pieces);
        if let Some(quantity) = set.quantity(&spec.quantity, &Start::new()) {
            let whole = ProbeSpec { within: None, weight: measure(spec), ..spec.clone() };
            return reduce_entries(&whole, set, &quantity, dimension);
        }
    }
    reduce_entries(spec, set, quantity, dimension)
}

/// True for integrals over a region.
fn integrates(spec: &ProbeSpec) -> bool {
    let over = matches!(
        spec.reduction(),
        Some(Reduction::Mean | Reduction::Sum | Reduction::CenterOfMass | Reduction::MeanRadius)
    );
    // Displacements are of particles.
    over && spec.quantity != "displacement"
}

/// Weight of an integral over a region: the volume, except for the sum of all volume or mass.
fn measure(spec: &ProbeSpec) -> Option<String> {
    let amount = spec.reduction() == Some(Reduction::Sum) && matches!(spec.quantity.as_str(), "volume" | "mass");
    spec.weight.clone().or_else(|| (!amount).then(|| "volume".to_owned()))
}

/// Lower and upper corner of the probe's box [m].
fn bounds(spec: &ProbeSpec) -> [[f64; 3]; 2] {
    let corner = |side: fn(&Within) -> &[f64], open: f64| {
        let given = spec.within.as_ref().map_or(&[][..], side);
        std::array::from_fn(|axis| given.get(axis).copied().unwrap_or(open))
    };
    [corner(|within| &within.lower, f64::NEG_INFINITY), corner(|within| &within.upper, f64::INFINITY)]
}

/// The values reduced over particles, nodes or elements.
fn reduce_entries(spec: &ProbeSpec, set: Set<'_>, quantity: &SetQuantity<'_>, dimension: usize) -> Vec<f64> {
    let places = set.places(quantity.on);
    let inside = |x: &[f64; 3]| spec.within.as_ref().is_none_or(|within| within.contains(x));
    let chosen: Vec<usize> = parallel::collect_some(places.len(), CHUNK, |i| inside(&places[i]).then_some(i));
    let weights = EntryWeights::new(spec, set);
    let axis = spec.axis.map_or(dimension - 1, |axis| axis.index());
    let coordinate = |i: usize| vec![places[i][axis]];
    let radius = |i: usize| vec![radius(spec, &places[i], dimension)];
    let value =
        |i: usize| selected(spec, &quantity.values[i * quantity.components..][..quantity.components], dimension);
    let count = selected(spec, &vec![0.0; quantity.components], dimension).len();
    match spec.reduction().unwrap_or(Reduction::Mean) {
        Reduction::Top => extreme(&chosen, 1, coordinate, greatest),
        Reduction::Bottom => extreme(&chosen, 1, coordinate, least),
        Reduction::MaxRadius => extreme(&chosen, 1, radius, greatest),
        Reduction::MeanRadius => weights.mean(&chosen, 1, radius),
        Reduction::Count => vec![chosen.len() as f64],
        Reduction::CountFragments => {
            let places: Vec<_> = chosen.iter().map(|&i| places[i]).collect();
            vec![count_fragments(&places, spec.cell.unwrap_or(f64::INFINITY)) as f64]
        }
        Reduction::CenterOfMass => weights.or_mass(set).mean(&chosen, dimension, |i| places[i][..dimension].to_vec()),
        Reduction::Mean => weights.mean(&chosen, count, value),
        Reduction::Sum => weights.sum(&chosen, count, value),
        Reduction::Min => extreme(&chosen, count, value, least),
        Reduction::Max => extreme(&chosen, count, value, greatest),
    }
}

/// NaN wins, so that it is noticed.
fn least(a: f64, b: f64) -> f64 {
    if a.is_nan() || a < b { a } else { b }
}

/// NaN wins, so that it is noticed.
fn greatest(a: f64, b: f64) -> f64 {
    if a.is_nan() || a > b { a } else { b }
}

/// Distance from the centre, or from the axis through it [m].
fn radius(spec: &ProbeSpec, x: &[f64; 3], dimension: usize) -> f64 {
    let center = spec.center.as_deref().unwrap_or(&[]);
    let along = spec.axis.map(|axis| axis.index());
    let offset = |i: usize| x[i] - center.get(i).copied().unwrap_or(0.0);
    (0..dimension).filter(|&i| Some(i) != along).map(|i| offset(i).powi(2)).sum::<f64>().sqrt()
}

/// The better one of each value; NaN where nothing is chosen.
fn extreme(
    chosen: &[usize],
    count: usize,
    value: impl Fn(usize) -> Vec<f64> + Sync,
    better: fn(f64, f64) -> f64,
) -> Vec<f64> {
    let both = |a: Vec<f64>, b: Vec<f64>| a.into_iter().zip(b).map(|(a, b)| better(a, b)).collect();
    let of_chunks = parallel::map_ranges(chosen.len(), CHUNK, |range| range.map(|n| value(chosen[n])).reduce(both));
    of_chunks.into_iter().flatten().reduce(both).unwrap_or_else(|| vec![f64::NAN; count])
}

/// Weights of entries; equal weights if `None`.
struct EntryWeights(Option<Vec<f64>>);

impl EntryWeights {
    fn new(spec: &ProbeSpec, set: Set<'_>) -> Self {
        Self(spec.weight.as_ref().and_then(|name| Self::field(set, name)))
    }

    /// These weights, or masses where there are none.
    fn or_mass(self, set: Set<'_>) -> Self {
        Self(self.0.or_else(|| Self::field(set, "mass")))
    }

    fn field(set: Set<'_>, name: &str) -> Option<Vec<f64>> {
        set.quantity(name, &Start::new()).filter(|field| field.components == 1).map(|field| field.values.into_owned())
    }

    fn of(&self, i: usize) -> f64 {
        self.0.as_ref().map_or(1.0, |weights| weights[i])
    }

    fn sum(&self, chosen: &[usize], count: usize, value: impl Fn(usize) -> Vec<f64> + Sync) -> Vec<f64> {
        let of_chunk = |range: Range<usize>| {
            let mut sum = vec![0.0; count];
            for &i in &chosen[range] {
                sum.iter_mut().zip(value(i)).for_each(|(sum, value)| *sum += self.of(i) * value);
            }
            sum
        };
        let both = |a: Vec<f64>, b: Vec<f64>| a.into_iter().zip(b).map(|(a, b)| a + b).collect();
        parallel::map_ranges(chosen.len(), CHUNK, of_chunk).into_iter().reduce(both).unwrap_or_else(|| vec![0.0; count])
    }

    /// NaN where nothing is chosen.
    fn mean(&self, chosen: &[usize], count: usize, value: impl Fn(usize) -> Vec<f64> + Sync) -> Vec<f64> {
        let total = parallel::sum(chosen.len(), |n| self.of(chosen[n]));
        self.sum(chosen, count, value).into_iter().map(|sum| sum / total).collect()
    }
}
