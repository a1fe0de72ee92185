//! Reading numbers from text or bytes, with the place kept for messages.

use std::fmt;

/// An error in a file, with its place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct GmshError {
    /// The problem, and advice.
    pub message: String,
    /// Its place.
    pub place: FilePlace,
}

/// A place in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FilePlace {
    /// The file as a whole.
    File,
    /// A line, counted from 1.
    Line(usize),
    /// A byte of a binary file, counted from 0.
    Byte(usize),
}

impl fmt::Display for GmshError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.place {
            FilePlace::File => write!(f, "{}", self.message),
            FilePlace::Line(line) => write!(f, "line {line}: {}", self.message),
            FilePlace::Byte(byte) => write!(f, "byte {byte}: {}", self.message),
        }
    }
}

impl std::error::Error for GmshError {}

/// A place in the bytes of a file, and how numbers are written from there on.
pub(super) struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
    /// Binary numbers instead of words.
    binary: bool,
    /// Binary numbers have their highest byte first.
    big_endian: bool,
}

impl<'a> Cursor<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0, binary: false, big_endian: false }
    }

    pub fn is_binary(&self) -> bool {
        self.binary
    }

    pub fn fail<T>(&self, message: impl Into<String>) -> Result<T, GmshError> {
        let at = self.at.min(self.bytes.len());
        let place = if self.binary {
            FilePlace::Byte(at)
        } else {
            FilePlace::Line(1 + self.bytes[..at].iter().filter(|&&b| b == b'\n').count())
        };
        Err(GmshError { message: message.into(), place })
    }

    fn rest(&self) -> &'a [u8] {
        &self.bytes[self.at..]
    }

    fn skip_blank(&mut self) {
        self.at += self.rest().iter().take_while(|b| b.is_ascii_whitespace()).count();
    }

    /// The rest of the line, without its end.
    fn line(&mut self) -> &'a [u8] {
        let rest = self.rest();
        let length = rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
        self.at += (length + 1).min(rest.len());
        rest[..length].trim_ascii_end()
    }

    /// The name of the next section, or `None` at the end of the file. What follows is its content.
    pub fn section(&mut self) -> Result<Option<String>, GmshError> {
        self.skip_blank();
        if self.rest().is_empty() {
            return Ok(None);
        }
        if self.rest()[0] != b'$' {
            return self.fail("expected the beginning of a section, such as $Nodes");
        }
        let name = &self.line()[1..];
        Ok(Some(String::from_utf8_lossy(name).into_owned()))
    }

    /// Goes behind `$End<name>`.
    pub fn skip_section(&mut self, name: &str) -> Result<(), GmshError> {
        let end = format!("$End{name}");
        let Some(length) = self.rest().windows(end.len()).position(|window| window == end.as_bytes()) else {
            return self.fail(format!("the section ${name} has no end: the file is cut off"));
        };
        self.at += length + end.len();
        Ok(())
    }

    /// A word that must come next.
    pub fn expect(&mut self, word: &str) -> Result<(), GmshError> {
        self.skip_blank();
        if !self.rest().starts_with(word.as_bytes()) {
            return self.fail(format!("expected {word}"));
        }
        self.at += word.len();
        Ok(())
    }

    /// The next word of text.
    pub fn word(&mut self) -> Result<&'a str, GmshError> {
        self.skip_blank();
        let rest = self.rest();
        let length = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        if length == 0 {
            return self.fail("the file ends too early");
        }
        match std::str::from_utf8(&rest[..length]) {
            Ok(word) => {
                self.at += length;
                Ok(word)
            }
            Err(_) => self.fail("expected text"),
        }
    }

    fn parsed<T: std::str::FromStr>(&mut self, what: &str) -> Result<T, GmshError> {
        let before = self.at;
        let word = self.word()?;
        word.parse().or_else(|_| {
            self.at = before;
            self.skip_blank();
            let shown: String = word.chars().take(40).collect();
            self.fail(format!("expected {what}, found `{shown}`"))
        })
    }

    /// A whole number that is text even in binary files.
    pub fn text_integer(&mut self) -> Result<i64, GmshError> {
        self.parsed("a whole number")
    }

    /// A text in double quotes.
    pub fn quoted(&mut self) -> Result<String, GmshError> {
        self.skip_blank();
        let text = self.rest().strip_prefix(b"\"");
        let Some((text, length)) = text.and_then(|t| t.iter().position(|&b| b == b'"').map(|n| (t, n))) else {
            return self.fail("expected a name in double quotes");
        };
        self.at += length + 2;
        Ok(String::from_utf8_lossy(&text[..length]).into_owned())
    }

    /// Ends the line of text; what follows is binary, beginning with the number 1 that shows the byte order.
    pub fn begin_binary(&mut self) -> Result<(), GmshError> {
        self.line();
        self.binary = true;
        let one = self.take::<4>()?;
        self.big_endian = one == 1i32.to_be_bytes();
        if !self.big_endian && one != 1i32.to_le_bytes() {
            return self.fail("the mark of the byte order is neither order's");
        }
        Ok(())
    }

    /// Ends a line of text before binary numbers.
    pub fn end_line(&mut self) {
        if self.binary {
            self.line();
        }
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N], GmshError> {
        match self.rest().first_chunk::<N>() {
            Some(chunk) => {
                self.at += N;
                let mut chunk = *chunk;
                if self.big_endian {
                    chunk.reverse();
                }
                Ok(chunk)
            }
            None => self.fail("the file ends too early"),
        }
    }

    /// A whole number; 4 bytes in binary.
    pub fn integer(&mut self) -> Result<i64, GmshError> {
        if self.binary { Ok(i64::from(i32::from_le_bytes(self.take()?))) } else { self.text_integer() }
    }

    /// A whole number that may be large; 8 bytes in binary.
    pub fn long(&mut self) -> Result<i64, GmshError> {
        if self.binary { Ok(i64::from_le_bytes(self.take()?)) } else { self.text_integer() }
    }

    /// A real number; 8 bytes in binary.
    pub fn real(&mut self) -> Result<f64, GmshError> {
        if self.binary { Ok(f64::from_le_bytes(self.take()?)) } else { self.parsed("a number") }
    }

    /// Three real numbers.
    pub fn position(&mut self) -> Result<[f64; 3], GmshError> {
        Ok([self.real()?, self.real()?, self.real()?])
    }

    /// A count of entries of at least `least` bytes each, checked against the rest of the file.
    pub fn checked_count(&self, count: i64, least: usize) -> Result<usize, GmshError> {
        let left = self.rest().len();
        match usize::try_from(count) {
            Ok(count) if count <= left / least => Ok(count),
            Ok(_) => {
                self.fail(format!("{count} entries are promised, but only {left} bytes are left: the file is cut off"))
            }
            Err(_) => self.fail(format!("a count can't be {count}")),
        }
    }

    /// As [`Cursor::checked_count`], with the sizes of an entry in text and in binary.
    pub fn count(&self, count: i64, text: usize, binary: usize) -> Result<usize, GmshError> {
        self.checked_count(count, if self.binary { binary } else { text })
    }
}
