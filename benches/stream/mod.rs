//! Bandwidth of the memory of this machine: the triad a = b + s c over arrays far larger than a core's cache.

use std::hint::black_box;

/// Numbers per array: three times 64 MB.
const NUMBERS: usize = 8 << 20;

/// Bytes per processor second of one core, the best of a few sweeps. Counted as the triad is by custom: two reads and
/// one write of eight bytes, and the read that a write to memory begins with.
pub fn triad() -> f64 {
    let (mut a, b, c) = (vec![0.0f64; NUMBERS], vec![1.0f64; NUMBERS], vec![2.0f64; NUMBERS]);
    let mut best = 0.0f64;
    for _ in 0..6 {
        let start = super::processor_seconds();
        let mut sweeps = 0.0;
        // The clock of the processor ticks a hundred times a second.
        while super::processor_seconds() - start < 0.2 {
            let scale = black_box(3.0);
            a.iter_mut().zip(&b).zip(&c).for_each(|((a, b), c)| *a = b + scale * c);
            black_box(&mut a);
            sweeps += 1.0;
        }
        let seconds = super::processor_seconds() - start;
        best = best.max(sweeps * (NUMBERS * 32) as f64 / seconds);
    }
    best
}
