//! How much memory reading a .brep file takes, whatever it claims. A test binary of its own with one test, as the
//! allocator counts for all threads.

use feeler_io::read_brep;
use peak_alloc::PeakAlloc;
use std::path::Path;

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

/// Bytes in memory for each byte of the file, at most. Parts of the thesis take 4 to 11; a control point of zeros takes
/// six bytes and is kept twice, as four numbers in vectors that double.
const FACTOR: usize = 64;

/// And what every file may take.
const FIXED: usize = 1 << 16;

/// Bytes in memory for each byte of the file.
fn check(bytes: &[u8]) -> f64 {
    ALLOCATOR.reset_peak_usage();
    let before = ALLOCATOR.current_usage();
    drop(read_brep(bytes));
    let used = ALLOCATOR.peak_usage().saturating_sub(before);
    assert!(
        used <= FACTOR * bytes.len() + FIXED,
        "{used} bytes for a file of {}",
        bytes.len()
    );
    used as f64 / bytes.len() as f64
}

#[test]
fn memory_stays_within_a_multiple_of_the_file() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../corpora/models/thesis");
    for part in [
        "cylinder.brep",
        "ball_nurbs_periodic.brep",
        "ball_joint_cavity_nurbs.brep",
        "geneva4_wheel.brep",
    ] {
        let text = std::fs::read_to_string(folder.join(part)).expect("a file of the corpus");
        println!("{part}: {:.1} bytes a byte", check(text.as_bytes()));
        let words: Vec<&str> = text.split_inclusive(char::is_whitespace).collect();
        let step = 1 + words.len() / 120;
        for at in (0..words.len()).step_by(step) {
            for wild in ["1 ", "100 ", "1000 ", "40.5 "] {
                let mut words = words.clone();
                words[at] = wild;
                check(words.concat().as_bytes());
            }
        }
    }
    // Tables of nothing but the shortest entries.
    let rest = "Polygon3D 0\nPolygonOnTriangulations 0\nSurfaces 0\nTriangulations 0\nTShapes 1\nCo\n0000000\n*\n+1 0\n";
    let lines = "1 0 0 0 0\n".repeat(20_000);
    let head = "CASCADE Topology V1, (c) Matra-Datavision\n";
    check(format!("{head}Locations 0\nCurve2ds 20000\n{lines}Curves 0\n{rest}").as_bytes());
    let knots = "0 2 ".to_owned() + &(1..2000).map(|k| format!("{k} 1 ")).collect::<String>();
    let points = "0 0 ".repeat(2000);
    let spline = format!("7 0 1 1 1999 2000 {}{knots}\n", &points[4..]);
    check(format!("{head}Locations 0\nCurve2ds 1\n{spline}Curves 0\n{rest}").as_bytes());
    let locations: String = (2..2000)
        .map(|i| format!("2 {i} 1 1 {} 0\n", 1 + i % 7))
        .collect();
    let first = "1\n1 0 0 1\n0 1 0 0\n0 0 1 0\n".repeat(2);
    check(
        format!("{head}Locations 2000\n{first}{locations}Curve2ds 0\nCurves 0\n{rest}").as_bytes(),
    );
}
