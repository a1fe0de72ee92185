//! What a case computes, as a short text: a checkpoint is resumed by the case that it was written for.

use super::{Case, OutputSpec, own_text};
use crate::output::fingerprint;
use std::path::Path;

/// Keys whose values are files.
const FILES: &[&str] = &["path", "file", "table"];

impl Case {
    /// Identifies what is computed: cases with one hash can go on from each other's checkpoints. The end
    /// of the run, texts and outputs don't count; the contents of the files that the case names do.
    pub fn hash(&self) -> String {
        let mut file = self.file.clone();
        file.title.clear();
        file.description.clear();
        file.time.end = 0.0;
        file.output = OutputSpec::default();
        file.probe.clear();
        file.picture.clear();
        let mut text = own_text(&file).unwrap_or_default();
        if let Ok(value) = text.parse::<toml::Table>() {
            let mut contents = Vec::new();
            mix(&toml::Value::Table(value), &self.source.base, &mut contents);
            text.extend(contents);
        }
        fingerprint(text.as_bytes())
    }
}

/// Adds what identifies the files that a value names, in the order of its keys. A file that can't be read was found before.
fn mix(value: &toml::Value, base: &Path, contents: &mut Vec<String>) {
    match value {
        toml::Value::Table(table) => table.iter().for_each(|(key, value)| match value {
            toml::Value::String(name) if FILES.contains(&key.as_str()) => {
                contents.extend(std::fs::read(base.join(name)).ok().map(|bytes| fingerprint(&bytes)));
            }
            _ => mix(value, base, contents),
        }),
        toml::Value::Array(values) => values.iter().for_each(|value| mix(value, base, contents)),
        _ => {}
    }
}
