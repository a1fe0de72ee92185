//! Chooses the registers at run time, once per task.
//!
//! Plain arrays serve other processors than x86-64, and with the feature `portable` those of x86-64 without AVX2. They
//! are a quarter of the code of all kernels there, for machines from before 2013: without the feature the program says
//! at the start that it can't compute on them.

use super::lanes::Lanes;
#[cfg(any(test, feature = "portable", not(target_arch = "x86_64")))]
use super::portable::Portable;

/// Why this build can't compute on this processor.
pub(crate) fn refusal() -> Option<&'static str> {
    #[cfg(all(target_arch = "x86_64", not(feature = "portable")))]
    if !(is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma")) {
        return Some(
            "this processor has no AVX2 and FMA: build lateen for it with `cargo build --release --features portable`",
        );
    }
    None
}

/// Work on a batch, written once for all registers. `run` and all that it calls must be
/// `#[inline(always)]`, so that it is compiled for the registers of the function that enters it.
pub(crate) trait Task {
    /// Its result.
    type Output;
    /// Does the work with lanes `L`.
    fn run<L: Lanes>(self) -> Self::Output;
}

/// Runs a task with the widest registers of this machine.
#[cfg(target_arch = "x86_64")]
#[allow(unsafe_code)]
pub(crate) fn widest<T: Task>(task: T) -> T::Output {
    use super::x86::{Avx2, Avx512};

    #[target_feature(enable = "avx512f,avx512vl,avx512dq,avx2,fma,bmi2")]
    fn on_avx512<T: Task>(task: T) -> T::Output {
        task.run::<Avx512>()
    }
    #[target_feature(enable = "avx2,fma")]
    fn on_avx2<T: Task>(task: T) -> T::Output {
        task.run::<Avx2>()
    }
    if is_x86_feature_detected!("avx512f")
        && is_x86_feature_detected!("avx512vl")
        && is_x86_feature_detected!("avx512dq")
    {
        // SAFETY: the features were detected (every AVX-512 machine has AVX2, FMA and BMI2).
        unsafe { on_avx512(task) }
    } else if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
        // SAFETY: the features were detected.
        unsafe { on_avx2(task) }
    } else {
        narrow(task)
    }
}

/// Runs a task without wide registers.
#[cfg(all(target_arch = "x86_64", feature = "portable"))]
fn narrow<T: Task>(task: T) -> T::Output {
    task.run::<Portable>()
}

/// This build can't: cases are refused before.
#[cfg(all(target_arch = "x86_64", not(feature = "portable")))]
fn narrow<T: Task>(_: T) -> T::Output {
    panic!("{}", refusal().unwrap_or("no wide registers"))
}

/// Runs a task with plain arrays.
#[cfg(not(target_arch = "x86_64"))]
pub(crate) fn widest<T: Task>(task: T) -> T::Output {
    task.run::<Portable>()
}

/// Runs a task with every kind of registers that this machine has, plain arrays first.
#[cfg(test)]
#[allow(unsafe_code)]
pub(crate) fn each<T: Task + Copy>(task: T) -> Vec<T::Output> {
    let mut outputs = vec![task.run::<Portable>()];
    #[cfg(target_arch = "x86_64")]
    {
        use super::x86::Avx2;
        #[target_feature(enable = "avx2,fma")]
        fn on_avx2<T: Task>(task: T) -> T::Output {
            task.run::<Avx2>()
        }
        if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
            // SAFETY: the features were detected.
            outputs.push(unsafe { on_avx2(task) });
        }
    }
    outputs.push(widest(task));
    outputs
}
