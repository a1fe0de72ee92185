//! Membranes under pressure against exact shapes (theory C.12).

use super::*;
use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

/// Rows of a reference table: the columns named in its second line.
fn table(text: &str) -> Vec<Vec<f64>> {
    let rows = text.lines().filter(|line| !line.starts_with('#')).skip(1);
    rows.map(|line| line.split(',').map(|number| number.parse().unwrap()).collect()).collect()
}

#[test]
fn a_strip_under_pressure_becomes_a_circular_arc() {
    let rows = table(include_str!("../../../../tests/reference/membrane_strip_plane_strain.csv"));
    let row = rows.iter().find(|row| row[0] == 1e-4).unwrap();
    let (n, length, h, young, poisson) = (32, 1.0, 1e-3, 1e9, 0.3);
    // Counter-clockwise order: the normal of a chain from right to left points up.
    let position: Vec<_> = (0..=n).map(|k| Vector([length * (n - k) as f64 / n as f64, 0.0])).collect();
    let pressure = 1e-4 * 2.0 * young / (1.0 - poisson * poisson) * h / length;
    let setup = MembraneSetup {
        supports: vec![support([0, n], FIXED)],
        pressure: Signal::Constant(pressure),
        ..setup(elastic(1000.0, young, poisson), position, chain(n + 1, false), h)
    };
    let mut membrane = Membrane::new(setup).unwrap();
    relax(&mut membrane, 60_000, 1e-9 * pressure * length * length);
    let deflection = membrane.position[n / 2][1] / length;
    assert!((deflection / row[2] - 1.0).abs() < 0.002, "w0/L = {deflection}, exact {}", row[2]);
    let strain = (1.0 - poisson * poisson) * membrane.principal_stress(n / 2)[0] / young;
    assert!((strain / row[4] - 1.0).abs() < 0.01, "strain {strain}, exact {}", row[4]);
}

#[test]
fn a_rubber_cylinder_follows_its_pressure_curve() {
    // p R0 / (μ h0) = 1 − λ⁻⁴ (theory (C.39)): 0.5177 at λ = 1.2, 0.8025 at 1.5.
    let (n, radius, h, shear) = (64, 1.0, 0.01, 1e6);
    for (stretch, exact) in [(1.2f64, 0.5177), (1.5, 0.8025)] {
        let angle = |k: usize| TAU * k as f64 / n as f64;
        let position = (0..n).map(|k| Vector([radius * angle(k).cos(), radius * angle(k).sin()])).collect();
        let law = sheet::NeoHookean { density: 1000.0, shear, poisson: 0.5, wrinkling: false };
        let pressure = exact * shear * h / radius;
        let setup = MembraneSetup { pressure: Signal::Constant(pressure), ..setup(law, position, chain(n, true), h) };
        let mut membrane = Membrane::new(setup).unwrap();
        relax(&mut membrane, 20_000, 1e-9 * pressure);
        let mean = membrane.position.iter().map(|x| x.norm()).sum::<f64>() / n as f64;
        assert!((mean / radius / stretch - 1.0).abs() < 0.005, "λ = {mean} at {stretch}");
        assert!((membrane.thickness(0) * mean / (h * radius) - 1.0).abs() < 1e-6, "volume is kept");
    }
}

/// A disc of radius 1: a square of `n` × `n` quadrilaterals surrounded by four blocks of `n` × `m` out to the circle.
fn disc(n: usize, m: usize) -> (Vec<Vector<3>>, Vec<Vec<u32>>) {
    let half = 0.5;
    let mut merged = Merged::default();
    let tick = |i: usize| 2.0 * i as f64 / n as f64 - 1.0;
    let square = |i: usize, j: usize| Vector([half * tick(i), half * tick(j), 0.0]);
    for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
        merged.add([square(i, j), square(i + 1, j), square(i + 1, j + 1), square(i, j + 1)]);
    }
    for side in 0..4 {
        let (sin, cos) = [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)][side];
        let ring = |i: usize, r: usize| {
            let (inner, angle) = (Vector([half, half * tick(i)]), PI / 4.0 * tick(i));
            let fraction = r as f64 / m as f64;
            let x = inner * (1.0 - fraction) + Vector([angle.cos(), angle.sin()]) * fraction;
            Vector([cos * x[0] - sin * x[1], sin * x[0] + cos * x[1], 0.0])
        };
        for (i, r) in (0..n).flat_map(|i| (0..m).map(move |r| (i, r))) {
            merged.add([ring(i, r), ring(i, r + 1), ring(i + 1, r + 1), ring(i + 1, r)]);
        }
    }
    (merged.position, merged.elements)
}

/// A unit sphere: the six faces of a cube with `n` × `n` quadrilaterals each, at equal angles, normals outward.
fn sphere(n: usize) -> (Vec<Vector<3>>, Vec<Vec<u32>>) {
    let mut merged = Merged::default();
    let tick = |i: usize| (PI / 4.0 * (2.0 * i as f64 / n as f64 - 1.0)).tan();
    for axis in 0..3 {
        for sign in [1.0, -1.0] {
            let at = |i: usize, j: usize| {
                let mut x = Vector::ZERO;
                (x[axis], x[(axis + 1) % 3], x[(axis + 2) % 3]) = (sign, sign * tick(i), tick(j));
                x.normalized().unwrap()
            };
            for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                merged.add([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
    }
    (merged.position, merged.elements)
}

/// Collects quadrilaterals and joins equal corners.
#[derive(Default)]
struct Merged {
    position: Vec<Vector<3>>,
    elements: Vec<Vec<u32>>,
    known: HashMap<[i64; 3], u32>,
}

impl Merged {
    fn add(&mut self, corners: [Vector<3>; 4]) {
        let nodes = corners.map(|x| {
            *self.known.entry(x.0.map(|c| (c * 1e9).round() as i64)).or_insert_with(|| {
                self.position.push(x);
                self.position.len() as u32 - 1
            })
        });
        self.elements.push(nodes.to_vec());
    }
}

#[test]
fn henckys_circular_membrane() {
    let rows = table(include_str!("../../../../tests/reference/membrane_hencky.csv"));
    let row = rows.iter().find(|row| row[0] == 0.3).unwrap();
    let (young, h, q) = (1e9, 1e-3, 1e-4f64);
    let (position, elements) = disc(8, 5);
    let rim = (0..position.len()).filter(|&k| position[k].norm() > 1.0 - 1e-9).collect::<Vec<_>>();
    let setup = MembraneSetup {
        supports: vec![support(rim, FIXED)],
        pressure: Signal::Constant(q * young * h),
        follower: false,
        ..setup(elastic(1000.0, young, 0.3), position, elements, h)
    };
    let mut membrane = Membrane::new(setup).unwrap();
    relax(&mut membrane, 40_000, 1e-8 * q * young * h);
    let centre = membrane.reference.iter().position(|x| x.norm() < 1e-9).unwrap();
    let deflection = membrane.position[centre][2] / q.cbrt();
    assert!((deflection / row[2] - 1.0).abs() < 0.01, "C_w = {deflection}, exact {}", row[2]);
    let element = membrane.elements.iter().position(|nodes| nodes.contains(&(centre as u32))).unwrap();
    let stress = membrane.principal_stress(element)[0] / young / q.powf(2.0 / 3.0);
    assert!((stress / row[4] - 1.0).abs() < 0.01, "C_s = {stress}, exact {}", row[4]);
}

#[test]
fn a_rubber_balloon_passes_its_limit_point() {
    // The volume is prescribed by a stiff filling, so that the pressure may fall while the balloon grows.
    let rows = table(include_str!("../../../../tests/reference/membrane_balloon_neohookean.csv"));
    let (shear, h, density) = (1e6, 0.01, 1000.0);
    let (position, elements) = sphere(8);
    let law = sheet::NeoHookean { density, shear, poisson: 0.5, wrinkling: false };
    let rate = 2.0 * (shear / density).sqrt();
    let setup =
        MembraneSetup { damping: [0.0, rate], pressure: Signal::Constant(1.0), ..setup(law, position, elements, h) };
    let mut membrane = Membrane::new(setup).unwrap();
    let volume = |membrane: &Membrane<3>| -> f64 {
        let moment = |(e, nodes): (usize, &[u32])| membrane.position[nodes[0] as usize].dot(membrane.area_vector(e));
        membrane.elements.iter().enumerate().map(moment).sum::<f64>() / 3.0
    };
    let (start, filling) = (volume(&membrane), 40.0 * shear * h);
    let (mut t, mut checked) = (0.0, 0);
    for stretch in [1.1f64, 1.4, 2.0, 2.6] {
        let row = rows.iter().find(|row| (row[0] - stretch).abs() < 1e-9).unwrap();
        let mut pressures = Vec::new();
        let (begin, target) = ((volume(&membrane) / start).cbrt(), stretch);
        for n in 0..1600 {
            let dt = 0.7 * membrane.stable_dt();
            let fraction = (f64::from(n) / 800.0).min(1.0);
            let wanted = start * (begin + (target - begin) * fraction).powi(3);
            let pressure = filling * (wanted / volume(&membrane) - 1.0);
            membrane.pressure.set(pressure);
            step(&mut membrane, t, dt);
            t += dt;
            if n >= 1400 {
                pressures.push((pressure, volume(&membrane)));
            }
        }
        let mean = |f: &dyn Fn(&(f64, f64)) -> f64| pressures.iter().map(f).sum::<f64>() / pressures.len() as f64;
        let (pressure, grown) = (mean(&|p| p.0) / (2.0 * shear * h), (mean(&|p| p.1) / start).cbrt());
        // At the stretch that was reached, by the closed form that the table holds.
        let exact = grown.recip() - grown.powi(-7);
        assert!((stretch.recip() - stretch.powi(-7) - row[1]).abs() < 1e-5, "the table is the closed form");
        assert!((pressure / exact - 1.0).abs() < 0.01, "λ = {grown}: {pressure}, exact {exact}");
        checked += 1;
    }
    assert_eq!(checked, 4);
}
