//! Runs each fuzz target on so many inputs, as the test of xtask does, up to the first finding; what `cargo xtask plant` asks about each mistake.

use feeler_fuzz::{TARGETS, smoke};
use std::time::Instant;

fn main() {
    let wanted = std::env::args().nth(1).and_then(|n| n.parse().ok());
    for target in &TARGETS {
        let begun = Instant::now();
        let done = smoke(target, 1, wanted.unwrap_or(100));
        println!(
            "{}: {done:?}, {:.1} s",
            target.name,
            begun.elapsed().as_secs_f64()
        );
        if done.is_err() {
            std::process::exit(1);
        }
    }
}
