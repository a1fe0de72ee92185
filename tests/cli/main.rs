//! The program from its command line.

mod cases;
mod guards;
mod run;
