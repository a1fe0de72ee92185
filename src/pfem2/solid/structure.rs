//! The solids of a run: state, prediction, equations, energies (theory J.1).
