//! How much memory reading takes, whatever a file claims. A test binary of its own, as the
//! allocator counts for all threads.

#[allow(dead_code, unreachable_pub)]
mod fixture;

use feeler_io::read_3dm;
use peak_alloc::PeakAlloc;

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

/// Bytes in memory for each byte of the file, at most. The densest: a missing curve takes 4 bytes in a
/// file and 16 in the table of places, doubled while that grows; a trim of 132 bytes becomes about 300.
const FACTOR: usize = 16;

/// And what every document takes.
const FIXED: usize = 1 << 16;

fn check(bytes: &[u8]) {
    ALLOCATOR.reset_peak_usage();
    let before = ALLOCATOR.current_usage();
    drop(read_3dm(bytes));
    let used = ALLOCATOR.peak_usage().saturating_sub(before);
    assert!(
        used <= FACTOR * bytes.len() + FIXED,
        "{used} bytes for a file of {}",
        bytes.len()
    );
}

#[test]
fn memory_stays_within_a_multiple_of_the_file() {
    let bytes = fixture::file(60, |w| {
        w.record("sheet", fixture::BREP, fixture::brep);
        w.record("sum", fixture::SUM, fixture::sum);
        w.record("net", fixture::NURBS_SURFACE, fixture::nurbs_surface);
        w.record("chain", fixture::POLY_CURVE, fixture::poly_curve);
    });
    check(&bytes);
    for at in 0..bytes.len() - 4 {
        for wild in [i32::MAX, 0x0FFF_FFFF, 1 << 16, 1 << 10] {
            let mut damaged = bytes.clone();
            damaged[at..at + 4].copy_from_slice(&wild.to_le_bytes());
            check(&damaged);
        }
    }
    // A list that is nothing but missing curves.
    let missing = fixture::file(60, |w| {
        w.record("", fixture::BREP, |w| {
            w.u8(0x33);
            w.chunk(fixture::ANONYMOUS, |w| {
                w.u8(0x10);
                w.i32_array(&vec![0; 1 << 20]);
            });
        });
    });
    check(&missing);
}
