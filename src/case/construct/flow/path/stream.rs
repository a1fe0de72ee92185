//! The strongest stream that solids may meet: from boundaries that move it, from its velocity at the start, from
//! pressures at openings, or from the fall of the fluids,
//!
//! ```text
//! U = max |v|,      U = √(2 Δp/ρ),      U = √(2 A/Σ m)
//! ```
//!
//! with the work A that gravity can do until the fluids lie in layers (Lorenz 1955). These two have the directions
//! along all axes, the last one that in which the mass goes, where it goes aside.

use super::{SolidSurroundings, extent};
use crate::case::construct::flow::fluids::velocity_at;
use crate::math::Vector;
use crate::pfem2::boundary::{BoundaryKind, Condition};

/// Times of a run at which conditions are taken.
const TIMES: usize = 32;

/// Part of the size of the mesh by which the mass must go aside as it falls, for the direction to be known.
const ASIDE: f64 = 0.02;

/// A stream.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct AmbientStream<const D: usize> {
    /// U [m/s].
    pub speed: f64,
    /// ρ of the heaviest fluid [kg/m³].
    pub density: f64,
    /// The directions that it may have.
    pub directions: Vec<Vector<D>>,
}

impl<const D: usize> AmbientStream<D> {
    /// ½ρU² [Pa].
    pub fn pressure(&self) -> f64 {
        0.5 * self.density * self.speed * self.speed
    }
}

/// The fastest stream; `None` where nothing moves the fluids.
pub(super) fn strongest<const D: usize, const N: usize>(around: &SolidSurroundings<D, N>) -> Option<AmbientStream<D>> {
    let density = around.fluids.iter().map(|fluid| fluid.density).fold(0.0, f64::max);
    let of = |speed: f64, directions: Vec<Vector<D>>| AmbientStream { speed, density, directions };
    let led = fastest(prescribed(around, |_| true).chain(initial(around)));
    let led = led.and_then(|v| Some(of(v.norm(), vec![v.normalized()?])));
    let pushed = of((2.0 * pressure_difference(around) / density).sqrt(), both_ways(|_| true));
    let all = led
        .into_iter()
        .chain([pushed, fall(around, density)])
        .filter(|stream| stream.speed.is_finite() && stream.speed > 0.0);
    all.max_by(|a, b| a.speed.total_cmp(&b.speed))
}

/// The largest speed with which fluid comes in through inlets until the end of a run [m/s].
pub(in crate::case::construct::flow) fn of_inlets<const D: usize, const N: usize>(
    around: &SolidSurroundings<D, N>,
) -> f64 {
    fastest(prescribed(around, BoundaryKind::prescribes_inflow)).map_or(0.0, |v| v.norm())
}

/// The speed of the stream that solids may meet but for the fall of fluids [m/s]. Pressures at openings drive none where
/// there is gravity: they bear the weight of the fluids.
pub(in crate::case::construct::flow) fn driven<const D: usize, const N: usize>(
    around: &SolidSurroundings<D, N>,
) -> f64 {
    let density = around.fluids.iter().map(|fluid| fluid.density).fold(0.0, f64::max);
    let weightless = times(around.file.time.end).all(|t| around.gravity(middle(around), t) == Vector::ZERO);
    let pressure = if weightless { pressure_difference(around) } else { 0.0 };
    let led = fastest(prescribed(around, |_| true).chain(initial(around))).map_or(0.0, |v| v.norm());
    Some(led.max((2.0 * pressure / density).sqrt())).filter(|speed| speed.is_finite()).unwrap_or(0.0)
}

fn both_ways<const D: usize>(along: impl Fn(usize) -> bool) -> Vec<Vector<D>> {
    (0..D).filter(|&axis| along(axis)).flat_map(|axis| [Vector::unit(axis), -Vector::unit(axis)]).collect()
}

fn middle<const D: usize, const N: usize>(around: &SolidSurroundings<D, N>) -> Vector<D> {
    around.mesh.nodes().iter().copied().sum::<Vector<D>>() / around.mesh.nodes().len() as f64
}

fn fastest<const D: usize>(all: impl Iterator<Item = Vector<D>>) -> Option<Vector<D>> {
    all.filter(|v| v.is_finite()).max_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared()))
}

/// Places of the boundary with their conditions.
fn boundary_places<'a, const D: usize, const N: usize>(
    around: &'a SolidSurroundings<D, N>,
) -> impl Iterator<Item = (&'a Condition<D>, Vector<D>)> {
    let places = |facet| around.mesh.facet_nodes(facet).into_iter().map(|node| around.mesh.nodes()[node as usize]);
    around
        .boundaries
        .iter()
        .flat_map(move |set| set.facets.iter().flat_map(move |&facet| places(facet).map(move |x| (&set.condition, x))))
}

fn times(end: f64) -> impl Iterator<Item = f64> {
    (0..=TIMES).map(move |k| end * k as f64 / TIMES as f64)
}

/// Velocities that boundaries of some kinds prescribe [m/s].
fn prescribed<const D: usize, const N: usize>(
    around: &SolidSurroundings<D, N>,
    by: impl Fn(BoundaryKind) -> bool,
) -> impl Iterator<Item = Vector<D>> {
    let end = around.file.time.end;
    let places = boundary_places(around).filter(move |(condition, _)| by(condition.kind()));
    places.flat_map(move |(condition, x)| times(end).filter_map(move |t| condition.velocity(x, t)))
}

/// Velocities of the fluids at the start [m/s].
fn initial<const D: usize, const N: usize>(around: &SolidSurroundings<D, N>) -> impl Iterator<Item = Vector<D>> {
    around.mesh.nodes().iter().map(|&x| velocity_at(around.bodies, x))
}

/// The largest difference of pressures at openings, at all times of the run [Pa].
fn pressure_difference<const D: usize, const N: usize>(around: &SolidSurroundings<D, N>) -> f64 {
    let end = around.file.time.end;
    let pressures = boundary_places(around)
        .flat_map(|(condition, x)| times(end).filter_map(move |t| condition.outside_pressure(x, t)));
    let none = [f64::INFINITY, f64::NEG_INFINITY];
    let [least, most] = pressures.fold(none, |[least, most], p| [least.min(p), most.max(p)]);
    (most - least).max(0.0)
}

/// The stream that the fluids make as they fall: with the speed that they have on average when all the work that
/// gravity can do has become motion, to where their mass goes.
fn fall<const D: usize, const N: usize>(around: &SolidSurroundings<D, N>, density: f64) -> AmbientStream<D> {
    let (mesh, gravity) = (around.mesh, around.gravity(middle(around), 0.0));
    let mut slots: Vec<(Vector<D>, f64)> =
        (0..mesh.elements().len()).map(|e| (mesh.center(e), mesh.simplex(e).volume)).collect();
    let potential = |x: Vector<D>| -gravity.dot(x);
    slots.sort_by(|a, b| potential(a.0).total_cmp(&potential(b.0)));
    let mut fluids: Vec<[f64; 2]> = slots.iter().map(|&(x, volume)| [around.density(x), volume]).collect();
    let mass: f64 = fluids.iter().map(|[density, volume]| density * volume).sum();
    let given: Vector<D> = slots.iter().zip(&fluids).map(|((x, _), [density, volume])| *x * (density * volume)).sum();
    fluids.sort_by(|a, b| b[0].total_cmp(&a[0]));
    let way = (layered(&slots, &fluids) - given) / mass;
    let speed = (2.0 * gravity.dot(way).max(0.0)).sqrt();
    let down = gravity.normalized();
    let level = down.map_or(way, |down| way - down * way.dot(down));
    let size = (0..D).map(|axis| extent(mesh.nodes(), axis)).map(|[a, b]| b - a).fold(0.0, f64::max);
    let directions = match level.normalized().filter(|_| level.norm() > ASIDE * size) {
        Some(e) => vec![e],
        None => both_ways(|axis| down.is_none_or(|down| down[axis].abs() < 0.5)),
    };
    AmbientStream { speed, density, directions }
}

/// Σ m x of volumes with densities in layers, the first lowest, in slots with a place and a volume, the lowest first
/// [kg m].
fn layered<const D: usize>(slots: &[(Vector<D>, f64)], fluids: &[[f64; 2]]) -> Vector<D> {
    let mut fluids = fluids.iter().copied();
    let (mut moment, mut current) = (Vector::ZERO, fluids.next());
    for &(x, mut room) in slots {
        while let Some([density, left]) = current {
            let taken = left.min(room);
            moment += x * (density * taken);
            room -= taken;
            current = if left > taken { Some([density, left - taken]) } else { fluids.next() };
            if room <= 0.0 {
                break;
            }
        }
    }
    moment
}
