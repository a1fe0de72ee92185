//! Variants of a case: the same case with other settings, compared with references of its own.
//!
//! ```toml
//! [[variant]]                   # a run of its own of `--full`
//! name = "density-0.1"
//! set = { "body.water.material.density" = 100.0 }    # beyond those of [full]
//!
//! [[variant.check]]             # as [[check]]
//! name = "half a swing"
//! ...
//! ```

use super::check::Check;
use serde::Deserialize;
use std::collections::BTreeMap;

/// A case with other settings than those of `--full`, with comparisons of its own.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Variant {
    /// Name of the variant; its run is that of the case with this behind it.
    pub name: String,
    /// Keys of the case to override, as `--set` does, beyond those of `[full]`.
    pub set: BTreeMap<String, toml::Value>,
    /// Comparisons; at least one.
    #[serde(default, rename = "check")]
    pub checks: Vec<Check>,
}
