//! Closed surfaces among facets: found by walking from neighbour to neighbour, whatever the sense of each facet.

use hashbrown::HashMap;

/// Facets that enclose something: every side belongs to two of them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ClosedSurface {
    /// The facets, and whether each has the opposite sense of the first: turned around, all of them look to one side.
    pub facets: Vec<(usize, bool)>,
}

impl ClosedSurface {
    /// True if all facets look to one side as they are.
    pub fn is_even(&self) -> bool {
        self.facets.iter().all(|(_, turned)| !turned)
    }
}

/// A side of a facet: its nodes, ascending; the end of a segment is one node twice.
type FacetSide = [u32; 2];

/// The closed surfaces among `facets` (2 nodes of a segment, 3 of a triangle, 4 of a quadrilateral). What has free
/// edges, edges of three facets, or one side only is not among them.
pub fn closed_surfaces<'a>(facets: impl Iterator<Item = &'a [u32]>) -> Vec<ClosedSurface> {
    let sides: Vec<Vec<(FacetSide, bool)>> = facets.map(|nodes| sides(nodes).collect()).collect();
    let mut meeting: HashMap<FacetSide, Vec<(usize, bool)>> = HashMap::new();
    for (facet, own) in sides.iter().enumerate() {
        own.iter().for_each(|&(side, forward)| meeting.entry(side).or_default().push((facet, forward)));
    }
    let mut turned: Vec<Option<bool>> = vec![None; sides.len()];
    (0..sides.len()).filter_map(|first| walk(first, &sides, &meeting, &mut turned)).collect()
}

/// The surface around a facet, if that is closed and has two sides and was not met before.
fn walk(
    first: usize,
    sides: &[Vec<(FacetSide, bool)>],
    meeting: &HashMap<FacetSide, Vec<(usize, bool)>>,
    turned: &mut [Option<bool>],
) -> Option<ClosedSurface> {
    if turned[first].is_some() {
        return None;
    }
    turned[first] = Some(false);
    let (mut facets, mut closed, mut next) = (vec![(first, false)], true, 0);
    while let Some(&(facet, sense)) = facets.get(next) {
        next += 1;
        for (side, forward) in &sides[facet] {
            let around = &meeting[side];
            closed &= around.len() == 2;
            for &(other, along) in around.iter().filter(|(other, _)| *other != facet) {
                // Two facets have normals to one side if they traverse their common edge in opposite senses.
                let wanted = sense ^ (along == *forward);
                match turned[other] {
                    Some(known) => closed &= known == wanted,
                    None => {
                        turned[other] = Some(wanted);
                        facets.push((other, wanted));
                    }
                }
            }
        }
    }
    closed.then_some(ClosedSurface { facets })
}

/// The sides of a facet, and whether it runs along each from the lower to the higher node; a segment begins at one end
/// and stops at the other.
fn sides(nodes: &[u32]) -> impl Iterator<Item = (FacetSide, bool)> + '_ {
    let n = nodes.len();
    (0..n).map(move |k| match n {
        2 => ([nodes[k]; 2], k == 0),
        _ => {
            let (a, b) = (nodes[k], nodes[(k + 1) % n]);
            ([a.min(b), a.max(b)], a < b)
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(facets: &[&[u32]]) -> Vec<ClosedSurface> {
        closed_surfaces(facets.iter().copied())
    }

    /// A tetrahedron; its first face stays, the third has the wrong sense.
    #[test]
    fn a_facet_of_the_wrong_sense_is_turned() {
        let mut faces: Vec<&[u32]> = vec![&[0, 2, 1], &[0, 1, 3], &[1, 2, 3], &[2, 0, 3]];
        assert!(found(&faces)[0].is_even());
        faces[2] = &[2, 1, 3];
        let surfaces = found(&faces);
        assert_eq!(surfaces.len(), 1);
        let mut facets = surfaces[0].facets.clone();
        facets.sort_unstable();
        assert_eq!(facets, [(0, false), (1, false), (2, true), (3, false)]);
    }

    #[test]
    fn free_edges_and_edges_of_three_facets_enclose_nothing() {
        assert!(found(&[&[0, 2, 1], &[0, 1, 3], &[1, 2, 3]]).is_empty());
        assert!(found(&[&[0, 2, 1], &[0, 1, 3], &[1, 2, 3], &[2, 0, 3], &[0, 1, 4]]).is_empty());
    }

    /// The projective plane with six corners: every edge belongs to two of its ten triangles.
    #[test]
    fn a_surface_with_one_side_encloses_nothing() {
        let plane: [&[u32]; 10] = [
            &[0, 1, 2],
            &[0, 2, 3],
            &[0, 3, 4],
            &[0, 4, 5],
            &[0, 5, 1],
            &[1, 2, 4],
            &[2, 3, 5],
            &[3, 4, 1],
            &[4, 5, 2],
            &[5, 1, 3],
        ];
        assert!(found(&plane).is_empty());
    }

    /// Two loops of segments in one chain, one of them with a segment of the wrong sense, and an open chain.
    #[test]
    fn every_loop_is_a_surface_of_its_own() {
        let chains: [&[u32]; 8] = [&[0, 1], &[1, 2], &[2, 0], &[3, 4], &[5, 4], &[5, 3], &[6, 7], &[7, 8]];
        let surfaces = found(&chains);
        assert_eq!(surfaces.len(), 2);
        assert!(surfaces[0].is_even() && !surfaces[1].is_even());
        let mut second = surfaces[1].facets.clone();
        second.sort_unstable();
        assert_eq!(second, [(3, false), (4, true), (5, false)]);
    }
}
