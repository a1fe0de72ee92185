//! Elastic solids with supports: deflections and swings by their natural modes.
//!
//! ```text
//! loads and weight less buoyancy   u(t) = Σ_k φ_k (φ_k·f(t))/ω_k², twice that where they come at once; 2 L/π at most
//! drag                             f = ½ρU² |n·e| e, in front and behind: a drag coefficient of two; 2 L/π at most
//! velocity at the start            ± Σ_k φ_k (φ_k·M v)/ω_k
//! swings in a stream               ± a_k φ_k, the end of which moves by the least of the deflection under
//!                                  ½ρU² from one side, of U/ω_k and of L/4
//! ```
//!
//! L is the longest side of the solid. A plate across a stream has a drag coefficient of about two (Hoerner 1965); a
//! cantilever that is bent to a quarter of a circle has moved its end by 2 L/π; flags and beams behind cylinders swing
//! by up to a quarter of their length, no faster than the stream.

use super::{AmbientStream, Placement, SolidSurroundings, largest, longest_side, nodes_of};
use crate::case::InitialStateSpec;
use crate::math::Vector;
use crate::pfem2::solid::setup::Inertia;
use crate::pfem2::solid::structure::Structure;
use crate::pfem2::solid::structure::modes::NaturalMode;
use crate::pfem2::solid::structure::response::{deflection, swing};
use std::f64::consts::{FRAC_2_PI, PI};

/// Parts of a displacement that are looked at.
const PARTS: usize = 16;

/// Times of a run at which loads are taken.
const TIMES: usize = 16;

/// Modes of a solid that a stream may shake.
const SHAKEN: usize = 3;

/// Displacement of the end of a flag in a stream, over its length.
const FLAPPING: f64 = 0.25;

/// The displacement of all nodes, from one multiple of it to another.
struct Deflection<const D: usize> {
    displacement: Vec<Vector<D>>,
    multiples: [f64; 2],
}

/// An elastic solid with supports, among the modes of all solids.
struct SupportedSolid<'a, const D: usize> {
    structure: &'a Structure<D>,
    modes: &'a [NaturalMode<D>],
    own: Vec<&'a NaturalMode<D>>,
    number: usize,
    length: f64,
    /// Length of the run [s].
    span: f64,
}

/// Places that a solid is likely to come to.
pub(super) fn placements<const D: usize, const N: usize>(
    structure: &Structure<D>,
    modes: &[NaturalMode<D>],
    number: usize,
    around: &SolidSurroundings<D, N>,
    stream: Option<&AmbientStream<D>>,
) -> Vec<Placement<D>> {
    let own = modes.iter().filter(|mode| mode.solid == number && mode.period.is_finite()).take(SHAKEN).collect();
    let (length, span) = (longest_side(&structure.setups()[number]), around.file.time.end);
    let solid = SupportedSolid { structure, modes, own, number, length, span };
    let nodes = nodes_of(structure, number);
    let deflections = solid.loaded(around).into_iter().chain(solid.swinging());
    let deflections = deflections.chain(stream.into_iter().flat_map(|stream| solid.in_stream(stream)));
    let parts = deflections.flat_map(|Deflection { displacement, multiples: [from, to] }| {
        let own = displacement[nodes.clone()].to_vec();
        let part = move |k: usize| from + (to - from) * k as f64 / PARTS as f64;
        (0..=PARTS).map(move |k| own.iter().map(|u| *u * part(k)).collect())
    });
    parts.chain(carried(structure, number, around)).collect()
}

impl<const D: usize> SupportedSolid<'_, D> {
    /// Deflections under loads and weight: the largest, and the one that is most opposite to it.
    fn loaded<const N: usize>(&self, around: &SolidSurroundings<D, N>) -> Vec<Deflection<D>> {
        let at = |k: usize| {
            let t = self.span * k as f64 / TIMES as f64;
            let displacement = self.bounded(deflection(self.modes, &self.forces(around, t))?)?;
            let most = if k == 0 { self.overshoot(around) } else { 1.0 };
            Some(Deflection { displacement, multiples: [0.0, most] })
        };
        let all: Vec<Deflection<D>> = (0..=TIMES).filter_map(at).collect();
        let reach = |a: &Deflection<D>| a.multiples[1] * largest(&a.displacement);
        let Some(first) = (0..all.len()).max_by(|&a, &b| reach(&all[a]).total_cmp(&reach(&all[b]))) else {
            return Vec::new();
        };
        let likeness = |a: &Deflection<D>| -> f64 {
            a.displacement.iter().zip(&all[first].displacement).map(|(a, b)| a.dot(*b)).sum()
        };
        let against = (0..all.len()).min_by(|&a, &b| likeness(&all[a]).total_cmp(&likeness(&all[b])));
        let chosen: Vec<usize> = [Some(first), against].into_iter().flatten().collect();
        all.into_iter().enumerate().filter(|(k, _)| chosen.contains(k)).map(|(_, deflection)| deflection).collect()
    }

    /// Forces of loads and of weight less buoyancy [N].
    fn forces<const N: usize>(&self, around: &SolidSurroundings<D, N>, t: f64) -> Vec<Vector<D>> {
        let setups = self.structure.setups();
        self.structure
            .loads(t, |solid, x| around.gravity(x, t) * (1.0 - around.density(x) / setups[solid].law.density()))
    }

    /// Deflection over that at rest where the loads at the start begin to act: that of an oscillator, 1 − cos ω t.
    fn overshoot<const N: usize>(&self, around: &SolidSurroundings<D, N>) -> f64 {
        let at_rest = self.structure.setups()[self.number].inertia == Inertia::QuasiStatic;
        if at_rest || around.file.pfem2.start != InitialStateSpec::Given {
            return 1.0;
        }
        1.0 - self.own.first().map_or(PI, |mode| (mode.frequency() * self.span).min(PI)).cos()
    }

    /// Swing from the velocity at the start.
    fn swinging(&self) -> Option<Deflection<D>> {
        let displacement = self.bounded(swing(self.modes, &self.structure.momenta(), self.span)?)?;
        Some(Deflection { displacement, multiples: [-1.0, 1.0] })
    }

    /// Deflections by which a stream bends the solid, and with which it shakes it.
    fn in_stream(&self, stream: &AmbientStream<D>) -> Vec<Deflection<D>> {
        let bent = |e: &Vector<D>| {
            let drag = |area: Vector<D>| area * stream.pressure();
            let forces: Vec<_> = self.structure.frontal_areas(self.number, *e).into_iter().map(drag).collect();
            let displacement = self.bounded(deflection(self.modes, &forces)?)?;
            Some(Deflection { displacement, multiples: [0.0, 1.0] })
        };
        let shaken = |mode: &&NaturalMode<D>| {
            let (moved, omega) = (largest(&mode.shape[nodes_of(self.structure, self.number)]), mode.frequency());
            let pushed = 0.5 * stream.pressure() * self.structure.swept_area(self.number, &mode.shape) / omega.powi(2);
            let room = (stream.speed / omega).min(stream.speed * self.span).min(FLAPPING * self.length) / moved;
            let amplitude = pushed.min(room);
            Deflection { displacement: mode.shape.iter().map(|u| *u * amplitude).collect(), multiples: [-1.0, 1.0] }
        };
        stream.directions.iter().filter_map(bent).chain(self.own.iter().map(shaken)).collect()
    }

    /// The displacement, made smaller where this solid moves farther than if it were bent to a quarter of a circle;
    /// `None` where it doesn't.
    fn bounded(&self, displacement: Vec<Vector<D>>) -> Option<Vec<Vector<D>>> {
        let most = largest(&displacement[nodes_of(self.structure, self.number)]);
        let factor = (FRAC_2_PI * self.length / most).min(1.0);
        (most > 0.0).then(|| displacement.into_iter().map(|u| u * factor).collect())
    }
}

/// Placements to which supports that move carry a solid: all of it as they move on average.
fn carried<const D: usize, const N: usize>(
    structure: &Structure<D>,
    number: usize,
    around: &SolidSurroundings<D, N>,
) -> Vec<Placement<D>> {
    let setup = &structure.setups()[number];
    let held = || {
        setup.held.iter().flat_map(|held| held.nodes.iter().map(move |&node| (held, setup.mesh.nodes[node as usize])))
    };
    let is_led = |velocity: &Option<crate::math::Signal>| velocity.as_ref().is_some_and(|v| !v.is_zero());
    if !setup.held.iter().any(|held| held.velocity.iter().any(is_led)) {
        return Vec::new();
    }
    let velocity = |t: f64| {
        Vector::<D>::from_fn(|axis| {
            let all = held().filter_map(|(held, x)| Some(held.velocity[axis].as_ref()?.value(x.to3(), t)));
            let (sum, count) = all.fold((0.0, 0.0), |(sum, count), v| (sum + v, count + 1.0));
            if count > 0.0 { sum / count } else { 0.0 }
        })
    };
    super::drifting::followed(around.file.time.end, velocity)
        .into_iter()
        .map(|u| vec![u; setup.mesh.nodes.len()])
        .collect()
}
