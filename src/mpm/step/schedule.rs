//! The sweeps of a step as one value, made once from the stress update and the cure of locking.
//!
//! S: scatter, G: gather, R: gather and scatter in one sweep; m, p, f: mass, momentum, force.
//!
//! | stress update | momentum | force | motion | re-mapping | stress | landing |
//! |---|---|---|---|---|---|---|
//! | first | S m p | R strain stress → f | G rate velocity | | | x |
//! | last | S m p f | | G velocity strain stress land | | | |
//! | modified last | S m p f | | R rate velocity → p | ṽ | G strain heat stress land | |
//! | average | S m p | R strain stress → f | R rate velocity → p | ṽ | G strain heat stress land | |
//!
//! With averages over the nodes (theory A.10) a strain is R strain → ΔJ, and the stress update reads the mean of ΔJ; a
//! force is R … → p, R p̃ → f: stresses before and after with averages make seven sweeps. When the noise filter is due,
//! nothing is scattered or strained before it: velocities are gathered, filtered, and scattered anew where they are
//! re-mapped.
//!
//! `first` and the first half of `average` strain with v⁻ over the interval that led to the positions; `last` with v⁺,
//! the others with ṽ, over the interval that follows (theory A.8).

use crate::mpm::executor::{MoveBy, Onto, Operation, Read, Visit};
use crate::mpm::stress::strain::Positions;
use crate::mpm::transfer::ScatterContent;
use crate::mpm::{Locking, StressUpdate};

/// The velocity of the nodes that strains the bodies after contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::mpm) enum StrainVelocity {
    /// None: no sweep is there for strains alone.
    None,
    /// v⁺.
    Nodes,
    /// The particles' new velocity, mapped back: ṽ.
    Remapped,
}

/// The sweeps after contact, over nodes that hold (m, v⁺, a).
#[derive(Debug, Clone)]
pub(in crate::mpm) struct AfterContact {
    /// v_p and ẋ_p, Lian (65, 19).
    pub motion: Vec<Visit>,
    /// The particles' new momentum, where `motion` has not scattered it.
    pub remap: Vec<Visit>,
    /// The velocity of the stress update.
    pub strain_velocity: StrainVelocity,
    /// σ_p, Lian (62, 63), and x_p, Lian (19).
    pub stress: Vec<Visit>,
    /// x_p, where no sweep before has moved the particles.
    pub landing: Vec<Visit>,
}

/// All sweeps over the particles that steps make, by stage.
#[derive(Debug, Clone)]
pub(in crate::mpm) struct SweepSchedule {
    /// m_I and p_I⁻, Lian (60, 61), and f_I where the stresses are known.
    pub momentum: Vec<Visit>,
    /// σ_p over the interval that led here, Lian (62, 63), and f_I, Lian (17, 18).
    force: Vec<Visit>,
    /// Visits for the force before any time has passed: no volume has changed that could be averaged.
    force_at_the_start: Vec<Visit>,
    unfiltered: AfterContact,
    filtered: AfterContact,
    /// Parts of the intervals before and after the positions over which stresses are updated; `None`: not at all.
    intervals: [Option<f64>; 2],
}

impl SweepSchedule {
    /// The sweeps of a stress update with a cure of locking.
    pub fn new(update: StressUpdate, locking: Locking) -> Self {
        let intervals = match update {
            StressUpdate::First => [Some(1.0), None],
            StressUpdate::Last | StressUpdate::ModifiedLast => [None, Some(1.0)],
            StressUpdate::Average => [Some(0.5), Some(0.5)],
        };
        let averages = locking != Locking::None;
        let content = match intervals {
            [None, _] if !averages => ScatterContent::MomentumAndForce,
            _ => ScatterContent::Momentum,
        };
        let strains = intervals[0].is_some();
        Self {
            momentum: vec![Visit::Scatter(content, Onto::Nodes)],
            force: if strains { strain_and_force(averages, true) } else { force(averages) },
            force_at_the_start: if strains { strain_and_force(averages, false) } else { force(averages) },
            unfiltered: unfiltered(update, averages),
            filtered: filtered(update, averages),
            intervals,
        }
    }

    /// The sweeps that make forces, after the interval `dt_previous` [s].
    pub fn force(&self, dt_previous: f64) -> &[Visit] {
        if dt_previous > 0.0 { &self.force } else { &self.force_at_the_start }
    }

    /// The sweeps after contact, in a step with a noise filter of this order; 0: without.
    pub fn after_contact(&self, filter_order: u32) -> &AfterContact {
        if filter_order == 0 { &self.unfiltered } else { &self.filtered }
    }

    /// The increment over which stresses are updated before the forces, of the interval that led here [s].
    pub fn strain_before(&self, dt_previous: f64) -> Option<f64> {
        self.intervals[0].map(|part| part * dt_previous)
    }

    /// Interval of the strain increment after the motion, that which follows [s].
    pub fn strain_after(&self, dt: f64) -> Option<f64> {
        self.intervals[1].map(|part| part * dt)
    }
}

/// Forces of stresses that are known: none are left where momentum and force were scattered at once.
fn force(averages: bool) -> Vec<Visit> {
    let Some(average) = averages.then(averaged_force) else { return Vec::new() };
    vec![Visit::Scatter(ScatterContent::Pressures, Onto::Sums), average]
}

/// f_I of averaged pressures, from their sums.
fn averaged_force() -> Visit {
    Visit::Relay(Read::Averages, vec![Operation::AveragePressure], ScatterContent::Force, Onto::Nodes)
}

/// Strains, updates stresses, and scatters their forces; `changed`: the volumes may have.
fn strain_and_force(averages: bool, changed: bool) -> Vec<Visit> {
    use Operation::{AverageVolumeRatio, ReferToStart, Stress, VolumeRatio};
    let volume_ratio = VolumeRatio(Positions::End);
    let at_once = vec![volume_ratio, ReferToStart, Stress];
    let averaged = vec![ReferToStart, AverageVolumeRatio, Stress];
    match (averages, changed) {
        (false, _) => vec![Visit::Relay(Read::Strain, at_once, ScatterContent::Force, Onto::Nodes)],
        (true, false) => {
            vec![Visit::Relay(Read::Strain, at_once, ScatterContent::Pressures, Onto::Sums), averaged_force()]
        }
        (true, true) => vec![
            Visit::Relay(Read::Strain, vec![volume_ratio], ScatterContent::Volumes, Onto::Sums),
            Visit::Relay(Read::Averages, averaged, ScatterContent::Pressures, Onto::Sums),
            averaged_force(),
        ],
    }
}

/// Σ N v̂ where external forces work.
fn midstep_velocity() -> Visit {
    Visit::Gather(Read::MidstepVelocity, vec![Operation::MidstepVelocity])
}

/// The sweeps after contact without a noise filter.
fn unfiltered(update: StressUpdate, averages: bool) -> AfterContact {
    use Operation::{Land, Rate, Stress, Velocity, VolumeRatio};
    let separate = filtered(update, averages);
    match update {
        StressUpdate::First => separate,
        StressUpdate::Last if averages => separate,
        StressUpdate::Last => {
            let all = vec![Velocity, VolumeRatio(Positions::Start), Stress, Land(MoveBy::Gathered)];
            AfterContact {
                motion: vec![midstep_velocity(), Visit::Gather(Read::Motion, all)],
                strain_velocity: StrainVelocity::None,
                stress: Vec::new(),
                ..separate
            }
        }
        StressUpdate::ModifiedLast | StressUpdate::Average => {
            let relay = Visit::Relay(Read::Motion, vec![Rate, Velocity], ScatterContent::Momentum, Onto::Velocity);
            AfterContact { motion: vec![midstep_velocity(), relay], remap: Vec::new(), ..separate }
        }
    }
}

/// The sweeps after contact with a noise filter between motion and stress update.
fn filtered(update: StressUpdate, averages: bool) -> AfterContact {
    let motion = vec![Operation::Rate, Operation::Velocity];
    let (strain_velocity, move_by) = match update {
        StressUpdate::First => (StrainVelocity::None, MoveBy::Kept),
        StressUpdate::Last => (StrainVelocity::Nodes, MoveBy::Kept),
        StressUpdate::ModifiedLast | StressUpdate::Average => (StrainVelocity::Remapped, MoveBy::StrainOfSolids),
    };
    let remapped = strain_velocity == StrainVelocity::Remapped;
    let strained = strain_velocity != StrainVelocity::None;
    let scatter = Visit::Scatter(ScatterContent::Momentum, Onto::Velocity);
    AfterContact {
        motion: vec![midstep_velocity(), Visit::Gather(Read::Motion, motion)],
        remap: if remapped { vec![scatter] } else { Vec::new() },
        strain_velocity,
        stress: if strained { strain_and_land(averages, remapped, move_by) } else { Vec::new() },
        landing: if strained { Vec::new() } else { vec![Visit::Land] },
    }
}

/// Strains with the heat that re-mapped nodes hand over, updates stresses, and moves the particles.
fn strain_and_land(averages: bool, remapped: bool, move_by: MoveBy) -> Vec<Visit> {
    use Operation::{AverageVolumeRatio, Heat, Land, Stress, VolumeRatio};
    let mut strain = vec![VolumeRatio(Positions::Start)];
    if remapped {
        strain.push(Heat);
    }
    let land = Land(move_by);
    if averages {
        return vec![
            Visit::Relay(Read::Strain, strain, ScatterContent::Volumes, Onto::Sums),
            Visit::Gather(Read::Averages, vec![AverageVolumeRatio, Stress, land]),
        ];
    }
    strain.extend([Stress, land]);
    vec![Visit::Gather(Read::Strain, strain)]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sweeps of a step over bodies without external forces.
    fn count(update: StressUpdate, locking: Locking, filter_order: u32) -> usize {
        let schedule = SweepSchedule::new(update, locking);
        let AfterContact { motion, remap, stress, landing, .. } = schedule.after_contact(filter_order);
        let idle = motion.iter().filter(|visit| matches!(visit, Visit::Gather(Read::MidstepVelocity, _))).count();
        let stages = [&schedule.momentum[..], schedule.force(1.0), motion, remap, stress, landing];
        stages.iter().map(|visits| visits.len()).sum::<usize>() - idle
    }

    #[test]
    fn steps_make_few_sweeps() {
        let averages = Locking::Average { blend: 1.0 };
        let updates = [StressUpdate::First, StressUpdate::Last, StressUpdate::ModifiedLast, StressUpdate::Average];
        assert_eq!(updates.map(|update| count(update, Locking::None, 0)), [4, 2, 3, 4]);
        assert_eq!(updates.map(|update| count(update, averages, 0)), [6, 6, 6, 7]);
        assert_eq!(updates.map(|update| count(update, Locking::None, 2)), [4, 3, 4, 5]);
    }

    /// Particles move once in a step, and stresses are updated as often as the scheme says.
    #[test]
    fn every_schedule_moves_once() {
        for (update, updates) in [
            (StressUpdate::First, 1),
            (StressUpdate::Last, 1),
            (StressUpdate::ModifiedLast, 1),
            (StressUpdate::Average, 2),
        ] {
            for (locking, order) in [(Locking::None, 0), (Locking::None, 2), (Locking::Average { blend: 0.5 }, 0)] {
                let schedule = SweepSchedule::new(update, locking);
                let AfterContact { motion, remap, stress, landing, .. } = schedule.after_contact(order);
                let all = [&schedule.momentum[..], schedule.force(1.0), motion, remap, stress, landing].concat();
                let operations = |visit: &Visit| match visit {
                    Visit::Gather(_, list) | Visit::Relay(_, list, ..) => list.clone(),
                    Visit::Scatter(..) => Vec::new(),
                    Visit::Land => vec![Operation::Land(MoveBy::Kept)],
                };
                let all: Vec<Operation> = all.iter().flat_map(operations).collect();
                let landings = all.iter().filter(|operation| matches!(operation, Operation::Land(_))).count();
                let stresses = all.iter().filter(|operation| **operation == Operation::Stress).count();
                assert_eq!((landings, stresses), (1, updates), "{update:?} {locking:?} {order}");
            }
        }
    }
}
