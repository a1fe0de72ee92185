//! Eight numbers at once, in the widest registers that the machine has.
//!
//! A grid node is one record of eight numbers, a cache line, and a transfer works on whole records: one
//! multiply–add per node and weight. The registers are chosen at run time, once per sweep.

/// A node's eight numbers, aligned to a cache line.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[repr(C, align(64))]
pub(crate) struct Record(pub [f64; 8]);

/// Eight numbers with the operations that the transfers need.
pub(crate) trait Lanes: Copy {
    /// All lanes equal.
    fn splat(value: f64) -> Self;
    /// From eight numbers in registers.
    fn set(values: [f64; 8]) -> Self;
    /// From memory.
    fn load(from: &Record) -> Self;
    /// To memory.
    fn store(self, to: &mut Record);
    /// self · factor + addend.
    fn mul_add(self, factor: Self, addend: Self) -> Self;
    /// Product.
    fn mul(self, factor: Self) -> Self;
    /// These lanes, but lane `LANE` from `other`.
    fn with_lane<const LANE: usize>(self, other: Self) -> Self;
}

/// Plain arrays, for machines without wide registers.
#[derive(Clone, Copy)]
pub(crate) struct Portable([f64; 8]);

impl Lanes for Portable {
    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self([value; 8])
    }
    #[inline(always)]
    fn set(values: [f64; 8]) -> Self {
        Self(values)
    }
    #[inline(always)]
    fn load(from: &Record) -> Self {
        Self(from.0)
    }
    #[inline(always)]
    fn store(self, to: &mut Record) {
        to.0 = self.0;
    }
    #[inline(always)]
    fn mul_add(self, factor: Self, addend: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] * factor.0[i] + addend.0[i]))
    }
    #[inline(always)]
    fn mul(self, factor: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] * factor.0[i]))
    }
    #[inline(always)]
    fn with_lane<const LANE: usize>(mut self, other: Self) -> Self {
        self.0[LANE] = other.0[LANE];
        self
    }
}

#[cfg(target_arch = "x86_64")]
pub(crate) use x86::{Avx2, Avx512};

#[cfg(target_arch = "x86_64")]
#[allow(unsafe_code)]
mod x86 {
    // SAFETY of every block below: these types are only used in functions compiled for the instructions in
    // question and entered after their run-time detection (`dispatch`); records are aligned to 64 bytes.
    use super::{Lanes, Record};
    use std::arch::x86_64::*;

    /// One 512-bit register.
    #[derive(Clone, Copy)]
    pub(crate) struct Avx512(__m512d);

    impl Lanes for Avx512 {
        #[inline(always)]
        fn splat(value: f64) -> Self {
            Self(unsafe { _mm512_set1_pd(value) })
        }
        #[inline(always)]
        fn set([a, b, c, d, e, f, g, h]: [f64; 8]) -> Self {
            Self(unsafe { _mm512_setr_pd(a, b, c, d, e, f, g, h) })
        }
        #[inline(always)]
        fn load(from: &Record) -> Self {
            Self(unsafe { _mm512_load_pd(from.0.as_ptr()) })
        }
        #[inline(always)]
        fn store(self, to: &mut Record) {
            unsafe { _mm512_store_pd(to.0.as_mut_ptr(), self.0) }
        }
        #[inline(always)]
        fn mul_add(self, factor: Self, addend: Self) -> Self {
            Self(unsafe { _mm512_fmadd_pd(self.0, factor.0, addend.0) })
        }
        #[inline(always)]
        fn mul(self, factor: Self) -> Self {
            Self(unsafe { _mm512_mul_pd(self.0, factor.0) })
        }
        #[inline(always)]
        fn with_lane<const LANE: usize>(self, other: Self) -> Self {
            Self(unsafe { _mm512_mask_blend_pd(1 << LANE, self.0, other.0) })
        }
    }

    /// Two 256-bit registers.
    #[derive(Clone, Copy)]
    pub(crate) struct Avx2(__m256d, __m256d);

    impl Lanes for Avx2 {
        #[inline(always)]
        fn splat(value: f64) -> Self {
            let v = unsafe { _mm256_set1_pd(value) };
            Self(v, v)
        }
        #[inline(always)]
        fn set([a, b, c, d, e, f, g, h]: [f64; 8]) -> Self {
            unsafe { Self(_mm256_setr_pd(a, b, c, d), _mm256_setr_pd(e, f, g, h)) }
        }
        #[inline(always)]
        fn load(from: &Record) -> Self {
            unsafe { Self(_mm256_load_pd(from.0.as_ptr()), _mm256_load_pd(from.0.as_ptr().add(4))) }
        }
        #[inline(always)]
        fn store(self, to: &mut Record) {
            unsafe {
                _mm256_store_pd(to.0.as_mut_ptr(), self.0);
                _mm256_store_pd(to.0.as_mut_ptr().add(4), self.1);
            }
        }
        #[inline(always)]
        fn mul_add(self, factor: Self, addend: Self) -> Self {
            unsafe { Self(_mm256_fmadd_pd(self.0, factor.0, addend.0), _mm256_fmadd_pd(self.1, factor.1, addend.1)) }
        }
        #[inline(always)]
        fn mul(self, factor: Self) -> Self {
            unsafe { Self(_mm256_mul_pd(self.0, factor.0), _mm256_mul_pd(self.1, factor.1)) }
        }
        #[inline(always)]
        fn with_lane<const LANE: usize>(self, other: Self) -> Self {
            const { assert!(LANE < 8) };
            // The lane is a constant: one of the branches remains.
            unsafe {
                match LANE {
                    0 => Self(_mm256_blend_pd::<1>(self.0, other.0), self.1),
                    1 => Self(_mm256_blend_pd::<2>(self.0, other.0), self.1),
                    2 => Self(_mm256_blend_pd::<4>(self.0, other.0), self.1),
                    3 => Self(_mm256_blend_pd::<8>(self.0, other.0), self.1),
                    4 => Self(self.0, _mm256_blend_pd::<1>(self.1, other.1)),
                    5 => Self(self.0, _mm256_blend_pd::<2>(self.1, other.1)),
                    6 => Self(self.0, _mm256_blend_pd::<4>(self.1, other.1)),
                    _ => Self(self.0, _mm256_blend_pd::<8>(self.1, other.1)),
                }
            }
        }
    }
}
