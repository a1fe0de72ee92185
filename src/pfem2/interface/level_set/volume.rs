//! The volume where a nodal level set is negative, and the shift that gives it a wanted value (theory (G.7)).

use crate::parallel;
use crate::pfem2::phases::FluidRegion;

/// Volume of the fluids where φ is negative [m³]; area [m²] in 2D.
pub fn negative_volume<const D: usize, const N: usize>(region: &FluidRegion<D, N>, level: &[f64]) -> f64 {
    let elements = region.mesh.elements();
    let own = |e: usize| elements[e].map(|node| level[node as usize]);
    parallel::sum(elements.len(), |e| region.negative_volume(e, &own(e)))
}

/// Shifts φ so that it is negative in `volume` [m³], to the last digits; returns the shift δ [m].
///
/// The volume falls monotonically with δ, so that bisection between ±`reach` [m] finds it. If that is not enough to
/// reach the volume, the shift that comes nearest is taken. Where only one sign is left there is nothing to shift.
pub fn shift_to_volume<const D: usize, const N: usize>(
    region: &FluidRegion<D, N>,
    level: &mut [f64],
    volume: f64,
    reach: f64,
) -> f64 {
    const BISECTIONS: usize = 60;
    let (fixed, band) = divide(region, level, reach);
    let excess = |shift: f64| {
        let own = |i: usize| region.mesh.elements()[band[i] as usize].map(|node| level[node as usize] + shift);
        let inside = |i: usize| region.negative_volume(band[i] as usize, &own(i));
        fixed + parallel::sum(band.len(), inside) - volume
    };
    let all = region.total();
    let exact = 8.0 * f64::EPSILON * all;
    let mut found = excess(0.0);
    if found + volume <= exact || found + volume >= all - exact {
        return 0.0;
    }
    let (mut low, mut high) = (-reach, reach);
    let mut shift = 0.0;
    let mut secant = None::<(f64, f64)>;
    for _ in 0..BISECTIONS {
        if found.abs() <= exact || high - low <= f64::EPSILON * reach {
            break;
        }
        if found > 0.0 {
            low = shift
        } else {
            high = shift
        }
        let guess = secant.map_or(f64::NAN, |(s, f)| shift - found * (shift - s) / (found - f));
        secant = Some((shift, found));
        shift = if guess > low && guess < high { guess } else { 0.5 * (low + high) };
        found = excess(shift);
    }
    level.iter_mut().for_each(|phi| *phi += shift);
    shift
}

/// The negative volume of the elements that no shift up to `reach` cuts, and the other elements.
fn divide<const D: usize, const N: usize>(region: &FluidRegion<D, N>, level: &[f64], reach: f64) -> (f64, Vec<u32>) {
    let mut band = Vec::new();
    let mut fixed = 0.0;
    for (e, nodes) in region.mesh.elements().iter().enumerate() {
        let own = nodes.map(|node| level[node as usize]);
        if own.iter().all(|&phi| phi < -reach) {
            fixed += region.volume(e);
        } else if !own.iter().all(|&phi| phi > reach) {
            band.push(e as u32);
        }
    }
    (fixed, band)
}
