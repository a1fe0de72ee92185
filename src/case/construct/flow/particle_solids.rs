//! Solids on particles, of the preset of the paper: law, supports, and what they don't have.

use super::super::Construction;
use super::super::signals::TrialPoints;
use super::fluids::InitialBody;
use crate::case::{AxisMotion, InterfaceSpec, Material, Preset, SupportPlace, SupportSpec};
use crate::error::Diagnostic;
use crate::material::{BulkViscosity, Hypoelastic, PointLaws};
use crate::math::{Signal, Vector};
use crate::mesh::Mesh;
use crate::pfem2::Scheme;
use crate::pfem2::particle_solids::setup::{HeldMeshNodes, ParticleSolidSetup, RateLaw};

/// The largest of Poisson's ratios: the pressure of a solid isn't stabilised.
const LARGEST_POISSON: f64 = 0.49;

impl Construction<'_> {
    /// The solids on particles: bodies of these `indices` in the case, the first of `bodies`. Those that can't be made
    /// are left out (and why is a finding).
    pub(super) fn particle_solids<const D: usize, const N: usize>(
        &mut self,
        indices: &[usize],
        bodies: &[InitialBody],
        mesh: &Mesh<D, N>,
    ) -> Vec<ParticleSolidSetup<D>> {
        let file = &self.case.file;
        if file.preset == Preset::Becker2015 {
            file.solids().into_iter().for_each(|body| self.no_rate_law(body, self.law_name(body)));
        }
        if let Some(&first) = indices.first() {
            self.choices_beside_solids(first);
        }
        let each = indices.iter().zip(bodies);
        each.filter_map(|(&index, body)| self.particle_solid(index, body, mesh)).collect()
    }

    fn law_name(&self, body: usize) -> &'static str {
        match &self.case.file.body[body].material {
            Material::Point(law) => law.name(),
            Material::Flow(law) => law.name(),
        }
    }

    /// Finds that the law of a body is not one of solids on particles.
    pub(super) fn no_rate_law(&mut self, body: usize, law: &str) {
        let message =
            format!("solids of `preset = \"becker-2015\"` are on particles, with a law in rates, and `{law}` is none");
        let finding = Diagnostic::error(format!("body[{body}].material"), message);
        let help = "write `law = \"hypoelastic\"`, or leave the preset out: solids then have meshes of their own and an elastic law";
        self.findings.push(finding.help(help));
    }

    /// Choices of `[pfem2]` that solids on particles don't go with.
    fn choices_beside_solids(&mut self, body: usize) {
        let file = &self.case.file;
        let (fluids, spec) = (file.fluids().len(), &file.pfem2);
        if fluids > 1 {
            let message = format!("solids on particles are in one fluid, and here are {fluids}");
            let finding = Diagnostic::error(format!("body[{body}]"), message);
            self.findings
                .push(finding.help("leave the preset out: solids on meshes of their own may be in several fluids"));
        }
        if Scheme::from(&spec.scheme) != Scheme::BackwardEuler {
            let message = "solids on particles have the time integration of the paper";
            let finding = Diagnostic::error("pfem2.scheme", message);
            self.findings.push(finding.help("write `scheme = \"backward-euler\"`, or leave it to the preset"));
        }
        if spec.interface == InterfaceSpec::Sharp {
            let message = "solids on particles are where their particles are: a sharp interface is for two fluids";
            let finding = Diagnostic::error("pfem2.interface", message);
            self.findings.push(finding.help("write `interface = \"pseudo\"`, or leave it to the preset"));
        }
    }

    fn particle_solid<const D: usize, const N: usize>(
        &mut self,
        index: usize,
        body: &InitialBody,
        mesh: &Mesh<D, N>,
    ) -> Option<ParticleSolidSetup<D>> {
        let spec = &self.case.file.body[index];
        let key = format!("body[{index}]");
        let Material::Point(PointLaws::Hypoelastic(Hypoelastic { elastic })) = &spec.material else { return None };
        self.keys_of_meshes(index);
        if elastic.poisson > LARGEST_POISSON {
            let message = format!(
                "solids on particles are compressible, with {LARGEST_POISSON} at most: their pressure isn't stabilised"
            );
            self.findings
                .push(Diagnostic::error(format!("{key}.material.poisson"), message).help("take a smaller value"));
        }
        if elastic.bulk_viscosity != BulkViscosity::default() {
            let finding = Diagnostic::error(format!("{key}.material.bulk-viscosity"), "solids on particles have none");
            self.findings.push(finding.help("take it out: no shock runs through them"));
        }
        self.plane_in_space::<D>(index);
        if !mesh.nodes().iter().any(|&x| body.contains(x)) {
            let message = format!("no node of the mesh lies in `{}`: elements are larger than it", spec.name);
            let finding = Diagnostic::error(format!("{key}.region"), message);
            self.findings.push(
                finding.help(
                    "refine the mesh where it is, to three elements over its thickness or more: `[[mesh.refine]]`",
                ),
            );
            return None;
        }
        let supports = spec.supports.iter().enumerate();
        let held =
            supports.filter_map(|(i, support)| self.held_nodes(support, &format!("{key}.supports[{i}]"), body, mesh));
        let held = held.collect();
        let law = RateLaw::new(elastic.density, elastic.moduli(), spec.plane.unwrap_or_default().into());
        Some(ParticleSolidSetup { name: spec.name.clone(), law, held })
    }

    /// Keys of a solid on a mesh of its own.
    fn keys_of_meshes(&mut self, body: usize) {
        let spec = &self.case.file.body[body];
        let given = [
            ("mesh", spec.mesh.is_some()),
            ("damping", spec.damping.is_some()),
            ("friction", spec.friction.is_some()),
            ("restitution", spec.restitution.is_some()),
            ("surface", spec.surface.is_some()),
            ("moment-about", spec.moment_about.is_some()),
            ("traction", !spec.traction.is_empty()),
            ("stress", spec.stress.is_some()),
        ];
        for (name, _) in given.into_iter().filter(|(_, given)| *given) {
            let message =
                format!("`{name}` is for solids on meshes of their own, and those of this preset are on particles");
            let finding = Diagnostic::error(format!("body[{body}].{name}"), message);
            self.findings.push(finding.help("take it out, or leave `preset = \"becker-2015\"` out"));
        }
    }

    /// The nodes of the mesh that a support holds: those in its region and in the body, at the start.
    fn held_nodes<const D: usize, const N: usize>(
        &mut self,
        support: &SupportSpec,
        key: &str,
        body: &InitialBody,
        mesh: &Mesh<D, N>,
    ) -> Option<HeldMeshNodes<D>> {
        let SupportPlace::Region(shape) = &support.on else {
            let message = "a solid on particles has no sides or nodes of its own to be held at";
            let help = "give a region: nodes of the mesh in it hold the solid. Where it touches walls of the mesh they hold it: such a \
                        support may be taken out";
            self.findings.push(Diagnostic::error(format!("{key}.on"), message).help(help));
            return None;
        };
        let region = self.region(&format!("{key}.on"), shape)?;
        let held = |x: &Vector<D>| region.signed_distance(x.to3()) <= 0.0 && body.contains(*x);
        let nodes: Vec<u32> = (0u32..).zip(mesh.nodes()).filter(|(_, x)| held(x)).map(|(node, _)| node).collect();
        if nodes.is_empty() {
            let message = "no node of the mesh lies in this region and in the body";
            let finding = Diagnostic::error(format!("{key}.on"), message);
            self.findings.push(finding.help("take a larger region, or smaller elements there"));
            return None;
        }
        let places: Vec<Vector<D>> = nodes.iter().map(|&node| mesh.nodes()[node as usize]).collect();
        let over = TrialPoints::over(&places, self.case.file.time.end);
        let velocity: [Option<Signal>; D] = std::array::from_fn(|i| match &support.velocity[i] {
            AxisMotion::Free(_) => None,
            AxisMotion::Velocity(v) => Some(self.signal(&format!("{key}.velocity[{i}]"), v, &over)),
        });
        Some(HeldMeshNodes { nodes, velocity })
    }
}
