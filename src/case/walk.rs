//! One walk over the tree of a case along its JSON Schema. It finds everything that is wrong at once, each
//! with its place, and turns every quantity into a plain number in SI.
//!
//! Beside the standard keywords the schema carries:
//! `unit` (of a number, an array of numbers or a signal), `formula` (a number, or text with a formula),
//! `words` (texts that a signal may be besides), `axes` (a list with one entry per axis of the case, padded
//! with zeros to three), `infinite` (`inf` is allowed), `clock` (a time of the clock on the wall, which has
//! its unit even in a case without units) and `columns` (rows of two numbers, which may come from a CSV file).

use super::keywords::{
    Schema, alternatives, expected, expected_dimension, fits, inherit, item_schema, kind, list, properties, required,
    tag, tag_value, texts,
};
use super::tree::{Entry, PlacedValue, Value, join};
use crate::error::Diagnostic;
use serde_json::Value as Json;
use std::path::Path;

/// Walks a case along a schema.
pub(super) struct Walker<'a> {
    definitions: &'a Schema,
    /// 2 or 3: entries of a list with `axes`.
    dimension: usize,
    /// False for `units = "none"`.
    pub(super) units: bool,
    /// The directory that the case's files are relative to.
    pub(super) base: &'a Path,
    /// Everything that is wrong.
    pub(super) findings: Vec<Diagnostic>,
}

impl<'a> Walker<'a> {
    pub(super) fn new(root: &'a Schema, dimension: usize, units: bool, base: &'a Path) -> Self {
        static NONE: std::sync::LazyLock<Schema> = std::sync::LazyLock::new(Schema::new);
        let definitions = root.get("$defs").and_then(Json::as_object).unwrap_or(&NONE);
        Self { definitions, dimension, units, base, findings: Vec::new() }
    }

    /// Checks `node` against `schema`; `None` if something in it is wrong (and was noted).
    pub(super) fn walk(&mut self, node: &PlacedValue, schema: &Schema, key: &str) -> Option<toml::Value> {
        let schema = self.resolve(schema);
        if schema.contains_key("formula") {
            return self.signal(node, &schema, key);
        }
        if schema.contains_key("columns") {
            return self.columns(node, &schema, key);
        }
        if let Some(branches) = alternatives(&schema) {
            return self.walk_alternatives(node, &schema, branches, key);
        }
        if schema.contains_key("const") || schema.contains_key("enum") {
            return self.choice(node, &texts(&schema), key);
        }
        match kind(&schema) {
            "object" => self.walk_table(node, &schema, key),
            "array" => self.walk_array(node, &schema, key),
            "number" => self.number(node, &schema, key).map(toml::Value::Float),
            "integer" => self.integer(node, &schema, key).map(toml::Value::Integer),
            "boolean" => match node.value {
                Value::Boolean(value) => Some(toml::Value::Boolean(value)),
                _ => self.wrong_kind(node, "true or false", key),
            },
            "string" => match &node.value {
                Value::String(text) => Some(toml::Value::String(text.clone())),
                _ => self.wrong_kind(node, "text", key),
            },
            _ => Some(plain(node)),
        }
    }

    /// Follows `$ref`; keywords beside the reference win. Drops the alternative "null" (TOML has none).
    fn resolve(&self, schema: &Schema) -> Schema {
        let mut resolved = schema.clone();
        while let Some(Json::String(reference)) = resolved.remove("$ref") {
            let name = reference.rsplit('/').next().unwrap_or_default();
            let Some(target) = self.definitions.get(name).and_then(Json::as_object) else { break };
            for (keyword, value) in target {
                resolved.entry(keyword.clone()).or_insert_with(|| value.clone());
            }
        }
        for keyword in ["anyOf", "oneOf"] {
            let Some(Json::Array(branches)) = resolved.get_mut(keyword) else { continue };
            branches.retain(|b| b.get("type").and_then(Json::as_str) != Some("null"));
            if let [Json::Object(only)] = branches.as_slice() {
                let only = only.clone();
                resolved.remove(keyword);
                for (keyword, value) in only {
                    resolved.entry(keyword).or_insert(value);
                }
                return self.resolve(&resolved);
            }
        }
        resolved
    }

    fn walk_alternatives(
        &mut self,
        node: &PlacedValue,
        schema: &Schema,
        branches: &[Json],
        key: &str,
    ) -> Option<toml::Value> {
        let mut branches: Vec<Schema> = branches.iter().filter_map(Json::as_object).map(|b| self.resolve(b)).collect();
        inherit(schema, &mut branches);
        flatten(self, &mut branches);
        let fitting: Vec<&Schema> = branches.iter().filter(|b| fits(b, node)).collect();
        match &node.value {
            Value::String(_) => {
                let choices: Vec<String> = fitting.iter().flat_map(|b| texts(b)).collect();
                let open = fitting.iter().find(|b| texts(b).is_empty());
                match (open, choices.is_empty()) {
                    (Some(branch), _) => self.walk(node, branch, key),
                    (None, false) => self.choice(node, &choices, key),
                    (None, true) => self.wrong_kind(node, &expected(&branches), key),
                }
            }
            Value::Table(_) if fitting.len() > 1 => self.tagged(node, &fitting, key),
            _ => match fitting.first() {
                Some(branch) => self.walk(node, branch, key),
                None => self.wrong_kind(node, &expected(&branches), key),
            },
        }
    }

    /// Chooses the branch by the tag (`law = "fluid"`), or else by the keys that are there.
    fn tagged(&mut self, node: &PlacedValue, branches: &[&Schema], key: &str) -> Option<toml::Value> {
        let Some(tag) = branches.iter().find_map(|b| tag(b)) else {
            let hits = |b: &Schema| properties(b).map_or(0, |p| p.keys().filter(|k| node.get(k).is_some()).count());
            let best = branches.iter().enumerate().max_by_key(|(i, b)| (hits(b), std::cmp::Reverse(*i)));
            return best.and_then(|(_, b)| self.walk_table(node, b, key));
        };
        let names: Vec<String> = branches.iter().filter_map(|b| tag_value(b, &tag)).collect();
        let Some(given) = node.get(&tag) else {
            let message = format!("the key `{tag}` is missing");
            self.note(node, key, message, Some(format!("`{tag}` is one of {}", list(&names))));
            return None;
        };
        self.choice(given, &names, &join(key, &tag))?;
        let name = given.as_str()?;
        let branch = branches.iter().find(|b| tag_value(b, &tag).as_deref() == Some(name))?;
        self.walk_table(node, branch, key)
    }

    fn walk_table(&mut self, node: &PlacedValue, schema: &Schema, key: &str) -> Option<toml::Value> {
        let Value::Table(entries) = &node.value else {
            return self.wrong_kind(node, "a table", key);
        };
        let empty = Schema::new();
        let known = properties(schema).unwrap_or(&empty);
        let others = schema.get("additionalProperties").and_then(Json::as_object);
        let before = self.findings.len();
        let mut table = toml::Table::new();
        for entry in entries {
            let path = join(key, &entry.key);
            let Some(schema) = known.get(&entry.key).and_then(Json::as_object).or(others) else {
                self.unknown_key(entry, known, &path);
                continue;
            };
            if let Some(value) = self.walk(&entry.node, schema, &path) {
                table.insert(entry.key.clone(), value);
            }
        }
        // A misspelt key is reported where it stands, and not as missing besides.
        let meant: Vec<&str> =
            entries.iter().filter_map(|e| nearest(&e.key, known.keys().map(String::as_str))).collect();
        for missing in required(schema).filter(|name| !meant.contains(name)) {
            let hint = known.get(missing).and_then(Json::as_object).and_then(|s| self.example(missing, s));
            self.note(node, key, format!("the key `{missing}` is missing"), hint);
        }
        (self.findings.len() == before).then_some(toml::Value::Table(table))
    }

    fn walk_array(&mut self, node: &PlacedValue, schema: &Schema, key: &str) -> Option<toml::Value> {
        let Value::Array(items) = &node.value else {
            return self.wrong_kind(node, "a list", key);
        };
        let axes = schema.contains_key("axes");
        if !self.length_fits(node, items, schema, axes, key) {
            return None;
        }
        let before = self.findings.len();
        let mut values = Vec::with_capacity(items.len());
        for (i, item) in items.iter().enumerate() {
            let path = format!("{key}[{i}]");
            let mut each = vec![item_schema(schema, i)];
            inherit(schema, &mut each);
            values.extend(self.walk(item, &each[0], &path));
        }
        if axes && self.findings.len() == before {
            self.pad(node, &mut values, key);
        }
        (self.findings.len() == before).then_some(toml::Value::Array(values))
    }

    fn length_fits(
        &mut self,
        node: &PlacedValue,
        items: &[PlacedValue],
        schema: &Schema,
        axes: bool,
        key: &str,
    ) -> bool {
        let bound = |keyword: &str| schema.get(keyword).and_then(Json::as_u64).map(|n| n as usize);
        let (least, most) = (bound("minItems").unwrap_or(0), bound("maxItems").unwrap_or(usize::MAX));
        let (least, most) = if axes { (self.dimension, 3) } else { (least, most) };
        if (least..=most).contains(&items.len()) {
            return true;
        }
        let wanted = match (least, most) {
            _ if axes => format!("{} entries (one per axis)", self.dimension),
            (a, b) if a == b => format!("{a} entries"),
            (a, usize::MAX) => format!("at least {a} entries"),
            (a, b) => format!("{a} to {b} entries"),
        };
        self.note(node, key, format!("expected {wanted}, found {}", items.len()), None);
        false
    }

    /// Fills a list with one entry per axis up to three with zeros; what lies outside the plane must be zero.
    fn pad(&mut self, node: &PlacedValue, values: &mut Vec<toml::Value>, key: &str) {
        let outside = values.get(self.dimension..).unwrap_or_default();
        if outside.iter().any(|v| v.as_float() != Some(0.0)) {
            let message = format!("expected {} entries, found {}", self.dimension, values.len());
            self.note(node, key, message, Some("this case is two-dimensional".to_owned()));
        }
        values.resize(3, toml::Value::Float(0.0));
    }

    fn integer(&mut self, node: &PlacedValue, schema: &Schema, key: &str) -> Option<i64> {
        let value = match node.value {
            Value::Integer(value) => value,
            Value::Float(value) if value.fract() == 0.0 && value.abs() < 1e15 => value as i64,
            _ => return self.wrong_kind(node, "a whole number", key),
        };
        self.in_range(node, value as f64, schema, key).then_some(value)
    }

    /// One of some names.
    fn choice(&mut self, node: &PlacedValue, names: &[String], key: &str) -> Option<toml::Value> {
        let Some(text) = node.as_str() else {
            return self.wrong_kind(node, &format!("one of {}", list(names)), key);
        };
        if names.iter().any(|name| name == text) {
            return Some(toml::Value::String(text.to_owned()));
        }
        let meant = nearest(text, names.iter().map(String::as_str)).or_else(|| synonym(text, names));
        let help = meant.map(|name| format!("did you mean `{name}`?"));
        self.note(node, key, format!("unknown name `{text}`; expected one of {}", list(names)), help);
        None
    }

    fn unknown_key(&mut self, entry: &Entry, known: &Schema, key: &str) {
        let names = || known.keys().map(String::as_str);
        let help = match nearest(&entry.key, names()) {
            Some(name) => format!("did you mean `{name}`?"),
            None => format!("known keys are {}", names().collect::<Vec<_>>().join(", ")),
        };
        let mut finding = Diagnostic::error(key, format!("unknown key `{}`", entry.key)).help(help);
        finding.span.clone_from(&entry.key_span);
        self.findings.push(finding);
    }

    /// Notes that `node` is of the wrong kind; always `None`, for use in tail position.
    pub(super) fn wrong_kind<T>(&mut self, node: &PlacedValue, expected: &str, key: &str) -> Option<T> {
        self.note(node, key, format!("expected {expected}, found {}", node.kind()), None);
        None
    }

    pub(super) fn note(&mut self, node: &PlacedValue, key: &str, message: impl Into<String>, help: Option<String>) {
        let finding = Diagnostic { span: node.span.clone(), help, ..Diagnostic::error(key, message) };
        self.findings.push(finding);
    }

    /// An example for a key that is missing.
    fn example(&self, name: &str, schema: &Schema) -> Option<String> {
        let schema = self.resolve(schema);
        let dimension = expected_dimension(&schema)?;
        let example = if self.units { dimension.example() } else { "1.0".to_owned() };
        Some(match kind(&schema) {
            "array" => return None,
            _ => format!("write for example `{name} = {example}`"),
        })
    }
}

/// The known name nearest to a misspelt one, within a third of its length.
pub(super) fn nearest<'n>(text: &str, names: impl Iterator<Item = &'n str>) -> Option<&'n str> {
    let distance = |name: &str| strsim::damerau_levenshtein(&text.to_lowercase(), &name.to_lowercase());
    let close = |name: &&str| distance(name) <= (text.chars().count() / 3).max(1);
    names.filter(close).min_by_key(|name| distance(name))
}

/// Names of a case file, and others for the same.
const SYNONYMS: [(&str, &[&str]); 11] = [
    ("sphere", &["ball", "circle", "disc", "disk"]),
    ("box", &["block", "brick", "cube", "cuboid", "rectangle", "square"]),
    ("cylinder", &["pipe", "rod", "tube"]),
    ("polygon", &["triangle", "trapezoid", "wedge"]),
    ("surface", &["mesh", "obj", "stl"]),
    ("wall", &["fixed", "no-slip", "noslip", "no slip"]),
    ("slip", &["free-slip", "freeslip", "frictionless"]),
    ("inlet", &["inflow", "velocity"]),
    ("outlet", &["outflow", "open"]),
    ("newtonian", &["fluid", "liquid", "viscous"]),
    ("neo-hookean", &["elastic", "hyperelastic", "rubber"]),
];

/// The known name of what another name is for.
fn synonym<'n>(text: &str, names: &'n [String]) -> Option<&'n str> {
    let (meant, _) = SYNONYMS.iter().find(|(_, others)| others.contains(&text.to_lowercase().as_str()))?;
    names.iter().map(String::as_str).find(|name| name == meant)
}

/// Alternatives within alternatives become alternatives.
fn flatten(walker: &Walker<'_>, branches: &mut Vec<Schema>) {
    let mut flat = Vec::new();
    for branch in branches.drain(..) {
        match alternatives(&branch) {
            Some(inner) if !branch.contains_key("formula") => {
                let mut inner: Vec<Schema> =
                    inner.iter().filter_map(Json::as_object).map(|b| walker.resolve(b)).collect();
                inherit(&branch, &mut inner);
                flatten(walker, &mut inner);
                flat.extend(inner);
            }
            _ => flat.push(branch),
        }
    }
    *branches = flat;
}

/// The value as it stands, where the schema says nothing about it.
fn plain(node: &PlacedValue) -> toml::Value {
    match &node.value {
        Value::String(text) | Value::Datetime(text) => toml::Value::String(text.clone()),
        Value::Integer(n) => toml::Value::Integer(*n),
        Value::Float(x) => toml::Value::Float(*x),
        Value::Boolean(b) => toml::Value::Boolean(*b),
        Value::Array(items) => toml::Value::Array(items.iter().map(plain).collect()),
        Value::Table(entries) => toml::Value::Table(entries.iter().map(|e| (e.key.clone(), plain(&e.node))).collect()),
    }
}
