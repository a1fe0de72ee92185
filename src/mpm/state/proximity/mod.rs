//! Notices of sheets that meet sheets, or themselves: contact between them is not resolved.
//!
//! Two elements meet where they cross, or where they are nearer to each other than the mean of their thicknesses. Those that share
//! a node, or lie at the same places and so are sewn together, don't; nor do those that were as near at the start: of one sheet twice
//! as near, because a sheet that is compressed along itself brings its elements together, too.
//!
//! The time of the next look follows from how far the nodes have moved since the last look, each by the *room* it had: with the least gap g
//! between elements that may meet, and their thickness τ, it is ½ (g − τ), at most a quarter of an element, and at least ½ τ: two
//! sheets that approach each other are seen while they are within τ, before they have passed. Where sheets are so fast that looks
//! would cost more than 2 % of the run, they are rarer. All of this follows from counts, never from times.

pub mod distance;
mod layout;
mod survey;

use crate::error::Diagnostic;
use crate::math::Vector;
use crate::mpm::contact::sample::Facet;
use crate::mpm::{Membrane, Setup};
use crate::parallel;
use crate::simulation::Column;
use layout::Layout;
use std::collections::BTreeSet;
use survey::{Found, Meeting, State, Survey};

/// Part of an element that nodes may move between two looks.
const QUARTER: f64 = 0.25;

/// Looks take at most one part in this many of the work of a run, beyond what doesn't matter in any.
const SHARE: f64 = 60.0;

/// Work that doesn't matter in any run [sub-steps of an element].
const FREE: f64 = 1e6;

/// The cost of a look per element, per element that it compares, and per pair that it measures; and what it costs to see how far nodes
/// have moved, per element: in the time that a sub-step of an element, or a step of a particle, takes.
const PRICE: [f64; 4] = [0.5, 0.5, 4.0, 0.05];

/// Watches over the distances of sheets.
#[derive(Debug, Default)]
pub(in crate::mpm) struct Proximity<const D: usize> {
    layout: Layout,
    /// Positions of all nodes at the last look [m].
    seen: Vec<Vec<Vector<D>>>,
    /// Distance that nodes may move until the next [m].
    room: f64,
    /// Work of the run that looks haven't taken their share of [sub-steps of an element].
    work: f64,
    /// Sheets for which a notice was given.
    said: BTreeSet<[u32; 2]>,
    pending: Vec<String>,
}

impl<const D: usize> Proximity<D> {
    /// For these membranes, not yet looked at.
    pub fn new(membranes: &[Membrane<D>]) -> Self {
        let facets = |membrane: &Membrane<D>| membrane.elements.iter().map(Facet::new).collect();
        let sheets = membranes.iter().map(|m| (m.name.as_str(), facets(m), m.reference.as_slice()));
        Self { layout: Layout::new(sheets), work: FREE, ..Self::default() }
    }

    /// The notices since the last call.
    pub fn take(&mut self) -> Vec<String> {
        std::mem::take(&mut self.pending)
    }

    /// The columns of a checkpoint: the sheets for which a notice was given.
    pub fn columns(&mut self, visit: &mut dyn FnMut(&str, Column<'_>)) {
        let mut said: Vec<[u32; 2]> = self.said.iter().copied().collect();
        visit("mpm.meetings", Column::growing(&mut said));
        self.said = said.into_iter().collect();
    }

    /// The first contradiction among restored columns, if there is one.
    pub fn misfit(&self) -> Option<String> {
        let sheets = self.layout.layers.len();
        let none = self.said.iter().flatten().find(|&&sheet| sheet as usize >= sheets)?;
        Some(format!("it says that membrane {none} has met another, of the {sheets} there are"))
    }

    /// Forgets the last look: nodes may be anywhere.
    pub fn forget(&mut self) {
        (self.room, self.work) = (0.0, FREE);
    }

    /// Looks if it is time to, after `work` elements and particles were moved; `t` is the end of the sub-step [s].
    pub fn watch(&mut self, membranes: &[Membrane<D>], work: u64, t: f64) {
        self.work += work as f64;
        let (sheets, count) = (membranes.len(), self.layout.count() as f64);
        if self.work < 0.0 || self.said.len() == sheets * (sheets + 1) / 2 {
            return;
        }
        let [all, compared, measured, moved] = PRICE.map(|price| SHARE * price);
        self.work -= moved * count;
        if self.moved(membranes) {
            let found = self.look(membranes);
            self.seen = membranes.iter().map(|membrane| membrane.position.clone()).collect();
            self.work -= all * count + compared * found.compared as f64 + measured * found.measured as f64;
            for meeting in found.meetings.values() {
                self.say(meeting, t);
            }
        }
    }

    /// True if a node has moved out of its room.
    fn moved(&self, membranes: &[Membrane<D>]) -> bool {
        let square = self.room * self.room;
        let far = |(membrane, seen): (&Membrane<D>, &Vec<Vector<D>>)| {
            parallel::first(seen.len(), |k| (membrane.position[k] - seen[k]).norm_squared() > square).is_some()
        };
        self.room == 0.0 || membranes.iter().zip(&self.seen).any(far)
    }

    /// Looks, and finds the room until the next time.
    fn look(&mut self, membranes: &[Membrane<D>]) -> Found {
        let state = |membrane: &Membrane<D>| State {
            position: membrane.position.iter().map(|x| Vector(x.to3())).collect(),
            thickness: (0..membrane.elements.len()).map(|e| membrane.thickness(e)).collect(),
        };
        let states: Vec<State> = membranes.iter().map(state).collect();
        let margin = 2.0 * QUARTER * self.layout.length;
        let (layout, said) = (&self.layout, &self.said);
        let counts = |[a, b]: [layout::Element; 2], reach: f64, _: bool| {
            !said.contains(&[a.sheet, b.sheet]) && !layout.began_near(a, b, reach)
        };
        let survey = Survey { layout, states: &states, margin, counts };
        let found = survey.run();
        self.room = 0.5 * found.gap.max(survey.least_thickness()).min(margin);
        found
    }

    fn say(&mut self, meeting: &Meeting, t: f64) {
        if self.said.insert(meeting.sheets()) {
            let what = describe::<D>(&self.layout, meeting);
            self.pending.push(format!(
                "{what}, at t = {t:.4e} s: contact of membranes with each other isn't resolved yet, they pass through each \
                 other; what the run shows there from now on has no meaning"
            ));
        }
    }
}

/// A warning for each two membranes, and each membrane, that cross or are too near to each other at the start.
pub fn meetings_at_the_start<const D: usize>(setup: &Setup<D>) -> Vec<Diagnostic> {
    let sheets = setup.membranes.iter();
    let facets = |elements: &[Vec<u32>]| elements.iter().map(|nodes| Facet::new(nodes)).collect();
    let layout = Layout::new(sheets.clone().map(|m| (m.name.as_str(), facets(&m.elements), m.position.as_slice())));
    let state = |membrane: &crate::mpm::MembraneSetup<D>| State {
        position: membrane.position.iter().map(|x| Vector(x.to3())).collect(),
        thickness: vec![membrane.thickness; membrane.elements.len()],
    };
    let states: Vec<State> = sheets.map(state).collect();
    let around = layout.around();
    let counts = |[a, b]: [layout::Element; 2], reach: f64, cross: bool| {
        cross || !layout.together(a, b) || !layout.neighbours(&around, [a, b], reach)
    };
    let found = Survey { layout: &layout, states: &states, margin: 0.0, counts }.run();
    let warn = |meeting: &Meeting| {
        let help =
            "contact of membranes with each other isn't resolved yet, they pass through each other: move them apart";
        let key = format!("membrane[{}].geometry", meeting.sheets()[1]);
        Diagnostic::warning(key, format!("{} at the start", describe::<D>(&layout, meeting))).help(help)
    };
    found.meetings.values().map(warn).collect()
}

/// The text about a meeting: the sheets, and the place.
fn describe<const D: usize>(layout: &Layout, meeting: &Meeting) -> String {
    let [a, b] = meeting.sheets().map(|sheet| &layout.layers[sheet as usize].name);
    let place = meeting.place.0[..D].iter().map(|c| format!("{c:.4e}")).collect::<Vec<_>>().join(", ");
    let Meeting { distance, reach, .. } = meeting;
    match (a == b, *distance == 0.0) {
        (true, true) => format!("the membrane `{a}` crosses itself at ({place})"),
        (false, true) => format!("the membranes `{a}` and `{b}` cross at ({place})"),
        (true, false) => format!(
            "parts of the membrane `{a}` come within {distance:.3e} m of each other, less than its thickness of {reach:.3e} m, \
             at ({place})"
        ),
        (false, false) => format!(
            "the membranes `{a}` and `{b}` come within {distance:.3e} m of each other, less than their mean thickness of \
             {reach:.3e} m, at ({place})"
        ),
    }
}
