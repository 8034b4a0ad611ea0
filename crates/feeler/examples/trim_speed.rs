//! How long a side in uv takes: `cargo run --release -p feeler --example trim_speed`.
//!
//! Medians of batches, in nanoseconds a query: random points in the loop's box, and points within 1e-12 of
//! the boundary.

#[path = "../tests/it/scenes/mod.rs"]
mod scenes;

use feeler::nurbs::Curve2;
use feeler::trim::{Side, TrimRegion};
use nalgebra::Point2;
use scenes::Random;
use scenes::loops::{anywhere, comb, face_within, islands, near, wavy};
use std::time::Instant;

/// How near to the boundary points are, in u and in v, in loops some units wide: where f64 still tells mostly, as the table of figures to
/// beat asks, and at some units of rounding.
const NEAR: f64 = 1e-12;
const NEAREST: f64 = 1e-15;

fn region(loops: Vec<Vec<Curve2>>) -> TrimRegion {
    let brep = face_within(loops);
    let start = Instant::now();
    let region = TrimRegion::new(&brep, 0);
    let made = start.elapsed();
    region.side(Point2::origin());
    let all = start.elapsed();
    let n = region.pieces().len() as f64;
    print!(
        "{:8.2} us/piece to make, {:8.2} with cells | ",
        made.as_secs_f64() * 1e6 / n,
        all.as_secs_f64() * 1e6 / n
    );
    region
}

fn time(region: &TrimRegion, points: &[Point2<f64>]) -> (f64, usize) {
    let mut inside = 0;
    let mut batches = Vec::new();
    for _ in 0..5 {
        for batch in points.chunks(points.len().div_ceil(20)) {
            let start = Instant::now();
            for q in batch {
                inside += usize::from(region.side(*q).side == Some(Side::Inside));
            }
            batches.push(start.elapsed().as_secs_f64() * 1e9 / batch.len() as f64);
        }
    }
    batches.sort_by(f64::total_cmp);
    (batches[batches.len() / 2], inside / 5)
}

fn measure(name: &str, loops: Vec<Vec<Curve2>>) {
    let mut random = Random::new(7);
    print!("{name:24}");
    let region = region(loops);
    let points = anywhere(&region, 100_000, &mut random);
    let (a, inside) = time(&region, &points);
    let (b, _) = time(&region, &near(&region, NEAR, 20_000, &mut random));
    let (c, _) = time(&region, &near(&region, NEAREST, 20_000, &mut random));
    // A box about each point, a hundredth of the domain wide.
    let size = region.domain().map(|d| (d.end - d.start) / 200.0);
    let start = Instant::now();
    let mut mixed = 0;
    for q in &points {
        let b = region.classify_box(
            [q.x - size[0], q.x + size[0]],
            [q.y - size[1], q.y + size[1]],
        );
        mixed += usize::from(b == feeler::trim::BoxSide::Mixed);
    }
    let boxes = start.elapsed().as_secs_f64() * 1e9 / points.len() as f64;
    println!(
        "random {a:7.1}, within {NEAR:e} {b:7.1}, within {NEAREST:e} {c:8.1}, box {boxes:6.1} ns | inside {:.3}, mixed {:.3}",
        inside as f64 / points.len() as f64,
        mixed as f64 / points.len() as f64
    );
}

fn main() {
    let mut random = Random::new(1);
    for n in [4, 16, 64] {
        measure(&format!("{n} rational cubics"), vec![wavy(n, &mut random)]);
    }
    for n in [1_000, 200_000] {
        measure(&format!("{n} cubics, a comb"), vec![comb(n)]);
        measure(&format!("{n} cubics, islands"), islands(n, &mut random));
    }
}
