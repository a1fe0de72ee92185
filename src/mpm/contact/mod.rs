//! Contact on the background grid: membranes with bodies, and bodies with each other.
//!
//! Bodies and membranes first move as if they were alone. Then they exchange impulses, in one of two places
//! ([`SheetContact`]): on the surface of the membrane, between its elements and the points of
//! bodies near it (`points`, `nearest`; theory 8.2), or, as in the paper, at the grid nodes (`sheet`, `row`, `band`):
//! where both have mass at a node, approach, and have closed their gap, they exchange an impulse (Lian, Liu & Zhang
//! 2014, section 5, with the signs of eqs. 55, 58 and 59 corrected; theory 6 and 7.2):
//!
//! ```text
//! (v̄_r − v̄_s)·n > 0  and  g − Δt (v̄_r − v̄_s)·n ≤ tol                    detection          (50, 52)
//! J = −M (v̄_r − v̄_s),  M = m_r m_s/(m_r + m_s)                          stick, on r        (54, 55)
//! J = J_n n + min(‖J_t‖, μ_f |J_n|) J_t/‖J_t‖,  no pulling               slip               (56–58)
//! p_s ← p_s − J,   v_K ← v_K + Δt/m_K Σ_q W_qK Σ_I N_I(x_q) f_I/m_I^r   both get their share (53, 59)
//! ```
//!
//! The order of a step:
//!
//! ```text
//! begin_step     label particles, find who may touch (nodes: map membranes, measure gaps); contact between bodies
//! resolve        per membrane sub-step: the trial state at that time → forces on the membrane's nodes
//!                in passes, as the nodes take up less than the grid gives (theory 6.7)
//! conclude       gaps and losses of the sub-step
//! finish_step    hand the impulses to the grid: p ← p + ΣJ, f ← f + ΣJ/Δt
//! account        (after the walls) forces of the step, and what contact dissipated (theory 10)
//! restore        (after particles and membranes moved) part what overlaps, keep particles on their sides (`guard`)
//! ```
//!
//! Linear momentum is conserved to round-off, because both sides of every impulse use the same weights.
//! Angular momentum is conserved up to Σ (x_s − x_r) × J, which is booked (theory 6.6).

mod band;
mod guard;
pub mod impulse;
pub mod locate;
mod margin;
mod nearest;
pub mod nodes;
pub mod normal;
mod pairwise;
mod partner;
mod points;
mod rigid;
mod row;
pub mod sample;
mod sheet;
mod solver;
mod watch;

pub use rigid::Squeeze;
pub use sheet::{SheetSource, Surface};

use crate::math::Vector;
use crate::mpm::wall::{SheetPush, Walls};
use crate::mpm::{Body, Friction, Grid, SheetContact, SubStep};
use crate::simulation::Column;
pub use band::Shift;
use band::{Band, Labels, Marks};
use guard::{Moved, Near};
use impulse::Settled;
use locate::Locator;
use nodes::Lattice;
use pairwise::Pairwise;
use partner::Partners;
use sheet::Sheet;
use std::collections::BTreeMap;
use watch::Scene;

/// Friction by name: pairs that the case lists, and the default for the others.
#[derive(Debug, Clone)]
pub struct FrictionTable {
    /// Two names (bodies or membranes, in any order) and what they do.
    pub listed: Vec<(String, String, Friction)>,
    /// All other pairs.
    pub default: Friction,
}

impl FrictionTable {
    /// What is listed with a part: the other name and what the two do.
    fn listed_with(&self, name: &str) -> Vec<(String, Friction)> {
        let other = |(x, y, friction): &(String, String, Friction)| match () {
            () if x == name => Some((y.clone(), *friction)),
            () if y == name => Some((x.clone(), *friction)),
            () => None,
        };
        self.listed.iter().filter_map(other).collect()
    }

    /// What parts with these names do: the first that is listed, or the default.
    pub(super) fn between(&self, a: &[String], b: &[String]) -> Friction {
        let names = |x: &String, y: &String| (a.contains(x) && b.contains(y)) || (a.contains(y) && b.contains(x));
        self.listed.iter().find(|(x, y, _)| names(x, y)).map_or(self.default, |(_, _, friction)| *friction)
    }
}

/// What contact has dissipated since the start [J] (theory 10).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Losses {
    /// Inelastic impact along the normals.
    pub normal: f64,
    /// Friction.
    pub friction: f64,
    /// Mapping between grid and membrane nodes.
    pub mapping: f64,
    /// Angular momentum that contact of sheets has added [N m s], because friction and nodes that are not opposite
    /// each other push along lines that don't coincide (theory 6.6).
    pub spin: [f64; 3],
}

/// A contact force: its name, and the mean over the last step [N] on the body that is named first.
#[derive(Debug, Clone)]
struct NamedForce<const D: usize> {
    name: String,
    value: Vector<D>,
}

impl<const D: usize> NamedForce<D> {
    fn between(a: &[String], b: &[String]) -> Self {
        Self { name: format!("contact:{}-{}", a.join("+"), b.join("+")), value: Vector::ZERO }
    }
}

/// All contacts of a simulation.
#[derive(Debug)]
pub struct Contact<const D: usize> {
    lattice: Lattice<D>,
    /// Where sheets meet bodies.
    place: SheetContact,
    /// Gap below which contact acts [m].
    tolerance: f64,
    dt: f64,
    /// Size of a cell [m].
    cell: f64,
    sheets: Vec<Sheet<D>>,
    locators: Vec<Locator<D>>,
    /// Labels of each sheet and body, bodies running fastest.
    labels: Vec<Labels>,
    /// Name of each body, and which part of it.
    bodies: Vec<(String, usize)>,
    partners: Partners<D>,
    pairwise: Pairwise<D>,
    marks: Marks,
    /// How far particles of each body are displaced at the end of the step.
    shifts: Vec<Vec<Shift<D>>>,
    /// Particles next to sheets during the step.
    guarded: Vec<Near<D>>,
    forces: Vec<NamedForce<D>>,
    /// Which of the forces each pair of a field and a sheet, and each of two fields, adds to: parts of one body share them.
    force_of: Vec<usize>,
    /// Steps taken, particles found to have crossed each sheet, and particles put back (once per step).
    counts: Vec<u64>,
    /// Sheets of which it was said that particles have crossed them.
    said: Vec<bool>,
    /// Losses of each pair (normal, friction), then the mapping loss of each sheet, then the spin.
    losses: Vec<f64>,
}

impl<const D: usize> Contact<D> {
    /// Contact between `bodies` and `sheets` at `place`; `tolerance` [m] is the gap below which it acts.
    pub fn new(
        lattice: Lattice<D>,
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
        let (mut named, mut force_of): (Vec<[Vec<String>; 2]>, Vec<usize>) = (Vec::new(), Vec::new());
        let mut numbers: BTreeMap<[Vec<String>; 2], usize> = BTreeMap::new();
        let mut name = |a: &[String], b: &[String]| {
            let pair = [a.to_vec(), b.to_vec()];
            let number = *numbers.entry(pair.clone()).or_insert(named.len());
            if number == named.len() {
                named.push(pair);
            }
            force_of.push(number);
        };
        let built = |sheet: &SheetSource<'_, D>| {
            let own = [sheet.name.to_owned()];
            let with_bodies = names.iter().map(|body| friction.between(body, &own)).collect();
            Sheet::new(sheet, with_bodies, friction.listed_with(sheet.name))
        };
        for sheet in sheets {
            names.iter().for_each(|body| name(body, &[sheet.name.to_owned()]));
        }
        let mut pairs = Vec::new();
        for (b, second) in names.iter().enumerate() {
            for (a, first) in names[..b].iter().enumerate() {
                let law = friction.between(first, second);
                // Between the parts of one body there is always a sheet.
                let parts = first.iter().any(|name| second.contains(name));
                if law != Friction::None && !parts {
                    pairs.push(([a, b], law));
                    name(first, second);
                }
            }
        }
        Self {
            lattice,
            place,
            tolerance,
            dt: 0.0,
            cell: 0.0,
            labels: (0..sheets.len()).flat_map(|s| bodies.iter().map(move |body| labels(body, s))).collect(),
            bodies: bodies.iter().map(|body| (body.name.clone(), body.part.number)).collect(),
            locators: sheets.iter().map(|sheet| Locator::new(&sheet.facets)).collect(),
            sheets: sheets.iter().map(built).collect(),
            partners: Partners::default(),
            pairwise: Pairwise::new(pairs),
            marks: Marks::default(),
            shifts: vec![Vec::new(); bodies.len()],
            guarded: Vec::new(),
            counts: vec![0; 2 + sheets.len()],
            said: vec![false; sheets.len()],
            losses: vec![0.0; 2 * force_of.len() + sheets.len() + 3],
            forces: named.iter().map(|[a, b]| NamedForce::between(a, b)).collect(),
            force_of,
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
        self.sheets.iter_mut().for_each(|sheet| sheet.rigid.begin_step(walls));
        self.partners.begin(dt);
        self.shifts.iter_mut().for_each(Vec::clear);
        self.guarded.clear();
        for (sheet, surface) in self.sheets.iter_mut().zip(surfaces) {
            sheet.before.clear();
            sheet.before.extend_from_slice(surface.position);
        }
        match self.place {
            SheetContact::Nodes => self.measure(grid, bodies, surfaces),
            SheetContact::Particles => self.look(grid, bodies, surfaces),
        }
        self.pairwise.resolve(grid, &self.lattice, bodies, &self.sheets, self.tolerance, dt);
        let reach = self.tolerance + grid.cell;
        for sheet in &mut self.sheets {
            sheet.choose(grid, &self.lattice, &mut self.partners, reach);
        }
    }

    /// Labels the particles around the sheets, and finds those that may touch them.
    fn look(&mut self, grid: &Grid<D>, bodies: &[Body<D>], surfaces: &[Surface<'_, D>]) {
        let Self { sheets, labels, counts, lattice, tolerance, dt, guarded, .. } = self;
        for (s, (sheet, surface)) in sheets.iter_mut().zip(surfaces).enumerate() {
            let Sheet { points, facets, friction, .. } = sheet;
            let scene = Scene { grid, lattice, surface, facets, tolerance: *tolerance, dt: *dt, step: counts[0] };
            points.begin(&scene);
            for (b, body) in bodies.iter().enumerate() {
                let labels = &mut labels[s * bodies.len() + b];
                counts[1 + s] += points.find((&scene, s), (b, body), friction[body.field], (labels, guarded));
            }
        }
    }

    /// Maps the sheets to the grid, labels the particles around them, and measures the gaps at the nodes.
    fn measure(&mut self, grid: &Grid<D>, bodies: &[Body<D>], surfaces: &[Surface<'_, D>]) {
        for (sheet, surface) in self.sheets.iter_mut().zip(surfaces) {
            sheet.map(grid, &self.lattice, surface);
        }
        self.marks.clear(grid);
        for row in self.sheets.iter().flat_map(|sheet| &sheet.rows) {
            self.marks.mark(grid, &self.lattice, row.node as usize);
        }
        let near = |body: &Body<D>| self.marks.near(grid, &self.lattice, &body.particles.position);
        let near: Vec<Vec<u32>> = bodies.iter().map(near).collect();
        for (s, surface) in surfaces.iter().enumerate() {
            let (step, dt) = (self.counts[0], self.dt);
            let band = Band { grid, lattice: &self.lattice, surface, step, dt, fastest: fastest(surface) };
            let (sheet, locator) = (&mut self.sheets[s], &mut self.locators[s]);
            let labels = &mut self.labels[s * bodies.len()..][..bodies.len()];
            if sheet.rows.iter().any(|row| row.folded) {
                bodies.iter().enumerate().for_each(|(b, body)| band.lean(sheet, body, &near[b], &labels[b], locator));
                sheet.unfold();
            }
            for (b, body) in bodies.iter().enumerate() {
                let guarded = &mut self.guarded;
                self.counts[1 + s] += band.measure((sheet, s), (body, b), &near[b], &mut labels[b], locator, guarded);
            }
        }
    }

    /// Contact of one sheet at the end of a sub-step: in `pass` 0, who touches, and the forces on the sheet's nodes [N]; in
    /// further passes, after the nodes have taken up the forces of the last, their change (theory 6.7). The supports'
    /// share is included; the membrane leaves it to them.
    pub fn resolve(
        &mut self,
        (sheet, pass): (usize, usize),
        surface: &Surface<'_, D>,
        walls: &Walls<D>,
        at: &SubStep<'_>,
    ) -> &[Vector<D>] {
        let Self { sheets, partners, tolerance, cell, .. } = self;
        sheets[sheet].resolve(pass, surface, (partners, walls), [*tolerance, *cell], at)
    }

    /// Ends the sub-step of a sheet, after its last pass: gaps and losses follow the velocities that its nodes
    /// have now.
    pub fn conclude(&mut self, sheet: usize, surface: &Surface<'_, D>, at: &SubStep<'_>) {
        let lost = self.sheets[sheet].conclude(surface, &self.partners, [at.momentum_end, at.momentum_dt]);
        self.losses[2 * self.force_of.len() + sheet] += lost;
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

    /// Hands the impulses of the step to the grid: p ← p + ΣJ, f ← f + ΣJ/Δt.
    pub fn finish_step(&mut self, grid: &mut Grid<D>) {
        let bodies = self.bodies.len();
        for (s, sheet) in self.sheets.iter_mut().enumerate() {
            sheet.points.part(&mut self.shifts);
            sheet.points.remember(&mut self.labels[s * bodies..][..bodies]);
            sheet.rigid.note();
        }
        self.partners.commit(grid);
    }

    /// Books forces and losses of the step, when p̄ and f on the grid are final.
    pub fn account(&mut self, grid: &Grid<D>) {
        let sheets = self.sheets.iter().flat_map(|sheet| sheet.settle(&self.partners, grid, self.dt));
        let pairs = self.pairwise.settle(grid, self.dt).into_iter();
        let pairs = pairs.map(|(impulse, lost)| Settled { impulse, lost, spin: Vector::ZERO });
        let settled: Vec<_> = sheets.chain(pairs).collect();
        let spin = 2 * self.force_of.len() + self.sheets.len();
        self.forces.iter_mut().for_each(|force| force.value = Vector::ZERO);
        for (index, settled) in settled.into_iter().enumerate() {
            self.forces[self.force_of[index]].value += settled.impulse / self.dt;
            self.losses[2 * index] += settled.lost[0];
            self.losses[2 * index + 1] += settled.lost[1];
            (0..3).for_each(|axis| self.losses[spin + axis] += settled.spin[axis]);
        }
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
            let Sheet { points, facets, before, .. } = sheet;
            points.refresh(facets, before, grid.cell);
            for (node, vote) in votes {
                if let Some(foot) = points.nearest().foot(facets, grid.position(node), grid.cell) {
                    visit(node, vote.signum() * foot.distance);
                }
            }
        }
    }

    /// Follows the sheets to `positions` [m], for [`Self::way_to`].
    pub fn find_membranes(&mut self, positions: &[&[Vector<D>]], cell: f64) {
        for (sheet, position) in self.sheets.iter_mut().zip(positions) {
            sheet.points.refresh(&sheet.facets, position, cell);
        }
    }

    /// The way from `x` [m] to a sheet within a cell, where it was found last, that has contact with a field.
    pub fn way_to(&self, (sheet, field): (usize, usize), x: Vector<D>, cell: f64) -> Option<Vector<D>> {
        let sheet = self.sheets.get(sheet).filter(|sheet| sheet.friction[field] != Friction::None)?;
        let foot = sheet.points.nearest().foot(&sheet.facets, x, cell)?;
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
        if self.guarded.is_empty() {
            return &self.shifts;
        }
        self.find_membranes(positions, self.cell);
        let moved = |(sheet, position)| moved(sheet, position);
        let sheets: Vec<Moved<'_, D>> = self.sheets.iter().zip(positions.iter().copied()).map(moved).collect();
        let displaced = guard::keep_sides(&self.guarded, &sheets, bodies, self.cell);
        self.counts[1 + self.sheets.len()] += displaced.len() as u64;
        for (body, shift) in displaced {
            bodies[body as usize].particles.position[shift.particle as usize] += shift.by;
            self.shifts[body as usize].push(shift);
        }
        &self.shifts
    }

    /// Named contact forces `contact:<body>-<other>`: mean over the last step [N], on the first of the two.
    pub fn forces(&self) -> impl Iterator<Item = (&str, [f64; 3])> {
        self.forces.iter().map(|force| (force.name.as_str(), force.value.to3()))
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
    pub fn lattice(&self) -> &Lattice<D> {
        &self.lattice
    }

    /// True if a sheet that meets bodies at the nodes lies in the support of this one.
    pub fn meets(&self, node: usize) -> bool {
        self.sheets.iter().any(|sheet| sheet.row(node).is_some())
    }

    /// What contact has dissipated since the start.
    pub fn losses(&self) -> Losses {
        let (pairs, rest) = self.losses.split_at(2 * self.force_of.len());
        let (mapping, spin) = rest.split_at(self.sheets.len());
        Losses {
            normal: pairs.iter().step_by(2).sum(),
            friction: pairs.iter().skip(1).step_by(2).sum(),
            mapping: mapping.iter().sum(),
            spin: std::array::from_fn(|axis| spin[axis]),
        }
    }

    /// The largest of the counters that a checkpoint keeps.
    pub fn counted(&self) -> u64 {
        self.counts.iter().copied().max().unwrap_or(0)
    }

    /// What a checkpoint must keep: the particles' sides, how hard they were pressed, counts and losses.
    pub fn columns(&mut self, prefix: &str, visit: &mut dyn FnMut(&str, Column<'_>)) {
        for (index, labels) in self.labels.iter_mut().enumerate() {
            let (sheet, (body, part)) = (index / self.bodies.len(), &self.bodies[index % self.bodies.len()]);
            let kind = if *part == 0 { "side".to_owned() } else { format!("side-{part}") };
            let sheet = &self.sheets[sheet].name;
            visit(&format!("{prefix}{kind}:{sheet}:{body}"), Column::growing(&mut labels.stamps));
            visit(&format!("{prefix}force-{kind}:{sheet}:{body}"), Column::growing(&mut labels.force));
        }
        for sheet in &mut self.sheets {
            visit(&format!("{prefix}pressed:{}", sheet.name), Column::new(&mut sheet.rigid.held));
        }
        visit(&format!("{prefix}counts"), Column::new(&mut self.counts));
        visit(&format!("{prefix}losses"), Column::new(&mut self.losses));
    }
}

/// The largest speed of a sheet's nodes [m/s].
fn fastest<const D: usize>(surface: &Surface<'_, D>) -> f64 {
    surface.velocity.iter().map(|v| v.norm_squared()).fold(0.0, f64::max).sqrt()
}

/// A sheet whose nodes have moved to `position` [m].
fn moved<'a, const D: usize>(sheet: &'a Sheet<D>, position: &'a [Vector<D>]) -> Moved<'a, D> {
    Moved { nearest: sheet.points.nearest(), facets: &sheet.facets, before: &sheet.before, position }
}

/// What is known at the start of the particles of a body and the sheet with this number.
fn labels<const D: usize>(body: &Body<D>, sheet: usize) -> Labels {
    let known = body.part.sides.get(sheet).copied().filter(|&side| side != 0.0);
    Labels { known, ..Labels::default() }
}
