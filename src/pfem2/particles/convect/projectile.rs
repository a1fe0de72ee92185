//! Projectiles, heavy particles in a light fluid (Becker (36); theory G.13): they follow the velocity of their side of
//! the interface, and a ballistic path beyond it.
//!
//! ```text
//! near nodes with φ < 0      w = Σ N_i v_i,  v_i of nodes with φ ≥ 0 taken from their heavy neighbours
//! elsewhere                  w = v_p + b (t − t_0)
//! ```
//! with the body force b where the particle enters an element.
//!
//! The source divides Σ_{φ<0} N_i v_i by Σ_{φ<0} N_i instead, which is a velocity continued as a constant too; with
//! the values continued at the nodes it stays affine in every element, so that the same exact walk serves.

use super::Projectiles;
use super::crossing::TERMS;
use super::eight::Rates;
use super::streamline::{GlidingFacets, MeshPoint, Motion, Stream, Taylor};
use crate::math::Vector;
use crate::mesh::Mesh;
use crate::parallel;

/// Nodal values continued from the heavy side by one layer of nodes.
#[derive(Debug, Clone)]
pub struct Continued<const D: usize> {
    /// The values; those of nodes without a heavy neighbour are as they were.
    pub values: Vec<Vector<D>>,
    /// True for nodes with φ < 0.
    pub heavy: Vec<bool>,
}

impl<const D: usize> Continued<D> {
    /// Continues `values` beyond the nodes whose `level` φ is negative.
    pub fn new<const N: usize>(mesh: &Mesh<D, N>, values: &[Vector<D>], level: &[f64]) -> Self {
        let heavy: Vec<bool> = level.iter().map(|&phi| phi < 0.0).collect();
        let continued = |node: usize| {
            let around = mesh.elements_around(node).iter().flat_map(|&e| mesh.elements()[e as usize]);
            let (sum, count) = around
                .filter(|&other| heavy[other as usize])
                .fold((Vector::ZERO, 0.0), |(sum, count), other| (sum + values[other as usize], count + 1.0));
            if heavy[node] || count == 0.0 { values[node] } else { sum / count }
        };
        let values = parallel::collect(values.len(), 256, continued);
        Self { values, heavy }
    }

    /// True if an element has a heavy node, so that the continued values hold there.
    #[inline(always)]
    pub fn reaches<const N: usize>(&self, nodes: &[u32; N]) -> bool {
        nodes.iter().any(|&node| self.heavy[node as usize])
    }
}

/// A projectile: carried where the heavy fluid is near, on a ballistic path elsewhere.
pub(super) struct Projectile<'a, const D: usize> {
    pub stream: Stream<'a, D>,
    pub carried: &'a [bool],
    /// Velocity on the ballistic path [m/s].
    pub velocity: Vector<D>,
    /// The rule that it follows.
    pub rule: &'a Projectiles<'a, D>,
    /// Body force on the last part of the way, if that was ballistic [m/s²].
    pub body_force: Option<Vector<D>>,
}

impl<const D: usize, const N: usize> Motion<D, N> for Projectile<'_, D> {
    fn taylor(&mut self, mesh: &Mesh<D, N>, place: &MeshPoint<N>, walls: &GlidingFacets<D, N>) -> Taylor<N> {
        if self.carried[place.element] {
            self.body_force = None;
            // Becker (36), where φ < 0.
            return self.stream.taylor(mesh, place, walls);
        }
        let b = self.rule.body_force_at(&place.shape, &mesh.elements()[place.element]);
        self.body_force = Some(b);
        let gradient = &mesh.simplex(place.element).gradient;
        let rate = |v: Vector<D>| walls.project(gradient, gradient.map(|g| g.dot(v)));
        let mut terms = [[0.0; N]; TERMS];
        // Becker (36), where φ > 0: v_p + b (t − t_0); theory (G.27).
        terms[..3].copy_from_slice(&[place.shape, rate(self.velocity), rate(b * 0.5)]);
        Taylor { terms, reach: f64::INFINITY }
    }

    fn elapse(&mut self, time: f64) {
        if let Some(b) = self.body_force {
            self.velocity += b * time;
        }
    }
}

/// Field that carries heavy particles: the continued velocity [m/s], its rates, and the elements where it holds.
pub(super) struct HeavyField<const D: usize> {
    pub velocity: Vec<Vector<D>>,
    pub rates: Rates,
    pub carried: Vec<bool>,
}

impl<const D: usize> HeavyField<D> {
    pub fn new<const N: usize>(mesh: &Mesh<D, N>, velocity: &[Vector<D>], level: &[f64]) -> Self {
        let continued = Continued::new(mesh, velocity, level);
        let carried: Vec<bool> = mesh.elements().iter().map(|nodes| continued.reaches(nodes)).collect();
        let rates = Rates::new(mesh, &continued.values, |e| carried[e]);
        Self { velocity: continued.values, rates, carried }
    }
}
