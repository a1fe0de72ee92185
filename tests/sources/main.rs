//! The sources and the guide as text: citations, pages, and which part imports which.

mod citations;
mod guide;
mod layering;
mod rooms;
