//! Prescribed nodes of solids and loads on their surfaces.
