//! Memory of this process as the system sees it.

/// Largest resident memory since the process began \[bytes\]; `None` where the system does not tell.
pub fn peak_memory() -> Option<u64> {
    status("VmHWM:")
}

/// Resident memory now \[bytes\]; `None` where the system does not tell.
pub fn resident_memory() -> Option<u64> {
    status("VmRSS:")
}

/// A line of Linux' account of the process, in kB there.
fn status(name: &str) -> Option<u64> {
    let text = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|kilobytes| 1024 * kilobytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_peak_is_not_below_what_is_resident_and_knows_what_was_touched() {
        let (Some(before), Some(_)) = (peak_memory(), resident_memory()) else {
            println!("skipped: this system does not tell");
            return;
        };
        let touched = std::hint::black_box(vec![1_u8; 64 << 20]);
        let (peak, resident) = (peak_memory().unwrap(), resident_memory().unwrap());
        assert!(peak >= resident && peak >= before && resident >= touched.len() as u64, "{peak} {resident} {before}");
    }
}
