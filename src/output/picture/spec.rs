//! The keys of `[[picture]]`.

use crate::error::Diagnostic;
use crate::math::Vector;
use crate::output::colour::ColourMap;
use crate::output::component::Component;
use crate::output::probe::Within;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Sine of an angle below which two directions are one.
const PARALLEL: f64 = 1e-9;

/// Pictures of particles and membranes over time: `pictures/<name>/000000.png`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct PictureSpec {
    /// Name of the directory of the pictures.
    pub name: String,
    /// Bodies and membranes in the picture; default: all.
    #[serde(default)]
    #[schemars(extend("minItems" = 1))]
    pub of: Vec<String>,
    /// The quantity that gives the colour; default: each body has another colour.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub field: Option<String>,
    /// The component of the quantity; default: its magnitude, or the value itself of a scalar.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub component: Option<Component>,
    /// Values at the ends of the colour bar, in SI units; default: from the values of each picture.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub range: Option<[f64; 2]>,
    /// Colour map of values; default: `blue-red` of `vorticity`, `viridis` of others. The middle of `blue-red` is
    /// zero, where no `range` is given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub map: Option<ColourMap>,
    /// Parts that keep their colour although they have the field.
    #[serde(default)]
    pub plain: Vec<String>,
    /// From where one looks: a direction from the model to the eye; default: from above in 2D.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub view: Option<[f64; 3]>,
    /// The direction that points up in the picture; default: y in 2D, z in 3D.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub up: Option<[f64; 3]>,
    /// The part of space that must fit into the picture.
    #[serde(default)]
    pub frame: FrameSpec,
    /// Hides one side of a plane.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cut: Option<CutSpec>,
    /// Width and height in pixels.
    #[serde(default = "size")]
    pub size: [u32; 2],
    /// Size of particles relative to their volume.
    #[serde(default = "one")]
    pub particle_size: f64,
    /// Opacity of membranes, above 0 (not seen) up to 1.
    #[serde(default = "one")]
    pub opacity: f64,
    /// Edges of membrane elements.
    #[serde(default)]
    pub mesh_lines: MeshLines,
    /// Time between pictures; default: that of the fields.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("unit" = "s"))]
    pub every: Option<f64>,
}

fn size() -> [u32; 2] {
    [1280, 960]
}

fn one() -> f64 {
    1.0
}

/// The part of space that must fit into the picture; the same over the whole run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum FrameSpec {
    /// A word.
    Word(FrameWord),
    /// A box.
    Box(Within),
}

impl Default for FrameSpec {
    fn default() -> Self {
        Self::Word(FrameWord::Domain)
    }
}

/// The part of space that must fit into the picture, by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FrameWord {
    /// The whole domain.
    Domain,
    /// The parts shown, at the start.
    Start,
}

/// Edges of membrane elements.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum MeshLines {
    /// Drawn where elements are large enough for them.
    #[default]
    Thin,
    /// Not drawn.
    None,
}

/// A plane; what lies on the side that its normal points to is hidden.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct CutSpec {
    /// A point of the plane; default: the origin.
    #[serde(default)]
    #[schemars(extend("unit" = "m", "axes" = true))]
    pub at: [f64; 3],
    /// The normal of the cutting plane, towards the hidden side.
    #[schemars(extend("axes" = true))]
    pub normal: [f64; 3],
}

impl CutSpec {
    /// True if the plane hides `x`.
    pub fn hides(&self, x: &[f64; 3]) -> bool {
        (0..3).map(|i| self.normal[i] * (x[i] - self.at[i])).sum::<f64>() > 0.0
    }
}

impl PictureSpec {
    /// A key that is given, other than by its default, and says how a field is shown where there is none.
    fn idle(&self) -> Option<&'static str> {
        let given = [
            ("component", self.component.is_some()),
            ("range", self.range.is_some()),
            ("map", self.map.is_some()),
            ("plain", !self.plain.is_empty()),
        ];
        given.into_iter().find(|(_, given)| *given && self.field.is_none()).map(|(key, _)| key)
    }

    /// The colour map in a model of this dimension: where none is given, one with a middle for a field that is as much
    /// below zero as above it.
    pub(super) fn map(&self, dimension: usize) -> ColourMap {
        let has_sign = dimension == 2 || self.component.is_some_and(|component| component != Component::Magnitude);
        let turns = has_sign && self.field.as_deref() == Some("vorticity");
        self.map.unwrap_or(if turns { ColourMap::BlueRed } else { ColourMap::Viridis })
    }

    /// Checks that need no model.
    ///
    /// # Errors
    /// Values that make no picture.
    pub(super) fn check(&self, key: &str) -> Result<(), Diagnostic> {
        let wrong = |field: &str, message: &str| Err(Diagnostic::error(format!("{key}.{field}"), message));
        if let Some(idle) = self.idle() {
            let finding = Diagnostic::error(format!("{key}.{idle}"), "has no effect on a picture without `field`");
            return Err(finding.help("add the `field` that gives the colours, or take it out"));
        }
        if !self.size.iter().all(|pixels| (64..=8192).contains(pixels)) {
            return wrong("size", "width and height must be between 64 and 8192 pixels");
        }
        if self.range.is_some_and(|[low, high]| !(low < high && low.is_finite() && high.is_finite())) {
            return wrong("range", "the first number must be below the second");
        }
        if let FrameSpec::Box(Within { lower, upper }) = &self.frame
            && lower.iter().zip(upper).any(|(lower, upper)| lower >= upper)
        {
            return wrong("frame", "every entry of `lower` must be below that of `upper`");
        }
        if !(self.particle_size > 0.0 && self.particle_size.is_finite()) {
            return wrong("particle-size", "the size of particles must be positive");
        }
        if !(self.opacity > 0.0 && self.opacity <= 1.0) {
            return wrong("opacity", "opacity must be above 0 and at most 1");
        }
        if [self.view, self.up].iter().flatten().any(|v| v.iter().all(|&c| c == 0.0)) {
            return wrong("view", "a direction can't be zero");
        }
        if self.cut.as_ref().is_some_and(|cut| cut.normal == [0.0; 3]) {
            return wrong("cut.normal", "a direction can't be zero");
        }
        if let (Some(view), Some(up)) = (self.view, self.up)
            && Vector(view).cross(Vector(up)).norm() <= PARALLEL * Vector(view).norm() * Vector(up).norm()
        {
            return wrong("up", "it points along `view`: nothing in the picture would");
        }
        if self.every.is_some_and(|every| every.is_nan() || every <= 0.0) {
            return wrong("every", "the time between pictures is not positive");
        }
        Ok(())
    }
}
