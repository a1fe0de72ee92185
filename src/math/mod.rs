//! Small vectors and tensors, and signals (values that vary in space and time).

mod signal;
mod tensor;
mod vector;

pub use signal::Signal;
pub use tensor::{SymTensor, Tensor};
pub use vector::Vector;
