//! The steps of the membranes, which meet the bodies on the grid (theory C.9, D.1, E.3, E.11; Lian, Liu & Zhang 2014,
//! section 6, 3 and 4).
//!
//! The stable step of a stiff membrane may be hundreds of times smaller than that of the bodies. Then it takes
//! n sub-steps of Δt/n, each against the trial state p̄(τ) = p⁻ + τ f of the bodies at its time, with their
//! weights and masses frozen; the bodies receive the sum of the impulses. With n = 1 this is the step of the paper.
//!
//! The grid stops a sheet by the lumped masses of its nodes, so the elements' nodes take up less than that. In each
//! pass of contact the sheet is mapped anew and the impulses are corrected, as in a projected Gauss–Seidel iteration
//! (theory D.7). With a single pass, as in the paper, a sheet at rest under pressure lets the gas creep, and the gas
//! loses energy for ever.

use super::contact::{ContactPass, Contacts, FrictionTable, NodePositions, SheetFacet, SheetSource, SheetSurface};
use super::membrane::Membrane;
use super::particles::Bodies;
use super::proximity::Proximity;
use super::wall::Walls;
use super::wall::folded_stencil::FoldedStencil;
use super::{Grid, LeapfrogStep, MembraneSetup, SheetContact, SubStep};
use crate::error::{Diagnostic, StepError};
use crate::math::{Signal, Vector};
use crate::simulation::Timer;
use crate::timed;

/// A membrane lies between a particle and something rigid if the cosine of the angle between the shortest lines from
/// the particle to the two is above this ...
const FACING_COSINE: f64 = 0.7;

/// ... and the membrane is no farther from the particle than the rigid surface, but for this overlap [cells].
const OVERLAP_ALLOWED: f64 = 0.1;

/// All membranes of a run, and everything that touches.
#[derive(Debug)]
pub struct Coupling<const D: usize> {
    /// The membranes.
    pub membranes: Vec<Membrane<D>>,
    /// Contact of membranes with bodies, and of bodies with each other.
    pub contact: Contacts<D>,
    /// Membranes that meet each other or themselves.
    pub(in crate::mpm) proximity: Proximity<D>,
    settings: CouplingSettings,
}

/// Contact of membranes with bodies, and the sub-steps of the membranes.
#[derive(Debug, Clone, Copy)]
pub struct CouplingSettings {
    /// Contact of membranes and bodies.
    pub contact: SheetContact,
    /// Gap below which they do [m].
    pub gap_tolerance: f64,
    /// Fraction of the stable step of a membrane.
    pub safety: f64,
    /// Most sub-steps per step.
    pub max_substeps: usize,
    /// Passes of contact per sub-step.
    pub passes: usize,
}

/// The membranes of a case under gravity.
///
/// # Errors
/// The findings of every membrane, with their keys.
pub fn build_membranes<const D: usize>(
    setups: Vec<MembraneSetup<D>>,
    gravity: &[Signal; D],
) -> Result<Vec<Membrane<D>>, Vec<Diagnostic>> {
    let (mut membranes, mut findings) = (Vec::new(), Vec::new());
    for (index, setup) in setups.into_iter().enumerate() {
        match Membrane::new(setup) {
            Ok(membrane) => membranes.push(membrane.with_gravity(gravity.clone())),
            Err(found) => findings.extend(found.into_iter().map(|finding| Diagnostic {
                key: format!("membrane[{index}].{}", finding.key).trim_end_matches('.').to_owned(),
                ..finding
            })),
        }
    }
    if findings.is_empty() { Ok(membranes) } else { Err(findings) }
}

impl<const D: usize> Coupling<D> {
    /// Membranes and bodies that may touch.
    pub fn new(
        membranes: Vec<Membrane<D>>,
        bodies: &Bodies<D>,
        stencil: FoldedStencil<D>,
        friction: &FrictionTable,
        settings: CouplingSettings,
    ) -> Self {
        let sources: Vec<_> = membranes.iter().map(source).collect();
        let contact = Contacts::new(stencil, friction, settings.contact, settings.gap_tolerance, bodies, &sources);
        let proximity = Proximity::new(&membranes);
        Self { membranes, contact, proximity, settings }
    }

    /// The largest stable sub-step of the membranes [s]; infinity without any.
    fn substep_bound(&self) -> f64 {
        self.membranes.iter().map(|membrane| self.settings.safety * membrane.stable_dt()).fold(f64::INFINITY, f64::min)
    }

    /// The largest step that the membranes allow [s].
    pub fn bound(&self) -> f64 {
        self.substep_bound() * self.settings.max_substeps.max(1) as f64
    }

    /// Advances the membranes over the step and exchanges impulses with the trial momentum on the grid, and with walls
    /// and obstacles.
    ///
    /// # Errors
    /// When an element collapses, a node is not finite, or walls, obstacles and supports leave one no way out.
    pub fn advance(
        &mut self,
        grid: &mut Grid<D>,
        walls: &Walls<D>,
        bodies: &Bodies<D>,
        step: &LeapfrogStep,
        timer: &mut Timer,
    ) -> Result<(), StepError> {
        let count = self.substeps(step.longer());
        let Self { membranes, contact, proximity, settings } = self;
        let offsets: Vec<Vec<f64>> = membranes.iter().map(offsets).collect();
        let surfaces: Vec<_> = membranes.iter().zip(&offsets).map(|(m, offset)| surface(m, &[], offset)).collect();
        timed!(timer, "contact", contact.begin_step(grid, walls, bodies, &surfaces, step.momentum_dt));

        membranes.iter_mut().for_each(Membrane::begin_step);
        let dt = step.dt / count as f64;
        let particles: usize = bodies.iter().map(|body| body.particles.len()).sum();
        let elements: usize = membranes.iter().map(|membrane| membrane.elements.len()).sum();
        let work = (elements + particles / count) as u64;
        // Momentum advances over the same time as that of the bodies. Otherwise a sheet in balance with its gas would
        // get an impulse wherever the step changes, above all in the first step, whose momentum advances by half of it.
        let momentum_dt = step.momentum_dt / count as f64;
        for substep in 0..count {
            let elapsed = dt * substep as f64;
            let at = SubStep { step, elapsed, dt, momentum_end: momentum_dt * (substep + 1) as f64, momentum_dt };
            for (index, (membrane, offset)) in membranes.iter_mut().zip(&offsets).enumerate() {
                let mut sheet = SheetInContact { index, offset, contact: &mut *contact, walls };
                sheet.advance(membrane, &at, settings.passes, timer)?;
            }
            timed!(timer, "proximity", proximity.survey_if_due(membranes, work, step.t + elapsed + dt));
        }
        timed!(timer, "contact", contact.finish_step(grid));
        timed!(timer, "contact", self.check_squeezed(walls, step))
    }

    /// Checks that no node is squeezed between walls, obstacles and supports.
    ///
    /// # Errors
    /// A node is.
    fn check_squeezed(&self, walls: &Walls<D>, step: &LeapfrogStep) -> Result<(), StepError> {
        self.membranes.iter().enumerate().try_for_each(|(index, membrane)| {
            let positions = NodePositions { position: &membrane.position, reference: &membrane.reference };
            let squeeze = self.contact.squeezed(index, positions, walls, step.dt);
            squeeze.map_or(Ok(()), |squeeze| Err(squeeze.error(&membrane.name)))
        })
    }

    /// Follows the membranes to where they are, for [`Self::lies_between`], if there is anything that they may shield
    /// bodies from.
    pub fn find_membranes(&mut self, walls: &Walls<D>, cell: f64) {
        if !walls.have_gaps() {
            return;
        }
        let positions: Vec<&[Vector<D>]> = self.membranes.iter().map(|membrane| &membrane.position[..]).collect();
        self.contact.find_membranes(&positions, cell);
    }

    /// True if a membrane that meets the bodies of this field lies between `x` [m] and something rigid with the normal
    /// `normal` at the distance `distance` [m].
    pub fn lies_between(&self, cell: f64, field: usize, x: Vector<D>, normal: Vector<D>, distance: f64) -> bool {
        (0..self.membranes.len()).any(|index| {
            let to = self.contact.vector_to_sheet(index, field, x, cell);
            to.is_some_and(|to| {
                to.dot(normal) < -FACING_COSINE * to.norm() && to.norm() <= distance + OVERLAP_ALLOWED * cell
            })
        })
    }

    /// Sub-steps of a step of `dt` [s].
    pub fn substeps(&self, dt: f64) -> usize {
        (dt / self.substep_bound() * (1.0 - 1e-12)).ceil().max(1.0) as usize
    }
}

/// A membrane during a sub-step, with what it meets.
struct SheetInContact<'a, const D: usize> {
    /// Number of the membrane.
    index: usize,
    /// Distance from the mid-surface to the faces, per element [m].
    offset: &'a [f64],
    contact: &'a mut Contacts<D>,
    walls: &'a Walls<D>,
}

impl<const D: usize> SheetInContact<'_, D> {
    /// One sub-step of the membrane, with so many passes of contact (theory D.7).
    fn advance(
        &mut self,
        membrane: &mut Membrane<D>,
        at: &SubStep<'_>,
        passes: usize,
        timer: &mut Timer,
    ) -> Result<(), StepError> {
        let Self { index, offset, contact, walls } = self;
        let (index, t, momentum_dt) = (*index, at.step.t + at.elapsed, at.momentum_dt);
        let previous = membrane.velocity.clone();
        timed!(timer, "membrane", membrane.internal_force(t)?); // f_K  Lian (32–45)
        timed!(timer, "membrane", membrane.advance_velocity(t, momentum_dt)); // v̄_K  Lian (46)
        for pass in 0..passes.max(1) {
            let (pass, surface) = (ContactPass { sheet: index, pass }, surface(membrane, &previous, offset));
            let force = timed!(timer, "contact", contact.resolve(pass, &surface, walls, at));
            timed!(timer, "membrane", membrane.apply_contact(force, t, momentum_dt)); // v_K   Lian (59)
        }
        let surface = surface(membrane, &previous, offset);
        timed!(timer, "contact", contact.conclude(index, &surface, at));
        timed!(timer, "membrane", membrane.move_nodes(t, at.dt)); // x_K                 Lian (47)
        timed!(timer, "contact", contact.undo_overlaps(index, &mut membrane.position, at));
        Ok(())
    }
}

/// A membrane as contact first sees it.
fn source<const D: usize>(membrane: &Membrane<D>) -> SheetSource<'_, D> {
    SheetSource {
        name: &membrane.name,
        facets: membrane.elements.iter().map(SheetFacet::new).collect(),
        reference: &membrane.reference,
        mass: &membrane.mass,
        held: (0..membrane.mass.len()).map(|k| membrane.constrained(k)).collect(),
    }
}

/// A membrane as contact sees it during a step.
fn surface<'a, const D: usize>(
    membrane: &'a Membrane<D>,
    previous: &'a [Vector<D>],
    offset: &'a [f64],
) -> SheetSurface<'a, D> {
    SheetSurface { position: &membrane.position, velocity: &membrane.velocity, previous, offset }
}

/// Distance from the mid-surface to the faces, per element [m].
fn offsets<const D: usize>(membrane: &Membrane<D>) -> Vec<f64> {
    (0..membrane.elements.len()).map(|element| membrane.contact_half_thickness(element)).collect()
}
