//! Conditions at the surface of obstacles, which lies anywhere between the nodes.
//!
//! A body meets an obstacle at points x_c of its surface. There, with the shape functions of the bodies,
//!
//! ```text
//! u = Σ_I N_I(x_c) v_I,   M⁻¹ = Σ_I N_I(x_c)²/m_I,   p_I ← p_I + N_I(x_c) J   J on the body: so that u satisfies the condition
//! ```
//!
//! Of an obstacle that binds, x_c are the feet of the nodes within half a cell: on average one per cell of the surface,
//! however it is turned. Of one that bodies may leave they are the feet of the particles that show the body's surface,
//! each with its gap g = d(x_p) − r_p(n) (theory (D.7)), which closes, at the earliest, at the end of the step
//! (theory (E.7)):
//!
//! ```text
//! binding   (u − v_w)·ν = 0, or u = v_w
//! contact   J_n ≥ 0,  (u − v_w)·ν + max(g, 0)/Δt ≥ 0,  one of them zero;   ‖J_t‖ ≤ μ J_n
//! ```
//!
//! Particles that creep towards an obstacle that binds, between its points, are stopped at half their reach, as by
//! contact without friction.
//!
//! A body with the pressure p that ends at the surface has the forces p ∫ ∇N_I dV = p N_I(x_c) ν on its nodes: the
//! impulses give back just that. Conditions at the nodes themselves would leave the forces p N_I on those in front, and
//! the body would come to rest up to half a cell off, where its particles balance them.
//!
//! A node at the edge of the particles' supports has very little mass, but not very little N_I(x_c): it would take up
//! the impulses, and the body pass through. No particle that lies at the point has a larger N_I than m_I/m_p;
//! nor has the point:
//!
//! ```text
//! N_I(x_c) ← min(N_I(x_c), m_I/m̄),   m̄ = 2⁻ᴰ Σ N_I(x_c) m_I: mass of a particle, two per cell and
//!                                     direction; then Σ N_I = 1 again
//! ```
//!
//! The velocity that FLIP gives a node is that of the mean place of its particles, x̄_I = Σ m_p N_Ip x_p/m_I, which at
//! the edge of a body lies inside of it: u is that of the body up to a quarter of a cell below its surface. Sliding
//! velocities are those of the surface itself, with tilted weights
//!
//! ```text
//! W_I = N_I (1 + γ (x̄_I − x̃)·ν),   x̃ = Σ N_I x̄_I,   γ so that Σ W_I x̄_I·ν = x_c·ν
//! ```
//!
//! for the tangential parts of u and J: a rigid motion is exact, and so is the angular momentum that friction gives.
//! Without, a wheel would roll on a radius that is too short.
//!
//! All points together are solved by projected Gauss–Seidel in a fixed order. Each visit is a projection in the metric
//! of the masses, so that obstacles at rest take energy and never give any, converged or not, without friction by proof
//! (theory E.7).

mod point;
mod step;

use crate::math::Vector;
use crate::mpm::wall::folded_stencil::{FoldedStencil, flip};
use crate::mpm::{Grid, Node};
pub use point::{ImpulseIterate, ImpulseLaw, NodeOfSupport, SurfaceFoot, SurfacePoint};

/// Least fraction of the support of a binding point that must have mass: else no body is there yet.
const LEAST_SUPPORT_FRACTION: f64 = 0.5;

/// Most sweeps, and the change of an impulse, relative to the largest one, that ends them.
const SWEEPS: usize = 40;
const SETTLED: f64 = 1e-4;

/// Sweeps over the points with an impulse, between two over all.
const ROUNDS: usize = 4;

/// The most that tilting changes a weight, relative to it.
const TILT: f64 = 0.9;

/// Stands for the number of a grid node that is not among the nodes of the supports.
const NONE: u32 = u32::MAX;

/// The points of obstacles' surfaces with conditions for a field during a step.
#[derive(Debug, Clone, Default)]
pub struct SurfacePoints<const D: usize> {
    pub points: Vec<SurfacePoint<D>>,
    support: Vec<NodeOfSupport<D>>,
    /// Grid nodes, and their 1/m [1/kg].
    nodes: Vec<(u32, f64)>,
    /// Number of each grid node among `nodes`.
    number: Vec<u32>,
}

/// Impulses of a solution [N s]: at all points, and on grid nodes.
pub struct SurfaceImpulses<const D: usize> {
    pub points: Vec<Vector<D>>,
    pub nodes: Vec<(usize, Vector<D>)>,
    /// The parts of impulses at points next to mirrors that mirrors take, by side, numbered 2 axis + end.
    pub mirrored: Vec<(usize, Vector<D>)>,
}

/// The state of the iteration: impulses at the points [N s], velocities of the nodes [m/s] and their impulses [N s].
struct Iterate<const D: usize> {
    impulse: Vec<Vector<D>>,
    velocity: Vec<Vector<D>>,
    nodal_impulse: Vec<Vector<D>>,
}

impl<const D: usize> SurfacePoints<D> {
    /// Replaces the points of the step before, and finds the nodes around them, which hold (m, p). Points of obstacles
    /// that bind are left out where no body is.
    pub fn find(
        &mut self,
        grid: &Grid<D>,
        stencil: &FoldedStencil<D>,
        nodes: &[Node<D>],
        points: impl Iterator<Item = SurfacePoint<D>>,
    ) {
        let known = self.number.len();
        self.nodes.iter().filter(|(n, _)| (*n as usize) < known).for_each(|&(n, _)| self.number[n as usize] = NONE);
        self.number.resize(nodes.len(), NONE);
        self.nodes.clear();
        self.points.clear();
        self.support.clear();
        for mut point in points {
            let start = self.add_support(grid, stencil, nodes, point.place);
            let cover = self.limit(start);
            if cover <= 0.0 || point.binds() && cover < LEAST_SUPPORT_FRACTION {
                self.support.truncate(start);
                continue;
            }
            for NodeOfSupport { number, weight, .. } in &mut self.support[start..] {
                *weight = *weight / cover;
                let inverse_mass = self.nodes[*number as usize].1;
                point.inverse_mass += Vector::from_fn(|a| weight[a] * weight[a] * inverse_mass);
            }
            point.sliding_inverse_mass = (0..D).map(|a| point.inverse_mass[a]).fold(0.0, f64::max);
            let mirrored = self.support[start..].iter().any(|at| (1..D).any(|a| at.weight[a] != at.weight[0]));
            point.mirrors = mirrored.then(|| nearer_sides(grid, point.place));
            (point.start, point.end) = (start as u32, self.support.len() as u32);
            self.points.push(point);
        }
    }

    /// Tilts the weights for what slides, where the nodes stand for these mean places of their particles [m].
    pub fn tilt(&mut self, means: &[Vector<D>]) {
        for point in &mut self.points {
            let near = &mut self.support[point.start as usize..point.end as usize];
            let height = |at: &NodeOfSupport<D>| (means[at.number as usize] - point.place).dot(point.normal);
            let mean: f64 = near.iter().map(|at| at.shape_function() * height(at)).sum();
            let spread: f64 = near.iter().map(|at| at.shape_function() * (height(at) - mean).powi(2)).sum();
            let most = near.iter().map(|at| (height(at) - mean).abs()).fold(0.0, f64::max);
            let slope = if spread > 0.0 { (-mean / spread).max(-TILT / most).min(TILT / most) } else { 0.0 };
            let mut inverse_mass = Vector::<D>::ZERO;
            for at in near {
                at.tilt = 1.0 + slope * (height(at) - mean);
                let nodal = self.nodes[at.number as usize].1 * at.tilt * at.tilt;
                inverse_mass += Vector::from_fn(|a| at.weight[a] * at.weight[a] * nodal);
            }
            point.sliding_inverse_mass = (0..D).map(|a| inverse_mass[a]).fold(0.0, f64::max);
        }
    }

    /// The mean places of the particles [m], node by node: Σ m_p N_Ip x_p/m_I over what `each` hands on, mass, place
    /// and its nodes.
    pub fn mean_places(&self, each: impl Fn(&mut dyn FnMut(usize, f64, Vector<D>))) -> Vec<Vector<D>> {
        let mut sums = vec![Vector::ZERO; self.nodes.len()];
        each(&mut |node, mass, x| {
            let number = self.number[node];
            if number != NONE {
                sums[number as usize] += x * (mass * self.nodes[number as usize].1);
            }
        });
        sums
    }

    /// Lists the nodes around `x` [m] that have mass; returns where they begin.
    fn add_support(&mut self, grid: &Grid<D>, stencil: &FoldedStencil<D>, nodes: &[Node<D>], x: Vector<D>) -> usize {
        let start = self.support.len();
        stencil.for_each(grid, x, |node, weight, flips| {
            let mass = nodes[node].mass;
            if mass <= stencil.cutoff {
                return;
            }
            let number = &mut self.number[node];
            if *number == NONE {
                *number = self.nodes.len() as u32;
                self.nodes.push((node as u32, 1.0 / mass));
            }
            let (number, weight) = (*number, flip(Vector::from_fn(|_| weight), flips));
            match self.support[start..].iter_mut().find(|support| support.number == number) {
                Some(support) => support.weight += weight,
                None => self.support.push(NodeOfSupport { number, weight, tilt: 1.0 }),
            }
        });
        start
    }

    /// Limits the weights of the nodes listed from `start` on by their masses; returns Σ N_I.
    fn limit(&mut self, start: usize) -> f64 {
        let Self { support, nodes, .. } = self;
        let mass = |at: &NodeOfSupport<D>| 1.0 / nodes[at.number as usize].1;
        let near = &mut support[start..];
        let [cover, sum] =
            near.iter().fold([0.0; 2], |[n, nm], at| [n + at.shape_function(), nm + at.shape_function() * mass(at)]);
        let particle = sum / cover / f64::from(1 << D);
        for at in near.iter_mut() {
            at.weight *= (mass(at) / (particle * at.shape_function().abs())).min(1.0);
        }
        near.iter().map(NodeOfSupport::shape_function).sum()
    }

    /// All points with the velocities there [m/s], from those of the nodes.
    pub fn velocities<'a>(
        &'a self,
        nodal: impl Fn(usize) -> Vector<D> + 'a,
    ) -> impl Iterator<Item = (&'a SurfacePoint<D>, Vector<D>)> + 'a {
        self.points.iter().map(move |point| {
            let near = &self.support[point.start as usize..point.end as usize];
            let read = |at: &NodeOfSupport<D>| at.read(nodal(self.nodes[at.number as usize].0 as usize), point.normal);
            (point, near.iter().map(read).sum())
        })
    }

    /// The impulses that make the velocities at all points what `law` asks for: `nodal` gives the velocity of a node
    /// [m/s], `walls` that of the wall at a point, `given` what it has had already [N s].
    pub fn solve(
        &self,
        nodal: impl Fn(usize) -> Vector<D>,
        walls: impl Fn(&SurfacePoint<D>) -> Vector<D>,
        given: impl Fn(&SurfacePoint<D>) -> Vector<D>,
        law: ImpulseLaw<'_, D>,
    ) -> SurfaceImpulses<D> {
        let walls: Vec<_> = self.points.iter().map(walls).collect();
        let velocity: Vec<_> = self.nodes.iter().map(|&(node, _)| nodal(node as usize)).collect();
        let nodal_impulse = vec![Vector::ZERO; velocity.len()];
        let first: Vec<_> = self.points.iter().map(given).collect();
        let mut solution = Iterate { impulse: first.clone(), velocity, nodal_impulse };
        let all: Vec<u32> = (0..self.points.len() as u32).collect();
        for _ in 0..SWEEPS / (1 + ROUNDS) {
            let (change, largest) = self.sweep(&all, &walls, &mut solution, law);
            if change <= SETTLED * largest {
                break;
            }
            let pushing: Vec<u32> =
                all.iter().copied().filter(|&k| solution.impulse[k as usize] != Vector::ZERO).collect();
            for _ in 0..ROUNDS {
                let (change, largest) = self.sweep(&pushing, &walls, &mut solution, law);
                if change <= SETTLED * largest {
                    break;
                }
            }
        }
        let nodes = self.nodes.iter().zip(solution.nodal_impulse).map(|(&(node, _), sum)| (node as usize, sum));
        let points: Vec<_> = solution.impulse.into_iter().zip(first).map(|(after, before)| after - before).collect();
        let nodes = nodes.filter(|(_, sum)| *sum != Vector::ZERO).collect();
        SurfaceImpulses { mirrored: self.mirrored(&points), points, nodes }
    }

    /// The parts of these impulses at the points that nodes don't get [N s], by side: those along a mirror's normal on
    /// the images of nodes.
    fn mirrored(&self, impulses: &[Vector<D>]) -> Vec<(usize, Vector<D>)> {
        let mut kept = Vec::new();
        for (point, &j) in self.points.iter().zip(impulses).filter(|(_, j)| **j != Vector::ZERO) {
            let Some(sides) = point.mirrors else { continue };
            let near = &self.support[point.start as usize..point.end as usize];
            let rest = j - near.iter().map(|at| at.spread(j, point.normal)).sum::<Vector<D>>();
            kept.extend((0..D).map(|a| (sides[a], Vector::unit(a) * rest[a])));
        }
        kept
    }

    /// One sweep over some points: the largest change of an impulse, and the largest impulse [N s].
    fn sweep(
        &self,
        points: &[u32],
        walls: &[Vector<D>],
        solution: &mut Iterate<D>,
        law: ImpulseLaw<'_, D>,
    ) -> (f64, f64) {
        let Iterate { impulse: impulses, velocity, nodal_impulse } = solution;
        let (mut change, mut largest) = (0.0_f64, 0.0_f64);
        for &k in points {
            let (point, impulse) = (&self.points[k as usize], &mut impulses[k as usize]);
            let near = &self.support[point.start as usize..point.end as usize];
            let u = near.iter().map(|at| at.read(velocity[at.number as usize], point.normal)).sum();
            let wanted = law(&ImpulseIterate { point, wall: walls[k as usize], velocity: u, impulse: *impulse });
            let delta = wanted - *impulse;
            *impulse = wanted;
            largest = largest.max(wanted.norm());
            if delta == Vector::ZERO {
                continue;
            }
            change = change.max(delta.norm());
            for at in near {
                let (part, node) = (at.spread(delta, point.normal), at.number as usize);
                nodal_impulse[node] += part;
                velocity[node] += part * self.nodes[node].1;
            }
        }
        (change, largest)
    }

    /// 1/m of a grid node around a point [1/kg].
    pub fn inverse_mass_of(&self, node: usize) -> f64 {
        self.nodes[self.number[node] as usize].1
    }
}

/// The side of the grid, numbered 2 axis + end, to which `x` [m] is nearer along each axis.
fn nearer_sides<const D: usize>(grid: &Grid<D>, x: Vector<D>) -> [usize; D] {
    let upper = grid.upper();
    std::array::from_fn(|a| 2 * a + usize::from(upper[a] - x[a] < x[a] - grid.origin[a]))
}
