//! Exactness, conservation, and orders against the table of theory G.11.

use super::*;
use std::f64::consts::PI;

fn square(cells: usize) -> Mesh<2, 3> {
    Mesh::block(Vector::ZERO, Vector::splat(1.0), [cells; 2]).unwrap()
}

fn cube(cells: usize) -> Mesh<3, 4> {
    Mesh::block(Vector::ZERO, Vector::splat(1.0), [cells; 3]).unwrap()
}

/// Two fluids with a slanted interface; every thirteenth particle is missing, so that none of this relies on lattices.
fn two_fluids<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    velocity: impl Fn(Vector<D>) -> Vector<D> + Sync,
) -> Particles<D> {
    let seeded = Particles::seed(mesh, 4, |x| Some(u8::from(x[0] + 0.3 * x[1] > 0.613)), velocity);
    let mut thinned = seeded.clone();
    (0..seeded.len()).step_by(13).for_each(|p| thinned.element[p] = crate::pfem2::particles::GONE);
    thinned.sort();
    thinned
}

fn plain<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    particles: &Particles<D>,
    kernel: AveragingKernel,
) -> Projected<D> {
    project(mesh, particles, &[1000.0, 1.0], kernel, &vec![Vector::ZERO; mesh.nodes().len()], &|e| {
        mesh.simplex(e).volume
    })
}

fn linear_exactness<const D: usize, const N: usize>(mesh: &Mesh<D, N>) {
    let field =
        |x: Vector<D>| Vector::from_fn(|c| 0.7 + (0..D).map(|i| (1.3 - (c + 2 * i) as f64) * x[i]).sum::<f64>());
    let projected = plain(mesh, &two_fluids(mesh, field), AveragingKernel::Linear);
    for (x, v) in mesh.nodes().iter().zip(&projected.velocity.mean) {
        assert!((*v - field(*x)).norm() < 1e-12, "{x:?}: {v:?}");
    }
}

#[test]
fn linear_fields_pass_the_linear_kernel_unchanged() {
    linear_exactness(&square(5));
    linear_exactness(&cube(3));
}

fn conserves_momentum<const D: usize, const N: usize>(mesh: &Mesh<D, N>) {
    let rough = |x: Vector<D>| Vector::from_fn(|c| (40.0 * x[c] + 90.0 * x[(c + 1) % D] * x[0]).sin());
    let particles = two_fluids(mesh, rough);
    let projected = plain(mesh, &particles, AveragingKernel::Linear);
    let nodes: Vector<D> = projected.velocity.mean.iter().zip(&projected.weight).map(|(&v, &m)| v * m).sum();
    let mut carried = Vector::ZERO;
    let mut size = 0.0;
    for e in 0..mesh.elements().len() {
        let volume = mesh.simplex(e).volume / particles.of(e).len() as f64;
        for p in particles.of(e) {
            let mass = volume * [1000.0, 1.0][particles.phase[p] as usize];
            carried += particles.velocity[p] * mass;
            size += mass * particles.velocity[p].norm();
        }
    }
    assert!((nodes - carried).norm() < 1e-13 * size, "{nodes:?} {carried:?}");
}

#[test]
fn the_linear_kernel_conserves_momentum_at_a_density_ratio_of_a_thousand() {
    conserves_momentum(&square(6));
    conserves_momentum(&cube(3));
}

/// Σ m N_i v of one particle among others at rest: it has no gradient, and what rounding makes of its spread is none.
#[test]
fn a_single_particle_gives_its_momentum_to_its_nodes() {
    let (mesh, velocity) = (square(3), Vector([1.0, 2.0]));
    let rest = Particles::seed(&mesh, 2, |_| Some(0), |_| Vector::ZERO);
    for sample in 0..2000 {
        let (p, way) = (sample % rest.len(), 0.3 * (0.5 + 0.5 * f64::from(sample as u32).sin()));
        let mut particles = rest.clone();
        (particles.phase[p], particles.velocity[p]) = (1, velocity);
        let e = particles.element[p] as usize;
        let towards = mesh.corners(e)[sample % 3] - particles.position[p];
        particles.position[p] += towards * way;
        let mass = mesh.simplex(e).volume / particles.of(e).len() as f64;
        let shape = mesh.shape_functions(e, particles.position[p]);
        let projected = plain(&mesh, &particles, AveragingKernel::Linear);
        for (n, &node) in shape.iter().zip(&mesh.elements()[e]) {
            let carried = projected.velocity.mean[node as usize] * projected.weight[node as usize];
            assert!((carried - velocity * (mass * n)).norm() < 1e-12 * mass, "{sample}: {carried:?}");
        }
    }
}

/// A film of heavy particles, a hundredth of an element thick, whose upper half moves one way and lower half the other:
/// carried on to nodes at its slope, this would be a hundred times what any particle has.
#[test]
fn the_slope_across_a_film_is_not_carried_on_to_the_nodes() {
    let mesh = square(6);
    let row = (3.0 + 7.0 / 12.0) / 6.0;
    let film = |x: Vector<2>| (x[1] - row).abs() < 0.01 / 6.0;
    let along = |x: Vector<2>| Vector([if film(x) { (x[1] - row).signum() } else { 0.0 }, 0.0]);
    let particles = Particles::seed(&mesh, 4, |x| Some(u8::from(!film(x))), along);
    let heavy = particles.phase.iter().filter(|&&fluid| fluid == 0).count();
    assert!((6..30).contains(&heavy), "{heavy}");
    let projected = plain(&mesh, &particles, AveragingKernel::Linear);
    let fastest = |v: &[Vector<2>]| v.iter().map(|v| v.norm()).fold(0.0, f64::max);
    let (own, mean) = (fastest(&projected.velocity.own[0]), fastest(&projected.velocity.mean));
    assert!(own < 10.0 && mean < 10.0, "{own} {mean}");
}

/// One fluid in a layer of a fifth of an element between a wall and a solid, a particle per sub-cell, with noise:
/// carried on across the whole element, it would be 75 times what any particle has. (A single average has up to 1.6
/// times, and that of what it leaves as much at most.)
#[test]
fn the_slope_across_a_layer_beside_a_solid_is_not_carried_on_to_the_nodes() {
    let (mesh, cells) = (square(6), 6.0);
    let layer = 0.2 / cells;
    for sample in 0..50 {
        let velocity =
            |x: Vector<2>| Vector([noise((1e6 * x[0]) as usize, sample), noise((1e6 * x[1]) as usize, sample)]);
        let mut particles = Particles::seed(&mesh, 2, |_| Some(0), |_| Vector::ZERO);
        for p in 0..particles.len() {
            let place = particles.position[p];
            let squeezed = Vector([place[0], layer * (0.5 + 0.3 * noise(p, sample))]);
            let shape = mesh.shape_functions(particles.element[p] as usize, squeezed);
            let is_inside = shape.iter().all(|&n| n > 0.0);
            if !is_inside {
                particles.element[p] = crate::pfem2::particles::GONE;
            }
            (particles.position[p], particles.velocity[p]) = (squeezed, velocity(squeezed));
        }
        particles.sort();
        let volume = |e: usize| if particles.of(e).is_empty() { 0.0 } else { 0.2 * mesh.simplex(e).volume };
        let still = vec![Vector::ZERO; mesh.nodes().len()];
        let projected = project(&mesh, &particles, &[1.0], AveragingKernel::Linear, &still, &volume);
        let fastest = |all: &[Vector<2>]| all.iter().map(|v| v.norm()).fold(0.0, f64::max);
        let (nodes, own) = (fastest(&projected.velocity.mean), fastest(&particles.velocity));
        assert!(particles.len() >= 12 && nodes < 3.2 * own, "{sample}: {nodes} {own}");
    }
}

/// Part of a field that alternates from node to node, carried by particles, that their average doesn't show.
fn unseen<const D: usize, const N: usize>(mesh: &Mesh<D, N>, cells: usize) -> f64 {
    let alternating = |x: &Vector<D>| {
        let along = (0..D).map(|axis| (x[axis] * cells as f64).round() as usize).sum::<usize>();
        Vector::splat(if along.is_multiple_of(2) { 1.0 } else { -1.0 })
    };
    let nodal: Vec<Vector<D>> = mesh.nodes().iter().map(alternating).collect();
    let mut particles = Particles::seed(mesh, 4, |_| Some(0), |_| Vector::ZERO);
    for p in 0..particles.len() {
        let e = particles.element[p] as usize;
        let shape = mesh.shape_functions(e, particles.position[p]);
        particles.velocity[p] = crate::pfem2::particles::interpolate_nodal(&shape, &mesh.elements()[e], &nodal);
    }
    let projected = plain(mesh, &particles, AveragingKernel::Linear);
    let rest = nodal.iter().zip(&projected.velocity.mean).zip(&projected.weight);
    let [lost, all] = rest.fold([0.0, 0.0], |[lost, all], ((&v, &hat), &m)| {
        [lost + m * (v - hat).norm_squared(), all + m * v.norm_squared()]
    });
    (lost / all).sqrt()
}

/// The eigenvalues of a mass matrix over its lumped one are at least 1/(D + 2) (Wathen 1987): when what an average
/// leaves is averaged once more, no more than (1 − 1/(D + 2))² of any field on the nodes stays behind. A single average
/// leaves 0.63 of these in the plane, and 0.72.
#[test]
fn velocities_that_nodes_gave_to_particles_come_back() {
    for (left, dimension) in [(unseen(&square(8), 8), 2.0), (unseen(&cube(4), 4), 3.0)] {
        let bound = (1.0_f64 - 1.0 / (dimension + 2.0)).powi(2);
        assert!(left < bound, "{dimension}: {left}, {bound}");
    }
}

/// A number between −1 and 1 that follows from two others without a pattern.
fn noise(a: usize, b: usize) -> f64 {
    let x = (12.9898 * a as f64 + 78.233 * b as f64).sin() * 43758.5453;
    2.0 * (x - x.floor()) - 1.0
}

/// Particles beside a heavy fluid at rest lose what their nodes receive of them, again and again: whatever line, film
/// or drop they fill, what is left never grows.
#[test]
fn slopes_of_a_cut_fluid_do_not_feed_on_themselves() {
    let (mesh, steps) = (square(5), 150);
    for sample in 0..60 {
        let (angle, off) = (3.2 * noise(sample, 1), 0.2 * noise(sample, 2));
        let (width, drop) = (0.13 * (1.1 + noise(sample, 3)), 0.17 * (1.2 + noise(sample, 4)));
        let fluid = |x: Vector<2>| {
            let from = x - Vector([0.5 + 0.1 * noise(sample, 5), 0.5]);
            let height = from[0] * angle.cos() + from[1] * angle.sin() - off;
            u8::from(match sample % 3 {
                0 => height > 0.0,
                1 => height > 0.0 && height < width,
                _ => from.norm() < drop,
            })
        };
        let mut particles = Particles::seed(&mesh, 3, |x| Some(fluid(x)), |_| Vector::ZERO);
        for p in 0..particles.len() {
            let to = mesh.corners(particles.element[p] as usize)[p % 3] - particles.position[p];
            particles.position[p] += to * (0.2 + 0.2 * noise(p, sample));
            particles.phase[p] = fluid(particles.position[p]);
            particles.velocity[p] = Vector([noise(p, 7), noise(p, 8)]);
        }
        particles.sort();
        let size = |particles: &Particles<2>| {
            let own = particles.phase.iter().zip(&particles.velocity).filter(|(fluid, _)| **fluid == 1);
            own.map(|(_, v)| v.norm_squared()).sum::<f64>().sqrt()
        };
        let start = size(&particles);
        for _ in 0..steps {
            let own = plain(&mesh, &particles, AveragingKernel::Linear).velocity.own.swap_remove(1);
            for p in 0..particles.len() {
                let e = particles.element[p] as usize;
                let shape = mesh.shape_functions(e, particles.position[p]);
                particles.velocity[p] -= crate::pfem2::particles::interpolate_nodal(&shape, &mesh.elements()[e], &own);
            }
        }
        assert!(size(&particles) <= 2.0 * start, "{sample}: {}", size(&particles) / start);
    }
}

#[test]
fn the_mean_velocity_is_the_mean_of_the_fluids_by_mass() {
    let mesh = square(6);
    let particles = two_fluids(&mesh, |x| Vector([if x[0] + 0.3 * x[1] > 0.613 { 1.0 } else { 3.0 }, x[0]]));
    let projected = plain(&mesh, &particles, AveragingKernel::Linear);
    for (node, mean) in projected.velocity.mean.iter().enumerate() {
        let mass = [1000.0 * projected.fraction[0][node], projected.fraction[1][node]];
        let own = [0, 1].map(|fluid: usize| projected.velocity.own[fluid][node]);
        assert!((own[0][0] - 3.0).abs() < 1e-12 || mass[0] == 0.0, "{own:?}");
        assert!((own[1][0] - 1.0).abs() < 1e-12 || mass[1] == 0.0, "{own:?}");
        assert!((*mean * (mass[0] + mass[1]) - own[0] * mass[0] - own[1] * mass[1]).norm() < 1e-9);
    }
}

#[test]
fn constants_pass_every_kernel_and_fractions_add_up_to_one() {
    let mesh = square(5);
    let constant = Vector([2.0, -3.0]);
    let particles = two_fluids(&mesh, |_| constant);
    for kernel in [AveragingKernel::Shape, AveragingKernel::Wendland, AveragingKernel::Linear] {
        let projected = plain(&mesh, &particles, kernel);
        for node in 0..mesh.nodes().len() {
            assert!((projected.velocity.mean[node] - constant).norm() < 1e-13);
            assert!((projected.fraction[0][node] + projected.fraction[1][node] - 1.0).abs() < 1e-13);
        }
    }
}

#[test]
fn nodes_without_particles_keep_their_velocity() {
    let mesh = square(4);
    let particles = Particles::seed(&mesh, 4, |x| (x[0] < 0.4).then_some(0), |_| Vector([1.0, 0.0]));
    let previous = vec![Vector([0.0, 7.0]); mesh.nodes().len()];
    let projected = project(&mesh, &particles, &[1.0], AveragingKernel::Linear, &previous, &|e| mesh.simplex(e).volume);
    for (node, x) in mesh.nodes().iter().enumerate() {
        assert_eq!(projected.bare[node], x[0] > 0.6);
        let expected = if x[0] > 0.6 { previous[node] } else { Vector([1.0, 0.0]) };
        assert!((projected.velocity.mean[node] - expected).norm() < 1e-14);
    }
}

/// Root mean square errors at interior and at boundary nodes for a smooth field, particles at random places.
fn errors(cells: usize, kernel: AveragingKernel) -> [f64; 2] {
    let mesh = square(cells);
    let field = |x: Vector<2>| Vector([(PI * x[0]).cos() * (1.5 * x[1] + 0.3).sin(), (2.0 * x[0] + x[1]).exp() * 0.2]);
    let particles = Particles::seed(&mesh, 3, |_| Some(0), field);
    let projected = project(&mesh, &particles, &[1.0], kernel, &vec![Vector::ZERO; mesh.nodes().len()], &|e| {
        mesh.simplex(e).volume
    });
    let mut sums = [[0.0, 0.0]; 2];
    for (x, v) in mesh.nodes().iter().zip(&projected.velocity.mean) {
        let at_boundary = x.0.iter().any(|&c| c == 0.0 || c == 1.0);
        let sum = &mut sums[usize::from(at_boundary)];
        *sum = [sum[0] + (*v - field(*x)).norm_squared(), sum[1] + 1.0];
    }
    sums.map(|[sum, count]| f64::sqrt(sum / count))
}

#[test]
fn kernels_converge_with_the_orders_of_the_published_table() {
    let order = |kernel, place: usize| (errors(10, kernel)[place] / errors(80, kernel)[place]).log2() / 3.0;
    for place in [0, 1] {
        let linear = order(AveragingKernel::Linear, place);
        assert!(linear > 1.85, "linear, {place}: {linear}");
    }
    for kernel in [AveragingKernel::Shape, AveragingKernel::Wendland] {
        let order = order(kernel, 1);
        assert!((0.75..1.25).contains(&order), "{kernel:?} at the boundary: {order}");
    }
}

/// Particles that a solid has swept over lie in elements without fluid, and have no weight.
#[test]
fn nodes_among_particles_in_solids_keep_their_velocity() {
    let mesh = square(4);
    let particles = Particles::seed(&mesh, 4, |_| Some(0), |_| Vector([1.0, 0.0]));
    let previous = vec![Vector([0.0, 7.0]); mesh.nodes().len()];
    let fluid = |e: usize| if mesh.corners(e).iter().all(|x| x[0] > 0.4) { 0.0 } else { mesh.simplex(e).volume };
    let projected = project(&mesh, &particles, &[1.0], AveragingKernel::Linear, &previous, &fluid);
    for (node, x) in mesh.nodes().iter().enumerate() {
        assert_eq!(projected.bare[node], x[0] > 0.6);
        let expected = if x[0] > 0.6 { previous[node] } else { Vector([1.0, 0.0]) };
        assert!((projected.velocity.mean[node] - expected).norm() < 1e-14);
    }
}
