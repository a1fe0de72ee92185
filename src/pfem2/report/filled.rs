//! The region that a fluid fills on the mesh, in pieces: whole elements, and of cut ones the simplices of its side
//! (theory G.7).
//!
//! Velocities are linear on a piece, so that sums over pieces of volume times the value at the centre are exact
//! integrals. A box cuts the pieces again, side by side. Of an element of more than two fluids each has its fraction
//! everywhere.

use crate::math::Vector;
use crate::pfem2::Pfem2;
use crate::pfem2::cut_element::{at_corners, inner, negative_side, volume_fraction};
use crate::pfem2::particles::interpolate;
use crate::pfem2::phases::Filling;
use crate::simulation::{Field, PointSet};
use std::borrow::Cow;

/// Lower and upper corner of a box [m]; infinite where it has no side.
pub type FluidBox = [[f64; 3]; 2];

/// A piece of a fluid.
struct FilledSimplex<const D: usize> {
    center: Vector<D>,
    velocity: Vector<D>,
    volume: f64,
}

/// The pieces of a fluid inside a box, as points with volumes and masses.
pub fn pieces<const D: usize, const N: usize>(
    pfem: &Pfem2<D, N>,
    fluid: usize,
    bounds: &FluidBox,
) -> PointSet<'static> {
    let elements = 0..pfem.system.mesh.elements().len();
    let pieces: Vec<FilledSimplex<D>> = elements.flat_map(|e| of_element(pfem, fluid, e, bounds)).collect();
    let density = pfem.interface.list.density()[fluid];
    let volumes: Vec<f64> = pieces.iter().map(|piece| piece.volume).collect();
    let masses: Vec<f64> = volumes.iter().map(|volume| density * volume).collect();
    let velocity: Vec<f64> = pieces.iter().flat_map(|piece| piece.velocity.to3()).collect();
    let count = pieces.len();
    PointSet {
        name: "",
        position: pieces.iter().map(|piece| piece.center.to3()).collect(),
        id: Cow::Owned((0..count as u32).collect()),
        fields: vec![
            Field::computed("velocity", "m/s", 3, move || velocity.clone()),
            Field::computed("volume", if D == 2 { "m^2" } else { "m^3" }, 1, move || volumes.clone()),
            Field::computed("mass", "kg", 1, move || masses.clone()),
            Field::computed("fluid", "", 1, move || vec![fluid as f64; count]),
        ],
        filled: None,
    }
}

/// The pieces of a fluid in an element.
fn of_element<const D: usize, const N: usize>(
    pfem: &Pfem2<D, N>,
    fluid: usize,
    e: usize,
    bounds: &FluidBox,
) -> Vec<FilledSimplex<D>> {
    let Some((parts, part)) = parts(pfem, fluid, e) else { return Vec::new() };
    let (mesh, x) = (&pfem.system.mesh, pfem.system.mesh.corners(e));
    let v = mesh.elements()[e].map(|node| pfem.system.velocity[node as usize]);
    let volume = part * mesh.simplex(e).volume;
    let piece = |corners: &[[f64; N]; N]| {
        let center = std::array::from_fn(|k| corners.iter().map(|corner| corner[k]).sum::<f64>() / N as f64);
        let (center, velocity) = (interpolate(&center, &x), interpolate(&center, &v));
        FilledSimplex { center, velocity, volume: volume * volume_fraction(corners) }
    };
    clipped(parts, &x, bounds).iter().map(piece).collect()
}

/// Simplices of an element that a fluid fills, by barycentric corners, and its fraction of them; none if it isn't
/// there.
fn parts<const D: usize, const N: usize>(
    pfem: &Pfem2<D, N>,
    fluid: usize,
    e: usize,
) -> Option<(Vec<[[f64; N]; N]>, f64)> {
    let simplices = || pfem.system.fluid_region().simplices(e);
    let negative = |level: [f64; N]| {
        let of = |corners: [[f64; N]; N]| {
            let own = negative_side(&at_corners(&corners, &level)).into_iter();
            own.map(move |part| inner(&corners, &part))
        };
        Some((simplices().into_iter().flat_map(of).collect(), 1.0))
    };
    match pfem.interface.phases().filling(&pfem.system.mesh.elements()[e]) {
        Filling::Pure(own) => (own == fluid).then(|| (simplices(), 1.0)),
        Filling::Mixed(fractions) => Some((simplices(), fractions[fluid])),
        Filling::Cut([heavy, _], level) if heavy == fluid => negative(level),
        Filling::Cut([_, light], level) if light == fluid => negative(level.map(|phi| -phi)),
        Filling::Cut(..) => None,
    }
}

/// The part inside a box of simplices in an element with corners at `x` [m].
fn clipped<const D: usize, const N: usize>(
    parts: Vec<[[f64; N]; N]>,
    x: &[Vector<D>; N],
    bounds: &FluidBox,
) -> Vec<[[f64; N]; N]> {
    let mut parts = parts;
    for axis in 0..D {
        for (bound, sign) in [(bounds[0][axis], -1.0), (bounds[1][axis], 1.0)] {
            if !bound.is_finite() || x.iter().all(|x| sign * (x[axis] - bound) <= 0.0) {
                continue;
            }
            parts = parts.iter().flat_map(|corners| below(corners, x, axis, bound, sign)).collect();
        }
    }
    parts
}

/// The part of a simplex where sign · (x − bound) is negative.
fn below<const D: usize, const N: usize>(
    corners: &[[f64; N]; N],
    x: &[Vector<D>; N],
    axis: usize,
    bound: f64,
    sign: f64,
) -> Vec<[[f64; N]; N]> {
    let level = corners.map(|corner| sign * (interpolate(&corner, x)[axis] - bound));
    negative_side(&level).iter().map(|own| inner(corners, own)).collect()
}
