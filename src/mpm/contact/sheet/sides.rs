//! Sides of a sheet on which particles are, from step to step (theory D.3).

use crate::simulation::Record;
use bytemuck::{Pod, Zeroable};

/// Sides of the particles of one body with respect to one sheet, by identity, as found in the last step in which each
/// was near.
#[derive(Debug, Default)]
pub struct Labels {
    /// The label of each, and the step that it is of.
    pub kept: Vec<KeptLabel>,
    /// The side of all of them throughout the run, where their region has one.
    pub region_side: Option<f64>,
    /// Normal contact force on each when it was near last [N]; may be shorter than `kept`, missing entries are 0.
    pub force: Vec<f32>,
}

/// The label of a particle in the step in which it was near last.
#[derive(Debug, Clone, Copy, Default, Pod, Zeroable)]
#[repr(C)]
pub struct KeptLabel {
    /// Number of the step, modulo 2³²; 0 of a particle that was never near.
    step: i32,
    /// +1 or −1; 0 beyond an edge.
    side: i32,
    /// 1 if it has crossed the sheet, else 0.
    crossed: i32,
}

impl Record for KeptLabel {
    type Number = i32;
}

/// The side of a particle with respect to a sheet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Label {
    pub side: f64,
    pub crossed: bool,
}

impl Labels {
    /// The label of a particle after `step`: with the side of its region, else as kept then.
    pub fn recall(&self, id: u32, step: u64) -> Option<Label> {
        let kept = self.label_of(id, step);
        let with_side = |side| Label { side, crossed: kept.is_some_and(|label| label.crossed) };
        self.region_side.map(with_side).or(kept)
    }

    fn label_of(&self, id: u32, step: u64) -> Option<Label> {
        let &KeptLabel { step: last, side, crossed } = self.kept.get(id as usize)?;
        (last == step as i32 && last != 0).then_some(Label { side: f64::from(side), crossed: crossed != 0 })
    }

    pub fn keep(&mut self, id: u32, step: u64, label: Label) {
        if self.kept.len() <= id as usize {
            self.kept.resize(id as usize + 1, KeptLabel::default());
        }
        let side = i32::from(label.side > 0.0) - i32::from(label.side < 0.0);
        self.kept[id as usize] = KeptLabel { step: step as i32, side, crossed: label.crossed.into() };
    }

    /// Normal contact force on a particle in `step` [N]; sets it to zero.
    pub fn take_force(&mut self, id: u32, step: u64) -> f64 {
        let near = self.label_of(id, step).is_some();
        let force = self.force.get_mut(id as usize).map_or(0.0, std::mem::take);
        if near && force.is_finite() { f64::from(force).max(0.0) } else { 0.0 }
    }

    /// Keeps the normal contact force on a particle [N].
    pub fn put_force(&mut self, id: u32, force: f64) {
        if self.force.len() <= id as usize {
            self.force.resize(id as usize + 1, 0.0);
        }
        self.force[id as usize] = force as f32;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A label is kept from one step to the next, and dropped after a step away.
    #[test]
    fn labels_last_while_the_particle_stays() {
        let mut labels = Labels::default();
        assert_eq!(labels.recall(3, 0), None);
        labels.keep(3, 7, Label { side: -1.0, crossed: true });
        assert_eq!(labels.recall(3, 7), Some(Label { side: -1.0, crossed: true }));
        assert_eq!(labels.recall(3, 8), None);
    }

    /// Particles that were never near have the side of their region; that one has crossed is dropped after a step away.
    #[test]
    fn the_side_of_a_region_holds_throughout_the_run() {
        let mut labels = Labels { region_side: Some(-1.0), ..Labels::default() };
        assert_eq!(labels.recall(3, 0), Some(Label { side: -1.0, crossed: false }));
        labels.keep(3, 7, Label { side: -1.0, crossed: true });
        assert_eq!(labels.recall(3, 7), Some(Label { side: -1.0, crossed: true }));
        assert_eq!(labels.recall(3, 8), Some(Label { side: -1.0, crossed: false }));
    }
}
