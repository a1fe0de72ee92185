//! Names for files, columns and axes.

/// Units in the names of columns and axes: a dimensionless case has none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum UnitLabels {
    /// `time [s]`
    #[default]
    Shown,
    /// `time`
    Hidden,
}

impl UnitLabels {
    /// The head of a column: the name, and its unit in brackets where there is one.
    pub fn head(self, name: &str, unit: &str) -> String {
        match self.unit(unit) {
            "" => name.to_owned(),
            unit => format!("{name} [{unit}]"),
        }
    }

    /// The head of a column of a force: the name, and in brackets its unit, if there is one, and the part that it acts
    /// on.
    pub fn head_of(self, name: &str, unit: &str, on: &str) -> String {
        match self.unit(unit) {
            "" => format!("{name} [{on}]"),
            unit => format!("{name} [{unit} {on}]"),
        }
    }

    /// The unit, or nothing where units are hidden.
    pub fn unit(self, unit: &str) -> &str {
        match self {
            Self::Shown => unit,
            Self::Hidden => "",
        }
    }
}

/// A name that is safe as a file name: other than letters, digits, `-`, `_` and `.` become `-`.
pub fn file_name(name: &str) -> String {
    let safe = |c: char| if c.is_alphanumeric() || matches!(c, '-' | '_' | '.') { c } else { '-' };
    let name: String = name.chars().map(safe).collect();
    let name = name.trim_end_matches('-');
    if name.starts_with('.') || name.is_empty() { format!("_{name}") } else { name.to_owned() }
}

/// Suffixes of the components of a field: none for a scalar, axes for vectors and tensors, else numbers.
pub fn component_names(components: usize) -> Vec<String> {
    let names: &[&str] = match components {
        1 => &[""],
        2 => &["x", "y"],
        3 => &["x", "y", "z"],
        6 => &["xx", "yy", "zz", "xy", "yz", "zx"],
        _ => return (0..components).map(|c| c.to_string()).collect(),
    };
    names.iter().map(|name| (*name).to_owned()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heads_carry_units_unless_hidden_or_dimensionless() {
        assert_eq!(UnitLabels::Shown.head("time", "s"), "time [s]");
        assert_eq!(UnitLabels::Shown.head("crossed", ""), "crossed");
        assert_eq!(UnitLabels::Hidden.head("time", "s"), "time");
        assert_eq!(UnitLabels::Shown.head_of("fx", "N", "on floor"), "fx [N on floor]");
        assert_eq!(UnitLabels::Hidden.head_of("fx", "N", "on floor"), "fx [on floor]");
    }

    #[test]
    fn file_names_stay_in_their_directory() {
        assert_eq!(file_name("contact:water-sheet"), "contact-water-sheet");
        assert_eq!(file_name("../../etc/passwd"), "_..-..-etc-passwd");
        assert_eq!(file_name("support:sheet[0]"), "support-sheet-0");
        assert_eq!(file_name(""), "_");
    }
}
