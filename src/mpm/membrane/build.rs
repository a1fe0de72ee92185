//! From a set-up to a membrane: checks, lumped masses, reference state, prestress (theory C.2, C.3, C.8, C.10).

use super::connectivity::MembraneElements;
use super::element::{self, HistoryBlock, MembraneParameters, ReferenceBlock};
use super::enclosed::VolumeOrigin;
use super::hourglass::Hourglass;
use super::lanes::{ElementLanes, LANES, LaneVector};
use super::ledger::MembraneLedger;
use super::load::{Pressure, Supports, area_vector};
use super::shape::{ElementShape, FullQuadrilateral, Metric, Modes, Quadrilateral, Segment, Triangle};
use super::{Membrane, task};
use crate::error::Diagnostic;
use crate::material::{Sheet, SheetKind};
use crate::math::{Signal, Vector};
use crate::mpm::MembraneSetup;

impl<const D: usize> Membrane<D> {
    /// Builds a membrane at rest under no gravity.
    ///
    /// # Errors
    /// Every finding: elements with too few or unknown nodes, without area or folded over; nodes that no element uses;
    /// a thickness that is not positive; a law without a wave speed.
    pub fn new(setup: MembraneSetup<D>) -> Result<Self, Vec<Diagnostic>> {
        let findings = check(&setup);
        if !findings.is_empty() {
            return Err(findings);
        }
        let points = if setup.sheet.wrinkles() { FullQuadrilateral::POINTS } else { Quadrilateral::POINTS };
        let elements = MembraneElements::new(&setup.elements, setup.position.len(), points);
        let nodes = setup.position.len();
        let warp = sorted_by_shape(&setup.elements, &setup.warp);
        let pressure = Pressure::new(setup.pressure, setup.follower, &elements, &setup.position);
        let mut membrane = Self {
            name: setup.name,
            reference: setup.position.clone(),
            mass: lumped_mass(&elements, &setup.position, setup.sheet.density() * setup.thickness),
            contact_thickness: setup.contact_thickness,
            gravity: std::array::from_fn(|_| Signal::ZERO),
            pressure,
            supports: Supports::new(&setup.supports, nodes, D),
            mass_damping: setup.damping[1],
            parameters: parameters(&*setup.sheet, setup.hourglass, setup.damping[0]),
            blocks: vec![HistoryBlock::default(); elements.block_count()],
            references: Vec::new(),
            before: setup.velocity.clone(),
            corner_force: vec![Vector::ZERO; elements.corner_nodes().len()],
            element_force: vec![Vector::ZERO; nodes],
            contact_force: vec![Vector::ZERO; nodes],
            touch: Vec::new(),
            touch_time: 0.0,
            enclosure: VolumeOrigin::new(&elements, &setup.position),
            momentum_dt: 0.0,
            ledger: MembraneLedger::default(),
            position: setup.position,
            velocity: setup.velocity,
            elements,
            sheet: setup.sheet,
        };
        membrane.initialise(&warp, setup.thickness, setup.prestress)?;
        Ok(membrane)
    }

    /// Thickness, prestress and the reference state of total laws; then the first energy and stable step.
    fn initialise(&mut self, warp: &[Vector<D>], thickness: f64, prestress: [f64; 2]) -> Result<(), Vec<Diagnostic>> {
        let natural = match self.sheet.kind() {
            SheetKind::Rate => {
                let stress = [prestress[0], prestress[1], 0.0].map(|s| [s; LANES]);
                self.blocks.fill(HistoryBlock { stress, thickness: [thickness; LANES], ..HistoryBlock::default() });
                if !warp.is_empty() {
                    self.turn_prestress(warp, prestress);
                }
                None
            }
            SheetKind::Total => Some(
                Natural::find(&*self.sheet, prestress, D == 2)
                    .map_err(|message| vec![Diagnostic::error("prestress", message)])?,
            ),
        };
        if let Some(natural) = natural {
            let [quadrilaterals, triangles, segments] = self.elements.counts();
            self.references.reserve(self.blocks.len());
            let mut first = 0;
            if self.sheet.wrinkles() {
                self.add_references::<FullQuadrilateral, 4>(&mut first, quadrilaterals, warp, thickness, natural);
            } else {
                self.add_references::<Quadrilateral, 4>(&mut first, quadrilaterals, warp, thickness, natural);
            }
            self.add_references::<Triangle, 3>(&mut first, triangles, warp, thickness, natural);
            self.add_references::<Segment, 2>(&mut first, segments, warp, thickness, natural);
        }
        let sums = self.update_elements();
        let kinetic = self.kinetic_energy();
        let ledger = &mut self.ledger;
        let strain = if self.sheet.kind() == SheetKind::Total { sums.strain } else { 0.0 };
        (ledger.frequency2, ledger.kinetic_start) = (sums.frequency2, kinetic);
        (ledger.strain, ledger.strain_start) = (strain.into(), strain);
        Ok(())
    }

    /// Reference duals of `count` elements of one shape from element `first` on.
    fn add_references<S: ElementShape<N>, const N: usize>(
        &mut self,
        first: &mut usize,
        count: usize,
        warp: &[Vector<D>],
        thickness: f64,
        natural: Natural,
    ) {
        for start in (0..count).step_by(LANES) {
            let lanes = LANES.min(count - start);
            let nodes: Vec<u32> = (0..lanes).flat_map(|k| self.elements.nodes(*first + start + k).to_vec()).collect();
            let x: [LaneVector; N] = task::gather(&nodes, lanes, &self.reference);
            let modes = S::modes(x, 1.0);
            let warp = std::array::from_fn(|k| warp.get(*first + start + k.min(lanes - 1)).map(|w| Vector(w.to3())));
            let plane = self.parameters.plane;
            self.references.extend((0..S::POINTS).map(|point| {
                let mut reference = reference_at::<S, N>(&modes, point, &warp, thickness, natural);
                reference.bound = element::bound::<S, N>(&natural_metric(&reference), plane).0;
                reference
            }));
        }
        *first += count;
    }

    /// Rate laws keep stress in the element frame: turns a prestress along the warp into it.
    fn turn_prestress(&mut self, warp: &[Vector<D>], prestress: [f64; 2]) {
        for (e, warp) in warp.iter().enumerate() {
            let x = |k: usize| Vector(self.reference[self.elements.nodes(e)[k] as usize].to3());
            let tangents = match self.elements.nodes(e).len() {
                4 => [x(1) - x(0) + x(2) - x(3), x(2) - x(0) + x(3) - x(1)],
                3 => [x(1) - x(0), x(2) - x(0)],
                _ => continue,
            };
            let [e1, e2] = bisector_axes(tangents);
            let [d1, _] = material_axes(tangents, Some(Vector(warp.to3())));
            let (c, s) = (d1.dot(e1), d1.dot(e2));
            let [p1, p2] = prestress;
            let stress = [p1 * c * c + p2 * s * s, p1 * s * s + p2 * c * c, (p1 - p2) * c * s];
            let (blocks, lane) = self.elements.blocks_and_lane(e);
            self.blocks[blocks].iter_mut().for_each(|block| (0..3).for_each(|i| block.stress[i][lane] = stress[i]));
        }
    }
}

/// Reference state at a quadrature point of the elements with the given tangents and warps, without its bound.
fn reference_at<S: ElementShape<N>, const N: usize>(
    modes: &Modes,
    point: usize,
    warp: &[Option<Vector<3>>; LANES],
    thickness: f64,
    natural: Natural,
) -> ReferenceBlock {
    let tangents = |m: &Modes, k: usize| [m.g1, m.g2].map(|g| Vector(g.0.map(|axis| axis.0[k])));
    let here = S::at(modes, point);
    let area = Metric::new(here.g1, here.g2).det.sqrt() * (S::AREA / S::POINTS as f64);
    let [l1, l2, l3] = natural.stretch;
    let mut reference = ReferenceBlock { thickness: [thickness / l3; LANES], ..ReferenceBlock::default() };
    for k in 0..LANES {
        // The points of an element have their axes in common.
        let common = || (S::POINTS > 1).then(|| bisector_axes(tangents(modes, k))[0]);
        let here = tangents(&here, k);
        let duals = duals(here, material_axes(here, warp[k].or_else(common)), natural.stretch);
        (0..4).for_each(|i| reference.duals[i][k] = duals[i]);
        reference.volume[k] = area.0[k] * thickness / (l1 * l2 * l3);
    }
    reference
}

/// The findings about a set-up.
fn check<const D: usize>(setup: &MembraneSetup<D>) -> Vec<Diagnostic> {
    let mut findings = Vec::new();
    let mut error = |key: &str, message: String| findings.push(Diagnostic::error(key, message));
    if !(setup.thickness > 0.0 && setup.thickness.is_finite()) {
        error("thickness", format!("the thickness must be positive, not {} m", setup.thickness));
    }
    let speed = setup.sheet.wave_speed();
    if !(speed > 0.0 && speed.is_finite()) {
        error("material", format!("these constants give no stable material (speed of waves {speed} m/s)"));
    }
    if setup.velocity.len() != setup.position.len() {
        error("velocity", format!("{} velocities for {} nodes", setup.velocity.len(), setup.position.len()));
    }
    if setup.elements.is_empty() {
        error("geometry", "the membrane has no elements".into());
    }
    let mut used = vec![false; setup.position.len()];
    for (e, element) in setup.elements.iter().enumerate() {
        match check_element(element, &setup.position) {
            Ok(()) => element.iter().for_each(|&k| used[k as usize] = true),
            Err(message) => error("geometry", format!("element {e} {message}")),
        }
    }
    let unused = used.iter().filter(|&&used| !used).count();
    if unused > 0 && findings.is_empty() {
        let first = used.iter().position(|&used| !used).unwrap_or(0);
        let message = format!("{unused} nodes belong to no element (the first is node {first})");
        findings.push(Diagnostic::error("geometry", message).help("remove them from the mesh"));
    }
    findings
}

/// The findings about one element.
fn check_element<const D: usize>(element: &[u32], position: &[Vector<D>]) -> Result<(), String> {
    let allowed: &[usize] = if D == 3 { &[3, 4] } else { &[2] };
    if !allowed.contains(&element.len()) {
        return Err(format!("has {} nodes; {D}D membranes have elements of {allowed:?} nodes", element.len()));
    }
    if let Some(node) = element.iter().find(|&&k| k as usize >= position.len()) {
        return Err(format!("names node {node}, but there are {}", position.len()));
    }
    if let Some(node) = element.iter().find(|&&k| !position[k as usize].is_finite()) {
        return Err(format!("has node {node} at infinity"));
    }
    let size =
        element.iter().map(|&k| (position[k as usize] - position[element[0] as usize]).norm()).fold(0.0, f64::max);
    let area = area_vector(element, position);
    if area.norm() <= 1e-9 * size.powi(D as i32 - 1) {
        return Err("has no area".into());
    }
    if let [a, b, c, d] = *element {
        // Each half of a valid quadrilateral looks the same way as the whole.
        let halves = [[a, b, c], [b, c, d], [c, d, a], [d, a, b]];
        if halves.iter().any(|half| area_vector(half, position).dot(area) <= 0.0) {
            return Err("is folded over: its corners are out of order or one is re-entrant".into());
        }
    }
    Ok(())
}

/// Equal parts of each element's mass for its nodes (theory (C.27)).
fn lumped_mass<const D: usize>(elements: &MembraneElements, position: &[Vector<D>], areal_density: f64) -> Vec<f64> {
    let part: Vec<f64> =
        elements.iter().map(|nodes| areal_density * area_vector(nodes, position).norm() / nodes.len() as f64).collect();
    (0..position.len()).map(|k| elements.corners(k).iter().map(|&c| part[elements.element_of(c)]).sum()).collect()
}

/// Per-element values in the order of [`MembraneElements`].
fn sorted_by_shape<T: Copy>(elements: &[Vec<u32>], values: &[T]) -> Vec<T> {
    let of_size = |n: usize| elements.iter().zip(values).filter(move |(e, _)| e.len() == n).map(|(_, &value)| value);
    [4, 3, 2].into_iter().flat_map(of_size).collect()
}

/// Least stiffness-proportional damping time of sheets that wrinkle, over Δt ([`element::SNAP`]).
const SNAP_DAMPING: f64 = 0.05;

fn parameters(sheet: &dyn Sheet, [stiffness, viscosity, warping]: [f64; 3], damping: f64) -> MembraneParameters {
    let (density, c) = (sheet.density(), sheet.wave_speed());
    let hourglass = Hourglass {
        // The 2 × 2 points of sheets that wrinkle see the hourglass mode.
        stiffness: if sheet.wrinkles() { 0.0 } else { stiffness * sheet.modulus() },
        viscosity: viscosity * 0.25 * density * c,
        warping_viscosity: warping * 0.25 * density * c,
    };
    let damping = if sheet.wrinkles() { damping.max(SNAP_DAMPING) } else { damping };
    let plane = (sheet.modulus() / (density * c * c)).min(1.0);
    MembraneParameters { dt: 0.0, hourglass, damping, speed2: c * c, plane, density }
}

/// Orthonormal axes e1, e2 in the plane of two tangents, e1 along `warp` (projected) or, without it, bisecting.
fn material_axes(tangents: [Vector<3>; 2], warp: Option<Vector<3>>) -> [Vector<3>; 2] {
    let bisector = bisector_axes(tangents);
    let normal = bisector[0].cross(bisector[1]);
    match warp.and_then(|w| (w - normal * w.dot(normal)).normalized()) {
        Some(e1) => [e1, normal.cross(e1)],
        None => bisector,
    }
}

/// The frame that bisects the normalised tangents (theory (C.6)).
pub(super) fn bisector_axes([g1, g2]: [Vector<3>; 2]) -> [Vector<3>; 2] {
    let (u, v) = (g1 * (1.0 / g1.norm()), g2 * (1.0 / g2.norm()));
    let unit = |w: Vector<3>| w * (1.0 / w.norm());
    let alpha = unit(u + v); // Lian (35)
    let beta = unit(v - u); // Lian (36)
    let e1 = (alpha - beta) * std::f64::consts::FRAC_1_SQRT_2; // Lian (37)
    let e2 = (alpha + beta) * std::f64::consts::FRAC_1_SQRT_2; // Lian (38)
    [e1, e2]
}

/// Duals of the stress-free tangents in the material axes: the inverse of their components.
fn duals([g1, g2]: [Vector<3>; 2], [e1, e2]: [Vector<3>; 2], [l1, l2, _]: [f64; 3]) -> [f64; 4] {
    let [j11, j12, j21, j22] = [g1.dot(e1) / l1, g2.dot(e1) / l1, g1.dot(e2) / l2, g2.dot(e2) / l2];
    let det = j11 * j22 - j12 * j21;
    [j22 / det, -j12 / det, -j21 / det, j11 / det]
}

/// Metric of the stress-free tangents, from their duals: the inverse of the products of the duals.
fn natural_metric(reference: &ReferenceBlock) -> Metric {
    let [m11, m12, m21, m22] = reference.duals.map(ElementLanes);
    let (a, b, c) = (m11 * m11 + m12 * m12, m21 * m21 + m22 * m22, m11 * m21 + m12 * m22);
    let det = ElementLanes::splat(1.0) / (a * b - c * c);
    Metric { a: b * det, b: a * det, c: -c * det, det }
}

/// Stretches of the sheet at the start from its stress-free state.
#[derive(Clone, Copy)]
struct Natural {
    /// Stretches along the material axes and through the thickness.
    stretch: [f64; 3],
}

impl Natural {
    /// Newton's method for the stretches λ1, λ2 with the true stress σ_i = λ_i² S_i / (λ1 λ2 λ3); in plane strain
    /// (`plane`) λ2 stays 1.
    fn find(sheet: &dyn Sheet, prestress: [f64; 2], plane: bool) -> Result<Self, String> {
        let unknowns = if plane { 1 } else { 2 };
        let residual = |[l1, l2]: [f64; 2]| {
            let state = sheet.total([l1 * l1, l2 * l2, 0.0]);
            let volume = l1 * l2 * state.thickness;
            [l1 * l1 * state.stress[0] / volume - prestress[0], l2 * l2 * state.stress[1] / volume - prestress[1]]
        };
        let tolerance = 1e-12 * prestress[0].abs().max(prestress[1].abs());
        let mut l = [1.0, 1.0];
        for _ in 0..100 {
            let r = residual(l);
            if r[..unknowns].iter().all(|r| r.abs() <= tolerance) {
                let thickness = sheet.total([l[0] * l[0], l[1] * l[1], 0.0]).thickness;
                return Ok(Self { stretch: [l[0], l[1], thickness] });
            }
            let column = |j: usize| {
                let (mut up, mut down) = (l, l);
                (up[j], down[j]) = (l[j] * (1.0 + 1e-6), l[j] * (1.0 - 1e-6));
                let (up, down) = (residual(up), residual(down));
                [(up[0] - down[0]) / (2e-6 * l[j]), (up[1] - down[1]) / (2e-6 * l[j])]
            };
            let [[a11, a21], [a12, a22]] = [column(0), if plane { [0.0, 1.0] } else { column(1) }];
            let det = a11 * a22 - a12 * a21;
            let r1 = if plane { 0.0 } else { r[1] };
            let steps = [(a22 * r[0] - a12 * r1) / det, (a11 * r1 - a21 * r[0]) / det];
            (0..unknowns).for_each(|i| l[i] -= steps[i].clamp(-0.2, 0.2));
        }
        Err(format!("the sheet can't carry a prestress of {prestress:?} Pa"))
    }
}
