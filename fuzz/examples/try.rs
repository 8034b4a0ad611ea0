//! `cargo run --release --no-default-features --example try -- TARGET COUNT [SEED]`: inputs without an engine, with times.
//! `... -- TARGET FILE`: one input, told as a scene.

use feeler_fuzz::{Outcome, Scene, input, target};
use std::time::Instant;

fn main() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [name, what, rest @ ..] = &args[..] else {
        eprintln!("usage: try TARGET (COUNT [SEED] | FILE)");
        std::process::exit(2);
    };
    let Some(target) = target(name) else {
        eprintln!("no target {name}");
        std::process::exit(2);
    };
    let Ok(count) = what.parse::<u64>() else {
        let bytes = std::fs::read(what).unwrap_or_default();
        if let Some(scene) = target.kind.and_then(|k| Scene::decode(k, &bytes)) {
            println!("{}", scene.to_text());
        }
        println!("{:?}", target.try_run(&bytes));
        return;
    };
    let seed = rest.first().and_then(|s| s.parse().ok()).unwrap_or(1);
    let begun = Instant::now();
    let (mut checked, mut slowest) = (0, (0.0, 0));
    let mut found = 0;
    for number in 0..count {
        let one = Instant::now();
        let bytes = input(seed, number);
        match std::panic::catch_unwind(|| target.try_run(&bytes)) {
            Ok(Ok(Outcome::Checked)) => checked += 1,
            Ok(Ok(Outcome::Rejected)) => {}
            Ok(Err(why)) => {
                found += 1;
                println!("{number}: {why}");
            }
            Err(_) => {
                found += 1;
                println!("{number}: panicked");
            }
        }
        let time = one.elapsed().as_secs_f64();
        if time > 0.2 {
            println!("{number}: {time:.2} s");
        }
        if time > slowest.0 {
            slowest = (time, number);
        }
    }
    let seconds = begun.elapsed().as_secs_f64();
    println!(
        "{name}: {count} inputs, {checked} checked, {found} findings, {:.0} a second; slowest {:.3} s ({})",
        count as f64 / seconds,
        slowest.0,
        slowest.1
    );
}
