//! Waves, vibration and free flight (theory C.12).

use super::*;

#[test]
fn a_free_sheet_falls_on_an_exact_parabola() {
    let (position, elements) = rectangle([3, 3], [0.3, 0.3]);
    let mut setup = setup(elastic(750.0, 1e9, 0.3), position, elements, 1e-3);
    setup.velocity.fill(Vector([1.0, -0.5, 2.0]));
    let g = [Signal::Constant(0.0), Signal::Constant(1.5), Signal::Constant(-9.81)];
    let mut membrane = Membrane::new(setup).unwrap().with_gravity(g);
    let dt = 0.5 * membrane.stable_dt();
    (0..200).for_each(|n| step(&mut membrane, f64::from(n) * dt, dt));
    // Velocities live at half steps: x_n = x_0 + n Δt v_0 + ½ n (n + 1) Δt² g.
    let (time, squares) = (200.0 * dt, 0.5 * 200.0 * 201.0 * dt * dt);
    let moved = Vector([time, -0.5 * time + 1.5 * squares, 2.0 * time - 9.81 * squares]);
    for k in 0..16 {
        assert!((membrane.position[k] - membrane.reference[k] - moved).norm() < 1e-13);
    }
    let balance = membrane.balance();
    assert!(balance.closure().abs() < 1e-12 * balance.kinetic);
}

#[test]
fn plane_waves_travel_at_the_plate_speed() {
    // One end pulled at V, sides held: σ = ρ c V behind a front at c = √(E / (ρ (1 − ν²))).
    let (n, length, pull) = (400, 2.0, -0.1);
    let (position, elements) = rectangle([n, 1], [length, 0.005]);
    let ends = (0..2).map(|j| j * (n + 1));
    let supports = vec![support(0..2 * (n + 1), [None, Some(0.0), Some(0.0)]), support(ends, [Some(pull), None, None])];
    let setup = MembraneSetup { supports, ..setup(elastic(1000.0, 1e6, 0.3), position, elements, 1e-3) };
    let mut membrane = Membrane::new(setup).unwrap();
    let c = (1e6f64 / (1.0 - 0.09) / 1000.0).sqrt();
    let dt = 0.9 * membrane.stable_dt();
    let stress = |membrane: &Membrane<3>, e: usize| membrane.principal_stress(e)[0] / (1000.0 * c * -pull);
    // The front is where half the stress has come; its lag behind c t hardly grows between two late times.
    let mut fronts = [0.4, 0.8].map(|_| [0.0; 2]);
    let mut done = 0;
    for (front, fraction) in fronts.iter_mut().zip([0.4, 0.8]) {
        let steps = (fraction * length / c / dt) as usize;
        (done..steps).for_each(|k| step(&mut membrane, k as f64 * dt, dt));
        done = steps;
        let e = (0..n).rev().find(|&e| stress(&membrane, e) > 0.5).unwrap();
        let (here, next) = (stress(&membrane, e), stress(&membrane, e + 1));
        *front = [steps as f64 * dt, (e as f64 + (here - 0.5) / (here - next)) * length / n as f64];
    }
    let speed = (fronts[1][1] - fronts[0][1]) / (fronts[1][0] - fronts[0][0]);
    assert!((speed / c - 1.0).abs() < 0.01, "front speed {speed}, c = {c}");
    let mean: f64 = (20..240).map(|e| stress(&membrane, e)).sum::<f64>() / 220.0;
    assert!((mean - 1.0).abs() < 0.005, "σ / (ρ c V) = {mean}");
}

#[test]
fn a_prestressed_square_drum_has_its_frequency() {
    // f11 = ½ √(T/m') √2 / a (theory (C.37)): a = 50 mm, T = 1 N/mm, m' = 7.5e-5 g/mm²: 1.633 kHz.
    let (n, a, h) = (16, 0.05, 1e-4);
    let (position, elements) = rectangle([n, n], [a, a]);
    let edge = (0..position.len()).filter(|k| [0, n].contains(&(k % (n + 1))) || [0, n].contains(&(k / (n + 1))));
    let supports = vec![support(edge, FIXED)];
    let mut setup =
        MembraneSetup { supports, prestress: [1e7; 2], ..setup(elastic(750.0, 1e9, 0.3), position, elements, h) };
    setup.hourglass[2] = 0.0;
    for k in 0..setup.position.len() {
        let [x, y, _] = setup.position[k].0.map(|x| (std::f64::consts::PI * x / a).sin());
        setup.velocity[k][2] = 0.05 * x * y;
    }
    let mut membrane = Membrane::new(setup).unwrap();
    let dt = 0.8 * membrane.stable_dt();
    let centre = n / 2 * (n + 2);
    let (mut crossings, mut t, mut last) = (Vec::new(), 0.0, 0.0);
    while crossings.len() < 7 {
        step(&mut membrane, t, dt);
        t += dt;
        let w = membrane.position[centre][2];
        if last * w < 0.0 {
            crossings.push(t - dt * w / (w - last));
        }
        last = w;
    }
    let frequency = 3.0 / (crossings[6] - crossings[0]);
    let exact = 0.5 * (1000.0f64 / 0.075).sqrt() * 2f64.sqrt() / a;
    assert!((exact - 1633.0).abs() < 1.0 && (frequency / exact - 1.0).abs() < 0.01, "{frequency} Hz, exact {exact}");
}

#[test]
fn a_string_hit_across_stretches_as_theory_says() {
    // V = c √(2 ε √(ε (1 + ε)) − ε²) (theory (C.38)); in plane strain c = √(E / (ρ (1 − ν²))).
    let (n, length) = (600, 1.0);
    let position: Vec<_> = (0..=n).map(|k| Vector([length * k as f64 / n as f64, 0.0])).collect();
    let (density, young, poisson) = (1000.0f64, 1e9f64, 0.3f64);
    let c = (young / (1.0 - poisson * poisson) / density).sqrt();
    let exact = 2.09e-3f64;
    let hit = c * (2.0 * exact * (exact * (1.0 + exact)).sqrt() - exact * exact).sqrt();
    assert!((hit / c - 0.01369).abs() < 3e-5);
    let supports = vec![support([0], [Some(0.0), Some(hit), None])];
    let setup =
        MembraneSetup { supports, ..setup(elastic(density, young, poisson), position, chain(n + 1, false), 1e-3) };
    let mut membrane = Membrane::new(setup).unwrap();
    let dt = 0.8 * membrane.stable_dt();
    let steps = (0.9 * length / c / dt) as usize;
    (0..steps).for_each(|k| step(&mut membrane, k as f64 * dt, dt));
    // Between the kink, which has gone c √(ε/(1+ε)) t ≈ 0.04 L, and the longitudinal front.
    let stretched = |from: usize, to: usize| (membrane.position[to] - membrane.position[from]).norm();
    let (from, to) = (n / 10, 7 * n / 10);
    let strain = stretched(from, to) / (0.6 * length) - 1.0;
    assert!((strain / exact - 1.0).abs() < 0.02, "ε = {strain}");
}

#[test]
fn energy_is_kept_over_many_oscillations() {
    let (position, elements) = rectangle([6, 6], [0.1, 0.1]);
    let law = sheet::NeoHookean { density: 1000.0, shear: 1e6, poisson: 0.5, wrinkling: false };
    let edge = (0..49).filter(|k| [0, 6].contains(&(k % 7)) || [0, 6].contains(&(k / 7)));
    let supports = vec![support(edge, FIXED)];
    let mut setup = MembraneSetup {
        supports,
        prestress: [1e5; 2],
        hourglass: [0.05, 0.0, 0.0],
        ..setup(law, position, elements, 1e-3)
    };
    setup.velocity[24][2] = 1.0;
    let mut membrane = Membrane::new(setup).unwrap();
    let dt = 0.5 * membrane.stable_dt();
    (0..5000).for_each(|k| step(&mut membrane, f64::from(k) * dt, dt));
    let balance = membrane.balance();
    assert!(balance.closure().abs() < 1e-12 * balance.kinetic_start, "closure {:e}", balance.closure());
    assert!(
        balance.mismatch.abs() < 0.01 * balance.kinetic_start,
        "mismatch {:e}",
        balance.mismatch / balance.kinetic_start
    );
}
