//! Elements of the fluid's mesh across a solid, along its way.

use super::{Placement, SolidSurroundings, extent, largest};
use crate::case::resolution::{MeshSizes, PathResolution, quadratic};
use crate::math::Vector;
use crate::mesh::Mesh;
use crate::mesh::quadratic::Thickness;
use crate::pfem2::solid::setup::SolidSetup;

/// The middle of a thickness, with the node next to it.
struct Thick<const D: usize> {
    middle: Vector<D>,
    length: f64,
    node: usize,
}

/// The fewest elements across a solid in all of these placements and where it starts; `None` without a placement that
/// moves it, or outside of the mesh.
pub(super) fn along<const D: usize, const N: usize>(
    setup: &SolidSetup<D>,
    placements: &[Placement<D>],
    around: &SolidSurroundings<D, N>,
    sizes: &MeshSizes,
) -> Option<PathResolution> {
    let way = largest(placements.iter().flatten());
    if way == 0.0 {
        return None;
    }
    let mesh = around.mesh;
    let (thick, mut guess) = (thicknesses(setup), 0);
    let mut fewest: Option<(f64, Vector<D>, f64)> = None;
    let at_rest = vec![Vector::ZERO; setup.mesh.nodes.len()];
    for placement in std::iter::once(&at_rest).chain(placements) {
        for Thick { middle, length, node } in &thick {
            let x = *middle + placement[*node];
            let place = around.locator.locate(mesh, x, guess);
            let Some(size) = sizes.at(mesh, &place) else { continue };
            guess = place.element().unwrap_or(guess);
            if fewest.is_none_or(|(cells, ..)| length / size < cells) {
                fewest = Some((length / size, x, *length));
            }
        }
    }
    let (cells, place, thickness) = fewest?;
    Some(PathResolution { cells, place: place.to3(), thickness, way, swept: swept(setup, placements, mesh) })
}

fn thicknesses<const D: usize>(setup: &SolidSetup<D>) -> Vec<Thick<D>> {
    let mesh = quadratic(setup);
    let mut all = mesh.thicknesses();
    if all.is_empty() {
        all.push(mesh.thinnest());
    }
    let nodes = || setup.mesh.nodes.iter().enumerate();
    let nearest = |x: Vector<D>| {
        let least = nodes().min_by(|a, b| (*a.1 - x).norm_squared().total_cmp(&(*b.1 - x).norm_squared()));
        least.map_or(0, |(node, _)| node)
    };
    let thick = |of: Thickness| {
        let middle = Vector::from3(of.middle);
        Thick { middle, length: of.length, node: nearest(middle) }
    };
    all.into_iter().map(thick).collect()
}

/// The box around a solid in all of these placements and where it starts, as far as it lies in that around the mesh.
fn swept<const D: usize, const N: usize>(
    setup: &SolidSetup<D>,
    placements: &[Placement<D>],
    mesh: &Mesh<D, N>,
) -> [[f64; 3]; 2] {
    let range = |axis: usize| {
        let moved = |placement: &Placement<D>| -> Vec<f64> {
            setup.mesh.nodes.iter().zip(placement).map(|(x, u)| x[axis] + u[axis]).collect()
        };
        let [lower, upper] = extent(&setup.mesh.nodes, axis);
        let all = placements.iter().flat_map(moved);
        let [least, most] = all.fold([lower, upper], |[lower, upper], x| [lower.min(x), upper.max(x)]);
        let [first, last] = extent(mesh.nodes(), axis);
        [least.max(first), most.min(last)]
    };
    let ranges: [[f64; 2]; D] = std::array::from_fn(range);
    [0, 1].map(|end| Vector::<D>::from_fn(|axis| ranges[axis][end]).to3())
}
