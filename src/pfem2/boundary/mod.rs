//! Conditions on the boundary of the mesh, per set of facets (theory F.9).
//!
//! ```text
//! wall, inlet      v = v̄(x, t) at the nodes
//! slip, symmetry   v·n = 0 along the nodal normal n_i ∝ Σ_f ∫N_i n dA; normals that differ by more than 45°
//!                  bind separately, so that an edge between two planes keeps one direction free
//! outlet           −p n + μ ∂v/∂n = 0;   pressure  −p n + μ ∂v/∂n = −p̄(x, t) n     (see `outflow`)
//! traction         σ n = t̄(x, t)
//! pressure pin     p = p̄(t) at one node of a box without outlet, traction or pressure; 0 at the highest node where none is named
//! ```
//!
//! A node of several sets takes the first of wall, inlet, slip that is among them. Of several walls or inlets the
//! slowest counts: a lid that slides along a box must not push fluid through the walls that it meets. Theory F.9.

mod condition;
mod constraints;
mod pin;

pub use condition::{BoundaryKind, BoundarySetup, Condition, Inflow};
pub use constraints::Constraints;
pub use pin::{Pin, PressurePin};

use crate::math::Vector;
use crate::mesh::{Facet, Mesh};
use crate::pfem2::ThetaStep;
use constraints::{Glide, axes_of, fixed_nodes, glides};

/// The conditions of a mesh.
#[derive(Debug, Clone)]
pub struct Boundary<const D: usize> {
    sets: Vec<BoundarySetup<D>>,
    /// Kind of every facet, in the order of [`Mesh::boundary`].
    pub kinds: Vec<BoundaryKind>,
    /// Set of every facet.
    owner: Vec<u32>,
    /// Nodes with a prescribed velocity, and the sets that prescribe it.
    fixed: Vec<(u32, Vec<u32>)>,
    glides: Vec<Glide<D>>,
    /// The node whose pressure is held, where no facet has a free flux.
    pub pin: Option<Pin>,
}

impl<const D: usize> Boundary<D> {
    /// Conditions on sets of facets; facets in no set are walls at rest. `gravity` [m/s²] tells where the top is.
    pub fn new<const N: usize>(mesh: &Mesh<D, N>, mut sets: Vec<BoundarySetup<D>>, gravity: Vector<D>) -> Self {
        let mut owner = vec![usize::MAX; mesh.boundary().len()];
        for (index, set) in sets.iter().enumerate() {
            let places = set.facets.iter().filter_map(|facet| mesh.boundary().binary_search(facet).ok());
            places.for_each(|place| owner[place] = owner[place].min(index));
        }
        let rest: Vec<usize> = (0..owner.len()).filter(|&place| owner[place] == usize::MAX).collect();
        if !rest.is_empty() {
            rest.iter().for_each(|&place| owner[place] = sets.len());
            let facets = rest.iter().map(|&place| mesh.boundary()[place]).collect();
            sets.push(BoundarySetup { name: "walls".into(), facets, condition: Condition::wall(), brings: None });
        }
        let kinds: Vec<BoundaryKind> = owner.iter().map(|&set| sets[set].condition.kind()).collect();
        let fixed = fixed_nodes(mesh, &sets, &owner);
        let glides = glides(mesh, &kinds, &fixed);
        let has_level = kinds.iter().any(|kind| kind.has_free_flux());
        let pin = (!has_level).then(|| Pin::highest(mesh, gravity));
        let owner = owner.into_iter().map(|set| set as u32).collect();
        Self { sets, kinds, owner, fixed: fixed.into_iter().collect(), glides, pin }
    }

    /// True if nothing can come in or leave. (With inlets alone a box isn't closed, and its pressure is held all the
    /// same.)
    pub fn is_closed(&self) -> bool {
        !self.kinds.iter().any(|kind| kind.admits_flow())
    }

    /// Holds the pressure at a place of its own, where no facet has a free flux.
    pub fn pinned<const N: usize>(mut self, mesh: &Mesh<D, N>, pin: Option<&PressurePin<D>>) -> Self {
        if let (Some(held), Some(pin)) = (&mut self.pin, pin) {
            *held = pin.held(mesh);
        }
        self
    }

    /// The sets, with the one of the facets that no set named last.
    pub fn sets(&self) -> &[BoundarySetup<D>] {
        &self.sets
    }

    /// The unknowns that are prescribed; their values are set by [`Boundary::prescribe`].
    pub fn constraints<const N: usize>(&self, nodes: usize) -> Constraints<D, N> {
        let upright = Constraints::<D, N>::UPRIGHT;
        let (mask, value, frame) = (vec![0; nodes], vec![[0.0; N]; nodes], vec![upright; nodes]);
        let mut constraints = Constraints { mask, value, frame, frames: Vec::new() };
        for (node, _) in &self.fixed {
            constraints.mask[*node as usize] |= (1 << D) - 1;
        }
        for glide in &self.glides {
            let node = glide.node as usize;
            match axes_of(glide) {
                Some(mask) => constraints.mask[node] |= mask,
                None => {
                    constraints.mask[node] |= (1 << glide.held) - 1;
                    constraints.frame[node] = constraints.frames.len() as u32;
                    constraints.frames.push(glide.frame);
                }
            }
        }
        if let Some(pin) = &self.pin {
            constraints.mask[pin.node as usize] |= 1 << D;
        }
        constraints
    }

    /// Sets the prescribed velocities and the held pressure of time `t` [s].
    pub fn prescribe<const N: usize>(&self, mesh: &Mesh<D, N>, t: f64, constraints: &mut Constraints<D, N>) {
        for (node, sets) in &self.fixed {
            let v = self.prescribed(mesh.nodes()[*node as usize], sets, t);
            constraints.value[*node as usize][..D].copy_from_slice(&v.0);
        }
        if let Some(pin) = &self.pin {
            let node = pin.node as usize;
            constraints.value[node][D] = pin.value.value(mesh.nodes()[node].to3(), t);
        }
    }

    /// Makes the convected velocity of nodes with a prescribed one fit it: v̂ = v − θ Δt Dv/Dt at the end of the step
    /// (theory (F.31)).
    pub fn impose<const N: usize>(&self, mesh: &Mesh<D, N>, step: ThetaStep, convected: &mut [Vector<D>]) {
        let ThetaStep { dt, theta, .. } = step;
        for (node, sets) in &self.fixed {
            let x = mesh.nodes()[*node as usize];
            let change = self.change(x, sets, step.end(), dt);
            convected[*node as usize] = self.prescribed(x, sets, step.end()) - change * theta;
        }
    }

    /// Nodes with a prescribed velocity, and that at the time `t` [m/s].
    pub fn held<const N: usize>(&self, mesh: &Mesh<D, N>, t: f64) -> Vec<(usize, Vector<D>)> {
        let at =
            |(node, sets): &(u32, Vec<u32>)| (*node as usize, self.prescribed(mesh.nodes()[*node as usize], sets, t));
        self.fixed.iter().map(at).collect()
    }

    /// Δt times the acceleration of what moves with the prescribed velocity at the time `t` [m/s]: a wall that turns
    /// leads the fluid around. The formula of an inlet doesn't say how the velocity changes across it.
    fn change(&self, x: Vector<D>, sets: &[u32], t: f64, dt: f64) -> Vector<D> {
        let inlet = sets.iter().any(|&set| self.sets[set as usize].condition.kind().prescribes_inflow());
        let along = if inlet { Vector::ZERO } else { self.prescribed(x, sets, t) };
        let between = |along: Vector<D>| {
            let [before, after] = [-0.5 * dt, 0.5 * dt].map(|s| self.prescribed(x + along * s, sets, t + s));
            after - before
        };
        // A formula need not hold beyond the end of the wall.
        Some(between(along)).filter(|change| change.norm().is_finite()).unwrap_or_else(|| between(Vector::ZERO))
    }

    /// The slowest of the velocities that sets prescribe at a place [m/s].
    fn prescribed(&self, x: Vector<D>, sets: &[u32], t: f64) -> Vector<D> {
        let velocities = sets.iter().filter_map(|&set| self.sets[set as usize].condition.velocity(x, t));
        velocities.min_by(|v, w| v.norm_squared().total_cmp(&w.norm_squared())).unwrap_or_default()
    }

    /// The inflow through a facet at the place `x` [m] and time `t` [s]; `None` inside.
    pub fn inflow<const N: usize>(&self, mesh: &Mesh<D, N>, facet: Facet, x: Vector<D>, t: f64) -> Option<Inflow<D>> {
        let place = mesh.boundary().binary_search(&facet).ok()?;
        let set = &self.sets[self.owner[place] as usize];
        Some(Inflow { velocity: set.condition.velocity(x, t), fluid: set.brings, facet: place })
    }

    /// The set of a facet, among [`Boundary::sets`].
    pub fn set_of<const N: usize>(&self, mesh: &Mesh<D, N>, facet: Facet) -> Option<usize> {
        let place = mesh.boundary().binary_search(&facet).ok()?;
        Some(self.owner[place] as usize)
    }

    /// The fluid that is named to come in through the facet at a place of [`Mesh::boundary`].
    pub fn inflow_fluid(&self, place: usize) -> Option<u8> {
        self.sets[self.owner[place] as usize].brings
    }

    /// The facets of each element whose condition passes a test: bit k for the one opposite to local node k.
    pub fn facet_bits<const N: usize>(&self, mesh: &Mesh<D, N>, test: impl Fn(&Condition<D>) -> bool) -> Vec<u8> {
        let mut bits = vec![0; mesh.elements().len()];
        let owned = self.owner.iter().zip(mesh.boundary());
        for (_, facet) in owned.filter(|(set, _)| test(&self.sets[**set as usize].condition)) {
            bits[facet.element as usize] |= 1 << facet.opposite;
        }
        bits
    }

    /// The traction at a place of a facet at time `t` [Pa].
    pub fn traction<const N: usize>(&self, mesh: &Mesh<D, N>, facet: Facet, x: Vector<D>, t: f64) -> Vector<D> {
        let set = self.set_of(mesh, facet).zip(mesh.facet_area(facet).normalized());
        set.and_then(|(set, n)| self.sets[set].condition.traction(x, n, t)).unwrap_or_default()
    }

    /// Adds the loads of tractions and pressures at time `t` on the facets of elements that `takes` to the nodal
    /// forces [N].
    pub fn load<const N: usize>(
        &self,
        mesh: &Mesh<D, N>,
        t: f64,
        takes: impl Fn(u32) -> bool,
        mut add: impl FnMut(usize, Vector<D>),
    ) {
        for set in &self.sets {
            for &facet in set.facets.iter().filter(|facet| takes(facet.element)) {
                let area = mesh.facet_area(facet);
                let Some(n) = area.normalized() else { continue };
                let nodes = mesh.facet_nodes(facet);
                // ∫N_i N_j dA = A (1 + δ_ij)/(d (d + 1))
                let weight = area.norm() / (D * (D + 1)) as f64;
                for &j in &nodes {
                    let Some(traction) = set.condition.traction(mesh.nodes()[j as usize], n, t) else { break };
                    for &i in &nodes {
                        add(i as usize, traction * (weight * if i == j { 2.0 } else { 1.0 }));
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Signal;

    fn set<const D: usize>(name: &str, facets: Vec<Facet>, condition: Condition<D>) -> BoundarySetup<D> {
        BoundarySetup { name: name.into(), facets, condition, brings: None }
    }

    /// Facets whose nodes all satisfy a test.
    fn facets<const D: usize, const N: usize>(mesh: &Mesh<D, N>, on: impl Fn(Vector<D>) -> bool) -> Vec<Facet> {
        let all = |facet: &&Facet| mesh.facet_nodes(**facet).iter().all(|&node| on(mesh.nodes()[node as usize]));
        mesh.boundary().iter().filter(all).copied().collect()
    }

    /// A fan of triangles around the origin.
    fn disc(count: u32) -> Mesh<2, 3> {
        let angle = |k: u32| std::f64::consts::TAU * f64::from(k) / f64::from(count);
        let rim = (0..count).map(|k| Vector([angle(k).cos(), angle(k).sin()]));
        let nodes = std::iter::once(Vector::ZERO).chain(rim).collect();
        let elements = (0..count).map(|k| [0, k + 1, (k + 1) % count + 1]).collect();
        Mesh::new(nodes, elements).unwrap()
    }

    #[test]
    fn the_nodal_normals_of_a_circle_point_outwards() {
        let mesh = disc(17);
        let sets = vec![set("rim", mesh.boundary().to_vec(), Condition::Slip)];
        let boundary = Boundary::new(&mesh, sets, Vector::ZERO);
        let constraints = boundary.constraints::<3>(mesh.nodes().len());
        for (node, x) in mesh.nodes().iter().enumerate().skip(1) {
            assert_eq!((constraints.mask[node] & 0b11).count_ones(), 1);
            let along = constraints.into_frame(node, *x);
            assert!((along[0].abs() - 1.0).abs() < 1e-12 && along[1].abs() < 1e-12);
            assert!((constraints.out_of_frame(node, along) - *x).norm() < 1e-14);
        }
    }

    #[test]
    fn slip_planes_hold_a_corner_and_leave_an_edge_one_direction() {
        let mesh = Mesh::<3, 4>::block(Vector([0.0; 3]), Vector([1.0; 3]), [2, 2, 2]).unwrap();
        let boundary = Boundary::new(&mesh, vec![set("all", mesh.boundary().to_vec(), Condition::Slip)], Vector::ZERO);
        let constraints = boundary.constraints::<4>(mesh.nodes().len());
        for (node, x) in mesh.nodes().iter().enumerate() {
            let planes = x.0.iter().filter(|&&c| c == 0.0 || c == 1.0).count();
            assert_eq!((constraints.mask[node] & 0b111).count_ones() as usize, planes);
        }
    }

    #[test]
    fn a_closed_box_is_pinned_at_its_top_and_an_open_one_is_not() {
        let mesh = Mesh::<2, 3>::block(Vector([0.0; 2]), Vector([1.0, 2.0]), [2, 2]).unwrap();
        let closed = Boundary::new(&mesh, Vec::new(), Vector([0.0, -1.0]));
        let at = |boundary: &Boundary<2>| boundary.pin.as_ref().map(|pin| mesh.nodes()[pin.node as usize]);
        assert_eq!(at(&closed), Some(Vector([0.0, 2.0])));
        let pin = PressurePin { at: Vector([0.6, 0.9]), value: Signal::formula("1 + t").unwrap() };
        let closed = closed.pinned(&mesh, Some(&pin));
        assert_eq!(at(&closed), Some(Vector([0.5, 1.0])));
        let mut constraints = closed.constraints::<3>(9);
        closed.prescribe(&mesh, 2.0, &mut constraints);
        assert_eq!((constraints.mask[4], constraints.value[4][2]), (0b100, 3.0));
        let top = facets(&mesh, |x| x[1] == 2.0);
        let open = Boundary::new(&mesh, vec![set("top", top, Condition::Outlet)], Vector([0.0, -1.0]));
        assert_eq!(at(&open.clone().pinned(&mesh, Some(&pin))), None);
        assert_eq!(open.sets().last().unwrap().name, "walls");
    }

    #[test]
    fn walls_win_over_inlets_and_inlets_over_slip() {
        let mesh = Mesh::<2, 3>::block(Vector([0.0; 2]), Vector([1.0; 2]), [2, 2]).unwrap();
        let sets = vec![
            set("below", facets(&mesh, |x| x[1] == 0.0), Condition::Slip),
            set("left", facets(&mesh, |x| x[0] == 0.0), Condition::Inlet([2.0.into(), 0.0.into()])),
            set("lid", facets(&mesh, |x| x[1] == 1.0), Condition::Wall([Signal::formula("t").unwrap(), 0.0.into()])),
        ];
        let boundary = Boundary::new(&mesh, sets, Vector::ZERO);
        let mut constraints = boundary.constraints::<3>(9);
        boundary.prescribe(&mesh, 3.0, &mut constraints);
        let speed = |node: usize| constraints.value[node][0];
        assert_eq!([speed(0), speed(3), speed(6)], [2.0, 2.0, 3.0]);
        let mut convected = vec![Vector::splat(9.0); 9];
        boundary.impose(&mesh, ThetaStep { t: 3.0, dt: 0.5, theta: 0.5 }, &mut convected);
        assert_eq!([convected[6], convected[4]], [Vector([3.25, 0.0]), Vector::splat(9.0)]);
    }

    #[test]
    fn a_lid_leaves_its_corners_to_the_walls_that_it_meets() {
        let mesh = Mesh::<2, 3>::block(Vector::ZERO, Vector::splat(1.0), [2; 2]).unwrap();
        let lid = Condition::Wall([1.0.into(), 0.0.into()]);
        let boundary = Boundary::new(&mesh, vec![set("lid", facets(&mesh, |x| x[1] == 1.0), lid)], Vector::ZERO);
        let mut constraints = boundary.constraints::<3>(9);
        boundary.prescribe(&mesh, 0.0, &mut constraints);
        assert_eq!([6, 7, 8].map(|node| constraints.value[node][0]), [0.0, 1.0, 0.0]);
    }

    #[test]
    fn pressure_all_around_has_no_net_force_and_a_linear_traction_its_moment() {
        let mesh = disc(9);
        let sets = vec![set("rim", mesh.boundary().to_vec(), Condition::Pressure(7.0.into()))];
        let mut net = Vector::ZERO;
        Boundary::new(&mesh, sets, Vector::ZERO).load(&mesh, 0.0, |_| true, |_, force| net += force);
        assert!(net.norm() < 1e-13);
        let mesh = Mesh::<2, 3>::block(Vector([0.0; 2]), Vector([1.0; 2]), [3, 1]).unwrap();
        let traction = Condition::Traction([0.0.into(), Signal::formula("x").unwrap()]);
        let sets = vec![set("top", facets(&mesh, |x| x[1] == 1.0), traction)];
        let (mut force, mut moment) = (0.0, 0.0);
        Boundary::new(&mesh, sets, Vector::ZERO).load(
            &mesh,
            0.0,
            |_| true,
            |node, f| {
                force += f[1];
                moment += f[1] * mesh.nodes()[node][0];
            },
        );
        assert!((force - 0.5).abs() < 1e-14 && (moment - 1.0 / 3.0).abs() < 1e-14);
    }
}
