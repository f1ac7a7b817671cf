//! Memory and processor time of this process as the system reports them.

use std::time::Duration;

/// Largest resident memory since the process began \[bytes\]; `None` where the system does not report it.
pub(crate) fn peak_memory() -> Option<u64> {
    status("VmHWM:")
}

/// Resident memory now \[bytes\]; `None` where the system does not report it.
pub(crate) fn resident_memory() -> Option<u64> {
    status("VmRSS:")
}

/// Processor time of all threads of the process so far; `None` where the system does not report it. A system call: half
/// a microsecond.
///
/// For milliseconds and more. Linux counts the time of other threads in lumps of milliseconds (measured on 6.18: over 5
/// us two busy threads seem to take 1.0 or 4.5 times the wall time, depending on how often it is read; 2.0 over a
/// second).
pub fn cpu_time() -> Option<Duration> {
    clocks::read(clocks::PROCESS)
}

/// Processor time of the calling thread so far, to the nanosecond; `None` where the system does not report it. A system
/// call: half a microsecond.
pub(crate) fn thread_cpu_time() -> Option<Duration> {
    clocks::read(clocks::THREAD)
}

#[cfg(unix)]
mod clocks {
    use std::time::Duration;

    use rustix::time::{ClockId, clock_gettime};

    pub(super) const PROCESS: ClockId = ClockId::ProcessCPUTime;
    pub(super) const THREAD: ClockId = ClockId::ThreadCPUTime;

    pub(super) fn read(clock: ClockId) -> Option<Duration> {
        let time = clock_gettime(clock);
        Some(Duration::new(u64::try_from(time.tv_sec).ok()?, u32::try_from(time.tv_nsec).ok()?))
    }
}

#[cfg(not(unix))]
mod clocks {
    use std::time::Duration;

    pub const PROCESS: () = ();
    pub const THREAD: () = ();

    pub fn read((): ()) -> Option<Duration> {
        None
    }
}

/// Value \[bytes\] of a line of `/proc/self/status`, which is in kB there.
fn status(name: &str) -> Option<u64> {
    let text = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|kilobytes| 1024 * kilobytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_peak_is_at_least_the_resident_memory() {
        let (Some(before), Some(_)) = (peak_memory(), resident_memory()) else {
            println!("skipped: this system does not report it");
            return;
        };
        let touched = std::hint::black_box(vec![1_u8; 64 << 20]);
        let (peak, resident) = (peak_memory().unwrap(), resident_memory().unwrap());
        assert!(peak >= resident && peak >= before && resident >= touched.len() as u64, "{peak} {resident} {before}");
    }

    #[test]
    fn work_takes_processor_time() {
        let Some(before) = cpu_time() else {
            println!("skipped: this system does not report it");
            return;
        };
        let begin = std::time::Instant::now();
        while begin.elapsed() < Duration::from_millis(20) {
            std::hint::black_box(begin);
        }
        // Other tests of the process may have worked, too; a busy machine may have given this one little.
        assert!(cpu_time().unwrap() > before && thread_cpu_time().unwrap() > Duration::ZERO);
    }

    #[test]
    fn sleep_takes_no_processor_time_of_the_thread() {
        let Some(begin) = thread_cpu_time() else { return };
        std::thread::sleep(Duration::from_millis(60));
        let slept = thread_cpu_time().unwrap() - begin;
        assert!(slept < Duration::from_millis(30), "{slept:?}");
        while thread_cpu_time().unwrap() - begin < Duration::from_millis(20) {
            std::hint::spin_loop();
        }
    }
}
