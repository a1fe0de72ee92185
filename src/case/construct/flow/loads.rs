//! Loads on the surface of solids: tractions fixed in direction, and pressures that follow it.

use super::super::Construction;
use super::super::signals::TrialPoints;
use super::holding::BothMeshes;
use crate::case::{SupportPlace, TractionSpec};
use crate::error::Diagnostic;
use crate::pfem2::solid::mesh::SolidFacet;
use crate::pfem2::solid::setup::{SurfacePressure, SurfaceTraction};

impl Construction<'_> {
    /// The loads of the solid `body[index]`.
    pub(super) fn loads<const D: usize>(
        &mut self,
        index: usize,
        meshes: BothMeshes<'_, D>,
        over: &TrialPoints,
    ) -> (Vec<SurfaceTraction<D>>, Vec<SurfacePressure>) {
        let (mut tractions, mut pressures) = (Vec::new(), Vec::new());
        for (i, load) in self.case.file.body[index].traction.iter().enumerate() {
            let key = format!("body[{index}].traction[{i}]");
            let Some(facets) = self.loaded_facets(load, &key, meshes) else { continue };
            match (&load.value, &load.pressure) {
                (Some(value), None) => {
                    let value = self.signals(&format!("{key}.value"), value, over);
                    let traction = std::array::from_fn(|axis| value[axis].clone());
                    tractions.push(SurfaceTraction { facets, traction });
                }
                (None, Some(pressure)) => {
                    let pressure = self.signal(&format!("{key}.pressure"), pressure, over);
                    pressures.push(SurfacePressure { facets, pressure });
                }
                _ => {
                    let message =
                        "a load is a force per area with a fixed direction, or a pressure that follows the surface";
                    let help = "give either `value` or `pressure`; for both write two loads";
                    self.findings.push(Diagnostic::error(key, message).help(help));
                }
            }
        }
        (tractions, pressures)
    }

    /// The sides of elements in the place of a load.
    fn loaded_facets<const D: usize>(
        &mut self,
        spec: &TractionSpec,
        key: &str,
        (quadratic, mesh): BothMeshes<'_, D>,
    ) -> Option<Vec<u32>> {
        let nodes = self.nodes_on(&spec.on, &format!("{key}.on"), "solid", quadratic)?;
        let covered = |facet: &SolidFacet| facet.nodes.iter().all(|node| nodes.binary_search(node).is_ok());
        let facets: Vec<u32> = (0u32..).zip(&mesh.facets).filter(|(_, f)| covered(f)).map(|(f, _)| f).collect();
        if facets.is_empty() {
            let help = match spec.on {
                SupportPlace::Point(_) => {
                    "a force needs an area: name a side, or a region that holds whole sides of elements"
                }
                _ => "take a larger place, or smaller elements: it must hold all nodes of a side",
            };
            let finding = Diagnostic::error(format!("{key}.on"), "no side of an element lies in this place");
            self.findings.push(finding.help(help));
            return None;
        }
        Some(facets)
    }
}
