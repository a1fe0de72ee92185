//! Contact on the background grid: membranes with bodies, and bodies with each other.
//!
//! Bodies and membranes first move as if they were alone. Then they exchange impulses. Membranes do so with bodies by one of two
//! methods, which the case chooses ([`SheetContact`]), with one interface (`method`):
//!
//! * `at_nodes`: at the grid nodes, as in the paper (Lian, Liu & Zhang 2014, eqs. 49 to 59; theory D.2 to D.8);
//! * `at_surface`: on the surface of the membrane, between its elements and the particles of bodies near it (theory D.9 to D.11).
//!
//! Both know the membrane as a `sheet` (elements, closest points, sides of particles), which touches walls and obstacles
//! (`rigid`), and the nodes of bodies on the grid as `partner`s. `bodies` is contact of bodies with each other at grid nodes. Common to
//! all: `impulse` (the impulses at one node), `friction` (coefficients by name), `folded_stencil` (grid nodes around a point, with walls),
//! `support_blocks` and `particle_size`, `ledger` (forces and losses). The order of a step, and of the interface within it:
//!
//! ```text
//! begin_step     find: label particles, find who may touch; contact between bodies; choose: their nodes on the grid
//! resolve        per membrane sub-step: the trial state at that time → forces on the membrane's nodes
//!                in passes, as the nodes take up less than the grid gives (theory D.7)
//! conclude       gaps and losses of the sub-step
//! finish_step    finish: displacements that part what overlaps; the impulses to the grid: p ← p + ΣJ, f ← f + ΣJ/Δt (53)
//! account        (after the walls) settle: forces of the step, and what contact dissipated (theory D.16; `ledger`)
//! restore        (after particles and membranes moved) part what overlaps, keep particles on their sides (`sheet::guard`)
//! ```
//!
//! J is what the body gets, and of two bodies the second; the sheet gets −J (theory D).
//! Linear momentum is conserved to round-off, because both sides of every impulse use the same weights.
//! Angular momentum is conserved up to Σ (x_s − x_r) × J, which is booked (theory D.15).

mod at_nodes;
mod at_surface;
mod bodies;
mod folded_stencil;
mod friction;
mod impulse;
mod ledger;
mod method;
mod particle_size;
mod partner;
mod rigid;
mod sheet;
mod support_blocks;

pub use folded_stencil::{Flips, FoldedStencil, flip};
pub use friction::FrictionTable;
pub use ledger::Losses;
pub use rigid::Squeeze;
pub use sheet::{Facet, Locator, Place, SheetSource, Shift, Surface};

use crate::math::Vector;
use crate::mpm::wall::{SheetPush, Walls};
use crate::mpm::{Body, Friction, Grid, SheetContact, SubStep};
use crate::simulation::Column;
use bodies::Pairwise;
use impulse::Settled;
use ledger::Books;
use method::{ContactMethod, StepContext};
use partner::Partners;
use sheet::{Moved, Near, Sheet, keep_sides, suspects};
use std::collections::BTreeMap;

/// All contacts of a simulation.
#[derive(Debug)]
pub struct Contact<const D: usize> {
    lattice: FoldedStencil<D>,
    /// Gap below which contact acts [m].
    tolerance: f64,
    dt: f64,
    /// Size of a cell [m].
    cell: f64,
    sheets: Vec<Sheet<D>>,
    /// The method of contact of each sheet with the bodies.
    methods: Vec<Box<dyn ContactMethod<D>>>,
    /// Name of each body, and which part of it.
    bodies: Vec<(String, usize)>,
    partners: Partners<D>,
    pairwise: Pairwise<D>,
    /// How far particles of each body are displaced at the end of the step.
    shifts: Vec<Vec<Shift<D>>>,
    /// Particles next to sheets during the step.
    guarded: Vec<Near<D>>,
    books: Books<D>,
    /// Steps taken, particles found to have crossed each sheet, and particles put back (once per step).
    counts: Vec<u64>,
    /// Sheets of which it was said that particles have crossed them.
    said: Vec<bool>,
}

impl<const D: usize> Contact<D> {
    /// Contact between `bodies` and `sheets` at `place`; `tolerance` [m] is the gap below which it acts.
    pub fn new(
        lattice: FoldedStencil<D>,
        friction: &FrictionTable,
        (place, tolerance): (SheetContact, f64),
        bodies: &[Body<D>],
        sheets: &[SheetSource<'_, D>],
    ) -> Self {
        let fields = bodies.iter().map(|body| body.field + 1).max().unwrap_or(0);
        let members = |field: usize| -> Vec<String> {
            bodies.iter().filter(|body| body.field == field).map(|body| body.name.clone()).collect()
        };
        let names: Vec<Vec<String>> = (0..fields).map(members).collect();
        let own = |sheet: &SheetSource<'_, D>| [sheet.name.to_owned()];
        let built = |(number, sheet): (usize, &SheetSource<'_, D>)| {
            let with_bodies = names.iter().map(|body| friction.between(body, &own(sheet))).collect();
            Sheet::new(number, sheet, bodies, with_bodies, friction.listed_with(sheet.name))
        };
        let pairs = friction.pairs_that_meet(&names);
        let with_sheets = sheets.iter().flat_map(|sheet| names.iter().map(|body| [body.clone(), own(sheet).to_vec()]));
        let with_bodies = pairs.iter().map(|(fields, _)| fields.map(|field| names[field].clone()));
        Self {
            lattice,
            tolerance,
            dt: 0.0,
            cell: 0.0,
            bodies: bodies.iter().map(|body| (body.name.clone(), body.part.number)).collect(),
            sheets: sheets.iter().enumerate().map(built).collect(),
            methods: sheets.iter().map(|sheet| method::build(place, sheet, fields, tolerance)).collect(),
            partners: Partners::default(),
            books: Books::new(with_sheets.chain(with_bodies).collect(), sheets.len()),
            pairwise: Pairwise::new(pairs),
            shifts: vec![Vec::new(); bodies.len()],
            guarded: Vec::new(),
            counts: vec![0; 2 + sheets.len()],
            said: vec![false; sheets.len()],
        }
    }

    /// Finds out who may touch whom during the step of length `dt` [s] whose trial state (m, p̄, f) is on
    /// the grid, and resolves the contact between bodies. One surface per sheet; their velocities are not
    /// used yet.
    pub fn begin_step(
        &mut self,
        (grid, walls): (&mut Grid<D>, &Walls<D>),
        bodies: &[Body<D>],
        surfaces: &[Surface<'_, D>],
        dt: f64,
    ) {
        (self.dt, self.cell) = (dt, grid.cell);
        self.counts[0] += 1;
        self.partners.begin(dt);
        self.shifts.iter_mut().for_each(Vec::clear);
        self.guarded.clear();
        let Self { lattice, sheets, methods, partners, guarded, counts, .. } = self;
        let step = counts[0];
        let scene = StepContext { grid: &*grid, lattice, bodies, step, dt };
        for ((sheet, method), surface) in sheets.iter_mut().zip(&mut *methods).zip(surfaces) {
            sheet.begin_step(surface, walls);
            counts[1 + sheet.number] += method.find(sheet, surface, &scene, guarded);
        }
        self.pairwise.resolve(grid, lattice, bodies, methods, self.tolerance, dt);
        // The grid has changed.
        let scene = StepContext { grid: &*grid, lattice, bodies, step, dt };
        for (sheet, method) in sheets.iter().zip(methods) {
            method.choose(sheet, &scene, partners);
        }
    }

    /// Contact of one sheet at the end of a sub-step: in `pass` 0, who touches, and the forces on the sheet's nodes [N]; in
    /// further passes, after the nodes have taken up the forces of the last, their change (theory D.7). The supports'
    /// share is included; the membrane leaves it to them.
    pub fn resolve(
        &mut self,
        (sheet, pass): (usize, usize),
        surface: &Surface<'_, D>,
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
    pub fn conclude(&mut self, sheet: usize, surface: &Surface<'_, D>, at: &SubStep<'_>) {
        self.sheets[sheet].rigid.conclude(surface);
        let lost = self.methods[sheet].conclude(&self.sheets[sheet], surface, &self.partners, at);
        self.books.lose_in_mapping(sheet, lost);
    }

    /// Parts a sheet from walls and obstacles, after its nodes have moved to `position` [m].
    pub fn part(&self, sheet: usize, position: &mut [Vector<D>], at: &SubStep<'_>) {
        self.sheets[sheet].part(position, at);
    }

    /// A point of a sheet that has no way out `elapsed` [s] after the start of the step, when its nodes have these positions, now and
    /// at the start of the run [m].
    pub fn squeezed(
        &self,
        sheet: usize,
        positions: [&[Vector<D>]; 2],
        (walls, elapsed): (&Walls<D>, f64),
    ) -> Option<Squeeze<D>> {
        self.sheets[sheet].squeezed(positions, (walls, elapsed))
    }

    /// What walls and obstacles gave all sheets during the step, by boundary.
    pub fn wall_pushes(&self) -> Vec<SheetPush<D>> {
        let mut sums: Vec<SheetPush<D>> = Vec::new();
        for pushes in self.sheets.iter().map(|sheet| &sheet.rigid.pushes) {
            sums.resize(pushes.len().max(sums.len()), SheetPush::default());
            sums.iter_mut().zip(pushes).for_each(|(sum, push)| sum.add(push));
        }
        sums
    }

    /// Hands the impulses of the step to the grid: p ← p + ΣJ, f ← f + ΣJ/Δt (53).
    pub fn finish_step(&mut self, grid: &mut Grid<D>) {
        for (sheet, method) in self.sheets.iter_mut().zip(&self.methods) {
            method.finish(sheet, &mut self.shifts);
            sheet.rigid.note();
        }
        self.partners.commit(grid);
    }

    /// Books forces and losses of the step, when p̄ and f on the grid are final.
    pub fn account(&mut self, grid: &Grid<D>) {
        let sheets = self.sheets.iter().zip(&self.methods).flat_map(|(sheet, method)| {
            let mut sums = vec![Settled::default(); sheet.friction.len()];
            method.settle(&self.partners, grid, self.dt, &mut sums);
            sums
        });
        let pairs = self.pairwise.settle(grid, self.dt).into_iter();
        let pairs = pairs.map(|(impulse, lost)| Settled { impulse, lost, spin: Vector::ZERO });
        self.books.settle(sheets.chain(pairs), self.dt);
    }

    /// Calls `visit` with the nodes around the particles of a field next to sheets, and their distances from the sheets on the side of most
    /// of these particles [m].
    pub fn limit_rooms(&mut self, grid: &Grid<D>, bodies: &[Body<D>], field: usize, mut visit: impl FnMut(usize, f64)) {
        for (number, sheet) in self.sheets.iter_mut().enumerate() {
            let own = |near: &&Near<D>| near.sheet as usize == number && bodies[near.body as usize].field == field;
            let mut votes: BTreeMap<usize, f64> = BTreeMap::new();
            for near in self.guarded.iter().filter(own) {
                self.lattice.for_each(grid, near.from, |node, weight, _| {
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

    /// Follows the sheets to `positions` [m], for [`Self::way_to`].
    pub fn find_membranes(&mut self, positions: &[&[Vector<D>]], cell: f64) {
        for (sheet, position) in self.sheets.iter_mut().zip(positions) {
            sheet.refresh(position, cell);
        }
    }

    /// The way from `x` [m] to a sheet within a cell, where it was found last, that has contact with a field.
    pub fn way_to(&self, (sheet, field): (usize, usize), x: Vector<D>, cell: f64) -> Option<Vector<D>> {
        let sheet = self.sheets.get(sheet).filter(|sheet| sheet.friction[field] != Friction::None)?;
        let foot = sheet.foot(x, cell)?;
        Some(foot.normal * -foot.distance)
    }

    /// What is left of the displacements `by` [m] of a body's particles: none goes towards a sheet next to it.
    pub fn keep_off(&self, body: usize, by: &mut [Vector<D>]) {
        for near in self.guarded.iter().filter(|near| near.body as usize == body) {
            let by = &mut by[near.particle as usize];
            *by -= near.away * by.dot(near.away).min(0.0);
        }
    }

    /// Parts the particles that overlap with a sheet, and keeps all on their sides of the sheets, whose nodes have moved to `positions` [m].
    /// Comes after the particles have moved, and before they are sorted. Returns the displacements of each body.
    pub fn restore(&mut self, bodies: &mut [Body<D>], positions: &[&[Vector<D>]]) -> &[Vec<Shift<D>>] {
        for (body, shifts) in bodies.iter_mut().zip(&self.shifts) {
            shifts.iter().for_each(|shift| body.particles.position[shift.particle as usize] += shift.by);
        }
        let travel: Vec<f64> = self.sheets.iter().zip(positions).map(|(sheet, at)| sheet.travel(at)).collect();
        let suspects = suspects(&self.guarded, &travel, bodies);
        if suspects.is_empty() {
            return &self.shifts;
        }
        self.find_membranes(positions, self.cell);
        let sheets: Vec<Moved<'_, D>> = self.sheets.iter().zip(positions).map(|(sheet, at)| sheet.moved(at)).collect();
        let displaced = keep_sides(&self.guarded, &suspects, &sheets, bodies, self.cell);
        self.counts[1 + self.sheets.len()] += displaced.len() as u64;
        for (body, shift) in displaced {
            bodies[body as usize].particles.position[shift.particle as usize] += shift.by;
            self.shifts[body as usize].push(shift);
        }
        &self.shifts
    }

    /// Named contact forces `contact:<body>-<other>`: mean over the last step [N], on the first of the two.
    pub fn forces(&self) -> impl Iterator<Item = (&str, [f64; 3])> {
        self.books.forces()
    }

    /// Since the start: particles found on the wrong side of each sheet, `crossed:<sheet>`, and how often one
    /// was put back to its least distance from a sheet, `held-back`.
    pub fn counts(&self) -> Vec<(String, u64)> {
        let names = self.sheets.iter().map(|sheet| format!("crossed:{}", sheet.name));
        let names = names.chain((!self.sheets.is_empty()).then(|| "held-back".to_owned()));
        names.zip(self.counts[1..].iter().copied()).collect()
    }

    /// Says once of each sheet that particles have crossed it.
    pub fn notices(&mut self) -> Vec<String> {
        let sheets = self.sheets.iter().zip(&self.counts[1..]).zip(&mut self.said);
        let news = sheets.filter_map(|((sheet, &count), said)| {
            (count > 0 && !std::mem::replace(said, count > 0)).then(|| sheet.name.clone())
        });
        news.map(|name| {
            format!(
                "particles have crossed the membrane `{name}` (`crossed:{name}` in counts.csv): its elements may be much \
                 larger than cells, or a body begins on both sides of it"
            )
        })
        .collect()
    }

    /// After a restore: what has been counted by then was said before.
    pub fn restored(&mut self) {
        self.said.iter_mut().zip(&self.counts[1..]).for_each(|(said, &count)| *said = count > 0);
    }

    /// The shape functions of the bodies, folded at walls.
    pub fn lattice(&self) -> &FoldedStencil<D> {
        &self.lattice
    }

    /// True if a sheet that meets bodies at the nodes lies in the support of this one.
    pub fn meets(&self, node: usize) -> bool {
        self.methods.iter().any(|method| method.meets(node))
    }

    /// What contact has dissipated since the start.
    pub fn losses(&self) -> Losses {
        self.books.losses()
    }

    /// The largest of the counters that a checkpoint keeps.
    pub fn counted(&self) -> u64 {
        self.counts.iter().copied().max().unwrap_or(0)
    }

    /// What a checkpoint must keep: the particles' sides, how hard they were pressed, counts and losses.
    pub fn columns(&mut self, prefix: &str, visit: &mut dyn FnMut(&str, Column<'_>)) {
        for Sheet { name: sheet, labels, .. } in &mut self.sheets {
            for (labels, (body, part)) in labels.iter_mut().zip(&self.bodies) {
                let kind = if *part == 0 { "side".to_owned() } else { format!("side-{part}") };
                visit(&format!("{prefix}{kind}:{sheet}:{body}"), Column::growing(&mut labels.stamps));
                visit(&format!("{prefix}force-{kind}:{sheet}:{body}"), Column::growing(&mut labels.force));
            }
        }
        for sheet in &mut self.sheets {
            visit(&format!("{prefix}pressed:{}", sheet.name), Column::new(&mut sheet.rigid.held));
        }
        visit(&format!("{prefix}counts"), Column::new(&mut self.counts));
        visit(&format!("{prefix}losses"), Column::new(&mut self.books.losses));
    }
}
