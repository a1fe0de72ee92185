//! The text header: contents, and a reader that checks everything.

use super::{ALIGNMENT, BLOCK, FORMAT};
use std::fmt::Write as _;
use std::str::SplitWhitespace;

/// Bytes of the first line, which says how long the header is.
pub(super) const FIRST_LINE: usize = "lateen checkpoint 3 header 0000000000 crc 00000000\n".len();
/// A compressed block is never longer than this.
const LONGEST_BLOCK: usize = BLOCK + BLOCK / 128 + 512;

/// Origin of a checkpoint.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Origin {
    /// Version of the program.
    pub program: String,
    /// Identifies the case.
    pub case: String,
    /// Steps taken.
    pub step: u64,
    /// Time [s].
    pub time: f64,
}

/// A column and where its blocks are.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ColumnEntry {
    pub name: String,
    pub kind: String,
    pub components: usize,
    pub bytes: u64,
    pub blocks: Vec<BlockEntry>,
}

/// A compressed block.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct BlockEntry {
    /// First byte in the file.
    pub at: u64,
    /// Bytes in the file.
    pub stored: usize,
    /// Bytes after decompression.
    pub raw: usize,
    /// Checksum of the stored bytes.
    pub crc: u32,
}

/// Everything that the header says.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Header {
    pub origin: Origin,
    pub columns: Vec<ColumnEntry>,
}

impl Header {
    /// The header as text, first line included. Its length depends on names and counts only, so that
    /// the places of blocks can be filled in later.
    pub fn encode(&self) -> String {
        let Origin { program, case, step, time } = &self.origin;
        let mut text = format!("program {program}\ncase {}\nstep {step}\ntime {time:?}\n", quoted(case));
        for ColumnEntry { name, kind, components, bytes, blocks } in &self.columns {
            let (count, name) = (blocks.len(), quoted(name));
            writeln!(text, "column {kind} components {components} bytes {bytes:020} blocks {count:08} name {name}")
                .expect("in memory");
            for BlockEntry { at, stored, raw, crc } in blocks {
                writeln!(text, "block at {at:020} stored {stored:08} raw {raw:08} crc {crc:08x}").expect("in memory");
            }
        }
        format!("{}{text}", first_line(FORMAT, &text))
    }

    /// The version of the program that wrote a header of any format.
    pub fn program(text: &str) -> Option<&str> {
        text.lines().next()?.strip_prefix("program ").map(str::trim)
    }

    /// Reads the header's text after the first line.
    pub fn parse(text: &str) -> Result<Self, String> {
        let mut lines = text.lines();
        let mut line = |label: &str| {
            let line = lines.next().unwrap_or_default();
            line.strip_prefix(label).map(str::trim).ok_or_else(|| format!("`{label}` expected, found `{line}`"))
        };
        let program = line("program")?.to_owned();
        let case = unquoted(line("case")?)?;
        let step = number(line("step")?)?;
        let time = number(line("time")?)?;
        let mut columns: Vec<ColumnEntry> = vec![];
        for line in lines {
            match (line.strip_prefix("column "), line.strip_prefix("block "), columns.last_mut()) {
                (Some(rest), _, _) => columns.push(ColumnEntry::parse(rest)?),
                (_, Some(rest), Some(column)) => column.blocks.push(BlockEntry::parse(rest)?),
                _ => return Err(format!("`column` or `block` expected, found `{line}`")),
            }
        }
        Ok(Self { origin: Origin { program, case, step, time }, columns })
    }

    /// Checks that blocks follow each other to the end of the file and add up to their columns.
    pub fn check_layout(&self, header_bytes: u64, file_bytes: u64) -> Result<(), String> {
        let mut end = header_bytes;
        for column in &self.columns {
            let mut raw = 0;
            for (b, block) in column.blocks.iter().enumerate() {
                let expected = if b == 0 { end.next_multiple_of(ALIGNMENT) } else { end };
                if block.at != expected || block.stored > LONGEST_BLOCK || block.raw > BLOCK {
                    return Err(format!("block {b} of `{}` is out of place", column.name));
                }
                raw += block.raw as u64;
                end = block.at + block.stored as u64;
            }
            if raw != column.bytes {
                return Err(format!("the blocks of `{}` hold {raw} bytes of {}", column.name, column.bytes));
            }
        }
        if end == file_bytes { Ok(()) } else { Err(format!("the file has {file_bytes} bytes, its header says {end}")) }
    }
}

impl ColumnEntry {
    /// A column with room for the places of its blocks.
    pub fn reserve(name: &str, kind: &str, components: usize, bytes: usize) -> Self {
        let blocks = vec![BlockEntry::default(); bytes.div_ceil(BLOCK)];
        Self { name: name.to_owned(), kind: kind.to_owned(), components, bytes: bytes as u64, blocks }
    }

    fn parse(line: &str) -> Result<Self, String> {
        let (numbers, name) = line.split_once(" name ").ok_or("column without name")?;
        let (kind, numbers) = numbers.split_once(' ').ok_or("column without kind")?;
        let mut words = numbers.split_whitespace();
        let components = labelled(&mut words, "components")?;
        let bytes = labelled(&mut words, "bytes")?;
        Ok(Self { name: unquoted(name)?, kind: kind.to_owned(), components, bytes, blocks: vec![] })
    }
}

impl BlockEntry {
    fn parse(line: &str) -> Result<Self, String> {
        let mut words = line.split_whitespace();
        let at = labelled(&mut words, "at")?;
        let stored = labelled(&mut words, "stored")?;
        let raw = labelled(&mut words, "raw")?;
        let crc = hexadecimal(word(&mut words, "crc")?)?;
        Ok(Self { at, stored, raw, crc })
    }
}

/// The first line over a header's text. Its checksum covers the line itself as well.
fn first_line(format: u32, text: &str) -> String {
    let start = format!("lateen checkpoint {format} header {:010} crc ", text.len());
    format!("{start}{:08x}\n", checksum(&start, text.as_bytes()))
}

fn checksum(start: &str, text: &[u8]) -> u32 {
    let mut crc = crc32fast::Hasher::new();
    crc.update(start.as_bytes());
    crc.update(text);
    crc.finalize()
}

/// The first line of a file: format, length and checksum of the rest of the header.
pub(super) struct FirstLine {
    /// Version of the format.
    pub format: u32,
    /// Bytes of the header after the first line.
    pub header_bytes: u64,
    start: String,
    crc: u32,
}

impl FirstLine {
    /// Reads the first line.
    pub fn parse(line: &[u8; FIRST_LINE]) -> Result<Self, String> {
        let line = std::str::from_utf8(line).ok().and_then(|line| line.strip_suffix('\n'));
        let (start, crc) = line.and_then(|line| line.split_at_checked(FIRST_LINE - 9)).ok_or("not a checkpoint")?;
        let mut words = start.split_whitespace();
        if words.next() != Some("lateen") {
            return Err("not a checkpoint".into());
        }
        let format = labelled(&mut words, "checkpoint")?;
        let header_bytes = labelled(&mut words, "header")?;
        Ok(Self { format, header_bytes, start: start.to_owned(), crc: hexadecimal(crc)? })
    }

    /// True if the checksum fits this line and the rest of the header.
    pub fn covers(&self, text: &[u8]) -> bool {
        checksum(&self.start, text) == self.crc
    }
}

/// Text in quotes, on one line whatever it holds.
fn quoted(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}

fn unquoted(text: &str) -> Result<String, String> {
    serde_json::from_str(text).map_err(|error| format!("`{text}`: {error}"))
}

fn word<'a>(words: &mut SplitWhitespace<'a>, label: &str) -> Result<&'a str, String> {
    match (words.next(), words.next()) {
        (Some(found), Some(value)) if found == label => Ok(value),
        _ => Err(format!("`{label}` expected")),
    }
}

fn labelled<T: std::str::FromStr>(words: &mut SplitWhitespace<'_>, label: &str) -> Result<T, String> {
    word(words, label).and_then(number)
}

fn number<T: std::str::FromStr>(text: &str) -> Result<T, String> {
    text.parse().map_err(|_| format!("`{text}` is not a number"))
}

/// Eight lower-case digits, as they are written: so that a changed byte can't mean the same.
fn hexadecimal(text: &str) -> Result<u32, String> {
    let number = u32::from_str_radix(text, 16).ok().filter(|number| format!("{number:08x}") == text);
    number.ok_or_else(|| format!("`{text}` is not a checksum"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_header_reads_back_with_awkward_names() {
        let origin = Origin { program: "0.1.0".into(), case: "a \"b\"".into(), step: 7, time: 0.1 + 0.2 };
        let mut column = ColumnEntry::reserve("wa\nter name \"x\".position", "f64", 3, BLOCK + 8);
        column.blocks[1] = BlockEntry { at: 1024, stored: 8, raw: 8, crc: 0xdead_beef };
        let header = Header { origin, columns: vec![column, ColumnEntry::reserve("", "u8", 1, 0)] };
        let text = header.encode();
        assert_eq!(Header::parse(&text[FIRST_LINE..]).unwrap(), header);
        let first = FirstLine::parse(text.as_bytes()[..FIRST_LINE].try_into().unwrap()).unwrap();
        assert_eq!(first.header_bytes as usize, text.len() - FIRST_LINE);
        assert!(first.covers(&text.as_bytes()[FIRST_LINE..]));
        assert!(!first.covers(&text.as_bytes()[FIRST_LINE + 1..]));
    }
}
