//! Filling of the elements that solids cut: one fluid, a mixture, or two with an interface (theory J.3, G.14).

use super::system::VelocityPressureSystem;
use crate::math::Vector;
use crate::mesh::Facet;
use crate::parallel;
use crate::pfem2::cut_element::{Enrichment, Medium};
use crate::pfem2::element::{Content, Drive};
use crate::pfem2::phases::FluidRegion;
use crate::pfem2::phases::{Filling, Phases};
use crate::pfem2::solid::coupling::fluid_part::FluidPart;
use crate::pfem2::solid::cut::ElementState;

impl<const D: usize, const N: usize> VelocityPressureSystem<D, N> {
    /// Makes the equations of elements that solids cut, and leaves their fluid in the contents.
    pub(super) fn fill_cut_by_solids(&mut self, contents: &mut [Content<N>], phases: &Phases, convected: &[Vector<D>]) {
        let Some(mut immersed) = self.immersed.take() else { return };
        let drives = self.elements(convected);
        let region = FluidRegion::new(&self.mesh, Some(&immersed.cut));
        let of = |cut: usize| {
            let own = &immersed.cut.elements[cut];
            let e = own.element as usize;
            match phases.filling(&own.nodes) {
                Filling::Cut(pair, level) => {
                    let (level, drive) = (own.level_on_its_side(level), drives.drive(e, true));
                    let is_pure = level.iter().all(|phi| (*phi < 0.0) == (level[0] < 0.0));
                    // Enriched, a sliver of fluid beside a thin wall would alone tell the pressure at its nodes inside.
                    let is_beside_thin_wall = own.nodes_of_two_sides().next().is_some();
                    match (is_pure, is_beside_thin_wall) {
                        (true, _) => self.pure_fluid(e, pair[usize::from(level[0] >= 0.0)], &drive),
                        (false, true) => self.one_fluid(e, &contents[e], &drives.drive(e, false)),
                        (false, false) => self.two_fluids(&region, e, pair, level, &drive),
                    }
                }
                Filling::Pure(_) | Filling::Mixed(_) => self.one_fluid(e, &contents[e], &drives.drive(e, false)),
            }
        };
        let fluids = parallel::collect(immersed.cut.elements.len(), 64, of);
        immersed.fill(&self.mesh, &self.equations, &fluids);
        contents.iter_mut().enumerate().for_each(|(e, content)| immersed.reduce(e, content));
        self.immersed = Some(immersed);
    }

    /// True for elements that no solid on a mesh of its own cuts or covers.
    pub(in crate::pfem2) fn is_whole(&self, element: u32) -> bool {
        self.immersed.as_ref().is_none_or(|immersed| immersed.cut.state[element as usize] == ElementState::Fluid)
    }

    /// Adds the tractions at time `t` on openings that solids meet to the equations of the elements there.
    pub(super) fn load_openings_beside_solids(&mut self, t: f64) {
        let Some(immersed) = &mut self.immersed else { return };
        for own in &mut immersed.elements {
            let element = own.element;
            own.load_openings(|opposite, x| self.boundary.traction(&self.mesh, Facet { element, opposite }, x, t));
        }
    }

    /// One fluid, or a mixture, in the part of an element that a solid leaves; `content` is that of the whole element.
    fn one_fluid(&self, e: usize, content: &Content<N>, drive: &Drive<D, N>) -> FluidPart<D, N> {
        let density = content.mass.iter().sum::<f64>() / self.mesh.simplex(e).volume;
        self.filled_with(e, Medium { density, viscosity: content.viscosity }, content.tau, drive)
    }

    /// One fluid in the part of an element that a solid leaves, where the interface with another one lies in the solid.
    fn pure_fluid(&self, e: usize, fluid: usize, drive: &Drive<D, N>) -> FluidPart<D, N> {
        let medium = Medium { density: self.contents.density[fluid], viscosity: self.viscosity(e, fluid) };
        self.filled_with(e, medium, self.tau(e, medium), drive)
    }

    /// A medium in the part of an element that a solid leaves.
    fn filled_with(&self, e: usize, medium: Medium, tau: f64, drive: &Drive<D, N>) -> FluidPart<D, N> {
        FluidPart {
            level: [1.0; N],
            media: [medium; 2],
            enrichment: Enrichment::None,
            tension: 0.0,
            held: self.mesh_data.held[e],
            openings: self.mesh_data.openings[e],
            outlets: self.mesh_data.outlets[e],
            tau,
            drive: *drive,
            sources: [drive.forces_of(&self.equations, [true; N]); 2],
        }
    }

    /// Two fluids with an interface in the part of an element that a solid leaves.
    fn two_fluids(
        &self,
        region: &FluidRegion<D, N>,
        e: usize,
        pair: [usize; 2],
        level: [f64; N],
        drive: &Drive<D, N>,
    ) -> FluidPart<D, N> {
        let media =
            pair.map(|fluid| Medium { density: self.contents.density[fluid], viscosity: self.viscosity(e, fluid) });
        let negative_fraction = region.negative_volume(e, &level) / region.volume(e).max(f64::MIN_POSITIVE);
        let mean =
            |of: fn(&Medium) -> f64| negative_fraction * of(&media[0]) + (1.0 - negative_fraction) * of(&media[1]);
        let mean = Medium { density: mean(|medium| medium.density), viscosity: mean(|medium| medium.viscosity) };
        let sides = [true, false].map(|negative| level.map(|phi| (phi < 0.0) == negative));
        let enrichment = match self.physics.enrichment {
            Enrichment::None => Enrichment::None,
            // Nodes inside of the solid may have no fluid of their side: one function per node tells what the other has
            // there.
            Enrichment::Kink | Enrichment::Jump => Enrichment::Jump,
        };
        FluidPart {
            level,
            media,
            enrichment,
            tension: self.physics.tension_between(pair),
            held: self.mesh_data.held[e],
            openings: self.mesh_data.openings[e],
            outlets: self.mesh_data.outlets[e],
            tau: self.cut_tau() * self.tau(e, mean),
            drive: *drive,
            sources: sides.map(|own| drive.forces_of(&self.equations, own)),
        }
    }
}
