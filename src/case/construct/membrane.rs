//! Membranes: mesh, supports, loads.

use super::Construction;
use super::signals::TrialPoints;
use crate::error::{Diagnostic, Severity};
use crate::math::{Signal, Vector};
use crate::mesh::{Facets, check};
use crate::mpm::{MembraneSetup, SupportSetup};

/// More findings about one mesh than this are not shown.
const MOST_FINDINGS: usize = 5;

impl Construction<'_> {
    /// The membrane `membrane[index]`; `None` if it can't be made (and why was noted).
    pub(super) fn membrane<const D: usize>(&mut self, index: usize) -> Option<MembraneSetup<D>> {
        let spec = &self.case.file.membrane[index];
        let key = format!("membrane[{index}]");
        let facets = self.facets(index, &format!("{key}.geometry"))?;
        let position: Vec<Vector<D>> = facets.nodes.iter().map(|&x| Vector::from3(x)).collect();
        let start = TrialPoints::start(&position);
        let over = TrialPoints::over(&position, self.case.file.time.end);
        let velocity: [Signal; 3] = self.signals(&format!("{key}.velocity"), &spec.velocity, &start);
        let pressure = spec.pressure.as_ref();
        let load = pressure.map_or(Signal::ZERO, |p| self.signal(&format!("{key}.pressure.value"), &p.value, &over));
        self.turned(index, &facets, over.has_positive(&load));
        let warp = spec.warp.map_or_else(Vec::new, |w| vec![Vector::from3(w); facets.elements.len()]);
        for (i, _) in spec.supports.iter().enumerate().filter(|(_, support)| support.is_spring()) {
            let finding =
                Diagnostic::error(format!("{key}.supports[{i}]"), "springs are for solids of `method = \"pfem2\"`");
            self.findings.push(
                finding.help("take `stiffness` and `damping` out: a membrane is held, or moved with a `velocity`"),
            );
        }
        let supports = spec.supports.iter().enumerate();
        let supports =
            supports.filter_map(|(i, s)| self.support(s, &format!("{key}.supports[{i}]"), "membrane", &facets, &over));
        let supports = supports.map(|(nodes, velocity)| SupportSetup { nodes, velocity }).collect();
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
            pressure: load,
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
                self.find(key, finding);
                return None;
            }
        };
        let mut findings = check::check(&facets);
        findings.sort_by_key(|f| !f.problem.is_error());
        let broken = findings.first().is_some_and(|f| f.problem.is_error());
        for finding in findings.iter().take(MOST_FINDINGS) {
            let severity = if finding.problem.is_error() { Severity::Error } else { Severity::Warning };
            self.findings.push(Diagnostic { severity, ..Diagnostic::error(key, finding.to_string()) });
        }
        (!broken).then_some(facets)
    }

    /// Notes closed parts whose normals point into them where something goes by normals: a pressure that is `pushing`,
    /// volumes, contact pressures.
    fn turned(&mut self, index: usize, facets: &Facets, pushing: bool) {
        let (file, dimension) = (&self.case.file, self.case.file.dimension);
        let [closed, turned] = [facets.closed_parts(dimension), facets.turned_parts(dimension)];
        let Some(first) = turned.first() else { return };
        let name = &file.membrane[index].name;
        let which = if closed.len() == 1 {
            format!("`{name}` is turned inside out: its normals point inwards")
        } else {
            let [lower, upper] = first.bounds.map(|x| format!("{:?}", &x[..dimension]));
            let counts = format!("{} of the {} closed parts of `{name}`", turned.len(), closed.len());
            format!("{counts} are turned inside out, the first from {lower} to {upper} m: their normals point inwards")
        };
        let reverse = "list the nodes of its elements in the other order (of a `chain` its points)";
        if pushing {
            let message = format!("{which}, and so does this pressure");
            let finding = Diagnostic::warning(format!("membrane[{index}].pressure.value"), message);
            self.findings.push(finding.help(format!("{reverse}, or change the sign of `value`")));
        }
        for (i, probe) in file.probe.iter().enumerate().filter(|(_, probe)| probe.of == *name) {
            let key = format!("probe[{i}].quantity");
            match probe.quantity.as_str() {
                "contact pressure" => {
                    let message = format!("{which}, where this pressure counts as positive");
                    self.findings.push(Diagnostic::warning(key, message).help(reverse));
                }
                "volume" if turned.len() < closed.len() => {
                    let message = format!("{which}: their volumes are taken from those of the others");
                    self.findings.push(Diagnostic::error(key, message).help(reverse));
                }
                _ => {}
            }
        }
    }
}
