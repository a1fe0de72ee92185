//! Triangles in a plane region: nodes along the outline, a hexagonal lattice thinned to the wanted size
//! inside, evened out by springs, and the Delaunay triangulation that keeps the outline.

use super::boundary::BoundaryPoints;
use super::relax::{Site, relax, sites};
use super::size::{SizeField, too_many};
use crate::geometry::Region;
use crate::math::Vector;
use crate::mesh::Mesh;
use spade::{ConstrainedDelaunayTriangulation, Triangulation};
use std::collections::BTreeMap;

/// Most places of the lattice that is thinned.
const MOST_LATTICE_PLACES: f64 = 2e8;

/// Triangles of a bounded region that follow `size`.
///
/// # Errors
/// An outline that touches itself, no room for an element; [`bounded`] finds a size too small for the region.
pub fn triangulate(region: &Region, size: &SizeField) -> Result<Mesh<2, 3>, String> {
    let boundary = BoundaryPoints::of(region, size)?;
    let fixed = boundary.nodes.len();
    let mut points = boundary.nodes;
    points.extend(seeds(region, size)?);
    relax(&mut points, fixed, region, size)?;
    let mut elements = connect(&points, &boundary.segments, region)?;
    turn_corners(&points, &mut elements, fixed);
    number_along(&mut points, &mut elements);
    Mesh::new(points, elements)
}

/// The domain must not be too large for its sizes: neither the lattice at the finest, nor the elements that are kept.
///
/// # Errors
/// It is; nothing has been stored yet.
pub fn bounded(region: &Region, size: &SizeField) -> Result<(), String> {
    const SAMPLES: usize = 256;
    let (bounds, finest) = (region.bounds(), size.finest());
    let extent = [0, 1].map(|i| bounds.upper[i] - bounds.lower[i]);
    if extent[0] / finest * (extent[1] / finest) > MOST_LATTICE_PLACES {
        return Err(format!("a size of {finest} m is too small for this domain"));
    }
    // An equilateral triangle has the area √3/4 h².
    let step = extent.map(|length| length / SAMPLES as f64);
    let place = |i: usize, j: usize| {
        [bounds.lower[0] + (i as f64 + 0.5) * step[0], bounds.lower[1] + (j as f64 + 0.5) * step[1], 0.0]
    };
    let inside = (0..SAMPLES * SAMPLES).map(|n| place(n % SAMPLES, n / SAMPLES)).filter(|&x| region.contains(x));
    let count = inside.map(|x| step[0] * step[1] / (0.75f64.sqrt() / 2.0 * size.at(x).powi(2))).sum();
    too_many(count).map_or(Ok(()), Err)
}

/// Places of a row of the lattice that are judged by one bound of the size, before each by its own.
const STRETCH: u64 = 32;

/// A hexagonal lattice at the finest size, each place kept with the probability (finest/h)².
fn seeds(region: &Region, size: &SizeField) -> Result<Vec<Vector<2>>, String> {
    let (bounds, finest) = (region.bounds(), size.finest());
    let row = finest * 0.75f64.sqrt();
    let count = [0, 1].map(|i| (bounds.upper[i] - bounds.lower[i]) / [finest, row][i]);
    let mut seeds = Vec::new();
    for j in 0..count[1].ceil() as u64 {
        let shift = if j % 2 == 0 { 0.25 } else { 0.75 };
        let place =
            |i: f64| [bounds.lower[0] + (i + shift - 0.5) * finest, bounds.lower[1] + (j as f64 + 0.5) * row, 0.0];
        let mut most = 1.0;
        for i in 0..=count[0].ceil() as u64 {
            if i % STRETCH == 0 {
                let half = 0.5 * STRETCH as f64;
                most = (finest / size.least(place(i as f64 + half), half * finest)).powi(2);
            }
            if chance(i, j) >= most {
                continue;
            }
            let x = place(i as f64);
            let h = size.at(x);
            if chance(i, j) < (finest / h).powi(2) && region.signed_distance(x) < -0.6 * h {
                seeds.push(Vector([x[0], x[1]]));
            }
        }
    }
    Ok(seeds)
}

/// A number in 0..1 that looks random but belongs to the place (SplitMix64).
fn chance(i: u64, j: u64) -> f64 {
    let mut z = i.wrapping_mul(0x9E37_79B9_7F4A_7C15).wrapping_add(j.wrapping_mul(0xD1B5_4A32_D192_ED03));
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
}

/// A triangle of nodes on one straight side has this part of the square of its longest edge as area at most, from
/// rounding.
const FLAT: f64 = 1e-9;

/// The triangles inside the region, counter-clockwise.
fn connect(points: &[Vector<2>], segments: &[[u32; 2]], region: &Region) -> Result<Vec<[u32; 3]>, String> {
    let edges = segments.iter().map(|s| s.map(|n| n as usize)).collect();
    let triangulation: ConstrainedDelaunayTriangulation<Site> =
        ConstrainedDelaunayTriangulation::bulk_load_cdt(sites(points), edges).map_err(|why| why.to_string())?;
    let mut elements: Vec<[u32; 3]> = triangulation
        .inner_faces()
        .map(|face| face.vertices().map(|vertex| vertex.data().index))
        .filter(|element| {
            let center = element.iter().map(|&n| points[n as usize]).sum::<Vector<2>>() / 3.0;
            region.contains(center.to3()) && !is_flat(element.map(|n| points[n as usize]))
        })
        .collect();
    if elements.is_empty() {
        return Err("the domain is too small for one element of the wanted size".into());
    }
    elements.sort_unstable();
    Ok(elements)
}

fn is_flat([a, b, c]: [Vector<2>; 3]) -> bool {
    let (u, v, w) = (b - a, c - a, c - b);
    u[0] * v[1] - u[1] * v[0] <= FLAT * u.norm_squared().max(v.norm_squared()).max(w.norm_squared())
}

/// An element with all nodes on the boundary could not move there: the side that it shares is turned.
fn turn_corners(points: &[Vector<2>], elements: &mut [[u32; 3]], fixed: usize) {
    let mut behind: BTreeMap<[u32; 2], usize> = BTreeMap::new();
    for (e, &[a, b, c]) in elements.iter().enumerate() {
        [[a, b], [b, c], [c, a]].into_iter().for_each(|side| {
            behind.insert(side, e);
        });
    }
    let area = |[a, b, c]: [u32; 3]| {
        let (u, v) = (points[b as usize] - points[a as usize], points[c as usize] - points[a as usize]);
        u[0] * v[1] - u[1] * v[0]
    };
    for e in 0..elements.len() {
        let element = elements[e];
        let inner: Vec<usize> = (0..3).filter(|&k| behind.contains_key(&[element[(k + 1) % 3], element[k]])).collect();
        let (&[k], true) = (inner.as_slice(), element.iter().all(|&n| (n as usize) < fixed)) else { continue };
        let [a, b, c] = std::array::from_fn(|i| element[(k + i) % 3]);
        let other = behind[&[b, a]];
        let Some(&d) = elements[other].iter().find(|&&n| n != a && n != b) else { continue };
        let turned = [[c, a, d], [c, d, b]];
        if d as usize >= fixed && turned.iter().all(|&t| area(t) > 0.2 * area(element)) {
            (elements[e], elements[other]) = (turned[0], turned[1]);
            for (side, owner) in
                [([c, a], e), ([a, d], e), ([d, c], e), ([c, d], other), ([d, b], other), ([b, c], other)]
            {
                behind.insert(side, owner);
            }
            behind.remove(&[a, b]);
            behind.remove(&[b, a]);
        }
    }
}

/// Numbers nodes and elements along a curve that fills the plane, so that neighbours lie together in memory.
fn number_along(points: &mut Vec<Vector<2>>, elements: &mut [[u32; 3]]) {
    let lower = points.iter().fold([f64::INFINITY; 2], |l, x| [l[0].min(x[0]), l[1].min(x[1])]);
    let upper = points.iter().fold([f64::NEG_INFINITY; 2], |u, x| [u[0].max(x[0]), u[1].max(x[1])]);
    let extent = (upper[0] - lower[0]).max(upper[1] - lower[1]);
    let place = |x: Vector<2>| {
        let [i, j] = [0, 1].map(|k| ((x[k] - lower[k]) / extent * 65535.0) as u64);
        (0..16).fold(0u64, |code, bit| code | ((i >> bit) & 1) << (2 * bit) | ((j >> bit) & 1) << (2 * bit + 1))
    };
    let mut order: Vec<u32> = (0..points.len() as u32).collect();
    order.sort_by_key(|&n| (place(points[n as usize]), n));
    let mut new = vec![0u32; points.len()];
    order.iter().enumerate().for_each(|(place, &n)| new[n as usize] = place as u32);
    *points = order.iter().map(|&n| points[n as usize]).collect();
    elements.iter_mut().for_each(|element| *element = element.map(|n| new[n as usize]));
    elements.sort_by_key(|element| place(element.iter().map(|&n| points[n as usize]).sum::<Vector<2>>() / 3.0));
}
