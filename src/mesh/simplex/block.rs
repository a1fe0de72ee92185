//! Boxes of simplices: every cell of a grid is cut along the paths from its lowest to its highest corner,
//! one per order of the axes (Kuhn), so that neighbouring cells fit.

use super::Mesh;
use crate::math::Vector;

impl<const D: usize, const N: usize> Mesh<D, N> {
    /// A box between two corners [m] with `cells` cells along each axis: 2 triangles or 6 tetrahedra per cell.
    ///
    /// # Errors
    /// No extent, no cells, or more nodes than numbers of 32 bits can name.
    pub fn block(lower: Vector<D>, upper: Vector<D>, cells: [usize; D]) -> Result<Self, String> {
        if (0..D).any(|i| !(upper[i] - lower[i] > 0.0 && (upper[i] - lower[i]).is_finite())) {
            return Err("the upper corner must exceed the lower one along every axis".into());
        }
        let simplices = cells.iter().try_fold(6usize, |product, &c| product.checked_mul(c + 1));
        if cells.contains(&0) || simplices.is_none_or(|count| count > u32::MAX as usize) {
            return Err(format!("{cells:?} cells are none or too many"));
        }
        let nodes = grid(cells.map(|c| c + 1))
            .map(|index| Vector::from_fn(|i| lower[i] + (upper[i] - lower[i]) * (index[i] as f64 / cells[i] as f64)))
            .collect();
        let number = |index: [usize; D]| (0..D).rev().fold(0, |n, i| n * (cells[i] + 1) + index[i]) as u32;
        let elements = grid(cells).flat_map(|cell| {
            ORDERS.iter().filter(|(order, _)| order[D..].iter().all(|&axis| axis >= D)).map(move |(order, even)| {
                let mut corner = cell;
                let mut element = [number(corner); N];
                for (place, &axis) in order[..D].iter().enumerate() {
                    corner[axis] += 1;
                    element[place + 1] = number(corner);
                }
                if !even {
                    element.swap(N - 2, N - 1);
                }
                element
            })
        });
        Self::new(nodes, elements.collect())
    }
}

/// Orders of three axes, and whether they are even; in 2D those that end with z.
const ORDERS: [([usize; 3], bool); 6] = [
    ([0, 1, 2], true),
    ([1, 0, 2], false),
    ([0, 2, 1], false),
    ([1, 2, 0], true),
    ([2, 0, 1], true),
    ([2, 1, 0], false),
];

/// All indices below `shape`, the first axis fastest.
fn grid<const D: usize>(shape: [usize; D]) -> impl Iterator<Item = [usize; D]> {
    let count: usize = shape.iter().product();
    (0..count).map(move |mut n| {
        shape.map(|size| {
            let index = n % size;
            n /= size;
            index
        })
    })
}
