//! The sparsity pattern of matrices on a fixed mesh: nodes that share an element.

use rayon::prelude::*;

/// The sparsity pattern of a mesh: row i holds node i itself and every node that shares an element with it.
///
/// Symmetric. Columns ascend within a row.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pattern {
    /// Entries of row i are `start[i]..start[i + 1]`.
    start: Vec<u32>,
    columns: Vec<u32>,
    diagonal: Vec<u32>,
    /// The entry (j, i) for each entry (i, j).
    mirror: Vec<u32>,
}

impl Pattern {
    /// The pattern of `nodes` nodes and elements given by their nodes, all below `nodes`.
    pub fn new<const N: usize>(nodes: usize, elements: &[[u32; N]]) -> Self {
        let around = Around::new(nodes, elements);
        let rows: Vec<Vec<u32>> = (0..nodes)
            .into_par_iter()
            .map(|node| {
                let own = std::iter::once(node as u32);
                let mut row: Vec<u32> = own.chain(around.of(node).iter().flat_map(|&e| elements[e as usize])).collect();
                row.sort_unstable();
                row.dedup();
                row
            })
            .collect();
        Self::from_rows(&rows)
    }

    /// A pattern from the ascending columns of each row; the pattern must be symmetric and hold the diagonal.
    fn from_rows(rows: &[Vec<u32>]) -> Self {
        let mut start = Vec::with_capacity(rows.len() + 1);
        start.push(0);
        for row in rows {
            start.push(start[start.len() - 1] + row.len() as u32);
        }
        let columns = rows.concat();
        let mut pattern = Self { start, columns, diagonal: Vec::new(), mirror: Vec::new() };
        // Rows are visited in ascending order, so that row j meets its columns i in their own order.
        let mut next: Vec<u32> = pattern.start.clone();
        pattern.mirror = pattern
            .columns
            .iter()
            .map(|&j| {
                let place = next[j as usize];
                next[j as usize] += 1;
                place
            })
            .collect();
        pattern.diagonal = (0..rows.len()).filter_map(|i| pattern.entry(i, i)).map(|entry| entry as u32).collect();
        pattern
    }

    /// Number of rows, one per node.
    pub fn rows(&self) -> usize {
        self.start.len() - 1
    }

    /// Number of entries.
    pub fn entries(&self) -> usize {
        self.columns.len()
    }

    /// The entries of a row.
    pub fn row(&self, row: usize) -> std::ops::Range<usize> {
        self.start[row] as usize..self.start[row + 1] as usize
    }

    /// The column of every entry.
    pub fn columns(&self) -> &[u32] {
        &self.columns
    }

    /// The entry at (`row`, `col`), if the two nodes share an element.
    pub fn entry(&self, row: usize, col: usize) -> Option<usize> {
        let range = self.row(row);
        self.columns[range.clone()].binary_search(&(col as u32)).ok().map(|place| range.start + place)
    }

    /// The entry on the diagonal of a row.
    pub fn diagonal(&self, row: usize) -> usize {
        self.diagonal[row] as usize
    }

    /// The entry (j, i) that mirrors the entry (i, j).
    pub fn mirror(&self, entry: usize) -> usize {
        self.mirror[entry] as usize
    }
}

/// Elements around each node.
struct Around {
    start: Vec<u32>,
    list: Vec<u32>,
}

impl Around {
    fn new<const N: usize>(nodes: usize, elements: &[[u32; N]]) -> Self {
        let mut start = vec![0u32; nodes + 1];
        elements.iter().flatten().for_each(|&node| start[node as usize + 1] += 1);
        (0..nodes).for_each(|node| start[node + 1] += start[node]);
        let mut next = start.clone();
        let mut list = vec![0; elements.len() * N];
        for (element, nodes) in (0u32..).zip(elements) {
            for &node in nodes {
                list[next[node as usize] as usize] = element;
                next[node as usize] += 1;
            }
        }
        Self { start, list }
    }

    fn of(&self, node: usize) -> &[u32] {
        &self.list[self.start[node] as usize..self.start[node + 1] as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_triangles_and_an_isolated_node() {
        let pattern = Pattern::new(5, &[[0, 1, 2], [2, 1, 3]]);
        let rows: Vec<&[u32]> = (0..5).map(|i| &pattern.columns()[pattern.row(i)]).collect();
        assert_eq!(rows, [&[0, 1, 2][..], &[0, 1, 2, 3], &[0, 1, 2, 3], &[1, 2, 3], &[4]]);
        assert_eq!((pattern.entry(0, 3), pattern.entry(3, 0)), (None, None));
        for i in 0..5 {
            assert_eq!(pattern.entry(i, i), Some(pattern.diagonal(i)));
            for entry in pattern.row(i) {
                let j = pattern.columns()[entry] as usize;
                assert_eq!(pattern.entry(j, i), Some(pattern.mirror(entry)));
            }
        }
    }
}
