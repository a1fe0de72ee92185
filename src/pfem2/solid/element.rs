//! Internal forces and tangent of an element of a solid (theory J.1).
