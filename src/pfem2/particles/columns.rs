//! Particles of PFEM-2: columns sorted by element.
//!
//! Particles carry velocity and fluid, no mass: a particle stands for V_e/n_e, its part of the element that it is
//! in (theory F.3). Those of an element follow one another; a stable counting sort ([`Groups`]) restores this after
//! every motion.

use crate::math::Vector;
use crate::mesh::Mesh;
use crate::parallel::{self, Groups};
use crate::simulation::Column;
use std::ops::Range;

/// The columns of particles, one entry each: its type, the memory that it is sorted into, and what two particles that
/// merge leave in it: their mean, or the value of the one that is kept.
macro_rules! particle_columns {
    ($($(#[$doc:meta])* $name:ident: $type:ty, sorted in $spare:ident, merged to $merge:ident;)*) => {
        /// Columns of particles; the same index in every column is the same particle.
        #[derive(Debug, Clone, Default)]
        pub struct Particles<const D: usize> {
            $($(#[$doc])* pub $name: Vec<$type>,)*
            /// Columns that a law or a phase asks for.
            optional: Vec<OptionalColumn>,
            /// Particles by element.
            pub(super) by_element: Groups,
            /// Memory for the sort, kept because fresh pages cost more than the sort itself.
            spare: Spare<D>,
        }

        impl<const D: usize> Particles<D> {
            /// Appends a particle of zeros.
            fn push_zeros(&mut self) {
                $(self.$name.push(Default::default());)*
                self.optional.iter_mut().for_each(OptionalColumn::push_zeros);
            }

            /// Brings all columns into a new order.
            fn reorder(&mut self, order: &[u32], spare: &mut Spare<D>) {
                $(gather(order, &mut self.$name, &mut spare.$spare);)*
                self.optional.iter_mut().for_each(|column| column.reorder(order, &mut spare.floats));
            }

            /// Makes one particle, `keep`, of two. [`Particles::sort`] has to follow, which drops the other.
            pub(super) fn merge(&mut self, keep: usize, drop: usize) {
                $($merge(&mut self.$name, keep, drop);)*
                self.optional.iter_mut().for_each(|column| column.merge(keep, drop));
                self.element[drop] = GONE;
            }

            /// Shows all columns to a checkpoint.
            pub(in crate::pfem2) fn visit_columns(&mut self, visit: &mut dyn FnMut(&str, Column<'_>)) {
                $(visit(concat!("particles/", stringify!($name)), Column::growing(&mut self.$name));)*
                for column in &mut self.optional {
                    let components = column.components;
                    let lent = Column { components, ..Column::growing(&mut column.values) };
                    visit(&format!("particles/{}", column.name), lent);
                }
            }

            /// True if all columns hold as many particles.
            pub(in crate::pfem2) fn is_consistent(&self) -> bool {
                let count = self.position.len();
                let optional = |column: &OptionalColumn| column.values.len() == count * column.components;
                [$(self.$name.len()),*].iter().all(|&other| other == count) && self.optional.iter().all(optional)
            }
        }
    };
}

particle_columns! {
    /// Position x_p [m].
    position: Vector<D>, sorted in vectors, merged to mean;
    /// Velocity v_p [m/s].
    velocity: Vector<D>, sorted in vectors, merged to mean;
    /// Its phase: the number of its fluid, or, after all fluids, of its solid on particles.
    phase: u8, sorted in bytes, merged to kept;
    /// Depth below the surface of its fluid [m]; only where the level set is sharp.
    depth: f64, sorted in floats, merged to mean;
    /// The element that holds the particle; ascending after [`Particles::sort`].
    element: u32, sorted in elements, merged to kept;
}

/// Two particles that merge leave the mean of their values.
fn mean<T>(column: &mut [T], keep: usize, drop: usize)
where
    T: Copy + std::ops::Add<Output = T> + std::ops::Mul<f64, Output = T>,
{
    column[keep] = (column[keep] + column[drop]) * 0.5;
}

/// Two particles that merge leave the value of the one that is kept.
fn kept<T>(_: &mut [T], _: usize, _: usize) {}

/// A column of some numbers per particle, as a law needs it for its history.
#[derive(Debug, Clone)]
struct OptionalColumn {
    name: &'static str,
    components: usize,
    /// The numbers, particle after particle.
    values: Vec<f64>,
}

impl OptionalColumn {
    fn push_zeros(&mut self) {
        self.values.resize(self.values.len() + self.components, 0.0);
    }

    fn reorder(&mut self, order: &[u32], spare: &mut Vec<f64>) {
        let (values, count) = (&self.values, self.components);
        spare.resize(order.len() * count, 0.0);
        parallel::fill(spare, parallel::CHUNK, |i| values[order[i / count] as usize * count + i % count]);
        std::mem::swap(&mut self.values, spare);
    }

    fn merge(&mut self, keep: usize, drop: usize) {
        for component in 0..self.components {
            let [keep, drop] = [keep, drop].map(|p| p * self.components + component);
            mean(&mut self.values, keep, drop);
        }
    }
}

/// Columns to sort into.
#[derive(Debug, Clone, Default)]
struct Spare<const D: usize> {
    vectors: Vec<Vector<D>>,
    bytes: Vec<u8>,
    floats: Vec<f64>,
    elements: Vec<u32>,
}

/// The element of a particle that is to be dropped by the next sort.
pub const GONE: u32 = Groups::NONE;

impl<const D: usize> Particles<D> {
    /// Seeds every element with the points of a lattice, [`lattice`].
    ///
    /// The lattice is the same after every exchange of nodes, so that elements that mirror each other hold
    /// particles that do; noise would be a difference between them, which an unstable flow multiplies.
    ///
    /// `fluid_at` gives the fluid at a place [m], or none where no particle shall be; `velocity_at` the velocity [m/s].
    pub fn seed<const N: usize>(
        mesh: &Mesh<D, N>,
        per_edge: usize,
        fluid_at: impl Fn(Vector<D>) -> Option<u8> + Sync,
        velocity_at: impl Fn(Vector<D>) -> Vector<D> + Sync,
    ) -> Self {
        let lattice = lattice::<N>(per_edge);
        let filled = |e: usize| {
            let corners = mesh.corners(e);
            let points = lattice.iter().map(|shape| interpolate(shape, &corners));
            points.filter_map(|x| fluid_at(x).map(|fluid| (x, fluid))).collect::<Vec<_>>()
        };
        let seeded = parallel::collect(mesh.elements().len(), 64, filled);
        let mut particles = Self { by_element: Groups::new(mesh.elements().len()), ..Self::default() };
        for (element, points) in (0u32..).zip(seeded) {
            for (x, fluid) in points {
                particles.push(x, velocity_at(x), fluid, element);
            }
        }
        particles.sort();
        particles
    }

    /// Adds a column of `components` numbers per particle that a law or a phase asks for, filled with zeros; it is
    /// sorted, merged and part of a checkpoint as the others are.
    pub fn add_column(&mut self, name: &'static str, components: usize) {
        let values = vec![0.0; self.len() * components];
        self.optional.push(OptionalColumn { name, components, values });
    }

    /// The numbers of a column that [`Particles::add_column`] added, particle after particle.
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        self.optional.iter().find(|column| column.name == name).map(|column| &column.values[..])
    }

    /// Calls `change` with the numbers of a column that [`Particles::add_column`] added, and the particles without it.
    pub fn change_column(&mut self, name: &str, change: impl FnOnce(&mut [f64], &Self)) {
        let Some(place) = self.optional.iter().position(|column| column.name == name) else { return };
        let mut values = std::mem::take(&mut self.optional[place].values);
        change(&mut values, self);
        self.optional[place].values = values;
    }

    /// Number of particles.
    pub fn len(&self) -> usize {
        self.position.len()
    }

    /// True if there are none.
    pub fn is_empty(&self) -> bool {
        self.position.is_empty()
    }

    /// The particles of an element.
    pub fn of(&self, element: usize) -> Range<usize> {
        self.by_element.range(element)
    }

    /// Appends a particle. [`Particles::sort`] has to follow.
    pub fn push(&mut self, position: Vector<D>, velocity: Vector<D>, phase: u8, element: u32) {
        let p = self.position.len();
        self.push_zeros();
        (self.position[p], self.velocity[p]) = (position, velocity);
        (self.phase[p], self.element[p]) = (phase, element);
    }

    /// Sorts by element and drops the particles whose element is [`GONE`]; those of one element keep their order.
    pub fn sort(&mut self) {
        self.group_by_element();
        let (by_element, mut spare) = (std::mem::take(&mut self.by_element), std::mem::take(&mut self.spare));
        self.reorder(by_element.entries(), &mut spare);
        (self.by_element, self.spare) = (by_element, spare);
    }

    /// Groups the particles by element and leaves them where they are; [`Particles::sort`] has to follow.
    pub(super) fn group_by_element(&mut self) {
        self.by_element.sort(&self.element);
    }
}

/// Brings a column into a new order, through another one that takes its place.
fn gather<T: Copy + Send + Sync + Default>(order: &[u32], column: &mut Vec<T>, spare: &mut Vec<T>) {
    parallel::map_into(order, spare, |&from| column[from as usize]);
    std::mem::swap(column, spare);
}

/// Lattice points in a simplex, as shape functions: N = (i + 1/(D+1))/(m+1) for all i_0 + … + i_D = m, with
/// m + 1 = `per_edge` points along an edge: 15 for 5 in 2D, 20 for 4 in 3D (theory (F.11)).
pub fn lattice<const N: usize>(per_edge: usize) -> Vec<[f64; N]> {
    let mut points = Vec::new();
    let mut index = [0usize; N];
    let sum = per_edge.saturating_sub(1);
    let count = per_edge.pow(N as u32 - 1);
    for mut n in 0..count {
        for i in index.iter_mut().take(N - 1) {
            *i = n % per_edge;
            n /= per_edge;
        }
        let Some(last) = sum.checked_sub(index[..N - 1].iter().sum()) else { continue };
        index[N - 1] = last;
        points.push(index.map(|i| (i as f64 + 1.0 / N as f64) / per_edge as f64));
    }
    points
}

/// Σ N_k f_k.
#[inline(always)]
pub(in crate::pfem2) fn interpolate<const D: usize, const N: usize>(
    shape: &[f64; N],
    values: &[Vector<D>; N],
) -> Vector<D> {
    let mut sum = values[0] * shape[0];
    for k in 1..N {
        sum += values[k] * shape[k];
    }
    sum
}

/// Σ N_k f_k at a point of an element, from the values of all nodes.
#[inline(always)]
pub(in crate::pfem2) fn interpolate_nodal<const D: usize, const N: usize>(
    shape: &[f64; N],
    nodes: &[u32; N],
    values: &[Vector<D>],
) -> Vector<D> {
    interpolate(shape, &nodes.map(|node| values[node as usize]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(cells: usize) -> Mesh<2, 3> {
        Mesh::block(Vector::ZERO, Vector::splat(1.0), [cells; 2]).unwrap()
    }

    #[test]
    fn lattices_have_the_centroid_of_the_simplex_as_their_mean() {
        for (points, count) in [(lattice::<3>(5), 15), (lattice::<3>(4), 10)] {
            assert_eq!(points.len(), count);
            for k in 0..3 {
                let mean = points.iter().map(|p| p[k]).sum::<f64>() / count as f64;
                assert!((mean - 1.0 / 3.0).abs() < 1e-14);
            }
        }
        assert_eq!(lattice::<4>(4).len(), 20);
    }

    #[test]
    fn seeded_particles_lie_in_their_elements_and_in_their_fluids() {
        let mesh = square(4);
        let below = |x: Vector<2>| (x[1] < 0.7).then_some(if x[1] < 0.4 { 0 } else { 1 });
        let particles = Particles::seed(&mesh, 5, below, |x| x);
        assert!(!particles.is_empty() && particles.len() < 15 * 32);
        for e in 0..mesh.elements().len() {
            for p in particles.of(e) {
                assert!(mesh.shape_functions(e, particles.position[p]).iter().all(|&n| n > 0.0));
                assert_eq!(Some(particles.phase[p]), below(particles.position[p]));
            }
        }
    }

    #[test]
    fn a_column_of_a_law_is_sorted_and_merged_with_the_others() {
        let mut particles = Particles::<2> { by_element: Groups::new(3), ..Particles::default() };
        particles.add_column("stress", 2);
        for element in [2, 0, 1, 0] {
            particles.push(Vector::ZERO, Vector::ZERO, 0, element);
        }
        particles.optional[0].values = vec![4.0, 5.0, 0.0, 1.0, 2.0, 3.0, 6.0, 7.0];
        particles.sort();
        assert_eq!(particles.column("stress").unwrap(), [0.0, 1.0, 6.0, 7.0, 2.0, 3.0, 4.0, 5.0]);
        particles.merge(0, 1);
        particles.sort();
        assert_eq!(particles.column("stress").unwrap(), [3.0, 4.0, 2.0, 3.0, 4.0, 5.0]);
        assert!(particles.is_consistent());
        let mut names = Vec::new();
        particles.visit_columns(&mut |name, column| names.push((name.to_owned(), column.components)));
        assert_eq!(names.last(), Some(&("particles/stress".to_owned(), 2)));
    }

    #[test]
    fn sorting_is_stable_and_drops_particles_that_left() {
        let mut particles = Particles::<2> { by_element: Groups::new(8), ..Particles::default() };
        for (p, element) in [5, GONE, 0, 5, 7, 0, GONE, 5].into_iter().enumerate() {
            particles.push(Vector::ZERO, Vector::ZERO, p as u8, element);
        }
        particles.sort();
        assert_eq!(particles.phase, [2, 5, 0, 3, 7, 4]);
        assert_eq!(particles.of(5), 2..5);
        assert_eq!(particles.of(6), 5..5);
    }
}
