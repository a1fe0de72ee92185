//! An elastic law in a body that is under stress as it is given (theory J.17).
//!
//! ```text
//! σ(F) = σ_law(F F₀),      W(F) = W_law(F F₀)/det F₀,      σ_law(F₀) = σ₀
//! ```
//!
//! F is counted from the body as it is given, F₀ leads there from a state without stress. The stored energy is
//! a function of F, so that stress and tangent follow from it as those of the law do.

use super::{
    ElasticLaw, ElasticState, Linearised, MaterialKind, Moduli, PointBatch, PointLaw, PointState, StartState, Storage,
};
use crate::math::{SymTensor, Tensor};

/// A law with the deformation that carries the stress at F = 1.
///
/// ```
/// use lateen::material::{Elastic, ElasticState, NeoHookean, PointLaw, Prestressed};
/// use lateen::math::{SymTensor, Tensor};
///
/// let rubber = NeoHookean { elastic: Elastic::new(1100.0, 1e6, 0.4) };
/// let stress = SymTensor([2e5, 0.0, 0.0, 0.0, 0.0, 0.0]);
/// let law = Prestressed::new(Box::new(rubber), stress).unwrap();
/// let rest = ElasticState { deformation: Tensor::identity(), stress: SymTensor::ZERO };
/// let found = law.elastic_law().unwrap().linearised(&rest).stress();
/// assert!((found.0[0] - 2e5).abs() < 1e-6 && found.0[1].abs() < 1e-6);
/// ```
#[derive(Debug)]
pub struct Prestressed {
    law: Box<dyn PointLaw>,
    /// F₀, symmetric.
    prestretch: Tensor<3>,
}

impl Prestressed {
    /// A law whose Cauchy stress is `stress` [Pa] at F = 1.
    ///
    /// # Errors
    /// A sentence: a law without an elastic tangent, a stress that no deformation carries, or one under which the law
    /// is unstable.
    pub fn new(law: Box<dyn PointLaw>, stress: SymTensor) -> Result<Self, String> {
        law.elastic_law()?;
        let start = StartState { stress: Some(stress), ..StartState::default() };
        let prestretch = law.initial(&start)?.deformation;
        Ok(Self { law, prestretch })
    }

    /// The law with its tangent.
    fn own(&self) -> &dyn ElasticLaw {
        self.law.elastic_law().expect("`Prestressed::new` takes laws with an elastic tangent alone")
    }

    /// F F₀.
    fn state(&self, state: &ElasticState) -> ElasticState {
        ElasticState { deformation: state.deformation.dot(&self.prestretch), stress: state.stress }
    }
}

impl ElasticLaw for Prestressed {
    fn reference_density(&self) -> f64 {
        self.own().reference_density()
    }

    fn moduli(&self) -> Moduli {
        self.own().moduli()
    }

    fn linearised(&self, state: &ElasticState) -> Linearised<6> {
        self.own().linearised(&self.state(state))
    }

    /// Thickness from that at F = 1, for prestresses in the plane: F₀ then has no shear across it.
    fn thickness_stretch(&self, in_plane: &Tensor<2>) -> Result<f64, String> {
        let own = Tensor::<2>::from_fn(|i, j| self.prestretch[i][j]);
        Ok(self.own().thickness_stretch(&in_plane.dot(&own))? / self.prestretch[2][2])
    }

    fn strain_energy(&self, state: &ElasticState) -> Option<f64> {
        Some(self.own().strain_energy(&self.state(state))? / self.prestretch.determinant())
    }
}

impl PointLaw for Prestressed {
    /// Density of the body at F = 1 [kg/m³]: the law counts from there, not from the state without stress.
    fn density(&self) -> f64 {
        self.law.density()
    }

    fn storage(&self) -> Storage {
        self.law.storage()
    }

    fn initial(&self, start: &StartState) -> Result<PointState, String> {
        self.law.initial(start)
    }

    fn update(&self, batch: &mut PointBatch<'_>) {
        self.law.update(batch);
    }

    fn reference_sound_speed(&self) -> f64 {
        self.law.reference_sound_speed()
    }

    fn phase(&self) -> MaterialKind {
        self.law.phase()
    }

    fn elastic_law(&self) -> Result<&dyn ElasticLaw, String> {
        Ok(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::{Elastic, NeoHookean, Rigid, StVenantKirchhoff};

    const STRESS: SymTensor = SymTensor([2e5, -1e5, 5e4, 3e4, -2e4, 8e4]);

    fn laws() -> [Box<dyn PointLaw>; 2] {
        let elastic = Elastic::new(1100.0, 1e6, 0.4);
        [Box::new(StVenantKirchhoff { elastic }), Box::new(NeoHookean { elastic })]
    }

    fn at(deformation: Tensor<3>) -> ElasticState {
        ElasticState { deformation, stress: SymTensor::ZERO }
    }

    /// The stress is that which was asked for, and it is the slope of the energy: J σ = ∂W/∂F Fᵀ, by differences.
    #[test]
    fn the_stress_is_given_and_is_the_slope_of_the_energy() {
        let (step, f) = (1e-5, Tensor([[1.1, 0.2, 0.0], [-0.1, 0.9, 0.15], [0.05, 0.0, 1.05]]));
        for law in laws() {
            let law = Prestressed::new(law, STRESS).unwrap();
            let rest = law.linearised(&at(Tensor::identity())).stress();
            assert!((0..6).all(|k| (rest.0[k] - STRESS.0[k]).abs() < 1e-5), "{rest:?}");
            let slope = Tensor::<3>::from_fn(|i, j| {
                let [more, less] = [step, -step].map(|step| {
                    let mut f = f;
                    f[i][j] += step;
                    law.strain_energy(&at(f)).unwrap()
                });
                (more - less) / (2.0 * step)
            });
            let expected = slope.dot(&f.transpose()) * (1.0 / f.determinant());
            let stress = law.linearised(&at(f)).stress().full();
            let error = (0..9).map(|k| (stress[k / 3][k % 3] - expected[k / 3][k % 3]).abs()).fold(0.0, f64::max);
            assert!(error < 1e-6 * 1e6, "{error}");
        }
    }

    /// A bar under tension in its axis is as thick as it is given where nothing pulls at it further.
    #[test]
    fn plane_stress_leaves_the_given_thickness() {
        for law in laws() {
            let law = Prestressed::new(law, SymTensor([3e5, 1e5, 0.0, 5e4, 0.0, 0.0])).unwrap();
            let stretch = law.thickness_stretch(&Tensor::identity()).unwrap();
            assert!((stretch - 1.0).abs() < 1e-8, "{stretch}");
            let pulled = Tensor::<2>([[1.2, 0.1], [0.0, 0.95]]);
            let stretch = law.thickness_stretch(&pulled).unwrap();
            let across = law.linearised(&at(pulled.embed(stretch))).stress().0[2];
            assert!(across.abs() < 1e-3, "{across}");
        }
    }

    #[test]
    fn a_stress_without_a_deformation_is_refused() {
        let torn = SymTensor::isotropic(1e9);
        let rubber = NeoHookean { elastic: Elastic::new(1100.0, 1e6, 0.4) };
        assert!(Prestressed::new(Box::new(rubber), torn).unwrap_err().contains("no deformation"));
        let pressed = SymTensor::isotropic(-1e8);
        let hooke = StVenantKirchhoff { elastic: Elastic::new(1100.0, 1e6, 0.4) };
        assert!(Prestressed::new(Box::new(hooke), pressed).is_err());
        assert!(Prestressed::new(Box::new(Rigid { density: 1.0 }), STRESS).is_err());
    }
}
