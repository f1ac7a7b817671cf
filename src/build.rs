//! Passes the compiler's version and the optimisation level to the program, which stamps performance records with them.

use std::process::Command;

fn main() {
    let compiler = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let version = Command::new(compiler).arg("--version").output().ok();
    let version = version.and_then(|output| String::from_utf8(output.stdout).ok()).unwrap_or_default();
    println!("cargo:rustc-env=TYREWAVE_COMPILER={}", version.trim());
    println!("cargo:rustc-env=TYREWAVE_OPTIMISATION={}", std::env::var("OPT_LEVEL").unwrap_or_default());
    println!("cargo:rerun-if-changed=src/build.rs");
}
