//! Histories of forces (contact, walls) and of counts (particles that crossed a sheet).
//!
//! One convention for both methods, in the heads as well: the force that the material exerts on the wall, obstacle,
//! part or support, and in a contact the force on the first of the two. The moment of a force about a point has
//! the same sign.

use super::history::{History, StepStart};
use super::label::{UnitLabels, file_name};
use crate::error::Result;
use crate::simulation::{Monitor, Snapshot};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Writes every named force to `<force>.csv`: mean over the time since the row before, one column per direction [N];
/// and its moment [N m], where there is one: in the plane one column, in space three.
#[derive(Debug)]
pub struct Forces {
    directory: PathBuf,
    interval: f64,
    units: UnitLabels,
    histories: BTreeMap<String, History>,
    resumed: Option<f64>,
}

impl Forces {
    /// Forces in `directory`, every `interval` seconds.
    pub fn new(directory: &Path, interval: f64, units: UnitLabels) -> Self {
        Self { directory: directory.to_owned(), interval, units, histories: BTreeMap::new(), resumed: None }
    }

    /// The history of a force; one that the resumed run meets again goes on from its file.
    fn history(&mut self, name: &str) -> Result<&mut History> {
        if !self.histories.contains_key(name) {
            let mut history = History::new(self.directory.join(format!("{}.csv", file_name(name))));
            if let Some(time) = self.resumed {
                history.resume(time)?;
            }
            self.histories.insert(name.to_owned(), history);
        }
        Ok(self.histories.get_mut(name).expect("inserted above"))
    }
}

impl Monitor for Forces {
    fn interval(&self) -> f64 {
        self.interval
    }

    /// Means are those up to the time at which it is due.
    fn interpolates(&self) -> bool {
        true
    }

    fn sample(&mut self, snapshot: &Snapshot<'_>, due: f64) -> Result<()> {
        let unit = if snapshot.dimension == 2 { "N/m" } else { "N" };
        for (name, force) in &snapshot.forces {
            let axes = ["fx", "fy", "fz"].into_iter().take(snapshot.dimension);
            let mut heads = vec![self.units.head("time", "s")];
            heads.extend(axes.map(|axis| self.units.head_of(axis, unit, &on(name))));
            let mut row = vec![due];
            row.extend_from_slice(&force[..snapshot.dimension]);
            if let Some((_, moment)) = snapshot.moments.iter().find(|(of, _)| of == name) {
                let (first, unit) = if snapshot.dimension == 2 { (2, "N m/m") } else { (0, "N m") };
                let axes = ["mx", "my", "mz"].into_iter().skip(first);
                heads.extend(axes.map(|axis| self.units.head_of(axis, unit, &on(name))));
                row.extend_from_slice(&moment[first..]);
            }
            self.history(name)?.append(&heads, &row)?;
        }
        Ok(())
    }

    fn records_forces(&self) -> bool {
        true
    }

    fn resume(&mut self, time: f64) -> Result<()> {
        self.resumed = Some(time);
        Ok(())
    }
}

/// The part that a force acts on, for the heads of its history.
fn on(name: &str) -> String {
    match name.strip_prefix("contacts:") {
        Some(solid) => format!("on {solid}"),
        None if name.starts_with("contact:") => "on the first".to_owned(),
        None => format!("on {name}"),
    }
}

/// Writes every named count, and the amounts beside them, to `counts.csv`, one column each.
#[derive(Debug)]
pub struct CountHistory {
    history: History,
    interval: f64,
    units: UnitLabels,
    step_start: StepStart,
}

impl CountHistory {
    /// Counts in `directory`, every `interval` seconds.
    pub fn new(directory: &Path, interval: f64, units: UnitLabels) -> Self {
        Self { history: History::new(directory.join("counts.csv")), interval, units, step_start: StepStart::default() }
    }
}

impl Monitor for CountHistory {
    fn interval(&self) -> f64 {
        self.interval
    }

    fn interpolates(&self) -> bool {
        true
    }

    fn begin_step(&mut self, snapshot: &Snapshot<'_>) {
        self.step_start.keep(snapshot.time, amounts(snapshot));
    }

    /// Counts are those at the end of the step.
    fn sample(&mut self, snapshot: &Snapshot<'_>, due: f64) -> Result<()> {
        if snapshot.counts.is_empty() {
            return Ok(());
        }
        let counts = snapshot.counts.iter().map(|(name, _)| name.clone());
        let named = snapshot.amounts.iter().map(|(name, unit, _)| self.units.head(name, unit));
        let heads: Vec<String> = [self.units.head("time", "s")].into_iter().chain(counts).chain(named).collect();
        let mut row = vec![due];
        row.extend(snapshot.counts.iter().map(|(_, count)| *count as f64));
        row.extend(self.step_start.between(due, snapshot.time, amounts(snapshot)));
        self.history.append(&heads, &row)
    }

    fn resume(&mut self, time: f64) -> Result<()> {
        self.history.resume(time)
    }
}

fn amounts(snapshot: &Snapshot<'_>) -> Vec<f64> {
    snapshot.amounts.iter().map(|(_, _, amount)| *amount).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::history::HistoryTable;

    fn pushing(time: f64) -> Snapshot<'static> {
        let forces =
            ["contact:ball-sheet", "wall:left"].map(|name| (name.to_owned(), [time, 2.0 * time, 0.0])).to_vec();
        let counts = vec![("crossed:sheet".to_owned(), 3)];
        let amounts = vec![("stray volume: water".to_owned(), "m^2", 0.5)];
        Snapshot { time, dimension: 2, forces, counts, amounts, ..Snapshot::default() }
    }

    #[test]
    fn each_force_has_a_file_and_a_resumed_run_repeats_it() {
        let dir = tempfile::tempdir().unwrap();
        let mut forces = Forces::new(dir.path(), 1.0, UnitLabels::Shown);
        for time in [0.0, 1.0, 2.0] {
            forces.sample(&pushing(time), time).unwrap();
        }
        let path = dir.path().join("contact-ball-sheet.csv");
        let whole = std::fs::read_to_string(&path).unwrap();
        assert_eq!(
            whole,
            "time [s],fx [N/m on the first],fy [N/m on the first]\n0.0,0.0,0.0\n1.0,1.0,2.0\n2.0,2.0,4.0\n"
        );
        let wall = HistoryTable::read(&dir.path().join("wall-left.csv")).unwrap();
        assert_eq!(wall.heads, ["time [s]", "fx [N/m on wall:left]", "fy [N/m on wall:left]"]);
        assert_eq!(wall.column("fy").unwrap(), [0.0, 2.0, 4.0]);

        let mut resumed = Forces::new(dir.path(), 1.0, UnitLabels::Shown);
        resumed.resume(1.0).unwrap();
        resumed.sample(&pushing(2.0), 2.0).unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), whole);
    }

    /// In the plane a moment has the third component alone; forces without one have no columns of it.
    #[test]
    fn a_moment_stands_beside_its_force() {
        let dir = tempfile::tempdir().unwrap();
        let mut forces = Forces::new(dir.path(), 1.0, UnitLabels::Shown);
        let moments = vec![("wall:left".to_owned(), [0.0, 0.0, 7.0])];
        forces.sample(&Snapshot { moments: moments.clone(), ..pushing(1.0) }, 1.0).unwrap();
        let text = |dir: &Path, name: &str| std::fs::read_to_string(dir.join(name)).unwrap();
        assert_eq!(
            text(dir.path(), "wall-left.csv"),
            "time [s],fx [N/m on wall:left],fy [N/m on wall:left],mz [N m/m on wall:left]\n1.0,1.0,2.0,7.0\n"
        );
        assert!(!text(dir.path(), "contact-ball-sheet.csv").contains("mz"));
        let space = tempfile::tempdir().unwrap();
        let snapshot = Snapshot { moments, dimension: 3, ..pushing(1.0) };
        Forces::new(space.path(), 1.0, UnitLabels::Hidden).sample(&snapshot, 1.0).unwrap();
        assert!(text(space.path(), "wall-left.csv").contains("1.0,1.0,2.0,0.0,0.0,0.0,7.0\n"));
    }

    #[test]
    fn counts_share_a_table() {
        let dir = tempfile::tempdir().unwrap();
        CountHistory::new(dir.path(), 1.0, UnitLabels::Hidden).sample(&pushing(1.0), 1.0).unwrap();
        let written = std::fs::read_to_string(dir.path().join("counts.csv")).unwrap();
        assert_eq!(written, "time,crossed:sheet,stray volume: water\n1.0,3.0,0.5\n");
    }
}
