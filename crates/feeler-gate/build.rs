//! Tells the program which compiler made it, for reports.

use std::process::Command;

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let version = Command::new(rustc).arg("--version").output();
    let text = version.map(|o| String::from_utf8_lossy(&o.stdout).trim().to_owned());
    let text = text.unwrap_or_else(|_| "unknown".to_owned());
    println!("cargo:rustc-env=FEELER_COMPILER={text}");
}
