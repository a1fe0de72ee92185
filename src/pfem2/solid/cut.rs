//! The fixed mesh cut by the surfaces of solids (theory J.2).
