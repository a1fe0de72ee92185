//! Contact on the background grid: membranes with bodies, and bodies with each other.
//!
//! Bodies and membranes first move as if they were alone. Then they exchange impulses. Membranes do so with bodies by
//! one of two methods, which the case chooses ([`SheetContact`]), with one interface (`method`):
//!
//! * `at_nodes`: at the grid nodes, as in the paper (Lian, Liu & Zhang 2014: Lian (49–59); theory D.2 to D.8);
//! * `at_surface`: on the surface of the membrane, between its elements and the particles of bodies near it (theory D.9
//!   to D.11).
//!
//! Both know the membrane as a `sheet` (closest points, sides of particles) of `facet`s, with a `surface` that moves,
//! which touches walls and obstacles (`rigid`), and the nodes of bodies on the grid as `partner`s. `bodies` is contact
//! of bodies with each other at grid nodes. Common to all: `impulse` (the impulses at one node), `friction`
//! (coefficients by name), `support_blocks` and `particle_size`, `ledger` (forces and losses); grid nodes around a
//! point, with walls, are [`FoldedStencil`]. The order of a step, and of the interface within it:
//!
//! ```text
//! begin_step    find: label particles, find the pairs that may touch; contact between bodies; choose: their
//!               nodes on the grid
//! resolve       per membrane sub-step: the trial state at that time → forces on the membrane's nodes
//!               in passes, as the nodes take up less than the grid gives (theory D.7)
//! conclude      gaps and losses of the sub-step
//! finish_step   finish: displacements that undo overlaps; the impulses to the grid: p ← p + ΣJ, f ← f + ΣJ/Δt, Lian (53)
//! account       (after the walls) add_totals: forces of the step, and what contact dissipated (theory D.16; `ledger`)
//! restore       (after particles and membranes moved) undo overlaps, keep particles on their sides (`sheet::guard`)
//! ```
//!
//! J is the impulse on the body, of two bodies on the second; the sheet gets −J (theory D.5, D.9, D.14). Only in
//! contact of a sheet with walls and obstacles (`rigid`) J acts on the sheet (theory E.10).
//! Linear momentum is conserved to round-off, because both sides of every impulse use the same weights.
//! Angular momentum is conserved up to Σ (x_s − x_r) × J, which is booked (theory D.15).

mod at_nodes;
mod at_surface;
mod bodies;
mod facet;
mod friction;
mod impulse;
mod ledger;
mod method;
mod particle_size;
mod partner;
mod rigid;
mod sheet;
mod support_blocks;
mod surface;

pub use facet::SheetFacet;
pub use friction::FrictionTable;
pub use ledger::Losses;
pub use rigid::{NodePositions, Squeeze};
pub use sheet::{FacetLocator, ParticleShift, SheetPosition};
pub use surface::{SheetSource, SheetSurface};

use crate::math::Vector;
use crate::mpm::particles::Bodies;
use crate::mpm::wall::folded_stencil::FoldedStencil;
use crate::mpm::wall::{SheetPush, Walls};
use crate::mpm::{Friction, Grid, SheetContact, SubStep};
use crate::simulation::Column;
use at_nodes::AtNodes;
use at_surface::AtSurface;
use bodies::Pairwise;
use impulse::ContactTotals;
use ledger::{ContactCounts, ContactLedger};
use method::{ContactMethod, StepContext};
use partner::Partners;
use sheet::{ContactSheet, GuardedParticle, MovedSheet, keep_sides, particles_to_check};
use std::collections::BTreeMap;

/// A pass of contact of a sheet in a sub-step.
#[derive(Debug, Clone, Copy)]
pub struct ContactPass {
    /// Number of the sheet.
    pub sheet: usize,
    /// Number of the pass in the sub-step, from 0.
    pub pass: usize,
}

/// All contacts of a simulation.
#[derive(Debug)]
pub struct Contacts<const D: usize> {
    stencil: FoldedStencil<D>,
    /// Gap below which contact acts [m].
    tolerance: f64,
    dt: f64,
    /// Size of a cell [m].
    cell: f64,
    sheets: Vec<ContactSheet<D>>,
    /// The method of contact of each sheet with the bodies.
    methods: Vec<Box<dyn ContactMethod<D>>>,
    /// Name of each body, and which part of it.
    bodies: Vec<(String, usize)>,
    partners: Partners<D>,
    pairwise: Pairwise<D>,
    /// Displacements of each body's particles at the end of the step.
    shifts: Vec<Vec<ParticleShift<D>>>,
    /// Particles next to sheets during the step.
    guarded: Vec<GuardedParticle<D>>,
    ledger: ContactLedger<D>,
    counts: ContactCounts,
}

impl<const D: usize> Contacts<D> {
    /// Contact between `bodies` and `sheets` at `place`; `tolerance` [m] is the gap below which it acts.
    pub fn new(
        stencil: FoldedStencil<D>,
        friction: &FrictionTable,
        place: SheetContact,
        tolerance: f64,
        bodies: &Bodies<D>,
        sheets: &[SheetSource<'_, D>],
    ) -> Self {
        let fields = bodies.field_count();
        let names: Vec<Vec<String>> = (0..fields).map(|field| bodies.names(field)).collect();
        let own = |sheet: &SheetSource<'_, D>| [sheet.name.to_owned()];
        let built = |(number, sheet): (usize, &SheetSource<'_, D>)| {
            let with_bodies = names.iter().map(|body| friction.between(body, &own(sheet))).collect();
            ContactSheet::new(number, sheet, bodies, with_bodies, friction.listed_with(sheet.name))
        };
        let pairs = friction.pairs_in_contact(&names);
        let with_sheets = sheets.iter().flat_map(|sheet| names.iter().map(|body| [body.clone(), own(sheet).to_vec()]));
        let with_bodies = pairs.iter().map(|(fields, _)| fields.map(|field| names[field].clone()));
        Self {
            stencil,
            tolerance,
            dt: 0.0,
            cell: 0.0,
            bodies: bodies.iter().map(|body| (body.name.clone(), body.part.number)).collect(),
            sheets: sheets.iter().enumerate().map(built).collect(),
            methods: sheets.iter().map(|sheet| contact_method(place, sheet, fields, tolerance)).collect(),
            partners: Partners::default(),
            ledger: ContactLedger::new(with_sheets.chain(with_bodies).collect(), sheets.len()),
            pairwise: Pairwise::new(pairs),
            shifts: vec![Vec::new(); bodies.len()],
            guarded: Vec::new(),
            counts: ContactCounts::new(sheets.len()),
        }
    }

    /// Finds the pairs that may touch during the step of length `dt` [s] whose trial state (m, p̄, f) is on
    /// the grid, and resolves the contact between bodies. One surface per sheet; their velocities are not
    /// used yet.
    pub fn begin_step(
        &mut self,
        grid: &mut Grid<D>,
        walls: &Walls<D>,
        bodies: &Bodies<D>,
        surfaces: &[SheetSurface<'_, D>],
        dt: f64,
    ) {
        (self.dt, self.cell) = (dt, grid.cell);
        self.counts.steps += 1;
        self.partners.begin(dt);
        self.shifts.iter_mut().for_each(Vec::clear);
        self.guarded.clear();
        let Self { stencil, sheets, methods, partners, guarded, counts, .. } = self;
        let step = counts.steps;
        let context = StepContext { grid: &*grid, stencil, bodies, step, dt };
        for ((sheet, method), surface) in sheets.iter_mut().zip(&mut *methods).zip(surfaces) {
            sheet.begin_step(surface, walls);
            counts.crossed[sheet.number] += method.find(sheet, surface, &context, guarded);
        }
        self.pairwise.resolve(grid, stencil, bodies, methods, self.tolerance, dt);
        // The grid has changed.
        let context = StepContext { grid: &*grid, stencil, bodies, step, dt };
        for (sheet, method) in sheets.iter().zip(methods) {
            method.choose(sheet, &context, partners);
        }
    }

    /// Contact of one sheet at the end of a sub-step: in pass 0 the detection, and the forces on the sheet's nodes [N];
    /// in further passes, after the nodes have taken up the forces of the last, their change (theory D.7). The
    /// supports' part is included; the membrane leaves it to them.
    pub fn resolve(
        &mut self,
        ContactPass { sheet, pass }: ContactPass,
        surface: &SheetSurface<'_, D>,
        walls: &Walls<D>,
        at: &SubStep<'_>,
    ) -> &[Vector<D>] {
        let (sheet, method) = (&mut self.sheets[sheet], &mut self.methods[sheet]);
        sheet.begin_pass(pass, surface, walls, at, self.cell);
        method.resolve(sheet, surface, &mut self.partners, pass, at);
        &sheet.forces
    }

    /// Ends the sub-step of a sheet, after its last pass: gaps and losses follow the velocities that its nodes
    /// have now.
    pub fn conclude(&mut self, sheet: usize, surface: &SheetSurface<'_, D>, at: &SubStep<'_>) {
        self.sheets[sheet].rigid.conclude(surface);
        let lost = self.methods[sheet].conclude(&self.sheets[sheet], surface, &self.partners, at);
        self.ledger.record_mapping_loss(sheet, lost);
    }

    /// Undoes a part of the overlaps of a sheet with walls and obstacles, after its nodes have moved to `position` [m].
    pub fn undo_overlaps(&self, sheet: usize, position: &mut [Vector<D>], at: &SubStep<'_>) {
        self.sheets[sheet].undo_overlaps(position, at);
    }

    /// A point of a sheet that is squeezed between walls, obstacles and supports `elapsed` [s] after the start of the
    /// step.
    pub fn squeezed(
        &self,
        sheet: usize,
        positions: NodePositions<'_, D>,
        walls: &Walls<D>,
        elapsed: f64,
    ) -> Option<Squeeze<D>> {
        self.sheets[sheet].squeezed(positions, walls, elapsed)
    }

    /// Impulse and work of walls and obstacles on all sheets during the step, by boundary.
    pub fn wall_pushes(&self) -> Vec<SheetPush<D>> {
        let mut sums: Vec<SheetPush<D>> = Vec::new();
        for pushes in self.sheets.iter().map(|sheet| &sheet.rigid.pushes) {
            sums.resize(pushes.len().max(sums.len()), SheetPush::default());
            sums.iter_mut().zip(pushes).for_each(|(sum, push)| sum.add(push));
        }
        sums
    }

    /// Adds the impulses of the step to the grid: p ← p + ΣJ, f ← f + ΣJ/Δt.
    pub fn finish_step(&mut self, grid: &mut Grid<D>) {
        for (sheet, method) in self.sheets.iter_mut().zip(&self.methods) {
            method.finish(sheet, &mut self.shifts);
            sheet.rigid.record_held_fractions();
        }
        // Lian (53).
        self.partners.apply_to_grid(grid);
    }

    /// Records forces and losses of the step, when p̄ and f on the grid are final.
    pub fn account(&mut self, grid: &Grid<D>) {
        let sheets = self.sheets.iter().zip(&self.methods).flat_map(|(sheet, method)| {
            let mut sums = vec![ContactTotals::default(); sheet.friction.len()];
            method.add_totals(&self.partners, grid, self.dt, &mut sums);
            sums
        });
        self.ledger.record_step(sheets.chain(self.pairwise.totals(grid, self.dt)), self.dt);
    }

    /// Calls `visit` with the nodes around the particles of a field next to sheets, and their distances from the sheets
    /// on the side of most of these particles [m].
    pub fn limit_free_volumes(
        &mut self,
        grid: &Grid<D>,
        bodies: &Bodies<D>,
        field: usize,
        mut visit: impl FnMut(usize, f64),
    ) {
        for (number, sheet) in self.sheets.iter_mut().enumerate() {
            let own = |near: &&GuardedParticle<D>| {
                near.sheet as usize == number && bodies.field_of(near.body as usize) == field
            };
            let mut votes: BTreeMap<usize, f64> = BTreeMap::new();
            for near in self.guarded.iter().filter(own) {
                self.stencil.for_each(grid, near.start, |node, weight, _| {
                    *votes.entry(node).or_insert(0.0) += near.side * weight;
                });
            }
            sheet.refresh_to_start(grid.cell);
            for (node, vote) in votes {
                if let Some(foot) = sheet.foot(grid.position(node), grid.cell) {
                    visit(node, vote.signum() * foot.distance);
                }
            }
        }
    }

    /// Sets the positions of the sheets' nodes [m] for [`Self::vector_to_sheet`].
    pub fn find_membranes(&mut self, positions: &[&[Vector<D>]], cell: f64) {
        for (sheet, position) in self.sheets.iter_mut().zip(positions) {
            sheet.refresh(position, cell);
        }
    }

    /// The vector from `x` to the closest point of a sheet within a cell, at the positions of [`Self::find_membranes`]
    /// [m]; `None` if the sheet has no contact with the field.
    pub fn vector_to_sheet(&self, sheet: usize, field: usize, x: Vector<D>, cell: f64) -> Option<Vector<D>> {
        let sheet = self.sheets.get(sheet).filter(|sheet| sheet.friction[field] != Friction::None)?;
        let foot = sheet.foot(x, cell)?;
        Some(foot.normal * -foot.distance)
    }

    /// Removes from the displacements `by` [m] of a body's particles the parts towards the sheets next to them.
    pub fn keep_off(&self, body: usize, by: &mut [Vector<D>]) {
        for near in self.guarded.iter().filter(|near| near.body as usize == body) {
            let by = &mut by[near.particle as usize];
            *by -= near.away * by.dot(near.away).min(0.0);
        }
    }

    /// Undoes a part of the overlaps of particles with sheets, and keeps all particles on their sides of the sheets,
    /// whose nodes have moved to `positions` [m]. Comes after the particles have moved, and before they are sorted.
    /// Returns the displacements of each body.
    pub fn restore(&mut self, bodies: &mut Bodies<D>, positions: &[&[Vector<D>]]) -> &[Vec<ParticleShift<D>>] {
        for (body, shifts) in bodies.iter_mut().zip(&self.shifts) {
            shifts.iter().for_each(|shift| body.particles.position[shift.particle as usize] += shift.by);
        }
        let travel: Vec<f64> = self.sheets.iter().zip(positions).map(|(sheet, at)| sheet.travel(at)).collect();
        let to_check = particles_to_check(&self.guarded, &travel, bodies);
        if to_check.is_empty() {
            return &self.shifts;
        }
        self.find_membranes(positions, self.cell);
        let sheets: Vec<MovedSheet<'_, D>> =
            self.sheets.iter().zip(positions).map(|(sheet, at)| sheet.moved(at)).collect();
        let displaced = keep_sides(&self.guarded, &to_check, &sheets, bodies, self.cell);
        self.counts.held_back += displaced.len() as u64;
        for (body, shift) in displaced {
            bodies[body as usize].particles.position[shift.particle as usize] += shift.by;
            self.shifts[body as usize].push(shift);
        }
        &self.shifts
    }

    /// Named contact forces `contact:<body>-<other>`: mean over the last step [N], on the first of the two.
    pub fn forces(&self) -> impl Iterator<Item = (&str, [f64; 3])> {
        self.ledger.forces()
    }

    /// Since the start: particles found on the wrong side of each sheet, `crossed:<sheet>`, and how often one
    /// was put back to its least distance from a sheet, `held-back`.
    pub fn counts(&self) -> Vec<(String, u64)> {
        let crossed =
            self.sheets.iter().map(|sheet| format!("crossed:{}", sheet.name)).zip(self.counts.crossed.clone());
        let held_back = (!self.sheets.is_empty()).then(|| ("held-back".to_owned(), self.counts.held_back));
        crossed.chain(held_back).collect()
    }

    /// Notices since the last call: one in a run for each sheet that particles have crossed.
    pub fn notices(&mut self) -> Vec<String> {
        self.counts.notices(self.sheets.iter().map(|sheet| sheet.name.as_str()))
    }

    /// The contradiction in columns that were just restored, if there is one.
    pub fn misfit(&self) -> Option<String> {
        self.counts.misfit()
    }

    /// The shape functions of the bodies, folded at walls.
    pub fn stencil(&self) -> &FoldedStencil<D> {
        &self.stencil
    }

    /// True if a sheet with contact at nodes lies in the support of this one.
    pub fn meets(&self, node: usize) -> bool {
        self.methods.iter().any(|method| method.meets(node))
    }

    /// Energy that contact has dissipated since the start.
    pub fn losses(&self) -> Losses {
        self.ledger.losses()
    }

    /// The largest of the counters that a checkpoint keeps.
    pub fn largest_count(&self) -> u64 {
        self.counts.largest()
    }

    /// Columns of a checkpoint: sides of particles and normal forces on them, fractions held by walls, counts and
    /// losses.
    pub fn columns(&mut self, prefix: &str, visit: &mut dyn FnMut(&str, Column<'_>)) {
        for ContactSheet { name: sheet, labels, .. } in &mut self.sheets {
            for (labels, (body, part)) in labels.iter_mut().zip(&self.bodies) {
                let kind = if *part == 0 { "side".to_owned() } else { format!("side-{part}") };
                visit(&format!("{prefix}{kind}:{sheet}:{body}"), Column::growing(&mut labels.kept));
                visit(&format!("{prefix}force-{kind}:{sheet}:{body}"), Column::growing(&mut labels.force));
            }
        }
        for sheet in &mut self.sheets {
            visit(&format!("{prefix}pressed:{}", sheet.name), Column::new(&mut sheet.rigid.held));
        }
        self.counts.columns(prefix, visit);
        self.ledger.columns(prefix, visit);
    }
}

/// The method at `place` for contact of a sheet with so many fields; `tolerance` [m] is the gap below which contact
/// acts.
fn contact_method<const D: usize>(
    place: SheetContact,
    source: &SheetSource<'_, D>,
    fields: usize,
    tolerance: f64,
) -> Box<dyn ContactMethod<D>> {
    match place {
        SheetContact::Nodes => Box::new(AtNodes::new(source, fields, tolerance)),
        SheetContact::Particles => Box::new(AtSurface::new(tolerance)),
    }
}
