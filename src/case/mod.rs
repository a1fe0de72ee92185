//! The case file: its keys, the checks of its values, and the solver that it describes.
//!
//! ```text
//! text → tree (TOML with places) → walk along the schema (all findings, quantities to SI)
//!      → preset → CaseFile → check (parts against each other) → build → solver
//! ```
//! Every finding carries its key and, where it stands in the file, its place.

mod check;
mod columns;
mod construct;
mod flow;
mod friction;
mod identity;
mod keywords;
mod membrane;
mod method;
mod mpm;
mod names;
mod obstacles;
mod parts;
mod preset;
mod quantity;
mod reference;
mod report;
mod resolution;
mod schema;
mod signal;
mod solid;
mod summary;
mod tree;
mod walk;
mod walls;

pub use construct::Model;
pub use flow::*;
pub use friction::{FrictionSpec, FrictionWord};
pub use membrane::*;
pub use mpm::*;
pub use names::is_case_name;
pub use parts::*;
pub use reference::{laws, schema};
pub use report::{line_and_column, render};
pub use schema::*;
pub use signal::{AxisMotion, FreeWord, SignalSpec, TableSpec};
pub use solid::{InertiaSpec, PlaneSpec, RigidMotionSpec, SolidCells, SolidDampingSpec, SolidMeshSpec, SurfaceSpec};
pub use summary::{BodySummary, CaseSummary, MembraneSummary, SolidSummary};
pub use walls::*;

use crate::error::{Diagnostic, Error, Result};
use crate::input;
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

/// The text of a case file and where it comes from.
///
/// ```
/// use lateen::Error;
/// use lateen::case::{Case, Source};
///
/// let text = "name = 'drop'\ndimension = 2\ntime = { ende = '1 s' }\n";
/// let source = Source::new("case.toml", "", text);
/// let Err(Error::Case(findings)) = Case::read(source.clone(), &[]) else { panic!("`ende` is no key") };
/// let shown = source.render(&findings, false);
/// assert!(shown.contains("did you mean `end`?") && shown.contains("case.toml"), "{shown}");
/// ```
#[derive(Debug, Clone)]
pub struct Source {
    /// Its name in messages: the path as the user gave it.
    pub name: String,
    /// The directory that paths in the case are relative to.
    pub base: PathBuf,
    /// The text.
    pub text: String,
}

/// The longest case file that is read [bytes].
const LONGEST_FILE: u64 = 16 << 20;

impl Source {
    /// Reads a file.
    ///
    /// # Errors
    /// The file can't be read, is too long for a case, or is not UTF-8.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let name = path.display().to_string();
        let Some(bytes) = input::read_up_to(path, LONGEST_FILE).map_err(|e| Error::io(path, e))? else {
            let message = format!("{name} is too long for a case: more than {LONGEST_FILE} bytes");
            return Err(Error::case(Diagnostic::error("", message)));
        };
        let text = String::from_utf8(bytes).map_err(|e| {
            let at = e.utf8_error().valid_up_to();
            Error::case(Diagnostic::error("", format!("{name} is not UTF-8 text (byte {at})")))
        })?;
        Ok(Self { name, base: path.parent().unwrap_or(Path::new("")).to_owned(), text })
    }

    /// A case held in memory; paths in it are relative to `base`.
    pub fn new(name: impl Into<String>, base: impl Into<PathBuf>, text: impl Into<String>) -> Self {
        Self { name: name.into(), base: base.into(), text: text.into() }
    }

    /// Shows findings with the text that they are about; `color` for terminals.
    pub fn render(&self, findings: &[Diagnostic], color: bool) -> String {
        render(findings, &self.name, &self.text, color)
    }
}

/// A case that has been read: right in itself, its parts not yet checked against each other.
#[derive(Debug, Clone)]
pub struct Case {
    /// Its contents, every default filled in, all numbers in SI.
    pub file: CaseFile,
    /// Its source.
    pub source: Source,
    places: BTreeMap<String, Range<usize>>,
    /// Keys that were set from outside.
    overridden: Vec<Override>,
}

/// A key that was set from outside.
#[derive(Debug, Clone)]
struct Override {
    /// The key's path.
    key: String,
    /// The option as the user wrote it.
    option: String,
}

impl Override {
    /// True if a key is the one that was set, or a part of its value.
    fn holds(&self, key: &str) -> bool {
        key.strip_prefix(&self.key).is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
    }
}

/// Reads the case at `path`; `overrides` are pairs such as `("body[0].spacing", "1 mm")`.
///
/// # Errors
/// Input/output errors, or everything that is wrong with the case.
pub fn load(path: impl AsRef<Path>, overrides: &[(String, String)]) -> Result<Case> {
    Case::read(Source::read(path)?, overrides)
}

impl Case {
    /// Reads a case; `overrides` are pairs such as `("body[0].spacing", "1 mm")`.
    ///
    /// # Errors
    /// Everything that is wrong with the case ([`Error::Case`]).
    pub fn read(source: Source, overrides: &[(String, String)]) -> Result<Self> {
        let mut tree = tree::PlacedValue::parse(&source.text).map_err(Error::Case)?;
        let mut overridden = Vec::new();
        for (path, value) in overrides {
            let key = tree.set(path, value).map_err(|message| Error::case(Diagnostic::error("", message)))?;
            overridden.push(Override { key, option: format!("--set {path}={value}") });
        }
        let places = tree.places();
        let mut findings = Vec::new();
        let file = read_tree(&tree, &source.base, &mut findings);
        match file {
            Some(file) if findings.is_empty() => Ok(Self { file, source, places, overridden }),
            _ => {
                locate(&places, &overridden, &mut findings);
                findings.sort_by_key(|f| f.span.as_ref().map_or(usize::MAX, |s| s.start));
                Err(Error::Case(findings))
            }
        }
    }

    /// The case with every default, in SI, as TOML.
    pub fn resolved_toml(&self) -> String {
        own_text(&self.file).unwrap_or_else(|error| format!("# {error}\n"))
    }

    /// Adds places to findings that only know their key.
    pub fn locate(&self, findings: &mut [Diagnostic]) {
        locate(&self.places, &self.overridden, findings);
    }

    /// True if the key was given, and not filled in.
    fn says(&self, key: &str) -> bool {
        self.places.contains_key(key) || self.overridden.iter().any(|set| set.key == key)
    }
}

/// Adds places to findings that only know their key: the option that set it, or the place of the key, or of the nearest
/// key above it.
fn locate(places: &BTreeMap<String, Range<usize>>, overridden: &[Override], findings: &mut [Diagnostic]) {
    let above = |key: &str| key.rfind(['.', '[']).unwrap_or(0);
    for finding in findings.iter_mut().filter(|f| f.span.is_none()) {
        if let Some(set) = overridden.iter().rev().find(|set| set.holds(&finding.key)) {
            if finding.key != set.key {
                finding.message = format!("`{}`: {}", finding.key, finding.message);
            }
            finding.key.clone_from(&set.option);
            continue;
        }
        let keys = std::iter::successors(Some(finding.key.as_str()), |key| Some(&key[..above(key)]));
        finding.span = keys.take_while(|key| !key.is_empty()).find_map(|key| places.get(key).cloned());
    }
}

/// The JSON Schema of the case file, with lateen's own keywords.
static SCHEMA: LazyLock<keywords::Schema> = LazyLock::new(|| {
    let schema = schemars::schema_for!(CaseFile);
    schema.as_object().cloned().unwrap_or_default()
});

/// The case as TOML, without the sections of other methods.
fn own_text(file: &CaseFile) -> Result<String, toml::ser::Error> {
    let mut table = toml::Table::try_from(file)?;
    method::keep_own(&mut table);
    toml::to_string(&table)
}

fn read_tree(tree: &tree::PlacedValue, base: &Path, findings: &mut Vec<Diagnostic>) -> Option<CaseFile> {
    let dimension = match tree.get("dimension").map(|n| &n.value) {
        Some(tree::Value::Integer(2)) => 2,
        _ => 3,
    };
    let units = tree.get("units").and_then(tree::PlacedValue::as_str) != Some("none");
    let mut walker = walk::Walker::new(&SCHEMA, dimension, units, base);
    let value = walker.walk(tree, &SCHEMA, "");
    findings.append(&mut walker.findings);
    method::check(tree, findings);
    let Some(toml::Value::Table(mut table)) = value else { return None };
    preset::apply(&mut table);
    match case_file(table) {
        Ok(mut file) => {
            file.output.complete(file.method, file.time);
            Some(file)
        }
        Err(finding) => {
            findings.push(finding);
            None
        }
    }
}

/// A case from its tables. The reader is behind a trait object, so that the sections are compiled for one kind of
/// reader instead of one per level.
fn case_file(table: toml::Table) -> Result<CaseFile, Diagnostic> {
    let mut track = serde_path_to_error::Track::new();
    let tracked = serde_path_to_error::Deserializer::new(toml::Value::Table(table), &mut track);
    let read = erased_serde::deserialize(&mut <dyn erased_serde::Deserializer>::erase(tracked));
    read.map_err(|error| {
        let key = track.path().to_string();
        Diagnostic::error(key.trim_matches('.'), error.to_string().trim_end())
    })
}
