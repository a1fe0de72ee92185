//! Rigid solids, and elastic ones without supports: flight of the centre of mass, without the resistance of the fluid.
//!
//! ```text
//! m x″ = (m − m_f(x)) g − k x      along axes that are free, m_f: mass of the fluid in the solid's place
//! x′ = v̄(t),   R′ = ω̄(t) × R        along axes that supports or the motion prescribe
//! x′ + U e                         once more with each stream, along free axes without springs
//! ± min(½ρU² A/k, U/ω, L)          on springs in a stream
//! ```
//!
//! It ends its way along an axis at the box around the mesh. Turns that nothing prescribes are left out.

use super::{AmbientStream, Placement, SolidSurroundings, extent, longest_side, nodes_of};
use crate::math::{Signal, Tensor, Vector};
use crate::pfem2::solid::rigid::turned_by;
use crate::pfem2::solid::setup::SolidSetup;
use crate::pfem2::solid::structure::Structure;

/// Steps of a flight, at least and at most.
const STEPS: [usize; 2] = [400, 4000];

/// Steps for a radian of the swing on a spring.
const PER_RADIAN: f64 = 10.0;

/// Least distance between two poses that are kept, over the length of the solid and over that of the mesh: the larger
/// distance counts.
const APART: [f64; 2] = [0.1, 0.005];

/// Parts of a displacement on springs that are looked at.
const PARTS: usize = 16;

/// Motion of a solid along an axis.
enum FlightAxis {
    /// By a prescribed velocity, at a place.
    Prescribed(Signal, [f64; 3]),
    /// By forces, and a spring of this stiffness [N/m].
    Free(f64),
}

impl FlightAxis {
    /// Stiffness of the spring; zero without one [N/m].
    fn stiffness(&self) -> f64 {
        match self {
            Self::Prescribed(..) => 0.0,
            Self::Free(stiffness) => *stiffness,
        }
    }
}

/// A solid that flies.
struct Flight<'a, const D: usize, const N: usize> {
    setup: &'a SolidSetup<D>,
    around: &'a SolidSurroundings<'a, D, N>,
    /// Mass fractions of the nodes.
    mass_fractions: Vec<f64>,
    mass: f64,
    center: Vector<D>,
    velocity: Vector<D>,
    axes: [FlightAxis; D],
    /// Least and largest displacement along each axis with which the solid stays in the box around the mesh [m].
    range: [[f64; 2]; D],
}

/// Displacement of the centre of mass, and rotation about it.
#[derive(Clone, Copy)]
struct Pose<const D: usize> {
    shift: Vector<D>,
    rotation: Tensor<3>,
}

/// Placements of a solid that it is likely to come to.
pub(super) fn placements<const D: usize, const N: usize>(
    structure: &Structure<D>,
    number: usize,
    around: &SolidSurroundings<D, N>,
    stream: Option<&AmbientStream<D>>,
) -> Vec<Placement<D>> {
    let flight = Flight::new(structure, number, around);
    if flight.is_held() {
        return Vec::new();
    }
    let streams = stream.into_iter().flat_map(|stream| stream.directions.iter().map(|e| *e * stream.speed));
    let starts = std::iter::once(Vector::ZERO).chain(streams);
    let poses = starts.flat_map(|with| flight.poses(with));
    let shaken = stream.into_iter().flat_map(|stream| flight.on_springs(structure, number, stream));
    poses.chain(shaken).map(|pose| flight.placement(&pose)).collect()
}

/// Displacements of what follows a velocity until the end of a run [m].
pub(super) fn followed<const D: usize>(end: f64, velocity: impl Fn(f64) -> Vector<D>) -> Vec<Vector<D>> {
    let dt = end / STEPS[0] as f64;
    let way = (0..STEPS[0]).scan(Vector::ZERO, |x, k| {
        *x += velocity((k as f64 + 0.5) * dt) * dt;
        Some(*x)
    });
    way.collect()
}

impl<'a, const D: usize, const N: usize> Flight<'a, D, N> {
    fn new(structure: &'a Structure<D>, number: usize, around: &'a SolidSurroundings<'a, D, N>) -> Self {
        let (setup, nodes) = (&structure.setups()[number], nodes_of(structure, number));
        let masses = structure.nodal_masses()[nodes.clone()].to_vec();
        let mass: f64 = masses.iter().sum();
        let mean = |of: &[Vector<D>]| of.iter().zip(&masses).map(|(x, m)| *x * (m / mass)).sum::<Vector<D>>();
        let range = |axis: usize| {
            let ([lower, upper], [least, most]) = (extent(&setup.mesh.nodes, axis), extent(around.mesh.nodes(), axis));
            [(least - lower).min(0.0), (most - upper).max(0.0)]
        };
        Self {
            setup,
            around,
            mass,
            center: mean(&setup.mesh.nodes),
            velocity: mean(&structure.state.velocity[nodes]),
            axes: std::array::from_fn(|axis| axis_motion(setup, axis)),
            range: std::array::from_fn(range),
            mass_fractions: masses.iter().map(|m| m / mass).collect(),
        }
    }

    /// True if nothing moves the solid.
    fn is_held(&self) -> bool {
        let still = |motion: &FlightAxis| matches!(motion, FlightAxis::Prescribed(velocity, _) if velocity.is_zero());
        self.axes.iter().all(still) && self.setup.motion.spin.iter().flatten().all(Signal::is_zero)
    }

    /// Poses along the way of the solid, with a velocity that is added to that at the start along axes where nothing
    /// leads or holds it [m/s].
    fn poses(&self, with: Vector<D>) -> Vec<Pose<D>> {
        let (count, dt) = self.steps();
        let is_loose = |axis: usize| matches!(self.axes[axis], FlightAxis::Free(0.0));
        let mut velocity = self.velocity + Vector::from_fn(|axis| if is_loose(axis) { with[axis] } else { 0.0 });
        let mut pose = Pose { shift: Vector::ZERO, rotation: Tensor::identity() };
        let (mut kept, mut farthest) = (vec![pose], pose);
        for k in 0..count {
            self.advance(&mut pose, &mut velocity, (k as f64 + 0.5) * dt, dt);
            if self.is_apart(&pose, &kept[kept.len() - 1]) {
                kept.push(pose);
            }
            if pose.shift.norm() > farthest.shift.norm() {
                farthest = pose;
            }
        }
        kept.push(farthest);
        kept
    }

    /// Number and length [s] of the steps of a flight: to the end of the run, or over many swings.
    fn steps(&self) -> (usize, f64) {
        let end = self.around.file.time.end;
        let omega = (self.axes.iter().map(FlightAxis::stiffness).fold(0.0, f64::max) / self.mass).sqrt();
        let count = ((PER_RADIAN * omega * end) as usize).clamp(STEPS[0], STEPS[1]);
        (count, (end / count as f64).min(1.0 / (PER_RADIAN * omega)))
    }

    /// A step of `dt` [s] with its middle at `t` [s].
    fn advance(&self, pose: &mut Pose<D>, velocity: &mut Vector<D>, t: f64, dt: f64) {
        let acceleration = self.acceleration(pose.shift, t);
        for (axis, motion) in self.axes.iter().enumerate() {
            match motion {
                FlightAxis::Prescribed(led, place) => velocity[axis] = led.value(*place, t),
                FlightAxis::Free(k) => velocity[axis] += dt * (acceleration[axis] - k / self.mass * pose.shift[axis]),
            }
            pose.shift[axis] += dt * velocity[axis];
            let inside = pose.shift[axis].clamp(self.range[axis][0], self.range[axis][1]);
            if inside != pose.shift[axis] {
                (pose.shift[axis], velocity[axis]) = (inside, 0.0);
            }
        }
        let spin = |axis: usize| self.setup.motion.spin[axis].as_ref().map_or(0.0, |spin| spin.value([0.0; 3], t));
        pose.rotation = turned_by(Vector(std::array::from_fn(spin)) * dt, &pose.rotation);
    }

    fn is_apart(&self, pose: &Pose<D>, last: &Pose<D>) -> bool {
        let length = longest_side(self.setup);
        let turned = (0..3).map(|i| (Vector(pose.rotation[i]) - Vector(last.rotation[i])).norm()).fold(0.0, f64::max);
        let mesh = (0..D).map(|axis| extent(self.around.mesh.nodes(), axis)).map(|[a, b]| b - a).fold(0.0, f64::max);
        (pose.shift - last.shift).norm() + turned * length > (APART[0] * length).max(APART[1] * mesh)
    }

    /// Acceleration by weight less buoyancy, at a displacement [m] and a time [s] [m/s²].
    fn acceleration(&self, shift: Vector<D>, t: f64) -> Vector<D> {
        let gravity = self.around.gravity(self.center + shift, t);
        if gravity == Vector::ZERO {
            return gravity;
        }
        let fluid = match self.around.fluids {
            [fluid] => fluid.density,
            _ => {
                let nodes = self.setup.mesh.nodes.iter().zip(&self.mass_fractions);
                nodes.map(|(x, fraction)| fraction * self.around.density(*x + shift)).sum()
            }
        };
        gravity * (1.0 - fluid / self.setup.law.density())
    }

    /// Poses of a solid that goes to and fro on its springs in a stream.
    fn on_springs(&self, structure: &Structure<D>, number: usize, stream: &AmbientStream<D>) -> Vec<Pose<D>> {
        let along = |(axis, motion): (usize, &FlightAxis)| {
            let stiffness = motion.stiffness();
            let e = Vector::<D>::unit(axis);
            let area = structure.frontal_areas(number, e).into_iter().sum::<Vector<D>>().dot(e);
            let fastest = stream.speed * (self.mass / stiffness).sqrt().min(self.around.file.time.end);
            let most = (stream.pressure() * area / stiffness).min(fastest).min(longest_side(self.setup));
            let parts = (0..=2 * PARTS).map(|k| k as f64 / PARTS as f64 - 1.0);
            let pose = move |part: f64| Pose { shift: e * (part * most), rotation: Tensor::identity() };
            (stiffness > 0.0).then(|| parts.map(pose).collect::<Vec<_>>())
        };
        self.axes.iter().enumerate().filter_map(along).flatten().collect()
    }

    fn placement(&self, pose: &Pose<D>) -> Placement<D> {
        let turned = |x: &Vector<D>| {
            let arm = Vector::<3>((*x - self.center).to3());
            pose.shift + Vector::from3((pose.rotation.apply(arm) - arm).0)
        };
        self.setup.mesh.nodes.iter().map(turned).collect()
    }
}

/// Motion of a solid along an axis: where several things prescribe it that of the solid, then that of the first
/// support.
fn axis_motion<const D: usize>(setup: &SolidSetup<D>, axis: usize) -> FlightAxis {
    if let Some(velocity) = &setup.motion.velocity[axis] {
        return FlightAxis::Prescribed(velocity.clone(), [0.0; 3]);
    }
    let held = setup.held.iter().find_map(|held| Some((held.velocity[axis].clone()?, *held.nodes.first()?)));
    match held {
        Some((velocity, node)) => FlightAxis::Prescribed(velocity, setup.mesh.nodes[node as usize].to3()),
        None => FlightAxis::Free(setup.springs.iter().map(|spring| spring.stiffness[axis]).sum()),
    }
}
