//! Friction between bodies and membranes, by name (theory D.1).

use crate::mpm::Friction;

/// Friction by name: pairs that the case lists, and the default for the others.
#[derive(Debug, Clone)]
pub struct FrictionTable {
    /// Two names (bodies or membranes, in any order) and their friction.
    pub listed: Vec<(String, String, Friction)>,
    /// All other pairs.
    pub default: Friction,
}

impl FrictionTable {
    /// The friction that is listed with a part, by the name of the other.
    pub(super) fn listed_with(&self, name: &str) -> Vec<(String, Friction)> {
        let other = |(x, y, friction): &(String, String, Friction)| match () {
            () if x == name => Some((y.clone(), *friction)),
            () if y == name => Some((x.clone(), *friction)),
            () => None,
        };
        self.listed.iter().filter_map(other).collect()
    }

    /// The friction between parts with these names: the first that is listed, or the default.
    pub(in crate::mpm) fn between(&self, a: &[String], b: &[String]) -> Friction {
        let names = |x: &String, y: &String| (a.contains(x) && b.contains(y)) || (a.contains(y) && b.contains(x));
        self.listed.iter().find(|(x, y, _)| names(x, y)).map_or(self.default, |(_, _, friction)| *friction)
    }

    /// Pairs of fields with contact, and their friction; `names` has the bodies of each field.
    pub(super) fn pairs_in_contact(&self, names: &[Vec<String>]) -> Vec<([usize; 2], Friction)> {
        let mut pairs = Vec::new();
        for (b, second) in names.iter().enumerate() {
            for (a, first) in names[..b].iter().enumerate() {
                let law = self.between(first, second);
                // Between the parts of one body there is always a sheet.
                let parts = first.iter().any(|name| second.contains(name));
                if law != Friction::None && !parts {
                    pairs.push(([a, b], law));
                }
            }
        }
        pairs
    }
}
