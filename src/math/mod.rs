//! Small vectors and tensors, and signals (values that vary in space and time).

pub mod formula;
mod signal;
mod tensor;
pub mod units;
mod vector;

pub use signal::{Signal, Table};
pub use tensor::{SymTensor, Tensor};
pub use vector::Vector;
