//! Lists of names: one line per law, element, boundary kind or output.
//!
//! The list makes the tagged enum that serde reads, the trait object that a solver calls, the names in
//! error messages, and the rows of `lateen laws`. Adding a member is one file and one line here.

/// Declares a registry: `Name: Trait, tag = "key" { "label" => Struct, ... }`.
///
/// The generated enum reads `{ key = "label", ...fields of Struct }`, and gives
/// `NAMES`, `name()`, `as_dyn()` and `into_box()`.
#[macro_export]
macro_rules! registry {
    ($(#[$meta:meta])* $vis:vis enum $Name:ident: $Trait:path, tag = $tag:literal {
        $( $label:literal => $Member:ident ),+ $(,)?
    }) => {
        $(#[$meta])*
        #[derive(Debug, Clone, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
        #[serde(tag = $tag)]
        // The reference of keys shows the description of the member itself.
        #[allow(missing_docs)]
        $vis enum $Name {
            $(
                #[serde(rename = $label)]
                $Member($Member)
            ),+
        }

        impl $Name {
            /// The names that a case may use.
            pub const NAMES: &'static [&'static str] = &[$($label),+];
            /// The key that holds the name.
            pub const TAG: &'static str = $tag;

            /// The name of this member, as a case writes it.
            pub fn name(&self) -> &'static str {
                match self { $( Self::$Member(_) => $label ),+ }
            }

            /// The member behind its trait.
            pub fn as_dyn(&self) -> &dyn $Trait {
                match self { $( Self::$Member(member) => member ),+ }
            }

            /// The member, boxed for a solver.
            pub fn into_box(self) -> Box<dyn $Trait> {
                match self { $( Self::$Member(member) => Box::new(member) ),+ }
            }
        }
    };
}
