//! Constants of all sheets during a run: elements, nodes at the same places, and distances of elements at the start
//! (theory D.17).

use super::distance::approach;
use crate::math::Vector;
use crate::mpm::contact::SheetFacet;
use hashbrown::{HashMap, HashSet};
use rstar::RTree;
use rstar::primitives::GeomWithData;

/// Nodes this near to each other at the start, over the length of elements, are one: sheets are joined there.
const COINCIDENT: f64 = 1e-6;

/// Distance at the start below which elements of one sheet are neighbours [thicknesses].
const BESIDE: f64 = 2.0;

/// Elements of a patch.
const PATCH: usize = 32;

/// An element of a sheet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Element {
    pub sheet: u32,
    pub index: u32,
}

/// The corners of an element [m].
pub struct ElementCorners {
    places: [Vector<3>; 4],
    count: usize,
}

impl ElementCorners {
    pub fn all(&self) -> &[Vector<3>] {
        &self.places[..self.count]
    }
}

/// One sheet.
#[derive(Debug)]
pub struct SheetLayout {
    pub name: String,
    pub facets: Vec<SheetFacet>,
    /// Positions of the nodes at the start [m].
    pub reference: Vec<Vector<3>>,
    /// Length of each element at the start: the root of its area, in 2D its length [m].
    pub length: Vec<f64>,
    /// Number of each node; those at the same place have the same one.
    nodes: Vec<u32>,
    /// Sheets that are joined have the same number.
    part: usize,
}

/// All sheets.
#[derive(Debug, Default)]
pub struct Layout {
    pub sheets: Vec<SheetLayout>,
    /// The least mean length of elements of a sheet [m].
    pub length: f64,
    /// Elements next to each other, in groups.
    pub patches: Vec<Vec<Element>>,
    /// Patches that share a node.
    joined: HashSet<[usize; 2]>,
}

impl Layout {
    /// The layout of sheets with these names, elements and positions of nodes at the start [m].
    pub fn new<'a, const D: usize>(sheets: impl Iterator<Item = (&'a str, Vec<SheetFacet>, &'a [Vector<D>])>) -> Self {
        let layer = |(name, facets, reference): (&str, Vec<SheetFacet>, &[Vector<D>])| SheetLayout {
            name: name.to_owned(),
            length: facets.iter().map(|facet| facet.area(reference).norm().powf(1.0 / (D - 1) as f64)).collect(),
            facets,
            reference: reference.iter().map(|x| Vector(x.to3())).collect(),
            nodes: Vec::new(),
            part: 0,
        };
        let sheets: Vec<SheetLayout> = sheets.map(layer).collect();
        let mean = |layer: &SheetLayout| layer.length.iter().sum::<f64>() / layer.length.len() as f64;
        let length = sheets.iter().map(mean).fold(f64::INFINITY, f64::min);
        let mut layout = Self { sheets, length, ..Self::default() };
        layout.join_coincident_nodes();
        let elements: Vec<Element> = layout.elements().collect();
        elements.chunk_by(|a, b| a.sheet == b.sheet).for_each(|own| layout.part(own.to_vec()));
        layout.join();
        layout
    }

    /// Finds nodes at the same place, and the sheets that they join.
    fn join_coincident_nodes(&mut self) {
        let places = self.sheets.iter().flat_map(|layer| &layer.reference).zip(0_u32..);
        let tree = RTree::bulk_load(places.map(|(x, k)| GeomWithData::new(x.0, k)).collect());
        let square = (COINCIDENT * self.length).powi(2);
        let number = |x: &Vector<3>| tree.locate_within_distance(x.0, square).map(|node| node.data).min().unwrap_or(0);
        let mut parts: Vec<usize> = (0..self.sheets.len()).collect();
        let mut ends = Vec::new();
        for (sheet, layer) in self.sheets.iter_mut().enumerate() {
            layer.nodes = layer.reference.iter().map(number).collect();
            let first = ends.last().copied().unwrap_or(0);
            for &node in layer.nodes.iter().filter(|&&node| node < first) {
                let other = parts[ends.partition_point(|&end| end <= node)];
                let own = std::mem::replace(&mut parts[sheet], other);
                parts.iter_mut().filter(|part| **part == own).for_each(|part| *part = other);
            }
            ends.push(first + layer.nodes.len() as u32);
        }
        self.sheets.iter_mut().zip(parts).for_each(|(layer, part)| layer.part = part);
    }

    /// Parts elements of a sheet into patches, across their longest side in the state at the start.
    fn part(&mut self, mut elements: Vec<Element>) {
        if elements.len() <= PATCH {
            self.patches.push(elements);
            return;
        }
        let extent = |axis: usize| {
            let places = elements.iter().map(|&e| self.start(e)[axis]);
            let [low, high] =
                places.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [x.min(low), x.max(high)]);
            high - low
        };
        let axis = (0..3).max_by(|&a, &b| extent(a).total_cmp(&extent(b))).unwrap_or(0);
        elements.sort_by(|&a, &b| self.start(a)[axis].total_cmp(&self.start(b)[axis]));
        let rest = elements.split_off(elements.len() / 2);
        self.part(elements);
        self.part(rest);
    }

    /// Finds the patches that share nodes.
    fn join(&mut self) {
        let mut around: HashMap<u32, Vec<usize>> = HashMap::new();
        for (p, patch) in self.patches.iter().enumerate() {
            for node in patch.iter().flat_map(|&e| self.nodes(e)) {
                let known = around.entry(node).or_default();
                if known.last() != Some(&p) {
                    known.push(p);
                }
            }
        }
        let pairs = |known: &Vec<usize>| {
            let known = known.clone();
            (0..known.len()).flat_map(move |i| known[..i].iter().map(|&p| [p, known[i]]).collect::<Vec<_>>())
        };
        self.joined = around.values().flat_map(pairs).collect();
    }

    /// True if two patches, in order, of one sheet share a node.
    pub fn joined(&self, [p, q]: [usize; 2]) -> bool {
        self.patches[p][0].sheet == self.patches[q][0].sheet && self.joined.contains(&[p, q])
    }

    /// The middle of an element at the start [m].
    fn start(&self, e: Element) -> Vector<3> {
        let corners = self.corners(e, &self.sheets[e.sheet as usize].reference);
        corners.all().iter().copied().sum::<Vector<3>>() / corners.all().len() as f64
    }

    /// The unit normal of an element, from the positions of its sheet's nodes [m]; of segments, in the plane.
    pub fn normal(&self, e: Element, position: &[Vector<3>]) -> Vector<3> {
        let area = match *self.corners(e, position).all() {
            [a, b] => Vector([b[1] - a[1], a[0] - b[0], 0.0]),
            [a, b, c] => (b - a).cross(c - a),
            [a, b, c, d] => (c - a).cross(d - b),
            _ => Vector::ZERO,
        };
        area.normalized().unwrap_or_default()
    }

    /// Number of elements of all sheets.
    pub fn count(&self) -> usize {
        self.sheets.iter().map(|layer| layer.facets.len()).sum()
    }

    /// Every element.
    pub fn elements(&self) -> impl Iterator<Item = Element> {
        let of = |(sheet, layer): (usize, &SheetLayout)| {
            let sheet = sheet as u32;
            (0..layer.facets.len() as u32).map(move |index| Element { sheet, index })
        };
        self.sheets.iter().enumerate().flat_map(of)
    }

    /// Corners of an element, from the positions of its sheet's nodes [m].
    pub fn corners(&self, e: Element, position: &[Vector<3>]) -> ElementCorners {
        let facet = &self.sheets[e.sheet as usize].facets[e.index as usize];
        ElementCorners { places: facet.corners(position), count: facet.count }
    }

    /// Numbers of the nodes of an element, the same for nodes at the same place.
    fn nodes(&self, e: Element) -> impl Iterator<Item = u32> {
        let layer = &self.sheets[e.sheet as usize];
        layer.facets[e.index as usize].nodes().iter().map(|&k| layer.nodes[k as usize])
    }

    /// True if two elements share a node.
    pub fn adjacent(&self, a: Element, b: Element) -> bool {
        self.nodes(a).any(|k| self.nodes(b).any(|other| other == k))
    }

    /// True if two elements belong to one sheet, or to sheets that are joined.
    pub fn together(&self, a: Element, b: Element) -> bool {
        self.sheets[a.sheet as usize].part == self.sheets[b.sheet as usize].part
    }

    /// True if two elements with the mean thickness `reach` [m] were so near to each other at the start that their
    /// distance now tells nothing.
    pub fn began_near(&self, a: Element, b: Element, reach: f64) -> bool {
        let within = if self.together(a, b) { BESIDE * reach } else { reach };
        let [x, y] = [a, b].map(|e| self.corners(e, &self.sheets[e.sheet as usize].reference));
        approach(x.all(), y.all(), within).is_some()
    }

    /// The elements around each node.
    pub fn around(&self) -> HashMap<u32, Vec<Element>> {
        let mut around: HashMap<u32, Vec<Element>> = HashMap::new();
        for e in self.elements() {
            self.nodes(e).for_each(|node| around.entry(node).or_default().push(e));
        }
        around
    }

    /// True if a way from `a` to `b` along the sheet stays within two elements and two thicknesses `reach` [m] of `a`.
    pub fn neighbours(&self, around: &HashMap<u32, Vec<Element>>, [a, b]: [Element; 2], reach: f64) -> bool {
        let within = BESIDE * (reach + self.sheets[a.sheet as usize].length[a.index as usize]);
        let (mut visited, mut front) = (HashSet::<Element>::from_iter([a]), vec![a]);
        while let Some(e) = front.pop() {
            for &next in self.nodes(e).flat_map(|node| &around[&node]) {
                if (self.start(next) - self.start(a)).norm() <= within && visited.insert(next) {
                    front.push(next);
                }
            }
        }
        visited.contains(&b)
    }
}
