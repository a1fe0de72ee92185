//! Meshes of simplices: triangles in 2D, tetrahedra in 3D.
//!
//! ```text
//! V_e = det[x_1 − x_0, …, x_D − x_0] / D!
//! N_k(x) = δ_k0 + g_k·(x − x_0),   g_k = ∇N_k constant,   Σ_k N_k = 1
//! area vector of the facet opposite node k, outward: −D V_e g_k
//! ```

mod file;
mod lattice;
mod locate;
mod topology;

pub use lattice::{CellCut, side_names};
pub use locate::{Location, Locator};
pub use topology::Facet;

use crate::math::{Tensor, Vector};
use std::collections::BTreeMap;
use topology::Topology;

/// A mesh of triangles (`Mesh<2, 3>`) or tetrahedra (`Mesh<3, 4>`).
#[derive(Debug, Clone)]
pub struct Mesh<const D: usize, const N: usize> {
    nodes: Vec<Vector<D>>,
    elements: Vec<[u32; N]>,
    simplices: Vec<Simplex<D, N>>,
    topology: Topology<N>,
    /// Named sets of boundary facets (physical groups of a Gmsh file).
    pub sets: BTreeMap<String, Vec<Facet>>,
    /// Number of facets inside the mesh by physical group, for groups that have any.
    pub inner: BTreeMap<String, usize>,
    /// Nodes of the file that no element uses [m]: they were left out.
    pub isolated: Vec<Vector<D>>,
}

/// Constants of an element.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Simplex<const D: usize, const N: usize> {
    /// Volume [m³]; area [m²] in 2D.
    pub volume: f64,
    /// Gradient of the shape function of each node [1/m].
    pub gradient: [Vector<D>; N],
}

impl<const D: usize, const N: usize> Simplex<D, N> {
    /// The simplex with nodes at these positions [m]; `None` if it has no volume. The volume of an inverted one is
    /// negative.
    pub fn new(x: [Vector<D>; N]) -> Option<Self> {
        const { assert!(N == D + 1, "a simplex in D dimensions has D + 1 nodes") };
        let edges = Tensor::<D>::from_fn(|i, j| x[j + 1][i] - x[0][i]).embed(1.0);
        let inverse = edges.inverse()?;
        let mut gradient = [Vector::ZERO; N];
        for k in 1..N {
            gradient[k] = Vector::from_fn(|i| inverse[k - 1][i]);
            gradient[0] -= gradient[k];
        }
        let factorial = if D == 2 { 2.0 } else { 6.0 };
        let volume = edges.determinant() / factorial;
        (volume != 0.0 && volume.is_finite()).then_some(Self { volume, gradient })
    }

    /// Outward area vector of the facet opposite node `k` [m²]; [m] in 2D.
    pub fn facet_area(&self, k: usize) -> Vector<D> {
        self.gradient[k] * (-(D as f64) * self.volume)
    }
}

impl<const D: usize, const N: usize> Mesh<D, N> {
    /// The mesh of node positions [m] and the nodes of each element: counter-clockwise in 2D; in 3D the first three
    /// counter-clockwise seen from the side away from the fourth.
    ///
    /// # Errors
    /// No elements, a node that isn't there or isn't finite, an element that is degenerate or inverted, a facet
    /// shared by more than two elements or by two on one side of it. The message names the element.
    pub fn new(nodes: Vec<Vector<D>>, elements: Vec<[u32; N]>) -> Result<Self, String> {
        Self::numbered(nodes, elements, &|element| element as i64)
    }

    /// [`Mesh::new`], with the numbers by which messages call the elements.
    fn numbered(nodes: Vec<Vector<D>>, elements: Vec<[u32; N]>, number: &dyn Fn(usize) -> i64) -> Result<Self, String> {
        if elements.is_empty() {
            return Err("the mesh has no elements".into());
        }
        if let Some(node) = nodes.iter().position(|x| !x.is_finite()) {
            return Err(format!("node {node} has a position that is not finite"));
        }
        let simplices = simplices(&nodes, &elements, number)?;
        let topology = Topology::new(&elements, nodes.len(), number)?;
        let (sets, inner) = (BTreeMap::new(), BTreeMap::new());
        Ok(Self { nodes, elements, simplices, topology, sets, inner, isolated: Vec::new() })
    }

    /// Node positions [m].
    pub fn nodes(&self) -> &[Vector<D>] {
        &self.nodes
    }

    /// Nodes of each element.
    pub fn elements(&self) -> &[[u32; N]] {
        &self.elements
    }

    /// Volume and gradients of an element.
    pub fn simplex(&self, element: usize) -> &Simplex<D, N> {
        &self.simplices[element]
    }

    /// Positions of an element's nodes [m].
    pub fn corners(&self, element: usize) -> [Vector<D>; N] {
        self.elements[element].map(|node| self.nodes[node as usize])
    }

    /// Shape functions of an element at `x`; all lie in 0..=1 inside.
    pub fn shape_functions(&self, element: usize, x: Vector<D>) -> [f64; N] {
        let away = x - self.nodes[self.elements[element][0] as usize];
        let gradient = &self.simplices[element].gradient;
        std::array::from_fn(|k| gradient[k].dot(away) + if k == 0 { 1.0 } else { 0.0 })
    }

    /// Centre of an element [m].
    pub fn center(&self, element: usize) -> Vector<D> {
        self.corners(element).into_iter().sum::<Vector<D>>() / N as f64
    }

    /// Shortest edge of an element [m].
    pub fn shortest_edge(&self, element: usize) -> f64 {
        let x = self.corners(element);
        let pairs = (0..N).flat_map(|i| (i + 1..N).map(move |j| (i, j)));
        pairs.map(|(i, j)| (x[j] - x[i]).norm()).fold(f64::INFINITY, f64::min)
    }

    /// Volume of the mesh [m³]; area [m²] in 2D.
    pub fn volume(&self) -> f64 {
        self.simplices.iter().map(|simplex| simplex.volume).sum()
    }

    /// The element behind the facet opposite local node `k`, or `None` at the boundary.
    pub fn neighbour(&self, element: usize, k: usize) -> Option<usize> {
        self.topology.neighbour(element, k)
    }

    /// Elements around a node, ascending.
    pub fn elements_around(&self, node: usize) -> &[u32] {
        self.topology.around(node)
    }

    /// The piece that each element belongs to, numbered by first elements, and how many pieces there are. Elements that
    /// share a node are of one piece.
    pub fn pieces(&self) -> (Vec<usize>, usize) {
        const NONE: usize = usize::MAX;
        let mut piece = vec![NONE; self.elements.len()];
        let mut reached = vec![false; self.nodes.len()];
        let mut count = 0;
        for first in 0..self.elements.len() {
            if piece[first] != NONE {
                continue;
            }
            piece[first] = count;
            let mut open = vec![first];
            while let Some(element) = open.pop() {
                for node in self.elements[element].map(|node| node as usize) {
                    if std::mem::replace(&mut reached[node], true) {
                        continue;
                    }
                    let new = self.elements_around(node).iter().map(|&e| e as usize).filter(|&e| piece[e] == NONE);
                    let new: Vec<usize> = new.collect();
                    new.iter().for_each(|&e| piece[e] = count);
                    open.extend(new);
                }
            }
            count += 1;
        }
        (piece, count)
    }

    /// Facets that belong to one element only, in the order of the elements.
    pub fn boundary(&self) -> &[Facet] {
        self.topology.boundary()
    }

    /// Nodes of a facet, in the order of its element.
    pub fn facet_nodes(&self, facet: Facet) -> Vec<u32> {
        topology::facet_nodes(&self.elements[facet.element as usize], facet.opposite as usize)
    }

    /// Outward area vector of a facet [m²]; [m] in 2D.
    pub fn facet_area(&self, facet: Facet) -> Vector<D> {
        self.simplices[facet.element as usize].facet_area(facet.opposite as usize)
    }
}

/// The reason why an element is unusable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Unsound {
    /// It names a node that isn't there.
    Missing(u32),
    /// Its volume is negative.
    Inverted,
    /// It has no volume.
    Degenerate,
}

/// The simplices of all elements, whose nodes must be there and whose volumes must be positive.
fn simplices<const D: usize, const N: usize>(
    nodes: &[Vector<D>],
    elements: &[[u32; N]],
    number: &dyn Fn(usize) -> i64,
) -> Result<Vec<Simplex<D, N>>, String> {
    let checked: Vec<_> = elements.iter().map(|element| sound(element, nodes)).collect();
    let Some((first, fault)) = checked.iter().enumerate().find_map(|(e, simplex)| Some((e, simplex.err()?))) else {
        return Ok(checked.into_iter().flatten().collect());
    };
    let same = checked.iter().filter(|simplex| simplex.err() == Some(fault)).count();
    let others = if same > 1 { format!(", and {} more", same - 1) } else { String::new() };
    let name = number(first);
    if let Unsound::Missing(node) = fault {
        return Err(format!("element {name} names node {node}, but there are only {} nodes", nodes.len()));
    }
    let center = elements[first].iter().map(|&n| nodes[n as usize]).sum::<Vector<D>>() / N as f64;
    let place = center.0.map(|c| format!("{c:.6}")).join(", ");
    let (what, why) = match fault {
        Unsound::Inverted => ("inverted", "its volume is negative; reverse its order of nodes (`ReverseMesh` in Gmsh)"),
        _ => ("degenerate", "it has no volume; mesh the geometry anew"),
    };
    Err(format!("element {name} at ({place}) m is {what}{others}: {why}"))
}

/// The simplex of an element.
fn sound<const D: usize, const N: usize>(element: &[u32; N], nodes: &[Vector<D>]) -> Result<Simplex<D, N>, Unsound> {
    const THINNEST: f64 = 1e-12;
    if let Some(&node) = element.iter().find(|&&node| node as usize >= nodes.len()) {
        return Err(Unsound::Missing(node));
    }
    let x = element.map(|node| nodes[node as usize]);
    let longest = (1..N).map(|k| (x[k] - x[0]).norm()).fold(0.0, f64::max);
    let least = THINNEST * longest.powi(D as i32);
    match Simplex::new(x) {
        Some(simplex) if simplex.volume > least => Ok(simplex),
        Some(simplex) if simplex.volume < -least => Err(Unsound::Inverted),
        _ => Err(Unsound::Degenerate),
    }
}
