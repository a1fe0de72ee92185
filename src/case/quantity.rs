//! Numbers, quantities and formulas in a case: units to SI, dimensions, ranges.

use super::keywords::Schema;
use super::keywords::expected_dimension;
use super::tree::{PlacedValue, Value};
use super::walk::Walker;
use crate::math::formula::{Formula, FormulaError};
use crate::math::units::{Dimension, Quantity};

impl Walker<'_> {
    /// A number, or text with a number and its unit, in SI.
    pub(super) fn number(&mut self, node: &PlacedValue, schema: &Schema, key: &str) -> Option<f64> {
        let value = match &node.value {
            Value::Integer(n) => *n as f64,
            Value::Float(x) => *x,
            Value::String(text) => self.quantity(node, text, schema, key)?,
            _ => return self.wrong_kind(node, &self.expected_number(schema), key),
        };
        self.in_range(node, value, schema, key).then_some(value)
    }

    fn expected_number(&self, schema: &Schema) -> String {
        match expected_dimension(schema) {
            Some(dimension) if self.units => dimension.describe(),
            _ => "a number".to_owned(),
        }
    }

    fn quantity(&mut self, node: &PlacedValue, text: &str, schema: &Schema, key: &str) -> Option<f64> {
        let quantity = match Quantity::parse(text) {
            Ok(quantity) => quantity,
            Err(problem) => {
                let help = self.example_of(schema);
                self.note(node, key, problem, help);
                return None;
            }
        };
        self.dimension_fits(node, quantity.dimension, schema, key).then_some(quantity.value)
    }

    /// Compares what was written (`None`: no unit) with what the schema asks for.
    pub(super) fn dimension_fits(
        &mut self,
        node: &PlacedValue,
        found: Option<Dimension>,
        schema: &Schema,
        key: &str,
    ) -> bool {
        let Some(found) = found else { return true };
        let expected = expected_dimension(schema).unwrap_or(Dimension::NONE);
        if !self.units && !schema.contains_key("clock") {
            let help = "write a plain number, or drop `units = \"none\"`".to_owned();
            self.note(node, key, "this case has no units", Some(help));
        } else if found != expected {
            let message = format!("expected {}, found {}", expected.describe(), found.describe());
            let help = self.example_of(schema);
            self.note(node, key, message, help);
        } else {
            return true;
        }
        false
    }

    fn example_of(&self, schema: &Schema) -> Option<String> {
        let dimension = expected_dimension(schema).unwrap_or(Dimension::NONE);
        let example = if self.units { dimension.example() } else { Dimension::NONE.example() };
        Some(format!("write for example {example}"))
    }

    /// Checks the range of the schema (given in SI).
    pub(super) fn in_range(&mut self, node: &PlacedValue, value: f64, schema: &Schema, key: &str) -> bool {
        let unit = schema.get("unit").and_then(|u| u.as_str()).filter(|u| self.units && *u != "1").unwrap_or("");
        let bound = |keyword: &str| schema.get(keyword).and_then(serde_json::Value::as_f64);
        let violated = [
            ("minimum", bound("minimum").filter(|b| value < *b), "at least"),
            ("exclusiveMinimum", bound("exclusiveMinimum").filter(|b| value <= *b), "above"),
            ("maximum", bound("maximum").filter(|b| value > *b), "at most"),
            ("exclusiveMaximum", bound("exclusiveMaximum").filter(|b| value >= *b), "below"),
        ];
        let with_unit = |x: f64| format!("{x} {unit}").trim_end().to_owned();
        if value.is_nan() || (value.is_infinite() && !schema.contains_key("infinite")) {
            self.note(node, key, format!("{value} is not a usable number here"), None);
            return false;
        }
        for (_, bound, word) in violated {
            if let Some(bound) = bound {
                self.note(node, key, format!("must be {word} {}, found {}", with_unit(bound), with_unit(value)), None);
                return false;
            }
        }
        true
    }

    /// A number, a quantity, a formula, a table, or one of the schema's `words`.
    pub(super) fn signal(&mut self, node: &PlacedValue, schema: &Schema, key: &str) -> Option<toml::Value> {
        match &node.value {
            Value::Integer(_) | Value::Float(_) => self.number(node, schema, key).map(toml::Value::Float),
            Value::String(text) => self.signal_text(node, text, schema, key),
            Value::Table(_) => {
                let branches = schema.get("anyOf").and_then(serde_json::Value::as_array)?;
                let table =
                    branches.iter().filter_map(serde_json::Value::as_object).find(|b| !b.contains_key("type"))?;
                let table = self.walk(node, table, key)?;
                self.table_fits(node, &table, schema, key).then_some(table)
            }
            _ => self.wrong_kind(node, &format!("{} or a formula", self.expected_number(schema)), key),
        }
    }

    fn signal_text(&mut self, node: &PlacedValue, text: &str, schema: &Schema, key: &str) -> Option<toml::Value> {
        let words = schema.get("words").and_then(serde_json::Value::as_array);
        if words.is_some_and(|words| words.iter().any(|w| w.as_str() == Some(text))) {
            return Some(toml::Value::String(text.to_owned()));
        }
        if Quantity::parse(text).is_ok() {
            return self.number(node, schema, key).map(toml::Value::Float);
        }
        let checked = Formula::parse(text).and_then(|formula| {
            let dimension = formula.dimension()?;
            Ok((formula, dimension))
        });
        let (formula, dimension) = match checked {
            Ok(checked) => checked,
            Err(error) => return self.formula_error(node, text, error, key),
        };
        if formula.has_units() && !self.dimension_fits(node, dimension, schema, key) {
            return None;
        }
        match formula.constant() {
            Some(value) => self.in_range(node, value, schema, key).then_some(toml::Value::Float(value)),
            None => Some(toml::Value::String(text.to_owned())),
        }
    }

    /// Underlines the place inside the quotes, where the text stands in the file as it is read.
    fn formula_error(&mut self, node: &PlacedValue, text: &str, error: FormulaError, key: &str) -> Option<toml::Value> {
        self.note(node, key, error.message, None);
        let finding = self.findings.last_mut()?;
        if let Some(span) = finding.span.clone().filter(|s| s.len() == text.len() + 2) {
            let start = span.start + 1;
            finding.span = Some(start + error.span.start..start + error.span.end);
        }
        None
    }
}
