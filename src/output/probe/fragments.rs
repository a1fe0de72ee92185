//! Number of connected pieces of a cloud of particles.

use hashbrown::HashMap;

/// Number of connected groups of occupied cells of size `cell` [m]; cells that share a corner touch.
pub(super) fn count_fragments(places: &[[f64; 3]], cell: f64) -> usize {
    let mut unseen: HashMap<[i64; 3], bool> =
        places.iter().map(|x| (x.map(|c| (c / cell).floor() as i64), true)).collect();
    let cells: Vec<[i64; 3]> = unseen.keys().copied().collect();
    let mut fragments = 0;
    for seed in cells {
        if std::mem::take(unseen.get_mut(&seed).expect("a key")) {
            fragments += 1;
            flood(seed, &mut unseen);
        }
    }
    fragments
}

/// Marks every cell that is connected with `seed` as seen.
fn flood(seed: [i64; 3], unseen: &mut HashMap<[i64; 3], bool>) {
    let mut front = vec![seed];
    while let Some(cell) = front.pop() {
        for n in 0..27 {
            let offset = [n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1];
            let neighbour = std::array::from_fn(|i| cell[i].saturating_add(offset[i]));
            if unseen.get_mut(&neighbour).is_some_and(std::mem::take) {
                front.push(neighbour);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn touching_cells_are_one_fragment() {
        let row = |from: i32, to: i32| (from..to).map(|i| [f64::from(i) + 0.5, -0.5, 0.0]);
        assert_eq!(count_fragments(&row(0, 9).collect::<Vec<_>>(), 1.0), 1);
        assert_eq!(count_fragments(&row(0, 4).chain(row(5, 9)).collect::<Vec<_>>(), 1.0), 2);
        assert_eq!(count_fragments(&row(0, 4).chain(row(5, 9)).collect::<Vec<_>>(), 2.0), 1);
        assert_eq!(count_fragments(&[[0.5, 0.5, 0.0], [1.5, 1.5, 0.0], [1.5, 3.5, 0.0]], 1.0), 2);
        assert_eq!(count_fragments(&[], 1.0), 0);
    }
}
