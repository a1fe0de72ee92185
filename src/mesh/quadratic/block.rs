//! Blocks of elements: boxes, also turned, and boxes of which other shapes cut an end off.
//!
//! Along the axis whose ends are cut, every row of nodes is spread evenly from where it enters the region to where it
//! leaves it:
//!
//! ```text
//! x(s, r) = a(r) + s (b(r) − a(r)),   s ∈ [0, 1],      r: place across the axis;   a, b: ends of the row
//! ```

use super::frame::Frame;
use super::{DISTANCE_ON_SIDE, ElementSize, QuadraticMesh};
use crate::geometry::Region;
use crate::mesh::side_names;

/// Places at which a row is searched for its ends.
const SAMPLES: usize = 512;

/// The shortest row may be this part of the longest one.
const LEAST_ROW_RATIO: f64 = 0.2;

/// Sides of elements may leave the surface of the region by this part of their length.
const OFF: f64 = 0.02;

/// A box in a region, in the coordinates of the box.
struct Cuboid {
    frame: Frame,
    lower: [f64; 3],
    upper: [f64; 3],
    /// True if something is taken away from it.
    cut: bool,
}

/// The block of a box, or of a box with cut ends; `None` for other regions, and for cuts that a block can't follow.
pub fn of_region(region: &Region, size: ElementSize, dimension: usize) -> Option<QuadraticMesh> {
    let cuboid = Cuboid::of(region, dimension)?;
    if !cuboid.cut {
        return Some(cuboid.mesh(dimension, cuboid.counts(size, dimension), |s| s));
    }
    let mut axes: Vec<usize> = (0..dimension).collect();
    axes.sort_by(|&i, &j| cuboid.length(j).total_cmp(&cuboid.length(i)));
    axes.into_iter().find_map(|axis| cuboid.trimmed(region, size, dimension, axis))
}

impl Cuboid {
    /// The box that is the whole of a region, or the first part of an intersection.
    fn of(region: &Region, dimension: usize) -> Option<Self> {
        let (mut frame, mut cut, mut rest) = (Frame::FIXED, false, region);
        loop {
            let (own, inner) = Frame::of(rest);
            frame = frame.after(&own);
            match inner {
                Region::Intersection(members) => {
                    cut |= members.len() > 1;
                    rest = members.first()?;
                }
                Region::Box { lower, upper } => {
                    let plane = |x: &[f64; 3]| std::array::from_fn(|i| if i < dimension { x[i] } else { 0.0 });
                    return Some(Self { frame, lower: plane(lower), upper: plane(upper), cut });
                }
                _ => return None,
            }
        }
    }

    fn length(&self, axis: usize) -> f64 {
        self.upper[axis] - self.lower[axis]
    }

    fn counts(&self, size: ElementSize, dimension: usize) -> [usize; 3] {
        std::array::from_fn(|axis| if axis < dimension { size.divisions(self.length(axis)) } else { 0 })
    }

    /// The place [m] of coordinates in 0..=1.
    fn place(&self, s: [f64; 3]) -> [f64; 3] {
        self.frame.place(std::array::from_fn(|i| self.lower[i] + s[i] * (self.upper[i] - self.lower[i])))
    }

    /// A lattice of elements; `shape` maps coordinates in 0..=1 to others.
    fn mesh(&self, dimension: usize, counts: [usize; 3], shape: impl Fn([f64; 3]) -> [f64; 3]) -> QuadraticMesh {
        let mut mesh = QuadraticMesh::lattice(dimension, counts, |at| {
            let s = std::array::from_fn(|k| at[k] as f64 / (2 * counts[k]).max(1) as f64);
            self.place(shape(s))
        });
        mesh.name_lattice_sides(counts);
        mesh
    }

    /// The block whose rows along `axis` end where the region does.
    fn trimmed(&self, region: &Region, size: ElementSize, dimension: usize, axis: usize) -> Option<QuadraticMesh> {
        let mut counts = self.counts(size, dimension);
        let lines: [usize; 3] = std::array::from_fn(|k| if k == axis { 1 } else { 2 * counts[k] + 1 });
        let across = |n: usize| [n % lines[0], n / lines[0] % lines[1], n / lines[0] / lines[1]];
        let row = |n: usize| {
            let at = across(n);
            self.row(region, axis, std::array::from_fn(|k| at[k] as f64 / (lines[k] - 1).max(1) as f64))
        };
        let rows: Vec<[f64; 2]> = (0..lines.iter().product()).map(row).collect::<Option<_>>()?;
        let lengths = || rows.iter().map(|[from, to]| to - from);
        let longest = lengths().fold(0.0, f64::max);
        let whole = |end: usize| {
            let at_end = rows.iter().filter(|row| row[end] == end as f64).count();
            at_end == 0 || at_end == rows.len()
        };
        if lengths().fold(longest, f64::min) < LEAST_ROW_RATIO * longest || !(whole(0) && whole(1)) {
            return None;
        }
        counts[axis] = size.divisions(self.length(axis) * lengths().sum::<f64>() / rows.len() as f64);
        let place = |mut s: [f64; 3]| {
            let at: [usize; 3] = std::array::from_fn(|k| (s[k] * (lines[k] - 1) as f64).round() as usize);
            let [from, to] = rows[at[0] + lines[0] * (at[1] + lines[1] * at[2])];
            s[axis] = from + s[axis] * (to - from);
            s
        };
        let mesh = self.mesh(dimension, counts, place);
        (mesh.folded().is_none() && mesh.distance_to(region) <= OFF * size.cell).then_some(mesh)
    }

    /// The ends of a row of the region along an axis, in 0..=1; `None` if it is not in one piece.
    fn row(&self, region: &Region, axis: usize, mut s: [f64; 3]) -> Option<[f64; 2]> {
        let size = (0..3).map(|k| self.length(k)).fold(0.0, f64::max);
        let mut inside = |along: f64| {
            s[axis] = along;
            // Rows on the sides of the box lie on the surface, up to rounding.
            region.signed_distance(self.place(s)) <= 1e-3 * DISTANCE_ON_SIDE * size
        };
        let at = |i: usize| i as f64 / SAMPLES as f64;
        let held: Vec<usize> = (0..=SAMPLES).filter(|&i| inside(at(i))).collect();
        let (&first, &last) = (held.first()?, held.last()?);
        if last - first + 1 != held.len() || first == last {
            return None;
        }
        let mut end = |held: usize, out: usize| {
            let (mut held, mut out) = (at(held), at(out));
            for _ in 0..60 {
                let middle = 0.5 * (held + out);
                if inside(middle) { held = middle } else { out = middle }
            }
            held
        };
        let from = if first == 0 { 0.0 } else { end(first, first - 1) };
        let to = if last == SAMPLES { 1.0 } else { end(last, last + 1) };
        Some([from, to])
    }
}

impl QuadraticMesh {
    /// A lattice of `counts` elements, whose nodes are counted along the first axis first; 0 elements along z in 2D.
    /// `place` gives the place [m] of a node.
    pub(super) fn lattice(dimension: usize, counts: [usize; 3], place: impl FnMut([usize; 3]) -> [f64; 3]) -> Self {
        let lines = counts.map(|count| 2 * count + 1);
        let split = |n: usize, sizes: [usize; 3]| [n % sizes[0], n / sizes[0] % sizes[1], n / sizes[0] / sizes[1]];
        let number = |at: [usize; 3]| (at[0] + lines[0] * (at[1] + lines[1] * at[2])) as u32;
        let cells = counts.map(|count| count.max(1));
        let element = |n: usize| {
            let first = split(n, cells);
            let local = |a: usize| {
                let own = split(a, [3; 3]);
                number(std::array::from_fn(|k| 2 * first[k] + own[k]))
            };
            (0..3usize.pow(dimension as u32)).map(local).collect()
        };
        Self {
            dimension,
            nodes: (0..lines.iter().product()).map(|n| split(n, lines)).map(place).collect(),
            elements: (0..cells.iter().product()).map(element).collect(),
            sets: Default::default(),
        }
    }

    /// Names the nodes on the ends of a lattice.
    fn name_lattice_sides(&mut self, counts: [usize; 3]) {
        let lines = counts.map(|count| 2 * count + 1);
        let along = |n: u32| {
            let n = n as usize;
            [n % lines[0], n / lines[0] % lines[1], n / lines[0] / lines[1]]
        };
        for axis in 0..self.dimension {
            let names = if self.dimension == 2 { side_names::<2>(axis) } else { side_names::<3>(axis) };
            for (name, end) in names.into_iter().zip([0, lines[axis] - 1]) {
                let nodes = (0..self.nodes.len() as u32).filter(|&n| along(n)[axis] == end).collect();
                self.sets.insert(name.to_owned(), nodes);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{plate, without};
    use super::*;

    /// The beam of Turek and Hron: 0.35 m and a little more from the cylinder's arc to x = 0.6, 0.02 m thick.
    #[test]
    fn a_beam_begins_on_the_arc_that_cuts_it() {
        let disc = Region::Sphere { center: [0.2, 0.2, 0.0], radius: 0.05 };
        let beam = without(plate([0.2, 0.19], [0.6, 0.21]), disc);
        let mesh = QuadraticMesh::fill(&beam, 0.01, 2).unwrap();
        assert_eq!((mesh.elements.len(), mesh.nodes.len(), mesh.sets["left"].len()), (70, 71 * 5, 5));
        for &n in &mesh.sets["left"] {
            let [x, y, _] = mesh.nodes[n as usize];
            assert!(((x - 0.2).hypot(y - 0.2) - 0.05).abs() < 1e-12);
        }
        // The box less the part of the disc between x = 0.2 and the arc: ½ (w √(R² − w²) + R² asin(w/R)) on both sides,
        // w = 0.01.
        let (w, r) = (0.01f64, 0.05f64);
        let taken = w * (r * r - w * w).sqrt() + r * r * (w / r).asin();
        assert!((mesh.volume() - (0.4 * 0.02 - taken)).abs() < 1e-6 * mesh.volume(), "{}", mesh.volume());
        let thinnest = mesh.thinnest();
        assert!(thinnest.elements == 2 && (thinnest.length - 0.02).abs() < 1e-12, "{thinnest:?}");
    }

    #[test]
    fn a_turned_box_keeps_the_names_of_its_sides() {
        let (sin, cos) = 0.5f64.sin_cos();
        let turned = Region::Placed {
            region: Box::new(plate([0.0, 0.0], [2.0, 1.0])),
            rotation: [[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]],
            shift: [3.0, 0.0, 0.0],
        };
        let mesh = QuadraticMesh::fill(&turned, 0.5, 2).unwrap();
        assert!((mesh.volume() - 2.0).abs() < 1e-12);
        let corner = mesh.nodes[*mesh.sets["right"].first().unwrap() as usize];
        assert!((corner[0] - (3.0 + 2.0 * cos)).abs() < 1e-14 && (corner[1] - 2.0 * sin).abs() < 1e-14);
    }

    /// A bar between two balls, cut from a box in space: its volume is that of the box less two caps, π h² (R − h/3)
    /// each.
    #[test]
    fn a_hole_is_no_cut_end_and_a_cut_box_in_space_is_a_block() {
        let hole = Region::Sphere { center: [1.0, 0.5, 0.0], radius: 0.2 };
        assert!(
            of_region(&without(plate([0.0, 0.0], [2.0, 1.0]), hole), ElementSize { cell: 0.1, across: 1 }, 2).is_none()
        );
        let notch = Region::Sphere { center: [1.0, 1.0, 0.0], radius: 0.2 };
        assert!(
            of_region(&without(plate([0.0, 0.0], [2.0, 1.0]), notch), ElementSize { cell: 0.1, across: 1 }, 2)
                .is_none()
        );
        let bar = Region::Box { lower: [0.0; 3], upper: [3.0, 1.0, 1.0] };
        let plane = Region::HalfSpace { point: [1.0, 0.0, 0.0], normal: [0.8, 0.6, 0.0] };
        let mesh = QuadraticMesh::fill(&without(bar, plane), 0.25, 3).unwrap();
        assert!((mesh.volume() - (2.0 + 0.375)).abs() < 1e-9, "{}", mesh.volume());
    }
}
