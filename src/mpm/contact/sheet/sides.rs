//! Sides of a sheet on which particles are, from step to step.

/// What the particles of one body remember of one sheet, by identity: the step in which each was near, and
/// its side.
#[derive(Debug, Default)]
pub struct Labels {
    /// Step · 8 + (1: +, 2: −, 0: beyond an edge) + (4: counted as crossed).
    pub stamps: Vec<u32>,
    /// The side of all of them for good, as their region has it.
    pub known: Option<f64>,
    /// How hard each was pressed against the sheet when it was near last [N]; fewer where the others weren't.
    pub force: Vec<f32>,
}

/// A particle's memory of a sheet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Label {
    pub side: f64,
    pub crossed: bool,
}

impl Labels {
    /// What is known of a particle after `step`: its side from its region, else what was kept then.
    pub fn recall(&self, id: u32, step: u64) -> Option<Label> {
        let kept = self.kept(id, step);
        let known = |side| Label { side, crossed: kept.is_some_and(|label| label.crossed) };
        self.known.map(known).or(kept)
    }

    fn kept(&self, id: u32, step: u64) -> Option<Label> {
        let stamp = *self.stamps.get(id as usize)?;
        let side = [0.0, 1.0, -1.0, 0.0][(stamp & 3) as usize];
        (stamp >> 3 == Self::clock(step) && stamp != 0).then_some(Label { side, crossed: stamp & 4 != 0 })
    }

    pub fn keep(&mut self, id: u32, step: u64, label: Label) {
        if self.stamps.len() <= id as usize {
            self.stamps.resize(id as usize + 1, 0);
        }
        let side = if label.side > 0.0 { 1 } else { u32::from(label.side < 0.0) * 2 };
        self.stamps[id as usize] = Self::clock(step) << 3 | u32::from(label.crossed) << 2 | side;
    }

    /// How hard a particle was pressed in `step` [N], which is then forgotten.
    pub fn take_force(&mut self, id: u32, step: u64) -> f64 {
        let near = self.kept(id, step).is_some();
        let force = self.force.get_mut(id as usize).map_or(0.0, std::mem::take);
        if near && force.is_finite() { f64::from(force).max(0.0) } else { 0.0 }
    }

    /// Remembers how hard a particle was pressed [N].
    pub fn put_force(&mut self, id: u32, force: f64) {
        if self.force.len() <= id as usize {
            self.force.resize(id as usize + 1, 0.0);
        }
        self.force[id as usize] = force as f32;
    }

    fn clock(step: u64) -> u32 {
        (step & 0x1fff_ffff) as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A label is remembered from one step to the next, and forgotten after a step away.
    #[test]
    fn labels_last_while_the_particle_stays() {
        let mut labels = Labels::default();
        assert_eq!(labels.recall(3, 0), None);
        labels.keep(3, 7, Label { side: -1.0, crossed: true });
        assert_eq!(labels.recall(3, 7), Some(Label { side: -1.0, crossed: true }));
        assert_eq!(labels.recall(3, 8), None);
    }

    /// The side that a region has is known of particles that were never near; that one has crossed is forgotten after a step away.
    #[test]
    fn the_side_of_a_region_is_known_for_good() {
        let mut labels = Labels { known: Some(-1.0), ..Labels::default() };
        assert_eq!(labels.recall(3, 0), Some(Label { side: -1.0, crossed: false }));
        labels.keep(3, 7, Label { side: -1.0, crossed: true });
        assert_eq!(labels.recall(3, 7), Some(Label { side: -1.0, crossed: true }));
        assert_eq!(labels.recall(3, 8), Some(Label { side: -1.0, crossed: false }));
    }
}
