//! The JSON Schema for editors, and the reference of all keys, both made from the structs of the case file.

use super::SCHEMA;
use super::keywords::Schema;
use super::keywords::kind;
use serde_json::{Value as Json, json};
use std::fmt::Write;

/// The JSON Schema of the case file, for editors that complete and check TOML.
pub fn schema() -> Json {
    let mut schema = Json::Object(SCHEMA.clone());
    relax(&mut schema);
    schema
}

/// Adds to the schema the values that the reader accepts beyond plain JSON types: quantities as text, two entries for
/// vectors in 2D.
fn relax(schema: &mut Json) {
    match schema {
        Json::Object(object) => {
            if object.contains_key("axes") {
                object.insert("minItems".into(), json!(2));
            }
            if object.contains_key("unit") {
                quantities(object);
            }
            object.values_mut().for_each(relax);
        }
        Json::Array(items) => items.iter_mut().for_each(relax),
        _ => {}
    }
}

/// Numbers with a unit may be text.
fn quantities(schema: &mut Schema) {
    let text = |kinds: &mut Json| match kinds {
        Json::String(kind) if kind == "number" => *kinds = json!(["number", "string"]),
        Json::Array(list) if list.iter().any(|k| k == "number") => list.push(json!("string")),
        _ => {}
    };
    schema.entry("type").and_modify(text);
    if let Some(Json::Object(items)) = schema.get_mut("items") {
        quantities(items);
    }
}

/// Sections of the reference: name in the schema, and heading. Others follow under their names.
const SECTIONS: &[(&str, &str)] = &[
    ("TimeSpec", "`[time]`"),
    ("GridSpec", "`[grid]`"),
    ("WallsSpec", "`[grid.walls]`"),
    ("WallSpec", "A wall"),
    ("MpmSpec", "`[mpm]`"),
    ("DomainMesh", "`[mesh]`"),
    ("Pfem2Spec", "`[pfem2]`"),
    ("SchemeSpec", "`pfem2.scheme`"),
    ("SchemeTable", "`pfem2.scheme = { kind = … }`"),
    ("SolverSpec", "`pfem2.solver`"),
    ("LinearSpec", "`[pfem2.solver]`"),
    ("BoundarySpec", "`[[boundary]]`"),
    ("TensionSpec", "`[[tension]]`"),
    ("BodySpec", "`[[body]]`"),
    ("Shape", "Regions: `region = { shape = … }`"),
    ("PointLaws", "Laws of material points: `material = { law = … }`"),
    ("ViscousLaws", "Laws of fluids on a mesh: `material = { law = … }`"),
    ("EquationsOfState", "Equations of state: `eos = { kind = … }`"),
    ("MembraneSpec", "`[[membrane]]`"),
    ("MembraneShape", "Meshes of membranes: `geometry = { shape = … }`"),
    ("SheetLaw", "Laws of membranes: `material = { law = … }`"),
    ("SupportSpec", "Supports of membranes and solids"),
    ("ObstacleSpec", "`[[obstacle]]`"),
    ("ContactSpec", "`[[contact]]`"),
    ("OutputSpec", "`[output]`"),
    ("ProbeSpec", "`[[probe]]`"),
    ("PictureSpec", "`[[picture]]`"),
];

/// All keys of the case file with their units, defaults and meaning, as Markdown.
pub fn laws() -> String {
    let mut page = String::from("# The case file\n");
    section(&mut page, "Top level", &SCHEMA);
    let empty = Schema::new();
    let definitions = SCHEMA.get("$defs").and_then(Json::as_object).unwrap_or(&empty);
    let listed = SECTIONS.iter().filter_map(|(name, title)| Some((*title, definitions.get(*name)?)));
    let others = definitions.iter().filter(|(name, _)| !SECTIONS.iter().any(|(listed, _)| listed == name));
    for (title, schema) in listed.chain(others.map(|(name, schema)| (name.as_str(), schema))) {
        if let Some(schema) = schema.as_object() {
            section(&mut page, title, schema);
        }
    }
    page
}

fn section(page: &mut String, title: &str, schema: &Schema) {
    let _ = write!(page, "\n## {title}\n\n");
    if let Some(text) = description(schema) {
        let _ = write!(page, "{text}\n\n");
    }
    keys(page, schema, None);
    let branches = ["oneOf", "anyOf"].iter().find_map(|k| schema.get(*k)?.as_array());
    for branch in branches.into_iter().flatten().filter_map(Json::as_object) {
        alternative(page, branch);
    }
}

/// One member of a choice: a name, a table that a name selects, or a plain value.
fn alternative(page: &mut String, branch: &Schema) {
    let text = description(branch).unwrap_or_default();
    let properties = branch.get("properties").and_then(Json::as_object);
    let tag = properties.and_then(|p| p.iter().find_map(|(key, s)| Some((key, s.get("const")?.as_str()?))));
    if let Some((tag, name)) = tag {
        let _ = write!(page, "### `{tag} = \"{name}\"`\n\n");
        if !text.is_empty() {
            let _ = write!(page, "{text}\n\n");
        }
        keys(page, branch, Some(tag));
        page.push('\n');
    } else {
        let _ = writeln!(page, "- {}{}{text}", value_kind(branch), if text.is_empty() { "" } else { ": " });
    }
}

fn keys(page: &mut String, schema: &Schema, tag: Option<&str>) {
    let required: Vec<&str> =
        schema.get("required").and_then(Json::as_array).into_iter().flatten().filter_map(Json::as_str).collect();
    for (key, value) in schema.get("properties").and_then(Json::as_object).into_iter().flatten() {
        let Some(value) = value.as_object().filter(|_| tag != Some(key)) else { continue };
        let default = match value.get("default").and_then(toml_text) {
            _ if required.contains(&key.as_str()) => ", required".to_owned(),
            Some(default) => format!(", default {default}"),
            None if value.contains_key("infinite") => ", default inf".to_owned(),
            None => String::new(),
        };
        let text = description(value).unwrap_or_default();
        let _ = writeln!(
            page,
            "- `{key}` ({}{default}){}{text}",
            value_kind(value),
            if text.is_empty() { "" } else { ": " }
        );
    }
}

/// A default as a case writes it; nothing for lists and for tables of tables, which the sections show.
fn toml_text(value: &Json) -> Option<String> {
    match value {
        Json::Null | Json::Array(_) => None,
        Json::Object(table) => {
            let entries = table.iter().map(|(key, value)| match value {
                Json::Object(_) => None,
                value => Some(format!("{key} = {}", toml_text(value)?)),
            });
            let entries = entries.collect::<Option<Vec<_>>>().filter(|entries| !entries.is_empty())?;
            Some(format!("{{ {} }}", entries.join(", ")))
        }
        value => Some(value.to_string()),
    }
}

fn description(schema: &Schema) -> Option<String> {
    Some(schema.get("description")?.as_str()?.replace('\n', " "))
}

/// The kind of a value with its unit: `list [m/s]`, `one of "left", "right"`.
fn value_kind(schema: &Schema) -> String {
    let unit = schema.get("unit").and_then(Json::as_str).filter(|u| *u != "1");
    let unit = unit.map(|u| format!(" [{u}]")).unwrap_or_default();
    let name = if let Some(name) = schema.get("const") {
        name.to_string()
    } else if let Some(names) = schema.get("enum").and_then(Json::as_array) {
        names.iter().map(Json::to_string).collect::<Vec<_>>().join(" | ")
    } else if let Some(reference) = schema.get("$ref").and_then(Json::as_str) {
        reference.rsplit('/').next().unwrap_or_default().to_owned()
    } else if let Some(branches) = ["oneOf", "anyOf"].iter().find_map(|k| schema.get(*k)?.as_array()) {
        let branches = branches.iter().filter_map(Json::as_object).filter(|b| kind(b) != "null");
        branches.map(value_kind).collect::<Vec<_>>().join(" or ")
    } else {
        match kind(schema) {
            "object" => "table".to_owned(),
            "array" => schema
                .get("items")
                .and_then(Json::as_object)
                .map_or("list".to_owned(), |items| format!("list of {}", value_kind(items))),
            "string" => "text".to_owned(),
            "integer" => "whole number".to_owned(),
            "boolean" => "true or false".to_owned(),
            other => other.to_owned(),
        }
    };
    format!("{name}{unit}")
}
