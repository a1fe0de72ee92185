//! The cells of a lattice inside of a surface: planes of the lattice, choice of the cells, repairs of their boundary.

use super::axes::area;
use super::features::{Features, normals};
use crate::geometry::{Surface, Triangles};
use crate::math::Vector;
use std::collections::{BTreeSet, VecDeque};

/// A flat part is level if the cosine between its normal and an axis is above.
const LEVEL: f64 = 0.9999;

/// Level parts of this area, over the square of the length of a cell, have a plane of the lattice.
const PLANE_AREA: f64 = 0.5;

/// Of two steps of a surface that are closer than this part of a cell the larger one has a plane.
const CLOSEST_STEPS: f64 = 0.5;

/// Level parts closer than this part of the extent are one plane.
const SAME_PLANE: f64 = 1e-6;

/// Planes of a lattice along the axes [m], ascending.
#[derive(Debug, Clone)]
pub struct Lattice {
    pub lines: [Vec<f64>; 3],
}

/// The level parts of a surface at a height.
#[derive(Debug, Clone, Copy)]
struct LevelParts {
    height: f64,
    /// Areas [m²] that face down and up.
    areas: [f64; 2],
}

/// Cells of a lattice that are kept.
pub struct Cells<'a> {
    pub lattice: &'a Lattice,
    pub kept: Vec<bool>,
    /// Depth of the middle below the surface, less what is asked for [m].
    depth: Vec<f64>,
}

impl Lattice {
    /// Planes around a surface about `cell` apart [m], also through its large level parts.
    pub fn new(surface: &Triangles, cell: f64) -> Self {
        Self { lines: [0, 1, 2].map(|axis| lines(&levels(surface, axis, cell), cell)) }
    }

    /// Number of cells along the axes.
    pub fn counts(&self) -> [usize; 3] {
        [0, 1, 2].map(|k| self.lines[k].len() - 1)
    }

    /// Lengths of a cell [m].
    pub fn sizes(&self, at: [usize; 3]) -> [f64; 3] {
        [0, 1, 2].map(|k| self.lines[k][at[k] + 1] - self.lines[k][at[k]])
    }

    pub fn middle(&self, at: [usize; 3]) -> Vector<3> {
        Vector::from_fn(|k| 0.5 * (self.lines[k][at[k]] + self.lines[k][at[k] + 1]))
    }

    /// The place of a cell by its number, the first axis fastest.
    pub fn at(&self, index: usize) -> [usize; 3] {
        let [x, y, _] = self.counts();
        [index % x, index / x % y, index / x / y]
    }

    /// The number of the cell at a place, if there is one.
    pub fn index(&self, at: [isize; 3]) -> Option<usize> {
        let counts = self.counts();
        let inside = (0..3).all(|k| (0..counts[k] as isize).contains(&at[k]));
        inside.then(|| at[0] as usize + counts[0] * (at[1] as usize + counts[1] * at[2] as usize))
    }
}

/// Heights of the ends of the surface and of its large level parts, ascending.
fn levels(surface: &Triangles, axis: usize, cell: f64) -> Vec<LevelParts> {
    let height = |v: u32| surface.vertices[v as usize][axis];
    let used = || surface.triangles.iter().flatten().map(|&v| height(v));
    let ends = [used().fold(f64::INFINITY, f64::min), used().fold(f64::NEG_INFINITY, f64::max)];
    let same = SAME_PLANE * (ends[1] - ends[0]);
    let mut flat: Vec<LevelParts> = Vec::new();
    for (t, normal) in surface.triangles.iter().zip(normals(surface)) {
        if normal[axis].abs() > LEVEL {
            let mut areas = [0.0; 2];
            areas[usize::from(normal[axis] > 0.0)] = area(surface, t);
            flat.push(LevelParts { height: t.iter().map(|&v| height(v)).sum::<f64>() / 3.0, areas });
        }
    }
    flat.sort_by(|a, b| a.height.total_cmp(&b.height));
    let mut found: Vec<LevelParts> = Vec::new();
    for level in flat {
        match found.last_mut() {
            Some(last) if level.height - last.height <= same => {
                (0..2).for_each(|k| last.areas[k] += level.areas[k]);
            }
            _ => found.push(level),
        }
    }
    let inner = |level: &LevelParts| level.height > ends[0] + same && level.height < ends[1] - same;
    found.retain(|level| inner(level) && level.areas[0] + level.areas[1] > PLANE_AREA * cell * cell);
    let infinite = |height: f64, side: usize| {
        let mut areas = [0.0; 2];
        areas[side] = f64::INFINITY;
        LevelParts { height, areas }
    };
    found.insert(0, infinite(ends[0], 0));
    found.push(infinite(ends[1], 1));
    found
}

/// Planes at levels, and evenly between them. Of steps that face the same way and are closer than a cell the smaller one
/// has none; walls and gaps, between parts that face each other or away from each other, keep both of theirs.
fn lines(levels: &[LevelParts], cell: f64) -> Vec<f64> {
    let mut levels = levels.to_vec();
    let total = |level: &LevelParts| level.areas[0] + level.areas[1];
    let closest = |levels: &[LevelParts]| {
        let gap = |i: &usize| levels[i + 1].height - levels[*i].height;
        let alike = |i: &usize| {
            let larger = |level: &LevelParts| usize::from(level.areas[1] > level.areas[0]);
            larger(&levels[*i]) == larger(&levels[i + 1])
        };
        let close = (0..levels.len() - 1).filter(|i| gap(i) < CLOSEST_STEPS * cell && alike(i));
        close.min_by(|a, b| gap(a).total_cmp(&gap(b)))
    };
    while let Some(i) = closest(&levels) {
        levels.remove(if total(&levels[i]) < total(&levels[i + 1]) { i } else { i + 1 });
    }
    let mut found = vec![levels[0].height];
    for pair in levels.windows(2) {
        let [from, to] = [pair[0].height, pair[1].height];
        // So that rounding of a turned surface doesn't decide about halves.
        let count = super::divisions((1.0 + SAME_PLANE) * (to - from), cell);
        found.extend((1..count).map(|i| from + (to - from) * i as f64 / count as f64));
        found.push(to);
    }
    found
}

impl<'a> Cells<'a> {
    /// Cells whose middle is inside of a surface, and at least `inset`, in lengths of a cell, from the patches that are
    /// listed; with one below zero cells whose middle is that far outside, too.
    ///
    /// # Errors
    /// No cell is inside.
    pub fn inside(
        lattice: &'a Lattice,
        surface: &Surface,
        features: &Features,
        inset: f64,
        patches: &BTreeSet<u32>,
    ) -> Result<Self, String> {
        let count = lattice.counts().iter().product();
        let depth = |index: usize| {
            let at = lattice.at(index);
            let (x, sizes) = (lattice.middle(at), lattice.sizes(at));
            let across = |n: Vector<3>| (0..3).map(|k| (n[k] * sizes[k]).powi(2)).sum::<f64>().sqrt();
            let (distance, n) = surface.distance(x);
            if inset <= 0.0 || distance >= 0.0 {
                return -distance - inset.min(0.0) * across(n);
            }
            let away = patches.iter().filter_map(|&patch| {
                let away = x - features.on_patch(patch, x)?.0;
                Some(away.norm() - inset * across(away.normalized().unwrap_or(n)))
            });
            away.fold(-distance, f64::min)
        };
        let depth: Vec<f64> = (0..count).map(depth).collect();
        let kept = depth.iter().map(|&depth| depth > 0.0).collect();
        let mut cells = Self { lattice, kept, depth };
        cells.keep_largest();
        if !cells.kept.contains(&true) {
            return Err("no element fits inside".into());
        }
        cells.make_manifold();
        Ok(cells)
    }

    /// Keeps the largest set of cells that are joined by faces.
    fn keep_largest(&mut self) {
        let mut part = vec![usize::MAX; self.kept.len()];
        let mut sizes = Vec::new();
        for start in 0..self.kept.len() {
            if !self.kept[start] || part[start] != usize::MAX {
                continue;
            }
            let mut queue = VecDeque::from([start]);
            (part[start], sizes) = (sizes.len(), [sizes, vec![0usize]].concat());
            while let Some(index) = queue.pop_front() {
                sizes[part[start]] += 1;
                for next in self.neighbours(index).into_iter().flatten() {
                    if self.kept[next] && part[next] == usize::MAX {
                        part[next] = part[start];
                        queue.push_back(next);
                    }
                }
            }
        }
        let largest = (0..sizes.len()).reduce(|best, next| if sizes[next] > sizes[best] { next } else { best });
        self.kept.iter_mut().zip(part).for_each(|(kept, part)| *kept &= Some(part) == largest);
    }

    /// The cells across the faces of a cell: lower and upper along each axis.
    fn neighbours(&self, index: usize) -> [Option<usize>; 6] {
        let at = self.lattice.at(index).map(|i| i as isize);
        std::array::from_fn(|side| {
            let mut next = at;
            next[side / 2] += if side % 2 == 0 { -1 } else { 1 };
            self.lattice.index(next)
        })
    }

    /// True if a cell is kept that has no kept neighbour across a side.
    pub fn is_boundary(&self, index: usize, side: usize) -> bool {
        self.kept[index] && self.neighbours(index)[side].is_none_or(|next| !self.kept[next])
    }

    /// Adds the deepest cells where the boundary touches itself in an edge or a corner, until it doesn't.
    fn make_manifold(&mut self) {
        let counts = self.lattice.counts();
        let corners = counts.map(|count| count + 1);
        let mut queue: BTreeSet<usize> = (0..corners.iter().product()).collect();
        while let Some(corner) = queue.pop_first() {
            let at = [corner % corners[0], corner / corners[0] % corners[1], corner / corners[0] / corners[1]];
            let cell = |i: usize| self.lattice.index(std::array::from_fn(|k| (at[k] + (i >> k & 1)) as isize - 1));
            let around: [Option<usize>; 8] = std::array::from_fn(cell);
            let kept = around.map(|cell| cell.is_some_and(|cell| self.kept[cell]));
            if is_joined(kept) && is_joined(kept.map(|kept| !kept)) {
                continue;
            }
            let empty = around.into_iter().flatten().filter(|&cell| !self.kept[cell]);
            let deepest = empty.reduce(|best, next| if self.depth[next] > self.depth[best] { next } else { best });
            let Some(added) = deepest else { continue };
            self.kept[added] = true;
            let at = self.lattice.at(added);
            queue.extend((0..8).map(|i| {
                let [x, y, z] = std::array::from_fn(|k| at[k] + (i >> k & 1));
                x + corners[0] * (y + corners[1] * z)
            }));
        }
    }
}

/// True if the marked ones of eight cells around a corner are joined by faces.
fn is_joined(marked: [bool; 8]) -> bool {
    let Some(first) = marked.iter().position(|&marked| marked) else { return true };
    let mut reached = 1u32 << first;
    loop {
        let next = (0..8).filter(|&i| reached >> i & 1 == 1).flat_map(|i| [i ^ 1, i ^ 2, i ^ 4]);
        let grown = next.filter(|&i| marked[i]).fold(reached, |reached, i| reached | 1 << i);
        if grown == reached {
            return (0..8).all(|i| !marked[i] || reached >> i & 1 == 1);
        }
        reached = grown;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_that_share_an_edge_or_a_corner_alone_are_not_joined() {
        let of = |members: &[usize]| is_joined(std::array::from_fn(|i| members.contains(&i)));
        assert!(of(&[]) && of(&[5]) && of(&[0, 1]) && of(&[0, 1, 3, 7]));
        assert!(!of(&[0, 3]) && !of(&[0, 7]) && !of(&[0, 1, 6]));
    }

    /// A wall thinner than half a cell keeps both of its planes; a step that low is left out.
    #[test]
    fn walls_have_planes_and_low_steps_none() {
        let level = |height: f64, down: f64, up: f64| LevelParts { height, areas: [down, up] };
        let ends = [level(0.0, f64::INFINITY, 0.0), level(2.0, 0.0, f64::INFINITY)];
        let wall = lines(&[ends[0], level(0.25, 0.0, 3.0), ends[1]], 1.0);
        assert_eq!(wall, [0.0, 0.25, 1.125, 2.0]);
        let step = lines(&[ends[0], level(1.75, 0.0, 3.0), ends[1]], 1.0);
        assert_eq!(step, [0.0, 1.0, 2.0]);
    }
}
