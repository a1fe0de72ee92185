//! The forces of all elements, with the tangents about the prediction of a step (theory (J.5), (J.5a)).

use super::deformation::{ElementFault, SolidLaw};
use super::element::last_stress;
use super::tangent::{ElementForces, LastStress};
use super::{Prediction, Structure};
use crate::error::StepError;
use crate::math::Vector;
use crate::parallel;
use crate::pfem2::solid::setup::Inertia;

/// Elements whose forces are held in memory at a time.
const BATCH: usize = 64;

impl<const D: usize> Structure<D> {
    /// Calls `work` with the solid, the nodes and the forces of every element at a displacement [m], in order.
    ///
    /// # Errors
    /// As [`Structure::equations`].
    pub(in crate::pfem2::solid) fn visit(
        &self,
        displacement: &[Vector<D>],
        work: impl FnMut(usize, &[u32], &ElementForces<D>),
    ) -> Result<(), StepError> {
        self.visit_with(displacement, |_, _, _| Ok(None), work)
    }

    /// Visits the elements, as [`Structure::visit`], at the prediction of a step. The geometric part of the tangent,
    /// and the pressure that stands beside it in the other part, are those of the stress that the last linear equations
    /// had at their end, those of the last step or of the last solution of this one
    /// (theory (J.5a)): a prediction along tangents strains a solid that turns, and the stress of that would hold back,
    /// or drive, its turn by more than its inertia where it is stiff. Solids without inertia take the prediction's in
    /// the first solution of a step.
    ///
    /// # Errors
    /// As [`Structure::equations`].
    pub(in crate::pfem2::solid) fn visit_step(
        &self,
        prediction: &Prediction<D>,
        work: impl FnMut(usize, &[u32], &ElementForces<D>),
    ) -> Result<(), StepError> {
        let (displacement, correction) = match &prediction.found {
            Some(correction) => (&prediction.displacement, correction),
            None => (&self.state.displacement, &self.state.correction),
        };
        let last = |solid: usize, element: usize, law: SolidLaw<'_>| {
            if prediction.found.is_none() && self.setups[solid].inertia != Inertia::Dynamic {
                return Ok(None);
            }
            let columns = [&self.nodes[..], displacement, correction];
            let (_, [places, u, correction]) = self.gather(solid, element, columns);
            last_stress(&self.points, law, &places, [&u, &correction]).map(Some)
        };
        self.visit_with(&prediction.displacement, last, work)
    }

    /// Visits the elements, as [`Structure::visit`], with a `last` stress in the tangent of each element, by the solid,
    /// its number and the law.
    fn visit_with(
        &self,
        displacement: &[Vector<D>],
        last: impl Fn(usize, usize, SolidLaw<'_>) -> Result<Option<LastStress>, ElementFault<D>> + Sync,
        mut work: impl FnMut(usize, &[u32], &ElementForces<D>),
    ) -> Result<(), StepError> {
        let of = |solid: usize, element: usize, law: SolidLaw<'_>| {
            let (_, [places, own]) = self.gather(solid, element, [&self.nodes, displacement]);
            let last = last(solid, element, law)?;
            ElementForces::with_last_stress(&self.points, law, [&places, &own], last)
        };
        self.visit_elements(self.elastic(), of, |solid, nodes, forces| work(solid, nodes, &forces))
    }

    /// Calls `work` with the solid, the nodes and what `of` finds of every element of some solids, by the solid, its
    /// number and the law; in order.
    ///
    /// # Errors
    /// As [`Structure::equations`].
    pub(super) fn visit_elements<T: Send>(
        &self,
        solids: impl Iterator<Item = usize>,
        of: impl Fn(usize, usize, SolidLaw<'_>) -> Result<T, ElementFault<D>> + Sync,
        mut work: impl FnMut(usize, &[u32], T),
    ) -> Result<(), StepError> {
        for solid in solids {
            let law = self.law(solid)?;
            for begin in (0..self.setups[solid].mesh.elements.len()).step_by(BATCH) {
                let count = BATCH.min(self.setups[solid].mesh.elements.len() - begin);
                let all = parallel::collect(count, 1, |k| of(solid, begin + k, law));
                for (k, found) in all.into_iter().enumerate() {
                    let found = found.map_err(|fault| self.error(solid, begin + k, fault))?;
                    let (nodes, []) = self.gather(solid, begin + k, []);
                    work(solid, &nodes, found);
                }
            }
        }
        Ok(())
    }

    /// The nodes of an element, and its entries of nodal columns.
    pub(in crate::pfem2::solid) fn gather<const K: usize>(
        &self,
        solid: usize,
        element: usize,
        columns: [&[Vector<D>]; K],
    ) -> (Vec<u32>, [Vec<Vector<D>>; K]) {
        let own = &self.setups[solid].mesh.elements[element];
        let nodes: Vec<u32> = own.iter().map(|node| node + self.first[solid]).collect();
        let entries = columns.map(|column| nodes.iter().map(|&node| column[node as usize]).collect());
        (nodes, entries)
    }
}
