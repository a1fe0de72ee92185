//! The phases of a run: what each is, and which of two the level set between them is negative in.
//!
//! Two phases are told apart by their roles, not by their numbers: a solid comes before a fluid, and of one role
//! the heavier comes first, of equally heavy ones the one that is named first. The level set between two is negative in
//! the first.

/// The role of a phase.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Role {
    /// A fluid, which flows.
    Fluid,
    /// A solid, which keeps a shape.
    Solid,
}

/// Rule by which particles are added and merged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Reseeding {
    /// By sub-cells: none stays empty, none is crowded.
    #[default]
    SubCells,
    /// By elements, before the projection and at the end of the step (the paper).
    Elements,
    /// Only where an element is empty: particles with a history are neither merged nor dropped, nor joined by others
    /// that have none.
    EmptyElements,
}

/// A phase.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Phase {
    /// Role of the phase.
    pub role: Role,
    /// Density [kg/m³].
    pub density: f64,
    /// Rule by which its particles are added and merged.
    pub reseeding: Reseeding,
}

impl Phase {
    /// A solid of this density [kg/m³], whose particles keep their history.
    pub fn solid(density: f64) -> Self {
        Self { role: Role::Solid, density, reseeding: Reseeding::EmptyElements }
    }

    /// A fluid of this density [kg/m³].
    pub fn fluid(density: f64, reseeding: Reseeding) -> Self {
        Self { role: Role::Fluid, density, reseeding }
    }
}

/// The phases of a run, by their numbers.
#[derive(Debug, Clone, Default)]
pub struct PhaseList {
    phases: Vec<Phase>,
    density: Vec<f64>,
    sides: Option<[usize; 2]>,
}

impl PhaseList {
    /// The list of these phases.
    pub fn new(phases: Vec<Phase>) -> Self {
        let density = phases.iter().map(|phase| phase.density).collect();
        let list = Self { phases, density, sides: None };
        Self { sides: (list.phases.len() == 2).then(|| list.ordered([0, 1])), ..list }
    }

    /// Fluids of these densities [kg/m³], reseeded by default.
    pub fn fluids(density: &[f64]) -> Self {
        Self::new(density.iter().map(|&density| Phase::fluid(density, Reseeding::default())).collect())
    }

    /// Number of phases.
    pub fn count(&self) -> usize {
        self.phases.len()
    }

    /// Densities of the phases [kg/m³].
    pub fn density(&self) -> &[f64] {
        &self.density
    }

    /// Rule by which the particles of a phase are added and merged.
    pub fn reseeding(&self, phase: usize) -> Reseeding {
        self.phases[phase].reseeding
    }

    /// True if some phase is a solid.
    pub fn has_solids(&self) -> bool {
        self.phases.iter().any(|phase| phase.role == Role::Solid)
    }

    /// True if the particles of some phase are added and taken away by elements.
    pub fn reseeds_by_elements(&self) -> bool {
        self.phases.iter().any(|phase| phase.reseeding == Reseeding::Elements)
    }

    /// The phases where the level set is negative and where it isn't, if there are two: one level set tells them apart.
    pub fn sides(&self) -> Option<[usize; 2]> {
        self.sides
    }

    /// Two phases, the one first in which the level set between them is negative.
    pub fn ordered(&self, [a, b]: [usize; 2]) -> [usize; 2] {
        if self.compare(a, b).is_ge() { [a, b] } else { [b, a] }
    }

    /// Greater is the phase that comes first.
    pub fn compare(&self, a: usize, b: usize) -> std::cmp::Ordering {
        let [first, second] = [self.phases[a], self.phases[b]];
        first.role.cmp(&second.role).then(first.density.total_cmp(&second.density))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_solid_comes_before_a_heavier_fluid_and_a_heavy_fluid_before_a_light_one() {
        let fluid = |density| Phase::fluid(density, Reseeding::default());
        let solid = |density| Phase { role: Role::Solid, ..fluid(density) };
        let sides = |phases: [Phase; 2]| PhaseList::new(phases.to_vec()).sides();
        assert_eq!(sides([fluid(1000.0), solid(1.0)]), Some([1, 0]));
        assert_eq!(sides([solid(1000.0), fluid(1000.0)]), Some([0, 1]));
        assert_eq!(sides([fluid(1.0), fluid(1000.0)]), Some([1, 0]));
        assert_eq!(sides([fluid(2.0), fluid(2.0)]), Some([0, 1]));
        assert_eq!(PhaseList::fluids(&[1.0, 2.0, 3.0]).sides(), None);
    }
}
