//! A solid on particles as a run starts with it.

use crate::material::Moduli;
use crate::math::Signal;
use crate::pfem2::solid::setup::Plane;

/// A solid on particles, made by the case layer.
#[derive(Debug, Clone)]
pub struct ParticleSolidSetup<const D: usize> {
    /// Name.
    pub name: String,
    /// Law of the solid.
    pub law: RateLaw,
    /// Nodes of the mesh with a prescribed velocity.
    pub held: Vec<HeldMeshNodes<D>>,
}

/// Nodes of the mesh whose velocity a support prescribes along some axes.
#[derive(Debug, Clone)]
pub struct HeldMeshNodes<const D: usize> {
    /// The nodes.
    pub nodes: Vec<u32>,
    /// Velocity along each axis [m/s]; `None`: free.
    pub velocity: [Option<Signal>; D],
}

/// A hypoelastic law, split in deviator and pressure: σ'^∇ = 2μ d', ṗ = −κ tr d (theory (K.1)).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RateLaw {
    /// Density ρ [kg/m³].
    pub density: f64,
    /// Shear modulus μ [Pa].
    pub shear: f64,
    /// κ = λ + ⅔ μ [Pa]; in plane stress λ* + ⅔ μ.
    pub bulk: f64,
    /// The third direction, in two dimensions.
    pub plane: Plane,
}

impl RateLaw {
    /// A solid of `density` [kg/m³] with these moduli.
    ///
    /// In plane stress λ* = 2λμ/(λ + 2μ) takes the place of λ: σ' − p 1 in the plane is then its stress, and p no
    /// longer the mean pressure (theory K.1).
    pub fn new(density: f64, Moduli { bulk, shear }: Moduli, plane: Plane) -> Self {
        // κ of Becker (14).
        let lame = bulk - 2.0 / 3.0 * shear;
        let bulk = match plane {
            Plane::Strain => bulk,
            Plane::Stress => 2.0 * lame * shear / (lame + 2.0 * shear) + 2.0 / 3.0 * shear,
        };
        Self { density, shear, bulk, plane }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::Elastic;

    /// A strip under uniaxial tension ε in its plane: the stress is E/(1 − ν²) times the strain where the other side is
    /// held, and the ratio of the two stresses is ν.
    #[test]
    fn plane_stress_has_the_stiffness_of_a_thin_plate() {
        let (young, nu) = (3e6, 0.3);
        let law = RateLaw::new(1000.0, Elastic::new(1000.0, young, nu).moduli(), Plane::Stress);
        let stress = |own: f64| 2.0 * law.shear * (own - 1.0 / 3.0) + law.bulk;
        assert!((stress(1.0) / (young / (1.0 - nu * nu)) - 1.0).abs() < 1e-14);
        assert!((stress(0.0) / stress(1.0) - nu).abs() < 1e-14);
        let strain = RateLaw::new(1000.0, Elastic::new(1000.0, young, nu).moduli(), Plane::Strain);
        assert!((strain.bulk / (young / (3.0 * (1.0 - 2.0 * nu))) - 1.0).abs() < 1e-14);
    }
}
