//! Every kind of registers against plain arithmetic.

use super::dispatch::each;
use super::{Lanes, Task, WIDTH};

const A: [f64; WIDTH] = [0.5, -1.25, 3.0, -0.0, 7.75, -8.5, 1e9, 2.0];
const B: [f64; WIDTH] = [-0.5, -1.5, 4.0, 0.0, 7.0, 8.5, -3.0, 2.0];

/// All operations on A and B, all of them exact in these numbers.
#[derive(Clone, Copy)]
struct AllLaneOperations;

impl Task for AllLaneOperations {
    type Output = Vec<[f64; WIDTH]>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let (a, b) = (L::load(&A), L::load(&B));
        let [first, last] = a.halves(b);
        let results = [
            first,
            last,
            L::pair(A[2], B[5]),
            L::splat(6.0).div(L::splat(4.0)),
            a.add(b),
            a.sub(b),
            a.mul(b),
            a.mul_add(b, a),
            a.max(b),
            a.min(b),
            a.floor(),
            a.blend(b, 0b1010_0110),
        ];
        let chosen = a.if_at_most(b, L::splat(1.0), L::splat(2.0));
        let mut rows = [a; WIDTH];
        for (k, row) in rows.iter_mut().enumerate() {
            *row = a.add(L::splat(k as f64));
        }
        let mut vectors = [[0.0; 3]; WIDTH];
        for k in 0..24 {
            vectors[k / 3][k % 3] = k as f64;
        }
        let all = results.into_iter().chain([chosen]).chain(L::transpose(rows)).chain(L::unzip(&vectors));
        let mut output = Vec::new();
        for lanes in all {
            let mut row = [0.0; WIDTH];
            lanes.store(&mut row);
            output.push(row);
        }
        output
    }
}

#[test]
fn every_kind_of_registers_computes_the_same() {
    let both = |f: &dyn Fn(f64, f64) -> f64| std::array::from_fn(|k| f(A[k], B[k]));
    let half = |from: [f64; WIDTH], k: usize| from[k % 4 + WIDTH / 2];
    let mut expected: Vec<[f64; WIDTH]> = vec![
        std::array::from_fn(|k| if k < 4 { A[k] } else { B[k - 4] }),
        std::array::from_fn(|k| if k < 4 { half(A, k) } else { half(B, k) }),
        std::array::from_fn(|k| if k < 4 { A[2] } else { B[5] }),
        [1.5; WIDTH],
        both(&|a, b| a + b),
        both(&|a, b| a - b),
        both(&|a, b| a * b),
        both(&|a, b| a * b + a),
        both(&f64::max),
        both(&f64::min),
        both(&|a, _| a.floor()),
        std::array::from_fn(|k| if [1, 2, 5, 7].contains(&k) { B[k] } else { A[k] }),
        both(&|a, b| if a <= b { 1.0 } else { 2.0 }),
    ];
    expected.extend((0..WIDTH).map(|k| std::array::from_fn(|i| A[k] + i as f64)));
    expected.extend((0..3).map(|axis| std::array::from_fn(|k| (3 * k + axis) as f64)));
    for output in each(AllLaneOperations) {
        assert_eq!(output, expected);
    }
}
