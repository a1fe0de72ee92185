//! Membranes against closed forms and published curves.

mod dynamics;
mod inflation;
mod patch;
mod robustness;

use super::Membrane;
use crate::material::{Sheet, sheet};
use crate::math::{Signal, Vector};
use crate::mpm::{MembraneSetup, SupportSetup};

/// A set-up with the recommended hourglass control and nothing else.
fn setup<const D: usize>(
    sheet: impl Sheet + 'static,
    position: Vec<Vector<D>>,
    elements: Vec<Vec<u32>>,
    thickness: f64,
) -> MembraneSetup<D> {
    MembraneSetup {
        name: "sheet".into(),
        sheet: Box::new(sheet),
        velocity: vec![Vector::ZERO; position.len()],
        position,
        elements,
        warp: Vec::new(),
        thickness,
        prestress: [0.0; 2],
        hourglass: [0.05, 0.0, 0.01],
        damping: [0.0; 2],
        supports: Vec::new(),
        pressure: Signal::ZERO,
        follower: true,
        contact_thickness: true,
    }
}

fn elastic(density: f64, young: f64, poisson: f64) -> sheet::Elastic {
    sheet::Elastic { density, young, poisson, wrinkling: false }
}

/// Nodes held still, or moved along the given axes.
fn support(nodes: impl IntoIterator<Item = usize>, velocity: [Option<f64>; 3]) -> SupportSetup {
    SupportSetup {
        nodes: nodes.into_iter().map(|k| k as u32).collect(),
        velocity: velocity.map(|v| v.map(Signal::Constant)),
    }
}

const FIXED: [Option<f64>; 3] = [Some(0.0); 3];

/// `nx` × `ny` quadrilaterals on (0, lx) × (0, ly) in the plane z = 0.
fn rectangle([nx, ny]: [usize; 2], [lx, ly]: [f64; 2]) -> (Vec<Vector<3>>, Vec<Vec<u32>>) {
    let at = |i: usize, j: usize| (j * (nx + 1) + i) as u32;
    let position = (0..(nx + 1) * (ny + 1))
        .map(|k| Vector([(k % (nx + 1)) as f64 * lx / nx as f64, (k / (nx + 1)) as f64 * ly / ny as f64, 0.0]))
        .collect();
    let cell = |k: usize| (k % nx, k / nx);
    let elements = (0..nx * ny)
        .map(|k| {
            let (i, j) = cell(k);
            vec![at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]
        })
        .collect();
    (position, elements)
}

/// A chain of segments through the points.
fn chain(points: usize, closed: bool) -> Vec<Vec<u32>> {
    let n = points as u32;
    let last = if closed { n } else { n - 1 };
    (0..last).map(|k| vec![k, (k + 1) % n]).collect()
}

/// One step with constant Δt.
fn step<const D: usize>(membrane: &mut Membrane<D>, t: f64, dt: f64) {
    membrane.internal_force(t).expect("a sound step");
    membrane.advance_velocity(t, dt);
    membrane.move_nodes(t, dt);
}

/// Moves towards rest by kinetic damping: whenever the kinetic energy has passed a maximum all velocities are cleared.
/// Stops when the kinetic energy at a maximum is below `tolerance` [J].
fn relax<const D: usize>(membrane: &mut Membrane<D>, steps: usize, tolerance: f64) {
    let (mut last, mut t) = (0.0, 0.0);
    for _ in 0..steps {
        let dt = 0.7 * membrane.stable_dt();
        step(membrane, t, dt);
        t += dt;
        let kinetic = membrane.kinetic_energy();
        if kinetic < last {
            membrane.velocity.fill(Vector::ZERO);
            if last < tolerance {
                return;
            }
        }
        last = if kinetic < last { 0.0 } else { kinetic };
    }
    panic!("not at rest after {steps} steps: kinetic energy {last:e} J");
}

/// Deterministic noise in −1..1.
fn noise(seed: &mut u64) -> f64 {
    *seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
    (*seed >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}
