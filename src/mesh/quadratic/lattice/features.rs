//! Features of a closed surface of triangles: smooth patches, the sharp edges between them, corners.

use crate::geometry::{IndexedTriangle, Triangles};
use crate::math::Vector;
use rstar::{AABB, RTree};
use std::collections::BTreeMap;

/// Cosines of the angle between the normals of two triangles beyond which their common edge is sharp: 40°; 60° where
/// elements can't follow the edges of less.
pub const SHARP_COSINES: [f64; 2] = [0.766, 0.5];

/// A vertex with a smaller sum of angles is the point of a cone, which is 90° wide at most. At those of an icosahedron it is 5π/3.
const APEX_ANGLE: f64 = 4.5;

/// A sharp edge between two patches is concave if more than this part of its length is.
const CONCAVE_PART: f64 = 0.1;

/// A surface with its features. A patch keeps its number when others are merged into it.
pub struct Features {
    triangles: Triangles,
    normals: Vec<Vector<3>>,
    /// Patch of each triangle.
    patch_of: Vec<u32>,
    /// The triangles of each patch; none of one that was merged into another.
    patches: Vec<RTree<IndexedTriangle>>,
    /// Sharp edges between two patches, the lower first.
    edges: BTreeMap<[u32; 2], FeatureEdge>,
    corners: Vec<FeatureVertex>,
    /// Points of cones, each on one patch.
    apexes: Vec<FeatureVertex>,
}

/// The sharp edge between two patches.
struct FeatureEdge {
    segments: RTree<IndexedTriangle>,
    /// Length [m].
    length: f64,
    concave: bool,
}

/// A corner, a vertex at which three patches or more meet, or the point of a cone.
pub struct FeatureVertex {
    /// Place [m].
    pub place: Vector<3>,
    /// Patches, ascending.
    pub patches: Vec<u32>,
}

/// An edge of the triangles.
struct TriangleEdge {
    ends: [u32; 2],
    triangles: [usize; 2],
}

impl Features {
    /// The features of a closed surface whose triangles point outward.
    pub fn new(triangles: Triangles, sharp_cosine: f64) -> Self {
        let normals = normals(&triangles);
        let mut root: Vec<usize> = (0..normals.len()).collect();
        for side in sides(&triangles) {
            let [a, b] = side.triangles;
            if normals[a].dot(normals[b]) > sharp_cosine {
                let (a, b) = (find(&mut root, a), find(&mut root, b));
                root[a.max(b)] = a.min(b);
            }
        }
        let mut number = BTreeMap::new();
        let mut patch_of = Vec::with_capacity(root.len());
        for triangle in 0..root.len() {
            let next = number.len() as u32;
            patch_of.push(*number.entry(find(&mut root, triangle)).or_insert(next));
        }
        let mut features = Self {
            triangles,
            normals,
            patch_of,
            patches: Vec::new(),
            edges: BTreeMap::new(),
            corners: Vec::new(),
            apexes: Vec::new(),
        };
        features.gather(number.len());
        features
    }

    /// Sorts triangles, sharp edges and corners by patches.
    fn gather(&mut self, count: usize) {
        let corner = |v: u32| Vector(self.triangles.vertices[v as usize]);
        let mut facets = vec![Vec::new(); count];
        for (index, t) in self.triangles.triangles.iter().enumerate() {
            facets[self.patch_of[index] as usize].push(IndexedTriangle { index, corners: t.map(corner) });
        }
        self.patches = facets.into_iter().map(RTree::bulk_load).collect();
        let mut segments: BTreeMap<[u32; 2], (Vec<IndexedTriangle>, [f64; 2])> = BTreeMap::new();
        let mut around: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for (index, side) in sides(&self.triangles).into_iter().enumerate() {
            let [p, q] = side.triangles.map(|t| self.patch_of[t]);
            if p == q {
                continue;
            }
            let [a, b] = side.ends.map(corner);
            let (own, length) = segments.entry([p.min(q), p.max(q)]).or_default();
            own.push(IndexedTriangle { index, corners: [a, b, b] });
            length[usize::from(self.is_concave(&side))] += (b - a).norm();
            side.ends.iter().for_each(|&v| around.entry(v).or_default().extend([p, q]));
        }
        let edge = |(own, [convex, concave]): (Vec<IndexedTriangle>, [f64; 2])| FeatureEdge {
            segments: RTree::bulk_load(own),
            length: convex + concave,
            concave: concave > CONCAVE_PART * (convex + concave),
        };
        self.edges = segments.into_iter().map(|(patches, own)| (patches, edge(own))).collect();
        let meeting = around.into_iter().map(|(v, mut patches)| {
            patches.sort_unstable();
            patches.dedup();
            FeatureVertex { place: corner(v), patches }
        });
        self.corners = meeting.filter(|corner| corner.patches.len() > 2).collect();
        self.apexes = self.find_apexes();
    }

    /// Vertices inside of a patch around which there is little angle.
    fn find_apexes(&self) -> Vec<FeatureVertex> {
        let mut angles: BTreeMap<u32, (f64, Vec<u32>)> = BTreeMap::new();
        for (t, &patch) in self.triangles.triangles.iter().zip(&self.patch_of) {
            let x = t.map(|v| Vector(self.triangles.vertices[v as usize]));
            for k in 0..3 {
                let (a, b) = (x[(k + 1) % 3] - x[k], x[(k + 2) % 3] - x[k]);
                let (angle, patches) = angles.entry(t[k]).or_default();
                *angle += a.cross(b).norm().atan2(a.dot(b));
                patches.push(patch);
            }
        }
        let pointed = angles.into_iter().filter_map(|(v, (angle, mut patches))| {
            patches.dedup();
            let place = Vector(self.triangles.vertices[v as usize]);
            (patches.len() == 1 && angle < APEX_ANGLE).then_some(FeatureVertex { place, patches })
        });
        pointed.collect()
    }

    fn is_concave(&self, side: &TriangleEdge) -> bool {
        let [first, second] = side.triangles;
        let start = Vector(self.triangles.vertices[side.ends[0] as usize]);
        let others = self.triangles.triangles[second].map(|v| Vector(self.triangles.vertices[v as usize]) - start);
        others.into_iter().map(|x| x.dot(self.normals[first])).sum::<f64>() > 0.0
    }

    /// Number of patches, those that were merged into others among them.
    pub fn patch_count(&self) -> usize {
        self.patches.len()
    }

    /// Joins each patch that isn't `marked` to a neighbour that is, or was joined to one: always the pair with the longest
    /// common edge first.
    pub fn merge_unmarked(&mut self, marked: &[bool]) {
        let mut into: Vec<u32> = (0..self.patches.len() as u32).collect();
        let mut settled = marked.to_vec();
        loop {
            let mut shared: BTreeMap<[u32; 2], f64> = BTreeMap::new();
            for (&[p, q], edge) in &self.edges {
                for [from, to] in [[p, q], [q, p]] {
                    if !settled[from as usize] && settled[to as usize] {
                        *shared.entry([from, into[to as usize]]).or_default() += edge.length;
                    }
                }
            }
            let longest = shared.into_iter().reduce(|best, other| if other.1 > best.1 { other } else { best });
            let Some(([from, to], _)) = longest else { break };
            (into[from as usize], settled[from as usize]) = (to, true);
        }
        self.patch_of.iter_mut().for_each(|patch| *patch = into[*patch as usize]);
        self.gather(self.patches.len());
    }

    /// The place of a patch nearest to `x`, and the normal there. `None` for a patch without triangles.
    pub fn on_patch(&self, patch: u32, x: Vector<3>) -> Option<(Vector<3>, Vector<3>)> {
        let nearest = self.patches[patch as usize].nearest_neighbor(x.0)?;
        Some((nearest.nearest(x), self.normals[nearest.index]))
    }

    /// The place of the sharp edge between two patches nearest to `x`, and the direction there.
    pub fn on_edge(&self, patches: [u32; 2], x: Vector<3>) -> Option<(Vector<3>, Vector<3>)> {
        let nearest = self.edges.get(&patches)?.segments.nearest_neighbor(x.0)?;
        let [a, b, _] = nearest.corners;
        Some((nearest.nearest(x), (b - a).normalized()?))
    }

    /// Patches that may lie within a distance of `x` [m]; ascending.
    pub fn patches_near(&self, x: Vector<3>, distance: f64) -> impl Iterator<Item = u32> + '_ {
        let box_of = |patch: &RTree<IndexedTriangle>| patch.root().envelope();
        let away = move |around: AABB<[f64; 3]>| around.distance_2(&x.0);
        let near = move |patch: &RTree<IndexedTriangle>| patch.size() > 0 && away(box_of(patch)) <= distance * distance;
        (0u32..).zip(&self.patches).filter(move |(_, patch)| near(patch)).map(|(number, _)| number)
    }

    /// Pairs of patches that meet at a concave edge.
    pub fn concave(&self) -> impl Iterator<Item = [u32; 2]> + '_ {
        self.edges.iter().filter(|(_, edge)| edge.concave).map(|(&patches, _)| patches)
    }

    /// Corners, in the order of the vertices.
    pub fn corners(&self) -> &[FeatureVertex] {
        &self.corners
    }

    /// Points of cones, in the order of the vertices.
    pub fn apexes(&self) -> &[FeatureVertex] {
        &self.apexes
    }
}

/// Outward unit normals of the triangles.
pub fn normals(surface: &Triangles) -> Vec<Vector<3>> {
    let normal = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|v| Vector(surface.vertices[v as usize]));
        (b - a).cross(c - a).normalized().unwrap_or(Vector::unit(0))
    };
    surface.triangles.iter().map(normal).collect()
}

/// Edges of a closed surface, each with its two triangles, in the order of their ends.
fn sides(surface: &Triangles) -> Vec<TriangleEdge> {
    let mut first: BTreeMap<[u32; 2], usize> = BTreeMap::new();
    let mut found = Vec::new();
    for (index, t) in surface.triangles.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            let ends = [a.min(b), a.max(b)];
            match first.get(&ends) {
                Some(&other) => found.push(TriangleEdge { ends, triangles: [other, index] }),
                None => _ = first.insert(ends, index),
            }
        }
    }
    found.sort_by_key(|side| side.ends);
    found
}

/// The root of a member of disjoint sets (Tarjan 1975), with halved paths.
pub fn find(root: &mut [usize], mut member: usize) -> usize {
    while root[member] != member {
        root[member] = root[root[member]];
        member = root[member];
    }
    member
}
