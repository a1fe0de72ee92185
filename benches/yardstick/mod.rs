//! The plain loop as a yardstick: a dense grid, particles one at a time, unsorted, no ledger.

use lateen::math::Vector;
use lateen::mpm::KernelKind;

/// The column with the same method as the bench (FLIP, stress last), on a dense grid with two ghost layers.
pub struct Column {
    kernel: KernelKind,
    cell: f64,
    size: [usize; 3],
    water: (f64, f64),
    gravity: f64,
    position: Vec<Vector<3>>,
    velocity: Vec<Vector<3>>,
    mass: f64,
    volume: Vec<f64>,
    pressure: Vec<f64>,
    nodes: Vec<[f64; 7]>,
}

/// The order in which the plain loop visits the particles.
#[derive(Clone, Copy)]
pub enum Order {
    /// Row by row, as they were made: neighbours are in the cache.
    RowByRow,
    /// Far from their neighbours, as after a long run of a code that never sorts.
    Mixed,
}

impl Order {
    fn of(self, lattice: Vec<Vector<3>>) -> Vec<Vector<3>> {
        match self {
            Self::RowByRow => lattice,
            // A stride that is coprime to the number of particles visits each of them once.
            Self::Mixed => {
                let n = lattice.len();
                let coprime = |stride: &usize| gcd(*stride, n) == 1;
                let stride = (n * 618 / 1000..n).find(coprime).unwrap_or(1);
                (0..n).map(|p| lattice[p * stride % n]).collect()
            }
        }
    }
}

/// Nodes beyond each wall.
const GHOSTS: usize = 2;

impl Column {
    /// The column with its particles in the given order of the lattice.
    pub fn new(n: usize, kernel: KernelKind, (water, gravity): ((f64, f64), f64), order: Order) -> Self {
        let cell = 0.5 / n as f64;
        let position = order.of(super::lattice(n));
        let count = position.len();
        let size = [4 * n, n, 2 * n].map(|cells| cells + 1 + 2 * GHOSTS);
        let volume = (0.5 * cell).powi(3);
        Self {
            kernel,
            cell,
            size,
            water,
            gravity,
            velocity: vec![Vector::ZERO; count],
            mass: water.0 * volume,
            volume: vec![volume; count],
            pressure: vec![0.0; count],
            nodes: vec![[0.0; 7]; size.iter().product()],
            position,
        }
    }

    pub fn step(&mut self, dt: f64) {
        match self.kernel {
            KernelKind::Linear => self.step_with::<2>(dt, linear),
            _ => self.step_with::<3>(dt, quadratic),
        }
    }

    fn step_with<const W: usize>(&mut self, dt: f64, weights: impl Fn(f64) -> (usize, [f64; W], [f64; W])) {
        let [nx, ny, _] = self.size;
        let per_cell = 1.0 / self.cell;
        self.nodes.fill([0.0; 7]);
        for p in 0..self.position.len() {
            let (v, m) = (self.velocity[p], self.mass);
            let force = self.volume[p] * self.pressure[p] * per_cell;
            let [(i0, wx, dx), (j0, wy, dy), (k0, wz, dz)] =
                self.position[p].0.map(|x| weights(x * per_cell + GHOSTS as f64));
            for k in 0..W {
                for j in 0..W {
                    let row = i0 + nx * (j0 + j + ny * (k0 + k));
                    for i in 0..W {
                        let (w, node) = (wx[i] * wy[j] * wz[k], &mut self.nodes[row + i]);
                        node[0] += m * w;
                        for a in 0..3 {
                            node[1 + a] += m * v[a] * w;
                        }
                        node[4] += force * dx[i] * wy[j] * wz[k];
                        node[5] += force * wx[i] * dy[j] * wz[k];
                        node[6] += force * wx[i] * wy[j] * dz[k];
                    }
                }
            }
        }
        self.advance_nodes(dt);
        for p in 0..self.position.len() {
            let [(i0, wx, dx), (j0, wy, dy), (k0, wz, dz)] =
                self.position[p].0.map(|x| weights(x * per_cell + GHOSTS as f64));
            let (mut v, mut a, mut divergence) = (Vector::ZERO, Vector::ZERO, 0.0);
            for k in 0..W {
                for j in 0..W {
                    let row = i0 + nx * (j0 + j + ny * (k0 + k));
                    for i in 0..W {
                        let (w, node) = (wx[i] * wy[j] * wz[k], &self.nodes[row + i]);
                        for axis in 0..3 {
                            v[axis] += w * node[1 + axis];
                            a[axis] += w * node[4 + axis];
                        }
                        divergence += node[1] * dx[i] * wy[j] * wz[k]
                            + node[2] * wx[i] * dy[j] * wz[k]
                            + node[3] * wx[i] * wy[j] * dz[k];
                    }
                }
            }
            self.velocity[p] = (self.velocity[p] + a * dt) * 0.999 + v * 0.001;
            self.position[p] += v * dt;
            self.volume[p] *= 1.0 + dt * divergence * per_cell;
            let (rho0, c) = self.water;
            self.pressure[p] = (c * c * (self.mass / self.volume[p] - rho0)).max(0.0);
        }
    }

    /// Velocities and accelerations, slip walls.
    fn advance_nodes(&mut self, dt: f64) {
        let [nx, ny, nz] = self.size;
        for (n, node) in self.nodes.iter_mut().enumerate() {
            if node[0] <= 0.0 {
                continue;
            }
            let at = [n % nx, n / nx % ny, n / (nx * ny)];
            for a in 0..3 {
                let size = [nx, ny, nz][a];
                let gravity = if a == 2 { self.gravity } else { 0.0 };
                let (mut v, mut acceleration) = (node[1 + a] / node[0], node[4 + a] / node[0] + gravity);
                v += acceleration * dt;
                if at[a] <= GHOSTS && v < 0.0 || at[a] + GHOSTS + 1 >= size && v > 0.0 {
                    acceleration -= v / dt;
                    v = 0.0;
                }
                (node[1 + a], node[4 + a]) = (v, acceleration);
            }
        }
    }
}

fn linear(x: f64) -> (usize, [f64; 2], [f64; 2]) {
    let first = x as usize;
    let f = x - first as f64;
    (first, [1.0 - f, f], [-1.0, 1.0])
}

fn quadratic(x: f64) -> (usize, [f64; 3], [f64; 3]) {
    let first = (x - 0.5) as usize;
    let f = x - first as f64;
    let (a, b, c) = (1.5 - f, f - 1.0, f - 0.5);
    (first, [0.5 * a * a, 0.75 - b * b, 0.5 * c * c], [-a, -2.0 * b, c])
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}
