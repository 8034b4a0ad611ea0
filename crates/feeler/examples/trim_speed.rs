//! How long a side in uv takes: `cargo run --release -p feeler --example trim_speed`.
//!
//! Medians of batches, in nanoseconds a query: random points in the loop's box, and points within 1e-12 of
//! the boundary.

use feeler::brep::*;
use feeler::numeric::Interval;
use feeler::nurbs::*;
use feeler::trim::{Side, TrimRegion};
use nalgebra::{Point2, Point3, Vector3};
use std::time::Instant;

struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}

fn region(loops: Vec<Vec<Curve2>>) -> TrimRegion {
    let d = Interval::new(-10.0, 10.0).expect("a domain");
    let mut parts = BrepParts {
        surfaces: vec![Surface::Plane(Plane {
            origin: Point3::origin(),
            x: Vector3::x(),
            y: Vector3::y(),
            domain: [d, d],
            extents: [d, d],
        })],
        vertices: vec![Vertex {
            point: Point3::origin(),
            edges: vec![],
            tolerance: None,
        }],
        ..BrepParts::default()
    };
    parts.faces.push(Face {
        surface: 0,
        loops: Some((0..loops.len()).collect()),
        reversed: false,
    });
    for (l, curves) in loops.into_iter().enumerate() {
        let first = parts.trims.len();
        for c in curves {
            parts.trims.push(TrimCurve {
                curve: parts.curves2.len(),
                span: c.domain(),
                reversed: false,
                edge: None,
                edge_reversed: false,
                vertices: [0, 0],
                kind: TrimKind::Unknown,
                iso: Iso::None,
                trim_loop: l,
            });
            parts.curves2.push(c);
        }
        parts.loops.push(TrimLoop {
            kind: LoopKind::Unknown,
            trims: (first..parts.trims.len()).collect(),
            face: 0,
        });
    }
    let brep = Brep::new(parts).expect("a BREP");
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

/// A wavy loop of `n` rational cubics around the origin.
fn wavy(n: usize, random: &mut Random) -> Vec<Curve2> {
    let at = |a: f64, r: f64| [r * a.cos(), r * a.sin()];
    let turn = std::f64::consts::TAU / n as f64;
    let radius: Vec<f64> = (0..n).map(|_| 4.0 + 2.0 * random.unit()).collect();
    (0..n)
        .map(|k| {
            let (a, b) = (k as f64 * turn, (k + 1) as f64 * turn);
            let (ra, rb) = (radius[k], radius[(k + 1) % n]);
            let end = if k + 1 == n { 0.0 } else { b };
            let stretch = 1.0 + turn * turn / 18.0;
            let points = [
                at(a, ra),
                at(a + turn / 3.0, ra * stretch),
                at(b - turn / 3.0, rb * stretch),
                at(end, rb),
            ];
            let weights = [
                1.0,
                0.8 + 0.4 * random.unit(),
                0.8 + 0.4 * random.unit(),
                1.0,
            ];
            let net = points
                .iter()
                .zip(weights)
                .map(|(p, w)| [p[0] * w, p[1] * w, w].into())
                .collect();
            let knots = vec![0., 0., 0., 0., 1., 1., 1., 1.];
            Curve::Nurbs(NurbsCurve::new(3, net, knots).expect("a cubic"))
        })
        .collect()
}

/// A comb of `n` cubics in all: teeth as high as the comb.
fn comb(n: usize) -> Vec<Curve2> {
    let teeth = n / 2;
    let width = 16.0 / teeth as f64;
    let mut corners = vec![[-8.0, -8.0]];
    for k in 0..teeth {
        let x = -8.0 + k as f64 * width;
        corners.push([x + 0.3 * width, 8.0]);
        corners.push([x + width, if k + 1 == teeth { -8.0 } else { -7.9 }]);
    }
    corners
        .windows(2)
        .chain([[corners[corners.len() - 1], corners[0]].as_slice()])
        .map(|c| {
            let (a, b) = (c[0], c[1]);
            let mix = |s: f64, off: f64| {
                [
                    a[0] + s * (b[0] - a[0]) + off * 0.1 * width,
                    a[1] + s * (b[1] - a[1]),
                    1.0,
                ]
            };
            let net = [
                mix(0.0, 0.0),
                mix(0.33, 1.0),
                mix(0.67, -1.0),
                mix(1.0, 0.0),
            ];
            let knots = vec![0., 0., 0., 0., 1., 1., 1., 1.];
            Curve::Nurbs(NurbsCurve::new(3, net.map(Into::into).to_vec(), knots).expect("a cubic"))
        })
        .collect()
}

/// Many small loops in a square.
fn islands(n: usize, random: &mut Random) -> Vec<Vec<Curve2>> {
    let side = ((n / 4) as f64).sqrt().ceil() as usize;
    let mut out = Vec::new();
    for i in 0..side {
        for j in 0..side {
            let c = [i, j].map(|k| -9.0 + 18.0 * (k as f64 + 0.5) / side as f64);
            let s = 1.6 / side as f64;
            let mut curves = wavy(4, random);
            for curve in &mut curves {
                if let Curve::Nurbs(n) = curve {
                    let net = n
                        .control_points()
                        .iter()
                        .map(|p| [p[0] * s + c[0] * p[2], p[1] * s + c[1] * p[2], p[2]].into())
                        .collect();
                    *curve = Curve::Nurbs(
                        NurbsCurve::new(3, net, n.knots().knots().to_vec()).expect("a cubic"),
                    );
                }
            }
            out.push(curves);
        }
    }
    out
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
    let mut random = Random(7);
    print!("{name:24}");
    let region = region(loops);
    let mut bounds = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
    for p in region.pieces() {
        for (b, h) in bounds.iter_mut().zip(p.hull) {
            *b = [b[0].min(h[0]), b[1].max(h[1])];
        }
    }
    let anywhere: Vec<_> = (0..100_000)
        .map(|_| {
            let [u, v] = bounds.map(|b| b[0] + (b[1] - b[0]) * random.unit());
            Point2::new(u, v)
        })
        .collect();
    let near = |distance: f64, random: &mut Random| -> Vec<Point2<f64>> {
        (0..20_000)
            .map(|_| {
                let n = region.pieces().len();
                let p = &region.pieces()[(random.unit() * n as f64) as usize];
                let t = random.unit();
                let mut d = p.control_points.clone();
                while d.len() > 1 {
                    d = d
                        .windows(2)
                        .map(|w| [0, 1, 2].map(|i| w[0][i] * (1.0 - t) + w[1][i] * t))
                        .collect();
                }
                Point2::new(
                    d[0][0] / d[0][2] + distance * (2.0 * random.unit() - 1.0),
                    d[0][1] / d[0][2] + distance * (2.0 * random.unit() - 1.0),
                )
            })
            .collect()
    };
    let (a, inside) = time(&region, &anywhere);
    let (b, _) = time(&region, &near(1e-12, &mut random));
    let (c, _) = time(&region, &near(1e-15, &mut random));
    // A box about each point, a hundredth of the loop wide.
    let size = bounds.map(|b| (b[1] - b[0]) / 200.0);
    let start = Instant::now();
    let mut mixed = 0;
    for q in &anywhere {
        let b = region.classify_box(
            [q.x - size[0], q.x + size[0]],
            [q.y - size[1], q.y + size[1]],
        );
        mixed += usize::from(b == feeler::trim::BoxSide::Mixed);
    }
    let boxes = start.elapsed().as_secs_f64() * 1e9 / anywhere.len() as f64;
    println!(
        "random {a:7.1}, within 1e-12 {b:7.1}, within 1e-15 {c:8.1}, box {boxes:6.1} ns | inside {:.3}, mixed {:.3}",
        inside as f64 / anywhere.len() as f64,
        mixed as f64 / anywhere.len() as f64
    );
}

fn main() {
    let mut random = Random(1);
    for n in [4, 16, 64] {
        measure(&format!("{n} rational cubics"), vec![wavy(n, &mut random)]);
    }
    for n in [1_000, 200_000] {
        measure(&format!("{n} cubics, a comb"), vec![comb(n)]);
        measure(&format!("{n} cubics, islands"), islands(n, &mut random));
    }
}
