//! Named arrays that a checkpoint stores and restores without knowing what they mean.

/// Names of columns that belong to an output begin so: a run may go on with other outputs than it had.
pub const OF_OUTPUT: &str = "output/";

/// A borrowed array of plain numbers.
pub struct Column<'a> {
    /// Numbers per entry (1 for scalars, 3 for vectors in 3D, 9 for 3D tensors).
    pub components: usize,
    /// How many entries it may have.
    pub size: Size,
    /// The array.
    pub data: &'a mut dyn ColumnData,
}

/// How many entries a column may have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Size {
    /// As many as it has: another number belongs to another model.
    Fixed,
    /// Any number: it changes during a run.
    Free,
}

impl<'a> Column<'a> {
    /// A column over `data`, whose entries hold `size_of::<T>() / size_of::<kind>()` numbers.
    pub fn new<T: bytemuck::Pod>(data: &'a mut Vec<T>) -> Self
    where
        Vec<T>: ColumnData,
    {
        Self { components: (size_of::<T>() / data.number_size()).max(1), size: Size::Fixed, data }
    }

    /// A column as [`Column::new`] makes it, whose number of entries changes during a run.
    pub fn growing<T: bytemuck::Pod>(data: &'a mut Vec<T>) -> Self
    where
        Vec<T>: ColumnData,
    {
        Self { size: Size::Free, ..Self::new(data) }
    }
}

/// An array that can be read as bytes and replaced from bytes.
pub trait ColumnData {
    /// `"f64"`, `"f32"`, `"u32"`, `"i32"`, `"u64"` or `"u8"`.
    fn kind(&self) -> &'static str;
    /// Bytes per number.
    fn number_size(&self) -> usize;
    /// The contents, little-endian as in memory.
    fn bytes(&self) -> &[u8];
    /// Replaces the contents; `false` if the length does not fit the entry type.
    fn replace(&mut self, bytes: &[u8]) -> bool;
}

macro_rules! column_data {
    ($kind:literal, $number:ty; $([$($generic:tt)*] $T:ty),+ $(,)?) => {$(
        impl<$($generic)*> ColumnData for Vec<$T> {
            fn kind(&self) -> &'static str { $kind }
            fn number_size(&self) -> usize { size_of::<$number>() }
            fn bytes(&self) -> &[u8] { bytemuck::cast_slice(self) }
            fn replace(&mut self, bytes: &[u8]) -> bool {
                if bytes.len() % size_of::<$T>() != 0 {
                    return false;
                }
                self.clear();
                self.resize(bytes.len() / size_of::<$T>(), bytemuck::Zeroable::zeroed());
                bytemuck::cast_slice_mut::<$T, u8>(self).copy_from_slice(bytes);
                true
            }
        }
    )+};
}

column_data!("f64", f64;
    [] f64,
    [const D: usize] crate::math::Vector<D>,
    [const D: usize] crate::math::Tensor<D>,
    [] crate::math::SymTensor,
);
column_data!("f32", f32; [] f32);
column_data!("u32", u32; [] u32, [] [u32; 2], [] [u32; 3], [] [u32; 4]);
column_data!("i32", i32; [] i32);
column_data!("u64", u64; [] u64);
column_data!("u8", u8; [] u8);
