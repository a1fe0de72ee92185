//! The system of a step: every row gathers the blocks of the elements around its node, in ascending order
//! (theory F.6, F.15, G.8).
//!
//! No element matrix is stored: a block of [`element::block`] costs about as much as loading it. Rows are made in
//! parallel, each by one thread in a fixed order, so the values have the same bits for any number of threads. The
//! places of an element's nodes in a row are found once, since the mesh is fixed.
//!
//! Rows of rotated nodes are turned into their frames, A_ij ← Q_i A_ij Q_jᵀ; prescribed unknowns are eliminated
//! symmetrically: their columns go to the right-hand side, their rows keep the diagonal alone.

use super::contents::{CutElement, ElementContents};
use super::mesh_data::MeshData;
use super::outflow;
use super::slip;
use super::subscale::Subscales;
use crate::linalg::{BlockMatrix, Pattern};
use crate::math::Vector;
use crate::mesh::Mesh;
use crate::parallel;
use crate::pfem2::boundary::Constraints;
use crate::pfem2::element::{self, Block, Drive, Equations, Stabilisation};
use crate::pfem2::particle_solids::element::SolidElement;
use crate::pfem2::particle_solids::solids::ParticleSolids;
use crate::pfem2::solid::coupling::immersed::Immersed;
use crate::pfem2::solid::cut::ElementState;
use std::sync::Arc;

/// Rows per task.
const ROWS: usize = 256;

/// Everything that the equations of a step consist of.
#[derive(Debug)]
pub struct ElementEquations<'a, const D: usize, const N: usize> {
    /// The mesh.
    pub mesh: &'a Mesh<D, N>,
    /// Constants of the step.
    pub equations: Equations,
    /// Sizes and boundary facets of the elements.
    pub mesh_data: &'a MeshData,
    /// Contents of the elements.
    pub contents: &'a ElementContents<D, N>,
    /// Body force at the nodes [m/s²].
    pub force: &'a [Vector<D>],
    /// Convected velocity v̂ at the nodes [m/s].
    pub convected: &'a [Vector<D>],
    /// Projected parts of the residual at the nodes, for the stabilisation.
    pub subscales: &'a Subscales<D>,
    /// Solids in the mesh.
    pub immersed: Option<&'a Immersed<D, N>>,
    /// Solids on particles.
    pub particle_solids: Option<&'a ParticleSolids<D, N>>,
}

impl<const D: usize, const N: usize> ElementEquations<'_, D, N> {
    /// The drive of an element.
    pub fn drive(&self, element: usize, cut: bool) -> Drive<D, N> {
        let nodes = self.mesh.elements()[element].map(|node| node as usize);
        let projected = match (self.equations.stabilisation, cut) {
            (Stabilisation::Oss, true) => nodes.map(|i| self.subscales.followed[i]),
            (Stabilisation::Oss | Stabilisation::ConsistentPspg | Stabilisation::Dynamic, false) => {
                nodes.map(|i| self.subscales.projected[i])
            }
            // The forces differ from side to side of an interface.
            (Stabilisation::ConsistentPspg | Stabilisation::Dynamic, true) | (Stabilisation::Pspg, _) => {
                [Vector::ZERO; N]
            }
        };
        let inertia = self.equations.stabilisation.subscale_inertia() * self.equations.delta;
        let hat = self.subscales.dynamic.convected.get(element).filter(|_| !cut);
        let subscale = hat.map_or(Vector::ZERO, |&hat| hat / inertia);
        Drive { force: nodes.map(|i| self.force[i]), convected: nodes.map(|i| self.convected[i]), projected, subscale }
    }

    /// The state of an element, and its equations if a solid cuts it.
    #[inline]
    pub fn beside_solid(&self, element: usize) -> Option<(&Immersed<D, N>, ElementState)> {
        let immersed = self.immersed?;
        let state = immersed.cut.state[element];
        (state != ElementState::Fluid).then_some((immersed, state))
    }

    /// The equations of an element that holds a solid on particles.
    #[inline]
    pub fn with_solid(&self, element: usize) -> Option<&SolidElement<D, N>> {
        self.particle_solids?.of(element)
    }

    /// The block of an element's local nodes `i` and `j`, condensed.
    #[inline]
    fn block(&self, element: usize, cut: Option<&CutElement<D, N>>, (i, j): (usize, usize)) -> Block<N> {
        if let Some(own) = self.with_solid(element) {
            return own.blocks[i][j];
        }
        if let Some((immersed, state)) = self.beside_solid(element) {
            return match state {
                ElementState::Cut(place) => immersed.elements[place as usize].blocks[i][j],
                _ => [[0.0; N]; N],
            };
        }
        let (simplex, content) = (self.mesh.simplex(element), &self.contents.elements[element]);
        let mut block = element::block(simplex, content, &self.equations, (i, j));
        if self.mesh_data.outlets[element] != 0 {
            outflow::release(&mut block, simplex, content.viscosity, self.mesh_data.outlets[element], (i, j));
            let back = if i == j { self.back(element, i) } else { 0.0 };
            (0..D).for_each(|r| block[r][r] += back);
        }
        if let Some(cut) = cut {
            add(&mut block, &cut.enriched.block(i, j));
            (0..D).for_each(|r| block[r][r] += cut.inertia[i][j] / self.equations.delta);
        }
        block
    }

    /// Inertial resistance at a local node to inflow through open facets of its element [kg/s] (see `outflow`).
    pub fn back(&self, element: usize, i: usize) -> f64 {
        let simplex = self.mesh.simplex(element);
        let density = self.contents.elements[element].mass.iter().sum::<f64>() / simplex.volume;
        let convected = self.convected[self.mesh.elements()[element][i] as usize];
        outflow::back(simplex, density, self.mesh_data.outlets[element], convected, i)
    }

    /// The right-hand side of an element's local node `i`, condensed.
    fn load(&self, element: usize, cut: Option<&CutElement<D, N>>, i: usize) -> [f64; N] {
        if let Some(own) = self.with_solid(element) {
            return own.loads[i];
        }
        if let Some((immersed, state)) = self.beside_solid(element) {
            return match state {
                ElementState::Cut(place) => immersed.elements[place as usize].loads[i],
                _ => [0.0; N],
            };
        }
        let (simplex, content) = (self.mesh.simplex(element), &self.contents.elements[element]);
        let drive = self.drive(element, cut.is_some());
        let source = cut.map_or_else(|| drive.source(&self.equations), |cut| cut.source);
        let mut load = element::load(simplex, content, &self.equations, &drive, source, i);
        if let Some(cut) = cut {
            let carried = (0..N).map(|j| drive.convected[j] * cut.inertia[i][j]).sum::<Vector<D>>();
            (0..D).for_each(|r| load[r] += carried[r] / self.equations.delta);
            let condensed = cut.enriched.load(i);
            (0..N).for_each(|r| load[r] += condensed[r]);
            (0..D).for_each(|r| load[r] += cut.tension[i][r]);
        }
        load
    }

    /// The block of the equations: what a slip wall takes up doesn't push the fluid along it.
    #[inline]
    fn equation(&self, element: usize, cut: Option<&CutElement<D, N>>, (i, j): (usize, usize)) -> Block<N> {
        let mut block = self.block(element, cut, (i, j));
        if self.mesh_data.slip[element] != 0
            && self.beside_solid(element).is_none()
            && self.with_solid(element).is_none()
        {
            slip::press(&mut block, self.mesh.simplex(element), self.mesh_data.slip[element], (i, j));
            cut.iter().for_each(|cut| add(&mut block, &cut.enriched.wall_block(i, j)));
        }
        block
    }

    /// Force of the elements on their node `i` [N] when the nodal unknowns are `x`: load − matrix · x. The rows of
    /// free nodes vanish; those of prescribed ones are minus the reaction of the support, and slip nodes pass on the
    /// pressure of their facets, too.
    pub fn nodal_force(&self, i: usize, x: impl Fn(usize) -> [f64; N]) -> Vector<D> {
        let mut force = Vector::ZERO;
        for &e in self.mesh.elements_around(i) {
            let element = e as usize;
            let nodes = &self.mesh.elements()[element];
            let Some(own) = nodes.iter().position(|&node| node as usize == i) else { continue };
            let cut = self.contents.cut(element);
            let load = self.load(element, cut, own);
            (0..D).for_each(|r| force[r] += load[r]);
            if let Some((immersed, ElementState::Cut(place))) = self.beside_solid(element) {
                let of_solids = immersed.elements[place as usize].from_solid(own, &immersed.velocity);
                (0..D).for_each(|r| force[r] -= of_solids[r]);
            }
            for (j, &node) in nodes.iter().enumerate() {
                let (block, x) = (self.block(element, cut, (own, j)), x(node as usize));
                for r in 0..D {
                    force[r] -= (0..N).map(|s| block[r][s] * x[s]).sum::<f64>();
                }
            }
        }
        force
    }
}

fn add<const N: usize>(a: &mut Block<N>, b: &Block<N>) {
    for r in 0..N {
        for s in 0..N {
            a[r][s] += b[r][s];
        }
    }
}

/// The fixed part of the assembly: pattern and places.
#[derive(Debug)]
pub struct Assembly<const N: usize> {
    pattern: Arc<Pattern>,
    /// Elements around node i have their places at `start[i]..start[i + 1]`.
    start: Vec<u32>,
    /// Places of an element's nodes in the row.
    places: Vec<[u16; N]>,
}

impl<const N: usize> Assembly<N> {
    /// The assembly for a mesh.
    pub fn new<const D: usize>(mesh: &Mesh<D, N>) -> Self {
        let nodes = mesh.nodes().len();
        let pattern = Pattern::new(nodes, mesh.elements());
        let mut start = vec![0u32; nodes + 1];
        (0..nodes).for_each(|i| start[i + 1] = start[i] + mesh.elements_around(i).len() as u32);
        let places_of = |i: usize| {
            let row = &pattern.columns()[pattern.row(i)];
            let place = move |node: u32| row.binary_search(&node).unwrap_or(0) as u16;
            mesh.elements_around(i).iter().map(move |&e| mesh.elements()[e as usize].map(place))
        };
        let places = (0..nodes).flat_map(places_of).collect();
        Self { pattern: Arc::new(pattern), start, places }
    }

    /// The pattern.
    pub fn pattern(&self) -> Arc<Pattern> {
        self.pattern.clone()
    }

    /// Fills the matrix and the right-hand side, which already holds the loads of the boundary.
    pub fn assemble<const D: usize>(
        &self,
        elements: &ElementEquations<D, N>,
        constraints: &Constraints<D, N>,
        matrix: &mut BlockMatrix<N>,
        rhs: &mut [[f64; N]],
    ) {
        let count = rhs.len();
        let entries = |first: usize| {
            let last = (first + ROWS).min(count) - 1;
            self.pattern.row(first).start..self.pattern.row(last).end
        };
        let values = parallel::parts_mut(&mut matrix.values, (0..count).step_by(ROWS).map(entries));
        let parts = (0..count).step_by(ROWS).zip(values.into_iter().zip(rhs.chunks_mut(ROWS)));
        parallel::map_parts(parts, |(first, (mut values, rhs))| {
            for (i, f) in (first..).zip(rhs) {
                let (row, after) = values.split_at_mut(self.pattern.row(i).len());
                values = after;
                self.gather(elements, i, row, f);
                constrain(constraints, self.columns(i), i, row, f);
            }
        });
    }

    /// Columns of a row.
    fn columns(&self, i: usize) -> &[u32] {
        &self.pattern.columns()[self.pattern.row(i)]
    }

    /// One row: the sum over the elements around its node.
    fn gather<const D: usize>(
        &self,
        elements: &ElementEquations<D, N>,
        i: usize,
        row: &mut [Block<N>],
        f: &mut [f64; N],
    ) {
        row.fill([[0.0; N]; N]);
        let places = &self.places[self.start[i] as usize..self.start[i + 1] as usize];
        let diagonal = (self.pattern.diagonal(i) - self.pattern.row(i).start) as u16;
        for (&e, places) in elements.mesh.elements_around(i).iter().zip(places) {
            let element = e as usize;
            let Some(own) = places.iter().position(|&place| place == diagonal) else { continue };
            let cut = elements.contents.cut(element);
            let load = elements.load(element, cut, own);
            (0..N).for_each(|r| f[r] += load[r]);
            if let Some(cut) = cut {
                let taken = cut.enriched.wall_load(own);
                (0..N).for_each(|r| f[r] += taken[r]);
            }
            for (j, &place) in places.iter().enumerate() {
                add(&mut row[place as usize], &elements.equation(element, cut, (own, j)));
            }
        }
    }
}

/// Turns a row into the frames of its nodes and eliminates what is prescribed.
fn constrain<const D: usize, const N: usize>(
    constraints: &Constraints<D, N>,
    columns: &[u32],
    i: usize,
    row: &mut [Block<N>],
    f: &mut [f64; N],
) {
    if let Some(frame) = constraints.frame(i) {
        let turned = frame.apply(Vector::from_fn(|r| f[r]));
        f[..D].copy_from_slice(&turned.0);
    }
    let own = constraints.mask[i];
    for (block, &column) in row.iter_mut().zip(columns) {
        let j = column as usize;
        turn(constraints, (i, j), block);
        let kept = std::array::from_fn::<f64, N, _>(|r| block[r][r]);
        for s in (0..N).filter(|s| constraints.mask[j] >> s & 1 == 1) {
            let value = constraints.value[j][s];
            for r in 0..N {
                f[r] -= block[r][s] * value;
                block[r][s] = 0.0;
            }
        }
        for r in (0..N).filter(|r| own >> r & 1 == 1) {
            block[r] = [0.0; N];
            if i == j {
                // The diagonal keeps its size and has the sign that the solver expects.
                let size = if kept[r] == 0.0 { 1.0 } else { kept[r].abs() };
                block[r][r] = if r < D { size } else { -size };
            }
        }
    }
    if own != 0 {
        let place = columns.binary_search(&(i as u32)).unwrap_or(0);
        for r in (0..N).filter(|r| own >> r & 1 == 1) {
            f[r] = row[place][r][r] * constraints.value[i][r];
        }
    }
}

/// Q_i A Q_jᵀ.
fn turn<const D: usize, const N: usize>(constraints: &Constraints<D, N>, (i, j): (usize, usize), block: &mut Block<N>) {
    if let Some(frame) = constraints.frame(i) {
        for s in 0..N {
            let column = frame.apply(Vector::<D>::from_fn(|r| block[r][s]));
            (0..D).for_each(|r| block[r][s] = column[r]);
        }
    }
    if let Some(frame) = constraints.frame(j) {
        for values in block.iter_mut() {
            let turned = frame.apply(Vector::<D>::from_fn(|s| values[s]));
            values[..D].copy_from_slice(&turned.0);
        }
    }
}
