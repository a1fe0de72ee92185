//! φ and fractions of fluids at nodes inside of solids (theory (G.29)).
//!
//! ```text
//! φ_i = ⟨φ_k + (x_i − x_k)·G_k⟩     node i inside, known nodes k of its elements, G_k: mean of the known ∇φ_e around k
//! f_i = ⟨f_k⟩                       row by row from the surface inwards
//! ```
//!
//! Nodes inside that see particles beside the solid have an average, exact for linear fields. So a plane
//! interface that meets a solid goes on as a plane behind its surface, whatever their angle, and fluids at rest stay at
//! rest there. Nodes that a solid leaves behind have the side of the fluid around them.

use crate::math::Vector;
use crate::mesh::Mesh;
use crate::parallel;
use crate::pfem2::phases::FluidRegion;

/// Nodes per piece of a parallel loop.
const PIECE: usize = 64;

/// Continues φ into solids, up to ± `band` [m], from nodes outside and those inside that are `seen` by particles.
pub fn continue_level<const D: usize, const N: usize>(
    region: &FluidRegion<D, N>,
    seen: impl Fn(usize) -> bool,
    level: &mut [f64],
    band: f64,
) {
    let mesh = region.mesh;
    inwards(region, seen, |row, known| {
        let of = |n: usize| {
            let node = row[n];
            let (mut sum, mut count) = (0.0, 0.0);
            for other in neighbours(mesh, node).filter(|&other| known[other]) {
                let way = mesh.nodes()[node] - mesh.nodes()[other];
                sum += level[other] + way.dot(slope(mesh, other, known, level));
                count += 1.0;
            }
            (sum / count).clamp(-band, band)
        };
        let found = parallel::collect(row.len(), PIECE, of);
        row.iter().zip(found).for_each(|(&node, phi)| level[node] = phi);
    });
}

/// Continues fractions of fluids into solids, by fluid and node.
pub fn continue_fractions<const D: usize, const N: usize>(region: &FluidRegion<D, N>, fraction: &mut [Vec<f64>]) {
    let seen: Vec<bool> = (0..region.mesh.nodes().len()).map(|i| fraction.iter().any(|own| own[i] > 0.0)).collect();
    inwards(
        region,
        |node| seen[node],
        |row, known| {
            for own in fraction.iter_mut() {
                let of = |n: usize| {
                    let around = || neighbours(region.mesh, row[n]).filter(|&other| known[other]);
                    around().map(|other| own[other]).sum::<f64>() / around().count() as f64
                };
                let found = parallel::collect(row.len(), PIECE, of);
                row.iter().zip(found).for_each(|(&node, fraction)| own[node] = fraction);
            }
        },
    );
}

/// Calls `fill` with the rows of nodes inside of solids from the surface inwards, each beside nodes that are known by
/// then.
fn inwards<const D: usize, const N: usize>(
    region: &FluidRegion<D, N>,
    seen: impl Fn(usize) -> bool,
    mut fill: impl FnMut(&[usize], &[bool]),
) {
    let mut rest: Vec<usize> = region.covered().filter(|&node| !seen(node)).collect();
    if rest.is_empty() {
        return;
    }
    let mut known = vec![true; region.mesh.nodes().len()];
    rest.iter().for_each(|&node| known[node] = false);
    while !rest.is_empty() {
        let (row, others): (Vec<usize>, Vec<usize>) =
            rest.into_iter().partition(|&node| neighbours(region.mesh, node).any(|other| known[other]));
        if row.is_empty() {
            return;
        }
        fill(&row, &known);
        row.iter().for_each(|&node| known[node] = true);
        rest = others;
    }
}

/// The mean gradient of the elements around a node whose nodes are known.
fn slope<const D: usize, const N: usize>(mesh: &Mesh<D, N>, node: usize, known: &[bool], level: &[f64]) -> Vector<D> {
    let (mut sum, mut volume) = (Vector::ZERO, 0.0);
    for e in mesh.elements_around(node).iter().map(|&e| e as usize) {
        let (nodes, simplex) = (&mesh.elements()[e], mesh.simplex(e));
        if nodes.iter().all(|&k| known[k as usize]) {
            let own = nodes.iter().zip(&simplex.gradient).map(|(&k, &g)| g * level[k as usize]).sum::<Vector<D>>();
            sum += own * simplex.volume;
            volume += simplex.volume;
        }
    }
    if volume > 0.0 { sum / volume } else { Vector::ZERO }
}

/// The other nodes of the elements around a node, each once per element.
fn neighbours<const D: usize, const N: usize>(mesh: &Mesh<D, N>, node: usize) -> impl Iterator<Item = usize> + '_ {
    let around = mesh.elements_around(node).iter().flat_map(|&e| mesh.elements()[e as usize]);
    around.map(|other| other as usize).filter(move |&other| other != node)
}
