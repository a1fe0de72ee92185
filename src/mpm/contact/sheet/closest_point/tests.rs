//! The foot of a point on a sheet, against a search through all facets, the projection on a plane, and a ball.

use super::*;

fn foot<const D: usize>(facets: &[SheetFacet], position: &[Vector<D>], x: Vector<D>) -> Option<Foot<D>> {
    let mut nearest = Nearest::new(facets, position.len());
    nearest.refresh(facets, position, 0.6, 0.3);
    nearest.foot(facets, x, 0.6)
}

/// A loop that runs counter-clockwise: outside is positive, also across its corners.
#[test]
fn the_side_of_a_loop_is_right_around_its_corners() {
    let position = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(Vector);
    let facets: Vec<_> = (0..4).map(|k| SheetFacet::new(&[k, (k + 1) % 4])).collect();
    for (x, expected) in
        [([0.9, 0.8], -0.1), ([1.1, 0.5], 0.1), ([1.03, 1.04], 0.05), ([0.97, 0.99], -0.01), ([-0.3, -0.4], 0.5)]
    {
        let found = foot(&facets, &position, Vector(x)).unwrap();
        assert!((found.distance - expected).abs() < 1e-12, "{x:?}: {found:?}");
    }
    assert!(foot(&facets, &position, Vector([9.0, 9.0])).is_none());
}

/// On a crumpled sheet the foot is that of a search through all facets, at the positions of the refresh and at
/// others.
#[test]
fn bounds_leave_out_no_closest_point() {
    let wave = |t: f64| {
        move |k: u32| {
            let (x, y) = (0.1 * f64::from(k % 12), 0.1 * f64::from(k / 12));
            Vector([x, y, 0.1 * (17.0 * x + t).sin() * (23.0 * y - t).cos()])
        }
    };
    let [now, then] = [0.0, 0.3].map(|t| (0..144).map(wave(t)).collect::<Vec<_>>());
    let corner = |k: &u32| k % 12 < 11;
    let facets: Vec<_> = (0..132)
        .filter(corner)
        .map(|k| SheetFacet::new(&[k, k + 1, k + 13, k + 12]))
        .chain([SheetFacet::new(&[0, 1, 12])])
        .collect();
    let mut nearest = Nearest::new(&facets, now.len());
    nearest.refresh(&facets, &now, 0.2, 0.2);
    for n in 0..500 {
        let part = |m: u32| f64::from(n * m % 499) / 499.0;
        let x = Vector([1.3 * part(7) - 0.1, 1.3 * part(31) - 0.1, 0.5 * part(101) - 0.25]);
        for (position, found) in
            [(&now, nearest.foot(&facets, x, 0.2)), (&then, nearest.foot_at(&facets, &then, x, 0.2))]
        {
            let mut best = ClosestSoFar { square: 0.04, facet: u32::MAX, weights: [0.0; 4], point: Vector::ZERO };
            (0..).zip(&facets).for_each(|(e, facet)| best.compare(e, facet.count, facet.corners(position), x));
            let expected = (best.facet != u32::MAX).then_some((best.facet, best.weights));
            assert_eq!(found.map(|foot| (foot.facet, foot.weights)), expected, "{x:?}");
        }
    }
}

/// On a tilted plane the foot is the orthogonal projection, whatever the elements.
#[test]
fn the_foot_on_a_plane_is_the_projection() {
    let plane = |x: f64, y: f64| Vector([x, y, 0.3 * x - 0.2 * y]);
    let position: Vec<_> = (0..9).map(|k| plane(f64::from(k % 3), f64::from(k / 3))).collect();
    let quad = |k: u32| [k, k + 1, k + 4, k + 3];
    let mut facets: Vec<_> = [0, 1, 3].map(|k| SheetFacet::new(&quad(k))).to_vec();
    facets.extend([SheetFacet::new(&[4, 5, 8]), SheetFacet::new(&[4, 8, 7])]);
    let normal = Vector([-0.3, 0.2, 1.0]).normalized().unwrap();
    for (x, y, d) in [(0.4, 0.3, 0.2), (1.7, 1.1, -0.3), (1.2, 1.9, 0.1), (0.8, 1.5, -1e-3), (0.1, 1.2, 1e-9)] {
        let found = foot(&facets, &position, plane(x, y) + normal * d).unwrap();
        assert!((found.distance - d).abs() < 1e-12 && (found.normal - normal).norm() < 1e-6, "{found:?}");
        let corners = facets[found.facet as usize].corners(&position);
        let point: Vector<3> = corners.iter().zip(found.weights).map(|(&c, w)| c * w).sum();
        assert!((point - plane(x, y)).norm() < 1e-12 && !found.beyond);
    }
    assert!(foot(&facets, &position, plane(-0.3, 1.0)).unwrap().beyond);
}

/// Quadrilaterals with their nodes on a sphere: the curved surface is the sphere, to a twentieth of what the
/// facets are off.
#[test]
fn the_curved_surface_of_a_ball_is_a_ball() {
    let (n, h, r) = (9_u32, 0.1, 1.0_f64);
    let at = |i: u32| h * (f64::from(i) - 4.0);
    let on_ball = |x: f64, y: f64| Vector([x, y, -(r * r - x * x - y * y).sqrt()]);
    let position: Vec<_> = (0..n * n).map(|k| on_ball(at(k % n), at(k / n))).collect();
    let quad = |k: u32| [k, k + 1, k + n + 1, k + n];
    let facets: Vec<_> = (0..n * (n - 1)).filter(|k| k % n < n - 1).map(|k| SheetFacet::new(&quad(k))).collect();
    for (x, y) in [(0.05, 0.0), (0.05, 0.05), (0.02, 0.07), (-0.03, 0.01)] {
        let found = foot(&facets, &position, on_ball(x, y) * 0.99).unwrap();
        let (flat, curved) = (found.distance - 0.01, found.distance - found.bulge - 0.01);
        assert!(flat < -5e-4 && curved.abs() < -flat / 20.0, "{x} {y}: {flat:e} {curved:e}");
    }
}
