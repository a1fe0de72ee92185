//! The stages of a membrane's step, and the bookkeeping of what they do (theory C.8, C.9, C.11).

use super::Membrane;
use super::element::MembraneSums;
use super::lanes::LANES;
use super::ledger::Balance;
use super::load::Prescribed;
use super::shape::{ElementShape, FullQuadrilateral, Quadrilateral, Segment, Triangle};
use super::task::{ElementTask, Run};
use crate::error::{Place, StepError};
use crate::material::SheetKind;
use crate::math::{Signal, Vector};
use crate::mpm::traction::no_load;
use crate::parallel;

/// Blocks of elements per parallel task.
const TASK: usize = 32;

/// Nodes per parallel task of a node loop.
const NODES: usize = 4096;

impl<const D: usize> Membrane<D> {
    /// Updates stress and thickness with the last displacement step and evaluates the forces at time `t`
    /// (Lian (32–45); theory C.3 to C.5).
    ///
    /// # Errors
    /// An element that has collapsed, a node that is not finite, or a load without a value.
    pub fn internal_force(&mut self, t: f64) -> Result<(), StepError> {
        self.parameters.dt = self.ledger.displacement_dt;
        let sums = self.update_elements();
        if !(sums.frequency2.is_finite() && sums.frequency2 > 0.0 && sums.strain.is_finite()) {
            return Err(self.broken(t));
        }
        let ledger = &mut self.ledger;
        match self.sheet.kind() {
            SheetKind::Rate => ledger.strain.add(sums.strain),
            SheetKind::Total => ledger.strain = sums.strain.into(),
        }
        ledger.hourglass.add(sums.hourglass);
        ledger.stiffness_damping.add(sums.damping);
        ledger.frequency2 = sums.frequency2;
        self.pressure.update(t, &self.elements, &self.position);
        self.check_loads(t)?;
        let Self { element_force, corner_force, elements, .. } = self;
        parallel::fill(element_force, NODES, |k| {
            elements.corners(k).iter().fold(Vector::ZERO, |sum, &corner| sum + corner_force[corner as usize])
        });
        Ok(())
    }

    /// Trial velocities, v̄ = v^{n−½} + Δt f / m, prescribed components as at `t + ½ dt`.
    pub fn advance_velocity(&mut self, t: f64, dt: f64) {
        self.momentum_dt = dt;
        self.touch_time += dt;
        std::mem::swap(&mut self.before, &mut self.velocity);
        let (mut velocity, drag, gravity) = (std::mem::take(&mut self.velocity), self.drag(), self.gravity_at(t));
        parallel::fill(&mut velocity, NODES, |k| {
            let force = self.element_force[k] + self.pressure.at(k);
            // Lian (46).
            self.before[k] + (force * (1.0 / self.mass[k]) + (gravity.at(k) - self.before[k] * drag)) * dt
        });
        self.velocity = velocity;
        self.contact_force.clear();
        self.supports.impose(&mut self.velocity, &self.reference, t + 0.5 * dt);
    }

    /// Corrects the velocities by contact forces on the nodes [N], prescribed components again.
    /// Several calls in a step add up.
    pub fn apply_contact(&mut self, force: &[Vector<D>], t: f64, dt: f64) {
        let Self { velocity, contact_force, touch, mass, .. } = self;
        contact_force.resize(velocity.len(), Vector::ZERO);
        touch.resize(velocity.len(), Vector::ZERO);
        let columns = (&mut velocity[..], &mut contact_force[..], &mut touch[..], force, &mass[..]);
        parallel::for_each_chunk(columns, NODES, |_, (velocity, sum, touch, force, mass)| {
            for ((((v, sum), touch), &f), &m) in velocity.iter_mut().zip(sum).zip(touch).zip(force).zip(mass) {
                // Lian (59).
                *v += f * (dt / m);
                *sum += f;
                *touch += f * dt;
            }
        });
        self.supports.impose(&mut self.velocity, &self.reference, t + 0.5 * dt);
    }

    /// Adds the work of this step to the ledger, then moves the nodes by `dt`.
    pub fn move_nodes(&mut self, t: f64, dt: f64) {
        self.book(t);
        self.ledger.displacement_dt = dt;
        let Self { position, velocity, .. } = self;
        // Lian (47).
        parallel::for_each_pair_mut(position, velocity, |x, v| *x += *v * dt);
    }

    /// Loads that vary have a value everywhere.
    fn check_loads(&self, t: f64) -> Result<(), StepError> {
        let (body, time) = (self.name.clone(), t);
        if let Some((index, value)) = self.pressure.undefined() {
            let position = self.centre(index).to3();
            return Err(StepError { time, ..no_load(Place::Element { body, index, position }, value) });
        }
        if self.gravity.iter().all(Signal::is_uniform) {
            return Ok(());
        }
        let gravity = self.gravity_at(t);
        parallel::first(self.mass.len(), |k| !gravity.at(k).is_finite()).map_or(Ok(()), |index| {
            let (position, value) = (self.position[index].to3(), gravity.at(index).norm() * self.mass[index]);
            Err(StepError { time, ..no_load(Place::Node { body, index, position }, value) })
        })
    }

    /// Centre of an element [m].
    fn centre(&self, element: usize) -> Vector<D> {
        let nodes = self.elements.nodes(element);
        nodes.iter().map(|&k| self.position[k as usize]).sum::<Vector<D>>() * (1.0 / nodes.len() as f64)
    }

    /// Rate by which mass-proportional damping c takes from a velocity, (1 − e^(−cΔt))/Δt [1/s]: exact for a sheet that
    /// nothing else acts on, however large the step.
    fn drag(&self) -> f64 {
        let dt = self.momentum_dt;
        if self.mass_damping > 0.0 && dt > 0.0 { -(-self.mass_damping * dt).exp_m1() / dt } else { self.mass_damping }
    }

    /// Contact force on node `k` in this step [N].
    #[inline(always)]
    fn contact_at(&self, k: usize) -> Vector<D> {
        self.contact_force.get(k).copied().unwrap_or(Vector::ZERO)
    }

    /// Gravity at time `t` [s].
    fn gravity_at(&self, t: f64) -> Gravity<'_, D> {
        let Self { gravity: signals, position, .. } = self;
        let uniform = signals.iter().all(Signal::is_uniform);
        let everywhere = uniform.then(|| Vector::from_fn(|axis| signals[axis].value([0.0; 3], t)));
        Gravity { signals, position, t, everywhere }
    }

    /// Kinetic energy now [J].
    pub fn kinetic_energy(&self) -> f64 {
        parallel::sum(self.mass.len(), |k| 0.5 * self.mass[k] * self.velocity[k].norm_squared())
    }

    /// Momentum now [N s].
    pub fn momentum(&self) -> Vector<D> {
        parallel::sum(self.mass.len(), |k| self.velocity[k] * self.mass[k])
    }

    /// Energies now and works since the start.
    pub fn balance(&self) -> Balance {
        self.ledger.balance(self.kinetic_energy())
    }

    /// Impulses since the start [N s]: of pressure, gravity and damping; of contact; of the supports.
    pub fn impulses(&self) -> [Vector<D>; 3] {
        self.ledger.impulses().map(|j| Vector::from_fn(|axis| j[axis]))
    }

    /// Adds the work and impulse of every force of this step, with the mean velocity.
    fn book(&mut self, t: f64) {
        let (dt, nodes) = (self.momentum_dt, self.mass.len());
        let (drag, gravity) = (self.drag(), self.gravity_at(t));
        let work = parallel::reduce(
            nodes,
            |range| range.fold(ForcePower::default(), |sum, k| sum.plus(self.work(k, gravity.at(k), drag))),
            ForcePower::plus,
        )
        .unwrap_or_default();
        let (support_work, support_impulse) = self.book_supports(t);
        let ledger = &mut self.ledger;
        ledger.half_step = -work.elements_new * 0.5 * dt;
        ledger.elements.add(work.elements * dt);
        ledger.pressure.add(work.pressure * dt);
        ledger.gravity.add(work.gravity * dt);
        ledger.contact.add(work.contact * dt);
        ledger.mass_damping.add(work.damping * dt);
        ledger.supports.add(support_work);
        for axis in 0..D {
            ledger.external_impulse[axis].add(work.external_force[axis] * dt);
            ledger.contact_impulse[axis].add(work.contact_force[axis] * dt);
            ledger.support_impulse[axis].add(support_impulse[axis]);
        }
    }

    /// Power of the forces on node `k` under `gravity` [m/s²].
    #[inline(always)]
    fn work(&self, k: usize, gravity: Vector<D>, drag: f64) -> ForcePower<D> {
        let (old, new, m) = (self.before[k], self.velocity[k], self.mass[k]);
        let mean = (old + new) * 0.5;
        let (element, contact, pressure) = (self.element_force[k], self.contact_at(k), self.pressure.at(k));
        let (weight, drag) = (gravity * m, old * (drag * m));
        ForcePower {
            elements: element.dot(mean),
            elements_new: element.dot(new),
            pressure: pressure.dot(mean),
            gravity: weight.dot(mean),
            contact: contact.dot(mean),
            damping: drag.dot(mean),
            external_force: pressure + weight - drag,
            contact_force: contact,
        }
    }

    /// Work and impulse of the supports: what the momentum of their nodes changed by beyond the other forces.
    fn book_supports(&mut self, t: f64) -> (f64, Vector<D>) {
        let (gravity, drag, dt) = (self.gravity_at(t), self.drag(), self.momentum_dt);
        let prescribed = self.supports.prescribed();
        let impulse_on = |p: &Prescribed| {
            let (k, axis) = (p.node as usize, p.axis as usize);
            let (old, new, m) = (self.before[k][axis], self.velocity[k][axis], self.mass[k]);
            let body = m * (gravity.at(k) - self.before[k] * drag)[axis];
            let applied = self.element_force[k][axis] + self.pressure.at(k)[axis] + self.contact_at(k)[axis] + body;
            m * (new - old) - applied * dt
        };
        let impulses = parallel::collect(prescribed.len(), NODES, |n| impulse_on(&prescribed[n]));
        let work = parallel::sum(impulses.len(), |n| {
            let (k, axis) = (prescribed[n].node as usize, prescribed[n].axis as usize);
            impulses[n] * 0.5 * (self.before[k][axis] + self.velocity[k][axis])
        });
        let impulse = parallel::sum(impulses.len(), |n| Vector::unit(prescribed[n].axis as usize) * impulses[n]);
        let mut reaction = std::mem::take(&mut self.supports.reaction);
        reaction.fill([0.0; 3]);
        for (p, impulse) in self.supports.prescribed().iter().zip(impulses) {
            reaction[p.support as usize][p.axis as usize] += impulse / dt;
        }
        self.supports.reaction = reaction;
        (work, impulse)
    }

    /// One pass over all elements.
    pub(super) fn update_elements(&mut self) -> MembraneSums {
        let [quadrilaterals, triangles, segments] = self.elements.counts();
        let (first, none) = (FirstElement::default(), MembraneSums::default());
        let (sums, next) = if self.sheet.wrinkles() {
            self.update_group::<FullQuadrilateral, 4>(first, quadrilaterals, none)
        } else {
            self.update_group::<Quadrilateral, 4>(first, quadrilaterals, none)
        };
        let (sums, next) = self.update_group::<Triangle, 3>(next, triangles, sums);
        self.update_group::<Segment, 2>(next, segments, sums).0
    }

    /// Updates the `count` elements of one shape that begin at `first`; returns the sums and where the next shape
    /// begins.
    fn update_group<S: ElementShape<N>, const N: usize>(
        &mut self,
        first: FirstElement,
        count: usize,
        sums: MembraneSums,
    ) -> (MembraneSums, FirstElement) {
        let blocks = count.div_ceil(LANES);
        let (element, corner) = (first.element + count, first.corner + N * count);
        let next = FirstElement { block: first.block + blocks * S::POINTS, corner, element };
        let task = ElementTask {
            nodes: &self.elements.corner_nodes()[first.corner..next.corner],
            references: self.references.get(first.block..next.block).unwrap_or(&[]),
            position: &self.position,
            velocity: &self.velocity,
            parameters: &self.parameters,
            sheet: &*self.sheet,
        };
        let mut areas = self.pressure.areas().get_mut(first.element..next.element).unwrap_or(&mut []);
        let mut runs = Vec::with_capacity(blocks.div_ceil(TASK));
        let forces = self.corner_force[first.corner..next.corner].chunks_mut(TASK * LANES * N);
        for (index, (blocks, force)) in
            self.blocks[first.block..next.block].chunks_mut(TASK * S::POINTS).zip(forces).enumerate()
        {
            let (area, rest) = areas.split_at_mut((TASK * LANES).min(areas.len()));
            areas = rest;
            runs.push(Run { first: index * TASK, blocks, force, area });
        }
        let parts: Vec<MembraneSums> = parallel::map_parts(runs, |run| task.run::<S, N>(run));
        (parts.into_iter().fold(sums, MembraneSums::plus), next)
    }

    /// The error for the worst element or node.
    fn broken(&self, t: f64) -> StepError {
        let advice = "lower `mpm.membrane-safety` or the load, refine the sheet, or let it wrinkle";
        let error = |what: &str, place, quantity, value| StepError {
            time: t,
            ..StepError::new(place, what, quantity, value, advice)
        };
        if let Some(k) = (0..self.position.len()).find(|&k| !self.position[k].is_finite()) {
            let place = Place::Node { body: self.name.clone(), index: k, position: self.reference[k].to3() };
            return error("a membrane node went to infinity", place, "coordinate", f64::NAN);
        }
        let area = |e: usize| self.area_vector(e).norm();
        let worst = (0..self.elements.len()).min_by(|&a, &b| area(a).total_cmp(&area(b))).unwrap_or(0);
        let place = Place::Element { body: self.name.clone(), index: worst, position: self.centre(worst).to3() };
        error("a membrane element collapsed", place, "area", area(worst))
    }
}

/// Body force per unit mass at the nodes [m/s²]. Where it is the same everywhere, its formulas are evaluated once.
struct Gravity<'a, const D: usize> {
    signals: &'a [Signal; D],
    position: &'a [Vector<D>],
    t: f64,
    everywhere: Option<Vector<D>>,
}

impl<const D: usize> Gravity<'_, D> {
    #[inline(always)]
    fn at(&self, k: usize) -> Vector<D> {
        let here = || Vector::from_fn(|axis| self.signals[axis].value(self.position[k].to3(), self.t));
        self.everywhere.unwrap_or_else(here)
    }
}

/// The first element of one shape.
#[derive(Clone, Copy, Default)]
struct FirstElement {
    block: usize,
    corner: usize,
    element: usize,
}

/// Power of the forces on a node or several.
#[derive(Clone, Copy, Default)]
struct ForcePower<const D: usize> {
    elements: f64,
    elements_new: f64,
    pressure: f64,
    gravity: f64,
    contact: f64,
    damping: f64,
    external_force: Vector<D>,
    contact_force: Vector<D>,
}

impl<const D: usize> ForcePower<D> {
    #[inline(always)]
    fn plus(self, b: Self) -> Self {
        Self {
            elements: self.elements + b.elements,
            elements_new: self.elements_new + b.elements_new,
            pressure: self.pressure + b.pressure,
            gravity: self.gravity + b.gravity,
            contact: self.contact + b.contact,
            damping: self.damping + b.damping,
            external_force: self.external_force + b.external_force,
            contact_force: self.contact_force + b.contact_force,
        }
    }
}
