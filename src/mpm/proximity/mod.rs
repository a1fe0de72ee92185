//! Detection of sheets that come near each other, or themselves (theory D.17). Contact between sheets is not resolved;
//! it is reported.
//!
//! Two elements are in contact where they cross, or where they are nearer to each other than the mean τ of their
//! thicknesses. Elements that share a node, or have nodes at the same places and so are joined there, don't count; nor
//! do those that were as near at the start: of one sheet twice as near, because a sheet that is compressed along itself
//! brings its elements together, too.
//!
//! ```text
//! ½ min(max(g, τ_min), ½ L)   displacement of nodes until the next survey: g: least gap between elements that count, less τ;
//!                             L: length of elements                                       (theory (D.31))
//! ```
//!
//! Two sheets that approach each other are thus detected while they are within τ, before they have passed. Where sheets
//! are so fast that surveys would cost more than 2 % of the run, they are rarer. All of this follows from counts, never
//! from times.

pub mod distance;
mod layout;
mod survey;

use crate::error::Diagnostic;
use crate::math::Vector;
use crate::mpm::contact::SheetFacet;
use crate::mpm::{Membrane, Setup};
use crate::parallel;
use crate::simulation::Column;
use layout::Layout;
use std::collections::BTreeSet;
use survey::{ElementContact, Survey, SurveyResult, SurveyedSheet};

/// Largest displacement of nodes between two surveys [lengths of elements].
const QUARTER: f64 = 0.25;

/// The work of a run over that of surveys, at least, beyond [`FREE_WORK`].
const WORK_RATIO: f64 = 60.0;

/// Work of surveys that is negligible in any run [sub-steps of an element].
const FREE_WORK: f64 = 1e6;

/// Cost of a survey per element, per element that it compares, and per pair that it measures; and of the test how far
/// nodes have moved, per element: in sub-steps of an element or steps of a particle.
const COST: [f64; 4] = [0.5, 0.5, 4.0, 0.05];

/// Surveys of the distances between sheets during a run.
#[derive(Debug, Default)]
pub(in crate::mpm) struct Proximity<const D: usize> {
    layout: Layout,
    /// Positions of all nodes at the last survey [m].
    surveyed: Vec<Vec<Vector<D>>>,
    /// Displacement of nodes until the next survey [m]; 0: at once.
    allowance: f64,
    /// Work of the run of which surveys have not used their part [sub-steps of an element].
    work: f64,
    /// Pairs of sheets whose contact was reported.
    reported: BTreeSet<[u32; 2]>,
    pending: Vec<String>,
}

impl<const D: usize> Proximity<D> {
    /// The proximity of these membranes, before the first survey.
    pub fn new(membranes: &[Membrane<D>]) -> Self {
        let facets = |membrane: &Membrane<D>| membrane.elements.iter().map(SheetFacet::new).collect();
        let sheets = membranes.iter().map(|m| (m.name.as_str(), facets(m), m.reference.as_slice()));
        Self { layout: Layout::new(sheets), work: FREE_WORK, ..Self::default() }
    }

    /// Notices since the last call.
    pub fn take(&mut self) -> Vec<String> {
        std::mem::take(&mut self.pending)
    }

    /// Columns of a checkpoint: the pairs that were reported.
    pub fn columns(&mut self, visit: &mut dyn FnMut(&str, Column<'_>)) {
        let mut reported: Vec<[u32; 2]> = self.reported.iter().copied().collect();
        visit("mpm.meetings", Column::growing(&mut reported));
        self.reported = reported.into_iter().collect();
    }

    /// An inconsistency of columns that were just restored.
    pub fn misfit(&self) -> Option<String> {
        let sheets = self.layout.sheets.len();
        let none = self.reported.iter().flatten().find(|&&sheet| sheet as usize >= sheets)?;
        Some(format!("it says that membrane {none} has met another, of the {sheets} there are"))
    }

    /// Discards the last survey: nodes may be anywhere.
    pub fn forget(&mut self) {
        (self.allowance, self.work) = (0.0, FREE_WORK);
    }

    /// Surveys the sheets if nodes have moved far enough, after `work` elements and particles were moved; `t` is the
    /// end of the sub-step [s].
    pub fn survey_if_due(&mut self, membranes: &[Membrane<D>], work: u64, t: f64) {
        self.work += work as f64;
        let (sheets, count) = (membranes.len(), self.layout.count() as f64);
        if self.work < 0.0 || self.reported.len() == sheets * (sheets + 1) / 2 {
            return;
        }
        let [all, compared, measured, moved] = COST.map(|price| WORK_RATIO * price);
        self.work -= moved * count;
        if self.moved(membranes) {
            let found = self.survey(membranes);
            self.surveyed = membranes.iter().map(|membrane| membrane.position.clone()).collect();
            self.work -= all * count + compared * found.compared as f64 + measured * found.measured as f64;
            for contact in found.contacts.values() {
                self.report(contact, t);
            }
        }
    }

    /// True if a node has moved as far as the next survey allows.
    fn moved(&self, membranes: &[Membrane<D>]) -> bool {
        let square = self.allowance * self.allowance;
        let far = |(membrane, surveyed): (&Membrane<D>, &Vec<Vector<D>>)| {
            parallel::first(surveyed.len(), |k| (membrane.position[k] - surveyed[k]).norm_squared() > square).is_some()
        };
        self.allowance == 0.0 || membranes.iter().zip(&self.surveyed).any(far)
    }

    /// Surveys the sheets, and finds the displacement until the next time.
    fn survey(&mut self, membranes: &[Membrane<D>]) -> SurveyResult {
        let state = |membrane: &Membrane<D>| SurveyedSheet {
            position: membrane.position.iter().map(|x| Vector(x.to3())).collect(),
            thickness: (0..membrane.elements.len()).map(|e| membrane.thickness(e)).collect(),
        };
        let states: Vec<SurveyedSheet> = membranes.iter().map(state).collect();
        let margin = 2.0 * QUARTER * self.layout.length;
        let (layout, reported) = (&self.layout, &self.reported);
        let counts = |[a, b]: [layout::Element; 2], reach: f64, _: bool| {
            !reported.contains(&[a.sheet, b.sheet]) && !layout.began_near(a, b, reach)
        };
        let survey = Survey { layout, states: &states, margin, counts };
        let found = survey.run();
        self.allowance = 0.5 * found.gap.max(survey.least_thickness()).min(margin);
        found
    }

    fn report(&mut self, contact: &ElementContact, t: f64) {
        if self.reported.insert(contact.sheets()) {
            let what = describe::<D>(&self.layout, contact);
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
    let facets = |elements: &[Vec<u32>]| elements.iter().map(|nodes| SheetFacet::new(nodes)).collect();
    let layout = Layout::new(sheets.clone().map(|m| (m.name.as_str(), facets(&m.elements), m.position.as_slice())));
    let state = |membrane: &crate::mpm::MembraneSetup<D>| SurveyedSheet {
        position: membrane.position.iter().map(|x| Vector(x.to3())).collect(),
        thickness: vec![membrane.thickness; membrane.elements.len()],
    };
    let states: Vec<SurveyedSheet> = sheets.map(state).collect();
    let around = layout.around();
    let counts = |[a, b]: [layout::Element; 2], reach: f64, cross: bool| {
        cross || !layout.together(a, b) || !layout.neighbours(&around, [a, b], reach)
    };
    let found = Survey { layout: &layout, states: &states, margin: 0.0, counts }.run();
    let warn = |contact: &ElementContact| {
        let help =
            "contact of membranes with each other isn't resolved yet, they pass through each other: move them apart";
        let key = format!("membrane[{}].geometry", contact.sheets()[1]);
        Diagnostic::warning(key, format!("{} at the start", describe::<D>(&layout, contact))).help(help)
    };
    found.contacts.values().map(warn).collect()
}

/// The sheets in contact, distance and place.
fn describe<const D: usize>(layout: &Layout, contact: &ElementContact) -> String {
    let [a, b] = contact.sheets().map(|sheet| &layout.sheets[sheet as usize].name);
    let place = contact.place.0[..D].iter().map(|c| format!("{c:.4e}")).collect::<Vec<_>>().join(", ");
    let ElementContact { distance, reach, .. } = contact;
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
