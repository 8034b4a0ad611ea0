//! How fast .3dm geometry is loaded and checked: MB/s of whole files, and milliseconds for 1,000 faces.
//!
//! `cargo run --release -p feeler-io --example load_speed -- FILE...` takes each file's model, writes it anew without what is not
//! geometry (meshes, settings, ...), over and over until the file has some 20 MB, and loads that: the median of 7.

use feeler_io::{Document, read_3dm, read_file, write_3dm};
use std::time::Instant;

const SIZE: usize = 20_000_000;
const RUNS: usize = 7;

fn main() {
    println!("| model | bytes of geometry | faces | copies | MB/s | ms for 1,000 faces |");
    println!("|---|---|---|---|---|---|");
    for path in std::env::args().skip(1) {
        let document = match read_file(&path) {
            Ok(document) => document,
            Err(error) => {
                eprintln!("{error}");
                continue;
            }
        };
        let bodies: Vec<_> = document.bodies().map(|(_, b)| b.clone()).collect();
        let faces: usize = bodies.iter().map(|b| b.faces().len()).sum();
        if faces == 0 {
            continue;
        }
        let once = match write_3dm(&Document::of_breps(bodies.clone())) {
            Ok(written) => written.bytes.len(),
            Err(error) => {
                eprintln!("{path}: {error}");
                continue;
            }
        };
        let copies = SIZE.div_ceil(once);
        let many = bodies.iter().cycle().take(bodies.len() * copies).cloned();
        let Ok(written) = write_3dm(&Document::of_breps(many.collect())) else {
            continue;
        };
        let mut times: Vec<f64> = (0..RUNS)
            .map(|_| {
                let start = Instant::now();
                let document = read_3dm(&written.bytes);
                let time = start.elapsed().as_secs_f64();
                assert!(document.is_ok_and(|d| d.bodies().count() == bodies.len() * copies));
                time
            })
            .collect();
        times.sort_by(f64::total_cmp);
        let time = times[RUNS / 2];
        println!(
            "| {path} | {once} | {faces} | {copies} | {:.0} | {:.2} |",
            written.bytes.len() as f64 / time / 1e6,
            time * 1e3 / (faces * copies) as f64 * 1e3,
        );
    }
}
