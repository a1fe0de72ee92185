//! Writing: a header with room for the places of blocks, the blocks, then the header as it is.

use super::header::{BlockEntry, ColumnEntry, Header, Origin};
use super::{ALIGNMENT, BLOCK};
use crate::parallel;
use crate::simulation::{Column, Columns};
use lz4_flex::block;
use std::io::{self, Seek, SeekFrom, Write};

/// Blocks compressed together, in parallel; bounds the memory of the writer.
const BATCH: usize = 16;

/// Writes all columns.
pub(super) fn write(out: &mut (impl Write + Seek), origin: Origin, columns: &mut Columns<'_>) -> io::Result<()> {
    let mut entries = vec![];
    columns(&mut |name, column: Column<'_>| {
        let bytes = column.data.bytes().len();
        entries.push(ColumnEntry::reserve(name, column.data.kind(), column.components, bytes));
    });
    let mut header = Header { origin, columns: entries };
    out.write_all(header.encode().as_bytes())?;

    let mut entries = header.columns.iter_mut();
    let mut result = Ok(());
    columns(&mut |_, column| {
        let entry = entries.next();
        if let (Ok(()), Some(entry)) = (&result, entry) {
            result = write_column(out, column.data.bytes(), &mut entry.blocks);
        }
    });
    result?;
    out.seek(SeekFrom::Start(0))?;
    out.write_all(header.encode().as_bytes())
}

/// Writes one column from the next aligned place on, and notes where its blocks are.
fn write_column(out: &mut (impl Write + Seek), bytes: &[u8], places: &mut [BlockEntry]) -> io::Result<()> {
    let mut at = out.stream_position()?;
    if !bytes.is_empty() {
        let start = at.next_multiple_of(ALIGNMENT);
        out.write_all(&[0; ALIGNMENT as usize][..(start - at) as usize])?;
        at = start;
    }
    let blocks: Vec<&[u8]> = bytes.chunks(BLOCK).collect();
    for (blocks, places) in blocks.chunks(BATCH).zip(places.chunks_mut(BATCH)) {
        let compressed = parallel::collect(blocks.len(), 1, |n| block::compress(blocks[n]));
        for ((raw, stored), place) in blocks.iter().zip(&compressed).zip(places) {
            out.write_all(stored)?;
            *place = BlockEntry { at, stored: stored.len(), raw: raw.len(), crc: crc32fast::hash(stored) };
            at += stored.len() as u64;
        }
    }
    Ok(())
}
