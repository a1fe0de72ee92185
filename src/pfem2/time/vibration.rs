//! The vibration that the changes of the velocity of solids show, and by how much it shortens steps (theory H.5).
//!
//! ```text
//! d of a vibration with ω:   |dⁿ⁺¹| = x² |vⁿ|,   |dⁿ⁺¹ − dⁿ| = x |dⁿ⁺¹|,   x = 2 sin(½ωΔt), in the mean over its phases
//! x² = ⟨|dⁿ⁺¹ − dⁿ|²⟩/⟨|dⁿ⁺¹|²⟩,   |v| = ⟨|dⁿ⁺¹|²⟩^½/x²                                              theory (H.7c)
//! ```
//!
//! Products are by mass. Means forget a fifth with each step.

use bytemuck::{Pod, Zeroable};

/// Part of the means that a step replaces.
const FORGOTTEN: f64 = 0.2;

/// Vibrations of less than this part of the largest speed of solids shorten no step, those of twice as much as errors
/// say: their energy is 1/1600 and 1/400 of the largest.
const UNFELT: f64 = 0.025;

/// Means of a vibration over the last steps.
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Vibration {
    /// ⟨|dⁿ⁺¹|²⟩ [kg m²/s²]; 0 before the first step.
    change: f64,
    /// ⟨|dⁿ⁺¹ − dⁿ|²⟩ [kg m²/s²].
    difference: f64,
}

impl Vibration {
    /// The means with those of one more step, |dⁿ⁺¹|² and |dⁿ⁺¹ − dⁿ|² [kg m²/s²].
    pub fn after(self, change: f64, difference: f64) -> Self {
        let part = if self.change > 0.0 { FORGOTTEN } else { 1.0 };
        let mean = |old: f64, new: f64| old + (new - old) * part;
        Self { change: mean(self.change, change), difference: mean(self.difference, difference) }
    }

    /// The speed of the vibration, √(mass) |v| [√kg m/s].
    fn speed(&self) -> f64 {
        if self.difference > 0.0 { self.change.powf(1.5) / self.difference } else { f64::INFINITY }
    }

    /// Part of the error of solids that counts, beside the largest speed of solids so far [√kg m/s].
    pub fn counts(&self, largest: f64) -> f64 {
        (self.speed() / (UNFELT * largest) - 1.0).clamp(0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The means in the steps of a vibration of the speed 0.3 with so many steps per period.
    fn vibrating(steps: f64) -> Vec<Vibration> {
        let v = |k: i32| 0.3 * (std::f64::consts::TAU * f64::from(k) / steps + 0.4).cos();
        let d = |k: i32| v(k) - 2.0 * v(k - 1) + v(k - 2);
        let after = |means: &mut Vibration, k: i32| {
            *means = means.after(d(k).powi(2), (d(k) - d(k - 1)).powi(2));
            Some(*means)
        };
        (0..500).scan(Vibration::default(), after).skip(100).collect()
    }

    /// A vibration has its speed, 0.3/√2, in the mean over its phases, however finely steps resolve it.
    #[test]
    fn a_vibration_has_the_speed_that_its_changes_show() {
        for steps in [2.3, 3.1, 5.3, 9.7] {
            let means = vibrating(steps);
            let mean = means.iter().map(|means| means.speed().ln()).sum::<f64>() / means.len() as f64;
            let speed = mean.exp() / (0.3 * 0.5_f64.sqrt());
            assert!((speed - 1.0).abs() < 0.1, "{steps}: {speed}");
        }
    }

    #[test]
    fn weak_vibrations_do_not_count_and_strong_ones_do() {
        let vibration = vibrating(7.3)[0];
        let largest = vibration.speed();
        assert_eq!(vibration.counts(largest / 0.024), 0.0);
        assert!((vibration.counts(largest / 0.0375) - 0.5).abs() < 1e-12);
        assert_eq!(vibration.counts(largest / 0.06), 1.0);
        // A motion that keeps its rate of change has none.
        assert_eq!(Vibration::default().after(1.0, 0.0).counts(1e9), 1.0);
    }
}
