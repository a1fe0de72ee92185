//! The visits over sorted particles, block by block: what a run uses (theory A.1). [`super::plain`] is their
//! specification, one particle at a time.

use super::visitor::{Executor, Gathering, Nodal, Scattering, Targets};
use crate::mpm::Grid;
use crate::mpm::grid::tile::{NodeRecord, put_acceleration, put_scalar, put_velocity};
use crate::mpm::particles::{Body, Summary};
use crate::mpm::transfer::{Chunk, GatherFields, Sweep};

/// Executes visits with private tiles of the grid.
#[derive(Debug)]
pub(in crate::mpm) struct Tiles;

/// Runs an expression, compiled for each kind of nodal field, with the function that sets what is read of a node.
macro_rules! with_nodes {
    ($nodal:expr, $fields:expr, $node:ident => $run:expr) => {
        match $nodal {
            Nodal::Motion(nodes) if $fields.has_acceleration() => {
                let $node = |n: usize, record: &mut NodeRecord| {
                    put_velocity(record, &nodes[n].velocity());
                    put_acceleration(record, &nodes[n].acceleration());
                };
                $run
            }
            Nodal::Motion(nodes) => {
                let $node = |n: usize, record: &mut NodeRecord| put_velocity(record, &nodes[n].velocity());
                $run
            }
            Nodal::MidstepVelocity(nodes, dt) => {
                let $node = |n: usize, record: &mut NodeRecord| {
                    put_velocity(record, &nodes[n].midstep_velocity(dt));
                };
                $run
            }
            Nodal::Velocity { scalar, .. } if $fields == GatherFields::Scalar => {
                let $node = |n: usize, record: &mut NodeRecord| put_scalar(record, scalar[n][0]);
                $run
            }
            Nodal::Velocity { velocity, scalar: [] } => {
                let $node = |n: usize, record: &mut NodeRecord| put_velocity(record, &velocity[n]);
                $run
            }
            Nodal::Velocity { velocity, scalar } => {
                let $node = |n: usize, record: &mut NodeRecord| {
                    put_scalar(record, scalar[n][0]);
                    put_velocity(record, &velocity[n]);
                };
                $run
            }
        }
    };
}

impl<const D: usize> Executor<D> for Tiles {
    fn scatter(&self, grid: &Grid<D>, field: usize, body: &mut Body<D>, scattering: Scattering<'_, D>) {
        let Scattering { content, targets } = scattering;
        let sweep = Sweep::new(grid, field, body);
        match targets {
            // The first scatter of a step finds the parts of the tiles that the particles reach.
            Targets::Nodes(nodes) => body.bins.extents = sweep.scatter(nodes, body, content),
            Targets::Momentum(momentum) => drop(sweep.scatter(momentum, body, content)),
            Targets::Sums(sums) => drop(sweep.scatter(sums, body, content)),
        }
    }

    fn gather(&self, grid: &Grid<D>, field: usize, body: &mut Body<D>, gathering: Gathering<'_, D>) -> Summary {
        let Gathering { nodal, operations } = gathering;
        let affine = !body.particles.affine.is_empty();
        let (sweep, law, view) = body.sweep(grid, field);
        let fields = operations.fields(law, affine);
        let perform = |chunk: &mut Chunk<'_, D>| operations.perform(law, chunk);
        with_nodes!(nodal, fields, node => sweep.gather(node, view, fields, perform))
    }

    fn relay(
        &self,
        grid: &Grid<D>,
        field: usize,
        body: &mut Body<D>,
        gathering: Gathering<'_, D>,
        scattering: Scattering<'_, D>,
    ) -> Summary {
        let (Gathering { nodal, operations }, Scattering { content, targets }) = (gathering, scattering);
        let affine = !body.particles.affine.is_empty();
        let (sweep, law, view) = body.sweep(grid, field);
        let fields = operations.fields(law, affine);
        let perform = |chunk: &mut Chunk<'_, D>| operations.perform(law, chunk);
        with_nodes!(nodal, fields, node => match targets {
            Targets::Nodes(nodes) => sweep.relay(node, view, fields, content, nodes, perform),
            Targets::Momentum(momentum) => sweep.relay(node, view, fields, content, momentum, perform),
            Targets::Sums(sums) => sweep.relay(node, view, fields, content, sums, perform),
        })
    }
}
