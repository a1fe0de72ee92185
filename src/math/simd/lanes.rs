//! Eight numbers at once.

/// Numbers per [`Lanes`].
pub(crate) const WIDTH: usize = 8;

/// Eight numbers in memory, aligned to a cache line.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[repr(C, align(64))]
pub(crate) struct Row(pub [f64; WIDTH]);

/// Eight numbers with the operations that the hot loops need. All methods are inlined into functions compiled for
/// the registers in question.
pub(crate) trait Lanes: Copy {
    /// All lanes equal.
    fn splat(value: f64) -> Self;
    /// From memory.
    fn load(from: &[f64; WIDTH]) -> Self;
    /// Stores the lanes.
    fn store(self, to: &mut [f64; WIDTH]);
    /// Sum.
    fn add(self, other: Self) -> Self;
    /// Difference.
    fn sub(self, other: Self) -> Self;
    /// Product.
    fn mul(self, factor: Self) -> Self;
    /// Quotient.
    fn div(self, divisor: Self) -> Self;
    /// self · factor + addend.
    fn mul_add(self, factor: Self, addend: Self) -> Self;
    /// The larger one; `other` if one is not a number.
    fn max(self, other: Self) -> Self;
    /// The smaller one; `other` if one is not a number.
    fn min(self, other: Self) -> Self;
    /// The largest whole number that is not above.
    fn floor(self) -> Self;
    /// `yes` where self ≤ bound, `no` elsewhere.
    fn if_at_most(self, bound: Self, yes: Self, no: Self) -> Self;
    /// These lanes, but those whose bit is set in `mask` from `other`. The mask is a constant after inlining.
    fn blend(self, other: Self, mask: u8) -> Self;
    /// `a` in the first four lanes, `b` in the last four.
    fn pair(a: f64, b: f64) -> Self;
    /// The first four lanes of both, and the last four lanes of both.
    fn halves(self, other: Self) -> [Self; 2];
    /// Lane i of entry k becomes lane k of entry i.
    fn transpose(rows: [Self; WIDTH]) -> [Self; WIDTH];

    /// Component by component from eight vectors of `D` numbers, one after the other.
    #[inline(always)]
    fn unzip<const D: usize>(vectors: &[[f64; D]; WIDTH]) -> [Self; D] {
        let mut lanes = [Self::splat(0.0); D];
        for (axis, lane) in lanes.iter_mut().enumerate() {
            let mut row = [0.0; WIDTH];
            for k in 0..WIDTH {
                row[k] = vectors[k][axis];
            }
            *lane = Self::load(&row);
        }
        lanes
    }
}
