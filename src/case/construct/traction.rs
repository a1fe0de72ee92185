//! Loads on the surface of a body: the outermost particle of every line of the lattice towards a side.

use super::Construction;
use super::signals::TrialPoints;
use crate::case::{Side, SupportPlace, TractionSpec};
use crate::error::Diagnostic;
use crate::math::Vector;
use crate::mpm::{Load, Traction, traction};
use hashbrown::HashMap;

/// The layer of particles towards a side, by their lines of the lattice.
struct Layer<'p, const D: usize> {
    position: &'p [Vector<D>],
    axis: usize,
    upper: bool,
    outermost: HashMap<[i64; D], u32>,
}

impl<'p, const D: usize> Layer<'p, D> {
    fn new(position: &'p [Vector<D>], spacing: f64, axis: usize, upper: bool) -> Self {
        let line = |x: &Vector<D>| -> [i64; D] {
            std::array::from_fn(|i| if i == axis { 0 } else { (x[i] / spacing).floor() as i64 })
        };
        let mut outermost: HashMap<[i64; D], u32> = HashMap::new();
        for (p, x) in (0u32..).zip(position) {
            let best = outermost.entry(line(x)).or_insert(p);
            let farther = x[axis] > position[*best as usize][axis];
            if farther == upper {
                *best = p;
            }
        }
        Self { position, axis, upper, outermost }
    }

    /// The particles with their lines, in order.
    fn particles(&self) -> Vec<([i64; D], u32)> {
        let mut particles: Vec<_> = self.outermost.iter().map(|(&line, &p)| (line, p)).collect();
        particles.sort_unstable_by_key(|&(_, p)| p);
        particles
    }

    /// The neighbours of particle `p` across the layer, and the fraction of their span that is the particle's: its
    /// part of the undeformed surface is `area` [m²] across the axis. `None` where it has no neighbour.
    fn span(&self, line: [i64; D], p: u32, area: f64) -> Option<(Vec<[u32; 2]>, f64)> {
        let neighbour = |axis: usize, step: i64| {
            let mut line = line;
            line[axis] += step;
            self.outermost.get(&line).copied().unwrap_or(p)
        };
        let axes = (0..D).filter(|&axis| axis != self.axis);
        let span: Vec<[u32; 2]> = axes.map(|axis| [neighbour(axis, -1), neighbour(axis, 1)]).collect();
        let across = traction::area(&span, |id| self.position[id as usize])[self.axis];
        let outward = if self.upper { area } else { -area };
        (across.abs() > 1e-9 * area).then(|| (span, outward / across))
    }
}

impl Construction<'_> {
    /// The loads of one `traction`.
    pub(super) fn traction<const D: usize>(
        &mut self,
        spec: &TractionSpec,
        key: &str,
        position: &[Vector<D>],
        spacing: f64,
    ) -> Vec<Traction> {
        let Some((axis, upper)) = self.loaded_side(&spec.on, &format!("{key}.on"), D) else { return Vec::new() };
        let samples = TrialPoints::over(position, self.case.file.time.end);
        let layer = Layer::new(position, spacing, axis, upper);
        let area = spacing.powi(D as i32 - 1);
        match (&spec.value, &spec.pressure) {
            (Some(value), None) => {
                let value = self.signals(&format!("{key}.value"), value, &samples);
                let load = |(_, particle)| Traction { particle, load: Load::Dead { value: value.clone(), area } };
                layer.particles().into_iter().map(load).collect()
            }
            (None, Some(pressure)) => {
                let value = self.signal(&format!("{key}.pressure"), pressure, &samples);
                let load = |(line, particle)| {
                    let (span, fraction) = layer.span(line, particle, area)?;
                    Some(Traction { particle, load: Load::Pressure { value: value.clone(), span, fraction } })
                };
                let loads: Option<Vec<Traction>> = layer.particles().into_iter().map(load).collect();
                loads.unwrap_or_else(|| {
                    let message = "a pressure needs a surface of at least two particles in each direction";
                    self.findings.push(Diagnostic::error(key, message).help("use a finer `spacing`, or `value`"));
                    Vec::new()
                })
            }
            _ => {
                let message = "give `value` (fixed in direction) or `pressure` (follows the surface)";
                self.findings.push(Diagnostic::error(key, message));
                Vec::new()
            }
        }
    }

    /// The axis of a side of a body of material points, and whether it is the upper end.
    fn loaded_side(&mut self, on: &SupportPlace, key: &str, dimension: usize) -> Option<(usize, bool)> {
        let named = match on {
            SupportPlace::Named(name) => Side::NAMED.into_iter().find(|(known, _)| known == name),
            SupportPlace::Point(_) | SupportPlace::Region(_) => None,
        };
        let message = match named.map(|(_, side)| side.axis(dimension)) {
            Some(Some(side)) => return Some(side),
            Some(None) => "this side exists in 3D only",
            None => "loads of material points act on a side of the body, and this is none",
        };
        let sides = Side::NAMED.into_iter().filter(|(_, side)| side.axis(dimension).is_some());
        let sides: Vec<&str> = sides.map(|(name, _)| name).collect();
        let help = format!("in {dimension}D the sides are {}", sides.join(", "));
        self.findings.push(Diagnostic::error(key, message).help(help));
        None
    }
}
