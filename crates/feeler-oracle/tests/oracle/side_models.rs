//! Sides in uv of the models, and of random loops of any degree: the oracle and the kernel, which share no
//! algorithm, agree wherever the kernel answers.

use crate::scene::{Random, brep, plane};
use feeler::brep::Brep;
use feeler::nurbs::{Curve2, NurbsCurve};
use feeler::trim::TrimRegion;
use feeler_oracle::Oracle;
use nalgebra::Point2;
use std::path::Path;
use std::time::{Duration, Instant};

/// A point of the domain, or some ulps from a trim curve or from one of its ends.
fn pick(g: &mut Random, b: &Brep, face: usize) -> [f64; 2] {
    let [u, v] = b.surface(face).domain();
    let loops = b.faces()[face].loops.as_deref().unwrap_or_default();
    let trims: Vec<usize> = loops
        .iter()
        .flat_map(|l| b.parts().loops[*l].trims.iter().copied())
        .collect();
    if trims.is_empty() || g.next() < 0.4 {
        return [
            g.range(u.start - 0.01 * u.length(), u.end + 0.01 * u.length()),
            g.range(v.start, v.end),
        ];
    }
    let trim =
        &b.parts().trims[trims[((g.next() * trims.len() as f64) as usize).min(trims.len() - 1)]];
    let t = match g.next() {
        x if x < 0.1 => trim.span.start,
        x if x < 0.2 => trim.span.end,
        _ => g.range(trim.span.start, trim.span.end),
    };
    let p = b.parts().curves2[trim.curve].point(t);
    [p.x, p.y].map(|mut x| {
        let ulps = (g.range(-2.5, 2.5)).round() as i32;
        for _ in 0..ulps.abs() {
            x = if ulps > 0 { x.next_up() } else { x.next_down() };
        }
        x
    })
}

/// Asks both; the times the oracle took.
fn compare(b: &Brep, queries: usize, seed: u64, name: &str) -> (Vec<Duration>, usize) {
    let o = Oracle::new(&[b]).unwrap();
    let mut g = Random(seed);
    let mut times = Vec::new();
    let mut unsettled = 0;
    for face in 0..b.faces().len() {
        let region = TrimRegion::new(b, face);
        let _ = o.side(face, [0.0; 2]).unwrap();
        for _ in 0..queries {
            let uv = pick(&mut g, b, face);
            // Of three, so that what else the machine does is left out.
            let time = || {
                let start = Instant::now();
                let truth = o.side(face, uv);
                (start.elapsed(), truth)
            };
            let (mut took, truth) = time();
            for _ in 0..2 {
                took = took.min(time().0);
            }
            times.push(took);
            let truth = truth.unwrap_or_else(|e| panic!("{name}, face {face}, {uv:?}: {e}"));
            let kernel = region.side(Point2::from(uv));
            match kernel.side {
                None => unsettled += 1,
                Some(side) => assert_eq!(side, truth.side, "{name}, face {face}, {uv:?}"),
            }
            // At ends of arcs, which it knows in enclosures only, the kernel takes the box of those.
            assert!(
                kernel.in_gap || !truth.in_gap,
                "{name}, face {face}, {uv:?}"
            );
        }
    }
    (times, unsettled)
}

fn report(what: &str, mut times: Vec<Duration>, unsettled: usize) {
    times.sort();
    if times.is_empty() {
        return;
    }
    let at = |k: usize| times[(times.len() - 1) * k / 100].as_secs_f64() * 1e6;
    println!(
        "{what}: {} sides, {:.1} / {:.1} / {:.1} us (median, p99, max); {unsettled} not settled by the kernel",
        times.len(),
        at(50),
        at(99),
        at(100)
    );
}

fn models(folder: &str, queries: usize) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../../shared/models")
        .join(folder);
    let Ok(entries) = std::fs::read_dir(&root) else {
        println!("absent, not tested: {}", root.display());
        return;
    };
    let mut files: Vec<_> = entries.filter_map(|e| e.ok().map(|e| e.path())).collect();
    files.sort();
    let (mut times, mut unsettled) = (Vec::new(), 0);
    for path in files {
        if path.extension().is_none_or(|e| e != "3dm") {
            continue;
        }
        let Ok(document) = feeler_io::read_file(&path) else {
            continue;
        };
        for object in document.objects {
            if let feeler_io::ObjectKind::Brep(b) = object.kind {
                let (t, n) = compare(&b, queries, 59, &path.display().to_string());
                times.extend(t);
                unsettled += n;
            }
        }
    }
    report(folder, times, unsettled);
}

#[test]
fn models_of_the_thesis() {
    models("thesis/3dm", 20);
}

#[test]
fn real_models() {
    models("real", 4);
}

#[test]
fn random_loops_of_any_degree() {
    let mut g = Random(61);
    for (degree, decades, queries) in [
        (2, 0.0, 300),
        (3, 1.0, 300),
        (3, 12.0, 200),
        (5, 3.0, 200),
        (9, 1.0, 100),
        (25, 0.0, 60),
        (25, 12.0, 40),
    ] {
        // Three splines around the origin that nearly meet.
        let n = degree + 3;
        let loops: Vec<Curve2> = (0..3)
            .map(|part| {
                let points = (0..n)
                    .map(|i| {
                        let a = (f64::from(part) + i as f64 / (n - 1) as f64) * 2.094_395_102_393_2;
                        let r = g.range(1.0, 3.0);
                        let w = 10f64.powf(decades * g.range(-1.0, 1.0));
                        [w * r * a.cos(), w * r * a.sin(), w].into()
                    })
                    .collect();
                let mut knots = vec![0.0; degree + 1];
                knots.extend([0.3, 0.6]);
                knots.extend(vec![1.0; degree + 1]);
                Curve2::Nurbs(NurbsCurve::new(degree, points, knots).unwrap())
            })
            .collect();
        let b = brep(plane(8.0), Some(vec![loops]));
        let (times, unsettled) = compare(&b, queries, 67, "random loop");
        report(
            &format!("degree {degree}, weights 1e+-{decades}"),
            times,
            unsettled,
        );
    }
}
