//! Reading: nothing is believed before its checksum fits, nothing is allocated before it fits the file.

use super::header::{BlockEntry, ColumnEntry, FIRST_LINE, FirstLine, Header};
use super::{FORMAT, VERSION};
use crate::input;
use crate::memory;
use crate::simulation::{Column, Columns, OF_OUTPUT, Size};
use lz4_flex::block;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

/// The longest header that is read [bytes]: that of a state of a terabyte.
const LONGEST_HEADER: u64 = 128 << 20;

/// Why a checkpoint can't be used.
#[derive(Debug, thiserror::Error)]
pub(super) enum Trouble {
    /// The disk or the file system.
    #[error("{0}")]
    Io(#[from] io::Error),
    /// Torn or changed: an older one may be good.
    #[error("damaged: {0}")]
    Damaged(String),
    /// Whole, but of another case, version or model.
    #[error("{0}")]
    Foreign(String),
}

impl Trouble {
    /// A checkpoint of another version or format than this program reads.
    fn of_another_program(program: &str, format: u32) -> Self {
        Self::Foreign(format!(
            "was written by lateen {program} in format {format}; this is lateen {VERSION}, which reads format {FORMAT}: resume with the \
             program that wrote it, or begin anew"
        ))
    }
}

/// A checkpoint whose header is whole.
pub(super) struct Reader<R> {
    file: R,
    header: Header,
    header_bytes: u64,
}

impl Reader<BufReader<File>> {
    /// Opens a file and reads its header.
    pub fn open(path: &Path) -> Result<Self, Trouble> {
        // Opening a pipe would wait for its other end.
        let bytes = input::length(path).map_err(|error| match error.kind() {
            io::ErrorKind::InvalidInput | io::ErrorKind::IsADirectory => Trouble::Damaged(error.to_string()),
            _ => Trouble::Io(error),
        })?;
        Self::new(BufReader::new(File::open(path)?), bytes)
    }
}

impl<R: Read + Seek> Reader<R> {
    /// Reads the header of a checkpoint of `file_bytes` bytes.
    pub fn new(mut file: R, file_bytes: u64) -> Result<Self, Trouble> {
        let damaged = Trouble::Damaged;
        let mut line = [0; FIRST_LINE];
        read_whole(&mut file, &mut line)?;
        let first = FirstLine::parse(&line).map_err(damaged)?;
        let header_bytes = FIRST_LINE as u64 + first.header_bytes;
        if header_bytes > file_bytes {
            return Err(Trouble::Damaged("its header is cut off".into()));
        }
        if first.header_bytes > LONGEST_HEADER {
            return Err(Trouble::Damaged(format!("a header of {} bytes is none of a checkpoint", first.header_bytes)));
        }
        let mut text = vec![0; first.header_bytes as usize];
        read_whole(&mut file, &mut text)?;
        if !first.covers(&text) {
            return Err(Trouble::Damaged("the header's checksum does not fit".into()));
        }
        let text = String::from_utf8(text).map_err(|error| Trouble::Damaged(error.to_string()))?;
        if first.format != FORMAT {
            return Err(Trouble::of_another_program(
                Header::program(&text).unwrap_or("of an unknown version"),
                first.format,
            ));
        }
        let header = Header::parse(&text).map_err(damaged)?;
        header.check_layout(header_bytes, file_bytes).map_err(damaged)?;
        Ok(Self { file, header, header_bytes })
    }

    /// Checks that this program wrote it for this case.
    pub fn check_origin(&self, case: &str) -> Result<(), Trouble> {
        let origin = &self.header.origin;
        if origin.program != VERSION {
            return Err(Trouble::of_another_program(&origin.program, FORMAT));
        }
        if origin.case != case {
            return Err(Trouble::Foreign(
                "belongs to another case, to other settings, or to other contents of a file that the case names; resume with what it \
                 was written for"
                    .into(),
            ));
        }
        Ok(())
    }

    /// Checks that its columns are those of the model and of its size, and that they fit into the memory, by what the
    /// header says.
    pub fn check_model(&self, columns: &mut Columns<'_>) -> Result<(), Trouble> {
        let mut entries = BTreeMap::new();
        for entry in &self.header.columns {
            if entries.insert(entry.name.as_str(), entry).is_some() {
                return Err(Trouble::Foreign(format!("has the column `{}` twice", entry.name)));
            }
        }
        let mut misfit = None;
        columns(&mut |name, column| {
            let found = match entries.remove(name) {
                Some(entry) => column_misfit(entry, &column),
                None if name.starts_with(OF_OUTPUT) => None,
                None => Some(format!("has no column `{name}`, which this model needs")),
            };
            misfit = misfit.take().or(found);
        });
        let foreign = entries.keys().find(|name| !name.starts_with(OF_OUTPUT));
        let misfit =
            misfit.or_else(|| foreign.map(|name| format!("has a column `{name}`, which this model does not have")));
        let misfit = misfit.map(|why| {
            format!(
                "{why}: it is of another build of lateen {VERSION} that writes format {FORMAT}, too; resume with the program that wrote it, \
                 or begin anew"
            )
        });
        let bytes: u64 = self.header.columns.iter().map(|entry| entry.bytes).sum();
        let misfit = misfit.or_else(|| memory::refusal(bytes as f64).map(|refusal| format!("would take {refusal}")));
        misfit.map_or(Ok(()), |why| Err(Trouble::Foreign(why)))
    }

    /// Checks every byte of it.
    pub fn verify(&mut self) -> Result<(), Trouble> {
        let mut end = self.header_bytes;
        self.file.seek(SeekFrom::Start(end))?;
        for column in self.header.columns.iter() {
            for block in &column.blocks {
                let mut gap = vec![0; (block.at - end) as usize];
                read_whole(&mut self.file, &mut gap)?;
                if gap.iter().any(|&byte| byte != 0) {
                    return Err(Trouble::Damaged(format!("something lies before `{}`", column.name)));
                }
                read_block(&mut self.file, block, &column.name)?;
                end = block.at + block.stored as u64;
            }
        }
        Ok(())
    }

    /// Replaces the contents of all columns, which are those that the file has; an output that it doesn't know begins
    /// anew.
    pub fn restore(&mut self, columns: &mut Columns<'_>) -> Result<(), Trouble> {
        let mut entries: BTreeMap<String, ColumnEntry> =
            self.header.columns.iter().map(|entry| (entry.name.clone(), entry.clone())).collect();
        let mut result = Ok(());
        columns(&mut |name, column| {
            if let (Ok(()), Some(entry)) = (&result, entries.remove(name)) {
                result = self.restore_column(&entry, column);
            }
        });
        result
    }

    fn restore_column(&mut self, entry: &ColumnEntry, column: Column<'_>) -> Result<(), Trouble> {
        let mut bytes = Vec::with_capacity(entry.bytes as usize);
        for block in &entry.blocks {
            self.file.seek(SeekFrom::Start(block.at))?;
            bytes.extend(read_block(&mut self.file, block, &entry.name)?);
        }
        if column.data.replace(&bytes) {
            Ok(())
        } else {
            Err(Trouble::Foreign(format!("`{}` has {} bytes, no whole number of entries", entry.name, bytes.len())))
        }
    }
}

/// Why a column of the file is not that of the model.
fn column_misfit(entry: &ColumnEntry, column: &Column<'_>) -> Option<String> {
    let ColumnEntry { name, kind, components, bytes, .. } = entry;
    let grouped = column.size == Size::Single || *components == column.components;
    if *kind != column.data.kind() || !grouped {
        return Some(format!("has no column `{name}` of the kind that this model needs"));
    }
    let (own, number) = (column.data.bytes().len() as u64, column.data.number_size() as u64);
    match column.size {
        Size::Fixed | Size::Single if *bytes != own => {
            Some(format!("has a column `{name}` of {bytes} bytes, where that of this model has {own}"))
        }
        Size::Free if bytes % (number * column.components as u64) != 0 => {
            Some(format!("has a column `{name}` of {bytes} bytes, no whole number of entries"))
        }
        _ => None,
    }
}

/// Reads and checks the block that the file stands at.
fn read_block(file: &mut impl Read, entry: &BlockEntry, name: &str) -> Result<Vec<u8>, Trouble> {
    let mut stored = vec![0; entry.stored];
    read_whole(file, &mut stored)?;
    if crc32fast::hash(&stored) != entry.crc {
        return Err(Trouble::Damaged(format!("a checksum of `{name}` does not fit")));
    }
    match block::decompress(&stored, entry.raw) {
        Ok(raw) if raw.len() == entry.raw => Ok(raw),
        _ => Err(Trouble::Damaged(format!("a block of `{name}` does not decompress"))),
    }
}

/// Fills the buffer; a file that ends before is damaged.
fn read_whole(file: &mut impl Read, buffer: &mut [u8]) -> Result<(), Trouble> {
    file.read_exact(buffer).map_err(|error| match error.kind() {
        io::ErrorKind::UnexpectedEof => Trouble::Damaged("it is cut off".into()),
        _ => Trouble::Io(error),
    })
}

#[cfg(test)]
mod tests {
    use super::super::header::Origin;
    use super::super::{ALIGNMENT, BLOCK, write};
    use super::*;
    use proptest::prelude::*;
    use std::io::Cursor;

    fn checkpoint(values: &mut Vec<f64>, id: &mut Vec<u32>) -> Vec<u8> {
        let mut file = Cursor::new(vec![]);
        let origin = Origin { program: VERSION.into(), case: "case".into(), step: 1, time: 0.5 };
        let mut columns = |visit: &mut dyn FnMut(&str, Column<'_>)| {
            visit("water.position", Column::new(values));
            visit("water.id", Column::new(id));
        };
        write::write(&mut file, origin, &mut columns).unwrap();
        file.into_inner()
    }

    fn read(bytes: &[u8]) -> Result<Header, Trouble> {
        let mut reader = Reader::new(Cursor::new(bytes), bytes.len() as u64)?;
        reader.check_origin("case")?;
        reader.verify()?;
        Ok(reader.header)
    }

    fn sample() -> Vec<u8> {
        checkpoint(&mut (0..300).map(|i| f64::from(i).sqrt()).collect(), &mut (0..100).collect())
    }

    #[test]
    fn a_change_of_any_byte_is_recognised() {
        let whole = sample();
        assert!(read(&whole).is_ok());
        for place in 0..whole.len() {
            for flip in [1, 0x20, 0x80] {
                let mut changed = whole.clone();
                changed[place] ^= flip;
                assert!(matches!(read(&changed), Err(Trouble::Damaged(_))), "byte {place} flipped by {flip}");
            }
        }
    }

    #[test]
    fn a_cut_or_longer_file_is_recognised() {
        let whole = sample();
        for length in 0..whole.len() {
            assert!(matches!(read(&whole[..length]), Err(Trouble::Damaged(_))), "cut at {length}");
        }
        assert!(matches!(read(&[&whole[..], b"\0"].concat()), Err(Trouble::Damaged(_))));
    }

    #[test]
    fn a_header_that_promises_more_than_the_file_holds_allocates_nothing() {
        let origin = Origin { program: VERSION.into(), case: "case".into(), step: 1, time: 0.5 };
        let mut column = ColumnEntry::reserve("a", "f64", 1, 8);
        column.bytes = 1 << 60;
        column.blocks = vec![BlockEntry { at: 256, stored: 99_999_999, raw: 99_999_999, crc: 0 }; 50];
        let text = Header { origin, columns: vec![column] }.encode();
        assert!(matches!(read(text.as_bytes()), Err(Trouble::Damaged(_))));
    }

    /// A mebibyte of zeros takes a few bytes in the file: twice the free memory is refused by the header.
    #[test]
    fn a_file_that_would_grow_beyond_the_memory_is_refused() {
        let Some(free) = memory::free() else { return };
        let count = (2.0 * free / BLOCK as f64) as usize;
        let stored = block::compress(&vec![0; BLOCK]);
        let block = BlockEntry { at: 0, stored: stored.len(), raw: BLOCK, crc: crc32fast::hash(&stored) };
        let origin = Origin { program: VERSION.into(), case: "case".into(), step: 1, time: 0.5 };
        let mut column = ColumnEntry::reserve("water.position", "f64", 1, 0);
        (column.bytes, column.blocks) = ((count * BLOCK) as u64, vec![block; count]);
        let mut header = Header { origin, columns: vec![column] };
        let start = (header.encode().len() as u64).next_multiple_of(ALIGNMENT);
        for (n, block) in (0..).zip(&mut header.columns[0].blocks) {
            block.at = start + n * stored.len() as u64;
        }
        let mut bytes = header.encode().into_bytes();
        bytes.resize(start as usize, 0);
        (0..count).for_each(|_| bytes.extend(&stored));
        let reader =
            Reader::new(Cursor::new(&bytes), bytes.len() as u64).map_err(|trouble| trouble.to_string()).unwrap();
        let mut values = vec![0.0_f64; 1];
        let refused = reader.check_model(&mut |visit| visit("water.position", Column::growing(&mut values)));
        assert!(refused.unwrap_err().to_string().contains("of memory"));
    }

    proptest! {
        #[test]
        fn random_bytes_are_refused(bytes in proptest::collection::vec(any::<u8>(), 0..2000)) {
            prop_assert!(matches!(read(&bytes), Err(Trouble::Damaged(_))));
        }

        #[test]
        fn a_header_with_a_fitting_checksum_but_random_text_is_refused(
            lines in proptest::collection::vec("(column f64|block at|name) ?[0-9]{0,25}( [a-z0-9\"]{0,12}){0,9}", 1..9)
        ) {
            let text = format!("program 0\ncase \"case\"\nstep 1\ntime 0.5\n{}", lines.join("\n"));
            let start = format!("lateen checkpoint {FORMAT} header {:010} crc ", text.len());
            let crc = crc32fast::hash(format!("{start}{text}").as_bytes());
            let file = format!("{start}{crc:08x}\n{text}");
            prop_assert!(matches!(read(file.as_bytes()), Err(Trouble::Damaged(_))));
        }
    }
}
