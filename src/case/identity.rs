//! A hash of the keys that results depend on: a checkpoint is resumed by the case that it was written for.

use super::tree::join;
use super::{Case, OutputSpec, own_text};
use crate::input;
use crate::output::fingerprint;
use std::path::Path;

/// Keys whose values are files.
const FILES: &[&str] = &["path", "file", "table"];

impl Case {
    /// A hash of the keys that results depend on: cases with one hash can go on from each other's checkpoints. The end
    /// of the run, texts and outputs don't count; the contents of the files that the case names do.
    pub fn hash(&self) -> String {
        let mut text = self.computed();
        if let Ok(value) = text.parse::<toml::Table>() {
            let mut contents = Vec::new();
            mix(&toml::Value::Table(value), &self.source.base, &mut contents);
            text.extend(contents);
        }
        fingerprint(text.as_bytes())
    }
}

impl Case {
    /// The keys that results depend on, as text.
    fn computed(&self) -> String {
        let mut file = self.file.clone();
        file.title.clear();
        file.description.clear();
        file.time.end = 0.0;
        file.output = OutputSpec::default();
        file.probe.clear();
        file.picture.clear();
        own_text(&file).unwrap_or_default()
    }

    /// Keys that results depend on and that have other values in a `resolved.toml`, with both values.
    pub fn differences(&self, resolved: &str) -> Vec<String> {
        let (Ok(now), Ok(mut before)) = (self.computed().parse::<toml::Table>(), resolved.parse::<toml::Table>())
        else {
            return Vec::new();
        };
        let mut now = now;
        for table in [&mut now, &mut before] {
            ["title", "description", "output", "probe", "picture"].iter().for_each(|key| drop(table.remove(*key)));
            table.get_mut("time").and_then(toml::Value::as_table_mut).map(|time| time.remove("end"));
        }
        let mut found = Vec::new();
        compare(Some(&toml::Value::Table(before)), Some(&toml::Value::Table(now)), "", &mut found);
        found
    }
}

/// Notes the keys at which two values differ.
fn compare(before: Option<&toml::Value>, now: Option<&toml::Value>, key: &str, found: &mut Vec<String>) {
    match (before, now) {
        (Some(toml::Value::Table(a)), Some(toml::Value::Table(b))) => {
            let added = b.keys().filter(|name| !a.contains_key(*name));
            for name in a.keys().chain(added) {
                compare(a.get(name), b.get(name), &join(key, name), found);
            }
        }
        (Some(toml::Value::Array(a)), Some(toml::Value::Array(b))) if a.len() == b.len() => {
            for (i, (a, b)) in a.iter().zip(b).enumerate() {
                compare(Some(a), Some(b), &format!("{key}[{i}]"), found);
            }
        }
        _ if before == now => {}
        _ => found.push(format!("`{key}` was {}, and is {}", shown(before), shown(now))),
    }
}

/// A value in a few words.
fn shown(value: Option<&toml::Value>) -> String {
    const LONGEST_VALUE: usize = 60;
    match value {
        None => "not there".to_owned(),
        Some(toml::Value::Array(values)) if values.iter().any(toml::Value::is_table) => {
            format!("a list of {}", values.len())
        }
        Some(toml::Value::Table(_)) => "a table".to_owned(),
        Some(value) => {
            let text = value.to_string();
            let cut = text.char_indices().nth(LONGEST_VALUE).map_or(text.len(), |(at, _)| at);
            if cut < text.len() { format!("{}…", &text[..cut]) } else { text }
        }
    }
}

/// Adds what identifies the files that a value names, in the order of its keys. A file that can't be read was found
/// before.
fn mix(value: &toml::Value, base: &Path, contents: &mut Vec<String>) {
    match value {
        toml::Value::Table(table) => table.iter().for_each(|(key, value)| match value {
            toml::Value::String(name) if FILES.contains(&key.as_str()) => {
                contents.extend(input::read(&base.join(name)).ok().map(|bytes| fingerprint(&bytes)));
            }
            _ => mix(value, base, contents),
        }),
        toml::Value::Array(values) => values.iter().for_each(|value| mix(value, base, contents)),
        _ => {}
    }
}
