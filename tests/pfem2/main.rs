//! Flows on fixed meshes with known solutions.

mod channel;
mod filled;
