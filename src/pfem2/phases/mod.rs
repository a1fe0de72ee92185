//! The fluids that fill an element: one, two with an interface between them, or a mixture of more.
//!
//! ```text
//! one fluid at all nodes   the element is full of it
//! two fluids a, b          cut where φ = 0: the level set of the run, sharp or of the projection, if there are only two
//!                          fluids in all, else φ_i = (f_b − f_a)/(f_a + f_b) of the nodal fractions (Becker (37) of the pair, theory (G.1))
//! more than two            not split: mass from the nodal fractions, viscosity and ∫dV/ρ from their means
//! ```
//!
//! The fluid of a node is the one with the largest fraction; of equal ones the first in the order of [`PhaseList`], the
//! heaviest. (Between nodes it is the one with the highest number: interpolated fractions are hardly ever equal.)
//!
//! ```text
//! phase_list     the phases by role and density
//! fluid_region   the part of the mesh that solids leave to the fluids             theory G.14
//! ```

mod fluid_region;
pub mod phase_list;

pub use fluid_region::FluidRegion;

use crate::parallel;
use crate::pfem2::cut_element::{CutGeometry, Medium, is_cut};
use crate::pfem2::element::Content;
use phase_list::PhaseList;

/// The filling of an element.
#[derive(Debug, Clone, PartialEq)]
pub enum Filling<const N: usize> {
    /// One fluid.
    Pure(usize),
    /// Two phases, and a level set that is negative in the first.
    Cut([usize; 2], [f64; N]),
    /// More than two; mean fraction of each.
    Mixed(Vec<f64>),
}

/// Nodal phases as the projection left them.
#[derive(Debug, Clone, Copy)]
pub struct Phases<'a> {
    /// The phases by their numbers.
    pub list: &'a PhaseList,
    /// Fraction of each fluid at each node, by fluid and node.
    pub fraction: &'a [Vec<f64>],
    /// Level set of two phases, negative in the first of their sides.
    pub level: &'a [f64],
}

impl Phases<'_> {
    /// The fluid of a node.
    pub fn at(&self, node: usize) -> usize {
        if let Some([negative, positive]) = self.list.sides() {
            return if self.level[node] < 0.0 { negative } else { positive };
        }
        let order = |a: &usize, b: &usize| {
            let [f, g] = [a, b].map(|phase| self.fraction[*phase][node]);
            f.total_cmp(&g).then(self.list.compare(*a, *b))
        };
        match self.list.count() {
            1 => 0,
            count => (0..count).max_by(order).unwrap_or(0),
        }
    }

    /// The fluid at a point of an element with these nodes and shape functions.
    pub fn at_place<const N: usize>(&self, nodes: &[u32; N], shape: &[f64; N]) -> usize {
        let mean = |values: &[f64]| nodes.iter().zip(shape).map(|(&i, n)| n * values[i as usize]).sum::<f64>();
        if let Some([negative, positive]) = self.list.sides() {
            return if mean(self.level) < 0.0 { negative } else { positive };
        }
        match self.list.count() {
            1 => 0,
            count => {
                (0..count).max_by(|a, b| mean(&self.fraction[*a]).total_cmp(&mean(&self.fraction[*b]))).unwrap_or(0)
            }
        }
    }

    /// The filling of an element with these nodes.
    pub fn filling<const N: usize>(&self, nodes: &[u32; N]) -> Filling<N> {
        let own = nodes.map(|node| self.at(node as usize));
        let first = own[0];
        let Some(&second) = own.iter().find(|&&fluid| fluid != first) else { return Filling::Pure(first) };
        if own.iter().any(|&fluid| fluid != first && fluid != second) {
            return Filling::Mixed(self.mean(nodes));
        }
        let pair = self.list.sides().unwrap_or_else(|| self.list.ordered([first, second]));
        let level = nodes.map(|node| self.level_of(node as usize, pair));
        match is_cut(&level) {
            true => Filling::Cut(pair, level),
            // One side is round-off: the element is full of the fluid of its largest level.
            false => Filling::Pure(if level.iter().sum::<f64>() < 0.0 { pair[0] } else { pair[1] }),
        }
    }

    /// Level set at the nodes of an element, if two fluids may meet in it or on one of its facets.
    pub fn level_in<const N: usize>(&self, nodes: &[u32; N]) -> Option<[f64; N]> {
        match self.list.count() {
            1 => None,
            2 => Some(nodes.map(|node| self.level[node as usize])),
            _ => match self.filling(nodes) {
                Filling::Cut(_, level) => Some(level),
                _ => None,
            },
        }
    }

    /// The level set between two fluids at a node.
    fn level_of(&self, node: usize, [negative, positive]: [usize; 2]) -> f64 {
        if self.list.sides().is_some() {
            return self.level[node];
        }
        let (a, b) = (self.fraction[negative][node], self.fraction[positive][node]);
        let level = (b - a) / (a + b).max(f64::MIN_POSITIVE);
        // A node of the first phase counts to its side also when the fractions are equal.
        if self.at(node) == negative { level.min(-f64::MIN_POSITIVE) } else { level.max(f64::MIN_POSITIVE) }
    }

    /// Volume of each fluid in all elements [m³].
    pub fn volumes<const D: usize, const N: usize>(&self, region: &FluidRegion<D, N>) -> Vec<f64> {
        self.volumes_in(region, region.mesh.elements().len(), |e| e)
    }

    /// Volume of each fluid in `count` elements, of which `element` gives each [m³].
    pub fn volumes_in<const D: usize, const N: usize>(
        &self,
        region: &FluidRegion<D, N>,
        count: usize,
        element: impl Fn(usize) -> usize + Sync + Send,
    ) -> Vec<f64> {
        let fluids = self.list.count();
        let chunk = |range: std::ops::Range<usize>| {
            let mut volumes = vec![0.0; fluids];
            for e in range.map(&element) {
                self.filling(&region.mesh.elements()[e]).add(region, e, &mut volumes);
            }
            volumes
        };
        let add = |a: Vec<f64>, b: Vec<f64>| a.iter().zip(&b).map(|(a, b)| a + b).collect();
        parallel::reduce(count, chunk, add).unwrap_or_else(|| vec![0.0; fluids])
    }

    /// Mean fractions over an element's nodes.
    fn mean<const N: usize>(&self, nodes: &[u32; N]) -> Vec<f64> {
        let count = self.list.count();
        let at = |fluid: usize| nodes.iter().map(|&i| self.fraction[fluid][i as usize]).sum::<f64>();
        let sums: Vec<f64> = (0..count).map(at).collect();
        let total: f64 = sums.iter().sum();
        sums.iter().map(|sum| sum / total).collect()
    }
}

impl<const N: usize> Filling<N> {
    /// The cut, if there is one; `viscosity` of each fluid in the element [Pa s].
    pub fn cut(&self, density: &[f64], viscosity: impl Fn(usize) -> f64) -> Option<CutGeometry<N>> {
        let Self::Cut(pair, level) = self else { return None };
        Some(cut_between(*pair, *level, density, viscosity))
    }

    /// Adds what an element holds of each fluid [m³].
    fn add<const D: usize>(&self, region: &FluidRegion<D, N>, element: usize, volumes: &mut [f64]) {
        let volume = region.volume(element);
        match self {
            Self::Pure(fluid) => volumes[*fluid] += volume,
            Self::Mixed(fractions) => {
                volumes.iter_mut().zip(fractions).for_each(|(own, fraction)| *own += fraction * volume)
            }
            Self::Cut([heavy, light], level) => {
                let own = region.negative_volume(element, level);
                volumes[*heavy] += own;
                volumes[*light] += volume - own;
            }
        }
    }

    /// Content of an element; `tau` from the mean medium, `cut_tau` that of cut elements.
    pub fn content(
        &self,
        volume: f64,
        density: &[f64],
        viscosity: impl Fn(usize) -> f64,
        tau: impl Fn(Medium) -> f64,
        cut_tau: impl Fn(Medium) -> f64,
    ) -> Content<N> {
        let uniform = |fraction: &dyn Fn(usize) -> f64| {
            let mean = |f: &dyn Fn(usize) -> f64| (0..density.len()).map(|k| fraction(k) * f(k)).sum::<f64>();
            let medium = Medium { density: mean(&|k| density[k]), viscosity: mean(&viscosity) };
            let mut content = Content::uniform(volume, medium.density, medium.viscosity, tau(medium));
            content.volume_over_density = volume * mean(&|k| 1.0 / density[k]);
            content
        };
        match self {
            Self::Pure(own) => uniform(&|fluid| f64::from(u8::from(*own == fluid))),
            Self::Mixed(fractions) => uniform(&|fluid| fractions[fluid]),
            Self::Cut(pair, level) => cut_between(*pair, *level, density, &viscosity).content(volume, cut_tau),
        }
    }
}

/// The cut between two fluids; `viscosity` of each in the element [Pa s].
fn cut_between<const N: usize>(
    pair: [usize; 2],
    level: [f64; N],
    density: &[f64],
    viscosity: impl Fn(usize) -> f64,
) -> CutGeometry<N> {
    CutGeometry::new(level, pair.map(|fluid| Medium { density: density[fluid], viscosity: viscosity(fluid) }))
}

#[cfg(test)]
mod tests {
    use super::*;

    const DENSITY: [f64; 3] = [1.0, 1000.0, 800.0];

    #[test]
    fn of_two_fluids_the_heavier_is_where_the_level_set_is_negative() {
        let phases = Phases { list: &PhaseList::fluids(&DENSITY[..2]), fraction: &[], level: &[-1.0, 1.0, 0.5, 0.0] };
        assert_eq!(phases.at(0), 1);
        assert_eq!(phases.at(3), 0);
        assert_eq!(phases.filling(&[1, 2, 3]), Filling::Pure(0));
        assert_eq!(phases.filling(&[0, 1, 2]), Filling::Cut([1, 0], [-1.0, 1.0, 0.5]));
        assert_eq!(phases.filling(&[0, 1, 0]), Filling::Cut([1, 0], [-1.0, 1.0, -1.0]));
    }

    #[test]
    fn of_two_equally_heavy_fluids_the_first_is_where_the_level_set_is_negative() {
        let phases = Phases { list: &PhaseList::fluids(&[2.0; 2]), fraction: &[], level: &[-1.0, 1.0, 0.5] };
        assert_eq!([phases.at(0), phases.at(1)], [0, 1]);
        assert_eq!(phases.filling(&[0, 1, 2]), Filling::Cut([0, 1], [-1.0, 1.0, 0.5]));
        assert_eq!(phases.filling(&[2, 0, 1]), Filling::Cut([0, 1], [0.5, -1.0, 1.0]));
    }

    #[test]
    fn three_fluids_meet_in_a_mixture_and_pairs_in_a_cut() {
        let fraction = [vec![0.9, 0.0, 0.0], vec![0.1, 1.0, 0.25], vec![0.0, 0.0, 0.75]];
        let phases = Phases { list: &PhaseList::fluids(&DENSITY), fraction: &fraction, level: &[] };
        let Filling::Mixed(fractions) = phases.filling(&[0, 1, 2]) else { panic!("three fluids are a mixture") };
        assert!((fractions[0] - 0.3).abs() < 1e-15 && (fractions[2] - 0.25).abs() < 1e-15);
        assert_eq!(phases.filling(&[1, 2, 2]), Filling::Cut([1, 2], [-1.0, 0.5, 0.5]));
        let content = phases.filling(&[0, 1, 2]).content(2.0, &DENSITY, |_| 1.0, |_| 1.0, |_| 1.0);
        let mass = 2.0 * (0.3 * 1.0 + 0.45 * 1000.0 + 0.25 * 800.0);
        assert!((content.mass.iter().sum::<f64>() / mass - 1.0).abs() < 1e-14);
    }
}
