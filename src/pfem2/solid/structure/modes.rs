//! Natural modes of solids without a fluid: K x = ω² M x in the reference state (theory J.15).

use super::Structure;
use crate::linalg::{MatrixEntry, Mode, SparseMatrix, lowest_modes};
use crate::math::{Tensor, Vector};
use crate::parallel;
use crate::pfem2::solid::equations::independent::IndependentVelocities;
use crate::pfem2::solid::equations::{IndependentInertia, LinearForces, SolidEquations};
use std::f64::consts::TAU;

/// Unknowns of solids that hang together, up to which modes are found in little time.
const UNKNOWNS: usize = 40_000;

/// ω² over that of the highest of the modes that were found below which a motion is a free one.
const FREE: f64 = 1e-6;

/// A mode of the solids.
#[derive(Debug, Clone, PartialEq)]
pub struct NaturalMode<const D: usize> {
    /// The solid that has most of its kinetic energy.
    pub solid: usize,
    /// Period of the mode [s]; infinite for a motion without stiffness.
    pub period: f64,
    /// φ at the nodes of all solids, φ·M φ = 1 [kg^−½].
    pub shape: Vec<Vector<D>>,
}

/// The modes of all solids.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct NaturalModes<const D: usize> {
    /// The modes, the slowest first.
    pub found: Vec<NaturalMode<D>>,
    /// Solids with too many unknowns for it, and their number.
    pub too_large: Vec<(usize, usize)>,
}

/// Solids that share independent velocities, as they are tied together.
struct TiedSolids {
    solids: Vec<usize>,
    /// Their independent velocities, ascending.
    unknowns: Vec<u32>,
}

impl<const D: usize> Structure<D> {
    /// The slowest modes of elastic solids, `count` of each one and of those that are tied together, without a fluid
    /// and with rigid solids at rest; none where an element is folded.
    pub fn natural_modes(&self, count: usize) -> NaturalModes<D> {
        let velocities = self.independent_at_rest();
        let mut modes = NaturalModes::default();
        let (small, large): (Vec<TiedSolids>, Vec<TiedSolids>) =
            self.tied_solids(&velocities).into_iter().partition(|tied| tied.unknowns.len() <= UNKNOWNS);
        let too_large = |tied: TiedSolids| tied.solids.into_iter().map(move |solid| (solid, tied.unknowns.len()));
        modes.too_large = large.into_iter().flat_map(too_large).collect();
        if small.is_empty() {
            return modes;
        }
        let Some(stiffness) = self.reference_stiffness() else { return modes };
        let reduced = |matrix: SparseMatrix, linear: LinearForces| {
            let rhs = vec![0.0; matrix.rows()];
            let (inertia, velocities) = (IndependentInertia::default(), velocities.clone());
            let volume_slopes = Vec::new();
            SolidEquations { matrix, rhs: rhs.clone(), linear, inertia, velocities, volume_slopes }
                .independent(&[], &rhs)
                .0
        };
        let mut springs = LinearForces::default();
        let rest = vec![Vector::ZERO; self.node_count()];
        self.springs.visit(&rest, |k, stiffness, _| springs.entries.push(MatrixEntry::new(k, k, stiffness)));
        let (stiffness, mass) =
            (reduced(stiffness, springs), reduced(self.nodal_mass_matrix(), LinearForces::default()));
        for tied in small {
            let [stiffness, mass] = [&stiffness, &mass].map(|matrix| matrix.of(&tied.unknowns));
            let own = lowest_modes(&stiffness, &mass, count).unwrap_or_default();
            modes.found.extend(self.modes_by_node(&own, &tied.unknowns, &velocities));
        }
        modes.found.sort_by(|a, b| b.period.total_cmp(&a.period));
        modes
    }

    /// Modes by the velocities of nodes, from those by some independent velocities.
    fn modes_by_node(
        &self,
        modes: &[Mode],
        unknowns: &[u32],
        velocities: &IndependentVelocities,
    ) -> Vec<NaturalMode<D>> {
        let highest = modes.last().map_or(0.0, |mode| mode.eigenvalue);
        let period =
            |eigenvalue: f64| if eigenvalue > FREE * highest { TAU / eigenvalue.sqrt() } else { f64::INFINITY };
        let mode = |mode: &Mode| {
            let mut independent = vec![0.0; velocities.count()];
            unknowns.iter().zip(&mode.vector).for_each(|(&w, x)| independent[w as usize] = *x);
            let shape = by_node(&velocities.added(&independent));
            NaturalMode { solid: self.most_moved(&shape), period: period(mode.eigenvalue), shape }
        };
        modes.iter().map(mode).collect()
    }

    /// The elastic solids, each with those that it is tied to.
    fn tied_solids(&self, velocities: &IndependentVelocities) -> Vec<TiedSolids> {
        let mut all: Vec<TiedSolids> = Vec::new();
        for (solid, (mesh, first)) in self.meshes().into_iter().enumerate() {
            let nodal = first as usize * D..(first as usize + mesh.nodes.len()) * D;
            let mut unknowns: Vec<u32> = nodal.flat_map(|k| velocities.row(k).map(|(w, _)| w)).collect();
            unknowns.sort_unstable();
            unknowns.dedup();
            let mut own = TiedSolids { solids: vec![solid], unknowns };
            let is_tied = |other: &TiedSolids| own.unknowns.iter().any(|w| other.unknowns.binary_search(w).is_ok());
            let (tied, apart): (Vec<TiedSolids>, Vec<TiedSolids>) = all.into_iter().partition(is_tied);
            for other in tied {
                own.solids.extend(other.solids);
                own.unknowns.extend(other.unknowns);
            }
            own.unknowns.sort_unstable();
            own.unknowns.dedup();
            all = apart;
            all.push(own);
        }
        all.retain(|tied| !tied.unknowns.is_empty());
        all
    }

    /// K in the reference state; `None` where an element is folded.
    fn reference_stiffness(&self) -> Option<SparseMatrix> {
        let mut matrix = self.zero_matrix();
        let rest = vec![Vector::ZERO; self.node_count()];
        let added = self.visit(&rest, |_, nodes, forces| {
            for (a, &row) in nodes.iter().enumerate() {
                for (b, &column) in nodes.iter().enumerate() {
                    self.add_block(&mut matrix, (row, column), &forces.tangent(a, b));
                }
            }
        });
        added.ok().map(|()| matrix)
    }

    /// M of all unknowns of the nodes.
    fn nodal_mass_matrix(&self) -> SparseMatrix {
        let mut matrix = self.zero_matrix();
        for MatrixEntry { row, column, value: mass } in self.mass.triplets() {
            self.add_block(&mut matrix, (row, column), &(Tensor::identity() * mass));
        }
        matrix
    }

    /// The solid with most of the kinetic energy at these nodal velocities.
    fn most_moved(&self, velocity: &[Vector<D>]) -> usize {
        let momentum = self.weighted_by_mass(velocity);
        let (momentum, _) = momentum.as_chunks::<D>();
        let of_solid = |solid: usize| {
            let nodes = self.nodes_of(solid);
            parallel::sum(nodes.len(), |n| Vector(momentum[nodes.start + n]).dot(velocity[nodes.start + n]))
        };
        let energies: Vec<f64> = (0..self.setups().len()).map(of_solid).collect();
        (0..energies.len()).max_by(|&a, &b| energies[a].total_cmp(&energies[b]).then(b.cmp(&a))).unwrap_or(0)
    }
}

/// Values of unknowns as vectors of the nodes.
pub(super) fn by_node<const D: usize>(unknowns: &[f64]) -> Vec<Vector<D>> {
    unknowns.chunks_exact(D).map(|own| Vector::from_fn(|axis| own[axis])).collect()
}

#[cfg(test)]
mod tests {
    use crate::math::Vector;
    use crate::pfem2::solid::mesh::SolidMesh;
    use crate::pfem2::solid::structure::Structure;
    use crate::pfem2::solid::structure::tests::solid;
    use std::f64::consts::{PI, TAU};

    /// A bar with ν = 0 that slides between walls: ω = (2 k − 1) π c/(2 l); one that is free moves without stiffness
    /// first.
    #[test]
    fn a_bar_has_its_periods() {
        let (length, young, density) = (2.0, 3e6, 1200.0);
        let mesh = || SolidMesh::block(Vector::ZERO, Vector([length, 0.1]), [24, 1]).unwrap();
        let mut bar = solid(mesh(), [density, young, 0.0], |x| x[0] == 0.0);
        let nodes = (0..bar.mesh.nodes.len() as u32).collect();
        let guide = crate::pfem2::solid::setup::HeldNodes { nodes, velocity: [None, Some(crate::math::Signal::ZERO)] };
        bar.held.push(guide.clone());
        let speed = (young / density).sqrt();
        let found = Structure::new(vec![bar]).unwrap().natural_modes(3).found;
        for (k, mode) in found.iter().enumerate() {
            let exact = TAU / ((2 * k + 1) as f64 * PI * speed / (2.0 * length));
            assert!((mode.period / exact - 1.0).abs() < 1e-4, "{k}: {} {exact}", mode.period);
        }
        let mut free = solid(mesh(), [density, young, 0.0], |_| false);
        free.held = vec![guide];
        let found = Structure::new(vec![free]).unwrap().natural_modes(2).found;
        assert!(
            found[0].period.is_infinite() && (found[1].period * speed / (2.0 * length) - 1.0).abs() < 1e-4,
            "{found:?}"
        );
    }

    /// Two bars that slide between walls, one free and four thousand times as stiff as the other: each has as many modes
    /// as are asked for, whatever the other has.
    #[test]
    fn each_solid_has_its_own_modes() {
        let (length, density) = (2.0, 1200.0);
        let bar = |x0: f64, young: f64, held: bool| {
            let mesh = SolidMesh::block(Vector([x0, 0.0]), Vector([x0 + length, 0.1]), [24, 1]).unwrap();
            let mut bar = solid(mesh, [density, young, 0.0], |x| held && x[0] == x0);
            let nodes = (0..bar.mesh.nodes.len() as u32).collect();
            let velocity = [None, Some(crate::math::Signal::ZERO)];
            bar.held.push(crate::pfem2::solid::setup::HeldNodes { nodes, velocity });
            bar
        };
        let modes = Structure::new(vec![bar(0.0, 3e6, true), bar(5.0, 1.2e10, false)]).unwrap().natural_modes(3);
        let of = |solid: usize| -> Vec<f64> {
            modes.found.iter().filter(|mode| mode.solid == solid).map(|mode| mode.period).collect()
        };
        let exact = |young: f64, parts: f64| 4.0 * length / (parts * f64::sqrt(young / density));
        for (period, parts) in of(0).iter().zip([1.0, 3.0, 5.0]) {
            assert!((period / exact(3e6, parts) - 1.0).abs() < 1e-4, "{period}");
        }
        let stiff = of(1);
        assert_eq!((of(0).len(), stiff.len()), (3, 3));
        assert!(stiff[0].is_infinite() && (stiff[1] / exact(1.2e10, 2.0) - 1.0).abs() < 1e-4, "{stiff:?}");
    }
}
