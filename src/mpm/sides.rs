//! Whether bodies lie on one side of closed membranes at the start.
//!
//! The facets of a sphere lie inside of it: a gas that fills the sphere reaches beyond their middles, by R (1 − cos φ) for
//! facets of half the angle φ. Contact takes each particle's side from where it starts, so that these particles would be
//! outside for good.

use super::contact::locate::{Locator, Place};
use super::contact::sample::Facet;
use super::{BodySetup, MembraneSetup, Setup};
use crate::error::Diagnostic;

/// A warning for each body that begins on both sides of a closed membrane.
pub fn astray<const D: usize>(setup: &Setup<D>) -> Vec<Diagnostic> {
    let mut findings = Vec::new();
    for membrane in &setup.membranes {
        let facets: Vec<Facet> = membrane.elements.iter().map(|nodes| Facet::new(nodes)).collect();
        let mut locator = Locator::new(&facets);
        if !locator.is_closed() {
            continue;
        }
        locator.refresh(&facets, &membrane.position, setup.grid.cell);
        let finding = |(index, body)| warn((index, body), membrane, &facets, &locator, setup.grid.cell);
        findings.extend(setup.bodies.iter().enumerate().filter_map(finding));
    }
    findings
}

/// The warning about one body and one membrane.
fn warn<const D: usize>(
    (index, body): (usize, &BodySetup<D>),
    membrane: &MembraneSetup<D>,
    facets: &[Facet],
    locator: &Locator<D>,
    cell: f64,
) -> Option<Diagnostic> {
    let (mut inside, mut outside) = (0, 0);
    for &x in &body.position {
        match locator.place(facets, &membrane.position, cell, x) {
            Place::Beside(d) if d < 0.0 => inside += 1,
            Place::Beside(_) => outside += 1,
            Place::Beyond | Place::Away => {}
        }
    }
    let (fewer, side) = if inside < outside { (inside, "inside") } else { (outside, "outside") };
    let message = format!("{fewer} particles of `{}` begin {side} the closed membrane `{}`", body.name, membrane.name);
    let help = "the facets of a curved membrane cut across the curve: take a smaller region, or finer elements";
    (fewer > 0).then(|| Diagnostic::warning(format!("body[{index}].region"), message).help(help))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vector;

    /// A loop of six sides in a circle: what lies between a side and the circle is outside, whatever its sense.
    #[test]
    fn particles_between_facets_and_the_curve_are_outside() {
        let around = |angle: f64, radius: f64| Vector([radius * angle.cos(), radius * angle.sin()]);
        let corner = |k: u32| around(f64::from(k) * std::f64::consts::FRAC_PI_3, 1.0);
        let position: Vec<Vector<2>> = (0..6).map(corner).collect();
        let facets: Vec<Facet> = (0..6).map(|k| Facet::new(&[k, (k + 1) % 6])).collect();
        let mut locator = Locator::new(&facets);
        assert!(locator.is_closed() && !Locator::<2>::new(&facets[..5]).is_closed());
        locator.refresh(&facets, &position, 0.1);
        let middle = std::f64::consts::FRAC_PI_6;
        for (x, outside) in [(around(middle, 0.9), true), (around(middle, 0.84), false), (corner(1) * 0.95, false)] {
            let Place::Beside(d) = locator.place(&facets, &position, 0.1, x) else { panic!("{x:?} lies near") };
            assert_eq!(d > 0.0, outside, "{x:?}: {d}");
        }
    }
}
