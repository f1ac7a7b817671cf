//! The machine, as far as measured times depend on it, and peak rates of one of its cores, with which the rates of
//! stages are compared.

use std::hint::black_box;
use std::time::Instant;

use pulp::{Arch, Simd, WithSimd};
use serde::{Deserialize, Serialize};

/// Independent chains of multiply-adds: more than latency times units of any processor, so that none waits.
const CHAINS: usize = 12;
/// Multiply-adds of a chain in a trial.
const LENGTH: usize = 50_000;
/// Doubles copied: 16 MB, more than the private caches of a core hold.
const COPIED: usize = 2 << 20;
/// Trials, of which the fastest counts.
const TRIALS: usize = 8;

/// Best rates of one core.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub struct MachinePeak {
    /// Independent fused multiply-adds with the vector width that the program uses \[flop/s\].
    pub flop_per_second: f64,
    /// Bytes read and written by copying 16 MB to other 16 MB: memory, or the cache that all cores share where that is
    /// large \[B/s\].
    pub bytes_per_second: f64,
}

impl MachinePeak {
    /// Measures both rates on the calling thread; takes some 20 ms.
    pub fn measure() -> Self {
        Self { flop_per_second: multiply_add_rate(), bytes_per_second: copy_rate() }
    }
}

/// Best of several trials of independent fused multiply-adds on one core \[flop/s\], two flops each.
pub fn multiply_add_rate() -> f64 {
    Arch::new().dispatch(MultiplyAdds)
}

struct MultiplyAdds;

impl WithSimd for MultiplyAdds {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let (factor, term) = (simd.splat_f64s(black_box(0.999_999)), simd.splat_f64s(black_box(1e-6)));
        let mut best = 0.0_f64;
        for _ in 0..TRIALS {
            let mut sums = [simd.splat_f64s(black_box(1.0)); CHAINS];
            let begin = Instant::now();
            for _ in 0..LENGTH {
                for sum in &mut sums {
                    *sum = simd.mul_add_e_f64s(*sum, factor, term);
                }
            }
            let seconds = begin.elapsed().as_secs_f64();
            black_box(sums.into_iter().fold(0.0, |total, sum| total + simd.reduce_sum_f64s(sum)));
            best = best.max((2 * CHAINS * LENGTH * S::F64_LANES) as f64 / seconds);
        }
        best
    }
}

/// Best rate of copying one array of 16 MB to another \[B/s, read and written\].
fn copy_rate() -> f64 {
    let (from, mut to) = (vec![1.0_f64; COPIED], vec![0.0_f64; COPIED]);
    let mut best = 0.0_f64;
    for _ in 0..TRIALS {
        let begin = Instant::now();
        to.copy_from_slice(black_box(&from));
        let seconds = begin.elapsed().as_secs_f64();
        black_box(&to);
        best = best.max((2 * size_of_val(from.as_slice())) as f64 / seconds);
    }
    best
}

/// The processor's model name as Linux reports it; `None` on other systems.
pub(crate) fn processor() -> Option<String> {
    let text = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let name = text.lines().find_map(|line| line.strip_prefix("model name"))?;
    Some(name.trim_start_matches([' ', '\t', ':']).trim().to_owned())
}

/// Instruction set for vectors on this processor: `x86-64-v4` (AVX-512), `x86-64-v3` (AVX2 and fused multiply-add), or
/// the architecture's name.
pub fn instruction_set() -> &'static str {
    // pulp has one type for each family, named alike on every architecture that has it.
    let arch = format!("{:?}", Arch::new());
    if arch.starts_with("V4") {
        "x86-64-v4"
    } else if arch.starts_with("V3") {
        "x86-64-v3"
    } else {
        std::env::consts::ARCH
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_core_is_between_a_slow_and_an_impossible_one() {
        let MachinePeak { flop_per_second, bytes_per_second } = MachinePeak::measure();
        println!("{:.1} Gflop/s, {:.1} GB/s", 1e-9 * flop_per_second, 1e-9 * bytes_per_second);
        assert!((1e7..1e13).contains(&flop_per_second), "{flop_per_second}");
        assert!((1e7..1e13).contains(&bytes_per_second), "{bytes_per_second}");
    }

    #[test]
    fn a_machine_has_a_name_and_instructions() {
        if cfg!(target_os = "linux") && cfg!(target_arch = "x86_64") {
            assert!(processor().is_some_and(|name| !name.is_empty() && !name.contains(':')));
        }
        assert!(!instruction_set().is_empty());
    }
}
