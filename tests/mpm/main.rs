//! The material point core against exact solutions, conservation laws and itself (threads, resumed runs).

mod books;
mod coupled;
mod exact;
mod model;
mod resume;
