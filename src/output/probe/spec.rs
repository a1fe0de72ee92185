//! The keys of `[[probe]]`.

use crate::error::Diagnostic;
use crate::output::component::Component;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A history of one quantity: at a place (`at`) or reduced over a whole set (`reduce`); or its impulse.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct ProbeSpec {
    /// Name of the history: `history/<name>.csv`.
    pub name: String,
    /// The observed part: the name of a body or membrane, or with PFEM-2 that of a body, `mesh` or
    /// `interface`.
    pub of: String,
    /// `position`, `displacement`, or a field such as `velocity` or `pressure`.
    #[serde(default = "position")]
    pub quantity: String,
    /// A place in the state at the start: follow the particle that is nearest to it, or the point of a membrane or mesh
    /// there, with fields of nodes interpolated in its element.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("unit" = "m"))]
    pub at: Option<Vec<f64>>,
    /// Reduce over all particles, nodes or elements.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reduce: Option<Reduction>,
    /// One component of the quantity; default: all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub component: Option<Component>,
    /// A scalar field of the same set to weight `mean`, `sum`, `mean-radius` and `center-of-mass` with, for example
    /// `mass`; default:
    /// the field `mass` for centres where there is one; else all count the same.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub weight: Option<String>,
    /// The direction of `top` and `bottom`, the axis of a radius; default: the last axis for `top` and
    /// `bottom`; a radius without axis is the distance from `center`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axis: Option<ProbeAxis>,
    /// The point that a radius is measured from; default: the origin.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("unit" = "m"))]
    pub center: Option<Vec<f64>>,
    /// Cell size of `count-fragments`: particles in cells that touch are one fragment.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("unit" = "m"))]
    pub cell: Option<f64>,
    /// Integrate over time between these two times, by every step: the impulse of a pressure or force, which doesn't
    /// depend on the height that a step gives to a peak.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("unit" = "s"))]
    pub impulse: Option<[f64; 2]>,
    /// Restriction to the part inside this box at the time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub within: Option<Within>,
    /// Time between samples; default: that of all histories.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("unit" = "s"))]
    pub every: Option<f64>,
}

fn position() -> String {
    "position".to_owned()
}

/// Reduction of several values to one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Reduction {
    /// Least value, per component.
    Min,
    /// Greatest value, per component.
    Max,
    /// Mean value, weighted by `weight`.
    Mean,
    /// Sum, weighted by `weight`.
    Sum,
    /// Mean position, weighted by `weight`, else by `mass` where there is one.
    CenterOfMass,
    /// Greatest coordinate along `axis`.
    Top,
    /// Least coordinate along `axis`.
    Bottom,
    /// Greatest distance from `axis` or `center`.
    MaxRadius,
    /// Mean distance from `axis` or `center`, weighted by `weight`.
    MeanRadius,
    /// Number of particles, nodes or elements.
    Count,
    /// Number of separate pieces, seen with cells of size `cell`.
    CountFragments,
}

impl Reduction {
    /// True for reductions of positions, which need no field.
    fn is_of_places(self) -> bool {
        !matches!(self, Self::Min | Self::Max | Self::Mean | Self::Sum)
    }
}

/// A coordinate axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[schemars(rename = "Coordinate")]
pub enum ProbeAxis {
    /// First.
    X,
    /// Second.
    Y,
    /// Third.
    Z,
}

impl ProbeAxis {
    /// 0, 1 or 2.
    pub fn index(self) -> usize {
        self as usize
    }
}

/// An axis-aligned box.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Within {
    /// Lower corner.
    #[schemars(extend("unit" = "m"))]
    pub lower: Vec<f64>,
    /// Upper corner.
    #[schemars(extend("unit" = "m"))]
    pub upper: Vec<f64>,
}

impl Within {
    /// True inside or on the boundary; the third axis is unbounded where a box of a plane doesn't give it.
    pub fn contains(&self, x: &[f64; 3]) -> bool {
        self.lower.iter().zip(x).all(|(lower, x)| lower <= x) && self.upper.iter().zip(x).all(|(upper, x)| x <= upper)
    }
}

impl ProbeSpec {
    /// The reduction, for a probe that follows no place.
    pub fn reduction(&self) -> Option<Reduction> {
        if self.at.is_some() { None } else { Some(self.reduce.unwrap_or(Reduction::Mean)) }
    }

    /// A key that is given and changes nothing.
    fn idle(&self) -> Option<&'static str> {
        use Reduction::{Bottom, CenterOfMass, CountFragments, MaxRadius, Mean, MeanRadius, Sum, Top};
        let reads = |those: &[Reduction]| self.reduction().is_some_and(|reduction| those.contains(&reduction));
        let keys = [
            ("within", self.within.is_some(), self.at.is_none()),
            ("weight", self.weight.is_some(), reads(&[Mean, Sum, CenterOfMass, MeanRadius])),
            ("axis", self.axis.is_some(), reads(&[Top, Bottom, MaxRadius, MeanRadius])),
            ("center", self.center.is_some(), reads(&[MaxRadius, MeanRadius])),
            ("cell", self.cell.is_some(), reads(&[CountFragments])),
        ];
        keys.into_iter().find(|(_, given, read)| *given && !read).map(|(key, ..)| key)
    }

    /// The lists of coordinates, by their keys.
    fn lengths(&self) -> impl Iterator<Item = (&'static str, usize)> {
        let within = self.within.as_ref();
        let lists = [
            ("at", self.at.as_ref()),
            ("center", self.center.as_ref()),
            ("within.lower", within.map(|within| &within.lower)),
            ("within.upper", within.map(|within| &within.upper)),
        ];
        lists.into_iter().filter_map(|(key, list)| Some((key, list?.len())))
    }

    /// Checks that need no model.
    ///
    /// # Errors
    /// Keys that contradict each other or need another one.
    pub(super) fn check(&self, key: &str, dimension: usize) -> Result<(), Diagnostic> {
        let wrong = |field: &str, message: &str, help: &str| wrong_key(key, field, message, help);
        if let Some((field, found)) = self.lengths().find(|(_, length)| !(dimension..=3).contains(length)) {
            let message = format!("{found} coordinates in {dimension}D");
            return wrong(field, &message, &format!("give {dimension}, one per axis"));
        }
        if self.impulse.is_some_and(|[from, to]| !(from >= 0.0 && to > from && to.is_finite())) {
            let help = "for example `impulse = [\"0.3 s\", \"0.5 s\"]`";
            return wrong("impulse", "the window ends before it begins, or begins before the start", help);
        }
        self.check_reduction(key)?;
        if let Some(Within { lower, upper }) = &self.within
            && lower.iter().zip(upper).any(|(lower, upper)| lower >= upper)
        {
            return wrong("within", "every entry of `lower` must be below that of `upper`", "nothing is in such a box");
        }
        if self.every.is_some_and(|every| every.is_nan() || every <= 0.0) {
            return wrong(
                "every",
                "the time between samples is not positive",
                "leave it out to sample as `output.history`",
            );
        }
        Ok(())
    }

    /// Checks the place or the reduction, and the keys that belong to it.
    ///
    /// # Errors
    /// As [`Self::check`].
    fn check_reduction(&self, key: &str) -> Result<(), Diagnostic> {
        let wrong = |field: &str, message: &str, help: &str| wrong_key(key, field, message, help);
        if self.at.is_some() == self.reduce.is_some() {
            return wrong("at", "a probe needs either `at` or `reduce`", "for example `reduce = \"mean\"`");
        }
        if self.reduce == Some(Reduction::CountFragments) && !self.cell.is_some_and(|cell| cell > 0.0) {
            return wrong("cell", "`count-fragments` needs a cell size", "about the cell size of the grid");
        }
        let reduction = self.reduction().filter(|reduction| reduction.is_of_places());
        if reduction.is_some() && (self.quantity != position() || self.component.is_some()) {
            let field = if self.component.is_some() { "component" } else { "quantity" };
            let message = "has no effect: this `reduce` looks at places alone";
            return wrong(field, message, "take it away, or reduce a quantity by `mean`, `sum`, `min` or `max`");
        }
        if let Some(field) = self.idle() {
            let (message, help) = match self.reduction() {
                None => ("has no effect: `at` follows one particle or point", "take it out, or reduce instead"),
                Some(_) => ("has no effect on this `reduce`", "take it out, or choose another `reduce`"),
            };
            return wrong(field, message, help);
        }
        Ok(())
    }
}

/// A key of a probe that can't be so.
fn wrong_key(key: &str, field: &str, message: &str, help: &str) -> Result<(), Diagnostic> {
    Err(Diagnostic::error(format!("{key}.{field}"), message).help(help))
}
