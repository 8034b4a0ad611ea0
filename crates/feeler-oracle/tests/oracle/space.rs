//! Lines, the side of a point in space and signed separations, against analysis.

use crate::scene;
use crate::scene::{brep, circle, dyadic, model, patch, plane, polygon};
use feeler::numeric::Dyadic;
use feeler::query::LineKind;
use feeler_oracle::{InsideTruth, LineTruth, Oracle, TruthEnclosure};
use std::time::Instant;

fn oracle(b: feeler::brep::Brep) -> Oracle {
    Oracle::new(&[&b]).unwrap()
}

/// Whether `e` holds `x` and is no wider than 2^-150.
fn is_narrow_about(e: &TruthEnclosure, x: f64) -> bool {
    let limit: Dyadic = "1p-150".parse().unwrap();
    e.contains(&dyadic(x)) && e.width() <= limit
}

fn only_hits(truth: &LineTruth) -> Vec<f64> {
    assert!(truth.open.is_empty(), "{truth:?}");
    truth.hits.iter().map(|h| h.t.lo.approximate()).collect()
}

#[test]
fn plane_is_hit_exactly() {
    let o = oracle(brep(
        plane(4.0),
        Some(vec![polygon(&[
            [-1.0, -1.0],
            [2.0, -1.0],
            [2.0, 3.0],
            [-1.0, 3.0],
        ])]),
    ));
    // At (0.5, 0.25, 0).
    let hit = o
        .line([0.5, 0.25, 3.0], [0.0, 0.0, -2.0], LineKind::Line)
        .unwrap();
    assert_eq!(hit.crossings, Some(1));
    assert_eq!(hit.in_crack, Some(false));
    assert_eq!(hit.hits[0].t.lo, dyadic(1.5));
    assert_eq!(hit.hits[0].t.hi, dyadic(1.5));
    // On an edge, then off the face, then before the start of a ray, then at the end of a segment.
    let edge = o
        .line([2.0, 0.0, 1.0], [0.0, 0.0, -1.0], LineKind::Line)
        .unwrap();
    // The edge is used once: there is no crack.
    assert!(edge.hits[0].boundary && edge.crossings == Some(1));
    assert_eq!(edge.in_crack, Some(false));
    let off = o
        .line([2.5, 0.0, 1.0], [0.0, 0.0, -1.0], LineKind::Line)
        .unwrap();
    assert!(off.hits.is_empty() && off.crossings == Some(0));
    let behind = o
        .line([0.0, 0.0, 1.0], [0.0, 0.0, 1.0], LineKind::Ray)
        .unwrap();
    assert!(behind.hits.is_empty());
    let end = o
        .line([0.0, 0.0, 1.0], [0.0, 0.0, -1.0], LineKind::Segment)
        .unwrap();
    assert_eq!(only_hits(&end), [1.0]);
    let short = o
        .line([0.0, 0.0, 1.0], [0.0, 0.0, -0.5], LineKind::Segment)
        .unwrap();
    assert!(short.hits.is_empty());
}

#[test]
fn line_in_a_plane_gives_intervals() {
    // A square with a round hole of radius 1.
    let square = polygon(&[[-2.0, -2.0], [2.0, -2.0], [2.0, 2.0], [-2.0, 2.0]]);
    let o = oracle(brep(plane(4.0), Some(vec![square, circle(1.0)])));
    let truth = o
        .line([-3.0, 0.6, 0.0], [1.0, 0.0, 0.0], LineKind::Line)
        .unwrap();
    assert_eq!(truth.hits.len(), 2, "{truth:?}");
    assert_eq!(truth.crossings, None);
    // In at x = -2, out where x^2 = 1 - fl(0.6)^2, symmetric.
    let root = (1.0 - 0.6f64 * 0.6).sqrt();
    let ends: Vec<f64> = truth
        .hits
        .iter()
        .flat_map(|h| {
            [
                h.t.lo.approximate(),
                h.t_end.as_ref().unwrap().hi.approximate(),
            ]
        })
        .collect();
    for (found, expected) in ends.iter().zip([1.0, 3.0 - root, 3.0 + root, 5.0]) {
        assert!((found - expected).abs() < 1e-14, "{ends:?}");
    }
    // The same exactly: at height 3/5 of a circle of radius 5 x = 4 ends it.
    let square = polygon(&[[-6.0, -6.0], [6.0, -6.0], [6.0, 6.0], [-6.0, 6.0]]);
    let o = oracle(brep(plane(8.0), Some(vec![square, circle(5.0)])));
    let truth = o
        .line([0.0, 3.0, 0.0], [1.0, 0.0, 0.0], LineKind::Ray)
        .unwrap();
    assert_eq!(truth.hits.len(), 1);
    assert!(is_narrow_about(&truth.hits[0].t, 4.0), "{truth:?}");
    assert!(is_narrow_about(truth.hits[0].t_end.as_ref().unwrap(), 6.0));
    // Along an edge of the square: it belongs to the face.
    let truth = o
        .line([0.0, 6.0, 0.0], [1.0, 0.0, 0.0], LineKind::Line)
        .unwrap();
    assert!(is_narrow_about(&truth.hits[0].t, -6.0));
    assert!(is_narrow_about(truth.hits[0].t_end.as_ref().unwrap(), 6.0));
    // Parallel, beside the plane.
    let truth = o
        .line([0.0, 3.0, 1e-300], [1.0, 0.0, 0.0], LineKind::Line)
        .unwrap();
    assert!(truth.hits.is_empty() && truth.open.is_empty());
}

/// z = x^2 + y^2 - 1/4 over [-1, 1]^2, as one biquadratic patch.
fn bowl() -> feeler::nurbs::Surface {
    // Bernstein coefficients of (2 u - 1)^2: 1, -1, 1.
    let square = [1.0, -1.0, 1.0];
    let mut net = Vec::new();
    for i in 0..3 {
        for j in 0..3 {
            let (x, y) = (i as f64 - 1.0, j as f64 - 1.0);
            net.push([x, y, square[i] + square[j] - 0.25, 1.0]);
        }
    }
    patch(2, 2, net)
}

#[test]
fn bowl_is_hit_where_algebra_says() {
    let o = oracle(brep(bowl(), None));
    // Along x through the axis, z = 0: x = -1/2, 1/2.
    let t = o
        .line([0.0, 0.0, 0.0], [1.0, 0.0, 0.0], LineKind::Line)
        .unwrap();
    assert_eq!(t.hits.len(), 2, "{t:?}");
    assert!(is_narrow_about(&t.hits[0].t, -0.5) && is_narrow_about(&t.hits[1].t, 0.5));
    assert!(t.hits.iter().all(|h| h.transversal && !h.boundary));
    assert_eq!(t.crossings, Some(2));
    // Nearly tangent to the bottom, 2^-70 above it: x = -2^-35, 2^-35.
    let z = -0.25 + 2f64.powi(-50);
    let t = o
        .line([0.0, 0.0, z], [1.0, 0.0, 0.0], LineKind::Line)
        .unwrap();
    let x = 2f64.powi(-25);
    assert_eq!(t.hits.len(), 2, "{t:?}");
    assert!(is_narrow_about(&t.hits[0].t, -x) && is_narrow_about(&t.hits[1].t, x));
    // As much below it: none.
    let z = -0.25 - 2f64.powi(-50);
    let t = o
        .line([0.0, 0.0, z], [1.0, 0.0, 0.0], LineKind::Line)
        .unwrap();
    assert!(t.hits.is_empty() && t.open.is_empty(), "{t:?}");
    // Exactly tangent.
    let t = o
        .line([0.0, 0.0, -0.25], [1.0, 0.0, 0.0], LineKind::Line)
        .unwrap();
    assert!(t.open.is_empty() && t.hits.len() == 1 && t.crossings == Some(0));
    assert!(is_narrow_about(&t.hits[0].t, 0.0), "{t:?}");
    assert!(t.hits[0].tangential && t.hits[0].multiplicity == Some(2));
    // Exactly on the domain's border.
    let t = o
        .line([1.0, 0.25, 0.0], [0.0, 0.0, 1.0], LineKind::Line)
        .unwrap();
    assert_eq!(t.hits.len(), 1, "{t:?}");
    assert!(t.hits[0].boundary && is_narrow_about(&t.hits[0].t, 0.8125));
    // Just off it.
    let x = 1f64.next_up();
    let t = o
        .line([x, 0.25, 0.0], [0.0, 0.0, 1.0], LineKind::Line)
        .unwrap();
    assert!(t.hits.is_empty() && t.open.is_empty() && t.crossings == Some(0));
}

#[test]
fn trims_cut_hits_exactly() {
    // The bowl cut out along a circle of radius 1/2 around the middle, in uv radius 1/4.
    let shifted: Vec<_> = [0, 1, 2, 3]
        .map(|k| {
            let turn = |[x, y, w]: [f64; 3]| match k {
                0 => [x + 0.5 * w, y + 0.5 * w, w],
                1 => [-y + 0.5 * w, x + 0.5 * w, w],
                2 => [-x + 0.5 * w, -y + 0.5 * w, w],
                _ => [y + 0.5 * w, -x + 0.5 * w, w],
            };
            scene::bezier(&[
                turn([0.25, 0.0, 1.0]),
                turn([0.25, 0.25, 1.0]),
                turn([0.0, 0.5, 2.0]),
            ])
        })
        .to_vec();
    let o = oracle(brep(bowl(), Some(vec![shifted])));
    let down = |x: f64, y: f64| {
        o.line([x, y, 2.0], [0.0, 0.0, -1.0], LineKind::Line)
            .unwrap()
    };
    assert_eq!(down(0.25, 0.25).crossings, Some(1));
    assert_eq!(down(0.45, 0.45).crossings, Some(0));
    // 1e-15 to each side of the circle at 45 degrees, then exactly on it: 0.5 (3/5, 4/5) is not a
    // double, so where the circle passes the axis.
    let on = 0.5f64;
    assert_eq!(only_hits(&down(on.next_down(), 0.0)).len(), 1);
    assert_eq!(only_hits(&down(on.next_up(), 0.0)).len(), 0);
    let s = 0.5 * 0.5f64.sqrt();
    for k in 1..5 {
        let e = f64::from(k) * 1e-15;
        assert_eq!(only_hits(&down(s - e, s - e)).len(), 1);
        assert_eq!(only_hits(&down(s + e, s + e)).len(), 0);
    }
    // On the curved loop, at z = 0.
    let t = down(on, 0.0);
    assert!(t.open.is_empty() && t.hits.len() == 1 && t.hits[0].boundary);
    assert!(is_narrow_about(&t.hits[0].t, 2.0), "{t:?}");
}

#[test]
fn socket_is_hit_at_its_radius() {
    let Some(breps) = model("thesis/3dm/ball_nurbs.3dm") else {
        return;
    };
    let o = Oracle::new(&breps.iter().collect::<Vec<_>>()).unwrap();
    // Skew to every joint of patches.
    let start = Instant::now();
    let t = o
        .line([0.1, 0.2, 0.3], [0.3, 0.4, 0.5], LineKind::Line)
        .unwrap();
    println!("ball: {:?}", start.elapsed());
    println!("{t:#?}");
    assert_eq!(t.hits.len(), 2);
    assert!(t.open.is_empty());
    // Along the axes, through poles or joints.
    for d in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] {
        let start = Instant::now();
        let t = o.line([0.0; 3], d, LineKind::Line).unwrap();
        println!(
            "{d:?} {:?}: {} hits, {} open",
            start.elapsed(),
            t.hits.len(),
            t.open.len()
        );
        for h in &t.hits {
            println!("  {} {:?}", h.t.lo.approximate(), h);
        }
        for h in &t.open {
            println!(
                "  {} {} {:?}",
                h.t.lo.approximate(),
                h.t.hi.approximate(),
                h.why
            );
        }
    }
}

#[test]
fn parts_have_an_inside() {
    // Material at these points, none at those, known from the parts' construction.
    for name in [
        "thesis/3dm/cube_nurbs.3dm",
        "thesis/3dm/cube.3dm",
        "thesis/3dm/ball_nurbs.3dm",
        "thesis/3dm/cylinder_nurbs.3dm",
        "thesis/3dm/ball_joint_socket_nurbs.3dm",
        "thesis/3dm/geneva6_wheel_nurbs.3dm",
        "thesis/3dm/shift_gate_nurbs.3dm",
        "real/v4_MechPartB.3dm",
        "real/v4_WishBone.3dm",
    ] {
        let Some(breps) = model(name) else { continue };
        let o = match Oracle::new(&breps.iter().collect::<Vec<_>>()) {
            Ok(o) => o,
            Err(e) => {
                println!("{name}: {e}");
                continue;
            }
        };
        let closed: Vec<bool> = breps.iter().map(|b| b.is_closed()).collect();
        println!("{name}: {} faces, closed {closed:?}", o.faces());
        for point in [[0.01, 0.02, 0.03], [1000.0, 1000.0, 1000.0]] {
            let start = Instant::now();
            let side = o.inside(point).unwrap();
            println!("  {point:?} {side:?} {:?}", start.elapsed());
            let start = Instant::now();
            let t = o.line(point, [0.31, 0.52, 0.71], LineKind::Line).unwrap();
            println!(
                "  line: {} hits, {:?} crossings, {} open, {:?}",
                t.hits.len(),
                t.crossings,
                t.open.len(),
                start.elapsed()
            );
            if point[0] > 100.0 {
                assert_eq!(side, InsideTruth::Outside, "{name}");
            }
        }
    }
}

/// Lines that cross a closed part do so an even number of times, and between the hits the side
/// (found with rays in other directions) alternates.
#[test]
fn sides_alternate_along_lines() {
    for name in [
        "thesis/3dm/cube_corner_sphere_cut_nurbs.3dm",
        "thesis/3dm/ball_joint_socket_nurbs.3dm",
        "thesis/3dm/geneva6_wheel_nurbs.3dm",
        "thesis/3dm/shift_gate_nurbs.3dm",
        "real/v4_MechPartB.3dm",
    ] {
        let Some(breps) = model(name) else { continue };
        let Ok(o) = Oracle::new(&[&breps[0]]) else {
            println!("{name}: not treated");
            continue;
        };
        assert!(breps[0].is_closed());
        let points: Vec<_> = breps[0].parts().vertices.iter().map(|v| v.point).collect();
        let range = |k: usize| {
            let all = points.iter().map(|p| p[k]);
            let lo = all.clone().fold(f64::INFINITY, f64::min);
            (lo - 1.0, all.fold(f64::NEG_INFINITY, f64::max) + 1.0)
        };
        let mut g = scene::Random(17);
        let (mut known, mut hits, mut undecided, mut sides) = (0, 0, 0, 0);
        let start = Instant::now();
        for _ in 0..30 {
            let mut at = || [0, 1, 2].map(|k| g.range(range(k).0, range(k).1));
            let (from, to) = (at(), at());
            let direction = [0, 1, 2].map(|k| to[k] - from[k]);
            let t = o.line(from, direction, LineKind::Line).unwrap();
            let Some(crossings) = t.crossings else {
                continue;
            };
            known += 1;
            hits += crossings;
            // t grows to hundreds of units at most here.
            let narrow: Dyadic = "1p-140".parse().unwrap();
            assert!(t.hits.iter().all(|h| h.t.width() <= narrow), "{name} {t:?}");
            assert_eq!(crossings % 2, 0, "{name} {from:?} {direction:?} {t:?}");
            for k in 1..t.hits.len() {
                let s = 0.5 * (t.hits[k - 1].t.hi.approximate() + t.hits[k].t.lo.approximate());
                let between = [0, 1, 2].map(|i| from[i] + s * direction[i]);
                match o.inside(between).unwrap() {
                    InsideTruth::Undecided(_) => undecided += 1,
                    side => {
                        let expected = [InsideTruth::Outside, InsideTruth::Inside][k % 2].clone();
                        assert_eq!(side, expected, "{name} {from:?} {direction:?} {k}");
                        sides += 1;
                    }
                }
            }
        }
        println!(
            "{name}: {known} of 30 lines settled, {hits} hits, {sides} sides, \
             {undecided} undecided, {:?}",
            start.elapsed()
        );
        assert!(known > 10, "{name}");
    }
}
