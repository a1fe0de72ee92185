//! Boxes of simplices: every cell of a grid is cut along the paths from one of its corners to the opposite
//! one, one per order of the axes (Kuhn), so that neighbouring cells fit.

use super::{Facet, Mesh};
use crate::math::Vector;

/// Diagonals along which the cells of a lattice are cut.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CellCut {
    /// All alike, from the lowest corner to the highest.
    Parallel,
    /// Mirrored from cell to cell, so that no direction is preferred and a lattice with an even number of
    /// cells is its own mirror image (union jack).
    Mirrored,
}

impl<const D: usize, const N: usize> Mesh<D, N> {
    /// A box between two corners [m] with `cells` cells along each axis: 2 triangles or 6 tetrahedra per cell,
    /// all cut alike.
    ///
    /// # Errors
    /// No extent, no cells, or more nodes than numbers of 32 bits can name.
    ///
    /// ```
    /// use lateen::math::Vector;
    /// use lateen::mesh::{Locator, Mesh};
    ///
    /// let mesh = Mesh::<2, 3>::block(Vector([0.0, 0.0]), Vector([2.0, 1.0]), [4, 2])?;
    /// assert_eq!((mesh.nodes().len(), mesh.elements().len(), mesh.volume()), (15, 16, 2.0));
    /// let x = Vector([1.3, 0.4]);
    /// let element = Locator::new(&mesh).locate(&mesh, x, 0).element().unwrap();
    /// let shape = mesh.shape_functions(element, x);
    /// assert!(shape.iter().all(|&n| n >= 0.0) && (shape.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    /// # Ok::<(), String>(())
    /// ```
    pub fn block(lower: Vector<D>, upper: Vector<D>, cells: [usize; D]) -> Result<Self, String> {
        if (0..D).any(|i| !(upper[i] - lower[i] > 0.0 && (upper[i] - lower[i]).is_finite())) {
            return Err("the upper corner must exceed the lower one along every axis".into());
        }
        check_count(cells)?;
        let line = |i: usize| -> Vec<f64> {
            (0..=cells[i]).map(|n| lower[i] + (upper[i] - lower[i]) * (n as f64 / cells[i] as f64)).collect()
        };
        Self::lattice(&std::array::from_fn(line), CellCut::Parallel)
    }

    /// The box whose nodes lie where the planes `lines` [m] (ascending, per axis) meet. Its sides are the sets
    /// `left`, `right` (x), `front`, `back` (y, in 3D) and `bottom`, `top` (the last axis).
    ///
    /// # Errors
    /// Fewer than two planes along an axis, planes that do not ascend, more nodes than numbers of 32 bits can name.
    pub fn lattice(lines: &[Vec<f64>; D], cut: CellCut) -> Result<Self, String> {
        let cells = std::array::from_fn(|i| lines[i].len().saturating_sub(1));
        check_count(cells)?;
        if lines.iter().flat_map(|line| line.windows(2)).any(|pair| pair[0] >= pair[1]) {
            return Err("the planes of a lattice must ascend along every axis".into());
        }
        let nodes = grid(cells.map(|c| c + 1)).map(|index| Vector::from_fn(|i| lines[i][index[i]])).collect::<Vec<_>>();
        let number = |index: [usize; D]| (0..D).rev().fold(0, |n, i| n * (cells[i] + 1) + index[i]) as u32;
        let elements = grid(cells).flat_map(|cell| paths::<D, N>(cell, cut).map(|path| path.map(number)));
        let mut mesh = Self::new(nodes, elements.collect())?;
        mesh.name_sides(std::array::from_fn(|axis| [lines[axis][0], lines[axis][cells[axis]]]));
        Ok(mesh)
    }

    /// Names the boundary facets on the sides of a box, given its lower and upper end along each axis [m].
    pub(in crate::mesh) fn name_sides(&mut self, ends: [[f64; 2]; D]) {
        for axis in 0..D {
            for (end, name) in ends[axis].into_iter().zip(side_names::<D>(axis)) {
                let on = |facet: &Facet| self.facet_nodes(*facet).iter().all(|&n| self.nodes[n as usize][axis] == end);
                let facets: Vec<Facet> = self.boundary().iter().filter(|facet| on(facet)).copied().collect();
                self.sets.insert(name.to_owned(), facets);
            }
        }
    }
}

/// Names of the lower and the upper side of a box along an axis.
pub fn side_names<const D: usize>(axis: usize) -> [&'static str; 2] {
    match axis {
        0 => ["left", "right"],
        1 if D == 3 => ["front", "back"],
        _ => ["bottom", "top"],
    }
}

/// The simplices of a cell, as places in the grid of nodes.
fn paths<const D: usize, const N: usize>(cell: [usize; D], cut: CellCut) -> impl Iterator<Item = [[usize; D]; N]> {
    let mirrored = cell.map(|index| cut == CellCut::Mirrored && index % 2 == 1);
    let turned = mirrored.iter().filter(|&&m| m).count() % 2 == 1;
    ORDERS.iter().filter(|(order, _)| order[D..].iter().all(|&axis| axis >= D)).map(move |(order, even)| {
        let mut corner: [usize; D] = std::array::from_fn(|i| cell[i] + mirrored[i] as usize);
        let mut path = [corner; N];
        for (place, &axis) in order[..D].iter().enumerate() {
            corner[axis] = if mirrored[axis] { corner[axis] - 1 } else { corner[axis] + 1 };
            path[place + 1] = corner;
        }
        if *even == turned {
            path.swap(N - 2, N - 1);
        }
        path
    })
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

/// # Errors
/// No cells, or more simplices than have numbers.
fn check_count<const D: usize>(cells: [usize; D]) -> Result<(), String> {
    let simplices = cells.iter().try_fold(6usize, |product, &c| product.checked_mul(c.checked_add(1)?));
    if cells.contains(&0) || simplices.is_none_or(|count| count > u32::MAX as usize) {
        return Err(format!("{cells:?} cells are none or too many"));
    }
    Ok(())
}

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
