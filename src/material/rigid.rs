//! A solid that moves and turns without a strain (theory J.11).

use super::{MaterialKind, PointBatch, PointLaw, PointState, StartState, Storage};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Rigid solid, for `method = "pfem2"`: its density alone counts.
///
/// It has no stress, and so no material points:
///
/// ```
/// use lateen::material::{PointLaw, Rigid, StartState};
///
/// let steel = Rigid { density: 7850.0 };
/// assert!(steel.is_rigid() && steel.elastic_law().is_err());
/// assert!(steel.initial(&StartState::default()).unwrap_err().contains("pfem2"));
/// ```
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Rigid {
    /// Density ρ.
    #[schemars(extend("unit" = "kg/m^3", "exclusiveMinimum" = 0.0))]
    pub density: f64,
}

impl PointLaw for Rigid {
    fn density(&self) -> f64 {
        self.density
    }

    fn storage(&self) -> Storage {
        Storage::default()
    }

    fn initial(&self, _start: &StartState) -> Result<PointState, String> {
        Err("a rigid solid has no stress that material points could carry: it is for `method = \"pfem2\"`; here an obstacle is \
             rigid, and a stiff elastic law nearly so"
            .into())
    }

    fn needs_gradient(&self) -> bool {
        false
    }

    /// Nothing of it changes.
    fn update(&self, _batch: &mut PointBatch<'_>) {}

    fn reference_sound_speed(&self) -> f64 {
        0.0
    }

    fn phase(&self) -> MaterialKind {
        MaterialKind::Elastic
    }

    fn elastic_law(&self) -> Result<&dyn super::ElasticLaw, String> {
        Err("a rigid solid has no stiffness".into())
    }

    fn is_rigid(&self) -> bool {
        true
    }
}
