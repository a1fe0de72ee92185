//! Notices for the user during a run: a fluid that is gone or going, an interface that came to an inlet, a
//! volume that could not be kept, energy that nothing gave.
//!
//! None of them stops a run. Where an interface comes to an inlet, what flows in stays the fluid of each place at the
//! start, unless the case names one; what a fluid without particles leaves behind is filled by the others.

use crate::parallel;
use crate::pfem2::boundary::BoundarySetup;
use crate::pfem2::equations::system::VelocityPressureSystem;
use crate::pfem2::fluid::FluidSetup;
use crate::pfem2::particles::Particles;
use crate::simulation::{Column, SaidOnce};
use std::collections::BTreeSet;

/// Part of its volume below which a fluid in a closed box is going.
const LEAST_VOLUME_LEFT: f64 = 0.9;

/// Relative change of the volume of one of several fluids from which a notice is given.
const CHANGED: f64 = 1e-3;

/// Part of the volume of solids that the mesh may show too little, or too much.
const SOLID_VOLUME: f64 = 0.1;

/// Imbalance of quasi-static solids, over the largest of their forces, from which a notice is given.
const BALANCED: f64 = 1e-3;

/// Steps that errors in the energy last until a notice is given: flows that begin are slower than their errors at
/// first.
const LASTING: u32 = 5;

/// Notices of a run, each kind given once.
#[derive(Debug, Clone, Default)]
pub(in crate::pfem2) struct Notices {
    /// Inlets, by their index among the sets, with each fluid that was there.
    fluids_at_inlets: BTreeSet<(usize, usize)>,
    /// Fluids that have had particles.
    ever_present: BTreeSet<usize>,
    /// Steps for which errors have taken, or given, much of the energy.
    lasting: u32,
    said: SaidOnce,
}

impl Notices {
    /// Takes the state at the start for granted: a case may begin with two fluids at an inlet.
    pub fn of_the_start<const D: usize, const N: usize>(
        system: &VelocityPressureSystem<D, N>,
        particles: &Particles<D>,
        fraction: &[Vec<f64>],
    ) -> Self {
        let mut notices = Self::default();
        notices.check_fluids(system, particles, fraction);
        let Self { fluids_at_inlets, ever_present, .. } = notices;
        Self { fluids_at_inlets, ever_present, ..Self::default() }
    }

    /// Looks at the state after a step; `fraction` by fluid and node.
    pub fn check_fluids<const D: usize, const N: usize>(
        &mut self,
        system: &VelocityPressureSystem<D, N>,
        particles: &Particles<D>,
        fraction: &[Vec<f64>],
    ) {
        let phases = fraction.len();
        if phases < 2 {
            return;
        }
        let seen = |range: std::ops::Range<usize>| {
            let mut left = vec![false; phases];
            particles.phase[range].iter().for_each(|&phase| left[usize::from(phase)] = true);
            left
        };
        let either = |a: Vec<bool>, b: Vec<bool>| a.into_iter().zip(b).map(|(a, b)| a || b).collect();
        let left = parallel::reduce(particles.len(), seen, either).unwrap_or_else(|| vec![false; phases]);
        for (index, (name, left)) in system.phase_names().zip(left).enumerate() {
            if left {
                self.ever_present.insert(index);
            } else if self.ever_present.contains(&index) {
                self.said.say(&format!("gone: {name}"), || format!("no particle of `{name}` is left"));
            }
        }
        for (inlet, fluid) in at_inlets(system, fraction) {
            if !self.fluids_at_inlets.insert((inlet, fluid)) {
                continue;
            }
            let name = &system.boundary.sets()[inlet].name;
            self.said.say(&format!("inlet: {name}"), || {
                format!(
                    "an interface came to the inlet `{name}`: what flows in stays the fluid that each place had at the start; \
                     `fluid` of the boundary names another"
                )
            });
        }
    }

    /// The volume of a fluid could not be kept with the largest shift of the interface in a step.
    pub fn volume(&mut self, fluid: &str) {
        self.said.say(&format!("volume: {fluid}"), || {
            format!(
                "the volume of `{fluid}` could not be kept: the interface may shift by the shortest edge of the mesh in a \
                 step, and that was not enough; take shorter steps (`history/balance.csv` shows the volume)"
            )
        });
    }

    /// The volume of a fluid could not be kept in a step in which nodes changed sides with every shift.
    pub fn volume_of_step(&mut self, fluid: &str) {
        self.said.say(&format!("volume of a step: {fluid}"), || {
            format!(
                "the volume of `{fluid}` could not be kept in a step, as drops and films of it came and went with every shift of \
                 the interface; the next steps make up for it (`history/balance.csv` shows the volume)"
            )
        });
    }

    /// The volumes of several fluids [m³] could not be kept.
    pub fn weights(&mut self, fluids: &[FluidSetup], start: &[f64], now: &[f64]) {
        let changed = |(start, now): (&f64, &f64)| (now - start).abs() > CHANGED * start;
        for (fluid, _) in fluids.iter().zip(start.iter().zip(now)).filter(|(_, pair)| changed(*pair)) {
            self.said.say(&format!("weights: {}", fluid.name), || {
                format!(
                    "the volume of `{}` could not be kept within a thousandth in a step: where an element begins to hold a third \
                     fluid, volumes jump; smaller elements make that less (`history/balance.csv` shows the volume)",
                    fluid.name
                )
            });
        }
    }

    /// The flow has gained too much from nothing.
    pub fn energy(&mut self) {
        let what = "errors have given the flow more than half of the kinetic energy that it ever had, or let gravity do more work than \
                    its fluids could give (`numerical dissipation` and `work of gravity` in `history/balance.csv`); take shorter \
                    steps (`time.step`, `pfem2.courant`) or smaller elements";
        self.said.say("energy", || what.to_owned());
    }

    /// Errors have taken this part of the largest other energy so far, or given it if it is below zero; a notice is
    /// given where it is `much` for some steps.
    pub fn errors(&mut self, part: f64, much: bool) {
        self.lasting = if much { LASTING.min(self.lasting + 1) } else { 0 };
        if self.lasting < LASTING {
            return;
        }
        let what = if part < 0.0 { "errors have given the flow" } else { "errors have taken" };
        self.said.say(what, || {
            format!(
                "{what} {:.0} % of the largest other energy so far (`numerical dissipation` in `history/balance.csv`; the progress \
                 line goes on showing it): smaller elements or shorter steps (`time.step`, `pfem2.courant`) make it less",
                100.0 * part.abs()
            )
        });
    }

    /// Fluids and solids have lost this part of the largest energy in the first step.
    pub fn mismatch(&mut self, part: f64) {
        self.said.say("mismatch", || {
            format!(
                "{:.0} % of the energy at the start went in the first step, because the velocities there don't fit together: a solid that moves in a fluid that \
                 doesn't make way for it, or through a wall, hits it (`numerical dissipation` in `history/balance.csv`); give the fluid a \
                 `velocity`, too, or begin at rest and push the solid (`traction`)",
                100.0 * part
            )
        });
    }

    /// Viscosity has given energy.
    pub fn negative_dissipation(&mut self) {
        let what = "`viscous dissipation` is below zero in `history/balance.csv`: the step is too long for this viscosity; take \
                    shorter steps (`time.step`)";
        self.said.say("viscous dissipation", || what.to_owned());
    }

    /// Fluids that have lost a tenth of their volume where nothing can leave; `start` and `now` by fluid [m³].
    pub fn losses(&mut self, fluids: &[FluidSetup], start: &[f64], now: &[f64]) {
        for ((fluid, start), now) in fluids.iter().zip(start).zip(now) {
            if *now < LEAST_VOLUME_LEFT * start {
                self.said.say(&format!("lost: {}", fluid.name), || {
                    format!(
                        "`{}` has lost more than a tenth of its volume, though nothing can leave: it is thinner than elements \
                         somewhere; take smaller elements (`history/balance.csv` shows the volumes)",
                        fluid.name
                    )
                });
            }
        }
    }

    /// The mesh shows solids with a volume `shown` that is not their `own` [m³], where none of them ends in
    /// the boundary.
    pub fn solid_volume(&mut self, shown: f64, own: f64) {
        if (shown - own).abs() > SOLID_VOLUME * own {
            self.said.say("volume of solids", || {
                format!(
                    "the mesh shows {:.0} % of the volume of the solids: they are thinner than elements somewhere, or have left the mesh; take \
                     smaller elements along their way",
                    100.0 * shown / own
                )
            });
        }
    }

    /// Quasi-static solids are off balance by this part of their largest internal force.
    pub fn imbalance(&mut self, part: f64) {
        if part > BALANCED {
            self.said.say("imbalance", || {
                format!(
                    "the internal forces of quasi-static solids are off balance by {:.1e} of the largest after a step: loads grow too much in \
                     one; take shorter steps (`time.step`)",
                    part
                )
            });
        }
    }

    /// Elastic solids still moved by this many elements when the step was solved for the last time.
    pub fn last_correction(&mut self, elements: f64) {
        if elements > 0.0 {
            self.said.say("unsettled", || {
                format!(
                    "the end of a step moved an elastic solid by {elements:.2} elements of the mesh however often the step was solved anew: its \
                     motion in a step is more than can be found; take shorter steps (`time.step`)"
                )
            });
        }
    }

    /// Contacts pulled, or lacked, when the step was solved for the last time.
    pub fn contacts(&mut self, are_wrong: bool) {
        if are_wrong {
            self.said.say("contacts", || {
                "a contact of a solid pulls, or one lacks, at the end of a step, however often the step was solved anew: more of it lands in a \
                 step than can be found; take shorter steps (`time.step`)"
                    .to_owned()
            });
        }
    }

    /// The notices since the last call.
    pub fn take(&mut self) -> Vec<String> {
        self.said.take()
    }

    /// Columns of a checkpoint: the steps that errors have lasted, and the notices that were given. (Fluids that have
    /// been there, and inlets that they have met, are found again by the next look.)
    pub fn columns(&mut self, visit: &mut dyn FnMut(&str, Column<'_>)) {
        visit("notices/lasting", Column::scalar(&mut self.lasting));
        // No more steps count than those after which a notice is given; a state that was not left by a run may hold any
        // number.
        self.lasting = self.lasting.min(LASTING);
        self.said.column("notices/said", visit);
    }

    /// The contradiction in columns that were just restored, if there is one.
    pub fn misfit(&self) -> Option<String> {
        self.said.misfit()
    }
}

/// The fluids at the inlets that bring none, as pairs of the place of the set and the fluid.
fn at_inlets<const D: usize, const N: usize>(
    system: &VelocityPressureSystem<D, N>,
    fraction: &[Vec<f64>],
) -> Vec<(usize, usize)> {
    let sets = system.boundary.sets().iter().enumerate();
    let asks = |set: &BoundarySetup<D>| set.condition.kind().prescribes_inflow() && set.brings.is_none();
    let touching = |(inlet, set): (usize, &BoundarySetup<D>)| {
        let nodes: BTreeSet<u32> = set.facets.iter().flat_map(|&facet| system.mesh.facet_nodes(facet)).collect();
        let there = fraction.iter().enumerate().filter(|(_, own)| nodes.iter().any(|&n| own[n as usize] > 0.5));
        there.map(|(fluid, _)| (inlet, fluid)).collect::<Vec<_>>()
    };
    sets.filter(|(_, set)| asks(set)).flat_map(touching).collect()
}
