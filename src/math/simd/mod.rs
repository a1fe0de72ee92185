//! Vector instructions, chosen at run time: work is written once over [`Lanes`], eight numbers at a time, and compiled
//! for each kind of register that a machine may have.
//!
//! AVX-512 and AVX2 give the same bits, lane by lane; plain arrays round multiply–adds twice, so that they agree with
//! them within rounding. One machine always takes the same path.

mod dispatch;
mod lanes;
#[cfg(any(test, feature = "portable", not(target_arch = "x86_64")))]
mod portable;
#[cfg(test)]
mod tests;
#[cfg(target_arch = "x86_64")]
mod x86;

pub(crate) use dispatch::{Task, refusal, widest};
pub(crate) use lanes::{Lanes, Row, WIDTH};
