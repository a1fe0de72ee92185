//! The plots of a whole run: every history with its references, the energies, and their closure.

use super::{CurveShape, Data, HorizontalLine, PhaseReference, PlotAxis, PlotSeries, PlotSpec, lines};
use crate::error::{Error, Result};
use crate::output::atomic::create_directory;
use crate::output::balance::LOST_TO_ERRORS;
use crate::output::colour::PALETTE;
use crate::output::history::HistoryTable;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// A published curve to draw over a history.
#[derive(Debug, Clone, PartialEq)]
pub struct ReferenceCurve {
    /// The history: name of its file without extension.
    pub history: String,
    /// Another history whose values are added, as the force on a cylinder to that on a beam behind it.
    pub plus: Option<String>,
    /// The column, without unit.
    pub column: String,
    /// The entry of the legend: the source.
    pub label: String,
    /// The curve, in the units of the history.
    pub shape: CurveShape,
    /// The phase in which it is drawn; else at its own times.
    pub phase: Option<PhaseReference>,
}

/// Plots every history of `histories` into `plots`, one plot per unit of its columns.
///
/// # Errors
/// Input/output errors.
pub fn plot_run(histories: &Path, plots: &Path, references: &[ReferenceCurve]) -> Result<()> {
    create_directory(plots)?;
    let references = in_phase(histories, references)?;
    for name in history_names(histories)? {
        let table = HistoryTable::read(&histories.join(format!("{name}.csv")))?;
        if table.columns.first().is_none_or(|time| time.len() < 2) {
            continue;
        }
        let specs = if name == "balance" { balance(&table) } else { history(&name, &table, &references) };
        for (stem, spec) in specs {
            lines(&spec, &plots.join(stem))?;
        }
    }
    plot_sums(histories, plots, &references)
}

/// Plots the sums of two histories that have references.
fn plot_sums(histories: &Path, plots: &Path, references: &[ReferenceCurve]) -> Result<()> {
    let pairs: BTreeSet<[&String; 2]> =
        references.iter().filter_map(|one| Some([&one.history, one.plus.as_ref()?])).collect();
    for [one, other] in pairs {
        let files = [one, other].map(|name| histories.join(format!("{name}.csv")));
        if !files.iter().all(|file| file.is_file()) {
            continue;
        }
        let table = HistoryTable::read(&files[0])?.plus(&HistoryTable::read(&files[1])?, other);
        let name = format!("{one}-and-{other}");
        let own =
            references.iter().filter(|reference| &reference.history == one && reference.plus.as_ref() == Some(other));
        let own: Vec<ReferenceCurve> =
            own.map(|reference| ReferenceCurve { history: name.clone(), plus: None, ..reference.clone() }).collect();
        for (stem, spec) in history(&name, &table, &own) {
            lines(&spec, &plots.join(stem))?;
        }
    }
    Ok(())
}

/// The references, those with a phase moved to that of the run; one whose run has none is left out.
fn in_phase(histories: &Path, references: &[ReferenceCurve]) -> Result<Vec<ReferenceCurve>> {
    let moved = |reference: &ReferenceCurve| {
        let Some(phase) = &reference.phase else { return Ok(Some(reference.clone())) };
        let path = histories.join(format!("{}.csv", phase.history));
        if !path.is_file() {
            return Ok(None);
        }
        let table = HistoryTable::read(&path)?;
        let signal = table.names().iter().position(|name| *name == phase.column).map(|c| points(&table, c));
        let shift = signal.and_then(|signal| phase.shift(&signal));
        Ok(shift.map(|shift| ReferenceCurve { shape: reference.shape.later(shift), ..reference.clone() }))
    };
    references.iter().filter_map(|reference| moved(reference).transpose()).collect()
}

/// Names of all `.csv` files, in order; none if there is no directory.
fn history_names(directory: &Path) -> Result<Vec<String>> {
    let entries = match fs::read_dir(directory) {
        Ok(entries) => entries,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(vec![]),
        Err(error) => return Err(Error::io(directory, error)),
    };
    let name = |path: &Path| path.file_name()?.to_str()?.strip_suffix(".csv").map(str::to_owned);
    let mut names: Vec<String> = entries.filter_map(|entry| name(&entry.ok()?.path())).collect();
    names.sort_unstable();
    Ok(names)
}

/// One plot per column that has references, and one per unit for the others.
fn history(name: &str, table: &HistoryTable, references: &[ReferenceCurve]) -> Vec<(String, PlotSpec)> {
    let of_column = |column: &str| -> Vec<&ReferenceCurve> {
        let is_own = |reference: &&ReferenceCurve| {
            reference.history == name && reference.column == column && reference.plus.is_none()
        };
        references.iter().filter(is_own).collect()
    };
    let mut groups: BTreeMap<(String, Option<usize>), Vec<usize>> = BTreeMap::new();
    for (c, head) in table.heads.iter().enumerate().skip(1) {
        let PlotAxis { name, unit } = PlotAxis::of_head(head);
        let alone = of_column(&name).iter().any(|reference| !reference.shape.is_levels()).then_some(c);
        groups.entry((unit, alone)).or_default().push(c);
    }
    let count = groups.len();
    let plots = |((unit, _), columns): ((String, Option<usize>), Vec<usize>)| {
        let names: Vec<String> = columns.iter().map(|&c| PlotAxis::of_head(&table.heads[c]).name).collect();
        let end = table.columns[0].last().copied().unwrap_or_default();
        let drawn: Vec<&ReferenceCurve> = names.iter().flat_map(|name| of_column(name)).collect();
        let mut series: Vec<PlotSeries> = drawn.iter().map(|reference| reference.series(end)).collect();
        series.sort_by_key(|series| !matches!(series.data, Data::Band(_)));
        series.extend(columns.iter().map(|&c| curve(table, c)));
        let stem = if count == 1 { name.to_owned() } else { format!("{name}-{}", names[0]) };
        let y = PlotAxis { name: names.join(", "), unit };
        let x = PlotAxis::of_head(&table.heads[0]);
        let begin = drawn.iter().filter(|r| r.phase.is_some()).filter_map(|r| r.shape.begin()).reduce(f64::min);
        let closer = begin.map(|begin| {
            let title = format!("{name}, the last periods");
            let series = series.iter().map(|series| series.since(begin - 0.5 * (end - begin))).collect();
            (format!("{stem}-periods"), PlotSpec { title, x: x.clone(), y: y.clone(), series })
        });
        [(stem, PlotSpec { title: name.to_owned(), x, y, series })].into_iter().chain(closer)
    };
    groups.into_iter().flat_map(plots).collect()
}

impl PlotSeries {
    /// The part from the time `begin` on.
    fn since(&self, begin: f64) -> Self {
        let later = |points: &[[f64; 2]]| points.iter().filter(|point| point[0] >= begin).copied().collect();
        let data = match &self.data {
            Data::Line(points) => Data::Line(later(points)),
            Data::Dashed(points) => Data::Dashed(later(points)),
            Data::Markers(points) => Data::Markers(later(points)),
            Data::Band(points) => Data::Band(points.iter().filter(|point| point[0] >= begin).copied().collect()),
            Data::Levels(levels) => {
                Data::Levels(levels.iter().filter_map(|level| level.within(begin, f64::INFINITY)).collect())
            }
        };
        Self { label: self.label.clone(), data }
    }
}

impl HorizontalLine {
    /// The part from the time `begin` to the time `end`, if there is one.
    fn within(&self, begin: f64, end: f64) -> Option<Self> {
        let x = [self.x[0].max(begin), self.x[1].min(end)];
        (x[0] <= x[1]).then_some(Self { x, ..*self })
    }
}

impl ReferenceCurve {
    /// The reference up to the time `end` of the last row: what lies beyond it would only squeeze the curves.
    fn series(&self, end: f64) -> PlotSeries {
        let data = match &self.shape {
            CurveShape::Points(points) => {
                Data::Markers(points.iter().filter(|point| point[0] <= end).copied().collect())
            }
            CurveShape::Band(points) => Data::Band(points.iter().filter(|point| point[0] <= end).copied().collect()),
            CurveShape::Levels(levels) => {
                Data::Levels(levels.iter().filter_map(|level| level.within(0.0, end)).collect())
            }
        };
        PlotSeries { label: self.label.clone(), data }
    }
}

/// Energies larger than a small part of the largest, and the closure of the ledger.
fn balance(table: &HistoryTable) -> Vec<(String, PlotSpec)> {
    /// Columns that are sums of others.
    const SUMS: [&str; 3] = ["stored energy", "gained energy", "lost energy"];
    /// Energies below this part of the largest are not drawn.
    const VISIBLE: f64 = 2e-3;
    let Some(closure) = table.heads.iter().position(|head| PlotAxis::of_head(head).name == "closure") else {
        return vec![];
    };
    let energy = PlotAxis::of_head(&table.heads[closure]).unit;
    let largest = |c: usize| table.columns[c].iter().filter(|e| e.is_finite()).fold(0.0, |a: f64, e| a.max(e.abs()));
    let is_energy = |head: &str| {
        let axis = PlotAxis::of_head(head);
        // Without units, names tell.
        axis.unit == energy && !["mass", "momentum", "impulse"].iter().any(|other| axis.name.contains(other))
    };
    let energies: Vec<usize> = (1..closure).filter(|&c| is_energy(&table.heads[c])).collect();
    let scale = energies.iter().map(|&c| largest(c)).fold(0.0, f64::max);
    let mut visible: Vec<usize> = energies.into_iter().filter(|&c| largest(c) > VISIBLE * scale).collect();
    // No two curves of one colour: the smallest terms give way.
    visible.sort_by(|&a, &b| largest(b).total_cmp(&largest(a)));
    visible.truncate(PALETTE.len());
    visible.sort_unstable();

    let series = visible.into_iter().map(|c| {
        let PlotSeries { label, data } = curve(table, c);
        let sum = SUMS.contains(&label.as_str());
        PlotSeries {
            label,
            data: if let (true, Data::Line(points)) = (sum, &data) { Data::Dashed(points.clone()) } else { data },
        }
    });
    let x = PlotAxis::of_head(&table.heads[0]);
    let y = PlotAxis { name: "energy".into(), unit: energy.clone() };
    let energies = PlotSpec { title: "Energy balance".into(), x: x.clone(), y, series: series.collect() };

    vec![("balance".to_owned(), energies), ("closure".to_owned(), unexplained(table, x, closure, scale))]
}

/// The closure over the largest energy; where a term is found as the remainder of all others, what errors took.
fn unexplained(table: &HistoryTable, x: PlotAxis, closure: usize, scale: f64) -> PlotSpec {
    let (title, label, name, values): (_, _, _, Vec<f64>) = match table.column(LOST_TO_ERRORS) {
        Some(part) => (
            "What errors took of the energy (below zero: gave)",
            "numerical dissipation / largest other energy so far",
            LOST_TO_ERRORS,
            part.to_vec(),
        ),
        None => {
            let part = table.columns[closure].iter().map(|c| c / scale.max(f64::MIN_POSITIVE));
            ("What the energy ledger can't explain", "closure / largest energy", "relative closure", part.collect())
        }
    };
    let points = table.columns[0].iter().zip(values).map(|(&t, value)| [t, value]).collect();
    let series = vec![PlotSeries { label: label.into(), data: Data::Line(points) }];
    PlotSpec { title: title.into(), x, y: PlotAxis { name: name.into(), unit: String::new() }, series }
}

fn curve(table: &HistoryTable, column: usize) -> PlotSeries {
    PlotSeries { label: PlotAxis::of_head(&table.heads[column]).name, data: Data::Line(points(table, column)) }
}

/// A column over the first one.
fn points(table: &HistoryTable, column: usize) -> Vec<[f64; 2]> {
    table.columns[0].iter().zip(&table.columns[column]).map(|(&x, &y)| [x, y]).collect()
}
