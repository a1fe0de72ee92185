//! What the machine has left, so that what can't fit is refused before it is tried.
//!
//! Without this, a spacing that is too small by a factor of ten, in three dimensions, ends with an allocation that fails or
//! with the operating system killing the program: neither says which key to change.

/// Bytes of memory that can be had without swapping; `None` where the system doesn't say (it does on Linux).
pub fn free() -> Option<f64> {
    available(&std::fs::read_to_string("/proc/meminfo").ok()?)
}

/// Why `bytes` can't be had; `None` if they can, or if nothing is known.
pub fn refusal(bytes: f64) -> Option<String> {
    let free = free()?;
    let gigabytes = |bytes: f64| format!("{:.1} GB", bytes / 1e9);
    (bytes > free).then(|| format!("at least {} of memory, and {} are free", gigabytes(bytes), gigabytes(free)))
}

/// The line `MemAvailable: 1234 kB` of Linux.
fn available(text: &str) -> Option<f64> {
    let rest = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kilobytes: f64 = rest.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(1024.0 * kilobytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_linux_says_is_read() {
        assert_eq!(available("MemTotal: 9 kB\nMemAvailable:   24000000 kB\n"), Some(1024.0 * 24e6));
        assert_eq!(available("MemTotal: 9 kB\n"), None);
    }

    #[test]
    fn an_exabyte_is_refused_and_a_byte_is_not() {
        assert_eq!(refusal(1.0), None);
        if free().is_some() {
            assert!(refusal(1e18).is_some_and(|text| text.contains("1000000000.0 GB")));
        }
    }
}
