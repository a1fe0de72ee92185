//! Nodes and points of surfaces where walls and obstacles act, found anew when the active blocks or an obstacle have
//! changed (theory E.1, E.5).

use super::surface::{SurfaceFoot, SurfacePoint};
use super::{NodeCondition, Walls, constrain, gap};
use crate::math::Vector;
use crate::mpm::WallKind;
use crate::mpm::grid::{EDGE, Grid};
use crate::parallel::{self, CHUNK};

/// Distance from the surface of an obstacle of the nodes whose feet are points where it binds [cells].
const BAND: f64 = 0.5;

/// Rounding error of distances from it [cells]: nodes on the surface of a box must count although −0.3 + 6 · 0.05 is
/// not exactly 0.
const ROUNDING: f64 = 1e-6;

/// Distance from an obstacle of blocks of the grid that may hold particles near it [cells].
const SEARCH_DISTANCE: f64 = 4.0;

impl<const D: usize> Walls<D> {
    /// Finds the nodes under a condition, after the active blocks or an obstacle changed.
    pub fn find_nodes(&mut self, grid: &Grid<D>) {
        self.conditions = parallel::collect_all(grid.node_count(), CHUNK, |node| self.conditions_of(grid, node));
        self.ranges = constrain::ranges(&self.conditions);
        let has_gap = |condition: &NodeCondition<D>| self.has_gap(condition);
        self.gap_conditions = gap::GapConditions::new(grid, &self.conditions, has_gap);
        self.binding_points =
            parallel::collect_all(grid.node_count(), CHUNK, |node| self.binding_points_of(grid, node));
        let reach = (0.5 * EDGE as f64 * (D as f64).sqrt() + SEARCH_DISTANCE) * grid.cell;
        let middle =
            |block: &[i32; D]| grid.origin + Vector::from_fn(|a| f64::from(block[a]) + 0.5) * (EDGE as f64 * grid.cell);
        self.near = grid.blocks().iter().map(|block| self.clearance_of_surfaces(middle(block)) < reach).collect();
    }

    /// The points of surfaces next to a node at which obstacles bind.
    fn binding_points_of(&self, grid: &Grid<D>, node: usize) -> Vec<SurfacePoint<D>> {
        let (x, cell) = (grid.position(node), grid.cell);
        let binding = (0..self.regions.len()).filter(|obstacle| self.boundaries[2 * D + obstacle].kind.binds());
        let foot = |obstacle: usize| {
            let beside = self.obstacle_distance(obstacle, x) / cell;
            if !(grid.contains(grid.coordinates(node)) && (ROUNDING - BAND..=ROUNDING + BAND).contains(&beside)) {
                return None;
            }
            let normal = self.obstacle_normal(obstacle, x, cell);
            let onto = |x: Vector<D>| x - normal * self.obstacle_distance(obstacle, x);
            let foot = SurfaceFoot { boundary: (2 * D + obstacle) as u32, place: onto(onto(x)), normal };
            Some(SurfacePoint::new(foot, None, f64::NEG_INFINITY))
        };
        binding.filter_map(foot).collect()
    }

    /// True if a condition acts where a gap closes: that of a wall or an obstacle that bodies may leave.
    pub(super) fn has_gap(&self, condition: &NodeCondition<D>) -> bool {
        !self.boundaries[condition.boundary as usize].kind.binds()
    }

    /// The conditions of a node, the strictest last.
    fn conditions_of(&self, grid: &Grid<D>, node: usize) -> Vec<NodeCondition<D>> {
        let (mut conditions, ijk) = (Vec::new(), grid.coordinates(node));
        if !self.may_hold_mass(grid, ijk) {
            return conditions;
        }
        for (side, boundary) in self.boundaries[..2 * D].iter().enumerate() {
            let (axis, end) = (side / 2, side % 2);
            if boundary.kind != WallKind::Open && ijk[axis] == if end == 0 { 0 } else { grid.cells[axis] } {
                let normal = Vector::unit(axis) * if end == 0 { 1.0 } else { -1.0 };
                conditions.push(NodeCondition { node: node as u32, boundary: side as u32, normal });
            }
        }
        let x = grid.position(node);
        for obstacle in 0..self.regions.len() {
            // Nodes that no body outside reaches hold what has entered; nearer ones hold a body that started there.
            let boundary = 2 * D + obstacle;
            let reach = if self.holds_a_body(boundary) { 0.0 } else { 0.5 * f64::from(self.stencil.support()) };
            if self.obstacle_distance(obstacle, x) < (ROUNDING - reach) * grid.cell {
                let normal = self.obstacle_normal(obstacle, x, grid.cell);
                conditions.push(NodeCondition { node: node as u32, boundary: boundary as u32, normal });
            }
        }
        conditions.sort_by_key(|c| self.boundaries[c.boundary as usize].kind.strictness());
        conditions
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Region;
    use crate::math::Signal;
    use crate::mpm::wall::folded_stencil::FoldedStencil;
    use crate::mpm::{GridSetup, Kernel, KernelKind, Obstacle, Wall};

    /// There is one point per node along a surface, also where a node lies on it (−0.3 + 6 · 0.05 is rounded to
    /// 6 · 10⁻¹⁷), and where it is halfway between two nodes.
    #[test]
    fn obstacles_bind_at_one_point_per_node_along_their_surface() {
        for top in [0.0, 0.01, 0.025, 0.04] {
            let walls = walls_with_a_floor(top);
            let places: Vec<_> = walls.binding_points.iter().map(|point| point.place).collect();
            assert_eq!(places.len(), 4, "{places:?}");
            assert!(places.iter().all(|place| (place[1] - top).abs() < 1e-12), "{places:?}");
            assert!(walls.binding_points.iter().all(|point| (point.normal - Vector([0.0, 1.0])).norm() < 1e-9));
        }
    }

    fn walls_with_a_floor(top: f64) -> Walls<2> {
        let walls = std::array::from_fn(|_| [Wall::default(), Wall::default()]);
        let setup = GridSetup::<2> { lower: Vector([0.0, -0.3]), cell: 0.05, cells: [8, 24], walls };
        let floor = Obstacle {
            name: "floor".into(),
            region: Region::Box { lower: [-1.0, -9.0, -1.0], upper: [9.0, top, 1.0] },
            kind: WallKind::Slip,
            velocity: std::array::from_fn(|_| Signal::ZERO),
        };
        let mut grid = Grid::new(setup.lower, setup.cell, setup.cells, 1);
        grid.set_blocks(vec![[0, 0], [0, 1], [0, 2]]);
        let stencil = FoldedStencil::new(Kernel::new(KernelKind::Quadratic, 0.25), &setup.walls);
        let mut walls = Walls::new(&setup, vec![floor], 1, stencil);
        walls.find_nodes(&grid);
        walls
    }
}
