//! The material point core against exact solutions, conservation laws and itself (threads, resumed runs).

mod books;
mod exact;
mod model;
mod resume;
