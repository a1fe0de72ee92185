//! Particles, membranes and meshes behind one view: positions and quantities.

use crate::simulation::{Field, PointSet, Snapshot, SurfaceSet};
use std::borrow::Cow;
use std::collections::HashMap;

/// A named set of a snapshot.
#[derive(Clone, Copy)]
pub(super) enum Set<'s> {
    /// Particles.
    Points(&'s PointSet<'s>),
    /// A membrane or mesh.
    Surface(&'s SurfaceSet<'s>),
}

/// The entities that the values of a quantity belong to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum On {
    /// Particles, or nodes of a surface.
    Entries,
    /// Elements of a surface.
    Elements,
}

/// A quantity of a set at one time.
pub(super) struct SetQuantity<'s> {
    pub unit: &'s str,
    pub components: usize,
    pub on: On,
    pub values: Cow<'s, [f64]>,
}

/// Initial positions of the particles of a set, by identity; empty for surfaces, which store theirs.
pub(super) type Start = HashMap<u32, [f64; 3]>;

impl<'s> Set<'s> {
    /// The set of that name.
    pub fn find(snapshot: &'s Snapshot<'s>, name: &str) -> Option<Self> {
        Self::all(snapshot).find(|set| set.name() == name)
    }

    /// All sets: particles first.
    pub fn all(snapshot: &'s Snapshot<'s>) -> impl Iterator<Item = Self> {
        let surfaces = snapshot.surfaces.iter().map(Self::Surface);
        snapshot.points.iter().map(Self::Points).chain(surfaces)
    }

    /// Its name.
    pub fn name(self) -> &'s str {
        match self {
            Self::Points(set) => set.name,
            Self::Surface(set) => set.name,
        }
    }

    /// Positions of particles or nodes [m].
    pub fn position(self) -> &'s [[f64; 3]] {
        match self {
            Self::Points(set) => &set.position,
            Self::Surface(set) => &set.position,
        }
    }

    /// Positions of entries or element centres [m].
    pub fn places(self, on: On) -> Cow<'s, [[f64; 3]]> {
        match (self, on) {
            (Self::Surface(set), On::Elements) => Cow::Owned(centres(&set.elements, &set.position)),
            (set, _) => Cow::Borrowed(set.position()),
        }
    }

    /// Positions of particles, by identity.
    pub fn start(self) -> Start {
        match self {
            Self::Points(set) => set.id.iter().copied().zip(set.position.iter().copied()).collect(),
            Self::Surface(_) => Start::new(),
        }
    }

    /// Everything that may be asked for.
    pub fn quantity_names(self) -> Vec<&'static str> {
        let mut names = vec!["position", "displacement"];
        names.extend(self.fields().map(|(field, _)| field.name));
        names
    }

    /// Why there is no quantity of this name, where that needs a reason.
    pub fn lacks(self, name: &str) -> Option<String> {
        let Self::Surface(set) = self else { return None };
        let reason = "only a membrane without free edges, whose elements all look to one side, encloses a volume";
        let membrane = set.element_fields.iter().any(|field| field.name == "thickness");
        (name == "volume" && membrane).then(|| reason.to_owned())
    }

    /// A field, `position`, or `displacement` (for particles from where they were at the start).
    pub fn quantity(self, name: &str, start: &Start) -> Option<SetQuantity<'s>> {
        if let Some((field, on)) = self.fields().find(|(field, _)| field.name == name) {
            return Some(SetQuantity { unit: field.unit, components: field.components, on, values: field.values() });
        }
        let values = match name {
            "position" => Cow::Borrowed(self.position().as_flattened()),
            "displacement" => Cow::Owned(self.displacement(start)),
            _ => return None,
        };
        Some(SetQuantity { unit: "m", components: 3, on: On::Entries, values })
    }

    fn displacement(self, start: &Start) -> Vec<f64> {
        let from = |now: &[f64; 3], then: &[f64; 3]| -> [f64; 3] { std::array::from_fn(|i| now[i] - then[i]) };
        let moved: Vec<[f64; 3]> = match self {
            Self::Surface(set) => {
                set.position.iter().zip(set.reference.iter()).map(|(now, then)| from(now, then)).collect()
            }
            Self::Points(set) => {
                let was = |id, now| start.get(id).unwrap_or(now);
                set.position.iter().zip(set.id.iter()).map(|(now, id)| from(now, was(id, now))).collect()
            }
        };
        moved.into_flattened()
    }

    fn fields(self) -> impl Iterator<Item = (&'s Field<'s>, On)> {
        let (entries, elements): (&[Field<'_>], &[Field<'_>]) = match self {
            Self::Points(set) => (&set.fields, &[]),
            Self::Surface(set) => (&set.node_fields, &set.element_fields),
        };
        entries.iter().map(|field| (field, On::Entries)).chain(elements.iter().map(|field| (field, On::Elements)))
    }
}

fn centres(elements: &[&[u32]], position: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let centre = |nodes: &&[u32]| {
        std::array::from_fn(|i| nodes.iter().map(|&n| position[n as usize][i]).sum::<f64>() / nodes.len() as f64)
    };
    elements.iter().map(centre).collect()
}

/// `; did you mean …?` with the nearest of the known names, and all of them.
pub(super) fn expected(name: &str, known: &[&str]) -> String {
    let near = known.iter().max_by(|a, b| strsim::jaro(name, a).total_cmp(&strsim::jaro(name, b)));
    let list = known.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
    match near {
        Some(near) if strsim::jaro(name, near) > 0.75 => format!("did you mean `{near}`? There are {list}"),
        Some(_) => format!("there are {list}"),
        None => "there are none".to_owned(),
    }
}
