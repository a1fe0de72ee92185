//! Conditions on the parts of the boundary.

use super::super::Construction;
use super::super::signals::TrialPoints;
use super::mesh::{at, middle};
use crate::case::{BoundarySpec, BoundaryWord, SignalSpec};
use crate::error::Diagnostic;
use crate::math::{Signal, Vector};
use crate::mesh::{Facet, Locator, Mesh};
use crate::pfem2::boundary::{BoundarySetup, Condition, PressurePin};
use crate::pfem2::{ForcedPart, MomentPoint};
use std::collections::{BTreeMap, BTreeSet};

impl<'c> Construction<'c> {
    /// Conditions on all parts of the boundary; every named part must have one.
    pub(super) fn boundaries<const D: usize, const N: usize>(&mut self, mesh: &Mesh<D, N>) -> Vec<BoundarySetup<D>> {
        let before = self.findings.len();
        let taken = self.named_parts(mesh);
        let facets = |spec: &BoundarySpec| -> Vec<Facet> {
            let named = |name: &str| mesh.sets.get(name).cloned().unwrap_or_default();
            let listed = |name: &str| if name == "rest" { rest(mesh, &taken) } else { named(name) };
            let all: BTreeSet<Facet> = spec.on.list().into_iter().flat_map(listed).collect();
            all.into_iter().collect()
        };
        let specs = &self.case.file.boundary;
        let made = specs.iter().enumerate().map(|(i, spec)| {
            let facets = facets(spec);
            let nodes: BTreeSet<u32> = facets.iter().flat_map(|&facet| mesh.facet_nodes(facet)).collect();
            let places = nodes.into_iter().map(|node| mesh.nodes()[node as usize]);
            let samples = TrialPoints::on_boundary(places, self.case.file.time.end);
            BoundarySetup {
                name: spec.part_name(),
                condition: self.condition(&format!("boundary[{i}]"), spec, &samples),
                brings: self.inflowing(&format!("boundary[{i}].fluid"), spec),
                facets,
            }
        });
        let made: Vec<_> = made.collect();
        if self.findings.len() == before {
            self.claimed_twice(mesh, &made);
        }
        made
    }

    /// The parts of the boundary that have a condition.
    fn named_parts<const D: usize, const N: usize>(&mut self, mesh: &Mesh<D, N>) -> BTreeSet<&'c str> {
        let known: Vec<&str> = mesh.sets.keys().map(String::as_str).collect();
        let mut taken: BTreeSet<&'c str> = BTreeSet::new();
        let specs = &self.case.file.boundary;
        for (i, spec) in specs.iter().enumerate() {
            if spec.on.list().is_empty() {
                let finding = Diagnostic::error(format!("boundary[{i}].on"), "this names no part of the boundary");
                self.findings.push(finding.help(format!("there are `{}`, and `rest`", known.join("`, `"))));
            }
            for name in spec.on.list() {
                self.boundary_name(&format!("boundary[{i}].on"), name, &known, &mesh.inner, &taken);
                taken.insert(name);
            }
        }
        let open: Vec<&str> = known.iter().copied().filter(|name| !taken.contains(name)).collect();
        if !taken.contains("rest") && !open.is_empty() {
            let message = format!("nothing is prescribed on `{}` of the boundary", open.join("`, `"));
            let help = "add a `[[boundary]]` with `on = [...]`, or `on = \"rest\"` for all that is left";
            self.findings.push(Diagnostic::error("boundary", message).help(help));
        }
        taken
    }

    /// A facet has one condition, even where groups of a file overlap.
    fn claimed_twice<const D: usize, const N: usize>(&mut self, mesh: &Mesh<D, N>, sets: &[BoundarySetup<D>]) {
        let mut owner: BTreeMap<Facet, usize> = BTreeMap::new();
        let mut shared: BTreeMap<[usize; 2], Vec<Facet>> = BTreeMap::new();
        for (i, set) in sets.iter().enumerate() {
            for &facet in &set.facets {
                match owner.get(&facet) {
                    Some(&first) => shared.entry([first, i]).or_default().push(facet),
                    None => drop(owner.insert(facet, i)),
                }
            }
        }
        for ([first, second], facets) in shared {
            let (names, place) = ([&sets[first].name, &sets[second].name], middle(mesh, facets[0]));
            let message = format!(
                "{} facets belong to both `{}` and `{}`, the first at ({})",
                facets.len(),
                names[0],
                names[1],
                at(place)
            );
            let help = "a facet has one condition: name both groups in one `on`, or take the facets out of one of them";
            self.findings.push(Diagnostic::error(format!("boundary[{second}].on"), message).help(help));
        }
    }

    /// `inner`: how many facets of a group are not on the boundary.
    fn boundary_name(
        &mut self,
        key: &str,
        name: &str,
        known: &[&str],
        inner: &BTreeMap<String, usize>,
        taken: &BTreeSet<&str>,
    ) {
        if taken.contains(name) {
            let message = format!("`{name}` already has a condition");
            self.findings.push(Diagnostic::error(key, message).help("a part of the boundary has one condition"));
        } else if let Some(count) = inner.get(name) {
            let finding = if known.contains(&name) {
                Diagnostic::warning(key, format!("{count} facets of `{name}` lie inside the mesh, and have no effect"))
            } else {
                let message = format!("`{name}` is no part of the boundary: its {count} facets lie inside the mesh");
                Diagnostic::error(key, message)
            };
            let help = "conditions are for the boundary: take such facets out, or cut the mesh open along them";
            self.findings.push(finding.help(help));
        } else if name != "rest" && !known.contains(&name) {
            let help = match known {
                [] => "the mesh has no named parts: use `\"rest\"`, or give the file physical groups".to_owned(),
                names => format!("there are `{}`, and `rest`", names.join("`, `")),
            };
            let message = format!("the boundary of the mesh has no part `{name}`");
            self.findings.push(Diagnostic::error(key, message).help(help));
        }
    }

    fn condition<const D: usize>(&mut self, key: &str, spec: &BoundarySpec, samples: &TrialPoints) -> Condition<D> {
        let given = [
            ("velocity", spec.velocity.iter().any(|v| *v != SignalSpec::default())),
            ("traction", spec.traction.iter().any(|v| *v != SignalSpec::default())),
            ("pressure", spec.pressure != SignalSpec::default()),
        ];
        let used = match spec.kind {
            BoundaryWord::Wall | BoundaryWord::Inlet => "velocity",
            BoundaryWord::Traction => "traction",
            BoundaryWord::Pressure => "pressure",
            BoundaryWord::Slip | BoundaryWord::Symmetry | BoundaryWord::Outlet => "",
        };
        for (name, _) in given.into_iter().filter(|(name, given)| *given && *name != used) {
            let message = format!("`{name}` says nothing about a boundary of this kind");
            self.findings
                .push(Diagnostic::error(format!("{key}.{name}"), message).help("take it out, or change `kind`"));
        }
        self.still_inlet(key, spec.kind);
        let mut vector = |name: &str, value: &[SignalSpec; 3]| -> [Signal; D] {
            let signals = self.signals(&format!("{key}.{name}"), value, samples);
            std::array::from_fn(|i| signals[i].clone())
        };
        match spec.kind {
            BoundaryWord::Wall => Condition::Wall(vector("velocity", &spec.velocity)),
            BoundaryWord::Inlet => Condition::Inlet(vector("velocity", &spec.velocity)),
            BoundaryWord::Slip | BoundaryWord::Symmetry => Condition::Slip,
            BoundaryWord::Outlet => Condition::Outlet,
            BoundaryWord::Traction => Condition::Traction(vector("traction", &spec.traction)),
            BoundaryWord::Pressure => {
                Condition::Pressure(self.signal(&format!("{key}.pressure"), &spec.pressure, samples))
            }
        }
    }

    /// Points about which forces on parts of the boundary and on solids have moments.
    pub(super) fn moments<const D: usize>(&mut self, sets: &[BoundarySetup<D>]) -> Vec<MomentPoint<D>> {
        let file = &self.case.file;
        let mut points = Vec::new();
        for (i, (spec, set)) in file.boundary.iter().zip(sets).enumerate() {
            let Some(about) = spec.moment_about else { continue };
            if set.condition.kind().has_free_flux() {
                let message =
                    "an open boundary holds nothing: the fluid exerts no force on it that could have a moment";
                let finding = Diagnostic::error(format!("boundary[{i}].moment-about"), message);
                self.findings.push(finding.help("take it out; walls, slip walls and inlets have a force"));
            }
            points.push(MomentPoint { part: ForcedPart::Boundary(i), about: Vector::from3(about) });
        }
        for (solid, body) in file.solids().into_iter().enumerate() {
            let about = file.body[body].moment_about;
            let of = |about| MomentPoint { part: ForcedPart::Solid(solid), about: Vector::from3(about) };
            points.extend(about.map(of));
        }
        points
    }

    /// Without a velocity an inlet would be a wall at rest, silently.
    fn still_inlet(&mut self, key: &str, kind: BoundaryWord) {
        if kind == BoundaryWord::Inlet && !self.case.says(&format!("{key}.velocity")) {
            let finding =
                Diagnostic::error(format!("{key}.kind"), "this inlet has no `velocity`: nothing would come in");
            let help =
                "add the velocity of what comes in, such as `velocity = [1.0, 0]`, or a formula in x, y, z and t";
            self.findings.push(finding.help(help));
        }
    }

    /// The place where the pressure of a closed box is prescribed, if the case gives one.
    pub(super) fn pin<const D: usize, const N: usize>(
        &mut self,
        mesh: &Mesh<D, N>,
        sets: &[BoundarySetup<D>],
    ) -> Option<PressurePin<D>> {
        const KEY: &str = "pfem2.pressure-pin";
        let spec = self.case.file.pfem2.pressure_pin.as_ref()?;
        if let Some(open) = sets.iter().find(|set| set.condition.kind().has_free_flux()) {
            let message = format!("`{}` is open: the pressure there already says what the pressure is", open.name);
            let help = "take the pin out, or give that boundary a `pressure`";
            self.findings.push(Diagnostic::error(KEY, message).help(help));
        }
        let at = Vector::from_fn(|i| spec.at[i]);
        if Locator::new(mesh).search(mesh, at).is_none() {
            let finding = Diagnostic::error(format!("{KEY}.at"), "this place is not in the mesh");
            self.findings.push(finding.help("the node nearest to a place in the mesh holds the pressure"));
        }
        let samples = TrialPoints::at(&[spec.at], self.case.file.time.end);
        Some(PressurePin { at, value: self.signal(&format!("{KEY}.value"), &spec.value, &samples) })
    }

    /// The fluid that a boundary brings in, if it names one.
    fn inflowing(&mut self, key: &str, spec: &BoundarySpec) -> Option<u8> {
        let name = spec.fluid.as_ref()?;
        let file = &self.case.file;
        let fluids: Vec<&str> = file.fluids().into_iter().map(|i| file.body[i].name.as_str()).collect();
        let place = fluids.iter().position(|fluid| fluid == name);
        let finding = match (spec.kind, place) {
            (BoundaryWord::Wall | BoundaryWord::Slip | BoundaryWord::Symmetry, _) => {
                Diagnostic::error(key, "nothing flows in through a boundary of this kind").help("take it out")
            }
            (_, None) => Diagnostic::error(key, format!("there is no body `{name}` of a fluid"))
                .help(format!("there are `{}`", fluids.join("`, `"))),
            (_, Some(place)) => return Some(place as u8),
        };
        self.findings.push(finding);
        None
    }
}

/// Facets in no named part that has a condition.
fn rest<const D: usize, const N: usize>(mesh: &Mesh<D, N>, taken: &BTreeSet<&str>) -> Vec<Facet> {
    let named = mesh.sets.iter().filter(|(name, _)| taken.contains(name.as_str()));
    let used: BTreeSet<Facet> = named.flat_map(|(_, facets)| facets.iter().copied()).collect();
    mesh.boundary().iter().copied().filter(|facet| !used.contains(facet)).collect()
}
