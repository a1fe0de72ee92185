//! The fields of outputs and the columns of checkpoints of a membrane.

use super::Membrane;
use super::element::HistoryBlock;
use super::shape::GAUSS;
use crate::material::{SheetKind, SheetState, sheet::principal};
use crate::math::Vector;
use crate::simulation::{Column, Elements, Field, Record, SurfaceSet};
use std::borrow::Cow;

impl<const D: usize> Membrane<D> {
    /// Every array that a checkpoint stores, named `prefix` + name.
    pub fn columns(&mut self, prefix: &str, visit: &mut dyn FnMut(&str, Column<'_>)) {
        visit(&format!("{prefix}position"), Column::new(&mut self.position));
        visit(&format!("{prefix}velocity"), Column::new(&mut self.velocity));
        visit(&format!("{prefix}elements"), Column::new(&mut self.blocks));
        visit(&format!("{prefix}ledger"), Column::record(&mut self.ledger));
    }

    /// Nodes, elements and fields for outputs.
    pub fn surface_set(&self) -> SurfaceSet<'_> {
        SurfaceSet {
            name: &self.name,
            position: padded(&self.position),
            reference: padded(&self.reference),
            elements: self.elements.iter().collect(),
            kind: Elements::Sheet,
            node_fields: vec![
                Field::scalar("mass", "kg", &self.mass),
                Field::computed("velocity", "m/s", 3, || flat(self.velocity.iter().copied())),
                Field::computed("displacement", "m", 3, || {
                    flat(self.position.iter().zip(&self.reference).map(|(&x, &reference)| x - reference))
                }),
            ],
            element_fields: self.element_fields(),
        }
    }

    fn element_fields(&self) -> Vec<Field<'_>> {
        let mut fields = vec![
            self.element_field("thickness", "m", |e| self.thickness(e)),
            self.element_field("stress 1", "Pa", |e| self.principal_stress(e)[0]),
            self.element_field("stress 2", "Pa", |e| self.principal_stress(e)[1]),
            self.element_field("resultant", "N/m", |e| self.principal_stress(e)[0] * self.thickness(e)),
            self.element_field("wrinkling", "", |e| self.wrinkle_state(e)),
            self.element_field("hourglass energy", "J", |e| self.hourglass_work(e)),
            self.element_field("area", "m^2", |e| self.area_vector(e).norm()),
            Field::computed("contact pressure", "Pa", 1, || self.contact_pressures()),
            Field::computed("contact area", "m^2", 1, || self.contact_areas()),
        ];
        if self.is_closed() {
            fields.push(Field::computed("volume", "m^3", 1, || self.volumes()));
        }
        fields
    }

    /// Principal values of the true stress that an element carries [Pa], the greater first: means over its quadrature
    /// points.
    pub fn principal_stress(&self, element: usize) -> [f64; 2] {
        let (blocks, lane) = self.elements.blocks_and_lane(element);
        let (first, points) = (blocks.start, blocks.len());
        let values: Vec<[f64; 2]> = blocks
            .map(|block| match self.sheet.kind() {
                SheetKind::Rate => principal(self.blocks[block].stress.map(|s| s[lane])).0,
                SheetKind::Total => {
                    let place = if points > 1 { GAUSS[block - first] } else { [0.0; 2] };
                    self.total_stress(element, block, lane, place)
                }
            })
            .collect();
        [0, 1].map(|i| values.iter().map(|value| value[i]).sum::<f64>() / points as f64)
    }

    /// Principal values of the true stress of a total law at (ξ, η) of an element with its state in `block`, `lane`
    /// [Pa].
    fn total_stress(&self, element: usize, block: usize, lane: usize, place: [f64; 2]) -> [f64; 2] {
        // σ = F S Fᵀ / J has the eigenvalues of C S / J.
        let c @ [c11, c22, c12] = self.right_cauchy_green(element, block, lane, place);
        let SheetState { stress: [s11, s22, s12], volume, .. } = self.sheet.total(c);
        let mean = 0.5 * (c11 * s11 + c22 * s22 + 2.0 * c12 * s12);
        let determinant = (c11 * c22 - c12 * c12) * (s11 * s22 - s12 * s12);
        let radius = (mean * mean - determinant).max(0.0).sqrt();
        [(mean + radius) / volume, (mean - radius) / volume]
    }

    /// 0 taut, 1 wrinkled, 2 slack; wrinkled or slack if all of it is.
    fn wrinkle_state(&self, element: usize) -> f64 {
        let [s1, s2] = self.principal_stress(element);
        let small = 1e-12 * self.sheet.modulus();
        match self.sheet.wrinkles() {
            true if s1 <= small => 2.0,
            true if s2 <= small => 1.0,
            _ => 0.0,
        }
    }

    /// Work taken up by the hourglass control of an element [J].
    fn hourglass_work(&self, element: usize) -> f64 {
        let (blocks, lane) = self.elements.blocks_and_lane(element);
        self.blocks[blocks].iter().map(|block| block.hourglass_work[lane]).sum()
    }

    /// C11, C22, C12 in the material axes (total laws) at (ξ, η) of an element with its reference in `block`, `lane`.
    fn right_cauchy_green(&self, element: usize, block: usize, lane: usize, [xi, eta]: [f64; 2]) -> [f64; 3] {
        let nodes = self.elements.nodes(element);
        let x = |k: usize| Vector(self.position[nodes[k] as usize].to3());
        let [g1, g2] = match nodes.len() {
            4 => {
                let h = x(0) - x(1) + x(2) - x(3);
                [x(1) - x(0) + x(2) - x(3) + h * eta, x(2) - x(0) + x(3) - x(1) + h * xi]
            }
            3 => [x(1) - x(0), x(2) - x(0)],
            _ => [x(1) - x(0), Vector::unit(2)],
        };
        let [m11, m12, m21, m22] = self.references[block].duals.map(|m| m[lane]);
        let (f1, f2) = (g1 * m11 + g2 * m21, g1 * m12 + g2 * m22);
        [f1.dot(f1), f2.dot(f2), f1.dot(f2)]
    }

    fn element_field<'a>(
        &'a self,
        name: &'static str,
        unit: &'static str,
        value: impl Fn(usize) -> f64 + 'a,
    ) -> Field<'a> {
        Field::computed(name, unit, 1, move || (0..self.elements.len()).map(&value).collect())
    }
}

/// Vectors with three components, borrowed where they already have them.
fn padded<const D: usize>(vectors: &[Vector<D>]) -> Cow<'_, [[f64; 3]]> {
    if D == 3 { Cow::Borrowed(bytemuck::cast_slice(vectors)) } else { vectors.iter().map(|v| v.to3()).collect() }
}

/// Vectors as numbers, three each.
fn flat<const D: usize>(vectors: impl Iterator<Item = Vector<D>>) -> Vec<f64> {
    vectors.flat_map(Vector::to3).collect()
}

impl Record for HistoryBlock {
    type Number = f64;
}
