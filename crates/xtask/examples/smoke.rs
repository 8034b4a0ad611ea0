//! Runs each fuzz target on so many inputs, as the test of xtask does; what `cargo xtask plant` asks about each mistake.

use feeler_fuzz::{TARGETS, smoke};
use std::time::Instant;

fn main() {
    let wanted = std::env::args().nth(1).and_then(|n| n.parse().ok());
    let mut failed = false;
    for target in &TARGETS {
        let begun = Instant::now();
        let done = smoke(target, 1, wanted.unwrap_or(100));
        failed |= done.is_err();
        println!(
            "{}: {done:?}, {:.1} s",
            target.name,
            begun.elapsed().as_secs_f64()
        );
    }
    std::process::exit(i32::from(failed));
}
