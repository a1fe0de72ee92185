//! The sources and the guide as text: citations, pages, what a checkpoint keeps, and which part imports which.

mod checkpoint;
mod citations;
mod guide;
mod layering;
mod rooms;
