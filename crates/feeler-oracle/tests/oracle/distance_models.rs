//! Distances and half-spaces on real parts: narrow, never above an exactly evaluated point of the
//! face, and in times that are printed (`--nocapture`).

use crate::scene::Random;
use feeler::brep::Brep;
use feeler::numeric::Dyadic;
use feeler::trim::Side;
use feeler_io::{ObjectKind, read_file};
use feeler_oracle::{DistanceStatus, Oracle};
use std::path::{Path, PathBuf};
use std::time::Instant;

fn models() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/models")
}

/// The BREPs of a file, or `None` (said aloud) where the file is not there.
fn breps(file: &str) -> Option<Vec<Brep>> {
    let path = models().join(file);
    if !path.exists() {
        println!("absent, not tested: {}", path.display());
        return None;
    }
    let document = read_file(&path).unwrap();
    let breps: Vec<Brep> = document
        .objects
        .into_iter()
        .filter_map(|o| match o.kind {
            ObjectKind::Brep(b) => Some(b),
            _ => None,
        })
        .collect();
    assert!(!breps.is_empty(), "{file}");
    Some(breps)
}

struct Point {
    what: &'static str,
    at: [f64; 3],
    /// Proven to be at least the squared distance, from a point of a face.
    square: Option<Dyadic>,
}

fn check(file: &str, per_kind: usize) {
    let Some(breps) = breps(file) else { return };
    let o = match Oracle::new(&breps.iter().collect::<Vec<_>>()) {
        Ok(o) => o,
        Err(e) => {
            println!("{file}: {e}");
            return;
        }
    };
    let start = Instant::now();
    o.distance([0.0; 3], None).unwrap();
    let prepare = start.elapsed();
    let mut random = Random(7);
    let mut box_ = [[f64::INFINITY, f64::NEG_INFINITY]; 3];
    let mut vertices = Vec::new();
    for b in &breps {
        for v in &b.parts().vertices {
            vertices.push(v.point);
            for (ends, x) in box_.iter_mut().zip(v.point.iter()) {
                *ends = [ends[0].min(*x), ends[1].max(*x)];
            }
        }
    }
    let size = (0..3)
        .map(|k| (box_[k][1] - box_[k][0]).powi(2))
        .sum::<f64>()
        .sqrt();
    let offsets = [1e-15, 1e-12, 1e-9, 1e-6, 1e-3];
    let mut points = Vec::new();
    let domains: Vec<_> = breps
        .iter()
        .flat_map(|b| (0..b.faces().len()).map(|f| b.surface(f).domain()))
        .collect();
    for i in 0..per_kind {
        let anywhere = [0, 1, 2].map(|k| {
            let margin = 0.1 * size;
            random.range(box_[k][0] - margin, box_[k][1] + margin)
        });
        points.push(Point {
            what: "anywhere",
            at: anywhere,
            square: None,
        });
        let e = offsets[i % offsets.len()] * size;
        let mut shift = || random.range(-e, e);
        let shift = [shift(), shift(), shift()];
        // Near a vertex.
        let v = vertices[(random.next() * vertices.len() as f64) as usize];
        points.push(Point {
            what: "vertex",
            at: [0, 1, 2].map(|k| v[k] + shift[k]),
            square: None,
        });
        // Near a point inside a face.
        for _ in 0..40 {
            let face = (random.next() * domains.len() as f64) as usize;
            let d = domains[face];
            let uv = [0, 1].map(|k| random.range(d[k].start, d[k].end));
            if o.side(face, uv).unwrap().side != Side::Inside {
                continue;
            }
            let p = o.evaluate(face, uv).unwrap().point;
            let at = [0, 1, 2].map(|k| p[k].lo.approximate() + shift[k]);
            let mut square = Dyadic::ZERO;
            for k in 0..3 {
                let q = Dyadic::from_f64(at[k]).unwrap();
                let (a, b) = (&p[k].lo - &q, &p[k].hi - &q);
                let (a, b) = (&a * &a, &b * &b);
                square = &square + if a > b { &a } else { &b };
            }
            points.push(Point {
                what: "face",
                at,
                square: Some(square),
            });
            break;
        }
        // The middle of the model and its neighbourhood: often a focal point.
        let c = [0, 1, 2].map(|k| 0.5 * (box_[k][0] + box_[k][1]));
        points.push(Point {
            what: "middle",
            at: if i == 0 {
                c
            } else {
                [0, 1, 2].map(|k| c[k] + shift[k])
            },
            square: None,
        });
        let zero = if i == 0 { [0.0; 3] } else { shift };
        points.push(Point {
            what: "origin",
            at: zero,
            square: None,
        });
    }
    let mut times = Vec::new();
    let mut widest = 0f64;
    let mut statuses = [0; 4];
    for p in &points {
        let start = Instant::now();
        let t = o.distance(p.at, None).unwrap().unwrap();
        let time = start.elapsed().as_secs_f64() * 1e3;
        times.push(time);
        let width = t.enclosure.width().approximate() / size;
        widest = widest.max(width);
        statuses[t.status as usize] += 1;
        if let Some(square) = &p.square {
            assert!(
                &t.enclosure.lo * &t.enclosure.lo <= *square,
                "{file} {:?}",
                p.at
            );
        }
        if t.status == DistanceStatus::Budget || width > 1e-30 || time > 200.0 {
            println!(
                "  {} {:?}: {time:.0} ms, width {width:.1e} {:?} {:?}",
                p.what, p.at, t.status, t.nodes
            );
        }
    }
    let mut half_times = Vec::new();
    let mut half_widest = 0f64;
    for i in 0..3 * per_kind {
        let n = if i == 6 {
            // Touches the border of the untrimmed sheet.
            [
                -0.6785800957523521,
                0.04055648639993682,
                -0.7334059074343623,
            ]
        } else if i < 6 {
            let s = if i % 2 == 0 { 1.0 } else { -1.0 };
            [0, 1, 2].map(|k| if i / 2 == k { s } else { 0.0 })
        } else {
            let v = nalgebra::Vector3::from_fn(|_, _| random.range(-1.0, 1.0)).normalize();
            [v.x, v.y, v.z]
        };
        let start = Instant::now();
        let t = o.half_space(n, 0.25, None).unwrap().unwrap();
        let time = start.elapsed().as_secs_f64() * 1e3;
        half_times.push(time);
        let width = t.enclosure.width().approximate() / size;
        half_widest = half_widest.max(width);
        if t.status == DistanceStatus::Budget || width > 1e-30 || time > 200.0 {
            println!(
                "  half-space {n:?}: {time:.0} ms, width {width:.1e} {:?} {:?}",
                t.status, t.nodes
            );
        }
    }
    let summary = |times: &mut Vec<f64>| {
        times.sort_by(f64::total_cmp);
        format!(
            "median {:.2} ms, max {:.1} ms",
            times[times.len() / 2],
            times[times.len() - 1]
        )
    };
    println!(
        "{file}: {} faces, prepared in {:.0} ms; {} distances: {}, widest {widest:.1e} of the size, \
         [regular, edge, interval, budget] {statuses:?}; half-spaces: {}, widest {half_widest:.1e}",
        o.faces(),
        prepare.as_secs_f64() * 1e3,
        points.len(),
        summary(&mut times),
        summary(&mut half_times),
    );
    assert!(
        widest < 2f64.powi(-96) && half_widest < 2f64.powi(-96),
        "{file}"
    );
}

#[test]
fn thesis_parts() {
    for file in [
        "ball_joint_cavity_nurbs",
        "ball_joint_socket_nurbs",
        "cube_corner_sphere_cut_nurbs",
        "cylinder_nurbs",
        "sheet_trimmed_nurbs",
        // Its loop follows the domain's border, but for rounding, on the outer side.
        "sheet_untrimmed_nurbs",
        "geneva4_wheel_nurbs",
        "shift_gate_nurbs",
    ] {
        check(&format!("thesis/3dm/{file}.3dm"), 10);
    }
}

#[test]
fn third_party_parts() {
    for file in ["v4_MechPartB", "v4_WishBone"] {
        check(&format!("real/{file}.3dm"), 10);
    }
}
