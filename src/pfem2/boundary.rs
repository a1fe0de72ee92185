//! What happens at the boundary of the mesh.

/// What a boundary facet is to the flow and to the particles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum BoundaryKind {
    /// The fluid sticks to it; no particle crosses it.
    #[default]
    Wall,
    /// The fluid glides along it; no particle crosses it.
    Slip,
    /// The velocity is prescribed; particles come in.
    Inlet,
    /// Traction or pressure is prescribed; particles leave, and come in with the fluid of the place.
    Outlet,
}
