//! Points on the surface of a region that is filled with particles, carried along by the particles (theory D.9).
//!
//! ```text
//! s = Σ_p w_p x_p,   Σ w_p = 1,   Σ w_p X_p = S        exact for every affine motion of the particles around S
//! w_p = 1/n + (X_p − C)·M⁻¹(S − C),   M = Σ (X_p − C)⊗(X_p − C),   C = Σ X_p/n      (the smallest such weights)
//! ```
//!
//! A lattice fills a curved body with steps: the lowest particles of a ball of radius R on a lattice of spacing h make
//! a flat disc of radius √(Rh), on which it would land. The points S are the corners of the lattice cells that lie
//! within half a spacing of the true surface, moved onto it: about one for each h².

use super::{Region, Sample};
use crate::math::dense::solve_semidefinite;
use hashbrown::HashMap;

/// A point on the surface.
#[derive(Debug, Clone, PartialEq)]
pub struct SkinPoint {
    /// Index of a particle, and its weight w_p.
    pub members: Vec<(u32, f64)>,
    /// The residual |S − Σ w_p X_p| [m], which is not zero if the particles lie in one plane or line.
    pub radius: f64,
}

/// A point is reached if the residual is smaller than this [spacings].
const REACHED: f64 = 1e-6;

/// Directions in which particles spread less than this part of the largest, of squares of lengths, are left out.
const LEAST_PIVOT: f64 = 1e-9;

type SpacingCell = [i64; 3];

/// The points on the surface of `region` for the particles of `sample`, in an order that depends on nothing else.
pub fn skin(region: &Region, sample: &Sample, dimension: usize) -> Vec<SkinPoint> {
    let deep = |layers: f64| move |x: &[f64; 3]| region.signed_distance(*x) > -layers * sample.spacing;
    let mut cells: HashMap<SpacingCell, u32> = HashMap::new();
    let mut corners: Vec<SpacingCell> = Vec::new();
    for (p, x) in (0..).zip(&sample.position) {
        if !deep(4.0)(x) {
            continue;
        }
        let cell = sample.lattice_index(*x);
        cells.insert(cell, p);
        if deep(1.5)(x) {
            corners.extend(
                (0..1 << dimension).map(|n| -> SpacingCell { std::array::from_fn(|a| cell[a] + (n >> a & 1)) }),
            );
        }
    }
    corners.sort_unstable();
    corners.dedup();
    corners.into_iter().filter_map(|corner| point(region, sample, dimension, &cells, corner)).collect()
}

/// The point of one corner of the lattice, if the surface is near.
fn point(
    region: &Region,
    sample: &Sample,
    dimension: usize,
    cells: &HashMap<SpacingCell, u32>,
    corner: SpacingCell,
) -> Option<SkinPoint> {
    let h = sample.spacing;
    let mut s: [f64; 3] =
        std::array::from_fn(|a| if a < dimension { sample.origin[a] + corner[a] as f64 * h } else { 0.0 });
    let (distance, normal) = region.distance_and_normal(s);
    if distance.abs() > 0.5 * h * (1.0 + 1e-9) {
        return None;
    }
    for _ in 0..2 {
        let (distance, normal) = region.distance_and_normal(s);
        s = std::array::from_fn(|a| s[a] - distance * normal[a]);
    }
    let along = (0..dimension).max_by(|&a, &b| normal[a].abs().total_cmp(&normal[b].abs()))?;
    let block = |wide: bool| -> Vec<u32> {
        let range = |a: usize| match a {
            _ if a >= dimension => 0..1,
            _ if wide || a == along => -2..2,
            _ => -1..1,
        };
        let lines = range(2).flat_map(|k| range(1).map(move |j| (j, k)));
        let row = |(j, k)| range(0).filter_map(move |i| cells.get(&[corner[0] + i, corner[1] + j, corner[2] + k]));
        lines.flat_map(row).copied().collect()
    };
    let near = fit(&block(false), sample, s)?;
    if near.radius <= REACHED * h { Some(near) } else { fit(&block(true), sample, s) }
}

/// The weights of these particles that make `s`.
fn fit(particles: &[u32], sample: &Sample, s: [f64; 3]) -> Option<SkinPoint> {
    let place = |p: u32| sample.position[p as usize];
    let n = particles.len() as f64;
    let centre: [f64; 3] = std::array::from_fn(|a| particles.iter().map(|&p| place(p)[a]).sum::<f64>() / n);
    let arm = |x: [f64; 3]| -> [f64; 3] { std::array::from_fn(|a| x[a] - centre[a]) };
    let mut matrix = [[0.0; 3]; 3];
    for &p in particles {
        let d = arm(place(p));
        (0..3).for_each(|i| (0..3).for_each(|j| matrix[i][j] += d[i] * d[j]));
    }
    let slope = solve_semidefinite(matrix, arm(s), LEAST_PIVOT);
    let dot = |a: [f64; 3], b: [f64; 3]| (0..3).map(|i| a[i] * b[i]).sum::<f64>();
    let members: Vec<_> = particles.iter().map(|&p| (p, 1.0 / n + dot(arm(place(p)), slope))).collect();
    let made = |a: usize| members.iter().map(|&(p, w)| w * place(p)[a]).sum::<f64>();
    let radius = (0..3).map(|a| (s[a] - made(a)).powi(2)).sum::<f64>().sqrt();
    (!members.is_empty()).then_some(SkinPoint { members, radius })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{centred_origin, sample};

    fn skin_of(region: &Region, spacing: f64, dimension: usize) -> (Sample, Vec<SkinPoint>) {
        let origin = centred_origin(region, spacing, dimension).unwrap();
        let sample = sample(region, spacing, dimension, origin).unwrap();
        let skin = skin(region, &sample, dimension);
        (sample, skin)
    }

    /// The points lie on the sphere, cover it with about one per h², and stay on it when it turns and is stretched.
    #[test]
    fn the_skin_of_a_ball_follows_it() {
        let region = Region::Sphere { center: [0.3, 0.2, 0.1], radius: 4.5 };
        let (sample, skin) = skin_of(&region, 0.5, 3);
        let area = 4.0 * std::f64::consts::PI * 4.5 * 4.5 / 0.25;
        assert!((0.7..1.5).contains(&(skin.len() as f64 / area)), "{} {area}", skin.len());
        let lowest = skin.iter().map(|point| place(&sample, point, |x| x)[2]).fold(f64::INFINITY, f64::min);
        assert!((lowest - (0.1 - 4.5)).abs() < 1e-12, "{lowest}");
        // x → (y, −1.1 x, z): a quarter turn and a stretch.
        for point in &skin {
            let [x, y, z] = place(&sample, point, |x| [x[1], -1.1 * x[0], x[2]]);
            let back = ((y / -1.1 - 0.3).powi(2) + (x - 0.2).powi(2) + (z - 0.1).powi(2)).sqrt();
            assert!((back - 4.5).abs() < 1e-9 && point.radius < 1e-9, "{back} {point:?}");
        }
    }

    /// A box has its corners; a plate of one layer reaches its faces by a radius of half the thickness.
    #[test]
    fn boxes_keep_their_corners_and_plates_their_thickness() {
        let region = Region::Box { lower: [0.0; 3], upper: [2.0, 1.0, 1.0] };
        let (sample, skin) = skin_of(&region, 0.25, 3);
        for corner in [[0.0, 0.0, 0.0], [2.0, 1.0, 1.0], [2.0, 0.0, 1.0]] {
            let near = |point: &SkinPoint| {
                let x = place(&sample, point, |x| x);
                (0..3).all(|a| (x[a] - corner[a]).abs() < 1e-12)
            };
            assert!(skin.iter().any(near), "{corner:?}");
        }
        let plate = Region::Box { lower: [0.0; 3], upper: [2.0, 1.0, 0.25] };
        let (_, skin) = skin_of(&plate, 0.25, 3);
        assert!(!skin.is_empty() && skin.iter().all(|point| (point.radius - 0.125).abs() < 1e-12));
    }

    fn place(sample: &Sample, point: &SkinPoint, map: impl Fn([f64; 3]) -> [f64; 3]) -> [f64; 3] {
        let x = |p: u32| map(sample.position[p as usize]);
        std::array::from_fn(|a| point.members.iter().map(|&(p, w)| w * x(p)[a]).sum())
    }
}
