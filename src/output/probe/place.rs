//! The target of a probe: a particle, an element, or a point between the nodes of an element.

use super::hexahedron::in_hexahedron;
use super::simple_elements::{blend, in_quadrilateral, in_simplex};
use crate::math::Vector;
use crate::output::set::{On, Set, SetQuantity};
use crate::simulation::{Elements, SurfaceSet};

/// The target of a probe.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Followed {
    /// A particle, by identity.
    Particle(u32),
    /// An element.
    Element(usize),
    /// A point of an element: its nodes with their shape functions.
    Point(Vec<(usize, f64)>),
}

/// The particle or element at a place of the reference state, or nearest to it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct NearestEntry {
    pub followed: Followed,
    /// Position in the reference state [m].
    pub place: [f64; 3],
}

/// A point this near to a node, over the longest side of its element, is the node.
const AT_NODE: f64 = 1e-9;

/// The particle or element at `place` [m] in the reference state, or nearest to it; `None` in an empty set.
pub(super) fn find(set: Set<'_>, on: On, place: &[f64]) -> Option<NearestEntry> {
    let place: [f64; 3] = std::array::from_fn(|i| place.get(i).copied().unwrap_or(0.0));
    match set {
        Set::Points(set) => {
            let (index, at) = nearest(&set.position, place)?;
            Some(NearestEntry { followed: Followed::Particle(set.id[index]), place: at })
        }
        Set::Surface(set) => {
            let (element, weights) = nearest_point(set, place)?;
            let nodes = set.elements[element].iter().map(|&n| n as usize);
            let at = nodes.clone().zip(&weights).map(|(n, w)| Vector(set.reference[n]) * *w).sum::<Vector<3>>().0;
            let point = nodes.zip(weights).filter(|(_, weight)| *weight != 0.0).collect();
            let followed = if on == On::Elements { Followed::Element(element) } else { Followed::Point(point) };
            Some(NearestEntry { followed, place: at })
        }
    }
}

/// The value at the followed particle or element; `None` if it is gone.
pub(super) fn follow(set: Set<'_>, followed: &Followed, quantity: &SetQuantity<'_>) -> Option<Vec<f64>> {
    let value = |index: usize| quantity.values.chunks_exact(quantity.components).nth(index).map(<[f64]>::to_vec);
    match (followed, set) {
        (Followed::Particle(id), Set::Points(set)) => value(set.id.iter().position(|other| other == id)?),
        (Followed::Element(index), Set::Surface(_)) => value(*index),
        (Followed::Point(nodes), Set::Surface(_)) => match nodes[..] {
            [(node, _)] => value(node),
            _ => nodes.iter().try_fold(vec![0.0; quantity.components], |mut sum, &(node, weight)| {
                sum.iter_mut().zip(value(node)?).for_each(|(sum, value)| *sum += weight * value);
                Some(sum)
            }),
        },
        _ => None,
    }
}

fn nearest(places: &[[f64; 3]], place: [f64; 3]) -> Option<(usize, [f64; 3])> {
    let distance = |x: &[f64; 3]| (Vector(*x) - Vector(place)).norm_squared();
    let places = places.iter().enumerate();
    places.min_by(|(_, a), (_, b)| distance(a).total_cmp(&distance(b))).map(|(index, x)| (index, *x))
}

/// The element that a place lies in, or whose point is nearest to it, and the shape functions there.
fn nearest_point(set: &SurfaceSet<'_>, place: [f64; 3]) -> Option<(usize, Vec<f64>)> {
    let mut best: Option<(f64, usize, Vec<f64>)> = None;
    for (element, nodes) in set.elements.iter().enumerate() {
        let corners: Vec<Vector<3>> = nodes.iter().map(|&n| Vector(set.reference[n as usize])).collect();
        if best.as_ref().is_some_and(|(least, ..)| around(&corners, place) >= *least) {
            continue;
        }
        let weights = match (corners.len(), set.kind) {
            (4, Elements::Sheet) => in_quadrilateral(&corners, Vector(place)),
            (8, Elements::Volume) => in_hexahedron(&corners, Vector(place)),
            _ => in_simplex(&corners, Vector(place)),
        };
        let distance = (blend(&corners, &weights) - Vector(place)).norm_squared();
        if best.as_ref().is_none_or(|(least, ..)| distance < *least) {
            best = Some((distance, element, at_node(&corners, weights, Vector(place))));
        }
    }
    best.map(|(_, element, weights)| (element, weights))
}

/// Square of the distance from the box around the corners [m²].
fn around(corners: &[Vector<3>], place: [f64; 3]) -> f64 {
    let beyond = |i: usize| {
        let low = corners.iter().map(|x| x[i]).fold(f64::INFINITY, f64::min);
        let high = corners.iter().map(|x| x[i]).fold(f64::NEG_INFINITY, f64::max);
        (low - place[i]).max(place[i] - high).max(0.0)
    };
    (0..3).map(|i| beyond(i).powi(2)).sum()
}

/// Rounding must not mix the values of a node with those of its neighbours.
fn at_node(corners: &[Vector<3>], weights: Vec<f64>, place: Vector<3>) -> Vec<f64> {
    let longest = corners.iter().flat_map(|a| corners.iter().map(move |b| (*a - *b).norm())).fold(0.0, f64::max);
    match corners.iter().position(|x| (*x - place).norm() <= AT_NODE * longest) {
        Some(node) => (0..corners.len()).map(|k| f64::from(u8::from(k == node))).collect(),
        None => weights,
    }
}
