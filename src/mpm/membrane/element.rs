//! The element kernels: strain, stress and nodal forces of a block of elements.
//!
//! Everything follows from the metric of the two tangents g₁, g₂. With contravariant components Tᵅᵝ of the stress
//! on the tangents, an element of volume V resists with (theory (C.14); Lian (42–45))
//!
//! ```text
//! f_K = Σ_α p_αK P_α,    P₁ = V (T¹¹ g₁ + T¹² g₂),    P₂ = V (T¹² g₁ + T²² g₂)
//! ```
//!
//! *Rate form* (theory C.3): the strain increment D Δt = ½ Δ(g_α·g_β), taken at mid-step where it is exact, in
//! the orthonormal frame that bisects the normalised tangents (Lian (32–41) with normalised tangents); stress history
//! in that frame.
//! *Total form* (theory (C.12)): C = Mᵀ (g_α·g_β) M and T = M S Mᵀ, where M holds the duals of the reference tangents
//! in the material axes; no frame is needed.

use super::frame::{BisectingFrame, contract, to_contravariant, to_material};
use super::hourglass::{Hourglass, HourglassForce, HourglassInput};
use super::lanes::{ElementLanes, LANES, LaneVector};
use super::shape::{ElementShape, Metric, Modes};
use crate::material::Sheet;
use bytemuck::{Pod, Zeroable};

/// History of a block of elements.
#[derive(Debug, Clone, Copy, Default, Pod, Zeroable)]
#[repr(C)]
pub struct HistoryBlock {
    /// Stress 11, 22, 12 of the flat sheet [Pa]: Cauchy in the co-rotational frame (rate laws),
    /// second Piola–Kirchhoff in the material axes (total laws).
    pub stress: [[f64; LANES]; 3],
    /// Thickness [m].
    pub thickness: [f64; LANES],
    /// Hourglass force on the tangents [N/m] and the normal [N].
    pub hourglass: [[f64; LANES]; 3],
    /// Work taken up by the hourglass control since the start [J].
    pub hourglass_work: [f64; LANES],
}

/// Reference state of a block of elements.
#[derive(Debug, Clone, Copy, Default)]
pub struct ReferenceBlock {
    /// Duals of the reference tangents in the material axes, g¹₁ g¹₂ g²₁ g²₂ [1/m].
    pub duals: [[f64; LANES]; 4],
    /// Volume [m³].
    pub volume: [f64; LANES],
    /// Thickness in the stress-free state [m].
    pub thickness: [f64; LANES],
    /// n Σ |∇N_K|²-like bound of the stable step: ω² = stiffness/ρ · bound [1/m²].
    pub bound: [f64; LANES],
}

/// Factor by which the steps of sheets that wrinkle are shorter than those of sheets that don't.
///
/// A slack element that snaps taut has moved past its length without a force. For one degree of freedom of frequency ω
/// and a random place in the step, the speed at which it comes back has 1.28 times the energy on average, up to 2.4,
/// where ω Δt = 1.6; where ω Δt = 1 and the stress has a viscous part of 0.05 of its increment, 0.86, at most 0.90.
pub const SNAP: f64 = 1.6;

/// The parameters that all elements of a membrane share.
#[derive(Debug, Clone, Copy)]
pub struct MembraneParameters {
    /// The step that led here, Δt^{n−½} [s].
    pub dt: f64,
    /// Hourglass control.
    pub hourglass: Hourglass,
    /// Stiffness-proportional damping time over Δt.
    pub damping: f64,
    /// Square of the in-plane wave speed [m²/s²].
    pub speed2: f64,
    /// 1 − ν², from Young's modulus over the plane-stress modulus.
    pub plane: f64,
    /// Density [kg/m³].
    pub density: f64,
}

/// Sums over elements of one step.
#[derive(Debug, Clone, Copy, Default)]
pub struct MembraneSums {
    /// Strain energy: increment (rate laws) or value (total laws) [J].
    pub strain: f64,
    /// Work taken up by the hourglass control [J].
    pub hourglass: f64,
    /// Energy lost to stiffness-proportional damping [J].
    pub damping: f64,
    /// Greatest ω² of an element [1/s²].
    pub frequency2: f64,
}

impl MembraneSums {
    /// Adds the sums of further elements.
    pub fn plus(self, other: Self) -> Self {
        Self {
            strain: self.strain + other.strain,
            hourglass: self.hourglass + other.hourglass,
            damping: self.damping + other.damping,
            frequency2: greater(self.frequency2, other.frequency2),
        }
    }
}

/// The greater of two numbers; NaN wins, so that it is noticed.
#[inline(always)]
fn greater(a: f64, b: f64) -> f64 {
    if b <= a || a.is_nan() { a } else { b }
}

/// Stress of a block, ready for the forces.
struct Stressed {
    /// V T¹¹, V T²², V T¹² on the current tangents.
    tension: [ElementLanes; 3],
    /// Volume for the hourglass control [m³].
    volume: ElementLanes,
    /// Strain energy and damping loss, as in [`MembraneSums`], per element.
    strain: ElementLanes,
    /// Damping loss [J].
    damping: ElementLanes,
    /// ω² of the element [1/s²].
    frequency2: ElementLanes,
}

/// Resultants of the stress on the patterns of g₁, g₂ and h [N], and [`Stressed`] summed over the quadrature points.
struct Resisted {
    /// Forces on the patterns of g₁, g₂ and h [N].
    on: [LaneVector; 3],
    /// The sums; of the frequencies the greatest.
    all: Stressed,
}

impl Resisted {
    /// The sum of both.
    #[inline(always)]
    fn plus(self, b: Self) -> Self {
        let all = Stressed {
            tension: std::array::from_fn(|i| self.all.tension[i] + b.all.tension[i]),
            volume: self.all.volume + b.all.volume,
            strain: self.all.strain + b.all.strain,
            damping: self.all.damping + b.all.damping,
            frequency2: ElementLanes(std::array::from_fn(|k| greater(self.all.frequency2.0[k], b.all.frequency2.0[k]))),
        };
        Self { on: std::array::from_fn(|i| self.on[i] + b.on[i]), all }
    }
}

/// Results of an update of the elements of a block.
pub struct Updated<const N: usize> {
    /// Force at each node [N].
    pub force: [LaneVector; N],
    /// Area vector over the number of nodes [m²].
    pub area: LaneVector,
    /// Sums over the elements.
    pub sums: MembraneSums,
}

/// The metric of a crumpled element is at least this [m⁴], so that its inverse is a number.
const LEAST_SPREAD: f64 = 1e-60;

/// The fourth power of the area over that of the reference, at most one: what is left of the viscosity of the hourglass
/// mode in an element of a sheet that wrinkles. The duals of one that crumples to a line grow as the inverse of its
/// squared area, and the viscosity with their squares: in full it would throw its nodes away.
#[inline(always)]
fn spread(area: ElementLanes, reference: Option<&ReferenceBlock>, volume: ElementLanes) -> ElementLanes {
    let Some(reference) = reference else { return ElementLanes::splat(1.0) };
    let ratio = area * ElementLanes(reference.thickness) / volume;
    let square = ratio * ratio;
    let fourth = square * square;
    -((-fourth).max(-1.0))
}

/// The tangents of a block of elements and their rates.
pub struct MovingTangents {
    now: Modes,
    rate: Modes,
}

impl MovingTangents {
    /// The state of elements with nodes at `x` [m] moving with `v` [m/s].
    #[inline(always)]
    pub fn of_nodes<S: ElementShape<N>, const N: usize>(x: [LaneVector; N], v: [LaneVector; N]) -> Self {
        Self { now: S::modes(x, 1.0), rate: S::modes(v, 0.0) }
    }
}

/// Updates `count` elements; they have a block and a reference for each quadrature point (rate laws: no reference).
#[inline(always)]
pub fn update<S: ElementShape<N>, const N: usize>(
    motion: &MovingTangents,
    parameters: &MembraneParameters,
    sheet: &dyn Sheet,
    blocks: &mut [HistoryBlock],
    references: &[ReferenceBlock],
    count: usize,
) -> Updated<N> {
    let mut resisted = resist_at::<S, N>(motion, 0, parameters, sheet, &mut blocks[0], references.first());
    for point in 1..S::POINTS {
        let (block, reference) = (&mut blocks[point], references.get(point));
        resisted = resisted.plus(resist_at::<S, N>(motion, point, parameters, sheet, block, reference));
    }
    let Resisted { on: [mut p, mut r, mut h], all: stressed } = resisted;
    let mut hourglass = 0.0;
    if S::HOURGLASS {
        let force = resist_hourglass::<S, N>(motion, parameters, &stressed, &mut blocks[0], references.first());
        (p, r, h) = (p + force.p, r + force.r, h + force.h);
        hourglass = force.work.sum(count);
    }
    let sums = MembraneSums {
        strain: stressed.strain.sum(count),
        hourglass,
        damping: stressed.damping.sum(count),
        frequency2: stressed.frequency2.0.into_iter().fold(0.0, greater),
    };
    // Lian (45): the nodes get the opposite.
    let area = motion.now.g1.cross(motion.now.g2) * (S::AREA / N as f64);
    Updated { force: S::spread(-p, -r, -h), area, sums }
}

/// Resultants of the stress at a quadrature point.
#[inline(always)]
fn resist_at<S: ElementShape<N>, const N: usize>(
    motion: &MovingTangents,
    point: usize,
    parameters: &MembraneParameters,
    sheet: &dyn Sheet,
    block: &mut HistoryBlock,
    reference: Option<&ReferenceBlock>,
) -> Resisted {
    let here = MovingTangents { now: S::at(&motion.now, point), rate: S::at(&motion.rate, point) };
    let now = &here.now;
    let metric = Metric::new(now.g1, now.g2);
    let all = match reference {
        None => rate_form::<S, N>(&here, &metric, parameters, sheet, block),
        Some(reference) => total_form(&here, &metric, parameters, sheet, block, reference),
    };
    let [t11, t22, t12] = all.tension;
    // Lian (42), Lian (43), along the tangents: vectors of space, as Lian (44) makes of them.
    Resisted { on: S::resultants(now.g1 * t11 + now.g2 * t12, now.g1 * t12 + now.g2 * t22, point), all }
}

/// Forces of the hourglass control of elements under the stress of all their points; `block` holds its history.
#[inline(always)]
fn resist_hourglass<S: ElementShape<N>, const N: usize>(
    MovingTangents { now, rate }: &MovingTangents,
    parameters: &MembraneParameters,
    stressed: &Stressed,
    block: &mut HistoryBlock,
    reference: Option<&ReferenceBlock>,
) -> HourglassForce {
    let metric = Metric::new(now.g1, now.g2);
    let area = metric.det.sqrt() * S::AREA;
    let [t11, t22, _] = stressed.tension;
    let spread = if S::POINTS > 1 { spread(area, reference, stressed.volume) } else { ElementLanes::splat(1.0) };
    let least = if S::POINTS > 1 { LEAST_SPREAD } else { 0.0 };
    let surroundings = HourglassInput {
        now,
        rate,
        metric: &metric,
        inverse: ElementLanes::splat(1.0) / metric.det.max(least * S::AREA * S::AREA),
        area,
        volume: stressed.volume * spread,
        // Several points see the mode and resist it themselves.
        tension: if S::POINTS > 1 { ElementLanes::splat(0.0) } else { t11 + t22 },
    };
    let mut q = block.hourglass.map(ElementLanes);
    let force = parameters.hourglass.resist(&surroundings, &mut q, parameters.dt);
    block.hourglass = q.map(|q| q.0);
    block.hourglass_work = (ElementLanes(block.hourglass_work) + force.work).0;
    force
}

/// Half the change of the metric over the step, at mid-step: the covariant strain increment (theory (C.10)).
#[inline(always)]
fn strain_increment(MovingTangents { now, rate }: &MovingTangents, dt: f64) -> (Metric, [ElementLanes; 3]) {
    let (u1, u2) = (rate.g1 * dt, rate.g2 * dt);
    let (m1, m2) = (now.g1 - u1 * 0.5, now.g2 - u2 * 0.5);
    // Lian (40), in covariant components.
    (Metric::new(m1, m2), [m1.dot(u1), m2.dot(u2), (m1.dot(u2) + m2.dot(u1)) * 0.5])
}

#[inline(always)]
fn rate_form<S: ElementShape<N>, const N: usize>(
    motion: &MovingTangents,
    metric: &Metric,
    parameters: &MembraneParameters,
    sheet: &dyn Sheet,
    block: &mut HistoryBlock,
) -> Stressed {
    let (middle, increment) = strain_increment(motion, parameters.dt);
    let d = BisectingFrame::new(&middle).local(increment);
    let (old, old_thickness) = (block.stress, ElementLanes(block.thickness));
    let d33 = ElementLanes(sheet.rate_lanes(&[d[0].0, d[1].0, (d[2] * 2.0).0], &mut block.stress));
    // (2 + D33 Δt)/(2 − D33 Δt), theory (C.11), is exp(D33 Δt) as the mid-point rule has it.
    let thickness = old_thickness * (d33 + 2.0) / (-d33 + 2.0);
    block.thickness = thickness.0;

    let (old, new) = (old.map(ElementLanes), block.stress.map(ElementLanes));
    let viscous: [ElementLanes; 3] = std::array::from_fn(|i| (new[i] - old[i]) * parameters.damping);
    let used = std::array::from_fn(|i| new[i] + viscous[i]);
    let mean = std::array::from_fn(|i| (old[i] + new[i]) * 0.5);
    let middle_volume = middle.det.sqrt() * (old_thickness + thickness) * (0.5 * S::AREA);
    let volume = metric.det.sqrt() * thickness * S::AREA;
    Stressed {
        tension: BisectingFrame::new(metric).contravariant(used).map(|t| t * volume),
        volume,
        strain: middle_volume * contract(mean, d),
        damping: middle_volume * contract(viscous, d),
        frequency2: bound::<S, N>(metric, parameters.plane) * parameters.speed2,
    }
}

#[inline(always)]
fn total_form(
    motion: &MovingTangents,
    metric: &Metric,
    parameters: &MembraneParameters,
    sheet: &dyn Sheet,
    block: &mut HistoryBlock,
    reference: &ReferenceBlock,
) -> Stressed {
    let duals = reference.duals.map(ElementLanes);
    let volume = ElementLanes(reference.volume);
    let state = sheet.total_lanes(&to_material(duals, [metric.a, metric.b, metric.c]).map(|c| c.0));
    let mut stiffness = ElementLanes(state.stiffness);
    if sheet.wrinkles() {
        // A slack or wrinkled point may be taut in the next step.
        stiffness = stiffness.max(parameters.speed2 * parameters.density) * (SNAP * SNAP);
    }
    let (old, elastic) = (block.stress.map(ElementLanes), state.stress.map(ElementLanes));
    block.stress = state.stress;
    block.thickness = (ElementLanes(reference.thickness) * ElementLanes(state.thickness)).0;
    let viscous: [ElementLanes; 3] = std::array::from_fn(|i| (elastic[i] - old[i]) * parameters.damping);
    let damping = if parameters.damping > 0.0 {
        let (_, increment) = strain_increment(motion, parameters.dt);
        volume * contract(viscous, to_material(duals, increment))
    } else {
        ElementLanes::splat(0.0)
    };
    let tension = to_contravariant(duals, std::array::from_fn(|i| elastic[i] + viscous[i]));
    Stressed {
        tension: tension.map(|t| t * volume),
        volume,
        strain: volume * ElementLanes(state.energy),
        damping,
        frequency2: ElementLanes(reference.bound) * stiffness * (1.0 / parameters.density),
    }
}

/// Bound of the element's greatest frequency (theory (C.33)): ω² = c² n μ, where
/// μ = ½ t + √(¼ t² − (1 − ν²) d) is the greatest eigenvalue of the strain modes, with the trace t and the
/// determinant d of Σ_K ∇N_K ⊗ ∇N_K. For a square of side s it gives Δt = 2/ω = s / (c √(1 + ν)).
#[inline(always)]
pub fn bound<S: ElementShape<N>, const N: usize>(metric: &Metric, plane: f64) -> ElementLanes {
    // In place of the characteristic length of Lian (48).
    let [trace, determinant] = S::gram(metric);
    let half = trace * 0.5;
    (half + (half * half - determinant * plane).max(0.0).sqrt()) * N as f64
}
