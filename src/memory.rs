//! Memory that the machine has left, so that a model that can't fit is refused before it is built.
//!
//! Without this, a spacing that is too small by a factor of ten, in three dimensions, ends with an allocation that
//! fails or with the operating system killing the program: neither says which key to change.

use std::fs::read_to_string;
use std::path::Path;

/// Bytes of memory that this process can have without swapping: those left on the machine, or less if the group of the
/// process (a container, a job of a batch system) or the process itself (`ulimit -v`) may not take so much; `None`
/// where the system doesn't say (it does on Linux).
pub fn free() -> Option<f64> {
    let machine = kilobytes(&read_to_string("/proc/meminfo").ok()?, "MemAvailable:");
    [machine, of_group(), of_process()].into_iter().flatten().reduce(f64::min)
}

/// Memory left by the limit of address space.
fn of_process() -> Option<f64> {
    let limits = read_to_string("/proc/self/limits").ok()?;
    let taken = kilobytes(&read_to_string("/proc/self/status").ok()?, "VmSize:")?;
    Some((address_space(&limits)? - taken).max(0.0))
}

/// The line `Max address space  8000000000  unlimited  bytes`; `None` if there is no limit.
fn address_space(limits: &str) -> Option<f64> {
    limits.lines().find_map(|line| line.strip_prefix("Max address space"))?.split_whitespace().next()?.parse().ok()
}

/// Memory left by the limits of the control group and of those above it.
fn of_group() -> Option<f64> {
    let groups = read_to_string("/proc/self/cgroup").ok()?;
    let within = |root: &str, path: &str, [limit, taken]: [&str; 2]| {
        let folder = Path::new(root).join(path.trim_start_matches('/'));
        let above = folder.ancestors().take_while(|folder| folder.starts_with(root));
        above.filter_map(|folder| left(folder, limit, taken)).reduce(f64::min)
    };
    let found = groups.lines().filter_map(|line| {
        let (hierarchy, path) = line.split_once(':')?.1.split_once(':')?;
        match hierarchy {
            "" => within("/sys/fs/cgroup", path, ["memory.max", "memory.current"]),
            "memory" => within("/sys/fs/cgroup/memory", path, ["memory.limit_in_bytes", "memory.usage_in_bytes"]),
            _ => None,
        }
    });
    found.reduce(f64::min)
}

/// Memory left in one group: its limit less the memory that is taken and can't be given back, as the cache of files
/// can.
fn left(group: &Path, limit: &str, taken: &str) -> Option<f64> {
    let number = |file: &str| read_to_string(group.join(file)).ok()?.trim().parse::<f64>().ok();
    let cache = read_to_string(group.join("memory.stat")).unwrap_or_default();
    let cache = cache.lines().find_map(|line| line.strip_prefix("inactive_file ")?.trim().parse().ok()).unwrap_or(0.0);
    Some((number(limit)? - (number(taken)? - cache)).max(0.0))
}

/// Why `bytes` can't be had; `None` if they can, or if nothing is known.
pub fn refusal(bytes: f64) -> Option<String> {
    let free = free()?;
    let gigabytes = |bytes: f64| format!("{:.1} GB", bytes / 1e9);
    (bytes > free).then(|| format!("at least {} of memory, and {} are free", gigabytes(bytes), gigabytes(free)))
}

/// A line such as `MemAvailable: 1234 kB`, in bytes.
fn kilobytes(text: &str, name: &str) -> Option<f64> {
    let rest = text.lines().find_map(|line| line.strip_prefix(name))?;
    let kilobytes: f64 = rest.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(1024.0 * kilobytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_that_linux_reports_is_read() {
        let available = |text| kilobytes(text, "MemAvailable:");
        assert_eq!(available("MemTotal: 9 kB\nMemAvailable:   24000000 kB\n"), Some(1024.0 * 24e6));
        assert_eq!(available("MemTotal: 9 kB\n"), None);
        let limits =
            |soft| format!("Max stack size   8388608  unlimited bytes\nMax address space  {soft}  unlimited  bytes\n");
        assert_eq!(address_space(&limits("8000000000")), Some(8e9));
        assert_eq!(address_space(&limits("unlimited")), None);
    }

    #[test]
    fn memory_left_of_a_control_group_includes_the_file_cache() {
        let group = tempfile::tempdir().unwrap();
        let write = |file: &str, text: &str| std::fs::write(group.path().join(file), text).unwrap();
        let left = || left(group.path(), "memory.max", "memory.current");
        assert_eq!(left(), None);
        write("memory.current", "3000000\n");
        write("memory.max", "max\n");
        assert_eq!(left(), None);
        write("memory.max", "4000000\n");
        assert_eq!(left(), Some(1e6));
        write("memory.stat", "anon 2000000\ninactive_file 500000\n");
        assert_eq!(left(), Some(1.5e6));
    }

    #[test]
    fn an_exabyte_is_refused_and_a_byte_is_not() {
        assert_eq!(refusal(1.0), None);
        if free().is_some() {
            assert!(refusal(1e18).is_some_and(|text| text.contains("1000000000.0 GB")));
        }
    }
}
