//! φ and fractions of fluids at nodes inside of solids (theory (G.29), (G.29a)).
//!
//! ```text
//! φ_i = ⟨φ_k + (x_i − x_k)·G_k⟩     node i inside, known nodes k of its elements, G_k: mean of the known ∇φ_e around k
//! f_i = ⟨f_k⟩                       row by row from the surface inwards
//! φ_i = ⟨φ_k + (x_i − x_k)·G⟩       for distances, from where the interface meets the surface with the mean slope G
//! ```
//!
//! Nodes inside that see particles beside the solid have an average, exact for linear fields. So a plane
//! interface that meets a solid goes on as a plane behind its surface, whatever their angle, and fluids at rest stay at
//! rest there. Nodes that a solid leaves behind have the side of the fluid around them.

use crate::math::Vector;
use crate::mesh::Mesh;
use crate::parallel;
use crate::pfem2::phases::FluidRegion;
use std::collections::{BTreeMap, BTreeSet};

/// Nodes per piece of a parallel loop.
const PIECE: usize = 64;

/// The mean slope of an interface at the surface of a solid, over its mean steepness there, below which it says nothing
/// about the inside: where water stands around a solid on all sides, slopes cancel each other.
const LEAST_COMMON_SLOPE: f64 = 0.5;

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

/// φ in which the interface goes on inside of solids from where it meets their surface: row by row, with the mean slope
/// that it has at the surface of the solid, (G.29a). Nodes outside have `level` [m]; inside of solids that no interface
/// meets, or that one surrounds, there is none.
///
/// [`continue_level`] goes on from all sides, and its zero inside moves with φ above and below the solid. Distances
/// from that would come back to these: on top of a floating box they fell from four elements to nothing in a second.
pub fn continue_interface<const D: usize, const N: usize>(
    region: &FluidRegion<D, N>,
    level: &[f64],
) -> Vec<Option<f64>> {
    let mut all: Vec<Option<f64>> = level.iter().copied().map(Some).collect();
    region.covered().for_each(|node| all[node] = None);
    let mut met: BTreeMap<usize, Vector<D>> = region
        .covered_beside_fluid()
        .into_iter()
        .filter_map(|node| Some((node, slope_where_crossed(region, node, level)?)))
        .collect();
    while let Some((&first, _)) = met.first_key_value() {
        let solid = connected(region, first);
        let own: Vec<(usize, Vector<D>)> = solid.iter().filter_map(|node| Some((*node, met.remove(node)?))).collect();
        let slope = own.iter().map(|(_, slope)| *slope).sum::<Vector<D>>() / own.len() as f64;
        let steepness = own.iter().map(|(_, slope)| slope.norm()).sum::<f64>() / own.len() as f64;
        if slope.norm() < LEAST_COMMON_SLOPE * steepness {
            continue;
        }
        let mut known: BTreeMap<usize, f64> = own.iter().map(|&(node, _)| (node, level[node])).collect();
        let mut rest: Vec<usize> = solid.into_iter().filter(|node| !known.contains_key(node)).collect();
        while !rest.is_empty() {
            let row = parallel::collect(rest.len(), PIECE, |n| beside(region.mesh, rest[n], &known, slope));
            known.extend(rest.iter().zip(&row).filter_map(|(&node, phi)| Some((node, (*phi)?))));
            rest.retain(|node| !known.contains_key(node));
        }
        known.into_iter().for_each(|(node, phi)| all[node] = Some(phi));
    }
    all
}

/// The nodes inside of solids that are connected with this one by nodes inside of solids, ascending.
fn connected<const D: usize, const N: usize>(region: &FluidRegion<D, N>, first: usize) -> BTreeSet<usize> {
    let (mut found, mut next) = (BTreeSet::from([first]), vec![first]);
    while let Some(node) = next.pop() {
        let covered = neighbours(region.mesh, node).filter(|&other| region.is_covered(other));
        next.extend(covered.filter(|&other| found.insert(other)));
    }
    found
}

/// φ at a node from the nodes around it that are known, with this slope; `None` where none is.
fn beside<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    node: usize,
    known: &BTreeMap<usize, f64>,
    slope: Vector<D>,
) -> Option<f64> {
    let (mut sum, mut count) = (0.0, 0.0);
    for (other, phi) in neighbours(mesh, node).filter_map(|other| Some((other, known.get(&other)?))) {
        sum += phi + (mesh.nodes()[node] - mesh.nodes()[other]).dot(slope);
        count += 1.0;
    }
    (count > 0.0).then(|| sum / count)
}

/// The mean gradient of the elements that φ crosses around a node inside of a solid and around those of its neighbours,
/// by the fluid that they hold: beside the solid φ is that of its particles. `None` where the interface doesn't meet the
/// solid at the node.
fn slope_where_crossed<const D: usize, const N: usize>(
    region: &FluidRegion<D, N>,
    node: usize,
    level: &[f64],
) -> Option<Vector<D>> {
    let mesh = region.mesh;
    let crossed = |e: &usize| {
        let negative = |&k: &u32| level[k as usize] < 0.0;
        let nodes = &mesh.elements()[*e];
        nodes.iter().any(negative) && !nodes.iter().all(negative) && region.volume(*e) > 0.0
    };
    let around = |node: usize| mesh.elements_around(node).iter().map(|&e| e as usize).filter(crossed);
    let beside: BTreeSet<usize> = around(node).flat_map(|e| mesh.elements()[e]).map(|other| other as usize).collect();
    let elements: BTreeSet<usize> = beside.into_iter().flat_map(around).collect();
    let (mut sum, mut volume) = (Vector::ZERO, 0.0);
    for e in elements {
        let (nodes, fluid) = (&mesh.elements()[e], region.volume(e));
        let gradient = &mesh.simplex(e).gradient;
        sum += nodes.iter().zip(gradient).map(|(&k, &g)| g * level[k as usize]).sum::<Vector<D>>() * fluid;
        volume += fluid;
    }
    (volume > 0.0).then(|| sum / volume)
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
