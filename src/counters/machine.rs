//! The machine, as far as measured times depend on it.

use pulp::Arch;

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
    fn a_machine_has_a_name_and_instructions() {
        if cfg!(target_os = "linux") && cfg!(target_arch = "x86_64") {
            assert!(processor().is_some_and(|name| !name.is_empty() && !name.contains(':')));
        }
        assert!(!instruction_set().is_empty());
    }
}
