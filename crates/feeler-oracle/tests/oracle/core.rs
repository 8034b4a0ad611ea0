//! Evaluation, sides in uv and containment of failures, against exact arithmetic by hand.

use crate::scene;
use crate::scene::{
    Random, bezier, brep, changed, circle, exact, line, patch, plane, polygon, rational,
};
use dashu_int::IBig;
use dashu_ratio::RBig;
use feeler::brep::Brep;
use feeler::nurbs::{Curve2, KnotVector, NurbsCurve, NurbsSurface, PolyCurve, Polyline, Surface};
use feeler::trim::Side;
use feeler_oracle::{Oracle, OracleError, TruthEnclosure, set_rounding_upward};
use nalgebra::{Point2, Vector4};

fn oracle(b: &Brep) -> Oracle {
    Oracle::new(&[b]).unwrap()
}

fn side(o: &Oracle, u: f64, v: f64) -> Side {
    o.side(0, [u, v]).unwrap().side
}

// ---- evaluation

/// De Boor's algorithm in exact rationals: the homogeneous point of a spline.
fn de_boor(knots: &KnotVector, points: &[Vec<RBig>], t: &RBig) -> Vec<RBig> {
    let p = knots.degree();
    let k: Vec<RBig> = knots.knots().iter().map(|x| exact(*x)).collect();
    let n = knots.control_points();
    let span = (p..n).rfind(|i| k[*i] < k[i + 1] && k[*i] <= *t).unwrap();
    let mut d: Vec<Vec<RBig>> = points[span - p..=span].to_vec();
    for r in 1..=p {
        for j in (r..=p).rev() {
            let (left, right) = (&k[span - p + j], &k[span + 1 + j - r]);
            let a = (t - left) / (right - left);
            let b = RBig::ONE - &a;
            let lower = d[j - 1].clone();
            for (x, l) in d[j].iter_mut().zip(&lower) {
                *x = &a * &*x + &b * l;
            }
        }
    }
    d[p].clone()
}

/// The homogeneous point of a surface.
fn surface_point(s: &NurbsSurface, u: &RBig, v: &RBig) -> Vec<RBig> {
    let count = s.counts()[1];
    let rows: Vec<Vec<RBig>> = s
        .control_net()
        .chunks(count)
        .map(|row| {
            let row: Vec<Vec<RBig>> = row
                .iter()
                .map(|p| p.iter().map(|x| exact(*x)).collect())
                .collect();
            de_boor(s.knots_v(), &row, v)
        })
        .collect();
    de_boor(s.knots_u(), &rows, u)
}

fn holds(e: &TruthEnclosure, x: &RBig) -> bool {
    let (lo, hi) = (rational(&e.lo), rational(&e.hi));
    // 160 bits at least.
    let limit = RBig::from_parts(IBig::ONE, (IBig::ONE << 160).try_into().unwrap());
    let size = if *x < RBig::ZERO { -x } else { x.clone() };
    lo <= *x && *x <= hi && &hi - &lo <= size * limit
}

fn random_surface(
    g: &mut Random,
    degrees: [usize; 2],
    spans: [usize; 2],
    weights: f64,
) -> NurbsSurface {
    let counts = [degrees[0] + spans[0], degrees[1] + spans[1]];
    let mut knots = [Vec::new(), Vec::new()];
    for k in 0..2 {
        let mut x = g.range(-1.0, 1.0);
        // Not clamped at the start, clamped at the end, unevenly spaced.
        for _ in 0..counts[k] {
            knots[k].push(x);
            x += g.range(0.01, 1.0);
        }
        knots[k].extend(vec![x; degrees[k] + 1]);
    }
    let net = (0..counts[0] * counts[1])
        .map(|_| {
            let w = weights.powf(g.range(-1.0, 1.0));
            Vector4::new(
                w * g.range(-9.0, 9.0),
                w * g.range(-9.0, 9.0),
                w * g.range(-9.0, 9.0),
                w,
            )
        })
        .collect();
    NurbsSurface::new(degrees, counts, net, knots).unwrap()
}

#[test]
fn evaluation_is_de_boor_in_rationals() {
    let mut g = Random(7);
    for (degrees, spans, weights) in [
        ([1, 1], [1, 1], 1.0),
        ([3, 2], [4, 3], 2.0),
        ([5, 4], [2, 6], 1e12),
        ([25, 3], [1, 2], 3.0),
        ([25, 2], [1, 1], 1e12),
    ] {
        let s = random_surface(&mut g, degrees, spans, weights);
        let o = oracle(&brep(Surface::Nurbs(s.clone()), None));
        let [du, dv] = s.domain();
        let mut at = vec![[du.start, dv.start], [du.end, dv.end]];
        for k in s.knots_u().spans().map(|(_, a, _)| a) {
            at.push([k, g.range(dv.start, dv.end)]);
        }
        for _ in 0..5 {
            at.push([g.range(du.start, du.end), g.range(dv.start, dv.end)]);
        }
        for uv in at {
            let e = o.evaluate(0, uv).unwrap();
            let h = surface_point(&s, &exact(uv[0]), &exact(uv[1]));
            for c in 0..3 {
                assert!(holds(&e.point[c], &(&h[c] / &h[3])), "{degrees:?} {uv:?}");
            }
        }
    }
}

#[test]
fn derivatives_are_exact() {
    // x = 3 u^2, y = 2 v, z = u v over [0, 1]^2, all times 5: x_u = 6 u, z_u = v, z_v = u.
    let mut net = Vec::new();
    for i in 0..3 {
        for j in 0..2 {
            let (u, v) = (f64::from(i) / 2.0, f64::from(j));
            let square = [0.0, 0.0, 1.0][usize::try_from(i).unwrap()];
            net.push([15.0 * square, 10.0 * v, 5.0 * u * v, 5.0]);
        }
    }
    let o = oracle(&brep(patch(2, 1, net), None));
    let (u, v) = (0.3, 0.7);
    let e = o.evaluate(0, [u, v]).unwrap();
    let (u, v) = (exact(u), exact(v));
    let n = |k: i32| RBig::from(IBig::from(k));
    assert!(holds(&e.point[0], &(n(3) * &u * &u)));
    assert!(holds(&e.du[0], &(n(6) * &u)));
    assert!(holds(&e.du[1], &n(0)));
    assert!(holds(&e.du[2], &v));
    assert!(holds(&e.dv[1], &n(2)));
    assert!(holds(&e.dv[2], &u));
    // The quarter circle ((1 - u^2) / (1 + u^2), 2 u / (1 + u^2)), lifted along v. At u = 1/2: the
    // point (3/5, 4/5), the derivative (-4 u, 2 - 2 u^2) / (1 + u^2)^2 = (-32/25, 24/25).
    let arc = [[1.0, 0.0, 1.0], [1.0, 1.0, 1.0], [0.0, 2.0, 2.0]];
    let net = arc
        .iter()
        .flat_map(|[x, y, w]| [[*x, *y, 0.0, *w], [*x, *y, *w, *w]])
        .collect();
    let o = oracle(&brep(patch(2, 1, net), None));
    let e = o.evaluate(0, [0.5, 0.25]).unwrap();
    assert!(holds(&e.point[0], &(n(3) / n(5))) && holds(&e.point[1], &(n(4) / n(5))));
    assert!(holds(&e.du[0], &(n(-32) / n(25))) && holds(&e.du[1], &(n(24) / n(25))));
    assert!(holds(&e.dv[2], &n(1)));
}

// ---- sides

#[test]
fn circle_of_rational_arcs_is_decided_exactly() {
    let o = oracle(&brep(plane(8.0), Some(vec![circle(5.0)])));
    for (x, y) in [(3.0f64, 4.0f64), (4.0, 3.0), (5.0, 0.0), (1.4, 4.8)] {
        for (x, y) in [(x, y), (-y, x), (-x, -y), (y, -x), (x, -y)] {
            // Exactly on it where x^2 + y^2 = 25 exactly; 1.4 and 4.8 are rounded.
            let square = exact(x) * exact(x) + exact(y) * exact(y);
            let expected = match square.cmp(&RBig::from(IBig::from(25))) {
                std::cmp::Ordering::Less => Side::Inside,
                std::cmp::Ordering::Equal => Side::Boundary,
                std::cmp::Ordering::Greater => Side::Outside,
            };
            assert_eq!(side(&o, x, y), expected, "{x} {y}");
            // One ulp towards the middle and away from it.
            assert_eq!(
                side(&o, x, y * (1.0 - f64::EPSILON)),
                match y {
                    0.0 => expected,
                    _ => Side::Inside,
                }
            );
            assert_eq!(
                side(&o, x * (1.0 + f64::EPSILON), y * (1.0 + f64::EPSILON)),
                Side::Outside
            );
        }
    }
    // At random, near the circle: the exact sign of x^2 + y^2 - 25.
    let mut g = Random(3);
    for k in 0..400 {
        let a = g.range(0.0, std::f64::consts::TAU);
        let r = 5.0 + 10f64.powi(-(k % 17)) * g.range(-1.0, 1.0);
        let (x, y) = (r * a.cos(), r * a.sin());
        let square = exact(x) * exact(x) + exact(y) * exact(y);
        let expected = match square.cmp(&RBig::from(IBig::from(25))) {
            std::cmp::Ordering::Less => Side::Inside,
            std::cmp::Ordering::Equal => Side::Boundary,
            std::cmp::Ordering::Greater => Side::Outside,
        };
        assert_eq!(side(&o, x, y), expected, "{x:?} {y:?}");
    }
}

#[test]
fn vertices_joints_and_horizontals() {
    // An L; rays to the right of these points pass vertices and run along edges.
    let l = polygon(&[
        [0.0, 0.0],
        [4.0, 0.0],
        [4.0, 1.0],
        [1.0, 1.0],
        [1.0, 3.0],
        [0.0, 3.0],
    ]);
    let o = oracle(&brep(plane(8.0), Some(vec![l.clone()])));
    for (u, v, expected) in [
        (0.5, 1.0, Side::Inside),
        (2.0, 1.0, Side::Boundary),
        (-1.0, 1.0, Side::Outside),
        (-1.0, 0.0, Side::Outside),
        (-1.0, 3.0, Side::Outside),
        (1.0, 1.0, Side::Boundary),
        (4.0, 1.0, Side::Boundary),
        (5.0, 1.0, Side::Outside),
        (0.5, 0.5, Side::Inside),
        (2.0, 2.0, Side::Outside),
        (0.0, 0.0, Side::Boundary),
        (1.0, 2.0, Side::Boundary),
    ] {
        assert_eq!(side(&o, u, v), expected, "{u} {v}");
    }
    // Backwards and with the loop given twice: even parity everywhere, the loop still Boundary.
    let b = changed(&brep(plane(8.0), Some(vec![l.clone(), l])), |_| {});
    let o = oracle(&b);
    assert_eq!(side(&o, 0.5, 0.5), Side::Outside);
    assert_eq!(side(&o, 0.0, 0.5), Side::Boundary);
}

#[test]
fn gaps_are_joined_and_flagged() {
    // A triangle whose last side is missing and whose second corner does not meet.
    let trims = vec![line([0.0, 0.0], [4.0, 0.0]), line([4.0, 0.5], [0.0, 4.0])];
    let o = oracle(&brep(plane(8.0), Some(vec![trims])));
    assert_eq!(side(&o, 1.0, 1.0), Side::Inside);
    // On the joining segments.
    assert_eq!(side(&o, 4.0, 0.25), Side::Boundary);
    assert_eq!(side(&o, 0.0, 2.0), Side::Boundary);
    assert_eq!(side(&o, -0.1, 2.0), Side::Outside);
    assert!(o.side(0, [4.0, 0.25]).unwrap().in_gap);
    assert!(o.side(0, [0.0, 4.0]).unwrap().in_gap);
    assert!(!o.side(0, [1.0, 1.0]).unwrap().in_gap);
}

#[test]
fn region_is_cut_with_the_domain() {
    let big = polygon(&[[-9.0, -9.0], [9.0, -9.0], [9.0, 9.0], [-9.0, 9.0]]);
    let o = oracle(&brep(plane(4.0), Some(vec![big])));
    assert_eq!(side(&o, 1.0, 1.0), Side::Inside);
    assert_eq!(side(&o, 4.0, 1.0), Side::Boundary);
    assert_eq!(side(&o, 5.0, 1.0), Side::Outside);
    let whole = oracle(&brep(plane(4.0), None));
    assert_eq!(side(&whole, 1.0, 1.0), Side::Inside);
    assert_eq!(side(&whole, -4.0, 1.0), Side::Boundary);
    assert_eq!(side(&whole, -4.1, 1.0), Side::Outside);
    let nothing = oracle(&brep(plane(4.0), Some(vec![])));
    assert_eq!(side(&nothing, 1.0, 1.0), Side::Outside);
    assert_eq!(side(&nothing, 4.0, 1.0), Side::Outside);
    // Along the domain's border exactly.
    let edge = polygon(&[[-4.0, -4.0], [4.0, -4.0], [4.0, 4.0], [-4.0, 4.0]]);
    let o = oracle(&brep(plane(4.0), Some(vec![edge])));
    assert_eq!(side(&o, 4.0, 1.0), Side::Boundary);
    assert_eq!(side(&o, 4.0f64.next_down(), 1.0), Side::Inside);
}

#[test]
fn spans_and_reversal_are_exact() {
    // A parabola v = u^2 over u in [-1, 1] as a spline of two spans; used over [-1/3, 0.7], from
    // the right to the left, closed by its chord.
    let third = 1.0f64 / 3.0;
    let knots = vec![-1.0, -1.0, -1.0, 0.1, 1.0, 1.0, 1.0];
    // The blossom of u^2 is s t: control points at the pairs of knots.
    let points = [(-1.0, -1.0), (-1.0, 0.1), (0.1, 1.0), (1.0, 1.0)]
        .map(|(s, t): (f64, f64)| [(s + t) / 2.0, s * t, 1.0].into())
        .to_vec();
    let c = Curve2::Nurbs(NurbsCurve::new(2, points, knots).unwrap());
    let b = changed(&brep(plane(8.0), Some(vec![vec![c]])), |p| {
        p.trims[0].span = scene::interval(-third, 0.7);
        p.trims[0].reversed = true;
    });
    let o = oracle(&b);
    // 0.1, -0.45 and 0.55 are rounded, so the curve is the parabola only to 1e-16: keep off by more.
    assert_eq!(side(&o, 0.25, 0.0625 + 1e-14), Side::Inside);
    assert_eq!(side(&o, 0.25, 0.0625 - 1e-14), Side::Outside);
    assert_eq!(side(&o, -0.5, 0.3), Side::Outside);
    let chord = |u: f64| third * third + (u + third) * (0.49 - third * third) / (0.7 + third);
    assert_eq!(side(&o, 0.2, chord(0.2) - 1e-14), Side::Inside);
    assert_eq!(side(&o, 0.2, chord(0.2) + 1e-14), Side::Outside);
}

#[test]
fn polycurves_and_polylines_are_flattened() {
    let corner = Curve2::Polyline(
        Polyline::new(
            vec![
                Point2::new(0.0, 0.0),
                Point2::new(2.0, 0.0),
                Point2::new(2.0, 2.0),
            ],
            vec![0.0, 1.0, 5.0],
        )
        .unwrap(),
    );
    let bow = bezier(&[[2.0, 2.0, 1.0], [0.0, 2.0, 1.0], [0.0, 0.0, 1.0]]);
    let both = Curve2::Poly(PolyCurve::new(vec![corner, bow], vec![0.0, 3.0, 4.0]).unwrap());
    let o = oracle(&brep(plane(8.0), Some(vec![vec![both]])));
    // The bow's middle is (1/2, 3/2).
    assert_eq!(side(&o, 0.5, 1.5), Side::Boundary);
    assert_eq!(side(&o, 0.5f64.next_up(), 1.5), Side::Inside);
    assert_eq!(side(&o, 0.5f64.next_down(), 1.5), Side::Outside);
    assert_eq!(side(&o, 2.0, 1.0), Side::Boundary);
}

#[test]
fn high_degrees_and_far_weights() {
    // A degree-25 arch over [0, 1] with weights of 1e12 and 1e-12: v > 0 inside it.
    let points: Vec<[f64; 3]> = (0..=25)
        .map(|i| {
            let w = if i % 2 == 0 { 1e12 } else { 1e-12 };
            let x = f64::from(i) / 25.0;
            [w * x, w * if (1..25).contains(&i) { 1.0 } else { 0.0 }, w]
        })
        .collect();
    let o = oracle(&brep(plane(2.0), Some(vec![vec![bezier(&points)]])));
    assert_eq!(side(&o, 0.5, 0.5), Side::Inside);
    assert_eq!(side(&o, 0.5, -1e-300), Side::Outside);
    assert_eq!(side(&o, 0.5, 0.0), Side::Boundary);
    assert_eq!(side(&o, 0.5, 1.5), Side::Outside);
    assert_eq!(side(&o, 0.0, 0.0), Side::Boundary);
}

// ---- containment

#[test]
fn bad_queries_are_refused() {
    let o = oracle(&brep(plane(4.0), None));
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert!(matches!(
            o.side(0, [bad, 0.0]),
            Err(OracleError::Refused(_))
        ));
        assert!(matches!(
            o.evaluate(0, [0.0, bad]),
            Err(OracleError::Refused(_))
        ));
        assert!(o.inside([bad, 0.0, 0.0]).is_err());
        assert!(o.distance([0.0, bad, 0.0], None).is_err());
        assert!(o.sphere([0.0; 3], bad, None).is_err());
        let kind = feeler::query::LineKind::Line;
        assert!(o.line([bad, 0.0, 0.0], [1.0, 0.0, 0.0], kind).is_err());
        assert!(o.line([0.0; 3], [1.0, bad, 0.0], kind).is_err());
    }
    let kind = feeler::query::LineKind::Line;
    assert!(o.line([0.0; 3], [0.0; 3], kind).is_err());
    assert!(o.sphere([0.0; 3], -1.0, None).is_err());
    assert!(matches!(
        o.side(1, [0.0; 2]),
        Err(OracleError::NoFace { face: 1, count: 1 })
    ));
    assert!(matches!(
        o.evaluate(0, [5.0, 0.0]),
        Err(OracleError::Refused(_))
    ));
}

#[test]
fn extreme_models_do_not_end_the_process() {
    let mut g = Random(11);
    for size in [1e-300, 1e-90, 1e20, 1e45] {
        let net = (0..9)
            .map(|_| {
                [
                    size * g.next(),
                    size * g.next(),
                    size * g.next(),
                    g.range(1e-12, 1e12),
                ]
            })
            .collect();
        let o = oracle(&brep(patch(2, 2, net), Some(vec![circle(0.5)])));
        let _ = o.evaluate(0, [0.5, 0.5]).unwrap();
        let _ = o.inside([0.0; 3]);
        let _ = o.line(
            [0.0; 3],
            [1.0, 1e-300, 1e300],
            feeler::query::LineKind::Line,
        );
        let _ = o.distance([1e300, 0.0, 0.0], Some(100));
    }
    // All control points alike: every number the same point.
    let o = oracle(&brep(patch(3, 3, vec![[1.0, 1.0, 1.0, 1.0]; 16]), None));
    let t = o
        .line([0.0; 3], [1.0; 3], feeler::query::LineKind::Line)
        .unwrap();
    assert!(!t.open.is_empty() || !t.hits.is_empty(), "{t:?}");
    let _ = o.distance([0.0; 3], Some(100));
}

/// A call of its own, so that the sum stays between the calls that change the mode.
#[inline(never)]
fn added(a: f64, b: f64) -> f64 {
    std::hint::black_box(std::hint::black_box(a) + std::hint::black_box(b))
}

#[test]
fn rounding_mode_is_left_alone() {
    // Parsing and adding round as the mode says; upward gives another sum.
    let sum = |a: &str, b: &str| -> f64 {
        std::hint::black_box(a.parse::<f64>().unwrap())
            + std::hint::black_box(b.parse::<f64>().unwrap())
    };
    let o = oracle(&brep(plane(8.0), Some(vec![circle(5.0)])));
    let nearest = sum("0.1", "0.2");
    let ask = || {
        assert_eq!(side(&o, 3.0, 4.0), Side::Boundary);
        o.evaluate(0, [1.0, 1.0]).unwrap();
        o.distance([1.0, 2.0, 3.0], None).unwrap();
        o.inside([1.0, 2.0, 3.0]).unwrap();
        let _ = o.side(0, [f64::NAN, 0.0]);
    };
    ask();
    assert_eq!(sum("0.1", "0.2").to_bits(), nearest.to_bits());
    assert_eq!(
        "0.3".parse::<f64>().unwrap().to_bits(),
        0x3fd3_3333_3333_3333
    );
    set_rounding_upward(true);
    let before = added(1.0, 1e-300);
    ask();
    let after = added(1.0, 1e-300);
    set_rounding_upward(false);
    assert!(before > 1.0 && after > 1.0, "the caller's mode is restored");
}

#[test]
fn sides_take_about_a_millisecond() {
    let o = oracle(&brep(plane(8.0), Some(vec![circle(5.0)])));
    let mut g = Random(5);
    let start = std::time::Instant::now();
    const N: u32 = 1000;
    for _ in 0..N {
        let _ = side(&o, g.range(-8.0, 8.0), g.range(-8.0, 8.0));
    }
    println!("side, random: {:?} each", start.elapsed() / N);
    let start = std::time::Instant::now();
    for _ in 0..100 {
        let a = g.range(0.0, std::f64::consts::TAU);
        let _ = side(&o, 5.0 * a.cos(), 5.0 * a.sin());
    }
    println!("side, at 1e-15: {:?} each", start.elapsed() / 100);
}
