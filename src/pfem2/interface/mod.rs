//! The interfaces between fluids: where they are, which elements they cut, and what happens there (theory G).
//!
//! ```text
//! tracking          fractions and level set at the nodes during a run                  theory G.2, G.11
//! level_set         φ at the nodes, negative in one of two fluids                    Becker (37), theory G.2–G.6
//! phase_list        the phases by role and density
//! phases            the fluid of a node, of an element, of a cut element's sides     theory G.1
//! volumes           the volume of each fluid, kept by shifts of φ or weights of shares  theory G.6
//! share_weights     these weights                                                    theory (G.8)
//! fluid_region      the part of the mesh that solids leave to the fluids             theory G.14
//! inflow            the fluid that open boundaries bring                             theory F.10, G.4
//! cut, enriched     cut elements: their content, and the enriched pressure           Becker (29)–(33), theory G.7, G.8
//! sub_simplices     the sides of a cut element as simplices                          theory G.7
//! surface_tension   forces of surface tension on the nodes                           theory G.10
//! outline, filled   interfaces as surfaces and fluids as volumes, for outputs
//! ```

mod cut;
mod enriched;
pub(super) mod filled;
mod fluid_region;
pub(super) mod inflow;
pub mod level_set;
pub mod outline;
pub mod phase_list;
pub mod phases;
mod share_weights;
mod sub_simplices;
pub mod surface_tension;
pub(super) mod tracking;
mod volumes;

pub use cut::{CutGeometry, Enrichment, Medium};
pub use enriched::{Enriched, ResidualTerms};
pub use fluid_region::FluidRegion;
pub use sub_simplices::{
    SubSimplex, at_corners, corners, facets, inner, is_cut, negative_side, share, sides, split, whole,
};
