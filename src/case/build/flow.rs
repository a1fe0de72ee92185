//! PFEM-2: mesh, conditions on its boundary, fluids and their particles.

use super::signals::Samples;
use super::{Assembly, Model, has_errors};
use crate::case::summary::Summary;
use crate::case::{BoundarySpec, BoundaryWord, Case, InterfaceSpec, Material, Pfem2Spec, SignalSpec, check};
use crate::error::Diagnostic;
use crate::geometry::Region;
use crate::math::{Signal, Vector};
use crate::mesh::{Facet, Mesh};
use crate::pfem2::boundary::{BoundarySetup, Condition};
use crate::pfem2::level_set::LevelSet;
use crate::pfem2::particles::Particles;
use crate::pfem2::setup::FluidSetup;
use crate::pfem2::{Pfem2, Setup};
use crate::simulation::Solver;
use std::collections::BTreeSet;

/// Makes the mesh of a case in its dimension.
pub(super) type MakeMesh<const D: usize, const N: usize> =
    fn(&crate::mesh::domain::DomainMesh, &std::path::Path) -> Result<Mesh<D, N>, Diagnostic>;

impl Case {
    /// The solver of PFEM-2, or everything that is wrong.
    pub(super) fn pfem2<const D: usize, const N: usize>(&self, make: MakeMesh<D, N>) -> Result<Model, Vec<Diagnostic>> {
        let mut assembly = Assembly { case: self, findings: Vec::new() };
        let setup = assembly.flow(make);
        let mut findings = assembly.findings;
        check::names(&self.file, &mut findings);
        let Some(setup) = setup.filter(|_| !has_errors(&findings)) else { return Err(findings) };
        let summary = Summary::of_flow(&setup, &self.file);
        let mut solver = Pfem2::new(setup);
        let summary = summary.with_solver(&mut solver, &self.file);
        check::steps(self, &summary, &mut findings);
        check::probes(&self.file, &solver.snapshot(), &mut findings);
        check::pictures(&self.file, &solver.snapshot(), summary.domain, &mut findings);
        if has_errors(&findings) {
            return Err(findings);
        }
        self.locate(&mut findings);
        Ok(Model { solver: Box::new(solver), summary, warnings: findings })
    }
}

/// A fluid as the case describes it: where it is, and how it moves at the start.
struct Part {
    region: Region,
    velocity: [Signal; 3],
}

impl Assembly<'_> {
    fn flow<const D: usize, const N: usize>(&mut self, make: MakeMesh<D, N>) -> Option<Setup<D, N>> {
        let file = &self.case.file;
        let mesh = self.mesh(make)?;
        let samples = Samples::over(mesh.nodes(), file.time.end);
        let gravity = self.signals("pfem2.gravity", &file.pfem2.gravity, &samples);
        let boundaries = self.boundaries(&mesh);
        let tension = self.tensions();
        let fluids: Vec<FluidSetup> = (0..file.body.len()).filter_map(|i| self.fluid(i)).collect();
        let parts: Vec<Part> = (0..file.body.len()).filter_map(|i| self.part(i, &mesh)).collect();
        if file.body.is_empty() {
            let finding = Diagnostic::error("", "there is no body: nothing fills the mesh");
            self.findings.push(finding.help("add a `[[body]]` with the region of a fluid"));
        }
        if has_errors(&self.findings) {
            return None;
        }
        self.through_flow(&mesh, &boundaries);
        self.left_over(&mesh, &boundaries);
        self.unfilled(&mesh, &parts);
        let mut particles = self.seed(&mesh, &parts)?;
        let level_set = sharp(&file.pfem2, &mesh, &fluids, &parts, &mut particles);
        let start = |x: Vector<D>| velocity_at(&parts, x);
        let spec = &file.pfem2;
        Some(Setup {
            velocity: mesh.nodes().iter().map(|&x| start(x)).collect(),
            boundaries,
            fluids,
            tension,
            gravity: std::array::from_fn(|i| gravity[i].clone()),
            particles,
            level_set,
            volume: spec.volume.into(),
            scheme: (&spec.scheme).into(),
            stabilisation: spec.stabilisation.into(),
            mass: spec.mass.into(),
            enrichment: spec.enrichment.into(),
            kernel: spec.kernel.into(),
            reseeding: spec.reseeding.into(),
            projectile_ratio: spec.projectile_ratio,
            relaxation: spec.relaxation,
            courant: if file.time.step.is_some() { f64::INFINITY } else { spec.courant },
            linear: spec.solver.options(),
            mesh,
        })
    }

    fn mesh<const D: usize, const N: usize>(&mut self, make: MakeMesh<D, N>) -> Option<Mesh<D, N>> {
        match make(self.case.file.mesh.as_ref()?, &self.case.source.base) {
            Ok(mesh) => Some(mesh),
            Err(finding) => {
                self.note("mesh", finding);
                None
            }
        }
    }

    /// Conditions on all parts of the boundary; every named part must have one.
    fn boundaries<const D: usize, const N: usize>(&mut self, mesh: &Mesh<D, N>) -> Vec<BoundarySetup<D>> {
        let specs = &self.case.file.boundary;
        let known: Vec<&str> = mesh.sets.keys().map(String::as_str).collect();
        let mut taken: BTreeSet<&str> = BTreeSet::new();
        for (i, spec) in specs.iter().enumerate() {
            for name in spec.on.list() {
                self.boundary_name(&format!("boundary[{i}].on"), name, &known, &taken);
                taken.insert(name);
            }
        }
        let open: Vec<&str> = known.iter().copied().filter(|name| !taken.contains(name)).collect();
        if !taken.contains("rest") && !open.is_empty() {
            let message = format!("nothing is prescribed on `{}` of the boundary", open.join("`, `"));
            let help = "add a `[[boundary]]` with `on = [...]`, or `on = \"rest\"` for all that is left";
            self.findings.push(Diagnostic::error("boundary", message).help(help));
        }
        let facets = |spec: &BoundarySpec| -> Vec<Facet> {
            let named = |name: &str| mesh.sets.get(name).cloned().unwrap_or_default();
            let listed = |name: &str| if name == "rest" { rest(mesh, &taken) } else { named(name) };
            let all: BTreeSet<Facet> = spec.on.list().into_iter().flat_map(listed).collect();
            all.into_iter().collect()
        };
        let samples = Samples::over(mesh.nodes(), self.case.file.time.end);
        let made = specs.iter().enumerate().map(|(i, spec)| BoundarySetup {
            name: spec.name.clone().unwrap_or_else(|| spec.on.list().join("+")),
            facets: facets(spec),
            condition: self.condition(&format!("boundary[{i}]"), spec, &samples),
            brings: self.inflowing(&format!("boundary[{i}].fluid"), spec),
        });
        made.collect()
    }

    fn boundary_name(&mut self, key: &str, name: &str, known: &[&str], taken: &BTreeSet<&str>) {
        if taken.contains(name) {
            let message = format!("`{name}` already has a condition");
            self.findings.push(Diagnostic::error(key, message).help("a part of the boundary has one condition"));
        } else if name != "rest" && !known.contains(&name) {
            let help = match known {
                [] => "the mesh has no named parts: use `\"rest\"`, or give the file physical groups".to_owned(),
                names => format!("there are `{}`, and `rest`", names.join("`, `")),
            };
            let message = format!("the boundary of the mesh has no part `{name}`");
            self.findings.push(Diagnostic::error(key, message).help(help));
        }
    }

    fn condition<const D: usize>(&mut self, key: &str, spec: &BoundarySpec, samples: &Samples) -> Condition<D> {
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

    /// The fluid that a boundary brings in, if it names one.
    fn inflowing(&mut self, key: &str, spec: &BoundarySpec) -> Option<u8> {
        let name = spec.fluid.as_ref()?;
        let bodies: Vec<&str> = self.case.file.body.iter().map(|body| body.name.as_str()).collect();
        let place = bodies.iter().position(|body| body == name);
        let finding = match (spec.kind, place) {
            (BoundaryWord::Wall | BoundaryWord::Slip | BoundaryWord::Symmetry, _) => {
                Diagnostic::error(key, "nothing flows in through a boundary of this kind").help("take it out")
            }
            (_, None) => Diagnostic::error(key, format!("there is no body `{name}`"))
                .help(format!("there are `{}`", bodies.join("`, `"))),
            (_, Some(place)) => return Some(place as u8),
        };
        self.findings.push(finding);
        None
    }

    /// Says what is left out of a mesh, and which part of its boundary nobody named.
    fn left_over<const D: usize, const N: usize>(&mut self, mesh: &Mesh<D, N>, sets: &[BoundarySetup<D>]) {
        let place = |x: Vector<D>| x.0.map(|c| format!("{c:.6}")).join(", ");
        if let Some(&first) = mesh.isolated.first() {
            let message =
                format!("{} nodes belong to no element, the first at ({})", mesh.isolated.len(), place(first));
            self.findings.push(Diagnostic::warning("mesh", message).help("they are left out"));
        }
        let named: usize = sets.iter().map(|set| set.facets.len()).sum();
        let facets = mesh.boundary();
        let bare = || facets.iter().filter(|facet| !sets.iter().any(|set| set.facets.contains(facet)));
        if named < facets.len() {
            let Some(&first) = bare().next() else { return };
            let nodes = mesh.facet_nodes(first);
            let middle = nodes.iter().map(|&n| mesh.nodes()[n as usize]).sum::<Vector<D>>() / D as f64;
            let count = facets.len() - named;
            let message =
                format!("{count} facets of the boundary are in no named part, the first at ({})", place(middle));
            let help = "they are walls at rest: say so with `on = \"rest\"`, or give them a physical group";
            self.findings.push(Diagnostic::warning("boundary", message).help(help));
        }
    }

    /// What flows in must be able to leave.
    fn through_flow<const D: usize, const N: usize>(&mut self, mesh: &Mesh<D, N>, sets: &[BoundarySetup<D>]) {
        let is_open =
            |c: &Condition<D>| matches!(c, Condition::Outlet | Condition::Traction(_) | Condition::Pressure(_));
        if sets.iter().any(|set| is_open(&set.condition)) {
            return;
        }
        let end = self.case.file.time.end;
        for t in (0..=16).map(|i| end * f64::from(i) / 16.0) {
            let (mut net, mut all) = (0.0, 0.0);
            for set in sets {
                let (Condition::Inlet(v) | Condition::Wall(v)) = &set.condition else { continue };
                for &facet in &set.facets {
                    let (through, most) = flux(mesh, facet, v, t);
                    (net, all) = (net + through, all + most);
                }
            }
            // A closed box can't take in what the rounding of a formula leaves, of a wall that turns as well.
            if net.abs() > 1e-6 * all {
                let first = sets.iter().position(|set| matches!(set.condition, Condition::Inlet(_))).unwrap_or(0);
                let rate = if D == 2 { "m²/s" } else { "m³/s" };
                let message = format!("{:.4e} {rate} flow in at t = {t} s, but nothing lets them out", -net);
                let finding = Diagnostic::error(format!("boundary[{first}]"), message);
                self.findings.push(finding.help("add a boundary with `kind = \"outlet\"`"));
                return;
            }
        }
    }

    fn tensions(&mut self) -> Vec<([usize; 2], f64)> {
        let file = &self.case.file;
        let mut made = Vec::new();
        for (i, spec) in file.tension.iter().enumerate() {
            let place = |name: &String| file.body.iter().position(|body| body.name == *name);
            match [place(&spec.between[0]), place(&spec.between[1])] {
                [Some(a), Some(b)] if a != b => made.push(([a, b], spec.value)),
                _ => {
                    let names: Vec<&str> = file.body.iter().map(|body| body.name.as_str()).collect();
                    let finding = Diagnostic::error(format!("tension[{i}].between"), "these are not two bodies");
                    self.findings.push(finding.help(format!("there are {}", names.join(", "))));
                }
            }
        }
        made
    }

    fn fluid(&mut self, index: usize) -> Option<FluidSetup> {
        let spec = &self.case.file.body[index];
        match &spec.material {
            Material::Flow(law) => {
                let (density, viscosity) = law.parts();
                Some(FluidSetup { name: spec.name.clone(), density, viscosity })
            }
            Material::Point(law) => {
                let message = format!("the law `{}` is for `method = \"mpm\"`", law.name());
                let finding = Diagnostic::error(format!("body[{index}].material"), message);
                self.findings.push(finding.help("laws of fluids on a mesh are newtonian, bingham, herschel-bulkley"));
                None
            }
        }
    }

    fn part<const D: usize, const N: usize>(&mut self, index: usize, mesh: &Mesh<D, N>) -> Option<Part> {
        let spec = &self.case.file.body[index];
        let region = self.region(&format!("body[{index}].region"), &spec.region)?;
        let within: Vec<Vector<D>> =
            mesh.nodes().iter().copied().filter(|x| region.signed_distance(x.to3()) <= 0.0).collect();
        let samples = Samples::start(&within);
        let velocity = self.signals(&format!("body[{index}].velocity"), &spec.velocity, &samples);
        Some(Part { region, velocity })
    }

    /// Every element must have a fluid.
    fn unfilled<const D: usize, const N: usize>(&mut self, mesh: &Mesh<D, N>, parts: &[Part]) {
        let count = mesh.elements().len();
        let mut bare = (0..count).map(|e| mesh.center(e)).filter(|&x| part_at(parts, x).is_none()).peekable();
        let Some(first) = bare.peek().map(|x| x.0.map(|c| format!("{c:.6}")).join(", ")) else { return };
        let number = bare.count();
        let message = format!("{number} of {count} elements lie in no body, the first at ({first})");
        let help = "let a body that is listed later fill the rest: where regions overlap, the first one counts";
        self.findings.push(Diagnostic::error("body", message).help(help));
    }

    fn seed<const D: usize, const N: usize>(&mut self, mesh: &Mesh<D, N>, parts: &[Part]) -> Option<Particles<D>> {
        let per_edge = self.case.file.pfem2.particles_per_edge;
        let fluid = |x: Vector<D>| part_at(parts, x).map(|part| part as u8);
        let particles = Particles::seed(mesh, per_edge, fluid, |x| velocity_at(parts, x));
        for index in 0..parts.len() {
            if !particles.fluid.contains(&(index as u8)) {
                let help = "the region lies outside the mesh, under a body listed before it, or between particles";
                let finding = Diagnostic::error(format!("body[{index}].region"), "no particles are in this region");
                self.findings.push(finding.help(help));
            }
        }
        (!has_errors(&self.findings)).then_some(particles)
    }
}

/// The sharp level set of two fluids, negative in the heavier one.
fn sharp<const D: usize, const N: usize>(
    spec: &Pfem2Spec,
    mesh: &Mesh<D, N>,
    fluids: &[FluidSetup],
    parts: &[Part],
    particles: &mut Particles<D>,
) -> Option<LevelSet> {
    let [first, second] = fluids else { return None };
    let heavy = u8::from(second.density > first.density);
    // Where regions overlap the first one counts: the interface is its surface.
    let sign = if heavy == 0 { 1.0 } else { -1.0 };
    let phi = |x: Vector<D>| sign * parts[0].region.signed_distance(x.to3());
    (spec.interface == InterfaceSpec::Sharp).then(|| LevelSet::new(mesh, heavy, phi, particles))
}

/// Facets in no named part that has a condition.
fn rest<const D: usize, const N: usize>(mesh: &Mesh<D, N>, taken: &BTreeSet<&str>) -> Vec<Facet> {
    let named = mesh.sets.iter().filter(|(name, _)| taken.contains(name.as_str()));
    let used: BTreeSet<Facet> = named.flat_map(|(_, facets)| facets.iter().copied()).collect();
    mesh.boundary().iter().copied().filter(|facet| !used.contains(facet)).collect()
}

/// Flux through a facet at its nodes' mean velocity, outward, and what it would be if they all moved across [m³/s].
fn flux<const D: usize, const N: usize>(mesh: &Mesh<D, N>, facet: Facet, v: &[Signal; D], t: f64) -> (f64, f64) {
    let (area, nodes) = (mesh.facet_area(facet), mesh.facet_nodes(facet));
    let velocity = |node: &u32| Vector::<D>::from_fn(|i| v[i].value(mesh.nodes()[*node as usize].to3(), t));
    let sum = |measure: &dyn Fn(Vector<D>) -> f64| nodes.iter().map(velocity).map(measure).sum::<f64>();
    let count = nodes.len() as f64;
    (sum(&|v| v.dot(area)) / count, sum(&|v| v.norm() * area.norm()) / count)
}

/// The first body whose region holds a place.
fn part_at<const D: usize>(parts: &[Part], x: Vector<D>) -> Option<usize> {
    parts.iter().position(|part| part.region.signed_distance(x.to3()) <= 0.0)
}

fn velocity_at<const D: usize>(parts: &[Part], x: Vector<D>) -> Vector<D> {
    let Some(part) = part_at(parts, x) else { return Vector::ZERO };
    Vector::from_fn(|i| parts[part].velocity[i].value(x.to3(), 0.0))
}
