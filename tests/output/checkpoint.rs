//! Checkpoints: bit-exact restoration; killed writers, full disks, damaged files, other cases and versions.

use lateen::error::Error;
use lateen::math::{SymTensor, Vector};
use lateen::output::Checkpoints;
use lateen::simulation::{CheckpointStore, Column};
use std::fs;
use std::path::{Path, PathBuf};

/// A state with every kind of column, an empty one, and one of several blocks.
#[derive(Debug, Clone, PartialEq, Default)]
struct State {
    position: Vec<Vector<3>>,
    stress: Vec<SymTensor>,
    id: Vec<u32>,
    counter: Vec<u64>,
    flags: Vec<u8>,
    empty: Vec<f64>,
}

impl State {
    fn new(count: usize, seed: f64) -> Self {
        let wave = |n: usize| (n as f64 * 0.731 + seed).sin();
        let mut position: Vec<_> = (0..count).map(|p| Vector([wave(p), wave(p + 1), wave(p + 2)])).collect();
        position[0] = Vector([f64::NAN, -0.0, f64::MIN_POSITIVE / 8.0]);
        Self {
            position,
            stress: vec![bytemuck::cast([wave(1), wave(2), wave(3), wave(4), wave(5), wave(6)])],
            id: (0..count as u32).rev().collect(),
            counter: vec![u64::MAX, count as u64],
            flags: vec![1, 2, 3],
            empty: vec![],
        }
    }

    fn columns(&mut self, visit: &mut dyn FnMut(&str, Column<'_>)) {
        visit("water.position", Column::growing(&mut self.position));
        visit("water.stress", Column::growing(&mut self.stress));
        visit("water.id", Column::growing(&mut self.id));
        visit("counter", Column::growing(&mut self.counter));
        visit("flags", Column::growing(&mut self.flags));
        visit("empty", Column::growing(&mut self.empty));
    }

    fn save(&mut self, store: &mut Checkpoints, step: u64) -> PathBuf {
        store.save(step, 0.1 * step as f64, &mut |visit| self.columns(visit)).unwrap()
    }

    fn restore(store: &mut Checkpoints) -> Result<Option<Self>, Error> {
        let mut state = Self { empty: vec![1.0; 9], ..Self::default() };
        Ok(store.restore(&mut |visit| state.columns(visit))?.map(|_| state))
    }

    /// Bits, so that NaN and −0 count.
    fn bits(&self) -> Vec<u8> {
        let mut bytes = vec![];
        self.clone().columns(&mut |name, column| {
            bytes.extend(name.bytes().chain(column.data.bytes().iter().copied()));
        });
        bytes
    }
}

fn store(directory: &Path) -> Checkpoints {
    Checkpoints::new(directory, "case-1")
}

#[test]
fn a_restored_state_is_the_same_bit_for_bit() {
    let dir = tempfile::tempdir().unwrap();
    for (step, count) in [(1, 3), (2, 150_000)] {
        let mut state = State::new(count, 0.5);
        state.save(&mut store(dir.path()), step);
        let restored = State::restore(&mut store(dir.path())).unwrap().unwrap();
        assert_eq!(restored.bits(), state.bits());
    }
}

#[test]
fn files_do_not_depend_on_the_number_of_threads() {
    let write = |threads: usize| {
        let dir = tempfile::tempdir().unwrap();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| fs::read(State::new(150_000, 0.5).save(&mut store(dir.path()), 1)).unwrap())
    };
    assert!(write(1) == write(4));
}

#[test]
fn columns_start_at_multiples_of_64_bytes() {
    let dir = tempfile::tempdir().unwrap();
    let bytes = fs::read(State::new(1000, 0.5).save(&mut store(dir.path()), 1)).unwrap();
    // The first block after the line of each column; an empty one has none.
    let header = String::from_utf8_lossy(&bytes);
    let columns = header.split("\ncolumn ").skip(1);
    let first = columns.filter_map(|column| column.split("\nblock at ").nth(1)?[..20].parse::<u64>().ok());
    let places: Vec<u64> = first.collect();
    assert_eq!(places.len(), 5);
    assert!(places.iter().all(|place| place % 64 == 0), "{places:?}");
}

#[test]
fn two_generations_are_kept() {
    let dir = tempfile::tempdir().unwrap();
    let mut store = store(dir.path());
    for step in 1..=5 {
        State::new(10, step as f64).save(&mut store, step);
    }
    assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 2);
    assert_eq!(State::restore(&mut store).unwrap().unwrap().bits(), State::new(10, 5.0).bits());
}

#[test]
fn a_folder_without_checkpoints_restores_nothing() {
    let dir = tempfile::tempdir().unwrap();
    assert!(State::restore(&mut store(&dir.path().join("not made yet"))).unwrap().is_none());
}

#[test]
fn a_damaged_newest_checkpoint_is_skipped_with_a_message() {
    let dir = tempfile::tempdir().unwrap();
    let mut store = store(dir.path());
    State::new(1000, 1.0).save(&mut store, 1);
    let newest = State::new(1000, 2.0).save(&mut store, 2);
    let whole = fs::read(&newest).unwrap();
    for place in (0..whole.len()).step_by(whole.len() / 97) {
        let mut changed = whole.clone();
        changed[place] ^= 0x10;
        fs::write(&newest, &changed).unwrap();
        let restored = State::restore(&mut store).unwrap().unwrap();
        assert_eq!(restored.bits(), State::new(1000, 1.0).bits(), "byte {place}");
        assert!(store.skipped()[0].contains("step-000000000002"), "{:?}", store.skipped());
    }
}

#[test]
fn a_damaged_checkpoint_is_not_counted_as_a_generation() {
    let dir = tempfile::tempdir().unwrap();
    let mut store = store(dir.path());
    State::new(10, 1.0).save(&mut store, 1);
    fs::write(State::new(10, 9.0).save(&mut store, 9), b"torn").unwrap();
    State::restore(&mut store).unwrap().unwrap();
    let second = State::new(10, 2.0).save(&mut store, 2);
    fs::write(second, b"torn as well").unwrap();
    assert_eq!(State::restore(&mut store).unwrap().unwrap().bits(), State::new(10, 1.0).bits());
}

#[test]
fn an_error_names_all_checkpoints_when_all_are_damaged() {
    let dir = tempfile::tempdir().unwrap();
    let mut store = store(dir.path());
    for step in 1..=2 {
        fs::write(State::new(10, 0.0).save(&mut store, step), b"lateen checkpoint").unwrap();
    }
    let error = State::restore(&mut store).unwrap_err();
    assert_eq!(error.exit_code(), 4);
    let text = error.to_string();
    assert!(text.contains("step-000000000001") && text.contains("step-000000000002"), "{text}");
}

#[test]
fn a_partial_file_of_a_killed_writer_is_ignored() {
    let dir = tempfile::tempdir().unwrap();
    let mut store = store(dir.path());
    let path = State::new(10, 1.0).save(&mut store, 1);
    // A killed writer leaves a temporary file, complete or not, that was never renamed.
    let whole = fs::read(&path).unwrap();
    fs::write(dir.path().join("step-000000000002.checkpoint.partial"), &whole[..whole.len() / 2]).unwrap();
    assert_eq!(State::restore(&mut store).unwrap().unwrap().bits(), State::new(10, 1.0).bits());
    assert!(store.skipped().is_empty());
}

#[cfg(unix)]
#[test]
fn a_failed_save_keeps_older_checkpoints() {
    let dir = tempfile::tempdir().unwrap();
    let mut store = store(dir.path());
    State::new(10, 1.0).save(&mut store, 1);
    // A disk that takes no more bytes: the temporary file is a link to /dev/full.
    let temporary = dir.path().join("step-000000000002.checkpoint.partial");
    if !Path::new("/dev/full").exists() {
        return;
    }
    std::os::unix::fs::symlink("/dev/full", temporary).unwrap();
    let mut state = State::new(1000, 2.0);
    let error = store.save(2, 0.2, &mut |visit| state.columns(visit)).unwrap_err();
    assert!(matches!(error, Error::Io { .. }), "{error}");
    assert_eq!(State::restore(&mut store).unwrap().unwrap().bits(), State::new(10, 1.0).bits());
}

#[test]
fn a_checkpoint_of_another_case_is_an_error() {
    let dir = tempfile::tempdir().unwrap();
    State::new(10, 1.0).save(&mut store(dir.path()), 1);
    let error = State::restore(&mut Checkpoints::new(dir.path(), "case-2")).unwrap_err();
    assert!(error.to_string().contains("another case"), "{error}");
}

/// Replaces the byte that follows `before` in the header of a checkpoint, with a fitting checksum.
fn replace_in_header(path: &Path, before: &str, byte: u8) {
    let mut bytes = fs::read(path).unwrap();
    let at = bytes.windows(before.len()).position(|window| window == before.as_bytes()).unwrap();
    bytes[at + before.len()] = byte;
    // Over the first line up to it, and the rest of the header.
    let line = bytes.iter().position(|&byte| byte == b'\n').unwrap();
    let length: usize = std::str::from_utf8(&bytes[27..37]).unwrap().parse().unwrap();
    let crc = crc32fast::hash(&[&bytes[..line - 8], &bytes[line + 1..line + 1 + length]].concat());
    bytes[line - 8..line].copy_from_slice(format!("{crc:08x}").as_bytes());
    fs::write(path, bytes).unwrap();
}

#[test]
fn a_checkpoint_of_another_version_is_an_error_that_names_it() {
    let dir = tempfile::tempdir().unwrap();
    let path = State::new(10, 1.0).save(&mut store(dir.path()), 1);
    replace_in_header(&path, "program ", b'9');
    let (error, version) = (State::restore(&mut store(dir.path())).unwrap_err().to_string(), env!("CARGO_PKG_VERSION"));
    assert!(error.contains("written by lateen 9") && error.contains(&format!("this is lateen {version}")), "{error}");
    assert!(error.contains("resume with the program that wrote it, or begin anew"), "{error}");
}

/// Builds of one version may write different formats: both are named, and the version that wrote it.
#[test]
fn a_checkpoint_of_another_format_is_an_error_that_names_both() {
    let dir = tempfile::tempdir().unwrap();
    let path = State::new(10, 1.0).save(&mut store(dir.path()), 1);
    replace_in_header(&path, "lateen checkpoint ", b'1');
    let (error, version) = (State::restore(&mut store(dir.path())).unwrap_err().to_string(), env!("CARGO_PKG_VERSION"));
    assert!(error.contains(&format!("written by lateen {version} in format 1;")), "{error}");
    assert!(error.contains(&format!("this is lateen {version}, which reads format ")), "{error}");
    assert!(error.contains("resume with the program that wrote it, or begin anew"), "{error}");
    assert!(path.is_file(), "it is kept for the program that can read it");
}

#[test]
fn a_model_with_other_columns_is_an_error_that_names_one() {
    let dir = tempfile::tempdir().unwrap();
    State::new(10, 1.0).save(&mut store(dir.path()), 1);
    let (mut energy, mut state) = (vec![0.0_f64; 3], State::default());
    let error = store(dir.path())
        .restore(&mut |visit| {
            state.columns(visit);
            visit("water.energy", Column::new(&mut energy));
        })
        .unwrap_err();
    assert!(error.to_string().contains("water.energy") && error.to_string().contains("another build"), "{error}");
    assert_eq!((energy, state), (vec![0.0; 3], State::default()), "nothing was replaced");
}

/// The sizes of columns that the model fixes are compared before any column is read.
#[test]
fn a_column_of_another_size_is_an_error_that_names_it() {
    let dir = tempfile::tempdir().unwrap();
    store(dir.path()).save(1, 0.1, &mut |visit| visit("nodes", Column::new(&mut vec![1.0_f64; 10]))).unwrap();
    let restored = |count: usize| {
        let mut nodes = vec![0.0_f64; count];
        store(dir.path()).restore(&mut |visit| visit("nodes", Column::new(&mut nodes))).map(|_| nodes)
    };
    assert_eq!(restored(10).unwrap(), [1.0; 10]);
    for count in [0, 9, 11] {
        let error = restored(count).unwrap_err().to_string();
        assert!(error.contains("`nodes` of 80 bytes"), "{error}");
    }
}

/// A record is read from its own column and from an array of the same numbers, however these are grouped.
#[test]
fn a_record_is_restored_from_as_many_numbers_of_its_type() {
    let dir = tempfile::tempdir().unwrap();
    let restored = || {
        let mut works = [0.0_f64; 4];
        store(dir.path()).restore(&mut |visit| visit("works", Column::record(&mut works))).map(|_| works)
    };
    let mut numbers = [1.0_f64, 2.0, 3.0, 4.0];
    let mut packed = numbers.to_vec();
    store(dir.path()).save(1, 0.1, &mut |visit| visit("works", Column::new(&mut packed))).unwrap();
    assert_eq!(restored().unwrap(), numbers);
    store(dir.path()).save(2, 0.1, &mut |visit| visit("works", Column::record(&mut numbers))).unwrap();
    assert_eq!(restored().unwrap(), numbers);
    packed.pop();
    store(dir.path()).save(3, 0.1, &mut |visit| visit("works", Column::new(&mut packed))).unwrap();
    let error = restored().unwrap_err().to_string();
    assert!(error.contains("`works` of 24 bytes"), "{error}");
    store(dir.path()).save(4, 0.1, &mut |visit| visit("works", Column::scalar(&mut 0_u64))).unwrap();
    let error = restored().unwrap_err().to_string();
    assert!(error.contains("of the kind that this model needs"), "{error}");
}
