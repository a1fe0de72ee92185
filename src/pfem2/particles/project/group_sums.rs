//! Sums over the particles of an element: all that the projection needs to know of them (theory G.11).
//!
//! ```text
//! S_kl = Σ_p N_k N_l,   R_k = Σ_p N_k f_p,   so that  Σ_p N_k = s_k = Σ_l S_kl,   Σ_p N_k x_p = Σ_l S_kl x_l
//! ```
//!
//! Particles are read once, element by element; nodes then gather from the elements around them, in ascending order.

use crate::math::Vector;
use crate::mesh::Mesh;
use crate::parallel;
use std::ops::Range;

/// Elements per parallel task.
const BLOCK: usize = 512;

/// Sums over the particles of one group in one element.
#[derive(Debug, Clone, Copy)]
pub(in crate::pfem2) struct GroupSums<const K: usize, const N: usize> {
    /// The group, here the fluid.
    pub group: u8,
    /// Weight of one particle: its volume V_e/n_e [m³], or one.
    pub weight: f64,
    /// S_kl; only k ≤ l is filled while summing.
    pub shape: [[f64; N]; N],
    /// R_k.
    pub values: [Vector<K>; N],
}

impl<const K: usize, const N: usize> GroupSums<K, N> {
    /// No particles.
    #[inline(always)]
    pub fn new(group: u8) -> Self {
        Self { group, weight: 1.0, shape: [[0.0; N]; N], values: [Vector::ZERO; N] }
    }

    /// Adds a particle with value f.
    #[inline(always)]
    pub fn add(&mut self, n: &[f64; N], f: Vector<K>) {
        for k in 0..N {
            for l in k..N {
                self.shape[k][l] += n[k] * n[l];
            }
            self.values[k] += f * n[k];
        }
    }

    fn merge(&mut self, other: &Self) {
        for k in 0..N {
            for l in k..N {
                self.shape[k][l] += other.shape[k][l];
            }
            self.values[k] += other.values[k];
        }
    }

    fn mirror(&mut self) {
        for k in 0..N {
            for l in 0..k {
                self.shape[k][l] = self.shape[l][k];
            }
        }
    }

    /// s_k = Σ_p N_k.
    #[inline(always)]
    pub fn sum(&self, k: usize) -> f64 {
        self.shape[k].iter().sum()
    }
}

/// Sums in all elements, one entry per group that an element holds.
#[derive(Debug, Clone)]
pub(in crate::pfem2) struct GroupSumTable<const K: usize, const N: usize> {
    blocks: Vec<SumBlock<K, N>>,
}

#[derive(Debug, Clone)]
struct SumBlock<const K: usize, const N: usize> {
    /// Entries of the block's e-th element are `entries[start[e]..start[e + 1]]`.
    start: Vec<u32>,
    entries: Vec<GroupSums<K, N>>,
}

impl<const K: usize, const N: usize> GroupSumTable<K, N> {
    /// Lets `fill` add up every element.
    pub fn collect(elements: usize, fill: impl Fn(usize, &mut Entries<K, N>) + Sync) -> Self {
        let block = |range: Range<usize>| {
            let mut entries = Entries { all: Vec::with_capacity(range.len() + range.len() / 8), own: 0 };
            let mut start = vec![0];
            for e in range {
                entries.own = entries.all.len();
                fill(e, &mut entries);
                entries.all[entries.own..].iter_mut().for_each(GroupSums::mirror);
                start.push(entries.all.len() as u32);
            }
            SumBlock { start, entries: entries.all }
        };
        Self { blocks: parallel::map_ranges(elements, BLOCK, block) }
    }

    /// The entries of an element.
    #[inline(always)]
    pub fn of(&self, element: usize) -> &[GroupSums<K, N>] {
        let (block, e) = (&self.blocks[element / BLOCK], element % BLOCK);
        &block.entries[block.start[e] as usize..block.start[e + 1] as usize]
    }

    /// Subtracts nodal values f_l of each group, interpolated, from the values of its particles (theory (G.24a)):
    /// R_k ← R_k − Σ_l S_kl f_l.
    pub fn subtract<const D: usize>(&mut self, mesh: &Mesh<D, N>, nodal: impl Fn(usize, usize) -> Vector<K> + Sync) {
        self.for_each(|e, entry| {
            let nodal = mesh.elements()[e].map(|node| nodal(entry.group as usize, node as usize));
            for (values, shape) in entry.values.iter_mut().zip(&entry.shape) {
                for (&f, &s) in nodal.iter().zip(shape) {
                    *values -= f * s;
                }
            }
        });
    }

    /// Changes every entry, given its element.
    pub fn for_each(&mut self, change: impl Fn(usize, &mut GroupSums<K, N>) + Sync) {
        parallel::change(&mut self.blocks, 1, |b, block| {
            for (e, bounds) in block.start.windows(2).enumerate() {
                for entry in &mut block.entries[bounds[0] as usize..bounds[1] as usize] {
                    change(b * BLOCK + e, entry);
                }
            }
        });
    }
}

/// The entries of the element that is being added up.
pub(in crate::pfem2) struct Entries<const K: usize, const N: usize> {
    all: Vec<GroupSums<K, N>>,
    own: usize,
}

impl<const K: usize, const N: usize> Entries<K, N> {
    /// Adds what was summed of one group.
    pub fn put(&mut self, sums: &GroupSums<K, N>) {
        match self.all[self.own..].iter_mut().find(|entry| entry.group == sums.group) {
            Some(entry) => entry.merge(sums),
            None => self.all.push(*sums),
        }
    }

    /// Sets the weight of the element's particles.
    pub fn weigh(&mut self, weight: f64) {
        self.all[self.own..].iter_mut().for_each(|entry| entry.weight = weight);
    }
}
