//! Equations of the fluid in elements that the surface of a solid cuts, coupled to the nodes of the solid (theory J.3).
