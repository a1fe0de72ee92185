//! One point of a surface where a body meets it, and the laws there.

use crate::math::Vector;
use crate::mpm::WallKind;

/// A point of a surface where a body meets it.
#[derive(Debug, Clone, Copy)]
pub struct Point<const D: usize> {
    pub boundary: u32,
    /// Body and particle whose foot it is; nothing where the obstacle binds.
    pub foot_of: Option<[u32; 2]>,
    /// x_c [m].
    pub place: Vector<D>,
    /// ν, out of the obstacle.
    pub normal: Vector<D>,
    /// g [m]; minus infinity where the obstacle binds.
    pub gap: f64,
    /// True if it was in contact in the step before.
    pub held: bool,
    /// True if what was in contact there stays so in this step: p⁻ is bound, too.
    pub rests: bool,
    /// True if it is in contact in this step.
    pub touches: bool,
    /// Force in this step [N].
    pub force: Vector<D>,
    /// M⁻¹ along each axis [1/kg], and the largest one for what slides.
    pub softness: Vector<D>,
    pub sliding_softness: f64,
    /// The nearer side of the grid by axis, numbered 2 axis + end, where a mirror is close.
    pub mirrors: Option<[usize; D]>,
    /// Its nodes in the list of all: from and to.
    pub start: u32,
    pub end: u32,
}

/// A node around a point.
#[derive(Debug, Clone, Copy)]
pub struct SupportNode<const D: usize> {
    /// Its number among the nodes of all points.
    pub number: u32,
    /// N_I along each axis: mirrors reverse one.
    pub weight: Vector<D>,
    /// W_I/N_I.
    pub tilt: f64,
}

impl<const D: usize> SupportNode<D> {
    /// N_I: mirrors leave it along one axis at least.
    #[inline]
    pub fn share(&self) -> f64 {
        (0..D).map(|a| self.weight[a]).fold(0.0, |most, n: f64| if n.abs() > most.abs() { n } else { most })
    }

    /// What the velocity `v` of the node adds to that of the point, whose normal is `n`.
    #[inline]
    pub fn read(&self, v: Vector<D>, n: Vector<D>) -> Vector<D> {
        let part = Vector::from_fn(|a| v[a] * self.weight[a]);
        part * self.tilt + n * (part.dot(n) * (1.0 - self.tilt))
    }

    /// What the node gets of an impulse `j` at the point.
    #[inline]
    pub fn give(&self, j: Vector<D>, n: Vector<D>) -> Vector<D> {
        let part = j * self.tilt + n * (j.dot(n) * (1.0 - self.tilt));
        Vector::from_fn(|a| part[a] * self.weight[a])
    }
}

/// A point while its impulse is sought: its velocity u and that of the wall there [m/s], and J so far [N s].
pub struct State<'a, const D: usize> {
    pub point: &'a Point<D>,
    pub wall: Vector<D>,
    pub velocity: Vector<D>,
    pub impulse: Vector<D>,
}

/// The impulse [N s] that a point in such a state should have.
pub type Law<'a, const D: usize> = &'a dyn Fn(&State<'_, D>) -> Vector<D>;

impl<const D: usize> Point<D> {
    /// Where nothing has happened yet.
    pub fn new((boundary, foot_of): (u32, Option<[u32; 2]>), [place, normal]: [Vector<D>; 2], gap: f64) -> Self {
        let (held, rests, touches) = (false, false, false);
        let (force, softness, sliding_softness) = (Vector::ZERO, Vector::ZERO, 0.0);
        Self {
            boundary,
            foot_of,
            place,
            normal,
            gap,
            held,
            rests,
            touches,
            force,
            softness,
            sliding_softness,
            mirrors: None,
            start: 0,
            end: 0,
        }
    }

    /// True if the obstacle binds.
    pub fn binds(&self) -> bool {
        self.foot_of.is_none()
    }

    /// The condition there of an obstacle of this kind: what creeps towards one that binds is only stopped.
    pub fn law(&self, kind: WallKind) -> WallKind {
        if self.binds() || !kind.binds() { kind } else { WallKind::Separate }
    }

    /// 1/M along the normal [1/kg].
    fn compliance(&self) -> f64 {
        (0..D).map(|a| self.normal[a] * self.normal[a] * self.softness[a]).sum()
    }
}

impl<const D: usize> State<'_, D> {
    /// The impulse after which the velocity along the normal is that of the wall.
    pub fn stopped(&self) -> Vector<D> {
        let normal = self.point.normal;
        self.impulse - normal * ((self.velocity - self.wall).dot(normal) / self.point.compliance())
    }

    /// The impulse of a condition of this kind; one that may be left lets the body approach by `allowed` [m/s].
    pub fn constrained(&self, kind: WallKind, allowed: f64) -> Vector<D> {
        let (relative, n) = (self.velocity - self.wall, self.point.normal);
        let sliding = (relative - n * relative.dot(n)) / self.point.sliding_softness;
        let coefficient = match kind {
            WallKind::Open => return self.impulse,
            WallKind::Slip => return self.stopped(),
            WallKind::Fixed => return self.stopped() - sliding,
            WallKind::Separate => 0.0,
            WallKind::Friction { coefficient } => coefficient,
        };
        let before = self.impulse.dot(n);
        let pressed = (before - (relative.dot(n) + allowed) / self.point.compliance()).max(0.0);
        let most = coefficient * pressed;
        if most == 0.0 {
            return n * pressed;
        }
        let wanted = self.impulse - n * before - sliding;
        let size = wanted.norm();
        n * pressed + if size > most { wanted * (most / size) } else { wanted }
    }
}
