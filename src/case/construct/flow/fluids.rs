//! Fluids: their laws, where they are at the start, and the tension between them.

use super::super::signals::TrialPoints;
use super::super::{Construction, has_errors};
use super::mesh::at;
use super::solids::{InitialSolid, solid_at};
use crate::case::{EnrichmentSpec, InterfaceSpec, Material, Pfem2Spec, Preset, VolumeSpec};
use crate::error::Diagnostic;
use crate::geometry::Region;
use crate::material::ViscousLaws;
use crate::math::{Signal, Vector};
use crate::mesh::Mesh;
use crate::parallel;
use crate::pfem2::boundary::BoundarySetup;
use crate::pfem2::fluid::FluidSetup;
use crate::pfem2::interface::level_set::LevelSet;
use crate::pfem2::particles::{Particles, lattice};

/// Most fluids: particles keep the number of theirs in a byte.
const MOST_FLUIDS: usize = 256;

/// Points along an edge of an element where two bodies meet, at which gaps between them are looked for.
const GAP_POINTS: usize = 8;

/// Nodes and elements that a thread asks for their bodies at once.
const PIECE: usize = 256;

/// A body of particles as the case describes it, a fluid or a solid: where it is, and how it moves at the start. Of
/// several the first counts where they overlap.
pub(super) struct InitialBody {
    /// Its place in `body`.
    body: usize,
    /// The number of its phase.
    phase: u8,
    region: Region,
    velocity: [Signal; 3],
}

impl InitialBody {
    /// The number of its phase: those of solids follow those of fluids.
    pub fn phase(&self) -> usize {
        self.phase.into()
    }

    /// True for a place inside of it, or on its boundary [m].
    pub fn contains<const D: usize>(&self, x: Vector<D>) -> bool {
        self.region.signed_distance(x.to3()) <= 0.0
    }
}

impl Construction<'_> {
    pub(super) fn tensions(&mut self) -> Vec<([usize; 2], f64)> {
        let file = &self.case.file;
        let mut made: Vec<([usize; 2], f64)> = Vec::new();
        let fluids: Vec<&str> = file.fluids().into_iter().map(|i| file.body[i].name.as_str()).collect();
        for (i, spec) in file.tension.iter().enumerate() {
            let place = |name: &String| fluids.iter().position(|fluid| fluid == name);
            match [place(&spec.between[0]), place(&spec.between[1])] {
                [Some(a), Some(b)] if a != b => {
                    if made.iter().any(|(pair, _)| *pair == [a, b] || *pair == [b, a]) {
                        let message = "this pair of bodies already has a surface tension";
                        let finding = Diagnostic::error(format!("tension[{i}].between"), message);
                        self.findings.push(finding.help("a pair has one tension: take one of them out"));
                    }
                    made.push(([a, b], spec.value));
                }
                _ => {
                    let message = "these are not two bodies of fluids";
                    let finding = Diagnostic::error(format!("tension[{i}].between"), message);
                    self.findings.push(finding.help(format!("there are {}", fluids.join(", "))));
                }
            }
        }
        self.idle_enrichment(&made);
        made
    }

    /// The key `enrichment` has no effect with surface tension: the pressure jumps.
    fn idle_enrichment(&mut self, tensions: &[([usize; 2], f64)]) {
        const KEY: &str = "pfem2.enrichment";
        let (file, fluids) = (&self.case.file, self.case.file.fluids().len());
        let all = fluids * fluids.saturating_sub(1) / 2;
        let pulled = tensions.iter().filter(|(_, tension)| *tension > 0.0).count();
        let other = file.pfem2.enrichment != EnrichmentSpec::Jump;
        if other && all > 0 && pulled == all && self.case.says(KEY) {
            let message = "has no effect: with surface tension the pressure jumps at the interface";
            self.findings.push(Diagnostic::error(KEY, message).help("take it out, or take the `[[tension]]` out"));
        }
    }

    pub(super) fn fluid(&mut self, index: usize) -> Option<FluidSetup> {
        let spec = &self.case.file.body[index];
        match &spec.material {
            Material::Flow(law) => Some(FluidSetup::new(&spec.name, law.clone().into_box())),
            Material::Point(law) => {
                if self.case.file.preset == Preset::Becker2015 {
                    self.no_rate_law(index, law.name());
                    return None;
                }
                let message = format!("the law `{}` is for `method = \"mpm\"`", law.name());
                let finding = Diagnostic::error(format!("body[{index}].material"), message);
                let help = format!(
                    "laws of fluids on a mesh are {}; solids in them have an elastic law with a stored energy, such as `neo-hookean`, or `rigid`",
                    ViscousLaws::NAMES.join(", ")
                );
                self.findings.push(finding.help(help));
                None
            }
        }
    }

    /// The body of this index in the case, as the one of this phase; `None` where its region can't be made.
    pub(super) fn initial_body<const D: usize, const N: usize>(
        &mut self,
        index: usize,
        phase: usize,
        mesh: &Mesh<D, N>,
    ) -> Option<InitialBody> {
        let spec = &self.case.file.body[index];
        let region = self.region(&format!("body[{index}].region"), spec.region.as_ref()?)?;
        let within: Vec<Vector<D>> =
            mesh.nodes().iter().copied().filter(|x| region.signed_distance(x.to3()) <= 0.0).collect();
        let samples = TrialPoints::start(&within);
        let velocity = self.signals(&format!("body[{index}].velocity"), &spec.velocity, &samples);
        Some(InitialBody { body: index, phase: phase as u8, region, velocity })
    }

    /// Every element must have a fluid, or be in a solid.
    pub(super) fn unfilled<const D: usize, const N: usize>(
        &mut self,
        mesh: &Mesh<D, N>,
        bodies: &[InitialBody],
        solids: &[InitialSolid<D>],
    ) {
        let count = mesh.elements().len();
        let is_bare = |x: &Vector<D>| body_at(bodies, *x).is_none() && solid_at(solids, *x).is_none();
        let mut bare = (0..count).map(|e| mesh.center(e)).filter(is_bare).peekable();
        let Some(first) = bare.peek().map(|&x| at(x)) else { return };
        let number = bare.count();
        let message = format!("{number} of {count} elements lie in no body, the first at ({first})");
        let help = "let a body that is listed later fill the rest: where regions overlap, the first one counts";
        self.findings.push(Diagnostic::error("body", message).help(help));
    }

    pub(super) fn seed<const D: usize, const N: usize>(
        &mut self,
        mesh: &Mesh<D, N>,
        bodies: &[InitialBody],
        solids: &[InitialSolid<D>],
    ) -> Option<Particles<D>> {
        if let Some(first) = bodies.get(MOST_FLUIDS) {
            let message = format!("a flow has at most {MOST_FLUIDS} bodies of fluids, and here are {}", bodies.len());
            let finding = Diagnostic::error(format!("body[{}]", first.body), message);
            self.findings.push(finding.help("join those of one material: a region may be a union of shapes"));
            return None;
        }
        let per_edge = self.case.file.pfem2.particles_per_edge;
        let fluid = |x: Vector<D>| match solid_at(solids, x) {
            Some(_) => None,
            None => body_at(bodies, x).map(|body| bodies[body].phase),
        };
        let particles = Particles::seed(mesh, per_edge, fluid, |x| velocity_at(bodies, x));
        if !has_errors(&self.findings) {
            self.gaps(mesh, bodies, solids);
        }
        for InitialBody { body, phase, .. } in bodies {
            if !particles.phase.contains(phase) && !self.comes_in(*body) {
                let help = "the region lies outside the mesh, under a body listed before it or a solid, or between particles; a fluid \
                            that is to come in is the `fluid` of an inlet";
                let finding = Diagnostic::error(format!("body[{body}].region"), "no particles are in this region");
                self.findings.push(finding.help(help));
            }
        }
        (!has_errors(&self.findings)).then_some(particles)
    }

    /// True if a part of the boundary brings the fluid of a body.
    fn comes_in(&self, index: usize) -> bool {
        let file = &self.case.file;
        file.boundary.iter().any(|part| part.fluid.as_ref() == Some(&file.body[index].name))
    }

    /// A sharp interface is for two fluids, and the volumes of more are corrected in closed boxes only: refuses a case
    /// that asks for it, and warns of the replacement otherwise.
    pub(super) fn several_fluids<const D: usize>(&mut self, sets: &[BoundarySetup<D>]) {
        let (case, spec) = (self.case, &self.case.file.pfem2);
        let fluids = case.file.fluids();
        let count = fluids.len();
        if count < 3 {
            self.pseudo_shift();
            return;
        }
        if spec.interface == InterfaceSpec::Sharp {
            let message = format!("this is for two fluids, and here are {count}");
            let help = "write `interface = \"pseudo\"`, or leave it out";
            self.findings.push(Diagnostic::error("pfem2.interface", message).help(help));
        }
        self.open_volumes(sets, fluids[2]);
        if case.file.preset == Preset::Recommended && !case.says("pfem2.interface") {
            let message = format!(
                "interfaces of {count} fluids are known within a part of an element (`interface = \"pseudo\"`)"
            );
            let help =
                "write `interface = \"pseudo\"` in `[pfem2]` if that is meant; two fluids have a sharp interface";
            self.findings.push(Diagnostic::warning(format!("body[{}]", fluids[2]), message).help(help));
        }
    }

    /// The outflow of three and more fluids isn't known by fluid: their volumes are corrected in closed boxes only.
    fn open_volumes<const D: usize>(&mut self, sets: &[BoundarySetup<D>], third: usize) {
        let spec = &self.case.file.pfem2;
        let Some(open) = sets.iter().find(|set| set.condition.kind().admits_flow()) else { return };
        if spec.volume == VolumeSpec::None {
            return;
        }
        let message =
            format!("the volumes of three and more fluids are kept in closed boxes, and `{}` is open", open.name);
        let help = "write `volume = \"none\"` in `[pfem2]`: they are in `history/balance.csv`";
        self.findings.push(match self.case.says("pfem2.volume") {
            true => Diagnostic::error("pfem2.volume", message).help(help),
            false => Diagnostic::warning(format!("body[{}]", third), message + ": they are not kept").help(help),
        });
    }

    /// Only the sharp interface can be shifted.
    fn pseudo_shift(&mut self) {
        let spec = &self.case.file.pfem2;
        if spec.interface == InterfaceSpec::Pseudo && spec.volume == VolumeSpec::Shift {
            let message =
                "this needs `interface = \"sharp\"`: a line that follows the fractions of particles can't be shifted";
            let help = "write `volume = \"none\"`, leave it out, or take the sharp interface";
            self.findings.push(Diagnostic::error("pfem2.volume", message).help(help));
        }
    }

    /// Warns of gaps between bodies, in elements whose centre is in one of them.
    fn gaps<const D: usize, const N: usize>(
        &mut self,
        mesh: &Mesh<D, N>,
        bodies: &[InitialBody],
        solids: &[InitialSolid<D>],
    ) {
        let is_bare = |x: Vector<D>| body_at(bodies, x).is_none() && solid_at(solids, x).is_none();
        let points = lattice::<N>(GAP_POINTS);
        let held: Vec<Option<usize>> =
            parallel::collect(mesh.nodes().len(), PIECE, |n| body_at(bodies, mesh.nodes()[n]));
        let bare = |e: usize| {
            let [first, others @ ..] = &mesh.elements()[e][..] else { return 0 };
            if others.iter().all(|&n| held[n as usize].is_some() && held[n as usize] == held[*first as usize]) {
                return 0;
            }
            let x = mesh.corners(e);
            let place = |shape: &[f64; N]| (0..N).map(|k| x[k] * shape[k]).sum::<Vector<D>>();
            points.iter().filter(|shape| is_bare(place(shape))).count()
        };
        let bare: Vec<usize> = parallel::collect(mesh.elements().len(), PIECE, bare);
        let Some(first) = bare.iter().position(|&count| count > 0) else { return };
        let size = |e: usize| mesh.simplex(e).volume * bare[e] as f64 / points.len() as f64;
        let volume: f64 = (0..bare.len()).map(size).sum();
        let message = format!(
            "about {volume:.2e} {} between the bodies belong to none of them, the first in the element at ({}): their \
             neighbours fill them",
            if D == 2 { "m²" } else { "m³" },
            at(mesh.center(first))
        );
        let help = "let the bodies touch or overlap: where regions overlap, the first one counts";
        self.findings.push(Diagnostic::warning("body", message).help(help));
    }
}

/// The sharp level set of two fluids, negative in the heavier one.
pub(super) fn sharp<const D: usize, const N: usize>(
    spec: &Pfem2Spec,
    mesh: &Mesh<D, N>,
    fluids: &[FluidSetup],
    bodies: &[InitialBody],
    particles: &mut Particles<D>,
) -> Option<LevelSet> {
    let [first, second] = fluids else { return None };
    let heavy = u8::from(second.density > first.density);
    // Of regions that overlap the first one counts: the interface is its surface.
    let sign = if heavy == 0 { 1.0 } else { -1.0 };
    let phi = |x: Vector<D>| sign * bodies[0].region.signed_distance(x.to3());
    (spec.interface == InterfaceSpec::Sharp).then(|| LevelSet::new(mesh, heavy, phi, particles))
}

/// The first body whose region contains a place [m].
pub(super) fn body_at<const D: usize>(bodies: &[InitialBody], x: Vector<D>) -> Option<usize> {
    bodies.iter().position(|body| body.contains(x))
}

pub(super) fn velocity_at<const D: usize>(bodies: &[InitialBody], x: Vector<D>) -> Vector<D> {
    let Some(body) = body_at(bodies, x) else { return Vector::ZERO };
    Vector::from_fn(|i| bodies[body].velocity[i].value(x.to3(), 0.0))
}

#[cfg(test)]
mod tests {
    use crate::case::Material;

    #[test]
    fn laws_with_a_stored_energy_and_rigid_ones_are_those_of_solids() {
        let elastic = "density = 1e3, young = 1e6, poisson = 0.3";
        let laws = [
            (format!("law = 'hypoelastic', {elastic}"), false),
            (format!("law = 'neo-hookean', {elastic}"), true),
            (format!("law = 'st-venant-kirchhoff', {elastic}"), true),
            (format!("law = 'j2', {elastic}, yield-stress = 1e3"), false),
            ("law = 'mooney-rivlin', density = 1e3, c10 = 1e5, c01 = 1e4, bulk = 1e7".to_owned(), true),
            ("law = 'newtonian', density = 1e3, viscosity = 1e-3".to_owned(), false),
            ("law = 'rigid', density = 1e3".to_owned(), true),
        ];
        for (law, is_solid) in laws {
            let table: toml::Table = toml::from_str(&format!("material = {{ {law} }}")).unwrap();
            let material: Material = table["material"].clone().try_into().expect(&law);
            assert_eq!(material.is_solid(), is_solid, "{law}");
        }
    }
}
