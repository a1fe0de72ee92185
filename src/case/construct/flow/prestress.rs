//! Laws of solids beside their moduli: the stress of a solid in the shape in which it is given, and incompressible
//! ones.

use super::super::Construction;
use super::super::signals::TrialPoints;
use crate::case::{CaseFile, Material, PlaneSpec};
use crate::error::Diagnostic;
use crate::material::{INCOMPRESSIBLE, PointLaw, Prestressed};
use crate::math::SymTensor;

/// Names of the components of a stress.
const COMPONENTS: [&str; 6] = ["xx", "yy", "zz", "xy", "yz", "zx"];

impl Construction<'_> {
    /// The law of the solid `body[index]` with its stress in the shape that is given, if there is one.
    pub(super) fn prestressed<const D: usize>(
        &mut self,
        index: usize,
        law: Box<dyn PointLaw>,
    ) -> Option<Box<dyn PointLaw>> {
        let spec = &self.case.file.body[index];
        let (key, plane) = (format!("body[{index}].stress"), spec.plane.unwrap_or_default());
        let Some(given) = spec.stress.as_ref().filter(|_| !law.is_rigid()) else { return Some(law) };
        let signals = self.signals(&key, given, &TrialPoints::at(&[[0.0; 3]], 0.0));
        if !signals.iter().all(|signal| signal.is_uniform() && signal.is_steady()) {
            let finding = Diagnostic::error(&key, "the stress of a solid at the start is the same everywhere");
            let help = "write six numbers, `stress = [\"1 MPa\", 0, 0, 0, 0, 0]`; loads and supports lead to other stresses, with \
                        `start = \"equilibrium\"` from the start";
            self.findings.push(finding.help(help));
            return None;
        }
        let stress = SymTensor(std::array::from_fn(|k| signals[k].value([0.0; 3], 0.0)));
        if let Some(k) = across::<D>(&stress, plane) {
            let message = format!("the component `{}` acts across the plane", COMPONENTS[k]);
            let help = "in 2D `yz` and `zx` are zero, and with `plane = \"stress\"` so is `zz`";
            self.findings.push(Diagnostic::error(&key, message).help(help));
            return None;
        }
        match Prestressed::new(law, stress) {
            Ok(law) => Some(Box::new(law)),
            Err(why) => {
                let finding = Diagnostic::error(&key, why);
                self.findings
                    .push(finding.help("take a smaller stress; are its unit and its sign right? Tension is positive"));
                None
            }
        }
    }
}

/// The place of a component that a solid in the plane can't have.
fn across<const D: usize>(stress: &SymTensor, plane: PlaneSpec) -> Option<usize> {
    let none: &[usize] = match (D, plane) {
        (2, PlaneSpec::Stress) => &[2, 4, 5],
        (2, PlaneSpec::Strain) => &[4, 5],
        _ => &[],
    };
    none.iter().copied().find(|&k| stress.0[k] != 0.0)
}

/// Note on incompressible solids for the user of a case.
pub(super) fn incompressible(file: &CaseFile) -> Option<String> {
    let is_half = |i: &usize| match &file.body[*i].material {
        Material::Point(law) => law.as_dyn().elastic_law().is_ok_and(|law| {
            let moduli = law.moduli();
            moduli.bulk >= 0.999 * INCOMPRESSIBLE * moduli.shear
        }),
        Material::Flow(_) => false,
    };
    let names: Vec<&str> = file.solids().into_iter().filter(is_half).map(|i| file.body[i].name.as_str()).collect();
    (!names.is_empty()).then(|| {
        format!(
            "nearly incompressible, with a bulk modulus of {INCOMPRESSIBLE:.0} times the shear modulus or more: {}",
            names.join(", ")
        )
    })
}
