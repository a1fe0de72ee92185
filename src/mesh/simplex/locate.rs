//! Point location: a directed walk from a guess, and bins if the walk ends at a boundary.

use super::{Facet, Mesh};
use crate::math::Vector;

/// Shape functions above −TOLERANCE count as inside, so that no point is lost between two elements.
const TOLERANCE: f64 = 1e-12;

/// Longest walk; a longer one is cut short by the bins.
const STEPS: usize = 200;

/// Location of a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Location<const N: usize> {
    /// A point in an element.
    Inside {
        /// The element.
        element: usize,
        /// Shape functions at the point.
        shape: [f64; N],
    },
    /// Outside of the mesh; the walk left it through this facet.
    Outside {
        /// The facet.
        exit: Facet,
    },
}

impl<const N: usize> Location<N> {
    /// The element, if the point lies in one.
    pub fn element(&self) -> Option<usize> {
        match self {
            Self::Inside { element, .. } => Some(*element),
            Self::Outside { .. } => None,
        }
    }
}

/// Finds the element in which a point lies.
///
/// Bins are the cells of a uniform grid, about one per element; each lists the elements whose bounding boxes
/// touch it, ascending.
#[derive(Debug, Clone)]
pub struct Locator<const D: usize> {
    lower: Vector<D>,
    size: Vector<D>,
    shape: [usize; D],
    /// Elements of bin b are `list[start[b]..start[b + 1]]`.
    start: Vec<u32>,
    list: Vec<u32>,
}

impl<const D: usize> Locator<D> {
    /// Bins for a mesh.
    pub fn new<const N: usize>(mesh: &Mesh<D, N>) -> Self {
        let (lower, upper) = bounds(mesh.nodes().iter().copied());
        let per_axis = (mesh.elements().len() as f64).powf(1.0 / D as f64).ceil() as usize;
        let shape = [per_axis.max(1); D];
        let size = Vector::from_fn(|i| ((upper[i] - lower[i]) / shape[i] as f64).max(f64::MIN_POSITIVE));
        let mut locator = Self { lower, size, shape, start: Vec::new(), list: Vec::new() };
        let touched: Vec<[[usize; 2]; D]> = (0..mesh.elements().len()).map(|e| locator.touched(mesh, e)).collect();
        let mut start = vec![0u32; per_axis.pow(D as u32) + 1];
        touched.iter().for_each(|range| locator.visit(range, |bin| start[bin + 1] += 1));
        (1..start.len()).for_each(|bin| start[bin] += start[bin - 1]);
        let mut next = start.clone();
        let mut list = vec![0; start.last().map_or(0, |&end| end as usize)];
        for (element, range) in (0u32..).zip(&touched) {
            locator.visit(range, |bin| {
                list[next[bin] as usize] = element;
                next[bin] += 1;
            });
        }
        (locator.start, locator.list) = (start, list);
        locator
    }

    /// Locates `x`, starting from a guess of the element. A point on a facet belongs to the element that the
    /// walk reaches first.
    pub fn locate<const N: usize>(&self, mesh: &Mesh<D, N>, x: Vector<D>, guess: usize) -> Location<N> {
        let walked = walk(mesh, x, guess);
        match walked {
            Some(inside @ Location::Inside { .. }) => inside,
            // Behind a re-entrant boundary the mesh may go on.
            _ => self.search(mesh, x).or(walked).unwrap_or_else(|| nearest_exit(mesh, x)),
        }
    }

    /// Locates `x` from the bins alone; `None` outside. Of several elements the one with the greatest least shape
    /// function.
    pub fn search<const N: usize>(&self, mesh: &Mesh<D, N>, x: Vector<D>) -> Option<Location<N>> {
        if !x.is_finite() {
            return None;
        }
        let mut deepest: Option<(f64, usize, [f64; N])> = None;
        for element in self.candidates(x).iter().map(|&e| e as usize) {
            let shape = mesh.shape_functions(element, x);
            let least = shape.into_iter().fold(f64::INFINITY, f64::min);
            if least >= -TOLERANCE && deepest.is_none_or(|(depth, ..)| least > depth) {
                deepest = Some((least, element, shape));
            }
        }
        deepest.map(|(_, element, shape)| Location::Inside { element, shape })
    }

    /// An element other than `element` that holds the centre of `element` well inside.
    pub fn overlapping<const N: usize>(&self, mesh: &Mesh<D, N>, element: usize) -> Option<usize> {
        /// Well inside: rounding of places doesn't reach it.
        const INSIDE: f64 = 1e-6;
        let x = mesh.center(element);
        let least = |e: usize| mesh.shape_functions(e, x).into_iter().fold(f64::INFINITY, f64::min);
        let candidates = self.candidates(x).iter().map(|&e| e as usize);
        candidates.into_iter().find(|&e| e != element && least(e) > INSIDE)
    }

    /// The elements whose bounding boxes touch the bin of a place.
    fn candidates(&self, x: Vector<D>) -> &[u32] {
        let bin = (0..D).rev().fold(0, |bin, i| bin * self.shape[i] + self.along(i, x[i]));
        &self.list[self.start[bin] as usize..self.start[bin + 1] as usize]
    }

    fn along(&self, axis: usize, x: f64) -> usize {
        (((x - self.lower[axis]) / self.size[axis]).max(0.0) as usize).min(self.shape[axis] - 1)
    }

    /// First and last bin along each axis that an element's bounding box touches, with room for the tolerance.
    fn touched<const N: usize>(&self, mesh: &Mesh<D, N>, element: usize) -> [[usize; 2]; D] {
        let (lower, upper) = bounds(mesh.corners(element).into_iter());
        std::array::from_fn(|i| {
            let room = 1e-9 * (upper[i] - lower[i]);
            [self.along(i, lower[i] - room), self.along(i, upper[i] + room)]
        })
    }

    fn visit(&self, range: &[[usize; 2]; D], mut each: impl FnMut(usize)) {
        let mut at: [usize; D] = std::array::from_fn(|i| range[i][0]);
        loop {
            each((0..D).rev().fold(0, |bin, i| bin * self.shape[i] + at[i]));
            let Some(axis) = (0..D).find(|&i| at[i] < range[i][1]) else { return };
            at[axis] += 1;
            (0..axis).for_each(|i| at[i] = range[i][0]);
        }
    }
}

/// Goes through the facet of the most negative shape function, or the next one if that is at the boundary.
fn walk<const D: usize, const N: usize>(mesh: &Mesh<D, N>, x: Vector<D>, guess: usize) -> Option<Location<N>> {
    let mut element = guess;
    for _ in 0..STEPS {
        let shape = mesh.shape_functions(element, x);
        let mut order: [usize; N] = std::array::from_fn(|k| k);
        order.sort_unstable_by(|&a, &b| shape[a].total_cmp(&shape[b]));
        if shape[order[0]] >= -TOLERANCE {
            return Some(Location::Inside { element, shape });
        }
        let behind = order.iter().filter(|&&k| shape[k] < 0.0).find_map(|&k| mesh.neighbour(element, k));
        match behind {
            Some(neighbour) => element = neighbour,
            None => {
                let exit = Facet { element: element as u32, opposite: order[0] as u32 };
                return Some(Location::Outside { exit });
            }
        }
    }
    None
}

/// The boundary facet whose centre is nearest: the exit of a point that no walk led to.
fn nearest_exit<const D: usize, const N: usize>(mesh: &Mesh<D, N>, x: Vector<D>) -> Location<N> {
    let away = |facet: &Facet| {
        let nodes = mesh.facet_nodes(*facet);
        let sum: Vector<D> = nodes.iter().map(|&n| mesh.nodes()[n as usize]).sum();
        (sum / nodes.len() as f64 - x).norm_squared()
    };
    let nearest = mesh.boundary().iter().min_by(|a, b| away(a).total_cmp(&away(b)));
    Location::Outside { exit: nearest.copied().unwrap_or(Facet { element: 0, opposite: 0 }) }
}

fn bounds<const D: usize>(points: impl Iterator<Item = Vector<D>>) -> (Vector<D>, Vector<D>) {
    points.fold((Vector::splat(f64::INFINITY), Vector::splat(f64::NEG_INFINITY)), |(lower, upper), x| {
        (Vector::from_fn(|i| lower[i].min(x[i])), Vector::from_fn(|i| upper[i].max(x[i])))
    })
}
