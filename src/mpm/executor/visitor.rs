//! The executor of the visits of a step: the seam between the algorithm and the way in which its sums are computed.

use super::operations::{OperationParameters, Operations};
use super::visit::{Onto, Operation, Read, Visit};
use crate::error::StepError;
use crate::math::Vector;
use crate::mpm::grid::{Ghosts, Grid, Node, NodeMotion, VelocityField};
use crate::mpm::motion::Landing;
use crate::mpm::particles::{Body, Reduce, Summary, health};
use crate::mpm::stress::average;
use crate::mpm::transfer::{ScatterContent, View};

/// The nodal fields of a gather.
#[derive(Clone, Copy)]
pub(in crate::mpm) enum Nodal<'a, const D: usize> {
    /// v⁺ and a of finished nodes.
    Motion(&'a [NodeMotion<D>]),
    /// v̂ = v⁺ − ½ Δt a of finished nodes, and Δt [s].
    MidstepVelocity(&'a [NodeMotion<D>], f64),
    /// A velocity [m/s], and a scalar; none where that is empty.
    Velocity { velocity: &'a [Vector<D>], scalar: &'a [[f64; 1]] },
}

/// The nodes that a scatter adds to.
pub(in crate::mpm) enum Targets<'a, const D: usize> {
    /// (m, p, f).
    Nodes(&'a mut [Node<D>]),
    /// Momentum alone [N s].
    Momentum(&'a mut [Vector<D>]),
    /// Two scalars.
    Sums(&'a mut [[f64; 2]]),
}

/// A gather: the nodal fields that it reads, and the operations on the particles.
#[derive(Clone, Copy)]
pub(in crate::mpm) struct Gathering<'a, const D: usize> {
    pub nodal: Nodal<'a, D>,
    pub operations: Operations<'a, D>,
}

/// A scatter: the quantities, and the nodes that they are added to.
pub(in crate::mpm) struct Scattering<'a, const D: usize> {
    pub content: ScatterContent,
    pub targets: Targets<'a, D>,
}

/// Computes the sums over the particles of a body of the velocity field number `field`, and performs operations with
/// them.
pub(in crate::mpm) trait Executor<const D: usize>: std::fmt::Debug + Send + Sync {
    /// Adds the contributions of the particles to the nodes.
    fn scatter(&self, grid: &Grid<D>, field: usize, body: &mut Body<D>, scattering: Scattering<'_, D>);

    /// Performs operations on the particles with the sums over the nodes around them.
    fn gather(&self, grid: &Grid<D>, field: usize, body: &mut Body<D>, gathering: Gathering<'_, D>) -> Summary;

    /// Does both, in one sweep where that is faster: the nodes that are read are others than those that are added to.
    fn relay(
        &self,
        grid: &Grid<D>,
        field: usize,
        body: &mut Body<D>,
        gathering: Gathering<'_, D>,
        scattering: Scattering<'_, D>,
    ) -> Summary {
        let summary = self.gather(grid, field, body, gathering);
        if !summary.inverted {
            self.scatter(grid, field, body, scattering);
        }
        summary
    }

    /// Moves the particles by the rates that were kept.
    fn land(&self, body: &mut Body<D>, landing: &Landing<D>) -> Summary {
        body.view().1.visit(&|chunk: &mut View<'_, D>| landing.land(chunk))
    }
}

/// All that the visits of a stage share.
#[derive(Clone, Copy)]
pub(in crate::mpm) struct Visitor<'a, const D: usize> {
    /// The executor.
    pub executor: &'a dyn Executor<D>,
    /// The grid, but for the field whose bodies are visited.
    pub grid: &'a Grid<D>,
    /// Number of that field.
    pub field: usize,
    /// Ghosts of the grid.
    pub ghosts: &'a Ghosts<D>,
    /// The numbers of the step.
    pub parameters: OperationParameters<D>,
}

impl<const D: usize> Visitor<'_, D> {
    /// Sweeps over the particles of a body of the velocity field `own`, one visit after the other, and adds their
    /// energies, largest speeds and findings to the body's summary.
    ///
    /// # Errors
    /// When a particle's volume would become negative or is not a number.
    pub fn run(&self, visits: &[Visit], own: &mut VelocityField<D>, body: &mut Body<D>) -> Result<(), StepError> {
        for visit in visits {
            let summary = self.visit(visit, own, body);
            if summary.inverted {
                return Err(health::inverted(body));
            }
            body.summary = body.summary.plus(summary);
        }
        Ok(())
    }

    fn visit(&self, visit: &Visit, own: &mut VelocityField<D>, body: &mut Body<D>) -> Summary {
        let &Self { executor, grid, field, .. } = self;
        match visit {
            Visit::Scatter(content, onto) => {
                executor.scatter(grid, field, body, lend(own, Some(*onto)).scattering(*content));
                Summary::default()
            }
            Visit::Gather(Read::MidstepVelocity, _) if body.work.mean.is_empty() => Summary::default(),
            Visit::Gather(read, list) => {
                let operations = self.prepare(*read, list, own, body);
                let nodal = self.nodal(*read, operations.heated, &lend(own, None));
                executor.gather(grid, field, body, Gathering { nodal, operations })
            }
            Visit::Relay(read, list, content, onto) => {
                let operations = self.prepare(*read, list, own, body);
                let lent = lend(own, Some(*onto));
                let nodal = self.nodal(*read, operations.heated, &lent);
                executor.relay(grid, field, body, Gathering { nodal, operations }, lent.scattering(*content))
            }
            Visit::Land => executor.land(body, &self.parameters.landing),
        }
    }

    /// The operations of a visit; averages that it reads are made of the sums that were scattered last.
    fn prepare<'a>(
        &self,
        read: Read,
        list: &'a [Operation],
        own: &mut VelocityField<D>,
        body: &mut Body<D>,
    ) -> Operations<'a, D> {
        if read == Read::Averages {
            average::divide(self.ghosts, &own.limits, &mut own.sums, &mut own.means);
        }
        if list.contains(&Operation::AveragePressure) {
            body.work.excess.resize(body.particles.len(), 0.0);
        }
        Operations::new(list, &self.parameters, self.grid, body)
    }

    /// The nodal fields that a visit reads.
    fn nodal<'a>(&self, read: Read, heated: bool, lent: &Lent<'a, D>) -> Nodal<'a, D> {
        let scalar = match read {
            Read::Averages => lent.means,
            _ if heated => lent.heat,
            _ => &[],
        };
        match read {
            Read::MidstepVelocity => Nodal::MidstepVelocity(lent.motion, self.parameters.momentum_dt),
            Read::Motion => Nodal::Motion(lent.motion),
            Read::Strain | Read::Averages => Nodal::Velocity { velocity: lent.velocity, scalar },
        }
    }
}

/// The arrays of a field, all but one to be read.
struct Lent<'a, const D: usize> {
    /// Motion of finished nodes.
    motion: &'a [NodeMotion<D>],
    velocity: &'a [Vector<D>],
    heat: &'a [[f64; 1]],
    means: &'a [[f64; 1]],
    targets: Option<Targets<'a, D>>,
}

impl<'a, const D: usize> Lent<'a, D> {
    fn scattering(self, content: ScatterContent) -> Scattering<'a, D> {
        Scattering { content, targets: self.targets.expect("a scatter has nodes to add to") }
    }
}

/// Lends the arrays of a field, one of them to be added to; sums start from zero.
fn lend<const D: usize>(field: &mut VelocityField<D>, onto: Option<Onto>) -> Lent<'_, D> {
    let VelocityField { nodes, velocity, heat, sums, means, .. } = field;
    let (motion, velocity, targets): (&[Node<D>], &[Vector<D>], _) = match onto {
        None => (nodes, velocity, None),
        Some(Onto::Nodes) => (&[], velocity, Some(Targets::Nodes(nodes))),
        Some(Onto::Velocity) => (nodes, &[], Some(Targets::Momentum(velocity))),
        Some(Onto::Sums) => {
            sums.clear();
            sums.resize(nodes.len(), [0.0; 2]);
            (nodes, velocity, Some(Targets::Sums(sums)))
        }
    };
    Lent { motion: NodeMotion::of(motion), velocity, heat, means, targets }
}
