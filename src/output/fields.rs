//! Fields over time for ParaView: `<name>.pvd` over `<name>/000000.vtu` (membranes, meshes) or `.vtp`
//! (particles, surfaces of solids).

pub use super::vtk::FieldPrecision;

use super::atomic::create_directory;
use super::label::{UnitLabels, file_name};
use super::vtk::{FileSeries, write_outline, write_points, write_surface};
use crate::error::Result;
use crate::simulation::{Monitor, Snapshot};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Writes all particles, membranes, meshes and surfaces of solids with all their fields.
#[derive(Debug)]
pub struct Fields {
    directory: PathBuf,
    interval: f64,
    precision: FieldPrecision,
    units: UnitLabels,
    series: BTreeMap<String, FileSeries>,
    resumed: Option<f64>,
}

impl Fields {
    /// Fields in `directory`, every `interval` seconds.
    pub fn new(directory: &Path, interval: f64, precision: FieldPrecision, units: UnitLabels) -> Self {
        let directory = directory.to_owned();
        Self { directory, interval, precision, units, series: BTreeMap::new(), resumed: None }
    }

    /// Writes one set at one time, unless it is there already, and adds it to its series.
    fn write(
        &mut self,
        name: &str,
        extension: &str,
        time: f64,
        write: impl FnOnce(&Path, FieldPrecision, UnitLabels) -> Result<()>,
    ) -> Result<()> {
        let stem = file_name(name);
        if !self.series.contains_key(&stem) {
            create_directory(&self.directory.join(&stem))?;
            let mut series = FileSeries::new(self.directory.join(format!("{stem}.pvd")));
            if let Some(time) = self.resumed {
                series.resume(time)?;
            }
            self.series.insert(stem.clone(), series);
        }
        let series = self.series.get_mut(&stem).expect("inserted above");
        if series.last_time().is_some_and(|last| last >= time) {
            return Ok(());
        }
        let file = format!("{stem}/{:06}.{extension}", series.len());
        write(&self.directory.join(&file), self.precision, self.units)?;
        series.add(time, file)
    }
}

impl Monitor for Fields {
    fn interval(&self) -> f64 {
        self.interval
    }

    fn sample(&mut self, snapshot: &Snapshot<'_>, _due: f64) -> Result<()> {
        let time = snapshot.time;
        for set in &snapshot.points {
            self.write(set.name, "vtp", time, |path, precision, units| {
                write_points(path, set, time, precision, units)
            })?;
        }
        for set in &snapshot.surfaces {
            self.write(set.name, "vtu", time, |path, precision, units| {
                write_surface(path, set, time, precision, units)
            })?;
        }
        for set in &snapshot.outlines {
            self.write(set.name, "vtp", time, |path, precision, units| {
                write_outline(path, set, time, precision, units)
            })?;
        }
        Ok(())
    }

    fn resume(&mut self, time: f64) -> Result<()> {
        self.resumed = Some(time);
        Ok(())
    }
}
