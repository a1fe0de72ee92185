//! Readers of the keywords of a JSON Schema.

use super::tree::{PlacedValue, Value};
use crate::math::units::{Dimension, Unit};
use serde_json::{Map, Value as Json};

/// A JSON Schema: its keywords.
pub(super) type Schema = Map<String, Json>;

/// The dimension that a schema's `unit` asks for.
pub(super) fn expected_dimension(schema: &Schema) -> Option<Dimension> {
    let unit = schema.get("unit")?.as_str()?;
    Unit::parse(unit).ok().map(|u| u.dimension)
}

pub(super) fn alternatives(schema: &Schema) -> Option<&[Json]> {
    schema.get("oneOf").or_else(|| schema.get("anyOf"))?.as_array().map(Vec::as_slice)
}

/// Hands the keywords of a list or choice that concern its members on to them.
pub(super) fn inherit(parent: &Schema, children: &mut [Schema]) {
    for keyword in ["unit", "minimum", "maximum", "exclusiveMinimum", "exclusiveMaximum", "infinite"] {
        let Some(value) = parent.get(keyword) else { continue };
        for child in children.iter_mut() {
            child.entry(keyword).or_insert_with(|| value.clone());
        }
    }
}

pub(super) fn item_schema(schema: &Schema, i: usize) -> Schema {
    let prefix = schema.get("prefixItems").and_then(|items| items.get(i));
    prefix.or_else(|| schema.get("items")).and_then(Json::as_object).cloned().unwrap_or_default()
}

/// The JSON type, "null" aside.
pub(super) fn kind(schema: &Schema) -> &str {
    match schema.get("type") {
        Some(Json::String(kind)) => kind,
        Some(Json::Array(kinds)) => kinds.iter().filter_map(Json::as_str).find(|k| *k != "null").unwrap_or(""),
        _ if schema.contains_key("properties") => "object",
        _ => "",
    }
}

pub(super) fn properties(schema: &Schema) -> Option<&Schema> {
    schema.get("properties")?.as_object()
}

pub(super) fn required(schema: &Schema) -> impl Iterator<Item = &str> {
    schema.get("required").and_then(Json::as_array).into_iter().flatten().filter_map(Json::as_str)
}

/// The texts that a schema allows (`const`, `enum`).
pub(super) fn texts(schema: &Schema) -> Vec<String> {
    if let Some(Json::String(text)) = schema.get("const") {
        return vec![text.clone()];
    }
    let allowed = schema.get("enum").and_then(Json::as_array).into_iter().flatten();
    allowed.filter_map(Json::as_str).map(str::to_owned).collect()
}

/// The property whose constant value tells this branch from others.
pub(super) fn tag(schema: &Schema) -> Option<String> {
    let constant = |(_, s): &(&String, &Json)| s.get("const").is_some();
    properties(schema)?.iter().find(constant).map(|(name, _)| name.clone())
}

pub(super) fn tag_value(schema: &Schema, tag: &str) -> Option<String> {
    properties(schema)?.get(tag)?.get("const")?.as_str().map(str::to_owned)
}

/// True if a value of this kind can belong to the branch.
pub(super) fn fits(schema: &Schema, node: &PlacedValue) -> bool {
    if schema.contains_key("formula") {
        return !matches!(node.value, Value::Array(_) | Value::Boolean(_));
    }
    match (kind(schema), &node.value) {
        ("object", Value::Table(_)) | ("array", Value::Array(_)) | ("boolean", Value::Boolean(_)) => true,
        ("number" | "integer", Value::Integer(_) | Value::Float(_)) | ("string", Value::String(_)) => true,
        ("number", Value::String(_)) => schema.contains_key("unit"),
        _ => false,
    }
}

/// The kinds of values that the branches accept, for a message.
pub(super) fn expected(branches: &[Schema]) -> String {
    let mut parts: Vec<String> = Vec::new();
    let names: Vec<String> = branches.iter().flat_map(texts).collect();
    if !names.is_empty() {
        parts.push(format!("one of {}", list(&names)));
    }
    for branch in branches.iter().filter(|b| texts(b).is_empty()) {
        let part = match kind(branch) {
            "object" => "a table",
            "array" => "a list",
            "number" | "integer" => "a number",
            "boolean" => "true or false",
            "string" => "text",
            _ => "a number or formula",
        };
        if !parts.iter().any(|p| p == part) {
            parts.push(part.to_owned());
        }
    }
    parts.join(", or ")
}

pub(super) fn list(names: &[String]) -> String {
    names.iter().map(|n| format!("`{n}`")).collect::<Vec<_>>().join(", ")
}
