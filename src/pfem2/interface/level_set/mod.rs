//! The level set φ at the nodes, whose zero is the interface between two fluids; negative in the fluid `inside`.
//!
//! ```text
//! pseudo   φ_i = Σ_p ±N_i / Σ_p N_i                                                   Becker (37), theory (G.2)
//! sharp    φ_i = linear-exact average of ±d_p, d_p = depth of the particle below the surface of its fluid   theory (G.3)
//! volume   find δ with V⁻(φ + δ) = V₀ − ∫∮_{φ<0} v*·n dA dt:  φ ← φ + δ                theory (G.7)
//! ```
//!
//! An average of signs is no distance: with n particles per element its zero line is noisy by h/√n. Depths that
//! travel with the particles and are averaged without an error in linear fields keep the line smooth to second
//! order. Every few steps they are measured anew. Particles farther than two elements from the interface take the
//! distance of their place from the cut polygons (see `distance`). Nearer ones only lose what has stretched φ by much,
//! and keep what it doesn't show (see `rescaled`): polygons cut corners, and measuring from them would shrink every
//! drop a little each time. A particle keeps its fluid whatever φ says; where φ disagrees, it also keeps its depth and
//! so pulls the line back: films thinner than an element come back when they grow.
//!
//! The shift δ is found by bisection, applied to the nodes and reported: nothing is added to the equations. What leaves
//! through open boundaries is counted (see `outflow`) and reported as well.

mod distance;
mod inflow_depth;
mod inlet;
mod isolated_nodes;
mod outflow;
mod rescaled;
mod solids;
mod spurious_nodes;
#[cfg(test)]
mod tests;
mod unresolved_films;
mod volume;

pub use distance::InterfacePolygons;
use distance::longest_edge;
pub use inflow_depth::{CameIn, InflowDepth};
pub use inlet::{InflowFluid, brought, on_facet};
pub use isolated_nodes::{absorb_isolated_fluids, absorb_isolated_nodes};
pub use outflow::{OpenFacet, fraction_inside, outflow};
pub use solids::{continue_fractions, continue_level};
pub use spurious_nodes::{Origins, revert_spurious_nodes};
pub use unresolved_films::absorb_unresolved_films;
pub use volume::{negative_volume, shift_to_volume};

use crate::math::Vector;
use crate::mesh::Mesh;
use crate::parallel;
use crate::pfem2::particles::Particles;
use crate::pfem2::particles::convect::MeshPoint;
use crate::pfem2::particles::project::group_sums::{GroupSumTable, GroupSums};
use crate::pfem2::phases::FluidRegion;

/// Particles nearer than this many edges, the longest of the cut elements, keep what the polygons don't show: with one
/// only, what the farther ones lose of a curve came back through slopes, and capillary waves grew.
const CORRECTION_BAND: f64 = 2.0;

/// Depths are measured up to this many edges. A slope at the node of a near element looks at nodes two edges farther
/// away, these at particles of elements whose nodes are three edges away, and the gradients at these at particles four
/// edges away: none of them may be cut off.
const BAND: f64 = CORRECTION_BAND + 4.0;

/// Steps between two measurements of the depths (theory G.3).
const MEASURED_EVERY: usize = 10;

/// |∇φ| − 1 from which on a measurement removes the whole stretch; of a smaller one it removes the part
/// ((|∇φ| − 1)/STRETCHED)² (theory (G.4)). Each measurement moves the interface a little, and waves that stretch depths
/// to and fro need none.
const STRETCHED: f64 = 0.3;

/// Depths differ from the distance to the polygons by at most this part of an edge: near ridges of φ, as in the middle
/// of a film, its slope means nothing.
const SLACK: f64 = 0.1;

/// Fluid that flows in has the depth that the inlet gives it, if that differs from the distance to the present
/// interface by no more than this part of an edge. Otherwise another interface is near the inlet, and its distance
/// counts (theory (G.6)).
const AGREES: f64 = 0.5;

/// The pseudo level set of Becker (37) from the fraction of the fluid inside: 1 − 2f.
pub fn pseudo(inside: &[f64]) -> Vec<f64> {
    // Becker (37): Σ s_p N_i / Σ N_i with s_p = −1 inside, 1 outside; theory (G.2).
    inside.iter().map(|f| 1.0 - 2.0 * f).collect()
}

/// A sharp level set.
#[derive(Debug, Clone)]
pub struct LevelSet {
    /// The fluid where φ is negative.
    pub inside: u8,
    /// φ at the nodes [m].
    pub level: Vec<f64>,
    /// Depths are known up to this [m].
    pub band: f64,
    /// Steps since depths were measured.
    pub age: usize,
}

impl LevelSet {
    /// Starts with φ(x) [m], negative in the fluid `inside` and a distance near its zero line, and gives the particles
    /// their depths. Particles whose fluid disagrees with φ lie on the interface.
    pub fn new<const D: usize, const N: usize>(
        mesh: &Mesh<D, N>,
        inside: u8,
        phi: impl Fn(Vector<D>) -> f64 + Sync,
        particles: &mut Particles<D>,
    ) -> Self {
        let level: Vec<f64> = parallel::collect(mesh.nodes().len(), 256, |node| phi(mesh.nodes()[node]));
        let interface = InterfacePolygons::new(&FluidRegion::whole(mesh), &level);
        // Without an interface yet, a fluid may still flow in.
        let longest = || (0..mesh.elements().len()).map(|e| longest_edge(&mesh.corners(e))).fold(0.0, f64::max);
        let edge = if interface.is_empty() { longest() } else { interface.longest_edge() };
        let band = BAND * edge;
        let set = Self { inside, level, band, age: 0 };
        let Particles { position, phase, depth, .. } = particles;
        parallel::fill(depth, 256, |p| (set.sign(phase[p]) * phi(position[p])).max(0.0));
        set
    }

    /// φ from the depths that the particles carried here and what `open_facets` bring, continued into solids; every tenth
    /// time depths are measured anew.
    pub fn update<const D: usize, const N: usize>(
        &mut self,
        region: &FluidRegion<D, N>,
        particles: &mut Particles<D>,
        open_facets: &[OpenFacet<D>],
    ) {
        let mesh = region.mesh;
        let before = std::mem::take(&mut self.level);
        self.level = self.average(mesh, particles, &before);
        let seen = |node: usize| mesh.elements_around(node).iter().any(|&e| !particles.of(e as usize).is_empty());
        continue_level(region, seen, &mut self.level, self.band);
        let origins = Origins { before: &before, inside: self.inside, particles, open_facets };
        revert_spurious_nodes(region, &origins, &mut self.level);
        self.age += 1;
        if self.age >= MEASURED_EVERY {
            self.measure(region, particles);
        }
    }

    /// The fluid where φ is not negative: a sharp level set has two.
    pub fn outside(&self) -> u8 {
        1 - self.inside
    }

    /// Fluid and depth at a place.
    pub fn at<const D: usize, const N: usize>(&self, mesh: &Mesh<D, N>, place: &MeshPoint<N>) -> (u8, f64) {
        let phi = value(mesh, place, &self.level);
        (if phi < 0.0 { self.inside } else { self.outside() }, phi.abs())
    }

    /// Longest edge of the elements around the interface, when it was last measured [m].
    pub fn edge(&self) -> f64 {
        self.band / BAND
    }

    /// φ [m] of a fluid at a depth [m].
    pub fn signed(&self, fluid: u8, depth: f64) -> f64 {
        self.sign(fluid) * depth
    }

    fn sign(&self, fluid: u8) -> f64 {
        if fluid == self.inside { -1.0 } else { 1.0 }
    }

    /// Nodes whose particles are all deeper than the band take ± the band; nodes without particles keep φ, `before`
    /// [m].
    fn average<const D: usize, const N: usize>(
        &self,
        mesh: &Mesh<D, N>,
        particles: &Particles<D>,
        before: &[f64],
    ) -> Vec<f64> {
        let near = self.near(mesh, particles);
        let mut table = GroupSumTable::<1, N>::collect(mesh.elements().len(), |e, entries| {
            let own = particles.of(e);
            if !near[e] || own.is_empty() {
                return;
            }
            let mut sums = GroupSums::new(0);
            for p in own.clone() {
                let phi = self.sign(particles.phase[p]) * particles.depth[p].min(self.band);
                sums.add(&mesh.shape_functions(e, particles.position[p]), Vector([phi]));
            }
            entries.put(&sums);
            entries.weigh(mesh.simplex(e).volume / own.len() as f64);
        });
        table.make_linear(mesh, 1, |_| false);
        let level = |node: usize| {
            let around = mesh.elements_around(node).iter().map(|&e| e as usize);
            if !around.clone().any(|e| near[e]) {
                let fluid = around.flat_map(|e| particles.of(e)).next().map(|p| particles.phase[p]);
                return fluid.map_or(before[node], |fluid| self.sign(fluid) * self.band);
            }
            let (mut sum, mut weight) = (0.0, 0.0);
            for e in around {
                for entry in table.of(e) {
                    let k = mesh.elements()[e].iter().position(|&n| n as usize == node).unwrap_or(0);
                    sum += entry.weight * entry.values[k][0];
                    weight += entry.weight * entry.sum(k);
                }
            }
            if weight > 0.0 { (sum / weight).clamp(-self.band, self.band) } else { before[node] }
        };
        parallel::collect(mesh.nodes().len(), 256, level)
    }

    /// Elements around nodes whose particles are not all deep in one fluid.
    fn near<const D: usize, const N: usize>(&self, mesh: &Mesh<D, N>, particles: &Particles<D>) -> Vec<bool> {
        let elements = mesh.elements().len();
        let shallow = |e: usize| {
            let own = particles.of(e);
            let mixed = particles.phase[own.clone()].windows(2).any(|pair| pair[0] != pair[1]);
            mixed || particles.depth[own].iter().any(|&depth| depth < 0.99 * self.band)
        };
        let shallow = parallel::collect(elements, 256, shallow);
        let node = |node: usize| {
            let around = mesh.elements_around(node);
            let fluids = || around.iter().filter_map(|&e| particles.of(e as usize).next()).map(|p| particles.phase[p]);
            around.iter().any(|&e| shallow[e as usize]) || fluids().any(|fluid| Some(fluid) != fluids().next())
        };
        let node = parallel::collect(mesh.nodes().len(), 256, node);
        parallel::collect(elements, parallel::CHUNK, |e| mesh.elements()[e].iter().any(|&n| node[n as usize]))
    }

    /// Measures the depths d of the particles that φ shows in their fluid anew (theory (G.4)):
    ///
    /// ```text
    /// far    d ← s D                                    D: signed distance from the polygons where φ = 0
    /// near   d ← d + r (u − d), |d − s D| ≤ slack, d ≥ 0
    ///        u = s D̃ + (d − s φ)/ψ,   r = min(1, ((ψ − 1)/STRETCHED)²)
    /// ```
    ///
    /// with the sign s of the fluid, the straightened level set D̃ and the slope ψ = |∇φ| of the nodes around.
    fn measure<const D: usize, const N: usize>(&mut self, region: &FluidRegion<D, N>, particles: &mut Particles<D>) {
        let mesh = region.mesh;
        let interface = InterfacePolygons::new(region, &self.level);
        self.age = 0;
        if interface.is_empty() {
            return;
        }
        self.band = BAND * interface.longest_edge();
        // Signed, so that in cut elements, too, the distance of a plane is linear.
        let mut distance = interface.distances(mesh, self.band);
        distance.iter_mut().zip(&self.level).for_each(|(distance, phi)| *distance = distance.copysign(*phi));
        let (straightened, slope) = (self.straightened(mesh), self.slopes(mesh));
        let slack = SLACK * interface.longest_edge();
        let Particles { position, element, phase, depth, .. } = particles;
        parallel::change(depth, 256, |p, depth| {
            let e = element[p] as usize;
            let place = MeshPoint { element: e, shape: mesh.shape_functions(e, position[p]) };
            let (sign, phi) = (self.sign(phase[p]), value(mesh, &place, &self.level));
            if sign * phi < 0.0 {
                return;
            }
            let far_depth = sign * value(mesh, &place, &distance);
            let is_near = far_depth < CORRECTION_BAND * interface.longest_edge();
            let psi = value(mesh, &place, &slope);
            let unstretched =
                known(mesh, &place, &straightened).map(|straight| sign * straight + (*depth - sign * phi) / psi);
            *depth = match unstretched.filter(|u| is_near && u.is_finite()) {
                Some(u) => near_depth(*depth, u, psi).clamp(far_depth - slack, far_depth + slack).max(0.0),
                None => far_depth,
            };
        });
    }

    /// |∇φ| at the nodes: of the mean gradient of the elements around.
    fn slopes<const D: usize, const N: usize>(&self, mesh: &Mesh<D, N>) -> Vec<f64> {
        let slope = |node: usize| {
            let around = || mesh.elements_around(node).iter().map(|&e| (e as usize, mesh.simplex(e as usize).volume));
            let sum: Vector<D> = around().map(|(e, volume)| self.gradient(mesh, e) * volume).sum();
            sum.norm() / around().map(|(_, volume)| volume).sum::<f64>()
        };
        parallel::collect(mesh.nodes().len(), 256, slope)
    }
}

/// d + r (u − d): the depth `d` [m] and what it would be without the stretch, `u` [m], by the slope `psi` of φ (theory
/// (G.4)).
fn near_depth(d: f64, u: f64, psi: f64) -> f64 {
    let r = ((psi - 1.0) / STRETCHED).powi(2).min(1.0);
    d + r * (u - d)
}

/// Σ N_i f_i, if all are known.
fn known<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    place: &MeshPoint<N>,
    values: &[Option<f64>],
) -> Option<f64> {
    place.shape.iter().zip(&mesh.elements()[place.element]).map(|(n, &node)| Some(n * values[node as usize]?)).sum()
}

/// Σ N_i f_i.
fn value<const D: usize, const N: usize>(mesh: &Mesh<D, N>, place: &MeshPoint<N>, values: &[f64]) -> f64 {
    place.shape.iter().zip(&mesh.elements()[place.element]).map(|(n, &node)| n * values[node as usize]).sum()
}
