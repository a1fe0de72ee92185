//! Entries grouped by a key below a known number: a counting sort.

use super::{change, parts_mut, threads};
use std::ops::Range;

/// Numbers of entries in the order of their keys; those with one key keep the order that they had.
///
/// The order is unique, so that it does not depend on the number of threads.
///
/// ```
/// use lateen::parallel::Groups;
///
/// // The elements around each node of a chain of three segments.
/// let segments = [[0, 1], [1, 2], [2, 3]];
/// let around = Groups::from_pairs(4, (0..).zip(segments).flat_map(|(e, nodes)| nodes.map(|node| (node, e))));
/// assert_eq!((around.of(0), around.of(1), around.of(3)), (&[0][..], &[0, 1][..], &[2][..]));
///
/// // Particles by the element that holds them; one has left the mesh.
/// let mut particles = Groups::new(3);
/// particles.sort(&[2, Groups::NONE, 0, 2]);
/// assert_eq!((particles.entries(), particles.range(2)), (&[2, 0, 3][..], 1..3));
/// ```
#[derive(Debug, Clone, Default)]
pub struct Groups {
    /// Entries of group k are `entries[first[k]..first[k + 1]]`.
    first: Vec<u32>,
    entries: Vec<u32>,
}

impl Groups {
    /// The key of an entry that is in no group.
    pub const NONE: u32 = u32::MAX;

    /// Groups without entries; `groups`: their number.
    pub fn new(groups: usize) -> Self {
        Self { first: vec![0; groups + 1], entries: Vec::new() }
    }

    /// Groups of entries that may be in several, from pairs of key and entry.
    pub fn from_pairs(groups: usize, pairs: impl Iterator<Item = (u32, u32)> + Clone) -> Self {
        let mut made = Self::new(groups);
        made.count(pairs.clone().map(|(key, _)| key));
        let mut next = made.first.clone();
        made.entries = vec![0; made.first[groups] as usize];
        for (key, entry) in pairs {
            let place = &mut next[key as usize];
            made.entries[*place as usize] = entry;
            *place += 1;
        }
        made
    }

    /// Groups the numbers of `keys` anew, in the memory of the last time; those with the key [`Groups::NONE`] are left
    /// out.
    ///
    /// Every thread orders a range of groups: it reads all keys, one after the other, and writes its part only.
    pub fn sort(&mut self, keys: &[u32]) {
        self.count(keys.iter().copied().filter(|&key| key != Self::NONE));
        let Self { first, entries } = self;
        let groups = first.len() - 1;
        entries.resize(first[groups] as usize, 0);
        let part_len = groups.div_ceil(threads()).max(1);
        let range = |part: usize| part * part_len..((part + 1) * part_len).min(groups);
        let places = |part: usize| first[range(part).start] as usize..first[range(part).end] as usize;
        let mut parts = parts_mut(entries, (0..groups.div_ceil(part_len)).map(places));
        change(&mut parts, 1, |n, part| {
            let range = range(n);
            let base = first[range.start];
            let mut next: Vec<u32> = first[range.clone()].iter().map(|start| start - base).collect();
            for (entry, &key) in (0u32..).zip(keys) {
                if let Some(next) = (key as usize).checked_sub(range.start).and_then(|own| next.get_mut(own)) {
                    part[*next as usize] = entry;
                    *next += 1;
                }
            }
        });
    }

    /// Finds where each group begins.
    fn count(&mut self, keys: impl Iterator<Item = u32>) {
        self.first.fill(0);
        keys.for_each(|key| self.first[key as usize + 1] += 1);
        (1..self.first.len()).for_each(|k| self.first[k] += self.first[k - 1]);
    }

    /// All entries, group after group.
    pub fn entries(&self) -> &[u32] {
        &self.entries
    }

    /// The start of each group among the entries, then the number of entries.
    pub fn first(&self) -> &[u32] {
        &self.first
    }

    /// Places of a group among the entries.
    pub fn range(&self, group: usize) -> Range<usize> {
        self.first[group] as usize..self.first[group + 1] as usize
    }

    /// The entries of a group.
    pub fn of(&self, group: usize) -> &[u32] {
        &self.entries[self.range(group)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_of_one_group_keep_their_order() {
        let keys: Vec<u32> = (0..10_000_u32).map(|n| if n % 7 == 3 { Groups::NONE } else { n * n % 101 }).collect();
        let mut groups = Groups::new(101);
        groups.sort(&[1; 20]);
        groups.sort(&keys);
        let kept = (0..).zip(&keys).filter(|(_, key)| **key != Groups::NONE);
        let mut expected: Vec<(u32, u32)> = kept.clone().map(|(n, &key)| (key, n)).collect();
        expected.sort_unstable();
        assert!(groups.entries().iter().eq(expected.iter().map(|(_, n)| n)));
        let pairs = Groups::from_pairs(101, kept.map(|(n, &key)| (key, n)));
        assert_eq!((pairs.entries(), pairs.first()), (groups.entries(), groups.first()));
        assert!((0..101).all(|key| groups.of(key).iter().all(|&n| keys[n as usize] == key as u32)));
    }
}
