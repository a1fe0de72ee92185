//! Warnings about bodies on both sides of a membrane at the start (theory D.13).
//!
//! The facets of a sphere lie inside of it: a gas that fills the sphere reaches beyond their middles, by R (1 − cos φ)
//! for facets of half the angle φ. A particle stays on the side where it starts, so that these would be outside for
//! good. A fluid that reaches farther to both sides of a closed membrane is meant to: it gets a velocity field on each
//! (`parts`).

use super::parts::Enclosure;
use crate::error::Diagnostic;
use crate::math::Vector;
use crate::mpm::contact::{FacetLocator, SheetFacet, SheetPosition};
use crate::mpm::{BodySetup, Friction, MembraneSetup, Setup};
use crate::parallel;

/// A fluid this near to an open membrane lies beside it [cells]: nodes between its two halves share what both bring.
const BESIDE: f64 = 1.0;

/// A warning for each body that a closed membrane cuts off a film next to it from, for each that keeps its shape and
/// that a membrane cuts through, and for each that flows and touches both sides of a membrane with free edges; as far
/// as the two have contact.
pub fn check_sides<const D: usize>(setup: &Setup<D>) -> Vec<Diagnostic> {
    let mut findings = Vec::new();
    for membrane in &setup.membranes {
        let facets: Vec<SheetFacet> = membrane.elements.iter().map(|nodes| SheetFacet::new(nodes)).collect();
        let mut locator = FacetLocator::new(&facets);
        locator.refresh(&facets, &membrane.position, setup.grid.cell);
        let sheet = SheetAtStart { membrane, facets, locator, cell: setup.grid.cell };
        let bodies = setup.bodies.iter().enumerate().filter(|(_, body)| meet(setup, body, &membrane.name));
        if sheet.locator.is_closed() {
            let enclosures = Enclosure::of(0, membrane.elements.iter().map(Vec::as_slice), &membrane.position);
            findings.extend(bodies.filter_map(|(index, body)| sheet.warn_of_both_sides(index, body, &enclosures)));
        } else {
            let warn = |(index, body)| sheet.warn_of_cut(index, body).or_else(|| sheet.warn_of_halves(index, body));
            findings.extend(bodies.filter_map(warn));
        }
    }
    findings
}

/// True if a body and a membrane have contact: friction that a case lists for one body of a group holds for all.
fn meet<const D: usize>(setup: &Setup<D>, body: &BodySetup<D>, membrane: &str) -> bool {
    let own = |name: &str| setup.bodies.iter().any(|other| other.group == body.group && other.name == name);
    let pair = |(a, b, _): &&(String, String, Friction)| (own(a) && b == membrane) || (a == membrane && own(b));
    setup.friction.iter().find(pair).map_or(setup.default_friction, |(.., friction)| *friction) != Friction::None
}

/// A membrane at the start.
struct SheetAtStart<'a, const D: usize> {
    membrane: &'a MembraneSetup<D>,
    facets: Vec<SheetFacet>,
    locator: FacetLocator<D>,
    cell: f64,
}

/// The particles beside a sheet on one of its sides.
#[derive(Clone, Copy)]
struct Beside {
    count: usize,
    /// Distance of the nearest from the sheet [m].
    nearest: f64,
}

impl<const D: usize> SheetAtStart<'_, D> {
    /// Particles among `particles` that lie beside the sheet, up to `reach` [m] from it: behind and in front.
    fn sides<'p>(&self, particles: impl Iterator<Item = &'p Vector<D>>, reach: f64) -> [Beside; 2] {
        let mut sides = [Beside { count: 0, nearest: f64::INFINITY }; 2];
        for &x in particles {
            match self.locator.locate(&self.facets, &self.membrane.position, self.cell, x) {
                SheetPosition::Beside(d) if d.abs() <= reach => {
                    let side = &mut sides[usize::from(d >= 0.0)];
                    *side = Beside { count: side.count + 1, nearest: side.nearest.min(d.abs()) };
                }
                _ => {}
            }
        }
        sides
    }

    /// The warning about a body on both sides of a closed membrane: a solid, or a fluid of which no more than a film
    /// next to the membrane is on one of them.
    fn warn_of_both_sides(&self, index: usize, body: &BodySetup<D>, all: &[Enclosure<D>]) -> Option<Diagnostic> {
        let within = |p: usize| all.iter().any(|enclosure| enclosure.holds(body.position[p]));
        let held: Vec<bool> = parallel::collect(body.position.len(), 256, within);
        let inside = held.iter().filter(|&&held| held).count();
        let outside = held.len() - inside;
        let (fewer, side) = if inside < outside { (inside, "inside") } else { (outside, "outside") };
        let spacing = body.volume.first()?.powf(1.0 / D as f64);
        let next_to = |x: &Vector<D>| match self.locator.locate(&self.facets, &self.membrane.position, self.cell, *x) {
            SheetPosition::Beside(d) => d.abs() <= spacing,
            SheetPosition::Beyond | SheetPosition::Away => false,
        };
        let mut few = body.position.iter().zip(&held).filter(|(_, held)| **held == (side == "inside"));
        if fewer == 0 || !(body.law.keeps_shape() || few.all(|(x, _)| next_to(x))) {
            return None;
        }
        let sheet = &self.membrane.name;
        let message = format!("{fewer} particles of `{}` begin {side} the closed membrane `{sheet}`", body.name);
        let help = "the facets of a curved membrane cut across the curve: take a smaller region, or finer elements";
        Some(Diagnostic::warning(format!("body[{index}].region"), message).help(help))
    }

    /// The warning about a body that keeps its shape with neighbours on both sides of an open membrane.
    fn warn_of_cut(&self, index: usize, body: &BodySetup<D>) -> Option<Diagnostic> {
        let spacing = body.volume.first()?.powf(1.0 / D as f64);
        if !body.law.keeps_shape() {
            return None;
        }
        let [behind, front] = self.sides(self.near(body, spacing), f64::INFINITY).map(|side| side.nearest);
        let sheet = &self.membrane.name;
        let message = format!("the membrane `{sheet}` cuts through `{}`: it has particles on both sides", body.name);
        let help = "they stay on their sides: move one of the two apart, they may touch";
        let cut = behind + front <= spacing * (1.0 + 1e-6);
        cut.then(|| Diagnostic::warning(format!("body[{index}].region"), message).help(help))
    }

    /// The warning about a body that flows and lies on both sides of an open membrane.
    fn warn_of_halves(&self, index: usize, body: &BodySetup<D>) -> Option<Diagnostic> {
        if body.law.keeps_shape() {
            return None;
        }
        let reach = BESIDE * self.cell;
        let [behind, front] = self.sides(self.near(body, reach), reach).map(|side| side.count);
        let message = format!(
            "`{}` lies on both sides of the membrane `{}`, which has free edges: within a cell of it are {behind} of its particles \
             behind and {front} in front",
            body.name, self.membrane.name
        );
        let help = "particles keep their sides, but a body has one velocity at each node, which both sides share next to the membrane and \
                    around its edges: make one body of each side where they don't meet";
        (behind > 0 && front > 0).then(|| Diagnostic::warning(format!("body[{index}].region"), message).help(help))
    }

    /// Particles in the box around the membrane, widened by `margin` [m].
    fn near<'b>(&self, body: &'b BodySetup<D>, margin: f64) -> impl Iterator<Item = &'b Vector<D>> {
        let bound = |a: usize, pick: fn(f64, f64) -> f64, start: f64| {
            self.membrane.position.iter().map(|x| x[a]).fold(start, pick)
        };
        let lower: [f64; D] = std::array::from_fn(|a| bound(a, f64::min, f64::INFINITY) - margin);
        let upper: [f64; D] = std::array::from_fn(|a| bound(a, f64::max, f64::NEG_INFINITY) + margin);
        body.position.iter().filter(move |x| (0..D).all(|a| (lower[a]..=upper[a]).contains(&x[a])))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A loop of six sides in a circle: what lies between a side and the circle is outside, whatever its sense.
    #[test]
    fn particles_between_facets_and_the_curve_are_outside() {
        let around = |angle: f64, radius: f64| Vector([radius * angle.cos(), radius * angle.sin()]);
        let corner = |k: u32| around(f64::from(k) * std::f64::consts::FRAC_PI_3, 1.0);
        let position: Vec<Vector<2>> = (0..6).map(corner).collect();
        let facets: Vec<SheetFacet> = (0..6).map(|k| SheetFacet::new(&[k, (k + 1) % 6])).collect();
        let mut locator = FacetLocator::new(&facets);
        assert!(locator.is_closed() && !FacetLocator::<2>::new(&facets[..5]).is_closed());
        locator.refresh(&facets, &position, 0.1);
        let middle = std::f64::consts::FRAC_PI_6;
        for (x, outside) in [(around(middle, 0.9), true), (around(middle, 0.84), false), (corner(1) * 0.95, false)] {
            let SheetPosition::Beside(d) = locator.locate(&facets, &position, 0.1, x) else {
                panic!("{x:?} lies near")
            };
            assert_eq!(d > 0.0, outside, "{x:?}: {d}");
        }
    }
}
