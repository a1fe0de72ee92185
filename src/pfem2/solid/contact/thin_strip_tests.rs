//! Contact of a thin strip with itself: layers that come near to each other, never its two sides.

use super::between_solids::{SearchContext, SolidContacts};
use super::force::ContactCandidate;
use super::places::ContactPlaces;
use crate::material::{Elastic, StVenantKirchhoff};
use crate::math::Vector;
use crate::mesh::Mesh;
use crate::pfem2::solid::mesh::SolidMesh;
use crate::pfem2::solid::setup::SolidSetup;
use crate::pfem2::solid::structure::Structure;
use crate::pfem2::solid::surface::SolidSurface;
use std::f64::consts::TAU;

/// Thickness and length of the strip, and size of the elements of the fluid's mesh [m].
const THICKNESS: f64 = 0.02;
const LENGTH: f64 = 1.8;
const SIZE: f64 = 0.1;

/// The candidates of the strip with its middle line at `place(s)`, with a unit vector across; so many elements along it.
fn candidates(elements: usize, place: impl Fn(f64) -> (Vector<2>, Vector<2>)) -> Vec<ContactCandidate<2>> {
    let half = Vector([0.5 * LENGTH, 0.5 * THICKNESS]);
    let blocks = SolidMesh::block(-half, half, [elements, 2]).unwrap();
    let law = Box::new(StVenantKirchhoff { elastic: Elastic::new(1000.0, 1e6, 0.3) });
    let structure = Structure::new(vec![SolidSetup::free("strip", blocks, law)]).unwrap();
    let mesh = Mesh::<2, 3>::block(Vector([-1.0; 2]), Vector([1.0; 2]), [(2.0 / SIZE) as usize; 2]).unwrap();
    let contacts = SolidContacts::new(&structure, &mesh);
    let bent = |x: &Vector<2>| {
        let (middle, across) = place(x[0] + half[0]);
        middle + across * x[1]
    };
    let predicted: Vec<Vector<2>> = structure.nodes.iter().map(bent).collect();
    let surface = SolidSurface::new(&structure.meshes(), &predicted);
    let places = ContactPlaces { start: &predicted, predicted: &predicted, surface: &surface };
    contacts.candidates(&SearchContext { structure: &structure, mesh: &mesh, places }).unwrap()
}

/// The place at the angle φ on a spiral that goes outward by `pitch` [m] per turn, and the unit vector inward.
fn spiral(start: f64, pitch: f64, angle: f64) -> (Vector<2>, Vector<2>) {
    let outward = Vector([angle.cos(), angle.sin()]);
    (outward * (start + pitch * angle / TAU), -outward)
}

/// Layers of a roll meet at the distance that is between them, half of the nodes on each of two sides; none meets
/// through the strip, which is as thick as they are apart and a fifth of an element.
#[test]
fn layers_of_a_roll_meet_each_other_and_not_through_the_strip() {
    let (inner, pitch) = (0.12, 2.0 * THICKNESS);
    // s = ∫ r dφ, short of the slope of the spiral.
    let angle = |s: f64| {
        let slope = pitch / TAU;
        (-inner + (inner * inner + 2.0 * slope * s).sqrt()) / slope
    };
    assert!(angle(LENGTH) > 1.7 * TAU, "{}", angle(LENGTH) / TAU);
    for elements in [45, 90, 180] {
        let found = candidates(elements, |s| spiral(inner, pitch, angle(s)));
        let gap = pitch - THICKNESS;
        // Beyond the outer end nodes see its corner, farther away.
        let across = found.iter().filter(|candidate| (candidate.distance / gap - 1.0).abs() < 0.1);
        assert!(across.count() > elements, "{elements}: {}", found.len());
        let nearest = found.iter().min_by(|a, b| a.distance.total_cmp(&b.distance)).unwrap();
        assert!(nearest.distance > 0.9 * gap, "{elements}: {nearest:?}");
    }
}

/// Nothing of a strip that is straight, shaken by what rounding takes, or bent to three quarters of a ring meets.
#[test]
fn a_strip_does_not_meet_its_other_side() {
    let radius = LENGTH / (0.75 * TAU);
    for elements in [28, 45, 90, 180] {
        for noise in [0.0, 1e-15, 1e-12, 1e-6] {
            let shaken = |s: f64| {
                let by = noise * (1e3 * s).sin();
                (Vector([s - 0.5 * LENGTH + by, by]), Vector([noise, 1.0]))
            };
            let found = candidates(elements, shaken);
            assert!(found.is_empty(), "{elements}, {noise:e}: {} {:?}", found.len(), found[0]);
        }
        let found = candidates(elements, |s| spiral(radius, 0.0, s / radius));
        assert!(found.is_empty(), "{elements}: {} {:?}", found.len(), found[0]);
    }
}
