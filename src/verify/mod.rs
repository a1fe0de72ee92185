//! Runs validation cases and compares their results with published, analytic or independent values.
//!
//! The comparisons of a case stand beside it in `expected.toml` ([`mod@expected`]); quantities of histories are
//! measured in [`series`] and [`measure`], fields are compared in [`profile`]; the case with other settings is a [`variant`].

pub mod check;
pub mod curve;
pub mod expected;
pub mod measure;
pub mod outcome;
pub mod profile;
pub mod series;
mod table;
pub mod variant;

pub use expected::Expected;
pub use outcome::{Level, Outcome};
pub use series::Series;
pub use table::render;

use crate::catalog::EXPECTED_FILE;
use crate::error::{Diagnostic, Error, Result};
use crate::output::history::HistoryTable;
use crate::output::plot::{CurveShape, HorizontalLine, PhaseReference, ReferenceCurve};
use crate::run::{self, Existing, Folder, Options, RunDirectory};
use curve::Curve;
use std::io;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// The comparisons of a case; `None` if there is no file of them.
///
/// # Errors
/// A file that can't be read, or is wrong.
pub fn expected(folder: &Folder) -> Result<Option<Expected>> {
    folder.text(EXPECTED_FILE)?.map(|text| Expected::parse(&text)).transpose()
}

/// Runs a case into `directory` and compares it, also where its [`expected::Effort`] leaves it out at this level.
///
/// # Errors
/// The case is wrong, the run failed, or a history or reference isn't there.
pub fn verify(
    folder: &Folder,
    expected: &Expected,
    level: Level,
    directory: &Path,
    stop: &Arc<AtomicBool>,
) -> Result<Vec<Outcome>> {
    let case = folder.read(&expected.effort(level).overrides())?;
    let directory = RunDirectory::new(directory);
    let options = Options {
        existing: Existing::Replace,
        stop: Arc::clone(stop),
        references: drawn(folder, expected)?,
        ..Options::default()
    };
    run::run(&case, case.build()?, &directory, options)?;
    let mut outcomes = compare(folder, expected, level, &directory.history())?;
    for profile in &expected.profiles {
        outcomes.push(profile.apply(&directory.fields(), level, |file| table_beside(folder, file))?);
    }
    Ok(outcomes)
}

/// Compares the histories of a run that is there already.
///
/// # Errors
/// A history, a column or a reference isn't there.
pub fn compare(folder: &Folder, expected: &Expected, level: Level, histories: &Path) -> Result<Vec<Outcome>> {
    let apply = |check: &check::Check| {
        let read = |name: &String| {
            let path = histories.join(format!("{name}.csv"));
            let history = if path.is_file() { HistoryTable::read(&path)? } else { HistoryTable::default() };
            if history.heads.is_empty() { Err(no_history(check, name, histories)) } else { Ok(history) }
        };
        let history = read(&check.history)?;
        let others = check.minus.iter().map(|name| (-1.0, name)).chain(check.plus.iter().map(|name| (1.0, name)));
        let others = others.map(|(factor, name)| Ok((factor, read(name)?))).collect::<Result<Vec<_>>>()?;
        check.apply(&history, &others, check.tolerance_at(level), |file| table_beside(folder, file))
    };
    expected.checks.iter().map(apply).collect()
}

/// A history that the run didn't write, and those that it did.
fn no_history(check: &check::Check, name: &str, histories: &Path) -> Error {
    let files = std::fs::read_dir(histories).into_iter().flatten().flatten().map(|entry| entry.path());
    let tables = files.filter(|path| path.extension().is_some_and(|extension| extension == "csv"));
    let mut names: Vec<String> =
        tables.filter_map(|path| Some(path.file_stem()?.to_string_lossy().into_owned())).collect();
    names.sort_unstable();
    let finding = Diagnostic::error(format!("check `{}`", check.name), format!("there is no history `{name}`"));
    Error::case(finding.help(format!("the run wrote {}", names.join(", "))))
}

/// The references to draw in the plots of a run: one curve as points, several as their band, numbers that columns are
/// compared with as levels, and times at which they pass a level as points.
///
/// # Errors
/// A table that isn't there, or can't be read.
pub fn drawn(folder: &Folder, expected: &Expected) -> Result<Vec<ReferenceCurve>> {
    let read = |curve: &Curve| curve.read(|file| table_beside(folder, file));
    let reference = |history: &String, column: &String, curves: &[Curve], source: &String| {
        let curves = curves.iter().map(read).collect::<Result<Vec<Series>>>()?;
        let (history, column) = (history.clone(), column.clone());
        Ok(ReferenceCurve { history, plus: None, column, label: source.clone(), shape: shape(&curves), phase: None })
    };
    let compared = expected.checks.iter().filter_map(|check| match &check.reference {
        check::Reference::Curves(curves) => Some(reference(&check.history, &check.value, curves, &check.source)),
        check::Reference::Number(_) => None,
    });
    let only_drawn = expected.drawn.iter().map(|drawn| {
        let in_phase = |phase: &expected::DrawnPhase| -> Result<PhaseReference> {
            let signal = points(&read(&phase.reference)?);
            Ok(PhaseReference { history: phase.history.clone(), column: phase.value.clone(), signal })
        };
        let curve = reference(&drawn.history, &drawn.value, &drawn.reference, &drawn.source)?;
        Ok(ReferenceCurve { phase: drawn.phase.as_ref().map(in_phase).transpose()?, ..curve })
    });
    let numbers = levels(&expected.checks).into_iter().chain(passages(&expected.checks));
    compared.chain(only_drawn).chain(numbers.map(Ok)).collect()
}

/// The points at which columns are to pass a level.
fn passages(checks: &[check::Check]) -> impl Iterator<Item = ReferenceCurve> {
    checks.iter().filter_map(|check| {
        Some(ReferenceCurve {
            history: check.history.clone(),
            plus: check.plus.clone(),
            column: check.value.clone(),
            label: check.source.split(": ").next().unwrap_or_default().to_owned(),
            shape: CurveShape::Points(vec![check.passage()?]),
            phase: None,
        })
    })
}

/// The numbers that columns are compared with, by column and source: values, and the extremes of an oscillation about
/// its middle.
fn levels(checks: &[check::Check]) -> Vec<ReferenceCurve> {
    let mut all: Vec<ReferenceCurve> = Vec::new();
    for check in checks {
        let label = check.source.split(": ").next().unwrap_or_default();
        let x = [check.from, check.until];
        let own: Vec<HorizontalLine> = check.levels(checks).into_iter().map(|y| HorizontalLine { y, x }).collect();
        let same = |one: &&mut ReferenceCurve| {
            (&one.history, &one.plus, &one.column) == (&check.history, &check.plus, &check.value) && one.label == label
        };
        match all.iter_mut().find(same) {
            _ if own.is_empty() => {}
            Some(ReferenceCurve { shape: CurveShape::Levels(levels), .. }) => levels.extend(own),
            _ => all.push(ReferenceCurve {
                history: check.history.clone(),
                plus: check.plus.clone(),
                column: check.value.clone(),
                label: label.to_owned(),
                shape: CurveShape::Levels(own),
                phase: None,
            }),
        }
    }
    all
}

fn shape(curves: &[Series]) -> CurveShape {
    match curves {
        [one] => CurveShape::Points(points(one)),
        many => CurveShape::Band(series::band(many)),
    }
}

fn points(series: &Series) -> Vec<[f64; 2]> {
    series.x.iter().zip(&series.y).map(|(&x, &y)| [x, y]).collect()
}

fn table_beside(folder: &Folder, file: &str) -> Result<HistoryTable> {
    let text = folder.text(file)?.ok_or_else(|| Error::io(file, io::ErrorKind::NotFound.into()))?;
    let invalid = |error| Error::io(file, io::Error::new(io::ErrorKind::InvalidData, error));
    HistoryTable::parse(text.as_bytes()).map_err(invalid)
}
