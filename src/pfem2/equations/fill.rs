//! Filling of each element in a step: its content, with viscosity and τ, and the enriched pressures of those that an
//! interface cuts (theory F.6, G.8).

use super::contents::CutElement;
use super::slip;
use super::subscale;
use super::system::VelocityPressureSystem;
use crate::math::Vector;
use crate::parallel;
use crate::pfem2::cut_element::surface_tension;
use crate::pfem2::cut_element::{Enriched, Enrichment, Medium, ResidualTerms};
use crate::pfem2::element::shear::shear_rate;
use crate::pfem2::element::{self, Content, Drive, Mass, Stabilisation};
use crate::pfem2::fluid::FluidSetup;
use crate::pfem2::particle_solids::solids::SurroundingFluid;
use crate::pfem2::phases::{Filling, Phases};
use crate::pfem2::solid::cut::ElementState;

impl<const D: usize, const N: usize> VelocityPressureSystem<D, N> {
    /// Finds what fills each element: its content, and the enrichment of cut ones.
    pub(in crate::pfem2) fn fill(&mut self, phases: &Phases, convected: &[Vector<D>]) {
        let count = self.mesh.elements().len();
        let filled: Vec<(Content<N>, bool)> = parallel::collect(count, 256, |e| {
            let filling = phases.filling(&self.mesh.elements()[e]);
            let volume = self.mesh.simplex(e).volume;
            let (viscosity, tau) = (|fluid| self.viscosity(e, fluid), |medium| self.tau(e, medium));
            let cut_tau = |medium| self.cut_tau() * tau(medium);
            let content = filling.content(volume, &self.contents.density, viscosity, tau, cut_tau);
            (content, matches!(filling, Filling::Pure(_)))
        });
        let (mut contents, mut pure): (Vec<_>, Vec<_>) = filled.into_iter().unzip();
        self.fill_cut_by_solids(&mut contents, phases, convected);
        self.fill_with_solids(phases, &mut contents, convected);
        pure.iter_mut().enumerate().for_each(|(e, pure)| *pure &= !self.holds_solid(e));
        let drives = self.elements(convected);
        let is_fluid =
            |e: usize| self.immersed.as_ref().is_none_or(|immersed| immersed.cut.state[e] == ElementState::Fluid);
        let elements = self.mesh.elements();
        let cuts = parallel::collect_some(count, 256, |e| {
            let enrich = || self.enrich(e, phases.filling(&elements[e]), &contents[e], &drives.drive(e, true));
            if pure[e] || !is_fluid(e) || self.holds_solid(e) { None } else { enrich() }
        });
        self.contents.volumes = phases.volumes(&self.fluid_region());
        self.contents.cuts = cuts;
        (self.contents.elements, self.contents.pure) = (contents, pure);
    }

    /// Makes the equations and the contents of elements that hold solids on particles.
    fn fill_with_solids(&mut self, phases: &Phases, contents: &mut [Content<N>], convected: &[Vector<D>]) {
        let Some(mut solids) = self.particle_solids.take() else { return };
        let drives = self.elements(convected);
        let around = SurroundingFluid {
            mesh: &self.mesh,
            equations: self.equations,
            drive: &|e| drives.drive(e, false),
            viscosity: &|e| self.viscosity(e, 0),
            tau: &|e, medium| self.tau(e, medium),
        };
        solids.fill(&around, phases, contents);
        self.particle_solids = Some(solids);
    }

    /// The enriched pressure and the surface tension of an element, if it is cut.
    fn enrich(
        &self,
        e: usize,
        filling: Filling<N>,
        content: &Content<N>,
        drive: &Drive<D, N>,
    ) -> Option<CutElement<D, N>> {
        let cut = filling.cut(&self.contents.density, |fluid| self.viscosity(e, fluid))?;
        let Filling::Cut(pair, level) = filling else { return None };
        let simplex = self.mesh.simplex(e);
        let tension = self.physics.tension_between(pair);
        let enrichment = if tension > 0.0 { Enrichment::Jump } else { self.physics.enrichment };
        let delay = match self.physics.stabilisation {
            Stabilisation::ConsistentPspg | Stabilisation::Dynamic => content.tau / self.equations.delta,
            Stabilisation::Pspg | Stabilisation::Oss => 0.0,
        };
        let walls = slip::press_enriched(&cut, enrichment, simplex, self.mesh_data.slip[e]);
        let sources = cut.sides().map(|own| drive.forces_of(&self.equations, own));
        let residual = ResidualTerms { source: sources, convected: &drive.convected, inertia: delay };
        let enriched = Enriched::new(&cut, enrichment, simplex, content.tau, residual).beside(walls);
        let negative_fraction = cut.negative_fraction();
        let source =
            sources[0] * negative_fraction + sources[1] * (1.0 - negative_fraction) + drive.inertia(&self.equations);
        let x = self.mesh.corners(e);
        let energy = if tension > 0.0 { tension * surface_tension::area(&level, &x) } else { 0.0 };
        let tension = surface_tension::forces(&level, &x, simplex, tension, self.mesh_data.outlets[e]);
        let inertia = match self.physics.mass {
            Mass::Lumped => [[0.0; N]; N],
            Mass::Consistent => {
                let own = cut.mass(simplex.volume);
                let mean = |i, j| element::mass(content, Mass::Consistent, (i, j));
                std::array::from_fn(|i| std::array::from_fn(|j| own[i][j] - mean(i, j)))
            }
        };
        Some(CutElement { element: e as u32, inertia, enriched, tension, energy, source })
    }

    /// Viscosity of a fluid in an element at the shear rate of the last velocity [Pa s].
    pub(super) fn viscosity(&self, e: usize, fluid: usize) -> f64 {
        let Some(FluidSetup { law, .. }) = self.physics.fluids.get(fluid) else { return 0.0 };
        let rate = if !law.is_newtonian() {
            let velocity = self.mesh.elements()[e].map(|node| self.velocity[node as usize]);
            shear_rate(&self.mesh.simplex(e).gradient, &velocity)
        } else {
            0.0
        };
        law.viscosity(rate)
    }

    /// Stabilisation time of an element [s]. Only the paper's form counts the speed: the system has no convection.
    pub(super) fn tau(&self, e: usize, medium: Medium) -> f64 {
        let speed = match self.physics.stabilisation {
            Stabilisation::Pspg => {
                let nodes = self.mesh.elements()[e];
                nodes.iter().map(|&i| self.velocity[i as usize]).sum::<Vector<D>>().norm() / N as f64
            }
            Stabilisation::ConsistentPspg | Stabilisation::Dynamic | Stabilisation::Oss => 0.0,
        };
        let delta = self.equations.delta * self.physics.stabilisation.subscale_inertia();
        element::tau(delta, medium.viscosity, medium.density, self.mesh_data.size[e], speed)
    }

    /// τ of a cut element, over that of another.
    pub(super) fn cut_tau(&self) -> f64 {
        match self.physics.stabilisation {
            Stabilisation::Oss => subscale::CUT_TAU,
            Stabilisation::Pspg | Stabilisation::ConsistentPspg | Stabilisation::Dynamic => 1.0,
        }
    }
}
