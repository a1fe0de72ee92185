//! The bodies of a run, owned by the velocity fields that they move in.

use super::Body;
use std::ops::{Index, IndexMut};

/// All bodies: each belongs to one velocity field of the grid, in which it moves; bodies of different fields meet by
/// contact. Stages of a step visit the bodies of one field. Outputs, checkpoints and sums over all bodies go in the
/// order of the case, in which bodies of one field need not be neighbours; a body's number is its place there (each
/// part of a divided body has one).
#[derive(Debug)]
pub struct Bodies<const D: usize> {
    /// By number of the velocity field.
    fields: Vec<FieldBodies<D>>,
    /// The places of the bodies, in the order of the case.
    order: Vec<BodyPlace>,
}

/// The bodies of one velocity field, in the order of the case.
#[derive(Debug)]
struct FieldBodies<const D: usize> {
    bodies: Vec<Body<D>>,
    /// The number of each in the case.
    numbers: Vec<usize>,
}

/// The place of a body: the number of its velocity field, and its index among the bodies of that.
#[derive(Debug, Clone, Copy)]
struct BodyPlace {
    field: usize,
    index: usize,
}

impl<const D: usize> Bodies<D> {
    /// Gives each of the bodies, which are in the order of the case, to the velocity field of its number.
    pub fn new(bodies: impl IntoIterator<Item = (usize, Body<D>)>) -> Self {
        let mut all = Self { fields: Vec::new(), order: Vec::new() };
        for (number, (field, body)) in bodies.into_iter().enumerate() {
            while all.fields.len() <= field {
                all.fields.push(FieldBodies { bodies: Vec::new(), numbers: Vec::new() });
            }
            let own = &mut all.fields[field];
            all.order.push(BodyPlace { field, index: own.bodies.len() });
            own.bodies.push(body);
            own.numbers.push(number);
        }
        all
    }

    /// All bodies in the order of the case, each with the number of its velocity field: what [`Self::new`] takes.
    pub fn into_pairs(self) -> impl Iterator<Item = (usize, Body<D>)> {
        let mut fields: Vec<_> = self.fields.into_iter().map(|own| own.bodies.into_iter()).collect();
        // In each field bodies are in the order of the case.
        self.order.into_iter().filter_map(move |BodyPlace { field, .. }| Some((field, fields[field].next()?)))
    }

    /// Number of velocity fields.
    pub fn field_count(&self) -> usize {
        self.fields.len()
    }

    /// The bodies of a velocity field.
    pub fn field(&self, field: usize) -> &[Body<D>] {
        &self.fields[field].bodies
    }

    /// The bodies of a velocity field, to be changed.
    pub fn field_mut(&mut self, field: usize) -> &mut [Body<D>] {
        &mut self.fields[field].bodies
    }

    /// The bodies of a velocity field, each with its number in the case.
    pub fn numbered(&self, field: usize) -> impl Iterator<Item = (usize, &Body<D>)> {
        let FieldBodies { bodies, numbers } = &self.fields[field];
        numbers.iter().copied().zip(bodies)
    }

    /// The names of the bodies of a velocity field.
    pub fn names(&self, field: usize) -> Vec<String> {
        self.field(field).iter().map(|body| body.name.clone()).collect()
    }

    /// Number of bodies.
    pub fn len(&self) -> usize {
        self.order.len()
    }

    /// The velocity field of the body of this number in the case.
    pub fn field_of(&self, number: usize) -> usize {
        self.order[number].field
    }

    /// All bodies in the order of the case.
    pub fn iter(&self) -> impl Iterator<Item = &Body<D>> {
        self.with_fields().map(|(_, body)| body)
    }

    /// All bodies in the order of the case, to be changed.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = &mut Body<D>> {
        self.with_fields_mut().map(|(_, body)| body)
    }

    /// All bodies in the order of the case, each with the number of its velocity field.
    pub fn with_fields(&self) -> impl Iterator<Item = (usize, &Body<D>)> {
        self.order.iter().map(|&BodyPlace { field, index }| (field, &self.fields[field].bodies[index]))
    }

    /// All bodies in the order of the case, each with the number of its velocity field, to be changed.
    pub fn with_fields_mut(&mut self) -> impl Iterator<Item = (usize, &mut Body<D>)> {
        let mut fields: Vec<_> = self.fields.iter_mut().map(|own| own.bodies.iter_mut()).collect();
        // In each field bodies are in the order of the case.
        self.order.iter().filter_map(move |&BodyPlace { field, .. }| Some((field, fields[field].next()?)))
    }
}

impl<const D: usize> Index<usize> for Bodies<D> {
    type Output = Body<D>;

    /// The body of this number in the case.
    fn index(&self, number: usize) -> &Body<D> {
        let BodyPlace { field, index } = self.order[number];
        &self.fields[field].bodies[index]
    }
}

impl<const D: usize> IndexMut<usize> for Bodies<D> {
    fn index_mut(&mut self, number: usize) -> &mut Body<D> {
        let BodyPlace { field, index } = self.order[number];
        &mut self.fields[field].bodies[index]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::{Elastic, NeoHookean};
    use crate::mpm::particles::Particles;
    use crate::mpm::{Kernel, KernelKind};
    use std::sync::Arc;

    fn body(name: &str) -> Body<2> {
        let law = NeoHookean { elastic: Elastic::new(1.0, 1.0, 0.3) };
        Body::new(name.into(), Arc::new(law), Kernel::new(KernelKind::Quadratic, 0.25), Particles::default())
    }

    /// Bodies of one field that don't follow one another in the case: each field has its own in the order of the case,
    /// and all together are in that order, however they are asked for.
    #[test]
    fn bodies_belong_to_fields_and_keep_the_order_of_the_case() {
        let of_case = [(0, "a"), (1, "b"), (0, "c"), (2, "d"), (1, "e")];
        let mut bodies = Bodies::new(of_case.map(|(field, name)| (field, body(name))));
        assert_eq!((bodies.field_count(), bodies.len()), (3, 5));
        assert_eq!([0, 1, 2].map(|field| bodies.names(field).concat()), ["ac", "be", "d"]);
        let numbered: Vec<(usize, &str)> = bodies.numbered(1).map(|(n, body)| (n, &*body.name)).collect();
        assert_eq!(numbered, [(1, "b"), (4, "e")]);
        for (number, (field, name)) in of_case.into_iter().enumerate() {
            assert_eq!((bodies.field_of(number), &*bodies[number].name), (field, name));
        }
        assert!(bodies.with_fields().map(|(field, body)| (field, &*body.name)).eq(of_case));
        assert!(bodies.with_fields_mut().map(|(field, body)| (field, &*body.name)).eq(of_case));
        for (number, body) in bodies.iter_mut().enumerate() {
            body.ambient = number as f64;
        }
        bodies.field_mut(2)[0].ambient += 10.0;
        bodies[4].ambient += 20.0;
        assert_eq!(bodies.iter().map(|body| body.ambient).collect::<Vec<_>>(), [0.0, 1.0, 2.0, 13.0, 24.0]);
        assert!(
            bodies.into_pairs().map(|(field, body)| (field, body.name)).eq(of_case.map(|(f, n)| (f, n.to_owned())))
        );
    }
}
