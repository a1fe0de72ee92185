//! Pressures that follow the surface of solids, with their load stiffness (theory J.16).
//!
//! ```text
//! f_a  = −∫ p N_a m dξ,      m = (t_y, −t_x) in the plane, t_0 × t_1 in space,      t_k = Σ_b x_b ∂N_b/∂ξ_k
//! ∂f_a/∂u_b = −∫ p N_a ∂m/∂x_b dξ
//! ```
//!
//! m is the normal away from the solid, as long as the deformed facet is large per dξ; p is positive where it pushes
//! into the solid. The derivative is not symmetric by itself; where a pressure that is the same everywhere acts on
//! a whole closed surface it is. Facets of rigid solids have no derivative: their forces are those at the prediction.

use crate::math::{Signal, Tensor, Vector};
use crate::pfem2::solid::mesh::gauss::{GaussPoint, gauss_points};
use crate::pfem2::solid::setup::SolidSetup;

/// The pressures on all solids.
#[derive(Debug, Clone, Default)]
pub struct FollowerPressures {
    facets: Vec<PressedFacet>,
    points: Vec<GaussPoint>,
}

/// A facet under pressure.
#[derive(Debug, Clone)]
struct PressedFacet {
    /// Nodes among those of all solids.
    nodes: Vec<u32>,
    /// Places of the Gauss points in the reference state [m].
    places: Vec<[f64; 3]>,
    pressure: Signal,
    is_rigid: bool,
}

impl FollowerPressures {
    /// The pressures of solids whose nodes begin at `first`.
    ///
    /// # Errors
    /// A facet that isn't there.
    pub fn new<const D: usize>(setups: &[SolidSetup<D>], first: &[u32]) -> Result<Self, String> {
        let (points, mut facets) = (gauss_points(D - 1), Vec::new());
        for (setup, first) in setups.iter().zip(first) {
            for load in &setup.pressures {
                for &facet in &load.facets {
                    let missing = || format!("the solid `{}` has no facet {facet} for a pressure", setup.name);
                    let own = &setup.mesh.facets.get(facet as usize).ok_or_else(missing)?.nodes;
                    let nodal: Vec<Vector<D>> = own.iter().map(|&node| setup.mesh.nodes[node as usize]).collect();
                    let place = |point: &GaussPoint| -> Vector<D> {
                        nodal.iter().zip(&point.shape).map(|(x, shape)| *x * *shape).sum()
                    };
                    facets.push(PressedFacet {
                        nodes: own.iter().map(|node| first + node).collect(),
                        places: points.iter().map(|point| place(point).to3()).collect(),
                        pressure: load.pressure.clone(),
                        is_rigid: setup.law.is_rigid(),
                    });
                }
            }
        }
        Ok(Self { facets, points })
    }

    /// True if there is none.
    pub fn is_empty(&self) -> bool {
        self.facets.is_empty()
    }

    /// Calls `add` with each node and its part of the forces at time `t` [s], where all nodes are at `positions` [m]
    /// [N].
    pub fn forces<const D: usize>(&self, t: f64, positions: &[Vector<D>], mut add: impl FnMut(u32, Vector<D>)) {
        for facet in &self.facets {
            for (point, place) in self.points.iter().zip(&facet.places) {
                let normal = normal(&tangents(&facet.nodes, positions, point));
                let force = normal * (-facet.pressure.value(*place, t) * point.weight);
                facet.nodes.iter().zip(&point.shape).for_each(|(&node, shape)| add(node, force * *shape));
            }
        }
    }

    /// Calls `add` with pairs of nodes (a, b) of elastic solids and their part of ∂f_a/∂u_b [N/m].
    pub fn stiffness<const D: usize>(
        &self,
        t: f64,
        positions: &[Vector<D>],
        mut add: impl FnMut((u32, u32), Tensor<D>),
    ) {
        for facet in self.facets.iter().filter(|facet| !facet.is_rigid) {
            for (point, place) in self.points.iter().zip(&facet.places) {
                let pressure = facet.pressure.value(*place, t);
                point_stiffness(&facet.nodes, positions, point, pressure, |(a, b), slope| {
                    add((facet.nodes[a], facet.nodes[b]), slope);
                });
            }
        }
    }
}

/// Calls `add` with pairs of places (a, b) among the nodes of a facet and the contribution of a Gauss point under this
/// pressure [Pa] to ∂f_a/∂u_b [N/m].
pub(in crate::pfem2::solid) fn point_stiffness<const D: usize>(
    nodes: &[u32],
    positions: &[Vector<D>],
    point: &GaussPoint,
    pressure: f64,
    mut add: impl FnMut((usize, usize), Tensor<D>),
) {
    let tangents = tangents(nodes, positions, point);
    for (b, slopes) in point.slopes.iter().enumerate() {
        let slope = normal_slope(&tangents, slopes) * (-pressure * point.weight);
        point.shape.iter().enumerate().for_each(|(a, shape)| add((a, b), slope * *shape));
    }
}

/// m dξ of a Gauss point of a facet [m²; m in the plane].
pub(in crate::pfem2::solid) fn area_vector<const D: usize>(
    nodes: &[u32],
    positions: &[Vector<D>],
    point: &GaussPoint,
) -> Vector<D> {
    normal(&tangents(nodes, positions, point)) * point.weight
}

/// t_k at a Gauss point of a facet [m]; in the plane the second is zero.
fn tangents<const D: usize>(nodes: &[u32], positions: &[Vector<D>], point: &GaussPoint) -> [Vector<D>; 2] {
    let tangent = |k: usize| {
        let all = nodes.iter().zip(&point.slopes);
        all.map(|(&node, slope)| positions[node as usize] * slope[k]).sum()
    };
    [tangent(0), if D == 3 { tangent(1) } else { Vector::ZERO }]
}

/// m.
fn normal<const D: usize>([along, across]: &[Vector<D>; 2]) -> Vector<D> {
    if D == 2 {
        return Vector::from_fn(|i| if i == 0 { along[1] } else { -along[0] });
    }
    let normal = Vector(along.to3()).cross(Vector(across.to3()));
    Vector::from_fn(|i| normal[i])
}

/// ∂m/∂x_b: in the plane ∂N_b/∂ξ_0 times a quarter of a turn, in space x ↦ ∂N_b/∂ξ_0 x × t_1 + ∂N_b/∂ξ_1 t_0 × x.
fn normal_slope<const D: usize>([along, across]: &[Vector<D>; 2], slopes: &[f64; 3]) -> Tensor<D> {
    Tensor::from_fn(|i, j| {
        let unit = Vector::<D>::from_fn(|k| f64::from(u8::from(k == j)));
        let moved = if D == 2 {
            normal(&[unit * slopes[0], Vector::ZERO])
        } else {
            normal(&[unit * slopes[0], *across]) + normal(&[*along, unit * slopes[1]])
        };
        moved[i]
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pfem2::solid::mesh::SolidMesh;
    use crate::pfem2::solid::setup::SurfacePressure;
    use crate::pfem2::solid::structure::tests::solid;

    /// A block with a pressure on facets all of whose nodes satisfy `on`, and its nodes moved.
    fn pressed<const D: usize>(on: impl Fn(Vector<D>) -> bool, p: &str) -> (FollowerPressures, Vec<Vector<D>>) {
        let mesh = SolidMesh::<D>::block(Vector::ZERO, Vector::from_fn(|k| 1.0 + 0.5 * k as f64), [2; D]).unwrap();
        let covered = |facet: &u32| mesh.facets[*facet as usize].nodes.iter().all(|&a| on(mesh.nodes[a as usize]));
        let facets = (0..mesh.facets.len() as u32).filter(covered).collect();
        let mut setup = solid(mesh, [1.0, 1.0, 0.3], |_| false);
        setup.pressures = vec![SurfacePressure { facets, pressure: Signal::formula(p).unwrap() }];
        let moved =
            |x: &Vector<D>| *x + Vector::from_fn(|k| 0.1 * (2.0 * x[(k + 1) % D] + x[k] * x[0] + k as f64).sin());
        let positions = setup.mesh.nodes.iter().map(moved).collect();
        (FollowerPressures::new(&[setup], &[0]).unwrap(), positions)
    }

    fn forces<const D: usize>(pressures: &FollowerPressures, x: &[Vector<D>]) -> Vec<Vector<D>> {
        let mut sum = vec![Vector::ZERO; x.len()];
        pressures.forces(2.0, x, |node, force| sum[node as usize] += force);
        sum
    }

    /// The load stiffness is the slope of the forces, for a pressure that depends on the place in the reference state.
    fn check_slopes<const D: usize>() {
        let (pressures, x) = pressed::<D>(|x| x[0] == 1.0, "(1 + y)*t");
        let mut matrix = vec![Tensor::<D>::ZERO; x.len() * x.len()];
        pressures.stiffness(2.0, &x, |(a, b), block| matrix[a as usize * x.len() + b as usize] += block);
        let step = 1e-6;
        for b in 0..x.len() {
            for j in 0..D {
                let [more, less] = [step, -step].map(|step| {
                    let mut x = x.clone();
                    x[b][j] += step;
                    forces(&pressures, &x)
                });
                for a in 0..x.len() {
                    let slope = (more[a] - less[a]) / (2.0 * step);
                    for i in 0..D {
                        let exact = matrix[a * x.len() + b][i][j];
                        assert!((slope[i] - exact).abs() < 1e-8, "{a} {b} {i} {j}: {} {exact}", slope[i]);
                    }
                }
            }
        }
    }

    #[test]
    fn load_stiffness_is_the_slope_of_the_forces() {
        check_slopes::<2>();
        check_slopes::<3>();
    }

    /// An even pressure around a closed surface has no resultant and no moment, whatever its shape; on the lid alone it
    /// has −p times the area vector of the deformed lid.
    #[test]
    fn an_even_pressure_all_around_holds_itself() {
        let (pressures, x) = pressed::<3>(|_| true, "7");
        let nodal = forces(&pressures, &x);
        let most = nodal.iter().map(|f| f.norm()).fold(0.0, f64::max);
        let force: Vector<3> = nodal.iter().copied().sum();
        let moment: Vector<3> = nodal.iter().zip(&x).map(|(f, x)| x.cross(*f)).sum();
        assert!(most > 0.1 && force.norm() < 1e-14 * 50.0 && moment.norm() < 1e-13 * 50.0, "{force:?} {moment:?}");
    }

    /// A facet that isn't there is said.
    #[test]
    fn a_facet_that_is_not_there_is_an_error() {
        let mesh = SolidMesh::<2>::block(Vector::ZERO, Vector([1.0, 1.0]), [1, 1]).unwrap();
        let mut setup = solid(mesh, [1.0, 1.0, 0.3], |_| false);
        setup.pressures = vec![SurfacePressure { facets: vec![9], pressure: 1.0.into() }];
        assert!(FollowerPressures::new(&[setup], &[0]).unwrap_err().contains("no facet 9"));
    }
}
