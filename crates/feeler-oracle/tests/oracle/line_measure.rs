//! How long lines take on real parts, and how many stay open. `--ignored --nocapture`; prints.

use crate::scene::{Random, model};
use feeler::brep::Brep;
use feeler::query::LineKind;
use feeler_oracle::Oracle;
use std::collections::BTreeMap;

/// Seconds that this thread ran: other work on the machine does not count.
fn processor_time() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let nanoseconds = text
        .split_whitespace()
        .next()
        .and_then(|s| s.parse::<f64>().ok());
    nanoseconds.unwrap_or(f64::NAN) * 1e-9
}

const MODELS: [&str; 8] = [
    "thesis/3dm/ball_joint_cavity_nurbs.3dm",
    "thesis/3dm/ball_joint_socket_nurbs.3dm",
    "thesis/3dm/cube_corner_sphere_cut_nurbs.3dm",
    "thesis/3dm/cylinder_nurbs.3dm",
    "thesis/3dm/geneva6_wheel_nurbs.3dm",
    "thesis/3dm/shift_gate_nurbs.3dm",
    "real/v4_MechPartB.3dm",
    "real/v4_WishBone.3dm",
];

/// A line of one of three kinds: through random points, aimed near an edge's or vertex's place,
/// nearly tangent to a face.
fn aimed(g: &mut Random, o: &Oracle, breps: &[Brep], kind: usize) -> ([f64; 3], [f64; 3]) {
    let global = (g.next() * o.faces() as f64) as usize;
    let (mut b, mut face) = (0, global);
    while face >= breps[b].faces().len() {
        face -= breps[b].faces().len();
        b += 1;
    }
    let b = &breps[b];
    let d = b.surface(face).domain();
    let mut uv = [0, 1].map(|k| g.range(d[k].start, d[k].end));
    if kind == 1 {
        // On an end of the domain, or next to it.
        let k = (g.next() * 2.0) as usize;
        uv[k] = d[k].end - (d[k].end - d[k].start) * 10f64.powf(g.range(-15.0, -6.0));
    }
    let e = o.evaluate(global, uv).unwrap();
    let near = |v: &[feeler_oracle::TruthEnclosure; 3]| {
        nalgebra::Vector3::from([0, 1, 2].map(|k| v[k].lo.approximate()))
    };
    let (du, dv) = (near(&e.du), near(&e.dv));
    let p: [f64; 3] = near(&e.point).into();
    let across = [0; 3].map(|_| g.range(-1.0, 1.0));
    if kind < 2 {
        return (p, across);
    }
    // In the tangent plane, tilted by 0 to 1e-8, and lifted as little.
    let tilt = if g.next() < 0.3 {
        0.0
    } else {
        10f64.powf(g.range(-16.0, -8.0))
    };
    let (a, c) = (g.range(-1.0, 1.0), g.range(-1.0, 1.0));
    let n = du.cross(&dv);
    let n = n / n.norm();
    let t = du / du.norm() * a + dv / dv.norm() * c + n * tilt;
    (
        [0, 1, 2].map(|k| p[k] + tilt * n[k] * g.range(-1.0, 1.0)),
        [t.x, t.y, t.z],
    )
}

#[test]
#[ignore = "minutes; prints figures"]
fn lines_on_parts() {
    let count: usize = std::env::var("LINES").map_or(100, |s| s.parse().unwrap());
    for name in MODELS {
        let Some(breps) = model(name) else { continue };
        let o = match Oracle::new(&breps.iter().collect::<Vec<_>>()) {
            Ok(o) => o,
            Err(e) => {
                println!("{name}: {e}");
                continue;
            }
        };
        let _ = o.line([0.0; 3], [0.3, 0.4, 0.5], LineKind::Line).unwrap();
        for (kind, what) in ["random", "near", "tangent"].iter().enumerate() {
            let mut g = Random(kind as u64 + 1);
            let mut times = Vec::new();
            let (mut hits, mut open, mut settled) = (0, 0, 0);
            let mut why: BTreeMap<String, usize> = BTreeMap::new();
            for _ in 0..count {
                let (origin, direction) = aimed(&mut g, &o, &breps, kind);
                if !direction.iter().chain(&origin).all(|x| x.is_finite()) {
                    continue;
                }
                let start = processor_time();
                let t = o.line(origin, direction, LineKind::Line).unwrap();
                let took = (processor_time() - start) * 1e3;
                if took > 500.0 {
                    println!("  slow: {took} ms {origin:?} {direction:?}");
                }
                times.push(took);
                hits += t.hits.len();
                settled += usize::from(t.crossings.is_some());
                if let Some(first) = t.open.first() {
                    open += 1;
                    *why.entry(first.why.clone()).or_default() += 1;
                    if open <= 2 {
                        println!(
                            "  open: {origin:?} {direction:?} {:?} {:e}",
                            first.why,
                            first.t.lo.approximate()
                        );
                    }
                }
            }
            times.sort_by(f64::total_cmp);
            let at = |q: f64| times[((times.len() - 1) as f64 * q) as usize];
            println!(
                "{name} ({} faces), {what}: {} lines, {hits} hits, {settled} with crossings, {open} open \
                 {why:?}; ms median {:.2}, p99 {:.1}, most {:.1}",
                o.faces(),
                times.len(),
                at(0.5),
                at(0.99),
                at(1.0)
            );
        }
    }
}
