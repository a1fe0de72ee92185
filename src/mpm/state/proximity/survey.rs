//! One look at all sheets: which elements that aren't neighbours are near to each other.
//!
//! Sheets are seen in patches of some elements. Most patches reach only those that they are joined with, and are nearly flat
//! together: nothing in them can meet. Elements are compared where that is not so.

use super::distance::approach;
use super::layout::{Element, Layout};
use crate::math::Vector;
use crate::parallel;
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};
use std::collections::BTreeMap;

/// Elements count as at least this thick, over their lengths.
const THIN: f64 = 0.02;

/// Half the angle of a cone, in which the normals of a connected piece lie: it can't meet itself (Volino & Magnenat-Thalmann 1994).
const FLAT: f64 = 1.2;

/// Patches per parallel task.
const TASK: usize = 8;

/// A sheet at one time.
pub struct State {
    /// Positions of the nodes [m].
    pub position: Vec<Vector<3>>,
    /// Thickness of each element [m].
    pub thickness: Vec<f64>,
}

/// Two elements that cross, or are nearer to each other than their thickness.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Meeting {
    pub elements: [Element; 2],
    /// Their distance [m]; 0 if they cross.
    pub distance: f64,
    /// The mean of their thicknesses [m].
    pub reach: f64,
    /// The place where they meet [m].
    pub place: Vector<3>,
}

impl Meeting {
    /// The sheets, in order.
    pub fn sheets(&self) -> [u32; 2] {
        self.elements.map(|e| e.sheet)
    }

    /// The nearer of two meetings; of equal ones that of the first elements.
    fn nearer(self, other: Self) -> Self {
        let order = self.distance.total_cmp(&other.distance).then(self.elements.cmp(&other.elements));
        if order.is_le() { self } else { other }
    }
}

/// The findings of a look.
#[derive(Debug, Default)]
pub struct Found {
    /// The nearest meeting of each two sheets, and of each with itself.
    pub meetings: BTreeMap<[u32; 2], Meeting>,
    /// The least distance, beyond their thickness, of elements that don't meet and aren't neighbours [m]; at most the margin.
    pub gap: f64,
    /// Elements that were compared with those of another patch, and pairs that were measured.
    pub compared: usize,
    pub measured: usize,
}

impl Found {
    fn nothing(margin: f64) -> Self {
        Self { gap: margin, ..Self::default() }
    }

    fn add(&mut self, meeting: Meeting) {
        let known = self.meetings.entry(meeting.sheets()).or_insert(meeting);
        *known = known.nearer(meeting);
    }

    fn and(mut self, other: Self) -> Self {
        other.meetings.into_values().for_each(|meeting| self.add(meeting));
        let (compared, measured) = (self.compared + other.compared, self.measured + other.measured);
        Self { gap: self.gap.min(other.gap), compared, measured, ..self }
    }
}

/// A look at all sheets.
pub struct Survey<'a, F> {
    pub layout: &'a Layout,
    pub states: &'a [State],
    /// Pairs of elements are looked for up to this far beyond their thickness [m].
    pub margin: f64,
    /// True for pairs that count, by their reach [m] and whether they cross.
    pub counts: F,
}

/// The box that an element or a patch reaches.
#[derive(Debug, Clone, Copy)]
struct Reach {
    lower: [f64; 3],
    upper: [f64; 3],
}

impl Reach {
    const NOTHING: Self = Self { lower: [f64::INFINITY; 3], upper: [f64::NEG_INFINITY; 3] };

    fn and(self, other: Self) -> Self {
        let pick = |f: fn(f64, f64) -> f64, a: [f64; 3], b: [f64; 3]| std::array::from_fn(|i| f(a[i], b[i]));
        Self { lower: pick(f64::min, self.lower, other.lower), upper: pick(f64::max, self.upper, other.upper) }
    }

    fn meets(&self, other: &Self) -> bool {
        (0..3).all(|i| self.lower[i] <= other.upper[i] && other.lower[i] <= self.upper[i])
    }
}

/// A patch at one time: what its elements reach, and the cone of their normals.
struct Shape {
    reaches: Vec<Reach>,
    all: Reach,
    axis: Vector<3>,
    /// Half its angle.
    angle: f64,
}

type Boxed = GeomWithData<Rectangle<[f64; 3]>, usize>;

impl<F: Fn([Element; 2], f64, bool) -> bool + Sync> Survey<'_, F> {
    /// The pairs that count.
    pub fn run(&self) -> Found {
        let patches = &self.layout.patches;
        let shapes: Vec<Shape> = parallel::collect(patches.len(), TASK, |p| self.shape(&patches[p]));
        let boxed = |(p, shape): (usize, &Shape)| {
            GeomWithData::new(Rectangle::from_corners(shape.all.lower, shape.all.upper), p)
        };
        let tree: RTree<Boxed> = RTree::bulk_load(shapes.iter().enumerate().map(boxed).collect());
        let look = |own: usize| {
            let mut found = Found::nothing(self.margin);
            let around = AABB::from_corners(shapes[own].all.lower, shapes[own].all.upper);
            let near = tree.locate_in_envelope_intersecting(around).map(|other| other.data);
            let mut near: Vec<usize> = near.filter(|&other| other >= own).collect();
            near.sort_unstable();
            near.into_iter().for_each(|other| self.compare([own, other], &shapes, &mut found));
            found
        };
        let parts: Vec<Found> = parallel::collect(patches.len(), TASK, look);
        parts.into_iter().fold(Found::nothing(self.margin), Found::and)
    }

    /// The distance that an element's thickness stands for [m].
    fn thickness(&self, e: Element) -> f64 {
        let (sheet, index) = (e.sheet as usize, e.index as usize);
        self.states[sheet].thickness[index].max(THIN * self.layout.layers[sheet].length[index])
    }

    /// The least of them [m].
    pub fn least_thickness(&self) -> f64 {
        self.layout.elements().map(|e| self.thickness(e)).fold(f64::INFINITY, f64::min)
    }

    fn shape(&self, patch: &[Element]) -> Shape {
        let normal = |e: Element| self.layout.normal(e, &self.states[e.sheet as usize].position);
        let normals: Vec<Vector<3>> = patch.iter().map(|&e| normal(e)).collect();
        let axis = normals.iter().copied().sum::<Vector<3>>().normalized().unwrap_or_default();
        let least = normals.iter().map(|n| n.dot(axis)).fold(1.0, f64::min);
        let reaches: Vec<Reach> = patch.iter().map(|&e| self.reach(e)).collect();
        let all = reaches.iter().copied().fold(Reach::NOTHING, Reach::and);
        Shape { reaches, all, axis, angle: least.max(-1.0).acos() }
    }

    fn reach(&self, e: Element) -> Reach {
        let corners = self.layout.corners(e, &self.states[e.sheet as usize].position);
        let reach = 0.5 * (self.thickness(e) + self.margin);
        let own = |x: &Vector<3>| Reach { lower: x.0.map(|c| c - reach), upper: x.0.map(|c| c + reach) };
        corners.all().iter().map(own).fold(Reach::NOTHING, Reach::and)
    }

    /// Measures the distances between the elements of two patches, or of one among each other, unless they are one nearly
    /// flat piece, which can't meet itself.
    fn compare(&self, [p, q]: [usize; 2], shapes: &[Shape], found: &mut Found) {
        let (first, second) = (&shapes[p], &shapes[q]);
        let axis = (first.axis + second.axis).normalized().unwrap_or_default();
        let widest = |shape: &Shape| shape.axis.dot(axis).clamp(-1.0, 1.0).acos() + shape.angle;
        if widest(first).max(widest(second)) < FLAT && (p == q || self.layout.joined([p, q])) {
            return;
        }
        let patches = &self.layout.patches;
        for (own, &a) in first.reaches.iter().zip(&patches[p]) {
            if own.meets(&second.all) {
                for (other, &b) in second.reaches.iter().zip(&patches[q]) {
                    if (p != q || b > a) && own.meets(other) && !self.layout.adjacent(a, b) {
                        self.measure([a.min(b), a.max(b)], found);
                    }
                }
            }
        }
        found.compared += first.reaches.len() + second.reaches.len();
    }

    /// Measures the distance of two elements.
    fn measure(&self, [a, b]: [Element; 2], found: &mut Found) {
        let reach = 0.5 * (self.thickness(a) + self.thickness(b));
        let [x, y] = [a, b].map(|e| self.layout.corners(e, &self.states[e.sheet as usize].position));
        found.measured += 1;
        let Some(near) = approach(x.all(), y.all(), reach + found.gap) else { return };
        if !(self.counts)([a, b], reach, near.distance == 0.0) {
            return;
        }
        if near.distance < reach {
            found.add(Meeting { elements: [a, b], distance: near.distance, reach, place: near.place });
        } else {
            found.gap = near.distance - reach;
        }
    }
}
