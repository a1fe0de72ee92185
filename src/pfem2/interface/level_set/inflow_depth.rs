//! The depth of what comes in through open boundaries, and where an interface is born at one (theory (G.6)).
//!
//! ```text
//! foot x_b on a facet, the particle at x_b − w before the step
//! depth = d(x_b) + max(0, −∇d·w)      d: distance from the interface as it is, on the side of the fluid that comes in
//! ```
//!
//! φ as it is at the facet is no measure: it is continued from the particles behind the facet, and what comes in with
//! it would continue it again. A jet that once came nearer to an outlet would come nearer for ever, until an interface
//! stood there that nothing brought. Distances are measured in every step, so that nothing is handed on; beyond a facet
//! there is only the fluid that comes in, so that no particle comes nearer to an interface by being farther out.
//!
//! If another fluid comes in than the one behind the facet, the facet itself is the interface at the start of the
//! step: the particles behind it learn how far away they are.

use super::distance::InterfacePolygons;
use super::{AGREES, LevelSet, OpenFacet, value};
use crate::math::Vector;
use crate::mesh::{Facet, Mesh};
use crate::parallel;
use crate::pfem2::cut_element::is_cut;
use crate::pfem2::particles::Particles;
use crate::pfem2::particles::convect::MeshPoint;
use crate::pfem2::phases::FluidRegion;

/// Distances from the interface at the start of a step, as open boundaries see them.
#[derive(Debug, Clone)]
pub struct InflowDepth {
    /// Distances of the nodes, with the sign of φ [m].
    distance: Vec<f64>,
}

impl InflowDepth {
    /// From the state at the start of a step that the convecting velocity v* [m/s] makes. The particles behind facets
    /// at which an interface begins take their distance from these as their depth.
    pub fn new<const D: usize, const N: usize>(
        region: &FluidRegion<D, N>,
        set: &LevelSet,
        open_facets: &[OpenFacet<D>],
        convecting: &[Vector<D>],
        particles: &mut Particles<D>,
    ) -> Self {
        let mesh = region.mesh;
        let mut interface = InterfacePolygons::new(region, &set.level);
        let fronts: Vec<Facet> =
            open_facets.iter().filter(|opening| is_front(mesh, set, opening, convecting)).map(|o| o.facet).collect();
        if !fronts.is_empty() {
            let fronts = InterfacePolygons::of_facets(mesh, &fronts);
            set.limit_depths(mesh, &fronts.distances(mesh, set.band), particles);
            interface = interface.union(fronts);
        }
        let mut distance = interface.distances(mesh, set.band);
        distance.iter_mut().zip(&set.level).for_each(|(distance, phi)| *distance = distance.copysign(*phi));
        Self { distance }
    }
}

/// True if another fluid comes in through a facet than the one behind it.
fn is_front<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    set: &LevelSet,
    opening: &OpenFacet<D>,
    convecting: &[Vector<D>],
) -> bool {
    let (area, nodes) = (mesh.facet_area(opening.facet), mesh.facet_nodes(opening.facet));
    let comes_in = nodes.iter().map(|&node| convecting[node as usize].dot(area)).sum::<f64>() < 0.0;
    let there: [f64; D] = std::array::from_fn(|k| set.level[nodes[k] as usize]);
    let inside = |phi: &[f64; D]| phi.iter().sum::<f64>() < 0.0;
    comes_in && !is_cut(&there) && !is_cut(&opening.inflow_level) && inside(&there) != inside(&opening.inflow_level)
}

/// A particle that came in through the boundary.
#[derive(Debug, Clone, Copy)]
pub struct CameIn<'a, const D: usize, const N: usize> {
    /// Place of the particle now.
    pub place: &'a MeshPoint<N>,
    /// The facet of the boundary.
    pub facet: Facet,
    /// Way of the particle from beyond the facet to that place [m].
    pub way: Vector<D>,
    /// The level that the facet holds there [m].
    pub held: f64,
}

impl LevelSet {
    /// Particles near an interface that begins at these distances of the nodes [m] are no deeper than that.
    fn limit_depths<const D: usize, const N: usize>(
        &self,
        mesh: &Mesh<D, N>,
        distance: &[f64],
        particles: &mut Particles<D>,
    ) {
        let Particles { position, element, depth, .. } = particles;
        parallel::change(depth, 256, |p, depth| {
            let e = element[p] as usize;
            let place = MeshPoint { element: e, shape: mesh.shape_functions(e, position[p]) };
            let away = value(mesh, &place, distance);
            if away < self.band {
                *depth = depth.min(away);
            }
        });
    }

    /// Fluid and depth of what came in. Where another line than that of the facet is near, its distance counts.
    pub fn inflow_at<const D: usize, const N: usize>(
        &self,
        mesh: &Mesh<D, N>,
        came: &CameIn<'_, D, N>,
        entering: &InflowDepth,
    ) -> (u8, f64) {
        let &CameIn { place, facet, way, held } = came;
        let simplex = mesh.simplex(place.element);
        let nodes = simplex.gradient.iter().zip(&mesh.elements()[place.element]);
        let slope: Vector<D> = nodes.map(|(&g, &node)| g * entering.distance[node as usize]).sum();
        let fluid = if held < 0.0 { self.inside } else { self.outside() };
        let near = self.sign(fluid) * value(mesh, place, &entering.distance);
        let farther = -self.sign(fluid) * slope.dot(way);
        // Fluid that came in before the step is inside, and may have come nearer.
        let outer = simplex.gradient[facet.opposite as usize].dot(way) >= 0.0;
        let least = if outer { 0.0 } else { -way.norm() };
        let seen = (near.max(0.0) + farther.clamp(least, way.norm())).clamp(0.0, self.band);
        let agrees = (held.abs() - seen).abs() <= AGREES * self.edge();
        (fluid, if agrees { held.abs() } else { seen.min(held.abs()) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const AIR: f64 = 1e30;

    fn top(mesh: &Mesh<2, 3>, inflow_level: f64) -> Vec<OpenFacet<2>> {
        let on = |facet: &&Facet| mesh.facet_nodes(**facet).iter().all(|&i| mesh.nodes()[i as usize][1] == 1.0);
        mesh.boundary().iter().filter(on).map(|&facet| OpenFacet { facet, inflow_level: [inflow_level; 2] }).collect()
    }

    /// Water below 0.6 in a box of unit size, with φ stretched above it; `inflow_level` is φ of what comes in from
    /// above.
    fn comes_in(stretch: impl Fn(f64) -> f64 + Sync, inflow_level: f64) -> (Particles<2>, Vec<(u8, f64)>) {
        let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector::splat(1.0), [10; 2]).unwrap();
        let phi = |x: Vector<2>| if x[1] < 0.61 { x[1] - 0.6 } else { stretch(x[1]) };
        let mut particles = Particles::seed(&mesh, 3, |x| Some(u8::from(phi(x) >= 0.0)), |_| Vector::ZERO);
        let set = LevelSet::new(&mesh, 0, phi, &mut particles);
        let (open_facets, fall) = (top(&mesh, inflow_level), Vector([0.0, -1.0]));
        let entering = InflowDepth::new(
            &FluidRegion::whole(&mesh),
            &set,
            &open_facets,
            &vec![fall; mesh.nodes().len()],
            &mut particles,
        );
        let middle = |opening: &OpenFacet<2>| {
            let facet = opening.facet;
            let shape = std::array::from_fn(|k| if k == facet.opposite as usize { 0.0 } else { 0.5 });
            let place = MeshPoint { element: facet.element as usize, shape };
            set.inflow_at(&mesh, &CameIn { place: &place, facet, way: fall * 0.05, held: inflow_level }, &entering)
        };
        let found = open_facets.iter().map(middle).collect();
        (particles, found)
    }

    /// As if water stood a little above the top: continued, an interface would come in that is nowhere.
    #[test]
    fn inflowing_air_has_its_distance_from_the_water_below_as_depth() {
        let (_, found) = comes_in(|y| 0.1 + (1.05 - y) * 0.1, AIR);
        for (fluid, depth) in found {
            assert!(fluid == 1 && (depth - 0.45).abs() < 1e-12, "{fluid} {depth}");
        }
    }

    /// Water comes in above air: the top is the interface, and the air below it is as deep as it is below the top.
    #[test]
    fn an_interface_begins_where_another_fluid_comes_in() {
        let (particles, found) = comes_in(|y| y - 0.6, -AIR);
        for (fluid, depth) in found {
            assert!(fluid == 0 && (depth - 0.05).abs() < 1e-12, "{fluid} {depth}");
        }
        let air =
            particles.position.iter().zip(&particles.depth).zip(&particles.phase).filter(|(_, fluid)| **fluid == 1);
        for ((x, depth), _) in air {
            assert!((depth - (x[1] - 0.6).min(1.0 - x[1])).abs() < 1e-12, "{x:?}: {depth}");
        }
    }
}
