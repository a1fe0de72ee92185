//! Regions of closed membranes: a fluid that begins on both sides of one becomes a part on each (theory D.13).
//!
//! ```text
//! region of a particle   the closed surfaces with |w(x_p)| > ½ at the start, w the winding number
//! part of a body         its particles in one region, with a velocity field for these
//! side of a part         of each membrane: +1 where its normals point, −1 behind, for good
//! ```
//!
//! One velocity field on both sides drags streams along each other through the sheet, and a side that is told from the
//! place of a particle that comes near is wrong in folds. What the winding number says of the start is right for ever,
//! because nothing passes a membrane that it meets. Parts of a body have its name; outputs show them as one.
//!
//! A solid keeps its shape, and is not cut in two. Where it reaches through a membrane the places of its particles tell
//! their sides.

use crate::error::Diagnostic;
use crate::geometry::{FacetCorners, Winding};
use crate::math::Vector;
use crate::mesh::{ClosedSurface, closed_surfaces};
use crate::mpm::contact::FrictionTable;
use crate::mpm::membrane::Membrane;
use crate::mpm::particles::{Bodies, Body, Part, Particles};
use crate::mpm::{Friction, Load, Traction};
use crate::parallel;
use std::sync::Arc;

/// Volumes below this fraction of area times size are rounding: such a surface has no outside yet.
const FLAT: f64 = 1e-9;

/// Particles per parallel task.
const TASK: usize = 256;

/// A closed surface of a membrane.
#[derive(Debug)]
pub(in crate::mpm) struct Enclosure<const D: usize> {
    /// Index of the membrane.
    sheet: usize,
    winding: Winding<D>,
    /// +1 where normals point outwards, −1 where they point inwards, 0 where they do neither.
    outward: f64,
}

impl<const D: usize> Enclosure<D> {
    /// All that the membrane `sheet` with these elements has, its nodes at `position` [m].
    pub fn of<'a>(sheet: usize, elements: impl Iterator<Item = &'a [u32]>, position: &[Vector<D>]) -> Vec<Self> {
        let elements: Vec<&[u32]> = elements.collect();
        let close = |surface: ClosedSurface| {
            let own = surface.facets.iter().flat_map(|&(e, turned)| simplices(elements[e], position, turned));
            let winding = Winding::new(own.collect());
            let volume = winding.volume();
            let outward = if volume.abs() <= FLAT * winding.area() * winding.radius() || !surface.is_even() {
                0.0
            } else {
                volume.signum()
            };
            Self { sheet, winding, outward }
        };
        closed_surfaces(elements.iter().copied()).into_iter().map(close).collect()
    }

    /// True if it goes around `x` [m].
    pub fn holds(&self, x: Vector<D>) -> bool {
        self.winding.number(x).abs() > 0.5
    }
}

/// An element as segments or triangles; a quadrilateral is the fan of four triangles around its mean point.
fn simplices<const D: usize>(nodes: &[u32], position: &[Vector<D>], turned: bool) -> Vec<FacetCorners<D>> {
    let x = |k: usize| position[nodes[k % nodes.len()] as usize];
    let count = nodes.len();
    let mut simplices = match count {
        2 => vec![[x(0), x(1), x(1)]],
        3 => vec![[x(0), x(1), x(2)]],
        _ => {
            let middle = (0..count).map(x).sum::<Vector<D>>() / count as f64;
            (0..count).map(|k| [x(k), x(k + 1), middle]).collect()
        }
    };
    if turned {
        simplices.iter_mut().for_each(|simplex| simplex.swap(0, 1));
    }
    simplices
}

/// The piece of a body in one region.
#[derive(Debug, PartialEq)]
struct RegionPiece {
    /// The enclosures that hold it, ascending.
    within: Vec<u32>,
    /// The side of each membrane.
    sides: Vec<f64>,
    /// Indices of its particles, ascending.
    particles: Vec<u32>,
}

/// The closed surfaces of all membranes.
struct Regions<const D: usize> {
    enclosures: Vec<Enclosure<D>>,
    sheets: usize,
}

impl<const D: usize> Regions<D> {
    /// Distributes the particles of a body at `position` [m] between regions, in the order of its particles. Only
    /// membranes that it `meets` count. One that is not to be `divided` is one piece, with no side of a membrane that
    /// it reaches through.
    fn distribute(&self, position: &[Vector<D>], meets: &[bool], divided: bool) -> Vec<RegionPiece> {
        let met = || (0..).zip(&self.enclosures).filter(|(_, enclosure)| meets[enclosure.sheet]);
        let region = |p: usize| met().filter(|(_, e)| e.holds(position[p])).map(|(n, _)| n).collect();
        let regions: Vec<Vec<u32>> = parallel::collect(position.len(), TASK, region);
        let mut pieces: Vec<RegionPiece> = Vec::new();
        for (p, within) in (0..).zip(regions) {
            match pieces.iter_mut().find(|piece| piece.within == within) {
                Some(piece) => piece.particles.push(p),
                None => pieces.push(RegionPiece { within, sides: Vec::new(), particles: vec![p] }),
            }
        }
        if divided || pieces.len() < 2 {
            for piece in &mut pieces {
                piece.sides = self.sides(meets, &[&piece.within]);
            }
            return pieces;
        }
        let all: Vec<&[u32]> = pieces.iter().map(|piece| &piece.within[..]).collect();
        let common = all[0].iter().copied().filter(|n| all.iter().all(|within| within.contains(n)));
        let (within, sides) = (common.collect(), self.sides(meets, &all));
        vec![RegionPiece { within, sides, particles: (0..position.len() as u32).collect() }]
    }

    /// The side of each membrane that particles in all these regions are on; 0 where they aren't on one.
    fn sides(&self, meets: &[bool], regions: &[impl AsRef<[u32]>]) -> Vec<f64> {
        let mut found: Vec<Option<f64>> = vec![None; self.sheets];
        for (n, enclosure) in (0..).zip(&self.enclosures).filter(|(_, enclosure)| meets[enclosure.sheet]) {
            for region in regions {
                let side = if region.as_ref().contains(&n) { -enclosure.outward } else { enclosure.outward };
                let known = found[enclosure.sheet].get_or_insert(side);
                if *known != side {
                    *known = 0.0;
                }
            }
        }
        found.into_iter().map(Option::unwrap_or_default).collect()
    }
}

/// Divides bodies by the regions of closed membranes, where these are at the start, and numbers the velocity fields
/// anew: bodies that shared one still do in each region.
///
/// # Errors
/// A body with a pressure on its surface that a membrane cuts through.
pub(in crate::mpm) fn divide<const D: usize>(
    bodies: Bodies<D>,
    membranes: &[Membrane<D>],
    friction: &FrictionTable,
) -> Result<Bodies<D>, Vec<Diagnostic>> {
    let all = (0..).zip(membranes);
    let all = all.flat_map(|(sheet, m)| Enclosure::of(sheet, m.elements.iter(), &m.position));
    let regions = Regions { enclosures: all.collect(), sheets: membranes.len() };
    if regions.enclosures.is_empty() {
        return Ok(bodies);
    }
    let meets = |field: usize| -> Vec<bool> {
        let names = bodies.names(field);
        let met = |m: &Membrane<D>| friction.between(&names, std::slice::from_ref(&m.name)) != Friction::None;
        membranes.iter().map(met).collect()
    };
    let met: Vec<Vec<bool>> = (0..bodies.field_count()).map(meets).collect();
    let (mut parts, mut findings, mut fields) = (Vec::new(), Vec::new(), Vec::new());
    for (index, (group, body)) in bodies.into_pairs().enumerate() {
        let divided = !body.law.keeps_shape() && body.skin.is_empty();
        let pieces = regions.distribute(&body.particles.position, &met[group], divided);
        let numbers: Vec<usize> = pieces.iter().map(|piece| field_number(&mut fields, group, &piece.within)).collect();
        match part(body, pieces, &numbers) {
            Ok(own) => parts.extend(own),
            Err(message) => findings.push(Diagnostic::error(format!("body[{index}].traction"), message).help(
                "give what is inside of the membrane and what is outside as two bodies, each with its tractions",
            )),
        }
    }
    if findings.is_empty() { Ok(Bodies::new(parts)) } else { Err(findings) }
}

/// The number of a velocity field: that of a group in a region, in the order in which they appear.
fn field_number(fields: &mut Vec<(usize, Vec<u32>)>, group: usize, within: &[u32]) -> usize {
    let known = fields.iter().position(|(other, region)| *other == group && region == within);
    known.unwrap_or_else(|| {
        fields.push((group, within.to_vec()));
        fields.len() - 1
    })
}

/// The parts of a body, one per piece, each with the number of its velocity field.
fn part<const D: usize>(
    mut body: Body<D>,
    pieces: Vec<RegionPiece>,
    fields: &[usize],
) -> Result<Vec<(usize, Body<D>)>, String> {
    let whole = pieces.len() < 2;
    let (mut parts, mut before) = (Vec::new(), 0);
    for (number, (piece, &field)) in pieces.into_iter().zip(fields).enumerate() {
        let count = piece.particles.len() as u32;
        let part = Part { number, before, sides: piece.sides };
        if whole {
            body.part = part;
            return Ok(vec![(field, body)]);
        }
        parts.push((field, cut(&body, &piece.particles, part)?));
        before += count;
    }
    Ok(parts)
}

/// The part of a body, before its first step, that has these of its particles; they are numbered anew.
fn cut<const D: usize>(body: &Body<D>, own: &[u32], part: Part) -> Result<Body<D>, String> {
    let mut particles: Particles<D> = body.particles.clone();
    particles.permute(own);
    let mut number: Vec<Option<u32>> = vec![None; body.particles.len()];
    for (new, &old) in (0..).zip(&particles.id) {
        number[old as usize] = Some(new);
    }
    let depth = if body.depth.is_empty() { &[][..] } else { &particles.id[..] };
    let depth = depth.iter().map(|&id| body.depth[id as usize]).collect();
    let traction = body.traction.iter().filter(|traction| number[traction.particle as usize].is_some());
    let traction = traction.map(|traction| renumbered(traction, &number)).collect::<Option<Vec<_>>>();
    let traction = traction.ok_or_else(|| {
        format!("the surface of `{}` that bears a pressure reaches through a closed membrane", body.name)
    })?;
    particles.id = (0..own.len() as u32).collect();
    let own = Body::new(body.name.clone(), Arc::clone(&body.law), body.kernel, particles);
    Ok(Body { part, depth, traction, ambient: body.ambient, ..own })
}

/// A load with new identities; `None` if a neighbour that its area is spanned by is in another part.
fn renumbered(traction: &Traction, number: &[Option<u32>]) -> Option<Traction> {
    let new = |id: u32| number[id as usize];
    let load = match &traction.load {
        Load::Dead { value, area } => Load::Dead { value: value.clone(), area: *area },
        Load::Pressure { value, span, fraction } => {
            let span = span.iter().map(|&[a, b]| Some([new(a)?, new(b)?])).collect::<Option<_>>()?;
            Load::Pressure { value: value.clone(), span, fraction: *fraction }
        }
    };
    Some(Traction { particle: new(traction.particle)?, load })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Elements and places of nodes.
    type Chain = (Vec<Vec<u32>>, Vec<Vector<2>>);

    /// The segments of a loop through nodes `first`, …, `first` + `count` − 1, back to the first.
    fn ring(first: u32, count: u32) -> Vec<Vec<u32>> {
        (0..count).map(|k| vec![first + k, first + (k + 1) % count]).collect()
    }

    fn regions(sheets: &[Chain]) -> Regions<2> {
        let of = |(sheet, (elements, position)): (usize, &Chain)| {
            Enclosure::of(sheet, elements.iter().map(Vec::as_slice), position)
        };
        Regions { enclosures: sheets.iter().enumerate().flat_map(of).collect(), sheets: sheets.len() }
    }

    fn square(lower: f64, upper: f64) -> Vec<Vector<2>> {
        [[lower, lower], [upper, lower], [upper, upper], [lower, upper]].map(Vector).to_vec()
    }

    /// The inside is the + side where normals point inwards; where they are mixed, only places tell.
    #[test]
    fn sides_follow_the_normals_and_regions_do_not() {
        let places = [Vector([0.5, 0.5]), Vector([1.5, 0.5]), Vector([0.9, 0.1])];
        let inwards: Vec<Vec<u32>> = ring(0, 4).into_iter().map(|nodes| vec![nodes[1], nodes[0]]).collect();
        let mut mixed = ring(0, 4);
        mixed[2].reverse();
        for (elements, inside) in [(ring(0, 4), -1.0), (inwards, 1.0), (mixed, 0.0)] {
            let pieces = regions(&[(elements, square(0.0, 1.0))]).distribute(&places, &[true], true);
            let expected = [
                RegionPiece { within: vec![0], sides: vec![inside], particles: vec![0, 2] },
                RegionPiece { within: vec![], sides: vec![-inside], particles: vec![1] },
            ];
            assert_eq!(pieces, expected);
        }
    }

    /// The slot of a horseshoe is outside of it, though the closest segments of both of its sides look into it.
    #[test]
    fn the_slot_of_a_folded_loop_is_outside() {
        let shoe = [[0.0, 0.0], [1.0, 0.0], [1.0, 2.0], [0.55, 2.0], [0.55, 0.5], [0.45, 0.5], [0.45, 2.0], [0.0, 2.0]];
        let regions = regions(&[(ring(0, 8), shoe.map(Vector).to_vec())]);
        let places = [[0.5, 1.9], [0.44, 1.9], [0.5, 0.51], [0.5, 0.49], [0.56, 1.0]].map(Vector);
        let pieces = regions.distribute(&places, &[true], true);
        let found: Vec<_> = pieces.iter().map(|piece| (&piece.particles[..], piece.sides[0])).collect();
        assert_eq!(found, [(&[0, 2][..], 1.0), (&[1, 3, 4][..], -1.0)]);
    }

    /// A loop within another one: three regions, with sides of their own of both; through one that is not met the
    /// body passes.
    #[test]
    fn nested_loops_divide_a_body_into_regions() {
        let sheets = [(ring(0, 4), square(0.0, 3.0)), (ring(0, 4), square(1.0, 2.0))];
        let places = [0.5, 1.5, 4.0].map(Vector::splat);
        let pieces = |meets: [bool; 2]| -> Vec<(Vec<u32>, Vec<f64>)> {
            let pieces = regions(&sheets).distribute(&places, &meets, true);
            pieces.into_iter().map(|piece| (piece.particles, piece.sides)).collect()
        };
        let apart = [(vec![0], vec![-1.0, 1.0]), (vec![1], vec![-1.0, -1.0]), (vec![2], vec![1.0, 1.0])];
        assert_eq!(pieces([true, true]), apart);
        assert_eq!(pieces([true, false]), [(vec![0, 1], vec![-1.0, 0.0]), (vec![2], vec![1.0, 0.0])]);
    }

    /// Two loops of one membrane: its sides differ for what is inside of one, and for a solid that reaches through.
    #[test]
    fn a_body_on_both_sides_of_a_membrane_has_no_side() {
        let mut elements = ring(0, 4);
        elements.extend(ring(4, 4));
        let both: Vec<_> = [square(0.0, 1.0), square(2.0, 3.0)].concat();
        let pieces = regions(&[(elements, both)]).distribute(&[0.5, 2.5, 1.5].map(Vector::splat), &[true], true);
        let found: Vec<_> = pieces.iter().map(|piece| (&piece.within[..], piece.sides[0])).collect();
        assert_eq!(found, [(&[0][..], 0.0), (&[1][..], 0.0), (&[][..], 1.0)]);
        let one = regions(&[(ring(0, 4), square(0.0, 1.0))]);
        let solid = one.distribute(&[0.5, 1.5].map(Vector::splat), &[true], false);
        assert_eq!(solid, [RegionPiece { within: vec![], sides: vec![0.0], particles: vec![0, 1] }]);
        let inside = one.distribute(&[0.5, 0.6].map(Vector::splat), &[true], false);
        assert_eq!(inside, [RegionPiece { within: vec![0], sides: vec![-1.0], particles: vec![0, 1] }]);
    }

    /// A bag that is exactly flat has no outside yet.
    #[test]
    fn a_flat_bag_has_no_sides() {
        let flat = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [1.0, 0.0]].map(Vector).to_vec();
        let pieces = regions(&[(ring(0, 4), flat)]).distribute(&[Vector([1.0, 0.3])], &[true], true);
        assert_eq!(pieces, [RegionPiece { within: vec![], sides: vec![0.0], particles: vec![0] }]);
    }
}
