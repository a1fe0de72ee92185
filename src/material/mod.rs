//! Laws of materials (theory B.1). One law, one file; its name in one list of the registry below.
//!
//! Laws are always three-dimensional: a two-dimensional solver embeds (plane strain) and reads back.
//! A boxed law is called once per *batch* of particles, so that dynamic dispatch costs nothing.

mod bulk_viscosity;
mod drucker_prager;
mod elastic;
pub mod eos;
mod fluid;
mod hyperelastic;
mod hypoelastic;
mod increment;
mod j2;
mod johnson_cook;
mod kinematics;
mod linearised;
mod mooney_rivlin;
mod neo_hookean;
mod prestressed;
mod rigid;
pub mod sheet;
mod solid;
mod st_venant_kirchhoff;
mod stiffness;
#[cfg(test)]
mod testing;
pub mod viscous;
mod yield_curve;

pub use bulk_viscosity::BulkViscosity;
pub use drucker_prager::DruckerPrager;
pub use elastic::{Elastic, INCOMPRESSIBLE, Moduli};
pub use eos::EquationsOfState;
pub use eos::FlowProperties;
pub use fluid::Fluid;
pub use hyperelastic::Hyperelastic;
pub use hypoelastic::Hypoelastic;
pub use increment::{Increment, Point, Response};
pub use j2::J2;
pub use johnson_cook::JohnsonCook;
pub use kinematics::rotation;
pub use linearised::{ElasticLaw, ElasticState, Linearised, Mixed};
pub use mooney_rivlin::MooneyRivlin;
pub use neo_hookean::NeoHookean;
pub use prestressed::Prestressed;
pub use rigid::Rigid;
pub use sheet::{LANES, Sheet, SheetKind, SheetLanes, SheetState};
pub use solid::Solid;
pub use st_venant_kirchhoff::StVenantKirchhoff;
pub use stiffness::Stiffness;
pub use viscous::*;
pub use yield_curve::YieldCurve;

use crate::math::{SymTensor, Tensor};
use crate::registry;

registry! {
    /// The laws of material points, by the name that a case gives as `law`.
    pub enum PointLaws: PointLaw, tag = "law" {
        "fluid" => Fluid,
        "hypoelastic" => Hypoelastic,
        "neo-hookean" => NeoHookean,
        "st-venant-kirchhoff" => StVenantKirchhoff,
        "mooney-rivlin" => MooneyRivlin,
        "j2" => J2,
        "johnson-cook" => JohnsonCook,
        "drucker-prager" => DruckerPrager,
        "rigid" => Rigid,
    }
}

/// A law of material points (solids, liquids, gases) as the material point method calls it.
///
/// One call updates a batch: all slices have one entry per particle.
pub trait PointLaw: std::fmt::Debug + Send + Sync {
    /// Density in the reference state [kg/m³].
    fn density(&self) -> f64;

    /// Optional columns that the law needs.
    fn storage(&self) -> Storage;

    /// The initial state of one particle, from the values that the case prescribes.
    ///
    /// # Errors
    /// A sentence that says why the law can't start from this state.
    fn initial(&self, start: &StartState) -> Result<PointState, String>;

    /// False if the law takes all it needs from `batch.volume_ratio`; `batch.gradient` is then empty.
    fn needs_gradient(&self) -> bool {
        true
    }

    /// Advances the batch by `batch.dt` under the velocity gradients `batch.gradient`.
    fn update(&self, batch: &mut PointBatch<'_>);

    /// Speed of sound in the reference state [m/s], for estimates; 0 for a gas, whose speed depends on the
    /// state at the start ([`PointState::sound_speed`]).
    fn reference_sound_speed(&self) -> f64;

    /// Phase of the material, by which presets of a case choose.
    fn phase(&self) -> MaterialKind;

    /// The law as an elastic one, with the tangents that an implicit system in velocity and pressure needs
    /// (theory B.13).
    ///
    /// # Errors
    /// A sentence that says why it has none: fluids, and solids that yield.
    fn elastic_law(&self) -> Result<&dyn ElasticLaw, String> {
        Err(linearised::no_tangent(self.phase()))
    }

    /// True for a solid that has no strain.
    fn is_rigid(&self) -> bool {
        false
    }

    /// True if neighbours stay neighbours, so that particles at the surface stay there.
    fn keeps_shape(&self) -> bool {
        matches!(self.phase(), MaterialKind::Plastic | MaterialKind::Elastic)
    }

    /// True if the pressure depends on the internal energy, so that heat acts.
    fn is_thermal(&self) -> bool {
        false
    }

    /// True if p V = (γ − 1) e: the pressure of a given energy doesn't depend on how volume is shared between
    /// particles.
    fn is_ideal_gas(&self) -> bool {
        false
    }

    /// Largest kinematic viscosity-like diffusivity, 4/3 μ/ρ [m²/s], for the explicit viscous limit; 0 if none.
    fn diffusivity(&self) -> f64 {
        0.0
    }
}

/// Phase of a material, by which the presets of a case choose defaults (`case/preset.rs`).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MaterialKind {
    /// A fluid whose pressure is that of its energy: it fills its room.
    Gas,
    /// A fluid that resists compression and rests at its density.
    Liquid,
    /// A solid that yields.
    Plastic,
    /// A solid that gives back all work.
    Elastic,
}

/// Optional columns that a law needs.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Storage {
    /// The full Cauchy stress per particle; without it only the pressure is stored.
    pub stress: bool,
    /// The deformation gradient per particle.
    pub deformation: bool,
    /// Names of history variables per particle (e.g. `plastic strain`); their number is the stride.
    pub history: &'static [&'static str],
}

/// The initial state of a region as a case prescribes it. At most one of the three is given.
#[derive(Debug, Clone, Copy, Default)]
pub struct StartState {
    /// Pressure [Pa].
    pub pressure: Option<f64>,
    /// Internal energy per unit *reference* volume [J/m³].
    pub energy: Option<f64>,
    /// Cauchy stress [Pa].
    pub stress: Option<SymTensor>,
}

/// The first state of a particle.
#[derive(Debug, Clone, Copy)]
pub struct PointState {
    /// Current density [kg/m³].
    pub density: f64,
    /// Internal energy per unit reference volume [J/m³].
    pub energy: f64,
    /// Pressure [Pa], −⅓ tr σ.
    pub pressure: f64,
    /// Cauchy stress [Pa].
    pub stress: SymTensor,
    /// Deformation gradient.
    pub deformation: Tensor<3>,
    /// Speed of sound in this state [m/s], for the first step.
    pub sound_speed: f64,
}

/// A batch of particles of one body during one step.
pub struct PointBatch<'a> {
    /// Time increment [s].
    pub dt: f64,
    /// Characteristic length for the artificial bulk viscosity, the cell size [m].
    pub length: f64,
    /// Volume of a cell [m³], the most that a particle's liquid and the void that opens in it take up.
    pub room: f64,
    /// Velocity gradient L = ∂v/∂x [1/s] over the positions x at the start of the increment: the motion of
    /// the increment is 1 + dt L. A gradient over the positions at its end is L (1 − dt L)⁻¹ here.
    /// Empty for laws that don't need it.
    pub gradient: &'a [Tensor<3>],
    /// Volume ratio V^{n+1}/V^n of this increment. The solver computes it (1 + dt tr L, or its
    /// locking-free average), so that all laws share one cure of volumetric locking.
    pub volume_ratio: &'a [f64],
    /// Mass [kg].
    pub mass: &'a [f64],
    /// Current volume [m³]; the law multiplies it by `volume_ratio`.
    pub volume: &'a mut [f64],
    /// Internal energy per particle [J].
    pub energy: &'a mut [f64],
    /// Mean compressive stress −⅓ tr σ [Pa], artificial viscosity included.
    pub pressure: &'a mut [f64],
    /// Cauchy stress [Pa], artificial viscosity included; empty unless `storage().stress`.
    pub stress: &'a mut [SymTensor],
    /// Deformation gradient F; empty unless `storage().deformation`. The law updates it.
    pub deformation: &'a mut [Tensor<3>],
    /// History variables, `storage().history.len()` per particle.
    pub history: &'a mut [f64],
    /// Out: speed that bounds the step, dt ≤ h / (wave_speed + |v|) [m/s] (sound speed corrected for
    /// the artificial viscosity; theory B.6).
    pub wave_speed: &'a mut [f64],
}

impl PointBatch<'_> {
    /// Number of particles in the batch.
    #[allow(clippy::len_without_is_empty)]
    pub fn len(&self) -> usize {
        self.mass.len()
    }
}
