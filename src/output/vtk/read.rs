//! Reads back arrays of the files that are written here: to compare fields with references.

use crate::input;
use flate2::read::ZlibDecoder;
use std::io::{self, Read};
use std::path::Path;

/// The numbers of the array `name` of a `.vtp` or `.vtu` file written by this program, tuple by tuple.
///
/// # Errors
/// Input/output errors; a file without the array, or that was not written here.
pub fn read_array(path: &Path, name: &str) -> io::Result<Vec<f64>> {
    let bytes = input::read(path)?;
    let start = find(&bytes, b"<AppendedData").ok_or_else(|| invalid("no appended data"))?;
    let first = start + find(&bytes[start..], b"_").ok_or_else(|| invalid("no appended data"))? + 1;
    let header = String::from_utf8_lossy(&bytes[..start]);
    let quoted = format!("Name=\"{}\"", super::array::escape(name));
    let element = header.split("<DataArray ").find(|element| element.contains(&quoted));
    let element = element.ok_or_else(|| invalid(&format!("no array `{name}`")))?;
    let offset = attribute(element, "offset").and_then(|text| text.parse::<usize>().ok());
    let raw = inflate(bytes.get(first + offset.ok_or_else(|| invalid("no offset"))?..).unwrap_or_default())?;
    match attribute(element, "type") {
        Some("Float32") => Ok(raw.as_chunks().0.iter().map(|&b| f64::from(f32::from_le_bytes(b))).collect()),
        Some("Float64") => Ok(raw.as_chunks().0.iter().map(|&b| f64::from_le_bytes(b)).collect()),
        _ => Err(invalid(&format!("`{name}` doesn't hold real numbers"))),
    }
}

/// Joins the compressed blocks behind their table: number of blocks, two sizes, size of each.
fn inflate(bytes: &[u8]) -> io::Result<Vec<u8>> {
    let (table, _) = bytes.as_chunks::<8>();
    let size = |n: usize| table.get(n).map(|&b| u64::from_le_bytes(b) as usize).ok_or_else(|| invalid("cut off"));
    let count = size(0)?;
    let (mut at, mut raw) = (8 * (3 + count), Vec::new());
    for block in 0..count {
        let end = at + size(3 + block)?;
        ZlibDecoder::new(bytes.get(at..end).ok_or_else(|| invalid("cut off"))?).read_to_end(&mut raw)?;
        at = end;
    }
    Ok(raw)
}

fn attribute<'a>(element: &'a str, name: &str) -> Option<&'a str> {
    element.split_once(&format!("{name}=\""))?.1.split('"').next()
}

fn find(bytes: &[u8], pattern: &[u8]) -> Option<usize> {
    bytes.windows(pattern.len()).position(|window| window == pattern)
}

fn invalid(what: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, what.to_owned())
}
