//! Viscous force per unit mass at the nodes, which the consistent stabilisation takes from the last velocity
//! (theory F.7.2).
//!
//! ```text
//! f_i = −Σ_e Σ_j K_ij v_j / Σ_e ρ V_e/(d + 1)      at nodes inside of one fluid: what the equation of momentum has there
//! f_i = the mean of the f_j of the nodes around    on the boundary, inside solids, and where an element holds several fluids
//! ```
//!
//! A linear velocity has no second derivatives in an element. Without f the residual lacks the viscous force, which in
//! the layer at a wall balances the pressure gradient. Between steps f goes along with the flow, as solids do.

use crate::math::Vector;
use crate::mesh::Mesh;
use crate::parallel;
use crate::pfem2::cut_element::Medium;
use crate::pfem2::element::{Content, viscous_forces};
use crate::pfem2::solid::coupling::immersed::Immersed;
use crate::pfem2::solid::coupling::viscous::CutForces;
use crate::pfem2::solid::cut::{CutBySolid, ElementState};

/// Flow from which viscous forces follow.
pub struct ViscousFlow<'a, const D: usize, const N: usize> {
    /// The mesh.
    pub mesh: &'a Mesh<D, N>,
    /// Content of each element.
    pub contents: &'a [Content<N>],
    /// Velocity at the nodes [m/s].
    pub velocity: &'a [Vector<D>],
    /// Solids in the mesh.
    pub immersed: Option<&'a Immersed<D, N>>,
}

impl<const D: usize, const N: usize> ViscousFlow<'_, D, N> {
    /// f at the nodes [m/s²]; `pure` is true for elements of one fluid, `walled` for nodes on the boundary.
    pub fn accelerations(
        &self,
        pure: impl Fn(usize) -> bool + Sync,
        walled: impl Fn(usize) -> bool + Sync,
    ) -> Vec<Vector<D>> {
        let Self { mesh, immersed, .. } = self;
        let cut: Vec<CutForces<D, N>> = immersed.map_or_else(Vec::new, |immersed| {
            parallel::collect(immersed.cut.elements.len(), 16, |place| self.in_cut_element(immersed, place))
        });
        let nodes = mesh.nodes().len();
        let inside = |i: usize| immersed.is_some_and(|immersed| immersed.cut.distance[i] <= 0.0);
        let own: Vec<Option<Vector<D>>> = parallel::collect(nodes, 256, |i| {
            let around = mesh.elements_around(i);
            if walled(i) || inside(i) || !around.iter().all(|&e| pure(e as usize)) {
                return None;
            }
            let (mut force, mut mass) = (Vector::ZERO, 0.0);
            for &e in around {
                let (own_force, own_mass) = self.at_node(e as usize, i, &cut);
                force += own_force;
                mass += own_mass;
            }
            (mass > 0.0).then(|| force / mass)
        });
        parallel::collect(nodes, 256, |i| own[i].unwrap_or_else(|| mean_around(mesh, i, &own)))
    }

    /// Force of an element on its node `i` [N], and its part of the mass there [kg].
    fn at_node(&self, e: usize, i: usize, cut: &[CutForces<D, N>]) -> (Vector<D>, f64) {
        let nodes = &self.mesh.elements()[e];
        let k = nodes.iter().position(|&node| node as usize == i).unwrap_or(0);
        match self.immersed.map_or(ElementState::Fluid, |immersed| immersed.cut.state[e]) {
            ElementState::Solid => (Vector::ZERO, 0.0),
            ElementState::Cut(place) => cut[place as usize][k],
            ElementState::Fluid => {
                let velocity = nodes.map(|node| self.velocity[node as usize]);
                let forces = viscous_forces(self.mesh.simplex(e), self.contents[e].viscosity, &velocity);
                (forces[k], self.contents[e].mass[k])
            }
        }
    }

    fn in_cut_element(&self, immersed: &Immersed<D, N>, place: usize) -> CutForces<D, N> {
        let CutBySolid { element, volume_fraction, .. } = immersed.cut.elements[place];
        let Content { mass, viscosity, .. } = &self.contents[element as usize];
        let volume = self.mesh.simplex(element as usize).volume * volume_fraction;
        if volume == 0.0 {
            return [(Vector::ZERO, 0.0); N];
        }
        let medium = Medium { density: mass.iter().sum::<f64>() / volume, viscosity: viscosity / volume_fraction };
        immersed.viscous_forces(self.mesh, place, medium, self.velocity)
    }
}

/// Mean of the values of the nodes around that have one; zero without any.
fn mean_around<const D: usize, const N: usize>(mesh: &Mesh<D, N>, i: usize, own: &[Option<Vector<D>>]) -> Vector<D> {
    let (mut sum, mut count) = (Vector::ZERO, 0.0);
    let corners = mesh.elements_around(i).iter().flat_map(|&e| &mesh.elements()[e as usize]);
    for value in corners.filter_map(|&node| own[node as usize]) {
        sum += value;
        count += 1.0;
    }
    if count > 0.0 { sum / count } else { Vector::ZERO }
}
