//! The interfaces between fluids: the level set, the fractions of fluids, and what flows in (theory G.1 to
//! G.10).
//!
//! ```text
//! level_set         φ at the nodes, negative in one of two fluids                    Becker (37), theory G.2–G.6
//! fraction_weights  weights of the fractions, which keep the volume of each fluid    theory (G.8)
//! inflow            the fluid that open boundaries bring                             theory F.10, G.4
//! outline           interfaces as surfaces, for outputs and distances
//! ```

pub(super) mod fraction_weights;
pub(super) mod inflow;
pub mod level_set;
pub mod outline;
