//! The registers of x86-64.
#![allow(unsafe_code)]

// SAFETY of every block below: these types are only used in functions compiled for the instructions in
// question and entered after their run-time detection (`dispatch`); loads and stores are of whole arrays and need no
// alignment.
use super::lanes::{Lanes, WIDTH};
use std::arch::x86_64::*;

/// One 512-bit register.
#[derive(Clone, Copy)]
pub(super) struct Avx512(__m512d);

/// Numbers of the three components among 24 consecutive ones: which of the first 16, then which of those and the
/// last 8.
const UNZIP_FIRST: [[i64; WIDTH]; 3] =
    [[0, 3, 6, 9, 12, 15, 0, 0], [1, 4, 7, 10, 13, 0, 0, 0], [2, 5, 8, 11, 14, 0, 0, 0]];
const UNZIP_LAST: [[i64; WIDTH]; 3] =
    [[0, 1, 2, 3, 4, 5, 10, 13], [0, 1, 2, 3, 4, 8, 11, 14], [0, 1, 2, 3, 4, 9, 12, 15]];

impl Avx512 {
    /// Entries of two registers by their numbers.
    #[inline(always)]
    fn pick(self, other: Self, numbers: &[i64; WIDTH]) -> Self {
        unsafe {
            let numbers = _mm512_loadu_si512(numbers.as_ptr().cast());
            Self(_mm512_permutex2var_pd(self.0, numbers, other.0))
        }
    }

    /// The even and the odd 128-bit parts of two registers.
    #[inline(always)]
    fn parts(a: __m512d, b: __m512d) -> (__m512d, __m512d) {
        unsafe { (_mm512_shuffle_f64x2::<0x88>(a, b), _mm512_shuffle_f64x2::<0xdd>(a, b)) }
    }
}

impl Lanes for Avx512 {
    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self(unsafe { _mm512_set1_pd(value) })
    }
    #[inline(always)]
    fn load(from: &[f64; WIDTH]) -> Self {
        Self(unsafe { _mm512_loadu_pd(from.as_ptr()) })
    }
    #[inline(always)]
    fn store(self, to: &mut [f64; WIDTH]) {
        unsafe { _mm512_storeu_pd(to.as_mut_ptr(), self.0) }
    }
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(unsafe { _mm512_add_pd(self.0, other.0) })
    }
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self(unsafe { _mm512_sub_pd(self.0, other.0) })
    }
    #[inline(always)]
    fn mul(self, factor: Self) -> Self {
        Self(unsafe { _mm512_mul_pd(self.0, factor.0) })
    }
    #[inline(always)]
    fn div(self, divisor: Self) -> Self {
        Self(unsafe { _mm512_div_pd(self.0, divisor.0) })
    }
    #[inline(always)]
    fn mul_add(self, factor: Self, addend: Self) -> Self {
        Self(unsafe { _mm512_fmadd_pd(self.0, factor.0, addend.0) })
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(unsafe { _mm512_max_pd(self.0, other.0) })
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(unsafe { _mm512_min_pd(self.0, other.0) })
    }
    #[inline(always)]
    fn floor(self) -> Self {
        Self(unsafe { _mm512_roundscale_pd::<{ _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC }>(self.0) })
    }
    #[inline(always)]
    fn if_at_most(self, bound: Self, yes: Self, no: Self) -> Self {
        unsafe {
            let holds = _mm512_cmp_pd_mask::<_CMP_LE_OQ>(self.0, bound.0);
            Self(_mm512_mask_blend_pd(holds, no.0, yes.0))
        }
    }
    #[inline(always)]
    fn blend(self, other: Self, mask: u8) -> Self {
        Self(unsafe { _mm512_mask_blend_pd(mask, self.0, other.0) })
    }
    #[inline(always)]
    fn pair(a: f64, b: f64) -> Self {
        Self(unsafe { _mm512_mask_blend_pd(0xf0, _mm512_set1_pd(a), _mm512_set1_pd(b)) })
    }
    #[inline(always)]
    fn halves(self, other: Self) -> [Self; 2] {
        unsafe {
            [Self(_mm512_shuffle_f64x2::<0x44>(self.0, other.0)), Self(_mm512_shuffle_f64x2::<0xee>(self.0, other.0))]
        }
    }
    #[inline(always)]
    fn transpose(r: [Self; WIDTH]) -> [Self; WIDTH] {
        unsafe {
            let even = |a: Self, b: Self| _mm512_unpacklo_pd(a.0, b.0);
            let odd = |a: Self, b: Self| _mm512_unpackhi_pd(a.0, b.0);
            let (a0, a1) = Self::parts(even(r[0], r[1]), even(r[2], r[3]));
            let (a2, a3) = Self::parts(even(r[4], r[5]), even(r[6], r[7]));
            let (b0, b1) = Self::parts(odd(r[0], r[1]), odd(r[2], r[3]));
            let (b2, b3) = Self::parts(odd(r[4], r[5]), odd(r[6], r[7]));
            let ((c0, c4), (c2, c6)) = (Self::parts(a0, a2), Self::parts(a1, a3));
            let ((c1, c5), (c3, c7)) = (Self::parts(b0, b2), Self::parts(b1, b3));
            [Self(c0), Self(c1), Self(c2), Self(c3), Self(c4), Self(c5), Self(c6), Self(c7)]
        }
    }
    #[inline(always)]
    fn unzip<const D: usize>(vectors: &[[f64; D]; WIDTH]) -> [Self; D] {
        let numbers = vectors.as_flattened();
        let at = |first: usize| Self(unsafe { _mm512_loadu_pd(numbers[first..][..WIDTH].as_ptr()) });
        let mut lanes = [Self::splat(0.0); D];
        if D == 3 {
            let (a, b, c) = (at(0), at(8), at(16));
            for axis in 0..D {
                lanes[axis] = a.pick(b, &UNZIP_FIRST[axis]).pick(c, &UNZIP_LAST[axis]);
            }
        } else {
            for (axis, lane) in lanes.iter_mut().enumerate() {
                let mut row = [0.0; WIDTH];
                for k in 0..WIDTH {
                    row[k] = vectors[k][axis];
                }
                *lane = Self::load(&row);
            }
        }
        lanes
    }
}

/// Two 256-bit registers.
#[derive(Clone, Copy)]
pub(super) struct Avx2(__m256d, __m256d);

impl Avx2 {
    /// A constant register that selects the lanes whose bit is set.
    #[inline(always)]
    fn selector(mask: u8) -> __m256d {
        let bit = |k: u8| -i64::from(mask >> k & 1);
        unsafe { _mm256_castsi256_pd(_mm256_set_epi64x(bit(3), bit(2), bit(1), bit(0))) }
    }

    #[inline(always)]
    fn transpose_quarter([a, b, c, d]: [__m256d; 4]) -> [__m256d; 4] {
        unsafe {
            let (ab_even, ab_odd) = (_mm256_unpacklo_pd(a, b), _mm256_unpackhi_pd(a, b));
            let (cd_even, cd_odd) = (_mm256_unpacklo_pd(c, d), _mm256_unpackhi_pd(c, d));
            [
                _mm256_permute2f128_pd::<0x20>(ab_even, cd_even),
                _mm256_permute2f128_pd::<0x20>(ab_odd, cd_odd),
                _mm256_permute2f128_pd::<0x31>(ab_even, cd_even),
                _mm256_permute2f128_pd::<0x31>(ab_odd, cd_odd),
            ]
        }
    }
}

impl Lanes for Avx2 {
    #[inline(always)]
    fn splat(value: f64) -> Self {
        let v = unsafe { _mm256_set1_pd(value) };
        Self(v, v)
    }
    #[inline(always)]
    fn load(from: &[f64; WIDTH]) -> Self {
        unsafe { Self(_mm256_loadu_pd(from.as_ptr()), _mm256_loadu_pd(from.as_ptr().add(4))) }
    }
    #[inline(always)]
    fn store(self, to: &mut [f64; WIDTH]) {
        unsafe {
            _mm256_storeu_pd(to.as_mut_ptr(), self.0);
            _mm256_storeu_pd(to.as_mut_ptr().add(4), self.1);
        }
    }
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        unsafe { Self(_mm256_add_pd(self.0, other.0), _mm256_add_pd(self.1, other.1)) }
    }
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        unsafe { Self(_mm256_sub_pd(self.0, other.0), _mm256_sub_pd(self.1, other.1)) }
    }
    #[inline(always)]
    fn mul(self, factor: Self) -> Self {
        unsafe { Self(_mm256_mul_pd(self.0, factor.0), _mm256_mul_pd(self.1, factor.1)) }
    }
    #[inline(always)]
    fn div(self, divisor: Self) -> Self {
        unsafe { Self(_mm256_div_pd(self.0, divisor.0), _mm256_div_pd(self.1, divisor.1)) }
    }
    #[inline(always)]
    fn mul_add(self, factor: Self, addend: Self) -> Self {
        unsafe { Self(_mm256_fmadd_pd(self.0, factor.0, addend.0), _mm256_fmadd_pd(self.1, factor.1, addend.1)) }
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        unsafe { Self(_mm256_max_pd(self.0, other.0), _mm256_max_pd(self.1, other.1)) }
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        unsafe { Self(_mm256_min_pd(self.0, other.0), _mm256_min_pd(self.1, other.1)) }
    }
    #[inline(always)]
    fn floor(self) -> Self {
        unsafe { Self(_mm256_floor_pd(self.0), _mm256_floor_pd(self.1)) }
    }
    #[inline(always)]
    fn if_at_most(self, bound: Self, yes: Self, no: Self) -> Self {
        unsafe {
            let first = _mm256_cmp_pd::<_CMP_LE_OQ>(self.0, bound.0);
            let second = _mm256_cmp_pd::<_CMP_LE_OQ>(self.1, bound.1);
            Self(_mm256_blendv_pd(no.0, yes.0, first), _mm256_blendv_pd(no.1, yes.1, second))
        }
    }
    #[inline(always)]
    fn blend(self, other: Self, mask: u8) -> Self {
        unsafe {
            Self(
                _mm256_blendv_pd(self.0, other.0, Self::selector(mask)),
                _mm256_blendv_pd(self.1, other.1, Self::selector(mask >> 4)),
            )
        }
    }
    #[inline(always)]
    fn pair(a: f64, b: f64) -> Self {
        unsafe { Self(_mm256_set1_pd(a), _mm256_set1_pd(b)) }
    }
    #[inline(always)]
    fn halves(self, other: Self) -> [Self; 2] {
        [Self(self.0, other.0), Self(self.1, other.1)]
    }
    #[inline(always)]
    fn transpose(r: [Self; WIDTH]) -> [Self; WIDTH] {
        let a = Self::transpose_quarter([r[0].0, r[1].0, r[2].0, r[3].0]);
        let b = Self::transpose_quarter([r[4].0, r[5].0, r[6].0, r[7].0]);
        let c = Self::transpose_quarter([r[0].1, r[1].1, r[2].1, r[3].1]);
        let d = Self::transpose_quarter([r[4].1, r[5].1, r[6].1, r[7].1]);
        let upper = |k: usize| Self(a[k], b[k]);
        let lower = |k: usize| Self(c[k], d[k]);
        [upper(0), upper(1), upper(2), upper(3), lower(0), lower(1), lower(2), lower(3)]
    }
}
