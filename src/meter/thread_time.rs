//! Processor time of the calling thread.

use std::time::Duration;

/// Time that this thread has had a processor; `None` where the system does not tell.
#[cfg(unix)]
pub fn thread_time() -> Option<Duration> {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    Some(Duration::new(u64::try_from(time.tv_sec).ok()?, u32::try_from(time.tv_nsec).ok()?))
}

/// Time that this thread has had a processor; `None` where the system does not tell.
#[cfg(not(unix))]
pub fn thread_time() -> Option<Duration> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_takes_processor_time_and_sleep_does_not() {
        let Some(begin) = thread_time() else { return };
        std::thread::sleep(Duration::from_millis(60));
        let slept = thread_time().unwrap() - begin;
        assert!(slept < Duration::from_millis(30), "{slept:?}");
        while thread_time().unwrap() - begin < Duration::from_millis(20) {
            std::hint::spin_loop();
        }
    }
}
