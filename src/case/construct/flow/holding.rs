//! Holds of solids: supports, springs, prescribed motion, bonds.

use super::super::Construction;
use super::super::signals::TrialPoints;
use crate::case::{AxisMotion, InertiaSpec, RigidMotionSpec, SupportSpec};
use crate::error::Diagnostic;
use crate::math::Signal;
use crate::mesh::QuadraticMesh;
use crate::pfem2::solid::mesh::SolidMesh;
use crate::pfem2::solid::setup::{HeldNodes, PrescribedMotion, SpringSupport};
use crate::pfem2::solid::support::facet_node_areas;

/// A solid's mesh, as sets of nodes are named in it and as it is solved.
pub(super) type BothMeshes<'a, const D: usize> = (&'a QuadraticMesh, &'a SolidMesh<D>);

impl Construction<'_> {
    /// Supports with a velocity, and those that are springs or dashpots.
    pub(super) fn holding<const D: usize>(
        &mut self,
        index: usize,
        meshes: BothMeshes<'_, D>,
        over: &TrialPoints,
    ) -> (Vec<HeldNodes<D>>, Vec<SpringSupport<D>>) {
        let (mut held, mut springs) = (Vec::new(), Vec::new());
        for (i, support) in self.case.file.body[index].supports.iter().enumerate() {
            let key = format!("body[{index}].supports[{i}]");
            if support.is_spring() {
                springs.extend(self.spring(support, &key, meshes));
            } else if let Some((nodes, velocity)) = self.support(support, &key, "solid", meshes.0, over) {
                held.push(HeldNodes { nodes, velocity });
            }
        }
        (held, springs)
    }

    /// A spring or dashpot. Nodes of whole sides of elements have weights by their areas, others equal ones.
    fn spring<const D: usize>(
        &mut self,
        spec: &SupportSpec,
        key: &str,
        (quadratic, mesh): BothMeshes<'_, D>,
    ) -> Option<SpringSupport<D>> {
        let nodes = self.nodes_on(&spec.on, &format!("{key}.on"), "solid", quadratic)?;
        if self.case.says(&format!("{key}.velocity")) {
            let finding = Diagnostic::error(format!("{key}.velocity"), "a spring pulls to where its nodes start");
            self.findings
                .push(finding.help("take `velocity` out; for a support that moves, `stiffness` and `damping`"));
        }
        for (name, values) in [("stiffness", &spec.stiffness), ("damping", &spec.damping)] {
            if values.iter().flatten().any(|value| *value < 0.0) {
                let finding = Diagnostic::error(format!("{key}.{name}"), "it must not be negative");
                self.findings.push(finding.help("0 where there is none along an axis"));
            }
        }
        let mut areas = vec![0.0; mesh.nodes.len()];
        for facet in 0..mesh.facets.len() {
            if mesh.facets[facet].nodes.iter().all(|node| nodes.binary_search(node).is_ok()) {
                facet_node_areas(mesh, facet).into_iter().for_each(|(node, area)| areas[node as usize] += area);
            }
        }
        let total: f64 = areas.iter().sum();
        let weight = |&node: &u32| match total > 0.0 {
            true => (node, areas[node as usize] / total),
            false => (node, 1.0 / nodes.len() as f64),
        };
        let weights = nodes.iter().map(weight).filter(|(_, weight)| *weight > 0.0).collect();
        let along = |values: &Option<[f64; 3]>| std::array::from_fn(|axis| values.map_or(0.0, |values| values[axis]));
        Some(SpringSupport { weights, stiffness: along(&spec.stiffness), damping: along(&spec.damping) })
    }

    /// The prescribed motion of a rigid solid; notes keys that a solid of its law has no use for.
    pub(super) fn motion<const D: usize>(&mut self, index: usize, over: &TrialPoints) -> PrescribedMotion {
        let spec = &self.case.file.body[index];
        let key = format!("body[{index}]");
        let Some(RigidMotionSpec { velocity, spin }) = &spec.motion else { return PrescribedMotion::default() };
        if !self.is_rigid(index) {
            let finding =
                Diagnostic::error(format!("{key}.motion"), "`motion` is for rigid solids, and this one is elastic");
            let help = "hold its nodes, `supports = [{ on = ..., velocity = [...] }]`, or write `law = \"rigid\"`";
            self.findings.push(finding.help(help));
        }
        let turns = if D == 2 { 1 } else { 3 };
        if !spin.is_empty() && spin.len() != turns {
            let message =
                format!("expected {turns} entr{}, found {}", if turns == 1 { "y" } else { "ies" }, spin.len());
            let help = "in 2D a solid turns in the plane, `spin = [\"2 / 1 s\"]`; in 3D there is an entry per axis";
            self.findings.push(Diagnostic::error(format!("{key}.motion.spin"), message).help(help));
            return PrescribedMotion::default();
        }
        let mut of = |name: &str, axis: usize, motion: Option<&AxisMotion>| match motion? {
            AxisMotion::Free(_) => None,
            AxisMotion::Velocity(v) => Some(self.signal(&format!("{key}.motion.{name}[{axis}]"), v, over)),
        };
        let velocity: [Option<Signal>; 3] = std::array::from_fn(|axis| {
            let own = velocity.as_ref().filter(|_| axis < D).map(|all| &all[axis]);
            of("velocity", axis, own)
        });
        let first = 3 - turns;
        let spin =
            std::array::from_fn(|axis| axis.checked_sub(first).and_then(|place| of("spin", place, spin.get(place))));
        PrescribedMotion { velocity, spin }
    }

    /// Notes keys of elastic solids that a rigid one has no use for.
    pub(super) fn unused_by_rigid(&mut self, index: usize) {
        let spec = &self.case.file.body[index];
        if !self.is_rigid(index) {
            return;
        }
        let strained = spec.damping.is_some_and(|damping| damping.stiffness.is_some());
        for (key, given) in [("plane", spec.plane.is_some()), ("damping.stiffness", strained)] {
            if given {
                let finding = Diagnostic::error(format!("body[{index}].{key}"), "a rigid solid has no strain");
                self.findings.push(finding.help("take it out, or choose an elastic law"));
            }
        }
        if spec.stress.is_some() {
            let finding = Diagnostic::error(format!("body[{index}].stress"), "a rigid solid has no stress");
            self.findings.push(finding.help("take it out, or choose an elastic law"));
        }
        if spec.inertia == Some(InertiaSpec::QuasiStatic) {
            let finding = Diagnostic::error(
                format!("body[{index}].inertia"),
                "without inertia a rigid solid has nothing to move by",
            );
            self.findings.push(finding.help("take it out, or prescribe its `motion`"));
        }
    }

    /// Notes keys of rigid solids that an elastic one has no use for.
    pub(super) fn unused_by_elastic(&mut self, index: usize) {
        if self.case.file.body[index].restitution.is_some() && !self.is_rigid(index) {
            let message = "`restitution` is for rigid solids, and this one is elastic: its own waves make it bounce";
            let finding = Diagnostic::error(format!("body[{index}].restitution"), message);
            self.findings
                .push(finding.help("take it out, or write `law = \"rigid\"`; `damping` takes from what bounces"));
        }
    }

    /// True for a solid that the case calls rigid.
    pub(super) fn is_rigid(&self, index: usize) -> bool {
        matches!(&self.case.file.body[index].material, crate::case::Material::Point(law) if law.as_dyn().is_rigid())
    }

    /// Pairs of solids that are bonded, numbered among the solids: the one that says so first.
    pub(super) fn bonds(&mut self) -> Vec<[usize; 2]> {
        let file = &self.case.file;
        let solids = file.solids();
        let mut bonds = Vec::new();
        for (own, &index) in solids.iter().enumerate() {
            for (k, name) in file.body[index].bond.iter().enumerate() {
                match solids.iter().position(|&other| file.body[other].name == *name).filter(|&other| other != own) {
                    Some(other) => bonds.push([own, other]),
                    None => {
                        let names: Vec<_> =
                            solids.iter().filter(|&&i| i != index).map(|&i| file.body[i].name.as_str()).collect();
                        let message = format!("there is no other solid `{name}` to be bonded to");
                        let finding = Diagnostic::error(format!("body[{index}].bond[{k}]"), message);
                        self.findings.push(finding.help(format!("the other solids are {}", names.join(", "))));
                    }
                }
            }
        }
        bonds
    }
}
