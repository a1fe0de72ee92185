//! Data arrays: their XML headers, and their numbers in compressed blocks.

use crate::parallel;
use crate::simulation::Field;
use flate2::{Compression, write::ZlibEncoder};
use std::borrow::Cow;
use std::fmt::Write as _;
use std::io::{self, Seek, SeekFrom, Write};

/// Bytes per compressed block.
const BLOCK: usize = 1 << 18;
/// Blocks compressed together, in parallel; bounds the memory of the writer.
const BATCH: usize = 32;
/// zlib level: most of the gain at a fraction of the time of the default.
const LEVEL: u32 = 3;

/// Precision of files for viewing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FieldPrecision {
    /// 7 digits, half the space.
    #[default]
    Single,
    /// 16 digits.
    Double,
}

/// The numbers of an array, converted to bytes block by block.
pub(super) enum ArrayValues<'a> {
    /// Real numbers, stored or computed when they are written.
    Real(Box<dyn Fn() -> Cow<'a, [f64]> + 'a>, FieldPrecision),
    /// Time: always in full.
    Time(f64),
    /// Identities.
    U32(&'a [u32]),
    /// Node numbers and offsets, computed when they are written.
    I64(Box<dyn Fn() -> Vec<i64> + 'a>),
    /// Cell types, computed when they are written.
    U8(Box<dyn Fn() -> Vec<u8> + 'a>),
}

/// A named array of a file.
pub(super) struct DataArray<'a> {
    pub name: &'a str,
    pub unit: &'a str,
    pub components: usize,
    pub numbers: ArrayValues<'a>,
}

impl<'a> DataArray<'a> {
    pub fn field(field: &'a Field<'a>, unit: &'a str, precision: FieldPrecision) -> Self {
        let numbers = ArrayValues::Real(Box::new(|| field.values()), precision);
        Self { name: field.name, unit, components: field.components, numbers }
    }

    pub fn points(position: &'a [[f64; 3]], unit: &'a str, precision: FieldPrecision) -> Self {
        let numbers = ArrayValues::Real(Box::new(|| Cow::Borrowed(position.as_flattened())), precision);
        Self { name: "position", unit, components: 3, numbers }
    }

    pub fn plain(name: &'a str, numbers: ArrayValues<'a>) -> Self {
        Self { name, unit: "", components: 1, numbers }
    }

    fn vtk_type(&self) -> &'static str {
        match self.numbers {
            ArrayValues::Real(_, FieldPrecision::Single) => "Float32",
            ArrayValues::Real(_, FieldPrecision::Double) | ArrayValues::Time(_) => "Float64",
            ArrayValues::U32(_) => "UInt32",
            ArrayValues::I64(_) => "Int64",
            ArrayValues::U8(_) => "UInt8",
        }
    }

    /// The XML element. `offset` is where the array starts in the appended data, once that is known;
    /// until then it takes the same room.
    pub fn header(&self, offset: Option<u64>) -> String {
        let mut xml = format!("<DataArray type=\"{}\" Name=\"{}\"", self.vtk_type(), escape(self.name));
        if self.components > 1 {
            write!(xml, " NumberOfComponents=\"{}\"", self.components).expect("in memory");
            for (c, name) in crate::output::label::component_names(self.components).iter().enumerate() {
                write!(xml, " ComponentName{c}=\"{}\"", name.to_uppercase()).expect("in memory");
            }
        }
        if matches!(self.numbers, ArrayValues::Time(_)) {
            xml.push_str(" NumberOfTuples=\"1\"");
        }
        let offset = format!("\"{}\"", offset.unwrap_or_default());
        // Blanks after the closing quote keep the length when the offset is filled in.
        write!(xml, " format=\"appended\" offset={offset:<22}>").expect("in memory");
        if !self.unit.is_empty() {
            let unit = escape(self.unit);
            write!(xml, "<InformationKey name=\"UNITS_LABEL\" location=\"vtkDataArray\">{unit}</InformationKey>")
                .expect("in memory");
        }
        xml.push_str("</DataArray>\n");
        xml
    }

    /// Appends the numbers in compressed blocks.
    pub fn append(&self, out: &mut (impl Write + Seek)) -> io::Result<()> {
        match &self.numbers {
            ArrayValues::Real(values, FieldPrecision::Single) => {
                append_blocks(out, &values(), |&value, bytes| bytes.extend((value as f32).to_le_bytes()))
            }
            ArrayValues::Real(values, FieldPrecision::Double) => {
                append_blocks(out, &values(), |&value, bytes| bytes.extend(value.to_le_bytes()))
            }
            ArrayValues::Time(time) => append_blocks(out, &[*time], |&value, bytes| bytes.extend(value.to_le_bytes())),
            ArrayValues::U32(values) => append_blocks(out, values, |&value, bytes| bytes.extend(value.to_le_bytes())),
            ArrayValues::I64(values) => {
                append_blocks(out, &values(), |&value, bytes| bytes.extend(value.to_le_bytes()))
            }
            ArrayValues::U8(values) => append_blocks(out, &values(), |&value, bytes| bytes.push(value)),
        }
    }
}

/// Text as the value of an XML attribute.
pub(super) fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// Writes the numbers as compressed blocks behind the table of their sizes.
fn append_blocks<T: Sync>(
    out: &mut (impl Write + Seek),
    values: &[T],
    encode: impl Fn(&T, &mut Vec<u8>) + Sync,
) -> io::Result<()> {
    let per_block = BLOCK / size_of_encoded(values.first(), &encode);
    let chunks: Vec<&[T]> = values.chunks(per_block).collect();
    let compress = |chunk: &[T]| -> io::Result<(usize, Vec<u8>)> {
        let mut raw = Vec::with_capacity(BLOCK);
        chunk.iter().for_each(|value| encode(value, &mut raw));
        let mut encoder = ZlibEncoder::new(Vec::new(), Compression::new(LEVEL));
        encoder.write_all(&raw)?;
        Ok((raw.len(), encoder.finish()?))
    };

    let table_at = out.stream_position()?;
    let mut table = vec![chunks.len() as u64, 0, 0];
    table.resize(3 + chunks.len(), 0);
    write_u64s(out, &table)?;
    for (batch, chunks) in chunks.chunks(BATCH).enumerate() {
        let blocks = parallel::collect(chunks.len(), 1, |n| compress(chunks[n]));
        let blocks: Vec<_> = blocks.into_iter().collect::<io::Result<_>>()?;
        for (b, (raw, compressed)) in blocks.iter().enumerate() {
            out.write_all(compressed)?;
            table[1] = table[1].max(*raw as u64);
            table[2] = *raw as u64 % table[1].max(1);
            table[3 + batch * BATCH + b] = compressed.len() as u64;
        }
    }
    let end = out.stream_position()?;
    out.seek(SeekFrom::Start(table_at))?;
    write_u64s(out, &table)?;
    out.seek(SeekFrom::Start(end))?;
    Ok(())
}

fn size_of_encoded<T>(value: Option<&T>, encode: &impl Fn(&T, &mut Vec<u8>)) -> usize {
    let mut bytes = Vec::new();
    value.into_iter().for_each(|value| encode(value, &mut bytes));
    bytes.len().max(1)
}

fn write_u64s(out: &mut impl Write, numbers: &[u64]) -> io::Result<()> {
    numbers.iter().try_for_each(|number| out.write_all(&number.to_le_bytes()))
}
