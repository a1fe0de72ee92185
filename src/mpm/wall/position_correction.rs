//! Positions of particles within obstacles, or beyond walls with contact at the surface, are corrected at the end of a
//! step, after both have moved (theory E.8).
//!
//! ```text
//! d(x_p) ≥ r_min:   else   x_p ← x_p + (r_min − d) ν   d, ν: exact distance and normal of the obstacle; r_min: half the reach of
//! the body there
//! ```
//!
//! Conditions stop velocities at points of the surface, not the positions of particles: under pressure these creep in
//! between, as they do at sheets (`contact::sheet::guard`). Neither momentum nor energy changes; the work that the
//! forces would have done along the displacement is booked (`shifting`).
//!
//! A body that starts within an obstacle, clamped by it, say, is not corrected.

use super::{BodiesAtWalls, Walls};
use crate::math::Vector;
use crate::mpm::LeapfrogStep;
use crate::mpm::particles::{Bodies, Body};

/// The least distance from an obstacle over the reach of the body.
pub(super) const LEAST_OBSTACLE_DISTANCE: f64 = 0.5;

/// A particle lies within an obstacle at the start if it is so deep below its surface [edges of its volume].
const WITHIN: f64 = 0.25;

/// Corrections of a particle that several obstacles displace.
const TRIES: usize = 4;

impl<const D: usize> Walls<D> {
    /// Records which of the bodies start within which obstacles.
    pub fn note_overlaps(&mut self, bodies: &Bodies<D>) {
        let within = |body: &Body<D>, obstacle: usize| {
            let particles = &body.particles;
            let edges = particles.volume.iter().map(|volume| volume.powf(1.0 / D as f64));
            particles.position.iter().zip(edges).any(|(&x, e)| self.obstacle_distance(obstacle, x) < -WITHIN * e)
        };
        let all = (0..bodies.len()).flat_map(|body| (0..self.regions.len()).map(move |obstacle| (body, obstacle)));
        let overlaps = all.filter(|&(body, obstacle)| within(&bodies[body], obstacle));
        self.overlaps = overlaps.map(|(body, obstacle)| [body as u32, (2 * D + obstacle) as u32]).collect();
    }

    /// True if a body started within an obstacle.
    pub(super) fn starts_within(&self, body: usize, boundary: usize) -> bool {
        self.overlaps.contains(&[body as u32, boundary as u32])
    }

    /// True if any body started within an obstacle.
    pub(super) fn holds_a_body(&self, boundary: usize) -> bool {
        self.overlaps.iter().any(|overlap| overlap[1] as usize == boundary)
    }

    /// The displacements of particles out of the obstacles at the end of a step: number of the body, particle,
    /// displacement [m].
    pub(in crate::mpm) fn position_corrections(
        &self,
        cell: f64,
        field: usize,
        bodies: &BodiesAtWalls<'_, D>,
        step: &LeapfrogStep,
    ) -> Vec<(usize, u32, Vector<D>)> {
        let obstacles = self.surfaces(field);
        if obstacles.is_empty() {
            return Vec::new();
        }
        bodies.collect(
            |block| self.near[block],
            |(number, body), p| {
                let start = body.particles.position[p];
                let mut x = start;
                for _ in 0..TRIES {
                    let mut fits = true;
                    for obstacle in &obstacles {
                        if self.starts_within(number, obstacle.number()) {
                            continue;
                        }
                        let (distance, normal) = obstacle.distance(x, obstacle.velocity(x, step) * step.dt);
                        let missing = LEAST_OBSTACLE_DISTANCE * body.reach(p, normal, cell) - distance;
                        if missing > 0.0 && !(bodies.shielded)(x, normal, distance) {
                            (x, fits) = (x + normal * missing, false);
                        }
                    }
                    if fits {
                        break;
                    }
                }
                if x == start { Vec::new() } else { vec![(number, p as u32, x - start)] }
            },
        )
    }
}
