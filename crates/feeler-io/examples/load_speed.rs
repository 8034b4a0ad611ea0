//! How fast geometry is loaded and checked, and in how much memory: MB/s of files, milliseconds for 1,000 faces, peak bytes for each byte.
//!
//! `cargo run --release -p feeler-io --example load_speed -- FILE...` takes each file's model and writes it anew, as .3dm and as .brep, without what
//! is not geometry (meshes, settings, ...), over and over until the file has some 20 MB, and loads that: the median of 7. A STEP file is
//! loaded as it is, as often in a row as takes a fifth of a second: the clock's ticks may be some milliseconds apart. Then all but the last are let go
//! within the time, too. Memory is what the allocator was asked for beyond the file's own bytes; it counts while time is taken, too. Times are of the
//! processor where Linux tells them, so that other work beside disturbs them less; elsewhere those of the clock.

use feeler_io::{
    Document, ReadError, Written, read_3dm, read_brep, read_step, write_3dm, write_brep,
};
use peak_alloc::PeakAlloc;
use std::time::Instant;

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

const SIZE: usize = 20_000_000;
const RUNS: usize = 7;
/// Seconds that one timing takes at least, about.
const LEAST: f64 = 0.2;

/// Seconds that this thread has been on a processor; of the clock where that is not told.
fn seconds(begun: Instant) -> f64 {
    let told = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let nanoseconds = told.and_then(|t| t.split(' ').next()?.parse::<f64>().ok());
    nanoseconds.map_or_else(|| begun.elapsed().as_secs_f64(), |n| n / 1e9)
}

type Read = fn(&[u8]) -> Result<Document, ReadError>;

fn measure(name: &str, format: &str, bytes: &[u8], faces: usize, read: Read) {
    let begun = Instant::now();
    ALLOCATOR.reset_peak_usage();
    let before = ALLOCATOR.current_usage();
    let document = read(bytes);
    let peak = ALLOCATOR.peak_usage().saturating_sub(before);
    let count = (LEAST / begun.elapsed().as_secs_f64()).ceil() as usize;
    let found = document.map(|d| d.bodies().map(|(_, b)| b.faces().len()).sum::<usize>());
    assert_eq!(found.ok(), Some(faces), "{name} as {format}");
    let mut times: Vec<f64> = (0..RUNS)
        .map(|_| {
            let start = seconds(begun);
            let mut last = None;
            for _ in 0..count {
                last = Some(read(bytes));
            }
            let time = seconds(begun) - start;
            drop(last);
            time / count as f64
        })
        .collect();
    times.sort_by(f64::total_cmp);
    let time = times[RUNS / 2];
    println!(
        "| {name} | {format} | {:.1} | {faces} | {:.1} | {:.2} | {:.1} |",
        bytes.len() as f64 / 1e6,
        bytes.len() as f64 / time / 1e6,
        time * 1e6 / faces as f64,
        peak as f64 / bytes.len() as f64,
    );
}

fn main() {
    println!("| model | format | MB | faces | MB/s | ms for 1,000 faces | peak bytes a byte |");
    println!("|---|---|---|---|---|---|---|");
    for path in std::env::args().skip(1) {
        let bytes = std::fs::read(&path).expect("a file");
        let document = match feeler_io::read_file(&path) {
            Ok(document) => document,
            Err(error) => {
                eprintln!("{error}");
                continue;
            }
        };
        let name = path.rsplit('/').next().unwrap_or(&path).to_owned();
        let bodies: Vec<_> = document.bodies().map(|(_, b)| b.into_owned()).collect();
        let faces: usize = bodies.iter().map(|b| b.faces().len()).sum();
        if faces == 0 {
            continue;
        }
        if document.format == feeler_io::Format::Step {
            measure(&name, "step", &bytes, faces, read_step);
            continue;
        }
        type Format = (
            &'static str,
            fn(&Document) -> Result<Written, feeler_io::WriteError>,
            Read,
        );
        let formats: [Format; 2] = [
            ("3dm", write_3dm, read_3dm),
            ("brep", write_brep, read_brep),
        ];
        for (format, write, read) in formats {
            let once = match write(&Document::of_breps(bodies.clone())) {
                Ok(written) => written.bytes.len(),
                Err(error) => {
                    eprintln!("{path} as {format}: {error}");
                    continue;
                }
            };
            let copies = SIZE.div_ceil(once);
            let many = bodies.iter().cycle().take(bodies.len() * copies).cloned();
            let Ok(written) = write(&Document::of_breps(many.collect())) else {
                continue;
            };
            measure(&name, format, &written.bytes, faces * copies, read);
        }
    }
}
