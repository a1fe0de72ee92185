//! Membranes: mesh, supports, loads.

use super::Assembly;
use super::signals::Samples;
use crate::case::{AxisMotion, SupportPlace, SupportSpec};
use crate::error::{Diagnostic, Severity};
use crate::math::{Signal, Vector};
use crate::mesh::{Facets, check};
use crate::mpm::{MembraneSetup, SupportSetup};

/// More findings about one mesh than this are not shown.
const MOST: usize = 5;

impl Assembly<'_> {
    /// The membrane `membrane[index]`; `None` if it can't be made (and why was noted).
    pub(super) fn membrane<const D: usize>(&mut self, index: usize) -> Option<MembraneSetup<D>> {
        let spec = &self.case.file.membrane[index];
        let key = format!("membrane[{index}]");
        let facets = self.facets(index, &format!("{key}.geometry"))?;
        let position: Vec<Vector<D>> = facets.nodes.iter().map(|&x| Vector::from3(x)).collect();
        let start = Samples::start(&position);
        let over = Samples::over(&position, self.case.file.time.end);
        let velocity: [Signal; 3] = self.signals(&format!("{key}.velocity"), &spec.velocity, &start);
        let pressure = spec.pressure.as_ref();
        let warp = spec.warp.map_or_else(Vec::new, |w| vec![Vector::from3(w); facets.elements.len()]);
        let supports = spec.supports.iter().enumerate();
        let supports =
            supports.filter_map(|(i, s)| self.support(s, &format!("{key}.supports[{i}]"), &facets, &over)).collect();
        Some(MembraneSetup {
            name: spec.name.clone(),
            sheet: spec.material.clone().into_box(),
            velocity: facets.nodes.iter().map(|&x| Vector::from_fn(|i| velocity[i].value(x, 0.0))).collect(),
            position,
            warp,
            thickness: spec.thickness,
            prestress: spec.prestress,
            hourglass: [spec.hourglass.stiffness, spec.hourglass.viscosity, spec.hourglass.warping],
            damping: [spec.damping.stiffness, spec.damping.mass],
            supports,
            pressure: pressure.map_or(Signal::ZERO, |p| self.signal(&format!("{key}.pressure.value"), &p.value, &over)),
            follower: pressure.is_none_or(|p| p.follower),
            contact_thickness: spec.contact_thickness,
            elements: facets.elements,
        })
    }

    fn facets(&mut self, index: usize, key: &str) -> Option<Facets> {
        let spec = &self.case.file.membrane[index];
        let facets = match spec.geometry.build(&self.case.source.base, self.case.file.dimension) {
            Ok(facets) => facets,
            Err(finding) => {
                self.note(key, finding);
                return None;
            }
        };
        let mut findings = check::check(&facets);
        findings.sort_by_key(|f| !f.problem.is_error());
        let broken = findings.first().is_some_and(|f| f.problem.is_error());
        for finding in findings.iter().take(MOST) {
            let severity = if finding.problem.is_error() { Severity::Error } else { Severity::Warning };
            self.findings.push(Diagnostic { severity, ..Diagnostic::error(key, finding.to_string()) });
        }
        (!broken).then_some(facets)
    }

    fn support(&mut self, spec: &SupportSpec, key: &str, facets: &Facets, over: &Samples) -> Option<SupportSetup> {
        let nodes = self.support_nodes(&spec.on, &format!("{key}.on"), facets)?;
        let velocity = std::array::from_fn(|i| match &spec.velocity[i] {
            AxisMotion::Free(_) => None,
            AxisMotion::Velocity(v) => Some(self.signal(&format!("{key}.velocity[{i}]"), v, over)),
        });
        Some(SupportSetup { nodes, velocity })
    }

    fn support_nodes(&mut self, on: &SupportPlace, key: &str, facets: &Facets) -> Option<Vec<u32>> {
        let nodes = match on {
            SupportPlace::Named(name) => facets.set(name),
            SupportPlace::Point(x) => facets.nearest_node(*x).map(|node| vec![node]),
            SupportPlace::Region(shape) => {
                let region = self.region(key, shape)?;
                Some(facets.nodes_in(&region))
            }
        };
        let finding = match nodes {
            Some(nodes) if !nodes.is_empty() => return Some(nodes),
            Some(_) => Diagnostic::error(key, "there is no node of the membrane here"),
            None => Diagnostic::error(key, "the membrane has no such set of nodes")
                .help(format!("its sets are {}", facets.set_names().join(", "))),
        };
        self.findings.push(finding);
        None
    }
}
