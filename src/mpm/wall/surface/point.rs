//! One point of an obstacle's surface with a condition for a body, and the laws there (theory E.5 to E.7).

use crate::math::Vector;
use crate::mpm::WallKind;

/// A place on the surface of a wall or an obstacle.
#[derive(Debug, Clone, Copy)]
pub struct SurfaceFoot<const D: usize> {
    pub boundary: u32,
    /// x_c [m].
    pub place: Vector<D>,
    /// ν, out of the obstacle.
    pub normal: Vector<D>,
}

/// A point of a surface with a condition for a body during a step.
#[derive(Debug, Clone, Copy)]
pub struct SurfacePoint<const D: usize> {
    pub boundary: u32,
    /// Body and particle whose foot it is; `None` where the obstacle binds.
    pub particle: Option<[u32; 2]>,
    /// x_c [m].
    pub place: Vector<D>,
    /// ν, out of the obstacle.
    pub normal: Vector<D>,
    /// g [m]; minus infinity where the obstacle binds.
    pub gap: f64,
    /// True if it was in contact in the step before.
    pub held: bool,
    /// True if that contact lasts in this step: p⁻ is bound, too.
    pub lasts: bool,
    /// True if it is in contact in this step.
    pub touches: bool,
    /// Force in this step [N].
    pub force: Vector<D>,
    /// M⁻¹ along each axis [1/kg], and the largest one with the weights for sliding.
    pub inverse_mass: Vector<D>,
    pub sliding_inverse_mass: f64,
    /// The nearer side of the grid by axis, numbered 2 axis + end, where a mirror is close.
    pub mirrors: Option<[usize; D]>,
    /// Nodes of the point in the list of all: from and to.
    pub start: u32,
    pub end: u32,
}

/// A node around a point.
#[derive(Debug, Clone, Copy)]
pub struct NodeOfSupport<const D: usize> {
    /// Number of the node among those of all points.
    pub number: u32,
    /// N_I along each axis: mirrors reverse one.
    pub weight: Vector<D>,
    /// W_I/N_I.
    pub tilt: f64,
}

impl<const D: usize> NodeOfSupport<D> {
    /// N_I: mirrors leave it along one axis at least.
    #[inline]
    pub fn shape_function(&self) -> f64 {
        (0..D).map(|a| self.weight[a]).fold(0.0, |most, n: f64| if n.abs() > most.abs() { n } else { most })
    }

    /// Contribution of the velocity `v` of the node to that of the point, whose normal is `n`.
    #[inline]
    pub fn read(&self, v: Vector<D>, n: Vector<D>) -> Vector<D> {
        let part = Vector::from_fn(|a| v[a] * self.weight[a]);
        part * self.tilt + n * (part.dot(n) * (1.0 - self.tilt))
    }

    /// Impulse on the node of an impulse `j` at the point, whose normal is `n`.
    #[inline]
    pub fn spread(&self, j: Vector<D>, n: Vector<D>) -> Vector<D> {
        let part = j * self.tilt + n * (j.dot(n) * (1.0 - self.tilt));
        Vector::from_fn(|a| part[a] * self.weight[a])
    }
}

/// A point while its impulse is sought: its velocity u and that of the wall there [m/s], and J so far [N s].
pub struct ImpulseIterate<'a, const D: usize> {
    pub point: &'a SurfacePoint<D>,
    pub wall: Vector<D>,
    pub velocity: Vector<D>,
    pub impulse: Vector<D>,
}

/// The impulse [N s] that a point in such a state should have.
pub type ImpulseLaw<'a, const D: usize> = &'a dyn Fn(&ImpulseIterate<'_, D>) -> Vector<D>;

impl<const D: usize> SurfacePoint<D> {
    /// A point without contact and impulse yet.
    pub fn new(foot: SurfaceFoot<D>, particle: Option<[u32; 2]>, gap: f64) -> Self {
        let SurfaceFoot { boundary, place, normal } = foot;
        let (held, lasts, touches) = (false, false, false);
        let (force, inverse_mass, sliding_inverse_mass) = (Vector::ZERO, Vector::ZERO, 0.0);
        Self {
            boundary,
            particle,
            place,
            normal,
            gap,
            held,
            lasts,
            touches,
            force,
            inverse_mass,
            sliding_inverse_mass,
            mirrors: None,
            start: 0,
            end: 0,
        }
    }

    /// True if the obstacle binds.
    pub fn binds(&self) -> bool {
        self.particle.is_none()
    }

    /// The condition there of an obstacle of this kind: particles that creep towards one that binds are only stopped.
    pub fn law(&self, kind: WallKind) -> WallKind {
        if self.binds() || !kind.binds() { kind } else { WallKind::Separate }
    }

    /// 1/M along the normal [1/kg].
    fn compliance(&self) -> f64 {
        (0..D).map(|a| self.normal[a] * self.normal[a] * self.inverse_mass[a]).sum()
    }
}

impl<const D: usize> ImpulseIterate<'_, D> {
    /// The impulse after which the velocity along the normal is that of the wall.
    pub fn stopped(&self) -> Vector<D> {
        let normal = self.point.normal;
        self.impulse - normal * ((self.velocity - self.wall).dot(normal) / self.point.compliance())
    }

    /// The impulse of a condition of this kind; one that may be left lets the body approach by `allowed` [m/s].
    pub fn constrained(&self, kind: WallKind, allowed: f64) -> Vector<D> {
        let (relative, n) = (self.velocity - self.wall, self.point.normal);
        let sliding = (relative - n * relative.dot(n)) / self.point.sliding_inverse_mass;
        let coefficient = match kind {
            WallKind::Open => return self.impulse,
            WallKind::Slip => return self.stopped(),
            WallKind::Fixed => return self.stopped() - sliding,
            WallKind::Separate => 0.0,
            WallKind::Friction { coefficient } => coefficient,
        };
        let before = self.impulse.dot(n);
        let normal_impulse = (before - (relative.dot(n) + allowed) / self.point.compliance()).max(0.0);
        let most = coefficient * normal_impulse;
        if most == 0.0 {
            return n * normal_impulse;
        }
        let wanted = self.impulse - n * before - sliding;
        let size = wanted.norm();
        n * normal_impulse + if size > most { wanted * (most / size) } else { wanted }
    }
}
