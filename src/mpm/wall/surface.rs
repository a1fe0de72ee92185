//! Conditions at the surface of obstacles, which lies anywhere between the nodes.
//!
//! Each node whose distance from the surface is at most half a cell has a foot x_c there: on average one place per cell of the surface,
//! however that is turned. With the shape functions of the body that meets it,
//!
//! ```text
//! u = Σ_I N_I(x_c) v_I,   M⁻¹ = Σ_I N_I(x_c)²/m_I,   p_I ← p_I + N_I(x_c) J          J: what makes u meet the condition
//! ```
//!
//! A body with the pressure p that ends at the surface has the forces p ∫ ∇N_I dV = p N_I(x_c) ν on its nodes: the impulses give back just that.
//! Conditions at the nodes themselves would leave p N_I on those in front, and the body would come to rest where its particles balance that,
//! up to half a cell off.
//!
//! All places together are solved by projected Gauss–Seidel in the order of their nodes. Each visit is a projection in the metric of the masses, so
//! that obstacles at rest take energy and never give any, converged or not (theory 1.5). Nodes deeper in an obstacle than its surface reaches are bound
//! one by one, as those of walls are: they belong to what has entered it.

use super::{Condition, Pushes, Walls};
use crate::math::Vector;
use crate::mpm::contact::nodes::{Lattice, flip};
use crate::mpm::{Grid, Node, Step, WallKind};

/// Nodes up to this distance from the surface have their foot among the places where it acts [cells].
pub(super) const BAND: f64 = 0.5;

/// Least share of the support of a place that must have mass: else the body is not there yet.
const LEAST: f64 = 0.5;

/// Most sweeps, and the change of an impulse, relative to the largest one, that ends them.
const SWEEPS: usize = 40;
const SETTLED: f64 = 1e-6;

/// The number of what is absent.
const NONE: u32 = u32::MAX;

/// A place on a surface with the nodes of a field around it.
#[derive(Debug, Clone, Copy)]
struct Row<const D: usize> {
    /// Its condition.
    condition: u32,
    /// Its nodes end here in the list of all.
    end: u32,
    /// M⁻¹ along each axis [1/kg].
    softness: Vector<D>,
}

/// The places where a field meets the surfaces of obstacles during a step.
#[derive(Debug, Clone, Default)]
pub(super) struct Rows<const D: usize> {
    rows: Vec<Row<D>>,
    /// Node, by its number among `nodes`, and N_I along each axis: mirrors reverse one.
    reached: Vec<(u32, Vector<D>)>,
    /// Grid nodes, and their 1/m [1/kg].
    nodes: Vec<(u32, f64)>,
    /// Number of each grid node among `nodes`.
    number: Vec<u32>,
}

/// What a solution changes: the impulses at places, by the numbers of their conditions, and at grid nodes [N s].
struct Solved<const D: usize> {
    places: Vec<(usize, Vector<D>)>,
    nodes: Vec<(usize, Vector<D>)>,
}

/// What a place asks for: the impulse that it should have [N s], u and J so far given.
type Law<'a, const D: usize> = &'a dyn Fn(&Place<D>) -> Vector<D>;

/// A place while its impulse is sought.
struct Place<const D: usize> {
    /// Number of its condition.
    condition: usize,
    /// u [m/s].
    velocity: Vector<D>,
    /// J so far [N s].
    impulse: Vector<D>,
    /// M⁻¹ along each axis [1/kg].
    softness: Vector<D>,
}

impl<const D: usize> Rows<D> {
    /// Finds the nodes of a field, which hold (m, p), around the places of these conditions.
    pub fn find<'a>(
        &mut self,
        (grid, lattice): (&Grid<D>, &Lattice<D>),
        nodes: &[Node<D>],
        conditions: impl Iterator<Item = (usize, &'a Condition<D>)>,
    ) {
        self.nodes.iter().for_each(|&(node, _)| self.number[node as usize] = NONE);
        self.number.resize(nodes.len(), NONE);
        self.nodes.clear();
        self.rows.clear();
        self.reached.clear();
        for (k, condition) in conditions {
            let start = self.reached.len();
            let mut cover = 0.0;
            lattice.for_each(grid, condition.place, |node, weight, flips| {
                let mass = nodes[node].mass;
                if mass <= lattice.cutoff {
                    return;
                }
                cover += weight;
                let number = self.number_of(node, mass);
                let weight = flip(Vector::from_fn(|_| weight), flips);
                match self.reached[start..].iter_mut().find(|reached| reached.0 == number) {
                    Some((_, sum)) => *sum += weight,
                    None => self.reached.push((number, weight)),
                }
            });
            if cover < LEAST {
                self.reached.truncate(start);
                continue;
            }
            let mut softness = Vector::ZERO;
            for (number, weight) in &mut self.reached[start..] {
                *weight = *weight / cover;
                let soft = self.nodes[*number as usize].1;
                softness += Vector::from_fn(|a| weight[a] * weight[a] * soft);
            }
            self.rows.push(Row { condition: k as u32, end: self.reached.len() as u32, softness });
        }
    }

    /// The number of a grid node of some mass [kg] among those of all places.
    fn number_of(&mut self, node: usize, mass: f64) -> u32 {
        let number = &mut self.number[node];
        if *number == NONE {
            *number = self.nodes.len() as u32;
            self.nodes.push((node as u32, 1.0 / mass));
        }
        *number
    }

    /// True if the field meets no surface.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Velocities at all places [m/s], from those of the nodes.
    fn velocities<'a>(
        &'a self,
        nodal: impl Fn(usize) -> Vector<D> + 'a,
    ) -> impl Iterator<Item = (usize, Vector<D>)> + 'a {
        let mut start = 0;
        self.rows.iter().map(move |row| {
            let near = &self.reached[start..row.end as usize];
            start = row.end as usize;
            let at = |&(n, weight): &(u32, Vector<D>)| along(nodal(self.nodes[n as usize].0 as usize), weight);
            (row.condition as usize, near.iter().map(at).sum())
        })
    }

    /// The impulses [N s] that make the velocities at all places what `law` asks for: `nodal` gives the velocity of a node [m/s], `given` what a
    /// place has had already [N s].
    fn solve(
        &self,
        nodal: impl Fn(usize) -> Vector<D>,
        given: impl Fn(usize) -> Vector<D>,
        law: Law<'_, D>,
    ) -> Solved<D> {
        let mut velocity: Vec<_> = self.nodes.iter().map(|&(node, _)| nodal(node as usize)).collect();
        let mut sums = vec![Vector::ZERO; velocity.len()];
        let first: Vec<_> = self.rows.iter().map(|row| given(row.condition as usize)).collect();
        let mut impulse = first.clone();
        for _ in 0..SWEEPS {
            let (mut start, mut change, mut largest) = (0, 0.0_f64, 0.0_f64);
            for (row, impulse) in self.rows.iter().zip(&mut impulse) {
                let near = &self.reached[start..row.end as usize];
                start = row.end as usize;
                let u = near.iter().map(|&(n, weight)| along(velocity[n as usize], weight)).sum();
                let Row { condition, softness, .. } = *row;
                let wanted = law(&Place { condition: condition as usize, velocity: u, impulse: *impulse, softness });
                let delta = wanted - *impulse;
                *impulse = wanted;
                largest = largest.max(wanted.norm());
                if delta == Vector::ZERO {
                    continue;
                }
                change = change.max(delta.norm());
                for &(n, weight) in near {
                    let part = along(delta, weight);
                    sums[n as usize] += part;
                    velocity[n as usize] += part * self.nodes[n as usize].1;
                }
            }
            if change <= SETTLED * largest {
                break;
            }
        }
        let pushed = |(_, sum): &(usize, Vector<D>)| *sum != Vector::ZERO;
        let nodes = self.nodes.iter().zip(sums).map(|(&(node, _), sum)| (node as usize, sum));
        let changes = impulse.into_iter().zip(first).map(|(after, before)| after - before);
        let places = self.rows.iter().map(|row| row.condition as usize).zip(changes);
        Solved { places: places.filter(pushed).collect(), nodes: nodes.filter(pushed).collect() }
    }

    /// 1/m of a grid node at a place [1/kg].
    fn softness_of(&self, node: usize) -> f64 {
        self.nodes[self.number[node] as usize].1
    }
}

/// `v` with each component times that of `weight`.
#[inline]
fn along<const D: usize>(v: Vector<D>, weight: Vector<D>) -> Vector<D> {
    Vector::from_fn(|a| v[a] * weight[a])
}

/// v of a node that holds (m, p) [m/s].
fn velocity<const D: usize>(node: &Node<D>) -> Vector<D> {
    node.momentum / node.mass
}

impl<const D: usize> Place<D> {
    /// 1/M along `n` [1/kg].
    fn compliance(&self, n: Vector<D>) -> f64 {
        (0..D).map(|a| n[a] * n[a] * self.softness[a]).sum()
    }

    /// The impulse after which the velocity along `n` is that of the wall.
    fn stopped(&self, n: Vector<D>, wall: Vector<D>) -> Vector<D> {
        self.impulse - n * ((self.velocity - wall).dot(n) / self.compliance(n))
    }

    /// The impulse of a condition of this kind that moves with `wall` [m/s]; one that may be left lets it approach by `allowed` [m/s].
    fn constrained(&self, kind: WallKind, n: Vector<D>, wall: Vector<D>, allowed: f64) -> Vector<D> {
        let relative = self.velocity - wall;
        let coefficient = match kind {
            WallKind::Open => return self.impulse,
            WallKind::Slip => return self.stopped(n, wall),
            WallKind::Fixed => {
                return Vector::from_fn(|a| self.impulse[a] - relative[a] / self.softness[a]);
            }
            WallKind::Separate => 0.0,
            WallKind::Friction { coefficient } => coefficient,
        };
        let before = self.impulse.dot(n);
        let pressed = (before - (relative.dot(n) + allowed) / self.compliance(n)).max(0.0);
        let most = coefficient * pressed;
        if most == 0.0 {
            return n * pressed;
        }
        let soft = (0..D).map(|a| self.softness[a]).fold(0.0, f64::max);
        let wanted = self.impulse - n * before - (relative - n * relative.dot(n)) / soft;
        let size = wanted.norm();
        n * pressed + if size > most { wanted * (most / size) } else { wanted }
    }
}

impl<const D: usize> Walls<D> {
    /// Finds where a field, whose nodes hold (m, p⁻), meets the surfaces of obstacles in this step.
    pub(super) fn find_surface(&mut self, grid: &Grid<D>, field: usize, nodes: &[Node<D>]) {
        let own = self.conditions.iter().enumerate().filter(|(_, condition)| condition.on_surface);
        let mut rows = std::mem::take(&mut self.reactions[field].rows);
        rows.find((grid, &self.lattice), nodes, own);
        self.reactions[field].rows = rows;
    }

    /// Binding conditions on p⁻ at time `t` (theory 9, 2b).
    pub(super) fn surface_start(&mut self, field: usize, nodes: &mut [Node<D>], t: f64) {
        let law = |place: &Place<D>| {
            let (condition, kind, wall) = self.at_place(place.condition, t);
            if kind.binds() { place.constrained(kind, condition.normal, wall, 0.0) } else { place.impulse }
        };
        let solved = self.reactions[field].rows.solve(|node| velocity(&nodes[node]), |_| Vector::ZERO, &law);
        self.change_start(field, nodes, &solved);
    }

    /// Conditions on p̄ whose gaps close, on p⁻ too where they held in the step before. Returns true if they pushed.
    pub(super) fn surface_trial(&mut self, field: usize, nodes: &mut [Node<D>], step: &Step) -> bool {
        if self.reactions[field].rows.is_empty() {
            return false;
        }
        self.hold_places(field, nodes, step);
        let (dt, reaction) = (step.momentum_dt, &self.reactions[field]);
        let rests = |k: usize| self.binds(k) || reaction.bound[k];
        let allowed = |k: usize| if rests(k) { 0.0 } else { reaction.gap[k].max(0.0) / dt };
        let law = |place: &Place<D>| {
            let k = place.condition;
            let (condition, kind, wall) = self.at_place(k, step.after());
            let allowed = allowed(k);
            if allowed.is_finite() { place.constrained(kind, condition.normal, wall, allowed) } else { place.impulse }
        };
        let given = |k: usize| reaction.force[k] * dt;
        let solved = reaction.rows.solve(|node| velocity(&nodes[node]), given, &law);
        for &(node, sum) in &solved.nodes {
            nodes[node].momentum += sum;
            nodes[node].force += sum / dt;
        }
        let touching: Vec<_> = reaction
            .rows
            .velocities(|node| velocity(&nodes[node]))
            .map(|(k, u)| {
                let (condition, _, wall) = self.at_place(k, step.after());
                (k, self.binds(k) || reaction.gap[k] + dt * (u - wall).dot(condition.normal) <= 0.0)
            })
            .collect();
        let reaction = &mut self.reactions[field];
        for &(k, change) in &solved.places {
            reaction.force[k] += change / dt;
        }
        for (k, touches) in touching {
            reaction.closed[k] = touches || reaction.force[k] != Vector::ZERO;
        }
        !solved.places.is_empty()
    }

    /// Binds p⁻ at the places that held in the step before and would close: they are at rest on the wall, whatever their gap is by rounding. To
    /// let them approach by that gap all the same, p̄ but not p⁻, would give the particles that are stopped here more than they lost.
    fn hold_places(&mut self, field: usize, nodes: &mut [Node<D>], step: &Step) {
        let mut bound = std::mem::take(&mut self.reactions[field].bound);
        let (dt, reaction) = (step.momentum_dt, &self.reactions[field]);
        if reaction.held.contains(&true) {
            for (k, u) in reaction.rows.velocities(|node| velocity(&nodes[node])) {
                let (condition, _, wall) = self.at_place(k, step.after());
                let approach = (u - wall).dot(condition.normal);
                bound[k] |= reaction.held[k] && approach < 0.0 && reaction.gap[k] + dt * approach <= 0.0;
            }
            let law = |place: &Place<D>| {
                let (condition, _, wall) = self.at_place(place.condition, step.before());
                if bound[place.condition] { place.stopped(condition.normal, wall) } else { place.impulse }
            };
            let before = |node: usize| (nodes[node].momentum - nodes[node].force * dt) / nodes[node].mass;
            let solved = reaction.rows.solve(before, |_| Vector::ZERO, &law);
            self.change_start(field, nodes, &solved);
        }
        self.reactions[field].bound = bound;
    }

    /// Changes p⁻, and p̄ with it.
    fn change_start(&mut self, field: usize, nodes: &mut [Node<D>], solved: &Solved<D>) {
        solved.nodes.iter().for_each(|&(node, sum)| nodes[node].momentum += sum);
        for &(k, change) in &solved.places {
            self.reactions[field].start[self.conditions[k].boundary as usize] += change;
        }
    }

    /// As [`Self::constrain_velocity`], at the surface.
    pub(super) fn surface_velocity(&self, field: usize, velocity: &mut [Vector<D>], t: f64) -> Pushes<D> {
        let reaction = &self.reactions[field];
        let law = |place: &Place<D>| {
            let (condition, kind, wall) = self.at_place(place.condition, t);
            if !reaction.closed[place.condition] {
                return place.impulse;
            }
            let constrained = place.constrained(kind, condition.normal, wall, 0.0);
            if kind.binds() || reaction.force[place.condition] == Vector::ZERO {
                return constrained;
            }
            let (n, stopped) = (condition.normal, place.stopped(condition.normal, wall));
            constrained + n * (stopped - constrained).dot(n)
        };
        self.push_velocity((field, t), velocity, &law)
    }

    /// As [`Self::constrain_correction`], at the surface.
    pub(super) fn surface_correction(&self, field: usize, correction: &mut [Vector<D>], t: f64) -> Pushes<D> {
        let law = |place: &Place<D>| {
            let (condition, kind, _) = self.at_place(place.condition, t);
            if kind.binds() { place.constrained(kind, condition.normal, Vector::ZERO, 0.0) } else { place.impulse }
        };
        self.push_velocity((field, t), correction, &law)
    }

    /// As [`Self::hold_velocity`], at the surface.
    pub(super) fn hold_surface(&self, field: usize, velocity: &mut [Vector<D>], t: f64) {
        let held = &self.reactions[field].held;
        let law = |place: &Place<D>| {
            let (condition, _, wall) = self.at_place(place.condition, t);
            if held[place.condition] { place.stopped(condition.normal, wall) } else { place.impulse }
        };
        self.push_velocity((field, t), velocity, &law);
    }

    /// Applies a law to velocities; returns what that pushes.
    fn push_velocity(&self, (field, t): (usize, f64), velocity: &mut [Vector<D>], law: Law<'_, D>) -> Pushes<D> {
        let (mut pushes, rows) = (self.pushes(), &self.reactions[field].rows);
        let solved = rows.solve(|node| velocity[node], |_| Vector::ZERO, law);
        for (node, sum) in solved.nodes {
            velocity[node] += sum * rows.softness_of(node);
        }
        for (k, change) in solved.places {
            let (condition, _, wall) = self.at_place(k, t);
            pushes.push(condition, change, wall);
        }
        pushes
    }

    /// Velocities at the places of a field [m/s], with the numbers of their conditions.
    pub(super) fn surface_velocities<'a>(
        &'a self,
        field: usize,
        nodal: impl Fn(usize) -> Vector<D> + 'a,
    ) -> impl Iterator<Item = (usize, Vector<D>)> + 'a {
        self.reactions[field].rows.velocities(nodal)
    }

    /// A condition, its kind and the velocity of its boundary there at time `t`.
    fn at_place(&self, k: usize, t: f64) -> (&Condition<D>, WallKind, Vector<D>) {
        let condition = &self.conditions[k];
        let boundary = condition.boundary as usize;
        (condition, self.boundaries[boundary].kind, self.velocity(boundary, condition.place, t))
    }

    /// True if the condition binds always.
    fn binds(&self, k: usize) -> bool {
        self.boundaries[self.conditions[k].boundary as usize].kind.binds()
    }
}
