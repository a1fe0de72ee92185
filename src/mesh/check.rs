//! Checks of the mesh of a membrane.

use super::Facets;
use super::facets::edges;
use crate::math::Vector;
use hashbrown::HashMap;
use std::fmt;

/// Thinnest element: area against the square of its longest side.
const THINNEST: f64 = 1e-10;

/// Nodes nearer than this, as a fraction of the mesh's extent, are the same.
const SAME_NODE_DISTANCE: f64 = 1e-12;

/// One finding about a mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// The problem.
    pub problem: Problem,
    /// Place of the flaw: the centre of the element, or the node [m].
    pub place: [f64; 3],
    /// Names of the element or node, and of its neighbour, in the message.
    called: [i64; 2],
}

/// Kinds of problems. Elements and nodes are counted from 0 in the order of the mesh; messages name them as the mesh's
/// file does, if there is one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Problem {
    /// The mesh has no elements.
    Empty,
    /// An element names a node that isn't there, or doesn't have 2, 3 or 4 nodes.
    Malformed {
        /// The element.
        element: usize,
    },
    /// A node's position is not finite.
    NotFinite {
        /// The node.
        node: u32,
    },
    /// An element covers nothing.
    Degenerate {
        /// The element.
        element: usize,
    },
    /// A quadrilateral whose sides cross, or with a corner that points inward.
    Folded {
        /// The element.
        element: usize,
    },
    /// An element whose normal points to the other side than that of its neighbour.
    Inverted {
        /// The element.
        element: usize,
        /// A neighbour.
        neighbour: usize,
    },
    /// More than two elements meet at an edge.
    NonManifold {
        /// One of the elements.
        element: usize,
        /// Number of elements that meet.
        count: usize,
    },
    /// Two nodes at one place: the mesh has a slit there.
    DuplicateNodes {
        /// The nodes.
        nodes: [u32; 2],
    },
    /// A node that no element uses.
    Unreferenced {
        /// The node.
        node: u32,
    },
}

impl Problem {
    /// True if a membrane can't be made of the mesh; the others may be intended.
    pub fn is_error(&self) -> bool {
        !matches!(self, Self::NonManifold { .. } | Self::DuplicateNodes { .. } | Self::Unreferenced { .. })
    }
}

impl Finding {
    fn new(problem: Problem, place: [f64; 3]) -> Self {
        Self { problem, place, called: [0; 2] }
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [own, other] = self.called;
        match &self.problem {
            Problem::Empty => return f.write_str("the mesh has no elements"),
            Problem::Malformed { .. } => {
                return write!(f, "element {own} names a node that isn't there or has not 2, 3 or 4 nodes");
            }
            Problem::NotFinite { .. } => return write!(f, "node {own} has a position that is not finite"),
            Problem::Degenerate { .. } => write!(f, "element {own} covers nothing")?,
            Problem::Folded { .. } => write!(f, "element {own} is folded: sides cross or a corner points in")?,
            Problem::Inverted { .. } => {
                write!(f, "element {own} is inverted: its normal is opposite to that of element {other}")?;
            }
            Problem::NonManifold { count, .. } => write!(f, "{count} elements meet at an edge of element {own}")?,
            Problem::DuplicateNodes { .. } => write!(f, "nodes {own} and {other} lie at one place")?,
            Problem::Unreferenced { .. } => write!(f, "node {own} belongs to no element")?,
        }
        let [x, y, z] = self.place;
        write!(f, " (at {x:.6e}, {y:.6e}, {z:.6e} m)")
    }
}

impl Problem {
    /// The element or node, and its neighbour, as messages about `facets` call them.
    fn called(&self, facets: &Facets) -> [i64; 2] {
        let numbers = &facets.numbers;
        match *self {
            Self::Empty => [0; 2],
            Self::Malformed { element }
            | Self::Degenerate { element }
            | Self::Folded { element }
            | Self::NonManifold { element, .. } => [numbers.element(element); 2],
            Self::Inverted { element, neighbour } => [element, neighbour].map(|e| numbers.element(e)),
            Self::NotFinite { node } | Self::Unreferenced { node } => [numbers.node(node); 2],
            Self::DuplicateNodes { nodes } => nodes.map(|node| numbers.node(node)),
        }
    }
}

/// All findings about a mesh, element by element, then node by node; messages count as the mesh's file does.
pub fn check(facets: &Facets) -> Vec<Finding> {
    let mut findings = find(facets);
    findings.iter_mut().for_each(|finding| finding.called = finding.problem.called(facets));
    findings
}

fn find(facets: &Facets) -> Vec<Finding> {
    let unsound = unsound(facets);
    if !unsound.is_empty() {
        return unsound;
    }
    let mut findings = Vec::new();
    shapes(facets, &mut findings);
    neighbours(facets, &mut findings);
    duplicates(facets, &mut findings);
    unreferenced(facets, &mut findings);
    findings
}

/// Checks that all others depend on.
fn unsound(facets: &Facets) -> Vec<Finding> {
    let count = facets.nodes.len();
    let nowhere = |problem| Finding::new(problem, [0.0; 3]);
    if facets.elements.is_empty() {
        return vec![nowhere(Problem::Empty)];
    }
    let sound = |e: &[u32]| matches!(e.len(), 2..=4) && e.iter().all(|&n| (n as usize) < count);
    let malformed = facets.elements.iter().enumerate().filter(|(_, e)| !sound(e));
    let mut findings: Vec<_> = malformed.map(|(element, _)| nowhere(Problem::Malformed { element })).collect();
    let finite = |x: &[f64; 3]| x.iter().all(|c| c.is_finite());
    let not_finite = (0u32..).zip(&facets.nodes).filter(|(_, x)| !finite(x));
    findings.extend(not_finite.map(|(node, _)| nowhere(Problem::NotFinite { node })));
    findings
}

fn shapes(facets: &Facets, findings: &mut Vec<Finding>) {
    for (element, nodes) in facets.elements.iter().enumerate() {
        let x: Vec<_> = nodes.iter().map(|&n| Vector(facets.nodes[n as usize])).collect();
        let area = facets.area_vector(element);
        let longest = (0..x.len()).map(|i| (x[(i + 1) % x.len()] - x[i]).norm_squared()).fold(0.0, f64::max);
        let least = if x.len() == 2 { 0.0 } else { THINNEST * longest };
        let corner = |i: usize| (x[(i + 1) % 4] - x[i]).cross(x[(i + 3) % 4] - x[i]).dot(area);
        let problem = if area.norm() <= least {
            Problem::Degenerate { element }
        } else if x.len() == 4 && (0..4).any(|i| corner(i) <= THINNEST * area.norm_squared()) {
            Problem::Folded { element }
        } else {
            continue;
        };
        findings.push(Finding::new(problem, facets.center(element).0));
    }
}

/// An element's use of an edge: the edge's nodes in ascending order, the element, and whether it runs from the
/// lower to the higher node. In 2D the edge is a node, and the sense tells the first end from the second.
type Use = ([u32; 2], usize, bool);

fn edge_uses(facets: &Facets) -> Vec<Use> {
    let mut uses = Vec::new();
    for (element, nodes) in facets.elements.iter().enumerate() {
        for (place, [a, b]) in edges(nodes).enumerate() {
            let forward = if a == b { place == 0 } else { a < b };
            uses.push(([a.min(b), a.max(b)], element, forward));
        }
    }
    uses.sort_unstable();
    uses
}

fn neighbours(facets: &Facets, findings: &mut Vec<Finding>) {
    let mut shared = vec![0u32; facets.elements.len()];
    let mut pairs = Vec::new();
    for at_edge in edge_uses(facets).chunk_by(|a, b| a.0 == b.0) {
        match at_edge {
            [(_, first, one), (_, second, other)] => {
                shared[*first] += 1;
                shared[*second] += 1;
                if one == other {
                    pairs.push([*first, *second]);
                }
            }
            [_] => {}
            more => {
                let problem = Problem::NonManifold { element: more[0].1, count: more.len() };
                findings.push(Finding::new(problem, facets.center(more[0].1).0));
            }
        }
    }
    let inverted = |[element, neighbour]: [usize; 2]| {
        Finding::new(Problem::Inverted { element, neighbour }, facets.center(element).0)
    };
    findings.extend(blame(&shared, &pairs).into_iter().map(inverted));
}

/// Of neighbours that disagree the one is inverted that disagrees with the greater fraction of its neighbours,
/// or with more of them; if both do alike, the later one.
fn blame(shared: &[u32], pairs: &[[usize; 2]]) -> Vec<[usize; 2]> {
    let mut disagreements = vec![0u32; shared.len()];
    pairs.iter().flatten().for_each(|&element| disagreements[element] += 1);
    let rank = |a: usize, b: usize| (disagreements[a] * shared[b], disagreements[a]);
    let mut blamed: Vec<[usize; 2]> = pairs
        .iter()
        .map(
            |&[first, second]| {
                if rank(first, second) > rank(second, first) { [first, second] } else { [second, first] }
            },
        )
        .collect();
    blamed.sort_unstable();
    blamed.dedup_by_key(|pair| pair[0]);
    blamed
}

/// Nodes in one cell of a lattice far finer than any element. Its cells are shifted so that round
/// coordinates lie well inside them.
fn duplicates(facets: &Facets, findings: &mut Vec<Finding>) {
    const SHIFT: f64 = 0.37;
    let extent = facets.nodes.iter().flatten().fold(f64::MIN_POSITIVE, |most, c| most.max(c.abs()));
    let cell = |c: f64| (c / (SAME_NODE_DISTANCE * extent) + SHIFT).floor() as i64;
    let mut first_in: HashMap<[i64; 3], u32> = HashMap::with_capacity(facets.nodes.len());
    for (node, &place) in (0u32..).zip(&facets.nodes) {
        let first = *first_in.entry(place.map(cell)).or_insert(node);
        if first != node {
            findings.push(Finding::new(Problem::DuplicateNodes { nodes: [first, node] }, place));
        }
    }
}

fn unreferenced(facets: &Facets, findings: &mut Vec<Finding>) {
    let mut used = vec![false; facets.nodes.len()];
    facets.elements.iter().flatten().for_each(|&node| used[node as usize] = true);
    for (node, place) in (0u32..).zip(&facets.nodes).filter(|(node, _)| !used[*node as usize]) {
        findings.push(Finding::new(Problem::Unreferenced { node }, *place));
    }
}
