//! A value in a case file that may vary: a number, a formula, or a table.

use crate::input;
use crate::math::{Signal, TimeTable};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::path::Path;

/// A value that may vary in space and time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum SignalSpec {
    /// A number [SI].
    Number(f64),
    /// A formula in `x y z t`.
    Formula(String),
    /// A table in time.
    Table(TableSpec),
}

/// Columns of a CSV file; the header may give units, as in `t [ms],p [kPa]`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct TableSpec {
    /// The CSV file, relative to the case file.
    pub table: String,
    /// Name of the column with the time; the first by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time: Option<String>,
    /// Name of the column with the value; the second by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub value: Option<String>,
}

impl Default for SignalSpec {
    fn default() -> Self {
        Self::Number(0.0)
    }
}

impl SignalSpec {
    /// The signal; `base` is the directory of the case file.
    ///
    /// # Errors
    /// A sentence about the formula or the table.
    pub fn build(&self, base: &Path) -> Result<Signal, String> {
        match self {
            Self::Number(value) => Ok(Signal::Constant(*value)),
            Self::Formula(source) => Signal::formula(source),
            Self::Table(spec) => {
                let path = base.join(&spec.table);
                let text = input::text(&path).map_err(|e| format!("{}: {e}", path.display()))?;
                let table = TimeTable::from_csv(&text, spec.time.as_deref(), spec.value.as_deref());
                Ok(Signal::Table(table.map_err(|e| format!("{}: {e}", path.display()))?.into()))
            }
        }
    }
}

impl JsonSchema for SignalSpec {
    fn schema_name() -> Cow<'static, str> {
        "Signal".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let table = generator.subschema_for::<TableSpec>();
        json_schema!({
            "description": "A number, a formula in x y z t, or a table { table = \"file.csv\" }.",
            "formula": true,
            "anyOf": [{ "type": "number" }, { "type": "string" }, table],
        })
    }
}

/// A prescribed motion of one axis: `"free"`, or a velocity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum AxisMotion {
    /// Not prescribed.
    Free(FreeWord),
    /// Prescribed velocity [m/s].
    Velocity(SignalSpec),
}

/// The word `free`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FreeWord {
    /// Not prescribed.
    Free,
}

impl Default for AxisMotion {
    fn default() -> Self {
        Self::Velocity(SignalSpec::default())
    }
}

impl JsonSchema for AxisMotion {
    fn schema_name() -> Cow<'static, str> {
        "AxisMotion".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let mut schema = SignalSpec::json_schema(generator);
        schema.insert("words".to_owned(), serde_json::json!(["free"]));
        schema.insert("description".to_owned(), "\"free\", or a velocity that may vary.".into());
        schema
    }
}
