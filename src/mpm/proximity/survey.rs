//! One survey of all sheets: elements that aren't neighbours and are near to each other (theory D.17).
//!
//! Elements are grouped in patches. Most patches are near to those alone that they are joined with, and are nearly flat
//! together, so that no elements in them are in contact. Elements of all other pairs of patches are compared.

use super::distance::approach;
use super::layout::{Element, Layout};
use crate::math::Vector;
use crate::parallel;
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};
use std::collections::BTreeMap;

/// Elements count as at least this thick, over their lengths.
const THIN: f64 = 0.02;

/// Half the angle of a cone, in which the normals of a connected piece lie that has no contact with itself (Volino &
/// Magnenat-Thalmann 1994).
const FLAT: f64 = 1.2;

/// Patches per parallel task.
const TASK: usize = 8;

/// A sheet at one time.
pub struct SurveyedSheet {
    /// Positions of the nodes [m].
    pub position: Vec<Vector<3>>,
    /// Thickness of each element [m].
    pub thickness: Vec<f64>,
}

/// Two elements that cross, or are nearer to each other than their thickness.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ElementContact {
    pub elements: [Element; 2],
    /// Distance of the two [m]; 0 if they cross.
    pub distance: f64,
    /// The mean of their thicknesses [m].
    pub reach: f64,
    /// Middle of the shortest line between them [m].
    pub place: Vector<3>,
}

impl ElementContact {
    /// The sheets, in order.
    pub fn sheets(&self) -> [u32; 2] {
        self.elements.map(|e| e.sheet)
    }

    /// The nearer of two contacts; of equal ones that of the first elements.
    fn nearer(self, other: Self) -> Self {
        let order = self.distance.total_cmp(&other.distance).then(self.elements.cmp(&other.elements));
        if order.is_le() { self } else { other }
    }
}

/// The result of a survey.
#[derive(Debug, Default)]
pub struct SurveyResult {
    /// The nearest contact of each two sheets, and of each with itself.
    pub contacts: BTreeMap<[u32; 2], ElementContact>,
    /// The least distance, beyond their thickness, of elements that are neither in contact nor neighbours [m]; at most
    /// the margin.
    pub gap: f64,
    /// Elements that were compared with those of another patch, and pairs that were measured.
    pub compared: usize,
    pub measured: usize,
}

impl SurveyResult {
    fn empty(margin: f64) -> Self {
        Self { gap: margin, ..Self::default() }
    }

    fn add(&mut self, contact: ElementContact) {
        let known = self.contacts.entry(contact.sheets()).or_insert(contact);
        *known = known.nearer(contact);
    }

    fn merged(mut self, other: Self) -> Self {
        other.contacts.into_values().for_each(|contact| self.add(contact));
        let (compared, measured) = (self.compared + other.compared, self.measured + other.measured);
        Self { gap: self.gap.min(other.gap), compared, measured, ..self }
    }
}

/// A survey of all sheets.
pub struct Survey<'a, F> {
    pub layout: &'a Layout,
    pub states: &'a [SurveyedSheet],
    /// Pairs of elements are looked for up to this far beyond their thickness [m].
    pub margin: f64,
    /// True for pairs that count; arguments: the elements, the mean of their thicknesses [m], and true if they cross.
    pub counts: F,
}

/// The box around an element or a patch, enlarged by half the margin and half the thickness.
#[derive(Debug, Clone, Copy)]
struct BoundingBox {
    lower: [f64; 3],
    upper: [f64; 3],
}

impl BoundingBox {
    const EMPTY: Self = Self { lower: [f64::INFINITY; 3], upper: [f64::NEG_INFINITY; 3] };

    fn union(self, other: Self) -> Self {
        let pick = |f: fn(f64, f64) -> f64, a: [f64; 3], b: [f64; 3]| std::array::from_fn(|i| f(a[i], b[i]));
        Self { lower: pick(f64::min, self.lower, other.lower), upper: pick(f64::max, self.upper, other.upper) }
    }

    fn meets(&self, other: &Self) -> bool {
        (0..3).all(|i| self.lower[i] <= other.upper[i] && other.lower[i] <= self.upper[i])
    }
}

/// A patch at one time: the boxes around its elements, and the cone of their normals.
struct PatchBounds {
    boxes: Vec<BoundingBox>,
    all: BoundingBox,
    axis: Vector<3>,
    /// Half its angle.
    angle: f64,
}

type Boxed = GeomWithData<Rectangle<[f64; 3]>, usize>;

impl<F: Fn([Element; 2], f64, bool) -> bool + Sync> Survey<'_, F> {
    /// Runs the survey.
    pub fn run(&self) -> SurveyResult {
        let patches = &self.layout.patches;
        let bounds: Vec<PatchBounds> = parallel::collect(patches.len(), TASK, |p| self.bounds_of(&patches[p]));
        let boxed = |(p, shape): (usize, &PatchBounds)| {
            GeomWithData::new(Rectangle::from_corners(shape.all.lower, shape.all.upper), p)
        };
        let tree: RTree<Boxed> = RTree::bulk_load(bounds.iter().enumerate().map(boxed).collect());
        let survey_patch = |own: usize| {
            let mut found = SurveyResult::empty(self.margin);
            let around = AABB::from_corners(bounds[own].all.lower, bounds[own].all.upper);
            let near = tree.locate_in_envelope_intersecting(around).map(|other| other.data);
            let mut near: Vec<usize> = near.filter(|&other| other >= own).collect();
            near.sort_unstable();
            near.into_iter().for_each(|other| self.compare([own, other], &bounds, &mut found));
            found
        };
        let parts: Vec<SurveyResult> = parallel::collect(patches.len(), TASK, survey_patch);
        parts.into_iter().fold(SurveyResult::empty(self.margin), SurveyResult::merged)
    }

    /// Thickness of an element in the survey [m].
    fn thickness(&self, e: Element) -> f64 {
        let (sheet, index) = (e.sheet as usize, e.index as usize);
        self.states[sheet].thickness[index].max(THIN * self.layout.sheets[sheet].length[index])
    }

    /// The least of them [m].
    pub fn least_thickness(&self) -> f64 {
        self.layout.elements().map(|e| self.thickness(e)).fold(f64::INFINITY, f64::min)
    }

    fn bounds_of(&self, patch: &[Element]) -> PatchBounds {
        let normal = |e: Element| self.layout.normal(e, &self.states[e.sheet as usize].position);
        let normals: Vec<Vector<3>> = patch.iter().map(|&e| normal(e)).collect();
        let axis = normals.iter().copied().sum::<Vector<3>>().normalized().unwrap_or_default();
        let least = normals.iter().map(|n| n.dot(axis)).fold(1.0, f64::min);
        let boxes: Vec<BoundingBox> = patch.iter().map(|&e| self.box_of(e)).collect();
        let all = boxes.iter().copied().fold(BoundingBox::EMPTY, BoundingBox::union);
        PatchBounds { boxes, all, axis, angle: least.max(-1.0).acos() }
    }

    fn box_of(&self, e: Element) -> BoundingBox {
        let corners = self.layout.corners(e, &self.states[e.sheet as usize].position);
        let reach = 0.5 * (self.thickness(e) + self.margin);
        let own = |x: &Vector<3>| BoundingBox { lower: x.0.map(|c| c - reach), upper: x.0.map(|c| c + reach) };
        corners.all().iter().map(own).fold(BoundingBox::EMPTY, BoundingBox::union)
    }

    /// Measures the distances between the elements of two patches, or of one among each other, unless they are one
    /// nearly flat piece, which has no contact with itself.
    fn compare(&self, [p, q]: [usize; 2], bounds: &[PatchBounds], found: &mut SurveyResult) {
        let (first, second) = (&bounds[p], &bounds[q]);
        let axis = (first.axis + second.axis).normalized().unwrap_or_default();
        let widest = |shape: &PatchBounds| shape.axis.dot(axis).clamp(-1.0, 1.0).acos() + shape.angle;
        if widest(first).max(widest(second)) < FLAT && (p == q || self.layout.joined([p, q])) {
            return;
        }
        let patches = &self.layout.patches;
        for (own, &a) in first.boxes.iter().zip(&patches[p]) {
            if own.meets(&second.all) {
                for (other, &b) in second.boxes.iter().zip(&patches[q]) {
                    if (p != q || b > a) && own.meets(other) && !self.layout.adjacent(a, b) {
                        self.measure([a.min(b), a.max(b)], found);
                    }
                }
            }
        }
        found.compared += first.boxes.len() + second.boxes.len();
    }

    /// Measures the distance of two elements.
    fn measure(&self, [a, b]: [Element; 2], found: &mut SurveyResult) {
        let reach = 0.5 * (self.thickness(a) + self.thickness(b));
        let [x, y] = [a, b].map(|e| self.layout.corners(e, &self.states[e.sheet as usize].position));
        found.measured += 1;
        let Some(near) = approach(x.all(), y.all(), reach + found.gap) else { return };
        if !(self.counts)([a, b], reach, near.distance == 0.0) {
            return;
        }
        if near.distance < reach {
            found.add(ElementContact { elements: [a, b], distance: near.distance, reach, place: near.place });
        } else {
            found.gap = near.distance - reach;
        }
    }
}
