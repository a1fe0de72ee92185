//! Linear algebra against systems with known solutions.

mod border;
mod solvers;
