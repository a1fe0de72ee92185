//! Profiles: a field of particles at the end of a run, compared with a curve over a coordinate.
//!
//! The deviation is the volume-weighted mean distance of the particles from the curve,
//! L1 = Σ V_p |f_p − f(x_p)| / Σ V_p, which for a domain of unit size is the usual L1 error.

use super::curve::Curve;
use super::outcome::{Level, Outcome, Tolerance};
use super::series::Series;
use crate::error::{Diagnostic, Error, Result};
use crate::output::component::Component;
use crate::output::history::HistoryTable;
use crate::output::vtk::{FileSeries, read_array};
use serde::Deserialize;
use std::path::Path;

/// A profile at the end of a run.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Profile {
    /// Name of the comparison.
    pub name: String,
    /// The bodies.
    pub of: Vec<String>,
    /// A field of their particles.
    pub field: String,
    /// The component of a vector or tensor.
    pub component: Option<Component>,
    /// The coordinate that the curve goes along.
    #[serde(default)]
    pub axis: ProfileAxis,
    /// The curve; its `x` is the place.
    pub reference: Curve,
    /// Largest mean distance.
    pub tolerance: Tolerance,
    /// The tolerance of the default run, where it is another one.
    pub quick: Option<Tolerance>,
    /// The tolerance of `--full`, where it is another one.
    pub full: Option<Tolerance>,
    /// Source of the curve.
    pub source: String,
}

/// The coordinate of a profile.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ProfileAxis {
    /// Along x.
    #[default]
    X,
    /// Along y.
    Y,
    /// Along z.
    Z,
}

/// One particle of a profile.
struct ProfileSample {
    place: f64,
    value: f64,
    volume: f64,
}

impl Profile {
    /// Compares the last fields in `fields`; `read_table` reads the table of the curve.
    ///
    /// # Errors
    /// Fields, arrays or tables that aren't there or can't be read.
    pub fn apply(
        &self,
        fields: &Path,
        level: Level,
        read_table: impl Fn(&str) -> Result<HistoryTable>,
    ) -> Result<Outcome> {
        let curve = self.reference.read(read_table)?;
        let samples = self.of.iter().map(|body| self.samples(fields, body)).collect::<Result<Vec<_>>>()?;
        let distance = mean_distance(samples.iter().flatten(), &curve);
        let special = match level {
            Level::Quick => self.quick,
            Level::Full => self.full,
        };
        Ok(Outcome {
            name: self.name.clone(),
            computed: distance,
            reference: 0.0,
            deviation: distance.unwrap_or(f64::INFINITY),
            limit: special.unwrap_or(self.tolerance).absolute,
            source: self.source.clone(),
        })
    }

    /// The particles of a body in its last file.
    fn samples(&self, fields: &Path, body: &str) -> Result<Vec<ProfileSample>> {
        let mut files = FileSeries::new(fields.join(format!("{body}.pvd")));
        files.resume(f64::INFINITY)?;
        let missing = || Error::io(files.path(), std::io::ErrorKind::NotFound.into());
        let path = fields.join(files.last_file().ok_or_else(missing)?);
        let read = |array: &str| read_array(&path, array).map_err(|error| Error::io(&path, error));
        let (positions, values, volumes) = (read("position")?, read(&self.field)?, read("volume")?);
        let values = self.scalars(&values, volumes.len())?;
        let places = positions.iter().skip(self.axis as usize).step_by(3);
        let both = values.into_iter().zip(volumes);
        Ok(places.zip(both).map(|(&place, (value, volume))| ProfileSample { place, value, volume }).collect())
    }

    /// One number per particle: the values themselves, or their component.
    fn scalars(&self, values: &[f64], particles: usize) -> Result<Vec<f64>> {
        let components = values.len().checked_div(particles).unwrap_or(1);
        match self.component {
            None if components == 1 => Ok(values.to_vec()),
            Some(component) if component.fits(components) => {
                Ok(values.chunks_exact(components).map(|value| component.of(value)).collect())
            }
            Some(component) => {
                let misfit = component.misfit("profile.component", &self.field, components, 3);
                Err(Error::Case(misfit.into_iter().collect()))
            }
            None => {
                let message = format!("`{}` has {components} components, and a curve is of one number", self.field);
                let finding = Diagnostic::error("profile.field", message);
                Err(Error::case(finding.help("name one: `component = \"x\"`, or \"magnitude\"")))
            }
        }
    }
}

/// Σ V |f − f(x)| / Σ V over the samples that the curve covers; `None` if it covers none.
fn mean_distance<'a>(samples: impl Iterator<Item = &'a ProfileSample>, curve: &Series) -> Option<f64> {
    let (mut distance, mut volume) = (0.0, 0.0);
    for sample in samples {
        if let Some(exact) = curve.at(sample.place) {
            distance += sample.volume * (sample.value - exact).abs();
            volume += sample.volume;
        }
    }
    (volume > 0.0).then(|| distance / volume)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_field_of_vectors_needs_a_component() {
        let profile = |component: &str| -> Profile {
            let text = format!(
                "name = \"p\"\nof = [\"gas\"]\nfield = \"velocity\"\n{component}\nsource = \"s\"\n\
                 reference = {{ file = \"f.csv\", x = \"x\", y = \"y\" }}\ntolerance = {{ absolute = 1.0 }}"
            );
            toml::from_str(&text).unwrap_or_else(|error| panic!("{error}"))
        };
        let vectors = [3.0, 4.0, 0.0, 1.0, 2.0, 2.0];
        let told = |component: &str, values: &[f64]| profile(component).scalars(values, 2).unwrap_err().to_string();
        assert!(told("", &vectors).contains("has 3 components"), "{}", told("", &vectors));
        assert!(told("component = \"x\"", &[1.0, 2.0]).contains("no `x`"));
        assert_eq!(profile("component = \"y\"").scalars(&vectors, 2).unwrap(), [4.0, 2.0]);
        assert_eq!(profile("component = \"magnitude\"").scalars(&vectors, 2).unwrap(), [5.0, 3.0]);
        assert_eq!(profile("").scalars(&[7.0, 8.0], 2).unwrap(), [7.0, 8.0]);
    }

    #[test]
    fn the_distance_is_weighted_with_the_volume() {
        let sample = |place, value, volume| ProfileSample { place, value, volume };
        let line = Series { x: vec![0.0, 1.0], y: vec![0.0, 2.0] };
        // Distances 1 and 0 with volumes 1 and 3; the last sample lies outside the curve.
        let samples = [sample(0.5, 2.0, 1.0), sample(1.0, 2.0, 3.0), sample(1.5, 9.0, 1.0)];
        assert_eq!(mean_distance(samples.iter(), &line), Some(0.25));
        assert_eq!(mean_distance(samples[2..].iter(), &line), None);
    }
}
