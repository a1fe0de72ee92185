//! The interface of the methods of contact between a sheet and the bodies (theory D.1).
//!
//! All methods know the sheet as [`ContactSheet`] and the bodies' nodes as [`Partners`], and exchange impulses between
//! the two. They differ in the places at which contact is detected and resolved: at grid nodes ([`super::at_nodes`]) or
//! on the surface of the sheet ([`super::at_surface`]).

use super::impulse::ContactTotals;
use super::partner::Partners;
use super::sheet::{ContactSheet, GuardedParticle, ParticleShift};
use super::surface::SheetSurface;
use crate::mpm::particles::Bodies;
use crate::mpm::wall::folded_stencil::FoldedStencil;
use crate::mpm::{Grid, SubStep};
use std::fmt::Debug;

/// The bodies and the grid at the start of a step.
pub struct StepContext<'a, const D: usize> {
    pub grid: &'a Grid<D>,
    pub stencil: &'a FoldedStencil<D>,
    pub bodies: &'a Bodies<D>,
    /// Number of the step, from 1, and its length [s].
    pub step: u64,
    pub dt: f64,
}

/// A method of contact between one sheet and the bodies, in the order in which a step calls it.
pub trait ContactMethod<const D: usize>: Debug + Send + Sync {
    /// Finds the particles that may touch the sheet during the step. Labels the particles around it with their sides,
    /// and adds those that have one to `guarded`. Returns how many have crossed the sheet since the last step.
    fn find(
        &mut self,
        sheet: &mut ContactSheet<D>,
        surface: &SheetSurface<'_, D>,
        context: &StepContext<'_, D>,
        guarded: &mut Vec<GuardedParticle<D>>,
    ) -> u64;

    /// True if the sheet runs between two fields at a grid node.
    fn separates(&self, node: usize, fields: [usize; 2]) -> bool;

    /// Adds the bodies' nodes that may take impulses to the partners.
    fn choose(&mut self, sheet: &ContactSheet<D>, context: &StepContext<'_, D>, partners: &mut Partners<D>);

    /// Resolves contact at the end of a sub-step, with walls and obstacles, in the pass of this number, from 0: adds
    /// the forces on the sheet's nodes, in further passes their change, to [`ContactSheet::forces`].
    fn resolve(
        &mut self,
        sheet: &mut ContactSheet<D>,
        surface: &SheetSurface<'_, D>,
        partners: &mut Partners<D>,
        pass: usize,
        at: &SubStep<'_>,
    );

    /// Ends the sub-step, with the velocities that the nodes have in the end. Returns the energy that mapping has lost
    /// [J].
    fn conclude(
        &mut self,
        sheet: &ContactSheet<D>,
        surface: &SheetSurface<'_, D>,
        partners: &Partners<D>,
        at: &SubStep<'_>,
    ) -> f64;

    /// Ends the step. Adds the displacements that part the particles of each body from the sheet to `shifts`, and keeps
    /// with their labels the forces from which the next step starts.
    fn finish(&self, sheet: &mut ContactSheet<D>, shifts: &mut [Vec<ParticleShift<D>>]);

    /// Adds the impulses and losses of the step to `sums`, field by field, when the momentum on the grid is final. The
    /// step was of the length `dt` [s].
    fn add_totals(&self, partners: &Partners<D>, grid: &Grid<D>, dt: f64, sums: &mut [ContactTotals<D>]);

    /// True if contact acts at grid nodes, and the sheet lies in the support of this one.
    fn meets(&self, node: usize) -> bool;
}
