//! Values of a case that stand in a CSV file: curves (`columns` in the schema) and signals over time.

use super::keywords::Schema;
use super::keywords::expected_dimension;
use super::tree::{PlacedValue, Value};
use super::walk::Walker;
use crate::input;
use crate::math::CsvColumns;
use crate::math::units::Dimension;
use serde_json::Value as Json;

impl Walker<'_> {
    /// A curve: one value, rows of two numbers, or `{ table = "file.csv" }`. It becomes rows in SI, so that a
    /// resolved case holds its numbers.
    pub(super) fn columns(&mut self, node: &PlacedValue, schema: &Schema, key: &str) -> Option<toml::Value> {
        let branches = schema.get("anyOf").and_then(Json::as_array)?.iter().filter_map(Json::as_object);
        let branch = |kind: &str| branches.clone().find(|b| b.get("type").and_then(Json::as_str) == Some(kind));
        match &node.value {
            Value::Integer(_) | Value::Float(_) | Value::String(_) => {
                self.number(node, schema, key).map(|value| rows(&[[0.0, value]]))
            }
            Value::Array(_) => self.walk(node, branch("array")?, key),
            Value::Table(_) => {
                let table = self.walk(node, branch("object")?, key)?;
                let columns = self.csv(node, &table, [None, None], key)?;
                let wanted = [Some(Dimension::NONE), expected_dimension(schema)];
                let fit = columns.dimensions.iter().zip(wanted).enumerate().all(|(n, (found, wanted))| {
                    self.column_fits(node, n, *found, wanted.unwrap_or(Dimension::NONE), key)
                });
                fit.then(|| rows(&columns.rows))
            }
            _ => self.wrong_kind(node, "a number, rows of numbers, or { table = \"file.csv\" }", key),
        }
    }

    /// Checks the units in the header of a signal's table.
    pub(super) fn table_fits(&mut self, node: &PlacedValue, table: &toml::Value, schema: &Schema, key: &str) -> bool {
        let name = |key: &str| table.get(key).and_then(toml::Value::as_str);
        let Some(columns) = self.csv(node, table, [name("time"), name("value")], key) else { return false };
        let wanted = [Dimension::TIME, expected_dimension(schema).unwrap_or(Dimension::NONE)];
        let [time, value] = columns.dimensions;
        self.column_fits(node, 0, time, wanted[0], key) && self.column_fits(node, 1, value, wanted[1], key)
    }

    fn csv(
        &mut self,
        node: &PlacedValue,
        table: &toml::Value,
        names: [Option<&str>; 2],
        key: &str,
    ) -> Option<CsvColumns> {
        let path = self.base.join(table.get("table").and_then(toml::Value::as_str).unwrap_or_default());
        let text = input::text(&path).map_err(|error| error.to_string());
        match text.and_then(|text| CsvColumns::read(&text, names)) {
            Ok(columns) => Some(columns),
            Err(why) => {
                self.note(node, key, format!("{}: {why}", path.display()), None);
                None
            }
        }
    }

    fn column_fits(
        &mut self,
        node: &PlacedValue,
        column: usize,
        found: Option<Dimension>,
        wanted: Dimension,
        key: &str,
    ) -> bool {
        let Some(found) = found.filter(|found| *found != wanted) else { return true };
        let (found, wanted) = (found.describe(), wanted.describe());
        let message = format!("column {} of the table: expected {wanted}, found {found}", column + 1);
        self.note(node, key, message, Some("correct the unit in the table's first row".to_owned()));
        false
    }
}

fn rows(rows: &[[f64; 2]]) -> toml::Value {
    let row = |row: &[f64; 2]| toml::Value::Array(row.iter().map(|&number| toml::Value::Float(number)).collect());
    toml::Value::Array(rows.iter().map(row).collect())
}
