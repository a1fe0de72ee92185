//! The program from its command line.

mod cases;
mod guards;
mod home;
mod run;
