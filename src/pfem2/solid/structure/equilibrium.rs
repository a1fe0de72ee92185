//! Solids at rest under their loads, by Newton's method in steps of the load (theory J.1).
//!
//! ```text
//! K(u) δu = λ f(u) − F(u),      u ← u + δu,      λ from 0 to 1
//! ```
//!
//! K holds −λ ∂f/∂u of pressures that follow the surface. A step of the load that doesn't converge, or turns an element
//! inside out, is halved. Prescribed components and rigid solids stay where they are.

use super::Structure;
use crate::error::{Place, StepError};
use crate::linalg::{MatrixEntry, SparseFactor};
use crate::math::Vector;
use crate::pfem2::solid::equations::{IndependentInertia, LinearForces, SolidEquations};

/// Out-of-balance forces this small, relative to loads and internal forces, end the iteration.
const TOLERANCE: f64 = 1e-10;

/// Changes this small, relative to the extent of the solids, are rounding.
const ROUNDING: f64 = 1e-14;

/// Newton's method converges quadratically; it takes more iterations only where the load step is too large.
const ITERATIONS: usize = 25;

/// The smallest step of the load.
const SMALLEST_STEP: f64 = 1.0 / 4096.0;

impl<const D: usize> Structure<D> {
    /// Finds the displacement at which the solids bear their loads at time `t` [s] and gravity in a place [m/s²];
    /// velocities stay as they are. Where there are several, it is the one that growing loads lead to. Returns
    /// the number of iterations.
    ///
    /// # Errors
    /// No equilibrium is found: the solids may move freely, or buckle. The displacement is then that of before.
    pub fn equilibrium(&mut self, t: f64, gravity: impl Fn(Vector<D>) -> Vector<D>) -> Result<usize, StepError> {
        let start = self.state.displacement.clone();
        let (mut load, mut step, mut iterations) = (0.0f64, 1.0f64, 0);
        while load < 1.0 {
            let aim = (load + step).min(1.0);
            let before = self.state.displacement.clone();
            match self.iterate(t, aim, &gravity) {
                Ok(taken) => {
                    (load, step) = (aim, 2.0 * step);
                    iterations += taken;
                }
                Err(_) if step > SMALLEST_STEP => {
                    self.state.displacement = before;
                    step *= 0.5;
                }
                Err(error) => {
                    self.state.displacement = start;
                    return Err(error);
                }
            }
        }
        Ok(iterations)
    }

    /// Newton's method at a part of the load. Returns the number of iterations.
    ///
    /// # Errors
    /// As [`Structure::equilibrium`].
    fn iterate(&mut self, t: f64, load: f64, gravity: &impl Fn(Vector<D>) -> Vector<D>) -> Result<usize, StepError> {
        let mut factor: Option<SparseFactor> = None;
        let velocities = self.independent_at_rest();
        let mut change = vec![0.0; velocities.count()];
        let mut excess = f64::INFINITY;
        let extent = self.extent();
        for iteration in 0..ITERATIONS {
            let (equations, scale) = self.imbalance(t, load, gravity)?;
            let (matrix, rhs) = equations.independent(&[], &vec![0.0; equations.rhs.len()]);
            excess = rhs.iter().fold(0.0, |most: f64, r| most.max(r.abs())) / scale.max(f64::MIN_POSITIVE);
            if excess <= TOLERANCE {
                return Ok(iteration);
            }
            let renewed = match factor.take() {
                Some(factor) => factor.renewed(&matrix),
                None => SparseFactor::new(&matrix),
            };
            let factor = factor.insert(renewed.ok_or_else(|| no_equilibrium(excess))?);
            factor.solve(&rhs, &mut change);
            if change.iter().any(|change| !change.is_finite()) {
                return Err(no_equilibrium(excess));
            }
            if change.iter().all(|change| change.abs() <= ROUNDING * extent) {
                return Ok(iteration);
            }
            let nodal = velocities.added(&change);
            let own = self.state.displacement.iter_mut().zip(nodal.chunks_exact(D));
            own.for_each(|(u, change)| *u += Vector::from_fn(|axis| change[axis]));
        }
        Err(no_equilibrium(excess))
    }

    /// K δu = λ f − F(u), and the largest of the forces [N].
    ///
    /// # Errors
    /// As [`Structure::equations`].
    fn imbalance(
        &self,
        t: f64,
        load: f64,
        gravity: &impl Fn(Vector<D>) -> Vector<D>,
    ) -> Result<(SolidEquations, f64), StepError> {
        let mut matrix = self.zero_matrix();
        let mut rhs = self.external_forces(t, &self.state.displacement, gravity);
        rhs.iter_mut().for_each(|force| *force *= load);
        let mut scale = rhs.iter().fold(0.0, |most: f64, force| most.max(force.abs()));
        self.visit(&self.state.displacement, |_, nodes, forces| {
            for (a, &row) in nodes.iter().enumerate() {
                for axis in 0..D {
                    rhs[row as usize * D + axis] -= forces.internal[a][axis];
                    scale = scale.max(forces.internal[a][axis].abs());
                }
                for (b, &column) in nodes.iter().enumerate() {
                    self.add_block(&mut matrix, (row, column), &forces.tangent(a, b));
                }
            }
        })?;
        self.pressures.stiffness(t, &self.positions(&self.state.displacement), |nodes, slope| {
            self.add_block(&mut matrix, nodes, &(slope * -load));
        });
        let mut linear = LinearForces::default();
        self.springs.visit(&self.state.displacement, |k, stiffness, force| {
            linear.entries.push(MatrixEntry::new(k, k, stiffness));
            rhs[k as usize] += force;
            scale = scale.max(force.abs());
        });
        let (inertia, velocities) = (IndependentInertia::default(), self.independent_at_rest());
        let volume_slopes = self.volume_slopes(&self.positions(&self.state.displacement));
        Ok((SolidEquations { matrix, rhs, linear, inertia, velocities, volume_slopes }, scale))
    }
}

fn no_equilibrium(excess: f64) -> StepError {
    StepError::new(
        Place::Everywhere,
        "the solids find no equilibrium under their loads",
        "relative force out of balance",
        excess,
        "hold the solids so that they can't move freely, or start without equilibrium",
    )
}
