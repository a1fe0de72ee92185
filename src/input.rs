//! Files that are named from outside: only ordinary ones are read, and only as far as the memory goes.
//!
//! A pipe that nobody writes into would be waited for, and a device such as `/dev/zero` has no end.

use crate::memory;
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;

/// The bytes of an ordinary file.
///
/// # Errors
/// Input/output errors; something that is no ordinary file, or is longer than the free memory.
pub fn read(path: &Path) -> io::Result<Vec<u8>> {
    let length = length(path)?;
    if let Some(refusal) = memory::refusal(length as f64) {
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, format!("reading it would take {refusal}")));
    }
    fs::read(path)
}

/// The text of an ordinary file.
///
/// # Errors
/// As [`read`]; bytes that are not UTF-8.
pub fn text(path: &Path) -> io::Result<String> {
    let no_text = |_| io::Error::new(io::ErrorKind::InvalidData, "this is not UTF-8 text");
    String::from_utf8(read(path)?).map_err(no_text)
}

/// The bytes of anything that can be read, a pipe included, where it ends before `most` [bytes]; else `None`.
///
/// # Errors
/// Input/output errors.
pub fn read_up_to(path: &Path, most: u64) -> io::Result<Option<Vec<u8>>> {
    let mut bytes = Vec::new();
    File::open(path)?.take(most + 1).read_to_end(&mut bytes)?;
    Ok((bytes.len() as u64 <= most).then_some(bytes))
}

/// The length of an ordinary file [bytes].
///
/// # Errors
/// Input/output errors; something that is no ordinary file.
pub fn length(path: &Path) -> io::Result<u64> {
    let data = fs::metadata(path)?;
    match (data.is_file(), data.is_dir()) {
        (true, _) => Ok(data.len()),
        (_, true) => Err(io::Error::new(io::ErrorKind::IsADirectory, "this is a directory")),
        _ => Err(io::Error::new(io::ErrorKind::InvalidInput, "this is no ordinary file, but a pipe or a device")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_ordinary_file_is_read() {
        let home = tempfile::tempdir().unwrap();
        let path = home.path().join("a");
        fs::write(&path, "text").unwrap();
        assert_eq!((read(&path).unwrap(), text(&path).unwrap()), (b"text".to_vec(), "text".to_owned()));
        assert_eq!(read_up_to(&path, 4).unwrap(), Some(b"text".to_vec()));
        assert_eq!(read_up_to(&path, 3).unwrap(), None);
        fs::write(&path, [0xff]).unwrap();
        assert!(text(&path).unwrap_err().to_string().contains("UTF-8"));
        assert_eq!(read(home.path()).unwrap_err().kind(), io::ErrorKind::IsADirectory);
    }

    #[test]
    #[cfg(unix)]
    fn endless_input_is_refused() {
        let zero = Path::new("/dev/zero");
        assert!(read(zero).unwrap_err().to_string().contains("device"));
        assert_eq!(read_up_to(zero, 1000).unwrap(), None);
    }

    /// A sparse file takes no room on the disk, and would take all of the memory.
    #[test]
    fn input_longer_than_the_memory_is_refused() {
        let file = tempfile::NamedTempFile::new().unwrap();
        if memory::free().is_some() && file.as_file().set_len(1 << 43).is_ok() {
            assert!(read(file.path()).unwrap_err().to_string().contains("memory"));
        }
    }
}
