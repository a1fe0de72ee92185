//! Small vectors and tensors, and signals (values that vary in space and time).

pub(crate) mod dense;
mod dimension;
pub mod formula;
mod root;
mod signal;
pub(crate) mod simd;
mod spectral;
mod table;
mod tensor;
pub mod units;
mod vector;

pub use root::nearest_root;
pub use signal::Signal;
pub use spectral::Spectrum;
pub use table::{CsvColumns, TimeTable, are_heads, separator};
pub use tensor::{SymTensor, Tensor};
pub use vector::Vector;
