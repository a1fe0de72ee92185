//! Named columns of numbers that a checkpoint stores and restores without knowing their meaning.
//!
//! A [`Column`] borrows one of three things: an array (`Vec`) with a fixed or a free number of entries, a scalar, or a
//! record, which is a struct whose fields are numbers of one type. A checkpoint stores a scalar or a record as it
//! stores an array with one entry.

use bytemuck::Pod;

/// Prefix of the names of columns that belong to an output: a run may be resumed with other outputs than it had.
pub const OF_OUTPUT: &str = "output/";

/// Borrowed numbers of a state.
///
/// ```
/// use lateen::simulation::{Column, Size};
///
/// let mut velocity = vec![[1.0, 0.0, 0.0], [0.0, 2.0, 0.0]];
/// let column = Column::new(&mut velocity);
/// assert_eq!((column.data.kind(), column.components, column.size), ("f64", 3, Size::Fixed));
/// assert_eq!(column.data.bytes().len(), 2 * 3 * 8);
/// ```
pub struct Column<'a> {
    /// Numbers per entry (1 for scalars, 3 for vectors in 3D, 9 for 3D tensors).
    pub components: usize,
    /// Number of entries it may have.
    pub size: Size,
    /// The numbers.
    pub data: &'a mut dyn ColumnData,
}

/// Number of entries a column may have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Size {
    /// The present number: another number belongs to another model.
    Fixed,
    /// Any number: it changes during a run.
    Free,
    /// One: a scalar or a record. How a file groups its numbers in entries does not matter, only how many there are.
    Single,
}

impl<'a> Column<'a> {
    /// A column over `data`, whose entries hold `size_of::<T>() / size_of::<number>()` numbers.
    pub fn new<T: Pod>(data: &'a mut Vec<T>) -> Self
    where
        Vec<T>: ColumnData,
    {
        Self { components: (size_of::<T>() / data.number_size()).max(1), size: Size::Fixed, data }
    }

    /// A column as [`Column::new`] makes it, whose number of entries changes during a run.
    pub fn growing<T: Pod>(data: &'a mut Vec<T>) -> Self
    where
        Vec<T>: ColumnData,
    {
        Self { size: Size::Free, ..Self::new(data) }
    }

    /// A column over one number, stored as an array with one entry.
    ///
    /// ```
    /// use lateen::simulation::Column;
    ///
    /// let mut steps = 7_u64;
    /// let column = Column::scalar(&mut steps);
    /// assert_eq!((column.data.kind(), column.components), ("u64", 1));
    /// assert!(column.data.replace(&8_u64.to_le_bytes()));
    /// assert!(!column.data.replace(&[0; 16]), "two numbers are no scalar");
    /// assert_eq!(steps, 8);
    /// ```
    pub fn scalar<T: Number>(data: &'a mut T) -> Self {
        Self::record(data)
    }

    /// A column over the fields of a struct, stored as an array with one entry. An array of the same numbers, one per
    /// entry, is restored into it as well.
    ///
    /// ```
    /// use bytemuck::{Pod, Zeroable};
    /// use lateen::simulation::{Column, Record};
    ///
    /// #[derive(Clone, Copy, Pod, Zeroable)]
    /// #[repr(C)]
    /// struct Works {
    ///     gravity: f64,
    ///     impulse: [f64; 3],
    /// }
    /// impl Record for Works {
    ///     type Number = f64;
    /// }
    ///
    /// let mut works = Works { gravity: 1.0, impulse: [0.0, 0.0, 2.0] };
    /// let column = Column::record(&mut works);
    /// assert_eq!((column.data.kind(), column.components), ("f64", 4));
    /// assert!(column.data.replace(bytemuck::cast_slice(&[5.0, 6.0, 7.0, 8.0])));
    /// assert_eq!((works.gravity, works.impulse), (5.0, [6.0, 7.0, 8.0]));
    /// ```
    pub fn record<R: Record>(data: &'a mut R) -> Self {
        Self { components: R::COMPONENTS, size: Size::Single, data }
    }
}

/// Numbers that can be read as bytes and replaced from bytes.
pub trait ColumnData {
    /// `"f64"`, `"f32"`, `"u32"`, `"i32"`, `"u64"` or `"u8"`.
    fn kind(&self) -> &'static str;
    /// Bytes per number.
    fn number_size(&self) -> usize;
    /// The contents, little-endian as in memory.
    fn bytes(&self) -> &[u8];
    /// Replaces the contents; `false`, and nothing replaced, if the length does not fit the entry type.
    fn replace(&mut self, bytes: &[u8]) -> bool;
}

/// A type of number that checkpoints know.
pub trait Number: Record<Number = Self> {
    /// Name of the type in the header of a checkpoint.
    const KIND: &'static str;
}

/// Numbers of one type, laid out without gaps (`#[repr(C)]`, `Pod`): a scalar, a vector, or a struct of these.
pub trait Record: Pod {
    /// The type of its numbers.
    type Number: Number;

    /// Number of its numbers; a struct whose size is no multiple of its numbers' doesn't compile as a column.
    const COMPONENTS: usize = {
        assert!(size_of::<Self>().is_multiple_of(size_of::<Self::Number>()), "a record holds numbers of one type");
        assert!(align_of::<Self>() == align_of::<Self::Number>(), "a record holds numbers of one type");
        size_of::<Self>() / size_of::<Self::Number>()
    };
}

impl<R: Record> ColumnData for R {
    fn kind(&self) -> &'static str {
        R::Number::KIND
    }

    fn number_size(&self) -> usize {
        size_of::<R::Number>()
    }

    fn bytes(&self) -> &[u8] {
        bytemuck::bytes_of(self)
    }

    fn replace(&mut self, bytes: &[u8]) -> bool {
        let fits = bytes.len() == size_of::<R>();
        if fits {
            bytemuck::bytes_of_mut(self).copy_from_slice(bytes);
        }
        fits
    }
}

impl<R: Record> ColumnData for Vec<R> {
    fn kind(&self) -> &'static str {
        R::Number::KIND
    }

    fn number_size(&self) -> usize {
        size_of::<R::Number>()
    }

    fn bytes(&self) -> &[u8] {
        bytemuck::cast_slice(self)
    }

    fn replace(&mut self, bytes: &[u8]) -> bool {
        let fits = bytes.len().is_multiple_of(size_of::<R>());
        if fits {
            self.clear();
            self.resize(bytes.len() / size_of::<R>(), bytemuck::Zeroable::zeroed());
            bytemuck::cast_slice_mut::<R, u8>(self).copy_from_slice(bytes);
        }
        fits
    }
}

macro_rules! numbers {
    ($($T:ident),+) => {$(
        impl Number for $T {
            const KIND: &'static str = stringify!($T);
        }
        impl Record for $T {
            type Number = $T;
        }
    )+};
}
numbers!(f64, f32, u32, i32, u64, u8);

impl<R: Record, const N: usize> Record for [R; N] {
    type Number = R::Number;
}

impl<const D: usize> Record for crate::math::Vector<D> {
    type Number = f64;
}

impl<const D: usize> Record for crate::math::Tensor<D> {
    type Number = f64;
}

impl Record for crate::math::SymTensor {
    type Number = f64;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scalar_and_a_record_are_stored_as_an_array_with_one_entry() {
        let (mut number, mut array) = (1.5, vec![1.5]);
        let (scalar, array) = (Column::scalar(&mut number), Column::new(&mut array));
        assert_eq!((scalar.components, scalar.data.kind()), (array.components, array.data.kind()));
        assert_eq!(scalar.data.bytes(), array.data.bytes());
        let (mut record, mut array) = ([1_u64, 2, 3], vec![[1_u64, 2, 3]]);
        let (record, array) = (Column::record(&mut record), Column::new(&mut array));
        assert_eq!((record.components, record.data.kind()), (array.components, array.data.kind()));
        assert_eq!(record.data.bytes(), array.data.bytes());
    }

    #[test]
    fn bytes_of_another_length_replace_nothing() {
        let (mut number, mut array) = (1_u32, vec![[1_u32, 2]]);
        assert!(!ColumnData::replace(&mut number, &[0; 3]) && !ColumnData::replace(&mut number, &[]));
        assert!(!ColumnData::replace(&mut array, &[0; 12]));
        assert_eq!((number, array), (1, vec![[1, 2]]));
    }
}
