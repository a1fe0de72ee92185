//! The TOML of a case as a tree whose every key and value knows its place in the text.

use crate::error::Diagnostic;
use std::collections::BTreeMap;
use std::ops::Range;
use toml::de::{DeTable, DeValue};

/// Bytes of the case file; `None` for what `--set` put there.
pub(super) type Span = Option<Range<usize>>;

/// A value and its place.
#[derive(Debug, Clone)]
pub(super) struct PlacedValue {
    pub span: Span,
    pub value: Value,
}

#[derive(Debug, Clone)]
pub(super) enum Value {
    String(String),
    Integer(i64),
    Float(f64),
    Boolean(bool),
    Datetime(String),
    Array(Vec<PlacedValue>),
    Table(Vec<Entry>),
}

/// A key with its value.
#[derive(Debug, Clone)]
pub(super) struct Entry {
    pub key: String,
    pub key_span: Span,
    pub node: PlacedValue,
}

impl PlacedValue {
    /// Parses a document; its root is a table.
    pub(super) fn parse(text: &str) -> Result<Self, Vec<Diagnostic>> {
        // One slip makes a cascade of syntax errors: only the first is worth showing.
        let (root, errors) = DeTable::parse_recoverable(text);
        if let Some(first) = errors.iter().min_by_key(|e| e.span().map_or(usize::MAX, |s| s.start)) {
            return Err(vec![syntax_error(first, text)]);
        }
        let mut findings = Vec::new();
        let span = root.span();
        let node = Self { span: Some(span), value: Value::Table(entries(root.get_ref(), &mut findings)) };
        if findings.is_empty() { Ok(node) } else { Err(findings) }
    }

    /// Parses the right-hand side of `--set`: TOML if it is TOML, text otherwise.
    fn parse_value(text: &str) -> Self {
        let mut findings = Vec::new();
        let value = DeValue::parse(text).ok().map(|v| convert(v.get_ref(), &mut findings));
        let value = value.filter(|_| findings.is_empty()).unwrap_or_else(|| Value::String(text.to_owned()));
        let mut node = Self { span: None, value };
        node.forget_places();
        node
    }

    fn forget_places(&mut self) {
        self.span = None;
        match &mut self.value {
            Value::Array(items) => items.iter_mut().for_each(Self::forget_places),
            Value::Table(entries) => entries.iter_mut().for_each(|entry| {
                entry.key_span = None;
                entry.node.forget_places();
            }),
            _ => {}
        }
    }

    /// The value under `key` of a table.
    pub(super) fn get(&self, key: &str) -> Option<&Self> {
        match &self.value {
            Value::Table(entries) => entries.iter().find(|e| e.key == key).map(|e| &e.node),
            _ => None,
        }
    }

    /// The text of a string.
    pub(super) fn as_str(&self) -> Option<&str> {
        match &self.value {
            Value::String(text) => Some(text),
            _ => None,
        }
    }

    /// Its kind, for messages.
    pub(super) fn kind(&self) -> &'static str {
        match self.value {
            Value::String(_) => "text",
            Value::Integer(_) => "a whole number",
            Value::Float(_) => "a number",
            Value::Boolean(_) => "true or false",
            Value::Datetime(_) => "a date",
            Value::Array(_) => "a list",
            Value::Table(_) => "a table",
        }
    }

    /// Places of all keys: for `body[0].spacing` its value.
    pub(super) fn places(&self) -> BTreeMap<String, Range<usize>> {
        let mut places = BTreeMap::new();
        self.collect_places("", &mut places);
        places
    }

    fn collect_places(&self, key: &str, places: &mut BTreeMap<String, Range<usize>>) {
        if let Some(span) = &self.span {
            places.insert(key.to_owned(), span.clone());
        }
        match &self.value {
            Value::Array(items) => {
                for (i, item) in items.iter().enumerate() {
                    item.collect_places(&format!("{key}[{i}]"), places);
                }
            }
            Value::Table(entries) => entries.iter().for_each(|e| e.node.collect_places(&join(key, &e.key), places)),
            _ => {}
        }
    }

    /// Sets the value at a path such as `time.end`, `body[0].spacing` or `body.water.spacing`
    /// (an element of a list by its index, its `name`, or the part of the boundary that it is `on`). Returns the key,
    /// with elements by their index.
    pub(super) fn set(&mut self, path: &str, value: &str) -> Result<String, String> {
        let bracketless = path.replace('[', ".").replace(']', "");
        let (mut node, mut key) = (self, String::new());
        for step in bracketless.split('.').map(str::trim) {
            let known = node.members();
            let found = node.descend(step, &key);
            (node, key) = found.ok_or_else(|| format!("`--set {path}`: there is no `{step}` to set{known}"))?;
        }
        *node = Self::parse_value(value);
        Ok(key)
    }

    /// Names that an element of a list may have.
    fn names(&self) -> Vec<&str> {
        let name = self.get("name").and_then(Self::as_str);
        let on = self.get("on").into_iter().flat_map(|on| match &on.value {
            Value::Array(parts) => parts.iter().filter_map(Self::as_str).collect(),
            _ => on.as_str().into_iter().collect::<Vec<_>>(),
        });
        name.into_iter().chain(on).collect()
    }

    /// The elements of a list by number and name, for messages; empty for a node that is no list.
    fn members(&self) -> String {
        let Value::Array(items) = &self.value else { return String::new() };
        if items.is_empty() {
            return ": the list is empty".to_owned();
        }
        let names = items.iter().flat_map(Self::names).map(|name| format!(", `{name}`"));
        format!("; there are 0 to {}{}", items.len() - 1, names.collect::<String>())
    }

    /// The node and the key that `step` leads to from the node at `key`.
    fn descend(&mut self, step: &str, key: &str) -> Option<(&mut Self, String)> {
        match &mut self.value {
            Value::Array(items) => {
                let by_name = |n: &Self| n.names().contains(&step);
                let index = step.parse().ok().or_else(|| items.iter().position(by_name))?;
                Some((items.get_mut(index)?, format!("{key}[{index}]")))
            }
            Value::Table(_) if step.is_empty() => None,
            Value::Table(entries) => {
                let index = entries.iter().position(|e| e.key == step).unwrap_or_else(|| {
                    let node = Self { span: None, value: Value::Table(Vec::new()) };
                    entries.push(Entry { key: step.to_owned(), key_span: None, node });
                    entries.len() - 1
                });
                Some((&mut entries[index].node, join(key, step)))
            }
            _ => None,
        }
    }
}

/// `a.b` from `a` and `b`; `b` alone at the top.
pub(super) fn join(parent: &str, key: &str) -> String {
    if parent.is_empty() { key.to_owned() } else { format!("{parent}.{key}") }
}

fn syntax_error(error: &toml::de::Error, text: &str) -> Diagnostic {
    let message = error.message().trim();
    let message = if message.is_empty() { "this can't be read" } else { message };
    let end = text.len();
    let span = error.span().map_or(end..end, |s| s.start.min(end)..s.end.min(end));
    Diagnostic::error("", format!("not TOML: {message}")).at(span)
}

fn entries(table: &DeTable<'_>, findings: &mut Vec<Diagnostic>) -> Vec<Entry> {
    let entry = |(key, value): (&toml::Spanned<_>, &toml::Spanned<DeValue<'_>>)| {
        let key: &toml::Spanned<std::borrow::Cow<'_, str>> = key;
        Entry { key: key.get_ref().to_string(), key_span: Some(key.span()), node: spanned(value, findings) }
    };
    table.iter().map(entry).collect()
}

fn spanned(value: &toml::Spanned<DeValue<'_>>, findings: &mut Vec<Diagnostic>) -> PlacedValue {
    let before = findings.len();
    let node = PlacedValue { span: Some(value.span()), value: convert(value.get_ref(), findings) };
    for finding in &mut findings[before..] {
        finding.span.get_or_insert(value.span());
    }
    node
}

fn convert(value: &DeValue<'_>, findings: &mut Vec<Diagnostic>) -> Value {
    match value {
        DeValue::String(text) => Value::String(text.to_string()),
        DeValue::Integer(n) => i64::from_str_radix(n.as_str(), n.radix()).map(Value::Integer).unwrap_or_else(|_| {
            findings.push(Diagnostic::error("", "this whole number is too large"));
            Value::Integer(0)
        }),
        DeValue::Float(x) => x.as_str().parse().map(Value::Float).unwrap_or_else(|_| {
            findings.push(Diagnostic::error("", "this number can't be read"));
            Value::Float(0.0)
        }),
        DeValue::Boolean(b) => Value::Boolean(*b),
        DeValue::Datetime(d) => Value::Datetime(d.to_string()),
        DeValue::Array(items) => Value::Array(items.iter().map(|item| spanned(item, findings)).collect()),
        DeValue::Table(table) => Value::Table(entries(table, findings)),
    }
}
