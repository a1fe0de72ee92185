//! Fluid that sticks to solids or glides along them, where the case doesn't say.
//!
//! A surface that swings with ω slows fluid down in the layer δ = √(2 ν/ω) (Stokes 1851), one of the length L a stream
//! of the speed U in δ = 2 √(ν L/U), to 63 % at its end (Blasius 1908). Elements wider than half of these don't hold
//! them: a whole element of fluid would stick to the solid (theory (J.6a)). A solid that nothing holds, or a rigid one,
//! slows down 1.27 √(ν t) in the time t at most, as a plate that is set in motion (Stokes 1851), to 63 %, too.
//!
//! Which layer it is doesn't matter where a stream passes all of a solid: it comes off behind it where fluid sticks, and
//! nowhere where it glides.

use super::path::{SolidSurroundings, driven_stream, longest_side, speed_of_inlets};
use crate::case::resolution::size_of;
use crate::case::{InitialStateSpec, SurfaceSpec};
use crate::math::Vector;
use crate::mesh::{Locator, Mesh};
use crate::pfem2::fluid::FluidSetup;
use crate::pfem2::solid::setup::{Inertia, SolidSetup, SurfaceCondition};
use crate::pfem2::solid::structure::Structure;
use crate::pfem2::solid::structure::modes::NaturalMode;
use std::f64::consts::{PI, TAU};

/// Part of the layer that an element may fill for the fluid to stick.
const PART: f64 = 0.5;

/// Unless the case sets the condition: lets fluids glide along solids beside which elements are wider than half the
/// layer that the solid slows down, and says so of each of them ([`FlowScales::layer`]).
///
/// Along a rigid solid they do so between two fluids alone, where the pressure moves it, and where none comes in: a
/// wedge that meets water has a force 11 % too large with noise of 12 % where the water sticks to it (2 and 2.5 % where
/// it glides), and a cylinder in a stream has a tenth of its drag where the flow doesn't come off. Along an elastic one
/// they don't in a stream that passes all of it within the run: a soft ring in a stream bends wrongly, and swings as it
/// doesn't on finer elements. Says so where fluid sticks to a solid beside elements that don't hold the layer.
///
/// Solids without a known period stay as they are, quasi-static ones and those whose modes weren't found; and so do all
/// where a run begins in equilibrium, which isn't found where fluids glide.
pub(super) fn choose<const D: usize, const N: usize>(
    structure: &mut Structure<D>,
    modes: &[NaturalMode<D>],
    around: &SolidSurroundings<D, N>,
) -> Vec<String> {
    let SolidSurroundings { file, mesh, locator, fluids, .. } = around;
    let open: Vec<usize> =
        (0..).zip(file.solids()).filter(|&(_, body)| file.body[body].surface.is_none()).map(|(s, _)| s).collect();
    let (Some(heaviest), InitialStateSpec::Given) =
        (fluids.iter().max_by(|a, b| a.density.total_cmp(&b.density)), file.pfem2.start)
    else {
        return Vec::new();
    };
    let (speed, stream) = (speed_of_inlets(around), driven_stream(around));
    let flow = FlowScales { heaviest, speed, stream, end: file.time.end };
    let mut notes = Vec::new();
    for solid in open {
        let setup = &structure.setups()[solid];
        let own: Vec<f64> = modes.iter().filter(|mode| mode.solid == solid).map(|mode| mode.period).collect();
        let layer = flow.layer(setup, &own);
        let (Some(layer), Some(element)) = (layer, element_size(setup, mesh, locator)) else { continue };
        if element <= PART * layer {
            continue;
        }
        let (fluid, name) = (&heaviest.name, &setup.name);
        if let Some(why) = flow.reason_to_stick(setup, fluids.len()) {
            notes.push(format!(
                "{fluid} sticks to `{name}`, {why}: elements of {element:.1e} m don't hold the layer of {layer:.1e} m that it \
                 slows down; `surface = \"slip\"` has it glide"
            ));
            continue;
        }
        notes.push(format!(
            "{fluid} glides along `{name}`: elements of {element:.1e} m don't hold the layer of {layer:.1e} m that it slows down; \
             `surface = \"no-slip\"` has the fluid stick"
        ));
        structure.set_surface(solid, SurfaceCondition::from(SurfaceSpec::Slip));
    }
    notes
}

/// Scales of the flow around solids, from which the thickness of the layers along them follows.
struct FlowScales<'a> {
    /// The heaviest fluid.
    heaviest: &'a FluidSetup,
    /// Largest speed of inlets [m/s].
    speed: f64,
    /// Speed of the stream that boundaries, pressures or the start drive [m/s].
    stream: f64,
    /// End of the run [s].
    end: f64,
}

impl FlowScales<'_> {
    /// Why fluid sticks to a solid whose layer elements don't hold, in a case with so many fluids; `None` where it glides.
    fn reason_to_stick<const D: usize>(&self, setup: &SolidSetup<D>, fluids: usize) -> Option<&'static str> {
        match setup.law.is_rigid() {
            true if fluids < 2 => Some("which is rigid, in one fluid"),
            true if self.speed > 0.0 => Some("which is rigid, in a stream"),
            false if self.stream * self.end > longest_side(setup) => Some("which a stream passes"),
            _ => None,
        }
    }

    /// The layer that a solid slows down [m]: as it swings in the longest of the periods of its modes, in the stream
    /// from inlets, and, if it is rigid or has a mode without stiffness, in the whole run. `None` of a solid without a
    /// known period.
    fn layer<const D: usize>(&self, setup: &SolidSetup<D>, periods: &[f64]) -> Option<f64> {
        let stream = layer_of_stream(self.heaviest, setup, self.speed);
        let in_the_run = layer_of_run(self.heaviest, self.end);
        if setup.law.is_rigid() {
            return Some(stream.max(in_the_run));
        }
        let longest = periods.iter().copied().find(|period| period.is_finite());
        let period = longest.filter(|_| setup.inertia == Inertia::Dynamic)?;
        let swings = layer_of_swings(self.heaviest, period).max(stream);
        Some(if periods.iter().any(|period| period.is_infinite()) { swings.max(in_the_run) } else { swings })
    }
}

/// Layer that a surface slows down as it swings [m]; of a fluid whose viscosity depends on the shear rate that at ω.
fn layer_of_swings(fluid: &FluidSetup, period: f64) -> f64 {
    (fluid.law.viscosity(TAU / period) / fluid.density * period / PI).sqrt()
}

/// Layer that a solid slows down in a time, once set in motion [m]; of a fluid whose viscosity depends on the shear rate
/// that at 1/t.
fn layer_of_run(fluid: &FluidSetup, time: f64) -> f64 {
    1.27 * (fluid.law.viscosity(1.0 / time) / fluid.density * time).sqrt()
}

/// Layer that a solid slows down in a stream of a speed [m/s] along its longest side [m]; zero without a stream.
fn layer_of_stream<const D: usize>(fluid: &FluidSetup, setup: &SolidSetup<D>, speed: f64) -> f64 {
    if speed == 0.0 {
        return 0.0;
    }
    let length = longest_side(setup);
    2.0 * (fluid.law.viscosity(speed / length) / fluid.density * length / speed).sqrt()
}

/// Mean size of the elements of the fluid's mesh at the nodes of a surface [m]; `None` outside of the mesh.
fn element_size<const D: usize, const N: usize>(
    setup: &SolidSetup<D>,
    mesh: &Mesh<D, N>,
    locator: &Locator<D>,
) -> Option<f64> {
    let nodes = setup.mesh.facets.iter().flat_map(|facet| facet.nodes.iter().copied());
    let place = |node: u32| -> Vector<D> { setup.mesh.nodes[node as usize] };
    let sizes = nodes.filter_map(|node| Some(size_of(mesh, locator.search(mesh, place(node))?.element()?)));
    let (sum, count) = sizes.fold((0.0, 0.0), |(sum, count), size| (sum + size, count + 1.0));
    (count > 0.0).then(|| sum / count)
}
